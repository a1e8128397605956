"""The picture of a pose over time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.style import BLUE, GREEN, ORANGE, new_figure, put_title, style_axes

_LABELS = ("x [m]", "y [m]", "ψ [rad]")
_COLOURS = (BLUE, GREEN, ORANGE)
# A coordinate that moves less than this share of the others rests: its rounding is not shown.
_RESTS = 0.02
_ROUNDING = 1e-6  # a robot that moves less turns on the spot [m]
_LEAST_TURN, _LEAST_WAY = 0.05, 0.1  # the least extent of an axis [rad], [m]


def plot_eta(run: Run) -> Figure:
    """Return the picture of the pose eta = (x, y, psi) over time, one below the other.

    Args:
        run: the run; psi is drawn as it is, not wrapped.

    Returns:
        The figure; ``save`` writes it.

    >>> from trundle import load, simulate
    >>> run = simulate(load("omni3"), wheel_speeds=[0.5, 0.5, 0.5], duration=2.0)
    >>> [axes.get_ylabel() for axes in plot_eta(run).axes]
    ['x [m]', 'y [m]', 'ψ [rad]']
    """
    figure = new_figure(9.0, 6.4)
    x, y, psi = (round(float(each), 3) + 0.0 for each in run.pose[-1])
    put_title(
        figure,
        "Pose η = (x, y, ψ) over time",
        [f"after {run.t[-1] - run.t[0]:g} s at ({x:.3f} m, {y:.3f} m, {psi:.3f} rad)"],
    )
    panels: list[Axes] = []
    for k, label in enumerate(_LABELS):
        axes = figure.add_axes(
            (0.115, 0.645 - 0.265 * k, 0.855, 0.205), sharex=panels[0] if panels else None
        )
        style_axes(axes, "t [s]" if k == 2 else "", label)
        axes.plot(run.t, run.pose[:, k], color=_COLOURS[k], linewidth=2.2, gid=label)
        axes.tick_params(labelbottom=k == 2)
        axes.set_ylim(*_limits(run.pose, k))
        axes.yaxis.set_label_coords(-0.085, 0.5)
        panels.append(axes)
    panels[0].set_xlim(run.t[0], run.t[-1])
    return figure


def _limits(pose: Array, k: int) -> tuple[float, float]:
    span = np.ptp(pose, axis=0)
    moved = float(span[:2].max())
    least = _LEAST_TURN if k == 2 else _RESTS * moved if moved > _ROUNDING else _LEAST_WAY
    middle = (float(pose[:, k].max()) + float(pose[:, k].min())) / 2
    half = 0.56 * max(float(span[k]), least)
    return middle - half, middle + half
