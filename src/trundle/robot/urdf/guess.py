"""A URDF that says nothing of trundle: which joints are wheels, and what had to be guessed."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any
from xml.etree import ElementTree as ET

from trundle.robot.urdf.actuators import Actuators, read_actuators
from trundle.robot.urdf.linkage import Link, links
from trundle.robot.urdf.masses import read_masses
from trundle.robot.urdf.text import shown
from trundle.robot.urdf.tree import Tree
from trundle.robot.urdf.wheels import LEAN, Seen, is_level, look, no_radius, table

# A wheel touches the ground that the lowest one touches, to this share of its radius.
_TOUCHES = 0.25
# A swivel axis nearer to the contact point than this share of the radius goes through it.
_THROUGH = 0.05
# A joint without a radius may be a wheel when it is as low as wheels are, to this factor.
_AS_LOW = 1.5
_A_WHEEL = (
    "a wheel is a continuous joint about an axis that lies level, with a cylinder or sphere that "
    "touches the ground"
)
_NEVER_TOLD = (
    "roller angles: no wheel is taken as an omni or mecanum wheel",
    "friction, motors, encoders and which wheels may skid are not in a URDF",
)


def guess(tree: Tree, root: ET.Element, faults: list[str]) -> tuple[dict[str, Any], list[str]]:
    """Return the tables of a robot file, and a sentence for each thing that is not sure."""
    notes: list[str] = []
    found = _find_wheels(tree, faults, notes)
    if not found and not faults:
        faults.append(f"no wheel is found among {len(tree.joints)} joints: {_A_WHEEL}")
    if faults:
        return {}, notes
    actuators = read_actuators(root)
    standard = [each for each in found if not _is_caster(each, actuators)]
    driven = {each.joint.name for each in _driven(standard, actuators, notes)}
    linked = links(tree, standard, faults)
    body, masses = read_masses(tree, found, faults)
    names = _names(found)
    free = {each.joint.name for each in found} - {each.joint.name for each in standard}
    tables = []
    for seen in found:
        joint = seen.joint.name
        kind = "caster" if joint in free else "steered" if seen.steering else "fixed"
        made = {"name": names[joint], "kind": kind} | table(tree, seen, kind, faults)
        made |= masses.get(joint, {})
        if kind == "caster":
            made.pop("spin_inertia", None)
        else:
            made["driven"] = joint in driven
            if joint in actuators.measured - driven:
                made["measured"] = True
            made |= _backwards(made)
            made |= _linked(made, linked.get(joint))
            _tell_simplified(seen, notes)
        tables.append({k: v for k, v in made.items() if v is not None})
    _tell_reversed(found, tables, notes)
    tables += _balls(tree, min(each.bottom for each in found), set(names.values()), faults)
    data = {"wheel": tables} | ({"body": body} if body else {})
    return data, [*notes, *_NEVER_TOLD]


def _find_wheels(tree: Tree, faults: list[str], notes: list[str]) -> list[Seen]:
    level = {
        joint.child: joint
        for joint in tree.joints.values()
        if joint.type == "continuous" and joint.child in tree.poses and is_level(tree.axis(joint))
    }
    outer = [j for j in level.values() if all(up.child not in level for up in tree.chain(j.parent))]
    if beneath := len(level) - len(outer):
        notes.append(f"{beneath} joints beneath wheels, such as rollers, are not read")
    seen = [look(tree, joint, faults) for joint in outer]
    ground = min((each.bottom for each in seen if each.radius is not None), default=0.0)
    largest = max((each.radius or 0.0 for each in seen), default=0.0)
    found = []
    for each in seen:
        high = each.bottom - ground
        if each.radius is not None and high <= _TOUCHES * each.radius:
            found.append(each)
        elif each.radius is None and (largest == 0 or high <= _AS_LOW * largest):
            faults.append(
                f"{each.joint.where}: {no_radius(tree, each.joint)}, or a <trundle> element that "
                "lists the wheels with their radius"
            )
        else:
            notes.append(
                f"{each.joint.where} is no wheel: what it turns ends {high:.3g} m above the ground"
            )
    return found


def _is_caster(seen: Seen, actuators: Actuators) -> bool:
    """Return whether a wheel swivels freely about a vertical axis, and nothing drives it.

    Where no joint is said to be driven, an axis through the contact point steers.
    """
    steering = seen.steering
    if steering is None or steering.type != "continuous":
        return False
    follows = steering.element.find("mimic") is not None
    through = seen.trail <= _THROUGH * (seen.radius or 0.0)
    driven = actuators.commanded & {steering.name, seen.joint.name}
    return not (follows or driven or (through and not actuators.commanded))


def _driven(standard: list[Seen], actuators: Actuators, notes: list[str]) -> list[Seen]:
    """Return the wheels that are driven: as the file says, or else a guess that is told."""
    for each in standard:
        if (mimic := each.joint.element.find("mimic")) is not None:
            leader = shown(mimic.get("joint", ""))
            notes.append(f"{each.joint.where} follows '{leader}': taken as a wheel of its own")
    told = [each for each in standard if each.joint.name in actuators.commanded]
    if told:
        return told
    fixed = [each for each in standard if each.steering is None]
    chosen = fixed or standard
    why = f"{actuators.source} names no wheel" if actuators.source else "the file does not say"
    names = ", ".join(f"'{shown(each.joint.name)}'" for each in chosen) or "none"
    notes.append(f"which wheels are driven: {why}; taken as driven: {names}")
    return chosen


def _names(found: list[Seen]) -> dict[str, str]:
    """Return a name for each wheel: its joint's, without "_joint" where that tells it apart."""
    short = {each.joint.name: each.joint.name.removesuffix("_joint") for each in found}
    taken = Counter(short.values())
    return {
        joint: name if name.strip() and taken[name] == 1 else joint for joint, name in short.items()
    }


def _backwards(made: dict[str, Any]) -> dict[str, Any]:
    """Return heading and sign of a wheel that a positive turn of its joint drives backwards.

    Backwards is against x, or to the right where it is straight across: so wheels that stand
    parallel have one heading, also where the axes of one side are mirrored.
    """
    if not math.isfinite(made["heading_deg"]):
        return {}
    heading, lean = math.remainder(made["heading_deg"], 360), math.degrees(LEAN)
    if lean - 90 < heading <= lean + 90:
        return {}
    return {"heading_deg": heading - math.copysign(180, heading), "reversed": True}


def _tell_reversed(found: list[Seen], tables: list[dict[str, Any]], notes: list[str]) -> None:
    back = [
        f"'{shown(seen.joint.name)}'"
        for seen, table in zip(found, tables, strict=True)
        if table.get("reversed")
    ]
    if back:
        notes.append(f"a positive turn drives backwards at {', '.join(back)}: taken as reversed")


def _linked(made: dict[str, Any], link: Link | None) -> dict[str, Any]:
    """Return the keys of a wheel that steers with others; an offset moves its zero."""
    if link is None:
        return {}
    found: dict[str, Any] = {"steering_group": link.group, "steering_ratio": link.ratio}
    offset = math.degrees(link.offset)
    if offset == 0:
        return found
    for key, sign in (("heading_deg", 1), ("steering_min_deg", -1), ("steering_max_deg", -1)):
        if made.get(key) is not None:
            found[key] = made[key] + sign * offset
    return found


def _tell_simplified(seen: Seen, notes: list[str]) -> None:
    if seen.steering is not None and seen.trail > _THROUGH * (seen.radius or 0.0):
        notes.append(
            f"{seen.steering.where} steers {seen.trail:.3g} m beside the contact point of "
            f"{seen.joint.where}: the wheel is taken to stand on the steering axis"
        )
    if seen.others:
        told = ", ".join(each.where for each in seen.others)
        notes.append(f"{told} above {seen.joint.where}: taken as fixed at zero")


def _balls(tree: Tree, ground: float, taken: set[str], faults: list[str]) -> list[dict[str, Any]]:
    """Return a ball for each link fixed to the base whose sphere touches the ground."""
    found = []
    for link, placed in tree.rigid(tree.base).items():
        shapes = tree.own_shapes(link, faults)
        spheres = [each for each in shapes if each.kind == "sphere" and each.radius is not None]
        for each in spheres[:1]:
            x, y, z = placed.at(each.pose.place)
            radius = each.radius or 0.0
            if abs(z - radius - ground) > _TOUCHES * radius:
                continue
            name = link.removesuffix("_link")
            name = name if name.strip() and name not in taken else link
            found.append({"name": name, "kind": "ball", "x": x, "y": y, "radius": radius})
    return found
