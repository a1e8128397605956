"""A robot's rows in sentences, with its own numbers: what each wheel does, W, and the constraints.

Every sentence is made from the rows, so that it is true of any mixture of wheels.
"""

from trundle.kinematics.explain.explanation import Explanation, explain

__all__ = ["Explanation", "explain"]
