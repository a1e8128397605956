"""Several reducers at once."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.recipe import Reduction
from trundle.simulation.rollout.reducers.base import Collected, Reducer
from trundle.simulation.rollout.reducers.cost import CostSum


class Several(Reducer):
    """Reducers side by side: the result is the tuple of their results."""

    def __init__(self, reducers: tuple[Reducer, ...]) -> None:
        self.reducers = reducers
        self.summed = math.gcd(*(each.summed for each in reducers))
        self.reads_command = any(each.reads_command for each in reducers)
        self.table = np.concatenate([each.table for each in reducers])

    def reduction(self, dtype: str) -> Reduction | None:
        """Return the functions, one after the other."""
        found = tuple(
            (reduction, sum(len(part) for part in each.constants(1.0, 0)))
            for each in self.reducers
            if (reduction := each.reduction(dtype)) is not None
        )
        return _Row(found) if found else None

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return the numbers of all, in their order."""
        parts = []
        for each in self.reducers:
            parts.extend(each.constants(dt, first))
            first += each.table.size
        return parts

    def check(self, command: int) -> None:
        """Refuse what does not fit commands of so many numbers."""
        for each in self.reducers:
            each.check(command)

    def with_parameters(self, parameters: Numbers) -> Several:
        """Return the same reducers, where the only cost among them has other parameters."""
        costs = [k for k, each in enumerate(self.reducers) if isinstance(each, CostSum)]
        if len(costs) != 1:
            raise TrundleError(
                f"parameters go to one CostSum, and there are {len(costs)}: call compile_rollout"
            )
        changed = list(self.reducers)
        changed[costs[0]] = changed[costs[0]].with_parameters(parameters)
        return Several(tuple(changed))

    def result(self, collected: Collected) -> tuple[Any, ...]:
        """Return the results of all."""
        results, first = [], 0
        for each, size in zip(self.reducers, self._sizes(collected.dtype), strict=True):
            registers = collected.registers[first : first + size]
            results.append(each.result(replace(collected, registers=registers)))
            first += size
        return tuple(results)

    def _sizes(self, dtype: str) -> list[int]:
        """Return how many registers each has."""
        reductions = (each.reduction(dtype) for each in self.reducers)
        return [0 if each is None else len(each.start) for each in reductions]


@dataclass(frozen=True)
class _Row:
    """Reductions, each with how many constants it takes."""

    parts: tuple[tuple[Reduction, int], ...]

    @property
    def start(self) -> tuple[float, ...]:
        """What the registers hold before the first step."""
        return tuple(number for reduction, _ in self.parts for number in reduction.start)

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        (reduction, count), later = self.parts[0], self.parts[1:]
        this, size = reduction.make(m, jit), len(reduction.start)
        if not later:
            return this
        others = _Row(later).make(m, jit)

        def both(
            t: Any, pose: Values, command: Values, registers: Values, constants: Values, table: Any
        ) -> Any:
            mine = this(t, pose, command, registers[:size], constants[:count], table)
            rest = others(t, pose, command, registers[size:], constants[count:], table)
            return mine + rest

        return jit(both)
