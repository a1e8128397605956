"""What is made of many robots' poses while they move, so that trajectories need not be stored."""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.recipe import Reduction


class Reducer:
    """What is made of poses and commands, step by step.

    Attributes:
        reduction: the function that the loops run, with its registers.
        constants: (k,) numbers that the function takes, or (k, N) of each robot.
        table: numbers that it looks up.
    """

    reduction: Reduction
    constants: Numbers = np.zeros(0)
    table: Numbers = np.zeros(0)

    def result(self, registers: Numbers, steps: int, dt: float) -> Any:
        """Return what the user sees, of the registers (k, N) after all steps."""
        raise NotImplementedError
