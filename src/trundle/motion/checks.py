"""Checks of what a trajectory is made of, each with its words."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.se2 import Array

# Far beyond any length, time or rate, and far enough from where the powers of a quintic overflow.
LARGEST = 1e15
SMALLEST = 1e-15


def number(value: object, name: str, unit: str) -> float:
    """Return a value as a finite float.

    Raises:
        TrundleError: it is no such number.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TrundleError(f"{name} must be a number [{unit}], got {value!r}")
    try:
        checked = float(value)
    except OverflowError:
        checked = math.inf
    if not math.isfinite(checked):
        raise TrundleError(f"{name} must be finite, got {checked}")
    if abs(checked) > LARGEST:
        raise TrundleError(f"{name} must be at most {LARGEST:g} {unit}, got {checked:g}")
    return checked


def positive(value: object, name: str, unit: str) -> float:
    """Return a value as a positive finite float.

    Raises:
        TrundleError: it is no such number.
    """
    checked = number(value, name, unit)
    if checked <= 0:
        raise TrundleError(f"{name} must be positive, got {checked:g} {unit}".rstrip())
    if checked < SMALLEST:
        raise TrundleError(f"{name} must be at least {SMALLEST:g} {unit}, got {checked:g}")
    return checked


def turning_rate(value: object, name: str = "rate") -> float:
    """Return a value as a finite float other than zero; a negative one runs clockwise.

    Raises:
        TrundleError: it is no such number.
    """
    checked = number(value, name, "rad/s")
    if abs(checked) < SMALLEST:
        raise TrundleError(f"{name} must not be zero; a negative one runs the other way round")
    return checked


def numbers(values: npt.ArrayLike, name: str) -> Array:
    """Return values as an array of finite floats of a usable size.

    Raises:
        ShapeError: they are no such array.
    """
    array = finite(values, name)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise ShapeError(f"{name} must lie between -{LARGEST:g} and {LARGEST:g}")
    return array


def row(values: npt.ArrayLike, name: str, width: int) -> Array:
    """Return values (width,).

    Raises:
        ShapeError: they have another shape, or are not finite numbers.
    """
    array = numbers(values, name)
    if array.shape != (width,):
        words = "(x, y)" if width == 2 else "(x, y, psi)"
        raise ShapeError(f"{name} must be {words}, got shape {array.shape}")
    return array


def points_array(points: npt.ArrayLike, name: str = "points") -> Array:
    """Return points (k, 2), or (k, 3) with headings; k is at least 2.

    Raises:
        ShapeError: they have another shape, or are not finite numbers.
    """
    array = numbers(points, name)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ShapeError(
            f"{name} must have shape (k, 2), or (k, 3) with a heading each, got {array.shape}"
        )
    if len(array) < 2:
        raise ShapeError(f"{name}: a trajectory needs at least two, got {len(array)}")
    return array


def times_array(times: npt.ArrayLike, count: int) -> Array:
    """Return times (count,) [s] that begin at 0 and grow.

    Raises:
        ShapeError: they have another shape, or are not finite numbers.
        TrundleError: they do not begin at 0, or do not grow.
    """
    array = numbers(times, "times")
    if array.shape != (count,):
        raise ShapeError(
            f"times must have shape ({count},), one for each of the {count} points, "
            f"got {array.shape}"
        )
    if array[0] != 0:
        raise TrundleError(f"times must begin at 0 s, got {array[0]:g} s")
    if (back := np.flatnonzero(np.diff(array) < SMALLEST)).size:
        k = int(back[0])
        raise TrundleError(
            f"times must grow from point to point: point {k + 2} has {array[k + 1]:g} s, "
            f"after {array[k]:g} s"
        )
    return array
