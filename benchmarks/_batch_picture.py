"""The picture of ``batches.py``: robot-steps a second of each candidate, on a scale of tens."""

from __future__ import annotations

import math
from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from trundle.view.style import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    ORANGE,
    SKY,
    SMALL,
    TICK,
    new_figure,
    put_title,
    style_axes,
)

# Candidates that are drawn, from the top of each group down.
COLOURS = {
    "trundle, float32": BLUE,
    "trundle, float64": SKY,
    "JAX, float32": GREEN,
    "JAX, float64": "#8FD3BC",
    "NumPy, float32": ORANGE,
    "NumPy, float64": "#F0B48C",
}
LEFT = 0.23  # of the picture's width, for the groups' names
GAP = 0.9  # between groups, in bars
BAR, EDGES = 0.25, 2.1  # heights of a bar, and of all around the bars [inch]

Rates = Mapping[str, Mapping[str, float]]


def bar_chart(rates: Rates, limits: Rates, note: str) -> Figure:
    """Return rates [M robot-steps/s] of each workload's candidates, limits as marks on them."""
    drawn = {title: [n for n in COLOURS if n in each] for title, each in rates.items()}
    rows = sum(map(len, drawn.values())) + GAP * (len(drawn) - 1)
    figure = new_figure(10.0, height := BAR * rows + EDGES)
    axes = figure.add_axes((LEFT, 0.62 / height, 0.76, BAR * rows / height))
    style_axes(axes, "million robot-steps per second", "")
    axes.grid(visible=False, axis="y")
    axes.set_xscale("log")
    at, ticks = 0.0, []
    for title, names in drawn.items():
        ticks.append(at + (len(names) - 1) / 2)
        for name in names:
            _put_bar(axes, at, name, rates[title][name], limits[title].get(name))
            at += 1
        at += GAP
    axes.set_ylim(rows - 0.4, -0.6)
    axes.set_yticks(ticks, [title.replace(", ", ",\n") for title in drawn])
    axes.tick_params(axis="y", length=0, labelsize=TICK)
    all_rates = [rates[title][name] for title, names in drawn.items() for name in names]
    all_rates += [limit for each in limits.values() for limit in each.values()]
    axes.set_xlim(10 ** math.floor(math.log10(min(all_rates) / 2)), max(all_rates) * 1.4)
    axes.xaxis.set_major_formatter("{x:g}")
    _put_legend(figure, axes, {name for names in drawn.values() for name in names})
    put_title(figure, "Many robots at once", [note])
    return figure


def _put_bar(axes: Axes, at: float, name: str, rate: float, limit: float | None) -> None:
    axes.barh(at, rate, height=0.86, color=COLOURS[name])
    # Inside the bar, so that the limit's mark never meets it.
    light = name in ("JAX, float64", "NumPy, float64", "trundle, float64")
    axes.annotate(
        f"{rate:,.0f}", (rate, at), (-4, -0.5), textcoords="offset points", ha="right",
        va="center", fontsize=SMALL, color=INK if light else "white",
    )  # fmt: skip
    if limit is not None:
        axes.plot([rate, limit], [at, at], color=FAINT, linewidth=1.0)
        axes.plot([limit, limit], [at - 0.46, at + 0.46], color=INK, linewidth=2.5)


def _put_legend(figure: Figure, axes: Axes, names: set[str]) -> None:
    entries: list[Patch | Line2D] = [
        Patch(color=COLOURS[n], label=n) for n in COLOURS if n in names
    ]
    entries.append(Line2D([], [], color=INK, linewidth=2.5, label="the memory's limit"))
    top = axes.get_position().y1
    figure.legend(
        handles=entries, loc="lower left", bbox_to_anchor=(LEFT, top), ncols=4, frameon=False,
        fontsize=SMALL, handlelength=1.2, columnspacing=1.6, borderaxespad=0.2,
    )  # fmt: skip
