"""The table of numbers below a comparison of runs, which is its legend too."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from trundle.view.outcome import Outcome
from trundle.view.panels import ROUNDING, short
from trundle.view.style import FAINT, INK, MUTED, SERIES, SMALL, TICK

LETTERS = 24  # of a run's name
_ROW, _HEAD = 0.29, 0.52  # heights [inch]
# Lines that lie on each other are told apart by their widths [pt].
_WIDEST, _NARROWEST = 3.4, 1.5
# What stands in each column, and where it ends, in the width of the figure.
_COLUMNS = (
    ("largest\ndistance [m]", 0.345),
    ("rms\ndistance [m]", 0.465),
    ("largest heading\nerror [rad]", 0.605),
    ("rms heading\nerror [rad]", 0.735),
    ("rms torque\n[N m]", 0.86),
    ("work\n[J]", 0.972),
)


def table_height(count: int) -> float:
    """Return the height of a table of so many runs, with its head [inch]."""
    return _HEAD + 0.1 + _ROW * count


def line_widths(count: int) -> list[float]:
    """Return the widths [pt] of the lines of so many runs, the first the widest."""
    return [float(each) for each in np.linspace(_WIDEST, _NARROWEST, count)]


def write_table(figure: Figure, outcomes: Mapping[str, Outcome]) -> None:
    """Write the table at the bottom of a sheet; its lines are the legend of the sheet."""
    width, height = (float(each) for each in figure.get_size_inches())
    left, widths = 0.35 / width, line_widths(len(outcomes))
    top = (table_height(len(outcomes)) - _HEAD) / height
    for words, x in _COLUMNS:
        figure.text(
            x, top + 0.06 / height, words, fontsize=SMALL - 0.5, color=MUTED, ha="right",
            va="bottom", linespacing=1.15,
        )  # fmt: skip
    figure.add_artist(Line2D([left, 0.974], [top, top], color=FAINT, linewidth=0.8))
    for k, (name, each) in enumerate(outcomes.items()):
        y = top - (k + 0.55) * _ROW / height
        figure.add_artist(
            Line2D(
                [left, left + 0.03], [y, y], color=SERIES[k],
                linewidth=widths[k] + 0.6,
            )
        )  # fmt: skip
        figure.text(
            left + 0.04, y, short(name, LETTERS), fontsize=TICK, color=INK, va="center",
            gid=f"name:{name}", parse_math=False,
        )  # fmt: skip
        for (_, x), value in zip(_COLUMNS, _cells(each), strict=True):
            figure.text(x, y, value, fontsize=TICK, color=INK, ha="right", va="center",
                        gid=f"number:{name}")  # fmt: skip


def _cells(each: Outcome) -> list[str]:
    values = (
        each.largest, each.rms, each.largest_turn, each.rms_turn, each.rms_torque, each.work,
    )  # fmt: skip
    return [_number(value) for value in values]


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}".replace("-", "−") if abs(value) >= ROUNDING else "0"
