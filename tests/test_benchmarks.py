"""Every benchmark runs, its candidates agree on the numbers, and it prints a table.

No time is asserted: machines differ, and `make bench` tells the ratios.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trundle

FOLDER = Path(__file__).parents[1] / "benchmarks"
SCRIPTS = sorted(path.name for path in FOLDER.glob("[a-z]*.py"))

# Far above a smoke run on a slow machine: it only ends a run that hangs.
TIMEOUT_S = 300


def run(script: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    here = str(Path(trundle.__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    return subprocess.run(
        [sys.executable, str(script), *arguments],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )


def test_the_benchmarks_are_found():
    wanted = {"batches.py", "single_step.py", "rollout.py", "closed_loop.py", "imports.py"}
    assert wanted <= set(SCRIPTS)


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_benchmark_runs_and_prints_its_table(name):
    done = run(FOLDER / name, "--smoke")
    assert done.returncode == 0, done.stderr
    tables = [line for line in done.stdout.splitlines() if line.startswith("|")]
    assert sum(line.startswith("| ---") for line in tables) >= 1
    assert any("trundle" in line for line in tables)


def test_candidates_that_disagree_end_the_run(tmp_path):
    source = (FOLDER / "rollout.py").read_text(encoding="utf-8")
    wrong = source.replace("dt * (J @ W @ omega[k])", "dt * (J @ W @ omega[k - 1])")
    assert wrong != source
    for name, text in {
        "rollout.py": wrong,
        "_common.py": (FOLDER / "_common.py").read_text(encoding="utf-8"),
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = run(tmp_path / "rollout.py", "--smoke")
    assert done.returncode != 0
    assert "disagree" in done.stderr
