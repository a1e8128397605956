"""The heading along a path's tangent, with its true derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from trundle.motion.curve import Curve
from trundle.motion.harmonics import Harmonics
from trundle.motion.pieces import Indices
from trundle.motion.sections import Complex, sections, unwrapped
from trundle.se2 import Array


@final
@dataclass(frozen=True, eq=False)
class Tangent:
    """``psi = atan2(u_y, u_x)``, unwrapped, of a vector u along the path that is nowhere zero.

    u is the velocity, or the velocity divided by what makes it zero at a standstill, so that
    nothing is 0/0 there::

        psi_d  = (u_x u_y' - u_y u_x') / |u|^2
        psi_dd = (u_x u_y'' - u_y u_x'') / |u|^2 - 2 psi_d (u . u') / |u|^2

    Attributes:
        direction: u as a curve; None for the velocity of the curve itself.
        starts: (m,) where sections begin in which u stays in a half-plane [s].
        near: (m,) unwrapped angle of u in each section, within pi/2 [rad].
        period: time after which u repeats itself [s], or None.
        turn: angle that it has gained by then: a whole number of turns [rad].
    """

    direction: Curve | None
    starts: Array
    near: Array
    period: float | None = None
    turn: float = 0.0
    extra: ClassVar[int] = 1
    plain: ClassVar[bool] = False
    words: ClassVar[str] = "along the path"

    def angles(self, t: Array, curve: Array, orders: int) -> Array:
        """Return psi and its derivatives (orders, T) at times (T,)."""
        if self.direction is None:
            along = curve[1 : 1 + orders]
        else:
            along = self.direction.derivatives(t, orders)
        out = np.empty((orders, len(t)))
        psi = np.arctan2(along[0, 1], along[0, 0], out=out[0])
        turns = self._reference(t)
        turns -= psi
        turns *= 1 / math.tau
        psi += math.tau * np.rint(turns, out=turns)
        if orders > 1:
            size = _dot(along[0], along[0])
            out[1] = _cross(along[0], along[1]) / size
            if orders > 2:
                bend = _cross(along[0], along[2])
                out[2] = (bend - 2 * out[1] * _dot(along[0], along[1])) / size
        return out

    def _reference(self, t: Array) -> Array:
        """Return the unwrapped angle (T,) within pi/2."""
        turned: Array | float = 0.0
        if self.period is not None:
            cycle = np.floor(t * (1 / self.period))
            t = t - cycle * self.period
            turned = cycle * self.turn
        section = np.maximum(np.searchsorted(self.starts, t, side="right") - 1, 0)
        return np.take(self.near, section) + turned

    def turned(self, psi: float) -> Tangent:
        """Return the heading along the curve turned by psi."""
        direction = None if self.direction is None else self.direction.moved(0.0, 0.0, psi)
        return replace(self, direction=direction, near=self.near + psi)

    def stretched(self, factor: float) -> Tangent:
        """Return the heading run through in ``factor`` times the time."""
        return replace(
            self,
            direction=None if self.direction is None else self.direction.stretched(factor),
            starts=factor * self.starts,
            period=None if self.period is None else factor * self.period,
        )


def tangent_of_harmonics(curve: Harmonics, direction: Harmonics | None, duration: float) -> Tangent:
    """Return the heading along a curve of harmonics.

    Args:
        curve: the curve.
        direction: its velocity, divided by what makes it zero; None where it is nowhere zero.
        duration: how long a curve without a period is followed [s].
    """
    along = curve.velocity() if direction is None else direction

    def vector(t: Array, _: Indices) -> Complex:
        found = along.derivatives(t, 2)
        return np.asarray(found[:, 0] + 1j * found[:, 1])

    span = duration if curve.period is None else curve.period
    found = sections(vector, np.array([along.acceleration_bound]), np.array([0.0, span]))
    angles, _ = unwrapped(vector, found)
    turn = 0.0
    if curve.period is not None:
        # Both ends of a period have the same direction.
        gained = angles[-1] - angles[0]
        turn = math.tau * round(gained / math.tau)
    return Tangent(direction, found.start, angles, curve.period, turn)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1])
