"""Panels of what a run took: torques, wheel speeds or steering angles with limits, and energy."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from trundle.dynamics import Dynamics
from trundle.robot import Robot, missing_masses
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.panels import beside, draw, head, hold, put_word, without_peak
from trundle.view.style import BLUE, INK, ORANGE, SERIES
from trundle.view.thin import stretches

# Bars that mark when wheels are at a limit: of one at most, and all together, in panel heights.
_BAR, _BARS = 0.055, 0.25
# A limit farther from the values than this many times their largest would flatten them.
_FAR = 3.0
_WIDEST, _NARROWEST = 2.8, 1.4  # lines that lie on each other are told apart by their widths [pt]


def draw_torques(axes: Axes, robot: Robot, run: Run, seen: int) -> None:
    """Draw the wheels' torques over time, their limits, and where the motors were at them."""
    assert run.torques is not None
    low, high = _torque_limits(robot, run)
    marked = run.saturated if run.force is not None else None
    _draw_wheels(
        axes, run, run.torques, run.driven, (low, high), marked, seen, "wheel torques", "N m"
    )


def draw_speeds(axes: Axes, robot: Robot, run: Run, seen: int) -> None:
    """Draw the wheels' speeds over time, their limits, and where the motion was cut to them."""
    most = np.array([np.inf if w.max_speed is None else w.max_speed for w in robot.driven])
    limits = np.broadcast_to(most, run.wheel_speeds.shape)
    _draw_wheels(
        axes, run, run.wheel_speeds, run.driven, (-limits, limits), run.saturated, seen,
        "wheel speeds", "rad/s",
    )  # fmt: skip


def draw_steering(axes: Axes, robot: Robot, run: Run, seen: int) -> None:
    """Draw the steering angles over time, their limits, and where the motion was cut."""
    ranges = np.array([wheel.steering_range for wheel in robot.steered], dtype=np.float64)
    low, high = (np.broadcast_to(each, run.steering.shape) for each in ranges.T)
    marked = run.saturated[:, :1] if run.saturated is not None and run.saturated.size else None
    _draw_wheels(
        axes, run, run.steering, run.steered, (low, high), marked, seen, "steering angles", "rad"
    )


def draw_energy(axes: Axes, run: Run, seen: int) -> None:
    """Draw kinetic energy and the motors' work over time."""
    lines = (
        (run.energy, "kinetic energy", BLUE, 2.4),
        (run.work, "motors' work", ORANGE, 1.7),
    )
    held = []
    for values, label, colour, width in lines:
        if values is None:
            continue
        gid = label.split()[-1]
        draw(axes, run.t, values, color=colour, linewidth=width, label=label, gid=gid)
        held.append(values[:seen])
    unit = hold(axes, held, "J")
    head(axes, f"energy [{unit}]")
    beside(axes)


def _torque_limits(robot: Robot, run: Run) -> tuple[Array, Array]:
    """Return the least and the largest torque (T, n) that the motors can give at their speeds."""
    if missing_masses(robot):
        given = np.array([wheel.max_torque or np.inf for wheel in robot.driven])
        most = np.broadcast_to(given, run.wheel_speeds.shape)
        return -most, most
    without = np.full(run.wheel_speeds.shape, np.inf)
    limits = Dynamics(robot).torque_limits
    low, high = limits.held(-without, run.wheel_speeds), limits.held(without, run.wheel_speeds)
    return low, high


def _draw_wheels(
    axes: Axes,
    run: Run,
    values: Array,
    names: tuple[str, ...],
    limits: tuple[Array, Array],
    marked: Array | None,
    seen: int,
    what: str,
    unit: str,
) -> None:
    """Draw a quantity (T, n) of n wheels, between limits, and where it was at them (T, n)."""
    t = run.t[:-1]
    below = 0.0 if marked is None else _draw_bars(axes, run.t, marked, names)
    for i, name in enumerate(names):
        width = np.linspace(_WIDEST, _NARROWEST, len(names))[i] if len(names) > 1 else 2.0
        draw(
            axes, t, values[:, i], color=SERIES[i % len(SERIES)], linewidth=width, label=name,
            gid=f"{what}:{name}", zorder=2 + 0.01 * i,
        )  # fmt: skip
    rest, peak = without_peak(t[:seen], values[:seen])
    near = [
        *_near(limits[1][:seen], float(rest.max(initial=0.0))),
        *_near(limits[0][:seen], float(rest.min(initial=0.0))),
    ]
    same = all((each == each[:, :1]).all() for each in limits)
    for i, limit in near:
        if i == 0 or not same:
            draw(
                axes, t[:seen], limit, color=INK if same else SERIES[i % len(SERIES)],
                linewidth=1.0, linestyle=(0, (4, 2.5)), zorder=1.8, gid=f"limit:{names[i]}",
            )  # fmt: skip
    shown = hold(axes, [rest, *(limit for _, limit in near)], unit, below)
    words = [
        f"{what} [{shown}]",
        "dashed: limits" if near else "",
        "bars: at a limit" if below else "",
    ]
    head(axes, ", ".join(each for each in words if each))
    if peak:
        put_word(axes, peak.replace(" at t", f" {unit} at t"))
    beside(axes)


def _draw_bars(axes: Axes, t: Array, marked: Array, names: tuple[str, ...]) -> float:
    """Mark by bars at the bottom when each wheel was at a limit; return the height they take."""
    if not marked.any():
        return 0.0
    together = marked.shape[1] != len(names) or bool((marked == marked[:, :1]).all())
    rows = marked[:, :1] if together else marked
    count = rows.shape[1]
    pitch = min(_BAR, _BARS / count)
    for i, row in enumerate(rows.T):
        low = pitch * (count - 0.75 - i)
        axes.broken_barh(
            stretches(t, row), (low, 0.75 * pitch), linewidth=0,
            facecolor=INK if together else SERIES[i % len(SERIES)], zorder=3,
            transform=axes.get_xaxis_transform(), gid=f"saturated:{'' if together else names[i]}",
        )  # fmt: skip
    return float(pitch * (count + 0.5))


def _near(limits: Array, extreme: float) -> list[tuple[int, Array]]:
    """Return the limits (T,) of the wheels that values come near, each with the wheel's number."""
    return [
        (i, limit)
        for i, limit in enumerate(limits.T)
        if np.abs(limit).min(initial=np.inf) <= _FAR * abs(extreme)
    ]
