"""Which wheel speeds move the lecture's three-omni robot purely sideways?

The lecture (a = 0.2 m, l = 0.3 m) turns it on the spot with equal speeds, drives it forward with
(0, -c, c), and leaves this question open after a few tries. W is square and regular, so there is
one answer.
"""

import numpy as np

import trundle

robot = trundle.load("omni3")
kin = trundle.Kinematics(robot)

tries = {
    "equal speeds": (1, 1, 1),
    "0, -c, c": (0, -1, 1),
    "wheel 1 alone": (1, 0, 0),
    "c, -c, -c": (1, -1, -1),
    "2c, -c, -c": (2, -1, -1),
}
print(f"{'':15}{'u':>10}{'v':>10}{'r':>10}   for c = 1 rad/s")
for name, speeds in tries.items():
    u, v, r = kin.forward(speeds)
    print(f"{name:15}{u:10.4f}{v:10.4f}{r:10.4f}")

answer = kin.inverse([0.0, 0.5, 0.0])
print("\n0.5 m/s to the left needs", answer.wheel_speeds.round(4), "rad/s")

# The lecture's simulation: 10 s from (0.5, 0.5, 45 deg).
start = (0.5, 0.5, np.pi / 4)
run = trundle.simulate(robot, wheel_speeds=answer.wheel_speeds, duration=10.0, pose=start)
print("10 s later it is at", run.pose[-1].round(4))

# By hand, from W = a/3 [[0, -s, s], [2, -1, -1], [1/l, 1/l, 1/l]] with s = sqrt(3).
a, l = 0.2, 0.3
s = np.sqrt(3)
np.testing.assert_allclose(kin.forward((0, -1, 1)), [2 * s * a / 3, 0, 0], atol=1e-12)
np.testing.assert_allclose(kin.forward((1, 0, 0)), [0, 2 * a / 3, a / (3 * l)], atol=1e-12)
np.testing.assert_allclose(kin.forward((1, -1, -1)), [0, 4 * a / 3, -a / (3 * l)], atol=1e-12)
np.testing.assert_allclose(kin.forward((2, -1, -1)), [0, 2 * a, 0], atol=1e-12)
np.testing.assert_allclose(answer.wheel_speeds, [2.5, -1.25, -1.25], atol=1e-12)
# 5 m to the left of a robot that looks along 45 deg is 5 m along 135 deg.
np.testing.assert_allclose(run.pose[-1], [0.5 - 5 / 2**0.5, 0.5 + 5 / 2**0.5, np.pi / 4])
