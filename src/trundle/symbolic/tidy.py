"""Symbolic results in the form in which people write them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import sympy

# In longer products of more angles than these, looking for sums of angles takes seconds.
_OPERATIONS, _ANGLES = 25, 3


def tidy(expression: Any, by: Sequence[Any] = ()) -> Any:
    """Return an expression with sines and cosines gathered and common factors in front.

    Args:
        expression: a sum of products of lengths, masses, rates, sines and cosines.
        by: symbols by whose powers the terms are put together.

    >>> a, b, m, s = sympy.symbols("a b m s")
    >>> tidy(sympy.cos(a) * sympy.cos(b) - sympy.sin(a) * sympy.sin(b))
    cos(a + b)
    >>> tidy(m * a + m * b * s + m * a * s, by=[s])
    m*(a + s*(a + b))
    """
    expression = sympy.expand(sympy.sympify(expression))
    if expression.has(sympy.sin, sympy.cos):
        expression = _gathered(expression)
    present = [symbol for symbol in by if expression.has(symbol)]
    if present:
        parts = sympy.collect(expression, present, evaluate=False)
        expression = sympy.Add(*(power * tidy(part) for power, part in parts.items()))
    return _leading_plus(sympy.factor_terms(expression))


def tidy_matrix(matrix: Any, by: Sequence[Any] = ()) -> Any:
    """Return a matrix, not to be changed, with every entry in that form."""
    return sympy.ImmutableMatrix(matrix.applyfunc(lambda entry: tidy(entry, by)))


def _leading_plus(expression: Any) -> Any:
    """Return a product whose sums begin without a minus, which goes in front."""
    if not expression.is_Mul or all(each.is_Rational or each.is_Add for each in expression.args):
        return expression
    factors = [
        -each if each.is_Add and each.as_ordered_terms()[0].could_extract_minus_sign() else each
        for each in expression.args
    ]
    turned = sum(a is not b for a, b in zip(factors, expression.args, strict=True))
    return sympy.Mul((-1) ** turned, *factors)


def _gathered(expression: Any) -> Any:
    """Return an expanded expression with the factor of each product of lengths simplified.

    Such factors are short and come back often, where the whole sum would take long.
    """
    atoms = expression.atoms(sympy.sin, sympy.cos)
    angles = set().union(*(atom.free_symbols for atom in atoms))
    lengths = sorted(expression.free_symbols - angles, key=str)
    if not lengths or not expression.is_polynomial(*lengths):
        return _simplified(expression)
    terms = sympy.Poly(expression, *lengths).terms()
    return sympy.Add(
        *(
            sympy.Mul(_simplified(factor), *map(sympy.Pow, lengths, powers))
            for powers, factor in terms
        )
    )


@cache
def _simplified(expression: Any) -> Any:
    many = len(expression.free_symbols) > _ANGLES and expression.count_ops() > _OPERATIONS
    return expression if many else sympy.trigsimp(expression)


def length(expression: Any) -> int:
    """Return how many operations an expression, or all entries of a matrix together, have.

    >>> length(sympy.Matrix([[sympy.Symbol("a") + 1, 0]]))
    1
    """
    if isinstance(expression, sympy.MatrixBase):
        return sum(int(entry.count_ops()) for entry in expression)
    return int(expression.count_ops())
