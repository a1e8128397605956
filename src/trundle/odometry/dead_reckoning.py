"""Dead reckoning: from the wheels' turning to the path, by exact arcs."""

from __future__ import annotations

import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.kinematics import Kinematics, finite
from trundle.robot import Robot
from trundle.se2 import Array, chain


def dead_reckon(
    robot: Robot,
    wheel_increments: npt.ArrayLike,
    steering: npt.ArrayLike | None = None,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Array:
    """Return the poses that the turning of the sensed wheels tells.

    Each row gives the body increment by least squares over the sensed wheels' rolling rows, and
    the pose moves along the exact arc of a constant twist.

    Args:
        robot: the robot.
        wheel_increments: (T, k) turn of the sensed wheels, in order, since the row before [rad],
            with the motors' signs.
        steering: (s,) or (T, s) steering angles at the middle of each row's interval [rad].
        pose: (3,) start x, y, psi in the inertial frame [m, m, rad].

    Returns:
        (T + 1, 3) poses in the inertial frame; psi is not wrapped.

    Raises:
        ShapeError: an array has the wrong shape or values that are not finite.
        UnobservedMotionError: too few wheels are sensed; the unobserved motion is named.

    Source: the exact arc step of Siegwart and Nourbakhsh, 2004, section 5.2.4, for any twist.

    >>> from trundle import load
    >>> quarter = [[5.0, 15.0]] * 10  # left, right [rad] per row
    >>> dead_reckon(load("differential", radius=0.02, track=0.4), quarter).shape
    (11, 3)
    """
    kinematics = Kinematics(robot)
    names = ", ".join(wheel.name for wheel in robot.sensed) or "no wheel"
    increments = finite(wheel_increments, "wheel_increments")
    if increments.ndim != 2 or increments.shape[1] != len(robot.sensed):
        raise ShapeError(
            f"wheel_increments must have shape (T, {len(robot.sensed)}), one column for each "
            f"sensed wheel ({names}), got {increments.shape}"
        )
    start = finite(pose, "pose")
    if start.shape != (3,):
        raise ShapeError(f"pose must be (x, y, psi), got shape {start.shape}")
    angles = None if steering is None else finite(steering, "steering")
    rows = (len(increments),)
    if angles is not None and angles.shape[:-1] not in ((), rows):
        raise ShapeError(
            f"steering must have shape (s,), or one row for each of the {len(increments)} rows of "
            f"wheel_increments, got shape {angles.shape}"
        )
    to_increment = kinematics.odometry_matrix(angles)
    return chain((to_increment @ increments[..., None])[..., 0], start)
