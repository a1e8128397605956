"""In words: what was done to a matrix as a whole, and to the components of the twist."""

from __future__ import annotations

import numpy as np

from trundle.kinematics.compare.comparison import Difference
from trundle.kinematics.compare.our_maps import COMPONENTS, EXACT, OurMaps
from trundle.kinematics.compare.search import ChangeSet
from trundle.kinematics.words import join
from trundle.se2 import Array

# A wrong sign in an inverse matrix, and in a forward one.
_BACKWARDS = {
    "VX": ("+VX drives backwards", "driving forwards comes out as driving backwards"),
    "VY": ("+VY drives to the right", "driving to the left comes out as driving to the right"),
    "WZ": ("+WZ turns clockwise", "turning counter-clockwise comes out as clockwise"),
}
_WRONG_ARM = {
    "arm_difference": "takes half the wheelbase and half the track with the wrong sign between",
    "full_track": "takes the full track in place of half of it",
    "full_wheelbase": "takes the full wheelbase in place of half of it",
    "no_wheelbase": "leaves out how far the wheels are in front or behind (x)",
    "no_track": "leaves out how far the wheels are to the side (y)",
}


def matrix_words(ours: OurMaps, found: ChangeSet) -> list[Difference]:
    """Return the differences that all wheels share, the one of the most entries first."""
    return [
        *_transposed_words(found),
        *_scale_words(ours, found),
        *_frame_words(ours, found),
        *_arm_variant_words(ours, found),
    ]


def wheel_line(found: ChangeSet) -> str:
    """Return what the line of a wheel is called in the pasted matrix."""
    return "row" if found.reading.form == "inverse" else "column"


def twist_line(found: ChangeSet) -> str:
    """Return what the line of a component of the twist is called in the pasted matrix."""
    return "column" if found.reading.form == "inverse" else "row"


def arm_words(ours: OurMaps, arms: Array) -> str:
    """Return the yaw arm among arms (n,) [m] that is farthest from ours."""
    own = ours.arms(ours.inverse)
    i = int(np.argmax(np.abs(arms - own)))
    turned = ", with the other sign" if arms[i] * own[i] < 0 else ""
    return (
        f"the yaw arm of {ours.names[i]!r} is {abs(arms[i]):.4g} m in place of "
        f"{abs(own[i]):.4g} m{turned}"
    )


def _times(found: ChangeSet, factor: float) -> str:
    """Return how many times ours the entries are, for a factor on the inverse map."""
    factor = 1 / factor if found.reading.form == "forward" else factor
    return {2.0: "twice", 0.5: "half of"}.get(factor, f"{factor:.4g} times") + " ours"


def _transposed_words(found: ChangeSet) -> list[Difference]:
    if not found.reading.transposed:
        return []
    form = found.reading.form
    other = "inverse" if form == "forward" else "forward"
    told = (
        f"the matrix is transposed: it is the {form} matrix with rows and columns exchanged, "
        f"which is not the {other} matrix"
    )
    return [Difference("transposed", told)]


def _scale_words(ours: OurMaps, found: ChangeSet) -> list[Difference]:
    scale, radius = found.fit.scale, float(ours.radii[0])
    factor = scale.factor / (radius if scale.rim and ours.one_radius else 1.0)
    if scale.code == "":
        return []
    if scale.code == "radius":
        told = f"the matrix uses the radius {radius / factor:.4g} m in place of {radius:.4g} m"
    elif scale.code == "rpm":
        told = "the wheel speeds are in rev/min in place of rad/s: a factor of 60/(2 pi)"
    else:
        reasons = join(_reasons(ours, found, factor), "or")
        told = f"every entry is {_times(found, factor)}{': ' * bool(reasons)}{reasons}"
    return [Difference(scale.code, told)]


def _reasons(ours: OurMaps, found: ChangeSet, factor: float) -> list[str]:
    """Return what a factor on the inverse map may come from."""
    scale, radius, n = found.fit.scale, float(ours.radii[0]), len(ours.names)
    if scale.code == "roller_cosine":
        return ["the cosine of the roller angle is left out"]
    reasons = []
    if factor == 0.5 and not scale.rim and ours.one_radius:
        reasons.append(f"the diameter {2 * radius:.4g} m in place of the radius {radius:.4g} m")
    if scale.code == "factor" and factor == 1 / n and found.reading.form == "forward":
        reasons.append(f"a sum over the {n} wheels in place of their mean")
    return reasons


def _frame_words(ours: OurMaps, found: ChangeSet) -> list[Difference]:
    frame, line = found.frame, twist_line(found)
    told = []
    if frame.swap:
        told.append(Difference("axes_swapped", f"the {line}s VX and VY are swapped"))
    for name, sign in zip(COMPONENTS, frame.signs, strict=True):
        # Where all three are wrong, the wheels turn backwards: that is told of the wheels.
        if sign < 0 and not frame.negated:
            swapped = frame.swap and name != "WZ"
            backwards = _BACKWARDS[name][found.reading.form == "forward"]
            so = "" if swapped else f", so that {backwards}"
            message = f"the {name} {line} has the wrong sign{so}"
            told.append(Difference(f"{name.lower()}_sign", message))
    if frame.factor != 1:
        told.append(_factor_words(ours, found))
    return told


def _factor_words(ours: OurMaps, found: ChangeSet) -> Difference:
    name, factor = COMPONENTS[found.frame.column], found.frame.factor
    told = f"the {name} {twist_line(found)} is {_times(found, factor)}"
    if name != "WZ":
        return Difference(f"{name.lower()}_factor", told)
    if factor not in (2.0, 0.5):
        return Difference("degrees", f"{told}: its yaw rate is in deg/s, a factor of 180/pi")
    arms = np.abs(found.variant.arms)
    if ours.turns and np.ptp(arms) <= EXACT * arms[0]:
        told += f": the yaw arm is {factor * arms[0]:.4g} m in place of {arms[0]:.4g} m"
        if factor == 2 and np.allclose(arms, [abs(wheel.y) for wheel in ours.robot.driven]):
            told += ", the full track in place of half of it"
    return Difference("arm_doubled" if factor == 2 else "arm_halved", told)


def _arm_variant_words(ours: OurMaps, found: ChangeSet) -> list[Difference]:
    code = found.variant.code
    if code not in _WRONG_ARM:
        return []
    arm = arm_words(ours, found.variant.arms)
    return [Difference(code, f"the WZ {twist_line(found)} {_WRONG_ARM[code]}: {arm}")]
