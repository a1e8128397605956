"""The exercise's three motions of a robot with three omni wheels that spin it clockwise.

Wheel speeds as functions of time give a turn on the spot, a line and a circle at constant heading
(l = 0.5 m, r = 0.1 m, wheels at alpha = 0, 120, 240 deg).
"""

import numpy as np

import trundle
from trundle import view

PERIOD, C = 60.0, 0.5  # [s], [rad/s]
l, radius = 0.5, 0.1
alpha = np.radians([0.0, 120.0, 240.0])

robot = trundle.load("omni3_exercise")


def turn(t):
    """One turn counter-clockwise in a period: the wheels' own sense is clockwise."""
    return np.full((*np.shape(t), 3), -2 * np.pi * l / (PERIOD * radius))


def line(t):
    """Straight ahead."""
    return np.broadcast_to([0.0, C, -C], (*np.shape(t), 3))


def circle(t):
    """The direction of travel goes round once in a period; the heading stays."""
    return np.cos(2 * np.pi * np.asarray(t)[..., None] / PERIOD - alpha)


runs = {
    motion.__name__: trundle.simulate(
        robot, wheel_speeds=motion, duration=PERIOD, dt=0.01, method="rk4"
    )
    for motion in (turn, line, circle)
}
for name, run in runs.items():
    print(f"{name:7} ends at {run.pose[-1].round(6) + 0.0}")
view.save(view.plot_path(robot, runs["circle"]), "circle.png")

np.testing.assert_allclose(runs["turn"].pose[-1], [0, 0, 2 * np.pi], atol=1e-9)
np.testing.assert_allclose(
    runs["line"].pose[-1], [PERIOD * 2 * radius * C / np.sqrt(3), 0, 0], atol=1e-9
)
# It starts along the body's -y, so that the centre is a radius ahead: counter-clockwise.
size = radius * PERIOD / (2 * np.pi)
away = np.hypot(*(runs["circle"].pose[:, :2] - [size, 0.0]).T)
np.testing.assert_allclose(away, size, rtol=1e-6)
assert np.abs(runs["circle"].pose[:, 2]).max() < 1e-9
