"""From what a closed loop noted to a run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.se2 import Array
from trundle.simulation.run import Run
from trundle.simulation.tracking.plant import Plant

# Torques that are cut off by less than rounding are not cut off.
_ROUNDING = 1e-9


class Motion(NamedTuple):
    """What a closed loop did in k <= T steps."""

    steps: int  # k
    notes: Array  # (15, T + 1): pose, twist, force in the body and the inertial frame, error
    asked: Array  # (n, k) torques that the commands ask of the wheels [N m]


def motion_run(plant: Plant, motion: Motion, t: Array, desired: Array) -> Run:
    """Return the run: wheel speeds, torques within the limits, energy, work and reports.

    Args:
        plant: what moved.
        motion: how it moved.
        t: (T + 1,) times asked [s].
        desired: (T + 1, 3) poses of the trajectory.
    """
    steps, dynamics = motion.steps, plant.dynamics
    done = t[: steps + 1]
    # Whole columns stand together in memory, so sums go along them.
    pose, twist, _, force, error = motion.notes[:, : steps + 1].reshape(5, 3, -1)
    speeds = product(plant.G, twist)
    torques, saturated = motion.asked, np.zeros((len(speeds), steps), dtype=bool)
    if dynamics.torque_limits.any:
        asked = torques
        torques = dynamics.torque_limits.held(asked.T, speeds[:, :-1].T).T
        saturated = np.abs(torques - asked) > _ROUNDING * np.maximum(np.abs(asked), 1.0)
    turns = 0.5 * (speeds[:, 1:] + speeds[:, :-1]) * np.diff(done)
    names = tuple(wheel.name for wheel in dynamics.robot.driven)
    return Run(
        t=done,
        pose=pose.T,
        twist=twist[:, :-1].T,
        wheel_speeds=speeds[:, :-1].T,
        steering=np.zeros((steps, 0)),
        wheel_angles=sums(turns).T,
        driven=names,
        steered=(),
        desired=desired[: steps + 1],
        error=error.T,
        torques=torques.T,
        force=force[:, :-1].T,
        energy=0.5 * (product(plant.here.M, twist) * twist).sum(axis=0),
        work=sums((torques * turns).sum(axis=0)),
        saturated=saturated.T,
        reports=tuple(_reports(t, steps, saturated, error, names)),
    )


def product(matrix: Array, columns: Array) -> Array:
    """Return matrix (k, 3) times columns (3, T).

    Not by BLAS, which shares long products out among threads: they wait for each other wherever
    other work holds a core, longer than one thread takes for all of it.
    """
    return np.asarray(np.einsum("ij,jt->it", matrix, columns))


def sums(steps: Array) -> Array:
    """Return the sums (..., T + 1) of steps (..., T), from 0."""
    out = np.zeros((*steps.shape[:-1], steps.shape[-1] + 1))
    np.cumsum(steps, axis=-1, out=out[..., 1:])
    return out


def _reports(
    t: Array, steps: int, saturated: Array, error: Array, names: tuple[str, ...]
) -> list[str]:
    """Return what went wrong: a motion that ended early, motors (n, T) at their limits."""
    told = []
    if steps < len(t) - 1:
        told.append(
            f"The motion grew beyond all bounds at t = {t[steps]:.4g} s of {t[-1]:.4g} s; the run "
            "ends there. Take a shorter step or smaller gains."
        )
    if saturated.any():
        share = saturated.mean(axis=1)
        worst = ", ".join(
            f"{name} {100 * part:.3g} %" for name, part in zip(names, share, strict=True) if part
        )
        first = t[int(saturated.any(axis=0).argmax())]
        told.append(
            f"Motors were at their torque limits ({worst} of the time, first at t = {first:.4g} "
            f"s); the robot was up to {np.hypot(error[0], error[1]).max():.3g} m from the "
            "trajectory. trundle.limits.feasibility tells by which factor to stretch time."
        )
    return told
