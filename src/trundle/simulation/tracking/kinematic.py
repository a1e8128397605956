"""Controllers that command twists: the wheels turn as told, and each step is an exact arc."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from trundle import se2
from trundle.dynamics import Dynamics, to_body, to_inertial
from trundle.kinematics import Inverse, Kinematics
from trundle.motion import Course
from trundle.robot import Robot, missing_masses
from trundle.se2 import Array
from trundle.simulation.run import Run
from trundle.simulation.tracking.loops import ENDLESS
from trundle.simulation.tracking.recorded import ended_early, heading_jumps, sums
from trundle.simulation.tracking.sampled import as_command, call
from trundle.simulation.tracking.signals import Controller, Measurement, reference

# Wheel speeds scaled down by less than rounding are not scaled down.
_ROUNDING = 1e-9
# A trajectory along its heading moves sideways by rounding only [m/s].
_SIDEWAYS = 1e-6


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
    first = kinematics.inverse(_start_twist(start))
    steering, steps = first.steering, T
    for k in range(T):
        wanted = reference(course, k, plain)
        error[k] = wanted.error(pose[k])
        measurement = Measurement(float(t[k]), pose[k].copy(), rate)
        command, memory = call(controller, memory, measurement, wanted)
        asked = as_command(command, 3, "twist")
        if not np.abs(asked).max() < ENDLESS:
            steps = k
            break
        found = kinematics.inverse(asked, steering=steering if s else None)
        twist[k], speeds[k], angles[k] = found.twist, found.wheel_speeds, found.steering
        steering, limited[k] = found.steering, _was_limited(found, asked)
        u, v, r = found.twist
        pose[k + 1] = se2.step(*pose[k], *((t[k + 1] - t[k]) * found.twist))
        c, sine = math.cos(pose[k + 1, 2]), math.sin(pose[k + 1, 2])
        rate = np.array([*to_inertial(c, sine, u, v), r])
    else:
        error[T] = reference(course, T, plain).error(pose[T])
    done, twist, speeds, angles = t[: steps + 1], twist[:steps], speeds[:steps], angles[:steps]
    error = error[: steps + 1]
    return Run(
        t=done,
        pose=pose[: steps + 1],
        twist=twist,
        wheel_speeds=speeds,
        steering=angles,
        wheel_angles=sums((speeds * np.diff(done)[:, None]).T).T,
        driven=tuple(wheel.name for wheel in robot.driven),
        steered=tuple(wheel.name for wheel in robot.steered),
        desired=course.position[: steps + 1],
        error=error,
        saturated=np.repeat(limited[:steps, None], n, axis=1),
        reports=(
            *ended_early(t, steps),
            *_reports(limited[:steps], error),
            *_sideways(twist, course, steps),
            *heading_jumps(done, course.position[: steps + 1], error[:, 2]),
        ),
        **_forces(robot, first, twist, speeds, angles, done),
    )


def _start_twist(start: Array) -> Array:
    """Return the twist (3,) in the body frame at the start."""
    u, v = to_body(math.cos(start[2]), math.sin(start[2]), start[3], start[4])
    return np.array([u, v, start[5]])


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


def _sideways(twist: Array, course: Course, steps: int) -> list[str]:
    """Return what to say where a trajectory moves sideways and the robot was never told to."""
    psi = course.position[: steps + 1, 2]
    x_dot, y_dot, _ = course.velocity[: steps + 1].T
    _, across = to_body(np.cos(psi), np.sin(psi), x_dot, y_dot)
    most = float(np.abs(across).max())
    if most < _SIDEWAYS or np.abs(twist[:, 1]).max(initial=0.0) > _ROUNDING:
        return []
    return [
        f"The trajectory moves at up to {most:.3g} m/s across its heading, and the robot was never "
        "told to move sideways: give the trajectory heading='path', or take a controller for "
        "robots that can, such as trundle.control.ResolvedRate."
    ]


def _forces(
    robot: Robot, first: Inverse, twist: Array, speeds: Array, angles: Array, t: Array
) -> dict[str, Any]:
    """Return the torques that the motion takes, the work that they do, and the kinetic energy.

    Over each step the speeds go evenly from those before it to its own; energy at a time is that
    before the step that begins there.
    """
    if missing_masses(robot):
        return {}
    dynamics, dt = Dynamics(robot), np.diff(t)[:, None]
    through = np.vstack([first.twist, twist])
    along = np.vstack([first.steering, angles]) if robot.steered else None
    held, steering_rate = (None, None) if along is None else (angles, np.diff(along, axis=0) / dt)
    torques = dynamics.torques(twist, np.diff(through, axis=0) / dt, held, steering_rate)
    every = np.vstack([first.wheel_speeds, speeds])
    turned = 0.5 * (every[1:] + every[:-1]) * dt
    return {
        "torques": torques,
        "work": sums((torques * turned).sum(axis=1)),
        "energy": dynamics.kinetic_energy(through, along),
    }
