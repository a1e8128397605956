"""One cycle of the bridge: printed C on this machine beside plain Python.

Every cycle has a reading of the counters, and every eighth a new command; the limits are in force
for most of the time. The C runs in a loop of its own, so that a call from Python does not count.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from _common import Job, Results, machine, measure, publish, read_options, serve, table, verdict

import trundle
from trundle.exchange import c_files

ROBOTS = ("differential", "omni3", "mecanum", "ackermann", "swerve", "mixed")
CYCLE_US, START_CYCLES = 20_000, 100
SETTINGS: dict[str, Any] = {
    "max_speed": 0.8, "max_reverse_speed": 0.5, "max_yaw_rate": 1.5, "max_acceleration": 2.0,
    "max_deceleration": 3.0, "max_yaw_acceleration": 5.0,
    "encoder": trundle.Encoder(ticks_per_motor_turn=2048),
}  # fmt: skip
COMMANDS = ((0.5, 0.1, 0.3), (0.2, -0.3, -0.4), (0.9, 0.0, 1.0), (0.4, 0.2, 0.1))
EVERY = 8
LOOP = """\
#include "trundle.h"
#include <stddef.h>

static const trundle_real commands[4][3] = {@COMMANDS@};
static trundle_state state;
static trundle_output output;
static uint32_t at;

static void cycle(void)
{
    uint32_t counts[TRUNDLE_COUNTERS];
    for (uint32_t i = 0; i < TRUNDLE_COUNTERS; i++) {
        counts[i] = (7 + i) * at;
    }
    trundle_step(&state, (at + 1) * @CYCLE@u, at % @EVERY@ ? NULL : commands[at / @EVERY@ % 4],
        counts @STEERING@, &output);
    at++;
}

void answer(double *to);
void run(long count);

void answer(double *to)
{
    trundle_start(&state, 0, NULL @STEERING@);
    for (at = 0; at < @START@;) {
        cycle();
    }
    for (int i = 0; i < 3; i++) {
        to[i] = (double)output.twist[i];
        to[3 + i] = (double)state.pose[i];
    }
}

void run(long count)
{
    for (long i = 0; i < count; i++) {
        cycle();
    }
}
"""
# Floats have 7 digits, and a hundred cycles add up their rounding.
AGREE = 1e-4
REQUIRED, REQUIRED_PYTHON = 500.0, 20_000.0  # [ns] a cycle
MANY = 1000  # cycles in one call from Python


def compiled(name: str, float_: bool) -> Job:
    robot = trundle.load(name)
    folder = Path(tempfile.mkdtemp(prefix="trundle-firmware-"))
    places = {
        "COMMANDS": ", ".join(
            "{" + ", ".join(f"(trundle_real){x}" for x in c) + "}" for c in COMMANDS
        ),
        "CYCLE": CYCLE_US,
        "EVERY": EVERY,
        "START": START_CYCLES,
        "STEERING": ", NULL" if robot.steered else "",
    }
    loop = LOOP
    for place, value in places.items():
        loop = loop.replace(f"@{place}@", str(value))
    for file, text in (c_files(robot, **SETTINGS) | {"loop.c": loop}).items():
        (folder / file).write_text(text, encoding="utf-8")
    flags = ["-std=c99", "-O2", "-shared", "-fPIC", *["-DTRUNDLE_FLOAT"][: int(float_)]]
    sources = [folder / "trundle.c", folder / "loop.c"]
    subprocess.run(["cc", *flags, *sources, "-o", folder / "loop.so", "-lm"], check=True)
    library = ctypes.CDLL(str(folder / "loop.so"))
    shutil.rmtree(folder)
    answer = (ctypes.c_double * 6)()
    library.answer(answer)
    return Job("run(many)", {"run": library.run, "many": ctypes.c_long(MANY)}, list(answer), MANY)


def python(name: str) -> Job:
    # These counts are of no motion that the wheels can make together: no slip is to be told.
    bridge = trundle.Bridge(trundle.load(name), slip_threshold=30.0, **SETTINGS)
    many = range(len(bridge.robot.sensed))
    state, output, at = bridge.start(), None, 0

    def cycle() -> None:
        nonlocal state, output, at
        command = None if at % EVERY else COMMANDS[at // EVERY % 4]
        counts = tuple([(7 + i) * at % 2**32 for i in many])
        output, state = bridge.step(state, (at + 1) * CYCLE_US * 1e-6, command, counts)
        at += 1

    for _ in range(START_CYCLES):
        cycle()
    assert output is not None
    return Job("cycle()", {"cycle": cycle}, [*output.twist, *state.pose])


DOUBLE, FLOAT, PYTHON = "C, double", "C, float", "Python"


def row(name: str, results: Results) -> list[str]:
    double, single, python = (f"{name}: {each}" for each in (DOUBLE, FLOAT, PYTHON))
    times = [f"{1e9 * results.median(each):.0f}" for each in (double, single, python)]
    met = verdict(1e9 * max(results.median(double), results.median(single)), REQUIRED)
    return [name, *times, met, verdict(1e9 * results.median(python), REQUIRED_PYTHON)]


def main() -> None:
    jobs = {}
    for name in ROBOTS:
        jobs[f"{name}: {DOUBLE}"] = partial(compiled, name, False)
        jobs[f"{name}: {FLOAT}"] = partial(compiled, name, True)
        jobs[f"{name}: {PYTHON}"] = partial(python, name)
    options = read_options(__doc__, processes=2, rounds=11, seconds=0.01)
    if options.candidate:
        serve(jobs[options.candidate]())
        return
    if shutil.which("cc") is None:
        print("There is no C compiler here: nothing is timed.")
        return
    results = measure(jobs, options)
    for name in ROBOTS:
        results.assert_agreement([f"{name}: {each}" for each in (PYTHON, DOUBLE, FLOAT)], AGREE)
    header = [
        "trundle on",
        f"{DOUBLE} [ns]",
        f"{FLOAT} [ns]",
        f"{PYTHON} [ns]",
        "required in C [ns]",
        "required in Python",
    ]
    rows = [row(name, results) for name in ROBOTS]
    text = f"## One cycle of the bridge\n\n{machine()}.\n{NOTES}\n\n{table(header, rows)}"
    publish("firmware", text, options)


NOTES = """\
`trundle_step` with a reading of the counters in every cycle and a new command in every eighth,
compiled by `cc -O2`, and the same by `Bridge.step`. Medians over rounds in which every candidate,
in a process of its own, takes its turn."""


if __name__ == "__main__":
    main()
