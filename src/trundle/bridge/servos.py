"""Steering servos: angles that follow their commands at a limited rate, in plain floats."""

from __future__ import annotations

import math

from trundle.bridge.units import Numbers
from trundle.limits import steering_groups
from trundle.robot import Robot


class Servos:
    """The steering of one robot; linked wheels keep their ratio on the way.

    >>> from trundle import load
    >>> servos = Servos(load("tricycle").with_wheels(steering_rate=2.0))
    >>> (mean,), (end,) = servos.move((0.0,), (1.0,), 0.25)  # over the step, and at its end
    >>> round(mean, 9), round(end, 9)
    (0.25, 0.5)
    """

    def __init__(self, robot: Robot) -> None:
        self._groups = steering_groups(robot)
        self._ranges = tuple(wheel.steering_range for wheel in robot.steered)
        self._rates = tuple(wheel.steering_rate for wheel in robot.steered)

    def within(self, angles: Numbers) -> Numbers:
        """Return angles (s,) [rad], those beyond a wheel's range at its end."""
        return tuple(
            min(max(angle, low), high)
            for angle, (low, high) in zip(angles, self._ranges, strict=True)
        )

    def move(self, angles: Numbers, commands: Numbers, dt: float) -> tuple[Numbers, Numbers]:
        """Return the mean angles over a step and those at its end [rad].

        A wheel without a rate is there at the step's end; one with a rate goes at it and waits.

        Args:
            angles: (s) angles at the start [rad].
            commands: (s) wanted [rad].
            dt: the step [s].
        """
        if angles == commands:
            return angles, angles
        mean, end = list(angles), list(angles)
        wanted = self.within(commands)
        for group in self._groups:
            # How many steps the slowest wheel of the group takes.
            needed = 0.0
            for i in group:
                rate, way = self._rates[i], abs(wanted[i] - angles[i])
                if way > 0.0:
                    needed = max(needed, 1.0 if rate is None else way / (rate * dt or _NEVER))
            if needed == 0.0:
                continue
            share = min(1.0, 1.0 / needed)
            # On the way for ``needed`` of the step, there for the rest.
            average = 1.0 - 0.5 * needed if needed < 1.0 else 0.5 * share
            for i in group:
                way = wanted[i] - angles[i]
                mean[i] = angles[i] + average * way
                end[i] = wanted[i] if share == 1.0 else angles[i] + share * way
        return tuple(mean), tuple(end)


_NEVER = math.ulp(0.0)
