"""The picture of what a trajectory demands of a robot, against the robot's limits."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from trundle.errors import TrundleError
from trundle.limits import KEPT, Demand, Feasibility
from trundle.se2 import Array
from trundle.view.panels import beside, draw, head, hold, short, stack
from trundle.view.style import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    SERIES,
    SMALL,
    fade,
    new_figure,
    put_remark,
    put_title,
)
from trundle.view.thin import thin

_WIDTH = 12.2  # [inch]
_OVER = fade(ORANGE, 0.7)
_STEEP = 6.0  # a share above this many limits is drawn on a logarithmic axis
_LEAST = 0.01  # where that axis begins
_UNTOUCHED = 1e-6  # what needs less of the time there is does not depend on the pace


def plot_feasibility(feasibility: Feasibility) -> Figure:
    """Return the picture of each quantity's largest share of its limit over time.

    Of every quantity the wheel that is nearest to its limit counts; what lies above 100 % is
    shaded. Beside it stand the factors by which time must be stretched. A second panel shows how
    the trajectory moves and the wheels cannot, where they cannot.

    Args:
        feasibility: from ``trundle.limits.feasibility``.

    Returns:
        The figure; ``save`` writes it.

    Raises:
        TrundleError: this is something else.

    >>> import trundle
    >>> slow = trundle.load("omni3").with_wheels(max_speed=1.0)
    >>> circle = trundle.motion.circle(radius=1.0, rate=0.4, heading=0.0)
    >>> found = trundle.limits.feasibility(slow, circle)
    >>> figure = plot_feasibility(found)
    >>> figure.axes[0].get_legend().get_texts()[0].get_text().splitlines()[::2]
    ['wheel speed', 'stretch time by 2']
    """
    if not isinstance(feasibility, Feasibility):
        raise TrundleError(
            "plot_feasibility draws what trundle.limits.feasibility(robot, trajectory) returns, "
            f"got {feasibility!r}"
        )
    shares = [1.6] if feasibility.follows else [1.6, 1.0]
    height = 5.6 if feasibility.follows else 7.4
    figure = new_figure(_WIDTH, height)
    put_title(figure, _title(feasibility), _notes(feasibility))
    panels = stack(figure, (0.075, 0.68 / height, 0.635, 1 - 2.0 / height), shares)
    panels[0].set_xlim(feasibility.t[0], feasibility.t[-1])
    if feasibility.demands:
        _draw_demands(panels[0], feasibility)
    else:
        panels[0].set_yticks([])
        put_remark(panels[0], "the robot's description has no limits")
    if not feasibility.follows:
        _draw_miss(panels[1], feasibility)
    return figure


def _title(found: Feasibility) -> str:
    if not found.follows:
        return "Not feasible: the wheels cannot move as the trajectory does"
    if found.tips:
        return "Not feasible: the body tips over"
    if found.stretch > KEPT:
        if not np.isfinite(found.stretch):
            return "Not feasible at any pace"
        return f"Not feasible: stretch time by {found.stretch:.4g}"
    if len(found.swings):
        return "Not feasible: steered wheels must turn at a standstill that takes no time"
    if found.stretch < _UNTOUCHED:
        return "Feasible: no limit is touched"
    return f"Feasible, and up to {1 / found.stretch:.4g} times faster"


def _notes(found: Feasibility) -> list[str]:
    notes = [f"{found.t[-1] - found.t[0]:.4g} s", "of each quantity, the wheel nearest its limit"]
    if not found.follows and np.isfinite(found.stretch) and found.stretch > KEPT:
        notes.append(f"for the limits, stretch time by {found.stretch:.4g}")
    return notes


def _draw_demands(axes: Axes, found: Feasibility) -> None:
    t, top = found.t, 1.0
    for k, demand in enumerate(found.demands):
        share = np.fmax.reduce(demand.share, axis=1)
        finite = share[np.isfinite(share)]
        top = max(top, float(finite.max(initial=0.0)))
        kept = thin(share)
        axes.fill_between(
            t[kept], 1.0, share[kept], where=share[kept] > 1, interpolate=True, color=_OVER,
            linewidth=0, zorder=1, gid=f"over:{demand.name}",
        )  # fmt: skip
        draw(
            axes, t, share, color=SERIES[k % len(SERIES)], linewidth=2.0,
            label=_words(t, demand, share), gid=f"share:{demand.name}", zorder=2.5,
        )  # fmt: skip
    axes.axhline(1.0, color=INK, linewidth=1.4, linestyle=(0, (5, 2.5)), gid="limit", zorder=2)
    if top > _STEEP:
        axes.set_yscale("log")
        axes.set_ylim(_LEAST, 1.5 * top)
        axes.yaxis.set_major_locator(LogLocator(numticks=6))
        axes.yaxis.set_minor_locator(NullLocator())
    else:
        axes.set_ylim(0.0, 1.12 * top)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    head(axes, "share of the limit that is used, dashed: the limit")
    legend = axes.legend(
        loc="upper left", bbox_to_anchor=(1.015, 1.03), borderaxespad=0.0, frameon=False,
        fontsize=SMALL - 0.5, labelcolor=INK, labelspacing=0.7, handlelength=1.6,
    )  # fmt: skip
    legend.set_gid("legend")
    for text in legend.get_texts():
        text.set_parse_math(False)


def _words(t: Array, demand: Demand, share: Array) -> str:
    when = int(np.argmax(share))  # a share that is not a number comes first
    wheel = int(np.argmax(demand.share[when]))
    if demand.stretch > KEPT:
        finite = np.isfinite(demand.stretch)
        remedy = f"stretch time by {demand.stretch:.4g}" if finite else "too much at any pace"
    elif demand.stretch > _UNTOUCHED:
        remedy = f"up to {1 / demand.stretch:.4g} times faster"
    else:
        remedy = "kept at any pace"
    where = f"({short(demand.wheels[wheel])}, t = {t[when]:.3g} s)"
    return f"{demand.name}\n{_percent(share[when])} {where}\n{remedy}"


def _percent(share: float) -> str:
    if not np.isfinite(share):
        return "without end"
    if share < _UNTOUCHED:
        return "0 %"
    return f"{100 * share:.0f} %" if share >= 1 else f"{100 * share:.3g} %"


def _draw_miss(axes: Axes, found: Feasibility) -> None:
    for k, (label, colour, width) in enumerate(
        (
            ("forward [m/s]", BLUE, 2.6),
            ("sideways [m/s]", GREEN, 2.0),
            ("turning [rad/s]", ORANGE, 1.5),
        )
    ):
        draw(
            axes, found.t, found.miss[:, k], color=colour, linewidth=width, label=label,
            gid=f"miss:{label.split()[0]}",
        )  # fmt: skip
    letter = hold(axes, [found.miss], "")
    for handle in axes.get_lines():
        handle.set_label(str(handle.get_label()).replace("[", f"[{letter}"))
    head(axes, "motion that the wheels cannot follow, at any pace")
    beside(axes)
