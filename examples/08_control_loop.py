"""A control loop at 100 Hz: plain floats in, plain floats out.

``bind()`` writes the robot's constants into three small functions. Here a mecanum robot goes to a
pose with a velocity in proportion to the distance left, as seen from the body, while odometry keeps
its pose from the wheels' turning.
"""

import math

import trundle

plain = trundle.Kinematics(trundle.load("mecanum")).bind()

GAIN, DT, STEPS = 1.5, 0.01, 500  # [1/s], [s]


def drive(goal):
    """Return the poses on the way to a goal, starting at the origin."""
    x, y, psi = 0.0, 0.0, 0.0
    poses = [(x, y, psi)]
    for _ in range(STEPS):
        far_x, far_y, turn = goal[0] - x, goal[1] - y, goal[2] - psi
        c, s = math.cos(psi), math.sin(psi)
        u = GAIN * (c * far_x + s * far_y)  # the inertial frame's velocity, seen from the body
        v = GAIN * (-s * far_x + c * far_y)
        wheel_speeds = plain.inverse(u, v, GAIN * turn)  # to the motors
        increments = [speed * DT for speed in wheel_speeds]  # from the encoders
        x, y, psi = plain.step(x, y, psi, *increments)
        poses.append((x, y, psi))
    return poses


straight = drive((1.0, 0.5, 0.0))
turning = drive((1.0, 0.5, math.pi / 2))
for poses in (straight, turning):
    print("after 1 s:", [round(value, 4) for value in poses[100]], end="   ")
    print("after 5 s:", [round(value, 4) for value in poses[-1]])
back = plain.forward(*plain.inverse(0.2, -0.1, 0.3))
print("there and back:", [round(value, 12) for value in back])

# By hand: without turning, each step leaves the share 1 - GAIN * DT of the distance.
left = (1 - GAIN * DT) ** 100
assert math.isclose(straight[100][0], 1 - left, rel_tol=1e-9)
assert math.isclose(straight[100][1], 0.5 * (1 - left), rel_tol=1e-9)
assert math.isclose(turning[100][2], math.pi / 2 * (1 - left), rel_tol=1e-9)
assert math.hypot(turning[-1][0] - 1.0, turning[-1][1] - 0.5) < 1e-3
assert [round(value, 12) for value in back] == [0.2, -0.1, 0.3]
