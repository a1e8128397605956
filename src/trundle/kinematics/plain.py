"""Kinematics for control loops: floats in, floats out, with the robot's constants written in.

The functions are straight-line programs made of the same maps that numpy reads, with shared sums
computed once, and compiled by Python itself: a call costs little more than its arithmetic.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from trundle import se2
from trundle.errors import TrundleError
from trundle.kinematics.constraints import gains, robot_of, rolling_matrix, side_slip_matrix
from trundle.kinematics.estimate import Estimate
from trundle.kinematics.inverse import InverseSolver
from trundle.kinematics.linear import RANK_TOLERANCE
from trundle.kinematics.maps import estimator
from trundle.kinematics.steering import contact_velocities, couplings, motion_space
from trundle.kinematics.straight import Code, Straight
from trundle.robot import Robot, RollingWheel
from trundle.se2 import Array

_TWIST = ("u", "v", "r")
_POSE = ("x", "y", "psi")
_ROOT = re.compile(r"(\([^()]*\)) \*\* 0\.5")


@dataclass(frozen=True)
class StraightLines:
    """The programs of one robot, without limits or checks: what Python runs and C prints.

    Attributes:
        inverse: (u, v, r) -> n wheel speeds [rad/s], then s steering angles [rad].
        forward: n wheel speeds ``w0 ...``, then s angles ``s0 ...`` -> (u, v, r).
        step: (x, y, psi), k increments of the sensed wheels ``w0 ...`` [rad], then s angles
            ``s0 ...`` -> (x, y, psi), along the exact arc.
    """

    inverse: Straight
    forward: Straight
    step: Straight


@dataclass(frozen=True)
class Plain:
    """The bound functions of one robot, without limits or checks.

    Attributes:
        inverse: ``inverse(u, v, r)`` -> n wheel speeds [rad/s], then s steering angles [rad].
        forward: ``forward(*wheel_speeds, *steering)`` -> (u, v, r), from the driven wheels.
        step: ``step(x, y, psi, *wheel_increments, *steering)`` -> (x, y, psi): the exact odometry
            step from the increments [rad] of the sensed wheels.
    """

    inverse: Callable[..., tuple[float, ...]]
    forward: Callable[..., tuple[float, ...]]
    step: Callable[..., tuple[float, ...]]


def straight_lines(robot: Robot) -> StraightLines:
    """Return the inverse, the forward map and the odometry step of a robot in straight lines.

    Where the wheels do not tell a motion, at some angles or at all, it is taken as zero.

    Raises:
        TrundleError: linked steering allows only a curved family of twists, in which the nearest is
            searched for; or skidding wheels slip in a way that depends on steering angles.

    >>> from trundle import load
    >>> lines = straight_lines(load("differential", radius=0.05, track=0.4))
    >>> lines.forward.results
    ('0.025 * (w0 + w1)', '0.0', '0.125 * (w1 - w0)')
    """
    solver = InverseSolver(robot_of(robot))
    return StraightLines(_inverse(robot, solver), _forward(robot), _step(robot))


def bind(robot: Robot, solver: InverseSolver) -> Plain:
    """Return the bound functions of a robot; what has no straight lines goes through the arrays."""
    try:
        inverse = _inverse(robot, solver).compile()
    except TrundleError:
        inverse = _inverse_of_arrays(solver)
    try:
        return Plain(inverse, _forward(robot).compile(), _step(robot).compile())
    except TrundleError:
        return Plain(inverse, _forward_of_arrays(robot), _step_of_arrays(robot))


def _inverse(robot: Robot, solver: InverseSolver) -> Straight:
    if not robot.steered:
        code = Code()
        rolling = rolling_matrix(robot, robot.driven, np.zeros(0)) @ solver.feasible
        results = code.linear(rolling / gains(robot.driven)[:, None], _TWIST)
        return code.program("inverse", _TWIST, results)
    if any(wheel.steering_group is not None for wheel in robot.steered):
        _check_linked(robot, solver.feasible)
    return _steered_inverse(robot, solver)


def _steered_inverse(robot: Robot, solver: InverseSolver) -> Straight:
    """Return the inverse for wheels that steer: each along its contact velocity.

    Of linked wheels the first is, and the others turn with it.
    """
    code, straight = Code(), np.zeros(len(robot.steered))
    plain = [wheel for wheel in robot.driven if not wheel.steers]
    rows = [
        rolling_matrix(robot, robot.steered, straight),
        side_slip_matrix(robot, robot.steered, straight),
        rolling_matrix(robot, plain, straight) / gains(plain)[:, None],
    ]
    values = code.linear(np.concatenate(rows) @ solver.feasible, _TWIST)
    count = len(robot.steered)
    # Adding 0.0 turns -0.0 into 0.0, so that straight back is +pi and standstill is 0.
    along = [code.name(f"{value} + 0.0") for value in values[:count]]
    across = [code.name(f"{value} + 0.0") for value in values[count : 2 * count]]
    speeds = dict(zip((wheel.name for wheel in plain), values[2 * count :], strict=True))
    leaders, angles = _leaders(robot), list[str]()
    for i, wheel in enumerate(robot.steered):
        a, b, per = along[i], across[i], float(1 / wheel.rows(0.0).gain)
        first, sign = leaders[i]
        if first == i:
            angles.append(code.name(f"atan2({b}, {a})"))
            speeds[wheel.name] = f"{per!r} * hypot({a}, {b})"
            continue
        # A wheel that is turned with another may roll backwards.
        angles.append(f"{sign}{angles[first]}")
        c, s = code.name(f"cos({angles[first]})"), code.name(f"sin({angles[first]})")
        speeds[wheel.name] = f"{per!r} * ({c} * {a} {sign or '+'} {s} * {b})"
    results = [*(speeds[wheel.name] for wheel in robot.driven), *angles]
    return code.program("inverse", _TWIST, results)


def _leaders(robot: Robot) -> list[tuple[int, str]]:
    """Return for each steered wheel the first of its group, and "-" where it turns against that."""
    coupling = couplings(robot)
    group = [int(np.flatnonzero(row)[0]) for row in coupling]
    first = [int(np.flatnonzero(column)[0]) for column in coupling.T]
    return [
        (first[j], "-" if coupling[i, j] * coupling[first[j], j] < 0 else "")
        for i, j in enumerate(group)
    ]


def _check_linked(robot: Robot, feasible: Array) -> None:
    """Refuse linked steering whose angles do not follow from the first wheels of the groups.

    Raises:
        TrundleError: the twists that it allows are curved; or wheels of a group steer unequally, or
            its first wheel may stand still where others move.
    """
    if not motion_space(robot)[1]:
        raise TrundleError(
            f"robot {robot.name!r}: its linked steering allows only a curved family of twists, in "
            "which the nearest to the one asked is searched for: that takes more than a program in "
            "straight lines; wheels that steer alone, or ratios of 1 and -1 with a common line of "
            "centres, have one"
        )
    velocity = contact_velocities(robot, feasible.T)
    for i, (first, _) in enumerate(_leaders(robot)):
        one, other = robot.steered[first], robot.steered[i]
        if abs(one.steering_ratio) != abs(other.steering_ratio):
            raise TrundleError(
                f"robot {robot.name!r}: wheels {one.name!r} and {other.name!r} of one group steer "
                "by different angles: that takes more than a program in straight lines"
            )
        pair = np.concatenate([velocity[:, first], velocity[:, i]], axis=-1)
        ranks = [np.linalg.matrix_rank(part, tol=RANK_TOLERANCE) for part in (pair[:, :2], pair)]
        if ranks[0] < ranks[1]:
            raise TrundleError(
                f"robot {robot.name!r}: wheel {one.name!r} may stand still where {other.name!r} of "
                "its group moves, and does not tell the angle then: that takes more than a program "
                "in straight lines"
            )


def _forward(robot: Robot) -> Straight:
    code, speeds = Code(), _names("w", len(robot.driven))
    angles = _names("s", len(robot.steered))
    return code.program("forward", speeds + angles, twist_lines(code, robot, robot.driven))


def _step(robot: Robot) -> Straight:
    code, turns = Code(), _names("w", len(robot.sensed))
    moved = twist_lines(code, robot, robot.sensed)
    results = step_lines(code, moved)
    return code.program("step", (*_POSE, *turns, *_names("s", len(robot.steered))), results)


def twist_lines(code: Code, robot: Robot, wheels: Sequence[RollingWheel]) -> list[str]:
    """Return expressions for the twist from the speeds ``w0 ...`` at the angles ``s0 ...``."""
    turns, angles = _names("w", len(wheels)), _names("s", len(robot.steered))
    if not robot.steered:
        return code.linear(estimator(robot, wheels, np.zeros(0))[0], turns)
    return Estimate.of(robot, wheels).twist(code, turns, angles)


def step_lines(code: Code, moved: Sequence[str]) -> list[str]:
    """Return expressions for the pose that an increment of the body leads to from (x, y, psi)."""
    code.lines += zip(("dx", "dy", "dpsi"), moved, strict=True)
    # The one motion step, written in place: a call would cost a fifth of the whole.
    *lines, last = _body(se2.step)
    for line in lines:
        name, _, expression = line.partition(" = ")
        code.lines.append((name, _ROOT.sub(r"sqrt\1", expression)))
    return last.removeprefix("return ").split(", ")


def _body(function: Callable[..., object]) -> list[str]:
    """Return the lines of a function whose body is straight-line code."""
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    names = inspect.getclosurevars(function).globals
    text = [line.strip() for line in lines[1:] if line.strip()]
    for name, value in names.items():
        text = [line.replace(name, repr(value)) for line in text]
    return text


def _names(letter: str, count: int) -> tuple[str, ...]:
    return tuple(f"{letter}{i}" for i in range(count))


def _inverse_of_arrays(solver: InverseSolver) -> Callable[..., tuple[float, ...]]:
    def inverse(u: float, v: float, r: float) -> tuple[float, ...]:
        found = solver.solve((u, v, r), limit=False)
        return (*found.wheel_speeds.tolist(), *found.steering.tolist())

    return inverse


def _forward_of_arrays(robot: Robot) -> Callable[..., tuple[float, ...]]:
    n = len(robot.driven)

    def forward(*values: float) -> tuple[float, ...]:
        to_twist, _ = estimator(robot, robot.driven, np.array(values[n:]))
        return tuple((to_twist @ values[:n]).tolist())

    return forward


def _step_of_arrays(robot: Robot) -> Callable[..., tuple[float, ...]]:
    n = len(robot.sensed)

    def step(x: float, y: float, psi: float, *values: float) -> tuple[float, ...]:
        to_increment, _ = estimator(robot, robot.sensed, np.array(values[n:]))
        return se2.step(x, y, psi, *(to_increment @ values[:n]).tolist())

    return step
