"""Whether a robot can follow a trajectory, and by how much time must be stretched."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import final

import numpy as np

from trundle.dynamics import wheel_loads
from trundle.errors import TrundleError
from trundle.kinematics import robot_of
from trundle.limits.demands import Demand, demands, motion_of
from trundle.motion import AnyTrajectory, length, sample
from trundle.robot import Robot, missing_masses
from trundle.se2 import Array

# A twist missed by less [m/s, rad/s] is rounding, or the step between two times.
_MISSED = 1e-6
# The largest of samples is a little less than the largest of all: this much over a limit is kept.
KEPT = 1 + 1e-3
_MOST_TIMES = 2_000_000


@final
@dataclass(frozen=True, eq=False)
class Feasibility:
    """What a trajectory demands of a robot.

    Attributes:
        t: (T,) times [s].
        demands: each quantity for which the robot has a limit, with its own stretch.
        miss: (T, 3) how the trajectory moves in the body frame and the wheels cannot:
            (u, v, r) [m/s, m/s, rad/s].
        swings: (k, 2) times [s] at which the robot stands and its wheels would have to turn at
            once, and by how much [rad].
        tips: whether the body would tip over, so that friction cannot be told.
        stretch: factor by which time must be stretched so that every limit is kept; below 1
            there is time to spare, 0 without limits, inf where no pace will do.

    >>> import trundle
    >>> slow = trundle.load("omni3").with_wheels(max_speed=1.0)
    >>> found = feasibility(slow, trundle.motion.circle(radius=1.0, rate=0.4, heading=0.0))
    >>> round(found.stretch, 6)  # 0.4 m/s on wheels of 0.2 m that give 0.2 m/s
    2.0
    """

    t: Array
    demands: tuple[Demand, ...]
    miss: Array
    swings: Array
    tips: bool
    stretch: float

    @property
    def follows(self) -> bool:
        """Whether the wheels can move as the trajectory does, however slowly."""
        return bool(np.abs(self.miss).max(initial=0.0) < _MISSED)

    @property
    def feasible(self) -> bool:
        """Whether the robot can follow the trajectory as it is."""
        return self.follows and self.stretch <= KEPT and not self.tips and len(self.swings) == 0

    @property
    def reports(self) -> tuple[str, ...]:
        """What stands in the way, a sentence each, and what would do."""
        told = []
        if not self.follows:
            told.append(_missed(self.t, self.miss))
        if len(self.swings):
            time, angle = self.swings[int(self.swings[:, 1].argmax())]
            told.append(
                f"At t = {time:.4g} s the robot stands, and a steered wheel must turn by "
                f"{angle:.3g} rad before it goes on: the trajectory leaves no time for it."
            )
        if self.tips:
            told.append("The body tips over: its centre of mass is not above its wheels.")
        told += [_exceeded(self.t, each) for each in self.demands if each.stretch > KEPT]
        if KEPT < self.stretch < np.inf:
            told.append(f"Stretch time by {self.stretch:.4g} to keep all limits.")
        return tuple(told)


def feasibility(
    robot: Robot, trajectory: AnyTrajectory, *, duration: float | None = None, dt: float = 0.01
) -> Feasibility:
    """Return what a trajectory demands of a robot, against the limits in its description.

    Wheel speed, wheel acceleration, steering angle and steering rate; where the masses are known
    also the motors' torque (their voltage and current too), and the friction with the ground that
    pushing and side forces need.

    Args:
        robot: the robot.
        trajectory: any value with position(t), velocity(t) and acceleration(t).
        duration: how much of it [s]; its own ``duration`` when left out.
        dt: time between two looks [s].

    Raises:
        TrundleError: duration or dt is not usable, or this is no trajectory.
    """
    robot_of(robot)
    seconds = length(trajectory, duration)
    if isinstance(dt, bool) or not isinstance(dt, Real) or not 0 < float(dt) < np.inf:
        raise TrundleError(f"dt must be a positive number of seconds, got {dt!r}")
    if seconds / dt > _MOST_TIMES:
        raise TrundleError(f"{seconds:g} s every {dt:g} s are too many times: take a longer dt")
    t = np.linspace(0.0, seconds, max(round(seconds / dt), 2) + 1)
    motion = motion_of(robot, sample(trajectory, t), t)
    found = tuple(demands(robot, motion))
    stretch = max((each.stretch for each in found), default=0.0)
    tips = not missing_masses(robot) and bool(np.isnan(wheel_loads(robot)).any())
    swings = motion.swings if any(w.steering_rate for w in robot.steered) else np.zeros((0, 2))
    return Feasibility(t, found, motion.miss, swings, tips, stretch)


def _missed(t: Array, miss: Array) -> str:
    units = ("m/s forward", "m/s sideways", "rad/s of turning")
    worst = int(np.abs(miss).max(axis=0).argmax())
    when = int(np.abs(miss[:, worst]).argmax())
    return (
        f"The wheels cannot move as the trajectory does: {abs(miss[when, worst]):.3g} "
        f"{units[worst]} are missing at t = {t[when]:.4g} s, at any pace. A heading along the path "
        "suits robots that cannot move sideways."
    )


def _exceeded(t: Array, demand: Demand) -> str:
    when, wheel = np.unravel_index(int(demand.share.argmax()), demand.share.shape)
    value, share = abs(demand.values[when, wheel]), demand.share[when, wheel]
    name = demand.wheels[wheel]
    if not np.isfinite(value):
        return f"{name} carries no weight, so it cannot push: look at com, or leave out friction."
    unit = f" {demand.unit}" if demand.unit else ""
    remedy = f"stretch time by {demand.stretch:.4g}" if demand.stretch < np.inf else "at any pace"
    return (
        f"{demand.name} of {name}: {value:.4g} of at most {demand.limits[wheel]:.4g}{unit} at "
        f"t = {t[when]:.4g} s, {share:.3g} times the limit: {remedy}."
    )
