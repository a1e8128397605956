"""Inverse kinematics: from a twist to wheel speeds and steering angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.errors import InfeasibleTwistError, ShapeError
from trundle.kinematics.angles import STANDSTILL, Steering
from trundle.kinematics.constraints import finite, gains, rolling_matrix, steering_array
from trundle.kinematics.curved import nearest_on_curve
from trundle.kinematics.linear import pseudo_inverse
from trundle.kinematics.maps import wheel_matrix
from trundle.kinematics.steering import motion_space
from trundle.robot import Robot
from trundle.se2 import Array, point_twist

# A twist that is met to nine digits is met.
_MET = 1e-9


@dataclass(frozen=True, eq=False)
class Inverse:
    """The answer of the inverse kinematics.

    Attributes:
        wheel_speeds: (..., n) [rad/s], motor signs, driven wheels in order.
        steering: (..., s) angles [rad], steered wheels in order.
        twist: (..., 3) the twist that these give, at the point that was asked for.
        residual: (..., 3) twist asked minus twist given.
    """

    wheel_speeds: Array
    steering: Array
    twist: Array
    residual: Array


def shift(about: npt.ArrayLike) -> tuple[Array, Array]:
    """Return the maps (3, 3) from a twist at a body point to the origin's, and back."""
    point = finite(about, "about", 2)
    if point.ndim != 1:
        raise ShapeError(f"about must be one point (x, y), got shape {point.shape}")
    basis = np.eye(3)
    return point_twist(basis, -point).T, point_twist(basis, point).T


class InverseSolver:
    """The inverse kinematics of one robot, with its constants computed once."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._gains = gains(robot.driven)
        self._max_speeds = np.array([w.max_speed or np.inf for w in robot.driven])
        self._rolling = rolling_matrix(robot, robot.driven, np.zeros(len(robot.steered)))
        self._steering = Steering.of(robot)
        if robot.steered:
            self._space, self._flat = motion_space(robot)
        else:
            _, can_give = wheel_matrix(robot, np.zeros(0))
            left, size, _ = np.linalg.svd(can_give)
            self._space, self._flat = left[:, size > 0.5], True
        # The projector onto the twists that some steering allows.
        self.feasible = self._nearest_map(np.eye(3), np.eye(3))

    def _nearest_map(self, to_origin: Array, to_point: Array) -> Array:
        """Return the map (3, 3) from a point's twist to the origin's that comes nearest to it."""
        space = to_point @ self._space
        return np.asarray(to_origin @ space @ pseudo_inverse(space.T)[0].T)

    def solve(
        self,
        twist: npt.ArrayLike,
        about: npt.ArrayLike = (0.0, 0.0),
        steering: npt.ArrayLike | None = None,
        strict: bool = False,
        limit: bool = True,
    ) -> Inverse:
        """Return wheel speeds and steering angles for a twist; see ``Kinematics.inverse``."""
        asked = finite(twist, "twist", 3)
        to_origin, to_point = shift(about)
        present = (
            None if steering is None else steering_array(self.robot, steering, asked.shape[:-1])
        )
        if self._flat:
            near, inputs = self._flat_answer(asked, to_origin, to_point, present, limit)
        else:
            near, inputs = self._curved_answer(asked, to_origin, to_point, present, limit)
        angles = inputs @ self._steering.coupling.T
        rolling = self._rolling
        if self.robot.steered:
            rolling = rolling_matrix(self.robot, self.robot.driven, angles)
            _, can_give = wheel_matrix(self.robot, angles)
            near = _without_noise((can_give @ near[..., None])[..., 0], asked)
            near = _best_multiple(near, asked @ to_origin.T, to_point)
        speeds = (rolling @ near[..., None])[..., 0] / self._gains
        if limit:
            scale = self._scale(speeds)
            speeds, near = scale * speeds, scale * near
        given = near @ to_point.T
        residual = asked - given
        rounding = STANDSTILL * np.abs(asked).max(axis=-1, keepdims=True, initial=0.0)
        given = np.where(np.abs(given) <= rounding, 0.0, given)
        residual = np.where(np.abs(residual) <= rounding, 0.0, residual)
        if strict:
            self._check(asked, residual, limit)
        return Inverse(speeds, angles, given, residual)

    def follow(self, twist: Array) -> Array:
        """Return steering angles (T, s) along feasible twists (T, 3) of the origin."""
        return self._steering.follow(twist) @ self._steering.coupling.T

    def _flat_answer(
        self, asked: Array, to_origin: Array, to_point: Array, present: Array | None, limit: bool
    ) -> tuple[Array, Array]:
        """Return the nearest feasible twist of the origin (..., 3) and the inputs (..., g)."""
        home = bool((to_point == np.eye(3)).all())
        nearest = self.feasible if home else self._nearest_map(to_origin, to_point)
        near = np.asarray(asked @ nearest.T)
        near = _without_noise(near, asked)
        if not self.robot.steered:
            return near, np.zeros((*asked.shape[:-1], 0))
        speed = np.abs(asked).max(axis=-1) * (1.0 + self.robot.reach)
        if present is not None:
            shape = np.broadcast_shapes(near.shape[:-1], present.shape[:-1])
            near = np.broadcast_to(near, (*shape, 3)).copy()
            present = np.broadcast_to(present, (*shape, present.shape[-1]))
        inputs, inside = self._steering.inputs(near, speed, present, limit)
        if not inside.all():
            asked = np.broadcast_to(asked, near.shape)
            for index in np.argwhere(~inside):
                at = tuple(index)
                near[at] = self._steering.nearest_in_range(
                    asked[at], to_point @ self._space, to_origin
                )
            inputs, _ = self._steering.inputs(near, speed, present, limit)
        return near, inputs

    def _curved_answer(
        self, asked: Array, to_origin: Array, to_point: Array, present: Array | None, limit: bool
    ) -> tuple[Array, Array]:
        steering = self._steering
        start = steering.inputs(asked @ to_origin.T, np.abs(asked).max(axis=-1), present, False)[0]
        near, inputs = np.empty((*start.shape[:-1], 3)), np.empty_like(start)
        asked = np.broadcast_to(asked, near.shape)
        far = np.full(len(steering.low), np.inf)
        low, high = (steering.low, steering.high) if limit else (-far, far)
        known: dict[bytes, tuple[Array, Array]] = {}  # held commands are searched for once
        for at in np.ndindex(near.shape[:-1]):
            key = asked[at].tobytes() + start[at].tobytes()
            if key not in known:
                known[key] = nearest_on_curve(self.robot, asked[at], to_point, start[at], low, high)
            inputs[at], near[at] = known[key]
        return near, inputs

    def _scale(self, speeds: Array) -> Array:
        if speeds.shape[-1] == 0:
            return np.ones((*speeds.shape[:-1], 1))
        over = np.abs(speeds) / self._max_speeds
        return np.asarray(1.0 / np.maximum(over.max(axis=-1, keepdims=True), 1.0))

    def _check(self, asked: Array, residual: Array, limit: bool) -> None:
        miss = np.abs(residual).max(axis=-1)
        if not (miss > _MET * np.abs(asked).max(axis=-1)).any():
            return
        worst = np.unravel_index(int(np.argmax(miss)), miss.shape)
        u, v, r = asked[worst]
        given = (asked[worst] - residual[worst]).round(12) + 0.0
        limits = " within its limits" if limit else ""
        raise InfeasibleTwistError(
            f"robot {self.robot.name!r} cannot have the twist (u, v, r) = ({u:g}, {v:g}, {r:g})"
            f"{limits}; the nearest that it can have is "
            f"({', '.join(f'{value:.6g}' for value in given)}): without strict that is the answer."
        )


def _without_noise(twist: Array, asked: Array) -> Array:
    """Return the twist, or standstill where it is rounding beside the twist asked."""
    largest = np.abs(asked).max(axis=-1, keepdims=True, initial=0.0)
    noise = (np.abs(twist) <= STANDSTILL * largest).all(axis=-1, keepdims=True)
    return np.where(noise, 0.0, twist)


def _best_multiple(twist: Array, asked: Array, to_point: Array) -> Array:
    """Return the multiple of a twist that is nearest, at the point, to the one asked.

    What no wheel drives is missing in the twist; the rest may then fit better larger or smaller.
    """
    given, wanted = twist @ to_point.T, asked @ to_point.T
    size = np.sum(given**2, axis=-1, keepdims=True)
    share = np.sum(given * wanted, axis=-1, keepdims=True) / np.where(size > 0, size, 1.0)
    return np.asarray(np.maximum(share, 0.0) * twist)
