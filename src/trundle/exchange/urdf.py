"""Robots as URDF, for ROS, simulators and their viewers."""

from __future__ import annotations

import math
import tomllib
from typing import Any
from xml.etree import ElementTree as ET

from trundle.errors import TrundleError
from trundle.exchange.inertia import Share, shares
from trundle.exchange.names import JointNames, check_xml, comment, joint_names
from trundle.robot import BallWheel, CasterWheel, Robot, RollingWheel, SteeredWheel, Wheel, to_toml

# URDF wants a number where a robot has no limit; what reads it back takes so large a one for none.
NO_LIMIT = 1e9
# Stand-ins for what a robot's description leaves out: they are seen, and nothing reads them back.
_WIDTH = {"fixed": 0.55, "steered": 0.55, "omni": 0.6, "mecanum": 0.8, "caster": 0.5}
_BALL = 0.06  # radius of a ball without one, over the robot's reach
_ABOVE = 1.05  # height of the body's floor over the top of the highest wheel
_FLAT = 0.15  # height of the body over its shorter side
_COLOURS = {
    "body": "0.80 0.84 0.88 1",
    "driven": "0.00 0.45 0.70 1",
    "passive": "0.45 0.45 0.45 1",
}
# Told by joints and links, so not in <trundle>.
_TOLD = ("name", "kind", "x", "y", "heading_deg", "radius", "trail")
_LIMITS = ("max_speed", "max_torque", "steering_min_deg", "steering_max_deg", "steering_rate_deg")
_HEAD = """
 {name}: base_link lies on the ground under the origin, x forward, y left. A wheel's heading is the
 x axis of its joint's frame. The joint's axis is +y of that frame, -y where the wheel is reversed:
 joints have the signs of the motors. Widths, heights and the body's height above the ground are
 stand-ins.
"""


def urdf(robot: Robot) -> str:
    """Return a robot as the text of a URDF; ``trundle.load`` reads the same robot back.

    Wheels are cylinders about a ``continuous`` joint, balls are fixed spheres, steering and the
    swivelling of casters is a joint about +z above the wheel's. Joints have the signs of the
    motors: the axis of a reversed wheel is turned over. What a URDF cannot say stands
    under ``<trundle>``. Heights, widths and, where the robot has a mass, the masses of parts that
    have none are stand-ins.

    Raises:
        TrundleError: XML cannot hold a name or a number of the robot.

    Source: the URDF specification (wiki.ros.org/urdf/XML), and REP 103 for axes and units.

    >>> from trundle import load
    >>> print(urdf(load("differential")).splitlines()[1])
    <robot name="differential">
    """
    check_xml(robot)
    names = joint_names(robot)
    root = ET.Element("robot", name=robot.name)
    root.append(ET.Comment(_HEAD.format(name=comment(robot.name))))
    for name, colour in _COLOURS.items():
        _add(_add(root, "material", name=name), "color", rgba=colour)
    radii = _radii(robot)
    weights = shares(robot, radii)
    _add_base(root, robot, max(radii.values()), weights.body)
    for wheel in robot.wheels:
        weight = weights.wheels.get(wheel.name)
        _add_wheel(root, robot, wheel, radii[wheel.name], names, weight)
    _add_control(root, robot, names)
    _add_extension(root, robot, names)
    ET.indent(root)
    # No encoding is named: UTF-8 is XML's own, and readers of texts refuse one that is named.
    return f'<?xml version="1.0"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _add(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    texts = {key: _text(value) for key, value in attributes.items() if value is not None}
    return ET.SubElement(parent, tag, texts)


def _text(value: object) -> str:
    """Return an attribute's text: numbers to their last digit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        if not math.isfinite(value):
            raise TrundleError("the robot's numbers are too large for a URDF: one became infinite")
        return repr(value)
    if isinstance(value, tuple | list):
        return " ".join(map(_text, value))
    return str(value)


def _radii(robot: Robot) -> dict[str, float]:
    """Return the radius of each wheel [m], a stand-in for a ball that has none."""
    own = {wheel.name: getattr(wheel, "radius", None) for wheel in robot.wheels}
    return {name: _BALL * robot.reach if radius is None else radius for name, radius in own.items()}


def _about(size: float) -> float:
    """Return a stand-in with the digits that people read."""
    return float(f"{size:.6g}")


def _add_base(root: ET.Element, robot: Robot, largest: float, weight: Share | None) -> None:
    """Add the body on top of the largest wheel, under a root without mass as ROS wants it."""
    _add(root, "link", name="base_footprint")
    base = _add(root, "link", name="base_link")
    joint = _add(root, "joint", name="base_footprint_to_base_link", type="fixed")
    _add(joint, "parent", link="base_footprint")
    _add(joint, "child", link="base_link")
    body = robot.body
    if body is not None and body.length is not None and body.width is not None:
        height = _about(_FLAT * min(body.length, body.width))
        floor = 2 * _ABOVE * largest
        size = {"size": (body.length, body.width, height)}
        _add_shape(base, "box", size, "body", xyz=(body.x, body.y, _about(floor + height / 2)))
    _add_inertial(base, weight)


def _add_shape(
    link: ET.Element,
    kind: str,
    sizes: dict[str, Any],
    material: str,
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0),
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> None:
    for tag in ("visual", "collision"):
        part = _add(link, tag)
        _add(part, "origin", xyz=xyz, rpy=rpy)
        _add(_add(part, "geometry"), kind, **sizes)
        if tag == "visual":
            _add(part, "material", name=material)


def _add_inertial(link: ET.Element, weight: Share | None) -> None:
    if weight is None:
        return
    part = _add(link, "inertial")
    _add(part, "origin", xyz=weight.at, rpy=(0.0, 0.0, 0.0))
    _add(part, "mass", value=weight.mass)
    ixx, iyy, izz = weight.inertia
    _add(part, "inertia", ixx=ixx, ixy=0.0, ixz=0.0, iyy=iyy, iyz=0.0, izz=izz)


def _add_joint(
    root: ET.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: tuple[float, ...],
    yaw: float = 0.0,
    axis: str | None = None,
) -> ET.Element:
    joint = _add(root, "joint", name=name, type=kind)
    _add(joint, "parent", link=parent)
    _add(joint, "child", link=child)
    _add(joint, "origin", xyz=xyz, rpy=(0.0, 0.0, yaw))
    if axis is not None:
        _add(joint, "axis", xyz=axis)
    return joint


def _add_wheel(
    root: ET.Element,
    robot: Robot,
    wheel: Wheel,
    radius: float,
    names: dict[str, JointNames],
    weight: tuple[Share, Share | None] | None,
) -> None:
    own = names[wheel.name]
    place, heading = (wheel.x, wheel.y, radius), getattr(wheel, "heading", 0.0)
    parent = "base_link"
    rolling, turning = weight or (None, None)
    if isinstance(wheel, SteeredWheel | CasterWheel):
        _add_inertial(_add(root, "link", name=own.steering_link), turning)
        _add_steering(root, robot, wheel, names, place)
        trail = wheel.trail or 0.0 if isinstance(wheel, CasterWheel) else 0.0
        parent, place, heading = own.steering_link, (0.0 - trail, 0.0, 0.0), 0.0
    link = _add(root, "link", name=own.link)
    if isinstance(wheel, BallWheel):
        _add_shape(link, "sphere", {"radius": radius}, "passive")
        _add_joint(root, own.wheel, "fixed", parent, own.link, place)
    else:
        sizes = {"radius": radius, "length": _about(_WIDTH[wheel.kind] * radius)}
        colour = "driven" if wheel.driven else "passive"
        _add_shape(link, "cylinder", sizes, colour, rpy=(math.pi / 2, 0.0, 0.0))
        axis = "0 -1 0" if getattr(wheel, "reversed", False) else "0 1 0"
        joint = _add_joint(root, own.wheel, "continuous", parent, own.link, place, heading, axis)
        if isinstance(wheel, RollingWheel):
            _add_limit(joint, effort=wheel.max_torque, velocity=wheel.max_speed)
    _add_inertial(link, rolling)


def _add_limit(joint: ET.Element, **limits: float | None) -> None:
    """Add a limit where one is known; URDF then wants effort and velocity, too."""
    if any(value is not None for value in limits.values()):
        _add(joint, "limit", **{key: _bound(key, value) for key, value in limits.items()})


def _bound(key: str, value: float | None) -> float:
    if value is None:
        return -NO_LIMIT if key == "lower" else NO_LIMIT
    return value


def _add_steering(
    root: ET.Element,
    robot: Robot,
    wheel: SteeredWheel | CasterWheel,
    names: dict[str, JointNames],
    place: tuple[float, ...],
) -> None:
    own = names[wheel.name]
    low, high = (getattr(wheel, f"steering_{end}", None) for end in ("min", "max"))
    limited = low is not None or high is not None
    kind = "revolute" if limited else "continuous"
    joint = _add_joint(
        root, own.steering, kind, "base_link", own.steering_link, place, wheel.heading, "0 0 1"
    )
    if not isinstance(wheel, SteeredWheel):
        return
    rate = wheel.steering_rate
    if limited:
        _add_limit(joint, lower=low, upper=high, effort=None, velocity=rate)
    else:
        _add_limit(joint, effort=None, velocity=rate)
    leader = _leader(robot, wheel)
    if leader is not wheel:
        ratio = wheel.steering_ratio / leader.steering_ratio
        _add(joint, "mimic", joint=names[leader.name].steering, multiplier=ratio, offset=0.0)


def _leader(robot: Robot, wheel: SteeredWheel) -> SteeredWheel:
    """Return the first wheel of a wheel's steering group."""
    if wheel.steering_group is None:
        return wheel
    return next(each for each in robot.steered if each.steering_group == wheel.steering_group)


def _add_control(root: ET.Element, robot: Robot, names: dict[str, JointNames]) -> None:
    """Add ``<ros2_control>``, in which ros2_control's own stand-in moves the joints."""
    joints: list[tuple[str, tuple[str, ...], tuple[str, ...]]] = []
    for wheel in robot.wheels:
        own = names[wheel.name]
        if isinstance(wheel, SteeredWheel):
            steers = ("position",) if _leader(robot, wheel) is wheel else ()
            joints.append((own.steering, steers, ("position",)))
        if isinstance(wheel, RollingWheel) and (wheel.driven or wheel.sensed):
            drives = ("velocity",) if wheel.driven else ()
            joints.append((own.wheel, drives, ("position", "velocity")))
    if not joints:
        return
    system = _add(root, "ros2_control", name="wheels", type="system")
    _add(_add(system, "hardware"), "plugin").text = "mock_components/GenericSystem"
    for name, commands, states in joints:
        joint = _add(system, "joint", name=name)
        for each in commands:
            _add(joint, "command_interface", name=each)
        for each in states:
            _add(joint, "state_interface", name=each)


def _add_extension(root: ET.Element, robot: Robot, names: dict[str, JointNames]) -> None:
    """Add what joints and links do not say, under the keys of a robot file."""
    tables = tomllib.loads(to_toml(robot))
    element = _add(root, "trundle")
    if "body" in tables:
        _add_table(element, "body", tables["body"])
    for wheel, table in zip(robot.wheels, tables["wheel"], strict=True):
        told = {"name": wheel.name, "kind": wheel.kind, "joint": names[wheel.name].wheel}
        if isinstance(wheel, BallWheel) and wheel.radius is None:
            told["radius"] = "none"
        rest = {k: v for k, v in table.items() if k not in _TOLD and not _in_joint(k, v)}
        _add_table(element, "wheel", told | rest)


def _in_joint(key: str, value: Any) -> bool:
    """Return whether a limit can stand in a joint: it is below what is taken for none."""
    size = math.radians(abs(value)) if key.endswith("_deg") and key in _LIMITS else value
    return key in _LIMITS and abs(size) < NO_LIMIT


def _add_table(parent: ET.Element, tag: str, table: dict[str, Any]) -> None:
    parts = {k: v for k, v in table.items() if isinstance(v, dict)}
    element = _add(parent, tag, **{k: v for k, v in table.items() if k not in parts})
    for key, value in parts.items():
        _add_table(element, key, value)
