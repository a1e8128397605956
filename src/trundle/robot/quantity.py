"""Fields that know their unit and their bounds: one source for checks, files and the schema."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import MISSING, field
from numbers import Real
from typing import Any


@dataclasses.dataclass(frozen=True)
class Quantity:
    """What a numeric field of a description may hold, and how it is told to people."""

    unit: str = ""
    positive: bool = False
    nonzero: bool = False
    nonnegative: bool = False

    def fault(self, value: object, degrees: bool = False) -> str:
        """Return what is wrong with a value, in words that follow the field's name, or ""."""
        name = "deg" + self.unit.removeprefix("rad") if degrees else self.unit
        unit = f" {name}" if name else ""
        if isinstance(value, bool) or not isinstance(value, Real):
            return f"must be a number{f' [{name}]' if name else ''}, got {value!r}"
        try:
            value = float(value)
        except OverflowError:
            return "must be finite, got a number too large"
        if not math.isfinite(value):
            return f"must be finite, got {value}"
        if self.positive and value <= 0:
            return f"must be positive, got {value:g}{unit}"
        if self.nonnegative and value < 0:
            return f"must not be negative, got {value:g}{unit}"
        if self.nonzero and value == 0:
            return "must not be zero"
        return ""


def quantity(
    unit: str,
    *,
    default: Any = MISSING,
    positive: bool = False,
    nonzero: bool = False,
    nonnegative: bool = False,
    degrees: bool = False,
    help: str,
) -> Any:
    """Return a dataclass field for a physical quantity; ``default=None`` makes it optional."""
    rule = Quantity(unit=unit, positive=positive, nonzero=nonzero, nonnegative=nonnegative)
    return field(default=default, metadata={"quantity": rule, "degrees": degrees, "help": help})


def point(unit: str, help: str) -> Any:
    """Return an optional dataclass field for a point (x, y) of the body."""
    return field(default=None, metadata={"point": Quantity(unit=unit), "help": help})


def part(cls: type, help: str) -> dict[str, Any]:
    """Return the metadata of a dataclass field for a description inside a description."""
    return {"part": cls, "help": help}


def flag(help: str, *, default: Any = False) -> Any:
    """Return a dataclass field that is true or false; ``default=None`` is decided by the class."""
    return field(default=default, metadata={"flag": True, "help": help})


def text(help: str, *, default: Any = MISSING) -> Any:
    """Return a dataclass field that holds a text; ``default=None`` makes it optional."""
    return field(default=default, metadata={"text": True, "help": help})


def key(item: dataclasses.Field[Any]) -> str:
    """Return the name that a field has in files: angles are given in degrees there."""
    return f"{item.name}_deg" if item.metadata.get("degrees") else item.name


def exact_degrees(angle: float) -> float:
    """Return an angle [rad] in degrees, on a grid of 1e-12 degree (coarser above 1000 degrees).

    >>> exact_degrees(math.pi / 3)
    60.0
    """
    degrees = math.degrees(angle)
    if not math.isfinite(degrees):
        return degrees
    # The grid stays coarser than what turning into radians and back rounds.
    return round(degrees, 15 - max(3, len(str(int(abs(degrees))))))


def check(item: Any) -> list[str]:
    """Return the faults of a dataclass's quantities and put its numbers into canonical form.

    Numbers become floats, and angles go to the grid of ``exact_degrees``, so that a description
    that was written in degrees comes back equal.
    """
    return [fault for each in dataclasses.fields(item) for fault in _check_field(item, each)]


def _check_field(item: Any, each: dataclasses.Field[Any]) -> list[str]:
    """Return the faults of one field, after putting a sound value into canonical form."""
    kind, value = each.metadata, getattr(item, each.name)
    if value is None and each.default is None:
        return []
    sound = value
    if "flag" in kind:
        fault = "" if isinstance(value, bool) else f"must be true or false, got {value!r}"
    elif "text" in kind:
        right = isinstance(value, str) and value.strip() != ""
        fault = "" if right else f"must be a text that is not empty, got {value!r}"
    elif "part" in kind:
        right = isinstance(value, kind["part"])
        fault = "" if right else f"must be of type {kind['part'].__name__}, got {value!r}"
    elif "point" in kind:
        fault, sound = _sound_point(kind["point"], value)
    else:
        fault, sound = _sound_number(kind["quantity"], value, kind["degrees"])
    if fault:
        return [f"{each.name} {fault}"]
    object.__setattr__(item, each.name, sound)
    return []


def _sound_number(rule: Quantity, value: Any, degrees: bool) -> tuple[str, Any]:
    if fault := rule.fault(value):
        return fault, None
    if not degrees:
        return "", float(value)
    angle = math.radians(exact_degrees(float(value)))
    return rule.fault(angle), angle


def _sound_point(rule: Quantity, value: Any) -> tuple[str, Any]:
    try:
        pair = dict(zip("xy", value, strict=True))
    except (TypeError, ValueError):
        return f"must be two numbers [x, y] [{rule.unit}], got {value!r}", None
    faults = [f"{axis} {fault}" for axis, v in pair.items() if (fault := rule.fault(v))]
    return "; ".join(faults), tuple(map(float, pair.values())) if not faults else None
