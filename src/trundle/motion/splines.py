"""Piecewise polynomials through points: cubic with given or continuous slopes, and quintic."""

from __future__ import annotations

import numpy as np

from trundle.motion.pieces import Pieces
from trundle.se2 import Array

# An end that a spline leaves at less than this share of the mean speed of its first interval is
# taken as a standstill: its direction would be that of the spline's own error.
_STANDSTILL = 0.25


def hermite(times: Array, values: Array, slopes: Array) -> Pieces:
    """Return the cubic pieces with given values (k, d) and slopes (k, d) at times (k,).

    ``p = p_0 + s_0 t + (3 D - 2 s_0 - s_1) t^2 / h + (s_0 + s_1 - 2 D) t^3 / h^2`` on a piece of
    length h, with the mean slope D = (p_1 - p_0) / h.

    Source: de Boor, A Practical Guide to Splines, 1978, chapter IV.
    """
    h = np.diff(times)[:, None]
    mean = np.diff(values, axis=0) / h
    first, last = slopes[:-1], slopes[1:]
    square = (3 * mean - 2 * first - last) / h
    cube = (first + last - 2 * mean) / h**2
    coefficients = np.stack([values[:-1], first, square, cube])
    return Pieces(times, np.swapaxes(coefficients, 1, 2))


def clamped_spline(times: Array, values: Array) -> Pieces:
    """Return the cubic spline through values (k, d), at rest at both ends.

    Value, slope and second derivative are continuous.

    Source: de Boor, A Practical Guide to Splines, 1978, chapter IV ("complete" spline).
    """
    from scipy.interpolate import CubicSpline

    slopes = np.asarray(CubicSpline(times, values, bc_type="clamped")(times, 1))
    slopes[[0, -1]] = 0.0
    return hermite(times, values, slopes)


def free_spline(times: Array, values: Array) -> Pieces:
    """Return the cubic spline through values (k, d) that finds its slopes at the ends itself.

    The first two and the last two pieces are one polynomial each ("not-a-knot"). An end from
    which this leads off far slower than the mean of its interval is one at rest.

    Source: de Boor, A Practical Guide to Splines, 1978, chapter IV.
    """
    from scipy.interpolate import CubicSpline

    def slopes(first: object, last: object) -> Array:
        return np.asarray(CubicSpline(times, values, bc_type=(first, last))(times, 1))

    ends: list[object] = ["not-a-knot", "not-a-knot"]
    found, rest = slopes(*ends), (1, np.zeros(values.shape[1]))
    for i in (0, -1):
        mean = (values[1] - values[0]) / (times[1] - times[0])
        if i:
            mean = (values[-1] - values[-2]) / (times[-1] - times[-2])
        if np.linalg.norm(found[i]) < _STANDSTILL * np.linalg.norm(mean):
            ends[i] = rest
    found = slopes(*ends)
    for i in (0, -1):
        if ends[i] is rest:
            found[i] = 0.0
    return hermite(times, values, found)


def quintic_piece(duration: float, start: Array, end: Array) -> Pieces:
    """Return the quintic with given value, slope and second derivative, (3, d), at both ends.

    Source: Craig, Introduction to Robotics, 3rd edition, 2005, section 7.3.
    """
    # In the time s = t / duration all powers are of one size.
    scale = np.array([[1.0], [duration], [duration**2]])
    (p, v, a), (q, w, b) = start * scale, end * scale
    miss, slope, bend = q - p - v - a / 2, w - v - a, b - a
    powers = [
        p,
        v,
        a / 2,
        10 * miss - 4 * slope + bend / 2,
        -15 * miss + 7 * slope - bend,
        6 * miss - 3 * slope + bend / 2,
    ]
    unit = Pieces(np.array([0.0, 1.0]), np.stack(powers)[:, :, None])
    return unit.stretched(duration)
