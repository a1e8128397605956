"""The Newton-Euler recursion: velocities outward, forces and moments inward."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import sympy

from trundle.symbolic.chain import Link, joints, transforms
from trundle.symbolic.equations import Derived, Equations, Named, equations_of
from trundle.symbolic.tidy import tidy_matrix

_Z = sympy.ImmutableMatrix([0, 0, 1])
_ZERO = sympy.ImmutableMatrix([0, 0, 0])
_AT_REST = (0, 0, 0)


class Motion(NamedTuple):
    """How a link moves, and the force and moment that this asks for, in the link's own frame."""

    omega: Any
    v: Any
    omega_d: Any
    v_d: Any
    v_d_com: Any = _ZERO
    force: Any = _ZERO
    moment: Any = _ZERO

    def named(self, i: int) -> tuple[Named, ...]:
        """Return the values of link i with their names in a derivation."""
        stems = ("omega_", "v_", "omegadot_", "vdot_", "vdot_C", "F_", "N_")
        return tuple(Named(f"{stem}{i}", value) for stem, value in zip(stems, self, strict=True))


def newton_euler(links: Sequence[Link], gravity: Sequence[Any] = _AT_REST) -> Equations:
    """Return the equations of motion of a chain by the Newton-Euler recursion.

    Outward for each link, with R to the link's frame and P the place of its origin::

        omega' = R omega + theta_d z                      (prismatic: R omega)
        omega_d' = R omega_d + R omega x theta_d z + theta_dd z
        v_d' = R (omega_d x P + omega x (omega x P) + v_d)  (+ 2 omega' x d_d z + d_dd z)
        v_d_C = omega_d' x P_C + omega' x (omega' x P_C) + v_d'
        F = m v_d_C,   N = I omega_d' + omega' x I omega'

    inward, with f and n what the link before gives to a link::

        f = R f' + F,   n = N + R n' + P_C x F + P' x R f'
        tau = z . n (revolute), z . f (prismatic)

    Args:
        links: the rows of the table, from the base outward.
        gravity: (3,) acceleration of gravity in the base frame, such as (0, 0, -g) [m/s^2].

    Source: Craig, Introduction to Robotics, 3rd edition, 2005, section 6.5, eqs. (6.45) to (6.53).

    >>> m, l, g = sympy.symbols("m l g")
    >>> pendulum = Link(kind="revolute", mass=m, com=(l, 0, 0))
    >>> newton_euler([pendulum], gravity=(0, -g, 0)).n
    Matrix([[g*l*m*cos(q_1)]])
    """
    steps_to = transforms(links)
    motions = motions_of(links, gravity)
    wrenches = _inward(links, steps_to, motions)
    efforts = [
        (moment if link.turns else force)[2]
        for link, (force, moment) in zip(links, wrenches[1:], strict=True)
    ]
    told = [
        Derived("transform", i, (Named(f"T_{i - 1}{i}", T),)) for i, T in enumerate(steps_to, 1)
    ]
    told += [Derived("outward", i, motion.named(i)) for i, motion in enumerate(motions, 1)]
    for i, (force, moment) in reversed(list(enumerate(wrenches))):
        told.append(Derived("inward", i, (Named(f"f_{i}", force), Named(f"n_{i}", moment))))
    named = tuple(Named(f"tau_{i}", value) for i, value in enumerate(efforts, 1))
    told.append(Derived("effort", 0, named))
    return equations_of(efforts, joints(links), wrenches[0], tuple(told))


def motions_of(links: Sequence[Link], gravity: Sequence[Any] = _AT_REST) -> tuple[Motion, ...]:
    """Return how the links of a chain move, from the first outward.

    >>> motions_of([Link(kind="revolute"), Link(kind="revolute", a=2)])[1].v.T
    Matrix([[2*qdot_1*sin(q_2), 2*qdot_1*cos(q_2), 0]])
    """
    # A base that accelerates upward makes the links feel gravity.
    motion = Motion(_ZERO, _ZERO, _ZERO, -sympy.ImmutableMatrix(gravity))
    motions = []
    _, qd, qdd = joints(links)
    for link, step, rate, acceleration in zip(links, transforms(links), qd, qdd, strict=True):
        moved = _next_motion(motion, link, step, rate, acceleration)
        motion = Motion(*(tidy_matrix(value, by=qdd + qd) for value in _loaded(moved, link)))
        motions.append(motion)
    return tuple(motions)


def _next_motion(before: Motion, link: Link, step: Any, qd: Any, qdd: Any) -> Motion:
    R, P = step[:3, :3].T, step[:3, 3]
    omega, omega_d = R * before.omega, R * before.omega_d
    v = R * (before.v + before.omega.cross(P))
    v_d = R * (before.omega_d.cross(P) + before.omega.cross(before.omega.cross(P)) + before.v_d)
    if link.turns:
        return Motion(omega + qd * _Z, v, omega_d + omega.cross(qd * _Z) + qdd * _Z, v_d)
    return Motion(omega, v + qd * _Z, omega_d, v_d + 2 * omega.cross(qd * _Z) + qdd * _Z)


def _loaded(motion: Motion, link: Link) -> Motion:
    """Return a link's motion with its com's acceleration and the force and moment it asks for."""
    com, inertia = sympy.Matrix(link.com), sympy.Matrix(link.inertia)
    omega, omega_d = motion.omega, motion.omega_d
    v_d_com = omega_d.cross(com) + omega.cross(omega.cross(com)) + motion.v_d
    moment = inertia * omega_d + omega.cross(inertia * omega)
    return motion._replace(v_d_com=v_d_com, force=link.mass * v_d_com, moment=moment)


def _inward(
    links: Sequence[Link], steps_to: Sequence[Any], motions: Sequence[Motion]
) -> list[tuple[Any, Any]]:
    """Return force and moment on the base, then on each link, each in its own frame."""
    _, qd, qdd = joints(links)
    force, moment = _ZERO, _ZERO
    wrenches = []
    base = Motion(_ZERO, _ZERO, _ZERO, _ZERO)
    coms = [sympy.Matrix(each.com) for each in links]
    to_next = [*steps_to, sympy.eye(4)]
    for motion, com, step in reversed(
        list(zip([base, *motions], [_ZERO, *coms], to_next, strict=True))
    ):
        R, P = step[:3, :3], step[:3, 3]
        moment = motion.moment + R * moment + com.cross(motion.force) + P.cross(R * force)
        force = motion.force + R * force
        force, moment = (tidy_matrix(value, by=qdd + qd) for value in (force, moment))
        wrenches.append((force, moment))
    return wrenches[::-1]
