"""Masses and inertias that a simulator takes, from those that a robot on a plane needs."""

from __future__ import annotations

from typing import NamedTuple

from trundle.robot import Body, CasterWheel, Robot, RollingWheel, SteeredWheel, Wheel

Vector = tuple[float, float, float]

# Simulators refuse a moving part without mass: those that have none share this much of the body's.
_OF_THE_BODY = 0.05
# What steers or swivels above a wheel, of the wheel's mass.
_FORK = 0.1
_WIDTH = 0.5  # of a wheel, over its radius
# Least mass [kg] and inertia [kg m^2] of a moving part: physics engines call less than this zero.
_LEAST_MASS, _LEAST_INERTIA = 1e-6, 1e-9


class Share(NamedTuple):
    """Mass [kg], centre of mass in the link's frame [m], inertia about x, y, z [kg m^2]."""

    mass: float
    at: Vector
    inertia: Vector


class Shares(NamedTuple):
    """What the body weighs, and each wheel: what rolls, and what steers above it."""

    body: Share | None
    wheels: dict[str, tuple[Share, Share | None]]


def shares(robot: Robot, radii: dict[str, float]) -> Shares:
    """Return what each link of a robot weighs; together they weigh what the robot does.

    Only the robot's masses and inertias about the vertical and about axles are its own. The
    others are those of a box and of cylinders; no simulator refuses them.
    """
    light = {wheel.name for wheel in robot.wheels if wheel.kind != "ball" and wheel.mass == 0}
    body_mass = robot.body.mass if robot.body is not None else None
    spare = _OF_THE_BODY * (body_mass or 0.0) / len(light) if light else 0.0
    wheels = {
        wheel.name: _wheel(wheel, wheel.mass or spare, radii[wheel.name])
        for wheel in robot.wheels
        if wheel.mass > 0 or (spare > 0 and wheel.name in light)
    }
    if robot.body is None or body_mass is None:
        return Shares(None, wheels)
    return Shares(_body(robot, robot.body, body_mass, 1 - _OF_THE_BODY * bool(light)), wheels)


def _wheel(wheel: Wheel, mass: float, radius: float) -> tuple[Share, Share | None]:
    """Return a wheel's mass as a cylinder about y, with the inertias that the wheel has."""
    forked = isinstance(wheel, SteeredWheel | CasterWheel)
    fork = _FORK * mass if forked else 0.0
    rolling = max(mass - fork, _LEAST_MASS)
    width = _WIDTH * radius
    across = rolling * (3 * radius * radius + width * width) / 12
    spin = getattr(wheel, "spin_inertia", 0.0) or rolling * radius * radius / 2
    # A solid's greatest inertia is at most the sum of the others; a geared rotor's makes it more.
    yaw = max(wheel.yaw_inertia or across, 0.51 * spin, _LEAST_INERTIA)
    if not isinstance(wheel, RollingWheel | CasterWheel):
        spin = yaw
    cylinder = Share(rolling, (0.0, 0.0, 0.0), (yaw, max(spin, _LEAST_INERTIA), yaw))
    if not forked:
        return cylinder, None
    ball = max(0.1 * fork * radius * radius, _LEAST_INERTIA)  # a ball of half the wheel's radius
    return cylinder, Share(max(fork, _LEAST_MASS), (0.0, 0.0, 0.0), (ball, ball, ball))


def _body(robot: Robot, body: Body, mass: float, factor: float) -> Share:
    """Return the body's share, with its centre of mass as high as the largest axle."""
    length, width = body.length or robot.reach, body.width or robot.reach
    square = length * length + width * width
    yaw = body.inertia or mass * square / 12
    x, y = body.com or (body.x, body.y)
    height = max(getattr(wheel, "radius", None) or 0.0 for wheel in robot.wheels)
    # A plate's inertias about its sides add up to that about its normal; its height adds to both.
    tall = mass * height * height / 12
    about_x = yaw * (width * width / square) + tall
    about_y = yaw * (length * length / square) + tall
    ixx, iyy, izz = (max(factor * each, _LEAST_INERTIA) for each in (about_x, about_y, yaw))
    return Share(factor * mass, (x, y, height), (ixx, iyy, izz))
