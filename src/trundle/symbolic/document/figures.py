"""Expressions with numbers in them, rounded for reading."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from trundle.symbolic.document.parts import Value
from trundle.symbolic.spaces import numbers

_DIGITS = 5
# In SI units, a figure below this is the rounding of a zero.
_ZERO = 1e-12


def figure(value: float) -> Any:
    """Return a number as sympy prints it for reading, with five digits.

    >>> figure(2.0), figure(1 / 3), figure(-1e-17)
    (2, 0.33333, 0)
    """
    if abs(value) < _ZERO:
        return sympy.Integer(0)
    digits, _, power = f"{value:.{_DIGITS}g}".partition("e")
    number = sympy.Float(digits, _DIGITS) if "." in digits else sympy.Integer(digits)
    if not power:
        return number
    tens = sympy.Pow(10, int(power), evaluate=False)
    return tens if number == 1 else sympy.Mul(number, tens, evaluate=False)


def in_words(value: float) -> str:
    """Return a number for a sentence.

    >>> in_words(0.2), in_words(-1e-17)
    ('0.2', '0')
    """
    return f"{0.0 if abs(value) < _ZERO else value:.{_DIGITS}g}"


def with_numbers(expression: Any, values: Mapping[Any, float]) -> Any:
    """Return an expression or matrix with the symbols that have numbers replaced, or None.

    None where no symbol in it has one.

    >>> a, psi = sympy.symbols("a psi")
    >>> with_numbers(sympy.sqrt(3) * a * sympy.cos(psi) / 3, {a: 0.2})
    0.11547*cos(psi)
    """
    known = expression.free_symbols & set(values)
    if not known:
        return None
    if expression.free_symbols == known:
        if not isinstance(expression, sympy.MatrixBase):
            return figure(float(numbers(sympy.Matrix([expression]), values)[0, 0]))
        found = numbers(expression, values)
        return sympy.Matrix(*found.shape, [figure(value) for value in found.ravel().tolist()])
    placed = expression.subs({symbol: sympy.Float(values[symbol]) for symbol in known})
    return placed.applyfunc(_rounded) if hasattr(placed, "applyfunc") else _rounded(placed)


def _rounded(expression: Any) -> Any:
    expression = sympy.expand(expression.evalf())
    return expression.xreplace(
        {each: figure(float(each)) for each in expression.atoms(sympy.Float)}
    )


def shown(left: Any, right: Any, values: Mapping[Any, float]) -> Value:
    """Return ``left = right`` with its numbers.

    >>> a = sympy.Symbol("a")
    >>> shown("x", 2 * a, {a: 1.0}).numbers
    2
    """
    return Value(left, right, with_numbers(right, values))
