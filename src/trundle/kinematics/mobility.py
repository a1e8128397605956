"""What a robot can and cannot do: mobility, and the tests of holonomy."""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass

import numpy as np

from trundle.kinematics.constraints import frame, robot_of, side_slip_matrix
from trundle.kinematics.linear import basis, null_projector
from trundle.kinematics.maps import motion_projector, wheel_matrix
from trundle.kinematics.steering import generic_pairs, motion_space
from trundle.kinematics.words import join, motions_in_words
from trundle.robot import FixedWheel, Robot
from trundle.se2 import Array

_TYPES = {
    "(3,0)": "omnidirectional, as far as the constraints go",
    "(2,0)": "like a differential drive",
    "(2,1)": "one steered direction, the rest omni or caster",
    "(1,1)": "like a tricycle, a bicycle or a car",
    "(1,2)": "like a two-steer or a swerve drive",
}


@dataclass(frozen=True)
class Mobility:
    """What a robot can and cannot do.

    Attributes:
        rank: rank of W, the lectures' test (steered robots: at generic consistent angles).
        degree: degree of mobility delta_m, the twists at fixed steering angles.
        steerability: degree of steerability delta_s, the independent steering inputs.
        maneuverability: delta_M = delta_m + delta_s.
        kind: the class as text, such as "(2,0)".
        omnidirectional: degree 3 and rank 3: any twist at once.
        holonomic: the constraints can be integrated (strict test, by Lie brackets).
        controllable: every pose can be reached, and no motion is left that nothing drives.
        motions: the twists that the constraints allow, in words.
        undriven: those among them that no driven wheel pushes.
        reasons: all of it in sentences.
    """

    rank: int
    degree: int
    steerability: int
    maneuverability: int
    kind: str
    omnidirectional: bool
    holonomic: bool
    controllable: bool
    motions: tuple[str, ...]
    undriven: tuple[str, ...]
    reasons: tuple[str, ...]


def mobility(robot: Robot) -> Mobility:
    """Return what a robot can and cannot do.

    ``delta_M = 3 - rank C_f``, ``delta_m = 3 - rank [C_f; C_s(beta)]`` at steering angles that
    share a generic instantaneous centre, ``delta_s = delta_M - delta_m``, lowered by linked
    steering to the independent inputs that keep the wheels consistent.

    Args:
        robot: the robot.

    Returns:
        The mobility, with reasons in words.

    Source: Campion, Bastin and d'Andrea-Novel, Structural properties and classification of
    kinematic and dynamic models of wheeled mobile robots, IEEE Transactions on Robotics and
    Automation 12(1), 1996.

    >>> from trundle import load
    >>> mobility(load("tricycle")).kind
    '(1,1)'
    """
    strict = without_skid(robot_of(robot))
    generic = generic_pairs(strict)
    degree = generic[0].degree if generic else 0
    steerability = generic[0].steerability if generic else 0
    steering = generic[0].steering if generic else np.zeros(len(robot.steered))
    _, can_give = wheel_matrix(robot, steering)
    rank = round(float(np.trace(can_give)))
    allowed, _ = motion_projector(robot, steering)
    free = basis(allowed)
    reachable = _reachable(robot, free)
    closed = closure(reachable)
    found = Mobility(
        rank=rank,
        degree=degree,
        steerability=steerability,
        maneuverability=degree + steerability,
        kind=f"({degree},{steerability})",
        omnidirectional=degree == 3 and rank == 3,
        holonomic=closed.shape[1] == free.shape[1],
        controllable=closed.shape[1] == 3 and rank == free.shape[1],
        motions=motions_in_words(free if not robot.steered else reachable),
        undriven=motions_in_words(basis(allowed - can_give)),
        reasons=(),
    )
    return dataclasses.replace(found, reasons=_reasons(robot, found, free.shape[1]))


def without_skid(robot: Robot) -> Robot:
    """Return the robot with every skidding wheel held against side slip."""
    wheels = tuple(
        dataclasses.replace(w, skid=False, track_factor=1.0) if isinstance(w, FixedWheel) else w
        for w in robot.wheels
    )
    return dataclasses.replace(robot, wheels=wheels)


def _reachable(robot: Robot, free: Array) -> Array:
    """Return a basis of all twists that the robot can have at one steering or another."""
    return motion_space(robot)[0] if robot.steered else free


def bracket(first: Array, second: Array) -> Array:
    """Return the Lie bracket of two twists in se(2).

    >>> bracket(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])).tolist()
    [0.0, -1.0, 0.0]
    """
    (u1, v1, r1), (u2, v2, r2) = first, second
    return np.array([-r1 * v2 + r2 * v1, r1 * u2 - r2 * u1, 0.0])


def closure(space: Array) -> Array:
    """Return a basis (3, m) of the smallest Lie algebra that holds the twists (3, k)."""
    while True:
        pairs = itertools.combinations(space.T, 2)
        grown = np.column_stack([space, *(bracket(a, b) for a, b in pairs)])
        left, size, _ = np.linalg.svd(grown)
        rank = int((size > 1e-9).sum())
        if rank <= space.shape[1]:
            return space
        space = left[:, :rank]


def _reasons(robot: Robot, found: Mobility, dimension: int) -> tuple[str, ...]:
    return (
        *_why_degree(robot, found),
        *_why_rank(found),
        *_why_holonomic(robot, found, dimension),
    )


def _why_degree(robot: Robot, found: Mobility) -> list[str]:
    fixed = [w for w in robot.wheels if not w.steers and w.rows().side_slip is not None]
    steered, skids = robot.steered, [w for w in robot.wheels if w.rows().skid is not None]
    told = []
    if fixed:
        rows = side_slip_matrix(robot, fixed, np.zeros(len(steered)))
        held = int(null_projector(rows, frame=frame(robot))[1])
        names = join([repr(w.name) for w in fixed])
        told.append(f"The side slip of {names} takes away {held} of the 3 motions of the plane.")
    if steered:
        names = join([repr(w.name) for w in steered])
        change = (
            f"steering changes which, with {found.steerability} independent "
            f"input{'s' * (found.steerability != 1)}"
            if found.steerability
            else "the steering cannot be moved without losing the common centre"
        )
        told.append(
            f"At fixed steering angles {names} leave{'s' * (len(steered) == 1)} {found.degree} "
            f"free motion{'s' * (found.degree != 1)}; {change}."
        )
    if skids:
        told.append(
            f"Without slip, the {len(skids)} wheels that may skid would leave degree "
            f"{found.degree}; the robot turns because they slip sideways."
        )
    if not (fixed or steered or skids):
        told.append("No wheel resists side slip: every motion of the plane is allowed.")
    name = _TYPES.get(found.kind, "degenerate: none of the five useful classes")
    return [*told, f"Class {found.kind}: {name}."]


def _why_rank(found: Mobility) -> list[str]:
    if found.omnidirectional:
        return ["W has rank 3: the driven wheels give every twist; the lectures call it holonomic."]
    if found.rank == 3:
        return []
    return [f"W has rank {found.rank}, less than 3: the lectures call it non-holonomic."]


def _why_holonomic(robot: Robot, found: Mobility, dimension: int) -> list[str]:
    told = []
    if found.degree == 3:
        told.append("Nothing holds the robot, so there is no constraint to integrate: holonomic.")
    elif found.holonomic and found.rank < 3:
        told.append(
            "The Lie brackets of the allowed twists give nothing new, so the constraints can be "
            "integrated: holonomic in the strict sense, though it cannot go everywhere. Here the "
            "two tests differ."
        )
    elif not found.holonomic:
        told.append(
            f"The Lie brackets of the {dimension} allowed twist{'s' * (dimension != 1)}"
            f"{' and of steering' * bool(robot.steered)} give more: the constraints cannot be "
            "integrated, truly non-holonomic."
        )
    if found.controllable:
        told.append("Every pose can be reached.")
    elif found.rank < dimension:
        told.append("Not every allowed motion is driven, so not every pose can be reached at will.")
    else:
        told.append("Not every pose can be reached.")
    return told
