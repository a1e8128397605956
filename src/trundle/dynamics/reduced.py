"""The equations of motion on the twists that the wheels allow.

    M zeta_dot + c(zeta) + G^T friction = G_d^T tau + C^T lambda,    C zeta = 0,    omega = G zeta

with G = R^-1 A of all wheels that roll and G_d of the driven ones. M holds the spinning wheels:
``M = M_body + G^T J G``. Steering angles that change turn the rows of C; those of G turn too, but
into side-slip rows, which are zero on every twist that holds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.dynamics.friction import coefficients, friction_torque
from trundle.dynamics.planar import body_bias
from trundle.errors import TrundleError
from trundle.kinematics import (
    abreast,
    gains,
    motion_projector,
    rolling_matrix,
    side_slip_matrix,
    skid_matrices,
)
from trundle.robot import Robot, RollingWheel, total_mass
from trundle.se2 import Array

# Side-slip rows that repeat each other share their force evenly; a row counts as a repetition when
# it adds less than this to the strongest, and what pushes less is rounding. Angles from files agree
# to about 1e-12.
REPEATED = 1e-9


def body_mass_matrix(mass: float, com: Array, inertia: float) -> Array:
    """Return M (..., 3, 3) of rigid bodies in the body frame, about its origin."""
    x, y = np.moveaxis(com, -1, 0)
    M = np.zeros((*x.shape, 3, 3))
    M[..., 0, 0] = M[..., 1, 1] = mass
    M[..., 0, 2] = M[..., 2, 0] = -mass * y
    M[..., 1, 2] = M[..., 2, 1] = mass * x
    M[..., 2, 2] = mass * (x * x + y * y + inertia / mass)
    return M


def rolling_wheels(robot: Robot) -> tuple[RollingWheel, ...]:
    """Return the wheels whose turning follows from the twist, driven or not, in order."""
    return tuple(wheel for wheel in robot.wheels if isinstance(wheel, RollingWheel))


class Reduced(NamedTuple):
    """The robot at steering angles (..., s) that change at given rates; w wheels roll, m hold."""

    M: Array  # (..., 3, 3) with the spin of all wheels
    M_free: Array  # (..., 3, 3) with the spin of those that no motor drives
    allowed: Array  # (..., 3, 3) projector N N^T onto the twists that the wheels allow
    G: Array  # (..., w, 3) wheel speeds from the twist [rad/m, rad/m, 1]
    holding: Array  # (..., m, 3) rows along which wheels take side forces
    turn: Array  # (..., 3, 3) accelerations that turning wheels ask for, from the twist [1/s]
    driven: Array  # (w,) mask of the driven wheels among the rolling ones
    spin: Array  # (w,) inertia about the axles [kg m^2]

    @property
    def G_d(self) -> Array:
        """The rows (..., n, 3) of G of the driven wheels."""
        return np.asarray(self.G[..., self.driven, :])

    def push(self, torques: Array) -> Array:
        """Return G_d^T tau (..., 3): the force on the body of motor torques (..., n)."""
        return apply(np.swapaxes(self.G_d, -1, -2), torques)

    def _inside(self) -> Array:
        """Return M on the twists that the wheels allow, and apart from it on the others."""
        others = np.eye(3) - self.allowed
        return np.asarray(self.allowed @ self.M @ self.allowed + others @ self.M @ others)

    def inverse(self) -> Array:
        """Return N (N^T M N)^-1 N^T (..., 3, 3): from forces to the accelerations they cause."""
        return np.asarray(self.allowed @ np.linalg.solve(self._inside(), self.allowed))

    def allocation(self) -> Array:
        """Return (N^T G_d^T)^+ N^T (..., n, 3): torques of least norm for a force on the body.

        Where the motors cannot give the whole force, they give the acceleration that is nearest
        in kinetic energy (Gauss's principle), which does not depend on units or on the origin.
        """
        # In the coordinates L^T zeta, with M = L L^T, kinetic energy is a sum of squares.
        to_even = np.linalg.inv(np.linalg.cholesky(self._inside()))
        everywhere = to_even @ np.swapaxes(self.G_d, -1, -2)
        pushing = to_even @ self.allowed @ np.swapaxes(self.G_d, -1, -2)
        inverse = _inverted(pushing, np.linalg.norm(everywhere, axis=(-2, -1)))
        return np.asarray(inverse @ to_even @ self.allowed)

    def bias(self, own: Array, friction: Array) -> Array:
        """Return all forces (..., 3) but inertia's and the motors'.

        Args:
            own: (..., 3) c(zeta) of the rigid body.
            friction: (..., w) friction torques [N m].
        """
        return own + apply(np.swapaxes(self.G, -1, -2), friction)


def _inverted(matrix: Array, size: Array) -> Array:
    """Return the pseudo-inverse of (..., k, n), without what is rounding beside a size (...,).

    Raises:
        TrundleError: a number in it is beyond the largest float.
    """
    if not np.isfinite(matrix).all():
        raise TrundleError(
            "the inertia is beyond the range of numbers: check mass, inertia and com of body "
            "and wheels"
        )
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    kept = values > REPEATED * np.maximum(size[..., None], values[..., :1])
    scaled = np.where(kept, 1.0, 0.0) / np.where(kept, values, 1.0)
    return np.asarray(np.swapaxes(right, -1, -2) @ (scaled[..., None] * np.swapaxes(left, -1, -2)))


def reduce(robot: Robot, steering: Array, steering_rate: Array) -> Reduced:
    """Return the reduced equations at steering angles (..., s) and rates (..., s)."""
    wheels = rolling_wheels(robot)
    total = total_mass(robot)
    rate = np.broadcast_to(steering_rate, np.broadcast_shapes(steering.shape, steering_rate.shape))
    angles = np.broadcast_to(steering, rate.shape)
    G = rolling_matrix(robot, wheels, angles) / gains(wheels)[..., None]
    spin = abreast([wheel.spin_inertia for wheel in wheels])
    driven = np.array([wheel.driven for wheel in wheels], dtype=bool)
    of_body = body_mass_matrix(total.mass, total.com, total.inertia)
    allowed = motion_projector(robot, angles)[0]
    slip = side_slip_matrix(robot, robot.wheels, angles)
    _, skid = skid_matrices(robot, angles.shape[:-1])
    return Reduced(
        M=of_body + _felt(G, spin),
        M_free=of_body + _felt(G, np.where(driven, 0.0, spin)),
        allowed=allowed,
        G=G,
        holding=np.concatenate([slip, skid], axis=-2),
        turn=_turn(robot, angles, rate, allowed),
        driven=driven,
        spin=spin,
    )


def holding_wheels(robot: Robot) -> list[int]:
    """Return which wheels take side forces, in the order of ``Reduced.holding``."""
    rows = [wheel.rows() for wheel in robot.wheels]
    slip = [i for i, row in enumerate(rows) if row.side_slip is not None]
    return slip + [i for i, row in enumerate(rows) if row.skid is not None]


def _felt(G: Array, spin: Array) -> Array:
    """Return G^T J G: spinning wheels as the body feels them."""
    return np.asarray(np.swapaxes(G, -1, -2) @ (spin[..., None] * G))


# Change of the steering angles [rad] over which the condition of skidding wheels is differenced.
_NUDGE = 1e-4


def _turn(robot: Robot, angles: Array, rate: Array, allowed: Array) -> Array:
    """Return T (..., 3, 3), so that turning wheels alone ask for the acceleration T zeta.

    ``T = -C^+ C_dot``: the side-slip row of a steered wheel turns into minus its rolling row.
    """
    if not rate.any():
        return np.zeros_like(allowed)
    if len(skid_matrices(robot)[0]):
        return _turn_by_difference(robot, angles, rate, allowed)
    C = side_slip_matrix(robot, robot.steered, angles)
    C_dot = -rate[..., None] * rolling_matrix(robot, robot.steered, angles)
    others = [wheel for wheel in robot.wheels if not wheel.steers]
    fixed = side_slip_matrix(robot, others, angles)
    rows = np.concatenate([C, fixed], axis=-2)
    change = np.concatenate([C_dot, np.zeros_like(fixed)], axis=-2)
    return np.asarray(-np.linalg.pinv(rows, rcond=REPEATED) @ change)


def _turn_by_difference(robot: Robot, angles: Array, rate: Array, allowed: Array) -> Array:
    """Return (1 - P) P_dot of the projector P: skidding wheels hold by a condition, not by rows."""
    step = _NUDGE / float(np.abs(rate).max())
    later, before = (
        motion_projector(robot, angles + sign * step * rate)[0] for sign in (1.0, -1.0)
    )
    return np.asarray((np.eye(3) - allowed) @ (later - before) / (2 * step))


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
