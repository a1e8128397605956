"""Odometry: dead reckoning, logs and their error against truth."""

from trundle.odometry.dead_reckoning import dead_reckon
from trundle.odometry.log import READINGS, Log, read_log
from trundle.odometry.score import Score, score

__all__ = ["READINGS", "Log", "Score", "dead_reckon", "read_log", "score"]
