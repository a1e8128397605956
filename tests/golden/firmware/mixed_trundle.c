/* The robot 'mixed': kinematics, limits and odometry. Printed by trundle. */
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
#define ABS fabsf
#else
#define R(number) number
#define SIN sin
#define COS cos
#define SQRT sqrt
#define HYPOT hypot
#define ABS fabs
#endif

/* What rounding makes of a twist, as a share of it. */
#if defined(TRUNDLE_FLOAT) || DBL_MANT_DIG < 53
#define ROUNDING R(1e-6)
#else
#define ROUNDING R(1e-12)
#endif

/* ---- kinematics: printed from the robot's equations ----------------------------------------- */

void trundle_inverse(const trundle_real twist[3], trundle_real wheel_speeds[2])
{
    const trundle_real u = twist[0];
    const trundle_real v = twist[1];
    const trundle_real r = twist[2];
    const trundle_real t0 = R(20.0) * u;
    const trundle_real t1 = R(2.1153846153846136) * v;
    const trundle_real t2 = R(10.576923076923073) * r;
    const trundle_real t3 = t1 + t2;
    wheel_speeds[0] = t0 - t3;
    wheel_speeds[1] = t0 + t3;
}

void trundle_forward(const trundle_real wheel_speeds[2], trundle_real twist[3])
{
    const trundle_real w0 = wheel_speeds[0];
    const trundle_real w1 = wheel_speeds[1];
    const trundle_real t0 = w1 - w0;
    twist[0] = R(0.025) * (w0 + w1);
    twist[1] = R(0.009090909090909084) * t0;
    twist[2] = R(0.04545454545454543) * t0;
}

/* The body's increment (dx, dy, dpsi) [m, m, rad] from the turns of the wheels [rad]. */
static void increment(const trundle_real wheel_increments[4], trundle_real moved[3])
{
    const trundle_real w0 = wheel_increments[0];
    const trundle_real w1 = wheel_increments[1];
    const trundle_real w2 = wheel_increments[2];
    const trundle_real w3 = wheel_increments[3];
    const trundle_real t0 = R(0.00833333333333333) * w0;
    const trundle_real t1 = R(0.00833333333333333) * w1;
    const trundle_real t2 = R(0.01) * w2;
    const trundle_real t3 = R(0.01) * w3;
    const trundle_real t4 = R(0.008764940239043822) * w0;
    const trundle_real t5 = R(0.008764940239043822) * w1;
    const trundle_real t6 = R(0.0014342629482071712) * w2;
    const trundle_real t7 = R(0.0014342629482071712) * w3;
    const trundle_real t8 = R(0.04382470119521911) * w0;
    const trundle_real t9 = R(0.04382470119521911) * w1;
    const trundle_real t10 = R(0.007171314741035855) * w2;
    const trundle_real t11 = R(0.007171314741035855) * w3;
    const trundle_real dx = t0 + t1 + t2 + t3;
    const trundle_real dy = t5 + t7 - t4 - t6;
    const trundle_real dpsi = t9 + t11 - t8 - t10;
    moved[0] = dx;
    moved[1] = dy;
    moved[2] = dpsi;
}

/* Move a pose by an increment, along the exact arc. */
static void advance(trundle_real pose[3], const trundle_real moved[3])
{
    const trundle_real x = pose[0];
    const trundle_real y = pose[1];
    const trundle_real psi = pose[2];
    const trundle_real dx = moved[0];
    const trundle_real dy = moved[1];
    const trundle_real dpsi = moved[2];
    const trundle_real half = R(0.5) * dpsi;
    const trundle_real nonzero = SQRT(half * half + R(5.551115123125783e-17));
    const trundle_real chord = SIN(nonzero) / nonzero;
    const trundle_real middle = psi + half;
    const trundle_real c = chord * COS(middle);
    const trundle_real s = chord * SIN(middle);
    pose[0] = x + c * dx - s * dy;
    pose[1] = y + s * dx + c * dy;
    pose[2] = psi + dpsi;
}

void trundle_odometry(trundle_real pose[3], const trundle_real wheel_increments[4])
{
    trundle_real moved[3];
    increment(wheel_increments, moved);
    advance(pose, moved);
}

/* ---- the robot's numbers -------------------------------------------------------------------- */

/* Age at which a command is stale, and the longest cycle over which a ramp goes on. */
#define TIMEOUT_US UINT32_C(300000)
#define MAX_INTERVAL_US UINT32_C(100000)
/* A clock that goes back by no more than this did; one that does by more has wrapped around. */
#define BACK_US UINT32_C(1000000)
/* No robot is commanded so fast [m/s, rad/s]. */
#define BEYOND R(1000.0)
/* The largest count, and what is half a turn of the counter. */
#define COUNTER_RANGE UINT32_C(0xffff)
#define COUNTER_HALF UINT32_C(0x8000)
/* Turns in a minute at 1 rad/s. */
#define RPM R(9.549296585513721)

/* One over each limit of the twist; 0 where there is none. */
#define PER_SPEED R(1.25) /* max_speed = 0.8 */
#define PER_REVERSE_SPEED R(2.0) /* max_reverse_speed = 0.5 */
#define PER_YAW_RATE R(0.6666666666666666) /* max_yaw_rate = 1.5 */
#define PER_ACCELERATION R(0.5) /* max_acceleration = 2 */
#define PER_DECELERATION R(0.3333333333333333) /* max_deceleration = 3 */
#define PER_REVERSE_ACCELERATION R(0.6666666666666666) /* max_reverse_acceleration = 1.5 */
#define PER_REVERSE_DECELERATION R(0.3333333333333333) /* max_reverse_deceleration = 3 */
#define PER_YAW_ACCELERATION R(0.2) /* max_yaw_acceleration = 5 */
#define PER_YAW_DECELERATION R(0.14285714285714285) /* max_yaw_deceleration = 7 */

/* Axes of the twist that have other limits on the other side of zero. */
static const bool sided[3] = {true, true, true};

/* A driven wheel: its radius [m], turns of its motor for one of its own, and counts per radian. */
typedef struct {
    trundle_real radius;
    trundle_real gear;
    trundle_real per_radian;
} unit;

static const unit units[TRUNDLE_WHEELS] = {
    {R(0.05), R(3.0), R(244.46199258915127)},
    {R(0.05), R(3.0), R(244.46199258915127)},
};

/* A wheel with a counter: its turn for one count [rad], and the speed beyond which a
 * reading of it cannot be [rad/s]; 0: none. */
typedef struct {
    trundle_real per_count;
    trundle_real fastest;
} counter;

static const counter counters[TRUNDLE_COUNTERS] = {
    {R(0.0040906154343617095), R(36.0)},
    {R(0.0040906154343617095), R(36.0)},
    {R(0.0030679615757712823), R(0.0)},
    {R(0.0030679615757712823), R(0.0)},
};

/* One over the driven wheels' largest speeds [s/rad]; 0 where there is no limit. */
static const trundle_real per_speed[TRUNDLE_WHEELS] = {
    R(0.05555555555555555),
    R(0.05555555555555555),
};

/* One over their largest accelerations [s^2/rad]; 0 where there is no limit. */
static const trundle_real per_acceleration[TRUNDLE_WHEELS] = {
    R(0.016666666666666666),
    R(0.016666666666666666),
};

/* ---- twists (u, v, r) ----------------------------------------------------------------------- */

static trundle_real seconds(uint32_t microseconds)
{
    return (trundle_real)microseconds / R(1e6);
}

static trundle_real larger(trundle_real a, trundle_real b)
{
    return a < b ? b : a;
}

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

/* Whether two twists differ by more than rounding. */
static bool differ(const trundle_real a[3], const trundle_real b[3])
{
    const trundle_real size = ABS(a[0]) + ABS(a[1]) + ABS(a[2]);
    return ABS(a[0] - b[0]) + ABS(a[1] - b[1]) + ABS(a[2] - b[2]) > ROUNDING * size;
}

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

/* ---- wheels: printed from the robot's equations ---------------------------------------------- */

/* The nearest twist that the wheels allow. */
static void project(const trundle_real twist[3], trundle_real to[3])
{
    const trundle_real u = twist[0];
    const trundle_real v = twist[1];
    const trundle_real r = twist[2];
    const trundle_real t0 = R(0.03846153846154) * v;
    const trundle_real t1 = R(0.19230769230769) * r;
    const trundle_real t2 = R(0.19230769230769) * v;
    const trundle_real t3 = R(0.96153846153846) * r;
    to[0] = u;
    to[1] = t0 + t1;
    to[2] = t2 + t3;
}

/* Speeds of the driven wheels that do not steer [rad/s]. */
static void fixed_speeds(const trundle_real twist[3], trundle_real to[2])
{
    const trundle_real u = twist[0];
    const trundle_real v = twist[1];
    const trundle_real r = twist[2];
    const trundle_real t0 = R(20.0) * u;
    const trundle_real t1 = R(20.0) * v;
    const trundle_real t2 = R(7.0) * r;
    const trundle_real t3 = t1 + t2;
    to[0] = t0 - t3;
    to[1] = t0 + t3;
}

/* How much of the wheels' limits a twist takes, or its change; each as one over the limit. */
static trundle_real wheel_share(const trundle_real twist[3], const trundle_real per[TRUNDLE_WHEELS])
{
    trundle_real share = R(0.0), speeds[TRUNDLE_WHEELS];
    fixed_speeds(twist, speeds);
    for (int i = 0; i < TRUNDLE_WHEELS; i++) {
        share = larger(share, ABS(speeds[i]) * per[i]);
    }
    return share;
}

/* ---- from the twist that is wanted to that of the next cycle -------------------------------- */

/* Find the twist that the robot may have in place of the one asked; return why it differs. */
static unsigned reach(const trundle_state *state, trundle_real target[3])
{
    const trundle_real *asked = state->command;
    unsigned why = 0;
    trundle_real body, wheels, share;
    project(asked, target);
    if (differ(target, asked)) {
        why |= TRUNDLE_LIMIT_WHEELS;
    }
    body = body_share(target);
    wheels = wheel_share(target, per_speed);
    share = larger(body, wheels);
    if (share > R(1.0)) {
        why |= body >= wheels ? TRUNDLE_LIMIT_SPEED : TRUNDLE_LIMIT_WHEEL_SPEED;
        set(target, target[0] / share, target[1] / share, target[2] / share);
    }
    return why;
}

/* Find the change to a target, or to the first point on the way with other limits: where an axis
 * changes its sign. */
static void find_change(const trundle_real now[3], const trundle_real target[3],
    trundle_real change[3])
{
    trundle_real share = R(1.0);
    int axis = -1;
    set(change, target[0] - now[0], target[1] - now[1], target[2] - now[2]);
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
}

/* Shorten a change to what a step at the acceleration limits makes of it; return whether. */
static bool shorten(const trundle_real now[3], trundle_real dt, trundle_real change[3])
{
    trundle_real needed = body_time(now, change);
    needed = larger(needed, wheel_share(change, per_acceleration));
    if (needed > dt) {
        scale(change, dt / needed);
        return true;
    }
    return false;
}

/* Brake on a straight line to rest; the steering stays. */
static void brake(trundle_state *state, trundle_real dt, trundle_real step[3])
{
    set(step, -state->twist[0], -state->twist[1], -state->twist[2]);
    shorten(state->twist, dt, step);
}

/* Find the step towards the command, and turn the steering along; return the limits in force. */
static unsigned drive(trundle_state *state, trundle_real dt, trundle_real step[3])
{
    trundle_real target[3];
    unsigned why = reach(state, target);
    find_change(state->twist, target, step);
    if (shorten(state->twist, dt, step)) {
        why |= TRUNDLE_LIMIT_ACCELERATION;
    }
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
static void read_counters(trundle_state *state, const uint32_t counts[4])
{
    const trundle_real interval = seconds(state->now_us - state->counts_us);
    const bool first = !state->counted;
    bool good = true;
    trundle_real turns[TRUNDLE_COUNTERS], moved[3];
    for (int i = 0; i < TRUNDLE_COUNTERS; i++) {
        /* Counters may come signed or unsigned; a number between cannot be. */
        if (counts[i] > COUNTER_RANGE && counts[i] < UINT32_C(0) - COUNTER_HALF) {
            state->refused_counts++;
            return;
        }
    }
    if (!first && interval <= R(0.0)) {
        return; /* the next reading makes it good */
    }
    for (int i = 0; i < TRUNDLE_COUNTERS; i++) {
        turns[i] = turn_of(state->counts[i], counts[i], counters[i].per_count);
        if (counters[i].fastest > R(0.0)
            && ABS(turns[i]) > counters[i].fastest * interval + R(2.0) * counters[i].per_count) {
            good = false;
        }
        state->counts[i] = counts[i];
    }
    state->counts_us = state->now_us;
    state->counted = true;
    if (first) {
        return;
    }
    if (!good) {
        state->refused_counts++;
        return;
    }
    increment(turns, moved);
    advance(state->pose, moved);
    for (int i = 0; i < 3; i++) {
        state->velocity[i] = moved[i] / interval;
    }
}

/* ---- the bridge ----------------------------------------------------------------------------- */

void trundle_start(trundle_state *state, uint32_t now_us, const trundle_real pose[3])
{
    const trundle_state fresh = {0};
    *state = fresh;
    state->now_us = now_us;
    state->counts_us = now_us;
    if (pose != NULL) {
        copy(state->pose, pose);
    }
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
    return limits;
}

void trundle_step(trundle_state *state, uint32_t now_us, const trundle_real command[3],
    const uint32_t counts[4], trundle_output *output)
{
    uint32_t elapsed_us = now_us - state->now_us;
    if (now_us != state->now_us && state->now_us - now_us <= BACK_US) {
        elapsed_us = 0; /* a time before the last one */
    }
    state->now_us += elapsed_us;
    if (command != NULL) {
        take(state, command);
    }
    output->limits = next_twist(state, elapsed_us, &output->stale);
    if (counts != NULL) {
        read_counters(state, counts);
    }
    copy(output->twist, state->twist);
    fixed_speeds(state->twist, output->wheel_speeds);
    for (int i = 0; i < TRUNDLE_WHEELS; i++) {
        const trundle_real speed = output->wheel_speeds[i];
        output->rim_speeds[i] = units[i].radius * speed;
        output->rpm[i] = RPM * speed;
        output->motor_rpm[i] = RPM * units[i].gear * speed;
        output->ticks[i] = seconds(elapsed_us) * units[i].per_radian * speed;
    }
}
