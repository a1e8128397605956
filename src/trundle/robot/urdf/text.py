"""The XML of a URDF, read so that no file can do harm, and the numbers in it."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

from trundle.errors import FileError
from trundle.robot.urdf.pose import Vector

# Descriptions of whole humanoids take a tenth of this; more is not a robot's description.
MOST_BYTES = 5_000_000
# Elements inside elements: a URDF needs six.
_DEEPEST = 50
_MOST_SHOWN = 60
_XACRO = (
    "this is a xacro file, which is a program that writes a URDF: run it first, with "
    "'xacro robot.urdf.xacro > robot.urdf', and load what it writes"
)


def parse(data: bytes, where: str) -> ET.Element:
    """Return the ``<robot>`` element of a URDF.

    A document type is refused, and with it every entity: nothing is expanded or fetched.

    Raises:
        FileError: this is no URDF, or one too large.
    """
    if len(data) > MOST_BYTES:
        raise FileError(
            f"{where}: the file has more than {MOST_BYTES // 1_000_000} MB: a URDF is a few "
            "thousand lines of text; meshes stand in files of their own"
        )
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    depth = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise FileError(f"{where}: elements stand more than {_DEEPEST} deep: this is no URDF")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_: Any) -> None:
        raise FileError(f"{where}: a URDF has no <!DOCTYPE>: remove it, and the entities with it")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = builder.data, refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        told = f"{expat.ErrorString(error.code)} in line {error.lineno}, column {error.offset + 1}"
        raise FileError(f"{where}: this is not valid XML: {told}{_encoding(data)}") from None
    except (LookupError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{where}: the encoding cannot be read: {error}; use UTF-8") from None
    return _checked(builder.close(), where)


def _encoding(data: bytes) -> str:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        return f" (byte {error.start + 1} is not UTF-8: save the file as UTF-8)"
    return ""


def _checked(root: ET.Element, where: str) -> ET.Element:
    if any(
        each.tag.startswith("xacro:") or any("${" in value for value in each.attrib.values())
        for each in root.iter()
    ):
        raise FileError(f"{where}: {_XACRO}")
    if root.tag != "robot":
        other = " (an SDF file: URDF is another format)" if root.tag == "sdf" else ""
        raise FileError(
            f"{where}: the outermost element of a URDF is <robot>, got <{shown(root.tag)}>{other}"
        )
    return root


def shown(text: str) -> str:
    """Return a text as a message quotes it: printable, and not too long."""
    cut = text if len(text) <= _MOST_SHOWN else text[:_MOST_SHOWN] + "..."
    return repr(cut)[1:-1]


def number(text: str) -> float | None:
    """Return the finite number that a text holds, or None.

    >>> number("1e-3"), number("nan"), number("1_0")
    (0.001, None, None)
    """
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def numbers(text: str | None, default: Vector, where: str, faults: list[str]) -> Vector:
    """Return the three numbers of an attribute, telling a fault where it holds none."""
    if text is None:
        return default
    parts = [number(part) for part in text.split()[:4]]
    if len(parts) != 3 or None in parts:
        faults.append(f"{where} must be three finite numbers, got '{shown(text)}'")
        return default
    x, y, z = (part for part in parts if part is not None)
    return x, y, z


def attribute(
    element: ET.Element | None, key: str, where: str, faults: list[str], *, positive: bool = False
) -> float | None:
    """Return the number in an attribute, or None where there is none; a fault where it is bad."""
    text = None if element is None else element.get(key)
    if text is None:
        return None
    value = number(text)
    if value is None or (positive and value <= 0):
        what = "a positive number" if positive else "a finite number"
        faults.append(f"{where}: {key} must be {what}, got '{shown(text)}'")
        return None
    return value
