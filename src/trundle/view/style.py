"""One look for all pictures: colours that the colour-blind can tell apart, and slide-size text."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from trundle.se2 import Array

# Okabe and Ito, Color Universal Design, 2008.
BLUE, ORANGE, GREEN, PURPLE, SKY = "#0072B2", "#D55E00", "#009E73", "#AA4499", "#56B4E9"
INK, MUTED, FAINT, GRID = "#222222", "#666666", "#A8ADB3", "#E8EAED"
BODY_FACE, BODY_EDGE = "#F4F5F7", "#8A9097"
SERIES = (BLUE, ORANGE, GREEN, PURPLE, SKY, "#E69F00", INK, FAINT)  # several lines in one picture
DASHES = (5.5, 2.0, 1.2, 2.0)  # of what is desired, in every picture

TITLE, LABEL, TICK, SMALL = 16.0, 13.0, 11.5, 11.0
DPI = 100
_LETTER = 0.52  # mean width of a letter over the size of the font


def new_figure(width: float, height: float) -> Figure:
    """Return an empty white figure [inch] on the Agg canvas; pyplot never hears of it."""
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def style_axes(axes: Axes, x: str, y: str, *, grid: bool = True) -> Axes:
    """Label axes and give them thin frames and a faint grid."""
    axes.set_xlabel(x, fontsize=LABEL, color=INK)
    axes.set_ylabel(y, fontsize=LABEL, color=INK)
    axes.tick_params(labelsize=TICK, color=FAINT, labelcolor=INK)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(FAINT)
    if grid:
        axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    return axes


def put_title(figure: Figure, title: str, notes: Sequence[str] = ()) -> None:
    """Write a figure's title, and below it notes in small grey letters, both flush left."""
    width, height = figure.get_size_inches()
    left = 0.35 / width
    size = min(TITLE, 72 * (width - 0.7) / (1.25 * _LETTER * max(len(title), 1)))
    figure.text(
        left, 1 - 0.22 / height, title, fontsize=size, color=INK, weight="bold", va="top",
        gid="title", parse_math=False,
    )  # fmt: skip
    lines = [""]
    for note in notes:
        longer = f"{lines[-1]}  ·  {note}" if lines[-1] else note
        if len(longer) * _LETTER * SMALL / 72 > width - 0.7 and lines[-1]:
            lines.append(note)
        else:
            lines[-1] = longer
    figure.text(
        left, 1 - 0.56 / height, "\n".join(lines), fontsize=SMALL, color=MUTED, va="top",
        linespacing=1.35, gid="note", parse_math=False,
    )  # fmt: skip


def put_remark(axes: Axes, text: str) -> Text:
    """Write a remark in the middle of axes that have nothing else to show."""
    return axes.text(
        0.5, 0.5, text, fontsize=LABEL, color=MUTED, ha="center", va="center",
        transform=axes.transAxes, gid="remark",
    )  # fmt: skip


def fade(colour: str, amount: float) -> str:
    """Return a colour mixed with white; 0 leaves it and 1 is white.

    Mixing, and not transparency, keeps a faded wheel opaque on its faded body.

    >>> fade("#000000", 0.5)
    '#808080'
    """
    mixed = [channel + (1 - channel) * amount for channel in to_rgb(colour)]
    return to_hex((mixed[0], mixed[1], mixed[2]))


def fit(axes: Axes, low: Array, high: Array, margin: float = 0.06) -> None:
    """Set limits that hold a box [m], at equal scale, and fill the axes."""
    box = axes.get_position()
    figure = axes.get_figure(root=True)
    width_in, height_in = figure.get_size_inches() if figure else (1.0, 1.0)
    wide, tall = box.width * width_in, box.height * height_in
    middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    span = [max(b - a, 1e-9) * (1 + 2 * margin) for a, b in zip(low, high, strict=True)]
    scale = max(span[0] / wide, span[1] / tall)
    axes.set_xlim(middle[0] - scale * wide / 2, middle[0] + scale * wide / 2)
    axes.set_ylim(middle[1] - scale * tall / 2, middle[1] + scale * tall / 2)
    axes.set_aspect("equal", adjustable="box")
