"""The bridge to hardware: from velocity commands to wheel speeds, from counters to a pose."""

from trundle.bridge.bridge import Bridge
from trundle.bridge.odometer import Odometry
from trundle.bridge.output import Output
from trundle.bridge.simulated import Reading, SimulatedRobot, SimulatedState
from trundle.bridge.state import State

__all__ = [
    "Bridge",
    "Odometry",
    "Output",
    "Reading",
    "SimulatedRobot",
    "SimulatedState",
    "State",
]
