"""The loop for the processor: blocks of robots, compiled and vectorised by numba.

A block's states lie in the nearest caches for all steps of a call; inside a step the loop goes over
its robots, whose numbers stand beside each other, so that one instruction serves many.

Where poses are kept, blocks are long, so that long runs of memory are written, and a step goes over
them piece by piece: what a piece has come to is written while the next one is computed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from trundle.simulation.arithmetic import (
    LARGEST_SQUARE,
    Arithmetic,
    Function,
    Jit,
    compiled_arithmetic,
    number_and_integer,
)
from trundle.simulation.rollout import written
from trundle.simulation.rollout.filling import make_fill
from trundle.simulation.rollout.intrinsics import choices, read_bits, streaming
from trundle.simulation.rollout.keeping import make_keep
from trundle.simulation.rollout.loop import DONE, LOST, TOO_FAR, Arguments
from trundle.simulation.rollout.recipe import Recipe, make_advance
from trundle.simulation.rollout.threads import run_all, thread_count

# Sums are not reordered: that would undo the reduction of angles and the compensation of sums.
FAST = {"contract", "nsz", "arcp"}
# Robots in a block: few enough for the nearest cache; more where commands are read, so that each
# row of them is a long run of memory; and many where poses are kept, in pieces of the first size.
_BLOCK, _READING, _KEEPING = 256, 1024, 4096
# What keeps a block's rows from lying a power of two apart: the nearest cache has few places for
# such addresses.
_APART = 16
# States of so many numbers, or random numbers, leave no room in the cache for long rows.
_MANY = 12
# Robot-steps that take longer than it takes to wake a thread.
_WORTH_SHARING = 20_000
# Parts that poses are summed in: as many threads can help, whereas each takes memory for its sums.
_LANES = 64


def block_size(recipe: Recipe) -> int:
    """Return how many robots a block holds."""
    many = recipe.noisy or recipe.state > _MANY
    reading = recipe.given and recipe.motion.arcs and not many
    return _KEEPING if recipe.keeps else _READING if reading else _BLOCK


def make_run(recipe: Recipe) -> Callable[[Arguments], int]:
    """Return the function that advances all robots, and tells how that ended."""
    loop, size = _compiled(recipe), min(block_size(recipe), _READING)

    def run(given: Arguments) -> int:
        count, lanes = given.state.shape[1], len(given.sums)
        small = _is_small(recipe, count, given.steps)
        if small and lanes == 1:
            return loop(0, count, 0, *given)  # type: ignore[no-any-return]
        threads, blocks = 1 if small else thread_count(), -(-count // size)
        # More parts than threads, so that a thread that is held up holds up little; where sums
        # are made, as many as there are lanes, on any number of threads.
        parts = lanes if recipe.spread else min(blocks, 4 * threads)
        edges = [size * (blocks * k // parts) for k in range(parts)] + [count]
        calls = [
            (lo, hi, k if recipe.spread else 0, *given)
            for k, (lo, hi) in enumerate(itertools.pairwise(edges))
        ]
        ends = run_all(loop, calls, threads)
        return TOO_FAR if TOO_FAR in ends else max(ends)

    return run


def _is_small(recipe: Recipe, count: int, steps: int) -> bool:
    """Whether a second thread would not help."""
    return count * steps < _WORTH_SHARING or count <= min(block_size(recipe), _READING)


def whole_loop(recipe: Recipe, count: int, steps: int) -> Function | None:
    """Return the loop, where so much is best done in one piece: see ``devices``."""
    return _compiled(recipe) if _is_small(recipe, count, steps) else None


def lanes(recipe: Recipe, count: int) -> int:
    """Return how many lanes the robots are dealt into for sums over all of them."""
    return min(-(-count // block_size(recipe)), _LANES)


@cache
def _compiled(recipe: Recipe) -> Function:
    """Return the loop over the robots from lo to hi; it lets other threads run meanwhile."""
    import numba

    def part(function: Any) -> Any:
        return numba.njit(inline="always", fastmath=FAST, error_model="numpy")(function)

    block = numba.njit(fastmath=FAST, error_model="numpy")(_make_block(recipe, part))
    size, finish = block_size(recipe), streaming().finish

    @numba.njit(error_model="numpy", nogil=True)  # type: ignore[untyped-decorator]
    def loop(
        lo: int, hi: int, lane: int, first: int, steps: int, commands: Any, moving: int,
        shared: Any, own: Any, table: Any, key: Any, state: Any, every: int, out: Any, sums: Any,
        summed: int,
    ) -> int:  # fmt: skip
        too_far = False
        for start in range(lo, hi, size):
            too_far |= block(
                start, min(hi, start + size), lane, first, steps, commands, moving, shared, own,
                table, key, state, every, out, sums, summed,
            )  # fmt: skip
        finish()
        if too_far:
            return TOO_FAR
        # What is no number stays none: it is enough to look once, when all steps are made.
        for k in range(3):
            for i in range(lo, hi):
                if not math.isfinite(state[k, i]):
                    return LOST
        return DONE

    made: Function = loop
    return made


def _make_block(recipe: Recipe, part: Jit) -> Function:
    """Return the function that advances the robots from lo to hi, a block, by some steps."""
    bits = read_bits()
    m = compiled_arithmetic(recipe.dtype, part, bits, recipe.wide, choices())
    number, _ = number_and_integer(recipe.dtype)
    rows, size, noise_rows = recipe.state, block_size(recipe), recipe.noise
    width, piece = size + _APART, _BLOCK if recipe.keeps else size
    fill_in = part(lambda noise, words, key, lo, a, b, t: None)  # noqa: ARG005
    if recipe.noisy:
        fill_in = make_fill(noise_rows, m, part)
    advance_all = _make_row_of_robots(recipe, m, bits, part)
    own_slices = part(written.row_slices(sum(recipe.own)))
    add_up, spread = _adder(), recipe.spread
    keep, keeps = make_keep(recipe.dtype, part), recipe.keeps

    def block(
        lo: int, hi: int, lane: int, first: int, steps: int, commands: Any, moving: int,
        shared: Any, own: Any, table: Any, key: Any, state: Any, every: int, out: Any, sums: Any,
        summed: int,
    ) -> bool:  # fmt: skip
        count = hi - lo
        here, noise = np.empty((rows, width), number), np.empty((noise_rows, size), number)
        words = np.empty((noise_rows, size), np.uint32)
        for k in range(rows):
            here[k, :count] = state[k, lo:hi]
        own_rows = own_slices(own, lo, hi)
        too_far = False
        for t in range(first, first + steps):
            for a in range(0, count, piece):
                b = min(a + piece, count)
                fill_in(noise, words, key, lo, a, b, t)
                too_far |= advance_all(
                    here, noise, commands, moving, lo, hi, a, b, t, shared, own_rows, table
                )
                if keeps and every > 0 and (t + 1) % every == 0:
                    keep(here, out, (t + 1) // every, lo, hi, a, b)
            if spread and (t + 1) % summed == 0:
                add_up(here, count, sums, lane, (t + 1) // summed - first // summed - 1)
        for k in range(rows):
            state[k, lo:hi] = here[k, :count]
        return too_far

    return block


@cache
def _adder() -> Function:
    """Return (here, count, sums, lane, row): add a block's poses to a row of sums.

    What a row is, ``reducers.moments`` tells. These sums are reordered, so that they are made
    several robots at once.
    """
    import numba

    @numba.njit(fastmath=FAST | {"reassoc"}, error_model="numpy")  # type: ignore[untyped-decorator]
    def add_up(here: Any, count: int, sums: Any, lane: int, row: int) -> None:
        x, y, psi, total = here[0], here[1], here[2], sums[lane, row]
        if total[0] == 0:
            total[1], total[2], total[3] = x[0], y[0], psi[0]
        total[0] += count
        x_first, y_first, psi_first = total[1], total[2], total[3]
        sx = sy = sp = sxx = sxy = sxp = syy = syp = spp = 0.0
        for i in range(count):
            dx, dy, dp = x[i] - x_first, y[i] - y_first, psi[i] - psi_first
            sx += dx
            sy += dy
            sp += dp
            sxx += dx * dx
            sxy += dx * dy
            sxp += dx * dp
            syy += dy * dy
            syp += dy * dp
            spp += dp * dp
        for k, each in enumerate((sx, sy, sp, sxx, sxy, sxp, syy, syp, spp)):
            total[4 + k] += each

    made: Function = add_up
    return made


def _make_row_of_robots(recipe: Recipe, m: Arithmetic, bits: Function, part: Jit) -> Function:
    """Return the function that advances a block's robots from a to b by one step.

    Its loop is the one that is made of vectors.
    """
    number, integer = number_and_integer(recipe.dtype)
    advance = make_advance(recipe, m, part)
    load, store = part(written.column(recipe.state)), part(written.put(recipe.state))
    constants_of, noise_of = part(written.constants(recipe.own)), part(written.column(recipe.noise))
    if recipe.common:
        slices, pick = part(written.step_values(recipe.given)), part(written.all_of(recipe.given))
    else:
        slices, pick = part(written.step_slices(recipe.given)), part(written.pick(recipe.given))
    furthest, watched = number(LARGEST_SQUARE), recipe.watched

    def row_of_robots(
        here: Any, noise: Any, commands: Any, moving: int, lo: int, hi: int, a: int, b: int, t: int,
        shared: Any, own_rows: Any, table: Any,
    ) -> bool:  # fmt: skip
        given = slices(commands, t * moving, lo, hi)
        left = integer(0)
        # Unsigned: each index that might be negative would be looked at, and no vectors made.
        for i in range(np.uintp(a), np.uintp(b)):
            new, half = advance(
                t, load(here, i), pick(given, i), noise_of(noise, i),
                constants_of(shared, own_rows, i), table,
            )  # fmt: skip
            store(here, i, new)
            if watched:
                # Negative, as its sign bit says, once a turn is beyond the limit.
                left = integer(left | bits(furthest - half * half))
        return bool(left < 0)

    return part(row_of_robots)
