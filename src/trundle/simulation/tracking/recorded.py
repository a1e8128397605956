"""From what a closed loop noted to a run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.se2 import Array
from trundle.simulation.run import Run
from trundle.simulation.tracking.loops import COLUMNS
from trundle.simulation.tracking.plant import Plant

# Torques that are cut off by less than rounding are not cut off.
_ROUNDING = 1e-9


class Motion(NamedTuple):
    """What a closed loop did in k <= T steps."""

    steps: int  # k
    block: Array  # (18 + 3 n + 2, T + 1): the loop's notes, and room for what follows from them
    asked: Array | None = None  # (n, k) torques commanded [N m], where not the least for the force
    continuous: bool = False  # whether the law was evaluated within the steps, not held over them
    straight: bool = False  # whether force and acceleration kept their direction over each step


def motion_run(plant: Plant, motion: Motion, t: Array, desired: Array) -> Run:
    """Return the run: wheel speeds, torques within the limits, energy, work and reports.

    Args:
        plant: what moved.
        motion: how it moved.
        t: (T + 1,) times asked [s].
        desired: (T + 1, 3) poses of the trajectory.
    """
    steps, dynamics, n = motion.steps, plant.dynamics, len(plant.G)
    done = t[: steps + 1]
    # Whole columns stand together in memory, all of them in one block that is quick to come by.
    pose, twist, body_force, force, error, moved, speeds, angles, torques = np.split(
        motion.block[:-2, : steps + 1], [3, 6, 9, 12, 15, 18, 18 + n, 18 + 2 * n]
    )
    energy, work = motion.block[-2:, : steps + 1]
    product(plant.G, twist, out=speeds)
    saturated = np.zeros((n, steps), dtype=bool)
    if motion.asked is None:
        product(plant.allocation, body_force, out=torques)
    else:
        torques[:, :-1], torques[:, -1:] = motion.asked, 0.0
    if dynamics.torque_limits.any:
        held = dynamics.torque_limits.held(torques.T, speeds.T).T
        slack = _ROUNDING * np.maximum(np.abs(torques), 1.0)
        saturated = (np.abs(held - torques) > slack)[:, :-1]
        torques[:] = held
    product(plant.G, moved, out=angles)
    work[0] = 0.0
    if motion.continuous:
        power = np.einsum("it,it->t", torques, speeds)
        gained = 0.5 * np.diff(done) * (power[1:] + power[:-1])
    elif motion.straight and not plant.acting:
        gained = np.einsum("it,it->t", force[:, :-1], np.diff(pose, axis=1))
    else:
        gained = np.einsum("it,it->t", torques[:, :-1], np.diff(angles, axis=1))
    np.cumsum(gained, out=work[1:])
    momentum = product(0.5 * plant.here.M, twist, np.empty_like(twist))
    np.einsum("it,it->t", momentum, twist, out=energy)
    names = tuple(wheel.name for wheel in dynamics.robot.driven)
    return Run(
        t=done,
        pose=pose.T,
        twist=twist[:, :-1].T,
        wheel_speeds=speeds[:, :-1].T,
        steering=np.zeros((steps, 0)),
        wheel_angles=angles.T,
        driven=names,
        steered=(),
        desired=desired[: steps + 1],
        error=error.T,
        torques=torques[:, :-1].T,
        force=force[:, :-1].T,
        energy=energy,
        work=work,
        saturated=saturated.T,
        reports=(
            *_reports(t, steps, saturated, error, names),
            *heading_jumps(done, desired[: steps + 1], error[2]),
        ),
    )


def new_block(wheels: int, times: int) -> Array:
    """Return a block for the motion of a robot with so many driven wheels at so many times."""
    return np.empty((COLUMNS + 3 * wheels + 2, times))


def product(matrix: Array, columns: Array, out: Array) -> Array:
    """Write matrix (k, 3) times columns (3, T) into ``out`` (k, T), and return it.

    Not by BLAS, which shares long products out among threads: they wait for each other wherever
    other work holds a core, longer than one thread takes for all of it.
    """
    return np.asarray(np.einsum("ij,jt->it", matrix, columns, out=out))


def sums(steps: Array) -> Array:
    """Return the sums (..., T + 1) of steps (..., T), from 0."""
    out = np.zeros((*steps.shape[:-1], steps.shape[-1] + 1))
    np.cumsum(steps, axis=-1, out=out[..., 1:])
    return out


def ended_early(t: Array, steps: int) -> list[str]:
    """Return what to say of a run that made fewer steps than there are times for."""
    if steps == len(t) - 1:
        return []
    return [
        f"The motion grew beyond all bounds at t = {t[steps]:.4g} s of {t[-1]:.4g} s; the run ends "
        "there. Take a shorter step or smaller gains."
    ]


# A heading that changes by more from one time to the next, and far more than usual, jumps [rad].
_JUMP, _FAR = 0.3, 20.0


def heading_jumps(t: Array, desired: Array, error: Array) -> list[str]:
    """Return what to say of a desired heading that jumps, which no robot can follow.

    Args:
        t: (T + 1,) times [s].
        desired: (T + 1, 3) poses.
        error: (T + 1,) of the heading [rad].
    """
    if np.abs(error).max(initial=0.0) < _JUMP:
        return []
    change = np.abs(np.diff(desired[:, 2]))
    if change.max(initial=0.0) <= max(_JUMP, _FAR * float(change.sum()) / max(len(change), 1)):
        return []
    at = np.flatnonzero(change > _JUMP)
    when, most = t[at[0] + 1], change[at].max()
    return [
        f"The desired heading jumps by up to {most:.3g} rad (first at t = {when:.4g} s): so large "
        "an error of psi is the trajectory's, not the controller's."
    ]


def _reports(
    t: Array, steps: int, saturated: Array, error: Array, names: tuple[str, ...]
) -> list[str]:
    """Return what went wrong: a motion that ended early, motors (n, T) at their limits."""
    told = ended_early(t, steps)
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
