"""The planar rigid body, written once: floats, arrays, symbols and compiled code read it.

The functions are branch-free and take scalars or arrays that broadcast. (x, y) is the centre of
mass in the body frame, (c, s) the cosine and sine of the heading.
"""

from __future__ import annotations

from typing import Any

Three = tuple[Any, Any, Any]


def body_bias(m: Any, x: Any, y: Any, u: Any, v: Any, r: Any) -> Three:
    """Return c(zeta) of ``M zeta_dot + c(zeta) = F`` in the body frame [N, N, N m].

    ``c = m r (-(v + x r), u - y r, x u + y v)``.

    Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd edition, 2021,
    section 3.3, the rigid-body Coriolis matrix in surge, sway and yaw with its centre of gravity
    at (x, y).
    """
    mr = m * r
    return -mr * (v + x * r), mr * (u - y * r), mr * (x * u + y * v)


def inertial_lever(m: Any, x: Any, y: Any, c: Any, s: Any) -> tuple[Any, Any]:
    """Return M[0, 2] and M[1, 2] of M(q), q = (x, y, psi) in the inertial frame [kg m].

    ``M[0, 2] = -m (y c + x s)``, ``M[1, 2] = m (x c - y s)``.

    Source: the lectures' planar base by the Newton-Euler recursion.
    """
    return -m * (y * c + x * s), m * (x * c - y * s)


def to_body(c: Any, s: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the body-frame components of a vector that is given in the inertial frame."""
    return c * x + s * y, c * y - s * x


def to_inertial(c: Any, s: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the inertial components of a vector that is given in the body frame."""
    return c * x - s * y, s * x + c * y
