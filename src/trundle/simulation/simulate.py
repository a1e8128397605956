"""Kinematic simulation of one robot with known commands."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from trundle.errors import TrundleError
from trundle.kinematics import Inverse, Kinematics, finite
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.commands import Command, Samples, length, sample
from trundle.simulation.integrators import METHODS
from trundle.simulation.run import Run
from trundle.simulation.times import step_times

# Steps multiplied together. BLAS would share longer products out among threads, which wait for
# each other wherever other work holds a core, longer than one thread takes for all of it.
_BLOCK = 16384


def simulate(
    robot: Robot,
    *,
    wheel_speeds: Command | None = None,
    twist: Command | None = None,
    steering: Command | None = None,
    duration: float | None = None,
    dt: float = 0.01,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
    method: str = "exact",
) -> Run:
    """Return the run of a robot under known commands, from ``eta_dot = J(psi) W omega``.

    A command is constant (k,), sampled (T, k) and held over each step, or a function of time
    that returns (..., k). Sampled commands give the duration.

    Args:
        robot: the robot.
        wheel_speeds: n wheel speeds [rad/s]; give these or ``twist``.
        twist: u, v, r in the body frame [m/s, m/s, rad/s]; the nearest feasible one is driven,
            within the limits of wheel speeds and steering.
        steering: s steering angles [rad]; with ``twist`` they follow from it.
        duration: length of the run [s]; the last step is shorter where dt does not divide it.
        dt: step [s].
        pose: (3,) start x, y, psi in the inertial frame [m, m, rad].
        method: "exact" and "euler" take each command at the step's start, "rk4" at its middle
            and end too. For constant and sampled commands "exact" has no error.

    Returns:
        The run.

    Raises:
        TrundleError: a command, duration, step or method is not usable; the message says why.

    >>> import math
    >>> from trundle import load
    >>> run = simulate(load("differential"), twist=[1.0, 0.0, 1.0], duration=math.pi, dt=0.1)
    >>> run.pose[-1].round(9).tolist()  # half a circle of radius 1 m
    [0.0, 2.0, 3.141592654]
    """
    if (wheel_speeds is None) == (twist is None):
        raise TrundleError("give either wheel_speeds or twist")
    if twist is not None and steering is not None:
        raise TrundleError("steering follows from the twist: leave it out")
    if not isinstance(method, str) or method not in METHODS:
        raise TrundleError(f"method must be one of {', '.join(METHODS)}, got {method!r}")
    start = finite(pose, "pose")
    if start.shape != (3,):
        raise TrundleError(f"pose must be three numbers (x, y, psi), got shape {start.shape}")
    given = {"wheel_speeds": wheel_speeds, "twist": twist, "steering": steering}
    rows = next((n for n in map(length, given.values(), given) if n is not None), None)
    t = step_times(duration, dt, rows)
    kinematics = Kinematics(robot)
    if twist is not None:
        speeds, angles = _from_twist(kinematics, sample(twist, t, 3, "twist"))
    else:
        assert wheel_speeds is not None
        speeds = sample(wheel_speeds, t, len(robot.driven), "wheel_speeds")
        held = np.zeros(0) if steering is None and not robot.steered else steering
        if held is None:
            names = ", ".join(wheel.name for wheel in robot.steered)
            raise TrundleError(f"robot {robot.name!r} steers: give steering, the angles of {names}")
        angles = sample(held, t, len(robot.steered), "steering")
    return _run(kinematics, speeds, angles, t, start, method)


def _from_twist(kinematics: Kinematics, twist: Samples) -> tuple[Samples, Samples]:
    """Return wheel speeds and steering angles for twists, steering without half-turn jumps."""
    if twist.middle is twist.start:  # held over each step
        found = _steadily(kinematics, twist.start)
        return Samples(*[found.wheel_speeds] * 3), Samples(*[found.steering] * 3)
    # In order of time: start, middle and end of a step, then the next.
    inorder = np.stack(twist, axis=1).reshape(-1, 3)
    found = _steadily(kinematics, inorder)
    speeds, angles = (
        Samples(*(values[i::3] for i in range(3)))
        for values in (found.wheel_speeds, found.steering)
    )
    return speeds, angles


def _steadily(kinematics: Kinematics, twist: Array) -> Inverse:
    found = kinematics.inverse(twist)
    if not kinematics.robot.steered:
        return found
    return kinematics.inverse(found.twist, steering=kinematics.steady_steering(found.twist))


def _run(
    kinematics: Kinematics, speeds: Samples, angles: Samples, t: Array, pose: Array, method: str
) -> Run:
    dt = np.diff(t)
    robot = kinematics.robot
    if method == "rk4":
        twist = Samples(*(_twist(kinematics, w, b) for w, b in zip(speeds, angles, strict=True)))
        turn = (speeds.start + 4 * speeds.middle + speeds.end) / 6
    else:
        first = _twist(kinematics, speeds.start, angles.start)
        twist, turn = Samples(first, first, first), speeds.start
    wheel_angles = np.zeros((len(t), len(robot.driven)))
    turned = np.multiply(turn, dt[:, None], out=wheel_angles[1:])
    np.cumsum(turned, axis=0, out=turned)
    return Run(
        t=t,
        pose=METHODS[method](twist, dt, pose),
        twist=twist.start,
        wheel_speeds=speeds.start,
        steering=angles.start,
        wheel_angles=wheel_angles,
        driven=tuple(wheel.name for wheel in robot.driven),
        steered=tuple(wheel.name for wheel in robot.steered),
    )


def _twist(kinematics: Kinematics, speeds: Array, angles: Array) -> Array:
    if not kinematics.robot.steered:
        twist = np.empty((len(speeds), 3))
        for first in range(0, len(speeds), _BLOCK):
            steps = slice(first, first + _BLOCK)
            np.matmul(speeds[steps], kinematics.W.T, out=twist[steps])
        return twist
    # Held angles need one matrix for all steps.
    same = len(angles) > 0 and bool((angles == angles[0]).all())
    matrix = kinematics.wheel_matrix(angles[0] if same else angles)
    return np.asarray((matrix @ speeds[..., None])[..., 0])
