"""How the robot's weight stands on its wheels."""

from __future__ import annotations

import numpy as np

from trundle.kinematics import robot_of
from trundle.robot import Robot, total_mass
from trundle.se2 import Array

# Standard gravity [m/s^2], exact: 3rd General Conference on Weights and Measures, 1901.
GRAVITY = 9.80665
# Equilibrium is reached, and a wheel carries nothing, to this share of the weight.
_ROUNDING = 1e-9
_MOST_ROUNDS = 50


def wheel_loads(robot: Robot) -> Array:
    """Return the weight on each wheel at rest (k,) [N], all wheels in order.

    ``sum N = m g`` and ``sum N d = m g c``, no wheel pulling. Four wheels and more share it as a
    stiff body on equally soft wheels does. A caster carries at its pivot. Where the body would tip
    nothing balances it, and every value is nan.

    >>> import trundle
    >>> bike = trundle.load("bicycle").with_body(mass=80.0, com=(0.25, 0.0))
    >>> wheel_loads(bike).round(3).tolist()  # front, rear
    [196.133, 588.399]
    """
    total = total_mass(robot_of(robot))
    weight = total.mass * GRAVITY
    # Places from the centre of mass, in units of the farthest: the moments about it are zero.
    place = np.array([(wheel.x, wheel.y) for wheel in robot.wheels]) - total.com
    place /= max(float(np.abs(place).max()), 1e-300)
    at = np.column_stack([np.ones(len(place)), place])
    wanted = np.array([weight, 0.0, 0.0])
    standing = np.ones(len(place), dtype=bool)
    depth = np.zeros(len(place))
    for _ in range(_MOST_ROUNDS):
        sink, *_ = np.linalg.lstsq(at.T[:, standing] @ at[standing], wanted, rcond=_ROUNDING)
        depth = at @ sink
        # A wheel that carries nothing stays as it is, up or down.
        still = np.where(np.abs(depth) <= _ROUNDING * weight, standing, depth > 0)
        if (still == standing).all():
            break
        standing = still
    loads = np.where(standing & (depth > _ROUNDING * weight), depth, 0.0)
    balanced = np.abs(at.T @ loads - wanted).max() <= _ROUNDING * weight
    return np.asarray(loads) if balanced else np.full(len(place), np.nan)
