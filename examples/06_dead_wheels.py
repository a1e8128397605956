"""A mixed robot, two mecanum wheels in front and two dead wheels behind: log and odometry.

The dead wheels have encoders and no motors, and hold the rear against side slip. The robot drives
a circle, its log is written as real sensors would have, and the log is replayed.
"""

import math

import numpy as np

import trundle
from trundle import view
from trundle.odometry import read_log, score
from trundle.simulation import replay, write_log

robot = trundle.load("mixed")
print("driven:", [wheel.name for wheel in robot.driven])
print("sensed:", [wheel.name for wheel in robot.sensed])

# The rear must not slip: v + r x = 0 at x = -0.2 m.
u, r, rear = 0.3, 0.4, -0.2
turns_once = 2 * math.pi / r
run = trundle.simulate(robot, twist=[u, -r * rear, r], duration=turns_once, dt=0.02)

path = write_log(robot, run, "log.csv", counter_bits=12)
print(path.read_text(encoding="utf-8").splitlines()[0])
log = read_log(path, robot, counter_bits=12)
replayed = replay(robot, log, pose=log.truth[0])
error = score(replayed.pose, log.truth)
print(f"{error.distance:.3f} m driven, {1000 * error.end_error:.3f} mm off at the end")
view.save(view.plot_path(robot, replayed, truth=log.truth), "replay.png")

# By hand: a circle about the point (rear, u / r) of the body, once round.
centre = np.array([rear, u / r])
away = np.hypot(*(run.pose[:, :2] - centre).T)
np.testing.assert_allclose(away, math.hypot(*centre), rtol=1e-9)
np.testing.assert_allclose(run.pose[-1], [0, 0, 2 * math.pi], atol=1e-9)

# The dead wheels stand at y = +-0.075 m with a radius of 0.03 m: rim speeds u - r y.
turned = log.wheel_increments.sum(axis=0)[2:]
by_hand = np.array([u - r * 0.075, u + r * 0.075]) * turns_once / 0.03
tick = 2 * math.pi / 2048
np.testing.assert_allclose(turned, by_hand, atol=tick)

# Half a tick of each dead wheel is 0.05 mm on the ground: the path ends within a millimetre.
assert error.end_error < 1e-3
assert math.isclose(error.distance, math.hypot(*centre) * 2 * math.pi, rel_tol=1e-3)
