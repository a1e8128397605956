"""The body's inertia in its own frame, and as the motions and wheels of a robot feel it."""

from __future__ import annotations

from typing import Any

import sympy

from trundle.symbolic import base
from trundle.symbolic.tidy import tidy_matrix

TWIST = sympy.symbols("u v r", real=True)


def body_mass_matrix() -> Any:
    """Return M_B (3, 3) of the body about its origin, in the body frame.

    >>> body_mass_matrix()[2, 2]
    I_cz + m*(x_bc**2 + y_bc**2)
    """
    m, x, y = base.m, base.x_bc, base.y_bc
    corner = base.I_cz + m * (x**2 + y**2)
    return sympy.ImmutableMatrix([[m, 0, -m * y], [0, m, m * x], [-m * y, m * x, corner]])


def body_bias(twist: Any = TWIST) -> Any:
    """Return c_B (3, 1) at a twist (u, v, r): what the turning of the body frame adds.

    Args:
        twist: u, v and r, as symbols or expressions.

    >>> body_bias()[0]
    -m*r*(r*x_bc + v)
    """
    u, v, r = twist
    m, x, y = base.m, base.x_bc, base.y_bc
    return sympy.ImmutableMatrix(
        [-m * r * (v + x * r), m * r * (u - y * r), m * r * (x * u + y * v)]
    )


def projected(columns: Any, bias: Any) -> tuple[Any, Any]:
    """Return ``X^T M_B X`` and ``X^T c_B`` for the columns X: N, or W.

    >>> import trundle
    >>> from trundle.symbolic import symbolic_robot
    >>> N = symbolic_robot(trundle.load("differential")).N
    >>> projected(N, body_bias())[0][0, 1]
    -m*y_bc
    """
    X = sympy.Matrix(columns)
    return tidy_matrix(X.T * body_mass_matrix() * X), tidy_matrix(X.T * bias)
