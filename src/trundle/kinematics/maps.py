"""From constraint rows to the linear maps between wheel speeds and twists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.kinematics.constraints import (
    frame,
    gains,
    rolling_matrix,
    side_slip_matrix,
    skid_matrices,
)
from trundle.kinematics.linear import (
    ANGLE_TOLERANCE,
    RANK_TOLERANCE,
    null_projector,
    pseudo_inverse,
)
from trundle.robot import Robot, RollingWheel, Wheel
from trundle.se2 import Array


def holding_rows(robot: Robot, steering: Array, exact: bool = True) -> tuple[Array, float]:
    """Return the rows (..., m, 3) that hold exactly, and the tolerance for their rank.

    The side-slip rows of the wheels; wheels that may skid add one condition: where the rolling
    rows leave a motion open, their side slip has the least sum of squares.

    Args:
        robot: the robot.
        steering: (..., s) steering angles [rad].
        exact: False leaves out the rows of steered wheels, whose angles are measured with error.
    """
    wheels: Sequence[Wheel] = robot.wheels
    if not exact:
        wheels = [wheel for wheel in wheels if not wheel.steers]
    rows = side_slip_matrix(robot, wheels, steering)
    tolerance = ANGLE_TOLERANCE if exact and robot.steered else RANK_TOLERANCE
    skid_rolling, skid_slip = skid_matrices(robot, steering.shape[:-1])
    if skid_slip.shape[-2] == 0:
        return rows, tolerance
    rolling = _stacked(rolling_matrix(robot, robot.driven, steering), skid_rolling)
    open_motion, _ = null_projector(_stacked(rows, rolling), tolerance, frame(robot))
    return _stacked(rows, open_motion @ (np.swapaxes(skid_slip, -1, -2) @ skid_slip)), tolerance


def _stacked(rows: Array, more: Array) -> Array:
    batch = rows.shape[:-2]
    return np.concatenate([rows, np.broadcast_to(more, (*batch, *more.shape[-2:]))], axis=-2)


def motion_projector(robot: Robot, steering: Array) -> tuple[Array, Array]:
    """Return the projector N N^T (..., 3, 3) onto the twists that hold, and the rows' rank."""
    rows, tolerance = holding_rows(robot, steering)
    return null_projector(rows, tolerance, frame(robot))


def _solve(
    robot: Robot, rows: Array, tolerance: float, moving: Array
) -> tuple[Array, Array, Array]:
    """Return N (A N)^+ (..., 3, k) for rows C that hold and moving rows A, and two projectors.

    The projectors are onto the motions that A tells, and onto those that it leaves open.
    """
    here = frame(robot)
    allowed, held = null_projector(rows, tolerance, here)
    unseen, both = null_projector(np.concatenate([rows, moving], axis=-2), tolerance, here)
    inverse, _ = pseudo_inverse(moving @ (allowed - unseen), both - held)
    return inverse, allowed - unseen, unseen


def wheel_matrix(robot: Robot, steering: Array) -> tuple[Array, Array]:
    """Return W (..., 3, n) = N (A N)^+ R, and the projector onto the twists that it can give.

    The side-slip rows of all wheels hold exactly; A and R take the driven wheels.
    """
    rows, tolerance = holding_rows(robot, steering)
    rolling = rolling_matrix(robot, robot.driven, steering)
    inverse, can_give, _ = _solve(robot, rows, tolerance, rolling)
    return inverse * gains(robot.driven)[..., None, :], can_give


def estimator(robot: Robot, wheels: Sequence[RollingWheel], steering: Array) -> tuple[Array, Array]:
    """Return the map (..., 3, k) from measured wheel speeds to the twist, and what it leaves open.

    Fixed wheels' side-slip rows hold exactly; the rolling rows of the given wheels and the
    side-slip rows of steered wheels enter the least squares together, with weight 1.

    Returns:
        The map, and the projector (..., 3, 3) onto the motions that are allowed but not observed.
    """
    rows, tolerance = holding_rows(robot, steering, exact=False)
    measured = _stacked(
        rolling_matrix(robot, wheels, steering), side_slip_matrix(robot, robot.steered, steering)
    )
    inverse, _, unseen = _solve(robot, rows, tolerance, measured)
    return inverse[..., : len(wheels)] * gains(wheels)[..., None, :], unseen
