"""Mecanum and omni robots for ``mecanum_drive_`` and ``omni_wheel_drive_controller``."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from trundle.exchange.ros2.controller import (
    Controller,
    Fitting,
    near_angle,
    rounding_note,
    speed_row,
    tidy,
)
from trundle.kinematics import Kinematics, motion_projector
from trundle.robot import MecanumWheel, OmniWheel

# Roller angles of mecanum wheels, as the controller has them: side of the body to slant.
_SLANTS = {"front_left": -1, "front_right": 1, "rear_left": 1, "rear_right": -1}


def mecanum_drive(fit: Fitting) -> Controller:
    """Return the settings of ``mecanum_drive_controller``.

    With k = ``sum_of_robot_center_projection_on_X_Y_axis`` and (x, y, theta) the base frame's
    offset, the controller turns (u, v) by theta into the frame of the wheels' centre, adds
    (y r, -x r), and gives ``(u -+ v -+ k r) / a``, with the signs - and - for front left, + and +
    for front right, - and + for rear right, + and - for rear left.

    Source: ros2_controllers, mecanum_drive_controller/src/mecanum_drive_controller.cpp.
    """
    fit.no_limits()
    wheels = [wheel for wheel in fit.robot.driven if isinstance(wheel, MecanumWheel)]
    if len(wheels) != 4:
        fit.refuse(f"the controller drives four wheels, the robot {len(wheels)}")
    radius = fit.one_radius(wheels)
    ahead = _shared_direction(fit, wheels)
    corners = _corners(fit, wheels, ahead)
    yaw = {name: radius * speed_row(wheel)[2] for name, wheel in corners.items()}
    right = yaw["rear_right"], yaw["front_right"]
    left = yaw["front_left"], yaw["rear_left"]
    arms = (right[0] - left[0]) / 2, (right[1] - left[1]) / 2
    if not fit.close(*arms):
        fit.refuse(
            "the controller has one yaw arm, half the wheelbase plus half the track; the wheels' "
            f"places give {arms[0]:g} and {arms[1]:g} m on the two diagonals"
        )
    plus, minus = (right[0] + left[0]) / 2, (right[1] + left[1]) / 2  # y + x, and y - x
    _free(fit)
    size = max(fit.size, math.hypot(plus, minus))
    x, y = (tidy(each, size) for each in ((plus - minus) / 2, (plus + minus) / 2))
    offset = {"x": x, "y": y, "theta": tidy(-ahead, 1.0)}
    parameters: dict[str, Any] = {
        f"{name}_wheel_command_joint_name": fit.joint(wheel) for name, wheel in corners.items()
    }
    parameters["kinematics"] = {
        "base_frame_offset": offset,
        "wheels_radius": radius,
        "sum_of_robot_center_projection_on_X_Y_axis": (arms[0] + arms[1]) / 2,
    }
    parameters |= {"base_frame_id": "base_link", "reference_timeout": fit.timeout}
    notes = rounding_note(abs(arms[0] - arms[1]))
    if near_angle(ahead, math.pi):
        notes += ("The wheels' forward is the body's backward: theta, and names from behind.",)
    return Controller(
        name=fit.controller,
        kind="mecanum_drive_controller/MecanumDriveController",
        topic=f"/{fit.controller}/reference",
        parameters=parameters,
        notes=notes,
    )


def _shared_direction(fit: Fitting, wheels: list[MecanumWheel]) -> float:
    """Return the direction in the body [rad] in which positive speeds of all wheels drive."""
    directions = [wheel.heading + (math.pi if wheel.reversed else 0.0) for wheel in wheels]
    # The first wheels of most robots look ahead: signs are told against the forward half.
    first = min(directions, key=lambda each: abs(math.remainder(each, math.tau)))
    other = [w for w, at in zip(wheels, directions, strict=True) if not near_angle(at, first)]
    turned = [w for w in other if near_angle(2 * w.heading, 2 * first)]
    if other and len(turned) == len(other):
        fit.turn_signs(turned)
    if other:
        fit.refuse(
            f"the controller's wheels are parallel; {other[0].name!r} drives along "
            f"{math.degrees(other[0].heading):g} deg, others along {math.degrees(first):g} deg"
        )
    return math.remainder(first, math.tau)


def _corners(fit: Fitting, wheels: list[MecanumWheel], ahead: float) -> dict[str, MecanumWheel]:
    """Return the wheel at each corner, seen with the wheels' forward in front."""
    c, s = math.cos(ahead), math.sin(ahead)
    x = sum(wheel.x for wheel in wheels) / 4
    y = sum(wheel.y for wheel in wheels) / 4
    corners = {}
    for wheel in wheels:
        front = c * (wheel.x - x) + s * (wheel.y - y) > 0
        left = c * (wheel.y - y) - s * (wheel.x - x) > 0
        corners[f"{'front' if front else 'rear'}_{'left' if left else 'right'}"] = wheel
    if len(corners) != 4:
        fit.refuse(
            "the controller has a wheel at each corner of a rectangle, front, rear, left and right"
        )
    slants = {name: math.tan(corners[name].roller) for name in _SLANTS}
    for name, slant in slants.items():
        if not near_angle(math.atan(abs(slant)), math.pi / 4):
            wheel = corners[name]
            fit.refuse(
                f"the controller's rollers are at 45 deg, those of {wheel.name!r} at "
                f"{math.degrees(wheel.roller):g} deg"
            )
    wrong = [name for name, slant in slants.items() if slant * _SLANTS[name] < 0]
    if len(wrong) == 4:
        fit.refuse(
            "the controller's rollers form an X seen from above, those of the robot an O, which "
            "leaves it the difference of track and wheelbase to turn by: swap its front wheels "
            "with the rear ones"
        )
    if wrong:
        fit.refuse(
            f"the roller of {corners[wrong[0]].name!r} slants the other way than the corner "
            f"{wrong[0].replace('_', ' ')} has it; it should be at {45 * _SLANTS[wrong[0]]} deg"
        )
    return {name: corners[name] for name in _SLANTS}


def omni_wheel_drive(fit: Fitting) -> Controller:
    """Return the settings of ``omni_wheel_drive_controller``.

    The controller gives wheel i of n, counter-clockwise, with gamma = 2 pi i / n + offset::

        (u sin(gamma) - v cos(gamma) - r d) / a

    so that positive speeds turn the robot clockwise; d is ``robot_radius``, a ``wheel_radius``.

    Source: ros2_controllers, omni_wheel_drive_controller/src/omni_wheel_drive_controller.cpp.
    """
    fit.no_limits()
    wheels = [wheel for wheel in fit.robot.driven if isinstance(wheel, OmniWheel)]
    if len(wheels) < 3:
        fit.refuse(f"the controller drives three wheels or more, the robot {len(wheels)}")
    rows = [speed_row(wheel) for wheel in wheels]
    radii = [1 / math.hypot(k_u, k_v) for k_u, k_v, _ in rows]
    if not fit.close(max(radii), min(radii)):
        fit.one_radius(wheels)
        fit.refuse("the controller has one radius for its wheels, and the roller angles differ")
    arms = [-a * k_r for a, (_, _, k_r) in zip(radii, rows, strict=True)]
    turning = [w for w, arm in zip(wheels, arms, strict=True) if arm < 0]
    if turning:
        _counter_clockwise(fit, turning, all_of_them=len(turning) == len(wheels))
    d, a = sum(arms) / len(arms), sum(radii) / len(radii)
    angles = [_from_x(math.atan2(k_u, -k_v)) for k_u, k_v, _ in rows]
    order = sorted(range(len(wheels)), key=lambda i: angles[i])
    offset = _even_offset(fit, [angles[i] for i in order])
    _one_distance(fit, wheels, arms, angles)
    _free(fit)
    return Controller(
        name=fit.controller,
        kind="omni_wheel_drive_controller/OmniWheelDriveController",
        topic=f"/{fit.controller}/cmd_vel",
        parameters={
            "wheel_offset": offset,
            "wheel_names": [fit.joint(wheels[i]) for i in order],
            "robot_radius": d,
            "wheel_radius": a,
            "base_frame_id": "base_link",
            "cmd_vel_timeout": fit.timeout,
        },
        notes=(
            "Wheels counter-clockwise; a positive speed of all of them turns the robot clockwise.",
            *rounding_note(max(abs(arm - d) for arm in arms)),
        ),
    )


def _counter_clockwise(fit: Fitting, wheels: list[OmniWheel], all_of_them: bool) -> None:
    if not all_of_them:
        fit.turn_signs(wheels)
    fit.refuse(
        "the controller's wheels turn the robot clockwise at positive speed, those of the robot "
        "counter-clockwise: turn the sign of the joints over in the hardware interface, then "
        "export the robot with `reversed` changed on every wheel"
    )


def _one_distance(
    fit: Fitting, wheels: list[OmniWheel], arms: list[float], angles: list[float]
) -> None:
    """Refuse wheels that are not as far from the origin [m], at evenly spread angles [rad]."""
    far, near = max(arms), min(arms)
    if fit.close(far, near):
        return
    centre = 2 / len(arms) * sum(cmath.rect(*each) for each in zip(arms, angles, strict=True))
    about = [arm - (centre * cmath.rect(1, -at)).real for arm, at in zip(arms, angles, strict=True)]
    why = "the controller's wheels are all as far from the body's origin; "
    if fit.close(max(about), min(about)):
        x, y = tidy(centre.real, fit.size), tidy(centre.imag, fit.size)
        fit.refuse(f"{why}take {x:g} from every x and {y:g} from every y")
    names = [wheels[arms.index(arm)].name for arm in (far, near)]
    fit.refuse(f"{why}{names[0]!r} is {far:g} m away, {names[1]!r} {near:g} m")


def _from_x(angle: float) -> float:
    """Return an angle from 0 to a turn; one that is zero but for rounding is not a whole turn."""
    turned = angle % math.tau
    return turned if turned < math.tau - 1e-9 else turned - math.tau


def _even_offset(fit: Fitting, angles: list[float]) -> float:
    """Return the angle of the first wheel, or refuse wheels that are not spread evenly."""
    step = math.tau / len(angles)
    offsets = [angle - i * step for i, angle in enumerate(angles)]
    if not all(near_angle(each, offsets[0]) for each in offsets):
        shown = ", ".join(f"{math.degrees(angle):.4g}" for angle in angles)
        fit.refuse(
            f"the controller's wheels are spread evenly, {math.degrees(step):g} deg apart; those "
            f"of the robot are at {shown} deg, by the way that they push"
        )
    return tidy(sum(offsets) / len(offsets), 1.0)


def _free(fit: Fitting) -> None:
    """Refuse a robot that cannot move in every direction, or whose odometry has no answer."""
    if round(float(np.trace(motion_projector(fit.robot, np.zeros(0))[0]))) < 3:
        held = [w.name for w in fit.robot.wheels if w.rows().side_slip or w.rows().skid]
        fit.refuse(f"{', '.join(held)} may not slip sideways, so that it is not omnidirectional")
    if np.linalg.matrix_rank(Kinematics(fit.robot).W, rtol=1e-6) < 3:
        fit.refuse("the yaw arm is zero: the wheels cannot turn the robot")
