"""Panels over one axis of time, one below the other: what the sheets of runs are made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.ticker import FuncFormatter, MaxNLocator

from trundle.se2 import Array
from trundle.view.style import INK, LABEL, MUTED, SMALL, style_axes
from trundle.view.thin import thin

_GAP = 0.5  # between two panels, for the words above each [inch]
# From which value on, the factor and the letter of a unit that is easy to read.
_PREFIXES = (
    (1e7, 1e6, "M"), (1e4, 1e3, "k"), (0.1, 1.0, ""), (1e-4, 1e-3, "m"), (1e-7, 1e-6, "µ"),
    (1e-10, 1e-9, "n"), (0.0, 1e-12, "p"),
)  # fmt: skip
# Below a picometre, a picoradian and so on there is only rounding, which is drawn as zero.
ROUNDING = 1e-12
_MARGIN = 0.1
# A peak of so few steps that is so many times as high as all the rest would flatten the rest.
_BRIEF, _HIGH = 3, 5.0
_LONGEST = 13  # letters of a name in a legend


def stack(
    figure: Figure, box: tuple[float, float, float, float], shares: Sequence[float]
) -> list[Axes]:
    """Return panels that share their axis of time, the first on top.

    Args:
        figure: where they go.
        box: left, bottom, width and height of all of them, in shares of the figure.
        shares: how high each is, relative to the others.
    """
    left, bottom, width, height = box
    gap = _GAP / float(figure.get_size_inches()[1])
    unit = (height - gap * (len(shares) - 1)) / sum(shares)
    panels: list[Axes] = []
    top = bottom + height
    for share in shares:
        axes = figure.add_axes(
            (left, top - share * unit, width, share * unit), sharex=panels[0] if panels else None
        )
        style_axes(axes, "", "")
        axes.tick_params(labelbottom=False)
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
        panels.append(axes)
        top -= share * unit + gap
    panels[-1].tick_params(labelbottom=True)
    panels[-1].set_xlabel("t [s]", fontsize=LABEL, color=INK)
    return panels


def head(axes: Axes, words: str) -> None:
    """Write what a panel shows above it, flush left."""
    axes.set_title(words, loc="left", fontsize=SMALL + 1, color=INK, pad=5.0)


def draw(axes: Axes, t: Array, values: Array, **style: Any) -> None:
    """Draw a curve over time, thinned where it has more points than can be seen."""
    kept = thin(values)
    marker = "o" if len(kept) == 1 else ""  # a line through one point is not seen
    axes.plot(t[kept], values[kept], marker=marker, **style)


def hold(axes: Axes, values: Sequence[Array], unit: str, below: float = 0.0) -> str:
    """Set the limits of a panel so that it holds values and zero; return the unit of its ticks.

    Tiny values are counted in thousandths, millionths and so on of the unit.

    Args:
        axes: the panel.
        values: arrays of any shape.
        unit: what they are in.
        below: share of the panel that is kept free at the bottom.
    """
    low = min(0.0, *(float(each.min(initial=0.0)) for each in values))
    high = max(0.0, *(float(each.max(initial=0.0)) for each in values))
    largest = max(high, -low)
    if largest < ROUNDING:
        low, high, largest = -1.0, 1.0, 1.0
        axes.set_yticks([0.0])
    margin = _MARGIN * (high - low)
    low, high = low - margin, high + margin
    axes.set_ylim(low - below / (1 - below) * (high - low), high)
    factor, letter = prefix(largest)
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value / factor:g}".replace("-", "−"))
    )
    return letter + unit


def told(value: float) -> str:
    """Return a value in two digits, and rounding as zero.

    >>> told(3.4913e-5), told(1.8e-15)
    ('3.5e-05', '0')
    """
    return f"{value:.2g}" if abs(value) >= ROUNDING else "0"


def prefix(largest: float) -> tuple[float, str]:
    """Return the factor and the letter of the unit in which a value is easy to read.

    >>> prefix(0.3), prefix(3.5e-5)
    ((1.0, ''), (1e-06, 'µ'))
    """
    return next((factor, letter) for least, factor, letter in _PREFIXES if largest >= least)


def without_peak(t: Array, values: Array) -> tuple[Array, str]:
    """Return values (T, k) without a very brief and high peak, and a word on the peak.

    A start off the trajectory takes one step of a torque that no later one comes near.

    >>> values = np.ones((50, 1))
    >>> values[0] = 90.0
    >>> rest, words = without_peak(np.arange(50.0), values)
    >>> float(rest.max()), words
    (1.0, 'peak 90 at t = 0 s')
    """
    size = np.abs(values).max(axis=1, initial=0.0)
    if len(size) <= 10 * _BRIEF:
        return values, ""
    order = np.argsort(size)
    top, rest = float(size[order[-1]]), float(size[order[-1 - _BRIEF]])
    if not top > _HIGH * max(rest, ROUNDING):
        return values, ""
    return values[order[:-_BRIEF]], f"peak {top:.3g} at t = {t[order[-1]]:.3g} s"


def put_word(axes: Axes, words: str) -> None:
    """Write a small word into a panel's upper right corner."""
    axes.text(
        0.995, 0.955, words, fontsize=SMALL - 1, color=MUTED, ha="right", va="top",
        transform=axes.transAxes, gid="word", zorder=5, parse_math=False,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5, "alpha": 0.8},
    )  # fmt: skip


def beside(axes: Axes) -> Legend:
    """Put a panel's legend to its right."""
    # Wheels may have names that matplotlib would hide, or set as a formula.
    handles = [each for each in axes.get_lines() if "limit:" not in str(each.get_gid())]
    labels = [str(each.get_label()) for each in handles]
    many = len(handles) > 5
    legend = axes.legend(
        handles, [short(each) for each in labels], loc="upper left", bbox_to_anchor=(1.015, 1.06),
        borderaxespad=0.0, frameon=False, fontsize=SMALL - 2 if many else SMALL, labelcolor=INK,
        labelspacing=0.25 if many else 0.4, handlelength=1.6,
    )  # fmt: skip
    legend.set_gid("legend")
    for text in legend.get_texts():
        text.set_parse_math(False)
    return legend


def short(name: str, letters: int = _LONGEST) -> str:
    """Return a name cut to the letters that fit beside a panel.

    >>> short("front_left_drive_wheel")
    'front_left_dr…'
    """
    if len(name) <= letters + 1:
        return name
    return name[:letters] + "…"
