"""Contact points, radii and track factors of a robot's wheels in symbols."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import sympy

from trundle.robot import FixedWheel, SwedishWheel, Wheel
from trundle.symbolic.quantities import Namer, exact_angle, same


class Place(NamedTuple):
    """A contact point in symbols, and the heading of the wheel there."""

    x: Any
    y: Any
    heading: Any


def places(wheels: Sequence[Wheel], namer: Namer) -> list[Place]:
    """Return the contact points in symbols, polar where the wheels stand on a circle."""
    if _on_a_circle(wheels):
        return _around(wheels, namer)
    along = _named_sizes([wheel.x for wheel in wheels], "l", "ahead of or behind the origin")
    aside = _named_sizes([wheel.y for wheel in wheels], "d", "beside the origin")
    return [
        Place(_signed(wheel.x, along, namer), _signed(wheel.y, aside, namer), heading)
        for wheel, heading in zip(wheels, _headings(wheels, namer), strict=True)
    ]


def _headings(wheels: Sequence[Wheel], namer: Namer) -> list[Any]:
    return [
        namer.angle(f"theta_{i}", getattr(wheel, "heading", 0.0), f"heading of wheel {i}")
        for i, wheel in enumerate(wheels, 1)
    ]


def _around(wheels: Sequence[Wheel], namer: Namer) -> list[Place]:
    """Return contact points on a circle by their polar angles, and headings across the arm."""
    arm = namer.length("l", math.hypot(wheels[0].x, wheels[0].y), "centre to contact points")
    angles = [
        namer.angle(f"alpha_{i}", _polar(wheel), f"polar angle of wheel {i}")
        for i, wheel in enumerate(wheels, 1)
    ]
    if _across(wheels):
        turns = [exact_angle(getattr(w, "heading", 0.0) - _polar(w)) for w in wheels]
        headings = [angle + turn for angle, turn in zip(angles, turns, strict=True)]
    else:
        headings = _headings(wheels, namer)
    return [
        Place(arm * sympy.cos(angle), arm * sympy.sin(angle), heading)
        for angle, heading in zip(angles, headings, strict=True)
    ]


def _polar(wheel: Wheel) -> float:
    return math.atan2(wheel.y, wheel.x)


def _on_a_circle(wheels: Sequence[Wheel]) -> bool:
    """Return whether wheels stand on a circle about the origin and are best told so."""
    arms = [math.hypot(wheel.x, wheel.y) for wheel in wheels]
    if len(wheels) < 3 or not all(same(arm, arms[0]) and arm > 0 for arm in arms):
        return False
    if _across(wheels):
        return True
    exact = all(exact_angle(_polar(wheel)) is not None for wheel in wheels)
    return exact and not _is_rectangle(wheels)


def _across(wheels: Sequence[Wheel]) -> bool:
    """Return whether all are omni wheels that drive across the arm to them."""
    quarter = sympy.pi / 2
    return all(
        isinstance(wheel, SwedishWheel)
        and exact_angle(wheel.roller) == 0
        and exact_angle(wheel.heading - _polar(wheel)) in (quarter, -quarter)
        for wheel in wheels
    )


def _is_rectangle(wheels: Sequence[Wheel]) -> bool:
    along, aside = (_sizes(values) for values in zip(*((w.x, w.y) for w in wheels), strict=True))
    return len(along) <= 1 and len(aside) <= 1


def _sizes(values: Iterable[float]) -> list[float]:
    """Return the different sizes other than zero, in order of appearance."""
    found: list[float] = []
    for value in map(abs, values):
        if not any(same(value, each) for each in (0.0, *found)):
            found.append(value)
    return found


def _named_sizes(values: Sequence[float], name: str, where: str) -> list[tuple[str, float, str]]:
    sizes = _sizes(values)
    names = [name] if len(sizes) == 1 else [f"{name}_{i + 1}" for i in range(len(sizes))]
    return [(label, size, f"distance {where}") for label, size in zip(names, sizes, strict=True)]


def _signed(value: float, sizes: Iterable[tuple[str, float, str]], namer: Namer) -> Any:
    for name, size, meaning in sizes:
        if same(abs(value), size):
            return int(math.copysign(1, value)) * namer.length(name, size, meaning)
    return sympy.Integer(0)


def radii(wheels: Sequence[Wheel], namer: Namer) -> list[Any]:
    """Return the radii of the driven wheels in symbols, None for the others."""
    driven = [wheel for wheel in wheels if wheel.driven]
    values = [wheel.radius for wheel in driven]  # type: ignore[attr-defined]
    equal = all(same(value, values[0]) for value in values)
    out: list[Any] = []
    for i, wheel in enumerate(wheels, 1):
        name, whose = ("a", "radius of the wheels") if equal else (f"a_{i}", f"radius of wheel {i}")
        if not wheel.driven:
            out.append(None)
        else:
            out.append(namer.symbol(name, wheel.radius, "m", whose, positive=True))  # type: ignore[attr-defined]
    return out


def track_factors(wheels: Sequence[Wheel], namer: Namer) -> list[Any]:
    """Return the factors on the arms of skidding wheels in symbols, 1 for the others."""
    skids = [wheel for wheel in wheels if isinstance(wheel, FixedWheel) and wheel.skid]
    equal = all(same(wheel.track_factor, skids[0].track_factor) for wheel in skids)
    out: list[Any] = []
    for i, wheel in enumerate(wheels, 1):
        if not isinstance(wheel, FixedWheel) or not wheel.skid:
            out.append(sympy.Integer(1))
        else:
            name = "kappa" if equal else f"kappa_{i}"
            meaning = "effective over geometric track, identified from data"
            out.append(namer.symbol(name, wheel.track_factor, "", meaning, positive=True))
    return out
