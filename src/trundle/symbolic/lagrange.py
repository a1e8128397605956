"""The same equations of motion from energies, and the matrix of Christoffel symbols."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import sympy

from trundle.symbolic.chain import Link, joints, transforms
from trundle.symbolic.newton_euler import motions_of
from trundle.symbolic.tidy import tidy, tidy_matrix


class Lagrangian(NamedTuple):
    """Kinetic and potential energy, and M (n, n) and n (n, 1) that follow from them."""

    kinetic: Any
    potential: Any
    M: Any
    n: Any


def lagrange(links: Sequence[Link], gravity: Sequence[Any] = (0, 0, 0)) -> Lagrangian:
    """Return the equations of motion of a chain from its kinetic and potential energy.

    ``d/dt dT/dq_d - dT/dq + dV/dq = tau``, with T = 1/2 q_d^T M q_d.

    Args:
        links: the rows of the table, from the base outward.
        gravity: (3,) acceleration of gravity in the base frame [m/s^2].

    Source: Craig, Introduction to Robotics, 3rd edition, 2005, section 6.9, eq. (6.77).

    >>> m, l, g = sympy.symbols("m l g")
    >>> pendulum = Link(kind="revolute", mass=m, com=(l, 0, 0))
    >>> lagrange([pendulum], gravity=(0, -g, 0)).n
    Matrix([[g*l*m*cos(q_1)]])
    """
    q, qd, _ = joints(links)
    kinetic, potential = kinetic_energy(links), potential_energy(links, gravity)
    momentum = sympy.Matrix([kinetic]).jacobian(qd).T
    M = momentum.jacobian(qd)
    slope = sympy.Matrix([kinetic - potential]).jacobian(q).T
    n = momentum.jacobian(q) * sympy.Matrix(qd) - slope
    return Lagrangian(kinetic, potential, tidy_matrix(M), tidy_matrix(n))


def kinetic_energy(links: Sequence[Link]) -> Any:
    """Return 1/2 (m v_C . v_C + omega . I omega), summed over the links.

    >>> kinetic_energy([Link(kind="prismatic", mass=2)])
    qdot_1**2
    """
    total: Any = 0
    for link, motion in zip(links, motions_of(links), strict=True):
        v_com = motion.v + motion.omega.cross(sympy.Matrix(link.com))
        spin = motion.omega.dot(sympy.Matrix(link.inertia) * motion.omega)
        total += sympy.Rational(1, 2) * (link.mass * v_com.dot(v_com) + spin)
    return tidy(total, by=joints(links).qd)


def potential_energy(links: Sequence[Link], gravity: Sequence[Any]) -> Any:
    """Return -m g . p_C, summed over the links.

    >>> potential_energy([Link(kind="prismatic", mass=2)], (0, 0, -10))
    20*q_1
    """
    total: Any = 0
    place = sympy.eye(4)
    for link, step in zip(links, transforms(links), strict=True):
        place = place * step
        com = (place * sympy.Matrix([*link.com, 1]))[:3, 0]
        total -= link.mass * sympy.Matrix(gravity).dot(com)
    return tidy(total)


def christoffel(M: Any, q: Sequence[Any], qd: Sequence[Any]) -> Any:
    """Return C(q, q_d) (n, n), with which n = C q_d where nothing but M makes forces.

    ``C_ij = sum_k 1/2 (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) q_d_k``

    Source: Siciliano, Sciavicco, Villani and Oriolo, Robotics: Modelling, Planning and Control,
    2009, section 7.2.1, eqs. (7.44) and (7.45).

    >>> q, qd, m = sympy.symbols("q qdot m")
    >>> christoffel(sympy.Matrix([[m * q**2]]), [q], [qd])
    Matrix([[m*q*qdot]])
    """
    size = len(q)

    def entry(i: int, j: int) -> Any:
        return sympy.Rational(1, 2) * sum(
            (M[i, j].diff(q[k]) + M[i, k].diff(q[j]) - M[j, k].diff(q[i])) * qd[k]
            for k in range(size)
        )

    return tidy_matrix(sympy.Matrix(size, size, entry))


def rate_of(M: Any, q: Sequence[Any], qd: Sequence[Any]) -> Any:
    """Return the rate of change of a matrix of q along a motion.

    >>> q, qd = sympy.symbols("q qdot")
    >>> rate_of(sympy.Matrix([[q**2]]), [q], [qd])
    Matrix([[2*q*qdot]])
    """
    return tidy_matrix(
        sum((M.diff(a) * b for a, b in zip(q, qd, strict=True)), sympy.zeros(*M.shape))
    )
