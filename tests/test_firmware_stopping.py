"""Without commands a robot stops in time: in Python, in C, and on emulated processors."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

import trundle
from firmware_tools import AVR, CORTEX_M3, HERE, HOST, Target, build, reals, run, write
from firmware_vectors import Call, Case, Cycle, Step, gentle, read_steps, steps, vectors
from trundle.exchange import c_files

TARGETS = {
    "host": HOST,
    "host float": HOST.as_float(),
    "cortex m3": CORTEX_M3,
    "cortex m3 float": CORTEX_M3.as_float(),
    "avr": AVR,
}
TIMEOUT, BRAKING, SPEED = 0.3, 2.0, 0.8
CASE = Case(
    trundle.load("mecanum"),
    {"timeout": TIMEOUT, "max_speed": SPEED, "max_acceleration": 4.0, "max_deceleration": BRAKING},
)
MINUTE = 60_000_000  # [us]
# Differences of floats with 7 digits, over a hundred of which a cycle is long.
FLOAT = 1e-4


def outcome(case: Case, cycles: list[Cycle], target: Target, folder: Path) -> list[Step]:
    robot = case.robot
    n, k, s = len(robot.driven), len(robot.sensed), len(robot.steered)
    call = Call((0.0,) * 3, (0.0,) * n, (0.0,) * k, (0.0,) * 3, (0.0,) * s)
    text = vectors([call], cycles, robot)
    folder = write(folder, c_files(robot, **case.settings) | {"vectors.h": text})
    values = run(target, build(target, folder, [HERE / "harness.c"]))
    return read_steps(values[n + s + 6 :], lambda v: reals(target, [v])[0], robot)


def twist(step: Step) -> list[float]:
    return step.numbers[-9:-6]


@pytest.mark.parametrize("period_us", [5_000, 20_000, 33_333])
@pytest.mark.parametrize("target", [*TARGETS, "python"])
def test_the_robot_rests_by_timeout_and_braking(target, period_us, tmp_path):
    last = 600_000  # the last command [us]; the clock wraps around at a second
    cycles = [
        Cycle(us, (0.6, -0.5, 0.9) if us <= last else None, None, None)
        for us in range(period_us, 1_800_000, period_us)
    ]
    if target == "python":
        done = steps(CASE, cycles)
    else:
        done = outcome(CASE, cycles, TARGETS[target], tmp_path)
    sent = max(c.us for c in cycles if c.command) / 1e6
    times = [c.us / 1e6 for c in cycles]
    speeds = [math.hypot(*twist(step)[:2]) for step in done]
    moving = [t for t, speed in zip(times, speeds, strict=True) if speed > 0]
    fastest = max(speeds)
    assert fastest == pytest.approx(math.hypot(0.6, 0.5), rel=FLOAT)
    assert sent + TIMEOUT - period_us / 1e6 < moving[-1] < sent + TIMEOUT + fastest / BRAKING
    # At rest for good, and never harder than the limit.
    assert [step.stale for step in done[-3:]] == [1, 1, 1]
    hardest = max((a - b) / (period_us / 1e6) for a, b in itertools.pairwise(speeds))
    assert hardest <= BRAKING * (1 + FLOAT)


@pytest.mark.parametrize("name", ["differential", "swerve"])
def test_an_old_command_never_becomes_young_again(name, tmp_path):
    """Story: ages in 32 bits of microseconds wrap around after 71.6 minutes."""
    case = gentle(name)
    wrap = 2**32
    late = [0, 100_000, *(wrap + us for us in range(-200_000, 400_000, 50_000)), 2 * wrap + 20_000]
    cycles = [Cycle(500_000, (0.5, 0.0, 0.0), None, None)]
    at = sorted(
        {600_000, *range(MINUTE, 3 * wrap, 20 * MINUTE), *(500_000 + us for us in late[2:])}
    )
    cycles += [Cycle(us, None, None, None) for us in at]
    done = outcome(case, cycles, HOST, tmp_path)
    assert not done[0].stale
    assert done[1].numbers[0] > 0
    for cycle, step in zip(cycles[2:], done[2:], strict=True):
        assert step.stale == 1, cycle.us
        assert step.numbers[-9:-6] == [0.0] * 3, cycle.us
