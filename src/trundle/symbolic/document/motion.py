"""The equations of motion of the body, and Lagrange's as the check."""

from __future__ import annotations

from functools import cache

import sympy

from trundle.symbolic.base import ORDER, planar_base, planar_links
from trundle.symbolic.document.case import Case
from trundle.symbolic.document.parts import Law, Section, Step, Value
from trundle.symbolic.lagrange import christoffel, lagrange, rate_of
from trundle.symbolic.tidy import tidy_matrix

_F = sympy.Matrix(sympy.symbols("F_x F_y M_z"))

_LETTERS = (
    r"In this section $n$ is the bias of the equations of motion, no moment, but for the shaking "
    r"moment $n_{0}$; $\tau = (F_{x}, F_{y}, M_{z})$ is the force on the body, no wheel torque. "
    "With every step shown, $T$ is the kinetic energy and $C$ the Christoffel matrix, not the "
    "transforms and the side-slip rows."
)


def equations_of_motion(case: Case) -> Section:
    """Return M and n, the shaking force and moment, and the check by energies."""
    made = planar_base()
    first, shaking = _forces()
    steps = [
        Step("Letters", _LETTERS),
        first,
        Step(
            "Equations of motion",
            "Sorted by accelerations, with $q = (x, y, \\psi)$ and "
            "$\\tau = (F_{x}, F_{y}, M_{z})$:",
            (
                Law(r"M(q) \ddot{q} + n(q, \dot{q}) = \tau"),
                case.shown("M", made.M),
                case.shown("n", made.n),
            ),
        ),
        shaking,
        *_lagrange(),
    ]
    return Section("Equations of motion of the body", tuple(steps))


@cache
def _forces() -> tuple[Step, Step]:
    """Return the joint efforts, and what the ground gives to the robot."""
    made = planar_base()
    efforts = sympy.Matrix(3, 1, [made.value(f"tau_{i + 1}") for i in ORDER])
    first = Step(
        "Joint efforts",
        "The efforts along x, y and psi are the forces that the wheels must give to the body, in "
        "the inertial frame. Joint 1 is y and joint 2 is x; from here on they are sorted as "
        r"$q = (x, y, \psi)$:",
        (
            Value(r"\tau", _F),
            *(Value(name, effort) for name, effort in zip(_F, efforts, strict=True)),
        ),
        detail=True,
    )
    shaking = Step(
        "Shaking force and moment",
        "What the ground must take: with it a robot that speeds up or turns shakes what it stands "
        "on. Here it is what the ground gives to the robot, about the inertial frame's origin; the "
        "ground feels the opposite. Force and moment are the mass times the acceleration "
        "of its centre, and the rate of the angular momentum.",
        (Value("f_{0}", made.shaking_force), Value("n_{0}", made.shaking_moment)),
    )
    return first, shaking


@cache
def _lagrange() -> tuple[Step, ...]:
    made, other = planar_base(), lagrange(planar_links())
    M = other.M.extract(list(ORDER), list(ORDER))
    n = other.n.extract(list(ORDER), [0])
    C = christoffel(made.M, made.q, made.qd)
    skew = tidy_matrix(rate_of(made.M, made.q, made.qd) - 2 * C)
    agrees = not any(made.M - M) and not any(made.n - n)
    verdict = "The same" if agrees else "The same after simplification"
    return (
        Step(
            "The same by Lagrange",
            "The kinetic energy of the body; there is no potential energy in the plane.",
            (
                Value("T", other.kinetic),
                Law(
                    r"\frac{d}{dt} \frac{\partial T}{\partial \dot{q}} - "
                    r"\frac{\partial T}{\partial q} = \tau"
                ),
            ),
            detail=True,
        ),
        Step(
            "What it gives",
            f"{verdict} $M$ and $n$ come out:",
            (Value("M", M), Value("n", n)),
            detail=True,
        ),
        Step(
            "Christoffel form",
            r"With $C$ from the Christoffel symbols of $M$, $n = C \dot{q}$, and "
            r"$\dot{M} - 2 C$ is skew-symmetric: the power of $\tau$ is the rate of the kinetic "
            "energy.",
            (Value("C", C), Value(r"\dot{M} - 2 C", skew)),
            detail=True,
        ),
    )
