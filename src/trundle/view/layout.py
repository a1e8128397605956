"""The picture of a robot from above, with what each of its wheels can and cannot do."""

from __future__ import annotations

import textwrap
from typing import Literal

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from trundle.kinematics import Kinematics, mobility
from trundle.robot import Robot, SwedishWheel
from trundle.se2 import Array
from trundle.view.centre import find_centre
from trundle.view.drawing import DRIVEN, LOOKS, look_of, robot_shapes
from trundle.view.inputs import steering_of, twist_of
from trundle.view.labels import LINE, MARK, SOLID, Ground, place_label
from trundle.view.sketch import Sketch
from trundle.view.stance import stand, trailing
from trundle.view.style import (
    INK,
    MUTED,
    PURPLE,
    SMALL,
    TICK,
    fit,
    new_figure,
    put_title,
    style_axes,
)

LineStyle = Literal["-", "--", ":", ""]

_ROLLERS_BELOW = "rollers as they touch the ground,\nseen through the wheel"


def plot_layout(
    robot: Robot, steering: npt.ArrayLike | None = None, twist: npt.ArrayLike | None = None
) -> Figure:
    """Return the picture of a robot from above: its wheels, and what they can and cannot do.

    Wheels are true to size, rollers drawn as they touch the ground. A dashed line is a wheel's
    force line, along which it can push: the axis of a Swedish wheel's roller, the drive direction
    of a standard wheel. A dotted line is a wheel's zero line: it cannot slip sideways, so the
    instantaneous centre lies on that line. An arrow is the way a positive motor speed drives.

    Args:
        robot: the robot.
        steering: (s,) steering angles [rad]; without them those for the twist, or zero.
        twist: (3,) body twist (u, v, r) [m/s, m/s, rad/s] whose instantaneous centre is drawn;
            without it the centre is drawn where the steering angles leave only one.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        ShapeError: steering or twist has the wrong shape or is not finite.

    >>> from trundle import load
    >>> figure = plot_layout(load("ackermann"), twist=[1.0, 0.0, 0.25])
    >>> figure.axes[0].get_xlabel()
    'x [m]'
    """
    kinematics = Kinematics(robot)
    asked = None if twist is None else twist_of(twist)
    angles = steering_of(kinematics, steering, asked)
    stance = stand(robot, angles, None if asked is None else trailing(robot, asked))
    centre = find_centre(kinematics, angles, asked)
    sketch = Sketch(robot, stance, centre, robot_shapes(robot, stance, "ground"))

    figure = new_figure(10.5, 6.4)
    axes = figure.add_axes((0.09, 0.105, 0.585, 0.735))
    style_axes(axes, "x [m]", "y [m]")
    put_title(figure, f"{robot.name} seen from above", _notes(sketch, angles, asked))
    fit(axes, *sketch.bounds())
    axes.autoscale(False)
    _draw_shapes(axes, sketch)
    _draw_lines(axes, sketch)
    _draw_arrows(axes, sketch)
    _draw_centre(axes, sketch)
    axes.apply_aspect()
    _write_names(axes, sketch)
    _add_legend(axes, sketch)
    return figure


def _notes(sketch: Sketch, angles: Array, twist: Array | None) -> list[str]:
    robot, found = sketch.robot, mobility(sketch.robot)
    skids = any(wheel.rows().skid is not None for wheel in robot.wheels)
    notes = [f"mobility {found.kind}" + (" if no wheel slips; here wheels skid" if skids else "")]
    notes[0] += ", omnidirectional" if found.omnidirectional else ""
    if twist is not None:
        u, v, r = (float(each) for each in twist)
        notes.append(f"twist (u, v, r) = ({u:.3g} m/s, {v:.3g} m/s, {r:.3g} rad/s)")
    if robot.steered:
        told = ", ".join(f"{round(angle, 1) + 0.0:g}" for angle in np.degrees(angles))
        notes.append(f"steering {told} deg")
    if sketch.centre.point is None and sketch.centre.words:
        notes.append(sketch.centre.words)
    return notes


def _draw_shapes(axes: Axes, sketch: Sketch) -> None:
    for shape in sketch.shapes:
        patch = Polygon(
            shape.points, closed=True, facecolor=shape.face, edgecolor=shape.edge,
            linewidth=shape.line, zorder=3.0 if shape.of else 1.0, gid=f"{shape.part}:{shape.of}",
        )  # fmt: skip
        axes.add_patch(patch)


def _draw_lines(axes: Axes, sketch: Sketch) -> None:
    for wheel in sketch.pushing:
        ends = sketch.force_line(wheel)
        colour = look_of(wheel).face
        axes.plot(
            *ends.T, color=colour, linewidth=1.1, dashes=(6, 3), alpha=0.75, zorder=2.2,
            gid=f"force:{wheel.name}",
        )  # fmt: skip
    if sketch.centre.point is None:
        for held in sketch.held:
            axes.plot(
                *sketch.zero_line(held).T, color=MUTED, linewidth=1.2, linestyle=":", zorder=2.0,
                gid=f"zero:{held.name}",
            )  # fmt: skip


def _draw_arrows(axes: Axes, sketch: Sketch) -> None:
    for wheel in sketch.arrowed:
        tail, tip = sketch.drive_arrow(wheel)
        _arrow(axes, tail, tip, look_of(wheel).edge, 2.0, f"drive:{wheel.name}")
    for end, name in sketch.frame_tips:
        _arrow(axes, (0.0, 0.0), end, INK, 2.2, f"frame:{name}")
    axes.plot(0, 0, "o", color=INK, markersize=5, zorder=6)


def _arrow(
    axes: Axes, tail: npt.ArrayLike, tip: npt.ArrayLike, colour: str, width: float, gid: str
) -> None:
    start, end = np.asarray(tail, dtype=np.float64), np.asarray(tip, dtype=np.float64)
    axes.annotate(
        "", (end[0], end[1]), (start[0], start[1]), zorder=6, gid=gid,
        arrowprops={
            "arrowstyle": "-|>,head_width=0.22,head_length=0.5", "color": colour,
            "linewidth": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 14,
        },
    )  # fmt: skip


def _draw_centre(axes: Axes, sketch: Sketch) -> None:
    point = sketch.centre.point
    if point is None:
        return
    for wheel in sketch.robot.wheels:
        x, y = sketch.stance.contact(wheel)
        free = wheel.rows().side_slip is None
        axes.plot(
            [point[0], x], [point[1], y], color=PURPLE, linewidth=0.9 if free else 1.4,
            linestyle=":" if free else "-", alpha=0.8, zorder=2.1, gid=f"centre:{wheel.name}",
        )  # fmt: skip
    if sketch.centre_in_view is not None:
        axes.plot(
            *point, marker="o", markersize=11, markerfacecolor="white", markeredgecolor=PURPLE,
            markeredgewidth=2.2, zorder=7, gid="centre",
        )  # fmt: skip
        axes.plot(*point, marker="o", markersize=3.5, color=PURPLE, zorder=7.1)


def _write_names(axes: Axes, sketch: Sketch) -> None:
    ground = Ground(axes)
    marks: list[tuple[Array, float]] = []
    marks += [(np.array(sketch.drive_arrow(wheel)), MARK) for wheel in sketch.arrowed]
    marks += [(np.array([(0.0, 0.0), tip]), MARK) for tip, _ in sketch.frame_tips]
    for shape in sketch.shapes:
        if shape.part == "body":
            ground.add_line(np.vstack([shape.points, shape.points[:1]]), 2 * LINE)
        elif shape.part in ("wheel", "pivot"):
            ground.add_polygon(shape.points, SOLID)
    marks += [(np.array(line.get_xydata()), LINE) for line in axes.get_lines()]
    for points, weight in marks:
        ground.add_line(points, weight)
    dot = np.zeros((1, 2))
    for tip, name in sketch.frame_tips:
        place_label(
            ground, name, tip, tip, dot + tip, fontsize=TICK + 2, color=INK, style="italic",
            gid=f"label:frame:{name}",
        )  # fmt: skip
    outlines = {shape.of: shape.points for shape in sketch.shapes if shape.part == "wheel"}
    for wheel in sketch.robot.wheels:
        at = sketch.stance.contact(wheel)
        place_label(
            ground, wheel.name, at, at, outlines[wheel.name], fontsize=TICK, color=INK,
            gid=f"label:{wheel.name}",
        )  # fmt: skip


def _add_legend(axes: Axes, sketch: Sketch) -> None:
    present = [look_of(wheel) for wheel in sketch.robot.wheels]
    handles: list[Patch | Line2D] = [
        Patch(facecolor=look.face, edgecolor=look.edge, label=look.words)
        for look in LOOKS
        if look in present
    ]
    if any(isinstance(wheel, SwedishWheel) for wheel in sketch.robot.wheels):
        handles.append(_line(_ROLLERS_BELOW, DRIVEN.face, marker="d", linestyle=""))
    if sketch.arrowed:
        handles.append(_line("drives this way at positive speed", INK, marker=">", linestyle="-"))
    if sketch.pushing:
        kinds = {isinstance(wheel, SwedishWheel) for wheel in sketch.pushing}
        along = ", ".join("roller's axis" if swedish else "drive direction" for swedish in kinds)
        handles.append(_line(f"force line: can push along it\n({along})", INK, linestyle="--"))
    if sketch.centre.point is None and sketch.held:
        handles.append(
            _line(
                "zero line: cannot slip sideways,\nso the centre lies on it", MUTED, linestyle=":"
            )
        )
    if sketch.centre.point is not None:
        handles.append(_line(_centre_words(sketch), PURPLE, marker="o", linestyle="-"))
    legend = axes.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(1.02, 1.01), borderaxespad=0.0,
        frameon=False, fontsize=SMALL, labelcolor=INK, labelspacing=0.9, handlelength=1.9,
    )  # fmt: skip
    legend.set_gid("legend")


def _centre_words(sketch: Sketch) -> str:
    place, _, fault = sketch.centre.words.partition("; ")
    outside = "" if sketch.centre_in_view is not None else " (outside the picture)"
    lines = [place.replace("centre at", "centre\nat") + outside, *textwrap.wrap(fault, 34)]
    return "\n".join(lines)


def _line(label: str, colour: str, marker: str = "", linestyle: LineStyle = "-") -> Line2D:
    return Line2D(
        [], [], color=colour, linewidth=1.4, marker=marker, markersize=7, linestyle=linestyle,
        label=label,
    )  # fmt: skip
