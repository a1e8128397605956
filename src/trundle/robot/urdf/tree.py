"""Links and joints of a URDF as the tree that they must form."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.etree import ElementTree as ET

from trundle.errors import did_you_mean
from trundle.robot.urdf.pose import UP, Pose, Vector, pose, unit
from trundle.robot.urdf.text import attribute, numbers, shown

_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
# Joints above one another: a humanoid has thirty. It bounds the time that a file can take.
_DEEPEST = 200
# Finding a near name takes its time: hints are given for so many faults, from so many names.
_HINTS, _NAMES = 20, 1000
# Simulators and exporters write a large number where there is no limit.
NO_LIMIT = 1e9


class Mimic(NamedTuple):
    """A joint's angle = multiplier * that of another joint + offset."""

    joint: str
    multiplier: float
    offset: float


class Shape(NamedTuple):
    """One geometry of a link; only a cylinder and a sphere have a radius."""

    part: str  # "collision" or "visual"
    kind: str
    radius: float | None
    pose: Pose


@dataclass(frozen=True)
class Joint:
    """A joint: the frame of its child in that of its parent, and its axis in the child's."""

    name: str
    type: str
    parent: str
    child: str
    pose: Pose
    axis: Vector
    element: ET.Element = field(repr=False, compare=False)

    @property
    def where(self) -> str:
        """The joint's name as messages tell it."""
        return f"joint '{shown(self.name)}'"

    def limit(self, key: str, faults: list[str]) -> float | None:
        """Return a bound of the joint's ``<limit>``, or None where it has none.

        Zero speed and effort are what some exporters write where nothing is known.
        """
        value = attribute(self.element.find("limit"), key, f"{self.where}: limit", faults)
        if value is None or abs(value) >= NO_LIMIT:
            return None
        return value if key in ("lower", "upper") or value > 0 else None

    def mimic(self, faults: list[str]) -> Mimic | None:
        """Return the joint that this one follows."""
        element = self.element.find("mimic")
        if element is None:
            return None
        where = f"{self.where}: mimic"
        multiplier = attribute(element, "multiplier", where, faults)
        offset = attribute(element, "offset", where, faults)
        return Mimic(
            element.get("joint", ""), 1.0 if multiplier is None else multiplier, offset or 0.0
        )


@dataclass(frozen=True)
class Tree:
    """The links and joints of a URDF.

    ``poses`` has each link in the base frame, with all joints at zero. The base is the root link,
    or the link that moves freely in it.
    """

    links: dict[str, ET.Element]
    joints: dict[str, Joint]
    above: dict[str, Joint]  # by the child's name
    below: dict[str, list[Joint]]  # by the parent's name
    base: str
    poses: dict[str, Pose]

    def chain(self, link: str) -> list[Joint]:
        """Return the joints from a link up to the base, the nearest first."""
        found = []
        while link != self.base and link in self.above:
            found.append(self.above[link])
            link = found[-1].parent
        return found

    def axis(self, joint: Joint) -> Vector:
        """Return a joint's axis in the base frame."""
        return self.poses[joint.child].turn(joint.axis)

    def rigid(self, link: str) -> dict[str, Pose]:
        """Return the links that fixed joints tie to a link, itself first, in its frame."""
        found = {link: Pose()}
        waiting = [link]
        while waiting:
            name = waiting.pop()
            for joint in self.below[name]:
                if joint.type == "fixed":
                    found[joint.child] = found[name].then(joint.pose)
                    waiting.append(joint.child)
        return found

    def shapes(self, link: str, faults: list[str]) -> list[Shape]:
        """Return the geometries of a link and of what is fixed to it, in the link's frame."""
        return [
            each._replace(pose=placed.then(each.pose))
            for name, placed in self.rigid(link).items()
            for each in self.own_shapes(name, faults)
        ]

    def own_shapes(self, link: str, faults: list[str]) -> list[Shape]:
        """Return the geometries of one link, in its frame."""
        element, found = self.links[link], []
        for tag in ("collision", "visual"):
            for each in element.findall(tag):
                geometry = each.find("geometry")
                for solid in [] if geometry is None else list(geometry)[:1]:
                    where = f"link '{shown(link)}': {tag}"
                    round_one = solid.tag in ("cylinder", "sphere")
                    radius = attribute(solid, "radius", where, faults, positive=True)
                    if round_one and solid.get("radius") is None:
                        faults.append(f"{where}: radius of the {solid.tag} is missing")
                    placed = read_origin(each, where, faults)
                    found.append(Shape(tag, solid.tag, radius if round_one else None, placed))
        return found


def read_origin(element: ET.Element, where: str, faults: list[str]) -> Pose:
    """Return the frame of an element's ``<origin>``."""
    origin = element.find("origin")
    if origin is None:
        return Pose()
    if origin.get("quat_xyzw") is not None:
        faults.append(f"{where}: origin must be told by rpy, not by quat_xyzw")
    zero = (0.0, 0.0, 0.0)
    xyz = numbers(origin.get("xyz"), zero, f"{where}: origin xyz", faults)
    return pose(xyz, numbers(origin.get("rpy"), zero, f"{where}: origin rpy", faults))


def read_tree(root: ET.Element, faults: list[str]) -> Tree | None:
    """Return the tree of a URDF, or None after telling what is wrong with it."""
    told = len(faults)
    links = {name: each for each in root.findall("link") if (name := _name(each, faults))}
    _tell_repeated(root, "link", faults)
    _tell_repeated(root, "joint", faults)
    joints = [joint for each in root.findall("joint") if (joint := _joint(each, links, faults))]
    if not links and len(faults) == told:
        faults.append("there is no <link>: a URDF has links, and joints between them")
    if len(faults) > told:
        return None
    base = _root(links, joints, faults)
    if base is None:
        return None
    below: dict[str, list[Joint]] = {name: [] for name in links}
    for joint in joints:
        below[joint.parent].append(joint)
    base = _free(base, below)
    poses = _poses(base, below, faults)
    if poses is None:
        return None
    return Tree(
        links, {each.name: each for each in joints}, {each.child: each for each in joints},
        below, base, poses,
    )  # fmt: skip


def _name(element: ET.Element, faults: list[str]) -> str:
    name = element.get("name", "")
    if not name.strip():
        faults.append(f"a <{element.tag}> has no name")
        return ""
    return name


def _tell_repeated(root: ET.Element, tag: str, faults: list[str]) -> None:
    for name, count in Counter(each.get("name", "") for each in root.findall(tag)).items():
        if count > 1 and name.strip():
            faults.append(f"{tag} '{shown(name)}': the name is used {count} times")


def _joint(element: ET.Element, links: dict[str, ET.Element], faults: list[str]) -> Joint | None:
    name = _name(element, faults)
    if not name:
        return None
    where = f"joint '{shown(name)}'"
    told = len(faults)
    kind = element.get("type", "")
    if kind not in _TYPES:
        got = f"got '{shown(kind)}'{did_you_mean(kind, _TYPES)}" if kind else "it is missing"
        faults.append(f"{where}: type must be one of {', '.join(_TYPES)}; {got}")
    ends = [_end(element, tag, where, links, faults) for tag in ("parent", "child")]
    placed = read_origin(element, where, faults)
    text = None if (found := element.find("axis")) is None else found.get("xyz")
    axis = unit(numbers(text, (1.0, 0.0, 0.0), f"{where}: axis xyz", faults))
    if axis is None and kind in ("revolute", "continuous"):
        faults.append(f"{where}: axis must not be zero")
    if len(faults) > told:
        return None
    return Joint(name, kind, ends[0], ends[1], placed, axis or UP, element)


def _end(
    element: ET.Element, tag: str, where: str, links: dict[str, ET.Element], faults: list[str]
) -> str:
    found = element.find(tag)
    link = "" if found is None else found.get("link", "")
    if not link:
        faults.append(f'{where}: its {tag} is missing: <{tag} link="..."/>')
    elif link not in links:
        hint = did_you_mean(link, list(links)[:_NAMES]) if len(faults) < _HINTS else ""
        faults.append(f"{where}: its {tag} '{shown(link)}' is no link{hint}")
    return link


def _root(links: dict[str, ET.Element], joints: list[Joint], faults: list[str]) -> str | None:
    parents = Counter(joint.child for joint in joints)
    for name, count in parents.items():
        if count > 1:
            faults.append(f"link '{shown(name)}': it is the child of {count} joints, may be of one")
    roots = [name for name in links if name not in parents]
    if len(roots) > 1:
        told = ", ".join(f"'{shown(name)}'" for name in roots[:5]) + ", ..." * (len(roots) > 5)
        faults.append(
            f"{len(roots)} links are the child of no joint ({told}): only one may be, the base"
        )
    if not roots:
        faults.append("every link is the child of a joint: the joints run in a circle")
    elif not faults and (lost := _unreached(roots[0], links, joints)):
        faults.append(f"joints run in a circle: link '{shown(lost)}' does not hang on the base")
    return None if faults else roots[0]


def _unreached(root: str, links: dict[str, ET.Element], joints: list[Joint]) -> str | None:
    below: dict[str, list[str]] = {name: [] for name in links}
    for joint in joints:
        below[joint.parent].append(joint.child)
    seen, waiting = {root}, [root]
    while waiting:
        children = below[waiting.pop()]
        seen.update(children)
        waiting += children
    return next((name for name in links if name not in seen), None)


def _free(root: str, below: dict[str, list[Joint]]) -> str:
    """Return the base: below a root such as 'world', the link that floats in it."""
    while len(below[root]) == 1 and below[root][0].type in ("floating", "planar"):
        root = below[root][0].child
    return root


def _poses(base: str, below: dict[str, list[Joint]], faults: list[str]) -> dict[str, Pose] | None:
    poses, layer, depth = {base: Pose()}, [base], 0
    while layer:
        joints = [joint for link in layer for joint in below[link]]
        poses |= {joint.child: poses[joint.parent].then(joint.pose) for joint in joints}
        layer, depth = [joint.child for joint in joints], depth + 1
        if depth > _DEEPEST:
            faults.append(f"more than {_DEEPEST} joints hang on one another: this is no robot")
            return None
    return poses
