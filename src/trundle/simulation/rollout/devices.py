"""What a rollout runs on."""

from __future__ import annotations

import importlib.util
import warnings
from functools import cache

from trundle.errors import SpeedWarning, TrundleError
from trundle.simulation.rollout.loop import Arguments
from trundle.simulation.rollout.recipe import Recipe

DEVICES = ("auto", "numpy", "cpu", "cuda")


def choose(device: str) -> str:
    """Return what to run on: "numpy", "cpu" or "cuda".

    Raises:
        TrundleError: the device is not known, or not there.
    """
    if device not in DEVICES:
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


def run(device: str, recipe: Recipe, given: Arguments) -> bool:
    """Advance all robots; return whether one turned too far in a step for the recipe."""
    # Imported here: compilers load when they are first used.
    if device == "cpu":
        from trundle.simulation.rollout import cpu

        return cpu.run(recipe, given)
    if device == "cuda":
        from trundle.simulation.rollout import cuda

        return cuda.run(recipe, given)
    from trundle.simulation.rollout import arrays

    return arrays.run(recipe, given)


_INSTALL = "pip install 'trundle[fast]'"


def has_numba() -> bool:
    """Whether loops can be compiled."""
    return importlib.util.find_spec("numba") is not None


@cache
def _tell_how() -> None:
    warnings.warn(
        f"rollouts run in numpy, some twenty times slower than compiled: {_INSTALL}",
        SpeedWarning,
        stacklevel=4,
    )
