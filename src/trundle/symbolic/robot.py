"""A robot in symbols: its rows, the twists that they allow, and W."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from trundle.kinematics import Kinematics, consistent_angles
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.symbolic.inputs import Inputs
from trundle.symbolic.quantities import Namer, Quantity
from trundle.symbolic.spaces import independent, null_space, numbers
from trundle.symbolic.tidy import tidy_matrix
from trundle.symbolic.twists import twists_of
from trundle.symbolic.wheels import SymbolicWheel, symbolic_wheels

_SEED = 1996  # any fixed seed: a generic position is found the same way at every call
_FAR = 0.3  # share by which sizes are moved to see what holds for this robot's only


@dataclass(frozen=True, eq=False)
class SymbolicRobot:
    """The rows of a robot in symbols, and what follows from them.

    ``W = K (A K)^+ R``, with K the driven part of N; all in the body frame, for twists (u, v, r).

    Attributes:
        robot: the robot, with its numbers.
        wheels: the wheels that push or hold, numbered as in the formulas.
        inputs: the steering inputs.
        quantities: each symbol with its number.
        general: whether the formulas hold for all sizes; else ranks drop at this robot's sizes,
            and the formulas hold where they do.
        A: (n, 3) rolling rows of the driven wheels.
        R: (n, n) diagonal of signed rim speeds for one rad/s.
        C: (m, 3) side-slip rows of all wheels, in their order.
        held: (h, 3) rows that hold: independent side-slip rows, and those of skidding wheels.
        held_by: the number of the wheel of each such row, 0 for one of skidding wheels.
        N: (3, 3 - h) twists that the held rows allow.
        undriven: (3, j) those among them that no driven wheel pushes.
        K: (3, k) those that the driven wheels push.
        AK: (n, k) what each driven wheel tells of each of these.
        W: (3, n) wheel configuration matrix.
    """

    robot: Robot
    wheels: tuple[SymbolicWheel, ...]
    inputs: Inputs
    quantities: tuple[Quantity, ...]
    general: bool
    A: Any
    R: Any
    C: Any
    held: Any
    held_by: tuple[int, ...]
    N: Any
    undriven: Any
    K: Any
    AK: Any
    W: Any

    @property
    def driven(self) -> tuple[SymbolicWheel, ...]:
        """The driven wheels, in the order of the columns of W."""
        return tuple(each for each in self.wheels if each.wheel.driven)

    def values(self, steering: Sequence[float] | Array | None = None) -> dict[Any, float]:
        """Return the number of each symbol, at steering angles (s,) [rad] or at their example.

        >>> import trundle
        >>> made = symbolic_robot(trundle.load("tricycle"))
        >>> {str(symbol): value for symbol, value in made.values([0.5]).items()}
        {'a': 0.1, 'l': 0.8, 'd': 0.25, 'beta': 0.5}
        """
        given = example_angles(self.robot) if steering is None else steering
        return _values(self.quantities, self.inputs, given, self.robot)


def symbolic_robot(robot: Robot) -> SymbolicRobot:
    """Return a robot in symbols, read from the same rows that numpy reads.

    Where steered wheels are more than needed, the first independent side-slip rows are held, and
    the formulas hold for angles that share a centre with these.

    Source: Campion, Bastin and d'Andrea-Novel, IEEE Transactions on Robotics and Automation
    12(1), 1996, for the constraints; the lectures for W.

    >>> import trundle
    >>> symbolic_robot(trundle.load("differential")).W
    Matrix([
    [     a/2,     a/2],
    [       0,       0],
    [-a/(2*d), a/(2*d)]])
    """
    made = _read(robot, Namer())
    if made.general:
        return made
    equal = _read(robot, Namer(shared=True))
    return equal if equal.general else made


def straight_angles(robot: Robot) -> Array:
    """Return steering angles (s,) that share a centre, nearest to zero; zeros where none do."""
    found = consistent_angles(robot)
    return np.zeros(len(robot.steered)) if found is None else found


def example_angles(robot: Robot) -> Array:
    """Return steering angles (s,) [rad] of a gentle left turn, as far as the robot can make it.

    >>> import trundle
    >>> example_angles(trundle.load("tricycle", wheelbase=1.0)).round(6).tolist()
    [0.244979]
    """
    return _angles_of(robot, (1.0, 0.2, 0.25 / robot.reach))


def generic_angles(robot: Robot) -> Array:
    """Return steering angles (s,) of a turn about a point of no special place."""
    u, v, r = np.random.default_rng(_SEED).normal(size=3).tolist()
    return _angles_of(robot, (u, v, r / robot.reach))


def _angles_of(robot: Robot, twist: tuple[float, float, float]) -> Array:
    answer = Kinematics(robot).inverse(twist, limit=False)
    moves = np.abs(answer.twist).max() > 0
    return answer.steering if moves else straight_angles(robot)


def _values(
    quantities: Sequence[Quantity], inputs: Inputs, steering: Sequence[float] | Array, robot: Robot
) -> dict[Any, float]:
    sizes = {each.symbol: each.value for each in quantities}
    return sizes | inputs.values(steering, robot)


def _read(robot: Robot, namer: Namer) -> SymbolicRobot:
    wheels, inputs = symbolic_wheels(robot, namer)
    quantities = namer.in_order()
    generic = _values(quantities, inputs, generic_angles(robot), robot)
    straight = _values(quantities, inputs, straight_angles(robot), robot)
    driven = [each.rows() for each in wheels if each.wheel.driven]
    A = _stack([rows.rolling for rows in driven])
    R = sympy.ImmutableMatrix(sympy.diag(*(rows.gain for rows in driven)))
    held, held_by = _held(wheels, A, generic, straight)
    found = twists_of(held, A, R, generic)
    slips = [rows.side_slip for rows in (each.rows() for each in wheels)]
    return SymbolicRobot(
        robot=robot,
        wheels=wheels,
        inputs=inputs,
        quantities=quantities,
        general=_general(wheels, sympy.Matrix.vstack(held, A), generic, inputs),
        A=A,
        R=R,
        C=_stack([row for row in slips if row is not None]),
        held=held,
        held_by=held_by,
        **found._asdict(),
    )


def _stack(rows: Sequence[Any]) -> Any:
    return sympy.ImmutableMatrix(len(rows), 3, [entry for row in rows for entry in row])


def _held(
    wheels: Sequence[SymbolicWheel],
    A: Any,
    generic: Mapping[Any, float],
    straight: Mapping[Any, float],
) -> tuple[Any, tuple[int, ...]]:
    """Return the independent rows that hold, fixed wheels' first, and whose they are."""
    by_angle = sorted(wheels, key=lambda each: each.wheel.steers)
    slips = [(each.number, each.rows().side_slip) for each in by_angle]
    numbered = [(number, row) for number, row in slips if row is not None]
    rows = _stack([row for _, row in numbered])
    chosen = _well_placed(rows, generic, straight)
    held, held_by = rows.extract(chosen, [0, 1, 2]), [numbered[i][0] for i in chosen]
    extra = _skid_rows(wheels, sympy.Matrix.vstack(held, A), generic)
    both = sympy.Matrix.vstack(held, extra)
    kept = independent(numbers(both, generic))
    held_by += [0] * extra.rows
    return (
        sympy.ImmutableMatrix(both.extract(kept, [0, 1, 2])),
        tuple(held_by[i] for i in kept),
    )


def _well_placed(
    rows: Any, generic: Mapping[Any, float], straight: Mapping[Any, float]
) -> list[int]:
    """Return independent rows, if possible such as are so straight ahead too."""
    turned = numbers(rows, generic)
    first = independent(turned)
    ahead = independent(numbers(rows, straight))
    return ahead if len(ahead) == len(first) == len(independent(turned[ahead])) else first


def _skid_rows(wheels: Sequence[SymbolicWheel], told: Any, values: Mapping[Any, float]) -> Any:
    """Return the conditions that leave skidding wheels the least side slip.

    For each motion e that nothing else tells, ``e^T S^T S`` with S the wheels' side-slip rows.
    """
    skids = [rows for rows in (each.rows() for each in wheels) if rows.skid is not None]
    if not skids:
        return sympy.zeros(0, 3)
    together = sympy.Matrix.vstack(told, _stack([rows.rolling for rows in skids]))
    kept = independent(numbers(together, values))
    free = null_space(together.extract(kept, [0, 1, 2]), values)
    S = _stack([rows.skid for rows in skids])
    rows = tidy_matrix(free.T * S.T * S)
    return rows.extract([i for i in range(rows.rows) if any(rows.row(i))], [0, 1, 2])


def _general(
    wheels: Sequence[SymbolicWheel], told: Any, here: Mapping[Any, float], inputs: Inputs
) -> bool:
    """Return whether ranks are the same for robots of other sizes with the same symbols."""
    random = np.random.default_rng(_SEED)
    there = {
        symbol: value if symbol in inputs.symbols else value * (1 + _FAR * random.random())
        for symbol, value in here.items()
    }
    fixed = [each.rows().side_slip for each in wheels if not each.wheel.steers]
    rigid = _stack([row for row in fixed if row is not None])
    return all(
        len(independent(numbers(rows, here))) == len(independent(numbers(rows, there)))
        for rows in (rigid, told)
    )
