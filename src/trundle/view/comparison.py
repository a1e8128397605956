"""The sheet that compares runs along one trajectory: paths, errors, torques, numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from trundle.errors import TrundleError
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.along import box_of, draw_desired, draw_ends, draw_path, steps_in_view
from trundle.view.motion import check_same
from trundle.view.outcome import Outcome, errors_of, outcome_of
from trundle.view.panels import (
    ROUNDING,
    draw,
    head,
    hold,
    put_word,
    short,
    stack,
    told,
    without_peak,
)
from trundle.view.style import SERIES, fit, new_figure, put_title, style_axes
from trundle.view.table import LETTERS, line_widths, table_height, write_table

_WIDTH = 13.2  # [inch]
_ABOVE = 6.1  # height of path and panels [inch]
_MOST = len(SERIES)
# Runs sampled at other times cut the corners of one path otherwise, by less than this share.
_SAME = 0.02
_APART = 10.0  # errors whose sizes differ more are drawn on a logarithmic axis
# A logarithmic axis begins below the least median, and ends above the largest value.
_BELOW, _ABOVE_ALL = 0.2, 2.0


def plot_comparison(robot: Robot, runs: Mapping[str, Run]) -> Figure:
    """Return the sheet that compares runs of one robot along one trajectory.

    The paths from above; over time the distance from the trajectory, the heading's error and the
    largest torque of any wheel; and a table of their largest values and root mean squares. Errors
    of very different sizes are drawn on a logarithmic axis.

    Args:
        robot: the robot of the runs.
        runs: two to eight runs of ``trundle.track``, by the name that the sheet gives them.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        TrundleError: too few runs or too many, one of another robot or without a trajectory, or
            runs along different trajectories.

    >>> import trundle
    >>> robot, circle = trundle.load("omni3"), trundle.motion.circle(radius=3.0, rate=0.1)
    >>> laws = {
    ...     "PD": trundle.control.PD(kp=[120, 120, 20], kd=[120, 120, 20]),
    ...     "computed torque": trundle.control.ComputedTorque(kp=[4] * 3, kd=[4] * 3),
    ... }
    >>> runs = {
    ...     name: trundle.track(robot, circle, law, duration=5.0, dt=0.1, method="lecture")
    ...     for name, law in laws.items()
    ... }
    >>> plot_comparison(robot, runs).axes[1].get_yscale()
    'log'
    """
    _check(robot, runs)
    runs = {str(name): run for name, run in runs.items()}
    outcomes = {name: outcome_of(run) for name, run in runs.items()}
    seen = {name: steps_in_view(robot, run) for name, run in runs.items()}
    table = table_height(len(runs))
    height = _ABOVE + table
    figure = new_figure(_WIDTH, height)
    put_title(figure, _title(robot, outcomes), _notes(runs, seen))
    _draw_paths(figure, runs, seen, table + 0.7)
    torques = any(run.torques is not None for run in runs.values())
    panels = stack(
        figure,
        (0.555, (table + 0.7) / height, 0.425, (_ABOVE - 1.85) / height),
        [1.2, 1.0, 1.0] if torques else [1.0, 1.0],
    )
    panels[0].set_xlim(_time_shown(runs, seen))
    _draw_errors(panels, runs, seen)
    if torques:
        _draw_torques(panels[2], runs, seen)
    write_table(figure, outcomes)
    return figure


def _check(robot: Robot, runs: Mapping[str, Run]) -> None:
    if not isinstance(runs, Mapping):
        kind = type(runs).__name__
        raise TrundleError(f"runs must be a dictionary from names to runs, got a {kind}")
    if not 2 <= len(runs) <= _MOST:
        raise TrundleError(f"runs must be 2 to {_MOST} to be compared, got {len(runs)}")
    for name, run in runs.items():
        errors_of(run, f"run {name!r}")
        check_same(robot, run)
    first, *others = runs.items()
    for other in others:
        _check_same_path(first, other)


def _check_same_path(first: tuple[str, Run], second: tuple[str, Run]) -> None:
    """Refuse runs along different paths; over time, as long as both last."""
    (name, run), (other, against) = first, second
    (desired, _, _), (path, _, _) = errors_of(run, name), errors_of(against, other)
    t = run.t[(run.t >= against.t[0]) & (run.t <= against.t[-1])]
    size = float(np.ptp(np.vstack([desired, path])[:, :2], axis=0).max())
    for k in range(2):
        apart = np.interp(t, run.t, desired[:, k]) - np.interp(t, against.t, path[:, k])
        if np.abs(apart).max(initial=0.0) > _SAME * size + ROUNDING:
            raise TrundleError(
                f"runs {name!r} and {other!r} were to follow different trajectories: they are up "
                f"to {np.abs(apart).max():.3g} m apart"
            )


def _title(robot: Robot, outcomes: Mapping[str, Outcome]) -> str:
    best, *_, worst = sorted(outcomes.items(), key=lambda item: item[1].largest)
    words = [f"{told(each.largest)} m ({short(name, LETTERS)})" for name, each in (best, worst)]
    return f"{robot.name}: largest error from {words[0]} to {words[1]}"


def _notes(runs: Mapping[str, Run], seen: Mapping[str, int]) -> list[str]:
    longest = max(float(run.t[-1] - run.t[0]) for run in runs.values())
    notes = [f"{longest:.4g} s along the same trajectory"]
    for name, run in runs.items():
        if seen[name] < len(run.t):
            notes.append(f"{name}: lost at t = {run.t[seen[name]]:.4g} s")
        elif run.t[-1] - run.t[0] < longest:
            notes.append(f"{name}: ends at t = {run.t[-1]:.4g} s")
        if run.force is not None and run.saturated is not None and run.saturated.any():
            share = 100 * run.saturated.any(axis=1).mean()
            notes.append(f"{name}: motors at their limits {share:.3g} % of the time")
    return notes


def _time_shown(runs: Mapping[str, Run], seen: Mapping[str, int]) -> tuple[float, float]:
    ends = [run.t[min(seen[name], len(run.t) - 1)] for name, run in runs.items()]
    return min(float(run.t[0]) for run in runs.values()), float(max(ends))


def _draw_paths(
    figure: Figure, runs: Mapping[str, Run], seen: Mapping[str, int], bottom: float
) -> None:
    height = float(figure.get_size_inches()[1])
    axes = figure.add_axes((0.062, bottom / height, 0.42, 1 - (bottom + 1.15) / height))
    style_axes(axes, "x [m]", "y [m]")
    longest = max(runs.values(), key=lambda run: len(run.t) and run.t[-1])
    desired, _, _ = errors_of(longest, "run")
    paths = [run.pose[: seen[name], :2] for name, run in runs.items()]
    fit(axes, *box_of([desired[:, :2], *paths]))
    axes.autoscale(False)
    for (name, run), colour, width in zip(
        runs.items(), SERIES, line_widths(len(runs)), strict=False
    ):
        draw_path(axes, run.pose[: seen[name] + 1], colour, width, name, f"path:{name}")
    draw_desired(axes, desired)
    draw_ends(axes, longest, end=False)


def _draw_errors(panels: list[Axes], runs: Mapping[str, Run], seen: Mapping[str, int]) -> None:
    distance = {name: errors_of(run, name)[2] for name, run in runs.items()}
    turn = {name: np.abs(errors_of(run, name)[1][:, 2]) for name, run in runs.items()}
    for axes, values, what, unit in (
        (panels[0], distance, "distance from the trajectory", "m"),
        (panels[1], turn, "heading error, its magnitude", "rad"),
    ):
        _draw_lines(axes, runs, values, what)
        shown = [each[: seen[name]] for name, each in values.items()]
        if (limits := _log_limits(shown)) is not None:
            axes.set_yscale("log")
            axes.set_ylim(*limits)
            axes.yaxis.set_major_locator(LogLocator(numticks=6))
            axes.yaxis.set_minor_locator(NullLocator())
            head(axes, f"{what} [{unit}]")
        else:
            head(axes, f"{what} [{hold(axes, shown, unit)}]")


def _log_limits(values: list[Array]) -> tuple[float, float] | None:
    """Return the limits of a logarithmic axis, or None where a linear one shows all values.

    Values that are rounding throughout lie at zero on either.
    """
    values = [each for each in values if each.max(initial=0.0) > ROUNDING]
    for size in (np.median, _rms):
        sizes = [max(float(size(each)), ROUNDING) for each in values]
        if len(sizes) > 1 and max(sizes) > _APART * min(sizes):
            middle = min(float(np.median(each)) for each in values)
            largest = max(float(each.max()) for each in values)
            return _BELOW * max(middle, ROUNDING), _ABOVE_ALL * largest
    return None


def _rms(values: Array) -> float:
    return float(np.sqrt(np.square(values).mean()))


def _draw_torques(axes: Axes, runs: Mapping[str, Run], seen: Mapping[str, int]) -> None:
    largest = {
        name: np.abs(run.torques).max(axis=1, initial=0.0)
        for name, run in runs.items()
        if run.torques is not None
    }
    _draw_lines(axes, runs, largest, "torque")
    rest, peaks = [], []
    for name, values in largest.items():
        held, peak = without_peak(runs[name].t, values[: seen[name], None])
        rest.append(held)
        if peak:
            peaks.append(f"{short(name, LETTERS)}: {peak.replace(' at t', ' N m at t')}")
    head(axes, f"largest torque of any wheel [{hold(axes, rest, 'N m')}]")
    if peaks:
        put_word(axes, "\n".join(peaks))


def _draw_lines(
    axes: Axes, runs: Mapping[str, Run], values: Mapping[str, Array], what: str
) -> None:
    for (name, run), colour, width in zip(
        runs.items(), SERIES, line_widths(len(runs)), strict=False
    ):
        if name in values:
            draw(
                axes, run.t[: len(values[name])], values[name], color=colour, linewidth=width,
                gid=f"{what.split()[0]}:{name}",
            )  # fmt: skip
