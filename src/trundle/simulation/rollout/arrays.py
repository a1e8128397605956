"""The loop in numpy: for machines without a compiler, and as a second reading of the same step."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from trundle.simulation.arithmetic import Function, array_arithmetic, as_is
from trundle.simulation.rollout.loop import DONE, LOST, Arguments
from trundle.simulation.rollout.random import make_normals
from trundle.simulation.rollout.recipe import Recipe, make_advance
from trundle.simulation.rollout.reducers.moments import add_poses
from trundle.simulation.rollout.written import constants

# Robots computed together: so few that their arrays stay in the cache, so many that numpy's cost
# per call does not count.
_BLOCK = 8192


@cache
def _parts(recipe: Recipe) -> tuple[Function, Function, Function | None]:
    m = array_arithmetic(recipe.dtype)
    normals = make_normals(recipe.noise, m, as_is) if recipe.noisy else None
    return make_advance(recipe, m, as_is), constants(recipe.own), normals


def run(recipe: Recipe, given: Arguments) -> int:
    """Advance all robots, and tell how that ended; numpy reads turns of any size rightly."""
    for lo in range(0, given.state.shape[1], _BLOCK):
        # The random words wrap around, as they should; what is no number is told afterwards.
        with np.errstate(all="ignore"):
            _run_block(recipe, given, slice(lo, lo + _BLOCK))
    return DONE if np.isfinite(given.state[:3]).all() else LOST


def _run_block(recipe: Recipe, given: Arguments, block: slice) -> None:
    advance, constants_of, normals = _parts(recipe)
    state = tuple(given.state[:, block].copy())
    robots = np.arange(given.state.shape[1], dtype=np.uint32)[block]
    own = constants_of(given.shared, given.own[:, block], slice(None))
    noise: tuple[Any, ...] = ()
    for t in range(given.first, given.first + given.steps):
        commands = given.commands[t * given.moving]
        command = tuple(commands[:, 0] if recipe.common else commands[:, block])
        if normals is not None:
            noise = normals(given.key, robots, t)
        state, _ = advance(t, state, command, noise, own, given.table)
        if given.every and (t + 1) % given.every == 0:
            for k in range(3):
                given.out[(t + 1) // given.every, k, block] = state[k]
        if given.summed and (t + 1) % given.summed == 0:
            row = (t + 1) // given.summed - given.first // given.summed - 1
            add_poses(given.sums[0, row], np.stack(state[:3]))
    for row, values in zip(given.state, state, strict=True):
        row[block] = values
