"""Steering inputs in symbols: one for each wheel that steers alone and one for each group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import sympy

from trundle.robot import Robot, SteeredWheel, Wheel
from trundle.se2 import Array
from trundle.symbolic.quantities import exact


class Inputs(NamedTuple):
    """The steering inputs, and each steered wheel's angle as a multiple of one of them."""

    symbols: tuple[Any, ...]
    angles: dict[str, Any]
    first: tuple[SteeredWheel, ...]

    def values(self, steering: Sequence[float] | Array, robot: Robot) -> dict[Any, float]:
        """Return the inputs that belong to steering angles (s,) [rad]."""
        by_name = dict(zip((wheel.name for wheel in robot.steered), steering, strict=True))
        return {
            symbol: float(by_name[wheel.name]) / wheel.steering_ratio
            for symbol, wheel in zip(self.symbols, self.first, strict=True)
        }


def steering_inputs(wheels: Sequence[Wheel]) -> Inputs:
    """Return beta for the one steering input, or beta_i after the first wheel i of each."""
    leaders: dict[str, tuple[int, SteeredWheel]] = {}
    for i, wheel in enumerate(wheels, 1):
        if isinstance(wheel, SteeredWheel):
            leaders.setdefault(_input_of(wheel), (i, wheel))
    symbols = {
        key: sympy.Symbol("beta" if len(leaders) == 1 else f"beta_{i}", real=True)
        for key, (i, _) in leaders.items()
    }
    angles = {
        wheel.name: exact(wheel.steering_ratio) * symbols[_input_of(wheel)]
        for wheel in wheels
        if isinstance(wheel, SteeredWheel)
    }
    return Inputs(tuple(symbols.values()), angles, tuple(wheel for _, wheel in leaders.values()))


def _input_of(wheel: SteeredWheel) -> str:
    return wheel.steering_group or f"\0{wheel.name}"
