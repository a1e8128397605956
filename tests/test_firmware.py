"""Firmware answers as Python does: on this machine, on a Cortex-M3 and on an AVR, emulated."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from firmware_tools import AVR, CORTEX_M3, HERE, HOST, Target, build, reals, run, write
from firmware_vectors import (
    Call,
    Case,
    Cycle,
    Step,
    answers,
    bare,
    gentle,
    limited,
    random_calls,
    random_cycles,
    read_steps,
    steps,
    vectors,
)
from trundle.exchange import c_files
from trundle.robot import CATALOG

CASES = {"bare": bare, "limited": limited, "gentle": gentle}
# Doubles, the same formulas in the same order; only sines and roots may round otherwise.
SAME = 1e-12
# Floats have 7 digits, and a hundred cycles add up their rounding.
FLOAT = 2e-4
# One of each kind of wheel and of steering: alone, linked, beside fixed wheels, with dead wheels.
ON_AVR = (
    "differential", "ackermann", "omni3", "mecanum", "swerve", "four_wheel_steered", "skid_steer",
    "mixed",
)  # fmt: skip

each_robot = pytest.mark.parametrize("name", CATALOG)


class Asked(NamedTuple):
    """What is asked of a robot's firmware, and what Python answers."""

    case: Case
    calls: list[Call]
    cycles: list[Cycle]
    answers: list[float]
    steps: list[Step]


@cache
def asked(name: str, kind: str) -> Asked:
    case = CASES[kind](name)
    calls, cycles = random_calls(case, 1), random_cycles(case, 2)
    return Asked(case, calls, cycles, answers(case, calls), steps(case, cycles))


def outcome(it: Asked, target: Target, folder: Path) -> tuple[list[float], list[Step]]:
    """Return what the firmware answers on a target: the calls' numbers, and the cycles."""
    files = c_files(it.case.robot, **it.case.settings)
    write(folder, files | {"vectors.h": vectors(it.calls, it.cycles, it.case.robot)})
    values = run(target, build(target, folder, [HERE / "harness.c"]))
    count = len(it.answers)
    done = read_steps(values[count:], lambda v: reals(target, [v])[0], it.case.robot)
    return reals(target, values[:count]), done


def agrees(it: Asked, target: Target, folder: Path, tolerance: float) -> list[Step]:
    """Assert that the firmware answers as Python does."""
    got, done = outcome(it, target, folder)
    assert got == pytest.approx(it.answers, rel=tolerance, abs=tolerance)
    for i, (have, want) in enumerate(zip(done, it.steps, strict=True)):
        assert have.told == want.told, f"cycle {i}"
        close = pytest.approx(want.numbers, rel=tolerance, abs=tolerance)
        assert have.numbers == close, f"cycle {i}"
    return done


@each_robot
@pytest.mark.parametrize("kind", ["bare", "limited"])
def test_doubles_are_pythons_under_sanitizers(name, kind, tmp_path):
    it = asked(name, kind)
    done = agrees(it, HOST, tmp_path, SAME)
    assert [step.limits for step in done] == [step.limits for step in it.steps]


# A bicycle without limits turns its front wheel across its way: the counters then tell of thousands
# of rad/s, whose angles floats do not hold.
@pytest.mark.parametrize(
    ("name", "kind"),
    [(n, k) for n in CATALOG for k in ("bare", "gentle") if (n, k) != ("bicycle", "bare")],
)
def test_floats_are_nearly_pythons_under_sanitizers(name, kind, tmp_path):
    agrees(asked(name, kind), HOST.as_float(), tmp_path, FLOAT)


@each_robot
def test_an_emulated_cortex_m3_answers_in_doubles(name, tmp_path):
    agrees(asked(name, "gentle"), CORTEX_M3, tmp_path, SAME)


@each_robot
def test_an_emulated_cortex_m3_answers_in_floats(name, tmp_path):
    agrees(asked(name, "gentle"), CORTEX_M3.as_float(), tmp_path, FLOAT)


@pytest.mark.parametrize("name", ON_AVR)
def test_an_emulated_avr_answers(name, tmp_path):
    agrees(asked(name, "gentle"), AVR, tmp_path, FLOAT)


def test_the_driving_shows_all_that_is_told():
    """The other tests compare; this one holds that there is something to compare."""
    limited = {name: asked(name, "limited").steps for name in CATALOG}
    told = [step for done in limited.values() for step in done]
    told += asked("mecanum", "gentle").steps
    for bit in (1, 2, 4, 8, 16, 32, 64):
        assert any(step.limits & bit for step in told), f"limit {bit}"
    for name, done in limited.items():
        assert any(step.stale for step in done), name
        assert any(not step.stale for step in done), name
        assert done[-1].refused, name
        assert done[-1].refused_counts, name
        # The body moves: its twist, its pose and its measured velocity.
        for place in (-9, -6, -5, -3):
            assert any(step.numbers[place] for step in done), f"{name}: {place}"
