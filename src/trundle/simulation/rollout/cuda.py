"""The loop for a GPU: one thread for each robot, compiled by numba-cuda.

A robot's state stays in the registers of its thread for all steps of a launch. Robots lie beside
each other along the last axis, so that neighbouring threads read and write neighbouring numbers.
"""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.simulation.arithmetic import Function, gpu_arithmetic
from trundle.simulation.rollout import written
from trundle.simulation.rollout.loop import DONE, LOST, Arguments
from trundle.simulation.rollout.memory import in_words
from trundle.simulation.rollout.random import make_normals
from trundle.simulation.rollout.recipe import Recipe, make_advance

try:
    # A name of the module: numba's simulator puts its own ``cuda`` in the place of that.
    from numba import cuda
except ImportError:  # ``check`` tells
    cuda = None

# Threads in a group: a few of the GPU's bundles of 32, so that many registers are left to each.
_THREADS = 128
# Bytes of commands and kept poses that lie on the GPU at once, where they come from the host or go
# there: enough to make the transfer's own cost small.
_AT_ONCE = 2**28


def check() -> None:
    """Refuse to run where there is no GPU.

    Raises:
        TrundleError: numba-cuda or the GPU is missing; the message says which.
    """
    if any(importlib.util.find_spec(name) is None for name in ("numba", "numba_cuda")):
        raise TrundleError(
            "device 'cuda' compiles its loops with numba-cuda: pip install 'trundle[gpu]'"
        )
    if not cuda.is_available():
        why = " ".join(str(cuda.cuda_error() or "the driver found none").split())
        raise TrundleError(f"device 'cuda' needs an NVIDIA GPU with its driver: {why}")


def is_on_device(array: object) -> bool:
    """Whether an array lies in a GPU's memory, whichever library made it."""
    # The simulator's arrays have the method of numba's, and no interface to share.
    return hasattr(array, "__cuda_array_interface__") or hasattr(array, "copy_to_host")


def as_device_array(array: Any) -> Any:
    """Return numba's view of an array in a GPU's memory; nothing is copied."""
    return array if hasattr(array, "copy_to_host") else cuda.as_cuda_array(array)


def run(recipe: Recipe, given: Arguments) -> int:
    """Advance all robots; a GPU's functions are right for turns of any size.

    ``given.out`` may lie in the GPU's memory: then the poses that are kept stay there.
    """
    out_stays = is_on_device(given.out)
    out: Any = as_device_array(given.out) if out_stays else given.out
    _ask_for_memory(given, out_stays)
    held = None if given.moving else _to_device(given.commands)
    shared, own, table, key, state = map(
        _to_device, (given.shared, given.own, given.table, given.key, given.state)
    )
    groups = -(-given.state.shape[1] // _THREADS)
    for first, steps in _slices(given, out_stays):
        last, every = first + steps, given.every
        commands = _to_device(given.commands[first:last]) if held is None else held
        # The rows that are due; the start's is not the loop's to write.
        lo, hi = (first // every + 1, last // every + 1) if every else (0, 0)
        if out_stays and hi > lo:
            rows = out[lo:hi]
        else:
            rows = cuda.device_array((hi - lo, *out.shape[1:]), out.dtype)
        # Steps to go to the next row: a counter is cheaper than a remainder. None if it is 0.
        wait = every - first % every if every else 0
        with warnings.catch_warnings():
            # A hint of numba's that few robots leave a GPU idle.
            warnings.filterwarnings("ignore", message="Grid size", category=Warning)
            _compiled(recipe)[groups, _THREADS](
                first, steps, commands, given.moving, shared, own, table, key, state, wait, every,
                rows,
            )  # fmt: skip
        if hi > lo and not out_stays:
            rows.copy_to_host(out[lo:hi])
    given.state[...] = state.copy_to_host()
    return DONE if np.isfinite(given.state[:3]).all() else LOST


def _to_device(array: Any) -> Any:
    # The strides of axes of length 1, which are arbitrary, are part of what numba compiles for.
    return cuda.to_device(np.ascontiguousarray(array).ravel().reshape(array.shape))


def _bytes_per_step(given: Arguments, out_stays: bool) -> float:
    """Return how many bytes of commands and kept poses a step moves to and from the GPU."""
    commands = given.commands[0].nbytes if given.moving else 0
    kept = 0.0 if out_stays or not given.every else given.state[:3].nbytes / given.every
    return commands + kept


def _slices(given: Arguments, out_stays: bool) -> Iterator[tuple[int, int]]:
    """Yield first step and number of steps of each launch."""
    at_once = max(int(_AT_ONCE / max(_bytes_per_step(given, out_stays), 1)), 1)
    for first in range(given.first, given.first + given.steps, at_once):
        yield first, min(at_once, given.first + given.steps - first)


def _ask_for_memory(given: Arguments, out_stays: bool) -> None:
    """Refuse to take more of the GPU's memory than is free.

    Raises:
        TrundleError: there is less; the message says how much is needed, and how much there is.
    """
    stay = (given.shared, given.own, given.table, given.key, given.state)
    size = sum(array.nbytes for array in stay) + (0 if given.moving else given.commands.nbytes)
    per_step = _bytes_per_step(given, out_stays)
    size += int(min(max(_AT_ONCE, per_step), per_step * given.steps))
    free = cuda.current_context().get_memory_info()[0]
    if size > free:
        raise TrundleError(
            f"the rollout would take {in_words(size)} of the GPU's memory, and {in_words(free)} "
            "are free: roll out fewer robots at once, or take dtype='float32'"
        )


@cache
def _compiled(recipe: Recipe) -> Any:
    return cuda.jit(make_kernel(recipe))


def make_kernel(recipe: Recipe) -> Function:
    """Return what one thread does: a robot's steps.

    It takes (first, steps, commands, moving, shared, own, table, key, state, wait, every, out):
    what ``Arguments`` has, where commands and out begin with the first step's; after ``wait`` steps
    the first row of out is due. It can be compiled for a GPU that is not at hand.
    """

    def part(function: Any) -> Any:
        return cuda.jit(function, device=True, inline="always")

    m = gpu_arithmetic(recipe.dtype, part)
    advance, apart = make_advance(recipe, m, part), int(not recipe.common)
    load, store = part(written.column(recipe.state)), part(written.put(recipe.state))
    given_of = part(written.step_column(recipe.given))
    constants_of = part(written.constants(recipe.own))
    normals = part(lambda key, i, t: ())  # noqa: ARG005
    if recipe.noisy:
        normals = make_normals(recipe.noise, m, part)

    def kernel(
        first: int, steps: int, commands: Any, moving: int, shared: Any, own: Any, table: Any,
        key: Any, state: Any, wait: int, every: int, out: Any,
    ) -> None:  # fmt: skip
        i = cuda.grid(1)
        if i < state.shape[1]:
            now, constants, row = load(state, i), constants_of(shared, own, i), 0
            for t in range(first, first + steps):
                given = given_of(commands, (t - first) * moving, i * apart)
                now, _ = advance(t, now, given, normals(key, i, t), constants, table)
                wait -= 1
                if wait == 0:
                    out[row, 0, i] = now[0]
                    out[row, 1, i] = now[1]
                    out[row, 2, i] = now[2]
                    row += 1
                    wait = every
            store(state, i, now)

    return kernel
