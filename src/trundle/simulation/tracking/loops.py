"""The closed loop over time, one function for each method; see ``laws`` for how it is read.

A loop takes the desired position, velocity and acceleration at every time (for "rk4" at every half
step), constants, the steps dt (T,), the start (x, y, psi, u, v, r) and a flat sequence for its
notes; it returns how many steps it made: fewer than T where the motion outgrew every number.

It notes pose (3), twist (3), force in the body frame (3), force in the inertial frame (3), error
(3) and the integral of the twist by the trapezoid (3) at the start of each step, and at the end.
"""

from __future__ import annotations

import math
import struct
from typing import Any

from trundle import se2
from trundle.simulation.arithmetic import Function, Jit
from trundle.simulation.tracking.laws import Law, make_evaluate

COLUMNS = 18
ENDLESS = 1e12  # a speed [m/s, rad/s] that no motion reaches and that still squares well


def make_loop(method: str, law: Law, hindered: bool, note: Function, jit: Jit) -> Function:
    """Return the loop of a method for a law; its parts are read by the compiler that is given.

    Args:
        method: one of ``LOOPS``.
        law: the control law.
        hindered: whether limits and friction stand between command and body.
        note: how states are kept, ``into_columns`` or ``into_rows``.
        jit: the compiler.
    """
    return _MAKERS[method](jit(make_evaluate(law, hindered, jit)), jit(note), jit)


def into_columns(
    notes: Any, k: int, size: int, x: float, y: float, psi: float, u: float, v: float, r: float,
    X: float, Y: float, Z: float, e_x: float, e_y: float, e_psi: float, c: float, s: float,
    w_x: float, w_y: float, w_z: float,
) -> None:  # fmt: skip
    """Write a state into 18 columns of ``size`` numbers, one after the other."""
    notes[k], notes[k + size], notes[k + 2 * size] = x, y, psi
    notes[k + 3 * size], notes[k + 4 * size], notes[k + 5 * size] = u, v, r
    notes[k + 6 * size], notes[k + 7 * size], notes[k + 8 * size] = X, Y, Z
    notes[k + 9 * size], notes[k + 10 * size] = c * X - s * Y, s * X + c * Y
    notes[k + 11 * size], notes[k + 12 * size] = Z, e_x
    notes[k + 13 * size], notes[k + 14 * size] = e_y, e_psi
    notes[k + 15 * size], notes[k + 16 * size], notes[k + 17 * size] = w_x, w_y, w_z


_ROW = struct.Struct(f"{COLUMNS}d")


def into_rows(
    notes: Any, k: int, _size: int, x: float, y: float, psi: float, u: float, v: float, r: float,
    X: float, Y: float, Z: float, e_x: float, e_y: float, e_psi: float, c: float, s: float,
    w_x: float, w_y: float, w_z: float,
) -> None:  # fmt: skip
    """Write a state as a row of 18 numbers into a buffer: quicker in Python."""
    _ROW.pack_into(
        notes, k * _ROW.size, x, y, psi, u, v, r, X, Y, Z, c * X - s * Y, s * X + c * Y, Z,
        e_x, e_y, e_psi, w_x, w_y, w_z,
    )  # fmt: skip


def _make_lecture(evaluate: Function, write: Function, _: Jit) -> Function:
    """q_dot' = q_dot + dt q_ddot,  q' = q + dt q_dot + dt^2 q_ddot / 2: the lectures' step."""

    def loop(
        at: Any, going: Any, rising: Any, gains: Any, body: Any, wheels: Any, count: int,
        wraps: bool, dts: Any, start: Any, notes: Any,
    ) -> int:  # fmt: skip
        x, y, psi, u, v, r = start[0], start[1], start[2], start[3], start[4], start[5]
        c, s = math.cos(psi), math.sin(psi)
        x_dot, y_dot = c * u - s * v, s * u + c * v
        w_x = w_y = w_z = 0.0
        steps, width = len(dts), len(at) // 3
        for k in range(steps + 1):
            a_u, a_v, a_r, X, Y, Z, e_x, e_y, e_psi = evaluate(
                at, going, rising, k, width, gains, body, wheels, count, wraps,
                x, y, psi, u, v, r, x_dot, y_dot, c, s,
            )  # fmt: skip
            write(
                notes, k, steps + 1, x, y, psi, u, v, r, X, Y, Z, e_x, e_y, e_psi, c, s,
                w_x, w_y, w_z,
            )  # fmt: skip
            if k == steps:
                break
            dt = dts[k]
            half = 0.5 * dt * dt
            a_u, a_v = a_u - r * v, a_v + r * u
            x_ddot, y_ddot = c * a_u - s * a_v, s * a_u + c * a_v
            x, y, psi = (
                x + dt * x_dot + half * x_ddot,
                y + dt * y_dot + half * y_ddot,
                psi + dt * r + half * a_r,
            )
            r_0 = r
            x_dot, y_dot, r = x_dot + dt * x_ddot, y_dot + dt * y_ddot, r + dt * a_r
            if not abs(x_dot) + abs(y_dot) + abs(r) < ENDLESS:
                return k
            c, s = math.cos(psi), math.sin(psi)
            w_x, w_y, w_z = w_x + 0.5 * dt * u, w_y + 0.5 * dt * v, w_z + 0.5 * dt * r_0
            u, v = c * x_dot + s * y_dot, c * y_dot - s * x_dot
            w_x, w_y, w_z = w_x + 0.5 * dt * u, w_y + 0.5 * dt * v, w_z + 0.5 * dt * r
        return steps

    return loop


def _make_semi_implicit(evaluate: Function, write: Function, jit: Jit) -> Function:
    """Zeta' = zeta + dt zeta_dot, and the exact arc of the new twist zeta'."""
    arc = jit(se2.step)

    def loop(
        at: Any, going: Any, rising: Any, gains: Any, body: Any, wheels: Any, count: int,
        wraps: bool, dts: Any, start: Any, notes: Any,
    ) -> int:  # fmt: skip
        x, y, psi, u, v, r = start[0], start[1], start[2], start[3], start[4], start[5]
        c, s = math.cos(psi), math.sin(psi)
        w_x = w_y = w_z = 0.0
        steps, width = len(dts), len(at) // 3
        for k in range(steps + 1):
            a_u, a_v, a_r, X, Y, Z, e_x, e_y, e_psi = evaluate(
                at, going, rising, k, width, gains, body, wheels, count, wraps,
                x, y, psi, u, v, r, c * u - s * v, s * u + c * v, c, s,
            )  # fmt: skip
            write(
                notes, k, steps + 1, x, y, psi, u, v, r, X, Y, Z, e_x, e_y, e_psi, c, s,
                w_x, w_y, w_z,
            )  # fmt: skip
            if k == steps:
                break
            dt = dts[k]
            w_x += dt * (u + 0.5 * dt * a_u)
            w_y += dt * (v + 0.5 * dt * a_v)
            w_z += dt * (r + 0.5 * dt * a_r)
            u, v, r = u + dt * a_u, v + dt * a_v, r + dt * a_r
            if not abs(u) + abs(v) + abs(r) < ENDLESS:
                return k
            x, y, psi = arc(x, y, psi, dt * u, dt * v, dt * r)
            c, s = math.cos(psi), math.sin(psi)
        return steps

    return loop


def _make_rk4(evaluate: Function, write: Function, _: Jit) -> Function:
    """Return the loop of the classical Runge-Kutta method on pose and twist.

    The reference has rows at t_0, t_0 + dt / 2, t_1, ...: 2 T + 1 of them.
    """

    def loop(
        at: Any, going: Any, rising: Any, gains: Any, body: Any, wheels: Any, count: int,
        wraps: bool, dts: Any, start: Any, notes: Any,
    ) -> int:  # fmt: skip
        x, y, psi, u, v, r = start[0], start[1], start[2], start[3], start[4], start[5]
        w_x = w_y = w_z = 0.0
        steps, width = len(dts), len(at) // 3
        for k in range(steps + 1):
            j = 2 * k
            c, s = math.cos(psi), math.sin(psi)
            a_u, a_v, a_r, X, Y, Z, e_x, e_y, e_psi = evaluate(
                at, going, rising, j, width, gains, body, wheels, count, wraps,
                x, y, psi, u, v, r, c * u - s * v, s * u + c * v, c, s,
            )  # fmt: skip
            write(
                notes, k, steps + 1, x, y, psi, u, v, r, X, Y, Z, e_x, e_y, e_psi, c, s,
                w_x, w_y, w_z,
            )  # fmt: skip
            if k == steps:
                break
            dt = dts[k]
            # Sums of slopes with weights 1, 2, 2, 1, and the state at the next evaluation.
            d_x, d_y, d_psi = c * u - s * v, s * u + c * v, r
            d_u, d_v, d_r = a_u, a_v, a_r
            x_i, y_i, p_i, u_i, v_i, r_i = d_x, d_y, r, a_u, a_v, a_r
            for i in range(1, 4):
                h = dt if i == 3 else 0.5 * dt
                u_n, v_n, r_n = u + h * u_i, v + h * v_i, r + h * r_i
                if not abs(u_n) + abs(v_n) + abs(r_n) < ENDLESS:
                    return k
                p_n = psi + h * p_i
                c, s = math.cos(p_n), math.sin(p_n)
                x_n, y_n = c * u_n - s * v_n, s * u_n + c * v_n
                u_i, v_i, r_i, X, Y, Z, e_x, e_y, e_psi = evaluate(
                    at, going, rising, j + (2 if i == 3 else 1), width, gains, body, wheels,
                    count, wraps, x + h * x_i, y + h * y_i, p_n, u_n, v_n, r_n, x_n, y_n, c, s,
                )  # fmt: skip
                x_i, y_i, p_i = x_n, y_n, r_n
                weight = 1.0 if i == 3 else 2.0
                d_x, d_y, d_psi = d_x + weight * x_i, d_y + weight * y_i, d_psi + weight * p_i
                d_u, d_v, d_r = d_u + weight * u_i, d_v + weight * v_i, d_r + weight * r_i
            sixth = dt / 6.0
            x, y, psi = x + sixth * d_x, y + sixth * d_y, psi + sixth * d_psi
            w_x += dt * (u + 0.5 * sixth * d_u)
            w_y += dt * (v + 0.5 * sixth * d_v)
            w_z += dt * (r + 0.5 * sixth * d_r)
            u, v, r = u + sixth * d_u, v + sixth * d_v, r + sixth * d_r
        return steps

    return loop


_MAKERS = {"lecture": _make_lecture, "semi-implicit": _make_semi_implicit, "rk4": _make_rk4}
LOOPS = tuple(_MAKERS)
