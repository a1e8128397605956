"""Which joints of a URDF are driven and measured, where it says so."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree as ET


class Actuators(NamedTuple):
    """Joints with a command and joints with a state that is measured; ``source`` tells where."""

    source: str
    commanded: frozenset[str]
    measured: frozenset[str]


def read_actuators(root: ET.Element) -> Actuators:
    """Return what ``<transmission>`` and ``<ros2_control>`` say of the joints.

    Source: ROS 2 control documentation, "ros2_control hardware interface types", and the URDF
    page on transmissions of the ROS wiki.
    """
    commanded, measured, sources = set(), set(), []
    for each in root.findall("transmission/joint"):
        commanded.add(each.get("name", ""))
        sources.append("<transmission>")
    for each in root.findall("ros2_control/joint"):
        name = each.get("name", "")
        if each.find("command_interface") is not None:
            commanded.add(name)
        if each.find("state_interface") is not None:
            measured.add(name)
        sources.append("<ros2_control>")
    told = " and ".join(dict.fromkeys(sources))
    return Actuators(told, frozenset(commanded), frozenset(measured))
