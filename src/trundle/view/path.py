"""The picture of a path with the robot drawn along it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trundle.errors import ShapeError
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.drawing import Shape, paint, place, robot_shapes
from trundle.view.motion import Motion, at_times
from trundle.view.style import (
    BLUE,
    INK,
    ORANGE,
    SMALL,
    fit,
    new_figure,
    put_title,
    style_axes,
)

_MOST_ROBOTS = 8
# A robot that is smaller than this share of the picture is drawn larger, and the picture says so.
_SMALLEST = 0.07
_PALEST = 0.72  # how much white is mixed into the robot at the start


def plot_path(robot: Robot, run: Run, truth: npt.ArrayLike | None = None) -> Figure:
    """Return the picture of a run from above: the path, and the robot at some of its poses.

    Args:
        robot: the robot of the run.
        run: the run.
        truth: (T, 3) poses x, y, psi [m, m, rad] to compare with, as of a motion capture.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        TrundleError: the run is of another robot.
        ShapeError: truth has the wrong shape or is not finite.

    >>> from trundle import load, simulate
    >>> robot = load("differential")
    >>> run = simulate(robot, twist=[0.2, 0.0, 0.5], duration=5.0)
    >>> plot_path(robot, run).axes[0].get_aspect()
    1.0
    """
    true = None if truth is None else _poses(truth)
    motion = at_times(robot, run, _times(run, robot.reach))
    every = run.pose[:, :2] if true is None else np.vstack([run.pose[:, :2], true[:, :2]])
    shapes = [robot_shapes(robot, stance) for stance in motion.stances]
    size = _size(shapes[0])
    view = max(float(np.ptp(every, axis=0).max()), size)
    scale = max(1.0, np.ceil(_SMALLEST * view / size))
    shapes = [[_scaled(each, scale) for each in drawn] for drawn in shapes]

    figure = new_figure(10.0, 6.4)
    axes = figure.add_axes((0.105, 0.105, 0.655, 0.735))
    style_axes(axes, "x [m]", "y [m]")
    put_title(figure, f"{robot.name}: path from above", _notes(run, scale))
    fit(axes, *_bounds(shapes, motion, every))
    _draw_robots(axes, shapes, motion)
    _draw_paths(axes, run, true)
    return figure


def _poses(truth: npt.ArrayLike) -> Array:
    try:
        poses = np.asarray(truth, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"truth must be poses (x, y, psi), got {truth!r}") from None
    if poses.ndim != 2 or poses.shape[1] != 3 or not len(poses):
        raise ShapeError(f"truth must have the shape (T, 3), got {poses.shape}")
    if not np.isfinite(poses).all():
        raise ShapeError("truth must be finite numbers, got nan or inf")
    return poses


def _times(run: Run, reach: float) -> Array:
    """Return the times at which the robot is drawn: evenly along its way, turning counted too."""
    moved = np.abs(np.diff(run.pose, axis=0)) * (1.0, 1.0, reach)
    way = np.concatenate(
        [[0.0], np.cumsum(np.hypot(np.hypot(moved[:, 0], moved[:, 1]), moved[:, 2]))]
    )
    count = int(np.clip(round(way[-1] / (2.2 * reach)) + 1, 2, _MOST_ROBOTS))
    if way[-1] <= 0:
        return run.t[-1:]
    return np.asarray(np.interp(np.linspace(0, way[-1], count), way, run.t))


def _size(shapes: list[Shape]) -> float:
    return float(np.ptp(np.vstack([each.points for each in shapes]), axis=0).max())


def _scaled(shape: Shape, scale: float) -> Shape:
    return Shape(shape.of, shape.part, shape.points * scale, shape.face, shape.edge, shape.line)


def _bounds(shapes: list[list[Shape]], motion: Motion, every: Array) -> tuple[Array, Array]:
    points = [every]
    for drawn, pose in zip(shapes, motion.pose, strict=True):
        points += [place(each.points, pose) for each in drawn]
    together = np.vstack(points)
    return together.min(axis=0), together.max(axis=0)


def _notes(run: Run, scale: float) -> list[str]:
    length = float(np.hypot(*np.diff(run.pose[:, :2], axis=0).T).sum())
    turn, time = float(run.pose[-1, 2] - run.pose[0, 2]), float(run.t[-1] - run.t[0])
    notes = [f"{length:.2f} m in {time:.4g} s, turned by {round(turn, 2) + 0.0:g} rad"]
    if scale > 1:
        notes.append(f"the robot is drawn {scale:g} times its size")
    return notes


def _draw_robots(axes: Axes, shapes: list[list[Shape]], motion: Motion) -> None:
    count = len(shapes)
    for k, (drawn, pose) in enumerate(zip(shapes, motion.pose, strict=True)):
        faded = 0.0 if k == count - 1 else _PALEST * (1 - 0.7 * k / (count - 1))
        artist = paint(drawn, pose, faded)
        artist.set_zorder(2 + 0.01 * k)
        artist.set_gid(f"robot:{k}")
        axes.add_collection(artist, autolim=False)


def _draw_paths(axes: Axes, run: Run, truth: Array | None) -> None:
    axes.autoscale(False)
    if truth is not None:
        axes.plot(
            truth[:, 0], truth[:, 1], color=INK, linewidth=1.6, dashes=(5, 2.5), label="truth",
            zorder=3.1, gid="truth",
        )  # fmt: skip
    axes.plot(
        run.pose[:, 0], run.pose[:, 1], color=BLUE, linewidth=2.2, label="path", zorder=3,
        gid="path",
    )  # fmt: skip
    for pose, marker, colour, label in (
        (run.pose[0], "o", "white", "start"),
        (run.pose[-1], "s", ORANGE, "end"),
    ):
        axes.plot(
            pose[0], pose[1], marker, markersize=9, markerfacecolor=colour, markeredgecolor=INK,
            markeredgewidth=1.6, linestyle="", label=label, zorder=4, gid=label,
        )  # fmt: skip
    legend = axes.legend(
        loc="upper left", bbox_to_anchor=(1.02, 1.01), borderaxespad=0.0, frameon=False,
        fontsize=SMALL + 1, labelcolor=INK, labelspacing=0.9,
    )  # fmt: skip
    legend.set_gid("legend")
