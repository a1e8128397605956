"""The instantaneous centre: the point of the body that stands still on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.kinematics import Kinematics
from trundle.se2 import Array

# Steering angles that miss a common centre by a millionth of a radian share it.
_SHARED = 1e-6
# Slower turning than this, against the motion's size, is straight motion.
_STRAIGHT = 1e-9


@dataclass(frozen=True)
class Centre:
    """The instantaneous centre of a robot's motion, or why there is none.

    Attributes:
        point: (2,) in the body frame [m], or None.
        words: what a picture says of it; "" where nothing is worth a word.
    """

    point: tuple[float, float] | None
    words: str = ""


def centre_of_twist(twist: Array) -> tuple[float, float] | None:
    """Return the point (-v / r, u / r) of the body that stands still, or None.

    >>> centre_of_twist(np.array([1.0, 0.0, 0.5]))
    (-0.0, 2.0)
    """
    u, v, r = (float(each) for each in twist)
    if abs(r) <= _STRAIGHT * float(np.hypot(u, v)) or r == 0.0:
        return None
    return -v / r, u / r


def find_centre(kinematics: Kinematics, steering: Array, twist: Array | None) -> Centre:
    """Return the instantaneous centre at steering angles (s,), or of a twist (3,).

    Without a twist there is one only where the wheels leave a single motion free.
    """
    _, _, slip = kinematics.constraints(steering)
    if twist is not None:
        words = ""
        if len(slip) and np.abs(slip @ twist).max() > _SHARED * np.abs(twist).max():
            words = "these wheels must slip sideways for this twist"
        return _named(centre_of_twist(twist), words)
    if not len(slip):
        return Centre(None)
    _, size, vectors = np.linalg.svd(slip)
    rank = int((size > _SHARED * size[0]).sum())
    if rank == 3:
        return Centre(None, "the wheels' axes share no centre: the robot cannot roll")
    if rank < 2:
        return Centre(None)
    return _named(centre_of_twist(vectors[2]), "")


def _named(point: tuple[float, float] | None, words: str) -> Centre:
    if point is None:
        return Centre(None, words or "straight on: the centre lies at infinity")
    x, y = (round(each, 3) + 0.0 for each in point)
    told = f"instantaneous centre at ({x:g}, {y:g}) m"
    return Centre(point, f"{told}; {words}" if words else told)
