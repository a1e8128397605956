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
        if self.nonzero and value == 0:
            return "must not be zero"
        return ""


def quantity(
    unit: str,
    *,
    default: Any = MISSING,
    positive: bool = False,
    nonzero: bool = False,
    degrees: bool = False,
    help: str,
) -> Any:
    """Return a dataclass field for a physical quantity; ``default=None`` makes it optional."""
    rule = Quantity(unit=unit, positive=positive, nonzero=nonzero)
    return field(default=default, metadata={"quantity": rule, "degrees": degrees, "help": help})


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
    faults = []
    for each in dataclasses.fields(item):
        rule, value = each.metadata.get("quantity"), getattr(item, each.name)
        if value is None and each.default is None:
            continue
        if each.metadata.get("flag") and not isinstance(value, bool):
            faults.append(f"{each.name} must be true or false, got {value!r}")
        if each.metadata.get("text") and not (isinstance(value, str) and value.strip()):
            faults.append(f"{each.name} must be a text that is not empty, got {value!r}")
        if rule is None:
            continue
        if fault := rule.fault(value):
            faults.append(f"{each.name} {fault}")
            continue
        value = float(value)
        if each.metadata.get("degrees"):
            value = math.radians(exact_degrees(value))
            if fault := rule.fault(value):
                faults.append(f"{each.name} {fault}")
                continue
        object.__setattr__(item, each.name, value)
    return faults
