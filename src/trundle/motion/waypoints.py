"""Splines through waypoints, about as fast as limits of speed and acceleration allow."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from trundle.errors import TrundleError
from trundle.motion.checks import points_array, positive
from trundle.motion.headings import HeadingChoice
from trundle.motion.pieces import Pieces
from trundle.motion.points import through, with_own_headings
from trundle.motion.splines import clamped_spline
from trundle.motion.trajectory import Trajectory
from trundle.se2 import Array

# After so many rounds the intervals no longer change the duration in its third digit.
_ROUNDS = 40
# Full steps swing to and fro, as each interval's peak depends on its neighbours too.
_STEP = 0.5
# Places on each piece at which its speed is looked at while the intervals are sought.
_LOOKS = np.linspace(0.0, 1.0, 9)


def waypoints(
    points: npt.ArrayLike,
    max_speed: float,
    max_acceleration: float,
    *,
    heading: HeadingChoice = None,
) -> Trajectory:
    """Return a smooth path through waypoints, at rest at both ends, that keeps two limits.

    A cubic spline of time with continuous acceleration. The times between waypoints are balanced
    until each interval is as near to a limit as its neighbours let it be, and then all stretched
    by one factor so that the first of the limits is just attained::

        max |(x_d, y_d)| <= max_speed,    max |(x_dd, y_dd)| <= max_acceleration

    (tangential and normal acceleration together). It is not the fastest motion that there is.

    Args:
        points: (k, 2) [m], or (k, 3) with headings [rad].
        max_speed: of the point in the plane [m/s].
        max_acceleration: likewise [m/s^2].
        heading: "path", "lecture", a number [rad], one heading for each point, ``spin`` or
            ``profile``; if left out the points' own where they have them, otherwise "path".

    Raises:
        TrundleError: a value is not usable; the message says why.

    >>> path = waypoints([(0, 0), (2, 0), (2, 2)], max_speed=0.5, max_acceleration=0.4)
    >>> t = np.linspace(0.0, path.duration, 2001)
    >>> round(float(np.hypot(*path.velocity(t)[:, :2].T).max()), 4)
    0.5
    """
    array, heading = with_own_headings(points_array(points), heading)
    limits = (
        positive(max_speed, "max_speed", "m/s"),
        positive(max_acceleration, "max_acceleration", "m/s^2"),
    )
    chords = np.linalg.norm(np.diff(array[:, :2], axis=0), axis=1)
    if not chords.all():
        k = int(np.argmin(chords))
        x, y = array[k, :2]
        raise TrundleError(
            f"points {k + 1} and {k + 2} are both ({x:g}, {y:g}): leave one of them out, or give "
            "times (motion.via) to wait there"
        )
    times = _balanced(array[:, :2], chords, limits)
    pieces = clamped_spline(times, array)
    path = pieces.columns(0, 2)
    factor = max(_top_speed(path) / limits[0], math.sqrt(_top_acceleration(path) / limits[1]))
    return through(f"spline through {len(array)} waypoints", pieces.stretched(factor), heading)


def _balanced(points: Array, chords: Array, limits: tuple[float, float]) -> Array:
    """Return times (k,) between which all intervals are about equally near to a limit.

    An interval at f times the speed, or f^2 times the acceleration, that is allowed is made longer
    in proportion to f^(1/2), again and again; the shortest motion found on the way is kept.
    """
    intervals = chords / limits[0]
    best, least = intervals, math.inf
    for _ in range(_ROUNDS):
        curve = clamped_spline(np.append(0.0, np.cumsum(intervals)), points)
        over = _over(curve, limits)
        duration = float(over.max() * intervals.sum())
        if duration < least:
            best, least = over.max() * intervals, duration
        intervals = intervals * over**_STEP
    return np.append(0.0, np.cumsum(best))


def _over(curve: Pieces, limits: tuple[float, float]) -> Array:
    """Return by which factor (n,) each piece should be stretched to just keep the limits."""
    lengths = np.diff(curve.breaks)
    piece = np.repeat(np.arange(len(lengths)), len(_LOOKS))
    since = np.outer(lengths, _LOOKS).reshape(-1)
    sizes = np.linalg.norm(curve.at(piece, since, 3)[1:], axis=1)
    speed, acceleration = sizes.reshape(2, len(lengths), -1).max(axis=-1)
    return np.asarray(np.maximum(speed / limits[0], np.sqrt(acceleration / limits[1])))


def _top_speed(curve: Pieces) -> float:
    """Return the greatest speed of a cubic curve: at a break, or where V . A = 0 in a piece."""
    _, velocity, half, sixth = curve.coefficients
    slope = np.stack(  # of |V|^2 / 2, with A = 2 half + 6 sixth s
        [
            2 * _dot(velocity, half),
            4 * _dot(half, half) + 6 * _dot(velocity, sixth),
            18 * _dot(half, sixth),
            18 * _dot(sixth, sixth),
        ]
    )
    top = 0.0
    for k, length in enumerate(np.diff(curve.breaks).tolist()):
        found = np.roots(slope[::-1, k])
        inside = found.real[(found.real > 0) & (found.real < length)]
        since = np.concatenate([[0.0, length], inside])
        speeds = np.linalg.norm(curve.at(np.full(len(since), k), since, 2)[1], axis=0)
        top = max(top, float(speeds.max()))
    return top


def _top_acceleration(curve: Pieces) -> float:
    """Return the greatest acceleration of a cubic curve: at a break, for it is linear between."""
    last = np.diff(curve.breaks)[-1:]
    ends = curve.at(np.array([len(curve.breaks) - 2]), last, 3)[2]
    starts = 2 * curve.coefficients[2]
    return float(np.linalg.norm(np.concatenate([starts, ends], axis=1), axis=0).max())


def _dot(a: Array, b: Array) -> Array:
    return np.asarray((a * b).sum(axis=0))
