"""Kinematics: constraint matrices, mobility, forward and inverse maps, the geometry doctor."""

from trundle.kinematics.centre import consistent_angles, off_centre_words, share_centre
from trundle.kinematics.compare import Comparison, compare_matrix, read_matrix
from trundle.kinematics.constraints import (
    abreast,
    finite,
    frame,
    gains,
    robot_of,
    rolling_matrix,
    side_slip_matrix,
    skid_matrices,
    steering_array,
)
from trundle.kinematics.doctor import diagnose
from trundle.kinematics.estimate import Estimate
from trundle.kinematics.explain import Explanation, explain
from trundle.kinematics.finding import Finding
from trundle.kinematics.inverse import Inverse
from trundle.kinematics.maps import motion_projector, wheel_matrix
from trundle.kinematics.mobility import Mobility, mobility
from trundle.kinematics.model import Kinematics
from trundle.kinematics.plain import Plain, StraightLines, step_lines, straight_lines
from trundle.kinematics.steering import motion_space
from trundle.kinematics.straight import Code, Straight

__all__ = [
    "Code",
    "Comparison",
    "Estimate",
    "Explanation",
    "Finding",
    "Inverse",
    "Kinematics",
    "Mobility",
    "Plain",
    "Straight",
    "StraightLines",
    "abreast",
    "compare_matrix",
    "consistent_angles",
    "diagnose",
    "explain",
    "finite",
    "frame",
    "gains",
    "mobility",
    "motion_projector",
    "motion_space",
    "off_centre_words",
    "read_matrix",
    "robot_of",
    "rolling_matrix",
    "share_centre",
    "side_slip_matrix",
    "skid_matrices",
    "steering_array",
    "step_lines",
    "straight_lines",
    "wheel_matrix",
]
