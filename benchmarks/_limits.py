"""What the machine can do: bytes read, written and copied in a second, and operations.

Each limit is measured in the way that turns out fastest on the machine, with as many threads as
trundle takes: library calls for whole arrays, and compiled loops where numba is installed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np
from _batch_tasks import Numbers
from _common import Job

Ways = dict[str, Callable[..., None]]
FAST = {"contract", "nnan", "ninf", "nsz", "arcp", "reassoc"}
_POOL: list[ThreadPoolExecutor] = []


def threads() -> int:
    """Return how many threads trundle takes."""
    if find_spec("numba") is None:
        return os.cpu_count() or 1
    import numba

    return int(numba.get_num_threads())


def shared(part: Callable[..., Any], *arrays: Numbers) -> list[Any]:
    """Call a function that lets other threads run, for as many parts of arrays as threads."""
    if not _POOL:
        _POOL.append(ThreadPoolExecutor(threads()))
    bounds = np.linspace(0, len(arrays[0]), threads() + 1).astype(int) // 16 * 16
    parts = [[each[lo:hi] for each in arrays] for lo, hi in pairwise(bounds)]
    return list(_POOL[0].map(lambda each: part(*each), parts))


# ---- memory ----------------------------------------------------------------------------------


def _compiled() -> tuple[Any, Any, Any]:
    """Return loops that read, fill and copy, or library calls in their place."""
    if find_spec("numba") is None:
        return np.max, _fill, np.copyto
    import numba

    compiled = numba.njit(nogil=True, fastmath=FAST)

    def read(a: Any) -> Any:
        total = a[0]
        for i in range(len(a)):
            total += a[i]
        return total

    def fill(a: Any) -> None:
        value = a[0]
        for i in range(len(a)):
            a[i] = value

    def copy(a: Any, b: Any) -> None:
        for i in range(len(a)):
            a[i] = b[i]

    return compiled(read), compiled(fill), compiled(copy)


def _fill(a: Numbers) -> None:
    a.fill(1.5)


def _clear(a: Numbers) -> None:
    a.fill(0)


def reading(count: int, size: int) -> Job:
    """Return reading of ``size`` bytes for each of ``count`` robot-steps."""
    memory = np.ones(count * size // 4, np.float32)
    loop, _, _ = _compiled()
    return _fastest(
        {"loop": lambda: shared(loop, memory), "max": lambda: shared(np.max, memory)}, count, size
    )


def writing(count: int, size: int) -> Job:
    """Return writing of ``size`` bytes for each of ``count`` robot-steps."""
    memory = np.ones(count * size // 4, np.float32)
    _, loop, _ = _compiled()
    ways = {
        "loop": lambda: shared(loop, memory),
        "fill": lambda: shared(_fill, memory),
        "clear": lambda: shared(_clear, memory),
    }
    return _fastest(ways, count, size)


def copying(count: int, size: int) -> Job:
    """Return copying that reads and writes ``size`` bytes in all for each of ``count`` steps."""
    source, memory = np.ones((2, count * size // 8), np.float32)
    _, _, loop = _compiled()
    ways = {
        "loop": lambda: shared(loop, memory, source),
        "copyto": lambda: shared(np.copyto, memory, source),
    }
    return _fastest(ways, count, size)


def _fastest(ways: dict[str, Callable[[], Any]], count: int, size: int) -> Job:
    """Return the way that is fastest here; the answer is the bytes of a robot-step."""
    taken = {}
    for name, way in ways.items():
        way()
        times = []
        for _ in range(5):
            start = time.perf_counter()
            way()
            times.append(time.perf_counter() - start)
        taken[name] = sorted(times)[2]
    return Job("way()", {"way": ways[min(taken, key=taken.__getitem__)]}, [size], count)


# ---- arithmetic ------------------------------------------------------------------------------

TERMS = 8  # products and sums after each other: loads and stores are few beside them
NUMBERS, TIMES = 2048, 20_000  # in the nearest cache, and how often they are gone over


def arithmetic(dtype: str, smoke: bool) -> float:
    """Return operations in a second: products and sums, each pair fused where the machine can.

    Many polynomials by Horner's rule, which depend on nothing but themselves.
    """
    import numba

    number = np.dtype(dtype).type
    repeats = 20 if smoke else TIMES

    def horner(a: Any, scale: Any, shift: Any) -> None:
        for _ in range(repeats):
            for i in range(NUMBERS):
                x = a[i]
                # Written out, TERMS of them: of a loop no vectors would be made here.
                x = (x * scale + shift) * scale + shift
                x = (x * scale + shift) * scale + shift
                x = (x * scale + shift) * scale + shift
                x = (x * scale + shift) * scale + shift
                a[i] = x

    # Terms are not reordered: the compiler would leave some of them out.
    compiled = numba.njit(nogil=True, fastmath={"contract"})(horner)
    memory = np.ones(NUMBERS * threads(), number)
    rates = []
    for _ in range(6):
        start = time.perf_counter()
        shared(lambda a: compiled(a, number(0.999), number(0.001)), memory)
        rates.append(2 * TERMS * repeats * len(memory) / (time.perf_counter() - start))
    return max(rates[1:])
