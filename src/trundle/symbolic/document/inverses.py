"""The lectures' pseudo-inverses of W, derived."""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

from trundle.symbolic.document.case import LONG, Case
from trundle.symbolic.document.figures import figure
from trundle.symbolic.document.parts import Law, Section, Step
from trundle.symbolic.pseudo_inverse import PseudoInverse, pseudo_inverse
from trundle.symbolic.spaces import numbers
from trundle.symbolic.tidy import length

_SEED = 1996
# Rounding lies far below this, a difference of formulas far above.
_EQUAL = 1e-9
_LEAST_SQUARES = (
    ("The distance to make small",
     r"The twists $W \omega$ do not fill the space of all twists. Of a twist $\zeta$ that lies "
     "outside, take the nearest: make the sum of squares $F$ (no force) of what is missing small.",
     (r"F(\omega) = \left(\zeta - W \omega\right)^{T} \left(\zeta - W \omega\right) = "
      r"\zeta^{T} \zeta - 2 \omega^{T} W^{T} \zeta + \omega^{T} W^{T} W \omega",)),
    ("Its slope is zero",
     "At the smallest value the gradient vanishes; the second derivative is positive where the "
     "columns of $W$ are independent.",
     (r"\frac{\partial F}{\partial \omega} = -2 W^{T} \zeta + 2 W^{T} W \omega = 0",
      r"\frac{\partial^{2} F}{\partial \omega^{2}} = 2 W^{T} W")),
    ("Solved for the wheel speeds", "",
     (r"W^{T} W \omega = W^{T} \zeta", r"\omega = \left(W^{T} W\right)^{-1} W^{T} \zeta")),
)  # fmt: skip
_LEAST_NORM = (
    ("The speeds to keep small",
     r"Many wheel speeds give the same twist $\zeta$. Of all of them take the smallest: the least "
     r"$\omega^{T} \omega$ with $W \omega = \zeta$ kept, by a Lagrange multiplier $\lambda$ for "
     "each of the three conditions.",
     (r"L(\omega, \lambda) = \frac{1}{2} \omega^{T} \omega + \lambda^{T} "
      r"\left(\zeta - W \omega\right)",)),
    ("Its slopes are zero", "",
     (r"\frac{\partial L}{\partial \omega} = \omega - W^{T} \lambda = 0",
      r"\frac{\partial L}{\partial \lambda} = \zeta - W \omega = 0")),
    ("The multiplier, then the wheel speeds",
     "The first goes into the second, which gives the multiplier, and that goes back into the "
     "first.",
     (r"\zeta = W W^{T} \lambda", r"\lambda = \left(W W^{T}\right)^{-1} \zeta",
      r"\omega = W^{T} \left(W W^{T}\right)^{-1} \zeta")),
)  # fmt: skip
_PLAIN = (
    ("As many wheels as motions",
     r"$W$ is square and regular: there is exactly one $\omega$ for each $\zeta$. Both "
     "pseudo-inverses come to the same.",
     (r"\left(W^{T} W\right)^{-1} W^{T} = W^{-1} W^{-T} W^{T} = W^{-1}",
      r"W^{T} \left(W W^{T}\right)^{-1} = W^{T} W^{-T} W^{-1} = W^{-1}")),
)  # fmt: skip
_MIXED = (
    "Least squares mix m/s and rad/s as plain numbers: $W^{T} W$ adds squares of both, such as m² "
    "and 1."
)
_DERIVED = {"left": _LEAST_SQUARES, "right": _LEAST_NORM, "inverse": _PLAIN}
_NAMES = {
    "left": ("least squares", r"\left(W^{T} W\right)^{-1} W^{T}", r"W^{T} W"),
    "right": ("minimum norm", r"W^{T} \left(W W^{T}\right)^{-1}", r"W W^{T}"),
    "inverse": ("the inverse", "W^{-1}", ""),
}


def inverses(case: Case) -> Section:
    """Return the derivation of the pseudo-inverse that this robot's W has, or why it has none."""
    told = pseudo_inverse(case.made)
    which = Step("Which one", _which(case, told))
    if told.kind == "none":
        return Section("The pseudo-inverse of W", (which, *_without(case)))
    steps = [which]
    steps += [
        Step(heading, text, tuple(Law(each) for each in laws), detail=True)
        for heading, text, laws in _DERIVED[told.kind]
    ]
    return Section("The pseudo-inverse of W", (*steps, *_here(case, told)))


def _which(case: Case, told: PseudoInverse) -> str:
    count = case.made.W.cols
    size = f"$W$ is 3 by {count} and has rank {told.rank}. "
    if not count:
        return "No wheel is driven: there is no $W$ to invert."
    if told.kind == "left":
        return size + (
            "Its columns are independent, but fewer than the three components of a twist: not "
            "every twist can be given, and the nearest is taken, by least squares."
        )
    if told.kind == "right":
        return size + (
            "It gives every twist, with more wheels than needed: the smallest wheel speeds are "
            "taken, by a Lagrange multiplier."
        )
    if told.kind == "inverse":
        return size + "It gives every twist, and with three wheels in one way only."
    return size + (
        f"Neither pseudo-inverse of the lectures exists: $W^{{T}} W$ ({count} by {count}) and "
        "$W W^{T}$ (3 by 3) both have that rank and cannot be inverted. The wheels share less "
        "motion than there are wheels, and do not give every twist."
    )


def _without(case: Case) -> list[Step]:
    if not case.made.W.cols:
        return []
    return [
        Step(
            "What to take instead",
            "Each driven wheel has its own rolling row. For a twist that the robot can have, they "
            "give speeds that fit together; for any other, first take the nearest that it can "
            r"have, $N \left(N^{T} N\right)^{-1} N^{T} \zeta$.",
            (Law(r"\omega = R^{-1} A\, \zeta"),),
        )
    ]


def _here(case: Case, told: PseudoInverse) -> list[Step]:
    words, name, normal = _NAMES[told.kind]
    law = Law(rf"\omega = W^{{+}} \zeta, \quad W^{{+}} = {name}")
    heading = f"For this robot: {words}"
    if told.matrix is None:
        return [Step(heading, "The entries are too long to write out.", (law,))]
    if length(told.matrix) > LONG:
        text = "The entries are long; with this robot's numbers:"
        numbers = case.shown("W^{+}", told.matrix).numbers
        return [Step(heading, text, (law, case.plain("W^{+}", numbers)))]
    steps = []
    if normal:
        formula = case.factored(normal, told.normal)
        mixed = _MIXED if told.kind == "left" else ""
        steps.append(Step("The matrix to invert", mixed, (formula,), detail=True))
    text = _compared(case, told.matrix)
    steps.append(Step(heading, text, (law, case.factored("W^{+}", told.matrix))))
    return [*steps, _check(case, told)]


def _compared(case: Case, matrix: Any) -> str:
    rows = case.made.R.inv() * case.made.A
    # Equal formulas are equal at sizes of no special place.
    random = np.random.default_rng(_SEED)
    anywhere = {symbol: random.uniform(0.5, 1.5) for symbol in case.values}
    if np.abs(numbers(matrix - rows, anywhere)).max() < _EQUAL:
        return r"It is the same as the rolling rows solved one by one, $R^{-1} A$."
    return (
        r"For twists that the robot can have it agrees with the rolling rows, $R^{-1} A$; for "
        "others the sum of squares counts 1 m/s as much as 1 rad/s, and its answer depends on "
        "that choice of units."
    )


def _check(case: Case, told: PseudoInverse) -> Step:
    W, inverse = case.made.W, told.matrix
    product, name = (inverse * W, "W^{+} W") if told.kind == "left" else (W * inverse, "W W^{+}")
    found = numbers(product, case.values)
    check = sympy.Matrix(*found.shape, [figure(value) for value in found.ravel().tolist()])
    return Step("Check", "", (case.plain(name, check),), detail=True)
