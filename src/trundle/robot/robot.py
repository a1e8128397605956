"""A robot: a name, its wheels in order, and the outline of its body."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from trundle.errors import RobotError, did_you_mean
from trundle.robot.quantity import check, point, quantity
from trundle.robot.wheels import RollingWheel, SteeredWheel, Wheel


@dataclass(frozen=True, kw_only=True)
class Body:
    """The outline that pictures draw, and what the body without its wheels weighs.

    The outline is a rectangle centred at (x, y) of the body frame. Mass, inertia and centre of
    mass are needed for dynamics alone, and have no default.

    >>> Body(length=0.5, width=0.4, mass=10.0, inertia=0.4, com=(0.05, 0.0)).com
    (0.05, 0.0)
    """

    length: float | None = quantity(
        "m", default=None, positive=True, help="extent along the body's x axis"
    )
    width: float | None = quantity(
        "m", default=None, positive=True, help="extent along the body's y axis"
    )
    x: float = quantity("m", default=0.0, help="centre of the outline in the body frame")
    y: float = quantity("m", default=0.0, help="centre of the outline in the body frame")
    mass: float | None = quantity(
        "kg", default=None, positive=True, help="mass of the body without the wheels"
    )
    inertia: float | None = quantity(
        "kg m^2",
        default=None,
        positive=True,
        help="inertia of the body about the vertical through its centre of mass",
    )
    com: tuple[float, float] | None = point("m", "centre of mass of the body, in the body frame")

    def __post_init__(self) -> None:
        faults = check(self)
        if (self.length is None) != (self.width is None):
            missing = "length" if self.length is None else "width"
            faults.append(f"{missing} is missing: an outline has length and width")
        if faults:
            raise RobotError(faults, "body")


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A wheeled robot, described by its wheels; everything else follows from them.

    Driven wheels in order give the n wheel speeds, steered wheels in order the s steering angles,
    sensed wheels in order the columns of odometry.

    Raises:
        RobotError: there is no wheel, or two wheels have the same name.

    >>> from trundle.robot import FixedWheel
    >>> left = FixedWheel(name="left", x=0.0, y=0.2, radius=0.05)
    >>> right = FixedWheel(name="right", x=0.0, y=-0.2, radius=0.05)
    >>> [wheel.name for wheel in Robot(name="mine", wheels=(left, right)).driven]
    ['left', 'right']
    """

    name: str
    wheels: tuple[Wheel, ...]
    body: Body | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.wheels, Iterable):
            raise RobotError([f"wheels must be a tuple of wheels, got {self.wheels!r}"])
        object.__setattr__(self, "wheels", tuple(self.wheels))
        faults = []
        if not isinstance(self.name, str) or not self.name.strip():
            faults.append(f"name must be a text that is not empty, got {self.name!r}")
        strangers = [each for each in self.wheels if not isinstance(each, Wheel)]
        faults += [f"wheels must hold wheels, got {each!r}" for each in strangers]
        if not self.wheels:
            faults.append("a robot needs at least one wheel")
        if not isinstance(self.body, Body | None):
            faults.append(f"body must be a Body, got {self.body!r}")
        if not strangers:
            faults += repeated_names([wheel.name for wheel in self.wheels])
            faults += _jammed_groups(self.steered)
        if faults:
            raise RobotError(faults, f"robot {self.name!r}")

    @property
    def driven(self) -> tuple[RollingWheel, ...]:
        """The wheels with a motor, in order: n wheel speeds."""
        return tuple(w for w in self.wheels if isinstance(w, RollingWheel) and w.driven)

    @property
    def steered(self) -> tuple[SteeredWheel, ...]:
        """The wheels with a steering angle, driven or not, in order: s angles."""
        return tuple(w for w in self.wheels if isinstance(w, SteeredWheel))

    @property
    def sensed(self) -> tuple[RollingWheel, ...]:
        """The wheels whose turning is measured, in order: the columns of odometry."""
        return tuple(w for w in self.wheels if isinstance(w, RollingWheel) and w.sensed)

    @property
    def reach(self) -> float:
        """Largest distance of a wheel from the body's origin [m], or the largest wheel radius."""
        far = max(math.hypot(w.x, w.y) for w in self.wheels)
        return far or max(getattr(w, "radius", None) or 1.0 for w in self.wheels)

    def with_wheels(self, **changes: Any) -> Robot:
        """Return the same robot with fields changed on every wheel that has them.

        Motor limits go to the driven wheels only.

        Raises:
            RobotError: no wheel has such a field, or a value is impossible.

        >>> import trundle
        >>> slow = trundle.load("mecanum").with_wheels(max_speed=10.0)
        >>> [wheel.max_speed for wheel in slow.driven]
        [10.0, 10.0, 10.0, 10.0]
        """
        known = {each.name for wheel in self.wheels for each in dataclasses.fields(wheel)}
        if strangers := set(changes) - known:
            raise RobotError([f"no wheel has {name!r}" for name in sorted(strangers)], self.name)
        return dataclasses.replace(
            self, wheels=tuple(_changed(wheel, changes) for wheel in self.wheels)
        )

    def with_body(self, **changes: Any) -> Robot:
        """Return the robot with the fields of its body changed.

        Raises:
            RobotError: the body has no such field, or a value is impossible.

        >>> import trundle
        >>> robot = trundle.load("omni3").with_body(mass=30.0, inertia=0.1, com=(0.0, 0.0))
        >>> robot.body.mass
        30.0
        """
        known = [each.name for each in dataclasses.fields(Body)]
        if strangers := set(changes) - set(known):
            faults = [f"a body has no {n!r}{did_you_mean(n, known)}" for n in sorted(strangers)]
            raise RobotError(faults, self.name)
        return dataclasses.replace(self, body=dataclasses.replace(self.body or Body(), **changes))


def repeated_names(names: Iterable[str]) -> list[str]:
    """Return a fault for each name that more than one wheel has."""
    return [
        f"wheel {name!r}: the name is used {count} times; names must differ"
        for name, count in Counter(names).items()
        if count > 1
    ]


def _jammed_groups(wheels: Iterable[SteeredWheel]) -> list[str]:
    """Return a fault for each steering group in which no angle keeps every wheel's limits."""
    groups: dict[str, list[SteeredWheel]] = {}
    for wheel in wheels:
        if wheel.steering_group is not None:
            groups.setdefault(wheel.steering_group, []).append(wheel)
    faults = []
    for name, members in groups.items():
        ranges = [sorted(end / w.steering_ratio for end in w.steering_range) for w in members]
        if max(low for low, _ in ranges) > min(high for _, high in ranges):
            faults.append(
                f"steering group {name!r}: no angle keeps the limits of all its wheels, "
                f"{', '.join(wheel.name for wheel in members)}"
            )
    return faults


def _changed(wheel: Wheel, changes: dict[str, Any]) -> Wheel:
    motor = {"max_speed", "max_acceleration", "max_torque", "motor"}
    names = {each.name for each in dataclasses.fields(wheel)} - (set() if wheel.driven else motor)
    return dataclasses.replace(wheel, **{k: v for k, v in changes.items() if k in names})
