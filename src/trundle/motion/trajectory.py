"""Trajectories: pose, velocity and acceleration as functions of time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from numbers import Real
from typing import final

import numpy as np
import numpy.typing as npt

from trundle.errors import TrundleError, did_you_mean
from trundle.kinematics import finite
from trundle.motion.checks import number, positive
from trundle.motion.curve import Curve, Heading
from trundle.motion.headings import Fixed, HeadingChoice, Lecture, Profile, Spin
from trundle.se2 import Array

# Times computed together: their arrays stay in the processor's cache.
_BLOCK = 8192
# Times beyond this [s] are looked at more closely.
_LATEST = 1e100


@final
@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A curve in the plane and a heading along it; the functions of ``trundle.motion`` make them.

    A trajectory is any value with ``position(t)``, ``velocity(t)`` and ``acceleration(t)``; this is
    one of them. Each takes a time and gives (3,), or times (T,) and gives (T, 3).

    Before 0 and after ``duration`` a curve that ends holds its end pose, at rest; a periodic one
    goes on.

    Attributes:
        name: what it is, for people.
        curve: x and y as functions of time.
        heading: psi as a function of time and the curve.
        duration: its length, a whole period for a periodic one unless it was given [s].

    >>> from trundle import motion
    >>> circle = motion.circle(radius=3.0, rate=0.1)
    >>> circle
    Trajectory(circle of radius 3 m at 0.1 rad/s, heading along the path, 62.83 s)
    >>> circle.velocity(0.0).tolist()
    [0.30000000000000004, 0.0, 0.1]
    """

    name: str
    curve: Curve
    heading: Heading
    duration: float

    def __repr__(self) -> str:
        return f"Trajectory({self.name}, heading {self.heading.words}, {self.duration:.4g} s)"

    @property
    def plain_heading(self) -> bool:
        """Whether the error of psi is a plain difference: with the lecture's policy only."""
        return self.heading.plain

    def position(self, t: npt.ArrayLike) -> Array:
        """Return x, y, psi (..., 3) in the inertial frame [m, m, rad] at times (...,) [s]."""
        return self._evaluate(t, 1)[0]

    def velocity(self, t: npt.ArrayLike) -> Array:
        """Return the first derivatives (..., 3) [m/s, m/s, rad/s] at times (...,) [s]."""
        return self._evaluate(t, 2)[1]

    def acceleration(self, t: npt.ArrayLike) -> Array:
        """Return the second derivatives (..., 3) [m/s^2, m/s^2, rad/s^2] at times (...,) [s].

        Where it leaps, as between two cubics, it has the value that it leaps to.
        """
        return self._evaluate(t, 3)[2]

    def sample(self, t: npt.ArrayLike) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration together, for little more than one of them.

        >>> from trundle import motion
        >>> position, velocity, acceleration = motion.circle(1.0, 1.0).sample([0.0, math.pi])
        >>> acceleration[0].round(9).tolist()
        [0.0, 1.0, 0.0]
        """
        position, velocity, acceleration = self._evaluate(t, 3)
        return position, velocity, acceleration

    def _evaluate(self, t: npt.ArrayLike, orders: int) -> tuple[Array, ...]:
        """Return the pose and so many derivatives, each (..., 3), at times (...,)."""
        times = _times(t)
        flat = times.reshape(-1)
        out = np.empty((orders, 3, flat.size))
        for first in range(0, flat.size, _BLOCK):
            block = slice(first, first + _BLOCK)
            self._fill(flat[block], out[:, :, block])
        return tuple(np.moveaxis(out.reshape(orders, 3, *times.shape), 1, -1))

    def _fill(self, t: Array, out: Array) -> None:
        orders = len(out)
        ends = self.curve.period is None
        inside = np.clip(t, 0.0, self.duration) if ends else t
        curve = self.curve.derivatives(inside, orders + self.heading.extra)
        out[:, :2] = curve[:orders]
        out[:, 2] = self.heading.angles(inside, curve, orders)
        if ends and (outside := inside != t).any():
            out[1:, :, outside] = 0.0

    def moved(self, x: float = 0.0, y: float = 0.0, psi: float = 0.0) -> Trajectory:
        """Return it turned by psi about the origin, then shifted by (x, y).

        Args:
            x: [m].
            y: [m].
            psi: [rad]; with the lecture's policy the heading is that of the turned path.

        >>> from trundle import motion
        >>> motion.line((0, 0), (1, 0), 2.0).moved(5, 0, math.pi / 2).position(2.0).round(
        ...     3
        ... ).tolist()
        [5.0, 1.0, 1.571]
        """
        x, y = number(x, "x", "m"), number(y, "y", "m")
        psi = number(psi, "psi", "rad")
        return replace(
            self,
            name=f"{self.name}, moved to ({x:g}, {y:g}) m and {math.degrees(psi):.4g} deg",
            curve=self.curve.moved(x, y, psi),
            heading=self.heading.turned(psi),
        )

    def stretched(self, factor: float) -> Trajectory:
        """Return the same path run through in ``factor`` times the time.

        Velocities are divided by the factor, accelerations by its square.

        >>> from trundle import motion
        >>> motion.circle(1.0, 1.0).stretched(2.0).velocity(0.0).tolist()
        [0.5, 0.0, 0.5]
        """
        factor = positive(factor, "factor", "")
        return replace(
            self,
            name=f"{self.name}, stretched {factor:g} times",
            curve=self.curve.stretched(factor),
            heading=self.heading.stretched(factor),
            duration=factor * self.duration,
        )


def _times(t: npt.ArrayLike) -> Array:
    """Return times as an array of finite floats; one that is such an array already, unchanged."""
    if not isinstance(t, np.ndarray) or t.dtype != np.float64 or not t.size:
        return finite(t, "t")
    # Any nan makes both nan.
    return t if t.min() >= -_LATEST and t.max() <= _LATEST else finite(t, "t")


def with_heading(
    name: str,
    curve: Curve,
    choice: HeadingChoice,
    duration: float,
    path: Callable[[], Heading],
) -> Trajectory:
    """Return a curve with the heading that was chosen; ``path`` makes that along the path.

    Raises:
        TrundleError: it is no heading.
    """
    heading: Heading
    if choice is None or (isinstance(choice, str) and choice == "path"):
        heading = path()
    elif isinstance(choice, str) and choice == "lecture":
        heading = Lecture.at_most(curve.speed_bound)
    elif isinstance(choice, Spin | Profile):
        heading = choice
    elif isinstance(choice, Real) and not isinstance(choice, bool):
        heading = Fixed(number(choice, "heading", "rad"))
    else:
        raise TrundleError(
            "heading must be 'path', 'lecture', a number [rad], or made by motion.spin or "
            f"motion.profile, got {choice!r}" + did_you_mean(choice, ("path", "lecture"))
        )
    return Trajectory(name, curve, heading, duration)
