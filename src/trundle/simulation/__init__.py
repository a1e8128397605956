"""Simulation: from commands over time to a run."""

from trundle.simulation.casters import caster_angles
from trundle.simulation.commands import Command
from trundle.simulation.run import Run
from trundle.simulation.simulate import simulate

__all__ = ["Command", "Run", "caster_angles", "simulate"]
