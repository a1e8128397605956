"""Kinematics: constraint matrices, mobility, forward and inverse maps."""

from trundle.kinematics.inverse import Inverse
from trundle.kinematics.mobility import Mobility, mobility
from trundle.kinematics.model import Kinematics
from trundle.kinematics.plain import Plain

__all__ = ["Inverse", "Kinematics", "Mobility", "Plain", "mobility"]
