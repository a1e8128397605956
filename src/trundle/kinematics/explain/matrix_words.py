"""The rows of W in words: each component of the twist from the wheels' speeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.kinematics.constraints import gains, rolling_matrix, side_slip_matrix
from trundle.kinematics.explain.numbers import TWIST, ZERO, factored, number
from trundle.kinematics.linear import ANGLE_TOLERANCE, null_projector
from trundle.kinematics.maps import motion_projector, wheel_matrix
from trundle.kinematics.words import join, motion_in_words
from trundle.robot import Robot, Wheel
from trundle.se2 import Array

_SPEED = {"u": "forward speed", "v": "sideways speed"}


def matrix_words(robot: Robot, steering: Array) -> tuple[str, ...]:
    """Return one text for each of the three rows of W at steering angles (s,) [rad]."""
    wheels = robot.driven
    if not wheels:
        return tuple(f"{name} = 0: no wheel is driven." for name in TWIST)
    W, feasible = wheel_matrix(robot, steering)
    names = [wheel.name for wheel in wheels]
    radii = np.array([wheel.radius for wheel in wheels])
    told = []
    for name, row, unit in zip(TWIST, W, np.eye(3), strict=True):
        if np.abs(row).max() <= ZERO * np.abs(W).max():
            told.append(f"{name} = 0: {_why_zero(robot, steering, name, unit)}.")
            continue
        if name == "r":
            turn = feasible @ unit / (unit @ feasible @ unit)
            inverse = rolling_matrix(robot, wheels, steering) / gains(wheels)[:, None]
            why = _why_turn(row / radii, names, radii * (inverse @ turn), turn)
        else:
            why = _why_line(_SPEED[name], row / radii, names)
        told.append(f"{name} = {factored(row, names)}: {why}.")
    return tuple(told)


def _why_line(speed: str, weights: Array, names: list[str]) -> str:
    """Return what forward or sideways speed is in rim speeds, for weights (n,) of them."""
    if mean := _mean(weights, names):
        return f"{speed} is {mean}"
    return f"in rim speeds [m/s], {speed} is {factored(weights, names)}"


def _why_turn(weights: Array, names: list[str], rims: Array, turn: Array) -> str:
    """Return why arms divide in the yaw row.

    Args:
        weights: (n,) the row's coefficients on the rim speeds.
        names: of the wheels.
        rims: (n,) rim speeds [m/s] while the robot turns at 1 rad/s.
        turn: (3,) the twist with r = 1 that is meant.
    """
    motion = motion_in_words(turn)
    arms = np.abs(rims)
    arm = float(arms.max())
    if np.ptp(arms) <= ZERO * arm and (mean := _mean(weights, names, 1 / arm)):
        comma = "," if "," in mean else ""
        rim = "the rim runs" if len(names) == 1 else "each rim runs"
        return (
            f"yaw rate is {mean}{comma} over the arm of {number(arm)} m. In one radian of "
            f"{motion} {rim} {number(arm)} m, so the arm divides"
        )
    runs = [f"{number(rim)} m at {name}" for rim, name in zip(rims, names, strict=True)]
    return (
        f"one radian of {motion} runs the rims by {join(runs)}; the row turns these back "
        "into one radian, so the arms divide"
    )


def _mean(weights: Array, names: list[str], total: float = 1.0) -> str:
    """Return the mean of rim speeds in words where the weights (n,) are one, else "".

    Args:
        weights: (n,) of the rim speeds.
        names: of the wheels.
        total: the sum of the weights' sizes that makes a mean.
    """
    rounding = ZERO * np.abs(weights).max()
    sizes = np.abs(weights[np.abs(weights) > rounding])
    if np.ptp(sizes) > rounding:
        return ""
    which = [name for name, size in zip(names, np.abs(weights), strict=True) if size > rounding]
    backwards = [name for name, weight in zip(names, weights, strict=True) if weight < -rounding]
    if len(which) == 1:
        told, counted = f"the rim speed of {which[0]}", ", counted backwards"
    else:
        of = "" if len(which) == len(names) else f" of {join(which)}"
        those = "all" if len(backwards) == len(which) else f"those of {join(backwards)}"
        told, counted = f"the mean of the rim speeds{of}", f", {those} counted backwards"
    share = float(sizes.sum()) / total
    times = f"{number(share)} times " if abs(share - 1) > ZERO else ""
    return f"{times}{told}{counted if backwards else ''}"


def _why_zero(robot: Robot, steering: Array, name: str, unit: Array) -> str:
    """Return why no wheel speed gives a component of the twist.

    Args:
        robot: the robot.
        steering: (s,) steering angles [rad].
        name: of the component.
        unit: (3,) the twist with this component alone.
    """
    holding = [w for w in robot.wheels if side_slip_matrix(robot, [w], steering).size]
    sets = [
        [w for w in holding if _forbid([w], robot, steering, unit)],
        [w for w in holding if not w.steers],
        holding,
    ]
    for wheels in sets:
        if wheels and _forbid(wheels, robot, steering, unit):
            at = " at these angles" if any(wheel.steers for wheel in wheels) else ""
            names = join([wheel.name for wheel in wheels])
            return f"no driven wheel gives {name}: the side slip of {names} forbids it{at}"
    allowed, _ = motion_projector(robot, steering)
    if unit @ allowed @ unit <= ZERO:
        return f"the wheels that may skid move so that they slip least, and that leaves no {name}"
    return f"no row forbids {name}, but no driven wheel gives it either"


def _forbid(wheels: Sequence[Wheel], robot: Robot, steering: Array, unit: Array) -> bool:
    rows = side_slip_matrix(robot, wheels, steering)
    projector, _ = null_projector(rows, ANGLE_TOLERANCE)
    return bool(unit @ projector @ unit <= ZERO)
