"""Robots from TOML files and back."""

from __future__ import annotations

import dataclasses
import difflib
import json
import math
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle.errors import FileError, RobotError
from trundle.robot.catalog import CATALOG, from_catalog
from trundle.robot.quantity import exact_degrees, key
from trundle.robot.robot import Body, Robot
from trundle.robot.wheels import Encoder, Wheel

if TYPE_CHECKING:
    from pydantic import BaseModel

_TOP_KEYS = ("name", "body", "wheel")


def load(name_or_path: str | Path, **sizes: Any) -> Robot:
    """Return a robot of the catalogue, or the robot that a TOML file describes.

    Args:
        name_or_path: a catalogue name, or the path of a TOML file.
        sizes: for catalogue robots, sizes to change, such as ``radius=0.1`` [m].

    Raises:
        RobotError: the description is wrong; all faults are listed.
        FileError: there is neither such a catalogue robot nor such a file.

    >>> load("omni3").name
    'omni3'
    """
    text = str(name_or_path)
    if isinstance(name_or_path, str) and text in CATALOG:
        return from_catalog(text, **sizes)
    path = Path(name_or_path)
    if not path.exists() and path.suffix != ".toml" and path.name == text:
        close = difflib.get_close_matches(text, CATALOG, n=1)
        hint = f"did you mean {close[0]!r}? " if close else ""
        raise FileError(
            f"no robot {text!r}: {hint}Give the path of a TOML file or one of {', '.join(CATALOG)}."
        )
    if sizes:
        raise FileError(f"{path}: sizes can be changed for catalogue robots; edit the file instead")
    return _read(path)


def _read(path: Path) -> Robot:
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise FileError(f"{path}: this is not valid TOML: {error}") from None
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: the file must be UTF-8 text: {error}") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    data.setdefault("name", path.stem)
    try:
        return robot_from_dict(data)
    except RobotError as error:
        raise RobotError(error.faults, str(path)) from None


def robot_from_dict(data: Mapping[str, Any]) -> Robot:
    """Return the robot that a parsed TOML table describes: angles in degrees under ``_deg`` keys.

    Raises:
        RobotError: all faults at once, each naming wheel and key.

    >>> wheel = {"name": "left", "kind": "fixed", "x": 0, "y": 0.2, "radius": 0.05}
    >>> robot_from_dict({"name": "mine", "wheel": [wheel]}).wheels[0].radius
    0.05
    """
    faults = [_unknown(name, _TOP_KEYS) for name in data if name not in _TOP_KEYS]
    name = data.get("name")
    if not isinstance(name, str) or not name.strip():
        faults.append("name is missing" if name is None else f"name must be a text, got {name!r}")
    body = _body(data.get("body"), faults)
    wheels = _wheels(data.get("wheel", []), faults)
    where = f"robot {name!r}" if name else "robot"
    if faults and not (wheels and name):
        raise RobotError(faults, where)
    try:
        robot = Robot(name=str(name), wheels=tuple(wheels), body=body)
    except RobotError as error:
        raise RobotError([*faults, *error.faults], where) from None
    if faults:
        raise RobotError(faults, where)
    return robot


def _body(table: object, faults: list[str]) -> Body | None:
    from trundle.robot.schema import body_model

    if table is None:
        return None
    made = _build(Body, body_model(), table, "body", faults)
    return made if isinstance(made, Body) else None


def _wheels(tables: object, faults: list[str]) -> list[Wheel]:
    if not isinstance(tables, list):
        faults.append("wheel must be a list of tables: write [[wheel]] above each")
        return []
    wheels = [_wheel(table, number, faults) for number, table in enumerate(tables, start=1)]
    return [wheel for wheel in wheels if wheel is not None]


@cache
def _model(kind: str) -> type[BaseModel]:
    from trundle.robot.schema import wheel_model

    return wheel_model(kind)


def _wheel(table: object, number: int, faults: list[str]) -> Wheel | None:
    from trundle.robot.schema import CLASSES, wheel_class

    if not isinstance(table, Mapping):
        faults.append(f"wheel {number} must be a table: write [[wheel]] above it")
        return None
    name = table.get("name")
    where = f"wheel {name!r}" if isinstance(name, str) and name.strip() else f"wheel {number}"
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in CLASSES:
        got = "it is missing" if kind is None else f"got {kind!r}"
        faults.append(f"{where}: kind must be one of {', '.join(CLASSES)}; {got}")
        return None
    rest = {k: v for k, v in table.items() if k != "kind"}
    made = _build(wheel_class(kind, table), _model(kind), rest, where, faults, kind)
    return made if isinstance(made, Wheel) else None


def _build(
    cls: Any,
    model: type[BaseModel],
    table: object,
    where: str,
    faults: list[str],
    kind: str | None = None,
) -> Any:
    """Return the value that a table describes, or None after telling its faults."""
    from pydantic import ValidationError

    if not isinstance(table, Mapping):
        faults.append(f"{where} must be a table, got {table!r}")
        return None
    found: list[str] = []
    bad: set[str] = set()
    try:
        model.model_validate(dict(table) | ({"kind": kind} if kind else {}))
    except ValidationError as error:
        for each in error.errors():
            bad.add(str(each["loc"][0]))
            found.append(_tell(each, cls, kind))
    items = {key(item): item for item in dataclasses.fields(cls)}
    made = None
    values = {items[k].name: _value(items[k], v) for k, v in table.items() if k not in bad}
    try:
        # With keys left out or wrong, what can be checked of the others still is.
        stand_ins = {
            item.name: "?" if item.name == "name" else 1.0
            for item in items.values()
            if item.default is dataclasses.MISSING and item.name not in values
        }
        made = cls(**(stand_ins | values))
    except RobotError as error:
        found += [_in_file_words(fault, items) for fault in error.faults]
    faults += [f"{where}: {fault}" for fault in found]
    return None if found else made


def _value(item: dataclasses.Field[Any], value: Any) -> Any:
    if item.metadata.get("degrees"):
        return math.radians(value)
    return Encoder(**value) if item.name == "encoder" else value


def _tell(error: Mapping[str, Any], cls: type, kind: str | None) -> str:
    """Return one pydantic error in our words; the dataclass's own rule speaks where it can."""
    path = [str(part) for part in error["loc"]]
    name = ".".join(path)
    owner = Encoder if len(path) > 1 else cls
    items = {key(item): item for item in dataclasses.fields(owner)}
    if error["type"] == "extra_forbidden":
        return _unknown(name, tuple(items), kind)
    if error["type"] == "missing":
        return f"{name} is missing"
    item = items[path[-1]]
    rule = item.metadata.get("quantity")
    if rule is not None and (fault := rule.fault(error["input"], item.metadata["degrees"])):
        return f"{name} {fault}"
    wanted = {"bool_type": "true or false", "string_type": "a text"}.get(error["type"], "a table")
    return f"{name} must be {wanted}, got {error['input']!r}"


def _unknown(name: str, known: tuple[str, ...], kind: str | None = None) -> str:
    from trundle.robot.schema import CLASSES, fields_by_key

    owners = [k for k, cls in CLASSES.items() if name in fields_by_key(cls)] if kind else []
    if owners:
        return f"key {name!r} does not belong to a {kind} wheel, only to {', '.join(owners)}"
    close = difflib.get_close_matches(name.split(".")[-1], known, n=1)
    hint = f": did you mean {close[0]!r}?" if close else f": it may have {', '.join(known)}"
    return f"unknown key {name!r}{hint}"


def _in_file_words(fault: str, items: Mapping[str, dataclasses.Field[Any]]) -> str:
    for name, item in items.items():
        if item.metadata.get("degrees") and fault.startswith(f"{item.name} "):
            return name + fault.removeprefix(item.name)
    return fault


def to_toml(robot: Robot) -> str:
    """Return the robot as the text of a TOML file; reading it gives an equal robot.

    >>> print(to_toml(load("bicycle")).splitlines()[0])
    name = "bicycle"
    """
    lines = [f"name = {_literal(robot.name)}"]
    if robot.body is not None:
        lines += ["", "[body]", *_lines(robot.body)]
    for wheel in robot.wheels:
        name, *rest = _lines(wheel)
        lines += ["", "[[wheel]]", name, f"kind = {_literal(wheel.kind)}", *rest]
    return "\n".join(lines) + "\n"


def save(robot: Robot, path: str | Path) -> Path:
    """Write the robot to a TOML file and return its path.

    Raises:
        FileError: the file cannot be written.
    """
    path = Path(path)
    try:
        path.write_text(to_toml(robot), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None
    return path


def _lines(item: Any) -> list[str]:
    lines = []
    for each in dataclasses.fields(item):
        value = getattr(item, each.name)
        derived = each.name == "driven" and value == item.may_drive
        if value == each.default or derived:
            continue
        shown = exact_degrees(value) if each.metadata.get("degrees") else value
        lines.append(f"{key(each)} = {_literal(shown)}")
    return lines


def _literal(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        # JSON's escapes are TOML's, but TOML also wants DEL escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return "{ " + ", ".join(_lines(value)) + " }"
