"""The picture of a trajectory: its path, its heading, and how fast it is run through."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from trundle.errors import TrundleError
from trundle.motion import AnyTrajectory, Course, length, sample
from trundle.se2 import Array
from trundle.view.along import box_of
from trundle.view.labels import LINE, MARK, SOLID, Ground, place_label
from trundle.view.panels import draw, head, hold, stack
from trundle.view.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    PURPLE,
    SMALL,
    TICK,
    fit,
    new_figure,
    put_title,
    style_axes,
)

_WIDTH, _HEIGHT = 13.2, 6.9  # [inch]
_POINTS = 4001
_ARROWS = 24  # that show the heading, at equal times
_LONG = 0.075  # an arrow over the picture's extent
_MARKS = 7  # at most so many times are written along the path
_STILL, _LEAST = 1e-6, 1.0  # a trajectory that moves less turns on the spot; its picture [m]


def plot_trajectory(trajectory: AnyTrajectory, duration: float | None = None) -> Figure:
    """Return the picture of a trajectory: the path from above, and its speeds over time.

    Arrows show the heading at equal times, dots with times the way along the path. Beside it are
    the speed, the yaw rate, and the magnitude of the acceleration.

    Args:
        trajectory: any value with position(t), velocity(t) and acceleration(t).
        duration: how much of it [s]; its own ``duration`` when left out.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        TrundleError: this is no trajectory, or the duration is missing or not positive.

    >>> import trundle
    >>> figure = plot_trajectory(trundle.motion.circle(radius=3.0, rate=0.1))
    >>> [axes.get_title("left") for axes in figure.axes[1:]]
    ['speed [m/s]', 'yaw rate [rad/s]', 'acceleration [mm/s²]']
    """
    if duration is not None and not isinstance(duration, Real):
        raise TrundleError(f"duration must be a positive number of seconds, got {duration!r}")
    seconds = length(trajectory, duration)
    if not (math.isfinite(seconds) and seconds > 0):
        raise TrundleError(f"duration must be a positive number of seconds, got {seconds!r}")
    t = np.linspace(0.0, seconds, _POINTS)
    course = sample(trajectory, t)
    figure = new_figure(_WIDTH, _HEIGHT)
    name = getattr(trajectory, "name", None) or type(trajectory).__name__
    put_title(figure, f"{name[:1].upper()}{name[1:]}", _notes(trajectory, t, course))
    _draw_above(figure, t, course)
    _draw_rates(figure, t, course)
    return figure


def _speed(course: Course) -> Array:
    return np.hypot(course.velocity[:, 0], course.velocity[:, 1])


def _notes(trajectory: AnyTrajectory, t: Array, course: Course) -> list[str]:
    way = float(np.hypot(*np.diff(course.position[:, :2], axis=0).T).sum())
    notes = [f"{way:.4g} m in {t[-1]:.4g} s"]
    heading = getattr(getattr(trajectory, "heading", None), "words", None)
    if isinstance(heading, str):
        notes.append(f"heading {heading}")
    turned = round(float(course.position[-1, 2] - course.position[0, 2]), 3) + 0.0
    notes.append(f"turned by {turned:g} rad")
    return notes


def _draw_above(figure: Figure, t: Array, course: Course) -> None:
    axes = figure.add_axes((0.062, 0.105, 0.455, 0.725))
    style_axes(axes, "x [m]", "y [m]")
    xy = course.position[:, :2]
    low, high = box_of([xy])
    extent = float((high - low).max())
    moves = extent > _STILL
    size = _LONG * extent if moves else _LEAST / 2
    fit(axes, low - size, high + size)
    axes.autoscale(False)
    axes.plot(xy[:, 0], xy[:, 1], color=BLUE, linewidth=2.2, zorder=2, gid="path")
    arrows = _draw_headings(axes, course, size)
    ends = (("start", 0, "o", "white"), ("end", -1, "s", ORANGE))
    for gid, k, marker, colour in ends:
        axes.plot(
            *xy[k], marker, markersize=9, markerfacecolor=colour, markeredgecolor=INK,
            markeredgewidth=1.6, linestyle="", label=gid, zorder=4, gid=gid,
        )  # fmt: skip
    axes.apply_aspect()
    if moves:
        _write_times(axes, t, xy, arrows)
    axes.plot([], [], color=INK, linewidth=1.2, label="heading", marker=">", markersize=5)
    axes.legend(
        loc="lower left", bbox_to_anchor=(-0.01, 1.0), borderaxespad=0.1, frameon=False, ncols=3,
        fontsize=SMALL, labelcolor=INK, columnspacing=1.4,
    ).set_gid("legend")  # fmt: skip


def _draw_headings(axes: Axes, course: Course, size: float) -> list[Array]:
    """Draw arrows of the heading, and return their ends, each (2, 2)."""
    which = np.linspace(0, _POINTS - 1, _ARROWS + 1).round().astype(int)
    x, y, psi = course.position[which].T
    along = size * np.stack([np.cos(psi), np.sin(psi)])
    arrows = axes.quiver(
        x, y, *along, angles="xy", scale_units="xy", scale=1.0, width=0.0035, headwidth=4.5,
        headlength=5.0, color=INK, zorder=3,
    )  # fmt: skip
    arrows.set_gid("heading")
    tails = np.stack([x, y])
    return list(np.stack([tails, tails + along]).transpose(2, 0, 1))


def _write_times(axes: Axes, t: Array, xy: Array, arrows: list[Array]) -> None:
    ticks = MaxNLocator(_MARKS, steps=[1, 2, 2.5, 5, 10]).tick_values(0.0, t[-1])
    ground = Ground(axes)
    ground.add_line(xy[:: _POINTS // 400], 4 * LINE)
    for each in arrows:
        ground.add_line(each, MARK)
    for k in (0, -1):
        ground.add_line(xy[[k]], SOLID)
    for time in ticks[(ticks > 0.02 * t[-1]) & (ticks < 0.98 * t[-1])]:
        at = (float(np.interp(time, t, xy[:, 0])), float(np.interp(time, t, xy[:, 1])))
        axes.plot(*at, "o", color=BLUE, markersize=7, zorder=3.5, gid=f"mark:{time:g}")
        outwards = (at[0] - float(xy[:, 0].mean()), at[1] - float(xy[:, 1].mean()))
        place_label(
            ground, f"{time:g} s", at, outwards, np.array([at]), fontsize=TICK - 1, color=MUTED,
            gid=f"time:{time:g}",
        )  # fmt: skip


def _draw_rates(figure: Figure, t: Array, course: Course) -> None:
    panels = stack(figure, (0.605, 0.105, 0.37, 0.735), [1.0, 1.0, 1.0])
    panels[0].set_xlim(0.0, t[-1])
    rising = np.hypot(course.acceleration[:, 0], course.acceleration[:, 1])
    for axes, values, what, base, rest, colour in (
        (panels[0], _speed(course), "speed", "m", "/s", BLUE),
        (panels[1], course.velocity[:, 2], "yaw rate", "rad", "/s", GREEN),
        (panels[2], rising, "acceleration", "m", "/s²", PURPLE),
    ):
        draw(axes, t, values, color=colour, linewidth=2.0, gid=what)
        head(axes, f"{what} [{hold(axes, [values], base)}{rest}]")
