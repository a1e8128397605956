"""The geometry doctor's look at each wheel: rollers, spin signs, positions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from trundle.kinematics.finding import Finding
from trundle.kinematics.words import join
from trundle.robot import Robot, RollingWheel, SwedishWheel
from trundle.se2 import Array

# A roller within 10 degrees of the drive direction turns most of the motor's force into nothing.
_WEAK_PUSH = math.cos(math.radians(80))
# Rollers within 10 degrees of an omni wheel's are not slanted.
_SLANTED = math.radians(10)
# Two lever arms that differ by less than a hundredth are the same by design.
_CLEARLY = 0.99


def yaw_arm_cancels(robot: Robot) -> Iterator[Finding]:
    """Mecanum rollers for which the yaw arm is |d - l| where d + l could be."""
    slanted = [
        wheel
        for wheel in robot.wheels
        if isinstance(wheel, SwedishWheel) and abs(math.tan(wheel.roller)) > math.tan(_SLANTED)
    ]
    if not slanted:
        return
    centre = np.mean([(wheel.x, wheel.y) for wheel in slanted], axis=0)
    arms = np.array(
        [[abs(_yaw_arm(w, sign * w.roller, centre)) for sign in (1, -1)] for w in slanted]
    )
    short = arms[:, 0] < _CLEARLY * arms[:, 1]
    if short.any():
        names = tuple(w.name for w, is_short in zip(slanted, short, strict=True) if is_short)
        arm, mirrored = arms[short].min(axis=0).round(9)
        yield Finding(
            "yaw_arm_cancels",
            f"the rollers of {join(names)} are mounted so that the two parts of the yaw arm "
            f"cancel: it is |d - l| = {arm:.3g} m, and the robot turns badly, or not at all near "
            "zero",
            f"mirror these rollers (change the sign of roller_deg, swap left and right wheels): "
            f"the arm becomes d + l = {mirrored:.3g} m",
            names,
        )


def _yaw_arm(wheel: SwedishWheel, roller: float, centre: Array) -> float:
    """Return the yaw arm of the rolling row about a centre, in rim speeds [m]."""
    angle = wheel.heading + roller
    x, y = wheel.x - centre[0], wheel.y - centre[1]
    return float((x * math.sin(angle) - y * math.cos(angle)) / math.cos(roller))


def cannot_push(robot: Robot) -> Iterator[Finding]:
    """Driven wheels whose rollers turn almost along the drive direction."""
    for wheel in robot.driven:
        if isinstance(wheel, SwedishWheel) and abs(math.cos(wheel.roller)) < _WEAK_PUSH:
            yield Finding(
                "cannot_push",
                f"wheel {wheel.name!r} can hardly push: with rollers at "
                f"{math.degrees(wheel.roller):g} deg only {abs(math.cos(wheel.roller)):.2g} of a "
                "force along its rollers' axes comes from the motor",
                "roller_deg is the angle from the drive direction to the roller's axis: 0 for "
                "omni wheels, usually +-45 for mecanum",
                (wheel.name,),
            )


def outside_body(robot: Robot) -> Iterator[Finding]:
    """Wheels beside the body's outline, as when the full track was taken for half of it."""
    if robot.body is None or robot.body.width is None:
        return
    half = robot.body.width / 2
    names = tuple(w.name for w in robot.wheels if abs(w.y - robot.body.y) > half)
    if names:
        far = max(abs(w.y - robot.body.y) for w in robot.wheels)
        yield Finding(
            "outside_body",
            f"{join(names)} stand outside the body: |y| is up to {far:g} m, and half the body's "
            f"width is {half:g} m",
            "y is measured from the middle of the robot: half the track, not the full one",
            names,
        )


def mass_outside(robot: Robot) -> Iterator[Finding]:
    """A body whose inertia is more than its outline can hold."""
    body = robot.body
    if body is None or body.length is None or body.width is None:
        return
    if body.mass is None or body.inertia is None or body.com is None:
        return
    x, y = body.com
    far = math.hypot(body.length / 2 + abs(x - body.x), body.width / 2 + abs(y - body.y))
    if body.inertia > body.mass * far**2:
        yield Finding(
            "mass_outside",
            f"the body's inertia of {body.inertia:g} kg m^2 cannot be: with all of its "
            f"{body.mass:g} kg in the farthest corner of its outline it would be "
            f"{body.mass * far**2:.3g} kg m^2",
            "inertia is in kg m^2, about the vertical through the centre of mass",
            (),
        )


def reversed_suspect(robot: Robot) -> Iterator[Finding]:
    """Wheels whose spin sign differs from that of the wheels like them."""
    kinds = {wheel.kind for wheel in robot.driven}
    for kind in sorted(kinds):
        alike = [wheel for wheel in robot.driven if wheel.kind == kind and not wheel.steers]
        odd = _odd_ones(alike)
        if odd:
            names = tuple(wheel.name for wheel in odd)
            yield Finding(
                "reversed_suspect",
                f"{join(names)} spin{'s' * (len(names) == 1)} against the other {kind} wheels "
                "that stand alike",
                "turn each motor slowly forwards and look: set reversed = true for the wheels "
                "that then drive against their heading, and only for them",
                names,
            )


def _odd_ones(wheels: Sequence[RollingWheel]) -> list[RollingWheel]:
    """Return the wheels whose spin looks mirrored among wheels that stand alike."""
    if len(wheels) < 3:
        return []
    drive = np.array([_drive_direction(wheel) for wheel in wheels])
    place = np.array([(wheel.x, wheel.y) for wheel in wheels])
    place = place - place.mean(axis=0)
    across = np.array([-drive[0, 1], drive[0, 0]])
    if np.abs(drive @ across).max() < 1e-6:
        return _odd_along_a_line(wheels, drive @ drive[0], place @ across)
    moments = place[:, 0] * drive[:, 1] - place[:, 1] * drive[:, 0]
    if np.abs(moments).min() < 0.5 * np.abs(moments).max():
        return []
    return _minority(wheels, np.sign(moments))


def _odd_along_a_line(
    wheels: Sequence[RollingWheel], along: Array, across: Array
) -> list[RollingWheel]:
    """Parallel wheels: motors of one side may all be mirrored, but one side must agree."""
    odd = []
    majority = np.sign(along.round().sum())
    for side in (across > 0, across < 0):
        signs = along[side].round()
        if len(set(signs.tolist())) < 2:
            continue
        members = [wheel for wheel, here in zip(wheels, side, strict=True) if here]
        found = _minority(members, signs)
        against = [w for w, s in zip(members, signs, strict=True) if s != (majority or 1)]
        odd += found or against
    return odd


def _minority(wheels: Sequence[RollingWheel], signs: Array) -> list[RollingWheel]:
    total = signs.sum()
    return [w for w, s in zip(wheels, signs, strict=True) if s * total < 0]


def _drive_direction(wheel: RollingWheel) -> tuple[float, float]:
    """Return where the contact point is driven by positive motor speed."""
    sign = wheel.spin_sign
    return sign * math.cos(wheel.heading), sign * math.sin(wheel.heading)
