"""The picture of a path with the robot drawn along it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from trundle.errors import ShapeError
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.along import (
    box_of,
    draw_desired,
    draw_ends,
    draw_path,
    draw_robots,
    robots_along,
    steps_in_view,
)
from trundle.view.motion import check_same
from trundle.view.style import BLUE, INK, SMALL, fit, new_figure, put_title, style_axes

_LONG = 1e6  # no more digits of a length than can be read [m]


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
    check_same(robot, run)
    seen = steps_in_view(robot, run)
    others = [each for each in (run.desired, true) if each is not None]
    every = np.vstack([each[:, :2] for each in (run.pose[:seen], *others)])
    along = robots_along(robot, run, every, seen)

    figure = new_figure(10.0, 6.4)
    axes = figure.add_axes((0.105, 0.105, 0.655, 0.735))
    style_axes(axes, "x [m]", "y [m]")
    put_title(figure, f"{robot.name}: path from above", _notes(run, along.scale, seen))
    fit(axes, *box_of([every, along.points()]))
    axes.autoscale(False)
    draw_robots(axes, along)
    if run.desired is not None:
        draw_desired(axes, run.desired)
    if true is not None:
        axes.plot(
            true[:, 0], true[:, 1], color=INK, linewidth=1.6, dashes=(5, 2.5), label="truth",
            zorder=3.1, gid="truth",
        )  # fmt: skip
    draw_path(axes, run.pose[: seen + 1], BLUE, 2.2, "path", "path")
    draw_ends(axes, run, end=seen == len(run.t))
    legend = axes.legend(
        loc="upper left", bbox_to_anchor=(1.02, 1.01), borderaxespad=0.0, frameon=False,
        fontsize=SMALL + 1, labelcolor=INK, labelspacing=0.9, handlelength=2.6,
    )  # fmt: skip
    legend.set_gid("legend")
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


def _notes(run: Run, scale: float, seen: int) -> list[str]:
    length = float(np.hypot(*np.diff(run.pose[:, :2], axis=0).T).sum())
    turn, time = float(run.pose[-1, 2] - run.pose[0, 2]), float(run.t[-1] - run.t[0])
    way = f"{length:.2f}" if length < _LONG else f"{length:.3g}"
    notes = [f"{way} m in {time:.4g} s, turned by {round(turn, 2) + 0.0:g} rad"]
    if scale > 1:
        notes.append(f"the robot is drawn {scale:g} times its size")
    if seen < len(run.t):
        notes.append(f"lost at t = {run.t[seen]:.4g} s")
    return notes
