"""Wheel speeds and steering angles of one robot for a control loop: plain floats, with limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from math import atan2, cos, floor, hypot, pi, sin

import numpy as np

from trundle.bridge.units import Numbers
from trundle.errors import TrundleError
from trundle.kinematics import (
    Code,
    Kinematics,
    gains,
    motion_space,
    rolling_matrix,
    side_slip_matrix,
)
from trundle.limits import Twist, per, steering_inputs
from trundle.robot import Robot
from trundle.se2 import Array

_TWIST = ("u", "v", "r")
# Digits of a projection, whose entries are at most 1, before rounding.
_DIGITS = 14
# A contact that moves slower than this share of the twist has no direction.
_STANDS = 1e-12
# Angles at a steering limit may exceed it by rounding [rad].
_AT_LIMIT = 1e-9


def feasible_map(robot: Robot) -> Array:
    """Return the map (3, 3) from a twist to the nearest one that some steering allows.

    Raises:
        TrundleError: linked steering allows a curved set of twists only.
    """
    if robot.steered and not motion_space(robot)[1]:
        raise TrundleError(
            f"robot {robot.name!r}: its linked steering allows only a curved set of twists, for "
            "which there are no closed formulas; link wheels with steering_ratio 1 or -1 so that "
            "they share a centre at every angle, or steer them alone"
        )
    return Kinematics(robot).feasible.round(_DIGITS)


def _program(name: str, matrix: Array) -> Callable[..., tuple[float, ...]]:
    """Return the function (u, v, r) -> ``matrix @ (u, v, r)``."""
    code = Code()
    return code.program(name, _TWIST, code.linear(matrix, _TWIST)).compile()


def _into_range(angle: float, low: float, high: float) -> float | None:
    """Return the angle, or its nearest half-turn flip, inside a range, or None."""
    if angle < low - _AT_LIMIT:
        angle += pi * math.ceil((low - _AT_LIMIT - angle) / pi)
    elif angle > high + _AT_LIMIT:
        angle -= pi * math.ceil((angle - high - _AT_LIMIT) / pi)
    if not low - _AT_LIMIT <= angle <= high + _AT_LIMIT:
        return None
    return min(max(angle, low), high)


class Wheels:
    """The wheels of one robot in plain floats; twists are feasible, as ``project`` makes them.

    Raises:
        TrundleError: linked steering for which there are no closed formulas.
    """

    def __init__(self, robot: Robot) -> None:
        feasible = feasible_map(robot)
        every = bool((feasible == np.eye(3)).all())
        self._project = None if every else _program("project", feasible)
        self.inputs = steering_inputs(robot)
        straight = np.zeros(len(robot.steered))
        along = rolling_matrix(robot, robot.steered, straight)
        across = side_slip_matrix(robot, robot.steered, straight)
        # (u, v, r) -> velocities of the steered contacts [m/s]: all along their zeros, all across.
        self._contacts = _program("contacts", np.concatenate([along, across]))
        plain = [wheel for wheel in robot.driven if not wheel.steers]
        rows = rolling_matrix(robot, plain, straight) / gains(plain)[:, None]
        self._plain = _program("speeds", rows)
        self._plain_limits = tuple((per(w.max_speed), per(w.max_acceleration)) for w in plain)
        turning = [w for w in robot.steered if w.driven]
        self._turning = tuple(
            (i, 1.0 / w.rows().gain, per(w.max_speed), per(w.max_acceleration))
            for i, w in enumerate(robot.steered)
            if w.driven
        )
        order = [wheel.name for wheel in (*plain, *turning)]
        self._order = tuple(order.index(wheel.name) for wheel in robot.driven)
        self._count = len(robot.steered)
        self._alone = all(each.members == ((i, 1.0),) for i, each in enumerate(self.inputs))
        self.limits_speed = any(wheel.max_speed for wheel in robot.driven)
        self.limits_steering = any(
            math.isfinite(i.low) or math.isfinite(i.high) for i in self.inputs
        )
        self.limits_acceleration = any(wheel.max_acceleration for wheel in robot.driven)

    def project(self, twist: Twist) -> Twist:
        """Return the nearest twist that some steering allows."""
        if self._project is None:
            return twist
        u, v, r = self._project(*twist)
        return u, v, r

    def speeds(self, twist: Twist, angles: Numbers) -> Numbers:
        """Return the driven wheels' speeds [rad/s] at a twist and steering angles [rad]."""
        plain = self._plain(*twist)
        if not self._turning:
            return plain
        contact, count = self._contacts(*twist), self._count
        found = list(plain)
        for i, per_gain, _, _ in self._turning:
            angle = angles[i]
            found.append((contact[i] * cos(angle) + contact[count + i] * sin(angle)) * per_gain)
        return tuple([found[i] for i in self._order]) if plain else tuple(found)

    def share(self, twist: Twist) -> float:
        """Return how much of the wheels' largest speeds a twist takes: above 1 it is too fast."""
        return self._largest(twist, 0) if self.limits_speed else 0.0

    def time(self, change: Twist) -> float:
        """Return the time [s] that a change of twist takes at the wheels' accelerations at least.

        Steered wheels count with the whole change of their contact's velocity.
        """
        return self._largest(change, 1) if self.limits_acceleration else 0.0

    def _largest(self, twist: Twist, which: int) -> float:
        """Return the largest wheel speed over its limit: 0 of speed, 1 of acceleration."""
        largest = 0.0
        for speed, each in zip(self._plain(*twist), self._plain_limits, strict=True):
            largest = max(largest, abs(speed) * each[which])
        if self._turning:
            contact, count = self._contacts(*twist), self._count
            for i, per_gain, *limits in self._turning:
                rim = hypot(contact[i], contact[count + i])
                largest = max(largest, rim * abs(per_gain) * limits[which])
        return largest

    def aim(self, twist: Twist, steering: Numbers) -> Numbers | None:
        """Return the inputs [rad] along a twist, nearest to the present ones, or None.

        Each takes the angle of its fastest wheel, or a half turn from it, within its range; where
        no wheel moves, it stays. None: no such angle lies in the range of some input.
        """
        still = _STANDS * (abs(twist[0]) + abs(twist[1]) + abs(twist[2]))
        contact, count = self._contacts(*twist), self._count
        found = []
        for present, (members, low, high, _) in zip(steering, self.inputs, strict=True):
            fastest, angle = still * still, present
            for i, ratio in members:
                a, b = contact[i], contact[count + i]
                speed = a * a + b * b
                if speed > fastest:
                    fastest, angle = speed, ratio * atan2(b, a)
            angle += pi * floor((present - angle) / pi + 0.5)
            if not low <= angle <= high:
                inside = _into_range(angle, low, high)
                if inside is None:
                    return None
                angle = inside
            found.append(angle)
        return tuple(found)

    def angles(self, steering: Numbers) -> Numbers:
        """Return the steering angles [rad] of inputs [rad]."""
        if not steering:
            return ()
        if self._alone:
            return steering
        angles = [0.0] * self._count
        for value, each in zip(steering, self.inputs, strict=True):
            for i, ratio in each.members:
                angles[i] = ratio * value
        return tuple(angles)

    def inputs_of(self, angles: Numbers) -> Numbers:
        """Return the inputs [rad] of steering angles [rad]: of each group its first wheel's."""
        firsts = (each.members[0] for each in self.inputs)
        return tuple(ratio * angles[i] for i, ratio in firsts)

    def ends(self, twist: Twist) -> list[float]:
        """Return the shares of the yaw rate, below 1, at which some wheel reaches its range's end.

        With share s the contact's velocity is (a0 + s a1, b0 + s b1); it points along the end's
        angle where ``b cos - a sin = 0``.
        """
        u, v, r = twist
        fixed, turned = self._contacts(u, v, 0.0), self._contacts(0.0, 0.0, r)
        shares = {0.0}
        for each in self.inputs:
            for i, ratio in each.members:
                for end in (ratio * each.low, ratio * each.high):
                    if math.isinf(end):
                        continue
                    c, s, j = cos(end), sin(end), self._count + i
                    off, by_turn = fixed[j] * c - fixed[i] * s, turned[j] * c - turned[i] * s
                    if by_turn != 0 and 0 < -off / by_turn < 1:
                        shares.add(-off / by_turn)
        return sorted(shares, reverse=True)
