"""The picture of many robots under the same commands: their paths, and where they end."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from trundle.errors import ShapeError
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.along import Along, box_of, draw_ends, draw_path, draw_robots, robots_along
from trundle.view.ends import Ends, ends_of
from trundle.view.motion import Motion, check_same
from trundle.view.style import (
    BLUE,
    INK,
    LABEL,
    ORANGE,
    PURPLE,
    SKY,
    SMALL,
    fade,
    fit,
    new_figure,
    put_remark,
    put_title,
    style_axes,
)
from trundle.view.thin import spread

_MOST_DOTS = 4000  # more of them are one blot
_MOST_PATHS = 30
# Ends closer together than so many times the size of the numbers differ by rounding alone.
_ROUNDING = 1e-12
_UNITS = (("m", 1.0, 0.5), ("cm", 1e2, 0.01), ("mm", 1e3, 2e-4), ("µm", 1e6, 0.0))


def plot_cloud(
    robot: Robot,
    run: Run,
    final: npt.ArrayLike,
    paths: npt.ArrayLike | None = None,
    notes: Sequence[str] = (),
) -> Figure:
    """Return the picture of where many robots end under the same commands.

    On the left the nominal robot's path, with the robot at its start and end, and some of the
    others' paths; on the right their ends, relative to the nominal one, and the ellipse about
    their mean that holds 95 % of them if they are normally distributed.

    Args:
        robot: the nominal robot.
        run: its run.
        final: (N, 3) poses x, y, psi in which the robots end [m, m, rad].
        paths: (T, K, 3) poses of some of them over time; at most 30 are drawn.
        notes: what else to write below the title.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        TrundleError: the run is of another robot.
        ShapeError: poses have the wrong shape or are not finite.

    >>> import numpy as np
    >>> from trundle import load, simulate
    >>> robot = load("differential")
    >>> run = simulate(robot, twist=[0.2, 0.0, 0.0], duration=5.0)
    >>> final = run.pose[-1] + np.random.default_rng(1).normal(0.0, 0.01, (1000, 3))
    >>> len(plot_cloud(robot, run, final).axes)
    2
    """
    check_same(robot, run)
    ends, poses = ends_of(run.pose[-1], final), np.asarray(final, dtype=np.float64)
    drawn = np.zeros((1, 0, 3)) if paths is None else _read_paths(paths)
    figure = new_figure(12.0, 6.6)
    put_title(
        figure,
        f"{robot.name}: where {len(poses)} robot{'s' * (len(poses) > 1)} under the same commands "
        "end",
        [_in_words(ends), *notes],
    )
    # Every further line of notes takes its height from the panels.
    height = 0.645 - 0.032 * figure.texts[-1].get_text().count("\n")
    left = figure.add_axes((0.075, 0.185, 0.45, height))
    right = figure.add_axes((0.625, 0.185, 0.355, height))
    _draw_ways(left, robot, run, poses[:_MOST_DOTS], drawn, ends)
    _draw_end(right, ends, poses)
    _put_legend(figure, left, right)
    return figure


def _read_paths(paths: npt.ArrayLike) -> Array:
    """Return at most so many paths (T, K, 3) as are drawn, with no more points than are seen."""
    try:
        poses = np.asarray(paths, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"paths must be poses (T, K, 3), got {paths!r}") from None
    if poses.ndim != 3 or poses.shape[2] != 3 or not len(poses):
        raise ShapeError(f"paths must have the shape (T, K, 3), got {poses.shape}")
    if not np.isfinite(poses).all():
        raise ShapeError("paths must be finite numbers, got nan or inf")
    return poses[spread(len(poses)), :_MOST_PATHS]


def _in_words(ends: Ends) -> str:
    return f"95 % end within {_length(ends.within)} of the nominal end"


def _length(value: float) -> str:
    unit, factor = _unit(value)
    return f"{0.0 if value < 5e-13 else value * factor:.3g} {unit}"


def _unit(size: float) -> tuple[str, float]:
    """Return the unit in which a length is short to write, and how many of it are a metre."""
    if size < 5e-13:
        return "m", 1.0
    return next((unit, factor) for unit, factor, least in _UNITS if size >= least)


def _draw_ways(axes: Axes, robot: Robot, run: Run, dots: Array, paths: Array, ends: Ends) -> None:
    """Draw paths and ends from above, with the nominal robot at its start and end."""
    style_axes(axes, "x [m]", "y [m]")
    axes.set_title("from above", loc="left", fontsize=LABEL, color=INK)
    others = [dots[:, :2], ends.ellipse(), paths[:, :, :2].reshape(-1, 2)]
    every = np.vstack([run.pose[:, :2], *others])
    along = _at_ends(robots_along(robot, run, every, len(run.t)))
    fit(axes, *box_of([every, along.points()]))
    axes.autoscale(False)
    draw_robots(axes, along)
    fan = LineCollection(
        list(paths[:, :, :2].swapaxes(0, 1)), colors=fade(SKY, 0.25), linewidths=0.7,
        label="some paths", zorder=2.5, gid="paths",
    )  # fmt: skip
    if paths.shape[1]:
        axes.add_collection(fan, autolim=False)
    _draw_dots(axes, dots[:, :2])
    draw_path(axes, run.pose, BLUE, 2.0, "nominal path", "path")
    axes.plot(*ends.ellipse().T, color=PURPLE, linewidth=1.6, zorder=3.5, gid="ellipse:path")
    draw_ends(axes, run)
    if along.scale > 1:
        axes.text(
            1.0, 1.015, f"the robot is drawn {along.scale:g} times its size", ha="right",
            va="bottom", fontsize=SMALL, color=INK, transform=axes.transAxes, gid="scale",
        )  # fmt: skip


def _at_ends(along: Along) -> Along:
    """Return the robot at its first and last pose alone."""
    motion, which = along.motion, sorted({0, len(along.shapes) - 1})
    return Along(
        tuple(along.shapes[k] for k in which),
        Motion(motion.t[which], motion.pose[which], tuple(motion.stances[k] for k in which)),
        along.scale,
    )


def _draw_dots(axes: Axes, points: Array) -> None:
    """Draw where robots end, the paler the more they are."""
    alpha = float(np.clip(12 / math.sqrt(len(points)), 0.18, 0.9))
    axes.plot(
        *points.T, "o", color=ORANGE, markersize=3.0, markeredgewidth=0.0, alpha=alpha,
        linestyle="", label="ends", zorder=2.8, gid="dots",
    )  # fmt: skip


def _draw_end(axes: Axes, ends: Ends, poses: Array) -> None:
    """Draw the ends relative to the nominal one, with the ellipse, in a unit that suits."""
    origin = ends.nominal[:2]
    far = float(ends.off.max())
    if far <= _ROUNDING * max(float(np.abs(origin).max()), 1.0):
        style_axes(axes, "x from the nominal end [m]", "y from the nominal end [m]")
        axes.set_xticks([])
        axes.set_yticks([])
        put_remark(axes, "all robots end at the nominal end")
        return
    unit, factor = _unit(far)
    style_axes(axes, f"x from the nominal end [{unit}]", f"y from the nominal end [{unit}]")
    axes.set_title("the ends", loc="left", fontsize=LABEL, color=INK)
    shown = np.vstack([poses[:_MOST_DOTS, :2], poses[ends.farthest, :2][None]])
    dots, ellipse, mean = (
        factor * (each - origin) for each in (shown, ends.ellipse(), ends.mean[:2])
    )
    fit(axes, *box_of([dots, ellipse, np.zeros((1, 2))]))
    axes.autoscale(False)
    _draw_dots(axes, dots)
    axes.plot(
        *ellipse.T, color=PURPLE, linewidth=2.0, label="95 % ellipse", zorder=3.5, gid="ellipse"
    )
    for point, marker, size, face, label in (
        (dots[-1], "D", 8, "white", "farthest robot"),
        ((0.0, 0.0), "s", 10, ORANGE, "nominal end"),
        (mean, "P", 6.5, "white", "mean"),
    ):
        axes.plot(
            *point, marker, markersize=size, markerfacecolor=face, markeredgecolor=INK,
            markeredgewidth=1.3, linestyle="", label=label, zorder=4, gid=label,
        )  # fmt: skip


def _put_legend(figure: Figure, *panels: Axes) -> None:
    """Write one legend for both panels below them; what stands in both is told once."""
    told: dict[str, Artist] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            told.setdefault("nominal end" if label == "end" else label, handle)
    figure.legend(
        list(told.values()), list(told), loc="lower left", bbox_to_anchor=(0.025, 0.015),
        ncols=len(told), frameon=False, fontsize=SMALL, labelcolor=INK, columnspacing=1.3,
        handlelength=2.0, handletextpad=0.5,
    ).set_gid("legend")  # fmt: skip
