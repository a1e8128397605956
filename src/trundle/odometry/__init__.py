"""Odometry: dead reckoning, logs and their error against truth."""

from trundle.odometry.dead_reckoning import dead_reckon
from trundle.odometry.log import READINGS, Log, read_log
from trundle.odometry.score import Score, score
from trundle.odometry.table import Counts, write_columns

__all__ = [
    "READINGS",
    "Counts",
    "Log",
    "Score",
    "dead_reckon",
    "read_log",
    "score",
    "write_columns",
]
