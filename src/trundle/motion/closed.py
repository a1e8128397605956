"""Closed curves: circle, ellipse, Lissajous figure, figure eight."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from trundle.errors import TrundleError
from trundle.motion.checks import positive, turning_rate
from trundle.motion.harmonics import Harmonics
from trundle.motion.headings import HeadingChoice, Spin
from trundle.motion.tangent import Tangent, tangent_of_harmonics
from trundle.motion.trajectory import Trajectory, with_heading

# Two rates whose ratio is one of whole numbers up to this have a period in common.
_MOST_TURNS = 200
# Rates given as decimal numbers have their ratio to this share.
_RATIO = 1e-12


def circle(
    radius: float,
    rate: float,
    *,
    heading: HeadingChoice = "path",
    duration: float | None = None,
) -> Trajectory:
    """Return a circle, ``x = r sin(w t)``, ``y = r - r cos(w t)``, at constant speed r |w|.

    Args:
        radius: r [m].
        rate: w [rad/s]; negative runs clockwise.
        heading: "path", "lecture", a number [rad], ``spin`` or ``profile``.
        duration: [s]; one turn if left out. The motion goes on after it.

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: the lectures' trajectory.

    >>> circle(2.0, 0.5).position([0.0, math.pi]).round(6).tolist()
    [[0.0, 0.0, 0.0], [2.0, 2.0, 1.570796]]
    """
    r, w = positive(radius, "radius", "m"), turning_rate(rate)
    start = 0.0 if w > 0 else math.pi
    curve = _lissajous(r, r, w, w, math.tau / abs(w))
    name = f"circle of radius {r:g} m at {w:g} rad/s"
    span = _span(curve, duration)
    return with_heading(name, curve, heading, span, lambda: Spin(start, w, along=True))


def ellipse(
    radius_x: float,
    radius_y: float,
    rate: float,
    *,
    heading: HeadingChoice = "path",
    duration: float | None = None,
) -> Trajectory:
    """Return an ellipse, ``x = r_x sin(w t)``, ``y = r_y - r_y cos(w t)``.

    Args:
        radius_x: half axis r_x [m].
        radius_y: half axis r_y [m].
        rate: w [rad/s]; negative runs clockwise.
        heading: "path", "lecture", a number [rad], ``spin`` or ``profile``.
        duration: [s]; one turn if left out. The motion goes on after it.

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: the lectures' trajectory.

    >>> ellipse(3.0, 2.0, 0.1).position(5 * math.pi).round(6).tolist()
    [3.0, 2.0, 1.570796]
    """
    r_x, r_y = positive(radius_x, "radius_x", "m"), positive(radius_y, "radius_y", "m")
    w = turning_rate(rate)
    curve = _lissajous(r_x, r_y, w, w, math.tau / abs(w))
    name = f"ellipse of half axes {r_x:g} m and {r_y:g} m at {w:g} rad/s"
    return _along(name, curve, None, heading, duration)


def lissajous(
    radius_x: float,
    radius_y: float,
    rate_x: float,
    rate_y: float,
    *,
    heading: HeadingChoice = "path",
    duration: float | None = None,
) -> Trajectory:
    """Return a Lissajous figure, ``x = r_x sin(w_x t)``, ``y = r_y - r_y cos(w_y t)``.

    Where it stands still and comes back the same way, as a parabola with w_y = 2 w_x does, the
    heading along the path stays smooth and the robot drives back backwards.

    Args:
        radius_x: r_x [m].
        radius_y: r_y [m].
        rate_x: w_x [rad/s].
        rate_y: w_y [rad/s].
        heading: "path", "lecture", a number [rad], ``spin`` or ``profile``.
        duration: [s]; the rates' common period if left out, after which the motion goes on. Rates
            without one need it, and their motion ends there.

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: the lectures' trajectory.

    >>> lissajous(3.0, 3.0, 0.2, 0.1).position(2.5 * math.pi).round(6).tolist()
    [3.0, 0.87868, 1.570796]
    """
    r_x, r_y = positive(radius_x, "radius_x", "m"), positive(radius_y, "radius_y", "m")
    w_x, w_y = turning_rate(rate_x, "rate_x"), turning_rate(rate_y, "rate_y")
    ratio = _ratio(w_x, w_y)
    if ratio is None and duration is None:
        raise TrundleError(
            f"rates {w_x:g} and {w_y:g} rad/s have no period in common of up to {_MOST_TURNS} "
            "turns: give a duration"
        )
    period = None if ratio is None else ratio.numerator * math.tau / abs(w_x)
    curve = _lissajous(r_x, r_y, w_x, w_y, period)
    direction = None if ratio is None else _through_reversals(r_x, r_y, w_x, w_y, ratio)
    name = f"Lissajous figure of {r_x:g} m and {r_y:g} m at {w_x:g} and {w_y:g} rad/s"
    return _along(name, curve, direction, heading, duration)


def figure_eight(
    length: float,
    rate: float,
    *,
    width: float | None = None,
    heading: HeadingChoice = "path",
    duration: float | None = None,
) -> Trajectory:
    """Return a figure eight, ``x = l/2 sin(w t)``, ``y = b/2 sin(2 w t)``, from its crossing.

    Args:
        length: l, along x [m].
        rate: w [rad/s].
        width: b, along y [m]; half the length if left out, so that it crosses at right angles.
        heading: "path", "lecture", a number [rad], ``spin`` or ``profile``.
        duration: [s]; one round if left out. The motion goes on after it.

    Raises:
        TrundleError: a value is not usable; the message says why.

    Source: the lemniscate of Gerono (Lawrence, A Catalog of Special Plane Curves, 1972).

    >>> figure_eight(4.0, 0.5).position([0.0, math.pi]).round(6).tolist()
    [[0.0, 0.0, 0.785398], [2.0, 0.0, -1.570796]]
    """
    l, w = positive(length, "length", "m"), turning_rate(rate)
    b = l / 2 if width is None else positive(width, "width", "m")
    curve = Harmonics(
        centre=np.zeros(2),
        rates=np.array([w, 2 * w]),
        sines=np.diag([l / 2, b / 2]),
        cosines=np.zeros((2, 2)),
        period=math.tau / abs(w),
    )
    return _along(
        f"figure eight of {l:g} m by {b:g} m at {w:g} rad/s", curve, None, heading, duration
    )


def _along(
    name: str,
    curve: Harmonics,
    direction: Harmonics | None,
    heading: HeadingChoice,
    duration: float | None,
) -> Trajectory:
    span = _span(curve, duration)

    def path() -> Tangent:
        return tangent_of_harmonics(curve, direction, span)

    return with_heading(name, curve, heading, span, path)


def _span(curve: Harmonics, duration: float | None) -> float:
    if duration is not None:
        return positive(duration, "duration", "s")
    assert curve.period is not None
    return curve.period


def _lissajous(r_x: float, r_y: float, w_x: float, w_y: float, period: float | None) -> Harmonics:
    if w_x == w_y:
        rates, x, y = [w_x], [r_x], [r_y]
    else:
        rates, x, y = [w_x, w_y], [r_x, 0.0], [0.0, r_y]
    zero = np.zeros(len(rates))
    return Harmonics(
        centre=np.array([0.0, r_y]),
        rates=np.array(rates),
        sines=np.array([x, zero]),
        cosines=np.array([zero, np.negative(y)]),
        period=period,
    )


def _ratio(w_x: float, w_y: float) -> Fraction | None:
    """Return |w_x / w_y| as a ratio of small whole numbers, or None where it is none."""
    exact = abs(w_x / w_y)
    near = Fraction(exact).limit_denominator(_MOST_TURNS)
    fits = 0 < near.numerator <= _MOST_TURNS and abs(near - exact) <= _RATIO * exact
    return near if fits else None


def _through_reversals(
    r_x: float, r_y: float, w_x: float, w_y: float, ratio: Fraction
) -> Harmonics | None:
    """Return the velocity divided by cos(a), a = |w_x| t / p, where it is zero with it; else None.

    With w_x / w_y = p / q in lowest terms, ``x_d = r_x w_x cos(p a)`` and
    ``y_d = r_y |w_y| sin(q a)`` are zero together only for odd p and even q, and only where
    cos(a) = 0. With m = (p - 1) / 2 and n = q / 2::

        cos(p a) / cos(a) = (-1)^m (1 + 2 sum_j (-1)^j cos(2 j a)),  j = 1 .. m
        sin(q a) / cos(a) = 2 sum_j (-1)^(n - j) sin((2 j - 1) a),   j = 1 .. n
    """
    p, q = ratio.numerator, ratio.denominator
    if p % 2 == 0 or q % 2 == 1:
        return None
    m, n = (p - 1) // 2, q // 2
    even, odd = np.arange(1, m + 1), np.arange(1, n + 1)
    x = r_x * w_x * (-1.0) ** m
    y = 2 * r_y * abs(w_y) * (-1.0) ** (n - odd)
    zero_even, zero_odd = np.zeros((2, m)), np.zeros((2, n))
    return Harmonics(
        centre=np.array([x, 0.0]),
        rates=np.concatenate([2 * even, 2 * odd - 1]) * abs(w_x) / p,
        sines=np.concatenate([zero_even, np.stack([0 * y, y])], axis=1),
        cosines=np.concatenate([np.stack([2 * x * (-1.0) ** even, 0.0 * even]), zero_odd], axis=1),
        period=p * math.tau / abs(w_x),
    )
