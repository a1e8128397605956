"""Null spaces and inverses in symbols, whose ranks the robot's numbers decide.

Elimination in symbols cannot tell an expression that vanishes from one that does not; the numbers
of the robot can, so that every pivot here is chosen by them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import sympy

from trundle.se2 import Array
from trundle.symbolic.tidy import tidy

# A row counts when what it adds is more than this share of it, as in trundle.kinematics.
_INDEPENDENT = 1e-9


def numbers(matrix: Any, values: Mapping[Any, float]) -> Array:
    """Return a matrix of expressions as numbers.

    >>> a = sympy.Symbol("a")
    >>> numbers(sympy.Matrix([[a, 2 * a]]), {a: 0.5}).tolist()
    [[0.5, 1.0]]
    """
    matrix = sympy.ImmutableMatrix(matrix)
    if matrix.rows == 0 or matrix.cols == 0:
        return np.zeros(matrix.shape)
    read = _reader(matrix, tuple(values))
    return np.array(read(*values.values()), dtype=np.float64).reshape(matrix.shape)


@lru_cache(maxsize=256)
def _reader(matrix: Any, symbols: tuple[Any, ...]) -> Callable[..., list[float]]:
    read: Callable[..., list[float]] = sympy.lambdify(symbols, list(matrix), "math", cse=True)
    return read


def independent(rows: Array) -> list[int]:
    """Return the first rows, in order, that are independent of those before them.

    >>> independent(np.array([[0.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 0.0]]))
    [0, 2]
    """
    kept: list[int] = []
    basis: list[Array] = []
    for i, row in enumerate(rows):
        rest = np.array(row)
        for _ in range(2):  # twice is enough for orthogonality to rounding
            for each in basis:
                rest -= (each @ rest) * each
        size = float(np.linalg.norm(rest))
        if size > _INDEPENDENT * max(1.0, float(np.linalg.norm(row))):
            kept.append(i)
            basis.append(rest / size)
    return kept


def null_space(rows: Any, values: Mapping[Any, float]) -> Any:
    """Return a basis (3, 3 - k) of the twists on which k independent rows (k, 3) vanish.

    >>> null_space(sympy.Matrix([[0, 1, 0]]), {}).T
    Matrix([
    [1, 0, 0],
    [0, 0, 1]])
    """
    rows = sympy.Matrix(rows)
    if rows.rows == 0:
        return sympy.ImmutableMatrix(sympy.eye(3))
    if rows.rows == 1:
        vectors = _across(rows, values)
    elif rows.rows == 2:
        vectors = [rows.row(0).cross(rows.row(1))]
    else:
        return sympy.ImmutableMatrix(3, 0, [])
    return sympy.ImmutableMatrix(sympy.Matrix.hstack(*(primitive(v).T for v in vectors)))


def _across(row: Any, values: Mapping[Any, float]) -> list[Any]:
    """Return two vectors on which one row vanishes."""
    size = np.abs(numbers(row, values)[0])
    # A pivot that is a number stays clear of zero whatever the symbols are.
    plain = [j for j in range(3) if row[j].is_number and size[j] > _INDEPENDENT]
    pivot = max(plain or range(3), key=lambda j: size[j])
    vectors = []
    for j in (k for k in range(3) if k != pivot):
        vector = sympy.zeros(1, 3)
        vector[j], vector[pivot] = row[pivot], -row[j]
        vectors.append(vector)
    return vectors


def primitive(vector: Any) -> Any:
    """Return the direction of a vector without factors that all its entries share.

    >>> a, b = sympy.symbols("a b")
    >>> primitive(sympy.Matrix([[a * b, 0, -a]]))
    Matrix([[b, 0, -1]])
    """
    entries = [sympy.expand(entry) for entry in vector]
    shared = sympy.gcd_list([entry for entry in entries if entry != 0])
    divided = [tidy(sympy.cancel(entry / shared)) for entry in entries]
    first = divided[0] if divided[0] != 0 else [entry for entry in divided if entry != 0][-1]
    sign = -1 if first.could_extract_minus_sign() else 1
    return sympy.Matrix([[sign * entry for entry in divided]])
