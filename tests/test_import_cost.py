"""``import trundle`` loads numpy and nothing heavier."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trundle

HEAVY = {"matplotlib", "numba", "pydantic", "rich", "scipy", "sympy", "typer"}

# Far above a start of Python on a slow machine: it only ends a run that hangs.
TIMEOUT_S = 120


def packages_loaded_by(statement: str) -> set[str]:
    """Return the top-level packages that a statement loads in a fresh Python."""
    # What the start of Python loads (a .pth file of another package, say) is not counted.
    program = (
        "import sys; before = set(sys.modules)\n"
        f"{statement}\n"
        "print(*{name.partition('.')[0] for name in set(sys.modules) - before})"
    )
    here = str(Path(trundle.__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    run = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return set(run.stdout.split())


def test_import_trundle_loads_nothing_heavy():
    loaded = packages_loaded_by("import trundle")
    assert "trundle" in loaded
    assert not loaded & HEAVY


@pytest.mark.parametrize("name", ["matplotlib", "pydantic", "rich", "scipy", "sympy", "typer"])
def test_a_heavy_import_would_be_seen(name):
    assert name in packages_loaded_by(f"import {name}")
