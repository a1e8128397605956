"""The peers in NumPy: whole arrays over all robots, and the lectures' loop over one."""

from __future__ import annotations

from typing import Any

import numpy as np
from _batch_tasks import (
    BELIEVED,
    COM,
    DT,
    FOLLOW_GAIN,
    INERTIA,
    KD,
    KP,
    MASS,
    MPPI_DT,
    MPPI_SIGMA,
    PATH_RADIUS,
    PATH_RATE,
    SIGMA,
    TEMPERATURE,
    TRACKING_DT,
    Numbers,
    Sizes,
    circle_table,
    constant_speeds,
    exact_step,
    few,
    first_plan,
    increments,
    spread,
    stage_cost,
    starts,
    streamed_speeds,
    tracking_step,
)
from _common import Job

# ---- wheel commands --------------------------------------------------------------------------


def drive(speeds: Numbers, matrix: Numbers, steps: int, out: Numbers | None = None) -> Any:
    """Return the final poses (x, y, psi); commands (T, 4, N), or (4, N) held over all steps."""
    x, y, psi = np.zeros((3, speeds.shape[-1]), speeds.dtype)
    if out is not None:
        out[0] = x, y, psi
    held = matrix @ speeds if speeds.ndim == 2 else None
    for t in range(steps):
        dx, dy, half = matrix @ speeds[t] if held is None else held
        x, y, psi = exact_step(np, x, y, psi, dx, dy, half)
        if out is not None:
            out[t + 1, 0], out[t + 1, 1], out[t + 1, 2] = x, y, psi
    return x, y, psi


def drive_held(speeds: Numbers, matrix: Numbers, steps: int, out: Numbers) -> None:
    """Write trajectories (T + 1, 3, N) of held commands: the chords are taken out of the loop."""
    dx, dy, half = matrix @ speeds
    z = half * half
    chord = 1 - z * (1 / 6 - z * (1 / 120))
    dx, dy, turn = chord * dx, chord * dy, 2 * half
    out[0] = 0
    for t in range(steps):
        (x, y, psi), (x_new, y_new, psi_new) = out[t], out[t + 1]
        middle = psi + half
        c, s = np.cos(middle), np.sin(middle)
        np.add(x, c * dx - s * dy, out=x_new)
        np.add(y, s * dx + c * dy, out=y_new)
        np.add(psi, turn, out=psi_new)


def streamed(size: Sizes, dtype: str, stored: bool = False) -> Job:
    speeds, matrix = streamed_speeds(size, dtype), increments().astype(dtype)
    out = np.zeros((size.steps + 1, 3, size.robots), dtype) if stored else None
    names = {"drive": drive, "speeds": speeds, "M": matrix, "T": size.steps, "out": out}
    answer = few(size, *drive(speeds, matrix, size.steps, out))
    return Job("drive(speeds, M, T, out)", names, answer, size.steps * size.robots)


def constant(size: Sizes, dtype: str) -> Job:
    speeds, matrix = constant_speeds(size).astype(dtype), increments().astype(dtype)
    out = np.zeros((size.steps + 1, 3, size.robots), dtype)
    drive_held(speeds, matrix, size.steps, out)
    names = {"drive": drive_held, "speeds": speeds, "M": matrix, "T": size.steps, "out": out}
    return Job("drive(speeds, M, T, out)", names, few(size, *out[-1]), size.steps * size.robots)


def noisy(size: Sizes, dtype: str) -> Job:
    """Return what a user writes whose commands are held and get noise in every step."""
    speeds, matrix = constant_speeds(size).astype(dtype), increments().astype(dtype)
    rng = np.random.default_rng(4)

    def drive_noisy() -> Any:
        x, y, psi = np.zeros((3, size.robots), dtype)
        for _ in range(size.steps):
            noise = rng.standard_normal(speeds.shape, dtype=dtype)
            dx, dy, half = matrix @ (speeds + SIGMA * noise)
            x, y, psi = exact_step(np, x, y, psi, dx, dy, half)
        return x, y, psi

    return Job("drive()", {"drive": drive_noisy}, spread(*drive_noisy()), size.steps * size.robots)


def euler_loop(W: Numbers, omega: Numbers, dt: float) -> Numbers:
    """Return the last pose of one robot: the lectures' J(psi) at the middle of each step's turn."""
    eta = np.zeros(3)
    for k in range(len(omega)):
        zeta = W @ omega[k]
        half = dt * zeta[2] / 2
        psi = eta[2] + half
        J = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
        chord = np.array([np.sinc(half / np.pi), np.sinc(half / np.pi), 1])
        eta = eta + dt * (J @ (chord * zeta))
    return eta


def lecture(size: Sizes) -> Job:
    """Return the lectures' loop, robot after robot."""
    speeds = streamed_speeds(size, "float64")[:, :, : size.few_robots]
    W = increments() / DT * np.array([[1.0], [1.0], [2.0]])
    rows = [np.ascontiguousarray(speeds[:, :, i]) for i in range(size.few_robots)]
    answer = few(size, *np.transpose([euler_loop(W, row, DT) for row in rows]))
    names = {"loop": euler_loop, "W": W, "omega": rows[0], "dt": DT}
    return Job("loop(W, omega, dt)", names, answer, size.steps)


# ---- dynamics --------------------------------------------------------------------------------


def computed_torque(size: Sizes, dtype: str) -> Job:
    start, desired = starts(size).astype(dtype), circle_table(size.steps).tolist()

    def run() -> Any:
        state = (*start, *np.zeros((3, size.robots), dtype))
        for now in desired:
            state = tracking_step(np, state, now)
        return state[:3]

    return Job("run()", {"run": run}, few(size, *run()), size.steps * size.robots)


def lecture_torque_loop(start: Numbers, table: Numbers) -> Numbers:
    """Return the last pose of one robot: matrices at each step, solved for the acceleration."""
    dt, m, m_ = TRACKING_DT, MASS, BELIEVED
    mx, mx_ = m * COM, m_ * COM
    M = np.array([[m, 0, 0], [0, m, mx], [0, mx, INERTIA + mx * COM]])
    M_ = np.array([[m_, 0, 0], [0, m_, mx_], [0, mx_, INERTIA + mx_ * COM]])
    eta, zeta = start.copy(), np.zeros(3)
    for X, Y, X_d, Y_d, X_dd, Y_dd in table:
        c, s = np.cos(eta[2]), np.sin(eta[2])
        J = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        u, v, r = zeta
        n = np.array([-m * r * v - mx * r**2, m * r * u, mx * r * u])
        n_ = np.array([-m_ * r * v - mx_ * r**2, m_ * r * u, mx_ * r * u])
        e, e_d = np.array([X, Y, 0]) - eta, np.array([X_d, Y_d, 0]) - J @ zeta
        a = J.T @ (np.array([X_dd, Y_dd, 0]) + KD * e_d + KP * e) + np.array([r * v, -r * u, 0])
        tau = M_ @ a + n_
        zeta = zeta + dt * np.linalg.solve(M, tau - n)
        half = dt * zeta[2] / 2
        c, s = np.cos(eta[2] + half), np.sin(eta[2] + half)
        J = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        chord = np.array([np.sinc(half / np.pi), np.sinc(half / np.pi), 1])
        eta = eta + dt * (J @ (chord * zeta))
    return eta


def lecture_torque(size: Sizes) -> Job:
    start, table = starts(size).astype(np.float64), circle_table(size.steps)
    robots = range(size.few_robots)
    answer = few(size, *np.transpose([lecture_torque_loop(start[:, i], table) for i in robots]))
    names = {"loop": lecture_torque_loop, "start": start[:, 0], "table": table}
    return Job("loop(start, table)", names, answer, size.steps)


# ---- MPPI ------------------------------------------------------------------------------------


def mppi(size: Sizes) -> Job:
    """Return a tick in single precision, its noise drawn anew."""
    plan, rng = first_plan(size), np.random.default_rng(5)
    shape = (size.horizon, 3, size.samples)

    def tick() -> Numbers:
        noise = rng.standard_normal(shape, dtype=np.float32)
        noise *= np.float32(MPPI_SIGMA)
        twists = plan[:, :, None] + noise
        x, y, psi, _ = np.zeros((4, size.samples), np.float32)
        # The price of the plan's effort: what a sample has more of it.
        cost = np.float32(TEMPERATURE / MPPI_SIGMA**2) * np.einsum("ti,tik->k", plan, noise)
        for u, v, r in twists:
            pose = exact_step(np, x, y, psi, MPPI_DT * u, MPPI_DT * v, (0.5 * MPPI_DT) * r)
            x, y, psi = pose
            cost = cost + stage_cost(np, x, y, u, v, r)
        weights = np.exp((cost.min() - cost) / np.float32(TEMPERATURE))
        weights /= weights.sum()
        return plan + noise @ weights

    return Job("tick()", {"tick": tick}, mean_plan(size, tick))


def mean_plan(size: Sizes, tick: Any) -> list[float]:
    """Return the twist that many ticks from the same plan give in the mean over the horizon."""
    return [float(x) for x in np.mean([tick() for _ in range(size.ticks)], axis=(0, 1))]


# ---- feedback --------------------------------------------------------------------------------


def feedback_loop(W: Numbers, W_inverse: Numbers, steps: int, dt: float) -> Numbers:
    """Return the last pose of a robot that follows a circle: the lectures' loop over matrices."""
    radius, w, gain = PATH_RADIUS, PATH_RATE, FOLLOW_GAIN
    eta = np.zeros(3)
    for k in range(steps):
        angle = w * (k * dt)
        eta_des = np.array([radius * np.sin(angle), radius - radius * np.cos(angle), 0])
        eta_d_des = np.array([radius * w * np.cos(angle), radius * w * np.sin(angle), 0])
        c, s = np.cos(eta[2]), np.sin(eta[2])
        J = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        omega = W_inverse @ (J.T @ (eta_d_des + gain * (eta_des - eta)))
        eta = eta + dt * (J @ (W @ omega))
    return eta


def wheel_matrix() -> Numbers:
    """Return W (3, 4), from wheel speeds to the twist."""
    matrix: Numbers = increments() / DT * np.array([[1.0], [1.0], [2.0]])
    return matrix


def feedback(size: Sizes) -> Job:
    W = wheel_matrix()
    names = {
        "loop": feedback_loop, "W": W, "W_inverse": np.linalg.pinv(W), "steps": size.loop_steps,
        "dt": TRACKING_DT,
    }  # fmt: skip
    answer = feedback_loop(W, np.linalg.pinv(W), size.loop_steps, TRACKING_DT)
    return Job("loop(W, W_inverse, steps, dt)", names, answer, size.loop_steps)
