"""Rollouts of many robots: trundle.compile_rollout beside NumPy, JAX, and the machine's limits.

Streamed and constant wheel commands, noise, computed torque, a tick of MPPI, and a single robot:
one step from Python, and a long run by feedback.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec

import _batch_trundle as ours
import _limits as limits
from _batch_tasks import FULL, SMOKE, Sizes
from _batch_workloads import (
    LIMIT_32,
    LIMIT_64,
    MUJOCO,
    NUMPY_64,
    OURS,
    TIMES_JAX,
    TRUNDLE,
    Jobs,
    Single,
    Workload,
    chosen,
    singles,
    workloads,
)
from _common import (
    PAGE,
    Options,
    Results,
    environment,
    machine,
    measure,
    publish,
    read_options,
    serve,
    table,
    verdict,
)

# ---- tables ----------------------------------------------------------------------------------


def as_three(value: float) -> str:
    """Return three digits at least, and all before the point."""
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def as_share(value: float) -> str:
    return f"{100 * value:.0f} %"


def wanted(value: float, least: float, what: str) -> str:
    """Return whether a ratio of rates is high enough."""
    return f"{what}: {'met' if value >= least else 'missed'}"


def row(work: Workload, results: Results, name: str) -> list[str]:
    """Return a candidate's rate, its ratios to NumPy, JAX and the limit, and what is required."""
    key, dtype = work.key(name), name.rpartition(", ")[2]
    jax, limit = work.key(f"JAX, {dtype}"), work.key(f"the limit, {dtype}")
    cells = [name, as_three(1e-6 / results.median(key)), "", "", "", ""]
    cells[2] = "1" if name == work.reference else ""
    told = []
    if name not in (work.reference, LIMIT_32, LIMIT_64):
        cells[2] = results.ratio_text(work.key(work.reference), key)
    if least := work.required.get(name):
        value = results.ratio(work.key(work.reference), key)[0]
        told.append(wanted(value, least, f"{least:g} times NumPy"))
    if name in OURS and jax in results.times:
        cells[3] = results.ratio_text(jax, key)
        told.append(wanted(results.ratio(jax, key)[0], TIMES_JAX, f"{TIMES_JAX:g} times JAX"))
    if least := work.share.get(name):
        value, low, high = results.ratio(limit, key)
        cells[4] = f"{as_share(value)} ({as_share(low)} to {as_share(high)})"
        told.append(wanted(value, least, f"{as_share(least)} of the limit"))
    cells[5] = "; ".join(told)
    return cells


def work_table(work: Workload, jobs: Jobs, results: Results) -> str:
    limit = f"of the limit, {work.limit}" if work.limit else "of a limit"
    header = [
        work.title,
        "M robot-steps/s",
        f"times {work.reference}",
        "times JAX",
        limit,
        "required",
    ]
    rows = [row(work, results, name) for name in jobs]
    used = [i for i in range(len(header)) if i < 2 or any(cells[i] for cells in rows)]
    return table([header[i] for i in used], [[cells[i] for i in used] for cells in rows])


def single_table(task: Single, jobs: Jobs, results: Results) -> str:
    unit, many = task.unit
    rows = []
    for name in jobs:
        key, reference = task.key(name), task.key(task.reference)
        told = []
        if name == TRUNDLE and task.ratio:
            told.append(verdict(results.ratio(key, reference)[0], task.ratio))
        if name == TRUNDLE and task.seconds:
            met = "met" if results.median(key) < task.seconds else "missed"
            told.append(f"under {many * task.seconds:g} {unit}: {met}")
        ratio = "1" if key == reference else results.ratio_text(key, reference)
        rows.append([name, as_three(many * results.median(key)), ratio, "; ".join(told)])
    return table([task.title, unit, f"ratio to {task.reference}", "required"], rows)


# ---- what is told by a process of its own ----------------------------------------------------

ERROR, ARITHMETIC = "error of float32", "operations"
REQUIRED_ERROR = 1e-4


def tell(name: str, size: Sizes) -> list[float]:
    if name == ERROR:
        return [ours.error(size)]
    return [limits.arithmetic(dtype, size is SMOKE) for dtype in ("float32", "float64")]


def told_by(name: str, options: Options) -> list[float]:
    command = [sys.executable, sys.argv[0], "--candidate", name, *["--smoke"][: options.smoke]]
    found: list[float] = json.loads(subprocess.check_output(command, env=environment(), text=True))
    return found


# ---- the comparison --------------------------------------------------------------------------


def run(work: Workload | Single, options: Options) -> tuple[Jobs, Results]:
    """Time a task's candidates, and see that they agree."""
    jobs = chosen(work.jobs, options.smoke)
    results = measure({work.key(name): job for name, job in jobs.items()}, options)
    same = [name for name in jobs if name not in (MUJOCO, LIMIT_32, LIMIT_64)]
    if isinstance(work, Single):
        results.assert_agreement([work.key(name) for name in same], work.tolerance)
        return jobs, results
    double = [name for name in same if "float32" not in name]
    results.assert_agreement([work.key(name) for name in double], work.double)
    single = [NUMPY_64, *(name for name in same if "float32" in name)]
    results.assert_agreement([work.key(name) for name in single], work.single)
    return jobs, results


def bandwidths(all_: list[tuple[Workload, Jobs, Results]]) -> str:
    """Return what the limits are, in words."""
    parts = []
    for work, _, results in all_:
        rates = [
            f"{1e-9 * results.answers[key][0] / results.median(key):.1f}"
            for name in (LIMIT_32, LIMIT_64)
            if (key := work.key(name)) in results.times
        ]
        if rates:
            parts.append(f"{work.limit} {' and '.join(rates)} GB/s")
    return ", ".join(parts)


def chart(all_: list[tuple[Workload, Jobs, Results]], note: str, options: Options) -> None:
    """Draw the rates; with --write, into the docs."""
    # Not for the candidates' processes: they start sooner without.
    from _batch_picture import bar_chart

    from trundle.view import save

    rates, marks = {}, {}
    for work, jobs, results in all_:
        rate = {name: 1e-6 / results.median(work.key(name)) for name in jobs}
        rates[work.title] = rate
        marks[work.title] = {
            name: rate[limit]
            for name in OURS
            if (limit := name.replace("trundle", "the limit")) in rate
        }
    figure = bar_chart(rates, marks, note)
    if options.write:
        save(figure, PICTURE)


NOTES = """\
{robots:,} robots with four mecanum wheels, {steps} steps in a call; every candidate in a process of
its own, with the threads that its library takes by itself ({threads} for trundle). Ratios are
medians over rounds in which all take their turn, in parentheses their quartiles. trundle is called
as a user of `compile_rollout` calls it, with `out=` memory that is there. NumPy computes on whole
arrays over all robots; JAX by `jit(vmap(scan))` on the processor, its commands in one array for
each wheel, the layout that it reads fastest. Both take three terms of sin(h)/h for the exact arc.
All are given the same commands, in arrays (steps, wheels, robots)."""
NOTES_LIMITS = """\
Limits of this machine with {threads} threads, each measured in the fastest of several ways and in
turn with the candidates: {bandwidths}; {single:.0f} GFLOP/s in single and {double:.0f} in double
precision."""
NOTES_ERROR = """\
After {steps:,} steps float32 has lost at most {error:.1e} of the distance driven, beside float64
with the same commands (required: below {limit:g}, {met})."""


def notes(size: Sizes, all_: list[tuple[Workload, Jobs, Results]], options: Options) -> str:
    """Return what was compared, the machine's limits, and the error of single precision."""
    threads = limits.threads()
    parts = [NOTES.format(robots=size.robots, steps=size.steps, threads=threads)]
    if find_spec("numba"):
        single, double = told_by(ARITHMETIC, options)
        parts.append(
            NOTES_LIMITS.format(
                threads=threads,
                bandwidths=bandwidths(all_),
                single=1e-9 * single,
                double=1e-9 * double,
            )
        )
    (error,) = told_by(ERROR, options)
    met = "met" if error < REQUIRED_ERROR else "missed"
    parts.append(
        NOTES_ERROR.format(steps=size.error_steps, error=error, limit=REQUIRED_ERROR, met=met)
    )
    return "\n\n".join(parts)


def main() -> None:
    options = read_options(__doc__, processes=2, rounds=6, seconds=0.2)
    size = SMOKE if options.smoke else FULL
    many, ones = workloads(size), singles(size)
    if options.candidate in (ERROR, ARITHMETIC):
        print(json.dumps(tell(options.candidate, size)))
        return
    if options.candidate:
        jobs = {work.key(name): job for work in (*many, *ones) for name, job in work.jobs.items()}
        serve(jobs[options.candidate]())
        return
    packages = say_what_is_absent()
    all_ = [(work, *run(work, options)) for work in many]
    parts = [f"## Many robots at once\n\n{machine(*packages)}.\n{notes(size, all_, options)}"]
    parts += [PICTURE_LINE, *(work_table(*each) for each in all_)]
    parts += [single_table(work, *run(work, options)) for work in ones]
    parts.append(REMARKS)
    chart(all_, machine(), options)
    publish("batches", "\n\n".join(parts), options)


def say_what_is_absent() -> list[str]:
    """Return the packages that are compared; print what is left out."""
    names = {"numba": "numba", "jax": "jax", "robotpy-wpimath": "wpimath", "mujoco": "mujoco"}
    here = {name for name, module in names.items() if find_spec(module)}
    for name in names.keys() - here:
        print(f"{name} is not installed: it is left out.")
    print()
    return ["numpy", *(name for name in names if name in here)]


PICTURE = PAGE.parent / "images" / "batches.png"
PICTURE_LINE = f"""\
![Million robot-steps per second of trundle, JAX and NumPy](images/{PICTURE.name})"""
REMARKS = """\
The lectures' loop and robotpy-wpimath take one robot in a loop in Python, a step at a time. MuJoCo
rolls out a thousand free planar bases under given forces; it does more: it solves the equations of
motion of any mechanism and stores every state. Where there is noise, each side draws its random
numbers by its own generator, anew in every call. All compute the same poses, or with noise the same
means and deviations."""


if __name__ == "__main__":
    main()
