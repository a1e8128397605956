/* Runs a robot's firmware over the numbers of vectors.h and writes what comes out, bit by bit, so
 * that no printing of numbers comes between: a line for each value, its bytes from low to high. */
#include "trundle.h"

#include <stddef.h>
#include <stdint.h>

#ifdef TRUNDLE_STEERED
#define STEERING(values) , values
#else
#define STEERING(values)
#endif

typedef struct {
    trundle_real twist[3];
    trundle_real wheel_speeds[TRUNDLE_WHEELS];
    trundle_real increments[TRUNDLE_COUNTERS];
    trundle_real pose[3];
#ifdef TRUNDLE_STEERED
    trundle_real steering[TRUNDLE_STEERED];
#endif
} call;

typedef struct {
    uint32_t now_us;
    bool asked;
    bool counted;
    bool measured;
    trundle_real command[3];
    uint32_t counts[TRUNDLE_COUNTERS];
#ifdef TRUNDLE_STEERED
    trundle_real steering[TRUNDLE_STEERED];
#endif
} cycle;

#include "vectors.h"

void emit(char letter);
#if defined(HOST)
#include <stdio.h>
void emit(char letter)
{
    putchar(letter);
}
#elif defined(__AVR__)
void finish(void);
#endif

static void show(const void *value, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)value;
    for (size_t i = 0; i < size; i++) {
        emit("0123456789abcdef"[bytes[i] >> 4]);
        emit("0123456789abcdef"[bytes[i] & 15]);
    }
    emit('\n');
}

static void show_reals(const trundle_real *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        show(&values[i], sizeof values[i]);
    }
}

static void show_number(uint32_t number)
{
    show(&number, sizeof number);
}

static void run_calls(void)
{
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++) {
        const call *each = &calls[i];
        trundle_real speeds[TRUNDLE_WHEELS], twist[3], pose[3];
#ifdef TRUNDLE_STEERED
        trundle_real angles[TRUNDLE_STEERED];
#endif
        trundle_inverse(each->twist, speeds STEERING(angles));
        show_reals(speeds, TRUNDLE_WHEELS);
#ifdef TRUNDLE_STEERED
        show_reals(angles, TRUNDLE_STEERED);
#endif
        trundle_forward(each->wheel_speeds STEERING(each->steering), twist);
        show_reals(twist, 3);
        for (int k = 0; k < 3; k++) {
            pose[k] = each->pose[k];
        }
        trundle_odometry(pose, each->increments STEERING(each->steering));
        show_reals(pose, 3);
    }
}

static void run_cycles(void)
{
    trundle_state state;
    trundle_output output;
    trundle_start(&state, START_US, NULL STEERING(NULL));
    for (size_t i = 0; i < sizeof cycles / sizeof cycles[0]; i++) {
        const cycle *now = &cycles[i];
        trundle_step(&state, now->now_us, now->asked ? now->command : NULL,
            now->counted ? now->counts : NULL STEERING(now->measured ? now->steering : NULL),
            &output);
        show_reals(output.wheel_speeds, TRUNDLE_WHEELS);
        show_reals(output.rim_speeds, TRUNDLE_WHEELS);
        show_reals(output.rpm, TRUNDLE_WHEELS);
        show_reals(output.motor_rpm, TRUNDLE_WHEELS);
        show_reals(output.ticks, TRUNDLE_WHEELS);
#ifdef TRUNDLE_STEERED
        show_reals(output.steering, TRUNDLE_STEERED);
#endif
        show_reals(output.twist, 3);
        show_reals(state.pose, 3);
        show_reals(state.velocity, 3);
        show_number(output.limits);
        show_number(output.stale);
        show_number(state.refused);
        show_number(state.refused_counts);
    }
}

int main(void)
{
    run_calls();
    run_cycles();
#ifdef __AVR__
    finish();
#endif
    return 0;
}
