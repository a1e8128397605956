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
from trundle.simulation import (
    Constant,
    Every,
    Policy,
    Rollouts,
    Run,
    Stream,
    compile_rollout,
    rollout,
    simulate,
    track,
)

__all__ = [
    "BallWheel",
    "Body",
    "CasterWheel",
    "Constant",
    "Controller",
    "Dynamics",
    "Encoder",
    "Every",
    "Feasibility",
    "FixedWheel",
    "Inverse",
    "Kinematics",
    "MecanumWheel",
    "Mobility",
    "Motor",
    "OmniWheel",
    "Policy",
    "Robot",
    "Rollouts",
    "Run",
    "SteeredWheel",
    "Stream",
    "Trajectory",
    "TrundleError",
    "compile_rollout",
    "dead_reckon",
    "load",
    "mobility",
    "robot_from_dict",
    "rollout",
    "simulate",
    "track",
]
