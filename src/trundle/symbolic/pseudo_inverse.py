"""The lectures' two pseudo-inverses of W, and which of them a robot has."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import sympy

from trundle.symbolic.robot import SymbolicRobot, generic_angles
from trundle.symbolic.solving import adjugate, determinant, quotient, shorter
from trundle.symbolic.spaces import numbers
from trundle.symbolic.tidy import length

# Expressions longer than this are not multiplied out.
_LONG = 100


class PseudoInverse(NamedTuple):
    """Which inverse of W there is, from a twist to wheel speeds, and its parts.

    Attributes:
        kind: "left" (least squares), "right" (minimum norm), "inverse", or "none".
        rank: rank of W at generic steering angles.
        normal: the square matrix W^T W or W W^T that is inverted, or W; None where it is too long.
        matrix: the inverse (n, 3); None where there is none or it is too long.
    """

    kind: str
    rank: int
    normal: Any
    matrix: Any


def pseudo_inverse(made: SymbolicRobot) -> PseudoInverse:
    """Return the pseudo-inverse of W that the lectures would take.

    ``(W^T W)^-1 W^T`` for fewer than 3 independent columns (least squares), ``W^T (W W^T)^-1``
    for more than 3 wheels that give every twist (minimum norm), ``W^-1`` for 3.

    Source: the lectures; Golub and Van Loan, Matrix Computations, 4th edition, 2013, sections 5.3
    and 5.6.

    >>> import trundle
    >>> from trundle.symbolic import symbolic_robot
    >>> pseudo_inverse(symbolic_robot(trundle.load("differential"))).matrix
    Matrix([
    [1/a, 0, -d/a],
    [1/a, 0,  d/a]])
    """
    count = made.W.cols
    rank = int(np.linalg.matrix_rank(numbers(made.W, made.values(generic_angles(made.robot)))))
    kind = _kind(rank, count)
    if kind == "none" or length(made.W) > _LONG:
        return PseudoInverse(kind, rank, None, None)
    W = sympy.Matrix(made.W)
    before, after = {
        "left": (sympy.eye(count), W.T),
        "right": (W.T, sympy.eye(3)),
        "inverse": (1, 1),
    }[kind]
    normal = (W * before if kind != "left" else after * W).applyfunc(_gathered)
    matrix = (before * _inverse(normal) * after).applyfunc(_gathered)
    return PseudoInverse(kind, rank, *map(sympy.ImmutableMatrix, (normal, matrix)))


def _kind(rank: int, count: int) -> str:
    if rank == count == 3:
        return "inverse"
    if rank == count > 0:
        return "left"
    return "right" if rank == 3 else "none"


def _gathered(entry: Any) -> Any:
    return quotient(*sympy.fraction(sympy.together(entry)))


def _inverse(matrix: Any) -> Any:
    bottom = shorter(determinant(matrix))
    return adjugate(matrix).applyfunc(lambda entry: quotient(entry, bottom))
