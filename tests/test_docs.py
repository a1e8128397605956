"""The docs are true: their code runs, their commands end well and print what is shown, links lead
somewhere, and the tables of keys, warnings and readings are those of the code.

Every page is one session in one folder. Its fenced blocks run in order: ``python`` (with prompts as
a doctest), ``console`` (lines after ``$ trundle``; each line shown is really printed, ``...``
stands for any), and ``toml`` or ``csv`` after a line that ends in the file's name: that file.
"""

import ast
import doctest
import io
import re
import shlex
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

import trundle
from trundle import kinematics, odometry, robot
from trundle.cli import output
from trundle.cli.app import run

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"`([\w.-]+\.(?:toml|csv))`:$")
LINK = re.compile(r"\]\((?!https?:|mailto:)([^)\s]+)\)")
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE

each_page = pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])


class Block(NamedTuple):
    kind: str
    text: str
    line: int
    file: str | None  # the name that the line before gives it


def blocks(page):
    text = page.read_text(encoding="utf-8")
    for found in FENCE.finditer(text):
        before = text[: found.start()].rstrip()
        named = NAMED.search(before)
        line = text[: found.start()].count("\n") + 1
        yield Block(found[1], found[2], line, named[1] if named else None)


@pytest.mark.filterwarnings("ignore::trundle.errors.UnobservedMotionWarning")
@each_page
def test_page_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setattr(output.out, "width", 80)
    names = {"__name__": page.stem}
    for block in blocks(page):
        where = f"{page.name}:{block.line}"
        if block.kind == "python" and ">>> " in block.text:
            run_prompts(block, names, where)
        elif block.kind == "python":
            exec(compile(block.text, where, "exec"), names)
        elif block.kind == "console":
            run_commands(block, where, capsys)
        elif block.kind in ("toml", "csv") and block.file:
            Path(block.file).write_text(block.text, encoding="utf-8")


def run_prompts(block, names, where):
    test = doctest.DocTestParser().get_doctest(block.text, names, where, where, block.line)
    told = io.StringIO()
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    runner.run(test, out=told.write, clear_globs=False)
    names.update(test.globs)
    assert runner.failures == 0, told.getvalue()


def run_commands(block, where, capsys):
    for part in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
        command, _, shown = part.partition("\n")
        if not command.startswith("trundle "):
            continue
        capsys.readouterr()
        code = run(shlex.split(command, comments=True)[1:])
        told = capsys.readouterr()
        assert code == 0, f"{where}: {command}: exit {code}\n{told.out}{told.err}"
        printed = " ".join(told.out.replace("\\", "/").split())
        for line in shown.splitlines():
            wanted = " ".join(line.split())
            assert wanted == "..." or wanted in printed, (
                f"{where}: `{command}` does not print {wanted!r}, but:\n{told.out}"
            )


@each_page
def test_robots_in_pages_load(page):
    for block in blocks(page):
        if block.kind == "toml":
            made = trundle.robot_from_dict({"name": "robot"} | tomllib.loads(block.text))
            assert kinematics.diagnose(made) == (), f"{page.name}:{block.line}: has warnings"


@each_page
def test_links_lead_somewhere(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    for target in LINK.findall(text):
        name, _, anchor = target.partition("#")
        there = page.parent / name if name else page
        assert there.exists(), f"{page.name}: {target} is not there"
        if anchor:
            assert anchor in anchors(there), f"{page.name}: {target}: no such heading"


def anchors(page):
    """Return the anchors that GitHub gives a page's headings."""
    heads = re.findall(r"^#+ (.*)$", FENCE.sub("", page.read_text(encoding="utf-8")), re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", head.lower()) for head in heads)
    return {head.replace(" ", "-") for head in plain}


def test_every_page_is_in_the_index():
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    missing = [p.name for p in PAGES[1:] if p.name != "README.md" and f"({p.name})" not in index]
    assert not missing
    examples = sorted((ROOT / "examples").glob("*.py"))
    assert [e.name for e in examples if f"(../examples/{e.name})" not in index] == []


def table(page, head):
    """Return the rows of the table whose header starts with a text, as lists of cells."""
    lines = (ROOT / "docs" / page).read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {head} |")) + 2
    rows = []
    for line in lines[start:]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]])
    return rows


def code(cell):
    return re.findall(r"`([^`]+)`", cell)


KINDS = ("fixed", "steered", "caster", "omni", "mecanum", "ball", "swedish")


def kinds(cell):
    """Return the kinds of wheel in a cell such as "all but caster, ball"."""
    chosen, _, left_out = cell.partition(" but ")
    if chosen == "all":
        return set(KINDS) - set(left_out.split(", "))
    return set(cell.split(", "))


def defaults(definition):
    """Return a schema definition's keys with "required", their default, or None."""
    required = definition.get("required", ())
    return {
        key: "required" if key in required else item.get("default")
        for key, item in definition["properties"].items()
    }


def as_default(cell):
    words = {"required": "required", "false": False, "none": None}
    words |= {"by kind": None, "by wheel": None}
    return words[cell] if cell in words else float(cell)


def test_wheel_keys_are_those_of_the_schema():
    definitions = robot.json_schema()["$defs"]
    told = {}
    for cell, of, default, _ in table("your-robot.md", "key of `[[wheel]]`"):
        for kind in kinds(of):
            (key,) = code(cell)
            assert (kind, key) not in told
            told[kind, key] = as_default(default)
    true = {
        (kind, key): default
        for kind in KINDS
        for key, default in defaults(definitions[f"{kind.capitalize()}Wheel"]).items()
    }
    assert told == true


@pytest.mark.parametrize(
    ("head", "name"), [("`encoder`", "Encoder"), ("`motor`", "Motor"), ("`[body]`", "Body")]
)
def test_other_keys_are_those_of_the_schema(head, name):
    told = {code(cell)[0]: as_default(d) for cell, d, _ in table("your-robot.md", f"key of {head}")}
    assert told == defaults(robot.json_schema()["$defs"][name])


def doctor_codes():
    """Return the codes of all ``Finding(...)`` in the source of the kinematics."""
    for path in Path(kinematics.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "Finding":
                (first, *_) = node.args
                assert isinstance(first, ast.Constant)
                yield first.value


def test_every_warning_of_the_doctor_is_explained():
    rows = table("your-robot.md", "code")
    assert {code(cell)[0] for cell, _, _ in rows} == set(doctor_codes())
    assert all(meaning and remedy for _, meaning, remedy in rows)


def test_readings_of_logs_are_those_of_the_code():
    told = [code(cell)[0] for cell, _ in table("logs.md", "READING")]
    assert told == list(odometry.READINGS)


def test_no_console_block_is_left_out():
    """A prompt that is not ours would not run: only ``$ trundle`` and ``$ make`` are shown."""
    for page in PAGES:
        for block in blocks(page):
            if block.kind == "console":
                starts = re.findall(r"^\$ (\w+)", block.text, re.MULTILINE)
                assert starts, f"{page.name}:{block.line}: no command"
                assert set(starts) <= {"trundle", "make"}, f"{page.name}:{block.line}"
