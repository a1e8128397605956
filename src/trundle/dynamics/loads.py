"""How the robot's weight stands on its wheels."""

from __future__ import annotations

import numpy as np

from trundle.robot import Robot, total_mass
from trundle.se2 import Array

# Standard gravity [m/s^2], exact: 3rd General Conference on Weights and Measures, 1901.
GRAVITY = 9.80665


def wheel_loads(robot: Robot) -> Array:
    """Return the weight on each wheel at rest (k,) [N], all wheels in order.

    ``sum N = m g`` and ``sum N d = m g c``. Four wheels and more share it in the least-squares
    sense, as a stiff body on equally soft wheels does. Where two wheels carry a body that would
    tip, nothing balances it and every value is nan.
    """
    total = total_mass(robot)
    at = np.array([(1.0, wheel.x, wheel.y) for wheel in robot.wheels]).T
    wanted = total.mass * GRAVITY * np.array([1.0, *total.com])
    loads, *_ = np.linalg.lstsq(at, wanted, rcond=None)
    if not np.allclose(at @ loads, wanted, rtol=1e-9, atol=1e-9 * wanted[0]):
        return np.full(len(robot.wheels), np.nan)
    return np.asarray(loads)
