"""Robots that steer: from wheel speeds and steering angles to the twist, in scalars.

The side-slip rows of all wheels hold exactly, the rolling rows of the driven wheels in the
least-squares sense: ``W = N (A N)^+ R`` as everywhere else. Two independent side-slip rows leave
one motion, so that with S = C^T C and P = adj(S) / tr(adj S), the projector onto that motion::

    zeta = P A^T R omega / tr(P A^T A)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from trundle.errors import OffCentreError, TrundleError
from trundle.kinematics import (
    frame,
    mobility,
    off_centre_words,
    rolling_matrix,
    share_centre,
    side_slip_matrix,
)
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.motions import CHORDS, Values, make_move

# Constants of a wheel: its rolling and its side-slip row where it points straight, and its gain.
_PER_WHEEL = 7
# Angles whose rows leave a motion to fewer digits than these are looked at more closely: a tenth of
# the angle, squared, that still counts as a common centre.
_SUSPECT = 1e-14
# Squares of rim speeds along a motion, beside those of the strongest.
_STILL = 1e-12


@dataclass(frozen=True)
class Steered:
    """Wheel speeds and then steering angles take the robot along.

    Attributes:
        driven: for each wheel with constants, which wheel speed is its own; -1 for none.
        steered: likewise, which steering angle.
        held: whether the wheel resists side slip.
        speeds: how many wheel speeds a command has.
        method: how a step goes along its arc.
    """

    driven: tuple[int, ...]
    steered: tuple[int, ...]
    held: tuple[bool, ...]
    speeds: int
    method: str
    kept: ClassVar[int] = 3

    @property
    def constants(self) -> int:
        """How many constants the function takes: the step, half of it, and those of the wheels."""
        return 2 + _PER_WHEEL * len(self.driven)

    @property
    def arcs(self) -> bool:
        """Whether the function reads sinc."""
        return self.method == "exact"

    def make(self, m: Arithmetic, jit: Jit, compensated: bool) -> Function:
        """Return (state, command, constants) -> the new state, and half of the step's turn."""
        chord, move = CHORDS[self.method](m, jit), make_move(m, jit, compensated)
        sums = self._make_sums(0, m, jit)
        adjugate, trace = jit(_adjugate), jit(_trace)

        def step(state: Values, command: Values, constants: Values) -> tuple[Values, Any]:
            b, A, S = sums(command, constants)
            P = adjugate(S)
            xx, xy, xz, yy, yz, zz = P
            seen = trace(P, A)
            per = constants[0] / seen
            dx = per * (xx * b[0] + xy * b[1] + xz * b[2])
            dy = per * (xy * b[0] + yy * b[1] + yz * b[2])
            half = constants[1] / seen * (xz * b[0] + yz * b[1] + zz * b[2])
            a, b_ = chord(dx, dy, half)
            return move(state, a, b_, half), half

        return jit(step)

    def _make_sums(self, i: int, m: Arithmetic, jit: Jit) -> Function:
        """Return (command, constants) -> A^T R omega, A^T A (6) and C^T C (6) from wheel i on."""
        rows, products, add = self._make_rows(i, m, jit), jit(_products), jit(_add)
        drives, holds, driven = self.driven[i] >= 0, self.held[i], self.driven[i]
        gain, nothing = 2 + _PER_WHEEL * i + 6, (m.number(0),) * 6

        def own(command: Values, constants: Values) -> tuple[Values, Values, Values]:
            rolling, across = rows(command, constants)
            b, A, S = nothing[:3], nothing, nothing
            if drives:
                rim = constants[gain] * command[driven]
                b, A = (rolling[0] * rim, rolling[1] * rim, rolling[2] * rim), products(rolling)
            if holds:
                S = products(across)
            return b, A, S

        own = jit(own)
        if i + 1 == len(self.driven):
            return own
        later = self._make_sums(i + 1, m, jit)

        def with_later(command: Values, constants: Values) -> tuple[Values, Values, Values]:
            b, A, S = own(command, constants)
            more_b, more_A, more_S = later(command, constants)
            return (
                (b[0] + more_b[0], b[1] + more_b[1], b[2] + more_b[2]),
                add(A, more_A),
                add(S, more_S),
            )

        return jit(with_later)

    def _make_rows(self, i: int, m: Arithmetic, jit: Jit) -> Function:
        """Return (command, constants) -> rolling and side-slip row of wheel i where it points."""
        sin, cos = m.sin, m.cos
        r, s, angle = 2 + _PER_WHEEL * i, 2 + _PER_WHEEL * i + 3, self.speeds + self.steered[i]

        def straight(_: Values, k: Values) -> tuple[Values, Values]:
            return (k[r], k[r + 1], k[r + 2]), (k[s], k[s + 1], k[s + 2])

        def turned(command: Values, k: Values) -> tuple[Values, Values]:
            c, s_ = cos(command[angle]), sin(command[angle])
            return (
                (c * k[r] + s_ * k[s], c * k[r + 1] + s_ * k[s + 1], c * k[r + 2] + s_ * k[s + 2]),
                (c * k[s] - s_ * k[r], c * k[s + 1] - s_ * k[r + 1], c * k[s + 2] - s_ * k[r + 2]),
            )

        return jit(straight if self.steered[i] < 0 else turned)


# Symmetric matrices are their upper halves: xx, xy, xz, yy, yz, zz.


def _adjugate(S: Values) -> Values:
    a, b, c, d, e, f = S
    return (
        d * f - e * e, c * e - b * f, b * e - c * d, a * f - c * c, b * c - a * e, a * d - b * b,
    )  # fmt: skip


def _trace(P: Values, A: Values) -> Any:
    """Return the trace of a product."""
    both = P[1] * A[1] + P[2] * A[2] + P[4] * A[4]
    return P[0] * A[0] + P[3] * A[3] + P[5] * A[5] + (both + both)


def _products(row: Values) -> Values:
    x, y, z = row
    return x * x, x * y, x * z, y * y, y * z, z * z


def _add(a: Values, b: Values) -> Values:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


def steered_motion(robot: Robot, varied: Robot, dt: float, method: str) -> tuple[Steered, Array]:
    """Return how wheel speeds and angles move a robot, and the constants (k,) or (k, N) of that.

    Args:
        robot: the robot as described.
        varied: the same, in which some numbers may be arrays.
        dt: step [s].
        method: how a step goes along its arc.

    Raises:
        TrundleError: its wheels leave more than one motion at given angles.
    """
    if mobility(robot).degree != 1:
        raise TrundleError(
            f"robot {robot.name!r} has more than one motion at given steering angles: rollouts "
            "take twists of it, Constant(twist=...) or Stream(twist=...), not wheel speeds"
        )
    speed = {wheel.name: i for i, wheel in enumerate(robot.driven)}
    angle = {wheel.name: i for i, wheel in enumerate(robot.steered)}
    driven, steered, held, numbers = [], [], [], []
    for wheel in varied.wheels:
        rows = wheel.rows(0.0, np)
        if wheel.name not in speed and rows.side_slip is None:
            continue
        driven.append(speed.get(wheel.name, -1))
        steered.append(angle.get(wheel.name, -1))
        held.append(rows.side_slip is not None)
        none = (0.0, 0.0, 0.0)
        numbers += [*(rows.rolling or none), *(rows.side_slip or none), rows.gain]
    # Yaw is counted as the speed of the outermost wheel: numbers of one size in a float.
    length = robot.reach
    for i in range(0, len(numbers), _PER_WHEEL):
        numbers[i + 2], numbers[i + 5] = numbers[i + 2] / length, numbers[i + 5] / length
    table = np.stack(np.broadcast_arrays(dt, dt / 2 / length, *numbers))
    made = Steered(tuple(driven), tuple(steered), tuple(held), len(speed), method)
    return made, table


def _check_driven(robot: Robot, S: Array, driven: Array, angles: Array) -> None:
    """Refuse angles (s, N) at which no driven wheel rolls along the motion that they leave."""
    upper = np.triu_indices(3)
    A = np.swapaxes(driven, -1, -2) @ driven
    P, half_A = _adjugate(tuple(S[:, *upper].T)), tuple(A[:, *upper].T)
    along = _trace(P, half_A)
    most = (P[0] + P[3] + P[5]) * np.trace(A, axis1=-2, axis2=-1)
    if len(still := np.flatnonzero(along <= _STILL * most)):
        told = ", ".join(f"{angle:.6g}" for angle in np.degrees(angles[:, still[0]]))
        raise TrundleError(
            f"robot {robot.name!r}: at steering angles of {told} deg no driven wheel rolls along "
            "the motion that is left, so that the wheel speeds do not tell where it goes"
        )


def check_centres(robot: Robot, steering: Array) -> None:
    """Refuse steering angles (T, s, N) that share no centre, or leave what nothing drives.

    They are those of the robot as described; of robots that differ from it, the motion is the one
    that slips least.

    Raises:
        OffCentreError: some do not; the nearest that do are told.
    """
    here = frame(robot)
    for angles in steering:
        rows = side_slip_matrix(robot, robot.wheels, np.asarray(angles.T, dtype=np.float64)) @ here
        S = np.swapaxes(rows, -1, -2) @ rows
        driven = rolling_matrix(robot, robot.driven, angles.T.astype(np.float64)) @ here
        _check_driven(robot, S, driven, angles)
        # The least of three eigenvalues, where it is far below the others.
        least = np.linalg.det(S) / (np.trace(S, axis1=-2, axis2=-1) ** 2)
        for i in np.flatnonzero(least > _SUSPECT):
            if not share_centre(robot, np.asarray(angles[:, i], dtype=np.float64)):
                raise OffCentreError(off_centre_words(robot, np.asarray(angles[:, i])))
