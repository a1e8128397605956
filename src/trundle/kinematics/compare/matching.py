"""Our lines beside the pasted ones: which is which, and what was done to single wheels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.kinematics.compare.changes import LineChanges
from trundle.kinematics.compare.our_maps import OurMaps
from trundle.kinematics.compare.readings import Reading, component_sizes
from trundle.kinematics.compare.scales import Scale, scale_of
from trundle.se2 import Array

# Another order costs more than two other changes.
_ORDER = 2.5
_IMPOSSIBLE = 1e6
# So little that it decides between equals only.
_MOVING = 0.01


@dataclass(frozen=True)
class Fit:
    """What turns our lines into the pasted ones: a factor, an order, changes of single wheels.

    Attributes:
        scale: the factor on the whole matrix.
        order: our wheel for each pasted one.
        changes: name of the change of each pasted wheel, "" for none.
        cost: the price of order and changes.
    """

    scale: Scale
    order: tuple[int, ...]
    changes: tuple[str, ...]
    cost: float


def match(
    ours: OurMaps,
    reading: Reading,
    pasted: Array,
    changes: LineChanges,
    tolerance: Array,
    *,
    inverse: bool,
) -> Fit | None:
    """Return what turns our lines into the pasted ones, None where nothing does.

    Args:
        ours: the robot's maps.
        reading: of the pasted matrix.
        pasted: (n, 3) one line for each wheel.
        changes: our lines, and what they may be changed to.
        tolerance: (3,) of the entries of VX, VY and WZ, relative to their sizes.
        inverse: the lines are rows of the inverse map, not columns of the forward map.
    """
    own = changes.lines[0]
    # Signs, order and (in a plane without constraints) mirrored rollers keep the norm of VX, VY.
    part = slice(0, 2) if own[:, :2].any() else slice(0, 3)
    ratio = float(np.linalg.norm(pasted[:, part]) / np.linalg.norm(own[:, part]))
    if ratio == 0:
        return None
    scale = scale_of(ours, reading, ratio if inverse else 1 / ratio, float(tolerance.max()))
    if scale is None:
        return None
    lines = changes.lines * (scale.factor if inverse else 1 / scale.factor)
    # Axes: change, pasted wheel, our wheel, component.
    misses = np.abs(pasted[None, :, None] - lines[:, None])
    near = (misses <= tolerance * component_sizes(lines[0])).all(axis=-1)
    prices = np.where(near, changes.costs[:, None, None], _IMPOSSIBLE)
    order, cost = _assign(prices.min(axis=0))
    if cost >= _IMPOSSIBLE:
        return None
    chosen = prices[:, np.arange(len(pasted)), list(order)].argmin(axis=0)
    return Fit(scale, order, tuple(changes.names[i] for i in chosen), cost)


def _assign(price: Array) -> tuple[tuple[int, ...], float]:
    """Return our wheel for each pasted one, and the price; our own order where that is possible.

    Args:
        price: (n, n) of our wheel (column) in the place of a pasted one (row).
    """
    n = len(price)
    same, own = tuple(range(n)), float(np.trace(price))
    if own <= _ORDER:
        return same, own
    if (price.min(axis=0) >= _IMPOSSIBLE).any() or (price.min(axis=1) >= _IMPOSSIBLE).any():
        return same, _IMPOSSIBLE
    from scipy.optimize import linear_sum_assignment

    # Among equals, as many wheels as can be stay where they are.
    _, to = linear_sum_assignment(price + _MOVING * (1 - np.eye(n)))
    moved = float(price[np.arange(n), to].sum()) + _ORDER
    if own <= moved:
        return same, own
    return tuple(int(i) for i in to), moved
