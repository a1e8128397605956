"""The steering inputs of a robot: one wheel that steers alone, or a group that is linked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from trundle.errors import TrundleError
from trundle.robot import Robot


class SteeringInput(NamedTuple):
    """What moves one wheel's angle, or those of a group together.

    Attributes:
        members: steered wheels, by their place among them, each with its ratio +1 or -1.
        low, high: range of the input in which all members keep theirs [rad].
        rate: largest rate [rad/s]; infinite without a limit.
    """

    members: tuple[tuple[int, float], ...]
    low: float
    high: float
    rate: float


def steering_groups(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Return the steered wheels, by their place among them, that each input moves together."""
    groups: dict[str, list[int]] = {}
    for i, wheel in enumerate(robot.steered):
        groups.setdefault(wheel.steering_group or f"\0{wheel.name}", []).append(i)
    return tuple(map(tuple, groups.values()))


def steering_inputs(robot: Robot) -> tuple[SteeringInput, ...]:
    """Return the steering inputs of a robot, in the order of their first wheels.

    Raises:
        TrundleError: a steering ratio is neither 1 nor -1.

    >>> from trundle.robot import load
    >>> [each.members for each in steering_inputs(load("four_wheel_steered"))]
    [((0, 1.0), (2, -1.0)), ((1, 1.0), (3, -1.0))]
    """
    for wheel in robot.steered:
        if abs(wheel.steering_ratio) != 1:
            raise TrundleError(
                f"wheel {wheel.name!r}: linked wheels need steering_ratio 1 or -1 in a control "
                f"loop, got {wheel.steering_ratio:g}"
            )
    return tuple(_input(robot, members) for members in steering_groups(robot))


def _input(robot: Robot, members: Sequence[int]) -> SteeringInput:
    wheels = [robot.steered[i] for i in members]
    ends = [sorted(end * wheel.steering_ratio for end in wheel.steering_range) for wheel in wheels]
    return SteeringInput(
        members=tuple((i, robot.steered[i].steering_ratio) for i in members),
        low=max(low for low, _ in ends),
        high=min(high for _, high in ends),
        rate=min(wheel.steering_rate or math.inf for wheel in wheels),
    )
