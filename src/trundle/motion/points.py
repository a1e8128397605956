"""Trajectories through points at given times: line, quintic, cubics with via points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.motion.checks import numbers, points_array, positive, row, times_array
from trundle.motion.headings import HeadingChoice, Profile
from trundle.motion.pieces import Pieces
from trundle.motion.splines import clamped_spline, hermite, quintic_piece
from trundle.motion.standstill import tangent_of_pieces
from trundle.motion.trajectory import Trajectory, with_heading
from trundle.se2 import Array


def line(
    start: npt.ArrayLike,
    end: npt.ArrayLike,
    duration: float,
    *,
    heading: HeadingChoice = None,
) -> Trajectory:
    """Return a straight line from rest to rest.

    ``p = p_0 + (p_1 - p_0) (10 s^3 - 15 s^4 + 6 s^5)`` with s = t / duration. The speed peaks at
    15/8 of its mean, the acceleration at 5.774 lengths / duration^2.

    Args:
        start: (x, y) [m], or (x, y, psi) with a heading [rad].
        end: likewise; with headings it may be the same place, to turn on the spot.
        duration: [s].
        heading: "path", "lecture", a number [rad], one heading for each end, ``spin`` or
            ``profile``; if left out the ends' own where they have them, otherwise "path".

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: Flash and Hogan, The Coordination of Arm Movements, J. Neuroscience 5, 1985, eq. (2)
    (the minimum-jerk profile).

    >>> line((0, 0), (4, 0), 2.0).velocity([0.0, 1.0, 2.0])[:, 0].round(9).tolist()
    [0.0, 3.75, 0.0]
    """
    return quintic(start, end, duration, heading=heading)


def quintic(
    start: npt.ArrayLike,
    end: npt.ArrayLike,
    duration: float,
    *,
    start_velocity: npt.ArrayLike | None = None,
    end_velocity: npt.ArrayLike | None = None,
    start_acceleration: npt.ArrayLike | None = None,
    end_acceleration: npt.ArrayLike | None = None,
    heading: HeadingChoice = None,
) -> Trajectory:
    """Return the quintic polynomial with given position, velocity and acceleration at both ends.

    Args:
        start: (x, y) [m], or (x, y, psi) with a heading [rad].
        end: likewise.
        duration: [s].
        start_velocity: as many values as the start has [m/s, rad/s]; rest if left out.
        end_velocity: likewise.
        start_acceleration: as many values [m/s^2, rad/s^2]; 0 if left out.
        end_acceleration: likewise.
        heading: "path", "lecture", a number [rad], one heading for each end, ``spin`` or
            ``profile``; if left out the ends' own where they have them, otherwise "path".

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: Craig, Introduction to Robotics, 3rd edition, 2005, section 7.3.

    >>> curve = quintic((0, 0), (1, 1), 2.0, start_velocity=(1, 0), end_velocity=(0, 1))
    >>> curve.position([0.0, 1.0, 2.0]).round(4).tolist()
    [[0.0, 0.0, 0.0], [0.8125, 0.1875, 0.7854], [1.0, 1.0, 1.5708]]
    """
    span = positive(duration, "duration", "s")
    ends = _two_ends(start, end)
    points, heading = with_own_headings(ends, heading)
    width = points.shape[1]

    def given(values: npt.ArrayLike | None, name: str) -> Array:
        return np.zeros(width) if values is None else row(values, name, width)

    first = [
        given(start_velocity, "start_velocity"),
        given(start_acceleration, "start_acceleration"),
    ]
    last = [given(end_velocity, "end_velocity"), given(end_acceleration, "end_acceleration")]
    pieces = quintic_piece(span, np.array([points[0], *first]), np.array([points[1], *last]))
    still = not np.any([*first, *last])
    length = math.dist(points[0, :2], points[1, :2])
    name = f"line of {length:g} m" if still else "quintic between two points"
    return through(name, pieces, heading)


def cubic_via(
    points: npt.ArrayLike,
    times: npt.ArrayLike,
    via_velocity: npt.ArrayLike | None = None,
    *,
    heading: HeadingChoice = None,
) -> Trajectory:
    """Return two cubics, from rest at the first point through the via point to rest at the last.

    With a velocity at the via these are two separate cubics; without, velocity and acceleration
    are continuous there (the lecture's 8 x 8 system).

    Args:
        points: (3, 2) start, via and end [m], or (3, 3) with headings [rad].
        times: (3,) from 0 [s].
        via_velocity: as many values as a point has [m/s, rad/s]; zeros stop at the via.
        heading: "path", "lecture", a number [rad], one heading for each point, ``spin`` or
            ``profile``; if left out the points' own where they have them, otherwise "path".

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: the lectures' two cubics; Craig, 3rd edition, 2005, section 7.3.

    >>> points = [(0, 0), (2, 2), (0, 4)]
    >>> cubic_via(points, (0, 30, 60), via_velocity=(0, 0)).velocity(30.0)[:2].tolist()
    [0.0, 0.0]
    >>> cubic_via(points, (0, 30, 60)).velocity(30.0)[:2].round(9).tolist()
    [0.0, 0.1]
    """
    array = points_array(points)
    if len(array) != 3:
        raise ShapeError(f"points must be start, via and end, got {len(array)} points")
    at = numbers(times, "times")
    if at.shape == (3,) and at[0] < at[2] and not at[0] < at[1] < at[2]:
        raise TrundleError(
            f"the via at {at[1]:g} s lies outside the span from {at[0]:g} s to {at[2]:g} s"
        )
    array, heading = with_own_headings(array, heading)
    velocities = None
    if via_velocity is not None:
        velocities = np.zeros_like(array)
        velocities[1] = row(via_velocity, "via_velocity", array.shape[1])
    return via(array, at, velocities, heading=heading)


def via(
    points: npt.ArrayLike,
    times: npt.ArrayLike,
    velocities: npt.ArrayLike | None = None,
    *,
    heading: HeadingChoice = None,
) -> Trajectory:
    """Return cubics through any number of points at given times.

    With velocities these are separate cubics; without, velocity and acceleration are continuous
    and both ends at rest (the clamped cubic spline).

    Args:
        points: (k, 2) [m], or (k, 3) with headings [rad].
        times: (k,) from 0, growing [s].
        velocities: as many values as the points have [m/s, rad/s].
        heading: "path", "lecture", a number [rad], one heading for each point, ``spin`` or
            ``profile``; if left out the points' own where they have them, otherwise "path".

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: de Boor, A Practical Guide to Splines, 1978, chapter IV.

    >>> path = via([(0, 0), (1, 0), (1, 1), (2, 1)], times=[0, 2, 4, 6])
    >>> path.position([2.0, 4.0])[:, :2].tolist()
    [[1.0, 0.0], [1.0, 1.0]]
    """
    array, heading = with_own_headings(points_array(points), heading)
    at = times_array(times, len(array))
    if velocities is None:
        pieces = clamped_spline(at, array)
    else:
        slopes = numbers(velocities, "velocities")
        if slopes.shape != array.shape:
            raise ShapeError(
                f"velocities must have the shape of the points, {array.shape}, got {slopes.shape}"
            )
        pieces = hermite(at, array, slopes)
    return through(f"cubics through {len(array)} points", pieces, heading)


def through(name: str, pieces: Pieces, heading: HeadingChoice) -> Trajectory:
    """Return the trajectory of polynomials of x and y, or x, y and psi."""
    curve = pieces.columns(0, 2)
    if heading is None and pieces.coefficients.shape[1] == 3:
        heading = Profile(pieces.columns(2, 3))
    span = float(pieces.breaks[-1])
    return with_heading(name, curve, heading, span, lambda: tangent_of_pieces(curve))


def _two_ends(start: npt.ArrayLike, end: npt.ArrayLike) -> Array:
    first = numbers(start, "start")
    if first.shape not in ((2,), (3,)):
        raise ShapeError(f"start must be (x, y) or (x, y, psi), got shape {first.shape}")
    return np.array([first, row(end, "end", len(first))])


def with_own_headings(points: Array, heading: HeadingChoice) -> tuple[Array, HeadingChoice]:
    """Return the points with a sequence of headings, one for each, as their third column.

    Raises:
        ShapeError: there are not as many headings as points.
        TrundleError: both the points and ``heading`` give them.
    """
    if points.shape[1] == 3 and heading is not None:
        raise TrundleError("the points have headings: leave out heading=, or the third column")
    if not isinstance(heading, Sequence | np.ndarray) or isinstance(heading, str | Real):
        return points, heading
    angles = numbers(heading, "heading")
    if angles.shape != (len(points),):
        raise ShapeError(
            f"heading must have one value for each of the {len(points)} points, "
            f"got shape {angles.shape}"
        )
    return np.column_stack([points, angles]), None
