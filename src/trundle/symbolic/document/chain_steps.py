"""The body as a chain of three joints: table, transforms, and the Newton-Euler recursion."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

from trundle.symbolic import base
from trundle.symbolic.base import planar_base, planar_links
from trundle.symbolic.chain import pose, table
from trundle.symbolic.document.case import Case
from trundle.symbolic.document.figures import in_words
from trundle.symbolic.document.parts import Law, Section, Step, Table, Value, literal
from trundle.symbolic.equations import Derived
from trundle.symbolic.latex import to_latex
from trundle.symbolic.tidy import length

_OUTWARD = (
    r"\omega' = R \omega + \dot{q} z \text{ (revolute), } R \omega \text{ (prismatic)}",
    r"\dot{\omega}' = R \dot{\omega} + R \omega \times \dot{q} z + \ddot{q} z "
    r"\text{ (revolute), } R \dot{\omega} \text{ (prismatic)}",
    r"\dot{v}' = R \left(\dot{\omega} \times P + \omega \times \left(\omega \times P\right) + "
    r"\dot{v}\right) \text{ (revolute; prismatic: } + 2 \omega' \times \dot{q} z + \ddot{q} z "
    r"\text{)}",
    r"\dot{v}_{C} = \dot{\omega}' \times P_{C} + \omega' \times \left(\omega' \times P_{C}\right) "
    r"+ \dot{v}'",
    r"F = m \dot{v}_{C}, \quad N = I \dot{\omega}' + \omega' \times I \omega'",
)
_INWARD = (
    r"f = R f' + F",
    r"n = N + R n' + P_{C} \times F + P' \times R f'",
    r"\tau = z \cdot f \text{ (prismatic), } z \cdot n \text{ (revolute)}",
)
_LETTERS = (
    r"In this section $\alpha$, $a$, $\theta$ and $d$ are the columns of Denavit and Hartenberg's "
    "table, not sizes of the robot; $T$ is a transform between links. With every step shown, $R$ "
    "is the rotation between links (the standard letter, in books with both links' numbers), not "
    r"the radii; $\omega$ a link's angular velocity, not wheel speeds; $N$ the moment of a link's "
    r"inertia, not the allowed twists; $n$ the moment between links; $\tau$ a joint's effort."
)
_MEANING = {
    base.m: "kg",
    base.I_cz: "kg m²",
    base.x_bc: "m",
    base.y_bc: "m",
}
_WORDS = {
    base.m: "mass of body and wheels",
    base.I_cz: "inertia about the vertical through the centre of mass",
    base.x_bc: "centre of mass, ahead of the body's origin (negative: behind)",
    base.y_bc: "centre of mass, to the left of it (negative: right)",
}
# Vectors with fewer operations than this stand in one row.
_SHORT = 12


def chain(case: Case) -> Section:
    """Return the Denavit-Hartenberg table, its transforms, and the recursion."""
    steps = [Step("Letters", _LETTERS), _masses(case), _table(), *_transforms(), *_recursion()]
    return Section("The body as a chain of joints", tuple(steps))


def _masses(case: Case) -> Step:
    rows = tuple(
        (symbol, f"{in_words(case.masses[symbol])} {unit}" if case.masses else "-", _WORDS[symbol])
        for symbol, unit in _MEANING.items()
    )
    text = "Wheels count with their mass, as points at their contact points; their spin does not."
    if case.missing:
        text += f" Numbers are left out: {literal(case.missing)}."
    return Step("Masses", text, (), Table(("symbol", "here", "what it is"), rows))


def _table() -> Step:
    rows = tuple(
        (str(i), *(sympy.sympify(each) for each in row), link.kind)
        for i, (row, link) in enumerate(zip(table(planar_links()), planar_links(), strict=True), 1)
    )
    head = ("link", r"$\alpha_{i-1}$", "$a_{i-1}$", r"$\theta_{i}$", "$d_{i}$", "joint")
    return Step(
        "Denavit-Hartenberg table",
        "A body in the plane moves as if it hung on two sliding joints, along y and along x, and "
        "a turning one. In Craig's (modified) convention each row leads from one frame to the "
        "next: turn about x, shift along x, turn about z, shift along z.",
        (),
        Table(head, rows),
    )


@cache
def _transforms() -> tuple[Step, ...]:
    steps = [step for step in planar_base().steps if step.phase == "transform"]
    each = tuple(_value(name, value) for step in steps for name, value in step.values)
    return (
        Step("Transforms", "", each, detail=True),
        Step(
            "The pose",
            "Their product is the planar pose $(x, y, \\psi)$:",
            (_value("T_03", pose(planar_links())),),
        ),
    )


@cache
@cache
def _recursion() -> tuple[Step, ...]:
    base_steps = planar_base().steps
    outward = [step for step in base_steps if step.phase == "outward"]
    inward = [step for step in base_steps if step.phase == "inward"]
    return (
        Step(
            "Outward: velocities and accelerations",
            "From a link to the next, which has a dash; $R$ turns into its frame, $P$ is the "
            "place of its origin, $z$ the axis of its joint with variable $q$, and $P_{C}$ its "
            "centre of mass.",
            tuple(Law(each) for each in _OUTWARD),
            detail=True,
        ),
        *(_link(step, "Outward") for step in outward),
        Step(
            "Inward: forces and moments",
            "Back from the last link: $f$ and $n$ are what the link before gives to a link; those "
            "of the next link, with a dash, are turned by $R$ and act at $P'$. Joint 1 is y, "
            "joint 2 is x, joint 3 is psi: their efforts are $F_{y}$, $F_{x}$ and $M_{z}$.",
            tuple(Law(each) for each in _INWARD),
            detail=True,
        ),
        *(_link(step, "Inward") for step in inward if step.link),
    )


def _link(step: Derived, way: str) -> Step:
    link = planar_links()[step.link - 1]
    zero = [to_latex(sympy.Symbol(name)) for name, value in step.values if not any(value)]
    values: list[Law | Value] = [_value(name, value) for name, value in step.values if any(value)]
    if zero:
        values.append(Law(" = ".join([*zero, "0"])))
    return Step(f"{way}, link {step.link} ({link.name})", "", tuple(values), detail=True)


def _value(name: str, value: Any) -> Value:
    symbol = sympy.Symbol(name)
    if value.shape == (3, 1) and length(value) < _SHORT:
        return Value(symbol ** sympy.Symbol("T"), value.T)
    return Value(symbol, value)
