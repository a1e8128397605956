"""Steering joints of a URDF that follow one another, as steering groups."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from trundle.robot.urdf.text import shown
from trundle.robot.urdf.tree import Joint, Tree
from trundle.robot.urdf.wheels import Seen


class Link(NamedTuple):
    """A wheel's steering angle about +z = ratio * the group's angle + offset [rad]."""

    group: str
    ratio: float
    offset: float


def links(tree: Tree, steered: list[Seen], faults: list[str]) -> dict[str, Link]:
    """Return how wheels steer together, by the name of the wheel's joint; others are left out."""
    found: dict[str, Link] = {}
    for seen in steered:
        if seen.steering is not None and (link := _follow(tree, seen.steering, faults)):
            found[seen.joint.name] = link
    sizes = Counter(link.group for link in found.values())
    own = {seen.steering.name for seen in steered if seen.steering is not None}
    return {
        name: link._replace(ratio=link.ratio * _sense(tree, tree.joints[link.group]))
        if link.group in own
        else link
        for name, link in found.items()
        if sizes[link.group] > 1 or link.group not in own
    }


def _sense(tree: Tree, joint: Joint) -> float:
    """Return +1 or -1: whether a positive turn of the joint is one about +z."""
    return math.copysign(1.0, tree.axis(joint)[2])


def _follow(tree: Tree, joint: Joint, faults: list[str]) -> Link | None:
    """Return the joint that a steering joint follows in the end, itself when it follows none."""
    ratio, offset, last, passed = 1.0, 0.0, joint, {joint.name}
    while (mimic := last.mimic(faults)) is not None:
        leader = tree.joints.get(mimic.joint)
        if leader is None or leader.name in passed:
            why = (
                "it is no joint" if leader is None else "the joints follow one another in a circle"
            )
            faults.append(f"{last.where}: it mimics '{shown(mimic.joint)}', but {why}")
            return None
        if mimic.multiplier == 0:
            faults.append(f"{last.where}: multiplier of its mimic must not be zero")
            return None
        offset += ratio * mimic.offset
        ratio *= mimic.multiplier
        passed.add(leader.name)
        last = leader
    sense = _sense(tree, joint)
    return Link(last.name, sense * ratio, sense * offset)
