"""How a command moves a robot in one step, in scalars.

Plain floats, numpy's arrays, numba and numba-cuda read these functions; each ``make`` takes the
arithmetic and the compiler of its reader. They hold no literal numbers, which would widen a float
to a double.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from trundle.se2 import make_chord, make_turned
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.written import dot

Values = tuple[Any, ...]


class Motion(Protocol):
    """A way to move: hashable; ``kept`` numbers of a robot, the pose first; its constants' number.

    ``arcs`` tells whether sinc is read, which compiled code has for less than half a turn only.
    """

    @property
    def kept(self) -> int:
        """How many numbers are kept of a robot, without what sums lose."""

    @property
    def constants(self) -> int:
        """How many constants the function takes."""

    @property
    def arcs(self) -> bool:
        """Whether the function reads sinc."""

    def make(self, m: Arithmetic, jit: Jit, compensated: bool) -> Function:
        """Return (state, command, constants) -> the new state, and half of the step's turn."""


# ---- from a twist's increment to its chord, for each method -----------------------------------


def _exact(m: Arithmetic, jit: Jit) -> Function:
    return jit(make_chord(m.sinc))


def _rk4(m: Arithmetic, jit: Jit) -> Function:
    """For a constant twist the method weighs three headings: ``(2 + cos h) / 3 (dx, dy)``."""
    cos, two, third = m.cos, m.number(2), m.number(1 / 3)
    weighed = jit(lambda half: (two + cos(half)) * third)
    return jit(make_chord(weighed))


def _euler(m: Arithmetic, jit: Jit) -> Function:
    """The heading at the start, seen from that at the middle."""
    turned = jit(make_turned(m.sin, m.cos))
    return jit(lambda dx, dy, half: turned(-half, dx, dy))


CHORDS: dict[str, Callable[[Arithmetic, Jit], Function]] = {
    "exact": _exact,
    "euler": _euler,
    "rk4": _rk4,
}


# ---- from chord to pose ----------------------------------------------------------------------


def make_sum(jit: Jit, compensated: bool) -> Function:
    """Return (state, dx, dy, half) -> the pose after a displacement and a turn of 2 half.

    Args:
        jit: the compiler.
        compensated: whether the state begins with x, y, psi and what their sums have lost to
            rounding, in place of x, y, psi. Source: Kahan, "Further remarks on reducing truncation
            errors", Communications of the ACM 8(1), 1965.
    """

    def add(total: Any, lost: Any, step: Any) -> tuple[Any, Any]:
        wanted = step - lost
        new = total + wanted
        return new, (new - total) - wanted

    add = jit(add)

    def moved(state: Values, dx: Any, dy: Any, half: Any) -> Values:
        return state[0] + dx, state[1] + dy, state[2] + (half + half)

    def moved_compensated(state: Values, dx: Any, dy: Any, half: Any) -> Values:
        x, lost_x = add(state[0], state[3], dx)
        y, lost_y = add(state[1], state[4], dy)
        psi, lost_psi = add(state[2], state[5], half + half)
        return x, y, psi, lost_x, lost_y, lost_psi

    return jit(moved_compensated if compensated else moved)


def make_move(m: Arithmetic, jit: Jit, compensated: bool) -> Function:
    """Return (state, a, b, half) -> the pose after a chord (a, b) and a turn of 2 half.

    The arguments are those of ``make_sum``, after the elementary functions.
    """
    turned, moved = jit(make_turned(m.sin, m.cos)), make_sum(jit, compensated)

    def move(state: Values, a: Any, b: Any, half: Any) -> Any:
        dx, dy = turned(state[2] + half, a, b)
        return moved(state, dx, dy, half)

    return jit(move)


# ---- motions ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Chord:
    """The command is the chord of the step itself, and half of its turn."""

    kept: ClassVar[int] = 3
    constants: ClassVar[int] = 0
    arcs: ClassVar[bool] = False

    def make(self, m: Arithmetic, jit: Jit, compensated: bool) -> Function:
        """Return (state, command, constants) -> the new state, and half of the step's turn."""
        move = make_move(m, jit, compensated)

        def step(state: Values, command: Values, _: Values) -> tuple[Values, Any]:
            return move(state, command[0], command[1], command[2]), command[2]

        return jit(step)


@dataclass(frozen=True)
class Linear:
    """A map (3, k), row by row in the constants, takes the command to dx, dy and half dpsi."""

    count: int
    method: str
    kept: ClassVar[int] = 3

    @property
    def constants(self) -> int:
        """How many constants the function takes."""
        return 3 * self.count

    @property
    def arcs(self) -> bool:
        """Whether the function reads sinc."""
        return self.method == "exact"

    def make(self, m: Arithmetic, jit: Jit, compensated: bool) -> Function:
        """Return (state, command, constants) -> the new state, and half of the step's turn."""
        chord, move = CHORDS[self.method](m, jit), make_move(m, jit, compensated)
        total, second, third = jit(dot(self.count)), self.count, 2 * self.count

        def step(state: Values, command: Values, constants: Values) -> tuple[Values, Any]:
            dx = total(constants, 0, command)
            dy = total(constants, second, command)
            half = total(constants, third, command)
            a, b = chord(dx, dy, half)
            return move(state, a, b, half), half

        return jit(step)
