"""A direction that turns, followed without a jump: sections in which it stays in a half-plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.motion.pieces import Indices
from trundle.se2 import Array

Complex = npt.NDArray[np.complex128]
# Vectors u and u' (2, T) at times (T,), as complex numbers, each by the formula of one piece.
Direction = Callable[[Array, Indices], Complex]

# A section's ends may differ from its middle by this share of the middle's length: 42 degrees.
_NEAR = 2 / 3
# Halvings of a section, down to times that floats can hardly tell apart.
_HALVINGS = 45


@dataclass(frozen=True, eq=False)
class Sections:
    """Stretches of time in which a direction stays within 42 degrees of that at the middle.

    Attributes:
        start, end: (m,) [s], in order.
        piece: (m,) piece of the direction that each belongs to.
    """

    start: Array
    end: Array
    piece: Indices


def sections(direction: Direction, bounds: Array, breaks: Array) -> Sections:
    """Return the sections of a direction that is nowhere zero.

    A vector whose second derivative is b at most stays within ``|u'| h + b h^2 / 2`` of that at the
    middle of an interval of half-length h; intervals for which that is too much are halved.

    Args:
        direction: the vectors.
        bounds: (n,) bound on the length of their second derivative in each piece.
        breaks: (n + 1,) ends of the pieces [s].
    """
    start, end, piece = breaks[:-1], breaks[1:], np.arange(len(bounds))
    starts, ends, pieces = [], [], []
    for level in range(_HALVINGS + 1):
        middle = (start + end) / 2
        half = (end - start) / 2
        size, rate = np.abs(direction(middle, piece))
        near = rate * half + bounds[piece] * half**2 / 2 <= _NEAR * size
        if level == _HALVINGS:
            near[:] = True
        starts.append(start[near])
        ends.append(end[near])
        pieces.append(piece[near])
        start, middle, end, piece = start[~near], middle[~near], end[~near], piece[~near]
        if not len(start):
            break
        start, end = np.concatenate([start, middle]), np.concatenate([middle, end])
        piece = np.concatenate([piece, piece])
    found = np.concatenate(starts)
    order = np.argsort(found)
    return Sections(found[order], np.concatenate(ends)[order], np.concatenate(pieces)[order])


def unwrapped(direction: Direction, found: Sections) -> tuple[Array, Array]:
    """Return the angles (m,) of a direction at the middle of its sections, and the jumps (m - 1,).

    The first angle lies in (-pi, pi], the others follow without turns left out; where one piece
    ends in another direction than the next begins with, the angle jumps the shorter way.
    """
    first, middle, last = (
        direction(t, found.piece)[0]
        for t in (found.start, (found.start + found.end) / 2, found.end)
    )
    opening, closing = _turn(first, middle), _turn(middle, last)
    jumps = _turn(last[:-1], first[1:])
    angle = math.atan2(first[0].imag, first[0].real)
    steps = closing[:-1] + jumps + opening[1:]
    return angle + opening[0] + np.concatenate([[0.0], np.cumsum(steps)]), jumps


def _turn(start: Complex, end: Complex) -> Array:
    """Return the angle in (-pi, pi] from one vector to another."""
    return np.angle(end * start.conj())
