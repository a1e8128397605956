"""A matrix that no simple change explains: the reading that comes nearest, entry by entry."""

from __future__ import annotations

import numpy as np

from trundle.kinematics.compare.comparison import Comparison, Difference, comparison
from trundle.kinematics.compare.our_maps import COMPONENTS, OurMaps
from trundle.kinematics.compare.readings import PRINTED, Reading, component_sizes
from trundle.se2 import Array

# More entries than these are not worth a sentence each.
_TOLD = 3


def nearest(ours: OurMaps, readings: list[Reading]) -> Comparison:
    """Return the reading that comes nearest, with the entries that differ most."""
    upright = [reading for reading in readings if not reading.transposed] or readings
    tried = [(reading, rim) for reading in upright for rim in (False, True)]
    for reading, rim in tried:
        if _undoes_ours(ours, reading, rim):
            told = (
                "it gives the right twist while no wheel slips, but is not the least-squares one: "
                "where wheels disagree it weighs them in another way"
            )
            findings = [Difference("other_weights", told)]
            return comparison(ours, reading, findings, agrees=False, rim=rim)
    misses = [_misses(ours, reading, rim) for reading, rim in tried]
    best = int(np.argmin([float(np.minimum(miss, 1.0).mean()) for miss in misses]))
    (reading, rim), miss = tried[best], misses[best]
    wrong = int((miss > PRINTED).sum())
    told = f"no simple change explains the difference: {wrong} of {miss.size} entries differ"
    worst = np.argsort(-miss, axis=None)[: min(_TOLD, wrong)]
    entries = [divmod(int(k), miss.shape[1]) for k in worst]
    findings = [
        Difference("unexplained", told),
        *(_entry_words(ours, reading, rim, entry) for entry in entries),
    ]
    return comparison(ours, reading, findings, agrees=False, rim=rim)


def _undoes_ours(ours: OurMaps, reading: Reading, rim: bool) -> bool:
    """Return whether a forward matrix takes our wheel speeds back to the twist they came from."""
    if reading.form == "inverse":
        return False
    there_and_back = reading.matrix @ ours.matrix("inverse", rim)
    return np.allclose(there_and_back @ ours.feasible, ours.feasible, atol=PRINTED)


def _misses(ours: OurMaps, reading: Reading, rim: bool) -> Array:
    """Return the differences from ours, relative to the entries of the same unit."""
    mine = ours.matrix(reading.form, rim)
    off = reading.matrix - mine
    if reading.form == "inverse":
        return np.asarray(np.abs(off @ ours.feasible) / component_sizes(mine))
    return np.asarray(np.abs(off) / component_sizes(mine.T)[:, None])


def _entry_words(ours: OurMaps, reading: Reading, rim: bool, at: tuple[int, int]) -> Difference:
    mine = ours.matrix(reading.form, rim)
    if reading.form == "inverse":
        row, column = repr(ours.names[at[0]]), COMPONENTS[at[1]]
    else:
        row, column = COMPONENTS[at[0]], repr(ours.names[at[1]])
    told = f"row {row}, column {column}: {reading.matrix[at]:.6g} in place of {mine[at]:.6g}"
    return Difference("entry", told)
