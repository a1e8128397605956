"""Robots: wheels, catalogue and files."""

from trundle.robot.catalog import CATALOG, from_catalog
from trundle.robot.files import load, save, to_toml
from trundle.robot.masses import TotalMass, missing_masses, total_mass
from trundle.robot.motor import Encoder, Motor
from trundle.robot.quantity import Quantity, check, quantity
from trundle.robot.reading import robot_from_dict
from trundle.robot.robot import Body, Robot
from trundle.robot.wheels import (
    WHEEL_KINDS,
    BallWheel,
    CasterWheel,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    RollingWheel,
    Rows,
    SteeredWheel,
    SwedishWheel,
    Wheel,
)


def json_schema() -> dict[str, object]:
    """Return the JSON schema with which editors complete and check robot files."""
    from trundle.robot import schema

    return schema.json_schema()


__all__ = [
    "CATALOG",
    "WHEEL_KINDS",
    "BallWheel",
    "Body",
    "CasterWheel",
    "Encoder",
    "FixedWheel",
    "MecanumWheel",
    "Motor",
    "OmniWheel",
    "Quantity",
    "RollingWheel",
    "Robot",
    "Rows",
    "SteeredWheel",
    "SwedishWheel",
    "TotalMass",
    "Wheel",
    "check",
    "from_catalog",
    "json_schema",
    "load",
    "missing_masses",
    "quantity",
    "robot_from_dict",
    "save",
    "to_toml",
    "total_mass",
]
