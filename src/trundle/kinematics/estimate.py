"""The estimate of the twist from wheels that turn, and its covariance, in straight lines.

With N a basis of the twists that fixed wheels' side slip leaves, the twist N z solves the normal
equations ``H z = b``, ``H = N^T M^T M N``, ``b = N^T M^T y``, with rolling rows and steered wheels'
side-slip rows in M, and rim speeds and zeros in y. A steered wheel at angle q has the rows
``cos q A + sin q B`` and ``cos q B - sin q A``: where its turning is measured, both are in M, and
together they give ``A^T A + B^T B`` at every angle. Only steered wheels whose turning is not
measured, here called loose, make H depend on the angles.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trundle.errors import TrundleError
from trundle.kinematics.constraints import (
    frame,
    gains,
    rolling_matrix,
    side_slip_matrix,
    skid_matrices,
)
from trundle.kinematics.linear import null_projector, pseudo_inverse
from trundle.kinematics.maps import holding_rows
from trundle.kinematics.normal import Entries, full_rank_rows, least_minors, normal_inverse
from trundle.kinematics.straight import Code
from trundle.robot import Robot, RollingWheel
from trundle.se2 import Array

# Entries this small in unit vectors are rounding.
_ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class Estimate:
    """How a robot's twist follows from the turning of some wheels: what its program is made of.

    Attributes:
        gains: (k,) of the measured wheels.
        angle: for each measured wheel, which steering angle is its own; None for none.
        basis: N (3, m), orthonormal.
        rows: (p, 3) constant rows: of each measured wheel its rolling row, or A and B in turn.
        loose: which steering angles are those of loose wheels.
        along: A (s, 3) of the steered wheels.
        across: B (s, 3) of the steered wheels.
        inverse: N (M N)^+ (3, p) for the constant rows alone.
        reduced: (q, m) rows of full rank with the same normal matrix as ``rows @ basis``.
        least: the bounds of ``normal_inverse``.
    """

    gains: Array
    angle: tuple[int | None, ...]
    basis: Array
    rows: Array
    loose: tuple[int, ...]
    along: Array
    across: Array
    inverse: Array
    reduced: Array
    least: tuple[float, ...]

    @classmethod
    def of(cls, robot: Robot, wheels: Sequence[RollingWheel]) -> Estimate:
        """Return the estimate from these wheels.

        Raises:
            TrundleError: how the robot's skidding wheels turn depends on its steering angles.
        """
        straight, here = np.zeros(len(robot.steered)), frame(robot)
        check_skid(robot)
        held, tolerance = holding_rows(robot, straight, exact=False)
        allowed, count = null_projector(held, tolerance, here)
        basis = _tidy_basis(allowed, 3 - int(count))
        along = rolling_matrix(robot, robot.steered, straight)
        across = side_slip_matrix(robot, robot.steered, straight)
        order = {wheel.name: i for i, wheel in enumerate(robot.steered)}
        angle = tuple(order.get(wheel.name) for wheel in wheels)
        rolling = rolling_matrix(robot, wheels, straight)
        rows = [
            rolling[i : i + 1] if j is None else np.stack([along[j], across[j]])
            for i, j in enumerate(angle)
        ]
        constant = np.concatenate([np.zeros((0, 3)), *rows])
        _, seen = null_projector(np.concatenate([held, constant]), tolerance, here)
        inverse, _ = pseudo_inverse(constant @ basis @ basis.T, np.asarray(seen - count))
        inverse = basis @ (basis.T @ inverse)
        loose = tuple(i for i in range(len(robot.steered)) if i not in angle)
        turning = np.concatenate([each[list(loose)] for each in (along, across)])
        return cls(
            gains=gains(wheels),
            angle=angle,
            basis=basis,
            rows=constant,
            loose=loose,
            along=along,
            across=across,
            inverse=inverse,
            reduced=full_rank_rows(constant @ basis, int(seen - count)),
            least=least_minors(constant, turning, basis, here),
        )

    @property
    def constant(self) -> bool:
        """Whether the map is constant, but for the angles of measured wheels."""
        return not self.loose or not len(self.reduced)

    def twist(self, code: Code, turns: Sequence[str], angles: Sequence[str]) -> list[str]:
        """Return expressions for the twist, or for the body's increment.

        Args:
            code: where the lines go.
            turns: names of the measured wheels' speeds, or of their increments.
            angles: names of all steering angles.
        """
        names = self.measured(code, turns, angles)
        if self.constant:
            return code.linear(self.inverse * self.factors, names)
        known = self.basis.T @ self.rows.T * self.factors
        b = [code.name(each) for each in code.linear(known, names)]
        H = self.normal_inverse(code, angles)
        k = range(len(b))
        z = [code.sum(*(code.product(H[i, j], b[j]) for j in k)) for i in k]
        return code.linear(self.basis, z)

    @property
    def factors(self) -> Array:
        """The gains (p,) of the constant rows."""
        return np.repeat(self.gains, [1 if j is None else 2 for j in self.angle])

    def measured(self, code: Code, turns: Sequence[str], angles: Sequence[str]) -> list[str]:
        """Return names of what the constant rows measure [rad], before their gains."""
        names = []
        for turn, j in zip(turns, self.angle, strict=True):
            directions = [] if j is None else turned(code, angles[j])
            names += [code.product(each, turn) for each in directions] or [turn]
        return names

    def covariance(
        self, code: Code, rolling: Sequence[str], slip: Sequence[str], angles: Sequence[str]
    ) -> list[str]:
        """Return expressions for the six entries uu, uv, ur, vv, vr, rr of the twist's covariance.

        Args:
            code: where the lines go.
            rolling: names of the variances of the measured wheels' rim speeds, or increments.
            slip: names of the variances of all steered wheels' side slip.
            angles: names of all steering angles.
        """
        rows = self.inverse.T if self.constant else self.rows @ self.basis
        variances, parts, at = [], [], 0
        for variance, j in zip(rolling, self.angle, strict=True):
            variances += [variance] if j is None else _spread(code, variance, slip[j], angles[j])
            parts += [_squares(rows[at])] if j is None else _mixed(rows[at], rows[at + 1])
            at += 1 if j is None else 2
        if self.constant:
            return code.linear(np.array(parts).reshape(-1, 6).T, variances)
        for j in self.loose:
            variances += _spread(code, "0.0", slip[j], angles[j])
            parts += _mixed(self.along[j] @ self.basis, self.across[j] @ self.basis)
        return self._sandwich(
            code, [code.name(x) for x in code.linear(np.array(parts).T, variances)], angles
        )

    def normal_inverse(self, code: Code, angles: Sequence[str]) -> Entries:
        """Return the names of the entries of H^+, for an estimate that is not constant."""
        loose = [code.linear(self.basis.T, row) for row in self.loose_rows(code, angles)]
        named = [[code.name(entry) for entry in row] for row in loose]
        return normal_inverse(code, self.reduced, named, self.least)

    def loose_rows(self, code: Code, angles: Sequence[str]) -> list[list[str]]:
        """Return the names of the side-slip rows of the loose wheels."""
        rows = []
        for j in self.loose:
            straight = np.stack([self.across[j], -self.along[j]], axis=-1)
            rows.append([code.name(x) for x in code.linear(straight, turned(code, angles[j]))])
        return rows

    def _sandwich(self, code: Code, spread: Sequence[str], angles: Sequence[str]) -> list[str]:
        """Return N H^+ G H^+ N^T for the entries of G."""
        k = self.basis.shape[1]
        H, G = self.normal_inverse(code, angles), {}
        for (i, j), entry in zip(
            itertools.combinations_with_replacement(range(k), 2), spread, strict=True
        ):
            G[i, j] = G[j, i] = entry
        n = range(k)
        HG = {(i, j): code.sum(*(code.product(H[i, m], G[m, j]) for m in n)) for i in n for j in n}
        upper = list(itertools.combinations_with_replacement(n, 2))
        X = [code.sum(*(code.product(HG[i, m], H[m, j]) for m in n)) for i, j in upper]
        N = self.basis
        mixed = [
            np.outer(N[:, i], N[:, j]) + (i != j) * np.outer(N[:, j], N[:, i]) for i, j in upper
        ]
        return code.linear(np.array([each[np.triu_indices(3)] for each in mixed]).T, X)


def check_skid(robot: Robot) -> None:
    """Refuse robots whose skidding wheels slip in a way that depends on steering angles.

    Raises:
        TrundleError: a wheel that steers and drives rolls along what the skidding wheels leave.
    """
    straight, here = np.zeros(len(robot.steered)), frame(robot)
    rolling, skid = skid_matrices(robot)
    if not len(skid) or not any(wheel.steers for wheel in robot.driven):
        return
    driven = [wheel for wheel in robot.driven if not wheel.steers]
    held = side_slip_matrix(robot, [w for w in robot.wheels if not w.steers], straight)
    rows = [held, rolling, rolling_matrix(robot, driven, straight)]
    _, rank = null_projector(np.concatenate(rows), frame=here)
    if rank < 3:
        names = [wheel.name for wheel in robot.driven if wheel.steers]
        raise TrundleError(
            f"robot {robot.name!r}: how its skidding wheels slip depends on the steering angle of "
            f"{', '.join(names)}, which takes more than a program in straight lines"
        )


def turned(code: Code, angle: str) -> list[str]:
    """Return the names of the cosine and the sine of an angle."""
    return [code.name(f"cos({angle})"), code.name(f"sin({angle})")]


def _spread(code: Code, rolling: str, slip: str, angle: str) -> list[str]:
    """Return the variances along A and along B and their covariance, for a wheel that steers."""
    c, s = turned(code, angle)
    cc, cs, ss = code.product(c, c), code.product(c, s), code.product(s, s)
    between = code.sum(rolling, minus=[slip])
    return [
        code.sum(code.product(cc, rolling), code.product(ss, slip)),
        code.product(cs, between),
        code.sum(code.product(ss, rolling), code.product(cc, slip)),
    ]


def _squares(row: Array) -> Array:
    return np.asarray(np.outer(row, row)[np.triu_indices(len(row))])


def _mixed(a: Array, b: Array) -> list[Array]:
    upper = np.triu_indices(len(a))
    return [_squares(a), np.asarray((np.outer(a, b) + np.outer(b, a))[upper]), _squares(b)]


def _tidy_basis(projector: Array, count: int) -> Array:
    """Return an orthonormal basis (3, count) of what a projector keeps, with zeros where it can."""
    left, rows = np.array(projector), list[Array]()
    for _ in range(count):
        pivot = int(np.argmax(np.abs(left).max(axis=0) - 1e-6 * np.arange(3)))
        row = left[int(np.argmax(np.abs(left[:, pivot])))]
        row = row / row[pivot]
        rows = [each - each[pivot] * row for each in rows] + [row]
        left = left - np.outer(left[:, pivot], row)
    basis, _ = np.linalg.qr(np.array(rows).reshape(-1, 3).T)
    basis[np.abs(basis) < _ROUNDING] = 0.0
    largest = np.take_along_axis(basis, np.abs(basis).argmax(axis=0)[None], axis=0)
    return np.asarray(basis * np.sign(largest))
