"""Where one frame of a URDF stands in another."""

from __future__ import annotations

import math
from typing import NamedTuple

Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]

UP: Vector = (0.0, 0.0, 1.0)


class Pose(NamedTuple):
    """A frame in another: p = rotation p' + place.

    ``yaw`` is the angle of a rotation about the z axis alone, as it was written, and None of any
    other: an angle that has gone through cosine and sine is rounded, and has lost its full turns.
    """

    rotation: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    place: Vector = (0.0, 0.0, 0.0)
    yaw: float | None = 0.0

    def turn(self, vector: Vector) -> Vector:
        """Return a vector of the inner frame in the outer one."""
        first, second, third = (dot(row, vector) for row in self.rotation)
        return first, second, third

    def at(self, point: Vector) -> Vector:
        """Return a point of the inner frame in the outer one."""
        return plus(self.turn(point), self.place)

    def then(self, inner: Pose) -> Pose:
        """Return a frame given in the inner frame, in the outer one."""
        columns = [self.turn(column) for column in zip(*inner.rotation, strict=True)]
        rows = tuple(zip(*columns, strict=True))
        yaw = None if self.yaw is None or inner.yaw is None else self.yaw + inner.yaw
        return Pose(rows, self.at(inner.place), yaw)  # type: ignore[arg-type]


def pose(xyz: Vector, rpy: Vector) -> Pose:
    """Return the frame of an ``<origin>``: R = Rz(yaw) Ry(pitch) Rx(roll).

    >>> pose((1.0, 0.0, 0.0), (0.0, 0.0, 0.5)).yaw
    0.5
    """
    (cr, cp, cy), (sr, sp, sy) = map(math.cos, rpy), map(math.sin, rpy)
    rotation = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    return Pose(rotation, xyz, rpy[2] if rpy[:2] == (0.0, 0.0) else None)


def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def times(factor: float, a: Vector) -> Vector:
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


def unit(a: Vector) -> Vector | None:
    """Return a / |a|, or None for zero."""
    most = max(map(abs, a))
    if most == 0:
        return None
    scaled = (a[0] / most, a[1] / most, a[2] / most)  # so that no square overflows
    return times(1 / math.hypot(*scaled), scaled)
