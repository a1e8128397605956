"""Simulation: from commands over time to a run."""

from trundle.simulation.casters import caster_angles
from trundle.simulation.commands import Command
from trundle.simulation.recording import replay, sensed_angles, write_log
from trundle.simulation.run import Run
from trundle.simulation.simulate import simulate

__all__ = ["Command", "Run", "caster_angles", "replay", "sensed_angles", "simulate", "write_log"]
