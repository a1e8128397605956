"""How a body follows wheels that roll and slip as they like: least squares in plain floats."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.kinematics import (
    Kinematics,
    frame,
    gains,
    motion_projector,
    rolling_matrix,
    side_slip_matrix,
)
from trundle.robot import BallWheel, Robot, RollingWheel
from trundle.se2 import Array

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

# Normal equations whose determinant is this small beside their size leave a motion open to
# rounding, as a front wheel that stands across a bicycle does.
_OPEN = 1e-13
_RANK = 1e-12


class Standing(NamedTuple):
    """A robot at given steering angles: how it moves with its wheels, and they with it.

    Attributes:
        columns: body increment for 1 rad of each driven wheel, then for 1 m of each steered
            wheel's slip to its left.
        sensed: (u, v, r) -> wheel speed [rad/s] of each sensed wheel.
        steered: (u, v, r) -> contact velocity of each steered wheel, along and across its zero.
    """

    columns: Sequence[Vector]
    sensed: Sequence[Vector]
    steered: Sequence[tuple[Vector, Vector]]

    def increment(self, turned: Sequence[float], slipped: Sequence[float] = ()) -> Vector:
        """Return the body increment (dx, dy, dpsi) [m, m, rad].

        Args:
            turned: (n) turn of the driven wheels that the ground feels [rad].
            slipped: (s) what the steered wheels slip to their left [m]; default: nothing.
        """
        dx = dy = dpsi = 0.0
        for amount, (u, v, r) in zip((*turned, *slipped), self.columns, strict=False):
            dx, dy, dpsi = dx + amount * u, dy + amount * v, dpsi + amount * r
        return dx, dy, dpsi

    def rolled(self, moved: Vector) -> list[float]:
        """Return how far (k) the sensed wheels roll along with a body increment [rad]."""
        return [_dot(row, moved) for row in self.sensed]

    def travels(self, moved: Vector) -> list[float]:
        """Return how far (s) the contacts of the steered wheels travel in a body increment [m]."""
        return [math.hypot(_dot(a, moved), _dot(b, moved)) for a, b in self.steered]


class Ground:
    """The body's motion from what the driven wheels turn and the steered ones slip sideways.

    Fixed wheels' side slip is zero; the other rows hold in the least-squares sense with weight 1,
    as in ``Kinematics.forward``: steering angles need share no centre. Motions that no row tells
    do not happen.

    Args:
        robot: the robot.

    >>> from trundle import load
    >>> standing = Ground(load("tricycle", radius=0.1, wheelbase=0.8)).at((0.0,))
    >>> [round(d, 9) + 0.0 for d in standing.increment([1.0], [0.02])]  # 1 rad, 2 cm to the left
    [0.1, 0.0, 0.025]
    """

    def __init__(self, robot: Robot) -> None:
        straight = np.zeros(len(robot.steered))
        along = _rows(rolling_matrix(robot, robot.steered, straight))
        across = _rows(side_slip_matrix(robot, robot.steered, straight))
        self._steered = tuple(zip(along, across, strict=True))
        self._driven = _wheels(robot, robot.driven)
        self._sensed = _wheels(robot, robot.sensed)
        self._still: Standing | None = None
        if robot.steered:
            self._space = _rows(_motions(robot))
            self._unused = tuple(
                float(not any(column)) for column in zip(*self._space, strict=True)
            )
        else:
            sensed = [_scaled(1.0 / wheel.gain, wheel.row) for wheel in self._sensed]
            # The bound function's coefficients are rid of rounding: equal wheels go straight.
            forward = Kinematics(robot).bind().forward
            units = np.eye(len(robot.driven)).tolist()
            columns = _rows(np.array([forward(*unit) for unit in units]).reshape(-1, 3))
            self._still = Standing(columns, sensed, ())

    def at(self, steering: Sequence[float]) -> Standing:
        """Return the robot at steering angles (s) [rad]."""
        if self._still is not None:
            return self._still
        rolling, slipping = [], []
        for angle, (along, across) in zip(steering, self._steered, strict=True):
            c, s = math.cos(angle), math.sin(angle)
            rolling.append(_sum(c, along, s, across))
            slipping.append(_sum(c, across, -s, along))
        driven = [rolling[wheel.place] if wheel.place >= 0 else wheel.row for wheel in self._driven]
        told = [self._inside(row) for row in (*driven, *slipping)]
        inverse = self._solved(told)
        columns = [self._outside(_times(inverse, row)) for row in told]
        for i, wheel in enumerate(self._driven):
            columns[i] = _scaled(wheel.gain, columns[i])
        sensed = [
            _scaled(1.0 / wheel.gain, rolling[wheel.place] if wheel.place >= 0 else wheel.row)
            for wheel in self._sensed
        ]
        return Standing(columns, sensed, self._steered)

    def _inside(self, row: Vector) -> Vector:
        """Return a row over the allowed motions' coordinates."""
        (p, q, s), (a, b, c) = row, self._space
        return (
            p * a[0] + q * b[0] + s * c[0],
            p * a[1] + q * b[1] + s * c[1],
            p * a[2] + q * b[2] + s * c[2],
        )

    def _outside(self, x: Vector) -> Vector:
        """Return the twist with such coordinates."""
        return _times(self._space, x)

    def _solved(self, rows: Sequence[Vector]) -> Matrix:
        """Return the inverse of the rows' normal equations; unused coordinates stand alone."""
        a, d, f = self._unused
        b = c = e = 0.0
        for p, q, s in rows:
            a, b, c, d, e, f = a + p * p, b + p * q, c + p * s, d + q * q, e + q * s, f + s * s
        x, y, z = d * f - e * e, c * e - b * f, b * e - c * d
        det = a * x + b * y + c * z
        if det <= _OPEN * (a + d + f) ** 3:
            normal = np.array([[a, b, c], [b, d, e], [c, e, f]])
            first, second, third = _rows(np.linalg.pinv(normal, _RANK, hermitian=True))
            return first, second, third
        x, y, z, w = x / det, y / det, z / det, (b * c - a * e) / det
        return (x, y, z), (y, (a * f - c * c) / det, w), (z, w, (a * d - b * b) / det)


class _Wheel(NamedTuple):
    row: Vector  # the rolling row, at steering angle 0
    gain: float  # rim speed along it for one rad/s [m]
    place: int  # among the steered wheels, or -1


def _wheels(robot: Robot, wheels: Sequence[RollingWheel]) -> tuple[_Wheel, ...]:
    straight = np.zeros(len(robot.steered))
    places = {wheel.name: i for i, wheel in enumerate(robot.steered)}
    return tuple(
        _Wheel(row, gain, places.get(wheel.name, -1))
        for row, gain, wheel in zip(
            _rows(rolling_matrix(robot, wheels, straight)),
            gains(wheels).tolist(),
            wheels,
            strict=True,
        )
    )


def _motions(robot: Robot) -> Array:
    """Return a basis (3, 3) of the twists that the wheels without steering allow; zeros last.

    Its coordinates are alike in size for robots of any size.
    """
    rigid = [wheel for wheel in robot.wheels if not wheel.steers]
    loose = BallWheel(name="\0", x=0.0, y=0.0)  # a robot needs a wheel
    allowed, _ = motion_projector(Robot(name="rigid", wheels=(*rigid, loose)), np.zeros(0))
    here = frame(robot)
    span, size, _ = np.linalg.svd(np.linalg.solve(here, allowed))
    return here @ np.where(size > _RANK * size[0], span, 0.0)


def _rows(matrix: npt.NDArray[np.floating[Any]]) -> tuple[Vector, ...]:
    return tuple((row[0], row[1], row[2]) for row in matrix.tolist())


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _times(matrix: Sequence[Vector], x: Vector) -> Vector:
    a, b, c = matrix
    return _dot(a, x), _dot(b, x), _dot(c, x)


def _scaled(factor: float, row: Vector) -> Vector:
    return factor * row[0], factor * row[1], factor * row[2]


def _sum(c: float, a: Vector, s: float, b: Vector) -> Vector:
    return c * a[0] + s * b[0], c * a[1] + s * b[1], c * a[2] + s * b[2]
