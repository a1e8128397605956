"""Regions of the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any

from trundle.errors import TrundleError
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.motions import Values


@dataclass(frozen=True)
class Disc:
    """All points within a distance of a centre; the border belongs to it.

    Attributes:
        x: centre, in the inertial frame [m].
        y: the same.
        radius: distance [m].

    Raises:
        TrundleError: a number is not finite, or the radius is not positive.

    >>> Disc(0.0, 0.0, -1.0)
    Traceback (most recent call last):
    trundle.errors.TrundleError: Disc: radius must be positive, got -1.0
    """

    x: float
    y: float
    radius: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        _check_finite(self)
        if self.radius <= 0:
            raise TrundleError(f"Disc: radius must be positive, got {self.radius}")

    @property
    def numbers(self) -> list[float]:
        """The numbers that the function takes."""
        return [self.x, self.y, self.radius]

    @staticmethod
    def make_outside(m: Arithmetic, jit: Jit) -> Function:  # noqa: ARG004
        """Return (x, y, numbers) -> a number that is positive outside."""

        def outside(x: Any, y: Any, numbers: Values) -> Any:
            dx, dy = x - numbers[0], y - numbers[1]
            return dx * dx + dy * dy - numbers[2] * numbers[2]

        return jit(outside)


@dataclass(frozen=True)
class Box:
    """All points between two values of x and two values of y; the border belongs to it.

    Attributes:
        x_min: smallest x, in the inertial frame [m].
        x_max: largest x.
        y_min: smallest y.
        y_max: largest y.

    Raises:
        TrundleError: a number is not finite, or a smallest one is not below the largest.

    >>> Box(-1.0, 1.0, 0.0, 4.0).y_max
    4.0
    """

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        _check_finite(self)
        for axis, low, high in (("x", self.x_min, self.x_max), ("y", self.y_min, self.y_max)):
            if low >= high:
                raise TrundleError(
                    f"Box: {axis}_min must be below {axis}_max, got {low} and {high}"
                )

    @property
    def numbers(self) -> list[float]:
        """The numbers that the function takes."""
        return [self.x_min, self.x_max, self.y_min, self.y_max]

    @staticmethod
    def make_outside(m: Arithmetic, jit: Jit) -> Function:
        """Return (x, y, numbers) -> a number that is positive outside."""
        maximum = m.maximum

        def outside(x: Any, y: Any, numbers: Values) -> Any:
            beside = maximum(numbers[0] - x, x - numbers[1])
            return maximum(beside, maximum(numbers[2] - y, y - numbers[3]))

        return jit(outside)


Region = Disc | Box


def _check_finite(region: Region) -> None:
    for field in fields(region):
        value = getattr(region, field.name)
        if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
            raise TrundleError(
                f"{type(region).__name__}: {field.name} must be a finite number, got {value!r}"
            )
