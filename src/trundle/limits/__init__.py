"""Limits: whether a robot can follow a trajectory, and at what pace."""

from trundle.limits.demands import Demand
from trundle.limits.feasibility import KEPT, Feasibility, feasibility
from trundle.limits.ramp import IMPLAUSIBLE, STILL, Ramp, Twist, TwistLimits, limit_names, per
from trundle.limits.steering import SteeringInput, steering_groups, steering_inputs

__all__ = [
    "IMPLAUSIBLE",
    "KEPT",
    "STILL",
    "Demand",
    "Feasibility",
    "Ramp",
    "SteeringInput",
    "Twist",
    "TwistLimits",
    "feasibility",
    "limit_names",
    "per",
    "steering_groups",
    "steering_inputs",
]
