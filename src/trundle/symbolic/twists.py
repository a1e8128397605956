"""From rows in symbols to the twists that they allow, and to W."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import sympy

from trundle.symbolic.solving import shorter, wheel_matrix
from trundle.symbolic.spaces import independent, null_space, numbers


class Twists(NamedTuple):
    """The twists that rows allow (N), those that nothing drives, the others (K), A K, and W."""

    N: Any
    undriven: Any
    K: Any
    AK: Any
    W: Any


def twists_of(held: Any, A: Any, R: Any, values: Mapping[Any, float]) -> Twists:
    """Return what rows that hold, rolling rows A and gains R say.

    Args:
        held: (h, 3) independent rows.
        A: (n, 3) rolling rows of the driven wheels.
        R: (n, n) gains.
        values: a number for each symbol, by which ranks are decided.

    >>> d = sympy.Symbol("d")
    >>> A = sympy.Matrix([[1, 0, -d], [1, 0, d]])
    >>> twists_of(sympy.Matrix([[0, 1, 0]]), A, sympy.eye(2), {d: 0.2}).W.row(2)
    Matrix([[-1/(2*d), 1/(2*d)]])
    """
    short = _directions([held, A])
    back = {letter: direction for direction, letter in short.items()}
    held, A = (sympy.ImmutableMatrix(matrix).xreplace(short) for matrix in (held, A))
    values = {**values, **{letter: _value(each, values) for each, letter in short.items()}}
    N = null_space(held, values)
    together = sympy.Matrix.vstack(held, A)
    told = independent(numbers(together, values))
    undriven = null_space(together.extract(told, [0, 1, 2]), values)
    K = null_space(sympy.Matrix.vstack(held, undriven.T), values) if undriven.cols else N
    AK = (A * K).applyfunc(shorter)
    found = N, undriven, K, AK, wheel_matrix(AK, R, K)
    return Twists(*(sympy.ImmutableMatrix(each).xreplace(back) for each in found))


def _directions(matrices: list[Any]) -> dict[Any, Any]:
    """Return one symbol for each direction that is a sum of symbols: they only come together."""
    found: set[Any] = set()
    for matrix in matrices:
        for atom in sympy.ImmutableMatrix(matrix).atoms(sympy.sin, sympy.cos):
            angle = atom.args[0]
            if angle.is_Add and all(term.is_Symbol for term in angle.args):
                found.add(angle)
    return {
        each: sympy.Dummy(f"delta_{i}", real=True) for i, each in enumerate(sorted(found, key=str))
    }


def _value(angle: Any, values: Mapping[Any, float]) -> float:
    return sum(values[term] for term in angle.args)
