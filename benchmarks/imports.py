"""What ``import trundle`` costs beside ``import numpy``, and that it loads nothing heavier.

Each import is timed in fresh processes; the start of Python alone is taken off, round by round.
"""

from __future__ import annotations

import re
import statistics
import subprocess
import sys
import time

from _common import Results, environment, machine, publish, read_options, table

STATEMENTS = {
    "Python alone": "pass",
    "import numpy": "import numpy",
    "import trundle": "import trundle",
}
HEAVY = ("matplotlib", "numba", "pydantic", "rich", "scipy", "sympy", "typer")

NOTES = f"""\
Wall time of a fresh process, the start of Python taken off; medians over rounds, in parentheses the
quartiles of the ratios. "-X importtime" is what Python itself counts for the import, with what
trundle's own modules take of it. The same run checks that `import trundle` loads none of
{", ".join(HEAVY[:-1])} and {HEAVY[-1]}."""


def python(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )


def wall(statement: str) -> float:
    start = time.perf_counter()
    python("-c", statement)
    return time.perf_counter() - start


def heavy_loaded() -> list[str]:
    """Return the heavy packages that ``import trundle`` loads, beyond what Python starts with."""
    found = python(
        "-c",
        "import sys; before = set(sys.modules); import trundle; "
        "print(*{name.partition('.')[0] for name in set(sys.modules) - before})",
    ).stdout.split()
    assert "trundle" in found
    return sorted(set(found) & set(HEAVY))


def import_times() -> tuple[float, float]:
    """Return the time [s] of ``import trundle`` by Python's count, and its own modules' part."""
    lines = python("-X", "importtime", "-c", "import trundle").stderr.splitlines()
    total = own = 0.0
    for line in lines:
        if not (match := re.match(r"import time:\s*(\d+) \|\s*(\d+) \| \s*(\S+)$", line)):
            continue
        alone, cumulative, name = int(match[1]), int(match[2]), match[3]
        if name == "trundle":
            total = cumulative * 1e-6
        if name.partition(".")[0] == "trundle":
            own += alone * 1e-6
    return total, own


def main() -> None:
    options = read_options(__doc__, processes=1, rounds=25, seconds=0.0)
    if heavy := heavy_loaded():
        raise SystemExit(f"import trundle loads {', '.join(heavy)}")
    times: dict[str, list[float]] = {name: [] for name in STATEMENTS}
    counted, own = [], []
    for _ in range(options.rounds):
        taken = {name: wall(statement) for name, statement in STATEMENTS.items()}
        for name, seconds in taken.items():
            times[name].append(seconds - (name != "Python alone") * taken["Python alone"])
        total, part = import_times()
        counted.append(total)
        own.append(part)
    results = Results(times, {})
    rows = [
        [name, f"{1e3 * results.median(name):.0f}", results.ratio_text(name, "import numpy")]
        for name in STATEMENTS
    ]
    rows[1][2] = "1"
    rows.append(["import trundle, -X importtime", f"{1e3 * statistics.median(counted):.0f}", ""])
    rows.append(["its own modules", f"{1e3 * statistics.median(own):.0f}", ""])
    text = f"## Import\n\n{machine('numpy')}.\n{NOTES}"
    publish("imports", f"{text}\n\n{table(['', 'ms', 'ratio to numpy'], rows)}", options)


if __name__ == "__main__":
    main()
