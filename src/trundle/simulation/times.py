"""The times of a run."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

from trundle.errors import TrundleError
from trundle.se2 import Array

# A duration that misses a whole number of steps by less is that number: 0.1 is no binary number.
_WHOLE = 1e-9
# A run of this many steps fills 4 GB.
_MOST_STEPS = 2e7


def step_times(duration: float | None, dt: float, rows: int | None = None) -> Array:
    """Return the times (T + 1,) of a run; its last step is shorter where dt does not divide it.

    Args:
        duration: length of the run [s], or None where the commands tell it.
        dt: step [s].
        rows: number of rows of sampled commands, or None.

    Raises:
        TrundleError: a value is not usable.
    """
    if not (isinstance(dt, Real) and math.isfinite(dt) and dt > 0):
        raise TrundleError(f"dt must be a positive number of seconds, got {dt!r}")
    if duration is None:
        if rows is None:
            raise TrundleError("give a duration: these commands do not tell how long they last")
        return np.arange(rows + 1, dtype=np.float64) * dt
    if not (isinstance(duration, Real) and math.isfinite(duration) and duration > 0):
        raise TrundleError(f"duration must be a positive number of seconds, got {duration!r}")
    if duration / dt > _MOST_STEPS:
        raise TrundleError(
            f"{duration:g} s in steps of {dt:g} s are more than {_MOST_STEPS:g} steps: "
            "take longer steps"
        )
    steps = max(math.ceil(duration / dt - _WHOLE), 1)
    t = np.arange(steps + 1, dtype=np.float64) * dt
    t[-1] = duration
    return t
