"""Piecewise polynomials of time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from trundle.motion.harmonics import turning_matrix
from trundle.se2 import Array

Indices = npt.NDArray[np.intp]


@final
@dataclass(frozen=True, eq=False)
class Pieces:
    """``p(t) = sum_j coefficients_j (t - breaks_k)^j`` for t in piece k.

    A break belongs to the piece that it begins.

    Attributes:
        breaks: (n + 1,) where the pieces begin, and where the last one ends [s].
        coefficients: (degree + 1, d, n) of each power, quantity and piece.
    """

    breaks: Array
    coefficients: Array
    period: ClassVar[None] = None

    @property
    def speed_bound(self) -> float:
        """A speed that it nowhere exceeds [m/s]."""
        return float(self.rate_bounds().max())

    def rate_bounds(self) -> Array:
        """Return a bound on the size of the derivative within each piece (n,)."""
        if len(self.coefficients) == 1:
            return np.zeros(self.coefficients.shape[2])
        control = bernstein(self.velocity().in_units())
        return np.asarray(np.linalg.norm(control, axis=1).max(axis=0))

    def in_units(self) -> Array:
        """Return the coefficients for time in lengths of each piece."""
        powers = np.arange(len(self.coefficients))[:, None, None]
        return np.asarray(self.coefficients * np.diff(self.breaks) ** powers)

    def derivatives(self, t: Array, count: int) -> Array:
        """Return the value and its derivatives (count, d, T) at times (T,)."""
        piece = self.pieces_at(t)
        return self.at(piece, t - self.breaks[piece], count)

    def pieces_at(self, t: Array) -> Indices:
        """Return the pieces (T,) that times belong to; the end ones go on outside the span."""
        last = len(self.breaks) - 2
        if last == 0:
            return np.zeros(len(t), dtype=np.intp)
        return np.clip(np.searchsorted(self.breaks, t, side="right") - 1, 0, last)

    def at(self, piece: Indices, since: Array, count: int) -> Array:
        """Return the derivatives (count, d, T) in given pieces, at times since their beginning.

        Horner's rule, carried through to the derivatives.
        """
        out = np.zeros((count, self.coefficients.shape[1], len(since)))
        for done, coefficient in enumerate(self.coefficients[::-1]):
            for order in range(min(done, count - 1), 0, -1):
                out[order] *= since
                out[order] += out[order - 1]
            out[0] *= since
            out[0] += np.take(coefficient, piece, axis=1)
        for order in range(2, count):
            out[order] *= math.factorial(order)
        return out

    def velocity(self) -> Pieces:
        """Return its derivative."""
        powers = np.arange(1, len(self.coefficients))
        return replace(self, coefficients=powers[:, None, None] * self.coefficients[1:])

    def columns(self, first: int, last: int) -> Pieces:
        """Return some of its quantities."""
        return replace(self, coefficients=self.coefficients[:, first:last])

    def cut(self, starts: Array, piece: Indices) -> Pieces:
        """Return it cut at other places: pieces that begin at starts (m,), each from one of its."""
        count = len(self.coefficients)
        powers = self.at(piece, starts - self.breaks[piece], count)
        factorials = [math.factorial(j) for j in range(count)]
        return Pieces(
            np.append(starts, self.breaks[-1]), powers / np.reshape(factorials, (-1, 1, 1))
        )

    def moved(self, x: float, y: float, psi: float) -> Pieces:
        """Return the curve turned by psi about the origin, then shifted by (x, y)."""
        coefficients = turning_matrix(psi) @ self.coefficients
        coefficients[0] += [[x], [y]]
        return replace(self, coefficients=coefficients)

    def raised(self, by: float) -> Pieces:
        """Return it with a constant added."""
        coefficients = self.coefficients.copy()
        coefficients[0] += by
        return replace(self, coefficients=coefficients)

    def stretched(self, factor: float) -> Pieces:
        """Return it run through in ``factor`` times the time."""
        shrink = factor ** -np.arange(len(self.coefficients), dtype=np.float64)
        return Pieces(factor * self.breaks, shrink[:, None, None] * self.coefficients)


def bernstein(powers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the Bernstein coefficients (degree + 1, ...) of polynomials on [0, 1].

    The polynomial stays in their convex hull.

    Source: Farouki and Rajan, On the Numerical Condition of Polynomials in Bernstein Form, 1987.

    >>> bernstein(np.array([0.0, 0.0, 1.0])).tolist()  # s^2
    [0.0, 0.0, 1.0]
    """
    n = len(powers) - 1
    matrix = [[math.comb(i, j) / math.comb(n, j) for j in range(n + 1)] for i in range(n + 1)]
    return np.asarray(np.tensordot(np.array(matrix), powers, axes=1))
