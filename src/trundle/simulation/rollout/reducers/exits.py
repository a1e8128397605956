"""When a robot leaves a region for the first time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.reducers.base import Collected, Reducer, first_times
from trundle.simulation.rollout.reducers.regions import Box, Disc, Region


@dataclass(frozen=True, eq=False)
class Exits:
    """When and where N robots left a region.

    Attributes:
        time: (N,) end of the first step after which the robot was outside [s]; infinity if never.
        pose: (N, 3) pose there (x, y, psi) [m, m, rad]; NaN if never.
    """

    time: Numbers
    pose: Numbers


class FirstExit(Reducer):
    """When each robot's origin is outside a region for the first time, and its pose then.

    Robots are looked at after each step, not at the start. The result is an ``Exits``.

    Args:
        region: ``Disc(x, y, radius)`` or ``Box(x_min, x_max, y_min, y_max)``.

    Raises:
        TrundleError: the region is neither.

    >>> from trundle import Constant, load, rollout
    >>> speeds = Constant([[1.0, 1.0], [-1.0, -1.0]])  # of two robots, 0.05 m/s ahead and back
    >>> exits = rollout(
    ...     load("differential"),
    ...     speeds,
    ...     dt=0.1,
    ...     steps=100,
    ...     save=FirstExit(Disc(0.3, 0.0, 0.501)),
    ...     device="numpy",
    ... ).reduced
    >>> exits.time.round(6)
    array([inf, 4.1])
    """

    def __init__(self, region: Region) -> None:
        if not isinstance(region, Disc | Box):
            raise TrundleError(f"region must be a Disc or a Box, got {region!r}")
        self.region = region

    def reduction(self, dtype: str) -> _Exit:
        """Return the function that remembers the first pose outside."""
        return _Exit(type(self.region))

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return the region's numbers."""
        return [np.array(self.region.numbers)]

    def result(self, collected: Collected) -> Exits:
        """Return times and poses."""
        steps, pose = collected.registers[0], collected.registers[1:]
        return Exits(first_times(steps, collected.dt), np.where(steps < 0, np.nan, pose).T)


@dataclass(frozen=True)
class _Exit:
    """How many steps it took, -1 if it never happened, and the pose."""

    region: type[Region]
    start = (-1.0, 0.0, 0.0, 0.0)

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        number, where, zero, one, two = m.number, m.where, m.number(0), m.number(1), m.number(2)
        outside = self.region.make_outside(m, jit)

        def reduce(
            t: Any, pose: Values, _: Values, registers: Values, constants: Values, __: Any
        ) -> Values:
            # 1 when it happens: what is 0 before is set by a product, which is cheap in a vector.
            excess = outside(pose[0], pose[1], constants)
            now = where(registers[0] < zero, one, zero) * where(excess > zero, one, zero)
            return (
                registers[0] + now * (number(t) + two),
                registers[1] + now * pose[0],
                registers[2] + now * pose[1],
                registers[3] + now * pose[2],
            )

        return jit(reduce)
