"""How casters swivel along a run, for pictures."""

from __future__ import annotations

import math

import numpy as np

from trundle.robot import CasterWheel, Robot
from trundle.se2 import Array, point_twist
from trundle.simulation.run import Run


def caster_angles(robot: Robot, run: Run) -> Array:
    """Return the swivel angles (T + 1, c) of the robot's casters in the body frame [rad].

    With V the pivot's speed, chi its direction and G = g + psi, all in the inertial frame, the
    side-slip condition n . v_p = b (r + g_dot) reads ``b G_dot = V sin(chi - G)``; over a step
    with constant chi it has the solution
    ``tan((G' - chi) / 2) = tan((G - chi) / 2) exp(-V dt / b)``. A caster without a trail follows
    at once.

    Args:
        robot: the robot of the run.
        run: the run.

    Source: Siegwart and Nourbakhsh, 2004, section 3.2.3, eq. (3.18).

    >>> from trundle import load, simulate
    >>> robot = load("differential")
    >>> run = simulate(robot, twist=[-0.5, 0.0, 0.0], duration=2.0)
    >>> casters = caster_angles(robot, run)  # it stands against the motion, on the edge of tipping
    >>> casters.shape
    (201, 1)
    """
    casters = [wheel for wheel in robot.wheels if isinstance(wheel, CasterWheel)]
    out = np.zeros((len(run.t), len(casters)))
    for i, wheel in enumerate(casters):
        out[:, i] = _swivel(wheel, run)
    return out


def _swivel(wheel: CasterWheel, run: Run) -> Array:
    dt = np.diff(run.t)
    velocity = point_twist(run.twist, (wheel.x, wheel.y))
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    middle = (run.pose[:-1, 2] + run.pose[1:, 2]) / 2
    course = (np.arctan2(velocity[:, 1], velocity[:, 0]) + middle).tolist()
    with np.errstate(over="ignore"):
        decay = np.exp(-speed * dt / wheel.trail) if wheel.trail else np.where(speed > 0, 0.0, 1.0)
    angle = wheel.heading + float(run.pose[0, 2])
    angles = [angle]
    for chi, left in zip(course, decay.tolist(), strict=True):
        off = math.remainder(angle - chi, 2 * math.pi)
        # A caster exactly against its course is at rest there; a real one tips over.
        if left < 1 and abs(abs(off) - math.pi) < 1e-6:
            off = math.pi - 1e-3
        angle = chi + 2 * math.atan(math.tan(off / 2) * left)
        angles.append(angle)
    return np.asarray(np.array(angles) - run.pose[:, 2])
