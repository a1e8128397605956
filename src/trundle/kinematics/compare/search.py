"""The cheapest changes that turn our matrix into the pasted one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from trundle.kinematics.compare.changes import Frame, LineChanges, Variant, frames, variants_of
from trundle.kinematics.compare.matching import Fit, match
from trundle.kinematics.compare.our_maps import EXACT, OurMaps
from trundle.kinematics.compare.readings import COARSE, Reading, component_sizes
from trundle.se2 import Array

_TRANSPOSED = 1.5  # its price
# A pseudo-inverse enlarges what rounding has left; what it finds is checked without this factor.
_SLACK = 10.0


@dataclass(frozen=True)
class ChangeSet:
    """Changes that together turn our matrix into the pasted one.

    Attributes:
        reading: how the pasted matrix is understood.
        frame: what was done to the twist.
        variant: what was done to the geometry.
        fit: what was done to the whole matrix and to single wheels.
        cost: the price of all of it.
    """

    reading: Reading
    frame: Frame
    variant: Variant
    fit: Fit
    cost: float


def candidates(ours: OurMaps) -> list[tuple[Frame, Variant]]:
    """Return the frames with the variants that may go with them, the cheapest first."""
    variants = variants_of(ours)
    pairs = [(f, v) for f in frames() for v in variants if f.factor == 1 or v.code == ""]
    return sorted(pairs, key=lambda pair: pair[0].cost + pair[1].cost)


def cheapest(
    ours: OurMaps,
    reading: Reading,
    pairs: Iterable[tuple[Frame, Variant]],
    tolerance: Array,
    best: ChangeSet | None,
) -> ChangeSet | None:
    """Return the cheapest changes for one reading, if they are cheaper than the best so far.

    Args:
        ours: the robot's maps.
        reading: of the pasted matrix.
        pairs: the candidates, the cheapest first.
        tolerance: (3,) of the entries of VX, VY and WZ, relative to their sizes.
        best: the cheapest so far.
    """
    fits = _inverse_fits if reading.form == "inverse" else _forward_fits
    start = _TRANSPOSED if reading.transposed else 0.0
    for frame, variant in pairs:
        cost = start + frame.cost + variant.cost
        if best is not None and cost >= best.cost:
            break
        if reading.short and frame.swap:
            continue
        for fit in fits(ours, reading, frame, variant, tolerance):
            total = cost + fit.scale.cost + fit.cost
            if best is None or total < best.cost:
                best = ChangeSet(reading, frame, variant, fit, total)
    return best


def _inverse_fits(
    ours: OurMaps, reading: Reading, frame: Frame, variant: Variant, tolerance: Array
) -> list[Fit]:
    """Return how single wheels explain what frame and variant leave of an inverse matrix."""
    pasted = reading.matrix @ np.linalg.inv(frame.matrix) @ ours.feasible
    rows = _feasible_rows(ours, reading, variant)
    fit = match(ours, reading, pasted, rows, tolerance, inverse=True)
    return [] if fit is None else [fit]


def _forward_fits(
    ours: OurMaps, reading: Reading, frame: Frame, variant: Variant, tolerance: Array
) -> list[Fit]:
    """Return how single wheels explain what frame and variant leave of a forward matrix."""
    units = ours.units(reading.rim)
    pasted = frame.matrix @ reading.matrix
    columns = replace(variant.forward, lines=variant.forward.lines / units[:, None])
    direct = match(ours, reading, pasted.T, columns, tolerance, inverse=False)
    # Back through the pseudo-inverse: a mirrored roller changes one row there, but every column.
    weights = ours.weights / units
    back = np.linalg.pinv(ours.feasible @ pasted / weights, rcond=EXACT) / weights[:, None]
    slack = np.minimum(_SLACK * tolerance, 2 * COARSE)
    rows = _feasible_rows(ours, reading, variant)
    through = match(ours, reading, back @ ours.feasible, rows, slack, inverse=True)
    if through is not None:
        made = ours.forward(_changed(variant.inverse, through)).T / units[:, None]
        made = made[list(through.order)]
        misses = np.abs(pasted.T * through.scale.factor - made)
        if (misses > tolerance * component_sizes(made)).any():
            through = None
    return [fit for fit in (direct, through) if fit is not None]


def _feasible_rows(ours: OurMaps, reading: Reading, variant: Variant) -> LineChanges:
    """Return the rows of the inverse map in the reading's quantity, for feasible twists only."""
    units = ours.units(reading.rim)[:, None]
    return replace(variant.inverse, lines=units * variant.inverse.lines @ ours.feasible)


def _changed(rows: LineChanges, fit: Fit) -> Array:
    """Return our inverse map (n, 3) with a fit's changes of single wheels, in our order."""
    changed = np.empty((len(fit.order), 3))
    for wheel, name in zip(fit.order, fit.changes, strict=True):
        changed[wheel] = rows.lines[rows.names.index(name), wheel]
    return changed
