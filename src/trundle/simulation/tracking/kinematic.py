"""Controllers that command twists: the wheels turn as told, and each step is an exact arc."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from trundle import se2
from trundle.dynamics import Dynamics, to_body
from trundle.kinematics import Inverse, Kinematics
from trundle.motion import Course
from trundle.robot import Robot, missing_masses
from trundle.se2 import Array
from trundle.simulation.run import Run
from trundle.simulation.tracking.recorded import sums
from trundle.simulation.tracking.sampled import as_command
from trundle.simulation.tracking.signals import Controller, Measurement, reference

# Wheel speeds scaled down by less than rounding are not scaled down.
_ROUNDING = 1e-9


def track_twist(
    robot: Robot, controller: Controller, course: Course, t: Array, plain: bool, start: Array
) -> Run:
    """Return the run under a controller of twists; torques and energy where masses are known.

    Args:
        robot: the robot.
        controller: commands twists.
        course: what is desired at T + 1 times.
        t: (T + 1,) times [s].
        plain: whether heading errors are the plain difference.
        start: (6,) pose and rate in the inertial frame.
    """
    kinematics = Kinematics(robot)
    T, n, s = len(t) - 1, len(robot.driven), len(robot.steered)
    pose, error = np.empty((T + 1, 3)), np.empty((T + 1, 3))
    twist, limited = np.empty((T, 3)), np.zeros(T, dtype=bool)
    speeds, angles = np.empty((T, n)), np.empty((T, s))
    pose[0], rate, memory = start[:3], start[3:], None
    steering = _first_steering(kinematics, start)
    for k in range(T):
        wanted = reference(course, k, plain)
        error[k] = wanted.error(pose[k])
        measurement = Measurement(float(t[k]), pose[k].copy(), rate)
        command, memory = controller.step(memory, measurement, wanted)
        asked = as_command(command, 3, "twist")
        found = kinematics.inverse(asked, steering=steering if s else None)
        twist[k], speeds[k], angles[k] = found.twist, found.wheel_speeds, found.steering
        steering, limited[k] = found.steering, _was_limited(found, asked)
        u, v, r = found.twist
        pose[k + 1] = se2.step(*pose[k], *((t[k + 1] - t[k]) * found.twist))
        c, sine = math.cos(pose[k + 1, 2]), math.sin(pose[k + 1, 2])
        rate = np.array([c * u - sine * v, sine * u + c * v, r])
    error[T] = reference(course, T, plain).error(pose[T])
    turns = sums((speeds * np.diff(t)[:, None]).T)
    return Run(
        t=t,
        pose=pose,
        twist=twist,
        wheel_speeds=speeds,
        steering=angles,
        wheel_angles=turns.T,
        driven=tuple(wheel.name for wheel in robot.driven),
        steered=tuple(wheel.name for wheel in robot.steered),
        desired=course.position,
        error=error,
        saturated=np.repeat(limited[:, None], n, axis=1),
        reports=tuple(_reports(limited, error)),
        **_forces(robot, twist, angles, t, start, turns),
    )


def _first_steering(kinematics: Kinematics, start: Array) -> Array:
    """Return the steering angles that go with the motion at the start."""
    u, v = to_body(math.cos(start[2]), math.sin(start[2]), start[3], start[4])
    return kinematics.inverse([u, v, start[5]]).steering


def _was_limited(found: Inverse, asked: Array) -> bool:
    return bool(np.abs(found.twist - asked).max() > _ROUNDING * max(np.abs(asked).max(), 1.0))


def _reports(limited: Array, error: Array) -> list[str]:
    if not limited.any():
        return []
    return [
        f"The robot could not have the twist that was asked for in {100 * limited.mean():.3g} % of "
        "the steps, for its wheels, their speed or their steering limits; it was up to "
        f"{np.hypot(error[:, 0], error[:, 1]).max():.3g} m from the trajectory."
    ]


def _forces(
    robot: Robot, twist: Array, angles: Array, t: Array, start: Array, turns: Array
) -> dict[str, Any]:
    """Return the torques that the motion takes, the work that they do, and the kinetic energy."""
    if missing_masses(robot):
        return {}
    dynamics = Dynamics(robot)
    dt = np.diff(t)[:, None]
    u, v = to_body(math.cos(start[2]), math.sin(start[2]), start[3], start[4])
    before = np.vstack([[u, v, start[5]], twist[:-1]])
    held = angles if robot.steered else None
    steering_rate = np.diff(angles, axis=0, prepend=angles[:1]) / dt if robot.steered else None
    torques = dynamics.torques(twist, (twist - before) / dt, held, steering_rate)
    last = None if held is None else np.vstack([angles, angles[-1:]])
    return {
        "torques": torques,
        "work": sums((torques * np.diff(turns.T, axis=0)).sum(axis=1)),
        "energy": dynamics.kinetic_energy(np.vstack([twist, twist[-1:]]), last),
    }
