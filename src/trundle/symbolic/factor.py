"""A factor that all entries of a matrix share."""

from __future__ import annotations

from typing import Any

import sympy

from trundle.symbolic.tidy import length, tidy

# Of longer matrices nobody looks for a factor.
_LONGEST = 120
# A factor is worth its place where so much is left of the operations at most.
_WORTH = 0.7


def common_factor(matrix: Any) -> tuple[Any, Any]:
    """Return a factor and the matrix that is left, so that no entry has a numeric denominator.

    The factor is 1 where the entries share none that makes them shorter.

    >>> a, l = sympy.symbols("a l")
    >>> common_factor(sympy.Matrix([[2 * a / 3, -a / 3, a / (3 * l)]]))
    (a/3, Matrix([[2, -1, 1/l]]))
    """
    matrix = sympy.ImmutableMatrix(matrix)
    if length(matrix) > _LONGEST:
        return sympy.Integer(1), matrix
    parts = [sympy.fraction(sympy.together(entry)) for entry in matrix if entry != 0]
    if len(parts) < 2:
        return sympy.Integer(1), matrix
    top = sympy.gcd_list([top for top, _ in parts])
    coefficients, bottoms = zip(*(bottom.as_coeff_Mul() for _, bottom in parts), strict=True)
    # A sum in all denominators stays as it is: the greatest divisor would multiply it out.
    same = len(set(bottoms)) == 1
    shared = bottoms[0] if same else sympy.gcd_list(list(bottoms))
    if not same and shared.has(sympy.Add):
        shared = sympy.Integer(1)
    factor = top / (tidy(shared) * sympy.ilcm(*coefficients))
    if factor.could_extract_minus_sign():
        factor = -factor
    rest = (matrix / factor).applyfunc(lambda entry: sympy.factor(sympy.cancel(entry)))
    if length(rest) > _WORTH * length(matrix):
        return sympy.Integer(1), matrix
    return factor, rest
