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

from trundle.dynamics import body_bias, friction_torque

# A law is made by a function of the compiler, as all functions here are. It takes its constants,
# the error (3), the error's rate (3), the desired acceleration (3), cosine and sine of the heading
# and the twist (3), all in scalars, and returns the force on the body (X, Y, Z) in the body frame.
Function = Callable[..., Any]
Jit = Callable[[Any], Any]
Law = Callable[[Jit], Function]

PER_WHEEL = 11  # numbers that describe a wheel to the function of `make_ground`
TURN = 2 * math.pi


def make_ground(jit: Jit) -> Function:
    """Return the function from the force commanded to the force that arrives (body frame).

    Each wheel takes its share of torque, its motor cuts it off, friction eats some of it.
    """
    friction = jit(friction_torque)

    def ground(
        wheels: Any, count: int, X: float, Y: float, Z: float, u: float, v: float, r: float
    ) -> tuple[float, float, float]:
        left_x = left_y = left_z = 0.0
        for i in range(count):
            j = PER_WHEEL * i
            g_x, g_y, g_z = wheels[j + 3], wheels[j + 4], wheels[j + 5]
            largest, stall = wheels[j + 6], wheels[j + 7]
            omega = g_x * u + g_y * v + g_z * r
            back = wheels[j + 8] * omega
            torque = wheels[j] * X + wheels[j + 1] * Y + wheels[j + 2] * Z
            torque = min(max(torque, -stall - back), stall - back)
            torque = min(max(torque, -largest), largest)
            torque -= friction(wheels[j + 9], wheels[j + 10], omega, math.sqrt)
            left_x += g_x * torque
            left_y += g_y * torque
            left_z += g_z * torque
        return left_x, left_y, left_z

    return ground


def make_evaluate(law: Law, hindered: bool, jit: Jit) -> Function:
    """Return the function that evaluates the closed loop at one state.

    It takes desired position, velocity and acceleration (each three columns of so many numbers,
    one after the other), which of them and how many, the constants of law, body and wheels, whether
    heading errors are wrapped, pose, twist, (x_dot, y_dot) in the inertial frame, cosine and sine
    of the heading. It returns acceleration (3) and commanded force (3) in the body frame, and the
    error (3). The acceleration is ``P (F - c(zeta))`` with P = N (N^T M N)^-1 N^T; ``body`` holds
    mass, centre of mass and the six numbers of P.

    Args:
        law: the control law.
        hindered: whether limits and friction stand between command and body.
        jit: the compiler.
    """
    command, bias = jit(law(jit)), jit(body_bias)
    ground = jit(make_ground(jit)) if hindered else None

    def evaluate(
        at: Any, going: Any, rising: Any, j: int, size: int, gains: Any, body: Any, wheels: Any,
        count: int, wraps: bool, x: float, y: float, psi: float, u: float, v: float, r: float,
        x_dot: float, y_dot: float, c: float, s: float,
    ) -> Any:  # fmt: skip
        k = j + size
        i = k + size
        e_x, e_y, e_psi = at[j] - x, at[k] - y, at[i] - psi
        if wraps and not -math.pi < e_psi <= math.pi:
            e_psi -= TURN * math.ceil((e_psi - math.pi) / TURN)
        X, Y, Z = command(
            gains, e_x, e_y, e_psi, going[j] - x_dot, going[k] - y_dot, going[i] - r,
            rising[j], rising[k], rising[i], c, s, u, v, r,
        )  # fmt: skip
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
            X, Y, Z, e_x, e_y, e_psi,
        )  # fmt: skip

    return evaluate
