"""The straight-line programs that firmware needs beside the kinematics."""

from __future__ import annotations

import numpy as np

from trundle.errors import TrundleError, UnobservedMotionError
from trundle.kinematics import (
    Code,
    Kinematics,
    Straight,
    gains,
    motion_space,
    rolling_matrix,
    side_slip_matrix,
)
from trundle.robot import Robot
from trundle.se2 import Array

_TWIST = ("u", "v", "r")
_POSE = ("x", "y", "psi")
_INCREMENT = ("dx", "dy", "dpsi")
# Digits of a projection, whose entries are at most 1, before rounding.
_DIGITS = 14
# Steering positions tried for one in which all motion is observed; any fixed seed.
_POSITIONS, _SEED = 8, 1996


def parts_of_step(step: Straight) -> tuple[Straight, Straight]:
    """Return the two parts of an odometry step: to the body's increment, and along it.

    The increment is what the measured twist follows from; it has the names dx, dy, dpsi.

    >>> import trundle
    >>> from trundle.kinematics import straight_lines
    >>> step = straight_lines(trundle.load("differential")).step
    >>> increment, advance = parts_of_step(step)
    >>> increment.arguments, advance.arguments
    (('w0', 'w1'), ('x', 'y', 'psi', 'dx', 'dy', 'dpsi'))
    >>> moved = increment.compile()(0.2, 0.3)
    >>> advance.compile()(1.0, 2.0, 0.5, *moved) == step.compile()(1.0, 2.0, 0.5, 0.2, 0.3)
    True
    """
    names = [name for name, _ in step.lines]
    last = max(names.index(name) for name in _INCREMENT) + 1
    return (
        Straight("increment", step.arguments[len(_POSE) :], step.lines[:last], _INCREMENT),
        Straight("advance", (*_POSE, *_INCREMENT), step.lines[last:], step.results),
    )


def wheel_programs(robot: Robot) -> dict[str, Straight]:
    """Return the programs from a twist to what limits it.

    ``project``: the nearest twist that the wheels allow, where they do not allow all.
    ``fixed_speeds``: speeds of the driven wheels that do not steer [rad/s].
    ``contacts``: velocities of the steered wheels' contacts [m/s], all along the zeros of their
    angles, then all a quarter turn further.

    Raises:
        TrundleError: linked steering allows a curved set of twists only.
    """
    if robot.steered and not motion_space(robot)[1]:
        raise TrundleError(
            f"robot {robot.name!r}: its linked steering allows only a curved set of twists, for "
            "which there are no closed formulas to print; link wheels with steering_ratio 1 or -1 "
            "so that they share a centre at every angle, or steer them alone"
        )
    straight = np.zeros(len(robot.steered))
    fixed = [wheel for wheel in robot.driven if not wheel.steers]
    matrices: dict[str, Array] = {}
    feasible = Kinematics(robot).feasible.round(_DIGITS)
    if (feasible != np.eye(3)).any():
        matrices["project"] = feasible
    if fixed:
        rows = rolling_matrix(robot, fixed, straight)
        matrices["fixed_speeds"] = rows / gains(fixed)[:, None]
    if robot.steered:
        along = rolling_matrix(robot, robot.steered, straight)
        across = side_slip_matrix(robot, robot.steered, straight)
        matrices["contacts"] = np.concatenate([along, across])
    return {name: _linear(name, matrix) for name, matrix in matrices.items()}


def _linear(name: str, matrix: Array) -> Straight:
    code = Code()
    return code.program(name, _TWIST, code.linear(matrix, _TWIST))


def check_observed(robot: Robot) -> None:
    """Raise where the counters do not tell every motion, at whatever steering angles.

    Raises:
        UnobservedMotionError: the unobserved motion.
    """
    kinematics, random = Kinematics(robot), np.random.default_rng(_SEED)
    for tried in range(_POSITIONS if robot.steered else 1, 0, -1):
        angles = None
        if robot.steered:
            angles = kinematics.inverse(random.normal(size=3), limit=False).steering
        try:
            kinematics.odometry_matrix(angles)
        except UnobservedMotionError:
            if tried == 1:
                raise
        else:
            return
