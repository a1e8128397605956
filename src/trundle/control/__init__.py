"""Control: from what is measured and wanted to forces, torques and twists."""

from trundle.control.mppi import MPPI, Foresight
from trundle.control.pose import PD, ComputedTorque
from trundle.control.rate import ResolvedRate
from trundle.control.reduced import ReducedComputedTorque
from trundle.control.tracking import GoToPose, Kanayama
from trundle.simulation import Controller, Measurement, Reference

__all__ = [
    "MPPI",
    "PD",
    "ComputedTorque",
    "Controller",
    "Foresight",
    "GoToPose",
    "Kanayama",
    "Measurement",
    "ReducedComputedTorque",
    "Reference",
    "ResolvedRate",
]
