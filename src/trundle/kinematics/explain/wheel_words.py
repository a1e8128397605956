"""What one wheel does: its force line, its lever arm, the degrees of freedom it leaves."""

from __future__ import annotations

from trundle.kinematics.explain.numbers import ZERO, degrees, number, point
from trundle.robot import CasterWheel, FixedWheel, RollingWheel, Rows, SwedishWheel, Wheel
from trundle.se2 import wrap


def wheel_words(wheel: Wheel, rows: Rows, steering: float | None) -> str:
    """Return what a wheel does, for its rows and its steering angle [rad], None for no steering."""
    told = [f"{wheel.name} ({_kind(wheel, steering)}): {_push(wheel, rows, steering)}."]
    if isinstance(wheel, RollingWheel) and wheel.reversed:
        told.append("It is mounted reversed: at positive motor speed it drives backwards.")
    if wheel.sensed and not wheel.driven:
        told.append("Its turning is measured, for odometry.")
    told.append(f"Alone on the ground it has {_freedom(wheel)}.")
    return " ".join(told)


def row_direction(wheel: RollingWheel, steering: float | None) -> float:
    """Return the direction of the wheel's rolling row in the body frame, in (-pi, pi] [rad]."""
    roller = wheel.roller if isinstance(wheel, SwedishWheel) else 0.0
    return float(wrap(wheel.heading + roller + (steering or 0.0)))


def _kind(wheel: Wheel, steering: float | None) -> str:
    if isinstance(wheel, SwedishWheel):
        return f"{wheel.kind}, heading {degrees(wheel.heading)}, roller {degrees(wheel.roller)}"
    if isinstance(wheel, RollingWheel):
        turned = "" if steering is None else f", steered by {degrees(steering)}"
        skid = ", may skid" if isinstance(wheel, FixedWheel) and wheel.skid else ""
        return f"{wheel.kind}, heading {degrees(wheel.heading)}{turned}{skid}"
    return wheel.kind


def _push(wheel: Wheel, rows: Rows, steering: float | None) -> str:
    if rows.rolling is None or not isinstance(wheel, RollingWheel):
        return f"at {point(wheel)} it follows every motion and restricts none"
    if not wheel.driven:
        held = "" if rows.side_slip is None else ", and holds its point against side slip"
        return f"at {point(wheel)} it rolls freely{held}"
    at = degrees(row_direction(wheel, steering))
    line = f"it pushes along the line at {at} through {point(wheel)}"
    arm = float(rows.rolling[2])
    if abs(arm) <= ZERO:
        return f"{line}, which meets the origin: no lever arm"
    way = "counter-clockwise" if arm * rows.gain > 0 else "clockwise"
    lever = f"its lever arm about the origin is {number(abs(arm))} m"
    return f"{line}; {lever}, {way} at positive speed"


def _freedom(wheel: Wheel) -> str:
    if isinstance(wheel, SwedishWheel):
        return "3 degrees of freedom: the wheel, the roller and turning about the contact"
    if isinstance(wheel, FixedWheel) and wheel.skid:
        return "3 degrees of freedom: rolling, slipping sideways and turning about the contact"
    if isinstance(wheel, RollingWheel):
        return "2 degrees of freedom: rolling and turning about the contact"
    if isinstance(wheel, CasterWheel):
        return "3 degrees of freedom: rolling, turning about the contact and about the pivot"
    return "3 degrees of freedom: rolling in two directions and turning about the contact"
