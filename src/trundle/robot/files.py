"""Robots from files, TOML or URDF, and back to TOML."""

from __future__ import annotations

import dataclasses
import json
import re
import tomllib
import warnings
from pathlib import Path
from typing import Any

from trundle.errors import FileError, GuessWarning, RobotError, did_you_mean
from trundle.robot.catalog import CATALOG, from_catalog
from trundle.robot.quantity import exact_degrees, key
from trundle.robot.reading import robot_from_dict
from trundle.robot.robot import Robot

# A URDF, or what a program makes one of: that is told when it is read.
_URDF = (".urdf", ".xacro", ".xml")


def load(name_or_path: str | Path, **sizes: Any) -> Robot:
    """Return a robot of the catalogue, or the robot that a TOML file or a URDF describes.

    A URDF that trundle wrote gives the same robot back. Another one gives the wheels that its
    joints tell; a ``GuessWarning`` lists what a URDF cannot say.

    Args:
        name_or_path: a catalogue name, or the path of a TOML file or of a URDF.
        sizes: for catalogue robots, sizes to change, such as ``radius=0.1`` [m].

    Raises:
        RobotError: the description is wrong; all faults are listed.
        FileError: there is neither such a catalogue robot nor such a file.

    >>> load("omni3").name
    'omni3'
    """
    if not isinstance(name_or_path, str | Path):
        raise FileError(f"give a catalogue name or the path of a file, got {name_or_path!r}")
    text = str(name_or_path)
    if isinstance(name_or_path, str) and text in CATALOG:
        return from_catalog(text, **sizes)
    path = Path(name_or_path)
    suffix = path.suffix.lower()
    if path.name == text and suffix not in (".toml", *_URDF) and not _is_there(path):
        hint = did_you_mean(text, CATALOG) or "."
        raise FileError(
            f"no robot {text!r}{hint} Give the path of a TOML file or one of {', '.join(CATALOG)}; "
            "the name of a URDF ends in .urdf."
        )
    if sizes:
        raise FileError(f"{path}: sizes can be changed for catalogue robots; edit the file instead")
    if suffix not in _URDF:
        return _read(path)
    robot, unknown = _read_urdf(path)
    if unknown:
        told = "".join(f"\n  - {each}" for each in unknown)
        warnings.warn(f"{path}: a URDF does not tell all of a robot{told}", GuessWarning, 2)
    return robot


def _read_urdf(path: Path) -> tuple[Robot, tuple[str, ...]]:
    from trundle.robot.urdf import MOST_BYTES, read_urdf

    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a name that no file can have
        raise FileError(f"{str(path)!r}: cannot be read: {error}") from None
    return read_urdf(data, str(path), path.stem)


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name that no file can have
        return False


def _read(path: Path) -> Robot:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: the file must be UTF-8 text: {error}") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a name that no file can have
        raise FileError(f"{str(path)!r}: cannot be read: {error}") from None
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path}: this is not valid TOML: {error}{_hint(text, error)}") from None
    data.setdefault("name", path.stem)
    try:
        return robot_from_dict(data)
    except RobotError as error:
        raise RobotError(error.faults, str(path)) from None


def _hint(text: str, error: Exception) -> str:
    """Return the line that TOML does not understand, and the usual slip that it looks like."""
    found = re.search(r"at line (\d+)", str(error))
    lines = text.splitlines()
    if found is None or int(found[1]) > len(lines):
        return ""
    line = lines[int(found[1]) - 1].strip()
    slips = {
        r"^\[wheel\]": "each wheel stands under [[wheel]], with two brackets",
        r"=\s*-?\d+,\d": "a decimal point, not a comma",
        r"=\s*[A-Za-z_]+\s*(#.*)?$": "texts need quotes",
    }
    hint = next((told for slip, told in slips.items() if re.search(slip, line)), "")
    return f": {line!r}{f' ({hint})' if hint else ''}"


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
        path.write_bytes(to_toml(robot).encode())
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None
    except UnicodeEncodeError as error:
        raise FileError(f"{path}: a name cannot be written as UTF-8: {error}") from None
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
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_literal, value)) + "]"
    if isinstance(value, str):
        # JSON's escapes are TOML's, but TOML also wants DEL escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return "{ " + ", ".join(_lines(value)) + " }"
