"""All sentences about one robot at its steering angles."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy.typing as npt

from trundle.kinematics.constraints import one_steering, wheel_rows
from trundle.kinematics.explain.constraint_words import constraint_words, motions_left
from trundle.kinematics.explain.matrix_words import matrix_words
from trundle.kinematics.explain.wheel_words import wheel_words
from trundle.kinematics.model import Kinematics
from trundle.robot import Robot, RollingWheel


@dataclass(frozen=True)
class Explanation:
    """A robot in sentences; iterating goes through all of them.

    Attributes:
        wheels: one text for each wheel: its force line, its lever arm, its degrees of freedom.
        matrix: one text for each of the three rows of W.
        constraints: one text for each rolling and side-slip row, then the motions they leave.
    """

    wheels: tuple[str, ...]
    matrix: tuple[str, ...]
    constraints: tuple[str, ...]

    def __iter__(self) -> Iterator[str]:
        """Go through all texts in order."""
        return itertools.chain(self.wheels, self.matrix, self.constraints)

    @property
    def sections(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The three parts, each with a title."""
        return (
            ("Wheels", self.wheels),
            ("Rows of W (a wheel's name stands for its speed in rad/s)", self.matrix),
            ("Constraints (omega is the wheel's speed in rad/s)", self.constraints),
        )


def explain(robot: Robot, steering: npt.ArrayLike | None = None) -> Explanation:
    """Return every row of W and of the constraints in sentences with this robot's numbers.

    Args:
        robot: the robot.
        steering: (s,) steering angles [rad] of a robot that steers.

    Raises:
        ShapeError: the steering angles of a robot that steers are missing.
        OffCentreError: the steering angles share no instantaneous centre.

    >>> from trundle import load
    >>> explain(load("differential")).matrix[0]
    'u = 0.025 (left + right): forward speed is the mean of the rim speeds.'
    """
    angles = one_steering(robot, steering)
    Kinematics(robot).wheel_matrix(steering)  # raises where the angles share no centre
    rows = wheel_rows(robot, angles)
    names = [wheel.name for wheel in robot.steered]
    steered: dict[str, float] = dict(zip(names, angles.tolist(), strict=True))
    constraints: list[str] = []
    for wheel in robot.wheels:
        if isinstance(wheel, RollingWheel):
            constraints += constraint_words(wheel, rows[wheel.name], steered.get(wheel.name))
    return Explanation(
        wheels=tuple(
            wheel_words(wheel, rows[wheel.name], steered.get(wheel.name)) for wheel in robot.wheels
        ),
        matrix=matrix_words(robot, angles),
        constraints=(*constraints, motions_left(robot, angles)),
    )
