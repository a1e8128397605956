"""A robot's control loop through the bridge, with a simulated robot in place of hardware.

Commands come ten times a second and stop after six seconds: the robot brakes on its curve and
stands in time. One wheel slips; the bridge sees that some wheels disagree, and odometry goes on.
"""

import math

import trundle
from trundle import Encoder

DT, TIMEOUT, BRAKING = 0.02, 0.5, 2.0  # [s], [s], [m/s^2]

robot = trundle.load("swerve")
encoder = Encoder(ticks_per_motor_turn=512, gear=20.0)
bridge = trundle.Bridge(
    robot,
    encoder=encoder,
    timeout=TIMEOUT,
    max_speed=1.0,
    max_acceleration=1.5,
    max_deceleration=BRAKING,
    max_yaw_acceleration=4.0,
    max_yaw_deceleration=8.0,
)
hardware = trundle.SimulatedRobot(robot, encoder=encoder, seed=4, slip={"rear_left": 0.25})

state, machine = bridge.start(), hardware.start()
reading = hardware.read(machine)
slipping, stood = set(), math.nan
for cycle in range(1, 401):
    time = cycle * DT
    command = (0.6, 0.2, 0.3) if time <= 6.0 and cycle % 5 == 0 else None
    output, state = bridge.step(state, time, command, reading.counts, reading.steering)
    reading, machine = hardware.step(machine, time + DT, output.wheel_speeds, output.steering)
    slipping.update(output.slipping)
    if time > 6.0 and not any(output.twist) and math.isnan(stood):
        stood = time

off = math.dist(output.pose[:2], machine.pose[:2])
sigma = math.sqrt(output.covariance[0][0] + output.covariance[1][1])
print(f"stood {stood - 6.0:.2f} s after the last command")
print("wheels that disagree:", *sorted(slipping))
print(f"odometry is {off:.3f} m off; without slip it would be about {sigma:.3f} m")

assert stood - 6.0 <= TIMEOUT + math.hypot(0.6, 0.2) / BRAKING + 1e-9
assert slipping == {"rear_left"}
assert off > sigma  # slip is not noise, and no covariance covers it
