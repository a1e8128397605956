"""Headings other than along the path: fixed, spinning, a profile of its own, the lecture's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.motion.checks import number, numbers, times_array
from trundle.motion.pieces import Pieces
from trundle.motion.splines import clamped_spline
from trundle.se2 import Array

# Below this share of the greatest speed a direction is the rounding of a standstill.
_STANDSTILL = 1e-9


@final
@dataclass(frozen=True)
class Fixed:
    """One heading throughout [rad]."""

    angle: float
    extra: ClassVar[int] = 0
    plain: ClassVar[bool] = False

    @property
    def words(self) -> str:
        """What it is, for people."""
        return f"at {math.degrees(self.angle):.4g} deg"

    def angles(self, t: Array, curve: Array, orders: int) -> Array:
        """Return psi and its derivatives (orders, T) at times (T,)."""
        out = np.zeros((orders, len(t)))
        out[0] = self.angle
        return out

    def turned(self, psi: float) -> Fixed:
        """Return the heading along the curve turned by psi."""
        return Fixed(self.angle + psi)

    def stretched(self, factor: float) -> Fixed:
        """Return the heading run through in ``factor`` times the time."""
        return self


@final
@dataclass(frozen=True)
class Spin:
    """``psi = start + rate t`` [rad], [rad/s]."""

    start: float
    rate: float
    along: bool = False  # the path too
    extra: ClassVar[int] = 0
    plain: ClassVar[bool] = False

    @property
    def words(self) -> str:
        """What it is, for people."""
        return "along the path" if self.along else f"turning at {self.rate:g} rad/s"

    def angles(self, t: Array, curve: Array, orders: int) -> Array:
        """Return psi and its derivatives (orders, T) at times (T,)."""
        out = np.zeros((orders, len(t)))
        np.multiply(t, self.rate, out=out[0])
        out[0] += self.start
        out[1:2] = self.rate
        return out

    def turned(self, psi: float) -> Spin:
        """Return the heading along the curve turned by psi."""
        return replace(self, start=self.start + psi)

    def stretched(self, factor: float) -> Spin:
        """Return the heading run through in ``factor`` times the time."""
        return replace(self, rate=self.rate / factor)


@final
@dataclass(frozen=True, eq=False)
class Profile:
    """A heading of its own: a piecewise polynomial of time, held before and after its span."""

    pieces: Pieces
    extra: ClassVar[int] = 0
    plain: ClassVar[bool] = False
    words: ClassVar[str] = "by its own profile"

    def __repr__(self) -> str:
        breaks = self.pieces.breaks
        return f"Profile({len(breaks)} headings over {breaks[-1]:g} s)"

    def angles(self, t: Array, curve: Array, orders: int) -> Array:
        """Return psi and its derivatives (orders, T) at times (T,)."""
        inside = np.clip(t, 0.0, self.pieces.breaks[-1])
        out = self.pieces.derivatives(inside, orders)[:, 0]
        out[1:, inside != t] = 0.0
        return out

    def turned(self, psi: float) -> Profile:
        """Return the heading along the curve turned by psi."""
        return Profile(self.pieces.raised(psi))

    def stretched(self, factor: float) -> Profile:
        """Return the heading run through in ``factor`` times the time."""
        return Profile(self.pieces.stretched(factor))


@final
@dataclass(frozen=True)
class Lecture:
    """The lecture's policy, which jumps: by name, to reproduce its numbers.

    ``psi = atan2(y_d, x_d)`` in [0, 2 pi), ``psi_d = (x_d y_dd - y_d x_dd) / (x_d^2 + y_d^2)``,
    both 0 at standstill; ``psi_dd = 0``. The controller takes the plain difference of headings.

    Attributes:
        standstill: speeds below it are the rounding of zero [m/s].
    """

    standstill: float
    extra: ClassVar[int] = 1
    plain: ClassVar[bool] = True
    words: ClassVar[str] = "by the lecture's policy"

    @classmethod
    def at_most(cls, speed: float) -> Lecture:
        """Return the policy for a curve that nowhere exceeds a speed [m/s]."""
        return cls(_STANDSTILL * speed)

    def angles(self, t: Array, curve: Array, orders: int) -> Array:
        """Return psi and its derivatives (orders, T) at times (T,)."""
        out = np.zeros((orders, len(t)))
        x, y = curve[1]
        size = x * x + y * y
        moves = size > self.standstill**2
        psi = np.arctan2(y, x)
        psi = np.where(psi < 0, psi + math.tau, psi)
        # A tiny negative angle rounds to a whole turn.
        out[0] = np.where(moves & (psi < math.tau), psi, 0.0)
        if orders > 1:
            turning = x * curve[2, 1] - y * curve[2, 0]
            np.divide(turning, size, out=out[1], where=moves)
        return out

    def turned(self, psi: float) -> Lecture:
        """Return the heading along the curve turned by psi."""
        return self

    def stretched(self, factor: float) -> Lecture:
        """Return the heading run through in ``factor`` times the time."""
        return Lecture(self.standstill / factor)


# What ``heading=`` takes; None is the points' own headings where they have some, else "path".
HeadingChoice = str | float | Sequence[float] | Array | Spin | Profile | None


def spin(rate: float, start: float = 0.0) -> Spin:
    """Return a heading that turns at a constant rate, ``psi = start + rate t``.

    Args:
        rate: [rad/s], counter-clockwise positive.
        start: heading at t = 0 [rad].

    Raises:
        TrundleError: one of them is no finite number.

    >>> from trundle import motion
    >>> motion.circle(1.0, 0.5, heading=motion.spin(-0.5)).position(2.0).round(3).tolist()
    [0.841, 0.46, -1.0]
    """
    return Spin(number(start, "start", "rad"), number(rate, "rate", "rad/s"))


def profile(times: npt.ArrayLike, angles: npt.ArrayLike) -> Profile:
    """Return a heading that takes given angles at given times.

    A cubic spline with continuous psi_d and psi_dd, at rest at both ends and held beyond them.

    Args:
        times: (k,) from 0, growing [s].
        angles: (k,) [rad]; they are not wrapped: from 0 to 4 pi are two turns.

    Raises:
        TrundleError: they are no such arrays.

    >>> from trundle import motion
    >>> turn = motion.profile([0, 5, 10], [0, 1, 0])
    >>> motion.circle(1.0, 0.5, heading=turn).position([0, 2.5, 5])[:, 2].round(9).tolist()
    [0.0, 0.5, 1.0]
    """
    values = numbers(angles, "angles")
    if values.ndim != 1 or len(values) < 2:
        raise ShapeError(f"angles must be two or more headings (k,), got shape {values.shape}")
    at = times_array(times, len(values))
    return Profile(clamped_spline(at, values[:, None]))
