"""The direction of a path of polynomials, through standstills, reversals and corners."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from trundle.errors import TrundleError
from trundle.motion.pieces import Indices, Pieces, bernstein
from trundle.motion.sections import Complex, sections, unwrapped
from trundle.motion.tangent import Tangent
from trundle.se2 import Array, Mask

# Coefficients below this share of a piece's are the rounding of zeros.
_ROUNDING = 1e-12
# A piece whose control vectors all point this far into one half-plane has no standstill.
_CLEAR = 1e-6
# A zero of the velocity this near to the axis of time, in lengths of its piece, lies on it: the
# half-turn that passing it takes would last a billionth of the piece.
_ON_AXIS = 1e-9
# A double zero comes out of rounding as two, split by about 1e-8.
_SPLIT = 1e-6
# A corner this near to half a turn is a reversal, through which the robot drives backwards.
_REVERSAL = 1e-6
# An angle beyond rounding.
_CORNER = 1e-9
# The tangent before a corner is held this share of the duration longer, so that rounding of a
# time does not turn the robot early.
_HELD = 1e-12


def tangent_of_pieces(curve: Pieces) -> Tangent:
    """Return the heading along a curve of polynomials.

    At a standstill it is the tangent's limit. Where the path reverses there, the robot goes on
    backwards; where it goes on in another direction, the heading jumps by the shorter way as soon
    as it moves.

    Raises:
        TrundleError: the curve never moves.
    """
    far = np.abs(curve.coefficients[0]).max()
    if curve.speed_bound * curve.breaks[-1] <= _ROUNDING * far or curve.speed_bound == 0:
        raise TrundleError(
            "a path of no length has no tangent to head along: give heading= a number [rad], "
            "or a heading with each point"
        )
    along = _directed(curve.velocity())

    def vector(t: Array, piece: Indices) -> Complex:
        found = along.at(piece, t - along.breaks[piece], 2)
        return np.asarray(found[:, 0] + 1j * found[:, 1])

    found = sections(vector, along.velocity().rate_bounds(), along.breaks)
    angles, jumps = unwrapped(vector, found)
    starts = found.start.copy()
    starts[1:][np.abs(jumps) > _CORNER] += _HELD * curve.breaks[-1]
    return Tangent(along.cut(starts, found.piece), starts, angles)


def _directed(velocity: Pieces) -> Pieces:
    """Return vectors along the path that are nowhere zero, to the side to which the robot faces."""
    scaled = velocity.in_units()
    powers = scaled[:, 0] + 1j * scaled[:, 1]
    first, last = np.ones(powers.shape[1]), np.ones(powers.shape[1])
    sizes = np.abs(powers).sum(axis=0)
    still = sizes <= _ROUNDING * sizes.max()
    for i in np.flatnonzero(~still & ~_clear(powers)):
        divided = _divide(powers[:, i])
        powers[:, i] = np.pad(divided.powers, (0, len(powers) - len(divided.powers)))
        first[i], last[i] = divided.first, divided.last
    start, end = first * powers[0], last * powers.sum(axis=0)
    for i in np.flatnonzero(still):  # it faces as before, or as it will face first
        start[i] = end[i] = end[i - 1] if i else start[~still][0]
        powers[:, i], powers[0, i] = 0.0, start[i]
    turned = np.abs(np.angle(start[1:] * end[:-1].conj()))
    reversal = np.where(turned >= math.pi - _REVERSAL, -1.0, 1.0)
    gear = np.concatenate([[1.0], np.cumprod(first[:-1] * last[:-1] * reversal)])
    facing = gear * first * powers
    lengths = np.diff(velocity.breaks) ** np.arange(len(powers))[:, None, None]
    return Pieces(velocity.breaks, np.stack([facing.real, facing.imag], axis=1) / lengths)


def _clear(powers: Complex) -> Mask:
    """Return which polynomials (degree + 1, n) surely have no zero on [0, 1]."""
    control = bernstein(powers)
    mean = control.sum(axis=0)
    ahead = (control * mean.conj()).real.min(axis=0)
    return np.asarray(ahead > _CLEAR * np.abs(mean) * np.abs(control).max(axis=0))


class _Divided(NamedTuple):
    """A polynomial u without zeros on [0, 1] in V = q u, and the sign of q next to both ends."""

    powers: Complex
    first: float
    last: float


def _divide(powers: Complex) -> _Divided:
    """Return a polynomial (degree + 1,), divided by what makes it zero on [0, 1]."""
    # q is s^j (1 - s)^k so far: positive in between.
    powers = _flip(_strip(_flip(_strip(powers))))
    side = powers[np.argmax(np.abs(powers))]
    along = powers * side.conj() / np.abs(side)
    if np.abs(along.imag).max() <= _ROUNDING * np.abs(powers).sum():  # a straight line
        return _Divided(np.array([side]), *np.sign([along.real[0], along.real.sum()]).tolist())
    first = last = 1.0
    roots = np.roots(powers[::-1])
    for root in roots:
        twins = (np.abs(roots - root) <= _SPLIT).sum() > 1
        near = _SPLIT if twins else _ON_AXIS
        if abs(root.imag) <= near and -near <= root.real <= 1 + near:
            powers = _quotient(powers, root)
            first *= -1.0 if root.real > 0 else 1.0
            last *= -1.0 if root.real >= 1 else 1.0
    return _Divided(powers, first, last)


def _strip(powers: Complex) -> Complex:
    """Return a polynomial divided by s as often as it is zero at s = 0."""
    size = np.abs(powers).sum()
    zeros = int(np.argmax(np.abs(powers) > _ROUNDING * size))
    return powers[zeros:]


def _quotient(powers: Complex, root: complex) -> Complex:
    """Return a polynomial divided by s - root, one of its roots."""
    quotient, _ = np.polydiv(powers[::-1], [1.0, -root])
    return np.asarray(quotient[::-1], dtype=np.complex128)


def _flip(powers: Complex) -> Complex:
    """Return the polynomial in 1 - s in place of s."""
    count = range(len(powers))
    matrix = [[math.comb(j, k) * (-1) ** k for j in count] for k in count]
    return np.asarray(np.array(matrix) @ powers)
