"""Masses of a URDF's links, gathered into a body and its wheels."""

from __future__ import annotations

import math
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

from trundle.robot.urdf.pose import Pose, Vector, dot
from trundle.robot.urdf.text import attribute, shown
from trundle.robot.urdf.tree import Tree, read_origin
from trundle.robot.urdf.wheels import Seen

_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


class Lump(NamedTuple):
    """Mass [kg], where it is in the base frame [m], inertia about three axes of the base frame."""

    mass: float
    at: Vector
    inertia: tuple[Vector, Vector, Vector]

    def about(self, axis: Vector) -> float:
        """Return the inertia about an axis of the base frame through the centre of mass."""
        return dot(axis, tuple(dot(row, axis) for row in self.inertia))  # type: ignore[arg-type]


def read_masses(
    tree: Tree, wheels: list[Seen], faults: list[str]
) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Return the body's mass, com and inertia, and those of each wheel by its joint's name.

    What turns with a wheel is the wheel's; all else is the body's, with all joints at zero.
    """
    of_wheels, taken = {}, set()
    for seen in wheels:
        turning = tree.rigid(seen.joint.child)
        taken |= set(turning)
        lumps = _lumps(tree, list(turning), faults)
        if mass := math.fsum(each.mass for each in lumps):
            of_wheels[seen.joint.name] = {
                "mass": mass,
                "yaw_inertia": _yaw_inertia(lumps, seen.centre),
                "spin_inertia": math.fsum(each.about(tree.axis(seen.joint)) for each in lumps),
            }
    return _body(
        _lumps(tree, [name for name in tree.poses if name not in taken], faults)
    ), of_wheels


def _body(lumps: list[Lump]) -> dict[str, Any]:
    mass = math.fsum(each.mass for each in lumps)
    if not mass > 0:
        return {}
    x, y = (math.fsum(each.mass * each.at[i] for each in lumps) / mass for i in (0, 1))
    inertia = _yaw_inertia(lumps, (x, y, 0.0))
    return {"mass": mass, "com": [x, y], "inertia": inertia if inertia > 0 else None}


def _yaw_inertia(lumps: list[Lump], centre: Vector) -> float:
    """Return the inertia about a vertical: the parallel-axis theorem."""
    total = 0.0
    for each in lumps:
        x, y = each.at[0] - centre[0], each.at[1] - centre[1]
        total += each.inertia[2][2] + each.mass * (x * x + y * y)
    return total


def _lumps(tree: Tree, names: list[str], faults: list[str]) -> list[Lump]:
    found = []
    for name in names:
        element = tree.links[name].find("inertial")
        if element is not None:
            found.append(_lump(element, tree.poses[name], f"link '{shown(name)}'", faults))
    return found


def _lump(element: ET.Element, placed: Pose, where: str, faults: list[str]) -> Lump:
    mass = attribute(element.find("mass"), "value", f"{where}: mass", faults) or 0.0
    inertia = element.find("inertia")
    ixx, iyy, izz, ixy, ixz, iyz = (
        attribute(inertia, key, f"{where}: inertia", faults) or 0.0 for key in _INERTIA
    )
    if min(mass, ixx, iyy, izz) < 0:
        faults.append(f"{where}: mass and inertia must not be negative")
    frame = placed.then(read_origin(element, f"{where}: inertial", faults))
    rows: list[Vector] = [(ixx, ixy, ixz), (ixy, iyy, iyz), (ixz, iyz, izz)]
    # R I R^T, row by row: I R^T first, then R times its columns.
    half = [frame.turn(row) for row in rows]
    turned = [frame.turn(column) for column in zip(*half, strict=True)]
    first, second, third = zip(*turned, strict=True)
    return Lump(mass, frame.place, (first, second, third))
