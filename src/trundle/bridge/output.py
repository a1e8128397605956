"""What a bridge says in a cycle; what is seldom read is worked out when it is read."""

from __future__ import annotations

from typing import NamedTuple

from trundle.bridge.odometer import Covariance, Odometer, Odometry, Pose, velocity_covariance
from trundle.bridge.units import Numbers, Units
from trundle.limits import Twist


class Output(NamedTuple):
    """What a bridge says in a cycle: wheels in the order of the robot's driven wheels.

    Attributes:
        wheel_speeds: (n) [rad/s], the motors' signs.
        steering: (s) steering angles [rad].
        twist: (u, v, r) that these give [m/s, m/s, rad/s].
        limits: names of the limits in force.
        stale: whether there is no command that is young enough.
        refusals: what was refused in this cycle, and why.
        odometry: what the counters have told.
        elapsed: length of the cycle before [s].
        units: radii and gears of the wheels.
        odometer: how the counters are read.
    """

    wheel_speeds: Numbers
    steering: Numbers
    twist: Twist
    limits: tuple[str, ...]
    stale: bool
    refusals: tuple[str, ...]
    odometry: Odometry
    elapsed: float
    units: Units
    odometer: Odometer

    def __repr__(self) -> str:
        """Return what the wheels are told, and where the robot is."""
        told = ("wheel_speeds", "steering", "twist", "limits", "stale", "refusals", "pose")
        return f"Output({', '.join(f'{name}={getattr(self, name)!r}' for name in told)})"

    @property
    def rim_speeds(self) -> Numbers:
        """Radius times wheel speed (n) [m/s]."""
        return self.units.rim_speeds(self.wheel_speeds)

    @property
    def rpm(self) -> Numbers:
        """Turns of the wheels per minute (n)."""
        return self.units.rpm(self.wheel_speeds)

    @property
    def motor_rpm(self) -> Numbers:
        """Turns of the motors per minute (n), before the gear."""
        return self.units.motor_rpm(self.wheel_speeds)

    @property
    def ticks(self) -> Numbers:
        """Encoder ticks (n) in a cycle as long as the last."""
        return self.units.ticks(self.wheel_speeds, self.elapsed)

    @property
    def pose(self) -> Pose:
        """The pose x, y, psi by odometry [m, m, rad]; psi is not wrapped."""
        return self.odometry.pose

    @property
    def covariance(self) -> Covariance:
        """The pose's covariance (3, 3), with the counters' resolution."""
        return self.odometer.covariance(self.odometry)

    @property
    def velocity(self) -> Twist:
        """The measured twist (u, v, r) over the last interval between two readings."""
        return self.odometry.velocity

    @property
    def velocity_covariance(self) -> Covariance:
        """The measured twist's covariance (3, 3)."""
        return velocity_covariance(self.odometry)

    @property
    def residuals(self) -> Numbers:
        """Mismatch (k) of the sensed wheels with the velocity [m/s]."""
        return self.odometry.residuals

    @property
    def slipping(self) -> tuple[str, ...]:
        """Names of the wheels that disagree with the others."""
        return self.odometry.slipping
