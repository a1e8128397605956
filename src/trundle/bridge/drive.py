"""From the twist that is wanted to the twist, steering and wheel speeds of the next cycle."""

from __future__ import annotations

import math
from typing import NamedTuple

from trundle.bridge.units import Numbers
from trundle.bridge.wheels import Wheels
from trundle.limits import STILL, Ramp, Twist, TwistLimits
from trundle.robot import Robot

# Halvings of a step in search of the part for which the steering is quick enough: to a millionth.
_HALVINGS = 20
# A twist is limited where it changes by more than rounding.
_ROUNDING = 1e-12


class Drive(NamedTuple):
    """What a cycle asks of the wheels.

    Attributes:
        twist: the twist (u, v, r) that the wheels then give [m/s, m/s, rad/s].
        change: what it differs by from that of the cycle before, for a ramp to go on with; none
            where it brakes.
        steering: inputs of the steering [rad].
        limits: names of the limits in force.
    """

    twist: Twist
    change: Twist
    steering: Numbers
    limits: tuple[str, ...]


class Driver:
    """The limits of one robot, applied in a control loop; it keeps nothing from cycle to cycle."""

    def __init__(self, robot: Robot, limits: TwistLimits) -> None:
        self.wheels = Wheels(robot)
        self._ramp = Ramp(limits)
        self._wheel_time = self.wheels.time if self.wheels.limits_acceleration else None
        self._rates = tuple(each.rate for each in self.wheels.inputs)

    def reach(self, asked: Twist, steering: Numbers) -> tuple[Twist, list[str]]:
        """Return the twist that the robot may have in place of the one asked, and why.

        The nearest that the wheels allow; with less yaw rate where a wheel's steering range ends;
        and all of it slower where the body or a wheel would be too fast, so that the path's
        curvature stays.
        """
        twist, why = self.wheels.project(asked), []
        if twist != asked and _differ(twist, asked):
            why.append("wheels")
        if self.wheels.limits_steering and self.wheels.aim(twist, steering) is None:
            twist = self._straighter(twist, steering)
            why.append("steering range")
        body, wheels = self._ramp.share(twist), self.wheels.share(twist)
        share = max(body, wheels)
        if share > 1.0:
            why.append("speed" if body >= wheels else "wheel speed")
            twist = twist[0] / share, twist[1] / share, twist[2] / share
        return twist, why

    def step(self, twist: Twist, last: Twist, steering: Numbers, asked: Twist, dt: float) -> Drive:
        """Return the next cycle's drive towards the twist asked.

        Args:
            twist: the present twist.
            last: what it changed by in the cycle before, at this cycle's length.
            steering: the present inputs of the steering [rad].
            asked: the twist wanted.
            dt: the cycle [s].
        """
        target, why = self.reach(asked, steering)
        wanted = self._ramp.until(twist, target)
        step = self._ramp.towards(twist, wanted, dt, self._wheel_time)
        if self._ramp.jerks:
            smooth = self._ramp.smooth(step, wanted, STILL if twist == STILL else last, dt)
            if _differ(smooth, step):
                why.append("jerk")
                step = self._within(twist, smooth, target, dt)
            elif step is not wanted:
                why.append("acceleration")
        elif step is not wanted:
            why.append("acceleration")
        return self._steered(twist, target, step, steering, dt, why)

    def brake(self, twist: Twist, steering: Numbers, dt: float) -> Drive:
        """Return the next cycle's drive on the way to rest, at the deceleration and no less.

        It tells of no change: a ramp with limited jerk begins anew after it.
        """
        back = -twist[0], -twist[1], -twist[2]
        step = self._ramp.towards(twist, back, dt, self._wheel_time)
        return Drive(_sum(twist, step), STILL, steering, ())

    def _straighter(self, twist: Twist, steering: Numbers) -> Twist:
        """Return the twist with as much of its yaw rate as the steering ranges allow, or rest."""
        for share in self.wheels.ends(twist):
            turned = twist[0], twist[1], share * twist[2]
            if self.wheels.aim(turned, steering) is not None:
                return turned
        return STILL

    def _within(self, twist: Twist, step: Twist, target: Twist, dt: float) -> Twist:
        """Return a step that keeps the other limits, where one that spares the jerk does not.

        So it is where a new command comes in the middle of a ramp. Nor does such a step go beyond
        zero on an axis where the target does not lie there: a robot that brakes and is told to go
        on must not first drive back.
        """
        end = _sum(twist, step)
        share = max(self._ramp.share(end), self.wheels.share(end))
        if share > 1.0 + _ROUNDING:
            step = end[0] / share - twist[0], end[1] / share - twist[1], end[2] / share - twist[2]
            end = _sum(twist, step)
        share = 1.0
        for now, then, goal in zip(twist, end, target, strict=True):
            if (then < 0.0 <= now and goal >= 0.0) or (then > 0.0 >= now and goal <= 0.0):
                share = min(share, now / (now - then))
        step = share * step[0], share * step[1], share * step[2]
        return self._ramp.towards(twist, step, dt, self._wheel_time)

    def _steered(
        self, twist: Twist, target: Twist, step: Twist, steering: Numbers, dt: float, why: list[str]
    ) -> Drive:
        """Return the drive whose steering follows the step, which may be shortened for it."""
        if not steering:
            return Drive(_sum(twist, step), step, steering, tuple(why))
        if twist == STILL:
            return self._from_rest(target, step, steering, dt, why)
        aimed = self._aimed(twist, step, 1.0, steering, dt)
        if aimed is not None:
            return Drive(_sum(twist, step), step, aimed, tuple(why))
        why.append("steering rate")
        low, high, found = 0.0, 1.0, None
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            aimed = self._aimed(twist, step, middle, steering, dt)
            if aimed is None:
                high = middle
            else:
                low, found = middle, aimed
        if found is None:
            # No way on at these angles: slower, until the wheels can turn at rest.
            return self.brake(twist, steering, dt)._replace(limits=tuple(why))
        step = low * step[0], low * step[1], low * step[2]
        return Drive(_sum(twist, step), step, found, tuple(why))

    def _from_rest(
        self, target: Twist, step: Twist, steering: Numbers, dt: float, why: list[str]
    ) -> Drive:
        """Return the drive from rest: the wheels first turn to where they will roll."""
        aimed = self.wheels.aim(target, steering)
        if aimed is None or target == STILL:
            return Drive(STILL, STILL, steering, tuple(why))
        turned = tuple(
            now + min(max(to - now, -rate * dt), rate * dt) if rate < math.inf else to
            for now, to, rate in zip(steering, aimed, self._rates, strict=True)
        )
        if turned != aimed:
            return Drive(STILL, STILL, turned, (*why, "steering rate"))
        return Drive(step, step, turned, tuple(why))

    def _aimed(
        self, twist: Twist, step: Twist, share: float, steering: Numbers, dt: float
    ) -> Numbers | None:
        """Return the inputs after a share of a step, or None where they cannot get there."""
        part = share * step[0], share * step[1], share * step[2]
        aimed = self.wheels.aim(_sum(twist, part), steering)
        if aimed is None:
            return None
        for now, to, rate in zip(steering, aimed, self._rates, strict=True):
            if abs(to - now) > rate * dt:
                return None
        return aimed


def _sum(twist: Twist, step: Twist) -> Twist:
    """Return the twist after a step; an axis of which only rounding is left stands still."""
    (u, v, r), (du, dv, dr) = twist, step
    x, y, z = u + du, v + dv, r + dr
    return (
        x if abs(x) > _ROUNDING * abs(du) else 0.0,
        y if abs(y) > _ROUNDING * abs(dv) else 0.0,
        z if abs(z) > _ROUNDING * abs(dr) else 0.0,
    )


def _differ(a: Twist, b: Twist) -> bool:
    """Return whether two twists differ by more than rounding."""
    (u, v, r), (x, y, z) = a, b
    size = abs(u) + abs(v) + abs(r)
    return abs(u - x) + abs(v - y) + abs(r - z) > _ROUNDING * size
