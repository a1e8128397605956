// A main loop for the robot 'mecanum' on an Arduino-style board:
// fill in the functions at the top.
#include "trundle.h"

// The counter of a wheel: a place TRUNDLE_COUNTER_... Counts go up when the motor turns forwards.
static uint32_t read_counter(int place) {
  (void)place;
  return 0;  // such as: encoder[place].read()
}

// Drive a motor at a speed [rad/s] of its wheel: a place TRUNDLE_WHEEL_...
static void drive_motor(int place, trundle_real speed) {
  (void)place;
  (void)speed;  // such as: controller[place].setSpeed(speed)
}

// Whether a command has come since the last call: a twist (u, v, r) [m/s, m/s, rad/s].
static bool read_command(trundle_real twist[3]) {
  (void)twist;
  return false;  // such as: read from Serial
}

static const uint32_t CYCLE_US = 20000;
static trundle_state state;
static uint32_t last_us;

void setup() {
  last_us = micros();
  trundle_start(&state, last_us, NULL);
}

void loop() {
  const uint32_t now_us = micros();
  if (now_us - last_us < CYCLE_US) {
    return;
  }
  last_us = now_us;

  trundle_real command[3];
  uint32_t counts[TRUNDLE_COUNTERS];
  trundle_output output;
  const bool commanded = read_command(command);
  for (int i = 0; i < TRUNDLE_COUNTERS; i++) {
    counts[i] = read_counter(i);
  }
  trundle_step(&state, now_us, commanded ? command : NULL, counts, &output);
  for (int i = 0; i < TRUNDLE_WHEELS; i++) {
    drive_motor(i, output.wheel_speeds[i]);
  }
  // state.pose is where the robot is: x, y [m], psi [rad].
}
