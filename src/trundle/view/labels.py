"""Where to write names in a picture, so that they cover neither each other nor what is drawn."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Text

from trundle.se2 import Array
from trundle.view.style import MUTED

_SPACING = 4.0  # between the points that stand for what is drawn [pixel]
_PADDING = 3.0  # kept free around a text [pixel]
_DIRECTIONS = 24
_RINGS = (3.0, 6.0, 12.0, 20.0, 32.0, 48.0, 70.0, 95.0, 125.0)  # from the thing named [pixel]
_LEADER = 9.0  # from here on a line ties the name to the thing [pixel]
# What it costs to cover one point: of a wheel or text; of an arrow or mark; of a thin line.
SOLID, MARK, LINE = 1000.0, 300.0, 6.0
_OUTSIDE = 1e5


@dataclass
class Ground:
    """What is drawn so far in some axes, as weighted points in pixels."""

    axes: Axes
    points: list[Array] = field(default_factory=list)
    weights: list[Array] = field(default_factory=list)

    def add_polygon(self, points: Array, weight: float) -> None:
        """Remember a filled convex polygon (k, 2) in data coordinates."""
        self._add(_inside(self.axes.transData.transform(points)), weight)

    def add_line(self, points: Array, weight: float) -> None:
        """Remember a line through points (k, 2) in data coordinates."""
        self._add(_along(self.axes.transData.transform(points)), weight)

    def add_box(self, low: Array, high: Array, weight: float) -> None:
        """Remember a box in pixels."""
        corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        self._add(_inside(corners), weight)

    def _add(self, points: Array, weight: float) -> None:
        frame = self.axes.get_window_extent()
        seen = ((points > frame.min) & (points < frame.max)).all(axis=1)
        self.points.append(points[seen])
        self.weights.append(np.full(int(seen.sum()), weight))

    def cost(self, low: Array, high: Array) -> float:
        """Return what a text in the box from low to high would cover, and miss of the axes."""
        points, weights = np.concatenate(self.points), np.concatenate(self.weights)
        covered = ((points > low - _PADDING) & (points < high + _PADDING)).all(axis=1)
        frame = self.axes.get_window_extent()
        short = np.maximum(np.asarray(frame.min) + _PADDING - low, 0).sum()
        over = np.maximum(high - np.asarray(frame.max) + _PADDING, 0).sum()
        return float(weights[covered].sum() + _OUTSIDE * (short + over))


def place_label(
    ground: Ground,
    text: str,
    at: tuple[float, float],
    outwards: tuple[float, float],
    clear: Array,
    **style: Any,
) -> Text:
    """Write a text near a point, where it covers least, and remember it as drawn.

    Args:
        ground: what is drawn so far; its axes have their final limits.
        text: what to write.
        at: (2,) the point named, in data coordinates.
        outwards: (2,) the direction preferred among places that are equally free.
        clear: (k, 2) outline of the thing named, in data coordinates.
        style: keywords of ``Axes.annotate``.
    """
    axes = ground.axes
    transform = axes.transData
    centre = transform.transform(at)
    outline = transform.transform(clear) - centre
    found = axes.annotate(
        text,
        at,
        ha="center",
        va="center",
        annotation_clip=False,
        zorder=20,
        parse_math=False,
        **style,
    )
    extent = found.get_window_extent(renderer_of(axes))
    half = np.array([extent.width, extent.height]) / 2
    preferred = math.atan2(outwards[1], outwards[0]) if any(outwards) else math.pi / 2
    best, least = centre, math.inf
    for ring in _RINGS:
        for k in range(_DIRECTIONS):
            angle = preferred + (k + 1) // 2 * (-1) ** k * 2 * math.pi / _DIRECTIONS
            middle = centre + _clearing(outline, half, angle, ring + _PADDING)
            cost = ground.cost(middle - half, middle + half) + 1.2 * ring
            cost += 12.0 * (1 - math.cos(angle - preferred))
            if cost < least:
                best, least = middle, cost
    found.set_position(tuple(transform.inverted().transform(best)))
    ground.add_box(best - half, best + half, SOLID)
    _tie(axes, transform.inverted(), centre, best, half, outline)
    return found


def _clearing(outline: Array, half: Array, angle: float, gap: float) -> Array:
    """Return the offset along an angle at which a box of half size clears an outline by a gap."""
    direction = np.array([math.cos(angle), math.sin(angle)])
    reach = float((outline @ direction).max(initial=0.0))
    own = float(half @ np.abs(direction))
    return np.asarray(direction * (reach + own + gap))


def _tie(
    axes: Axes, to_data: Any, centre: Array, middle: Array, half: Array, outline: Array
) -> None:
    """Draw a line from a name to the nearest point of its thing, where the two are apart."""
    rim = centre + _along(np.vstack([outline, outline[:1]]))
    gap = np.maximum(np.abs(rim - middle) - half, 0.0)
    nearest = rim[np.argmin(np.hypot(*gap.T) + 0.01 * np.hypot(*(rim - middle).T))]
    start = np.clip(nearest, middle - half - 1.0, middle + half + 1.0)
    if np.hypot(*(nearest - start)) >= _LEADER:
        ends = to_data.transform([nearest, start])
        axes.plot(*ends.T, color=MUTED, linewidth=0.7, zorder=19, gid="leader")


def renderer_of(axes: Axes) -> Any:
    """Return the renderer that measures texts."""
    canvas: Any = axes.get_figure(root=True).canvas  # type: ignore[union-attr]
    return canvas.get_renderer()


def _inside(corners: Array) -> Array:
    """Return points on a grid inside a convex polygon [pixel], and points along its rim."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    counts = np.maximum(np.ceil((high - low) / _SPACING), 1).astype(int) + 1
    x, y = np.meshgrid(*(np.linspace(low[i], high[i], counts[i]) for i in (0, 1)))
    grid = np.column_stack([x.ravel(), y.ravel()])
    edge = np.roll(corners, -1, axis=0) - corners
    offset = grid[:, None, :] - corners
    turning = edge[:, 0] * offset[..., 1] - edge[:, 1] * offset[..., 0]
    within = (turning >= 0).all(axis=1) | (turning <= 0).all(axis=1)
    return np.vstack([grid[within], _along(np.vstack([corners, corners[:1]]))])


def _along(points: Array) -> Array:
    """Return points along a line [pixel], closer than ``_SPACING``."""
    pieces = [points[:1]]
    for start, end in itertools.pairwise(points):
        count = max(int(np.ceil(np.hypot(*(end - start)) / _SPACING)), 1)
        share = np.linspace(0, 1, count + 1)[1:, None]
        pieces.append(start + share * (end - start))
    return np.vstack(pieces)
