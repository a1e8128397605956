"""The robots that the laws hold for: the whole catalogue and some awkward mixtures.

With each goes the space of twists that it can have, told by hand from its geometry.
"""

import dataclasses
import math
from collections.abc import Callable, Iterable
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from geometry import allowed_twists
from trundle.robot import (
    CATALOG,
    BallWheel,
    CasterWheel,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
    SwedishWheel,
    Wheel,
)

Floats = NDArray[np.float64]
BATCH_SHAPES = ((), (5,), (2, 3))

ODD_OMNI = Robot(
    name="odd_omni",  # uneven radii, rollers and headings; two wheels reversed; far from the origin
    wheels=(
        OmniWheel(name="a", x=1.3, y=0.4, radius=0.05, heading=0.3),
        OmniWheel(name="b", x=1.1, y=-0.2, radius=0.08, heading=2.0, reversed=True),
        MecanumWheel(name="c", x=0.7, y=0.1, radius=0.06, heading=-1.2, roller=0.6, reversed=True),
        OmniWheel(name="d", x=0.9, y=0.5, radius=0.11, heading=3.0, roller=-0.2),
        MecanumWheel(name="loose", x=0.2, y=0.0, radius=0.06, roller=-0.9, driven=False),
    ),
)
ODD_SWERVE = Robot(
    name="odd_swerve",  # modules whose zero is not forward; one without a motor
    wheels=(
        SteeredWheel(name="a", x=-0.9, y=0.6, radius=0.07, heading=1.1),
        SteeredWheel(name="b", x=-1.4, y=0.5, radius=0.05, heading=-2.0, reversed=True),
        SteeredWheel(name="c", x=-1.0, y=1.1, radius=0.09, heading=0.4, driven=False),
        BallWheel(name="ball", x=-1.1, y=0.7),
    ),
)
ODD_DIFFERENTIAL = Robot(
    name="odd_differential",  # drives along 40 deg, beside the origin, uneven radii
    wheels=(
        FixedWheel(name="left", x=0.2, y=0.9, radius=0.06, heading=math.radians(40)),
        FixedWheel(
            name="right",
            x=0.2 + 0.5 * math.sin(math.radians(40)),
            y=0.9 - 0.5 * math.cos(math.radians(40)),
            radius=0.05,
            heading=math.radians(220),
            reversed=True,
        ),
        CasterWheel(name="caster", x=-0.1, y=0.3, radius=0.02, trail=0.03, heading=0.5),
    ),
)
ODD_OMNI_STEER = Robot(
    name="odd_omni_steer",
    wheels=(
        OmniWheel(name="a", x=0.3, y=0.5, radius=0.05, heading=0.7, reversed=True),
        SteeredWheel(name="b", x=-0.4, y=0.1, radius=0.09, heading=-0.5),
        OmniWheel(name="c", x=0.1, y=-0.6, radius=0.04, heading=1.9),
        CasterWheel(name="caster", x=0.0, y=0.0, radius=0.02),
    ),
)
SKEW_SKID = Robot(
    name="skew_skid",  # a six-wheel skid-steer about a point behind the origin
    wheels=tuple(
        FixedWheel(name=f"{x}{y}", x=x - 0.4, y=y, radius=0.1, skid=True, track_factor=1.4)
        for x in (-0.3, 0.1, 0.35)
        for y in (0.25, -0.25)
    ),
)
# The rear wheel steers half as far as the front one, the other way: the twists form a curved cone.
CURVED_RATIOS = (1.0, -0.5)
CURVED = Robot(
    name="curved",
    wheels=(
        SteeredWheel(name="front", x=0.6, y=0.0, radius=0.1, steering_group="g"),
        SteeredWheel(
            name="rear",
            x=-0.4,
            y=0.0,
            radius=0.08,
            reversed=True,
            steering_group="g",
            steering_ratio=CURVED_RATIOS[1],
        ),
    ),
)

ROBOTS: dict[str, Robot] = {name: trundle.load(name) for name in CATALOG} | {
    robot.name: robot
    for robot in (ODD_OMNI, ODD_SWERVE, ODD_DIFFERENTIAL, ODD_OMNI_STEER, SKEW_SKID, CURVED)
}
each_robot = pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
each_plane_robot = pytest.mark.parametrize(
    "robot",
    [r for r in ROBOTS.values() if r is not CURVED],
    ids=[n for n in ROBOTS if n != "curved"],
)
each_steered = pytest.mark.parametrize(
    "robot",
    [r for r in ROBOTS.values() if r.steered],
    ids=[n for n, r in ROBOTS.items() if r.steered],
)


def several(robot: Robot, count: int) -> int:
    """Return how many twists to look at: few where each inverse is a search."""
    return 1 if robot is CURVED else count


@cache
def kinematics(robot: Robot) -> trundle.Kinematics:
    """Return the robot's kinematics, made once for all tests."""
    return trundle.Kinematics(robot)


def twist_space(robot: Robot) -> Floats:
    """Return a basis (3, k) of the twists that the robot can have, told by hand."""
    if robot.name in ("synchro",):  # all wheels parallel
        return np.eye(3)[:, :2]
    if robot.name in ("four_wheel_steered",):  # the centre lies on the y axis
        return np.eye(3)[:, [0, 2]]
    rigid = [wheel for wheel in robot.wheels if not wheel.steers]
    return allowed_twists(Robot(name="rigid", wheels=(*rigid, _BALL)), [])


_BALL = BallWheel(name="\0nothing", x=0.0, y=0.0)


def feasible_twists(robot: Robot, shape: tuple[int, ...], seed: int = 7) -> Floats:
    """Return random twists (*shape, 3) that the robot can have."""
    random = np.random.default_rng(seed)
    if robot is CURVED:
        twists = np.empty((*shape, 3))
        for at in np.ndindex(shape):
            angle = random.uniform(-1.2, 1.2)
            N = allowed_twists(robot, [ratio * angle for ratio in CURVED_RATIOS])
            twists[at] = N[:, 0] * random.uniform(0.5, 2.0)
        return twists
    space = twist_space(robot)
    return random.normal(size=(*shape, space.shape[1])) @ space.T


def steering_for(robot: Robot, twist: Floats) -> Floats:
    """Return steering angles (..., s) for feasible twists (..., 3), by atan2 of the velocities."""
    out = np.empty((*twist.shape[:-1], len(robot.steered)))
    for i, wheel in enumerate(robot.steered):
        along_x = twist[..., 0] - twist[..., 2] * wheel.y
        along_y = twist[..., 1] + twist[..., 2] * wheel.x
        out[..., i] = np.arctan2(along_y, along_x) - wheel.heading
    if robot is CURVED:  # the half turn that keeps the two angles linked
        front = np.arctan(np.tan(out[..., 0]))
        out = np.stack([front, CURVED_RATIOS[1] * front], axis=-1)
    return out


# ---- the same robot described otherwise ----------------------------------------------------


def with_each_wheel(robot: Robot, change: Callable[[Wheel], dict[str, object]]) -> Robot:
    """Return the robot with fields of each wheel changed, without its body outline."""
    wheels = tuple(dataclasses.replace(wheel, **change(wheel)) for wheel in robot.wheels)
    return dataclasses.replace(robot, wheels=wheels, body=None)


def seen_from(robot: Robot, x: float, y: float, angle: float) -> Robot:
    """Return the robot described in a frame that lies at (x, y, angle) in its body frame."""
    c, s = math.cos(angle), math.sin(angle)

    def change(wheel: Wheel) -> dict[str, object]:
        dx, dy = wheel.x - x, wheel.y - y
        place: dict[str, object] = {"x": c * dx + s * dy, "y": -s * dx + c * dy}
        if hasattr(wheel, "heading"):
            place["heading"] = wheel.heading - angle
        return place

    return with_each_wheel(robot, change)


def mirrored(robot: Robot) -> Robot:
    """Return the robot mirrored about its x axis."""

    def change(wheel: Wheel) -> dict[str, object]:
        new: dict[str, object] = {"y": -wheel.y}
        if hasattr(wheel, "heading"):
            new["heading"] = -wheel.heading
        if isinstance(wheel, SwedishWheel):
            new["roller"] = -wheel.roller
        return new

    return with_each_wheel(robot, change)


def scaled(robot: Robot, size: float) -> Robot:
    """Return the robot with all lengths scaled."""

    def change(wheel: Wheel) -> dict[str, object]:
        lengths = ("x", "y", "radius", "trail")
        return {
            name: size * getattr(wheel, name)
            for name in lengths
            if getattr(wheel, name, None) is not None
        }

    return with_each_wheel(robot, change)


def reordered(robot: Robot, order: Iterable[int]) -> Robot:
    """Return the robot with its wheels in another order."""
    wheels = tuple(robot.wheels[i] for i in order)
    return dataclasses.replace(robot, wheels=wheels)


def all_reversed(robot: Robot) -> Robot:
    """Return the robot with every motor's sign turned round."""
    return with_each_wheel(
        robot, lambda wheel: {"reversed": not wheel.reversed} if hasattr(wheel, "reversed") else {}
    )
