"""Robots from URDF: what joints and links say, and what only a ``<trundle>`` element can say."""

from __future__ import annotations

from typing import Any, NamedTuple

from trundle.errors import RobotError
from trundle.robot.reading import robot_from_dict
from trundle.robot.robot import Robot
from trundle.robot.urdf.extension import read_extension
from trundle.robot.urdf.guess import guess
from trundle.robot.urdf.text import MOST_BYTES, parse
from trundle.robot.urdf.tree import read_tree

__all__ = ["MOST_BYTES", "UrdfReading", "read_urdf"]

_MOST_FAULTS = 20


class UrdfReading(NamedTuple):
    """A robot, and a sentence for each thing that the URDF does not tell."""

    robot: Robot
    unknown: tuple[str, ...]


def read_urdf(data: bytes, where: str = "URDF", name: str = "robot") -> UrdfReading:
    """Return the robot that a URDF describes.

    With a ``<trundle>`` element it is the robot that was written. Otherwise its wheels are the
    joints that can be wheels, standard ones, and ``unknown`` lists what is taken for granted.

    Args:
        data: the bytes of the file.
        where: the file's name, for messages.
        name: the robot's name where the file gives none.

    Raises:
        FileError: this is no URDF.
        RobotError: the description is wrong; all faults are listed.
    """
    root = parse(data, where)
    faults: list[str] = []
    notes: list[str] = []
    made: dict[str, Any] = {}
    tree = read_tree(root, faults)
    own = root.findall("trundle")
    if len(own) > 1:
        faults.append(f"there are {len(own)} elements <trundle>, may be one")
    if tree is not None and not faults:
        if own:
            made = read_extension(tree, own[0], faults)
        else:
            made, notes = guess(tree, root, faults)
    if faults:
        raise RobotError(_some(faults), where)
    called = root.get("name", "")
    try:
        robot = robot_from_dict({"name": called if called.strip() else name} | made)
    except RobotError as error:
        raise RobotError(_some(list(error.faults)), where) from None
    return UrdfReading(robot, tuple(_some(notes)))


def _some(sentences: list[str]) -> list[str]:
    """Return the first of many sentences, each once."""
    found = list(dict.fromkeys(sentences))
    more = len(found) - _MOST_FAULTS
    return found[:_MOST_FAULTS] + ([f"and {more} more"] if more > 0 else [])
