"""Compare a matrix from elsewhere with ours: exactly, then to the digits that are given."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from trundle.kinematics.compare.comparison import Comparison, Difference, comparison
from trundle.kinematics.compare.nearest import nearest
from trundle.kinematics.compare.our_maps import EXACT, OurMaps, our_maps
from trundle.kinematics.compare.readings import PRINTED, Reading, print_tolerance, readings_of
from trundle.kinematics.compare.search import ChangeSet, candidates, cheapest
from trundle.kinematics.compare.wheel_words import order_words, wheel_words
from trundle.kinematics.compare.words import matrix_words
from trundle.kinematics.constraints import finite
from trundle.robot import Robot
from trundle.se2 import Array


def compare_matrix(
    robot: Robot, matrix: npt.ArrayLike, steering: npt.ArrayLike | None = None
) -> Comparison:
    """Return how a matrix from elsewhere compares with ours, with the differences in words.

    Looked for are the fewest changes that turn ours into it: rim speeds, order, reversed wheels,
    mirrored rollers, signs and order of the twist's components, the yaw arm, units and factors.

    Args:
        robot: the robot.
        matrix: (3, n) forward or (n, 3) inverse; robots without sideways motion may leave out VY.
            The columns of an inverse count only for twists that the robot can have.
        steering: (s,) steering angles [rad] of a robot that steers.

    Raises:
        ShapeError: the matrix fits neither form, or steering angles are missing.
        OffCentreError: the steering angles share no instantaneous centre.
        TrundleError: no driven wheel moves the robot.

    >>> from trundle import load
    >>> compare_matrix(load("differential"), [[0.025, 0.025], [-0.0625, 0.0625]]).findings[0].code
    'arm_doubled'
    """
    pasted = finite(matrix, "matrix")
    ours = our_maps(robot, steering)
    readings, pairs = readings_of(pasted, ours), candidates(ours)
    for step, tolerances in enumerate(_steps(readings)):
        best: ChangeSet | None = None
        for reading, tolerance in tolerances:
            best = cheapest(ours, reading, pairs, tolerance, best)
        if best is not None:
            return _explained(ours, best, rounded=step > 0)
    return nearest(ours, readings)


def _steps(readings: list[Reading]) -> Iterator[list[tuple[Reading, Array]]]:
    """Yield each reading with its tolerance (3,): exact, in four digits, in fewer."""
    yield [(reading, np.full(3, EXACT)) for reading in readings]
    yield [(reading, np.full(3, PRINTED)) for reading in readings]
    coarse = [(reading, print_tolerance(reading)) for reading in readings]
    yield [(reading, tolerance) for reading, tolerance in coarse if (tolerance > PRINTED).any()]


def _explained(ours: OurMaps, found: ChangeSet, rounded: bool) -> Comparison:
    findings = [*matrix_words(ours, found), *wheel_words(ours, found)]
    agrees = not findings
    findings += order_words(ours, found)
    if rounded:
        same = "it agrees" if agrees else "with these changes it agrees"
        findings.append(Difference("rounded", f"{same} to the digits given"))
    return comparison(
        ours,
        found.reading,
        findings,
        agrees=agrees,
        rim=found.fit.scale.rim,
        order=found.fit.order,
    )
