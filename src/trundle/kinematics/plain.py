"""Kinematics for control loops: floats in, floats out, with the robot's constants written in.

The functions are written as Python source from the same maps that numpy reads, with shared sums
computed once, and compiled by Python itself: a call costs little more than its arithmetic.
"""

from __future__ import annotations

import inspect
import itertools
import math
import textwrap
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trundle import se2
from trundle.kinematics.constraints import gains, rolling_matrix, side_slip_matrix
from trundle.kinematics.inverse import InverseSolver
from trundle.kinematics.maps import estimator
from trundle.robot import Robot
from trundle.se2 import Array

_TWIST = ("u", "v", "r")
# Coefficients that differ by this much of their size are one number, and one this small beside its
# row is zero: the maps come from pseudo-inverses, whose last digits are rounding.
_ROUNDING = 1e-14
# A size this near to a short decimal is that decimal: a few units in the last place.
_LAST_DIGIT = 1e-15


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


def bind(robot: Robot, solver: InverseSolver) -> Plain:
    """Return the bound functions of a robot.

    Linked steering and the estimates of robots that steer go through the array functions.
    """
    if robot.steered:
        linked = any(wheel.steering_group is not None for wheel in robot.steered)
        return Plain(
            inverse=_from_arrays(solver) if linked else _steered_inverse(robot, solver),
            forward=_steered_forward(robot),
            step=_steered_step(robot),
        )
    return Plain(_inverse(robot, solver), _forward(robot), _step(robot))


def _inverse(robot: Robot, solver: InverseSolver) -> Callable[..., tuple[float, ...]]:
    rolling = rolling_matrix(robot, robot.driven, np.zeros(0)) @ solver.feasible
    code = _Code()
    code.results = code.linear(rolling / gains(robot.driven)[:, None], _TWIST)
    return code.compile("inverse", _TWIST)


def _forward(robot: Robot) -> Callable[..., tuple[float, ...]]:
    code, speeds = _Code(), _names("w", len(robot.driven))
    code.results = code.linear(estimator(robot, robot.driven, np.zeros(0))[0], speeds)
    return code.compile("forward", speeds)


def _step(robot: Robot) -> Callable[..., tuple[float, ...]]:
    code, turns = _Code(), _names("w", len(robot.sensed))
    moved = code.linear(estimator(robot, robot.sensed, np.zeros(0))[0], turns)
    code.lines += [f"{n} = {m}" for n, m in zip(("dx", "dy", "dpsi"), moved, strict=True)]
    # The one motion step, written in place: a call would cost a fifth of the whole.
    *lines, last = _body(se2.step)
    code.lines += lines
    code.results = [last.removeprefix("return ")]
    return code.compile("step", ("x", "y", "psi", *turns))


def _steered_inverse(robot: Robot, solver: InverseSolver) -> Callable[..., tuple[float, ...]]:
    """Return the inverse for wheels that steer alone: each along its contact velocity."""
    code, straight = _Code(), np.zeros(len(robot.steered))
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
    for wheel, a, b in zip(robot.steered, along, across, strict=True):
        speeds[wheel.name] = f"{float(1 / wheel.rows(0.0).gain)!r} * hypot({a}, {b})"
    angles = [f"atan2({b}, {a})" for a, b in zip(along, across, strict=True)]
    code.results = [*(speeds[wheel.name] for wheel in robot.driven), *angles]
    return code.compile("inverse", _TWIST)


def _from_arrays(solver: InverseSolver) -> Callable[..., tuple[float, ...]]:
    def inverse(u: float, v: float, r: float) -> tuple[float, ...]:
        found = solver.solve((u, v, r), limit=False)
        return (*found.wheel_speeds.tolist(), *found.steering.tolist())

    return inverse


def _steered_forward(robot: Robot) -> Callable[..., tuple[float, ...]]:
    n = len(robot.driven)

    def forward(*values: float) -> tuple[float, ...]:
        to_twist, _ = estimator(robot, robot.driven, np.array(values[n:]))
        return tuple((to_twist @ values[:n]).tolist())

    return forward


def _steered_step(robot: Robot) -> Callable[..., tuple[float, ...]]:
    n = len(robot.sensed)

    def step(x: float, y: float, psi: float, *values: float) -> tuple[float, ...]:
        to_increment, _ = estimator(robot, robot.sensed, np.array(values[n:]))
        return se2.step(x, y, psi, *(to_increment @ values[:n]).tolist())

    return step


def _names(letter: str, count: int) -> tuple[str, ...]:
    return tuple(f"{letter}{i}" for i in range(count))


def _without_rounding(matrix: Array) -> Array:
    """Return a matrix in which sizes that differ by rounding are equal: 1.0, not 1 - 2e-16."""
    largest = np.abs(matrix).max(axis=-1, keepdims=True, initial=0.0)
    kept = np.where(np.abs(matrix) > _ROUNDING * largest, np.abs(matrix), 0.0)
    sizes, at = np.unique(kept, return_inverse=True)
    first = np.flatnonzero(np.diff(sizes, prepend=0.0) > _ROUNDING * sizes)
    for group in np.split(sizes, first)[1:]:
        middle = float(np.median(group))
        decimal = float(f"{middle:.14g}")
        group[:] = decimal if math.isclose(decimal, middle, rel_tol=_LAST_DIGIT) else middle
    return np.asarray(np.copysign(sizes[at.reshape(matrix.shape)], matrix))


def _body(function: Callable[..., Any]) -> list[str]:
    """Return the lines of a function whose body is straight-line code."""
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    names = inspect.getclosurevars(function).globals
    text = [line.strip() for line in lines[1:] if line.strip()]
    for name, value in names.items():
        text = [line.replace(name, repr(value)) for line in text]
    return text


@dataclass
class _Code:
    """Lines of straight-line Python, in which products and sums that recur are named once."""

    lines: list[str] = field(default_factory=list)
    results: list[str] = field(default_factory=list)
    _named: dict[str, str] = field(default_factory=dict)

    def name(self, expression: str) -> str:
        """Return the name of an expression's value, computing it at most once."""
        if expression.isidentifier():
            return expression
        if expression not in self._named:
            self._named[expression] = f"t{len(self._named)}"
            self.lines.append(f"{self._named[expression]} = {expression}")
        return self._named[expression]

    def linear(self, matrix: Array, inputs: Sequence[str]) -> list[str]:
        """Return expressions for ``matrix @ inputs``.

        A factor that a whole row shares is taken out of it; other products are named, since
        another row often needs them with the same or the other sign.
        """
        rows, factors = [], []
        for row in _without_rounding(matrix).tolist():
            sizes = {abs(coefficient) for coefficient in row if coefficient}
            shared = sizes.pop() if len(sizes) == 1 else 1.0
            factors.append(shared)
            rows.append(self._terms([coefficient / shared for coefficient in row], inputs))
        self._share_pairs(rows)
        return [self._sum(terms, factor) for terms, factor in zip(rows, factors, strict=True)]

    def _terms(self, row: Sequence[float], inputs: Sequence[str]) -> dict[str, int]:
        """Return a row as named terms with their signs."""
        terms = {}
        for coefficient, name in zip(row, inputs, strict=True):
            if size := abs(coefficient):
                term = name if size == 1 else self.name(f"{size!r} * {name}")
                terms[term] = 1 if coefficient > 0 else -1
        return terms

    def _share_pairs(self, rows: list[dict[str, int]]) -> None:
        """Replace the pair of terms that most rows share, up to sign, until none recurs."""
        while True:
            pairs = Counter(
                (a, b, row[a] * row[b])
                for row in rows
                for a, b in itertools.combinations(sorted(row), 2)
            )
            if not pairs or max(pairs.values()) < 2:
                return
            a, b, sign = max(pairs, key=pairs.__getitem__)
            sharing = [row for row in rows if row.get(a, 0) * row.get(b, 0) == sign]
            # Of a - b and b - a, the one that more rows add: the others subtract it.
            if sum(row[b] - row[a] for row in sharing) > 0:
                a, b = b, a
            total = self.name(f"{a} {'+' if sign > 0 else '-'} {b}")
            for row in sharing:
                row[total] = row.pop(a)
                del row[b]

    def _sum(self, terms: dict[str, int], factor: float) -> str:
        if not terms:
            return "0.0"
        if len(terms) == 1 and factor != 1:
            [(term, sign)] = terms.items()
            return f"{sign * factor!r} * {term}"
        # A positive term goes first, where there is one: it needs no negation.
        ordered = sorted(terms.items(), key=lambda each: -each[1])
        text = "".join(f" {'+' if sign > 0 else '-'} {term}" for term, sign in ordered)
        text = text[3:] if text.startswith(" + ") else f"-{text[3:]}"
        if factor == 1:
            return text
        return f"{factor!r} * ({text})"

    def compile(self, name: str, arguments: Sequence[str]) -> Callable[..., tuple[float, ...]]:
        """Return the function of these arguments that runs the lines and returns the results."""
        inner = [*self.lines, f"return ({''.join(f'{result}, ' for result in self.results)})"]
        if len(self.results) == 1 and self.results[0].count(","):
            inner[-1] = f"return {self.results[0]}"
        source = "\n".join(
            [
                "def make(sin, cos, hypot, atan2):",
                f"    def {name}({', '.join(arguments)}):",
                *(f"        {line}" for line in inner),
                f"    return {name}",
            ]
        )
        scope: dict[str, Any] = {}
        exec(source, scope)
        made: Callable[..., tuple[float, ...]] = scope["make"](
            math.sin, math.cos, math.hypot, math.atan2
        )
        return made
