"""A matrix from elsewhere beside ours: the fewest changes that turn ours into it, in words."""

from trundle.kinematics.compare.comparing import compare_matrix
from trundle.kinematics.compare.comparison import Comparison, Difference
from trundle.kinematics.compare.matrix_file import read_matrix

__all__ = ["Comparison", "Difference", "compare_matrix", "read_matrix"]
