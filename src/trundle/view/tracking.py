"""The sheet of one run in closed loop: path, errors, what the wheels did, energy."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.along import (
    Along,
    box_of,
    draw_desired,
    draw_ends,
    draw_path,
    draw_robots,
    robots_along,
    steps_in_view,
)
from trundle.view.efforts import draw_energy, draw_speeds, draw_steering, draw_torques
from trundle.view.motion import check_same
from trundle.view.outcome import errors_of, outcome_of
from trundle.view.panels import beside, draw, head, hold, stack, told
from trundle.view.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    SMALL,
    fit,
    new_figure,
    put_title,
    style_axes,
)

_WIDTH = 13.2  # [inch]
_PANEL = 1.42  # of height for each panel [inch]
_LETTERS = 68  # of a report's lines, as wide as the path's axes


def plot_tracking(robot: Robot, run: Run) -> Figure:
    """Return the sheet of a run in closed loop: its path, its errors, and what the wheels did.

    The path from above, with the robot at some poses; the errors, desired minus actual; the
    wheels' torques with their limits, shaded where a motor was at one; kinetic energy and the
    motors' work. Controllers that command twists leave wheel speeds or steering angles, and
    torques only where the robot's masses are known.

    Args:
        robot: the robot of the run.
        run: a run of ``trundle.track``.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        TrundleError: the run is of another robot, or has no trajectory.

    >>> import trundle
    >>> robot, circle = trundle.load("omni3"), trundle.motion.circle(radius=3.0, rate=0.1)
    >>> controller = trundle.control.PD(kp=[120, 120, 20], kd=[120, 120, 20])
    >>> run = trundle.track(robot, circle, controller, duration=5.0)
    >>> [axes.get_title("left") for axes in plot_tracking(robot, run).axes[2:]]
    ['heading error [rad]', 'wheel torques [N m]', 'energy [J]']
    """
    desired, _, _ = errors_of(run, "run")
    check_same(robot, run)
    seen = steps_in_view(robot, run)
    moved = [draw_steering if robot.steered else draw_speeds] if run.force is None else []
    shares = [1.0, 0.8, *(1.15 for _ in moved)]
    shares += [1.25 + 0.15 * max(len(run.driven) - 4, 0)] if run.torques is not None else []
    shares += [1.0] if run.energy is not None or run.work is not None else []
    height = max(1.6 + _PANEL * (sum(shares) + 0.3), 6.8)

    figure = new_figure(_WIDTH, height)
    along = robots_along(robot, run, np.vstack([run.pose[:seen], desired])[:, :2], seen)
    put_title(figure, _title(robot, run), _notes(run, along.scale, seen))
    _draw_above(figure, run, along, desired, seen)
    panels = stack(figure, (0.515, 0.62 / height, 0.35, 1 - 1.75 / height), shares)
    panels[0].set_xlim(run.t[0], run.t[min(seen, len(run.t) - 1)])
    _draw_errors(panels[0], panels[1], run, seen)
    rest = iter(panels[2:])
    for drawn in moved:
        drawn(next(rest), robot, run, seen)
    if run.torques is not None:
        draw_torques(next(rest), robot, run, seen)
    if run.energy is not None or run.work is not None:
        draw_energy(next(rest), run, seen)
    return figure


def _title(robot: Robot, run: Run) -> str:
    found = outcome_of(run)
    return (
        f"{robot.name} on its trajectory: largest error {told(found.largest)} m, "
        f"{told(found.largest_turn)} rad"
    )


def _notes(run: Run, scale: float, seen: int) -> list[str]:
    _, error, distance = errors_of(run, "run")
    found, steps = outcome_of(run), len(run.t) - 1
    notes = [
        f"{run.t[-1] - run.t[0]:.4g} s in {steps} step{'s' if steps > 1 else ''}",
        f"root mean square {told(found.rms)} m, {told(found.rms_turn)} rad",
        f"at the end {told(distance[-1])} m, {told(abs(error[-1, 2]))} rad",
    ]
    if run.torques is None:
        notes.append("no torques: the robot's masses are not known")
    if scale > 1:
        notes.append(f"the robot is drawn {scale:g} times its size")
    if seen < len(run.t):
        notes.append(f"shown up to t = {run.t[seen]:.4g} s, when the robot is lost")
    return notes


def _draw_above(figure: Figure, run: Run, along: Along, desired: Array, seen: int) -> None:
    """Draw the path from above on the left, and below it what went wrong."""
    height = float(figure.get_size_inches()[1])
    lines = [line for each in run.reports for line in textwrap.wrap(each, _LETTERS)]
    room = 0.62 + (0.25 + 0.195 * len(lines) if lines else 0.0)
    axes = figure.add_axes((0.062, room / height, 0.395, 1 - (room + 1.32) / height))
    style_axes(axes, "x [m]", "y [m]")
    every = np.vstack([run.pose[:seen, :2], desired[:, :2]])
    fit(axes, *box_of([every, along.points()]))
    axes.autoscale(False)
    draw_robots(axes, along)
    draw_desired(axes, desired)
    draw_path(axes, run.pose[: seen + 1], BLUE, 2.2, "path", "path")
    draw_ends(axes, run, end=seen == len(run.t))
    legend = axes.legend(
        loc="lower left", bbox_to_anchor=(-0.01, 1.0), borderaxespad=0.1, frameon=False, ncols=4,
        fontsize=SMALL, labelcolor=INK, handlelength=2.6, columnspacing=1.4,
    )  # fmt: skip
    legend.set_gid("legend")
    if lines:
        figure.text(
            0.35 / _WIDTH, 0.12 / height, "\n".join(lines), fontsize=SMALL, color=MUTED,
            va="bottom", linespacing=1.3, gid="reports", parse_math=False,
        )  # fmt: skip


def _draw_errors(position: Axes, heading: Axes, run: Run, seen: int) -> None:
    _, error, _ = errors_of(run, "run")
    for k, (axes, name, colour, width) in enumerate(
        ((position, "x", BLUE, 2.4), (position, "y", GREEN, 1.7), (heading, "ψ", ORANGE, 2.0))
    ):
        draw(
            axes, run.t, error[:, k], color=colour, linewidth=width, label=name,
            gid=f"error:{name}",
        )  # fmt: skip
    unit = hold(position, [error[:seen, :2]], "m")
    head(position, f"position error, desired minus actual [{unit}]")
    unit = hold(heading, [error[:seen, 2]], "rad")
    head(heading, f"heading error [{unit}]")
    beside(position)
    beside(heading)
