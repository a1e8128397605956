"""What the robot can and cannot do, with the Lie brackets that decide it."""

from __future__ import annotations

from typing import Any

from trundle.kinematics import mobility
from trundle.symbolic.brackets import Found, Integrability, integrability
from trundle.symbolic.document.case import Case
from trundle.symbolic.document.parts import Law, Section, Step, literal
from trundle.symbolic.latex import to_latex

_BRACKET = (
    r"\left[(u_{1}, v_{1}, r_{1}), (u_{2}, v_{2}, r_{2})\right] = "
    r"\left(r_{2} v_{1} - r_{1} v_{2}, r_{1} u_{2} - r_{2} u_{1}, 0\right)"
)


def abilities(case: Case) -> Section:
    """Return mobility in words, and integrability by Lie brackets."""
    can = mobility(case.robot)
    steps = [Step(f"Mobility {can.kind}", literal(" ".join(can.reasons)))]
    steps += _brackets(case, integrability(case.made))
    return Section("What the robot can do", tuple(steps))


def _brackets(case: Case, told: Integrability) -> list[Step]:
    if len(told.allowed) in (0, 3):
        text = (
            "Every twist is allowed: there is no constraint that could be integrated."
            if told.allowed
            else "No twist is allowed: the robot stands still."
        )
        return [Step("Integrability", text)]
    first = Step(
        "Integrability",
        "Constraints on velocities can be integrated to constraints on poses exactly if the Lie "
        "brackets of the allowed twists, the columns of $N$, give nothing new. A bracket is what "
        "is left of going forth along two motions and back along them in turn.",
        (Law(_BRACKET), *(case.shown(_name(name), twist) for name, twist in told.allowed)),
        detail=True,
    )
    moved = [found for found in told.found if not isinstance(found.parents[1], str)]
    steering = Step(
        "Steering",
        "Steering angles move too: the bracket of steering with a twist is its derivative by the "
        "angle.",
        detail=True,
    )
    steps = [first, *([steering] if moved else [])]
    steps += [
        Step(_heading(each), "", (case.shown(_left(each), each.twist),), detail=True)
        for each in told.found
    ]
    return [*steps, Step("Verdict", _verdict(told))]


def _heading(found: Found) -> str:
    return "A new direction" if found.new else "Nothing new"


def _left(found: Found) -> str:
    first, second = found.parents
    if isinstance(second, str):
        made = rf"\left[{_name(first)}, {_name(second)}\right]"
    else:
        made = rf"\frac{{\partial {_name(first)}}}{{\partial {to_latex(second)}}}"
    return f"{_name(found.name)} = {made}" if found.new else made


def _name(name: Any) -> str:
    letter, _, index = str(name).partition("_")
    return f"{letter}_{{{index}}}"


def _verdict(told: Integrability) -> str:
    count = len(told.allowed)
    start = "The allowed twist" if count == 1 else f"The {count} allowed twists"
    if told.integrable:
        return (
            f"{start} {'gives' if count == 1 else 'give'} nothing new: the constraints can be "
            "integrated, and the robot stays on a surface in the space of poses: holonomic in the "
            "strict sense."
        )
    end = (
        "all three dimensions, so that every pose can be reached"
        if told.dimension == 3
        else f"{told.dimension} of the three dimensions"
    )
    return (
        f"{start} {'grows' if count == 1 else 'grow'} to {end}. The constraints cannot be "
        "integrated: the robot is non-holonomic."
    )
