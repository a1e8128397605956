"""The equations of motion that are left on the motions that the wheels allow."""

from __future__ import annotations

from typing import Any

import sympy

from trundle.symbolic.document.case import LONG, Case
from trundle.symbolic.document.figures import figure, with_numbers
from trundle.symbolic.document.parts import Law, Step, Value
from trundle.symbolic.reduced import TWIST, body_bias, body_mass_matrix, projected
from trundle.symbolic.spaces import numbers
from trundle.symbolic.tidy import length, tidy, tidy_matrix

_RATES = sympy.symbols("udot vdot rdot", real=True)
_PROJECTED = (
    r"N^{T} M_{B} N \dot{z} + N^{T} c_{B} = \left(R^{-1} A N\right)^{T} \tau_{w}, "
    r"\quad \zeta = N z"
)


def reduced_dynamics(case: Case) -> list[Step]:
    """Return the equations of motion in the motions, or in the wheel speeds, of a robot."""
    if not case.made.N.cols:
        return []
    body = Step(
        "Reduced dynamics",
        r"In the body frame $M_{B} \dot{\zeta} + c_{B} = F_{B}$, up to the side forces of the "
        "ground. $c_{B}$ is there because the body frame turns.",
        (case.shown("M_{B}", body_mass_matrix()), case.shown("c_{B}", body_bias())),
    )
    if case.robot.steered:
        return [body, _steered()]
    if case.made.N.cols == 3 and not case.made.undriven.cols:
        return [body, _in_wheels(case)]
    return [body, *_in_motions(case)]


def _steered() -> Step:
    return Step(
        "With the constraints",
        "At steering angles that stay fixed, the side forces drop out as in virtual work; while "
        r"angles turn, $N$ changes and $N^{T} M_{B} \dot{N} z$ comes in. In Python, "
        "trundle.Dynamics(robot).torques(..., steering=...) has the numbers.",
        (Law(_PROJECTED),),
    )


def _in_motions(case: Case) -> list[Step]:
    """Return the equations in z, and one by one where z is part of u, v and r."""
    N = case.made.N
    plain = all(sorted(map(str, N.col(j))) == ["0", "0", "1"] for j in range(N.cols))
    z = _motions(N, plain)
    text = (
        r"Put $\zeta = N z$ in, with $N$ constant, and multiply by $N^{T}$ from the left: the side "
        "forces do no work and drop out."
    )
    if length(N) > LONG:
        return [Step("Without the side forces", text, (Law(_PROJECTED),))]
    M, c = projected(N, body_bias(sympy.Matrix(N) * z))
    gain = tidy_matrix((case.made.R.inv() * case.made.A * N).T)
    values = [
        _short(case, "N^{T} M_{B} N", M),
        _short(case, "N^{T} c_{B}", c),
        _short(case, r"\left(R^{-1} A N\right)^{T}", gain),
    ]
    vector = Value("z", z)
    told = tuple(each for each in (vector, *values) if each is not None)
    steps = [Step("Without the side forces", text, (Law(_PROJECTED), *told))]
    return steps + ([_one_by_one(case, M, c, gain)] if plain else [])


def _motions(N: Any, plain: bool) -> Any:
    """Return z (k, 1): u, v and r where the columns of N are these, else z_1, z_2, ..."""
    if plain:
        return sympy.Matrix([TWIST[list(N.col(j)).index(1)] for j in range(N.cols)])
    return sympy.Matrix([sympy.Symbol(f"z_{j + 1}", real=True) for j in range(N.cols)])


def _one_by_one(case: Case, M: Any, c: Any, gain: Any) -> Step:
    N = case.made.N
    rates = sympy.Matrix([_RATES[list(N.col(j)).index(1)] for j in range(N.cols)])
    names = [sympy.Symbol(f"tau_{each.number}", real=True) for each in case.made.driven]
    left, right = M * rates + c, (gain * sympy.Matrix(names)).applyfunc(tidy)
    formulas = [Value(a, b) for a, b in zip(left, right, strict=True)]
    text = r"One by one, with $\tau_{i}$ the torque of wheel $i$"
    values = case.values | case.masses
    if case.masses:
        text += ", and again with this robot's numbers"
        formulas += [
            Value(with_numbers(a, values), with_numbers(b, values))
            for a, b in zip(left, right, strict=True)
        ]
    return Step("The scalar equations", f"{text}:", tuple(formulas))


def _in_wheels(case: Case) -> Step:
    """Return the equations in wheel speeds, for robots whose wheels give every twist."""
    W = case.made.W
    text = r"No side force holds this robot, and $\zeta = W \omega$ with $W$ constant:"
    if W.cols > W.rows:
        text = (
            r"No side force holds this robot, and $\zeta = W \omega$ with $W$ constant. More "
            r"wheels than motions: $M_{w}$ has rank 3, and $\tau_{w}$ are the torques of least "
            "norm."
        )
    laws = (
        Law(r"M_{w} \dot{\omega} + c_{w} = \tau_{w}"),
        Law(r"M_{w} = W^{T} M_{B} W, \quad c_{w} = W^{T} c_{B}"),
    )
    if length(W) > LONG:
        return Step("In wheel speeds", text, (*laws, *_long_wheels(case)))
    M, c = projected(W, body_bias())
    told = (_short(case, "M_{w}", M), _short(case, "c_{w}", c))
    return Step("In wheel speeds", text, (*laws, *(each for each in told if each is not None)))


def _long_wheels(case: Case) -> tuple[Value, ...]:
    """Return M_w and c_w in numbers, where W in symbols is long."""
    if not case.masses:
        return ()
    values = case.values | case.masses
    W = sympy.Matrix(numbers(case.made.W, case.values))
    M, c = W.T * body_mass_matrix() * W, W.T * body_bias()
    return (
        case.plain("M_{w}", with_numbers(M, values)),
        case.plain("c_{w}", with_numbers(c, values)),
    )


def _short(case: Case, left: str, right: Any) -> Value | None:
    """Return ``left = right``; only its numbers where it is long; None where it has none."""
    if length(right) <= LONG:
        return case.shown(left, right)
    values = case.values | case.masses
    if right.free_symbols <= set(values):
        found = numbers(right, values)
        return case.plain(
            left, sympy.Matrix(*found.shape, [figure(each) for each in found.ravel().tolist()])
        )
    return case.plain(left, with_numbers(right, values)) if case.masses else None
