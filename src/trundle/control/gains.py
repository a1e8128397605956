"""Gains, checked."""

from __future__ import annotations

import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.kinematics import finite


def three_gains(gains: npt.ArrayLike, name: str) -> tuple[float, float, float]:
    """Return three gains that are not negative, for x, y and psi.

    Raises:
        ShapeError: they are something else.
    """
    values = finite(gains, name)
    if values.shape != (3,):
        raise ShapeError(f"{name} must be three gains, for x, y and psi, got shape {values.shape}")
    if (values < 0).any():
        raise ShapeError(f"{name} must not be negative, got {values.tolist()}: it would push away")
    x, y, psi = values.tolist()
    return x, y, psi


def one_gain(gain: float, name: str) -> float:
    """Return a gain that is positive.

    Raises:
        ShapeError: it is something else.
    """
    value = finite(gain, name)
    if value.shape != () or value <= 0:
        raise ShapeError(f"{name} must be one positive number, got {gain!r}")
    return float(value)
