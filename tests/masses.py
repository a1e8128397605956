"""Masses for the robots of the laws, and Newton's laws apart from trundle's equations.

Bodies are split into mass points whose positions are differentiated numerically; a robot on its
wheels is taken apart into its body and its wheels, each with its own acceleration, and the forces
between them and from the ground are unknowns of one linear system. Constraint rows come from
``geometry``.
"""

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy import linalg

from catalogue import CURVED, CURVED_RATIOS, ROBOTS, feasible_twists, seen_from, steering_for
from geometry import (
    Floats,
    allowed_twists,
    rolling_rows,
    slip_rows,
    turning,
    velocity,
    widened,
)
from trundle.robot import Body, FixedWheel, Robot, SteeredWheel, SwedishWheel, Wheel
from trundle.robot.wheels import RollingWheel

# Coulomb friction is smoothed within this wheel speed [rad/s], as its docstring says.
SLOW = 0.01
# Singular values below this share of the largest are rounding: dozens of sums at 1e-16.
_RANK = 1e-11


# ---- robots with masses --------------------------------------------------------------------


def heavy(robot: Robot) -> Robot:
    """Return the robot with a mass, inertia, spin and friction of its own for each part."""
    random = np.random.default_rng(sum(map(ord, robot.name)))
    mass, size = float(random.uniform(5.0, 50.0)), robot.reach
    x, y = random.uniform(-0.4, 0.4, 2) * size
    body = Body(
        mass=mass,
        inertia=float(mass * random.uniform(0.05, 0.3) * size**2),
        com=(float(x), float(y)),
    )

    def weighed(wheel: Wheel) -> Wheel:
        m, a = float(random.uniform(0.2, 3.0)), getattr(wheel, "radius", None) or 0.02
        new: dict[str, Any] = {"mass": m, "yaw_inertia": float(random.uniform(0.1, 1.0) * m * a**2)}
        if isinstance(wheel, RollingWheel):
            new["spin_inertia"] = float(random.uniform(0.3, 3.0) * m * a**2)
            new["viscous_friction"], new["coulomb_friction"] = map(
                float, random.uniform(0.0, 0.3, 2)
            )
        return dataclasses.replace(wheel, **new)

    return dataclasses.replace(
        robot, wheels=tuple(weighed(wheel) for wheel in robot.wheels), body=body
    )


HEAVY: dict[str, Robot] = {name: heavy(robot) for name, robot in ROBOTS.items()}
each_heavy = pytest.mark.parametrize("robot", HEAVY.values(), ids=HEAVY)
UNSTEERED = {name: robot for name, robot in HEAVY.items() if not robot.steered}
each_unsteered = pytest.mark.parametrize("robot", UNSTEERED.values(), ids=UNSTEERED)
STEERED = {name: robot for name, robot in HEAVY.items() if robot.steered}
each_steered_heavy = pytest.mark.parametrize("robot", STEERED.values(), ids=STEERED)


def frictionless(robot: Robot) -> Robot:
    """Return the robot without friction at its wheels."""
    return robot.with_wheels(viscous_friction=0.0, coulomb_friction=0.0)


def heavy_seen_from(robot: Robot, x: float, y: float, angle: float) -> Robot:
    """Return the robot and its masses described in a frame at (x, y, angle) in its body frame."""
    assert robot.body is not None
    assert robot.body.com is not None
    com = (complex(*robot.body.com) - complex(x, y)) * np.exp(-1j * angle)
    body = dataclasses.replace(robot.body, com=(float(com.real), float(com.imag)))
    return dataclasses.replace(seen_from(robot, x, y, angle), body=body)


# ---- motions -------------------------------------------------------------------------------


class Motion(NamedTuple):
    """A twist (3,), steering angles (s,) that allow it, and rates (s,) that go on allowing it."""

    twist: Floats
    steering: Floats
    rate: Floats


def slope(at: Callable[[float], Any], size: float = 1.0) -> Any:
    """Return the derivative at zero of a smooth function whose scale of change is 1 / size.

    By the five-point rule: its error, 1e-14 at this step, is that of rounding.
    """
    h = 1e-3 / max(1.0, size)
    return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)


def motions(robot: Robot, count: int = 3, seed: int = 11) -> list[Motion]:
    """Return motions that the robot can make, steering on the way where it steers."""
    if robot.name == CURVED.name:
        return _curved_motions(robot, count, seed)
    here, change = (feasible_twists(robot, (count,), seed + i) for i in range(2))
    if not robot.steered:
        return [Motion(twist, np.zeros(0), np.zeros(0)) for twist in here]
    return [
        Motion(twist, steering_for(robot, twist), steering_rates(robot, twist, turn))
        for twist, turn in zip(here, change, strict=True)
    ]


def steering_rates(robot: Robot, twist: Floats, change: Floats) -> Floats:
    """Return how fast wheels along their contact velocities turn while the twist changes."""
    here = [velocity(list(twist), wheel.x, wheel.y) for wheel in robot.steered]
    later = [velocity(list(change), wheel.x, wheel.y) for wheel in robot.steered]
    return np.array([(b / a).imag for a, b in zip(here, later, strict=True)])


def _curved_motions(robot: Robot, count: int, seed: int) -> list[Motion]:
    random = np.random.default_rng(seed)
    found = []
    for angle, speed, rate in random.uniform(0.2, 1.2, (count, 3)):
        steering = np.array(CURVED_RATIOS) * angle
        twist = speed * allowed_twists(robot, list(steering))[:, 0]
        found.append(Motion(twist, steering, np.array(CURVED_RATIOS) * rate))
    return found


def steered_at(robot: Robot, motion: Motion) -> dict[str, Any]:
    """Return the keywords for a motion's steering, none for robots that do not steer."""
    if not robot.steered:
        return {}
    return {"steering": motion.steering, "steering_rate": motion.rate}


def torques_for(robot: Robot, seed: int = 5, shape: tuple[int, ...] = ()) -> Floats:
    """Return random torques (*shape, n) of the motors."""
    return np.random.default_rng(seed).normal(scale=3.0, size=(*shape, len(robot.driven)))


def rolling_wheels(robot: Robot) -> list[RollingWheel]:
    """Return the wheels that turn with the motion, in order."""
    return [wheel for wheel in robot.wheels if isinstance(wheel, RollingWheel)]


def friction(wheels: Sequence[RollingWheel], speeds: Floats) -> Floats:
    """Return the friction torques of wheels without motors at their speeds (k,)."""
    return np.array(
        [
            wheel.viscous_friction * speed
            + wheel.coulomb_friction * speed / math.hypot(speed, SLOW)
            for wheel, speed in zip(wheels, speeds, strict=True)
        ]
    )


# ---- mass points ---------------------------------------------------------------------------


def points(robot: Robot) -> tuple[Floats, Floats]:
    """Return mass points (k,) and their places (k, 2) in the body frame.

    Body and wheels are a pair of points each, with the same mass, centre of mass and inertia.
    """
    assert robot.body is not None
    parts = [(robot.body.mass, robot.body.inertia, robot.body.com)]
    parts += [(wheel.mass, wheel.yaw_inertia, (wheel.x, wheel.y)) for wheel in robot.wheels]
    mass, place = [], []
    for i, (m, inertia, at) in enumerate(parts):
        if m == 0:
            assert inertia == 0  # a point without mass cannot carry inertia
            continue
        arm = math.sqrt(inertia / m) * np.array([math.cos(i), math.sin(i)])
        mass += [m / 2, m / 2]
        place += [at + arm, at - arm]
    return np.array(mass), np.array(place)


def positions(robot: Robot, pose: Any) -> Any:
    """Return where the mass points (k, 2) are at a pose, which may be complex (complex step)."""
    x, y, psi = pose
    c, s = np.cos(psi), np.sin(psi)
    at = points(robot)[1]
    return np.stack([x + c * at[:, 0] - s * at[:, 1], y + s * at[:, 0] + c * at[:, 1]], axis=-1)


_STEP = 1e-30  # of complex-step differentiation, which loses no digits however small


def velocities(robot: Robot, pose: Floats, rate: Floats) -> Floats:
    """Return the mass points' velocities (k, 2), exact to rounding."""
    return np.imag(positions(robot, np.asarray(pose) + 1j * _STEP * np.asarray(rate))) / _STEP


def points_energy(robot: Robot, pose: Floats, rate: Floats) -> float:
    """Return the kinetic energy of the mass points [J]."""
    return float(0.5 * points(robot)[0] @ np.square(velocities(robot, pose, rate)).sum(axis=-1))


def points_mass_matrix(robot: Robot, pose: Any) -> Any:
    """Return M(q) with T = q_dot^T M q_dot / 2, from the kinetic energy's values alone."""
    unit = np.eye(3)

    def energy(rate: Floats) -> float:
        return points_energy(robot, pose, rate)

    return np.array([[energy(a + b) - energy(a) - energy(b) for b in unit] for a in unit])


def christoffel(mass_matrix: Callable[[Floats], Floats], pose: Floats) -> Floats:
    """Return the Christoffel symbols Gamma_ijk of the first kind (3, 3, 3) at a pose.

    ``Gamma_ijk = (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2``, by numerical differentiation.
    """
    change = np.stack([slope(lambda t, e=e: mass_matrix(pose + t * e)) for e in np.eye(3)], axis=-1)
    return np.asarray(0.5 * (change + change.transpose(0, 2, 1) - change.transpose(2, 0, 1)))


def resultant(robot: Robot, twist: Floats, acceleration: Floats) -> Floats:
    """Return (F_x, F_y, M_z about the origin) in the body frame that the mass points need.

    At rest in an inertial frame that coincides with the body's: velocity i r z of a point z
    relative to the origin, and its acceleration from differentiating the twist's vectors.
    """
    u, v, r = twist
    mass, place = points(robot)
    z = place @ (1, 1j)
    origin = complex(acceleration[0], acceleration[1]) + 1j * r * complex(u, v)
    force = mass * (origin + (1j * acceleration[2] - r * r) * z)
    return np.array([force.real.sum(), force.imag.sum(), (z.conjugate() * force).imag.sum()])


# ---- the robot taken apart -----------------------------------------------------------------


class Reaction(NamedTuple):
    """What follows from Newton's laws: accelerations, and the ground's forces on all wheels."""

    twist_acceleration: Floats  # (3,)
    wheel_acceleration: Floats  # (w,) of all rolling wheels
    along: Floats  # (k,)
    side: Floats  # (k,) least norm


def directions(robot: Robot, steering: Sequence[float] | Floats) -> dict[str, complex]:
    """Return each rolling wheel's drive direction in the body frame, as a unit vector."""
    angles = {wheel.name: angle for wheel, angle in zip(robot.steered, steering, strict=True)}
    return {
        wheel.name: complex(np.exp(1j * (wheel.heading + angles.get(wheel.name, 0.0))))
        for wheel in rolling_wheels(robot)
    }


def rolling_force(wheel: RollingWheel, ahead: complex) -> tuple[complex, complex]:
    """Return the direction and the point of the ground's force along a wheel.

    A Swedish wheel is pushed along the axis of its roller. A wheel that may skid acts where its
    track factor puts it.
    """
    roller = wheel.roller if isinstance(wheel, SwedishWheel) else 0.0
    point = widened(wheel) if isinstance(wheel, FixedWheel) else (wheel.x, wheel.y)
    return ahead * complex(np.exp(1j * roller)), complex(*point)


def holding_wheels(robot: Robot) -> tuple[list[int], list[int]]:
    """Return the places of the wheels that must not slip sideways, and of those that may skid."""
    standard = [i for i, w in enumerate(robot.wheels) if isinstance(w, FixedWheel | SteeredWheel)]
    skids = [i for i in standard if getattr(robot.wheels[i], "skid", False)]
    return [i for i in standard if i not in skids], skids


def cross(a: complex, b: complex) -> float:
    return (a.conjugate() * b).imag


def newton_euler(robot: Robot, motion: Motion, torques: Floats) -> Reaction:
    """Return accelerations and ground forces, with each part's motion and each force unknown.

    The unknowns are the accelerations (x, y, yaw) of the body and of each wheel, the spin of each
    rolling wheel, the forces and torques in the joints between body and wheels, and the ground's
    forces. The equations are Newton's and Euler's for each part, the joints', and the constraint
    rows differentiated along the motion. Inertial frame: the body's, at this instant.
    """
    assert robot.body is not None
    wheels, rolling = robot.wheels, rolling_wheels(robot)
    held, skids = holding_wheels(robot)
    u, v, r = motion.twist
    size = float(np.abs(motion.rate).max(initial=0.0))

    def rows(t: float) -> tuple[Floats, Floats]:
        angles = motion.steering + t * motion.rate
        return rolling_rows(robot, rolling, angles)[0], slip_rows(robot, angles)

    A, C = rows(0.0)
    A_dot, C_dot = slope(lambda t: rows(t)[0], size), slope(lambda t: rows(t)[1], size)
    gains = rolling_rows(robot, rolling, motion.steering)[1]
    ahead = directions(robot, motion.steering)
    com = complex(*robot.body.com)
    k, w, m = len(wheels), len(rolling), len(C)
    spin0 = 3 * (k + 1)
    joint0 = spin0 + w
    push0 = joint0 + 3 * k
    hold0 = push0 + w
    L, b = np.zeros((hold0 + m, hold0 + m)), np.zeros(hold0 + m)

    def load(part: int, column: int, force: complex, moment: float) -> None:
        """Add a force and a moment about the part's centre to its equations of motion."""
        L[3 * part : 3 * part + 3, column] -= (force.real, force.imag, moment)

    # Newton and Euler for the body and the wheels, and the joints between them.
    parts = [(robot.body.mass, robot.body.inertia)] + [(x.mass, x.yaw_inertia) for x in wheels]
    for part, (mass, inertia) in enumerate(parts):
        L[range(3 * part, 3 * part + 3), range(3 * part, 3 * part + 3)] = mass, mass, inertia
    for i, wheel in enumerate(wheels):
        arm = complex(wheel.x, wheel.y) - com
        for j, (force, moment) in enumerate([(1 + 0j, 0.0), (1j, 0.0), (0j, 1.0)]):
            load(i + 1, joint0 + 3 * i + j, force, moment)
            load(0, joint0 + 3 * i + j, -force, -moment - cross(arm, force))
        # The joint: acceleration of a point of the body, and the same yaw.
        at = joint0 + 3 * i
        L[range(at, at + 3), range(3 * i + 3, 3 * i + 6)] = 1.0
        L[range(at, at + 3), range(3)] = -1.0
        L[at, 2], L[at + 1, 2] = arm.imag, -arm.real
        b[at], b[at + 1] = -r * r * arm.real, -r * r * arm.imag
    # The ground's forces on the wheels, and the spin about the axles.
    speeds = turning(robot, rolling, motion.twist, motion.steering)
    motor = iter(torques)
    given = np.array([next(motor) if wheel.driven else 0.0 for wheel in rolling])
    for j, wheel in enumerate(rolling):
        direction, point = rolling_force(wheel, ahead[wheel.name])
        arm = point - complex(wheel.x, wheel.y)
        load(wheels.index(wheel) + 1, push0 + j, direction, cross(arm, direction))
        L[spin0 + j, spin0 + j], L[spin0 + j, push0 + j] = wheel.spin_inertia, gains[j]
    b[spin0:joint0] = given - friction(rolling, speeds)
    for j, group in enumerate([[i] for i in held] + ([skids] if skids else [])):
        for i in group:
            load(i + 1, hold0 + j, 1j * ahead[wheels[i].name] / len(group), 0.0)
    # The rows, with the twist's rate of change from the acceleration of the body's centre of mass.
    to_rate = np.array([[1.0, 0.0, com.imag], [0.0, 1.0, -com.real], [0.0, 0.0, 1.0]])
    own = np.array([r * r * com.real + r * v, r * r * com.imag - r * u, 0.0])
    for at, row, row_dot in ((push0, A, A_dot), (hold0, C, C_dot)):
        L[at : at + len(row), :3] = row @ to_rate
        b[at : at + len(row)] = -row_dot @ motion.twist - row @ own
    L[range(push0, hold0), range(spin0, joint0)] = -gains

    found, *_ = linalg.lstsq(L, b, cond=_RANK)
    np.testing.assert_allclose(L @ found, b, atol=1e-8 * (1 + np.abs(b).max()))
    acceleration = to_rate @ found[:3] + own
    along = np.zeros(k)
    along[[wheels.index(wheel) for wheel in rolling]] = found[push0:hold0]
    side = least_side(robot, motion, acceleration, along)
    return Reaction(acceleration, found[spin0:joint0], along, side)


def least_side(robot: Robot, motion: Motion, acceleration: Floats, along: Floats) -> Floats:
    """Return the side forces (k,) of least norm that, with those along, accelerate the masses."""
    ahead, wheels = directions(robot, motion.steering), robot.wheels
    needed = resultant(robot, motion.twist, acceleration)
    for wheel, force in zip(wheels, along, strict=True):
        if isinstance(wheel, RollingWheel):
            direction, point = rolling_force(wheel, ahead[wheel.name])
            needed -= force * np.array([direction.real, direction.imag, cross(point, direction)])
    held, skids = holding_wheels(robot)
    holding, side = held + skids, np.zeros(len(wheels))
    if holding:
        ways = [1j * ahead[wheels[i].name] for i in holding]
        arms = [complex(wheels[i].x, wheels[i].y) for i in holding]
        S = [[n.real, n.imag, cross(p, n)] for n, p in zip(ways, arms, strict=True)]
        side[holding] = linalg.lstsq(np.array(S).T, needed, cond=_RANK)[0]
    return side
