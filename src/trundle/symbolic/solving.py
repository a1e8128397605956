"""W in symbols, by least squares."""

from __future__ import annotations

from typing import Any

import sympy

from trundle.symbolic.spaces import primitive
from trundle.symbolic.tidy import tidy

# Expressions of more operations than this are left as they are: to gather or to cancel them takes
# longer than it helps a reader.
LONGEST = 90


def wheel_matrix(AK: Any, R: Any, K: Any) -> Any:
    """Return W (3, n) = K (A K)^+ R, for the product A K (n, k) of full column rank.

    ``(A K)^+ = ((A K)^T (A K))^-1 (A K)^T``, the inverse where A K is square.

    >>> A = sympy.Matrix([[1, 0, -2], [1, 0, 2]])
    >>> K = sympy.Matrix([[1, 0], [0, 0], [0, 1]])
    >>> wheel_matrix(A * K, sympy.eye(2), K)
    Matrix([
    [ 1/2, 1/2],
    [   0,   0],
    [-1/4, 1/4]])
    """
    if not len(AK):
        return sympy.ImmutableMatrix.zeros(3, AK.rows)
    if K.cols == 1:
        return _along_one_motion(AK, R, K)
    square = AK.rows == AK.cols
    normal = AK if square else (AK.T * AK).applyfunc(shorter)
    top, bottom = adjugate(normal), shorter(determinant(normal))
    if not square:
        top = top * AK.T
    return sympy.ImmutableMatrix((K * top * R).applyfunc(lambda entry: quotient(entry, bottom)))


def _along_one_motion(AK: Any, R: Any, K: Any) -> Any:
    """Return W for one motion: each wheel tells its share, weighted by how much it tells."""
    told = primitive(AK).T
    i = next(i for i in range(AK.rows) if told[i] != 0)
    shared = quotient(AK[i], told[i])
    weight = shared * sympy.Add(*(entry**2 for entry in told))
    if told.rows == 1:
        weight = shorter(weight)
    return sympy.ImmutableMatrix(
        (K * told.T * R).applyfunc(lambda entry: sympy.factor_terms(sympy.factor(entry) / weight))
    )


def adjugate(matrix: Any) -> Any:
    """Return the adjugate of a matrix of at most three rows, its entries not expanded.

    >>> adjugate(sympy.Matrix([[1, 2], [3, 4]]))
    Matrix([
    [ 4, -2],
    [-3,  1]])
    """
    if matrix.rows == 1:
        return sympy.eye(1)
    if matrix.rows == 2:
        (a, b), (c, d) = matrix.tolist()
        return sympy.Matrix([[d, -b], [-c, a]])
    first, second, third = (matrix.row(i) for i in range(3))
    return sympy.Matrix([second.cross(third), third.cross(first), first.cross(second)]).T.applyfunc(
        shorter
    )


def determinant(matrix: Any) -> Any:
    """Return the determinant of a matrix of at most three rows, not expanded.

    >>> determinant(sympy.Matrix([[1, 2], [3, 4]]))
    -2
    """
    return (matrix.row(0) * adjugate(matrix).col(0))[0]


def shorter(expression: Any) -> Any:
    """Return an expression tidied where it is short enough for that.

    >>> a = sympy.Symbol("a")
    >>> shorter(sympy.cos(a) ** 2 + sympy.sin(a) ** 2)
    1
    """
    return tidy(expression) if expression.count_ops() < LONGEST else expression


def quotient(top: Any, bottom: Any) -> Any:
    """Return a quotient without common factors, where that is not too long to find.

    >>> a, b = sympy.symbols("a b")
    >>> quotient(a**2 - b**2, a + b)
    a - b
    """
    if top == 0:
        return sympy.Integer(0)
    if top.count_ops() + bottom.count_ops() > LONGEST:
        return top / bottom
    whole = sympy.factor(sympy.cancel(tidy(top) / bottom))
    top, bottom = sympy.fraction(whole)
    # Cancelling puts 1 - sin^2 for cos^2; other sums are best left in factors.
    return top / tidy(bottom) if bottom.has(sympy.sin, sympy.cos) else whole
