"""Steering inputs, and the angles and twists that go together.

A robot's steering inputs q are one angle for each wheel that steers alone and one for each group;
wheel i stands at ``ratio_i q``. A pair (q, zeta) is consistent when every side-slip row at those
angles holds for zeta: all wheels share one instantaneous centre.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.kinematics.constraints import frame, rolling_matrix, side_slip_matrix
from trundle.kinematics.linear import RANK_TOLERANCE, null_projector
from trundle.robot import Robot
from trundle.se2 import Array

_SEED = 1996  # any fixed seed: generic points are found the same way at every call
_SAMPLES = 12  # consistent pairs looked at; a space of twists has at most 3 dimensions
_NEWTON_STEPS = 80  # half a digit each where two solutions fall together
# Newton's method ends at rounding: rows have coefficients near 1 and twists have norm 1.
_CONSISTENT = 1e-11
# What Newton's method leaves lies far below this, a true rank far above.
_FOUND = 1e-7


def couplings(robot: Robot) -> Array:
    """Return B (s, g), so that the steering angles are B q for the g independent inputs q."""
    names = [wheel.steering_group or f"\0{wheel.name}" for wheel in robot.steered]
    inputs = list(dict.fromkeys(names))
    out = np.zeros((len(names), len(inputs)))
    for i, (name, wheel) in enumerate(zip(names, robot.steered, strict=True)):
        out[i, inputs.index(name)] = wheel.steering_ratio
    return out


def contact_velocities(robot: Robot, twist: Array) -> Array:
    """Return each steered wheel's contact velocity (..., s, 2), in the wheel's zero frame.

    The first component lies along the wheel's drive direction at steering angle 0.
    """
    straight = np.zeros(len(robot.steered))
    along = rolling_matrix(robot, robot.steered, straight)
    across = side_slip_matrix(robot, robot.steered, straight)
    return np.stack([twist @ along.T, twist @ across.T], axis=-1)


# How far inputs are moved to see whether they can [rad].
_NUDGE = 1e-3


class Generic(NamedTuple):
    """A consistent pair in general position, and what is true around it."""

    steering: Array  # (s,) angles [rad]
    twist: Array  # (3,) of norm 1
    degree: int  # dimension of the twists at these angles
    steerability: int  # independent steering inputs that keep the wheels consistent


def generic_pairs(robot: Robot) -> list[Generic]:
    """Return consistent pairs from random starts, those of the largest family first.

    For wheels that steer alone: a random twist that the fixed wheels allow, and every steered
    wheel along its contact velocity. Linked wheels are brought together by Newton's method on
    ``C(q) zeta = 0`` with minimum-norm steps.

    Source: Campion, Bastin and d'Andrea-Novel, 1996, section III, for the definitions.
    """
    fixed = [wheel for wheel in robot.wheels if not wheel.steers]
    here = frame(robot)
    rows = side_slip_matrix(robot, fixed, np.zeros(len(robot.steered)))
    allowed, _ = null_projector(rows, frame=here)
    if not robot.steered:
        return [Generic(np.zeros(0), allowed[:, 0], round(float(np.trace(allowed))), 0)]
    coupling = couplings(robot)
    random = np.random.default_rng(_SEED)
    found = []
    for _ in range(_SAMPLES):
        twist = allowed @ (here @ random.normal(size=3))
        velocity = contact_velocities(robot, twist)
        angles = np.arctan2(velocity[:, 1], velocity[:, 0])
        inputs = np.asarray(np.linalg.pinv(coupling) @ angles, dtype=np.float64)
        pair = settle(robot, coupling, inputs, twist)
        if pair is not None:
            found.append(_classify(robot, coupling, *pair))
    # Of isolated positions the one nearest to straight comes first.
    return sorted(
        found, key=lambda each: (-each.steerability, float(np.abs(np.sin(each.steering)).max()))
    )


def _derivative(robot: Robot, coupling: Array, inputs: Array, twist: Array) -> tuple[Array, Array]:
    """Return C(q) (m, 3) and the derivative (m, g) of C(q) zeta by q."""
    steering = coupling @ inputs
    fixed = [wheel for wheel in robot.wheels if not wheel.steers]
    held = side_slip_matrix(robot, fixed, steering)
    turning = side_slip_matrix(robot, robot.steered, steering)
    # A steered wheel's side-slip row turns into minus its rolling row.
    by_angle = -np.diag(rolling_matrix(robot, robot.steered, steering) @ twist)
    by_input = np.vstack([np.zeros((len(held), len(inputs))), by_angle @ coupling])
    return np.vstack([held, turning]), by_input


def settle(
    robot: Robot, coupling: Array, inputs: Array, twist: Array
) -> tuple[Array, Array] | None:
    """Return a consistent pair near the given one, by Newton's method, or None."""
    here = frame(robot)
    consistent = False
    for _ in range(_NEWTON_STEPS):
        size = float(np.linalg.norm(np.linalg.solve(here, twist)))
        if size < RANK_TOLERANCE:
            return None
        twist = twist / size
        rows, by_input = _derivative(robot, coupling, inputs, twist)
        miss = rows @ twist
        consistent = bool(np.abs(miss).max(initial=0.0) < _CONSISTENT)
        step, *_ = np.linalg.lstsq(np.hstack([by_input, rows @ here]), -miss, rcond=RANK_TOLERANCE)
        # Where two solutions fall together the miss vanishes before the angles are right.
        if consistent and np.abs(step).max(initial=0.0) < _CONSISTENT:
            break
        inputs, twist = inputs + step[: len(inputs)], twist + here @ step[len(inputs) :]
    return (inputs, twist) if consistent else None


def _classify(robot: Robot, coupling: Array, inputs: Array, twist: Array) -> Generic:
    rows, by_input = _derivative(robot, coupling, inputs, twist)
    rows = rows @ frame(robot)
    both = np.hstack([by_input, rows])
    degree = 3 - _rank(rows)
    steerability = len(inputs) + 3 - _rank(both) - degree
    if steerability and len(inputs) < len(coupling):
        steerability = _movable(robot, coupling, inputs, twist, both)
    return Generic(coupling @ inputs, twist, degree, steerability)


def _movable(robot: Robot, coupling: Array, inputs: Array, twist: Array, both: Array) -> int:
    """Return in how many directions linked inputs can really move from a consistent pair.

    To first order an isolated position may look movable; Newton's method then leads back to it.
    """
    free = np.linalg.svd(both)[2][_rank(both) :]
    left, size, _ = np.linalg.svd(free[:, : len(inputs)])
    moved = []
    for j in np.flatnonzero(size > _FOUND):
        step = _NUDGE * (left[:, j] @ free) / size[j]
        pair = settle(
            robot,
            coupling,
            inputs + step[: len(inputs)],
            twist + frame(robot) @ step[len(inputs) :],
        )
        moved.append(inputs * 0 if pair is None else (pair[0] - inputs) / _NUDGE)
    return int(np.linalg.matrix_rank(np.array(moved), tol=0.5)) if moved else 0


def _rank(rows: Array) -> int:
    return int(np.linalg.matrix_rank(rows, tol=_FOUND)) if rows.size else 0


def motion_space(robot: Robot) -> tuple[Array, bool]:
    """Return a basis (3, k) of all twists that some steering allows, and whether all are allowed.

    The second value is False where linked wheels allow only a curved cone inside that space.
    """
    pairs = generic_pairs(robot)
    if not pairs:
        return np.zeros((3, 0)), True
    best = pairs[0]
    twists = []
    here = frame(robot)
    # Where the steering cannot move, other positions cannot be reached from the first.
    for pair in pairs if best.steerability else pairs[:1]:
        if (pair.degree, pair.steerability) == (best.degree, best.steerability):
            rows = side_slip_matrix(robot, robot.wheels, pair.steering)
            # In the frame the projector's columns span the null space at one scale.
            twists.append(null_projector(rows @ here, _FOUND)[0])
    _, size, vectors = np.linalg.svd(np.concatenate(twists), full_matrices=True)
    kept = int((size > _FOUND).sum())
    space, _ = np.linalg.qr(here @ vectors[:kept].T)
    return space, kept == best.degree + best.steerability
