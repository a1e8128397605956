"""The factor on a whole matrix: the quantity that it counts in, or a mistake with a name."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trundle.kinematics.compare.our_maps import EXACT, OurMaps
from trundle.kinematics.compare.readings import PRINTED, Reading
from trundle.se2 import Array

# Prices: a factor with a name costs 1.
_RADIUS = 1.6
_ANY_FACTOR = 2.5


@dataclass(frozen=True)
class Scale:
    """The factor on the whole inverse map, and the quantity that goes with it.

    Attributes:
        factor: the pasted inverse map over ours.
        rim: wheels are counted in rim speeds.
        code: of the mistake, "" where the factor is only the quantity's.
        cost: its price.
    """

    factor: float
    rim: bool
    code: str
    cost: float


def scale_of(ours: OurMaps, reading: Reading, ratio: float, tolerance: float) -> Scale | None:
    """Return what the ratio of the pasted inverse map to ours stands for, None for nothing."""
    units = [(False, 1.0), (True, float(ours.radii[0]))]
    if not ours.one_radius:
        units = [(reading.rim, 1.0)]
    named = _named(ours, units)
    misses = [abs(ratio / scale.factor - 1) for scale in named]
    for scale, miss in zip(named, misses, strict=True):
        if miss <= tolerance:
            return scale
    # The rounding of a name is left to a step with more tolerance; any factor on a transpose
    # explains what is a few numbers only.
    if reading.transposed or min(misses) <= max(PRINTED, 2 * tolerance):
        return None
    if ours.one_radius and 0.25 < ratio < 4:
        return Scale(ratio, False, "radius", _RADIUS)
    rim, _ = min(units, key=lambda unit: abs(math.log(ratio / unit[1])))
    return Scale(ratio, rim, "scale", _ANY_FACTOR)


def _named(ours: OurMaps, units: list[tuple[bool, float]]) -> list[Scale]:
    """Return the factors that have a name, in each quantity (rim, what 1 rad/s is in it)."""
    n = len(ours.names)
    codes = {1.0: ""}
    for factor in (2.0, 0.5, float(n), 1 / n):
        codes.setdefault(factor, "factor")
    if (push := _common_push(ours.rollers)) < 1 - EXACT:
        codes[push] = "roller_cosine"
    named = [
        Scale(unit * factor, rim, code, float(code != ""))
        for factor, code in codes.items()
        for rim, unit in units
    ]
    if not units[0][0]:
        named.append(Scale(30 / math.pi, False, "rpm", 1.0))
    return named


def _common_push(rollers: Array) -> float:
    """Return the cosine that all roller angles (n,) [rad] share, 1 where they share none."""
    cosines = np.abs(np.cos(rollers))
    return float(cosines[0]) if np.ptp(cosines) <= EXACT else 1.0
