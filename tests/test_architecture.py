"""The floors of the design: who may import whom inside ``src/trundle``, read from the source."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

PACKAGE = "trundle"
SOURCE = Path(__file__).parents[1] / "src" / PACKAGE

# The one table of rooms: a room imports only from rooms on floors below its own.
FLOORS = (
    ("errors", "se2"),
    ("robot",),
    ("kinematics",),
    ("dynamics", "motion", "odometry", "symbolic"),
    ("limits", "simulation"),
    ("control", "bridge", "exchange"),
    ("links", "view"),
    ("cli",),
)
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
IMPORTED_ONLY_BY = {"symbolic": {"cli", "exchange"}, "view": {"cli"}}
FACE = ""  # trundle/__init__.py
NOT_LOADED_BY_FACE = {"view", "cli"}


@dataclass(frozen=True)
class Import:
    """One imported module or name, absolute; lazy when it does not run with its module."""

    target: tuple[str, ...]  # parts after the package's name, such as ("robot", "Robot")
    line: int
    lazy: bool


def find_violations(source: Path) -> list[str]:
    """Return a sentence for every import in a package's source that breaks the design."""
    violations = []
    for path in sorted(source.rglob("*.py")):
        inside = path.relative_to(source)
        room = room_of(inside)
        if room not in FLOOR_OF and room != FACE:
            violations.append(f"{inside.as_posix()}: '{room}' is not in the table of rooms")
            continue
        for item in imports(path, inside):
            fault = fault_of(room, item, source)
            if fault:
                violations.append(f"{inside.as_posix()}:{item.line}: {fault}")
    return violations


def room_of(inside: Path) -> str:
    """Return the room of a file; ``__main__.py`` only starts the command."""
    if len(inside.parts) > 1:
        return inside.parts[0]
    return {"__init__": FACE, "__main__": "cli"}.get(inside.stem, inside.stem)


def imports(path: Path, inside: Path) -> Iterator[Import]:
    """Yield every import of our own package in a file, wherever in the file it stands."""
    package = (PACKAGE, *inside.parent.parts)

    def visit(node: ast.AST, lazy: bool) -> Iterator[Import]:
        for name in imported_by(node, package):
            if name[0] == PACKAGE:
                yield Import(name[1:], node.lineno, lazy)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            children = [(child, child in node.body) for child in ast.iter_child_nodes(node)]
        else:
            deferred = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            children = [(child, deferred) for child in ast.iter_child_nodes(node)]
        for child, deferred in children:
            yield from visit(child, lazy or deferred)

    return visit(ast.parse(path.read_text(encoding="utf-8"), str(path)), False)


def imported_by(node: ast.AST, package: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Yield the absolute names that one statement or call imports."""
    if isinstance(node, ast.Import):
        yield from (tuple(alias.name.split(".")) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = package[: len(package) - node.level + 1] if node.level else ()
        module = (*base, *(node.module.split(".") if node.module else ()))
        yield from ((*module, alias.name) for alias in node.names)
    elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
        called = ast.unparse(node.func).rpartition(".")[2]
        if called in {"import_module", "__import__"}:
            name = str(node.args[0].value)
            level = len(name) - len(name.lstrip("."))
            base = package[: len(package) - level + 1] if level else ()
            yield (*base, *name.lstrip(".").split("."))


def fault_of(room: str, item: Import, source: Path) -> str | None:
    """Return what is wrong with one import of a room (or of the face), or None."""
    target = item.target[0] if item.target else FACE
    if target == room:
        return None
    if target not in FLOOR_OF:
        if room in {"cli", FACE}:
            return None
        return f"{room} imports the face 'trundle'; only cli may, rooms import from rooms"
    if room == FACE:
        if target in NOT_LOADED_BY_FACE and not item.lazy:
            return f"the face loads {target} at import; load it in __getattr__"
    elif FLOOR_OF[target] >= FLOOR_OF[room]:
        return (
            f"{room} (floor {FLOOR_OF[room]}) imports {target} (floor {FLOOR_OF[target]}); "
            "a room imports only from floors below"
        )
    elif room not in IMPORTED_ONLY_BY.get(target, {room}):
        return f"{room} imports {target}, which only {sorted(IMPORTED_ONLY_BY[target])} may"
    return fault_of_reach(item, source)


def fault_of_reach(item: Import, source: Path) -> str | None:
    """Return what is wrong when an import takes more of a room than it offers, or None."""
    room, *names = item.target
    init = source / room / "__init__.py"
    if not init.exists():  # one file is its own face
        return None
    offered = public_names(init)
    if len(names) == 1 and names[0] in offered:
        return None
    asked = ".".join([PACKAGE, room, *names])
    return f"'{asked}': write 'from {PACKAGE}.{room} import NAME' with a NAME in its __all__"


def public_names(init: Path) -> set[str]:
    """Return what ``__all__`` lists in a file."""
    names: set[str] = set()
    for node in ast.parse(init.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign) and node.value:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(ast.unparse(target) == "__all__" for target in targets):
                names.update(ast.literal_eval(node.value))
    return names


def test_the_source_keeps_to_the_floors():
    assert len(list(SOURCE.rglob("*.py"))) > 1, f"no source in {SOURCE}"
    violations = find_violations(SOURCE)
    assert not violations, "\n" + "\n".join(violations)


def test_a_sound_tree_has_no_violation(tmp_path):
    assert find_violations(write_tree(tmp_path, {})) == []


SOUND = {
    "__init__.py": (
        "from trundle.robot import Robot\n"
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    from trundle.view import draw\n"
        "def __getattr__(name):\n    from trundle.view import draw\n"
    ),
    "__main__.py": "from trundle.cli import main\n",
    "errors.py": "class TrundleError(ValueError): ...\n",
    "se2.py": "import numpy as np\n",
    "robot/__init__.py": "from trundle.robot.robot import Robot\n__all__ = ['Robot']\n",
    "robot/robot.py": "from ..errors import TrundleError\nfrom .wheels import Fixed\n",
    "robot/wheels.py": "from trundle import se2\nimport trundle.errors\n",
    "kinematics/__init__.py": "__all__: list[str] = []\n__all__ += ['forward']\n",
    "kinematics/forward.py": "from trundle.robot import Robot\n",
    "symbolic.py": "from trundle.kinematics import forward\n",
    "odometry.py": "",
    "simulation.py": "",
    "exchange.py": "import trundle.symbolic\n",
    "view/__init__.py": "__all__ = ['draw']\n",
    "cli/__init__.py": "from trundle import __version__\nfrom trundle.view import draw\n",
}


def write_tree(tmp_path: Path, changed: dict[str, str]) -> Path:
    source = tmp_path / PACKAGE
    for name, text in (SOUND | changed).items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text, encoding="utf-8")
    return source


LAZY = "def f():\n    {}\n"
TYPES_ONLY = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    {}\n"


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("se2.py", "from trundle.robot import Robot", "se2 (floor 0) imports robot (floor 1)"),
        ("se2.py", "import trundle.robot", "a room imports only from floors below"),
        ("se2.py", "from trundle import robot", "a room imports only from floors below"),
        ("robot/robot.py", "from .. import kinematics", "imports kinematics (floor 2)"),
        ("robot/robot.py", "from ..kinematics import forward", "imports kinematics (floor 2)"),
        ("se2.py", LAZY.format("from trundle.robot import Robot"), "se2.py:2: se2 (floor 0)"),
        ("se2.py", TYPES_ONLY.format("from trundle.robot import Robot"), "se2 (floor 0)"),
        ("se2.py", "class A:\n    def f(self):\n        import trundle.cli", "imports cli"),
        ("se2.py", "try:\n    import trundle.cli\nexcept ImportError: ...", "imports cli"),
        ("se2.py", "import importlib\nimportlib.import_module('trundle.cli')", "imports cli"),
        ("robot/robot.py", "from importlib import import_module as i", None),
        ("robot/robot.py", "__import__('trundle.view')", "imports view (floor 6)"),
        ("se2.py", "from trundle.errors import TrundleError", "imports errors (floor 0)"),
        ("odometry.py", "import trundle.symbolic", "imports symbolic (floor 3)"),
        ("simulation.py", "import trundle.symbolic", "which only ['cli', 'exchange'] may"),
        ("links.py", "from trundle.view import draw", "links (floor 6) imports view (floor 6)"),
        ("kinematics/forward.py", "from trundle.robot.wheels import Fixed", "with a NAME in its"),
        ("kinematics/forward.py", "from trundle.robot import wheels", "with a NAME in its"),
        ("kinematics/forward.py", "from trundle.robot import *", "'trundle.robot.*'"),
        ("kinematics/forward.py", "import trundle.robot.wheels", "'trundle.robot.wheels'"),
        ("kinematics/forward.py", "from trundle import robot", "'trundle.robot'"),
        ("cli/__init__.py", "from trundle.view.draw import x", "'trundle.view.draw.x'"),
        ("kinematics/forward.py", "from trundle import Robot", "imports the face"),
        ("kinematics/forward.py", "import trundle", "imports the face"),
        ("__init__.py", "from trundle.view import draw", "the face loads view"),
        ("__init__.py", "from .cli import main", "the face loads cli"),
        ("__init__.py", "from trundle.robot.wheels import Fixed", "with a NAME in its"),
        ("__init__.py", LAZY.format("from trundle.view import x"), "with a NAME in its"),
        ("helpers.py", "", "'helpers' is not in the table of rooms"),
        ("tools/deep/x.py", "", "'tools' is not in the table of rooms"),
        ("robot/deep/x.py", "from ...kinematics import forward", "imports kinematics (floor 2)"),
        ("robot/deep/x.py", "from ..wheels import Fixed", None),
    ],
)
def test_each_kind_of_violation_is_found(tmp_path, name, text, expected):
    found = find_violations(write_tree(tmp_path, {name: text}))
    if expected is None:
        assert found == []
    else:
        assert len(found) == 1, found
        assert found[0].startswith(name)
        assert expected in found[0]


def test_only_its_users_may_import_view_even_from_above(tmp_path, monkeypatch):
    monkeypatch.setitem(FLOOR_OF, "loft", len(FLOORS))
    source = write_tree(tmp_path, {"loft.py": "from trundle.view import draw"})
    assert find_violations(source) == [
        "loft.py:1: loft imports view, which only ['cli'] may",
    ]
