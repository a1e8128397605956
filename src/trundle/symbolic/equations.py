"""The equations of motion of a chain, and the steps that led to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy

from trundle.symbolic.chain import Joints
from trundle.symbolic.tidy import tidy_matrix


class Named(NamedTuple):
    """A value with the name of its symbol, such as ``vdot_C1``."""

    name: str
    value: Any


class Derived(NamedTuple):
    """One step of a derivation: its phase, the link that it is about, and what it gives.

    Phases are "transform", "outward", "inward" and "effort"; links count from 1, the base is 0.
    """

    phase: str
    link: int
    values: tuple[Named, ...]

    def __getitem__(self, key: Any) -> Any:
        """Return a value by its name, or an item of the tuple."""
        if isinstance(key, str):
            return dict(self.values)[key]
        return tuple.__getitem__(self, key)


@dataclass(frozen=True, eq=False)
class Equations:
    """M(q) q_dd + n(q, q_d) = tau, with what the chain does to the ground.

    Attributes:
        q: joint variables.
        qd: their rates.
        qdd: their accelerations.
        M: (n, n) mass matrix.
        n: (n, 1) what speeds and gravity ask for.
        parameters: the other symbols in M and n, in order of name.
        shaking_force: (3, 1) force that the ground gives to the first link, in the base frame;
            the ground feels the opposite.
        shaking_moment: (3, 1) moment that it gives, about the base's origin.
        steps: the derivation, in order.

    >>> from trundle.symbolic import planar_base
    >>> planar_base().parameters
    (I_cz, m, x_bc, y_bc)
    """

    q: tuple[Any, ...]
    qd: tuple[Any, ...]
    qdd: tuple[Any, ...]
    M: Any
    n: Any
    parameters: tuple[Any, ...]
    shaking_force: Any
    shaking_moment: Any
    steps: tuple[Derived, ...] = ()

    @property
    def efforts(self) -> Any:
        """The joint efforts tau (n, 1) for given accelerations."""
        return self.M * sympy.Matrix(self.qdd) + self.n

    def value(self, name: str) -> Any:
        """Return what the derivation calls by a name, such as ``omega_2``.

        >>> from trundle.symbolic import planar_base
        >>> planar_base().value("omega_3").T
        Matrix([[0, 0, psidot]])
        """
        return {each.name: each.value for step in self.steps for each in step.values}[name]


def equations_of(
    efforts: Sequence[Any], joints: Joints, shaking: tuple[Any, Any], steps: tuple[Derived, ...]
) -> Equations:
    """Return the equations of motion that joint efforts, linear in the accelerations, say."""
    q, qd, qdd = joints
    tau = sympy.Matrix(efforts)
    M = tidy_matrix(tau.jacobian(qdd))
    n = tidy_matrix(tau.subs(dict.fromkeys(qdd, 0)), by=qd)
    parameters = (M.free_symbols | n.free_symbols) - {*q, *qd, *qdd}
    return Equations(
        q=q,
        qd=qd,
        qdd=qdd,
        M=M,
        n=n,
        parameters=tuple(sorted(parameters, key=str)),
        shaking_force=shaking[0],
        shaking_moment=shaking[1],
        steps=steps,
    )
