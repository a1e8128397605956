"""Limits on a body's twist, and the ramps that keep them, in plain floats.

A twist (u, v, r) changes along a straight line in the space of twists: all three axes arrive
together, and where only the size changes, as in starting and stopping, the path's curvature stays.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

from trundle.errors import TrundleError
from trundle.robot import check, quantity

Twist = tuple[float, float, float]

STILL: Twist = (0.0, 0.0, 0.0)

# A wheel that seems to have turned so many times further than its largest speed allows has not:
# its counter was reset, or a bit was lost on the way.
IMPLAUSIBLE = 2.0

# No clock tells cycles shorter than this [s]: they are as good as none.
_SHORTEST = 1e-9


@dataclass(frozen=True, kw_only=True)
class TwistLimits:
    """What a body's twist may be, and how fast it may change; None is no limit.

    Speed and acceleration are those of the body's origin, sqrt(u^2 + v^2) where the limits ahead
    and in reverse are one; where they differ, the share of the limit is taken for u alone.
    Reverse limits are those ahead where they are not given, deceleration is acceleration.

    Raises:
        TrundleError: a limit is not a positive number.

    >>> TwistLimits(max_speed=0.5, max_acceleration=1.0).max_reverse_deceleration
    1.0
    """

    max_speed: float | None = quantity(
        "m/s", default=None, positive=True, help="largest speed ahead and sideways"
    )
    max_reverse_speed: float | None = quantity(
        "m/s", default=None, positive=True, help="largest speed in reverse (default: max_speed)"
    )
    max_yaw_rate: float | None = quantity(
        "rad/s", default=None, positive=True, help="largest yaw rate"
    )
    max_acceleration: float | None = quantity(
        "m/s^2", default=None, positive=True, help="largest acceleration"
    )
    max_deceleration: float | None = quantity(
        "m/s^2", default=None, positive=True, help="largest braking (default: max_acceleration)"
    )
    max_reverse_acceleration: float | None = quantity(
        "m/s^2", default=None, positive=True, help="the same in reverse (default: ahead)"
    )
    max_reverse_deceleration: float | None = quantity(
        "m/s^2", default=None, positive=True, help="the same in reverse (default: ahead)"
    )
    max_yaw_acceleration: float | None = quantity(
        "rad/s^2", default=None, positive=True, help="largest yaw acceleration"
    )
    max_yaw_deceleration: float | None = quantity(
        "rad/s^2",
        default=None,
        positive=True,
        help="largest braking of the yaw rate (default: max_yaw_acceleration)",
    )
    max_jerk: float | None = quantity("m/s^3", default=None, positive=True, help="largest jerk")
    max_yaw_jerk: float | None = quantity(
        "rad/s^3", default=None, positive=True, help="largest yaw jerk"
    )

    def __post_init__(self) -> None:
        if faults := check(self):
            raise TrundleError("; ".join(faults))
        for name, other in _DEFAULTS:
            if getattr(self, name) is None:
                object.__setattr__(self, name, getattr(self, other))

    @property
    def turns(self) -> tuple[bool, bool, bool]:
        """Which axes have other limits beyond zero, or on the way away from it."""
        ahead = {self.max_acceleration, self.max_deceleration}
        back = {self.max_reverse_acceleration, self.max_reverse_deceleration}
        yaw = {self.max_yaw_acceleration, self.max_yaw_deceleration}
        return len(ahead | back) > 1, len(ahead) > 1, len(yaw) > 1


# What a limit is where it is not given, in an order in which each is known when it is needed.
_DEFAULTS = (
    ("max_reverse_speed", "max_speed"),
    ("max_deceleration", "max_acceleration"),
    ("max_reverse_acceleration", "max_acceleration"),
    ("max_reverse_deceleration", "max_deceleration"),
    ("max_reverse_deceleration", "max_reverse_acceleration"),
    ("max_yaw_deceleration", "max_yaw_acceleration"),
)


def limit_names() -> tuple[str, ...]:
    """Return the names of the limits, in order."""
    return tuple(each.name for each in dataclasses.fields(TwistLimits))


def per(limit: float | None) -> float:
    """Return one over a limit, 0 where there is none."""
    return 0.0 if limit is None else 1.0 / limit


class Ramp:
    """The limits of a twist as functions of plain floats.

    >>> ramp = Ramp(TwistLimits(max_speed=1.0, max_acceleration=0.5))
    >>> ramp.share((2.0, 0.0, 0.3)), ramp.time(STILL, (1.0, 0.0, 0.0))
    (2.0, 2.0)
    """

    def __init__(self, limits: TwistLimits) -> None:
        self._per_speed = per(limits.max_speed)
        self._per_reverse_speed = per(limits.max_reverse_speed)
        self._per_yaw_rate = per(limits.max_yaw_rate)
        self._per_acceleration = per(limits.max_acceleration)
        self._per_deceleration = per(limits.max_deceleration)
        self._per_reverse_acceleration = per(limits.max_reverse_acceleration)
        self._per_reverse_deceleration = per(limits.max_reverse_deceleration)
        self._per_yaw_acceleration = per(limits.max_yaw_acceleration)
        self._per_yaw_deceleration = per(limits.max_yaw_deceleration)
        self._per_jerk = per(limits.max_jerk)
        self._per_yaw_jerk = per(limits.max_yaw_jerk)
        self._turns = limits.turns
        self.jerks = limits.max_jerk is not None or limits.max_yaw_jerk is not None

    def share(self, twist: Twist) -> float:
        """Return how much of the speed limits a twist takes: above 1 it is too fast.

        It grows in proportion with the twist, so that the twist over its share keeps the limits.
        """
        u, v, r = twist
        along = u * (self._per_reverse_speed if u < 0 else self._per_speed)
        return max(math.hypot(along, v * self._per_speed), abs(r) * self._per_yaw_rate)

    def time(self, now: Twist, change: Twist) -> float:
        """Return the time [s] that a change of the twist takes at the acceleration limits."""
        (u, v, r), (du, dv, dr) = now, change
        if u * du < 0:
            per_u = self._per_deceleration if u > 0 else self._per_reverse_deceleration
        else:
            per_u = self._per_acceleration if du > 0 else self._per_reverse_acceleration
        per_v = self._per_deceleration if v * dv < 0 else self._per_acceleration
        per_r = self._per_yaw_deceleration if r * dr < 0 else self._per_yaw_acceleration
        return max(math.hypot(du * per_u, dv * per_v), abs(dr) * per_r)

    def until(self, now: Twist, target: Twist) -> Twist:
        """Return the change to the target, or to the first point on the way with other limits.

        That is where an axis changes its sign and its limits with it.

        >>> limits = TwistLimits(max_acceleration=1.0, max_deceleration=2.0)
        >>> Ramp(limits).until((0.5, 0.0, 0.3), (-0.5, 0.0, 0.3))
        (-0.5, 0.0, 0.0)
        """
        change = target[0] - now[0], target[1] - now[1], target[2] - now[2]
        share, axis = 1.0, -1
        for i in (0, 1, 2):
            if self._turns[i] and now[i] * target[i] < 0 and now[i] / -change[i] < share:
                share, axis = now[i] / -change[i], i
        if axis < 0:
            return change
        short = [share * each for each in change]
        short[axis] = -now[axis]  # exactly to zero
        return short[0], short[1], short[2]

    def towards(
        self, now: Twist, change: Twist, dt: float, time: Callable[[Twist], float] | None = None
    ) -> Twist:
        """Return the part of a change that a step at the acceleration limits makes.

        Args:
            now: the present twist (u, v, r) [m/s, m/s, rad/s].
            change: the change wanted, as ``until`` gives it.
            dt: the step [s].
            time: what else takes time: change -> [s], in proportion with the change.

        >>> Ramp(TwistLimits(max_acceleration=1.0)).towards(STILL, (2.0, 0.0, 4.0), 0.5)
        (0.5, 0.0, 1.0)
        """
        needed = self.time(now, change)
        if time is not None:
            needed = max(needed, time(change))
        if needed <= dt:
            return change
        share = dt / needed
        return share * change[0], share * change[1], share * change[2]

    def smooth(self, step: Twist, change: Twist, last: Twist, dt: float) -> Twist:
        """Return a step whose jerk is limited, in place of one that keeps the other limits.

        A step differs from the last one by no more than the jerk allows; and it is no larger than
        can be taken back on the way: in units of ``J dt^2``, steps of n + f, n - 1 + f, ..., f make
        a way of ``(n + 1) (n / 2 + f)``.

        Args:
            step: the step that the other limits allow.
            change: the whole change wanted, of which the step is a part.
            last: the step before.
            dt: the length of both [s].
        """
        if dt < _SHORTEST:
            return STILL
        left, taken = self._jerks(*change) / (dt * dt), self._jerks(*step) / (dt * dt)
        n = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * left) - 1.0))
        largest = n + (left / (n + 1) - 0.5 * n)
        if taken > largest:
            share = largest / taken
            step = share * step[0], share * step[1], share * step[2]
        du, dv, dr = step[0] - last[0], step[1] - last[1], step[2] - last[2]
        jerk = self._jerks(du, dv, dr) / (dt * dt)
        if jerk <= 1.0:
            return step
        return last[0] + du / jerk, last[1] + dv / jerk, last[2] + dr / jerk

    def _jerks(self, du: float, dv: float, dr: float) -> float:
        """Return a change of twist in units of the jerk limits [s^2]."""
        return max(math.hypot(du, dv) * self._per_jerk, abs(dr) * self._per_yaw_jerk)
