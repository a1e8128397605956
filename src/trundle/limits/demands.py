"""What a trajectory demands of a robot, over time and at another pace."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from trundle.dynamics import Dynamics, friction_torque, to_body, wheel_loads
from trundle.kinematics import Kinematics
from trundle.motion import Course
from trundle.robot import Robot, RollingWheel, missing_masses
from trundle.se2 import Array, Mask

# The values (T, k) of a quantity at a stretch, and their shares of the limit.
Use = Callable[[float], tuple[Array, Array]]

# A robot stands below this speed [m/s, rad/s]: there a wheel's direction is rounding.
_STANDS = 1e-9
# A larger change of angle from one time to the next is a turn at standstill [rad].
_JUMP = 0.02


class Motion(NamedTuple):
    """A robot's motion along a trajectory at T times, as its wheels allow it."""

    t: Array  # (T,)
    twist: Array  # (T, 3) that the wheels can give
    acceleration: Array  # (T, 3) u_dot, v_dot, r_dot
    miss: Array  # (T, 3) twist of the trajectory minus the one that the wheels can give
    steering: Array  # (T, s)
    steering_rate: Array  # (T, s)
    swings: Array  # (k, 2) times and angles of turns that wheels make at standstill

    def at_pace(self, stretch: float) -> Motion:
        """Return the same path when it is run through in ``stretch`` times the time."""
        return self._replace(
            t=self.t * stretch,
            twist=self.twist / stretch,
            acceleration=self.acceleration / stretch**2,
            steering_rate=self.steering_rate / stretch,
        )


class Demand(NamedTuple):
    """One quantity of some wheels along a trajectory, and its limits.

    Attributes:
        name: what it is.
        unit: its unit.
        wheels: names of the k wheels that have a limit.
        values: (T, k).
        limits: (k,) largest magnitude.
        share: (T, k) of the limit that is used; above 1 the limit is exceeded.
        stretch: factor by which time must be stretched to keep the limit: below 1 there is time
            to spare, inf where no pace will do.
    """

    name: str
    unit: str
    wheels: tuple[str, ...]
    values: Array
    limits: Array
    share: Array
    stretch: float


def motion_of(robot: Robot, course: Course, t: Array) -> Motion:
    """Return the motion of a robot along a course at times (T,), whatever its limits."""
    if robot.steered:
        robot = robot.with_wheels(steering_min=None, steering_max=None)
    kinematics = Kinematics(robot)
    asked, rising = body_twists(course)
    found = kinematics.inverse(asked, limit=False)
    if not robot.steered:
        rising = rising - kinematics.inverse(rising, limit=False).residual
        none = np.zeros((len(t), 0))
        return Motion(t, found.twist, rising, found.residual, none, none, np.zeros((0, 2)))
    rising = rising - _rate(found.residual, t)
    moving = np.abs(found.twist).max(axis=1) > _STANDS
    steering = kinematics.steady_steering(found.twist)
    # Before it first moves, a robot steers to where it goes.
    steering[: int(moving.argmax())] = steering[int(moving.argmax())]
    rate, swings = _steering_rates(steering, moving, t)
    return Motion(t, found.twist, rising, found.residual, steering, rate, swings)


def _steering_rates(steering: Array, moving: Mask, t: Array) -> tuple[Array, Array]:
    """Return steering rates (T, s), and the turns (k, 2) that wheels make at standstill.

    A wheel holds its angle where the robot stands; where it goes on in another direction, the
    angle jumps, at a rate that only tells how closely one looks.
    """
    change = np.diff(steering, axis=0)
    jumps = ~moving[:-1, None] & (np.abs(change) > _JUMP)
    at = np.flatnonzero(jumps.any(axis=1))
    swings = np.stack([t[at], np.abs(change[at]).max(axis=1, initial=0.0)], axis=-1)
    change[jumps] = 0.0
    smooth = np.vstack([np.zeros(steering.shape[1]), np.cumsum(change, axis=0)])
    return _rate(smooth, t), swings


def body_twists(course: Course) -> tuple[Array, Array]:
    """Return the twists (T, 3) along a course and their rates (T, 3), in the body frame."""
    psi = course.position[:, 2]
    c, s, r = np.cos(psi), np.sin(psi), course.velocity[:, 2]
    (x, y), (x_dot, y_dot) = course.velocity[:, :2].T, course.acceleration[:, :2].T
    (u, v), (a_u, a_v) = to_body(c, s, x, y), to_body(c, s, x_dot, y_dot)
    rate = a_u + r * v, a_v - r * u, course.acceleration[:, 2]  # the body frame turns
    return np.stack([u, v, r], axis=-1), np.stack(rate, axis=-1)


def _rate(values: Array, t: Array) -> Array:
    """Return the time derivative (T, k) of sampled values (T, k)."""
    if values.size == 0 or len(t) < 2:
        return np.zeros_like(values)
    return np.asarray(np.gradient(values, t, axis=0))


def demands(robot: Robot, motion: Motion) -> list[Demand]:
    """Return every quantity of the motion for which the robot has a limit."""
    found = [
        _wheel_speed(robot, motion),
        _wheel_acceleration(robot, motion),
        _steering_angle(robot, motion),
        _steering_rate(robot, motion),
    ]
    if not missing_masses(robot):
        dynamics = Dynamics(robot)
        found += [made(robot, dynamics, motion) for made in (_torque, _voltage, _friction)]
    return [each for each in found if each is not None]


def _speeds(robot: Robot, motion: Motion) -> Array:
    steering = motion.steering if robot.steered else None
    return Kinematics(robot).rolling_speeds(motion.twist, steering)


def _wheel_speed(robot: Robot, motion: Motion) -> Demand | None:
    limits = [wheel.max_speed for wheel in robot.driven]
    values, names = _speeds(robot, motion), [wheel.name for wheel in robot.driven]
    return _plain("wheel speed", "rad/s", names, values, limits, power=1)


def _wheel_acceleration(robot: Robot, motion: Motion) -> Demand | None:
    limits = [wheel.max_acceleration for wheel in robot.driven]
    if robot.steered:
        values = _rate(_speeds(robot, motion), motion.t)
    else:
        values = Kinematics(robot).rolling_speeds(motion.acceleration)
    names = [wheel.name for wheel in robot.driven]
    return _plain("wheel acceleration", "rad/s^2", names, values, limits, power=2)


def _steering_rate(robot: Robot, motion: Motion) -> Demand | None:
    limits = [wheel.steering_rate for wheel in robot.steered]
    names = [wheel.name for wheel in robot.steered]
    return _plain("steering rate", "rad/s", names, motion.steering_rate, limits, power=1)


def _steering_angle(robot: Robot, motion: Motion) -> Demand | None:
    # Angles between a least and a largest one: counted from the middle of the range.
    ranges = [wheel.steering_range for wheel in robot.steered]
    known = [high - low < np.inf for low, high in ranges]
    limits = [(high - low) / 2 if k else None for (low, high), k in zip(ranges, known, strict=True)]
    middle = [(high + low) / 2 if k else 0.0 for (low, high), k in zip(ranges, known, strict=True)]
    names = [wheel.name for wheel in robot.steered]
    return _plain("steering angle", "rad", names, motion.steering - middle, limits, power=0)


_LOCKED = 1e-9  # angle by which a locked wheel may differ [rad]


def _plain(
    name: str, unit: str, names: list[str], values: Array, limits: list[float | None], power: int
) -> Demand | None:
    """Return a demand that falls with a power of the stretch, or None without limits."""
    kept = [i for i, limit in enumerate(limits) if limit is not None]
    if not kept:
        return None
    bounds = np.array([limits[i] for i in kept], dtype=np.float64)
    used = np.abs(values[:, kept])
    # A wheel that is locked (a range of one angle) has a limit of zero.
    share = np.where(bounds > 0, used / np.where(bounds > 0, bounds, 1.0), used / _LOCKED)
    most = float(share.max(initial=0.0))
    stretch = (np.inf if most > 1 else 0.0) if power == 0 else most ** (1 / power)
    wheels = tuple(names[i] for i in kept)
    return Demand(name, unit, wheels, values[:, kept], bounds, share, float(stretch))


def _torque(robot: Robot, dynamics: Dynamics, motion: Motion) -> Demand | None:
    """The torque that the gears and the current bear."""
    largest = dynamics.torque_limits.largest
    kept = np.isfinite(largest)

    def use(stretch: float) -> tuple[Array, Array]:
        values = _felt_torques(robot, dynamics, motion.at_pace(stretch))[:, kept]
        return values, np.abs(values) / largest[kept]

    return _searched("torque", "N m", robot, kept, largest, use)


def _voltage(robot: Robot, dynamics: Dynamics, motion: Motion) -> Demand | None:
    """The voltage that speed and torque need together."""
    supply = np.array([w.motor.max_voltage or np.inf if w.motor else np.inf for w in robot.driven])
    kept = np.isfinite(supply)
    _, stall, slope = dynamics.torque_limits

    def use(stretch: float) -> tuple[Array, Array]:
        at = motion.at_pace(stretch)
        needed = _felt_torques(robot, dynamics, at) + slope * _speeds(robot, at)
        share = needed[:, kept] / stall[kept]
        return share * supply[kept], np.abs(share)

    return _searched("voltage", "V", robot, kept, supply, use)


def _searched(
    name: str, unit: str, robot: Robot, kept: Mask, limits: Array, use: Use
) -> Demand | None:
    """Return a demand of some driven wheels whose stretch is searched, or None for none."""
    if not kept.any():
        return None
    values, share = use(1.0)
    names = tuple(w.name for w, k in zip(robot.driven, kept, strict=True) if k)
    return Demand(name, unit, names, values, limits[kept], share, _stretch(use))


def _felt_torques(robot: Robot, dynamics: Dynamics, motion: Motion) -> Array:
    """Return the motors' torques (T, n); slow wheels feel the whole of Coulomb friction.

    The dynamics smooth it.
    """
    rolling = [wheel for wheel in robot.wheels if isinstance(wheel, RollingWheel)]
    coulomb = dynamics.friction_coefficients[1][[wheel.driven for wheel in rolling]]
    speeds = _speeds(robot, motion)
    missing = coulomb * np.sign(speeds) - friction_torque(0.0, coulomb, speeds, np.sqrt)
    return np.asarray(_torques(robot, dynamics, motion) + missing)


def _torques(robot: Robot, dynamics: Dynamics, motion: Motion) -> Array:
    if robot.steered:
        return dynamics.torques(
            motion.twist, motion.acceleration, motion.steering, motion.steering_rate
        )
    return dynamics.torques(motion.twist, motion.acceleration)


def _friction(robot: Robot, dynamics: Dynamics, motion: Motion) -> Demand | None:
    """The coefficient of friction that the wheels need, for what pushes and what holds them."""
    limits = [getattr(wheel, "friction", None) for wheel in robot.wheels]
    kept = [i for i, limit in enumerate(limits) if limit is not None]
    if not kept or np.isnan(wheel_loads(robot)).any():
        return None
    bounds = np.array([limits[i] for i in kept], dtype=np.float64)

    def use(stretch: float) -> tuple[Array, Array]:
        at = motion.at_pace(stretch)
        torques = _torques(robot, dynamics, at)
        steered = (at.steering, at.steering_rate) if robot.steered else ()
        needed = dynamics.ground_forces(at.twist, torques, *steered).friction[:, kept]
        return needed, needed / bounds

    values, share = use(1.0)
    names = tuple(robot.wheels[i].name for i in kept)
    # What carries nothing cannot push, however slowly.
    stretch = _stretch(use) if np.isfinite(share).all() else np.inf
    return Demand("friction with the ground", "", names, values, bounds, share, stretch)


# Stretches between which the one that just keeps a limit is looked for, and how closely.
_FASTEST, _SLOWEST, _CLOSE = 1e-3, 1e4, 1e-9


def _stretch(use: Use) -> float:
    """Return the least stretch at which no limit is exceeded."""
    from scipy.optimize import brentq

    def over(log: float) -> float:
        # The logarithm of what grows like a power is nearly straight.
        return float(np.log(max(use(float(np.exp(log)))[1].max(), 1e-300)))

    low, high = float(np.log(_FASTEST)), float(np.log(_SLOWEST))
    if over(high) > 0:
        return np.inf
    if over(low) <= 0:
        return 0.0
    return float(np.exp(brentq(over, low, high, xtol=_CLOSE)))
