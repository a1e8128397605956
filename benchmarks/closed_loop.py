"""A closed loop: trundle.track, in Python alone and compiled, beside the lectures' loop in NumPy.

Computed torque keeps a robot of three omni wheels on a circle. The lectures' loop builds M(q) and
n(q, q_d) at each step, solves the equations of motion for q_dd and takes the lectures' step; all
candidates with that step must agree on poses, errors and forces.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import fields
from functools import partial
from importlib.util import find_spec

import numpy as np
from _common import (
    Job,
    Options,
    Results,
    as_digits,
    environment,
    machine,
    measure,
    publish,
    read_options,
    serve,
    table,
    verdict,
)
from numpy.typing import NDArray

import trundle
from trundle import motion
from trundle.control import ComputedTorque

Array = NDArray[np.float64]

# The smoke run's is the shortest that trundle still compiles for.
DURATION, SMOKE_DURATION = 60.0, 20.0  # [s]
DT = 1e-3  # [s]
MASS, INERTIA, COM = 30.0, 0.1, (0.0, 0.0)  # [kg], about the centre of mass [kg m^2], [m]
RADIUS, RATE = 3.0, 0.1  # [m], [rad/s]
GAIN = 4.0  # of all errors [1/s^2] and of their rates [1/s]

# Sides round differently, some 1e-16 a step; the loop damps what has gathered within a second.
ROUNDING = 1e-9
REQUIRED, REQUIRED_COMPILED, FIRST_CALL_S = 1 / 5, 1 / 200, 2.0
FIRST_CALLS = 9


# ---- the lectures' loop ----------------------------------------------------------------------


def lecture_loop(duration: float) -> tuple[Array, Array, Array]:
    """Return poses (T + 1, 3), errors (T, 3) and forces (T, 3)."""
    m, I_cz, (x_bc, y_bc) = MASS, INERTIA, COM
    r, w, dt = RADIUS, RATE, DT
    K_p, K_d = GAIN * np.eye(3), GAIN * np.eye(3)
    T = round(duration / dt)
    q, q_d = np.array([0.0, 0.0, 0.0]), np.array([r * w, 0.0, w])
    pose, error, force = np.zeros((T + 1, 3)), np.zeros((T, 3)), np.zeros((T, 3))
    for k in range(T):
        # Where to be.
        sin_wt, cos_wt = np.sin(w * k * dt), np.cos(w * k * dt)
        x_d, y_d = r * w * cos_wt, r * w * sin_wt
        x_dd, y_dd = -r * w**2 * sin_wt, r * w**2 * cos_wt
        psi = np.arctan2(y_d, x_d) % (2 * np.pi)
        psi_d = (x_d * y_dd - y_d * x_dd) / (x_d**2 + y_d**2)
        q_des = np.array([r * sin_wt, r - r * cos_wt, psi])
        q_d_des = np.array([x_d, y_d, psi_d])
        q_dd_des = np.array([x_dd, y_dd, 0.0])
        # The equations of motion here, M q_dd + n = tau.
        c, s = np.cos(q[2]), np.sin(q[2])
        a, b = -m * (y_bc * c + x_bc * s), m * (x_bc * c - y_bc * s)
        M = np.array([[m, 0, a], [0, m, b], [a, b, I_cz + m * (x_bc**2 + y_bc**2)]])
        n = np.array([-b * q_d[2] ** 2, a * q_d[2] ** 2, 0])
        # Computed torque, and the step.
        e, e_d = q_des - q, q_d_des - q_d
        tau = M @ (q_dd_des + K_d @ e_d + K_p @ e) + n
        q_dd = np.linalg.solve(M, tau - n)
        pose[k], error[k], force[k] = q, e, tau
        q = q + dt * q_d + dt**2 / 2 * q_dd
        q_d = q_d + dt * q_dd
    pose[T] = q
    return pose, error, force


# ---- candidates ------------------------------------------------------------------------------


def sampled(pose: Array, error: Array, force: Array) -> list[float]:
    """Return some of the numbers, the last among them."""
    last = len(force) - 1
    rows = np.linspace(0, last, 21).astype(int)
    return [float(x) for a in (pose[1:], error, force) for x in a[rows].ravel()]


def closed_loop(
    method: str, duration: float, heading: str = "path"
) -> tuple[str, dict[str, object]]:
    """Return the statement that a user writes, and the values of its names."""
    names = {
        "track": trundle.track,
        "robot": trundle.load("omni3").with_body(mass=MASS, inertia=INERTIA, com=COM),
        "circle": motion.circle(RADIUS, RATE, heading=heading),
        "controller": ComputedTorque([GAIN] * 3, [GAIN] * 3),
    }
    given = f"duration={duration}, dt={DT}, method={method!r}"
    return f"track(robot, circle, controller, {given})", names


def hide_numba() -> None:
    """Make this process one where numba is not installed: Python's own way to block an import."""
    sys.modules["numba"] = None  # type: ignore[assignment]


def track(method: str, duration: float, compiled: bool = True, heading: str = "path") -> Job:
    if not compiled:
        hide_numba()
    statement, names = closed_loop(method, duration, heading)
    run = eval(statement, names)
    if (sys.modules.get("numba") is not None) != compiled:
        raise SystemExit(f"{statement} was {'not ' * compiled}compiled")
    return Job(statement, names, sampled(run.pose, run.error, run.force))


def by_hand(duration: float) -> Job:
    names = {"loop": lecture_loop, "duration": duration}
    return Job("loop(duration)", names, sampled(*lecture_loop(duration)))


def write(duration: float) -> Job:
    """Return the writing alone of what a Run stores."""
    hide_numba()
    statement, names = closed_loop("lecture", duration)
    run = eval(statement, names)
    stored = [getattr(run, field.name) for field in fields(run)]
    size = sum(array.nbytes for array in stored if isinstance(array, np.ndarray))
    return Job("memory.fill(1.0)", {"memory": np.zeros(size // 8)}, [size])


PLAIN, COMPILED = "trundle.track, without numba", "trundle.track, compiled"
HEADING = f"{COMPILED}, the lectures' heading"
SEMI_IMPLICIT, RK4 = f'{COMPILED}, "semi-implicit"', f'{COMPILED}, "rk4"'
LOOP, WRITE = "the lectures' loop in NumPy", "writing the results"
FIRST = "its first call, in a fresh process"


def jobs(duration: float, numba: bool, smoke: bool) -> dict[str, Callable[[], Job]]:
    """Return all candidates; a smoke run leaves out methods that nothing else is compared with."""
    out: dict[str, Callable[[], Job]] = {PLAIN: partial(track, "lecture", duration, compiled=False)}
    if numba:
        out[COMPILED] = partial(track, "lecture", duration)
        out[HEADING] = partial(track, "lecture", duration, heading="lecture")
    if numba and not smoke:
        out[SEMI_IMPLICIT] = partial(track, "semi-implicit", duration)
        out[RK4] = partial(track, "rk4", duration)
    out[LOOP] = partial(by_hand, duration)
    out[WRITE] = partial(write, duration)
    return out


# ---- the first call --------------------------------------------------------------------------


def first_call(duration: float) -> float:
    """Return the time [s] of the first call that is compiled, in the process that asks."""
    statement, names = closed_loop("lecture", duration)
    start = time.perf_counter()
    eval(statement, names)
    return time.perf_counter() - start


def first_calls(options: Options) -> list[float]:
    command = [sys.executable, sys.argv[0], "--candidate", FIRST, *["--smoke"][: options.smoke]]
    return [
        float(subprocess.check_output(command, env=environment(), text=True))
        for _ in range(2 if options.smoke else FIRST_CALLS)
    ]


# ---- the comparison --------------------------------------------------------------------------

NOTES = """\
{steps:,} steps of 1 ms: three omni wheels, {mass:g} kg, a circle of {radius:g} m, and the lectures'
step where no other is named. Ratios are medians over rounds in which every candidate, in a process
of its own, takes its turn; in parentheses their quartiles. The loop stores poses, errors and
forces; track checks its input and stores wheel speeds, torques, energy and work, too. "Writing the
results" fills memory that is already there with as many bytes ({size:.1f} MB), at
{bandwidth:.1f} GB/s: the limit of any implementation on this machine."""
NOTES_COMPILED = """\
The first call, which imports numba and compiles, is the median of {count} fresh processes, with
quartiles of {low:.2f} s and {high:.2f} s."""


def rows(results: Results, first: list[float]) -> list[list[str]]:
    required = {PLAIN: REQUIRED, COMPILED: REQUIRED_COMPILED}
    out = []
    for name in results.times:
        row = [name, as_digits(1e3 * results.median(name)), results.ratio_text(name, LOOP), ""]
        if name == LOOP:
            row[2] = "1"
        if name in required:
            row[3] = verdict(results.ratio(name, LOOP)[0], required[name])
        out.append(row)
        if name == COMPILED:
            taken = statistics.median(first)
            met = "met" if taken < FIRST_CALL_S else "missed"
            out.append([FIRST, as_digits(1e3 * taken), "", f"under {FIRST_CALL_S:g} s: {met}"])
    return out


def main() -> None:
    options = read_options(__doc__, processes=2, rounds=6, seconds=0.05)
    duration = SMOKE_DURATION if options.smoke else DURATION
    if options.candidate == FIRST:
        print(first_call(duration))
        return
    numba = find_spec("numba") is not None
    all_ = jobs(duration, numba, options.smoke)
    if options.candidate:
        serve(all_[options.candidate]())
        return
    if not numba:
        print("numba is not installed: nothing is compiled.\n")
    results = measure(all_, options)
    results.assert_agreement([LOOP, PLAIN, *[COMPILED, HEADING] * numba], ROUNDING)
    first = first_calls(options) if numba else []
    size = results.answers[WRITE][0]
    notes = NOTES.format(
        steps=round(duration / DT),
        mass=MASS,
        radius=RADIUS,
        size=1e-6 * size,
        bandwidth=1e-9 * size / results.median(WRITE),
    )
    if numba:
        low, _, high = statistics.quantiles(first, method="inclusive")
        notes += "\n" + NOTES_COMPILED.format(count=len(first), low=low, high=high)
    text = f"## A closed loop\n\n{machine('numpy', *['numba'] * numba)}.\n{notes}"
    header = [f"computed torque, {duration:g} s", "ms per run", "ratio to the loop", "required"]
    publish("closed_loop", f"{text}\n\n{table(header, rows(results, first))}", options)


if __name__ == "__main__":
    main()
