"""What a comparison tells: the matrix as it was understood, the differences, and our matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trundle.kinematics.compare.our_maps import OurMaps
from trundle.kinematics.compare.readings import Reading
from trundle.se2 import Array


@dataclass(frozen=True)
class Difference:
    """One difference: a code for programs, and a sentence for people."""

    code: str
    message: str


@dataclass(frozen=True, eq=False)
class Comparison:
    """How a matrix from elsewhere compares with ours.

    Attributes:
        agrees: it is the same map; the wheels may stand in another order, and the digits may end
            where the print ended. Both are told in ``findings``.
        form: "forward" (wheels to twist) or "inverse" (twist to wheels).
        quantity: "wheel speeds in rad/s" or "rim speeds in m/s".
        order: names of the driven wheels in the order of the matrix.
        findings: the differences, the one of the most entries first.
        largest_difference: of an entry from ours, for twists that the robot can have.
        ours: our matrix in the same form, quantity and order.
    """

    agrees: bool
    form: str
    quantity: str
    order: tuple[str, ...]
    findings: tuple[Difference, ...]
    largest_difference: float
    ours: Array


def comparison(
    ours: OurMaps,
    reading: Reading,
    findings: Sequence[Difference],
    *,
    agrees: bool,
    rim: bool,
    order: Sequence[int] | None = None,
) -> Comparison:
    """Return the comparison with a reading of the pasted matrix.

    Args:
        ours: the robot's maps.
        reading: of the pasted matrix.
        findings: the differences.
        agrees: whether they leave it the same map.
        rim: the matrix counts in rim speeds, not in wheel speeds.
        order: our wheel for each pasted one; left out, they stand in our order.
    """
    forward = reading.form == "forward"
    order = range(len(ours.names)) if order is None else order
    mine = ours.matrix(reading.form, rim, order)
    off = reading.matrix - mine
    # The columns of an inverse count only for twists that the robot can have.
    off = off if forward else off @ ours.feasible
    if reading.short:
        mine = np.delete(mine, 1, axis=0 if forward else 1)
    mine.setflags(write=False)
    return Comparison(
        agrees=agrees,
        form=reading.form,
        quantity="rim speeds in m/s" if rim else "wheel speeds in rad/s",
        order=tuple(ours.names[i] for i in order),
        findings=tuple(findings),
        largest_difference=float(np.abs(off).max()),
        ours=mine,
    )
