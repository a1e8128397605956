"""The picture of the twists that a robot can reach within its wheels' speed limits."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from trundle.kinematics import Kinematics
from trundle.robot import Robot
from trundle.view.inputs import steering_of
from trundle.view.reach import (
    ASSUMED_SPEED,
    Section,
    limited,
    sections_at,
    sections_over_steering,
)
from trundle.view.style import (
    BLUE,
    FAINT,
    INK,
    LABEL,
    fade,
    new_figure,
    put_remark,
    put_title,
    style_axes,
)

_LABELS = ("u, forward [m/s]", "v, to the left [m/s]", "r, yaw rate [rad/s]")
_MARGIN = 1.15  # limits of the axes over the extent of what is drawn


def plot_reachable(robot: Robot, steering: npt.ArrayLike | None = None) -> Figure:
    """Return the picture of the twists that a robot can reach without exceeding ``max_speed``.

    A twist is outside where any wheel would have to turn faster than its limit. Robots that move
    freely are shown in three cross-sections through standstill; those with two freedoms in one
    figure, the third component follows. Robots that steer are shown at the steering angles given;
    without them, every twist counts that some steering angles allow. Where a wheel has no
    ``max_speed``, 10 rad/s is taken, and the picture says so.

    Args:
        robot: the robot.
        steering: (s,) steering angles [rad], held.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        ShapeError: steering has the wrong shape or is not finite.
        OffCentreError: the steering angles share no instantaneous centre.

    >>> from trundle import load
    >>> [axes.get_title("left") for axes in plot_reachable(load("mecanum")).axes]
    ['r = 0', 'v = 0', 'u = 0']
    """
    fast, assumed = limited(robot)
    kinematics = Kinematics(fast)
    if robot.steered and steering is None:
        sections = sections_over_steering(kinematics)
        how = "every twist that some steering angles allow"
    else:
        angles = steering_of(kinematics, steering)
        sections = sections_at(kinematics, angles)
        told = ", ".join(f"{round(angle, 1) + 0.0:g}" for angle in np.degrees(angles))
        how = f"steering held at {told} deg" if robot.steered else "outside, a wheel turns too fast"
    figure = new_figure(12.6, 4.9) if len(sections) == 3 else new_figure(8.4, 6.2)
    notes = _notes(how, assumed) if sections else []
    put_title(figure, f"{robot.name}: reachable twists, {_speeds(fast)}", notes)
    if not sections:
        axes = figure.add_axes((0.1, 0.1, 0.8, 0.7))
        axes.set_axis_off()
        put_remark(axes, "no motor can move this robot")
    for k, section in enumerate(sections):
        _draw(_panel(figure, k, len(sections)), section)
    return figure


def _speeds(robot: Robot) -> str:
    speeds = sorted({wheel.max_speed for wheel in robot.driven if wheel.max_speed})
    if not speeds:
        return "no motor"
    many = f"{speeds[0]:g} to {speeds[-1]:g}" if len(speeds) > 1 else f"{speeds[0]:g}"
    return f"wheels at up to {many} rad/s"


def _notes(how: str, assumed: float | None) -> list[str]:
    notes = [how]
    if assumed is not None:
        notes.append(f"{ASSUMED_SPEED:g} rad/s is assumed where no max_speed is given")
    return notes


def _panel(figure: Figure, k: int, count: int) -> Axes:
    if count == 1:
        return figure.add_axes((0.125, 0.115, 0.83, 0.68))
    return figure.add_axes((0.07 + k * 0.325, 0.145, 0.245, 0.6))


def _draw(axes: Axes, section: Section) -> None:
    i, j = section.axes
    style_axes(axes, _LABELS[i], _LABELS[j])
    words = [section.words, *(f"the motors do not limit {name}" for name in section.unlimited)]
    axes.set_title(", ".join(words), fontsize=LABEL, color=INK, loc="left")
    axes.axhline(0, color=FAINT, linewidth=1.0, zorder=1)
    axes.axvline(0, color=FAINT, linewidth=1.0, zorder=1)
    axes.add_patch(
        Polygon(
            section.outline,
            closed=True,
            facecolor=fade(BLUE, 0.75),
            edgecolor=BLUE,
            linewidth=2.2,
            joinstyle="round",
            zorder=2,
            gid="reachable",
        )
    )
    high = _MARGIN * np.abs(section.outline).max(axis=0)
    high = np.where(high > 1e-9 * high.max(), high, high.max())
    high = high / _MARGIN if section.unlimited else high
    if section.axes == (0, 1):
        high[:] = high.max()
        axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(-high[0], high[0])
    axes.set_ylim(-high[1], high[1])
