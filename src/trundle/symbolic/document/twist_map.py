"""From the rows to the twists that are allowed, to W, and back to wheel speeds."""

from __future__ import annotations

from typing import Any

import sympy

from trundle.symbolic.document.case import LONG, Case, listed, many
from trundle.symbolic.document.parts import Law, Step
from trundle.symbolic.solving import adjugate, determinant, quotient, shorter
from trundle.symbolic.tidy import length, tidy_matrix


def allowed_twists(case: Case) -> list[Step]:
    """Return which rows hold, and the twists N that they leave."""
    made = case.made
    if not made.held.rows:
        text = "No wheel resists side slip: every twist is allowed, and $N$ is the identity."
        return [Step("Allowed twists", text), *_undriven(case)]
    all_rows = made.held == made.C
    which = Step("Which rows hold", _which(case), (case.shown("H", made.held),))
    steps = [] if all_rows else [which]
    if not made.N.cols:
        text = "Three independent rows hold: no motion is left, and W is zero."
        return [*steps, Step("Allowed twists", text)]
    law = "C N = 0" if all_rows else "H N = 0"
    text = f"The columns of $N$ are twists with ${law}$: {many(made.N.cols, 'motion')} left."
    steps.append(Step("Allowed twists", text, (case.shown("N", made.N),)))
    return steps + _undriven(case)


def _which(case: Case) -> str:
    made = case.made
    taken = [number for number in made.held_by if number]
    told = []
    if taken:
        told.append(
            f"Of the {many(made.C.rows, 'row')} of $C$, {len(taken)} "
            f"{'is' if len(taken) == 1 else 'are'} independent: $H$ takes "
            f"{'that' if len(taken) == 1 else 'those'} of {_wheels(taken)}."
        )
    slips = [each for each in made.wheels if each.rows().side_slip is not None]
    left = [each for each in slips if each.number not in taken]
    told += _others(left)
    if 0 in made.held_by:
        told.append(
            "Wheels that may skid: the rolling rows leave a motion open in which all of them slip "
            "sideways. It is fixed by the least sum of squares of the side slips, the last row "
            "of $H$: they balance."
        )
    return " ".join(told)


def _wheels(numbers: list[int]) -> str:
    return f"wheel{'s' * (len(numbers) > 1)} {listed([str(number) for number in numbers])}"


def _others(left: list[Any]) -> list[str]:
    fixed = [each.number for each in left if not each.wheel.steers]
    steered = [each.number for each in left if each.wheel.steers]
    told = []
    if fixed:
        told.append(f"The side slip of {_wheels(fixed)} says nothing more.")
    if steered:
        told.append(
            f"The steering of {_wheels(steered)} is not free: it follows from the centre of "
            "rotation that the others share. Where the axles of the wheels in $H$ lie in one "
            "line, take another wheel's row."
        )
    return told


def _undriven(case: Case) -> list[Step]:
    made = case.made
    if not made.undriven.cols:
        return []
    if not made.K.cols:
        text = "No driven wheel pushes any of these motions: W is zero."
        return [Step("What is driven", text)]
    return [
        Step(
            "What is driven",
            "No driven wheel pushes the twists in the columns of $U$; they are left at zero, and "
            "$K$ holds the allowed twists across them.",
            (case.shown("U", made.undriven), case.shown("K", made.K)),
        )
    ]


def wheel_map(case: Case) -> list[Step]:
    """Return W and how it comes about."""
    made, k = case.made, case.k_name
    if not made.A.rows or not made.K.cols:
        return []
    AK = made.AK
    square = AK.rows == AK.cols
    free = made.N.cols == 3
    name, inner, z = ("A", "A", r"\zeta") if free else (f"A {k}", rf"\left(A {k}\right)", "z")
    inverse = f"{inner}^{{-1}}" if square else f"{inner}^{{+}}"
    text = "" if free else f"A twist is $\\zeta = {k} z$, with one number in $z$ for each motion. "
    text += (
        f"As many wheels as motions: ${name}$ is square, and its inverse is the answer."
        if square
        else f"More wheels than motions: the least squares of ${name} {z} = R\\, \\omega$ decide, "
        f"${inverse} = \\left({inner}^{{T}} {name}\\right)^{{-1}} {inner}^{{T}}$."
    )
    formulas = () if free else (case.shown(name, AK),)
    steps = [Step("From wheel speeds to motions", text, formulas, detail=True)]
    steps += _normal(case, AK, name if square else f"{inner}^{{T}} {name}", square)
    law = rf"\zeta = W \omega, \quad W = {'' if free else k} {inverse} R"
    if made.K.cols == 1 and not square:
        law += rf" = \frac{{1}}{{g^{{T}} g}} {k} g^{{T}} R, \quad g = A {k}"
    return [*steps, *_result(case, Law(law), AK)]


def _normal(case: Case, AK: Any, name: str, square: bool) -> list[Step]:
    """Return the square matrix that is inverted, and its inverse."""
    # For one motion it is a single sum of squares, which W shows better; a long W has a long one.
    if AK.cols == 1 or length(case.made.W) > 4 * LONG:
        return []
    normal = AK if square else (AK.T * AK).applyfunc(shorter)
    if length(normal) > LONG:
        return []
    formulas = [] if square else [case.shown(name, normal)]
    bottom = shorter(determinant(normal))
    inverse = adjugate(normal).applyfunc(lambda entry: quotient(entry, bottom))
    if length(inverse) < LONG:
        whole = name if name == "A" else rf"\left({name}\right)"
        formulas.append(case.shown(f"{whole}^{{-1}}", sympy.Matrix(inverse)))
    return [Step("The matrix to invert", "", tuple(formulas), detail=True)] if formulas else []


def _result(case: Case, law: Law, AK: Any) -> list[Step]:
    made = case.made
    g = [case.shown("g", AK)] if made.K.cols == 1 and AK.rows > 1 else []
    if length(made.W) <= LONG:
        formulas = (law, case.factored("W", made.W))
        return [Step("W", "The twist from the wheel speeds:", formulas)]
    text = (
        "Written out, the entries of $W$ are long; the product of the matrices is the shorter way "
        "to say it. With this robot's numbers:"
    )
    numbers = case.shown("W", made.W).numbers
    return [Step("W", text, (law, *g, case.plain("W", numbers)))]


def speeds_from_twist(case: Case) -> list[Step]:
    """Return the wheel speeds for a twist that is allowed."""
    made = case.made
    if not made.A.rows or not made.N.cols:
        return []
    inverse = tidy_matrix(made.R.inv() * made.A)
    name = "C" if made.held == made.C else "H"
    held = rf" (which must keep ${name} \zeta = 0$)" * bool(made.held.rows)
    text = f"The other way round, every driven wheel has its own row: a twist{held} needs"
    law = Law(r"\omega = R^{-1} A\, \zeta")
    return [Step("Wheel speeds for a twist", text, (law, case.factored(r"R^{-1} A", inverse)))]
