"""The loop for the processor: blocks of robots, compiled and vectorised by numba.

A block's states lie in the nearest cache for all steps of a call; inside a step the loop goes over
its robots, whose numbers stand beside each other, so that one instruction serves many.
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
from trundle.simulation.rollout.loop import DONE, LOST, TOO_FAR, Arguments
from trundle.simulation.rollout.random import make_normals
from trundle.simulation.rollout.recipe import Recipe, make_advance
from trundle.simulation.rollout.threads import run_all, thread_count

# Sums are not reordered: that would undo the reduction of angles and the compensation of sums.
FAST = {"contract", "nsz", "arcp"}
# Robots in a block: few enough for the nearest cache, and more where commands are read, so that
# each row of them is a long run of memory.
_BLOCK, _READING = 256, 1024
# What keeps a block's rows from lying a power of two apart: the nearest cache has few places for
# such addresses.
_APART = 16
# States of so many numbers leave no room in the cache for long rows.
_MANY = 12
# Robot-steps that take longer than it takes to wake a thread.
_WORTH_SHARING = 20_000
# Parts that poses are summed in: as many threads can help, whereas each takes memory for its sums.
_LANES = 64


def read_bits() -> Function:
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


def choices() -> tuple[Function, Function, Function]:
    """Return the compiled functions (condition, yes, no), (a, b) -> the smaller, -> the larger.

    They are made of instructions that choose. Of Python's ``yes if condition else no`` the compiler
    makes branches where several have the same condition, and then no vectors. As in numpy, what
    meets a number that is none is none.
    """
    from numba import types
    from numba.extending import intrinsic

    def common(typing: Any, a: Any, b: Any) -> Any:
        """Return the type of both; a whole number does not widen a float."""
        if isinstance(a, types.Float) and not isinstance(b, types.Float):
            return a
        if isinstance(b, types.Float) and not isinstance(a, types.Float):
            return b
        return typing.unify_types(a, b)

    @intrinsic  # type: ignore[untyped-decorator]
    def where(typing: Any, condition: Any, yes: Any, no: Any) -> Any:
        to = common(typing, yes, no)

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            given = zip(arguments, signature.args, (types.boolean, to, to), strict=True)
            chosen, *both = (context.cast(builder, each, of, into) for each, of, into in given)
            return builder.select(chosen, *both)

        return to(condition, yes, no), generate

    def extreme(sign: str) -> Any:
        @intrinsic  # type: ignore[untyped-decorator]
        def choose(typing: Any, a: Any, b: Any) -> Any:
            to = common(typing, a, b)

            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                given = zip(arguments, signature.args, strict=True)
                first, second = (context.cast(builder, each, of, to) for each, of in given)
                if isinstance(to, types.Integer):
                    return builder.select(builder.icmp_signed(sign, first, second), first, second)
                none = builder.fcmp_unordered("uno", first, first)
                taken = builder.or_(builder.fcmp_ordered(sign, first, second), none)
                return builder.select(taken, first, second)

            return to(a, b), generate

        return choose

    return where, extreme("<"), extreme(">")


def block_size(recipe: Recipe) -> int:
    """Return how many robots a block holds."""
    reading = recipe.given and recipe.motion.arcs and recipe.state <= _MANY
    return _READING if reading else _BLOCK


def make_run(recipe: Recipe) -> Callable[[Arguments], int]:
    """Return the function that advances all robots, and tells how that ended."""
    loop, size = _compiled(recipe), block_size(recipe)

    def run(given: Arguments) -> int:
        count, lanes = given.state.shape[1], len(given.sums)
        small = _is_small(recipe, count, given.steps)
        if small and lanes == 1:
            return loop(0, count, 0, *given)  # type: ignore[no-any-return]
        threads, blocks = 1 if small else thread_count(), -(-count // size)
        # More pieces than threads, so that a thread that is held up holds up little; where sums
        # are made, as many as there are lanes, on any number of threads.
        pieces = lanes if recipe.spread else min(blocks, 4 * threads)
        edges = [size * (blocks * k // pieces) for k in range(pieces)] + [count]
        calls = [
            (lo, hi, k if recipe.spread else 0, *given)
            for k, (lo, hi) in enumerate(itertools.pairwise(edges))
        ]
        ends = run_all(loop, calls, threads)
        return TOO_FAR if TOO_FAR in ends else max(ends)

    return run


def _is_small(recipe: Recipe, count: int, steps: int) -> bool:
    """Whether a second thread would not help."""
    return count * steps < _WORTH_SHARING or count <= block_size(recipe)


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
    size = block_size(recipe)

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
    width = size + _APART
    fill_in = _make_noise(recipe, m, part)
    advance_all = _make_row_of_robots(recipe, m, bits, part)
    own_slices = part(written.row_slices(sum(recipe.own)))
    add_up, spread = _adder(), recipe.spread

    def block(
        lo: int, hi: int, lane: int, first: int, steps: int, commands: Any, moving: int,
        shared: Any, own: Any, table: Any, key: Any, state: Any, every: int, out: Any, sums: Any,
        summed: int,
    ) -> bool:  # fmt: skip
        count = hi - lo
        here, noise = np.empty((rows, width), number), np.empty((noise_rows, size), number)
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
