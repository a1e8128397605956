"""Statistics of each robot's pose over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.reducers.base import Collected, Reducer

# Beyond every pose, and a number in both types.
_LARGE = 3e38


@dataclass(frozen=True, eq=False)
class PoseStatistics:
    """Statistics over the poses after each step, (N, 3) each: of x, y, psi [m, m, rad].

    Attributes:
        mean: means over time.
        std: standard deviations over time (the root of the mean square).
        smallest: smallest values.
        largest: largest values.
    """

    mean: Numbers
    std: Numbers
    smallest: Numbers
    largest: Numbers


class Statistics(Reducer):
    """Mean, standard deviation, smallest and largest of x, y and psi over time, for each robot.

    They are taken over the poses after each step; the start is not among them. The result is a
    ``PoseStatistics`` of arrays (N, 3); without any step its numbers are NaN. Headings are not
    wrapped: a robot that turns on has ever larger ones.

    Source: Welford, "Note on a method for calculating corrected sums of squares and products",
    Technometrics 4(3), 1962.

    >>> from trundle import Constant, load, rollout
    >>> straight_on = Constant([1.0, 1.0])
    >>> over_time = rollout(
    ...     load("differential"), straight_on, dt=0.1, steps=10, save=Statistics(), device="numpy"
    ... ).reduced
    >>> over_time.mean[:, 0].round(6), over_time.largest[:, 0].round(6)  # of x
    (array([0.0275]), array([0.05]))
    """

    def reduction(self, dtype: str) -> _Running:
        """Return the function that takes one more pose into account."""
        return _Running(dtype == "float32")

    def result(self, collected: Collected) -> PoseStatistics:
        """Return the statistics."""
        each = collected.registers.reshape(3, -1, collected.registers.shape[1])
        if not collected.steps:
            each = np.full_like(each, np.nan)
        variance = each[:, 1] / max(collected.steps, 1)
        return PoseStatistics(each[:, 0].T, np.sqrt(variance).T, each[:, 2].T, each[:, 3].T)


@dataclass(frozen=True)
class _Running:
    """Of each coordinate: mean, sum of squared deviations, smallest, largest.

    If compensated, also what mean and sum have lost to rounding.
    """

    compensated: bool

    @property
    def start(self) -> tuple[float, ...]:
        """What the registers hold before the first step."""
        lost = (0.0, 0.0) if self.compensated else ()
        return (0.0, 0.0, _LARGE, -_LARGE, *lost) * 3

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        number, one = m.number, m.number(1)
        take = _make_take_compensated(m, jit) if self.compensated else _make_take(m, jit)
        size = len(self.start) // 3
        both = 2 * size

        def reduce(t: Any, pose: Values, _: Values, registers: Values, __: Values, ___: Any) -> Any:
            share = one / number(t + 1)
            return (
                take(share, pose[0], registers[:size])
                + take(share, pose[1], registers[size:both])
                + take(share, pose[2], registers[both:])
            )

        return jit(reduce)


def _make_take(m: Arithmetic, jit: Jit) -> Function:
    """Return (share, x, registers) -> the registers of a coordinate after one more value."""
    minimum, maximum = m.minimum, m.maximum

    def take(share: Any, x: Any, registers: Values) -> Values:
        mean, squares, smallest, largest = registers
        apart = x - mean
        new = mean + apart * share
        return new, squares + apart * (x - new), minimum(smallest, x), maximum(largest, x)

    return jit(take)


def _make_take_compensated(m: Arithmetic, jit: Jit) -> Function:
    """Return the same; its registers hold too much, by what is carried along."""
    minimum, maximum = m.minimum, m.maximum

    @jit
    def add(total: Any, excess: Any, term: Any) -> tuple[Any, Any]:
        wanted = term - excess
        new = total + wanted
        return new, (new - total) - wanted

    def take(share: Any, x: Any, registers: Values) -> Values:
        mean, squares, smallest, largest, mean_excess, squares_excess = registers
        apart = (x - mean) + mean_excess
        new, new_excess = add(mean, mean_excess, apart * share)
        total, total_excess = add(squares, squares_excess, apart * ((x - new) + new_excess))
        return (
            new, total, minimum(smallest, x), maximum(largest, x), new_excess, total_excess,
        )  # fmt: skip

    return jit(take)
