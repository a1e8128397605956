"""What a robot's wheels leave of a twist, in scalars.

The twist is projected on those that some steering angle allows, bent no more than the steering
limits permit, and scaled where a wheel would turn too fast, so that the path keeps its curvature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout import written
from trundle.simulation.rollout.drive import allowed_twists, check_driven


@dataclass(frozen=True)
class Bounds:
    """What the wheels leave of twists: how many conditions of each kind there are.

    Attributes:
        held: whether the wheels do not allow every twist.
        steering: rows whose sign must not change while a twist is bent from straight ahead.
        speeds: rows whose product with the twist is at most 1.
        rims: pairs of rows, the length of whose products with the twist is at most 1.
    """

    held: bool
    steering: int
    speeds: int
    rims: int

    @property
    def constants(self) -> int:
        """How many constants the function takes."""
        bent = 9 + 3 * self.steering if self.steering else 0
        return (9 if self.held else 0) + bent + 3 * self.speeds + 6 * self.rims

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (twist, constants) -> the twist that the wheels can have."""
        steps, at = [], 0
        if self.held:
            steps.append(_projected(jit, 0))
            at = 9
        if self.steering:
            rows = range(at + 9, at + 9 + 3 * self.steering, 3)
            steps.append(_bent(at, rows, m, jit))
            at = rows.stop
        if self.speeds or self.rims:
            singles = range(at, at + 3 * self.speeds, 3)
            pairs = range(singles.stop, singles.stop + 6 * self.rims, 6)
            steps.append(_slowed(singles, pairs, m, jit))
        return _chained(steps, jit)


def _chained(steps: list[Function], jit: Jit) -> Function:
    """Return the function that takes a twist through all steps."""
    if not steps:
        return jit(lambda twist, constants: (twist[0], twist[1], twist[2]))  # noqa: ARG005
    first, later = steps[0], _chained(steps[1:], jit)
    return jit(lambda twist, constants: later(first(twist, constants), constants))


def _projected(jit: Jit, at: int) -> Function:
    """Return (twist, constants) -> a matrix's product with the twist."""
    product, second, third = jit(written.dot(3)), at + 3, at + 6

    def projected(twist: Any, constants: Any) -> Any:
        return (
            product(constants, at, twist),
            product(constants, second, twist),
            product(constants, third, twist),
        )

    return jit(projected)


def _bent(at: int, rows: range, m: Arithmetic, jit: Jit) -> Function:
    """Return (twist, constants) -> the twist, bent from straight ahead no more than wheels steer.

    A steered wheel keeps its limits while no row at its limits changes sign: a row's share of the
    bend must not exceed what the motion straight ahead gives it.
    """
    product, ahead = jit(written.dot(3)), _projected(jit, at)
    minimum, maximum, where = m.minimum, m.maximum, m.where
    zero, one, tiny = m.number(0), m.number(1), m.number(1e-30)

    def share_from(index: int) -> Function:
        if index == len(rows):
            return jit(lambda straight, bend, constants: one)  # noqa: ARG005
        row, later = rows[index], share_from(index + 1)

        def share(straight: Any, bend: Any, constants: Any) -> Any:
            there, change = product(constants, row, straight), product(constants, row, bend)
            against = where(there < zero, change, -change)
            most = maximum(there, -there) / maximum(against, tiny)
            return minimum(most, later(straight, bend, constants))

        return jit(share)

    largest_share = share_from(0)

    def bent(twist: Any, constants: Any) -> Any:
        straight = ahead(twist, constants)
        bend = twist[0] - straight[0], twist[1] - straight[1], twist[2] - straight[2]
        share = largest_share(straight, bend, constants)
        return (
            straight[0] + share * bend[0],
            straight[1] + share * bend[1],
            straight[2] + share * bend[2],
        )

    return jit(bent)


def _slowed(singles: range, pairs: range, m: Arithmetic, jit: Jit) -> Function:
    """Return (twist, constants) -> the twist, scaled so that no wheel is too fast."""
    product, maximum, sqrt, one = jit(written.dot(3)), m.maximum, m.sqrt, m.number(1)

    def single(row: int, later: Function) -> Function:
        def square(twist: Any, constants: Any) -> Any:
            speed = product(constants, row, twist)
            return maximum(speed * speed, later(twist, constants))

        return jit(square)

    def pair(row: int, later: Function) -> Function:
        across = row + 3

        def square(twist: Any, constants: Any) -> Any:
            a, b = product(constants, row, twist), product(constants, across, twist)
            return maximum(a * a + b * b, later(twist, constants))

        return jit(square)

    largest: Function = jit(lambda twist, constants: one)  # noqa: ARG005
    for row in singles:
        largest = single(row, largest)
    for row in pairs:
        largest = pair(row, largest)

    def slowed(twist: Any, constants: Any) -> Any:
        scale = one / sqrt(largest(twist, constants))
        return scale * twist[0], scale * twist[1], scale * twist[2]

    return jit(slowed)


# ---- from a robot to its bounds --------------------------------------------------------------

# A projector that differs from 1 by less lets every twist pass.
_FREE = 1e-9


def twist_bounds(robot: Robot, max_twist: Array | None = None) -> tuple[Bounds, Array]:
    """Return what a robot's wheels leave of twists, and the constants of that.

    Args:
        robot: the robot.
        max_twist: (3,) largest (u, v, r) beside the wheels' own limits [m/s, m/s, rad/s].
    """
    check_driven(robot)
    allowed = allowed_twists(robot)
    ahead, wedges = _steering_limits(robot, allowed)
    singles, pairs = [], []
    for wheel in robot.driven:
        if wheel.max_speed is None:
            continue
        rows, fastest = wheel.rows(), wheel.max_speed
        size = abs(rows.gain) * fastest
        if wheel.steers:
            pairs.append(np.array([rows.rolling, rows.side_slip]) / size)
        else:
            singles.append(np.array(rows.rolling) / size)
    if max_twist is not None:
        singles += list(np.diag(1.0 / max_twist))
    held = bool(np.abs(allowed - np.eye(3)).max() > _FREE)
    parts = [*([allowed] if held else []), *([ahead, *wedges] if wedges else []), *singles, *pairs]
    constants = np.concatenate([np.zeros(0), *(np.ravel(part) for part in parts)])
    return Bounds(held, len(wedges), len(singles), len(pairs)), constants


def _steering_limits(robot: Robot, allowed: Array) -> tuple[Array, list[Array]]:
    """Return the projector onto twists with all limited wheels at the middle of their range.

    And the rows, two for each such wheel, that are zero where it stands at a limit.
    """
    middles, rows = [], []
    for wheel in robot.steered:
        low, high = wheel.steering_range
        if high - low < math.pi:
            middles.append(wheel.rows((low + high) / 2).side_slip)
            rows += [np.array(wheel.rows(end).side_slip) for end in (low, high)]
    if not rows:
        return allowed, []
    across = np.array(middles) @ allowed
    _, size, vectors = np.linalg.svd(np.vstack([across, np.eye(3) - allowed]))
    free = vectors[size < _FREE]
    return free.T @ free, rows
