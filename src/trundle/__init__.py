"""Wheeled mobile robots: describe a robot by its wheels, get everything that follows."""

from trundle.control import Controller
from trundle.dynamics import Dynamics
from trundle.errors import TrundleError
from trundle.kinematics import Inverse, Kinematics, Mobility, mobility
from trundle.limits import Feasibility
from trundle.motion import Trajectory
from trundle.odometry import dead_reckon
from trundle.robot import (
    BallWheel,
    Body,
    CasterWheel,
    Encoder,
    FixedWheel,
    MecanumWheel,
    Motor,
    OmniWheel,
    Robot,
    SteeredWheel,
    load,
    robot_from_dict,
)
from trundle.simulation import Run, simulate, track

__all__ = [
    "BallWheel",
    "Body",
    "CasterWheel",
    "Controller",
    "Dynamics",
    "Encoder",
    "Feasibility",
    "FixedWheel",
    "Inverse",
    "Kinematics",
    "MecanumWheel",
    "Mobility",
    "Motor",
    "OmniWheel",
    "Robot",
    "Run",
    "SteeredWheel",
    "Trajectory",
    "TrundleError",
    "dead_reckon",
    "load",
    "mobility",
    "robot_from_dict",
    "simulate",
    "track",
]
