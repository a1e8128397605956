"""Which wheel disagrees with the others: the residuals of a least-squares fit, looked at over time.

The residuals ``E`` of the rows, summed over the last second, are zero but for noise while no wheel
slips; a wheel that slips makes them grow along its own direction. With ``s^2`` the variance that
noise gives to a row, and L the projector onto the residuals, ``|E|^2 / s^2`` then follows the
chi-square law with as many degrees of freedom as there are rows too many, and a single wheel whose
row i is left out takes ``E_i^2 / (L_ii s^2)`` of it away.

Source: Baarda, A testing procedure for use in geodetic networks, 1968, for the test of one row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from trundle.bridge.uncertainty import counted, names, turns_of
from trundle.kinematics import Code, Estimate, Straight
from trundle.robot import Robot
from trundle.se2 import Array

# Over this time [s] what was seen fades: slip of a fifth is told from noise within it at a walking
# pace, and forgotten soon after it ends.
_MEMORY = 1.0
# A wheel is not to be blamed when another explains the residuals better by this: at equal noise, by
# a likelihood ratio of exp(4.5), or 90.
_CLEARED = 9.0
# Entries of a projector below this are rounding.
_ROUNDING = 1e-12
# Added to what a row varies by at rest [m^2], so that 0 / 0 never arises: a nanometre, squared.
_LEAST = 1e-18
# Added to the share of the residuals that a row has: a wheel without a share explains nothing.
_NO_SHARE = 1e-6
_HALVINGS = 100

Memory = tuple[float, ...]


class SlipWatch:
    """The search for slipping wheels of one robot; it keeps nothing from step to step.

    Where one row is too many, as with four mecanum wheels, every wheel explains its mismatch as
    well as any other: all of them are told. With more, those are told that explain what is seen
    (nearly) as well as the best, most often one. Where no row is too many, nothing can be seen.

    Args:
        robot: the robot.
        wheel_noise: variance of a wheel's travel over its length [m^2/m].
        steering_noise: variance of a steered wheel's side slip over its way [m^2/m].
        threshold: the residuals count as slip where noise alone would reach them as rarely as a
            normal variable reaches so many standard deviations to either side.
        without: names of sensed wheels that do not count.
        resolutions: (k) turn of each sensed wheel for one count [rad].

    Attributes:
        start: what is remembered before the first step.
        redundancy: how many rows are too many.

    >>> from trundle import load
    >>> watch = SlipWatch(load("skid_steer"), 1e-4, 1e-4, 5.0)
    >>> past = watch.start
    >>> for _ in range(50):  # a second of driving ahead; the first wheel turns a fifth too far
    ...     past, slipping, _ = watch.step(past, (0.24, 0.2, 0.2, 0.2), (), 0.02)
    >>> slipping
    ('front_left', 'rear_left')
    """

    def __init__(
        self,
        robot: Robot,
        wheel_noise: float,
        steering_noise: float,
        threshold: float,
        without: frozenset[str] = frozenset(),
        resolutions: Sequence[float] = (),
    ) -> None:
        wheels = counted(robot, without)
        parts = _Parts(robot, Estimate.of(robot, wheels), without)
        self.redundancy = parts.redundancy
        floor = parts.floor(resolutions)
        self.start: Memory = (0.0,) * parts.count + (floor,)
        self._names = parts.tested
        self._limit = chi_square(self.redundancy, threshold) if self.redundancy else math.inf
        self._watch = parts.watch(max(wheel_noise, steering_noise), floor).compile()
        self._test = parts.test().compile()
        self._sums = parts.count + 1
        self._none = (0.0,) * len(robot.sensed)

    def step(
        self, past: Memory, turned: Sequence[float], angles: Sequence[float], interval: float
    ) -> tuple[Memory, tuple[str, ...], tuple[float, ...]]:
        """Return what is remembered, the names of the wheels that may slip, and the residuals.

        Args:
            past: what was remembered after the step before, or ``start``.
            turned: (k) increments of the sensed wheels [rad].
            angles: (s) steering angles at the middle of the step [rad].
            interval: time of the step [s].

        Returns:
            The memory; names of sensed or steered wheels; and of each sensed wheel its rim speed
            less that of the fit, along its row [m/s], 0 for wheels that do not count.
        """
        if not self.redundancy:
            return past, (), self._none
        size, *rest = self._watch(*past, *turned, *angles, interval)
        memory = tuple(rest[: self._sums])
        if size <= self._limit:
            return memory, (), tuple(rest[self._sums :])
        return memory, self._suspects(size, memory, angles), tuple(rest[self._sums :])

    def _suspects(self, size: float, memory: Memory, angles: Sequence[float]) -> tuple[str, ...]:
        """Return the wheels without which the residuals are nearly as small as they can be."""
        explained: dict[str, float] = {}
        for name, part in zip(self._names, self._test(*memory, *angles), strict=True):
            explained[name] = max(part, explained.get(name, 0.0))
        least = max(explained.values()) - _CLEARED
        return tuple(name for name, part in explained.items() if part >= least)


class _Parts:
    """The rows of an estimate, and the programs that watch their residuals.

    Rows are the estimate's constant ones, two for a steered wheel that is measured, and the
    side-slip rows of its loose wheels.
    """

    def __init__(self, robot: Robot, estimate: Estimate, without: frozenset[str]) -> None:
        self._estimate, self._every = estimate, [wheel.name for wheel in robot.sensed]
        self._wheels = [wheel for wheel in robot.sensed if wheel.name not in without]
        self._turns, self._angles = turns_of(robot, without), names("s", len(robot.steered))
        loose = () if estimate.constant else estimate.loose
        fixed = len(estimate.rows)
        self.count = fixed + len(loose)
        self._sums = names("e", self.count)
        L = np.eye(fixed) - estimate.rows @ estimate.inverse
        self._projector = np.where(np.abs(L) < _ROUNDING, 0.0, L)
        seen = estimate.basis.shape[1] if loose else fixed - round(float(np.trace(L)))
        self.redundancy = max(self.count - seen, 0)
        self.tested = [w.name for w in self._wheels for _ in range(2 if w.steers else 1)]
        self.tested += [robot.steered[j].name for j in loose]

    def floor(self, resolutions: Sequence[float]) -> float:
        """Return what a row varies by at rest [m^2]: the first and the last count stay open."""
        counts = dict(zip(self._every, resolutions or [0.0] * len(self._every), strict=True))
        squares = [2.0 / 12.0 * counts[wheel.name] ** 2 for wheel in self._wheels]
        return float(self._row_variance(squares).sum()) + _LEAST

    def watch(self, noise: float, floor: float) -> Straight:
        """Return (memory, increments, angles, dt) -> size, memory and residuals [m/s]."""
        code = Code()
        kept = code.name(f"{_MEMORY!r} / ({_MEMORY!r} + dt)")
        fresh = self._residuals(code)
        sums = [code.name(f"{kept} * {e} + {f}") for e, f in zip(self._sums, fresh, strict=True)]
        ways = [code.name(f"sqrt({turn} * {turn})") for turn in self._turns]
        rates = [noise / wheel.radius for wheel in self._wheels]
        added = code.linear(self._row_variance(rates)[None], ways)[0]
        spread = code.name(f"{kept} * {kept} * (spread - {floor!r}) + {added} + {floor!r}")
        size = " + ".join(f"{each} * {each}" for each in sums) or "0.0"
        size = f"({size}) / {spread}"
        told = dict.fromkeys(self._every, "0.0") | self._speeds(code, fresh)
        inputs = (*names("w", len(self._every)), *self._angles, "dt")
        results = (size, *sums, spread, *told.values())
        return code.program("watch", (*self._sums, "spread", *inputs), results)

    def test(self) -> Straight:
        """Return (memory, angles) -> by how much the size is less without each tested row."""
        code, at = Code(), 0
        parts = list[str]()
        for j in self._estimate.angle:
            if j is None:
                parts.append(self._explained(code, {at: "1.0"}))
                at += 1
                continue
            c, s = _directions(code, self._angles[j])
            parts.append(self._explained(code, {at: c, at + 1: s}))
            parts.append(self._explained(code, {at: code.name(f"-{s}"), at + 1: c}))
            at += 2
        parts += [self._explained(code, {i: "1.0"}) for i in range(at, self.count)]
        return code.program("test", (*self._sums, "spread", *self._angles), parts)

    def _residuals(self, code: Code) -> list[str]:
        """Return the names of the rows' residuals in this step [m]."""
        estimate = self._estimate
        measured = estimate.measured(code, self._turns, self._angles)
        if estimate.constant:
            fresh = code.linear(self._projector * estimate.factors, measured)
            return [code.name(each) for each in fresh]
        moved = [code.name(x) for x in estimate.twist(code, self._turns, self._angles)]
        both = np.hstack([np.diag(estimate.factors), -estimate.rows])
        fresh = code.linear(both, [*measured, *moved])
        for row in estimate.loose_rows(code, self._angles):
            products = [code.product(a, b) for a, b in zip(row, moved, strict=True)]
            fresh.append(code.sum(minus=products))
        return [code.name(each) for each in fresh]

    def _row_variance(self, variances: Sequence[float]) -> Array:
        """Return what variances of the wheels' turns [rad^2] add to that of a row, each [m^2].

        A row has its share of the residuals, tr(L S) in all. Where L depends on the angles, all
        rows are taken to have the same share.
        """
        estimate = self._estimate
        owner = np.repeat(range(len(self._wheels)), [1 if j is None else 2 for j in estimate.angle])
        share = np.full(len(owner), 1.0 / max(len(owner), 1))
        if estimate.constant and self.redundancy:
            share = np.diag(self._projector) / self.redundancy
        out = np.zeros(len(self._wheels))
        np.add.at(out, owner, share)
        return np.asarray(out * estimate.gains**2 * np.asarray(variances))

    def _speeds(self, code: Code, fresh: Sequence[str]) -> dict[str, str]:
        """Return each wheel's residual along its rolling direction [m/s]."""
        per, out, at = code.name("1.0 / dt"), {}, 0
        for wheel, j in zip(self._wheels, self._estimate.angle, strict=True):
            if j is None:
                out[wheel.name] = code.product(per, fresh[at])
                at += 1
                continue
            c, s = _directions(code, self._angles[j])
            both = code.sum(code.product(c, fresh[at]), code.product(s, fresh[at + 1]))
            out[wheel.name] = code.product(per, both)
            at += 2
        return out

    def _explained(self, code: Code, direction: dict[int, str]) -> str:
        """Return E_d^2 / (L_dd s^2) for a direction d over rows."""
        along = code.sum(*(code.product(c, self._sums[i]) for i, c in direction.items()))
        share = code.sum(
            *(
                code.product(a, b, self._entry(code, i, j))
                for i, a in direction.items()
                for j, b in direction.items()
            )
        )
        return f"{along} * {along} / (({share} + {_NO_SHARE!r}) * spread)"

    def _entry(self, code: Code, i: int, j: int) -> str:
        """Return an entry of L = 1 - R H^+ R^T."""
        estimate = self._estimate
        if estimate.constant:
            return repr(float(self._projector[i, j]))
        rows = [[repr(x) for x in row] for row in (estimate.rows @ estimate.basis).tolist()]
        rows += [
            [code.name(x) for x in code.linear(estimate.basis.T, row)]
            for row in estimate.loose_rows(code, self._angles)
        ]
        H = estimate.normal_inverse(code, self._angles)
        used = [code.product(rows[i][a], H[a, b], rows[j][b]) for a, b in H]
        return code.sum("1.0" if i == j else "0.0", minus=used)


def _directions(code: Code, angle: str) -> tuple[str, str]:
    return code.name(f"cos({angle})"), code.name(f"sin({angle})")


def chi_square(freedom: int, deviations: float) -> float:
    """Return what a chi-square variable exceeds as rarely as a normal one does the deviations.

    >>> round(chi_square(1, 5.0), 9), round(chi_square(4, 3.0), 2)  # 0.27 %
    (25.0, 16.25)
    """
    rare = math.erfc(deviations / math.sqrt(2.0))
    low, high = 0.0, (deviations + math.sqrt(freedom) + 1.0) ** 2
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _exceeds(freedom, middle) > rare else (low, middle)
    return 0.5 * (low + high)


def _exceeds(freedom: int, value: float) -> float:
    """Return the chance that a chi-square variable exceeds a value, by its recurrence.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 1964, eqs. 26.4.4 and 26.4.5.
    """
    half = 0.5 * value
    odd = freedom % 2
    chance = math.erfc(math.sqrt(half)) if odd else math.exp(-half)
    for m in range(2 - odd, freedom, 2):
        chance += half ** (0.5 * m) * math.exp(-half) / math.gamma(0.5 * m + 1.0)
    return chance
