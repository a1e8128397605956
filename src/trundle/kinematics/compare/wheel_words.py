"""In words: what was done to single wheels, and to their order."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from trundle.kinematics.compare.comparison import Difference
from trundle.kinematics.compare.our_maps import COMPONENTS, OurMaps
from trundle.kinematics.compare.search import ChangeSet
from trundle.kinematics.compare.words import arm_words, twist_line, wheel_line
from trundle.kinematics.words import join


def wheel_words(ours: OurMaps, found: ChangeSet) -> list[Difference]:
    """Return the differences of single wheels: reversed, mirrored, one entry's sign."""
    # A change's name by our wheel; a change of all wheels and one of this wheel cancel.
    changes = dict(sorted(zip(found.fit.order, found.fit.changes, strict=True)))
    all_reversed, all_mirrored = found.frame.negated, found.variant.code == "rollers_mirrored"
    backwards = [i for i, name in changes.items() if ("reversed" in name) != all_reversed]
    mirrored = [i for i, name in changes.items() if ("mirrored" in name) != all_mirrored]
    return [
        *_reversed_words(ours, backwards, found),
        *_mirrored_words(ours, mirrored, found),
        *_entry_words(ours, changes, found),
    ]


def order_words(ours: OurMaps, found: ChangeSet) -> list[Difference]:
    """Return in which order the wheels stand, if not in ours."""
    moved = [k for k, wheel in enumerate(found.fit.order) if wheel != k]
    if not moved:
        return []
    row = wheel_line(found)
    if len(moved) == 2:
        told = f"order swapped: the {row}s of {_quoted(ours, moved)} have changed places"
    else:
        order = _quoted(ours, found.fit.order)
        told = f"the {row}s stand in the order {order}, not in the robot's"
    return [Difference("order", told)]


def _quoted(ours: OurMaps, wheels: Iterable[int]) -> str:
    return join([repr(ours.names[i]) for i in wheels])


def _reversed_words(ours: OurMaps, which: list[int], found: ChangeSet) -> list[Difference]:
    if not which:
        return []
    if len(which) == len(ours.names) > 1:
        told = "all wheels are reversed: every entry has the wrong sign"
        return [Difference("all_reversed", told)]
    row = wheel_line(found)
    are, rows_have = ("are", f"{row}s have") if len(which) > 1 else ("is", f"{row} has")
    told = f"{_quoted(ours, which)} {are} reversed: the {rows_have} the wrong sign"
    return [Difference("reversed", told)]


def _mirrored_words(ours: OurMaps, which: list[int], found: ChangeSet) -> list[Difference]:
    if not which:
        return []
    degrees = np.degrees(ours.rollers[which[0]])
    example = f"{ours.names[which[0]]!r}: {-degrees:.4g} deg in place of {degrees:.4g} deg"
    many = len(which) > 1
    if many and len(which) == np.count_nonzero(ours.rollers):
        arm = arm_words(ours, ours.arms(ours.mirrored))
        told = f"all rollers are mirrored ({example}), so that {arm}"
        return [Difference("rollers_mirrored", told)]
    told = (
        f"{wheel_line(found)}{'s' * many} {_quoted(ours, which)} {'have' if many else 'has'} "
        f"the sign of a mirrored roller ({example})"
    )
    if found.reading.form == "forward":
        told += "; in a forward matrix that changes every column"
    return [Difference("roller_mirrored", told)]


def _entry_words(ours: OurMaps, changes: dict[int, str], found: ChangeSet) -> list[Difference]:
    row, column = wheel_line(found), twist_line(found)
    told = []
    for wheel, name in changes.items():
        where = f"{row} {ours.names[wheel]!r}"
        if name == "leaning":
            message = (
                f"{where} has VX and VY as if its roller were mirrored, but WZ as ours: "
                "one sign is wrong"
            )
            told.append(Difference("roller_sign", message))
        elif name in COMPONENTS:
            message = f"{where}, {column} {name}: the entry has the wrong sign"
            told.append(Difference("entry_sign", message))
    return told
