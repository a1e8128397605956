"""Limits: whether a robot can follow a trajectory, and at what pace."""

from trundle.limits.demands import Demand
from trundle.limits.feasibility import KEPT, Feasibility, feasibility

__all__ = ["KEPT", "Demand", "Feasibility", "feasibility"]
