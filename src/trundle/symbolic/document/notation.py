"""The first section: frames, symbols with this robot's numbers, and its wheels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from trundle.robot import RollingWheel, SwedishWheel, Wheel
from trundle.symbolic.document.case import Case, listed
from trundle.symbolic.document.figures import in_words
from trundle.symbolic.document.parts import Section, Step, Table, literal
from trundle.symbolic.latex import to_latex
from trundle.symbolic.wheels import SymbolicWheel, says_something


def notation(case: Case) -> Section:
    """Return frames and symbols, each with its number for this robot."""
    return Section("Notation", (_motion(), _sizes(case), _wheels(case)))


def _motion() -> Step:
    rows = (
        (r"$\eta = (x, y, \psi)$", "m, m, rad", "pose of the body frame in the inertial frame"),
        (r"$\zeta = (u, v, r)$", "m/s, m/s, rad/s",
         "twist in the body frame: forward, to the left, counter-clockwise"),
        (r"$\omega_{i}$", "rad/s", "speed of driven wheel $i$"),
    )  # fmt: skip
    return Step(
        "Frames and motion",
        "The body frame has x forward, y to the left, z up; the inertial frame is fixed. The pose "
        r"follows from the twist by $\dot{\eta} = J(\psi)\, \zeta$, with $J$ the rotation by "
        r"$\psi$.",
        (),
        Table(("symbol", "unit", "what it is"), rows),
    )


def _sizes(case: Case) -> Step:
    made = case.made
    rows: list[tuple[Any, ...]] = [
        (each.symbol, _number(each.value, each.unit), each.meaning) for each in made.quantities
    ]
    names = [wheel.name for wheel in case.robot.steered]
    for symbol, value in made.inputs.values(case.steering, case.robot).items():
        led = [name for name in names if made.inputs.angles[name].has(symbol)]
        rows.append((symbol, _number(value, "rad"), f"steering angle: {_led(led, symbol, made)}"))
    text = "Sizes without a symbol are zero or plain angles."
    if names:
        text += (
            " The steering angles are inputs; the numbers are those of one position, "
            + listed(
                [f"{literal(n)} {a:.4g} deg" for n, a in zip(names, _degrees(case), strict=True)]
            )
            + "."
        )
    if not made.general:
        text += (
            " The formulas hold for robots with this robot's dependencies between sizes: wheels "
            "that agree with each other here would not do so at any sizes."
        )
    return Step("Sizes", text, (), Table(("symbol", "here", "what it is"), tuple(rows)))


def _led(names: list[str], symbol: Any, made: Any) -> str:
    told = []
    for name in names:
        ratio = made.inputs.angles[name] / symbol
        told.append(literal(name) if ratio == 1 else f"{literal(name)} ({ratio} times)")
    return listed(told)


def _degrees(case: Case) -> list[float]:
    return [float(angle) + 0.0 for angle in np.degrees(case.steering)]


def _number(value: float, unit: str) -> str:
    if unit == "rad":
        return f"{in_words(value)} rad = {math.degrees(value):.4g} deg"
    return f"{in_words(value)} {unit}".strip()


def _wheels(case: Case) -> Step:
    rollers = any(isinstance(each.wheel, SwedishWheel) for each in case.made.wheels)
    rows = tuple(_wheel(each, rollers) for each in case.made.wheels)
    silent = [wheel for wheel in case.robot.wheels if not says_something(wheel)]
    text = "Contact points are in the body frame; the heading is the drive direction."
    if any(each.wheel.steers for each in case.made.wheels):
        text += " Steered wheels point along heading plus steering angle."
    if silent:
        text += " " + " ".join(_silent(wheel) for wheel in silent)
    head = ("wheel", "name", "contact point", "heading", *["roller"] * rollers, "kind")
    return Step("Wheels", text, (), Table(head, rows))


def _wheel(each: SymbolicWheel, rollers: bool) -> tuple[Any, ...]:
    wheel, place = each.wheel, each.place
    turned = place.heading + each.steering
    notes = [wheel.kind, "driven" if wheel.driven else "not driven"]
    notes += ["reversed"] * getattr(wheel, "reversed", False)
    notes += ["may skid"] * getattr(wheel, "skid", False)
    point = f"$({to_latex(place.x)}, {to_latex(place.y)})$"
    roller = [each.roller if isinstance(wheel, SwedishWheel) else ""] * rollers
    return str(each.number), literal(wheel.name), point, turned, *roller, ", ".join(notes)


def _silent(wheel: Wheel) -> str:
    if isinstance(wheel, RollingWheel):
        return f"{literal(wheel.name)} is not driven, and its rollers let it follow every motion."
    name = literal(wheel.name)
    name = name if name == wheel.kind else f"{name} ({wheel.kind})"
    return f"{name} follows every motion and puts no constraint on it."
