"""A path from above with the robot along it: what the pictures of paths have in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.drawing import Shape, paint, place, robot_shapes
from trundle.view.motion import Motion, at_times
from trundle.view.style import DASHES, INK, ORANGE
from trundle.view.thin import spread

_MOST_ROBOTS = 8
# A robot that is smaller than this share of the picture is drawn larger, and the picture says so.
_SMALLEST = 0.07
_PALEST = 0.72  # how much white is mixed into the robot at the start
# A robot farther from its trajectory than so many times the trajectory's size is lost.
_LOST = 3.0
_ROOM = 4.0  # in the robot's reach: a trajectory on the spot has no size


@dataclass(frozen=True)
class Along:
    """A robot as it is drawn at some poses of a run.

    Attributes:
        shapes: its polygons at each of them, in the body frame, scaled.
        motion: times, poses and wheels.
        scale: how many times its size it is drawn.
    """

    shapes: tuple[tuple[Shape, ...], ...]
    motion: Motion
    scale: float

    def points(self) -> Array:
        """Return the corners (k, 2) of all that is drawn, in the inertial frame."""
        return np.vstack(
            [
                place(each.points, pose)
                for drawn, pose in zip(self.shapes, self.motion.pose, strict=True)
                for each in drawn
            ]
        )


def steps_in_view(robot: Robot, run: Run) -> int:
    """Return how many of a run's times come before the robot is lost: all of them, if it is not.

    A loop that is unstable leaves its trajectory by many times the trajectory's size, or spins by
    more than a turn in a step; a picture that held all of it would show nothing else.
    """
    if run.desired is None:
        return len(run.t)
    low, high = run.desired[:, :2].min(axis=0), run.desired[:, :2].max(axis=0)
    room = _LOST * max(float((high - low).max()), _ROOM * robot.reach)
    xy = run.pose[:, :2]
    lost = ((xy < low - room) | (xy > high + room)).any(axis=1)
    lost[1:] |= np.abs(np.diff(run.pose[:, 2])) > math.tau
    return max(int(lost.argmax()), 1) if lost.any() else len(run.t)


def robots_along(robot: Robot, run: Run, every: Array, seen: int) -> Along:
    """Return the robot at some poses of a run.

    Args:
        robot: the robot.
        run: its run.
        every: (k, 2) all other points of the picture.
        seen: how many of the run's times the picture shows.
    """
    motion = at_times(robot, run, _times(run.t[:seen], run.pose[:seen], robot.reach))
    shapes = [robot_shapes(robot, stance) for stance in motion.stances]
    size = float(np.ptp(np.vstack([each.points for each in shapes[0]]), axis=0).max())
    view = max(float(np.ptp(every, axis=0).max()), size)
    scale = max(1.0, float(np.ceil(_SMALLEST * view / size)))
    scaled = tuple(tuple(_scaled(each, scale) for each in drawn) for drawn in shapes)
    return Along(scaled, motion, scale)


def _times(t: Array, pose: Array, reach: float) -> Array:
    """Return the times at which the robot is drawn: evenly along its way, turning counted too."""
    moved = np.abs(np.diff(pose, axis=0)) * (1.0, 1.0, reach)
    way = np.concatenate(
        [[0.0], np.cumsum(np.hypot(np.hypot(moved[:, 0], moved[:, 1]), moved[:, 2]))]
    )
    count = int(np.clip(round(way[-1] / (2.2 * reach)) + 1, 2, _MOST_ROBOTS))
    if way[-1] <= 0:
        return t[-1:]
    return np.asarray(np.interp(np.linspace(0, way[-1], count), way, t))


def _scaled(shape: Shape, scale: float) -> Shape:
    return Shape(shape.of, shape.part, shape.points * scale, shape.face, shape.edge, shape.line)


def box_of(points: Sequence[Array]) -> tuple[Array, Array]:
    """Return the corners of the box that holds points (k, 2)."""
    together = np.vstack(points)
    return together.min(axis=0), together.max(axis=0)


def draw_robots(axes: Axes, along: Along) -> None:
    """Paint the robot at its poses, the paler the earlier."""
    count = len(along.shapes)
    for k, (drawn, pose) in enumerate(zip(along.shapes, along.motion.pose, strict=True)):
        faded = 0.0 if k == count - 1 else _PALEST * (1 - 0.7 * k / (count - 1))
        artist = paint(drawn, pose, faded)
        artist.set_zorder(2 + 0.01 * k)
        artist.set_gid(f"robot:{k}")
        axes.add_collection(artist, autolim=False)


def draw_desired(axes: Axes, desired: Array) -> None:
    """Draw the path (T, 3) of a trajectory that a robot is to follow."""
    points = desired[spread(len(desired))]
    axes.plot(
        points[:, 0], points[:, 1], color=INK, linewidth=1.3, dashes=DASHES, label="desired",
        zorder=3.2, gid="desired",
    )  # fmt: skip


def draw_path(axes: Axes, pose: Array, colour: str, width: float, label: str, gid: str) -> None:
    """Draw the path of poses (T, 3)."""
    points = pose[spread(len(pose))]
    axes.plot(
        points[:, 0], points[:, 1], color=colour, linewidth=width, label=label, zorder=3, gid=gid
    )


def draw_ends(axes: Axes, run: Run, *, end: bool = True) -> None:
    """Mark where a run begins and ends."""
    ends = ((run.pose[0], "o", "white", "start"), (run.pose[-1], "s", ORANGE, "end"))
    for pose, marker, colour, label in ends[: 2 if end else 1]:
        axes.plot(
            pose[0], pose[1], marker, markersize=9, markerfacecolor=colour, markeredgecolor=INK,
            markeredgewidth=1.6, linestyle="", label=label, zorder=4, gid=label,
        )  # fmt: skip
