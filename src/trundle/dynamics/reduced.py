"""The equations of motion on the twists that the wheels allow.

    M zeta_dot + c(zeta) + G^T friction = G_d^T tau + C^T lambda,    C zeta = 0,    omega = G zeta

with G = R^-1 A of all wheels that roll and G_d of the driven ones. M holds the spinning wheels:
``M = M_body + G^T J G``. Steering angles that change at rates beta_dot turn the rows of C and G.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.dynamics.friction import coefficients, friction_torque
from trundle.dynamics.planar import body_bias
from trundle.kinematics import gains, motion_projector, rolling_matrix, side_slip_matrix
from trundle.robot import Robot, RollingWheel, total_mass
from trundle.se2 import Array

# Side-slip rows that repeat each other share their force evenly; a row counts as a repetition when
# it adds less than this to the strongest. Angles from files agree to about 1e-12.
REPEATED = 1e-9


def body_mass_matrix(mass: float, com: Array, inertia: float) -> Array:
    """Return M (3, 3) of a rigid body in the body frame, about its origin."""
    x, y = com
    return mass * np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [-y, x, x * x + y * y + inertia / mass]])


def rolling_wheels(robot: Robot) -> tuple[RollingWheel, ...]:
    """Return the wheels whose turning follows from the twist, driven or not, in order."""
    return tuple(wheel for wheel in robot.wheels if isinstance(wheel, RollingWheel))


class Reduced(NamedTuple):
    """The robot at steering angles (..., s) that change at given rates; w wheels roll, m hold."""

    M: Array  # (..., 3, 3) with the spin of all wheels
    M_free: Array  # (..., 3, 3) with the spin of those that no motor drives
    allowed: Array  # (..., 3, 3) projector N N^T onto the twists that the wheels allow
    G: Array  # (..., w, 3) wheel speeds from the twist [rad/m, rad/m, 1]
    G_dot: Array  # (..., w, 3)
    C: Array  # (..., m, 3) side-slip rows
    C_dot: Array  # (..., m, 3)
    driven: Array  # (w,) mask of the driven wheels among the rolling ones
    spin: Array  # (w,) inertia about the axles [kg m^2]

    def push(self, torques: Array) -> Array:
        """Return G_d^T tau (..., 3): the force on the body of motor torques (..., n)."""
        return apply(np.swapaxes(self.G[..., self.driven, :], -1, -2), torques)

    def allocation(self) -> Array:
        """Return (N^T G_d^T)^+ N^T (..., n, 3): torques of least norm for a force on the body."""
        pushing = self.allowed @ np.swapaxes(self.G[..., self.driven, :], -1, -2)
        return np.asarray(np.linalg.pinv(pushing, rcond=REPEATED) @ self.allowed)

    def inverse(self) -> Array:
        """Return N (N^T M N)^-1 N^T (..., 3, 3): from forces to the accelerations they cause."""
        inside = self.allowed @ self.M @ self.allowed + (np.eye(3) - self.allowed)
        return np.asarray(self.allowed @ np.linalg.solve(inside, self.allowed))

    def turning(self, twist: Array) -> Array:
        """Return the acceleration (..., 3) that turning wheels alone ask for: -C^+ C_dot zeta."""
        if not self.C_dot.any():
            return np.zeros_like(twist)
        asked = -apply(self.C_dot, twist)
        return apply(np.asarray(np.linalg.pinv(self.C, rcond=REPEATED)), asked)

    def bias(self, twist: Array, own: Array, friction: Array) -> Array:
        """Return all forces (..., 3) but inertia's and the motors'.

        Args:
            twist: (..., 3) body twist.
            own: (..., 3) c(zeta) of the rigid body.
            friction: (..., w) friction torques [N m].
        """
        turned = self.spin * apply(self.G_dot, twist)
        return own + apply(np.swapaxes(self.G, -1, -2), turned + friction)


def reduce(robot: Robot, steering: Array, steering_rate: Array) -> Reduced:
    """Return the reduced equations at steering angles (..., s) and rates (..., s)."""
    wheels = rolling_wheels(robot)
    total = total_mass(robot)
    rate = np.broadcast_to(steering_rate, np.broadcast_shapes(steering.shape, steering_rate.shape))
    angles = np.broadcast_to(steering, rate.shape)
    along = rolling_matrix(robot, wheels, angles)
    G = along / gains(wheels)[:, None]
    spin = np.array([wheel.spin_inertia for wheel in wheels])
    driven = np.array([wheel.driven for wheel in wheels], dtype=bool)
    of_body = body_mass_matrix(total.mass, total.com, total.inertia)
    G_dot, C_dot = _turned_rows(robot, wheels, angles, rate)
    return Reduced(
        M=of_body + _felt(G, spin),
        M_free=of_body + _felt(G, np.where(driven, 0.0, spin)),
        allowed=motion_projector(robot, angles)[0],
        G=G,
        G_dot=G_dot,
        C=side_slip_matrix(robot, robot.wheels, angles),
        C_dot=C_dot,
        driven=driven,
        spin=spin,
    )


def _felt(G: Array, spin: Array) -> Array:
    """Return G^T J G: spinning wheels as the body feels them."""
    return np.asarray(np.swapaxes(G, -1, -2) @ (spin[:, None] * G))


def _turned_rows(
    robot: Robot, wheels: tuple[RollingWheel, ...], angles: Array, rate: Array
) -> tuple[Array, Array]:
    """Return the time derivatives of G and C: a rolling row turns into its side-slip row.

    d/dbeta of the rolling row is the side-slip row, and of the side-slip row minus the rolling row.
    """
    holding = [wheel for wheel in robot.wheels if wheel.rows().side_slip is not None]
    along = rolling_matrix(robot, holding, angles)
    across = side_slip_matrix(robot, holding, angles)
    G_dot = np.zeros((*angles.shape[:-1], len(wheels), 3))
    C_dot = np.zeros_like(across)
    for i, steered in enumerate(robot.steered):
        k, w = holding.index(steered), wheels.index(steered)
        turn = rate[..., i, None]
        C_dot[..., k, :] = -turn * along[..., k, :]
        G_dot[..., w, :] = turn * across[..., k, :] / gains([steered])[0]
    return G_dot, C_dot


def apply(matrix: Array, vector: Array) -> Array:
    """Return matrix (..., k, j) times vector (..., j)."""
    return np.asarray((matrix @ vector[..., None])[..., 0])


def rigid_bias(mass: float, com: Array, twist: Array) -> Array:
    """Return c(zeta) (..., 3) of the rigid body at twists (..., 3)."""
    u, v, r = np.moveaxis(twist, -1, 0)
    return np.stack(body_bias(mass, com[0], com[1], u, v, r), axis=-1)


def friction_of(wheels: tuple[RollingWheel, ...], speeds: Array) -> Array:
    """Return the friction torques (..., w) [N m] at wheel speeds (..., w)."""
    viscous, coulomb = coefficients(wheels)
    return np.asarray(friction_torque(viscous, coulomb, speeds, np.sqrt))
