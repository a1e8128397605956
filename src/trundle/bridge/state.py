"""What a bridge knows from cycle to cycle: a value."""

from __future__ import annotations

from typing import NamedTuple

from trundle.bridge.odometer import Odometry, Pose
from trundle.bridge.units import Numbers
from trundle.limits import STILL, Twist


class State(NamedTuple):
    """The state of a bridge after a cycle.

    Attributes:
        time: time of the cycle [s].
        steering: the inputs of the steering [rad].
        odometry: what the counters have told.
        command: the last good command (u, v, r) [m/s, m/s, rad/s].
        command_time: when it came [s]; -inf before the first.
        twist: the twist that the wheels were told to give.
        rate: how fast it changed [m/s^2, m/s^2, rad/s^2].
        cycle: length of the last cycle that had one [s].
        refused: how many commands were refused.
    """

    time: float
    steering: Numbers
    odometry: Odometry
    command: Twist = STILL
    command_time: float = float("-inf")
    twist: Twist = STILL
    rate: Twist = STILL
    cycle: float = 0.0
    refused: int = 0

    @property
    def pose(self) -> Pose:
        """The pose x, y, psi by odometry [m, m, rad]."""
        return self.odometry.pose

    @property
    def refused_counts(self) -> int:
        """How many readings of the counters were refused."""
        return self.odometry.refused
