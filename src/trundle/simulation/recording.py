"""Runs and the logs of wheel sensors: one made into the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from trundle.kinematics import Kinematics
from trundle.odometry import Counts, Log, dead_reckon, write_columns
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.run import Run


def sensed_angles(robot: Robot, run: Run) -> Array:
    """Return how far the sensed wheels have turned (T + 1, k) [rad], dead wheels too.

    Each turns with the twist held over the step, with no slip.

    >>> from trundle import load, simulate
    >>> robot = load("mixed")
    >>> run = simulate(robot, twist=[0.3, 0.0, 0.0], duration=1.0)
    >>> sensed_angles(robot, run)[-1].round(9).tolist()
    [6.0, 6.0, 10.0, 10.0]
    """
    steering = run.steering if robot.steered else None
    rates = Kinematics(robot).rolling_speeds(run.twist, steering, sensed=True)
    out = np.zeros((len(run.t), rates.shape[1]))
    np.cumsum(rates * np.diff(run.t)[:, None], axis=0, out=out[1:])
    return out


def write_log(robot: Robot, run: Run, path: str | Path, counter_bits: int | None = None) -> Path:
    """Write a log as the robot would have recorded it, with the run's pose as truth.

    Wheels with an encoder give running counts, quantised, which wrap around at ``counter_bits``;
    the others their angle. ``read_log`` reads it back.

    Raises:
        FileError: the file cannot be written.
    """
    columns: dict[str, Array | Counts] = {
        "time": run.t,
        "x": run.pose[:, 0],
        "y": run.pose[:, 1],
        "psi": run.pose[:, 2],
    }
    for wheel, angle in zip(robot.sensed, sensed_angles(robot, run).T, strict=True):
        if wheel.encoder is None:
            columns[f"angle:{wheel.name}"] = angle
            continue
        counts = np.round(angle / wheel.encoder.radians_per_tick)
        if counter_bits is not None:
            counts = np.mod(counts, 2.0**counter_bits)
        columns[f"counts:{wheel.name}"] = counts.astype(np.int64)
    for i, steered in enumerate(robot.steered):
        held = run.steering[:, i]
        columns[f"steering:{steered.name}"] = np.concatenate([held[:1], held])
    return write_columns(path, columns)


def replay(robot: Robot, log: Log, pose: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Run:
    """Return the run that a log tells, by dead reckoning.

    A log whose time is missing or stands still counts its rows as seconds.

    Args:
        robot: the robot of the log.
        log: the log.
        pose: (3,) start x, y, psi in the inertial frame [m, m, rad].

    Raises:
        UnobservedMotionError: too few wheels are sensed; the unobserved motion is named.

    >>> from trundle import load
    >>> log = Log(time=None, wheel_increments=np.ones((3, 2)), steering=None, truth=None)
    >>> run = replay(load("differential", radius=0.05), log)
    >>> round(float(run.pose[-1, 0]), 9)
    0.15
    """
    t = np.arange(len(log.wheel_increments) + 1, dtype=np.float64)
    if log.time is not None and (np.diff(log.time) > 0).all():
        t = log.time
    dt = np.diff(t)[:, None]
    kinematics = Kinematics(robot)
    moved = kinematics.odometry_matrix(log.steering) @ log.wheel_increments[..., None]
    twist = moved[..., 0] / dt
    wheel_speeds = kinematics.rolling_speeds(twist, log.steering)
    return Run(
        t=t,
        pose=dead_reckon(robot, log.wheel_increments, log.steering, pose),
        twist=twist,
        wheel_speeds=wheel_speeds,
        steering=np.zeros((len(dt), 0)) if log.steering is None else log.steering,
        wheel_angles=np.concatenate(
            [np.zeros((1, wheel_speeds.shape[1])), np.cumsum(wheel_speeds * dt, axis=0)]
        ),
        driven=tuple(wheel.name for wheel in robot.driven),
        steered=tuple(wheel.name for wheel in robot.steered),
    )
