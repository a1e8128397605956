"""A robot's wheels and limits as constants in C."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from trundle.exchange.c.printer import number
from trundle.limits import IMPLAUSIBLE, SteeringInput, TwistLimits, limit_names, per
from trundle.robot import Encoder, Robot


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


def input_table(inputs: Iterable[SteeringInput]) -> str:
    """Return the rows of the table of steering inputs."""
    return _table(
        f"{{{_bound(each.low)}, {_bound(each.high)}, {_bound(each.rate)}}}" for each in inputs
    )


def steered_table(inputs: Sequence[SteeringInput]) -> str:
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
        fastest = IMPLAUSIBLE * wheel.max_speed if wheel.max_speed and wheel.driven else 0.0
        rows.append(f"{{{size}, {number(fastest)}}}" if plausible else f"{{{size}}}")
    return _table(rows)


def _bound(value: float) -> str:
    if math.isinf(value):
        return "UNLIMITED" if value > 0 else "-UNLIMITED"
    return number(value)


def numbers(values: Iterable[float]) -> str:
    """Return the entries of an array of numbers."""
    return _table(map(number, values))


def _table(rows: Iterable[str]) -> str:
    return "\n".join(f"    {row}," for row in rows)
