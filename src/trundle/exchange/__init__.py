"""Robots for other programs: firmware in C, URDF, settings of ros2_controllers."""

from trundle.exchange.c import c_files
from trundle.exchange.names import (
    JointNames,
    check_xml,
    comment,
    identifiers,
    joint_names,
    plain_name,
    renamed,
    yaml_number,
    yaml_string,
)
from trundle.exchange.ros2.export import ros2_controllers
from trundle.exchange.urdf import urdf

__all__ = [
    "JointNames",
    "c_files",
    "check_xml",
    "comment",
    "identifiers",
    "joint_names",
    "plain_name",
    "renamed",
    "ros2_controllers",
    "urdf",
    "yaml_number",
    "yaml_string",
]
