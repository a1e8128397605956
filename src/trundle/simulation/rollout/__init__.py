"""Rollouts of many robots: the same step, compiled and batched."""

from trundle.simulation.rollout.commands import Constant, Policy, Stream
from trundle.simulation.rollout.reducers import Reducer
from trundle.simulation.rollout.rollout import (
    PreparedRollout,
    Rollouts,
    compile_rollout,
    rollout,
)
from trundle.simulation.rollout.saving import Every

__all__ = [
    "Constant",
    "Every",
    "Policy",
    "PreparedRollout",
    "Reducer",
    "Rollouts",
    "Stream",
    "compile_rollout",
    "rollout",
]
