"""What the writers of sections share: the robot, its symbols, and their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy

from trundle.errors import RobotError
from trundle.kinematics import Kinematics
from trundle.robot import Robot, total_mass
from trundle.se2 import Array
from trundle.symbolic import base
from trundle.symbolic.document.figures import shown
from trundle.symbolic.document.parts import Value
from trundle.symbolic.factor import common_factor
from trundle.symbolic.robot import SymbolicRobot, example_angles, symbolic_robot

# Expressions with more operations than this are told in factors, not written out.
LONG = 150

u, v, r = sympy.symbols("u v r", real=True)
TWIST = (u, v, r)


@dataclass(frozen=True, eq=False)
class Case:
    """A robot in symbols, with the numbers that the document shows.

    Attributes:
        made: the robot in symbols.
        steering: (s,) the angles of the numbers [rad].
        values: the number of each symbol of the kinematics.
        masses: the number of each symbol of the dynamics; empty where a value is missing.
        missing: what is missing for them, in a sentence; empty where nothing is.
    """

    made: SymbolicRobot
    steering: Array
    values: dict[Any, float]
    masses: dict[Any, float]
    missing: str

    @property
    def robot(self) -> Robot:
        """The robot with its numbers."""
        return self.made.robot

    def shown(self, left: Any, right: Any) -> Value:
        """Return ``left = right`` with this robot's numbers."""
        return shown(left, right, self.values | self.masses)

    @staticmethod
    def plain(left: Any, right: Any) -> Value:
        """Return ``left = right`` where the right side is numbers already."""
        return Value(left, right)

    def factored(self, left: Any, matrix: Any) -> Value:
        """Return ``left = matrix`` with a factor that its entries share in front."""
        factor, rest = common_factor(matrix)
        right = matrix if factor == 1 else sympy.MatMul(factor, rest, evaluate=False)
        return Value(left, right, self.shown(left, matrix).numbers)

    @property
    def k_name(self) -> str:
        """N where the wheels drive all that is allowed, K where they drive part of it."""
        return "K" if self.made.undriven.cols else "N"


def case_of(robot: Robot, steering: npt.ArrayLike | None = None) -> Case:
    """Return what the writers need to know of a robot.

    Raises:
        OffCentreError: the steering angles that were given share no centre.

    >>> import trundle
    >>> sorted(map(str, case_of(trundle.load("omni3")).values))
    ['a', 'l']
    """
    if steering is not None:
        Kinematics(robot).wheel_matrix(steering)
    made = symbolic_robot(robot)
    angles = example_angles(robot) if steering is None else _array(steering)
    masses, missing = _masses(robot)
    return Case(made, angles, made.values(angles), masses, missing)


def _array(values: npt.ArrayLike) -> Array:

    return np.asarray(values, dtype=np.float64)


def _masses(robot: Robot) -> tuple[dict[Any, float], str]:
    try:
        total = total_mass(robot)
    except RobotError as error:
        return {}, error.faults[0]
    x, y = total.com.tolist()
    return {base.m: total.mass, base.I_cz: total.inertia, base.x_bc: x, base.y_bc: y}, ""


def wheel_speeds(made: SymbolicRobot) -> Any:
    """Return the symbols of the driven wheels' speeds (n, 1), numbered as the wheels."""
    return sympy.Matrix(
        [sympy.Symbol(f"omega_{each.number}", real=True) for each in made.driven]
    ).reshape(len(made.driven), 1)


def listed(items: Sequence[str]) -> str:
    """Return items as a list in a sentence.

    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def many(count: int, word: str) -> str:
    """Return a count and its word.

    >>> many(1, "row"), many(2, "row")
    ('1 row', '2 rows')
    """
    return f"{count} {word}{'s' * (count != 1)}"
