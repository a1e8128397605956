"""What a rollout runs on."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from trundle.errors import SpeedWarning, TrundleError
from trundle.simulation.arithmetic import Function
from trundle.simulation.rollout.loop import Arguments
from trundle.simulation.rollout.recipe import Recipe

DEVICES = ("auto", "numpy", "cpu", "cuda")


def choose(device: str) -> str:
    """Return what to run on: "numpy", "cpu" or "cuda".

    Raises:
        TrundleError: the device is not known, or not there.
    """
    if not isinstance(device, str) or device not in DEVICES:
        raise TrundleError(f"device must be one of {', '.join(DEVICES)}, got {device!r}")
    if device == "auto":
        if has_numba():
            return "cpu"
        _tell_how()
        return "numpy"
    if device == "cpu" and not has_numba():
        raise TrundleError(f"device 'cpu' compiles its loops with numba: {_INSTALL}")
    if device == "cuda":
        from trundle.simulation.rollout import cuda

        cuda.check()
    return device


def make_run(device: str, recipe: Recipe) -> Callable[[Arguments], int]:
    """Return the function that advances all robots, and tells how that ended: see ``loop``."""
    # Imported here: compilers load when they are first used.
    if device == "cpu":
        from trundle.simulation.rollout import cpu

        return cpu.make_run(recipe)
    if device == "cuda":
        from trundle.simulation.rollout import cuda

        return partial(cuda.run, recipe)
    from trundle.simulation.rollout import arrays

    return partial(arrays.run, recipe)


def whole_loop(device: str, recipe: Recipe, count: int, steps: int) -> Function | None:
    """Return the compiled loop over the robots from lo to hi, where it is best run in one piece.

    It takes lo, hi and a lane before the ``Arguments``, each by itself.
    """
    if device == "cpu":
        from trundle.simulation.rollout import cpu

        return cpu.whole_loop(recipe, count, steps)
    return None


def as_array(device: str, out: Any) -> Any:
    """Return an array for poses, in the memory of this machine or of its GPU."""
    if device == "cuda" and not isinstance(out, np.ndarray):
        from trundle.simulation.rollout import cuda

        return cuda.as_device_array(out) if cuda.is_on_device(out) else out
    return out if isinstance(out, np.ndarray) else None


def lanes(device: str, recipe: Recipe, count: int) -> int:
    """Return how many lanes a device deals robots into, where it sums their poses.

    Raises:
        TrundleError: it cannot sum them.
    """
    if device == "cpu":
        from trundle.simulation.rollout import cpu

        return cpu.lanes(recipe, count)
    if device == "cuda":
        raise TrundleError("Spread is not there for device 'cuda': take 'cpu'")
    return 1


_INSTALL = "pip install 'trundle[fast]'"


def has_numba() -> bool:
    """Whether loops can be compiled."""
    return importlib.util.find_spec("numba") is not None


@cache
def _tell_how() -> None:
    warnings.warn(
        f"rollouts run in numpy, ten or more times slower than compiled: {_INSTALL}",
        SpeedWarning,
        stacklevel=4,
    )
