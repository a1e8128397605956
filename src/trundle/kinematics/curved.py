"""Inverse kinematics where linked wheels allow only a curved family of twists."""

from __future__ import annotations

import numpy as np

from trundle.kinematics.constraints import frame, side_slip_matrix
from trundle.kinematics.linear import ANGLE_TOLERANCE, null_projector
from trundle.kinematics.steering import couplings
from trundle.robot import Robot
from trundle.se2 import Array

_STARTS = 9  # start angles tried for each half turn of an input's range
_MOST = np.pi  # beyond half a turn to either side a wheel without limits stands as before


def nearest_on_curve(
    robot: Robot, asked: Array, to_point: Array, start: Array, low: Array, high: Array
) -> tuple[Array, Array]:
    """Return inputs (g,) and twist (3,) of the origin that come nearest to the twist asked.

    Minimises ``|T zeta - asked|^2`` under ``C(q) zeta = 0`` and the range of q, from several
    starts; standing still is always an answer.

    Args:
        robot: the robot, with linked steering.
        asked: (3,) twist of the point that was asked for.
        to_point: (3, 3) map T from the origin's twist to the point's.
        start: (g,) inputs to prefer among equals.
        low: (g,) least inputs [rad].
        high: (g,) largest inputs [rad].
    """
    best, held, least = np.clip(start, low, high), np.zeros(3), float(asked @ asked)
    for first in _starts(start, low, high):
        inputs = _search(robot, asked, to_point, first, low, high)
        twist = _best_twist(robot, asked, to_point, inputs)
        miss = float(np.sum((to_point @ twist - asked) ** 2))
        if miss < least - 1e-9 * float(asked @ asked):
            best, held, least = inputs, twist, miss
    return best, held


def _starts(start: Array, low: Array, high: Array) -> list[Array]:
    left, right = np.maximum(low, -_MOST), np.minimum(high, _MOST)
    count = int(np.ceil(_STARTS * (right - left).max() / np.pi))
    # Never exactly the middle, where linked wheels are often parallel and the way is not defined.
    shares = (np.arange(count) + 0.4) / count
    return [np.clip(start, low, high), *(left + share * (right - left) for share in shares)]


def _search(
    robot: Robot, asked: Array, to_point: Array, first: Array, low: Array, high: Array
) -> Array:
    from scipy.optimize import minimize

    coupling, g = couplings(robot), len(first)
    size = float(np.linalg.norm(asked)) or 1.0

    def miss(z: Array) -> float:
        return float(np.sum((to_point @ z[g:] - asked / size) ** 2))

    def slip(z: Array) -> Array:
        return np.asarray(side_slip_matrix(robot, robot.wheels, coupling @ z[:g]) @ z[g:])

    found = minimize(
        miss,
        np.concatenate([first, np.linalg.solve(to_point, asked / size)]),
        method="SLSQP",
        bounds=[*zip(low, high, strict=True), *[(None, None)] * 3],
        constraints={"type": "eq", "fun": slip},
        options={"ftol": 1e-14, "maxiter": 200},
    )
    # Where wheels all but coincide, the search may lose itself in numbers that are none.
    inputs = np.where(np.isfinite(found.x[:g]), found.x[:g], first)
    return np.asarray(np.clip(inputs, low, high))


def _best_twist(robot: Robot, asked: Array, to_point: Array, inputs: Array) -> Array:
    """Return the allowed twist at these inputs that is nearest to the one asked."""
    rows = side_slip_matrix(robot, robot.wheels, couplings(robot) @ inputs)
    allowed, _ = null_projector(rows, ANGLE_TOLERANCE, frame(robot))
    weights, *_ = np.linalg.lstsq(to_point @ allowed, asked, rcond=1e-9)
    return np.asarray(allowed @ weights)
