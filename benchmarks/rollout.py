"""A long rollout with known wheel speeds: trundle.simulate beside a loop over time in NumPy.

The loop is the one that lectures write in MATLAB: at each step it builds J(psi), multiplies
eta_dot = J(psi) W omega, and takes an Euler step. Its time per step does not depend on the number
of steps, so that it runs fewer of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from _common import Job, as_digits, machine, measure, publish, read_options, serve, table, verdict
from numpy.typing import NDArray

import trundle

Array = NDArray[np.float64]

STEPS, LOOP_STEPS = 1_000_000, 20_000
# trundle takes steps in blocks of some ten thousand: all candidates agree beyond one, too.
SMOKE_STEPS = 20_000
DT = 0.01  # [s]
# The sums of both sides are rounded in a different order; a path of a million steps is some
# kilometres long.
ROUNDING = 1e-9
REQUIRED = 1 / 50


def wheel_speeds(steps: int) -> Array:
    """Return wheel speeds (T, 4) [rad/s] that wander, so that the robot drives a long curve."""
    t = np.arange(steps) * DT
    waves = [np.sin(0.3 * t), np.cos(0.21 * t), -np.sin(0.17 * t), 0.2 + np.sin(0.13 * t)]
    return 4.0 + np.stack(waves, axis=-1)


def sampled(poses: Array, loop_steps: int) -> list[float]:
    """Return some of the poses, within the steps that every candidate makes."""
    return [float(x) for x in poses[: loop_steps + 1 : loop_steps // 20].ravel()]


def simulate(method: str, steps: int, loop_steps: int) -> Job:
    robot, speeds = trundle.load("mecanum"), wheel_speeds(steps)
    run = trundle.simulate(robot, wheel_speeds=speeds, dt=DT, method=method)
    names = {"simulate": trundle.simulate, "robot": robot, "speeds": speeds}
    return Job(
        f"simulate(robot, wheel_speeds=speeds, dt={DT}, method={method!r})",
        names,
        sampled(run.pose, loop_steps),
        steps,
    )


def euler_loop(W: Array, omega: Array, dt: float) -> Array:
    eta = np.zeros((len(omega) + 1, 3))
    for k in range(len(omega)):
        psi = eta[k, 2]
        J = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
        eta[k + 1] = eta[k] + dt * (J @ W @ omega[k])
    return eta


def prefix_sums(W: Array, omega: Array, dt: float) -> Array:
    """Return exact poses from cumulative sums over whole columns, without any check."""
    dx, dy, dpsi = dt * (W @ omega.T)
    psi = np.cumsum(dpsi)
    half = dpsi / 2
    chord = np.sinc(half / np.pi)
    c, s = chord * np.cos(psi - half), chord * np.sin(psi - half)
    x, y = np.cumsum(c * dx - s * dy), np.cumsum(s * dx + c * dy)
    return np.concatenate([np.zeros((1, 3)), np.stack([x, y, psi], axis=-1)])


def by_hand(function: Callable[[Array, Array, float], Array], steps: int, loop_steps: int) -> Job:
    W, omega = np.array(trundle.Kinematics(trundle.load("mecanum")).W), wheel_speeds(steps)
    names = {"poses": function, "W": W, "omega": omega, "dt": DT}
    answer = sampled(function(W, omega, DT), loop_steps)
    return Job("poses(W, omega, dt)", names, answer, steps)


def write(steps: int) -> Job:
    """Return the writing alone of what a Run stores anew: t, pose, twist and wheel angles."""
    run = trundle.simulate(trundle.load("mecanum"), wheel_speeds=np.ones((2, 4)), dt=DT)
    per_step = sum(a.itemsize * a[0].size for a in (run.t, run.pose, run.twist, run.wheel_angles))
    memory = np.zeros(steps * per_step // 8)
    return Job("memory.fill(1.0)", {"memory": memory}, [per_step], steps)


EXACT, EULER = "trundle.simulate, exact", "trundle.simulate, Euler"
LOOP, FLOOR, WRITE = "Euler loop in NumPy", "prefix sums in NumPy", "writing the results"


def jobs(steps: int, loop_steps: int) -> dict[str, Callable[[], Job]]:
    return {
        EXACT: partial(simulate, "exact", steps, loop_steps),
        EULER: partial(simulate, "euler", steps, loop_steps),
        FLOOR: partial(by_hand, prefix_sums, steps, loop_steps),
        LOOP: partial(by_hand, euler_loop, loop_steps, loop_steps),
        WRITE: partial(write, steps),
    }


NOTES = """\
{steps:,} steps of a mecanum robot with wheel speeds (T, 4) given beforehand; the loop is timed over
{loop_steps:,} steps. Ratios are medians over rounds in which every candidate, in a process of its
own, takes its turn; in parentheses their quartiles. simulate checks its input and stores times,
poses, twists and wheel angles; the prefix sums store poses alone. "Writing the results" fills
memory that is already there with as many bytes as simulate stores ({bytes:.0f} per step), at
{bandwidth:.1f} GB/s: the limit of any implementation on this machine."""


def main() -> None:
    options = read_options(__doc__, processes=2, rounds=8, seconds=0.01)
    steps, loop_steps = (SMOKE_STEPS,) * 2 if options.smoke else (STEPS, LOOP_STEPS)
    all_ = jobs(steps, loop_steps)
    if options.candidate:
        serve(all_[options.candidate]())
        return
    results = measure(all_, options)
    results.assert_agreement([EULER, LOOP], ROUNDING)
    results.assert_agreement([EXACT, FLOOR], ROUNDING)
    rows = []
    for name in all_:
        row = [name, as_digits(1e9 * results.median(name)), results.ratio_text(name, LOOP), ""]
        if name == LOOP:
            row[2] = "1"
        if name == EXACT:
            row[3] = verdict(results.ratio(name, LOOP)[0], REQUIRED)
        rows.append(row)
    size = results.answers[WRITE][0]
    notes = NOTES.format(
        steps=steps,
        loop_steps=loop_steps,
        bytes=size,
        bandwidth=1e-9 * size / results.median(WRITE),
    )
    text = f"## A long rollout\n\n{machine('numpy')}.\n{notes}"
    header = ["mecanum, one robot", "ns per step", "ratio to the loop", "required"]
    publish("rollout", f"{text}\n\n{table(header, rows)}", options)


if __name__ == "__main__":
    main()
