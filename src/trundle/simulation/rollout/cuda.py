"""The loop for a GPU: one thread for each robot, compiled by numba-cuda."""

from __future__ import annotations

from trundle.errors import TrundleError
from trundle.simulation.rollout.loop import Arguments
from trundle.simulation.rollout.recipe import Recipe


def check() -> None:
    """Refuse to run where there is no GPU.

    Raises:
        TrundleError: numba-cuda or the GPU is missing.
    """
    raise TrundleError("device 'cuda' needs a GPU and numba-cuda: pip install 'trundle[gpu]'")


def run(recipe: Recipe, given: Arguments) -> bool:
    """Advance all robots; return whether one turned too far in a step for the recipe."""
    raise NotImplementedError
