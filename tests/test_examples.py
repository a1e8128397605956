"""Every example runs by itself, is short, and checks its own numbers."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import trundle

FOLDER = Path(__file__).parents[1] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
FORM = re.compile(r"\d\d_[a-z0-9_]+\.py")
LINES_BELOW = 60

# An example takes seconds, an animation on a slow machine a minute: this ends one that hangs.
TIMEOUT_S = 300

each_example = pytest.mark.parametrize(
    "example", EXAMPLES, ids=[example.stem for example in EXAMPLES]
)


def test_there_are_examples_and_each_has_its_own_number():
    assert EXAMPLES, f"no examples in {FOLDER}"
    misnamed = [example.name for example in EXAMPLES if not FORM.fullmatch(example.name)]
    assert not misnamed, f"an example is named like 01_first_robot.py: {misnamed}"
    numbers = [example.name[:2] for example in EXAMPLES]
    assert len(set(numbers)) == len(numbers), f"two examples share a number: {numbers}"


@each_example
def test_example_is_short(example):
    lines = len(example.read_text(encoding="utf-8").splitlines())
    assert lines < LINES_BELOW, f"{example.name} has {lines} lines; fewer than {LINES_BELOW} fit"


@each_example
def test_example_checks_its_numbers(example):
    tree = ast.parse(example.read_text(encoding="utf-8"))
    checks = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Assert)
        or (isinstance(node, ast.Call) and "assert" in ast.unparse(node.func))
    ]
    assert checks, f"{example.name} asserts nothing"


@each_example
def test_example_runs(example, tmp_path):
    here = str(Path(trundle.__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    run = subprocess.run(
        [sys.executable, str(example)],
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": "Agg", "PYTHONPATH": path},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert run.returncode == 0, f"{example.name} failed:\n{run.stdout}\n{run.stderr}"
