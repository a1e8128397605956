"""From constraint rows to the linear maps between wheel speeds and twists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.kinematics.constraints import (
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


def motion_projector(robot: Robot, steering: Array, exact: bool = True) -> tuple[Array, Array]:
    """Return the projector onto the twists that the side-slip rows allow, and the rows' rank.

    ``P = N N^T`` with N an orthonormal basis of null(C). Wheels that may skid add one condition:
    where the rolling rows leave a motion open, their side slip has the least sum of squares.

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
    projector, rank = null_projector(rows, tolerance)
    skid_rolling, skid_slip = skid_matrices(robot)
    if len(skid_slip) == 0:
        return projector, rank
    batch = rows.shape[:-2]
    held = np.concatenate(
        [np.broadcast_to(skid_rolling, (*batch, *skid_rolling.shape)), np.eye(3) - projector],
        axis=-2,
    )
    open_motion, _ = null_projector(held)
    least_slip = open_motion @ (skid_slip.T @ skid_slip)
    return null_projector(np.concatenate([rows, least_slip], axis=-2), tolerance)


def wheel_matrix(robot: Robot, steering: Array) -> tuple[Array, Array]:
    """Return W (..., 3, n) = N (A N)^+ R, and the projector onto the twists that it can give.

    The side-slip rows of all wheels hold exactly; A and R take the driven wheels.
    """
    allowed, _ = motion_projector(robot, steering)
    rolling = rolling_matrix(robot, robot.driven, steering) @ allowed
    inverse, _ = pseudo_inverse(rolling)
    return inverse * gains(robot.driven), inverse @ rolling


def estimator(robot: Robot, wheels: Sequence[RollingWheel], steering: Array) -> tuple[Array, Array]:
    """Return the map (..., 3, k) from measured wheel speeds to the twist, and what it leaves open.

    Fixed wheels' side-slip rows hold exactly; the rolling rows of the given wheels and the
    side-slip rows of steered wheels enter the least squares together, with weight 1.

    Returns:
        The map, and the projector (..., 3, 3) onto the motions that are allowed but not observed.
    """
    allowed, _ = motion_projector(robot, steering, exact=False)
    rows = np.concatenate(
        [
            rolling_matrix(robot, wheels, steering),
            side_slip_matrix(robot, robot.steered, steering),
        ],
        axis=-2,
    )
    inverse, _ = pseudo_inverse(rows @ allowed)
    observed = inverse @ rows @ allowed
    return inverse[..., : len(wheels)] * gains(wheels), allowed - observed
