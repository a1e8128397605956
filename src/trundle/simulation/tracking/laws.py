"""The closed loop at one state, in plain scalars: error, control law, motors, body.

Everything here is written once and read twice: by Python's floats for short runs, and by numba,
where it is installed, for long ones. Each ``make`` function takes the compiler, or nothing, and
returns a function; constants come as flat sequences, so that one compiled loop serves every robot,
gain and trajectory.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from trundle.dynamics import SLOW, body_bias, friction_torque
from trundle.simulation.arithmetic import PLAIN, Arithmetic, Function, Jit

# A law is made by a function of the compiler, as all functions here are. It takes its constants,
# the error (3), the error's rate (3), the desired acceleration (3), cosine and sine of the heading
# and the twist (3), all in scalars, and returns the force on the body (X, Y, Z) in the body frame.
Law = Callable[[Jit], Function]

PER_WHEEL = 11  # numbers that describe a wheel to the function of `make_ground`
TURN = 2 * math.pi


def make_wheel(m: Arithmetic, jit: Jit) -> Function:
    """Return the function from the force commanded to what one wheel lets arrive (body frame).

    The wheel takes its share of torque, its motor cuts it off, friction eats some of it. Its
    numbers begin at j.
    """
    slow = m.number(SLOW)
    friction, sqrt, least, most = jit(friction_torque), m.sqrt, m.minimum, m.maximum

    def wheel(
        wheels: Any, j: int, X: Any, Y: Any, Z: Any, u: Any, v: Any, r: Any
    ) -> tuple[Any, Any, Any]:
        g_x, g_y, g_z = wheels[j + 3], wheels[j + 4], wheels[j + 5]
        largest, stall = wheels[j + 6], wheels[j + 7]
        omega = g_x * u + g_y * v + g_z * r
        back = wheels[j + 8] * omega
        torque = wheels[j] * X + wheels[j + 1] * Y + wheels[j + 2] * Z
        torque = least(most(torque, -stall - back), stall - back)
        torque = least(most(torque, -largest), largest)
        torque = torque - friction(wheels[j + 9], wheels[j + 10], omega, sqrt, slow)
        return g_x * torque, g_y * torque, g_z * torque

    return wheel


def make_ground(jit: Jit) -> Function:
    """Return the function from the force commanded to the force that arrives (body frame)."""
    wheel = jit(make_wheel(PLAIN, jit))

    def ground(
        wheels: Any, count: int, X: float, Y: float, Z: float, u: float, v: float, r: float
    ) -> tuple[float, float, float]:
        left_x = left_y = left_z = 0.0
        for i in range(count):
            x, y, z = wheel(wheels, PER_WHEEL * i, X, Y, Z, u, v, r)
            left_x, left_y, left_z = left_x + x, left_y + y, left_z + z
        return left_x, left_y, left_z

    return ground


def shorter(error: float) -> float:
    """Return a heading error in (-pi, pi], which is the shorter way round."""
    if -math.pi < error <= math.pi:
        return error
    return error - TURN * math.ceil((error - math.pi) / TURN)


def make_shorter(m: Arithmetic, jit: Jit) -> Function:
    """Return ``shorter`` without a branch."""
    floor, pi, turn = m.floor, m.number(math.pi), m.number(TURN)
    return jit(lambda error: error + turn * floor((pi - error) / turn))


def make_respond(law: Law, ground: Function | None, jit: Jit) -> Function:
    """Return the function from an error to what the closed loop does about it.

    It takes the law's constants, those of body and wheels and the wheels' count, error, error's
    rate and desired acceleration (3 each, inertial frame), cosine and sine of the heading, and the
    twist. It returns acceleration (3) and commanded force (3) in the body frame. The acceleration
    is ``P (F - c(zeta))`` with P = N (N^T M N)^-1 N^T; ``body`` holds mass, centre of mass and the
    six numbers of P.

    Args:
        law: the control law.
        ground: what stands between command and body, limits and friction, or None.
        jit: the compiler.
    """
    command, bias = jit(law(jit)), jit(body_bias)

    def respond(
        gains: Any, body: Any, wheels: Any, count: int, e_x: Any, e_y: Any, e_psi: Any,
        d_x: Any, d_y: Any, d_psi: Any, a_x: Any, a_y: Any, a_psi: Any, c: Any, s: Any,
        u: Any, v: Any, r: Any,
    ) -> Any:  # fmt: skip
        X, Y, Z = command(gains, e_x, e_y, e_psi, d_x, d_y, d_psi, a_x, a_y, a_psi, c, s, u, v, r)
        if ground is None:
            F_x, F_y, F_z = X, Y, Z
        else:
            F_x, F_y, F_z = ground(wheels, count, X, Y, Z, u, v, r)
        b_x, b_y, b_z = bias(body[0], body[1], body[2], u, v, r)
        F_x, F_y, F_z = F_x - b_x, F_y - b_y, F_z - b_z
        return (
            body[3] * F_x + body[4] * F_y + body[5] * F_z,
            body[4] * F_x + body[6] * F_y + body[7] * F_z,
            body[5] * F_x + body[7] * F_y + body[8] * F_z,
            X, Y, Z,
        )  # fmt: skip

    return respond


def make_evaluate(law: Law, hindered: bool, jit: Jit) -> Function:
    """Return the function that evaluates the closed loop at one state.

    It takes desired position, velocity and acceleration (each three columns of so many numbers,
    one after the other), which of them and how many, the constants of law, body and wheels, whether
    heading errors are wrapped, pose, twist, (x_dot, y_dot) in the inertial frame, cosine and sine
    of the heading. It returns acceleration (3) and commanded force (3) in the body frame, and the
    error (3).

    Args:
        law: the control law.
        hindered: whether limits and friction stand between command and body.
        jit: the compiler.
    """
    ground = jit(make_ground(jit)) if hindered else None
    respond, wrapped = jit(make_respond(law, ground, jit)), jit(shorter)

    def evaluate(
        at: Any, going: Any, rising: Any, j: int, size: int, gains: Any, body: Any, wheels: Any,
        count: int, wraps: bool, x: float, y: float, psi: float, u: float, v: float, r: float,
        x_dot: float, y_dot: float, c: float, s: float,
    ) -> Any:  # fmt: skip
        k = j + size
        i = k + size
        e_x, e_y, e_psi = at[j] - x, at[k] - y, at[i] - psi
        if wraps:
            e_psi = wrapped(e_psi)
        a_u, a_v, a_r, X, Y, Z = respond(
            gains, body, wheels, count, e_x, e_y, e_psi, going[j] - x_dot, going[k] - y_dot,
            going[i] - r, rising[j], rising[k], rising[i], c, s, u, v, r,
        )  # fmt: skip
        return a_u, a_v, a_r, X, Y, Z, e_x, e_y, e_psi

    return evaluate
