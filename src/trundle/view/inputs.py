"""What pictures are given, checked and completed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.kinematics import Kinematics
from trundle.se2 import Array


def twist_of(twist: npt.ArrayLike) -> Array:
    """Return a twist (3,) as an array.

    Raises:
        ShapeError: it has another shape or is not finite.
    """
    return _vector(twist, 3, "twist must be (u, v, r)")


def steering_of(
    kinematics: Kinematics, steering: npt.ArrayLike | None, twist: Array | None = None
) -> Array:
    """Return steering angles (s,): those given, else those for the twist, else zeros.

    Raises:
        ShapeError: they have the wrong shape or are not finite.
    """
    names = [wheel.name for wheel in kinematics.robot.steered]
    if steering is not None:
        told = ", ".join(names) or "a robot without steering"
        return _vector(steering, len(names), f"steering of {told} must be {len(names)} angles")
    if twist is None or not names:
        return np.zeros(len(names))
    return kinematics.inverse(twist, limit=True).steering


def _vector(values: npt.ArrayLike, size: int, wanted: str) -> Array:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"{wanted}, got {values!r}") from None
    if array.shape != (size,):
        raise ShapeError(f"{wanted}, got shape {array.shape}")
    if not np.isfinite(array).all():
        raise ShapeError(f"{wanted}, all finite, got nan or inf")
    return array
