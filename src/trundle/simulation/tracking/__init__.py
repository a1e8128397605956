"""Simulation in closed loop."""

from trundle.simulation.arithmetic import Function, Jit
from trundle.simulation.tracking.laws import Law
from trundle.simulation.tracking.signals import Controller, Measurement, Reference
from trundle.simulation.tracking.track import TRACK_METHODS, track

__all__ = [
    "TRACK_METHODS",
    "Controller",
    "Function",
    "Jit",
    "Law",
    "Measurement",
    "Reference",
    "track",
]
