"""An X-drive whose motors are all mounted mirrored: there and back, and wheel by wheel.

The formulas are those of the slides on the four-omni robot, with the sign put right that they
lost: v_i = vx sin th_i - vy cos th_i - w R. A round trip alone would also pass for the mirrored
robot, so the end of this file looks at how each contact point moves.
"""

import numpy as np

import trundle

robot = trundle.load("omni4")  # all wheels have reversed = true
kin = trundle.Kinematics(robot)
th = np.radians([45.0, 315.0, 135.0, 225.0])  # FL, FR, RL, RR
radius, arm = 0.05, 0.2

asked = np.array([0.3, -0.1, 0.8])
speeds = kin.inverse(asked).wheel_speeds
back = kin.forward(speeds)
for wheel, speed in zip(robot.driven, speeds, strict=True):
    print(f"{wheel.name:12} {speed:8.4f} rad/s")
print("there and back:", asked, "->", back.round(12))

# The slides, there: rim speeds from a twist.
vx, vy, w = asked
rims = vx * np.sin(th) - vy * np.cos(th) - w * arm
np.testing.assert_allclose(radius * speeds, rims, atol=1e-12)

# The slides, back: their printed forward map.
again = [(rims * np.sin(th)).sum() / 2, -(rims * np.cos(th)).sum() / 2, -rims.sum() / (4 * arm)]
np.testing.assert_allclose(again, asked, atol=1e-12)
np.testing.assert_allclose(back, asked, atol=1e-12)

# Wheel by wheel: the contact moves along the drive direction by minus the rim speed.
for wheel, rim in zip(robot.driven, rims, strict=True):
    contact = np.array([vx - w * wheel.y, vy + w * wheel.x])
    drive = np.array([np.cos(wheel.heading), np.sin(wheel.heading)])
    assert wheel.reversed
    assert abs(contact @ drive + rim) < 1e-12
