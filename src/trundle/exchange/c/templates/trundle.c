/* The robot '@ROBOT@': kinematics, limits and odometry. Printed by trundle. */
#include "trundle.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "this code looks for commands that are no numbers: compile it without -ffast-math"
#endif

/* R(0.5) is the number 0.5 and SIN the sine for the type that trundle_real is. */
#ifdef TRUNDLE_FLOAT
#define R(number) number##f
#define SIN sinf
#define COS cosf
#define SQRT sqrtf
#define HYPOT hypotf
//: if floors
#define FLOOR floorf
//: end
//: if steered
#define ATAN2 atan2f
#define CEIL ceilf
//: end
#define ABS fabsf
#else
#define R(number) number
#define SIN sin
#define COS cos
#define SQRT sqrt
#define HYPOT hypot
//: if floors
#define FLOOR floor
//: end
//: if steered
#define ATAN2 atan2
#define CEIL ceil
//: end
#define ABS fabs
#endif

/* What rounding makes of a twist, as a share of it@ROUNDED_ANGLE@. */
#if defined(TRUNDLE_FLOAT) || DBL_MANT_DIG < 53
#define ROUNDING R(1e-6)
//: if steered
#define AT_LIMIT R(1e-5)
//: end
#else
#define ROUNDING R(1e-12)
//: if steered
#define AT_LIMIT R(1e-9)
//: end
#endif

/* ---- kinematics: printed from the robot's equations ----------------------------------------- */

@INVERSE@
@FORWARD@
/* The body's increment (dx, dy, dpsi) [m, m, rad] from the turns of the wheels [rad]. */
static @INCREMENT@
/* Move a pose by an increment, along the exact arc. */
static @ADVANCE@
@ODOMETRY_HEAD@
{
    trundle_real moved[3];
    increment(wheel_increments, @STEERING@moved);
    advance(pose, moved);
}

/* ---- the robot's numbers -------------------------------------------------------------------- */

/* Age at which a command is stale, and the longest cycle over which a ramp goes on. */
#define TIMEOUT_US @TIMEOUT_US@
#define MAX_INTERVAL_US @MAX_INTERVAL_US@
/* A clock that goes back by no more than this did; one that does by more has wrapped around. */
#define BACK_US UINT32_C(1000000)
/* No robot is commanded so fast [m/s, rad/s]. */
#define BEYOND R(1000.0)
/* The largest count, and what is half a turn of the counter. */
#define COUNTER_RANGE @COUNTER_RANGE@
#define COUNTER_HALF @COUNTER_HALF@
/* Turns in a minute at 1 rad/s. */
#define RPM @RPM@

/* One over each limit of the twist; 0 where there is none. */
@LIMITS@
//: if turns

/* Axes of the twist that have other limits on the other side of zero. */
static const bool sided[3] = {@TURNS@};
//: end

//: if steered
#define PI R(3.141592653589793)
#define HALVINGS 20 /* of a step, in search of the part that steering can follow */
#define UNLIMITED ((trundle_real)INFINITY)

//: end
/* A driven wheel: its radius [m], turns of its motor for one of its own, and counts per radian. */
typedef struct {
    trundle_real radius;
    trundle_real gear;
    trundle_real per_radian;
} unit;

//: if stand_in
#define STAND_IN (@TURN@ / (trundle_real)(TRUNDLE_TICKS_PER_TURN))

//: end
static const unit units[TRUNDLE_WHEELS] = {
@UNIT_TABLE@
};

/* A wheel with a counter: its turn for one count [rad]@FASTEST_WORDS@. */
typedef struct {
    trundle_real per_count;
//: if plausible
    trundle_real fastest;
//: end
} counter;

static const counter counters[TRUNDLE_COUNTERS] = {
@COUNTER_TABLE@
};

//: if wheel_speed
/* One over the driven wheels' largest speeds [s/rad]; 0 where there is no limit. */
static const trundle_real per_speed[TRUNDLE_WHEELS] = {
@PER_SPEED@
};

//: end
//: if wheel_acceleration
/* One over their largest accelerations [s^2/rad]; 0 where there is no limit. */
static const trundle_real per_acceleration[TRUNDLE_WHEELS] = {
@PER_ACCELERATION@
};

//: end
//: if turning
//: if fixed
/* A driven wheel: which of the steered wheels it is, or which of the others, and otherwise -1; and
 * one over its radius, with the motor's sign [1/m]. */
//: else
/* A driven wheel: which of the steered wheels it is; and one over its radius, with the motor's sign
 * [1/m]. */
//: end
typedef struct {
    int steered;
//: if fixed
    int fixed;
//: end
    trundle_real per_radius;
} driven_wheel;

static const driven_wheel driven_wheels[TRUNDLE_WHEELS] = {
@DRIVEN_TABLE@
};

//: end
//: if steered
/* A steering input: one wheel, or some that are steered together. */
typedef struct {
    trundle_real low;  /* range in which all its wheels keep their limits [rad] */
    trundle_real high;
    trundle_real rate; /* largest rate [rad/s] */
} input;

static const input inputs[TRUNDLE_INPUTS] = {
@INPUT_TABLE@
};

/* A steered wheel: its input, and the sign with which it follows that. */
typedef struct {
    int input;
    trundle_real sign;
} steered_wheel;

static const steered_wheel steered_wheels[TRUNDLE_STEERED] = {
@STEERED_TABLE@
};

//: end
/* ---- twists (u, v, r) ----------------------------------------------------------------------- */

static trundle_real seconds(uint32_t microseconds)
{
    return (trundle_real)microseconds / R(1e6);
}

static trundle_real larger(trundle_real a, trundle_real b)
{
    return a < b ? b : a;
}

//: if rests
static trundle_real smaller(trundle_real a, trundle_real b)
{
    return b < a ? b : a;
}

//: end
static void set(trundle_real twist[3], trundle_real u, trundle_real v, trundle_real r)
{
    twist[0] = u;
    twist[1] = v;
    twist[2] = r;
}

static void copy(trundle_real to[3], const trundle_real from[3])
{
    set(to, from[0], from[1], from[2]);
}

static void scale(trundle_real twist[3], trundle_real share)
{
    set(twist, share * twist[0], share * twist[1], share * twist[2]);
}

/* Find the twist after a step; an axis of which only rounding is left stands still. */
static void add(trundle_real sum[3], const trundle_real twist[3], const trundle_real step[3])
{
    for (int i = 0; i < 3; i++) {
        const trundle_real whole = twist[i] + step[i];
        sum[i] = ABS(whole) > ROUNDING * ABS(step[i]) ? whole : R(0.0);
    }
}

//: if rests
static bool stands(const trundle_real twist[3])
{
    return ABS(twist[0]) + ABS(twist[1]) + ABS(twist[2]) <= R(0.0);
}

//: end
//: if differs
/* Whether two twists differ by more than rounding. */
static bool differ(const trundle_real a[3], const trundle_real b[3])
{
    const trundle_real size = ABS(a[0]) + ABS(a[1]) + ABS(a[2]);
    return ABS(a[0] - b[0]) + ABS(a[1] - b[1]) + ABS(a[2] - b[2]) > ROUNDING * size;
}

//: end
/* ---- limits of the body --------------------------------------------------------------------- */

/* How much of the speed limits a twist takes: above 1 it is too fast. */
static trundle_real body_share(const trundle_real twist[3])
{
    const trundle_real ahead = twist[0] * (twist[0] < R(0.0) ? PER_REVERSE_SPEED : PER_SPEED);
    return larger(HYPOT(ahead, twist[1] * PER_SPEED), ABS(twist[2]) * PER_YAW_RATE);
}

/* The time that a change of the twist takes at the body's acceleration limits [s]. */
static trundle_real body_time(const trundle_real now[3], const trundle_real change[3])
{
    trundle_real per_u, per_v, per_r;
    if (now[0] * change[0] < R(0.0)) {
        per_u = now[0] > R(0.0) ? PER_DECELERATION : PER_REVERSE_DECELERATION;
    } else {
        per_u = change[0] > R(0.0) ? PER_ACCELERATION : PER_REVERSE_ACCELERATION;
    }
    per_v = now[1] * change[1] < R(0.0) ? PER_DECELERATION : PER_ACCELERATION;
    per_r = now[2] * change[2] < R(0.0) ? PER_YAW_DECELERATION : PER_YAW_ACCELERATION;
    return larger(HYPOT(change[0] * per_u, change[1] * per_v), ABS(change[2]) * per_r);
}

//: if jerk
/* A change of twist in units of the jerk limits [s^2]. */
static trundle_real jerks(const trundle_real change[3])
{
    return larger(HYPOT(change[0], change[1]) * PER_JERK, ABS(change[2]) * PER_YAW_JERK);
}

/* Change a step so that it differs from the last by no more than the jerk allows, and is no larger
 * than can be taken back on the way: in units of J dt^2, steps of n + f, n - 1 + f, ..., f make a
 * way of (n + 1) (n / 2 + f). */
static void smooth(const trundle_real change[3], const trundle_real last[3], trundle_real dt,
    trundle_real step[3])
{
    const trundle_real square = dt * dt;
    trundle_real left, taken, whole, largest, jerk, more[3];
    if (dt < R(1e-9)) {
        set(step, R(0.0), R(0.0), R(0.0));
        return;
    }
    left = jerks(change) / square;
    taken = jerks(step) / square;
    whole = FLOOR(R(0.5) * (SQRT(R(1.0) + R(8.0) * left) - R(1.0)));
    largest = whole + (left / (whole + R(1.0)) - R(0.5) * whole);
    if (taken > largest) {
        scale(step, largest / taken);
    }
    set(more, step[0] - last[0], step[1] - last[1], step[2] - last[2]);
    jerk = jerks(more) / square;
    if (jerk > R(1.0)) {
        set(step, last[0] + more[0] / jerk, last[1] + more[1] / jerk, last[2] + more[2] / jerk);
    }
}

//: end
/* ---- wheels: printed from the robot's equations ---------------------------------------------- */

//: if projects
/* The nearest twist that the wheels allow. */
static @PROJECT@
//: end
//: if steered
/* Velocities of the steered wheels' contacts [m/s]: all along the zeros of their angles, then all a
 * quarter turn further. */
static @CONTACTS@
//: end
//: if fixed
/* Speeds of the driven wheels that do not steer [rad/s]. */
static @FIXED_SPEEDS@
//: end
//: if turning
/* Speeds of all driven wheels [rad/s]; without steering angles: the largest at any angles. */
static void wheel_speeds(const trundle_real twist[3], const trundle_real *angles,
    trundle_real speeds[TRUNDLE_WHEELS])
{
    trundle_real contact[2 * TRUNDLE_STEERED];
//: if fixed
    trundle_real rolled[@FIXED@];
    fixed_speeds(twist, rolled);
//: end
    contacts(twist, contact);
    for (int i = 0; i < TRUNDLE_WHEELS; i++) {
        const driven_wheel *wheel = &driven_wheels[i];
        const int k = wheel->steered;
//: if fixed
        if (k < 0) {
            speeds[i] = rolled[wheel->fixed];
            continue;
        }
//: end
        const trundle_real a = contact[k], b = contact[TRUNDLE_STEERED + k];
        if (angles != NULL) {
            speeds[i] = (a * COS(angles[k]) + b * SIN(angles[k])) * wheel->per_radius;
        } else {
            speeds[i] = HYPOT(a, b) * ABS(wheel->per_radius);
        }
    }
}

//: end
//: if wheel_limits
/* How much of the wheels' limits a twist takes, or its change; each as one over the limit. */
static trundle_real wheel_share(const trundle_real twist[3], const trundle_real per[TRUNDLE_WHEELS])
{
    trundle_real share = R(0.0), speeds[TRUNDLE_WHEELS];
//: if turning
    wheel_speeds(twist, NULL, speeds);
//: else
    fixed_speeds(twist, speeds);
//: end
    for (int i = 0; i < TRUNDLE_WHEELS; i++) {
        share = larger(share, ABS(speeds[i]) * per[i]);
    }
    return share;
}

//: end
//: if steered
/* ---- steering ------------------------------------------------------------------------------- */

static void copy_inputs(trundle_real to[TRUNDLE_INPUTS], const trundle_real from[TRUNDLE_INPUTS])
{
    for (int j = 0; j < TRUNDLE_INPUTS; j++) {
        to[j] = from[j];
    }
}

/* Find the inputs along a twist, nearest to the present ones: each takes the angle of its fastest
 * wheel, or half a turn from it; where no wheel moves, it stays. False: one has no such angle in
 * its range. */
static bool aim(const trundle_real twist[3], const trundle_real present[TRUNDLE_INPUTS],
    trundle_real aimed[TRUNDLE_INPUTS])
{
    const trundle_real still = ROUNDING * (ABS(twist[0]) + ABS(twist[1]) + ABS(twist[2]));
    trundle_real contact[2 * TRUNDLE_STEERED];
    contacts(twist, contact);
    for (int j = 0; j < TRUNDLE_INPUTS; j++) {
        const input *each = &inputs[j];
        const trundle_real low = each->low - AT_LIMIT, high = each->high + AT_LIMIT;
        trundle_real fastest = still * still, angle = present[j];
        for (int i = 0; i < TRUNDLE_STEERED; i++) {
            const trundle_real a = contact[i], b = contact[TRUNDLE_STEERED + i];
            const trundle_real square = a * a + b * b;
            if (steered_wheels[i].input == j && square > fastest) {
                fastest = square;
                angle = steered_wheels[i].sign * ATAN2(b, a);
            }
        }
        angle += PI * FLOOR((present[j] - angle) / PI + R(0.5));
        if (angle < low) {
            angle += PI * CEIL((low - angle) / PI);
        } else if (angle > high) {
            angle -= PI * CEIL((angle - high) / PI);
        }
        if (angle < low || angle > high) {
            return false;
        }
        aimed[j] = smaller(larger(angle, each->low), each->high);
    }
    return true;
}

//: if ranged
/* Reduce a twist's yaw rate until every wheel finds an angle in its range, or stop. */
static void straighten(trundle_real twist[3], const trundle_real present[TRUNDLE_INPUTS])
{
    const trundle_real straight[3] = {twist[0], twist[1], R(0.0)};
    const trundle_real turn[3] = {R(0.0), R(0.0), twist[2]};
    trundle_real fixed[2 * TRUNDLE_STEERED], turned[2 * TRUNDLE_STEERED];
    trundle_real best = R(-1.0), aimed[TRUNDLE_INPUTS];
    contacts(straight, fixed);
    contacts(turn, turned);
    if (aim(straight, present, aimed)) {
        best = R(0.0);
    }
    for (int i = 0; i < TRUNDLE_STEERED; i++) {
        const steered_wheel *each = &steered_wheels[i];
        const trundle_real ends[2] = {inputs[each->input].low, inputs[each->input].high};
        for (int k = 0; k < 2; k++) {
            const int n = TRUNDLE_STEERED + i;
            trundle_real c, s, off, by_turn, share;
            if (ABS(ends[k]) >= UNLIMITED) {
                continue;
            }
            /* With a share of the yaw rate the contact's velocity (a, b) is fixed + share turned:
             * it points along the end's angle where b cos - a sin = 0. */
            c = COS(each->sign * ends[k]);
            s = SIN(each->sign * ends[k]);
            off = fixed[n] * c - fixed[i] * s;
            by_turn = turned[n] * c - turned[i] * s;
            share = ABS(by_turn) > R(0.0) ? -off / by_turn : R(0.0);
            if (share > larger(best, R(0.0)) && share < R(1.0)) {
                const trundle_real less[3] = {twist[0], twist[1], share * twist[2]};
                if (aim(less, present, aimed)) {
                    best = share;
                }
            }
        }
    }
    if (best < R(0.0)) {
        set(twist, R(0.0), R(0.0), R(0.0));
    } else {
        twist[2] = best * twist[2];
    }
}

//: end
/* Whether the inputs can follow a share of a step, and where they then are. */
static bool follow(const trundle_real now[3], const trundle_real step[3], trundle_real share,
    const trundle_real present[TRUNDLE_INPUTS], trundle_real dt, trundle_real aimed[TRUNDLE_INPUTS])
{
    trundle_real part[3], end[3];
    copy(part, step);
    scale(part, share);
    add(end, now, part);
    if (!aim(end, present, aimed)) {
        return false;
    }
    for (int j = 0; j < TRUNDLE_INPUTS; j++) {
        if (ABS(aimed[j] - present[j]) > inputs[j].rate * dt) {
            return false;
        }
    }
    return true;
}

//: end
/* ---- from the twist that is wanted to that of the next cycle -------------------------------- */

/* Find the twist that the robot may have in place of the one asked; return why it differs. */
static unsigned reach(const trundle_state *state, trundle_real target[3])
{
    const trundle_real *asked = state->command;
    unsigned why = 0;
//: if wheel_speed
    trundle_real body, wheels, share;
//: else
    trundle_real share;
//: end
//: if projects
    project(asked, target);
    if (differ(target, asked)) {
        why |= TRUNDLE_LIMIT_WHEELS;
    }
//: else
    copy(target, asked);
//: end
//: if ranged
    {
        trundle_real aimed[TRUNDLE_INPUTS];
        if (!aim(target, state->inputs, aimed)) {
            straighten(target, state->inputs);
            why |= TRUNDLE_LIMIT_STEERING_RANGE;
        }
    }
//: end
//: if wheel_speed
    body = body_share(target);
    wheels = wheel_share(target, per_speed);
    share = larger(body, wheels);
    if (share > R(1.0)) {
        why |= body >= wheels ? TRUNDLE_LIMIT_SPEED : TRUNDLE_LIMIT_WHEEL_SPEED;
//: else
    share = body_share(target);
    if (share > R(1.0)) {
        why |= TRUNDLE_LIMIT_SPEED;
//: end
        set(target, target[0] / share, target[1] / share, target[2] / share);
    }
    return why;
}

/* Find the change to a target, or to the first point on the way with other limits: where an axis
 * changes its sign. */
static void find_change(const trundle_real now[3], const trundle_real target[3],
    trundle_real change[3])
{
//: if turns
    trundle_real share = R(1.0);
    int axis = -1;
//: end
    set(change, target[0] - now[0], target[1] - now[1], target[2] - now[2]);
//: if turns
    for (int i = 0; i < 3; i++) {
        if (sided[i] && now[i] * target[i] < R(0.0) && now[i] / -change[i] < share) {
            share = now[i] / -change[i];
            axis = i;
        }
    }
    if (axis >= 0) {
        scale(change, share);
        change[axis] = -now[axis]; /* exactly to zero */
    }
//: end
}

/* Shorten a change to what a step at the acceleration limits makes of it; return whether. */
static bool shorten(const trundle_real now[3], trundle_real dt, trundle_real change[3])
{
    trundle_real needed = body_time(now, change);
//: if wheel_acceleration
    needed = larger(needed, wheel_share(change, per_acceleration));
//: end
    if (needed > dt) {
        scale(change, dt / needed);
        return true;
    }
    return false;
}

/* Brake on a straight line to rest; the steering stays. */
static void brake(trundle_state *state, trundle_real dt, trundle_real step[3])
{
//: if jerk
    state->braked = true;
//: end
    set(step, -state->twist[0], -state->twist[1], -state->twist[2]);
    shorten(state->twist, dt, step);
}

//: if jerk
/* Keep the other limits where a step that spares the jerk does not: so it is where a new command
 * comes in the middle of a ramp. Nor does such a step go beyond zero on an axis where the target
 * does not lie there. */
static void keep_within(const trundle_real now[3], const trundle_real target[3], trundle_real dt,
    trundle_real step[3])
{
    trundle_real end[3], share;
    add(end, now, step);
    share = body_share(end);
//: if wheel_speed
    share = larger(share, wheel_share(end, per_speed));
//: end
    if (share > R(1.0) + ROUNDING) {
        set(step, end[0] / share - now[0], end[1] / share - now[1], end[2] / share - now[2]);
        add(end, now, step);
    }
    share = R(1.0);
    for (int i = 0; i < 3; i++) {
        if ((end[i] < R(0.0) && now[i] >= R(0.0) && target[i] >= R(0.0))
            || (end[i] > R(0.0) && now[i] <= R(0.0) && target[i] <= R(0.0))) {
            share = smaller(share, now[i] / (now[i] - end[i]));
        }
    }
    scale(step, share);
    shorten(now, dt, step);
}

//: end
//: if steered
/* From rest the wheels first turn to where they will roll; only then the step is taken. */
static unsigned set_off(trundle_state *state, const trundle_real target[3], trundle_real dt,
    trundle_real step[3])
{
    trundle_real aimed[TRUNDLE_INPUTS];
    bool there = true;
    if (stands(target) || !aim(target, state->inputs, aimed)) {
        set(step, R(0.0), R(0.0), R(0.0));
        return 0;
    }
    for (int j = 0; j < TRUNDLE_INPUTS; j++) {
        const trundle_real most = inputs[j].rate * dt, way = aimed[j] - state->inputs[j];
        if (inputs[j].rate >= UNLIMITED) {
            state->inputs[j] = aimed[j];
        } else {
            state->inputs[j] += smaller(larger(way, -most), most);
            there = there && ABS(state->inputs[j] - aimed[j]) <= R(0.0);
        }
    }
    if (there) {
        return 0;
    }
    set(step, R(0.0), R(0.0), R(0.0));
    return TRUNDLE_LIMIT_STEERING_RATE;
}

/* Turn the wheels along a step, which is shortened where they are not quick enough. */
static unsigned steer(trundle_state *state, const trundle_real target[3], trundle_real dt,
    trundle_real step[3])
{
    trundle_real aimed[TRUNDLE_INPUTS], found[TRUNDLE_INPUTS];
    trundle_real low = R(0.0), high = R(1.0);
    bool any = false;
    if (stands(state->twist)) {
        return set_off(state, target, dt, step);
    }
    if (follow(state->twist, step, R(1.0), state->inputs, dt, aimed)) {
        copy_inputs(state->inputs, aimed);
        return 0;
    }
    copy_inputs(found, state->inputs);
    for (int i = 0; i < HALVINGS; i++) {
        const trundle_real middle = R(0.5) * (low + high);
        if (follow(state->twist, step, middle, state->inputs, dt, aimed)) {
            low = middle;
            copy_inputs(found, aimed);
            any = true;
        } else {
            high = middle;
        }
    }
    copy_inputs(state->inputs, found);
    if (any) {
        scale(step, low);
    } else {
        /* No way on at these angles: slower, until the wheels can turn at rest. */
        brake(state, dt, step);
    }
    return TRUNDLE_LIMIT_STEERING_RATE;
}

//: end
/* Find the step towards the command, and turn the steering along; return the limits in force. */
static unsigned drive(trundle_state *state, trundle_real dt, trundle_real step[3])
{
    trundle_real target[3];
    unsigned why = reach(state, target);
//: if jerk
    trundle_real last[3], change[3], other[3];
    bool shortened;
    copy(last, state->rate);
    scale(last, stands(state->twist) ? R(0.0) : dt);
    find_change(state->twist, target, change);
    copy(step, change);
    shortened = shorten(state->twist, dt, step);
    copy(other, step);
    smooth(change, last, dt, other);
    if (differ(other, step)) {
        why |= TRUNDLE_LIMIT_JERK;
        keep_within(state->twist, target, dt, other);
        copy(step, other);
    } else if (shortened) {
        why |= TRUNDLE_LIMIT_ACCELERATION;
    }
//: else
    find_change(state->twist, target, step);
    if (shorten(state->twist, dt, step)) {
        why |= TRUNDLE_LIMIT_ACCELERATION;
    }
//: end
//: if steered
    why |= steer(state, target, dt, step);
//: end
    return why;
}

/* ---- counters ------------------------------------------------------------------------------- */

/* The turn of a wheel between two readings of its counter, which may have wrapped around [rad]. */
static trundle_real turn_of(uint32_t before, uint32_t now, trundle_real per_count)
{
    const uint32_t ahead = (now - before) & COUNTER_RANGE;
    if (ahead < COUNTER_HALF) {
        return (trundle_real)ahead * per_count;
    }
    return -(trundle_real)(COUNTER_RANGE - ahead + 1) * per_count;
}

/* Move the pose by what the counters say. */
static @READ_COUNTERS@
{
    const trundle_real interval = seconds(state->now_us - state->counts_us);
    const bool first = !state->counted;
//: if plausible
    bool good = true;
//: end
    trundle_real turns[TRUNDLE_COUNTERS], moved[3];
//: if steered
    trundle_real middle[TRUNDLE_STEERED];
//: end
//: if narrow
    for (int i = 0; i < TRUNDLE_COUNTERS; i++) {
        /* Counters may come signed or unsigned; a number between cannot be. */
        if (counts[i] > COUNTER_RANGE && counts[i] < UINT32_C(0) - COUNTER_HALF) {
            state->refused_counts++;
            return;
        }
    }
//: end
    if (!first && interval <= R(0.0)) {
        return; /* the next reading makes it good */
    }
    for (int i = 0; i < TRUNDLE_COUNTERS; i++) {
        turns[i] = turn_of(state->counts[i], counts[i], counters[i].per_count);
//: if plausible
        if (counters[i].fastest > R(0.0)
            && ABS(turns[i]) > counters[i].fastest * interval + R(2.0) * counters[i].per_count) {
            good = false;
        }
//: end
        state->counts[i] = counts[i];
    }
//: if steered
    for (int i = 0; i < TRUNDLE_STEERED; i++) {
        middle[i] = R(0.5) * (state->angles[i] + angles[i]);
        state->angles[i] = angles[i];
    }
//: end
    state->counts_us = state->now_us;
    state->counted = true;
    if (first) {
        return;
    }
//: if plausible
    if (!good) {
        state->refused_counts++;
        return;
    }
//: end
    increment(turns, @MIDDLE@moved);
    advance(state->pose, moved);
    for (int i = 0; i < 3; i++) {
        state->velocity[i] = moved[i] / interval;
    }
}

/* ---- the bridge ----------------------------------------------------------------------------- */

@START@
{
    const trundle_state fresh = {0};
    *state = fresh;
    state->now_us = now_us;
    state->counts_us = now_us;
    if (pose != NULL) {
        copy(state->pose, pose);
    }
//: if steered
    for (int i = TRUNDLE_STEERED - 1; i >= 0; i--) {
        const bool known = steering != NULL && ABS(steering[i]) <= BEYOND;
        state->angles[i] = known ? steering[i] : R(0.0);
        state->inputs[steered_wheels[i].input] = steered_wheels[i].sign * state->angles[i];
    }
//: end
}

/* Take a new command, unless it is bad. */
static void take(trundle_state *state, const trundle_real command[3])
{
    for (int i = 0; i < 3; i++) {
        if (!(ABS(command[i]) <= BEYOND)) { /* so that what is no number is refused, too */
            state->refused++;
            return;
        }
    }
    copy(state->command, command);
    state->command_us = state->now_us;
    state->commanded = true;
}

/* Find the next twist, and whether the command is stale; return the limits in force. */
static unsigned next_twist(trundle_state *state, uint32_t elapsed_us, bool *stale)
{
    const uint32_t dt_us = elapsed_us < MAX_INTERVAL_US ? elapsed_us : MAX_INTERVAL_US;
    const uint32_t age_us = state->now_us - state->command_us;
    trundle_real step[3];
    unsigned limits = 0;
//: if jerk
    state->braked = false;
//: end
    /* What is told holds until the next cycle, which is as far away as the last one. */
    *stale = !state->commanded
        || (age_us > 0 && (age_us > TIMEOUT_US || elapsed_us > TIMEOUT_US - age_us));
    if (*stale) {
        uint32_t late_us = elapsed_us;
        if (state->commanded && age_us <= TIMEOUT_US) {
            late_us = elapsed_us - (TIMEOUT_US - age_us);
        }
        /* An age that wraps around must not make an old command young again. */
        state->commanded = state->commanded && age_us <= TIMEOUT_US;
        brake(state, seconds(late_us), step);
    } else {
        limits = drive(state, seconds(dt_us), step);
    }
    add(state->twist, state->twist, step);
//: if jerk
    if (elapsed_us > 0) {
        copy(state->rate, step);
        scale(state->rate, state->braked ? R(0.0) : R(1.0) / seconds(elapsed_us));
    }
//: end
    return limits;
}

@STEP@
{
    uint32_t elapsed_us = now_us - state->now_us;
//: if steered
    trundle_real angles[TRUNDLE_STEERED];
    bool measured = steering != NULL;
//: end
    if (now_us != state->now_us && state->now_us - now_us <= BACK_US) {
        elapsed_us = 0; /* a time before the last one */
    }
    state->now_us += elapsed_us;
    if (command != NULL) {
        take(state, command);
    }
//: if steered
    for (int i = 0; measured && i < TRUNDLE_STEERED; i++) {
        measured = ABS(steering[i]) <= BEYOND;
    }
    for (int i = 0; i < TRUNDLE_STEERED; i++) {
        const steered_wheel *wheel = &steered_wheels[i];
        angles[i] = measured ? steering[i] : wheel->sign * state->inputs[wheel->input];
    }
//: end
    output->limits = next_twist(state, elapsed_us, &output->stale);
    if (counts != NULL) {
        read_counters(state, counts@ANGLES@);
    }
    copy(output->twist, state->twist);
//: if steered
    for (int i = 0; i < TRUNDLE_STEERED; i++) {
        const steered_wheel *wheel = &steered_wheels[i];
        output->steering[i] = wheel->sign * state->inputs[wheel->input];
    }
//: end
//: if turning
    wheel_speeds(state->twist, output->steering, output->wheel_speeds);
//: else
    fixed_speeds(state->twist, output->wheel_speeds);
//: end
    for (int i = 0; i < TRUNDLE_WHEELS; i++) {
        const trundle_real speed = output->wheel_speeds[i];
        output->rim_speeds[i] = units[i].radius * speed;
        output->rpm[i] = RPM * speed;
        output->motor_rpm[i] = RPM * units[i].gear * speed;
        output->ticks[i] = seconds(elapsed_us) * units[i].per_radian * speed;
    }
}
