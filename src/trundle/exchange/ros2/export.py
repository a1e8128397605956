"""Which controller of ros2_controllers drives a robot, and its parameter file."""

from __future__ import annotations

import math
from collections.abc import Callable

from trundle.errors import TrundleError, did_you_mean
from trundle.exchange.ros2 import differential, omnidirectional, steering
from trundle.exchange.ros2.controller import INSTEAD, Controller, Fitting, to_yaml
from trundle.limits import TwistLimits, limit_names
from trundle.robot import FixedWheel, MecanumWheel, OmniWheel, Robot, RollingWheel

_MAKERS: dict[str, Callable[[Fitting], Controller]] = {
    "diff_drive_controller": differential.diff_drive,
    "mecanum_drive_controller": omnidirectional.mecanum_drive,
    "omni_wheel_drive_controller": omnidirectional.omni_wheel_drive,
    "tricycle_controller": steering.tricycle,
    "bicycle_steering_controller": steering.bicycle_steering,
    "tricycle_steering_controller": steering.tricycle_steering,
    "ackermann_steering_controller": steering.ackermann_steering,
}


def ros2_controllers(robot: Robot, *, timeout: float = 0.5, **limits: float | None) -> str:
    """Return the YAML with which a controller of ros2_controllers drives the robot.

    The controller follows from the wheels; the names of the joints are those of the URDF. Its
    wheel commands are those of ``Kinematics.inverse``, in the motors' signs.

    Args:
        robot: the robot.
        timeout: age at which a command is stale [s].
        limits: the fields of ``trundle.limits.TwistLimits``, where the controller has them.

    Returns:
        A parameter file for ROS 2 Jazzy or later.

    Raises:
        TrundleError: no controller drives such a robot, or a limit cannot be kept; says why.

    Source: ros2_controllers 4.30 and later, the controllers' parameter files and kinematics.

    >>> import trundle
    >>> text = ros2_controllers(trundle.load("differential", track=0.4), max_speed=1.0)
    >>> "wheel_separation: 0.4" in text, "max_velocity: 1.0" in text
    (True, True)
    """
    if not isinstance(robot, Robot):
        raise TrundleError(f"give a Robot, such as load(...) gives, got {robot!r}")
    for name in limits:
        if name not in limit_names():
            raise TrundleError(f"there is no setting {name!r}{did_you_mean(name, limit_names())}")
    if isinstance(timeout, bool) or not isinstance(timeout, int | float):
        raise TrundleError(f"timeout must be a number [s], got {timeout!r}")
    if not (math.isfinite(timeout) and timeout > 0):
        raise TrundleError(f"timeout must be positive and finite, got {timeout:g} s")
    name = _controller(robot)
    made = _MAKERS[name](Fitting(robot, name, float(timeout), TwistLimits(**limits)))
    return to_yaml(robot, made)


def _controller(robot: Robot) -> str:
    """Return the name of the controller that such wheels need.

    Raises:
        TrundleError: there is none; says why.
    """
    driven = robot.driven
    if not driven:
        raise TrundleError(f"robot {robot.name!r} drives no wheel, so no controller drives it")
    if robot.steered:
        return _steering_controller(robot)
    for kind, name in (
        (FixedWheel, "diff_drive_controller"),
        (MecanumWheel, "mecanum_drive_controller"),
        (OmniWheel, "omni_wheel_drive_controller"),
    ):
        if all(isinstance(wheel, kind) for wheel in driven):
            return name
    raise _none(robot, f"it drives wheels of several kinds ({_kinds(driven)})")


def _steering_controller(robot: Robot) -> str:
    driven, steered = robot.driven, robot.steered
    if not all(isinstance(wheel, FixedWheel) or wheel.steers for wheel in driven):
        raise _none(robot, f"it steers, and drives wheels of several kinds ({_kinds(driven)})")
    if len(steered) > 2:
        raise _none(robot, f"it steers {len(steered)} wheels")
    if len(steered) == 1 and driven == steered:
        return "tricycle_controller"
    both = [wheel.name for wheel in driven if wheel.steers]
    if both:
        raise _none(robot, f"it steers and drives {', '.join(both)}, and is no tricycle")
    fitting = {
        (1, 1): "bicycle_steering_controller",
        (1, 2): "tricycle_steering_controller",
        (2, 2): "ackermann_steering_controller",
    }
    if (len(steered), len(driven)) not in fitting:
        raise _none(robot, f"it steers {len(steered)} and drives {len(driven)} wheels")
    return fitting[len(steered), len(driven)]


def _kinds(wheels: tuple[RollingWheel, ...]) -> str:
    return ", ".join(dict.fromkeys(wheel.kind for wheel in wheels))


def _none(robot: Robot, why: str) -> TrundleError:
    return TrundleError(
        f"robot {robot.name!r}: none of the ros2_controllers that trundle knows fits: {why}. "
        f"Try {INSTEAD}"
    )
