"""What joints and links say of one wheel: where it stands, which way it drives, how large it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from trundle.robot.quantity import exact_degrees
from trundle.robot.urdf.pose import UP, Pose, Vector, dot, plus, times
from trundle.robot.urdf.text import shown
from trundle.robot.urdf.tree import Joint, Shape, Tree

# Axes are written with angles such as 1.57, or lean a little (camber): this far [rad] from upright
# or level still counts.
LEAN = 0.05
# A wheel's cylinder may be this much of its radius beside the axis, from rounded drawings.
_ECCENTRIC = 0.1


@dataclass(frozen=True)
class Seen:
    """What a URDF says of a wheel.

    Attributes:
        joint: the joint about the wheel's axle (of a ball: the joint that fixes it).
        steering: the nearest joint above it that turns about a vertical axis.
        others: further joints above it that move, such as a suspension's.
        centre: the wheel's centre in the base frame [m].
        heading: the direction in which a positive turn drives, or a negative one where the wheel
            is said to be reversed [rad]; None of an upright axle.
        radius: of its cylinder or sphere [m], or None.
        pivot: where the steering axis stands in the base frame [m].
        trail: horizontal distance from the steering axis to the wheel's centre [m].
        behind: direction from the centre to the steering axis [rad].
    """

    joint: Joint
    steering: Joint | None
    others: tuple[Joint, ...]
    centre: Vector
    heading: float | None
    radius: float | None
    pivot: Vector | None = None
    trail: float = 0.0
    behind: float = 0.0

    @property
    def bottom(self) -> float:
        """Height of the contact point in the base frame [m]."""
        return self.centre[2] - (self.radius or 0.0)


def is_level(axis: Vector) -> bool:
    """Return whether an axis lies level."""
    return abs(axis[2]) <= LEAN


def is_upright(axis: Vector) -> bool:
    """Return whether an axis stands upright, either way."""
    return math.hypot(axis[0], axis[1]) <= LEAN


def look(tree: Tree, joint: Joint, faults: list[str], turned: bool = False) -> Seen:
    """Return what joints and links say of the wheel that turns about a joint.

    A reversed wheel's axis is turned over, because the joint has the sign of the motor.
    """
    here = tree.poses[joint.child]
    size = _size(tree.shapes(joint.child, faults), joint.axis)
    along = times(dot(size.pose.place, joint.axis), joint.axis) if size else (0.0, 0.0, 0.0)
    level = joint.type != "fixed" and is_level(tree.axis(joint))
    moving = [each for each in tree.chain(joint.parent) if each.type != "fixed"]
    turning = [each for each in moving if each.type in ("revolute", "continuous")]
    steering = next((each for each in turning if is_upright(tree.axis(each))), None)
    seen = Seen(
        joint=joint,
        steering=steering,
        others=tuple(each for each in moving if each is not steering),
        centre=here.at(along),
        heading=_heading(here, times(-1.0 if turned else 1.0, joint.axis)) if level else None,
        radius=size.radius if size else None,
    )
    if steering is None:
        return seen
    pivot = tree.poses[steering.child]
    trail, behind = _polar(pivot, times(-1.0, _between(tree, steering, joint).at(along)))
    return replace(seen, pivot=pivot.place, trail=trail, behind=behind)


def _size(shapes: list[Shape], axis: Vector) -> Shape | None:
    """Return the largest cylinder about the axle, or sphere; what collides comes first."""
    for part in ("collision", "visual"):
        round_ones = [each for each in shapes if each.part == part and _turns(each, axis)]
        if round_ones:
            return max(round_ones, key=lambda each: each.radius or 0.0)
    return None


def _turns(shape: Shape, axis: Vector) -> bool:
    """Return whether a geometry looks the same at every turn about an axis."""
    if shape.radius is None:
        return False
    along = dot(shape.pose.place, axis)
    aside = plus(shape.pose.place, times(-along, axis))
    if math.hypot(*aside) > _ECCENTRIC * shape.radius:
        return False
    return shape.kind == "sphere" or abs(dot(shape.pose.turn(UP), axis)) >= math.cos(LEAN)


def _between(tree: Tree, upper: Joint, lower: Joint) -> Pose:
    """Return the frame of the lower joint's child in that of the upper joint's child."""
    found = Pose()
    for each in [lower, *tree.chain(lower.parent)]:
        if each is upper:
            break
        found = each.pose.then(found)
    return found


def _heading(pose: Pose, axis: Vector) -> float:
    """Return the direction of axis x up: a wheel that turns about +y drives towards +x."""
    if pose.yaw is not None:
        return pose.yaw + math.atan2(-axis[0], axis[1])
    x, y, _ = pose.turn(axis)
    return math.atan2(-x, y)


def _polar(pose: Pose, vector: Vector) -> tuple[float, float]:
    """Return length and direction in the base frame of what is level of a vector."""
    if pose.yaw is not None:
        return math.hypot(vector[0], vector[1]), pose.yaw + math.atan2(vector[1], vector[0])
    x, y, _ = pose.turn(vector)
    return math.hypot(x, y), math.atan2(y, x)


def no_radius(tree: Tree, joint: Joint) -> str:
    """Return why a wheel's radius is not known, and the first half of what to do."""
    kinds = {each.kind for each in tree.shapes(joint.child, [])}
    link = f"link '{shown(joint.child)}'"
    if kinds & {"cylinder", "sphere"}:
        reason = f"the cylinder of {link} does not turn about the axis of {joint.where}"
    elif "mesh" in kinds:
        reason = f"the mesh of {link} does not tell the wheel's radius"
    else:
        reason = f"{link} has no cylinder or sphere that tells the wheel's radius"
    return f"{reason}: add a <collision> with a cylinder about the axle"


def table(tree: Tree, seen: Seen, kind: str, faults: list[str]) -> dict[str, Any]:
    """Return the keys of a robot file that the joints give for a wheel of a kind."""
    swivels = kind in ("steered", "caster") and seen.pivot is not None
    place = seen.pivot if swivels and seen.pivot is not None else seen.centre
    found: dict[str, Any] = {"x": place[0], "y": place[1], "radius": seen.radius}
    if kind == "ball":
        return found
    trails = kind == "caster" and seen.trail > 0
    heading = seen.behind if trails else seen.heading
    found["heading_deg"] = None if heading is None else exact_degrees(heading) + 0.0
    if kind == "caster":
        return found | {"trail": seen.trail or None}
    found["max_speed"] = seen.joint.limit("velocity", faults)
    found["max_torque"] = seen.joint.limit("effort", faults)
    if kind == "steered" and seen.steering is not None:
        found |= _steering_limits(tree, seen.steering, faults)
    return found


def _steering_limits(tree: Tree, joint: Joint, faults: list[str]) -> dict[str, Any]:
    low = high = None
    if joint.type == "revolute":
        low, high = joint.limit("lower", faults), joint.limit("upper", faults)
    if tree.axis(joint)[2] < 0:  # a positive turn of the joint is a negative steering angle
        low, high = (None if each is None else -each for each in (high, low))
    angles = {
        "steering_min_deg": low,
        "steering_max_deg": high,
        "steering_rate_deg": joint.limit("velocity", faults),
    }
    return {key: None if each is None else exact_degrees(each) for key, each in angles.items()}
