"""Robots with steered front wheels for the tricycle, bicycle and Ackermann controllers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from trundle.exchange.ros2.controller import INSTEAD, Controller, Fitting, near_angle, speed_row
from trundle.robot import FixedWheel, RollingWheel, SteeredWheel


def tricycle(fit: Fitting) -> Controller:
    """Return the settings of ``tricycle_controller``: one front wheel steers and drives.

    With L the wheelbase: steering angle ``atan(r L / u)``, wheel speed ``u / (a cos(angle))``.

    Source: ros2_controllers, tricycle_controller/src/tricycle_controller.cpp, twist_to_ackermann.
    """
    (front,) = fit.robot.steered
    wheelbase = _wheelbase(fit)
    _in_the_middle(fit, front)
    _forwards(fit, [front])
    parameters: dict[str, Any] = {
        "traction_joint_name": fit.joint(front),
        "steering_joint_name": fit.steering_joint(front),
        "wheelbase": wheelbase,
        "wheel_radius": front.radius,
        "base_frame_id": "base_link",
        "enable_odom_tf": True,
        "cmd_vel_timeout": max(round(1000 * fit.timeout), 1),
    }
    return Controller(
        name=fit.controller,
        kind="tricycle_controller/TricycleController",
        topic=f"/{fit.controller}/cmd_vel",
        parameters=parameters | _tricycle_limits(fit, front),
        notes=("cmd_vel_timeout is in milliseconds here; limits are the front wheel's.",),
    )


def _tricycle_limits(fit: Fitting, front: SteeredWheel) -> dict[str, Any]:
    """Return limits of the front wheel [rad/s, rad/s^2, rad], speeds alike in both directions."""
    limits = fit.limits
    for name in ("max_yaw_rate", "max_yaw_acceleration", "max_yaw_deceleration", "max_yaw_jerk"):
        if getattr(limits, name) is not None:
            fit.refuse(
                f"the controller limits the front wheel, not the yaw, so {name} would be lost"
            )
    if limits.max_deceleration is not None and limits.max_acceleration is None:
        fit.refuse("the controller takes max_deceleration with max_acceleration only")
    for name in ("speed", "acceleration", "deceleration"):
        ahead, back = (getattr(limits, f"max_{which}{name}") for which in ("", "reverse_"))
        if ahead != back:
            fit.refuse(
                f"the controller has no limits of its own in reverse: not max_reverse_{name}"
            )
    a = front.radius
    traction = {
        "max_velocity": _least(limits.max_speed and limits.max_speed / a, front.max_speed),
        "max_acceleration": _least(
            limits.max_acceleration and limits.max_acceleration / a, front.max_acceleration
        ),
        "max_deceleration": _least(
            limits.max_deceleration and limits.max_deceleration / a, front.max_acceleration
        ),
        "max_jerk": limits.max_jerk and limits.max_jerk / a,
    }
    low, high = front.steering_range
    steering = {"max_velocity": front.steering_rate}
    if math.isfinite(low) or math.isfinite(high):  # it never asks for more than a quarter turn
        steering["min_position"] = max(low, -math.pi / 2)
        steering["max_position"] = min(high, math.pi / 2)
    given = {
        name: {key: value for key, value in group.items() if value is not None}
        for name, group in (("traction", traction), ("steering", steering))
    }
    return {name: group for name, group in given.items() if group}


def _least(*limits: float | None) -> float | None:
    given = [limit for limit in limits if limit is not None]
    return min(given) if given else None


def bicycle_steering(fit: Fitting) -> Controller:
    """Return the settings of ``bicycle_steering_controller``: one wheel drives, one steers.

    With L the wheelbase: steering angle ``atan(r L / u)``, wheel speed ``u / a``.

    Source: ros2_controllers, steering_controllers_library, steering_kinematics, BICYCLE_CONFIG.
    """
    rear = fit.robot.driven
    if not fit.close(rear[0].y, 0.0):
        fit.refuse(
            f"the controller drives a wheel on the x axis, {rear[0].name!r} has y = {rear[0].y:g} m"
        )
    (front,) = fit.robot.steered
    _in_the_middle(fit, front)
    more = {"wheelbase": _wheelbase(fit), "traction_wheel_radius": rear[0].radius}
    return _from_library(fit, "bicycle_steering_controller/BicycleSteeringController", more)


def tricycle_steering(fit: Fitting) -> Controller:
    """Return the settings of ``tricycle_steering_controller``: two wheels drive, one steers.

    With R = u / r: the angle as on a bicycle, right and left speeds ``(u / a) (R +- track/2) / R``.

    Source: ros2_controllers, steering_controllers_library, steering_kinematics, TRICYCLE_CONFIG.
    """
    (front,) = fit.robot.steered
    _in_the_middle(fit, front)
    more = {
        "wheelbase": _wheelbase(fit),
        "traction_track_width": _track(fit, fit.robot.driven),
        "traction_wheels_radius": fit.one_radius(fit.robot.driven),
    }
    return _from_library(fit, "tricycle_steering_controller/TricycleSteeringController", more)


def ackermann_steering(fit: Fitting) -> Controller:
    """Return the settings of ``ackermann_steering_controller``: two wheels drive, two steer.

    Speeds as on a tricycle with two driven wheels; each front wheel's angle is exact.

    Source: ros2_controllers, steering_controllers_library, steering_kinematics, ACKERMANN_CONFIG.
    """
    wheelbase = _wheelbase(fit)
    groups = [wheel.steering_group for wheel in fit.robot.steered]
    if groups[0] is not None and groups[0] == groups[1]:
        fit.refuse("the controller steers the two wheels apart, those of the robot are linked")
    tracks = _track(fit, fit.robot.driven), _track(fit, fit.robot.steered)
    more = {"wheelbase": wheelbase, "traction_track_width": tracks[0]}
    more["steering_track_width"] = tracks[1]
    more["traction_wheels_radius"] = fit.one_radius(fit.robot.driven)
    return _from_library(fit, "ackermann_steering_controller/AckermannSteeringController", more)


def _from_library(fit: Fitting, kind: str, more: dict[str, float]) -> Controller:
    """Return a controller of steering_controllers_library: joints right, then left."""
    fit.no_limits()
    driven = sorted(fit.robot.driven, key=lambda wheel: wheel.y)
    _forwards(fit, driven)
    notes = ["Joints right, then left. The controller knows no limits of speed or steering."]
    if len(driven) > 1:
        notes.append("It cannot turn about the middle of its rear axle: u = 0 stops its wheels.")
    return Controller(
        name=fit.controller,
        kind=kind,
        topic=f"/{fit.controller}/reference",
        parameters={
            "traction_joints_names": [fit.joint(wheel) for wheel in driven],
            "steering_joints_names": [
                fit.steering_joint(wheel) for wheel in sorted(fit.robot.steered, key=lambda w: w.y)
            ],
            **more,
            "base_frame_id": "base_link",
            "reference_timeout": fit.timeout,
        },
        notes=tuple(notes),
    )


def _wheelbase(fit: Fitting) -> float:
    """Return how far the steered wheels are ahead of the fixed ones, which are at x = 0."""
    fixed = [wheel for wheel in fit.robot.wheels if isinstance(wheel, FixedWheel)]
    if not fixed:
        fit.refuse("the controller needs an axle of fixed wheels, the robot has none")
    for wheel in fixed:
        if not near_angle(2 * wheel.heading, 0.0) or wheel.skid:
            fit.refuse(
                f"its fixed wheels must roll along x without side slip, not so {wheel.name!r}"
            )
        if not fit.close(wheel.x, fixed[0].x):
            fit.refuse(
                f"its fixed wheels must be on one axle; {fixed[0].name!r} and {wheel.name!r} are "
                f"at x = {fixed[0].x:g} and {wheel.x:g} m"
            )
    if not fit.close(fixed[0].x, 0.0):
        fit.refuse(
            f"the controller's base frame is on the axle of the fixed wheels, and that is at x = "
            f"{fixed[0].x:g} m of the body: take {fixed[0].x:g} from every x"
        )
    for front in fit.robot.steered:
        if not near_angle(front.heading, 0.0):
            fit.refuse(
                f"steering angle 0 must be straight ahead; {front.name!r} then points along "
                f"{math.degrees(front.heading):g} deg"
            )
    ends = [wheel.x for wheel in fit.robot.steered]
    if not fit.close(max(ends), min(ends)):
        fit.refuse(f"its steered wheels must be abreast, they are at x = {ends} m")
    if min(ends) <= 0:
        fit.refuse(
            "the controller's steered wheels are ahead of the fixed axle; behind it, as those of "
            f"the robot, they turn it the other way: try {INSTEAD}"
        )
    return sum(ends) / len(ends)


def _in_the_middle(fit: Fitting, wheel: RollingWheel) -> None:
    if not fit.close(wheel.y, 0.0):
        fit.refuse(
            f"the controller steers a wheel on the x axis, {wheel.name!r} is at y = {wheel.y:g} m"
        )


def _track(fit: Fitting, pair: Sequence[RollingWheel]) -> float:
    """Return the distance between two wheels that are as far left as right of the x axis."""
    right, left = sorted(pair, key=lambda wheel: wheel.y)
    if left.y <= 0 or not fit.close(left.y, -right.y):
        fit.refuse(
            "the controller's base frame is midway between the wheels; "
            f"{left.name!r} and {right.name!r} are at y = {left.y:g} and {right.y:g} m"
        )
    return left.y - right.y


def _forwards(fit: Fitting, wheels: Sequence[RollingWheel]) -> None:
    if backwards := [wheel for wheel in wheels if speed_row(wheel)[0] < 0]:
        fit.turn_signs(backwards)
