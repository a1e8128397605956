"""Timing of candidates side by side, each in a process of its own, and tables of the results.

A candidate's process builds what it needs, tells its answer, and then times its statement whenever
it is asked. The candidates are asked in turn, round after round, so that a busy machine slows all
of them alike, and ratios are taken within a round.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import platform
import statistics
import subprocess
import sys
import timeit
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"


@dataclass(frozen=True)
class Job:
    """What a candidate's process times.

    Attributes:
        statement: the code, run over and over in a loop of timeit.
        names: the values of its names, which are local: bound once, outside the loop.
        answer: the numbers that all candidates of a task must agree on.
        count: calls or steps in one statement.
    """

    statement: str
    names: Mapping[str, object]
    answer: Iterable[float] = ()
    count: int = 1


@dataclass(frozen=True)
class Options:
    """How much to measure: processes of each candidate, rounds in each, seconds in each round."""

    processes: int
    rounds: int
    seconds: float
    smoke: bool
    write: bool
    candidate: str | None


def read_options(description: str | None, processes: int, rounds: int, seconds: float) -> Options:
    parser = argparse.ArgumentParser(description=(description or "").partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=rounds, help="rounds in each process")
    parser.add_argument("--smoke", action="store_true", help="tiny sizes: only see that it runs")
    parser.add_argument("--write", action="store_true", help=f"put the tables into {PAGE.name}")
    parser.add_argument("--candidate", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.rounds < 2:
        parser.error("a median needs at least 2 rounds")
    if given.smoke:
        processes, given.rounds, seconds = 1, 2, 1e-4
    return Options(processes, given.rounds, seconds, given.smoke, given.write, given.candidate)


# ---- one candidate ---------------------------------------------------------------------------


def serve(job: Job) -> None:
    """Tell the job's answer, then time its statement as often as each line of input says."""
    setup = "\n".join(f"{name} = given[{name!r}]" for name in job.names)
    timer = timeit.Timer(job.statement, setup or "pass", globals={"given": job.names})
    print(json.dumps({"answer": [float(x) for x in job.answer], "count": job.count}), flush=True)
    for line in sys.stdin:
        print(timer.timeit(int(line)), flush=True)


class Candidate:
    """The process that times one candidate."""

    def __init__(self, name: str, smoke: bool) -> None:
        command = [sys.executable, sys.argv[0], "--candidate", name, *["--smoke"][:smoke]]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment()
        )
        self.name, self.number = name, 1

    def read(self) -> str:
        assert self._process.stdout is not None
        if not (line := self._process.stdout.readline()):
            raise SystemExit(f"the process of {self.name!r} ended early")
        return line

    def seconds(self, number: int) -> float:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{number}\n")
        self._process.stdin.flush()
        return float(self.read())

    def close(self) -> None:
        self._process.communicate()

    def calibrate(self, seconds: float) -> None:
        """Choose how often to run the statement in a round; this warms the process up as well."""
        while (taken := self.seconds(self.number)) < seconds / 4:
            self.number *= 4
        self.number = max(1, round(self.number * seconds / taken))


def environment() -> dict[str, str]:
    """Return the environment of the timed processes, in which BLAS chooses its own settings."""
    return {k: v for k, v in os.environ.items() if not k.startswith("OPENBLAS_")}


# ---- all candidates --------------------------------------------------------------------------


@dataclass(frozen=True)
class Results:
    """Seconds per call or step of each candidate, round by round, and the candidates' answers."""

    times: Mapping[str, list[float]]
    answers: Mapping[str, list[float]]

    def median(self, name: str) -> float:
        return statistics.median(self.times[name])

    def ratio(self, name: str, reference: str) -> tuple[float, float, float]:
        """Return the median of the ratios within each round, and their quartiles."""
        both = zip(self.times[name], self.times[reference], strict=True)
        low, middle, high = statistics.quantiles([a / b for a, b in both], method="inclusive")
        return middle, low, high

    def ratio_text(self, name: str, reference: str) -> str:
        middle, low, high = self.ratio(name, reference)
        return f"{as_ratio(middle)} ({as_ratio(low)} to {as_ratio(high)})"

    def assert_agreement(self, names: Sequence[str], relative: float) -> None:
        first = self.answers[names[0]]
        for name in names[1:]:
            other = self.answers[name]
            if len(other) != len(first) or not all(
                math.isclose(a, b, rel_tol=relative, abs_tol=relative)
                for a, b in zip(first, other, strict=True)
            ):
                raise SystemExit(f"{names[0]} and {name} disagree: {first} and {other}")


def measure(jobs: Mapping[str, Callable[[], Job]], options: Options) -> Results:
    """Time all jobs in turn, each in its own process, and start new processes in between."""
    times: dict[str, list[float]] = {name: [] for name in jobs}
    answers: dict[str, list[float]] = {}
    for _ in range(options.processes):
        with candidates(jobs, options.smoke) as running:
            counts = {}
            for each in running:
                told = json.loads(each.read())
                answers[each.name], counts[each.name] = told["answer"], told["count"]
            for each in running:
                each.calibrate(options.seconds)
            for k in range(options.rounds):
                for each in running if k % 2 == 0 else reversed(running):
                    taken = each.seconds(each.number) / each.number
                    times[each.name].append(taken / counts[each.name])
    return Results(times, answers)


@contextlib.contextmanager
def candidates(names: Mapping[str, object], smoke: bool) -> Iterator[list[Candidate]]:
    running = [Candidate(name, smoke) for name in names]
    try:
        yield running
    finally:
        for each in running:
            each.close()


# ---- tables ----------------------------------------------------------------------------------


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table with its columns aligned; numbers stand in all but the first."""
    widths = [max(len(row[i]) for row in (header, *rows)) for i in range(len(header))]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    lines = []
    for row in (header, rule, *rows):
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def machine(*packages: str) -> str:
    """Return the machine and the versions in words."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = info.read_text(encoding="utf-8").splitlines()
        named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
        model = named[0] if named else model
    parts = [f"{model}, {os.cpu_count()} cores", f"Python {platform.python_version()}"]
    parts += [f"{package} {metadata.version(package)}" for package in packages]
    return "; ".join(parts)


def as_ratio(value: float) -> str:
    if value < 0.1:
        return f"1/{1 / value:.0f}"
    return f"{value:.2f}" if value < 10 else f"{value:.0f}"


def as_digits(value: float) -> str:
    return f"{value:.0f}" if value >= 10 else f"{value:.1f}"


def verdict(value: float, limit: float) -> str:
    return f"at most {as_ratio(limit)}: {'met' if value <= limit else 'missed'}"


def publish(name: str, text: str, options: Options) -> None:
    """Print a benchmark's text; with --write, put it between its markers on the page too."""
    print(f"{text}\n")
    if options.smoke:
        print("This was a smoke run: its figures mean nothing.\n")
    if not options.write:
        return
    begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->"
    page = PAGE.read_text(encoding="utf-8")
    if begin not in page or end not in page:
        raise SystemExit(f"{PAGE} has no lines {begin.strip()} and {end}")
    head, tail = page.partition(begin)[0], page.partition(end)[2]
    PAGE.write_text(f"{head}{begin}\n{text}\n\n{end}{tail}", encoding="utf-8")
    print(f"Written to {PAGE}.")
