"""Whether steering angles share an instantaneous centre, and the nearest angles that do."""

from __future__ import annotations

import numpy as np

from trundle.kinematics.constraints import frame, side_slip_matrix
from trundle.kinematics.linear import ANGLE_TOLERANCE, null_projector
from trundle.kinematics.steering import contact_velocities, couplings, motion_space, settle
from trundle.robot import Robot
from trundle.se2 import Array, Mask


def share_centre(robot: Robot, steering: Array) -> Mask:
    """Return whether (...,) the robot can roll at steering angles (..., s)."""
    rows = side_slip_matrix(robot, robot.wheels, steering)
    return np.asarray(null_projector(rows, ANGLE_TOLERANCE, frame(robot))[1] < 3)


def nearest_angles(robot: Robot, steering: Array) -> Array | None:
    """Return the steering angles (s,) that share a centre and are nearest, or None.

    Nearest in the sum of squared angle differences, found from the twist that slips least.
    """
    from scipy.optimize import least_squares

    rows = side_slip_matrix(robot, robot.wheels, steering)
    here = frame(robot)
    least_slip = here @ np.linalg.svd(rows @ here)[2][-1]
    space, flat = motion_space(robot)
    if not flat:
        coupling = couplings(robot)
        inputs = np.linalg.pinv(coupling) @ steering
        pair = settle(robot, coupling, inputs, least_slip)
        return None if pair is None else np.asarray(coupling @ pair[0])
    if space.shape[1] == 0:
        return None

    def turn(weights: Array) -> Array:
        velocity = contact_velocities(robot, space @ weights)
        difference = np.arctan2(velocity[:, 1], velocity[:, 0]) - steering
        return np.asarray(difference - np.pi * np.round(difference / np.pi))

    start = space.T @ least_slip
    found = least_squares(turn, start / np.linalg.norm(start), x_scale="jac")
    return np.asarray(steering + turn(found.x))


def consistent_angles(robot: Robot) -> Array | None:
    """Return steering angles (s,) [rad] at or nearest to zero that share a centre, or None.

    >>> from trundle import load
    >>> consistent_angles(load("ackermann")).tolist()
    [0.0, 0.0]
    """
    zero = np.zeros(len(robot.steered))
    return zero if share_centre(robot, zero) else nearest_angles(robot, zero)


def off_centre_words(robot: Robot, steering: Array) -> str:
    """Return what is wrong with steering angles that share no centre, and what would be right."""
    names = ", ".join(wheel.name for wheel in robot.steered)
    told = (
        f"the steering angles of {names}, {_degrees(steering)} deg, share no instantaneous centre: "
        f"robot {robot.name!r} cannot roll without slipping"
    )
    near = nearest_angles(robot, steering)
    if near is None:
        return f"{told}, at these or any other angles"
    radians = ", ".join(f"{angle:.9f}" for angle in near)
    return f"{told}. The nearest that do are {_degrees(near)} deg ({radians} rad)"


def _degrees(angles: Array) -> str:
    return ", ".join(f"{angle:.6g}" for angle in np.degrees(angles))
