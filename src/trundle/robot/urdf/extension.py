"""The ``<trundle>`` element of a URDF: what joints and links cannot say of a robot."""

from __future__ import annotations

import dataclasses
import math
from typing import Any
from xml.etree import ElementTree as ET

from trundle.errors import did_you_mean
from trundle.robot.quantity import key
from trundle.robot.robot import Body
from trundle.robot.schema import CLASSES, wheel_class
from trundle.robot.urdf.text import number, shown
from trundle.robot.urdf.tree import Joint, Tree
from trundle.robot.urdf.wheels import look, no_radius, table

# Numbers that stand in two places may differ by the digits that a program left out.
_SAME = 1e-6


def read_extension(tree: Tree, element: ET.Element, faults: list[str]) -> dict[str, Any]:
    """Return the tables of a robot file: what joints say, and what ``<trundle>`` adds."""
    faults += [
        f"<trundle>: unknown element <{shown(each.tag)}>: it has body and wheel"
        for each in element
        if each.tag not in ("body", "wheel")
    ]
    made: dict[str, Any] = {"wheel": []}
    bodies = element.findall("body")
    if len(bodies) > 1:
        faults.append(f"<trundle>: it has {len(bodies)} elements <body>, may have one")
    if bodies:
        made["body"] = _typed(bodies[0], Body, "<trundle>: body", faults)
    for number_, each in enumerate(element.findall("wheel"), start=1):
        if wheel := _wheel(tree, each, number_, faults):
            made["wheel"].append(wheel)
    if not made["wheel"] and not faults:
        faults.append("<trundle>: it has no <wheel>: list every wheel, or remove the element")
    return made


def _wheel(
    tree: Tree, element: ET.Element, number_: int, faults: list[str]
) -> dict[str, Any] | None:
    name = element.get("name")
    where = f"wheel {number_}" if name is None else f"wheel '{shown(name)}'"
    kind, joint_name = element.get("kind", ""), element.get("joint", "")
    if kind not in CLASSES:
        got = f"got '{shown(kind)}'{did_you_mean(kind, CLASSES)}" if kind else "it is missing"
        faults.append(f"{where}: kind must be one of {', '.join(CLASSES)}; {got}")
        return None
    joint = tree.joints.get(joint_name)
    if joint is None or joint.child not in tree.poses:
        faults.append(f"{where}: {_no_joint(tree, joint_name)}")
        return None
    told = _typed(element, wheel_class(kind, {}), where, faults)
    for each in ("joint", "kind"):
        told.pop(each, None)
    given = _seen(tree, joint, kind, told.get("reversed") is True, where, faults)
    if given is None:
        return None
    _tell_differences(told, given, where, joint, faults)
    if kind != "ball" and given["radius"] is None and "radius" not in told:
        faults.append(f"{where}: {no_radius(tree, joint)}, or radius to the <wheel>")
        return None
    merged = {k: v for k, v in (given | told).items() if v is not None}
    return {"name": joint_name, **merged, "kind": kind}


def _no_joint(tree: Tree, name: str) -> str:
    if not name:
        return 'its joint is missing: joint="..." names the joint that the wheel turns about'
    near = did_you_mean(name, list(tree.joints)[:1000])
    return f"the URDF has no joint '{shown(name)}'{near}"


def _seen(
    tree: Tree, joint: Joint, kind: str, turned: bool, where: str, faults: list[str]
) -> dict[str, Any] | None:
    """Return what joints and links say of the wheel, or None after telling that they do not."""
    told = len(faults)
    seen = look(tree, joint, faults, turned)
    if kind != "ball" and seen.heading is None:
        level = "continuous, about an axis that lies level" if joint.type == "fixed" else "level"
        faults.append(f"{where}: {joint.where} must be {level} in the base frame")
    if kind == "steered" and seen.steering is None:
        faults.append(f"{where}: no joint above {joint.where} turns about a vertical axis")
    given = table(tree, seen, kind, faults)
    return given if len(faults) == told else None


def _tell_differences(
    told: dict[str, Any], given: dict[str, Any], where: str, joint: Joint, faults: list[str]
) -> None:
    for name, value in told.items():
        other = given.get(name)
        if not isinstance(value, float) or not isinstance(other, float):
            continue
        if not math.isclose(value, other, rel_tol=_SAME, abs_tol=_SAME):
            faults.append(
                f"{where}: {name} is {value:g} in <trundle>, but the links and joints of "
                f"{joint.where} make it {other:g}: mend one, or leave it out of <trundle>"
            )


def _typed(element: ET.Element, cls: type, where: str, faults: list[str]) -> dict[str, Any]:
    """Return an element's attributes as a robot file has them; "none" is what is not there."""
    items = {key(each): each for each in dataclasses.fields(cls)}
    found: dict[str, Any] = {
        name: _value(text, items[name]) if name in items else text
        for name, text in element.attrib.items()
    }
    for each in element:
        item = items.get(each.tag)
        if item is None or "part" not in item.metadata:
            faults.append(f"{where}: unknown element <{shown(each.tag)}>")
        else:
            inner = f"{where}: {each.tag}"
            found[each.tag] = _typed(each, item.metadata["part"], inner, faults)
    return found


def _value(text: str, item: dataclasses.Field[Any]) -> Any:
    """Return what an attribute holds; what is not of its type stays text, to be told as such."""
    if text == "none" and item.default is None and "text" not in item.metadata:
        return None
    if "flag" in item.metadata:
        return {"true": True, "false": False}.get(text, text)
    if "point" in item.metadata:
        parts = [number(part) for part in text.split()[:3]]
        return text if None in parts else parts
    if "quantity" in item.metadata:
        value = number(text)
        return text if value is None else value
    return text
