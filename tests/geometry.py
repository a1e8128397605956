"""Rolling wheels, straight from geometry and apart from trundle's constraint rows.

Planar vectors are complex numbers x + iy. A body with twist (u, v, r) carries its point p with the
velocity u + iv + r ip; a wheel's rim hands the contact point the velocity a omega along its drive
direction.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, optimize

from trundle.robot import FixedWheel, Robot, SteeredWheel, SwedishWheel
from trundle.robot.wheels import RollingWheel

Floats = NDArray[np.float64]


def velocity(twist: Sequence[float], x: float, y: float) -> complex:
    """Return the velocity of the body point (x, y)."""
    u, v, r = twist
    return complex(u, v) + r * complex(-y, x)


def along(vector: complex, angle: float) -> float:
    """Return a vector's component along a direction."""
    return (vector * complex(math.cos(angle), -math.sin(angle))).real


def rim_speed(wheel: RollingWheel, wheel_speed: float) -> float:
    """Return how fast the contact goes along the drive direction where the wheel does not slip."""
    return (-1.0 if wheel.reversed else 1.0) * wheel.radius * wheel_speed


def widened(wheel: FixedWheel) -> tuple[float, float]:
    """Return the contact point, moved across the drive direction by the wheel's track factor."""
    across = complex(-math.sin(wheel.heading), math.cos(wheel.heading))
    offset = (complex(wheel.x, wheel.y) * across.conjugate()).real
    point = complex(wheel.x, wheel.y) + (wheel.track_factor - 1.0) * offset * across
    return point.real, point.imag


def misfits(
    robot: Robot,
    twist: Sequence[float],
    wheel_speeds: Sequence[float],
    steering: Sequence[float] = (),
) -> dict[str, float]:
    """Return by how much [m/s] each wheel's contact moves otherwise than the wheel says."""
    speeds = {
        wheel.name: float(speed) for wheel, speed in zip(robot.driven, wheel_speeds, strict=True)
    }
    angles = {
        wheel.name: float(angle) for wheel, angle in zip(robot.steered, steering, strict=True)
    }
    found = {}
    for wheel in robot.wheels:
        if not isinstance(wheel, RollingWheel):
            continue
        contact = velocity(twist, wheel.x, wheel.y)
        speed = speeds.get(wheel.name)
        rim = None if speed is None else rim_speed(wheel, speed)
        if isinstance(wheel, SwedishWheel):
            axis = wheel.heading + wheel.roller
            held = 0.0 if rim is None else along(contact, axis) - rim * math.cos(wheel.roller)
            found[wheel.name] = abs(held)
            continue
        heading = wheel.heading + angles.get(wheel.name, 0.0)
        if isinstance(wheel, FixedWheel) and wheel.skid:
            contact = velocity(twist, *widened(wheel))
            slip = 0.0
        else:
            slip = along(contact, heading + math.pi / 2)
        rolled = 0.0 if rim is None else along(contact, heading) - rim
        found[wheel.name] = math.hypot(rolled, slip)
    return found


def rolling_rows(
    robot: Robot, wheels: Sequence[RollingWheel], steering: Sequence[float]
) -> tuple[Floats, Floats]:
    """Return A and the diagonal of R for the wheels: contact velocities of the unit twists."""
    angles = {wheel.name: angle for wheel, angle in zip(robot.steered, steering, strict=True)}
    rows, gains = [], []
    for wheel in wheels:
        heading = wheel.heading + angles.get(wheel.name, 0.0)
        roller = wheel.roller if isinstance(wheel, SwedishWheel) else 0.0
        point = widened(wheel) if isinstance(wheel, FixedWheel) else (wheel.x, wheel.y)
        rows.append([along(velocity(unit, *point), heading + roller) for unit in np.eye(3)])
        gains.append(rim_speed(wheel, 1.0) * math.cos(roller))
    return np.array(rows).reshape(-1, 3), np.array(gains)


def turning(
    robot: Robot,
    wheels: Sequence[RollingWheel],
    twist: Sequence[float],
    steering: Sequence[float] = (),
) -> Floats:
    """Return how fast [rad/s] the wheels turn at a twist that they can all roll along with."""
    rows, gains = rolling_rows(robot, wheels, steering)
    return np.asarray(rows @ np.asarray(twist) / gains)


def slip_rows(robot: Robot, steering: Sequence[float]) -> Floats:
    """Return C: the sideways contact velocities of the unit twists, for wheels that must not slip.

    Wheels that may skid keep only the mean sideways velocity of their contacts at zero.
    """
    angles = {wheel.name: angle for wheel, angle in zip(robot.steered, steering, strict=True)}
    rows, skids = [], []
    for wheel in robot.wheels:
        if not isinstance(wheel, FixedWheel | SteeredWheel):
            continue
        across = wheel.heading + angles.get(wheel.name, 0.0) + math.pi / 2
        row = [along(velocity(unit, wheel.x, wheel.y), across) for unit in np.eye(3)]
        (skids if isinstance(wheel, FixedWheel) and wheel.skid else rows).append(row)
    if skids:
        rows.append(list(np.mean(skids, axis=0)))
    return np.array(rows).reshape(-1, 3)


def allowed_twists(robot: Robot, steering: Sequence[float]) -> Floats:
    """Return an orthonormal basis (3, k) of the twists without side slip."""
    rows = slip_rows(robot, steering)
    if len(rows) == 0:
        return np.eye(3)
    return np.asarray(linalg.null_space(rows, rcond=1e-9))


def wheel_matrix(robot: Robot, steering: Sequence[float]) -> Floats:
    """Return W column by column: the twist without side slip that fits one turning wheel best."""
    A, gains = rolling_rows(robot, robot.driven, steering)
    N = allowed_twists(robot, steering)
    columns = []
    for unit in np.eye(len(gains)):
        weights, *_ = linalg.lstsq(A @ N, gains * unit, cond=1e-9)
        columns.append(N @ weights)
    return np.array(columns).reshape(-1, 3).T


def consistent_steering(robot: Robot, twist: Sequence[float]) -> Floats:
    """Return each steered wheel's angle along its contact velocity."""
    angles = []
    for wheel in robot.steered:
        contact = velocity(twist, wheel.x, wheel.y)
        angles.append(math.atan2(contact.imag, contact.real) - wheel.heading)
    return np.array(angles)


def turned(difference: ArrayLike) -> Floats:
    """Return angle differences modulo half a turn, in [-pi/2, pi/2]."""
    difference = np.asarray(difference, dtype=np.float64)
    return np.asarray(difference - np.pi * np.round(difference / np.pi))


def nearest_linked(
    robot: Robot, asked: Sequence[float], ratios: Sequence[float], low: float, high: float
) -> float:
    """Return the least distance to a twist that wheels on one input can have, by brute force.

    All angles of a fine grid are tried, then the best is refined.
    """
    target = np.asarray(asked, dtype=np.float64)

    def miss(angle: float) -> float:
        N = allowed_twists(robot, [ratio * angle for ratio in ratios])
        return float(np.linalg.norm(target - N @ (N.T @ target)))

    grid = np.linspace(low, high, 721)
    step = grid[1] - grid[0]
    best = min(grid, key=miss)
    found = optimize.minimize_scalar(
        miss,
        bounds=(max(low, best - step), min(high, best + step)),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return float(min(found.fun, miss(best)))
