"""Steering angles for a feasible twist: along the contact velocity, or half a turn from it."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from trundle.kinematics.constraints import stack
from trundle.kinematics.steering import contact_velocities, couplings
from trundle.robot import Robot
from trundle.se2 import Array, Mask

# Velocities below this share of the twist are rounding, and give no direction.
STANDSTILL = 1e-12
# Angles at a steering limit may exceed it by rounding.
_AT_LIMIT = 1e-9


@dataclass(frozen=True)
class Steering:
    """The steering inputs of a robot: which wheels each moves, and its range.

    Attributes:
        coupling: (s, g) with steering angles = coupling @ inputs.
        low, high: (g,) range of each input [rad] in which all its wheels keep their limits.
    """

    robot: Robot
    coupling: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, robot: Robot) -> Steering:
        """Return the steering inputs of a robot."""
        coupling = couplings(robot)
        low = np.full(coupling.shape[1], -np.inf)
        high = np.full(coupling.shape[1], np.inf)
        for row, wheel in zip(coupling, robot.steered, strict=True):
            j = int(np.flatnonzero(row)[0])
            ends = sorted(end / row[j] for end in wheel.steering_range)
            low[j], high[j] = max(low[j], ends[0]), min(high[j], ends[1])
        return cls(robot, coupling, low, high)

    def inputs(
        self, twist: Array, speed: Array, present: Array | None, limit: bool
    ) -> tuple[Array, Mask]:
        """Return the inputs (..., g) that point the wheels along a feasible twist.

        Args:
            twist: (..., 3) feasible twist of the origin.
            speed: (...,) size of the twist asked; far slower wheels stand still.
            present: (..., s) present angles: the nearer of each angle and its half-turn flip is
                taken, and wheels at standstill are held. Without them the angle is the
                velocity's, and 0 at standstill.
            limit: whether the steering limits count.

        Returns:
            The inputs, and whether (...,) all of them lie in their range.
        """
        angle, moving = self._directions(twist, speed)
        if present is None:
            angle = np.where(moving, angle, 0.0)
        else:
            turn = angle - present
            near = turn - np.pi * np.round(turn / np.pi)
            angle = np.where(moving, present + near, present)
        inputs = self._leaders(angle, moving)
        if not limit:
            return inputs, np.ones(inputs.shape[:-1], dtype=bool)
        return self._into_range(inputs, self._leaders(moving.astype(np.float64), moving) != 0)

    def follow(self, twist: Array) -> Array:
        """Return the inputs (T, g) along feasible twists (T, 3) in order of time.

        Each is the nearer of the velocity's angle and its half-turn flip to the one before, within
        its range; wheels at standstill are held, and stand at 0 before the first motion.
        """
        speed = (1.0 + self.robot.reach) * np.abs(twist).max(axis=-1, initial=0.0)
        angle, moving = self._directions(twist, speed)
        asked = self._leaders(angle, moving)
        moves = self._leaders(moving.astype(np.float64), moving) != 0
        out = np.empty_like(asked)
        for j, half in enumerate(self._half_turns):
            low, high = float(self.low[j]), float(self.high[j])
            now = min(max(0.0, low), high)
            angles, moved = asked[:, j].tolist(), moves[:, j].tolist()
            for k, angle in enumerate(angles):
                if moved[k]:
                    near = angle + half * round((now - angle) / half) if k else angle
                    now = _inside(near, half, low, high)
                out[k, j] = now
        return out

    def _directions(self, twist: Array, speed: Array) -> tuple[Array, Mask]:
        """Return each wheel's direction of motion (..., s), and whether it moves."""
        velocity = contact_velocities(self.robot, twist)
        noise = np.abs(velocity) <= STANDSTILL * speed[..., None, None]
        # Without noise, and with -0.0 made 0.0, straight back is +pi and standstill is 0.
        along, across = np.moveaxis(np.where(noise, 0.0, velocity) + 0.0, -1, 0)
        return np.asarray(np.arctan2(across, along)), np.asarray(~noise.all(axis=-1))

    @property
    def _half_turns(self) -> Array:
        """Half a turn of the wheels, as a change of each input (g,)."""
        return np.asarray(np.pi / np.abs(self.coupling).max(axis=0, initial=0.0))

    def _leaders(self, values: Array, moving: Mask) -> Array:
        """Return for each input the value of its first moving wheel, over the wheel's ratio."""
        out = np.empty((*values.shape[:-1], self.coupling.shape[1]))
        for j, column in enumerate(self.coupling.T):
            members = np.flatnonzero(column)
            first = np.argmax(moving[..., members], axis=-1)[..., None]
            chosen = np.take_along_axis(values[..., members] / column[members], first, axis=-1)
            out[..., j] = chosen[..., 0]
        return out

    def _into_range(self, inputs: Array, moving: Mask) -> tuple[Array, Mask]:
        low, high = self.low - _AT_LIMIT, self.high + _AT_LIMIT
        half = self._half_turns
        up = np.where(inputs < low, np.ceil((low - inputs) / half), 0.0)
        down = np.where(inputs > high, np.ceil((inputs - high) / half), 0.0)
        flipped = inputs + half * (up - down)
        inside = (flipped >= low) & (flipped <= high)
        kept = np.clip(np.where(inside & moving, flipped, inputs), self.low, self.high)
        return kept, np.asarray((inside | ~moving).all(axis=-1))

    def nearest_in_range(self, asked: Array, space: Array, to_origin: Array) -> Array:
        """Return the twist nearest to the one asked for which every wheel keeps its limits.

        A wheel's limits hold its contact velocity in a double wedge; for each choice of the sides
        this is the projection onto a convex cone, a non-negative least-squares problem.

        Args:
            asked: (3,) twist of the point that was asked for.
            space: (3, k) basis of the feasible twists of that point.
            to_origin: (3, 3) map from the point's twist to the origin's.

        Returns:
            (3,) twist of the origin.
        """
        from scipy.optimize import nnls

        base, _ = np.linalg.qr(space)
        target = base.T @ asked
        wedges = [wedge @ to_origin @ base for wedge in self._wedges()]
        best, least = np.zeros(len(target)), np.inf
        for signs in itertools.product((1.0, -1.0), repeat=len(wedges)):
            sides = np.concatenate([s * wedge for s, wedge in zip(signs, wedges, strict=True)])
            # Moreau: the projection is the target less its part in the polar cone.
            weights, _ = nnls(-sides.T, target)
            point = target + sides.T @ weights
            miss = float(np.linalg.norm(point - target))
            if miss < least - _AT_LIMIT * float(np.linalg.norm(target)):
                best, least = point, miss
        return np.asarray(to_origin @ base @ best)

    def _wedges(self) -> list[Array]:
        """Return for each limited wheel the two rows (2, 3) that are >= 0 inside its wedge."""
        wedges = []
        for row, wheel in zip(self.coupling, self.robot.steered, strict=True):
            j = int(np.flatnonzero(row)[0])
            low, high = sorted((row[j] * self.low[j], row[j] * self.high[j]))
            if high - low < np.pi:
                left, right = wheel.rows(low).side_slip, wheel.rows(high).side_slip
                wedges.append(stack([left or (), [-c for c in right or ()]], ()))
        return wedges


def _inside(angle: float, half: float, low: float, high: float) -> float:
    """Return the angle, or its nearest half-turn flip, inside a range."""
    if angle < low - _AT_LIMIT:
        angle += half * math.ceil((low - _AT_LIMIT - angle) / half)
    elif angle > high + _AT_LIMIT:
        angle -= half * math.ceil((angle - high - _AT_LIMIT) / half)
    return min(max(angle, low), high)
