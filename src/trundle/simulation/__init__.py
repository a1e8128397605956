"""Simulation: from commands over time, or a controller in closed loop, to a run."""

from trundle.simulation.casters import caster_angles
from trundle.simulation.commands import Command
from trundle.simulation.recording import replay, sensed_angles, write_log
from trundle.simulation.rollout import (
    Constant,
    Every,
    Policy,
    PreparedRollout,
    Reducer,
    Rollouts,
    Stream,
    compile_rollout,
    rollout,
)
from trundle.simulation.run import Run
from trundle.simulation.simulate import simulate
from trundle.simulation.tracking import (
    TRACK_METHODS,
    Controller,
    Function,
    Jit,
    Law,
    Measurement,
    Reference,
    track,
)

__all__ = [
    "TRACK_METHODS",
    "Command",
    "Constant",
    "Controller",
    "Every",
    "Function",
    "Jit",
    "Law",
    "Measurement",
    "Policy",
    "PreparedRollout",
    "Reducer",
    "Reference",
    "Rollouts",
    "Run",
    "Stream",
    "caster_angles",
    "compile_rollout",
    "replay",
    "rollout",
    "sensed_angles",
    "simulate",
    "track",
    "write_log",
]
