"""The kinds of wheel and the constraint rows that each puts on the body's twist.

Every row is written here once, as a function of the wheel, its steering angle and a module that
offers ``cos`` and ``sin``: numpy reads it over batches of angles, sympy reads it in symbols.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple, final

from trundle.errors import RobotError
from trundle.robot.motor import Encoder, Motor
from trundle.robot.quantity import check, flag, part, quantity, text

# A roller closer than this to +-90 deg leaves a force along the drive direction of less than a
# millionth of the roller's: no wheel is made to such an angle, so it is a slip of the pen.
_LEAST_PUSH = 1e-6


class Rows(NamedTuple):
    """What one wheel says of the twist (u, v, r); each row is three coefficients.

    ``rolling . twist = gain * wheel_speed`` and ``side_slip . twist = 0``; None where the wheel
    says nothing. ``skid`` is the side-slip row of a wheel that is allowed to skid.
    """

    rolling: tuple[Any, Any, Any] | None = None
    gain: Any = 0.0
    side_slip: tuple[Any, Any, Any] | None = None
    skid: tuple[Any, Any, Any] | None = None


def contact_row(x: Any, y: Any, angle: Any, math: Any) -> tuple[Any, Any, Any]:
    """Return the row that takes (u, v, r) to a body point's velocity along a direction.

    ``cos(angle) (u - r y) + sin(angle) (v + r x)``.

    Args:
        x: coordinate of the point in the body frame [m].
        y: coordinate of the point in the body frame [m].
        angle: direction in the body frame [rad]; an array gives arrays.
        math: a module with ``cos`` and ``sin``: math, numpy, sympy.
    """
    c, s = math.cos(angle), math.sin(angle)
    return c, s, x * s - y * c


def across_row(x: Any, y: Any, angle: Any, math: Any) -> tuple[Any, Any, Any]:
    """Return the row of a quarter turn further: ``-sin(angle) (u - r y) + cos(angle) (v + r x)``.

    The arguments are those of ``contact_row``; written out, so that zeros and symbols are exact.
    """
    c, s = math.cos(angle), math.sin(angle)
    return -s, c, x * c + y * s


@dataclass(frozen=True, kw_only=True)
class Wheel(ABC):
    """What all wheels have: a name and the contact point (x, y) in the body frame [m]."""

    kind: ClassVar[str]
    may_drive: ClassVar[bool] = True

    name: str = text("name of the wheel, in messages and pictures")
    x: float = quantity("m", help="contact point in the body frame; for casters the pivot")
    y: float = quantity("m", help="contact point in the body frame; for casters the pivot")
    driven: bool = flag("whether a motor drives the wheel", default=None)
    mass: float = quantity(
        "kg", default=0.0, nonnegative=True, help="mass of the wheel, which the body's excludes"
    )
    yaw_inertia: float = quantity(
        "kg m^2",
        default=0.0,
        nonnegative=True,
        help="inertia about the vertical through (x, y)",
    )

    def __post_init__(self) -> None:
        faults = check(self)
        if self.driven is None:
            object.__setattr__(self, "driven", self.may_drive)
        elif self.driven and not self.may_drive:
            faults.append(f"driven must be false: a driven {self.kind} is not supported")
        if not faults:
            faults = self._cross_faults()
        if faults:
            raise RobotError(faults, f"wheel {self.name!r}")

    def _cross_faults(self) -> list[str]:
        """Return the faults that lie between two values, each of which alone is well."""
        return []

    @property
    def sensed(self) -> bool:
        """Whether the wheel's turning is measured, so that it counts in odometry."""
        return False

    @property
    def steers(self) -> bool:
        """Whether the wheel has a steering angle."""
        return False

    @abstractmethod
    def rows(self, steering: Any = 0.0, math: Any = math) -> Rows:
        """Return the wheel's constraint rows at a steering angle [rad]."""


@dataclass(frozen=True, kw_only=True)
class RollingWheel(Wheel, ABC):
    """What all wheels have whose turning is tied to the motion: radius, heading, motor, encoder."""

    radius: float = quantity("m", positive=True, help="rolling radius")
    heading: float = quantity(
        "rad",
        default=0.0,
        degrees=True,
        help="drive direction in the body frame; for steered wheels the zero of steering",
    )
    reversed: bool = flag("true: positive motor speed drives backwards")
    measured: bool = flag(
        "whether the turning is measured (default: driven wheels and wheels with an encoder)",
        default=None,
    )
    encoder: Encoder | None = field(
        default=None, metadata=part(Encoder, "encoder on the motor shaft")
    )
    max_speed: float | None = quantity(
        "rad/s", default=None, positive=True, help="largest wheel speed"
    )
    max_acceleration: float | None = quantity(
        "rad/s^2", default=None, positive=True, help="largest wheel acceleration"
    )
    max_torque: float | None = quantity(
        "N m", default=None, positive=True, help="largest torque of the motor at the wheel"
    )
    motor: Motor | None = field(
        default=None, metadata=part(Motor, "DC motor that drives the wheel")
    )
    spin_inertia: float = quantity(
        "kg m^2",
        default=0.0,
        nonnegative=True,
        help="inertia about the axle, with the motor's rotor as the wheel feels it",
    )
    viscous_friction: float = quantity(
        "N m s/rad", default=0.0, nonnegative=True, help="friction torque at 1 rad/s"
    )
    coulomb_friction: float = quantity(
        "N m", default=0.0, nonnegative=True, help="friction torque at any speed"
    )
    friction: float | None = quantity(
        "", default=None, positive=True, help="coefficient of friction with the ground"
    )

    @property
    def sensed(self) -> bool:
        """Whether the wheel's turning is measured, so that it counts in odometry."""
        return self.driven or self.encoder is not None if self.measured is None else self.measured

    @property
    def spin_sign(self) -> int:
        """+1, or -1 where positive motor speed drives backwards."""
        return -1 if self.reversed else 1


@final
@dataclass(frozen=True, kw_only=True)
class FixedWheel(RollingWheel):
    """A standard wheel whose drive direction is fixed in the body.

    It rolls without slipping and does not slip sideways, with theta its heading::

        cos(theta) (u - r y) + sin(theta) (v + r x) = a omega
       -sin(theta) (u - r y) + cos(theta) (v + r x) = 0

    With ``skid`` the second row is not enforced wheel by wheel (skid-steer robots); the arm of r in
    the first is then ``track_factor`` times as long.

    Source: Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, 2004, section 3.2.3,
    eqs. (3.12) and (3.13).

    >>> wheel = FixedWheel(name="left", x=0.0, y=0.2, radius=0.05)
    >>> wheel.rows().rolling, wheel.rows().gain
    ((1.0, 0.0, -0.2), 0.05)
    """

    kind = "fixed"

    skid: bool = flag("true: the wheel may slip sideways, as on a skid-steer robot")
    track_factor: float = quantity(
        "",
        default=1.0,
        positive=True,
        help="effective over geometric track of a skidding wheel, identified from data",
    )

    def _cross_faults(self) -> list[str]:
        if self.track_factor < 1:
            return [f"track_factor must be at least 1, got {self.track_factor:g}"]
        if self.track_factor != 1 and not self.skid:
            return ["track_factor belongs to wheels with skid = true"]
        return []

    def rows(self, steering: Any = 0.0, math: Any = math) -> Rows:
        """Return the wheel's constraint rows; the steering angle has no effect."""
        c, s, arm = contact_row(self.x, self.y, self.heading, math)
        rolling = c, s, arm * self.track_factor
        across = across_row(self.x, self.y, self.heading, math)
        gain = self.spin_sign * self.radius
        if self.skid:
            return Rows(rolling, gain, skid=across)
        return Rows(rolling, gain, side_slip=across)


@final
@dataclass(frozen=True, kw_only=True)
class SteeredWheel(RollingWheel):
    """A standard wheel that turns about a vertical axis through its contact point.

    The rows are those of a fixed wheel at theta = heading + steering angle. Wheels of one
    ``steering_group`` share one input: each angle is the group's angle times ``steering_ratio``.

    Source: Siegwart and Nourbakhsh, 2004, section 3.2.3, eqs. (3.15) and (3.16).

    >>> wheel = SteeredWheel(name="front", x=1.0, y=0.0, radius=0.3)
    >>> [round(c, 12) for c in wheel.rows(steering=math.pi / 2).rolling]
    [0.0, 1.0, 1.0]
    """

    kind = "steered"

    steering_group: str | None = text("wheels of one group are steered by one input", default=None)
    steering_ratio: float = quantity(
        "", default=1.0, nonzero=True, help="steering angle over the angle of the group"
    )
    steering_min: float | None = quantity(
        "rad", default=None, degrees=True, help="least steering angle"
    )
    steering_max: float | None = quantity(
        "rad", default=None, degrees=True, help="largest steering angle"
    )
    steering_rate: float | None = quantity(
        "rad/s", default=None, degrees=True, positive=True, help="largest steering rate"
    )

    def _cross_faults(self) -> list[str]:
        faults = []
        low, high = self.steering_range
        if low > high:
            faults.append(
                f"steering_min must not exceed the largest angle, got {math.degrees(low):g} "
                f"and {math.degrees(high):g} deg"
            )
        if self.steering_group is None and self.steering_ratio != 1:
            faults.append("steering_ratio needs a steering_group")
        return faults

    @property
    def steers(self) -> bool:
        """Whether the wheel has a steering angle: always."""
        return True

    @property
    def steering_range(self) -> tuple[float, float]:
        """Least and largest steering angle [rad], infinite where there is no limit."""
        low = -math.inf if self.steering_min is None else self.steering_min
        high = math.inf if self.steering_max is None else self.steering_max
        return low, high

    def rows(self, steering: Any = 0.0, math: Any = math) -> Rows:
        """Return the wheel's constraint rows at a steering angle [rad]."""
        theta = self.heading + steering
        return Rows(
            rolling=contact_row(self.x, self.y, theta, math),
            gain=self.spin_sign * self.radius,
            side_slip=across_row(self.x, self.y, theta, math),
        )


@dataclass(frozen=True, kw_only=True)
class SwedishWheel(RollingWheel, ABC):
    """A wheel with free rollers on its rim, at ``roller`` from drive direction to roller axis.

    It is held along the axis of the roller on the ground and free across it, with phi the roller
    angle::

        cos(theta + phi) (u - r y) + sin(theta + phi) (v + r x) = a omega cos(phi)

    Source: Siegwart and Nourbakhsh, 2004, section 3.2.3, eqs. (3.19) and (3.20).
    """

    roller: float

    def _cross_faults(self) -> list[str]:
        if abs(math.cos(self.roller)) < _LEAST_PUSH:
            return [
                "roller must not be 90 deg: the roller would turn freely along the drive "
                f"direction and the wheel could not push, got {math.degrees(self.roller):g} deg"
            ]
        return []

    def rows(self, steering: Any = 0.0, math: Any = math) -> Rows:
        """Return the wheel's constraint row; the steering angle has no effect."""
        return Rows(
            rolling=contact_row(self.x, self.y, self.heading + self.roller, math),
            gain=self.spin_sign * self.radius * math.cos(self.roller),
        )


@final
@dataclass(frozen=True, kw_only=True)
class OmniWheel(SwedishWheel):
    """A Swedish wheel whose rollers turn about the drive direction's line (roller angle 0).

    >>> OmniWheel(name="right", x=0.3, y=0.0, heading=math.pi / 2, radius=0.1).rows().gain
    0.1
    """

    kind = "omni"

    roller: float = quantity(
        "rad", default=0.0, degrees=True, help="angle from drive direction to roller axis"
    )


@final
@dataclass(frozen=True, kw_only=True)
class MecanumWheel(SwedishWheel):
    """A Swedish wheel with slanted rollers, usually at +-45 deg.

    >>> wheel = MecanumWheel(name="fl", x=0.2, y=0.15, radius=0.05, roller=-math.pi / 4)
    >>> [round(c / wheel.rows().gain * 0.05, 12) for c in wheel.rows().rolling]
    [1.0, -1.0, -0.35]
    """

    kind = "mecanum"

    roller: float = quantity(
        "rad",
        degrees=True,
        help="angle from the drive direction to the axis of the roller on the ground",
    )


@final
@dataclass(frozen=True, kw_only=True)
class CasterWheel(Wheel):
    """An undriven wheel that swivels about a pivot ahead of its contact point.

    It never restricts the twist; with e the direction of the wheel at swivel angle g, n across it
    and v_p the pivot's velocity, it follows by e . v_p = a omega and n . v_p = b (r + g_dot).

    Source: Siegwart and Nourbakhsh, 2004, section 3.2.3, eqs. (3.17) and (3.18).

    >>> CasterWheel(name="rear", x=-0.2, y=0.0, radius=0.03, trail=0.02).rows()
    Rows(rolling=None, gain=0.0, side_slip=None, skid=None)
    """

    kind = "caster"
    may_drive = False

    radius: float = quantity("m", positive=True, help="rolling radius")
    trail: float | None = quantity(
        "m",
        default=None,
        positive=True,
        help="distance from the pivot back to the contact point (default: it follows at once)",
    )
    heading: float = quantity(
        "rad", default=0.0, degrees=True, help="swivel angle at the start of a simulation"
    )

    def rows(self, steering: Any = 0.0, math: Any = math) -> Rows:
        """Return no row: a caster follows every motion."""
        return Rows()


@final
@dataclass(frozen=True, kw_only=True)
class BallWheel(Wheel):
    """A ball that rolls in every direction and constrains nothing.

    >>> BallWheel(name="support", x=-0.1, y=0.0).driven
    False
    """

    kind = "ball"
    may_drive = False

    radius: float | None = quantity(
        "m", default=None, positive=True, help="radius of the ball, for pictures"
    )

    def rows(self, steering: Any = 0.0, math: Any = math) -> Rows:
        """Return no row: a ball follows every motion."""
        return Rows()


WHEEL_KINDS: tuple[type[Wheel], ...] = (
    FixedWheel,
    SteeredWheel,
    CasterWheel,
    OmniWheel,
    MecanumWheel,
    BallWheel,
)
