"""Serial chains by their modified Denavit-Hartenberg table, and the transforms that follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy

from trundle.errors import TrundleError
from trundle.symbolic.tidy import tidy_matrix

_KINDS = ("revolute", "prismatic")
_NOTHING = ((0, 0, 0), (0, 0, 0), (0, 0, 0))


@dataclass(frozen=True, kw_only=True)
class Link:
    """One row of a modified (Craig) Denavit-Hartenberg table, and the body that it carries.

    The joint variable is added to ``theta`` (revolute) or to ``d`` (prismatic). All values may be
    numbers or sympy expressions.

    Attributes:
        kind: "revolute" or "prismatic".
        alpha: angle from z of the link before to z of this one, about x of the one before [rad].
        a: distance between the two, along x of the link before [m].
        theta: angle from x of the link before to x of this one, about z of this one [rad].
        d: distance between the two, along z of this link [m].
        mass: mass [kg].
        com: (3,) centre of mass in the link's frame [m].
        inertia: (3, 3) inertia about the centre of mass, along the link's axes [kg m^2].
        name: the joint variable's name; ``q_1``, ``q_2``, ... where it is left out.

    Source: Craig, Introduction to Robotics, 3rd edition, 2005, sections 3.4 and 3.5.

    >>> Link(kind="prismatic", alpha=sympy.pi / 2, mass=2).kind
    'prismatic'
    """

    kind: str
    alpha: Any = 0
    a: Any = 0
    theta: Any = 0
    d: Any = 0
    mass: Any = 0
    com: Sequence[Any] = (0, 0, 0)
    inertia: Sequence[Sequence[Any]] = _NOTHING
    name: str | None = None

    def __post_init__(self) -> None:
        if self.kind not in _KINDS:
            raise TrundleError(f"a link's kind must be {' or '.join(_KINDS)}, got {self.kind!r}")
        if sympy.Matrix(self.com).shape != (3, 1):
            raise TrundleError(f"a link's com must have 3 values, got {self.com!r}")
        inertia = sympy.Matrix(self.inertia)
        if inertia.shape != (3, 3) or not inertia.is_symmetric():
            raise TrundleError(
                f"a link's inertia must be a symmetric matrix (3, 3), got {self.inertia!r}"
            )

    @property
    def turns(self) -> bool:
        """Whether the joint is revolute."""
        return self.kind == "revolute"


class Joints(NamedTuple):
    """The joint variables of a chain, their rates and their accelerations, as symbols."""

    q: tuple[Any, ...]
    qd: tuple[Any, ...]
    qdd: tuple[Any, ...]


def joints(links: Sequence[Link]) -> Joints:
    """Return the symbols of a chain's joints.

    Raises:
        TrundleError: there is no link, or two joints have the same name.

    >>> joints([Link(kind="revolute"), Link(kind="prismatic", name="s")]).qd
    (qdot_1, sdot)
    """
    if not links:
        raise TrundleError("a chain needs at least one link")
    names = [link.name or f"q_{i + 1}" for i, link in enumerate(links)]
    if len(set(names)) < len(names):
        raise TrundleError(f"the joints of a chain need names that differ, got {', '.join(names)}")
    return Joints(*(tuple(_symbol(name, dots) for name in names) for dots in ("", "dot", "ddot")))


def _symbol(name: str, dots: str) -> Any:
    letter, line, index = name.partition("_")
    return sympy.Symbol(letter + dots + line + index, real=True)


def table(links: Sequence[Link]) -> tuple[tuple[Any, Any, Any, Any], ...]:
    """Return the rows (alpha, a, theta, d) with the joint variables in them.

    >>> table([Link(kind="revolute", a=2, theta=sympy.pi / 2)])
    ((0, 2, q_1 + pi/2, 0),)
    """
    return tuple(
        (
            sympy.sympify(link.alpha),
            sympy.sympify(link.a),
            link.theta + (q if link.turns else sympy.Integer(0)),
            link.d + (sympy.Integer(0) if link.turns else q),
        )
        for link, q in zip(links, joints(links).q, strict=True)
    )


def transforms(links: Sequence[Link]) -> tuple[Any, ...]:
    """Return each link's transform (4, 4) to the frame of the link before it.

    ``T = Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)``; the first leads to the base.

    Source: Craig, 2005, section 3.5, eq. (3.6).

    >>> transforms([Link(kind="prismatic", alpha=sympy.pi / 2)])[0]
    Matrix([
    [1, 0,  0,    0],
    [0, 0, -1, -q_1],
    [0, 1,  0,    0],
    [0, 0,  0,    1]])
    """
    return tuple(tidy_matrix(_transform(*row)) for row in table(links))


def _transform(alpha: Any, a: Any, theta: Any, d: Any) -> Any:
    ca, sa = sympy.cos(alpha), sympy.sin(alpha)
    ct, st = sympy.cos(theta), sympy.sin(theta)
    return sympy.Matrix(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -sa * d],
            [st * sa, ct * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )


def pose(links: Sequence[Link]) -> Any:
    """Return the transform (4, 4) from the last link's frame to the base.

    >>> pose([Link(kind="revolute"), Link(kind="revolute", a=1)])[0, 3]
    cos(q_1)
    """
    product = sympy.eye(4)
    for step in transforms(links):
        product = product * step
    return tidy_matrix(product)
