"""The pasted matrix: the ways to understand it, and how exactly it is written."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.errors import ShapeError
from trundle.kinematics.compare.our_maps import OurMaps
from trundle.se2 import Array

# Four digits printed.
PRINTED = 1e-3
# Print with fewer digits is told from the decimals, up to a twentieth of an entry.
COARSE = 0.05
# Keeps a matrix of zeros from a division by zero; far below every entry.
_NOT_ZERO = 1e-300


@dataclass(frozen=True)
class Reading:
    """One way to understand the pasted matrix.

    Attributes:
        form: "forward" (wheels to twist) or "inverse" (twist to wheels).
        matrix: (3, n) forward, (n, 3) inverse.
        transposed: it was pasted with rows and columns exchanged.
        short: VY was left out; it is filled in with zeros.
        rim: wheels are counted in rim speeds. Where all radii are one, a factor tells it instead.
    """

    form: str
    matrix: Array
    transposed: bool
    short: bool
    rim: bool


def readings_of(pasted: Array, ours: OurMaps) -> list[Reading]:
    """Return all ways to understand a pasted matrix.

    Raises:
        ShapeError: there is none.
    """
    n = len(ours.names)
    sizes = (3, 2) if ours.planar else (3,)
    found = []
    for transposed, matrix in ((False, pasted), (True, pasted.T)):
        for form, shaped in (("forward", matrix), ("inverse", matrix.T)):
            if shaped.ndim == 2 and shaped.shape[0] in sizes and shaped.shape[1] == n:
                short = shaped.shape[0] == 2
                full = np.insert(shaped, 1, 0.0, axis=0) if short else shaped
                full = full if form == "forward" else full.T
                bases = (False,) if ours.one_radius else (False, True)
                found += [Reading(form, full, transposed, short, rim) for rim in bases]
    if not found:
        raise ShapeError(_shape_words(pasted, ours))
    return found


def _shape_words(pasted: Array, ours: OurMaps) -> str:
    n = len(ours.names)
    shape = " x ".join(str(length) for length in pasted.shape)
    also = f" (without VY: 2 x {n}, {n} x 2)" if ours.planar else ""
    return (
        f"the matrix is {shape}, but robot {ours.robot.name!r} has {n} driven "
        f"wheel{'s' * (n != 1)}: a forward matrix is 3 x {n}, an inverse {n} x 3{also}"
    )


def component_sizes(lines: Array) -> Array:
    """Return the size (3,) of VX, VY and WZ in lines (n, 3); VX and VY share a unit."""
    u, v, r = np.abs(lines).max(axis=-2)
    return np.array([max(u, v), max(u, v), r or max(u, v)])


def print_tolerance(reading: Reading) -> Array:
    """Return how far (3,) from VX, VY and WZ their print may lie, relative to their sizes."""
    lines = reading.matrix.T if reading.form == "forward" else reading.matrix
    decimals = max(len(f"{x:.12f}".rstrip("0").partition(".")[2]) for x in lines.ravel().tolist())
    # Half of the last digit printed, with room for the rounding of this very number.
    half = 0.501 * 10.0**-decimals
    return np.clip(half / (component_sizes(lines) + _NOT_ZERO), PRINTED, COARSE)
