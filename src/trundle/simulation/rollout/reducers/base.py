"""What all reducers are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.recipe import Reduction
from trundle.simulation.rollout.reducers.moments import Moments


@dataclass(frozen=True, eq=False)
class Collected:
    """What the loops leave to a reducer.

    Attributes:
        registers: (k, N) numbers of each robot after all steps.
        steps: how many steps there were.
        dt: step [s].
        dtype: "float32" or "float64".
        moments: of the poses of all robots, at the start and every ``summed`` steps, or None.
        summed: see there; 0 for never.
    """

    registers: Numbers
    steps: int
    dt: float
    dtype: str
    moments: Moments | None = None
    summed: int = 0


class Reducer:
    """What is made of poses and commands, step by step.

    Attributes:
        summed: at every so many steps the poses of all robots are added up; 0 for never.
        reads_command: whether its function needs the command, and not the pose alone.
        table: numbers that it looks up.
    """

    summed: int = 0
    reads_command: bool = False
    table: Numbers = np.zeros(0)

    def reduction(self, dtype: str) -> Reduction | None:
        """Return the function that the loops run, with its registers, or None."""
        return None

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return the numbers that the function takes.

        Args:
            dt: step [s].
            first: where its table begins.

        Returns:
            Arrays (k,) of numbers that all robots share, or (k, N) of each robot, in their order.
        """
        return []

    def check(self, command: int) -> None:
        """Refuse what does not fit commands of so many numbers."""

    def with_parameters(self, parameters: Numbers) -> Reducer:
        """Return the same reducer with other parameters.

        Raises:
            TrundleError: it has none.
        """
        raise TrundleError(f"{type(self).__name__} takes no parameters")

    def result(self, collected: Collected) -> Any:
        """Return what the user sees."""
        raise NotImplementedError


def first_times(steps: Numbers, dt: float) -> Numbers:
    """Return the times [s] at the ends of steps counted from 1; infinity where the count is < 0."""
    return np.where(steps < 0, np.inf, steps * dt)
