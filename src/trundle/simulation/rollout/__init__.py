"""Rollouts of many robots: the same step, compiled and batched."""

from trundle.simulation.rollout.commands import Constant, Policy, Stream
from trundle.simulation.rollout.prepared import PreparedRollout
from trundle.simulation.rollout.reducers import (
    Box,
    Collision,
    Contacts,
    CostSum,
    Disc,
    Exits,
    FirstExit,
    GridCollision,
    PoseSpread,
    PoseStatistics,
    Reducer,
    Spread,
    Statistics,
)
from trundle.simulation.rollout.result import Rollouts
from trundle.simulation.rollout.rollout import compile_rollout, rollout
from trundle.simulation.rollout.sampling import TwistSampler
from trundle.simulation.rollout.saving import Every
from trundle.simulation.rollout.tracking import Tracking

__all__ = [
    "Box",
    "Collision",
    "Constant",
    "Contacts",
    "CostSum",
    "Disc",
    "Every",
    "Exits",
    "FirstExit",
    "GridCollision",
    "Policy",
    "PoseSpread",
    "PoseStatistics",
    "PreparedRollout",
    "Reducer",
    "Rollouts",
    "Spread",
    "Statistics",
    "Stream",
    "Tracking",
    "TwistSampler",
    "compile_rollout",
    "rollout",
]
