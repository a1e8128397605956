"""What the firmware's tests ask of a robot, and what Python answers.

Random twists, speeds and poses for the three functions; and some seconds of driving for the bridge,
with commands that are missing or bad, counters that wrap around, jump or are not read, angles that
are measured or not, and cycles of several lengths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import trundle
from trundle.robot import Encoder, Robot

ENCODER = Encoder(ticks_per_motor_turn=512, gear=3.0)
# A grid of times on which floats are exact, so that Python and C see the same seconds.
GRID_US = 15_625
MICRO = 1e-6
# The C's clock starts so near its end that it wraps around after a second.
START_US = 2**32 - 1_000_000
CALLS, CYCLES = 8, 96
LIMITS = {
    "wheels": 1, "steering range": 2, "speed": 4, "wheel speed": 8, "acceleration": 16, "jerk": 32,
    "steering rate": 64,
}  # fmt: skip
# The limits of a small indoor robot, all different.
SETTINGS: dict[str, Any] = {
    "timeout": 0.3, "max_speed": 0.8, "max_reverse_speed": 0.5, "max_yaw_rate": 1.5,
    "max_acceleration": 2.0, "max_deceleration": 3.0, "max_reverse_acceleration": 1.5,
    "max_yaw_acceleration": 5.0, "max_yaw_deceleration": 7.0,
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A robot and the settings of its bridge."""

    robot: Robot
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def bits(self) -> int:
        """Width of the counters."""
        return int(self.settings.get("counter_bits", 32))


def bare(name: str) -> Case:
    """Return a catalogue robot without limits."""
    return Case(trundle.load(name), {"encoder": ENCODER})


def limited(name: str) -> Case:
    """Return a catalogue robot with limits of every kind, and narrow counters."""
    case = gentle(name)
    robot = case.robot
    if robot.steered:
        robot = robot.with_wheels(steering_min=-1.1, steering_max=1.2)
    return Case(robot, {**case.settings, "max_jerk": 40.0, "max_yaw_jerk": 90.0})


def gentle(name: str) -> Case:
    """Return the same without limits at which the next step hangs on the last digit.

    A wheel at the end of its range may go on, or must not; and a jerk that is limited leaves more
    or less than nothing of an axis that comes to rest.
    """
    robot = trundle.load(name)
    robot = robot.with_wheels(max_speed=0.9 / robot.driven[0].radius, max_acceleration=60.0)
    if robot.steered:
        robot = robot.with_wheels(steering_rate=8.0)
    return Case(robot, {**SETTINGS, "counter_bits": 16, "encoder": ENCODER})


@dataclass(frozen=True)
class Call:
    """Arguments of the three functions."""

    twist: tuple[float, ...]
    wheel_speeds: tuple[float, ...]
    increments: tuple[float, ...]
    pose: tuple[float, ...]
    steering: tuple[float, ...]


@dataclass(frozen=True)
class Cycle:
    """Arguments of one cycle of the bridge; None where there are none."""

    us: int  # since the start
    command: tuple[float, ...] | None
    counts: tuple[int, ...] | None
    steering: tuple[float, ...] | None


def random_calls(case: Case, seed: int) -> list[Call]:
    """Return random arguments, and standstill."""
    random, robot = np.random.default_rng(seed), case.robot
    kinematics = trundle.Kinematics(robot)
    n, k, s = len(robot.driven), len(robot.sensed), len(robot.steered)
    calls = [Call((0.0,) * 3, (0.0,) * n, (0.0,) * k, (0.0,) * 3, (0.0,) * s)]
    while len(calls) < CALLS:
        angles = _consistent(kinematics, random)
        calls.append(
            Call(*(tuple(random.uniform(-1, 1, m).tolist()) for m in (3, n, k, 3)), angles)
        )
    return calls


def _consistent(kinematics: trundle.Kinematics, random: np.random.Generator) -> tuple[float, ...]:
    """Return steering angles near such that share a centre."""
    found = kinematics.inverse(random.uniform(-1, 1, 3))
    return tuple(float(angle) + random.normal(0, 0.02) for angle in found.steering)


def random_cycles(case: Case, seed: int, count: int = CYCLES) -> list[Cycle]:
    """Return some seconds of driving, in which all that may go wrong does."""
    random, robot = np.random.default_rng(seed), case.robot
    kinematics, turns = trundle.Kinematics(robot), 1 << case.bits
    us, counts = 0, random.integers(0, turns, len(robot.sensed)).astype(object)
    cycles = []
    for i in range(count):
        us += GRID_US * int(random.choice([1, 1, 1, 2, 3, 12], p=[0.3, 0.3, 0.1, 0.1, 0.17, 0.03]))
        counts = counts + random.integers(-40, 60, len(counts))
        if random.random() < 0.03:
            counts = counts + 3_000  # a counter that was reset
        command = _command(random)
        # Commands stop for a while in the middle, until they are stale and the robot stands.
        if random.random() > 0.25 or 0.45 < i / count < 0.75:
            command = (math.nan, 0.0, 0.0) if i == count // 5 else None
        angles = _consistent(kinematics, random)
        if random.random() < 0.1:
            angles = (math.nan, *angles[1:])
        late = GRID_US * int(random.random() < 0.03)  # a clock that goes back
        cycles.append(
            Cycle(
                us - late,
                command,
                _shown(random, counts, turns) if random.random() < 0.8 else None,
                angles if robot.steered and random.random() < 0.5 else None,
            )
        )
    return cycles


def _command(random: np.random.Generator) -> tuple[float, ...]:
    """Return a command: one in ten is bad, and one in ten is to stop."""
    u, v, r = (random.uniform(-1, 1, 3) * (1.2, 0.8, 2.5)).tolist()
    kind = random.random()
    if kind < 0.1:
        return u, float(random.choice([math.nan, math.inf, 1e4])), r
    return (0.0, 0.0, 0.0) if kind < 0.2 else (u, v, r)


def _shown(random: np.random.Generator, counts: Any, turns: int) -> tuple[int, ...]:
    """Return what counters show; narrow ones may be signed, or show what cannot be."""
    shown = tuple(int(each) % turns for each in counts)
    if turns < 2**32 and random.random() < 0.2:
        shown = tuple(each - turns * (each >= turns // 2) for each in shown)
    if turns < 2**32 and random.random() < 0.03:
        shown = (turns + 5, *shown[1:])
    return shown


def vectors(calls: list[Call], cycles: list[Cycle], robot: Robot, start: int = START_US) -> str:
    """Return the text of vectors.h."""
    steers = bool(robot.steered)
    first = [
        f"{{{', '.join(map(_reals, (c.twist, c.wheel_speeds, c.increments, c.pose)))}"
        f"{', ' + _reals(c.steering) if steers else ''}}}"
        for c in calls
    ]
    then = [
        ", ".join(
            [
                f"{{UINT32_C({(start + c.us) % 2**32})",
                *(_flag(each) for each in (c.command, c.counts, c.steering)),
                _reals(c.command or (0.0,) * 3),
                _wholes(c.counts or (0,) * len(robot.sensed)),
                *([_reals(c.steering or (0.0,) * len(robot.steered))] if steers else []),
            ]
        )
        + "}"
        for c in cycles
    ]
    return "\n".join(
        [
            "#include <math.h>",
            f"#define START_US UINT32_C({start})",
            "static const call calls[] = {",
            *(f"    {row}," for row in first),
            "};",
            "static const cycle cycles[] = {",
            *(f"    {row}," for row in then),
            "};",
            "",
        ]
    )


def _flag(value: object) -> str:
    return "false" if value is None else "true"


def _reals(values: tuple[float, ...]) -> str:
    return f"{{{', '.join(map(_real, values))}}}"


def _real(value: float) -> str:
    if math.isfinite(value):
        return f"(trundle_real){value!r}"
    return "(trundle_real)NAN" if math.isnan(value) else "(trundle_real)INFINITY"


def _wholes(values: tuple[int, ...]) -> str:
    return f"{{{', '.join(f'UINT32_C({value % 2**32})' for value in values)}}}"


def answers(case: Case, calls: list[Call]) -> list[float]:
    """Return what Python's bound functions answer, in the order in which the harness writes."""
    plain, out = trundle.Kinematics(case.robot).bind(), []
    for c in calls:
        out += plain.inverse(*c.twist)
        out += plain.forward(*c.wheel_speeds, *c.steering)
        out += plain.step(*c.pose, *c.increments, *c.steering)
    return out


@dataclass(frozen=True)
class Step:
    """What comes out of a cycle: numbers, and what is told beside them."""

    numbers: list[float]
    limits: int
    stale: int
    refused: int
    refused_counts: int

    @property
    def told(self) -> tuple[int, int, int]:
        """What does not hang on the last digit: stale, and what was refused."""
        return self.stale, self.refused, self.refused_counts


def steps(case: Case, cycles: list[Cycle]) -> list[Step]:
    """Return what Python's bridge does."""
    bridge = trundle.Bridge(case.robot, **case.settings)
    state, out = bridge.start(), []
    for c in cycles:
        o, state = bridge.step(state, c.us * MICRO, c.command, c.counts, c.steering)
        numbers = [*o.wheel_speeds, *o.rim_speeds, *o.rpm, *o.motor_rpm, *o.ticks, *o.steering]
        numbers += [*o.twist, *o.pose, *o.velocity]
        limits = sum(LIMITS[name] for name in set(o.limits))
        out.append(Step(numbers, limits, int(o.stale), state.refused, state.refused_counts))
    return out


def read_steps(values: list[bytes], real: Any, robot: Robot) -> list[Step]:
    """Return what the harness wrote of its cycles."""
    size = 5 * len(robot.driven) + len(robot.steered) + 9
    out = []
    for i in range(0, len(values), size + 4):
        numbers = [real(value) for value in values[i : i + size]]
        told = [int.from_bytes(value, "little") for value in values[i + size : i + size + 4]]
        out.append(Step(numbers, *told))
    return out
