"""What is made of many robots' poses while they move, so that trajectories need not be stored."""

from trundle.simulation.rollout.reducers.base import Collected, Reducer
from trundle.simulation.rollout.reducers.collision import Collision, Contacts
from trundle.simulation.rollout.reducers.cost import CostSum
from trundle.simulation.rollout.reducers.exits import Exits, FirstExit
from trundle.simulation.rollout.reducers.grid import GridCollision
from trundle.simulation.rollout.reducers.regions import Box, Disc
from trundle.simulation.rollout.reducers.several import Several
from trundle.simulation.rollout.reducers.spread import PoseSpread, Spread
from trundle.simulation.rollout.reducers.statistics import PoseStatistics, Statistics

__all__ = [
    "Box",
    "Collected",
    "Collision",
    "Contacts",
    "CostSum",
    "Disc",
    "Exits",
    "FirstExit",
    "GridCollision",
    "PoseSpread",
    "PoseStatistics",
    "Reducer",
    "Several",
    "Spread",
    "Statistics",
]
