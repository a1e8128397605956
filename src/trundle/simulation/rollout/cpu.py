"""The loop for the processor: blocks of robots, compiled and vectorised by numba.

A block's states lie in the nearest cache for all steps of a call; inside a step the loop goes over
its robots, whose numbers stand beside each other, so that one instruction serves many.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
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
from trundle.simulation.rollout.loop import Arguments
from trundle.simulation.rollout.random import make_normals
from trundle.simulation.rollout.recipe import Recipe, make_advance

# Sums are not reordered: that would undo the reduction of angles and the compensation of sums.
FAST = {"contract", "nnan", "ninf", "nsz", "arcp"}
# Robots in a block: few enough for the nearest cache, and more where commands are read, so that
# each row of them is a long run of memory.
_BLOCK, _READING = 256, 1024
# Robot-steps that take longer than it takes to wake a thread.
_WORTH_SHARING = 20_000


def _intrinsics() -> Function:
    """Return the compiled function that reads a number's bits as an integer, and back."""
    from numba import types
    from numba.extending import intrinsic

    read_as = {
        types.float32: types.int32,
        types.float64: types.int64,
        types.int32: types.float32,
        types.int64: types.float64,
    }

    @intrinsic  # type: ignore[untyped-decorator]
    def bits(_: Any, value: Any) -> Any:
        to = read_as[value]

        def generate(context: Any, builder: Any, __: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], context.get_value_type(to))

        return to(value), generate

    made: Function = bits
    return made


def block_size(recipe: Recipe) -> int:
    """Return how many robots a block holds."""
    return _READING if recipe.given and recipe.motion.arcs else _BLOCK


def run(recipe: Recipe, given: Arguments) -> bool:
    """Advance all robots; return whether one turned too far in a step for the recipe."""
    loop, count, size = _compiled(recipe), given.state.shape[1], block_size(recipe)
    blocks = -(-count // size)
    if count * given.steps < _WORTH_SHARING or blocks == 1 or (threads := _threads()) == 1:
        return bool(loop(0, count, *given))
    # More pieces than threads, so that a thread that is held up holds up little.
    pieces = min(blocks, 4 * threads)
    bounds = [size * (blocks * k // pieces) for k in range(pieces)] + [count]
    pool = _pool(threads)
    running = [pool.submit(loop, lo, hi, *given) for lo, hi in itertools.pairwise(bounds)]
    too_far = [future.result() for future in running]
    return any(too_far)


def _threads() -> int:
    """Return how many threads numba would take, so that its settings hold here too."""
    import numba

    return int(numba.get_num_threads())


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="rollout")


@cache
def _compiled(recipe: Recipe) -> Function:
    """Return the loop over the robots from lo to hi; it lets other threads run meanwhile."""
    import numba

    def part(function: Any) -> Any:
        return numba.njit(inline="always", fastmath=FAST, error_model="numpy")(function)

    block = numba.njit(fastmath=FAST, error_model="numpy")(_make_block(recipe, part))
    size = block_size(recipe)

    @numba.njit(error_model="numpy", nogil=True)  # type: ignore[untyped-decorator]
    def loop(
        lo: int, hi: int, first: int, steps: int, commands: Any, moving: int, shared: Any, own: Any,
        table: Any, key: Any, state: Any, every: int, out: Any,
    ) -> bool:  # fmt: skip
        too_far = False
        for start in range(lo, hi, size):
            too_far |= block(
                start, min(hi, start + size), first, steps, commands, moving, shared, own, table,
                key, state, every, out,
            )  # fmt: skip
        return too_far

    made: Function = loop
    return made


def _make_block(recipe: Recipe, part: Jit) -> Function:
    """Return the function that advances the robots from lo to hi, a block, by some steps."""
    bits = _intrinsics()
    m = compiled_arithmetic(recipe.dtype, part, bits, recipe.wide)
    number, _ = number_and_integer(recipe.dtype)
    rows, size, noise_rows = recipe.state, block_size(recipe), recipe.noise
    fill_in = _make_noise(recipe, m, part)
    advance_all = _make_row_of_robots(recipe, m, bits, part)
    own_slices = part(written.row_slices(sum(recipe.own)))

    def block(
        lo: int, hi: int, first: int, steps: int, commands: Any, moving: int, shared: Any, own: Any,
        table: Any, key: Any, state: Any, every: int, out: Any,
    ) -> bool:  # fmt: skip
        count = hi - lo
        here, noise = np.empty((rows, size), number), np.empty((noise_rows, size), number)
        for k in range(rows):
            here[k, :count] = state[k, lo:hi]
        own_rows = own_slices(own, lo, hi)
        too_far = False
        for t in range(first, first + steps):
            fill_in(noise, key, lo, count, t)
            too_far |= advance_all(
                here, noise, commands, moving, lo, hi, t, shared, own_rows, table
            )
            if every > 0 and (t + 1) % every == 0:
                for k in range(3):
                    row = out[(t + 1) // every, k][lo:hi]
                    for i in range(count):
                        row[i] = here[k, i]
        for k in range(rows):
            state[k, lo:hi] = here[k, :count]
        return too_far

    return block


def _make_noise(recipe: Recipe, m: Arithmetic, part: Jit) -> Function:
    """Return (noise, key, lo, count, t): fill in the random numbers of a step.

    It is a loop of its own: with the step it would need more registers than there are.
    """
    if not recipe.noisy:
        return part(lambda noise, key, lo, count, t: None)  # noqa: ARG005
    normals, put = make_normals(recipe.noise, m, part), part(written.put(recipe.noise))

    def fill_in(noise: Any, key: Any, lo: int, count: int, t: int) -> None:
        for i in range(count):
            put(noise, i, normals(key, lo + i, t))

    return part(fill_in)


def _make_row_of_robots(recipe: Recipe, m: Arithmetic, bits: Function, part: Jit) -> Function:
    """Return the function that advances a block by one step: the loop that is made of vectors."""
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
        here: Any, noise: Any, commands: Any, moving: int, lo: int, hi: int, t: int, shared: Any,
        own_rows: Any, table: Any,
    ) -> bool:  # fmt: skip
        given = slices(commands, t * moving, lo, hi)
        left = integer(0)
        for i in range(hi - lo):
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
