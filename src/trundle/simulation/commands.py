"""Commands over time: constant, one row per step, or a function of time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.kinematics import finite
from trundle.se2 import Array

Command = npt.ArrayLike | Callable[[Any], npt.ArrayLike]


class Samples(NamedTuple):
    """A command at the start, the middle and the end of each step, each (T, k)."""

    start: Array
    middle: Array
    end: Array


def length(command: Command | None, name: str) -> int | None:
    """Return the number of rows of a sampled command, None for the other forms."""
    if command is None or callable(command):
        return None
    array = finite(command, name)
    return len(array) if array.ndim == 2 else None


def sample(command: Command, t: Array, width: int, name: str) -> Samples:
    """Return a command over the steps between the times t (T + 1,).

    Args:
        command: (k,) held throughout; (T, k) held over each step; or a function of a time or an
            array of times that returns (..., k).
        t: (T + 1,) times [s].
        width: k.
        name: what the command is, for messages.

    Raises:
        ShapeError: the command has the wrong shape or values that are not finite.
    """
    if callable(command):
        start = _call(command, t, width, name)
        middle = _call(command, (t[:-1] + t[1:]) / 2, width, name)
        return Samples(start[:-1], middle, start[1:])
    held = finite(command, name)
    if held.shape not in ((width,), (len(t) - 1, width)):
        raise ShapeError(
            f"{name} must have shape ({width},) or ({len(t) - 1}, {width}), one row per step, "
            f"got {held.shape}"
        )
    held = np.broadcast_to(held, (len(t) - 1, width))
    return Samples(held, held, held)


def _call(function: Callable[[Any], npt.ArrayLike], t: Array, width: int, name: str) -> Array:
    """Return a function's values at all times: in one call where it takes arrays of times."""
    # With as many times as values nobody can tell rows from columns.
    together = _try(function, t) if len(t) != width else None
    if together is not None and together.shape == (len(t), width):
        ends = [finite(function(float(t[i])), name) for i in (0, -1)]
        if np.array_equal(together[0], ends[0]) and np.array_equal(together[-1], ends[1]):
            return together if np.isfinite(together).all() else finite(together, name)
    rows = [finite(function(float(time)), name) for time in t]
    for time, row in zip(t, rows, strict=True):
        if row.shape != (width,):
            raise ShapeError(
                f"{name} at t = {time:g} s must have shape ({width},), got {row.shape}"
            )
    return np.array(rows).reshape(len(t), width)


def _try(function: Callable[[Any], npt.ArrayLike], t: Array) -> Array | None:
    """Return what a function gives for all times at once, or None where it takes one time only."""
    try:
        return np.asarray(function(t), dtype=np.float64)
    except Exception:  # noqa: BLE001  a user's function may fail in any way on an array of times
        return None
