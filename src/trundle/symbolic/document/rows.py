"""The rows of the wheels, one by one and stacked."""

from __future__ import annotations

from typing import Any

import sympy

from trundle.robot import SwedishWheel, Wheel
from trundle.symbolic.document.case import TWIST, Case
from trundle.symbolic.document.parts import Law, Step, Value, literal
from trundle.symbolic.wheels import SymbolicWheel

_SWEDISH = (
    r"\cos\left(\theta_{i} + \phi_{i}\right) \left(u - r y_{i}\right) + "
    r"\sin\left(\theta_{i} + \phi_{i}\right) \left(v + r x_{i}\right) = "
    r"a_{i} \omega_{i} \cos\phi_{i}"
)
_ROLLING = (
    r"\cos\theta_{i} \left(u - r y_{i}\right) + \sin\theta_{i} \left(v + r x_{i}\right) = "
    r"a_{i} \omega_{i}"
)
_ACROSS = r"-\sin\theta_{i} \left(u - r y_{i}\right) + \cos\theta_{i} \left(v + r x_{i}\right)"


_CONTACT = Step(
    "What a wheel says",
    "The contact point $(x_{i}, y_{i})$ of wheel $i$ is a point of the body, so that it moves with "
    r"the velocity $\left(u - r y_{i}, v + r x_{i}\right)$.",
    detail=True,
)
_KINDS = {
    "swedish": Step(
        "Omni and mecanum wheels",
        "The roller on the ground turns freely across its own axis, so that the wheel holds only "
        r"along that axis, at $\theta_{i} + \phi_{i}$. There the contact point has the part "
        r"$\cos\phi_{i}$ of the rim's speed.",
        (Law(_SWEDISH),),
        detail=True,
    ),
    "standard": Step(
        "Fixed and steered wheels",
        r"The wheel rolls along $\theta_{i}$ and does not slip across it; for steered wheels "
        r"$\theta_{i}$ is heading plus steering angle.",
        (Law(_ROLLING), Law(f"{_ACROSS} = 0")),
        detail=True,
    ),
    "skid": Step(
        "Wheels that may skid",
        r"Only the rolling row holds, with the arm of $r$ made longer by $\kappa \ge 1$, since a "
        "robot that skids turns less than its wheels say.",
        (Law(_ROLLING.replace("r y", r"\kappa r y").replace("r x", r"\kappa r x")),),
        detail=True,
    ),
}


def rows(case: Case) -> list[Step]:
    """Return what each wheel says of the twist, and the matrices of all of it."""
    made = case.made
    steps = [*_kinds(case), *(_one(case, each) for each in made.wheels)]
    if made.A.rows:
        steps.append(
            Step(
                "The rolling rows together",
                r"The driven wheels say $A \zeta = R\, \omega$, one row for each wheel.",
                (case.factored("A", made.A), case.factored("R", made.R)),
            )
        )
    else:
        steps.append(Step("The rolling rows", "No wheel is driven: there is no rolling row."))
    if made.C.rows:
        steps.append(
            Step(
                "The side-slip rows together",
                r"The wheels that do not slip sideways, driven or not, say $C \zeta = 0$.",
                (case.shown("C", made.C),),
            )
        )
    return steps


def _kinds(case: Case) -> list[Step]:
    """Return the equation of each kind of wheel that the robot has."""
    kinds = {_kind(each.wheel) for each in case.made.wheels}
    return [_CONTACT, *(step for kind, step in _KINDS.items() if kind in kinds)]


def _kind(wheel: Wheel) -> str:
    if isinstance(wheel, SwedishWheel):
        return "swedish"
    return "skid" if getattr(wheel, "skid", False) else "standard"


def _one(case: Case, each: SymbolicWheel) -> Step:
    told, formulas = each.rows(), []
    if each.wheel.driven and told.rolling is not None:
        speed = sympy.Symbol(f"omega_{each.number}", real=True)
        formulas.append(case.shown(_row(told.rolling), told.gain * speed))
    if told.side_slip is not None:
        formulas.append(Value(_row(told.side_slip), sympy.Integer(0)))
    text = "A reversed wheel's positive speed drives backwards." * getattr(
        each.wheel, "reversed", False
    )
    heading = f"Wheel {each.number} ({literal(each.wheel.name)})"
    return Step(heading, text, tuple(formulas), detail=True)


def _row(row: tuple[Any, Any, Any]) -> Any:
    return sympy.Add(*(a * b for a, b in zip(row, TWIST, strict=True)))
