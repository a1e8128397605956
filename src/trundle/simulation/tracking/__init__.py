"""Simulation in closed loop."""

from trundle.simulation.tracking.laws import Function, Jit, Law
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
