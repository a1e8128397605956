"""Dynamics: masses and forces, of the body in the plane and of the wheels."""

from trundle.dynamics.friction import SLOW, friction_torque
from trundle.dynamics.ground import GroundForces
from trundle.dynamics.loads import GRAVITY, wheel_loads
from trundle.dynamics.model import Dynamics
from trundle.dynamics.motors import Limits, Motors
from trundle.dynamics.planar import body_bias, to_body, to_inertial
from trundle.dynamics.reduced import Reduced, reduce

__all__ = [
    "GRAVITY",
    "SLOW",
    "Dynamics",
    "GroundForces",
    "Limits",
    "Motors",
    "Reduced",
    "body_bias",
    "friction_torque",
    "reduce",
    "to_body",
    "to_inertial",
    "wheel_loads",
]
