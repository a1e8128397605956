"""Integrability: what the Lie brackets of the allowed twists add to them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import sympy

from trundle.kinematics import mobility
from trundle.symbolic.robot import SymbolicRobot, generic_angles
from trundle.symbolic.spaces import independent, numbers
from trundle.symbolic.tidy import tidy_matrix


class Found(NamedTuple):
    """A twist got from others, by a bracket or by moving a steering input.

    Attributes:
        name: what it is called, such as ``g_3``.
        parents: the names of the two twists of a bracket; or of one, and the input's symbol.
        twist: (3, 1) the twist.
        new: whether it is independent of those before it.
    """

    name: str
    parents: tuple[str, Any]
    twist: Any
    new: bool


class Integrability(NamedTuple):
    """The allowed twists, what is got from them, and what that says.

    Attributes:
        allowed: names and twists (3, 1) that the constraints allow at fixed steering angles.
        found: what brackets and steering give, in order, as far as they are needed.
        dimension: of the smallest Lie algebra that holds all of them.
        integrable: whether nothing new was found: holonomic in the strict sense.
    """

    allowed: tuple[tuple[str, Any], ...]
    found: tuple[Found, ...]
    dimension: int
    integrable: bool


def bracket(first: Any, second: Any) -> Any:
    """Return the Lie bracket (3, 1) of two twists in se(2).

    ``[(u1, v1, r1), (u2, v2, r2)] = (r2 v1 - r1 v2, r1 u2 - r2 u1, 0)``

    Source: Lynch and Park, Modern Robotics, 2017, section 13.3.2, with the vector fields of
    the columns of J(psi).

    >>> bracket(sympy.Matrix([1, 0, 0]), sympy.Matrix([0, 0, 1])).T
    Matrix([[0, -1, 0]])
    """
    (u1, v1, r1), (u2, v2, r2) = first, second
    return tidy_matrix(sympy.Matrix([r2 * v1 - r1 * v2, r1 * u2 - r2 * u1, 0]))


def integrability(made: SymbolicRobot) -> Integrability:
    """Return what the Lie brackets of a robot's allowed twists say of its constraints.

    The constraints can be integrated if brackets, and moving the steering inputs, give no twist
    that is not allowed already. Independence is decided by the robot's numbers.

    Source: the lectures' definition of holonomy; Campion, Bastin and d'Andrea-Novel, 1996,
    section III, for steered wheels.

    >>> import trundle
    >>> from trundle.symbolic import symbolic_robot
    >>> told = integrability(symbolic_robot(trundle.load("differential")))
    >>> told.found[0].twist.T, told.dimension, told.integrable
    (Matrix([[0, -1, 0]]), 3, False)
    """
    values = made.values(generic_angles(made.robot))
    named = [(f"g_{j + 1}", made.N.col(j)) for j in range(made.N.cols)]
    allowed = tuple(named)
    steering = _movable(made)
    found: list[Found] = []
    tried = 0
    while tried < len(named) < 3:
        name, twist = named[tried]
        offers = [((name, beta), tidy_matrix(twist.diff(beta))) for beta in steering]
        offers += [((other, name), bracket(g, twist)) for other, g in named[:tried]]
        tried += 1
        for parents, made_of in offers:
            if len(named) == 3 or not any(made_of):
                continue
            together = sympy.Matrix.hstack(*(g for _, g in named), made_of).T
            new = len(independent(_scaled(numbers(together, values), made))) == len(named) + 1
            label = f"g_{len(named) + 1}" if new else ""
            found.append(Found(label, parents, made_of, new))
            if new:
                named.append((label, made_of))
    return Integrability(allowed, tuple(found), len(named), len(named) == len(allowed))


def _movable(made: SymbolicRobot) -> tuple[Any, ...]:
    """Return the steering inputs on which the allowed twists depend, if they can be moved."""
    if mobility(made.robot).steerability == 0:
        return ()
    return tuple(beta for beta in made.inputs.symbols if made.N.has(beta))


def _scaled(twists: Any, made: SymbolicRobot) -> Any:
    """Return twists in rows with yaw as the speed that it gives far from the origin."""
    return twists * np.array([1.0, 1.0, made.robot.reach])
