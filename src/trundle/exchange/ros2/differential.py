"""Differential and skid-steer robots for ``diff_drive_controller``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle.exchange.ros2.controller import (
    Controller,
    Fitting,
    near_angle,
    rounding_note,
    speed_row,
)
from trundle.kinematics import motion_projector
from trundle.limits import TwistLimits
from trundle.robot import FixedWheel, RollingWheel


def diff_drive(fit: Fitting) -> Controller:
    """Return the settings of ``diff_drive_controller`` for a robot driven by fixed wheels.

    The controller gives the left wheels ``(u - r s/2) / (m_l a)`` and the right ones
    ``(u + r s/2) / (m_r a)``, with s the separation times its multiplier, a the radius and m the
    radius multipliers of the sides: a side that is reversed has a negative one.

    Source: ros2_controllers, diff_drive_controller/src/diff_drive_controller.cpp, and
    diff_drive_controller_parameter.yaml.
    """
    left, right = _sides(fit)
    arms = [_arm(wheel) for wheel in (*left, *right)]
    factor = _factor(fit, [*left, *right])
    radii = [_signed_radius(fit, side) for side in (left, right)]
    _stands_on_its_axle(fit)
    radius = abs(radii[0])
    multipliers = {"left_wheel_radius_multiplier": radii[0] / radius}
    multipliers["right_wheel_radius_multiplier"] = radii[1] / radius
    arm = sum(arms) / len(arms)
    parameters: dict[str, Any] = {
        "left_wheel_names": [fit.joint(wheel) for wheel in left],
        "right_wheel_names": [fit.joint(wheel) for wheel in right],
        "wheel_separation": 2 * arm,
        "wheel_radius": radius,
    }
    if factor != 1:
        parameters["wheel_separation_multiplier"] = factor
    parameters |= {name: value for name, value in multipliers.items() if value != 1}
    parameters |= {"base_frame_id": "base_link", "cmd_vel_timeout": fit.timeout}
    notes = rounding_note(max(abs(each - arm) for each in arms))
    if min(radii) < 0:
        notes += ("A negative radius multiplier turns the sign of that side's joints over.",)
    return Controller(
        name=fit.controller,
        kind="diff_drive_controller/DiffDriveController",
        topic=f"/{fit.controller}/cmd_vel",
        parameters=parameters | _limits(fit, fit.limits),
        notes=notes,
    )


def _arm(wheel: RollingWheel) -> float:
    return abs(wheel.y)


def _sides(fit: Fitting) -> tuple[list[FixedWheel], list[FixedWheel]]:
    """Return the wheels to the left and to the right, which stand as the controller expects."""
    wheels = [wheel for wheel in fit.robot.driven if isinstance(wheel, FixedWheel)]
    for wheel in wheels:
        if not (near_angle(wheel.heading, 0.0) or near_angle(wheel.heading, math.pi)):
            fit.refuse(
                f"wheel {wheel.name!r} drives along {math.degrees(wheel.heading):g} deg of the "
                "body, the controller's wheels along x: turn the body frame so that x points there"
            )
    left = [wheel for wheel in wheels if wheel.y > 0]
    right = [wheel for wheel in wheels if wheel.y < 0]
    if len(left) != len(right) or len(left) + len(right) != len(wheels):
        fit.refuse(
            "the controller needs as many driven wheels left of the body's x axis as right of it, "
            f"got {len(left)} and {len(right)} of {len(wheels)}"
        )
    for name, side in (("left", left), ("right", right)):
        far, near = max(map(_arm, side)), min(map(_arm, side))
        if not fit.close(far, near):
            fit.refuse(
                f"the controller has one wheel separation, but the wheels on the {name} are "
                f"{near:g} and {far:g} m from the x axis"
            )
    shift = (left[0].y + right[0].y) / 2
    if not fit.close(left[0].y, -right[0].y):
        fit.refuse(
            "the controller's base frame is midway between the wheels, the body's origin is not: "
            f"take {shift:g} from every y"
        )
    return left, right


def _factor(fit: Fitting, wheels: Sequence[FixedWheel]) -> float:
    factors = sorted({wheel.track_factor for wheel in wheels})
    if len(factors) > 1:
        fit.refuse(
            f"the controller has one separation multiplier, but the track factors are {factors}"
        )
    return factors[0]


def _signed_radius(fit: Fitting, side: Sequence[FixedWheel]) -> float:
    """Return the radius of a side's wheels, negative where positive speed drives backwards."""
    radius = fit.one_radius(side, "the controller has one radius on a side")
    backwards = [wheel for wheel in side if speed_row(wheel)[0] < 0]
    if backwards and len(backwards) < len(side):
        fit.turn_signs(backwards)
    return -radius if backwards else radius


def _stands_on_its_axle(fit: Fitting) -> None:
    """Refuse a robot whose origin slips sideways, or that cannot turn."""
    held = motion_projector(fit.robot, np.zeros(0))[0]
    motions = round(float(np.trace(held)))
    if motions == 1:
        fit.refuse(
            "its fixed wheels, which may not slip sideways, keep it from turning: give skid = true "
            "to those that do slip"
        )
    if motions == 3:
        fit.refuse("nothing keeps the robot from slipping sideways")
    axle = -float(held[1, 2] / held[2, 2])
    if not fit.close(axle, 0.0):
        fit.refuse(
            "the controller's base frame is the point of the axle about which the robot turns, and "
            f"that is at x = {axle:g} m of the body: take {axle:g} from every x"
        )


def _limits(fit: Fitting, limits: TwistLimits) -> dict[str, Any]:
    """Return the limits of the controller, which are signed; a limit ahead has one in reverse."""
    for name, needed in _NEEDS.items():
        if getattr(limits, name) is not None and getattr(limits, needed) is None:
            fit.refuse(f"the controller keeps {name} only where {needed} is given, too")
    linear = {
        "max_velocity": limits.max_speed,
        "min_velocity": _minus(limits.max_reverse_speed),
        "max_acceleration": limits.max_acceleration,
        "max_deceleration": _minus(limits.max_deceleration),
        "max_acceleration_reverse": _minus(limits.max_reverse_acceleration),
        "max_deceleration_reverse": limits.max_reverse_deceleration,
        "max_jerk": limits.max_jerk,
        "min_jerk": _minus(limits.max_jerk),
    }
    angular = {
        "max_velocity": limits.max_yaw_rate,
        "min_velocity": _minus(limits.max_yaw_rate),
        "max_acceleration": limits.max_yaw_acceleration,
        "max_deceleration": _minus(limits.max_yaw_deceleration),
        "max_acceleration_reverse": _minus(limits.max_yaw_acceleration),
        "max_deceleration_reverse": limits.max_yaw_deceleration,
        "max_jerk": limits.max_yaw_jerk,
        "min_jerk": _minus(limits.max_yaw_jerk),
    }
    given = {"linear": {"x": _given(linear)}, "angular": {"z": _given(angular)}}
    return {name: axes for name, axes in given.items() if any(axes.values())}


# A limiter of the controller works only where its limit ahead is given.
_NEEDS = {
    "max_reverse_speed": "max_speed",
    "max_deceleration": "max_acceleration",
    "max_reverse_acceleration": "max_acceleration",
    "max_reverse_deceleration": "max_acceleration",
    "max_yaw_deceleration": "max_yaw_acceleration",
}


def _minus(limit: float | None) -> float | None:
    return None if limit is None else -limit


def _given(limits: dict[str, float | None]) -> dict[str, float]:
    return {name: limit for name, limit in limits.items() if limit is not None}
