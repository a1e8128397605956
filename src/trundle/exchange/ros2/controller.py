"""What all controllers of ros2_controllers have in common, and how it becomes YAML."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

from trundle.errors import TrundleError
from trundle.exchange.names import (
    JointNames,
    joint_names,
    one_line,
    renamed,
    yaml_number,
    yaml_string,
)
from trundle.limits import TwistLimits
from trundle.robot import Robot, RollingWheel

# Coordinates in files are rounded to a millimetre or so: what differs by less than this share of
# the robot's size, or by less than this angle [rad], is meant to be the same.
_MEANT = 1e-3
# What arithmetic rounds: above it the YAML says that numbers were rounded.
_EXACT = 1e-9
# What drives a robot that no controller fits; ROBOT is as the command was given it.
INSTEAD = "trundle export ROBOT --to c"


@dataclass(frozen=True)
class Controller:
    """One controller of ros2_controllers with its parameters, and what a person should know."""

    name: str
    kind: str
    topic: str
    parameters: Mapping[str, Any]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Fitting:
    """A robot that is to fit one controller, and how a misfit is told."""

    robot: Robot
    controller: str
    timeout: float
    limits: TwistLimits

    def joint(self, wheel: RollingWheel) -> str:
        """Return the name of the joint that rolls a wheel."""
        return joint_names(self.robot)[wheel.name].wheel

    def steering_joint(self, wheel: RollingWheel) -> str:
        """Return the name of the joint that steers a wheel."""
        return joint_names(self.robot)[wheel.name].steering

    def refuse(self, why: str) -> NoReturn:
        """Raise, saying why the robot does not fit."""
        raise TrundleError(f"robot {self.robot.name!r} does not fit {self.controller}: {why}")

    @cached_property
    def size(self) -> float:
        """The largest distance of a rolling wheel from the middle of them all [m]."""
        wheels = [wheel for wheel in self.robot.wheels if isinstance(wheel, RollingWheel)]
        x = sum(wheel.x for wheel in wheels) / len(wheels)
        y = sum(wheel.y for wheel in wheels) / len(wheels)
        return max(math.hypot(wheel.x - x, wheel.y - y) for wheel in wheels)

    def close(self, one: float, other: float) -> bool:
        """Return whether two lengths [m] are meant to be the same."""
        return abs(one - other) <= _MEANT * self.size

    def one_radius(
        self, wheels: Iterable[RollingWheel], whose: str = "the controller has one radius"
    ) -> float:
        """Return the radius that the wheels share, or refuse."""
        wheels = list(wheels)
        radii = [wheel.radius for wheel in wheels]
        if max(radii) - min(radii) > _EXACT * max(radii):
            small, large = (f(wheels, key=lambda wheel: wheel.radius) for f in (min, max))
            self.refuse(
                f"{whose} for its wheels, but that of {small.name!r} is {small.radius:g} m "
                f"and that of {large.name!r} {large.radius:g} m"
            )
        return radii[0]

    def no_limits(self) -> None:
        """Refuse limits of speed or acceleration, for controllers that have none."""
        given = [name for name in vars(self.limits) if getattr(self.limits, name) is not None]
        if given:
            self.refuse(
                f"the controller has no limits of speed or acceleration, so {given[0]} would "
                "be lost: leave it out and limit the commands before they get there"
            )

    def turn_signs(self, wheels: Iterable[RollingWheel]) -> NoReturn:
        """Refuse wheels whose sign the controller cannot turn over, and say what to do."""
        names = ", ".join(repr(wheel.name) for wheel in wheels)
        self.refuse(
            f"the controller has no sign for a wheel, and a positive speed of {names} drives the "
            "other way than it takes for granted: turn the sign of that joint over in the hardware "
            "interface, then export the robot with `reversed` changed there"
        )


def near_angle(one: float, other: float) -> bool:
    """Return whether two directions [rad] are meant to be the same, up to whole turns."""
    return abs(math.remainder(one - other, math.tau)) <= _MEANT


def speed_row(wheel: RollingWheel) -> tuple[float, float, float]:
    """Return the wheel's speed per u, v and r of the body: rolling row over gain [rad/m, rad]."""
    rows = wheel.rows()
    assert rows.rolling is not None  # every rolling wheel has one
    k_u, k_v, k_r = (float(each) / float(rows.gain) for each in rows.rolling)
    return k_u, k_v, k_r


def rounding_note(deviation: float) -> tuple[str, ...]:
    """Return a note where lengths [m] that were meant to be equal are not quite, else nothing."""
    if deviation <= _EXACT:
        return ()
    return (f"Lengths that differ by up to {deviation:.1g} m were taken as equal.",)


def to_yaml(robot: Robot, made: Controller) -> str:
    """Return the parameter file of a controller manager with one controller for the robot."""
    joints = {
        name: each.wheel.removesuffix("_joint")
        for name, each in joint_names(robot).items()
        if _is_named(each, made.parameters)
    }
    head = [
        f"Robot '{one_line(robot.name)}' for {made.name} of ros2_controllers, "
        "ROS 2 Jazzy or later.",
        *made.notes,
        *_signs_note(robot),
        *_wheel_limits_note(robot, made.name),
        *(f"Mind: {sentence}." for sentence in renamed(joints)),
        f"Commands (geometry_msgs/TwistStamped) go to {made.topic}. To start it:",
        "  ros2 run controller_manager spawner joint_state_broadcaster "
        f"{made.name} --param-file THIS_FILE",
    ]
    manager = {
        "update_rate": 100,
        "joint_state_broadcaster": {"type": "joint_state_broadcaster/JointStateBroadcaster"},
        made.name: {"type": made.kind},
    }
    lines = [f"# {line}" for line in head]
    lines += ["", "controller_manager:", "  ros__parameters:", *_lines(manager, 4)]
    lines += ["", f"{made.name}:", "  ros__parameters:", *_lines(made.parameters, 4)]
    return "\n".join(lines) + "\n"


def _is_named(joints: JointNames, parameters: Mapping[str, Any]) -> bool:
    """Return whether a controller knows a wheel's joints; casters, say, it does not."""
    named: list[Any] = []
    for value in parameters.values():
        named += value if isinstance(value, list) else [value]
    return joints.wheel in named or joints.steering in named


def _signs_note(robot: Robot) -> list[str]:
    turned = [f"'{one_line(wheel.name)}'" for wheel in robot.driven if wheel.reversed]
    if not turned:
        return []
    return [
        "Joints have the signs of the motors: a positive speed drives backwards at "
        f"{', '.join(turned)}, which must be so in hardware or simulation, too."
    ]


def _wheel_limits_note(robot: Robot, controller: str) -> list[str]:
    limited = [w.name for w in robot.driven if w.max_speed or w.max_acceleration]
    if not limited or controller == "tricycle_controller":
        return []
    return ["The controller does not know the wheels' own max_speed and max_acceleration."]


def _lines(values: Mapping[str, Any], indent: int) -> list[str]:
    lines = []
    for key, value in values.items():
        if isinstance(value, Mapping):
            lines += [f"{' ' * indent}{key}:", *_lines(value, indent + 2)]
        else:
            lines.append(f"{' ' * indent}{key}: {_scalar(value)}")
    return lines


def _scalar(value: Any) -> str:
    if isinstance(value, str):
        return yaml_string(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(map(_scalar, value)) + "]"
    return yaml_number(tidy(value)) if isinstance(value, float) else str(value)


def tidy(value: float, scale: float = 0.0) -> float:
    """Return a number without the last digits, which are rounding; 0 where the scale drowns it."""
    return 0.0 if abs(value) < 1e-12 * scale else float(f"{value:.12g}")
