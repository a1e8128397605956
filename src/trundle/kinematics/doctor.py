"""The geometry doctor: what is wrong, or looks wrong, with a robot, and the remedy."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from trundle.kinematics.centre import nearest_angles, off_centre_words, share_centre
from trundle.kinematics.constraints import (
    frame,
    one_steering,
    robot_of,
    rolling_matrix,
    side_slip_matrix,
    steering_array,
)
from trundle.kinematics.finding import Finding
from trundle.kinematics.linear import RANK_TOLERANCE, basis
from trundle.kinematics.maps import estimator, motion_projector, wheel_matrix
from trundle.kinematics.mobility import mobility, without_skid
from trundle.kinematics.mounting import (
    cannot_push,
    mass_outside,
    outside_body,
    reversed_suspect,
    yaw_arm_cancels,
)
from trundle.kinematics.steering import generic_pairs
from trundle.kinematics.words import join, motion_in_words, motions_in_words
from trundle.robot import Robot, Wheel
from trundle.se2 import Array

# Beyond this, an error of 1 % in one wheel's speed is an error of a third in some motion.
_ILL_CONDITIONED = 30.0


def diagnose(robot: Robot, steering: npt.ArrayLike | None = None) -> tuple[Finding, ...]:
    """Return the warnings about a robot's geometry.

    Args:
        robot: the robot.
        steering: (s,) steering angles [rad] to look at; without them, angles in general position
            that share a centre.

    Returns:
        The findings, each with a code, an explanation and a remedy.

    >>> from trundle import load
    >>> [finding.code for finding in diagnose(load("mecanum_lecture"))]
    ['yaw_arm_cancels']
    """
    robot_of(robot)
    if steering is not None:
        steering = one_steering(robot, steering)
    found = [
        *yaw_arm_cancels(robot),
        *cannot_push(robot),
        *reversed_suspect(robot),
        *outside_body(robot),
        *mass_outside(robot),
        *side_slip_blocks(robot),
        *off_centre_angles(robot, steering),
    ]
    if any(each.code == "off_centre_angles" for each in found):
        return tuple(found)
    angles = _angles(robot, steering)
    return (
        *found,
        *one_motion_left(robot),
        *wheels_conflict(robot, angles),
        *no_push(robot, angles),
        *ill_conditioned(robot, angles),
        *unobserved_motion(robot, angles),
    )


def _angles(robot: Robot, steering: npt.ArrayLike | None) -> Array:
    if steering is not None:
        return steering_array(robot, steering)
    pairs = generic_pairs(robot)
    return pairs[0].steering if pairs else np.zeros(len(robot.steered))


def off_centre_angles(robot: Robot, steering: npt.ArrayLike | None) -> Iterator[Finding]:
    """Steering angles that share no centre; steering that cannot be moved without losing it."""
    if not robot.steered:
        return
    names = tuple(wheel.name for wheel in robot.steered)
    if steering is not None:
        angles = steering_array(robot, steering)
        if not share_centre(robot, angles):
            near = nearest_angles(robot, angles)
            yield Finding(
                "off_centre_angles",
                off_centre_words(robot, angles),
                "compute the angles from the twist with the inverse kinematics"
                if near is not None
                else "look at how the wheels are placed and linked",
                names,
            )
    elif mobility(robot).steerability == 0:
        yield Finding(
            "off_centre_angles",
            f"the steering of {join(names)} cannot be moved: at almost all angles that it can "
            "take the wheels share no instantaneous centre",
            "steer the wheels alone, or link them so that they keep a common centre "
            "(steering_group, steering_ratio); left and right wheels of a car need different "
            "angles",
            names,
        )


def one_motion_left(robot: Robot) -> Iterator[Finding]:
    """Fixed wheels whose axles do not fall together, so that one motion is all that is left."""
    if robot.steered:
        return
    allowed, _ = motion_projector(robot, np.zeros(0))
    if round(float(np.trace(allowed))) == 1:
        names = tuple(wheel.name for axle in _axles(robot) for wheel in axle)
        yield Finding(
            "wheels_conflict",
            f"{join(names)} can roll together in one motion only: "
            f"{join(motions_in_words(basis(allowed)))}",
            "put the fixed wheels on one axle with one heading, steer a wheel, use omni wheels, "
            "or set skid = true if they may slip sideways",
            names,
        )


def wheels_conflict(robot: Robot, angles: Array) -> Iterator[Finding]:
    """Wheels that cannot roll together: nothing moves, or a motor that cannot turn."""
    allowed, _ = motion_projector(robot, angles)
    slipping = tuple(w.name for w in robot.wheels if w.rows(0.0).side_slip is not None)
    if np.trace(allowed) < 0.5:
        yield Finding(
            "wheels_conflict",
            f"{join(slipping)} cannot roll together: without slipping the robot cannot move",
            "wheels roll together when their axles' lines meet in one point or are parallel; "
            "change a heading or a position, use omni wheels, or set skid = true",
            slipping,
        )
        return
    rolling = rolling_matrix(robot, robot.driven, angles) @ allowed
    for wheel, row in zip(robot.driven, rolling, strict=True):
        if np.linalg.norm(row) < RANK_TOLERANCE:
            yield Finding(
                "wheels_conflict",
                f"wheel {wheel.name!r} cannot turn: no motion that the side slip of "
                f"{join(slipping)} allows runs along its drive direction",
                "change its heading or position, or use an omni wheel",
                (wheel.name,),
            )


def no_push(robot: Robot, angles: Array) -> Iterator[Finding]:
    """Motions that the constraints allow and no driven wheel pushes."""
    allowed, _ = motion_projector(robot, angles)
    _, can_give = wheel_matrix(robot, angles)
    open_motions = motions_in_words(basis(allowed - can_give))
    if open_motions:
        yield Finding(
            "cannot_push",
            f"the driven wheels cannot push {_motion(open_motions)}: nothing drives it and nothing "
            "holds it",
            "drive another wheel, or turn one so that it pushes that way",
        )


def unobserved_motion(robot: Robot, angles: Array) -> Iterator[Finding]:
    """Motions that the sensed wheels do not observe."""
    _, unobserved = estimator(robot, robot.sensed, angles)
    motions = motions_in_words(basis(unobserved))
    if motions:
        yield Finding(
            "unobserved_motion",
            f"the sensed wheels do not observe {_motion(motions)}: odometry cannot know it",
            "give an encoder to a wheel that turns with that motion",
        )


def _motion(motions: tuple[str, ...]) -> str:
    return "any motion" if len(motions) == 3 else f"the motion {join(motions)}"


def ill_conditioned(robot: Robot, angles: Array) -> Iterator[Finding]:
    """Wheel speeds whose small errors become large errors of a motion."""
    allowed, _ = motion_projector(robot, angles)
    # Yaw as the speed of the outermost wheel, so that all motions are in m/s.
    here = frame(robot)
    free, _ = np.linalg.qr(np.linalg.solve(here, basis(allowed)))
    rolling = rolling_matrix(robot, robot.driven, angles) @ here @ free
    if rolling.size == 0:
        return
    _, size, motions = np.linalg.svd(rolling)
    size = size[size > RANK_TOLERANCE]
    if len(size) and size[0] > _ILL_CONDITIONED * size[-1]:
        weak = here @ free @ motions[len(size) - 1]
        yield Finding(
            "ill_conditioned",
            f"the condition number is {size[0] / size[-1]:.3g}: errors of the wheel speeds are "
            f"magnified that much in the motion {motion_in_words(weak)}",
            "place the wheels so that this motion has a longer lever arm",
        )


def side_slip_blocks(robot: Robot) -> Iterator[Finding]:
    """Fixed wheels on one line that forbid a motion which the other wheels allow and drive."""
    strict = without_skid(robot) if not any(w.rows().skid for w in robot.wheels) else robot
    degree = _degree(strict)
    for axle in _axles(robot):
        names = {wheel.name for wheel in axle}
        others = tuple(wheel for wheel in robot.wheels if wheel.name not in names)
        if not others:
            continue
        rest = dataclasses.replace(robot, wheels=others)
        pairs = generic_pairs(rest)
        if not pairs or pairs[0].degree <= degree:
            continue
        allowed, _ = motion_projector(rest, pairs[0].steering)
        _, can_give = wheel_matrix(rest, pairs[0].steering)
        if np.trace(allowed - can_give) < 0.5:
            told = tuple(wheel.name for wheel in axle)
            yield Finding(
                "side_slip_blocks",
                f"the side slip of {join(told)} forbids what the other wheels allow and drive: "
                f"the robot is left with {degree} of {pairs[0].degree} motions",
                "use omni wheels there, put the wheels on the axle of the others, or set "
                "skid = true if they may slip sideways",
                told,
            )


def _degree(robot: Robot) -> int:
    pairs = generic_pairs(robot)
    return pairs[0].degree if pairs else 0


def _axles(robot: Robot) -> list[list[Wheel]]:
    """Return the fixed wheels whose side-slip rows are one, up to sign."""
    axles: list[tuple[Array, list[Wheel]]] = []
    for wheel in robot.wheels:
        if wheel.steers or wheel.rows().side_slip is None:
            continue
        row = side_slip_matrix(robot, [wheel], np.zeros(len(robot.steered)))[0]
        for known, members in axles:
            if min(np.abs(row - known).max(), np.abs(row + known).max()) < RANK_TOLERANCE:
                members.append(wheel)
                break
        else:
            axles.append((row, [wheel]))
    return [members for _, members in axles]
