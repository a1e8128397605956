"""What a trajectory is joined from: a curve in the plane, and a heading along it."""

from __future__ import annotations

from typing import Protocol

from trundle.se2 import Array


class Curve(Protocol):
    """A curve in the plane as a function of time, with all its derivatives."""

    @property
    def period(self) -> float | None:
        """Time after which it repeats itself [s]; None for a curve that ends."""

    @property
    def speed_bound(self) -> float:
        """A speed that it nowhere exceeds [m/s]."""

    def derivatives(self, t: Array, count: int) -> Array:
        """Return position, velocity and so on (count, 2, T) at times (T,)."""

    def moved(self, x: float, y: float, psi: float) -> Curve:
        """Return the curve turned by psi about the origin, then shifted by (x, y)."""

    def stretched(self, factor: float) -> Curve:
        """Return the curve run through in ``factor`` times the time."""


class Heading(Protocol):
    """A heading as a function of time, which may follow the curve's derivatives."""

    @property
    def extra(self) -> int:
        """How many more derivatives of the curve it needs than of itself are asked."""

    @property
    def plain(self) -> bool:
        """Whether its error is taken as a plain difference, as in the lecture."""

    @property
    def words(self) -> str:
        """What it is, for people."""

    def angles(self, t: Array, curve: Array, orders: int) -> Array:
        """Return psi and its derivatives (orders, T) at times (T,).

        ``curve`` holds the derivatives (orders + extra, 2, T) of the curve there.
        """

    def turned(self, psi: float) -> Heading:
        """Return the heading along the curve turned by psi."""

    def stretched(self, factor: float) -> Heading:
        """Return the heading run through in ``factor`` times the time."""
