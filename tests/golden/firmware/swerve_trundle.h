/* The robot 'swerve': kinematics, limits and odometry. Printed by trundle.
 *
 * SI units and radians. A twist is (u, v, r): velocity ahead and to the left [m/s] and yaw rate,
 * counter-clockwise [rad/s], of the body's origin; a pose is (x, y, psi). Wheel speeds [rad/s] have
 * the signs of the motors. Nothing is allocated, and nothing is kept between calls but what stands
 * in the trundle_state.
 */
#ifndef TRUNDLE_H
#define TRUNDLE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The type of all numbers: double, or float where TRUNDLE_FLOAT is defined for every file, such as
 * by -DTRUNDLE_FLOAT. Functions for float have names of their own: a mixture does not link. */
#ifdef TRUNDLE_FLOAT
typedef float trundle_real;
#define trundle_inverse trundle_inverse_float
#define trundle_forward trundle_forward_float
#define trundle_odometry trundle_odometry_float
#define trundle_start trundle_start_float
#define trundle_step trundle_step_float
#else
typedef double trundle_real;
#endif

#define TRUNDLE_WHEELS 4   /* driven wheels */
#define TRUNDLE_STEERED 4  /* steered wheels */
#define TRUNDLE_INPUTS 4   /* steering motors: wheels that are linked share one */
#define TRUNDLE_COUNTERS 4 /* wheels with a counter */

/* Places of wheels in arrays: of driven wheels, of steered ones, and of those with a counter. */
enum {
    TRUNDLE_WHEEL_FRONT_LEFT = 0,
    TRUNDLE_WHEEL_FRONT_RIGHT = 1,
    TRUNDLE_WHEEL_REAR_LEFT = 2,
    TRUNDLE_WHEEL_REAR_RIGHT = 3,
    TRUNDLE_STEERED_FRONT_LEFT = 0,
    TRUNDLE_STEERED_FRONT_RIGHT = 1,
    TRUNDLE_STEERED_REAR_LEFT = 2,
    TRUNDLE_STEERED_REAR_RIGHT = 3,
    TRUNDLE_COUNTER_FRONT_LEFT = 0,
    TRUNDLE_COUNTER_FRONT_RIGHT = 1,
    TRUNDLE_COUNTER_REAR_LEFT = 2,
    TRUNDLE_COUNTER_REAR_RIGHT = 3
};

/* ---- kinematics ----------------------------------------------------------------------------- */

/* Wheel speeds [rad/s] and steering angles [rad] for a twist, without limits. */
void trundle_inverse(const trundle_real twist[3], trundle_real wheel_speeds[4],
    trundle_real steering[4]);

/* The twist from the driven wheels' speeds [rad/s] and the steering angles [rad]. */
void trundle_forward(const trundle_real wheel_speeds[4], const trundle_real steering[4],
    trundle_real twist[3]);

/* Move a pose by the turns [rad] of the wheels with a counter since the last call,
 * at the steering angles [rad] midway between the two. */
void trundle_odometry(trundle_real pose[3], const trundle_real wheel_increments[4],
    const trundle_real steering[4]);

/* ---- the whole bridge: commands in, wheel speeds out; counters in, pose out ------------------ */

/* What keeps a robot from doing what was asked; output.limits holds the sum of those in force. */
enum {
    TRUNDLE_LIMIT_WHEELS = 1,         /* the wheels do not allow such a twist */
    TRUNDLE_LIMIT_STEERING_RANGE = 2, /* a steering angle ends */
    TRUNDLE_LIMIT_SPEED = 4,
    TRUNDLE_LIMIT_WHEEL_SPEED = 8,
    TRUNDLE_LIMIT_ACCELERATION = 16,
    TRUNDLE_LIMIT_JERK = 32,
    TRUNDLE_LIMIT_STEERING_RATE = 64
};

/* What is known from cycle to cycle. A value: it can be copied and kept. */
typedef struct {
    uint32_t refused;         /* commands that were no numbers, or far too large */
    uint32_t refused_counts;  /* readings of the counters that cannot be */
    trundle_real pose[3];     /* by odometry [m, m, rad]; psi is not wrapped */
    trundle_real velocity[3]; /* measured twist */
    /* what follows is trundle_step's own */
    trundle_real command[3];
    trundle_real twist[3];
    trundle_real rate[3];
    bool braked; /* whether the last step was not a ramp's */
    trundle_real inputs[TRUNDLE_INPUTS];
    trundle_real angles[TRUNDLE_STEERED];
    uint32_t counts[TRUNDLE_COUNTERS];
    uint32_t now_us;
    uint32_t command_us;
    uint32_t counts_us;
    bool commanded; /* there is a command that is not stale for good */
    bool counted;   /* there is a reading of the counters */
} trundle_state;

/* What a cycle tells the wheels, driven wheels in order. */
typedef struct {
    trundle_real wheel_speeds[TRUNDLE_WHEELS]; /* [rad/s] */
    trundle_real rim_speeds[TRUNDLE_WHEELS];   /* [m/s] */
    trundle_real rpm[TRUNDLE_WHEELS];          /* turns of the wheels per minute */
    trundle_real motor_rpm[TRUNDLE_WHEELS];    /* turns of the motors per minute, before the gear */
    trundle_real ticks[TRUNDLE_WHEELS];        /* counts in a cycle as long as the last */
    trundle_real steering[TRUNDLE_STEERED];    /* [rad] */
    trundle_real twist[3];                     /* what these give */
    unsigned limits;                           /* sum of TRUNDLE_LIMIT_... */
    bool stale;                                /* no command is young enough: braking, or at rest */
} trundle_output;

/* Begin at rest at a pose [m, m, rad], with steering angles [rad]; NULL: zeros. Times are of a
 * clock that counts microseconds and never goes back; it may wrap around, as micros() does. */
void trundle_start(trundle_state *state, uint32_t now_us, const trundle_real pose[3],
    const trundle_real steering[4]);

/* One cycle, at least once an hour.
 *
 * command: a twist that has come since the last cycle, or NULL.
 * counts: the counters of the wheels in places TRUNDLE_COUNTER_..., or NULL where they were not
 *     read; they may wrap around after 16 bits. A reading that cannot be is refused.
 * steering: the measured steering angles [rad], or NULL: then those told stand for them.
 */
void trundle_step(trundle_state *state, uint32_t now_us, const trundle_real command[3],
    const uint32_t counts[4], const trundle_real steering[4], trundle_output *output);

#ifdef __cplusplus
}
#endif

#endif
