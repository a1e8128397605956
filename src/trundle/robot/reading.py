"""Robots from tables, as TOML gives them, with all faults told at once."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from trundle.errors import RobotError, did_you_mean
from trundle.robot.quantity import key
from trundle.robot.robot import Body, Robot, repeated_names
from trundle.robot.wheels import Wheel

if TYPE_CHECKING:
    from pydantic import BaseModel

_EXAMPLES = {
    "encoder": "{ ticks_per_motor_turn = 64, gear = 43.7 }",
    "motor": "{ torque_constant = 0.02, resistance = 1.5, gear = 43.7, max_voltage = 12 }",
}
_TOP_KEYS = ("name", "body", "wheel")


def robot_from_dict(data: Mapping[str, Any]) -> Robot:
    """Return the robot that a parsed TOML table describes: angles in degrees under ``_deg`` keys.

    Raises:
        RobotError: all faults at once, each naming wheel and key.

    >>> wheel = {"name": "left", "kind": "fixed", "x": 0, "y": 0.2, "radius": 0.05}
    >>> robot_from_dict({"name": "mine", "wheel": [wheel]}).wheels[0].radius
    0.05
    """
    if not isinstance(data, Mapping):
        raise RobotError([f"a robot must be a table, got {data!r}"])
    faults = [_unknown(name, _TOP_KEYS) for name in data if name not in _TOP_KEYS]
    name = data.get("name")
    if not isinstance(name, str) or not name.strip():
        faults.append("name is missing" if name is None else f"name must be a text, got {name!r}")
    body = _body(data.get("body"), faults)
    tables = data.get("wheel", [])
    wheels = _wheels(tables, faults)
    where = f"robot {name!r}" if isinstance(name, str) else "robot"
    if not faults:
        try:
            return Robot(name=str(name), wheels=tuple(wheels), body=body)
        except RobotError as error:
            faults += error.faults
    elif isinstance(tables, list):
        named = [table.get("name") for table in tables if isinstance(table, Mapping)]
        faults += repeated_names(name for name in named if isinstance(name, str))
    raise RobotError(faults, where)


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
        close = difflib.get_close_matches(str(kind).lower(), CLASSES, n=1)
        hint = did_you_mean(str(kind).lower(), CLASSES)
        faults.append(f"{where}: kind must be one of {', '.join(CLASSES)}; {got}{hint}")
        if not close:
            return None
        kind = close[0]  # the other keys are checked as for the kind that was probably meant
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
    # In TOML keys are texts; a table from elsewhere is told of its other keys.
    texts = {str(k): v for k, v in table.items()}
    try:
        model.model_validate(texts | ({"kind": kind} if kind else {}))
    except ValidationError as error:
        for each in error.errors():
            bad.add(str(each["loc"][0]))
            found.append(_tell(each, cls, kind))
    items = {key(item): item for item in dataclasses.fields(cls)}
    made = None
    values = {items[k].name: _value(items[k], v) for k, v in texts.items() if k not in bad}
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
    return item.metadata["part"](**value) if "part" in item.metadata else value


def _tell(error: Mapping[str, Any], cls: type, kind: str | None) -> str:
    """Return one pydantic error in our words; the dataclass's own rule speaks where it can."""
    path = [str(part) for part in error["loc"]]
    name = ".".join(path)
    items = {key(item): item for item in dataclasses.fields(cls)}
    outer = items[path[0]].metadata if path[0] in items else {}
    if "point" in outer:
        return f"{path[0]} must be two numbers [x, y] [{outer['point'].unit}]"
    if len(path) > 1:
        items = {key(item): item for item in dataclasses.fields(outer["part"])}
    if error["type"] == "extra_forbidden":
        return _unknown(name, tuple(items), kind)
    if error["type"] == "missing":
        return f"{name} is missing"
    item = items[path[-1]]
    rule = item.metadata.get("quantity")
    if rule is not None and (fault := rule.fault(error["input"], item.metadata["degrees"])):
        return f"{name} {fault}"
    wanted = {"bool_type": "true or false", "string_type": "a text"}.get(
        error["type"], f"a table such as {_EXAMPLES.get(name)}"
    )
    return f"{name} must be {wanted}, got {error['input']!r}"


def _unknown(name: object, known: tuple[str, ...], kind: str | None = None) -> str:
    from trundle.robot.schema import CLASSES, fields_by_key

    name = str(name)
    owners = [k for k, cls in CLASSES.items() if name in fields_by_key(cls)] if kind else []
    if owners:
        return f"key {name!r} does not belong to {kind} wheels, only to {', '.join(owners)}"
    hint = did_you_mean(name.split(".")[-1], known) or f": it may have {', '.join(known)}"
    return f"unknown key {name!r}{hint}"


def _in_file_words(fault: str, items: Mapping[str, dataclasses.Field[Any]]) -> str:
    for name, item in items.items():
        if item.metadata.get("degrees") and fault.startswith(f"{item.name} "):
            return name + fault.removeprefix(item.name)
    return fault
