"""A robot's wheels and limits as constants in C."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from trundle.errors import TrundleError
from trundle.exchange.c.printer import number
from trundle.limits import TwistLimits, limit_names
from trundle.robot import Encoder, Robot

# A wheel that seems to have turned so many times further than its largest speed allows has not.
_IMPLAUSIBLE = 2.0


def driven_table(robot: Robot) -> str:
    """Return each driven wheel's place among the steered ones, and among the others if any."""
    steered = [wheel.name for wheel in robot.steered]
    fixed = [wheel.name for wheel in robot.driven if not wheel.steers]
    rows = []
    for wheel in robot.driven:
        here = steered.index(wheel.name) if wheel.steers else -1
        there = -1 if wheel.steers else fixed.index(wheel.name)
        parts = [str(here), *([str(there)] if fixed else []), number(1.0 / wheel.rows().gain)]
        rows.append(f"{{{', '.join(parts)}}}")
    return _table(rows)


@dataclass(frozen=True)
class Input:
    """A steering input: the wheels that follow it, each with its sign, its range and its rate."""

    members: tuple[tuple[int, float], ...]
    low: float
    high: float
    rate: float


def steering_inputs(robot: Robot) -> tuple[Input, ...]:
    """Return the steering inputs of a robot, in the order of their first wheels.

    Raises:
        TrundleError: a steering ratio is neither 1 nor -1.
    """
    groups: dict[str, list[int]] = {}
    for i, wheel in enumerate(robot.steered):
        if abs(wheel.steering_ratio) != 1:
            raise TrundleError(
                f"wheel {wheel.name!r}: linked wheels in C need steering_ratio 1 or -1, got "
                f"{wheel.steering_ratio:g}"
            )
        groups.setdefault(wheel.steering_group or f"\0{wheel.name}", []).append(i)
    return tuple(_input(robot, members) for members in groups.values())


def _input(robot: Robot, members: Sequence[int]) -> Input:
    wheels = [robot.steered[i] for i in members]
    ends = [sorted(end * wheel.steering_ratio for end in wheel.steering_range) for wheel in wheels]
    return Input(
        members=tuple((i, robot.steered[i].steering_ratio) for i in members),
        low=max(low for low, _ in ends),
        high=min(high for _, high in ends),
        rate=min(wheel.steering_rate or math.inf for wheel in wheels),
    )


def input_table(inputs: Iterable[Input]) -> str:
    """Return the rows of the table of steering inputs."""
    return _table(
        f"{{{_bound(each.low)}, {_bound(each.high)}, {_bound(each.rate)}}}" for each in inputs
    )


def steered_table(inputs: Sequence[Input]) -> str:
    """Return the rows of the table of steered wheels."""
    follows = {i: (j, sign) for j, each in enumerate(inputs) for i, sign in each.members}
    return _table(f"{{{follows[i][0]}, {number(follows[i][1])}}}" for i in sorted(follows))


def limit_lines(limits: TwistLimits) -> str:
    """Return one over each limit as macros."""
    lines = []
    jerk = limits.max_jerk is not None or limits.max_yaw_jerk is not None
    for name in limit_names():
        if name.endswith("jerk") and not jerk:
            continue
        value = getattr(limits, name)
        word = name.removeprefix("max_").upper()
        told = "" if value is None else f" /* {name} = {value:g} */"
        lines.append(f"#define PER_{word} {number(per(value))}{told}")
    return "\n".join(lines)


def turns(limits: TwistLimits) -> tuple[bool, bool, bool]:
    """Return which axes have other limits on the other side of zero, or on the way away from it."""
    ahead = {limits.max_acceleration, limits.max_deceleration}
    back = {limits.max_reverse_acceleration, limits.max_reverse_deceleration}
    yaw = {limits.max_yaw_acceleration, limits.max_yaw_deceleration}
    return len(ahead | back) > 1, len(ahead) > 1, len(yaw) > 1


def unit_table(robot: Robot, encoder: Encoder | None) -> str:
    """Return radius, gear and counts per radian of each driven wheel."""
    rows = []
    for wheel in robot.driven:
        own = wheel.encoder or encoder
        shaft = wheel.motor or own
        gear = 1.0 if shaft is None else shaft.gear
        per_radian = number(1.0 / own.radians_per_tick if own else 0.0)
        if own is None and wheel.sensed:
            per_radian = "R(1.0) / STAND_IN"
        rows.append(f"{{{number(wheel.radius)}, {number(gear)}, {per_radian}}}")
    return _table(rows)


def counter_table(robot: Robot, encoder: Encoder | None, plausible: bool) -> str:
    """Return radians per count of each wheel with a counter, and its largest plausible speed."""
    rows = []
    for wheel in robot.sensed:
        own = wheel.encoder or encoder
        size = number(own.radians_per_tick) if own else "STAND_IN"
        fastest = _IMPLAUSIBLE * wheel.max_speed if wheel.max_speed and wheel.driven else 0.0
        rows.append(f"{{{size}, {number(fastest)}}}" if plausible else f"{{{size}}}")
    return _table(rows)


def per(limit: float | None) -> float:
    """Return one over a limit, 0 where there is none."""
    return 0.0 if limit is None else 1.0 / limit


def _bound(value: float) -> str:
    if math.isinf(value):
        return "UNLIMITED" if value > 0 else "-UNLIMITED"
    return number(value)


def numbers(values: Iterable[float]) -> str:
    """Return the entries of an array of numbers."""
    return _table(map(number, values))


def _table(rows: Iterable[str]) -> str:
    return "\n".join(f"    {row}," for row in rows)
