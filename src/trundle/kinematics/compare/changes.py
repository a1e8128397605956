"""What may be changed, each change with its price: the twist, the geometry, single wheels.

A change that is made often is cheap: a sign, a reversed wheel, a mirrored roller cost 1.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from trundle.kinematics.compare.our_maps import COMPONENTS, OurMaps, inverse_of
from trundle.se2 import Array

_ENTRY = 1.5  # one entry's sign
_LEANING = 1.4  # the entry of a mirrored roller, but with our yaw arm
_ARM = 1.1
# Factors on one component of the twist: its column, the factor, the price.
_FACTORS = (
    (2, 1.0, 0.0),
    (2, 2.0, 1.0),
    (2, 0.5, 1.0),
    (2, math.pi / 180, 1.0),
    (0, 2.0, 1.2),
    (0, 0.5, 1.2),
    (1, 2.0, 1.2),
    (1, 0.5, 1.2),
)
# What the yaw column may hold in place of our arm: the wheels' x and y, scaled.
_ARMS = (
    ("arm_difference", -1.0, 1.0),
    ("arm_difference", 1.0, -1.0),
    ("full_track", 1.0, 2.0),
    ("full_wheelbase", 2.0, 1.0),
    ("no_wheelbase", 0.0, 1.0),
    ("no_track", 1.0, 0.0),
)


@dataclass(frozen=True)
class Frame:
    """What was done to the twist: the pasted inverse map is ours @ matrix.

    Attributes:
        swap: VX and VY have changed places.
        signs: of VX, VY and WZ.
        column: of the component with a factor.
        factor: on that component, 1 where there is none.
        cost: the price of all of it.
        matrix: (3, 3).
    """

    swap: bool
    signs: tuple[int, ...]
    column: int
    factor: float
    cost: float
    matrix: Array

    @property
    def negated(self) -> bool:
        """Whether all three signs are wrong, which is one change: the wheels turn backwards."""
        return _negated(self.signs)


def _negated(signs: tuple[int, ...]) -> bool:
    return signs.count(-1) == 3


def frames() -> list[Frame]:
    """Return everything that may have been done to the twist."""
    return [
        _frame(signs, swap, *factor)
        for signs in itertools.product((1, -1), repeat=3)
        for swap in (False, True)
        for factor in _FACTORS
    ]


def _frame(signs: tuple[int, ...], swap: bool, column: int, factor: float, price: float) -> Frame:
    matrix = np.diag(np.array(signs, dtype=np.float64))
    matrix[column, column] *= factor
    matrix = matrix[[1, 0, 2]] if swap else matrix
    wrong = 1 if _negated(signs) else signs.count(-1)
    return Frame(swap, signs, column, factor, wrong + swap + price, matrix)


@dataclass(frozen=True)
class LineChanges:
    """What the line of each of n wheels in a map may be changed to, in k ways.

    Attributes:
        names: (k,) of the changes, the first "" for none.
        costs: (k,) their prices.
        lines: (k, n, 3) the lines so changed.
    """

    names: tuple[str, ...]
    costs: Array
    lines: Array


def _line_changes(own: Array, more: dict[str, tuple[float, Array]]) -> LineChanges:
    """Return our own lines (n, 3), reversed ones, those with one sign lost, and more."""
    found = {"": (0.0, own), "reversed": (1.0, -own)} | more
    for j, name in enumerate(COMPONENTS):
        found[name] = (_ENTRY, own * np.where(np.arange(3) == j, -1.0, 1.0))
    costs, lines = zip(*found.values(), strict=True)
    return LineChanges(tuple(found), np.array(costs), np.stack(lines))


@dataclass(frozen=True)
class Variant:
    """Our maps with the geometry of all wheels changed at once.

    Attributes:
        code: of that change, "" for none.
        cost: its price.
        arms: (n,) what each rim then runs for one radian of yaw [m].
        inverse: the rows of the inverse map, and what they may be changed to.
        forward: the columns of the forward map likewise.
    """

    code: str
    cost: float
    arms: Array
    inverse: LineChanges
    forward: LineChanges


def variants_of(ours: OurMaps) -> list[Variant]:
    """Return our maps as they are, with all rollers mirrored, and with other yaw arms."""
    if ours.has_rollers:
        found = [
            _variant(ours, "", 0.0, ours.inverse, ours.mirrored),
            _variant(ours, "rollers_mirrored", 1.0, ours.mirrored, ours.inverse),
        ]
    else:
        found = [_variant(ours, "", 0.0, ours.inverse)]
    for code, along, across in _ARMS if ours.turns else ():
        if code == "arm_difference" and not ours.has_rollers:
            continue
        rows = inverse_of(ours.robot, ours.steering, along, across)
        if not any(np.allclose(rows, each.inverse.lines[0]) for each in found):
            found.append(_variant(ours, code, _ARM, rows))
    return found


def _variant(
    ours: OurMaps, code: str, cost: float, rows: Array, mirrored: Array | None = None
) -> Variant:
    """Return a variant with an inverse map (n, 3); single rollers may be mirrored in it."""
    columns = ours.forward(rows).T
    rows_more: dict[str, tuple[float, Array]] = {}
    columns_more: dict[str, tuple[float, Array]] = {}
    if mirrored is not None:
        leaning = np.column_stack([mirrored[:, :2], rows[:, 2]])
        rows_more = {
            "mirrored": (1.0, mirrored),
            "mirrored reversed": (2.0, -mirrored),
            "leaning": (_LEANING, leaning),
        }
        columns_more = {"leaning": (_LEANING, _leaning_columns(ours, columns))}
    return Variant(
        code=code,
        cost=cost,
        arms=ours.arms(rows),
        inverse=_line_changes(rows, rows_more),
        forward=_line_changes(columns, columns_more),
    )


def _leaning_columns(ours: OurMaps, columns: Array) -> Array:
    """Return columns (n, 3) of W with each wheel's push mirrored about its drive direction."""
    twice = np.array([2 * wheel.heading for wheel in ours.robot.driven])
    c, s = np.cos(twice), np.sin(twice)
    u, v, r = columns.T
    return np.column_stack([c * u + s * v, s * u - c * v, r])
