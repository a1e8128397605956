"""How a block of robots writes the poses that are kept.

What goes beyond the caches is written past them, a line of memory at once: it need not be read
before, and what is in the caches stays there.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle.simulation.arithmetic import Function, Jit
from trundle.simulation.rollout.intrinsics import LINE, streaming

# Bytes that do not stay in a cache anyhow.
_BEYOND_CACHES = 2**24


def make_keep(dtype: str, part: Jit) -> Function:
    """Return (here, out, row, lo, hi, a, b): write a block's poses from a to b to a row of out.

    ``here`` is (K, width), the block's states, and ``out`` (rows, 3, N); the robots from lo to hi
    are the block's. Pieces of a block come in their order.

    Args:
        dtype: "float32" or "float64".
        part: the compiler of what becomes part of the loop: a function that is called would hold up
            the next piece until all is written.
    """
    address, size = streaming().address, np.dtype(dtype).itemsize
    many = _BEYOND_CACHES // size
    near, far = part(_near), part(_make_far(size, part))

    def keep(here: Any, out: Any, row: int, lo: int, hi: int, a: int, b: int) -> None:
        if out.size > many and address(out) % size == 0:
            far(here, out, row, lo, hi, a, b)
        else:
            near(here, out, row, lo, hi, a, b)

    return part(keep)


def _near(here: Any, out: Any, row: int, lo: int, hi: int, a: int, b: int) -> None:
    for k in range(3):
        to, of = out[row, k][lo:hi], here[k]
        for i in range(np.uintp(a), np.uintp(b)):
            to[i] = of[i]


def _make_far(size: int, part: Jit) -> Function:
    address, put_line, _ = streaming()
    line = LINE // size

    @part
    def copy(here: Any, out: Any, row: int, k: int, lo: int, a: int, b: int) -> None:
        for i in range(a, b):
            out[row, k, lo + i] = here[k, i]

    def far(here: Any, out: Any, row: int, lo: int, hi: int, a: int, b: int) -> None:
        for k in range(3):
            # Counted through both arrays: to make a view of a row takes as long as to write it.
            to, of = (3 * row + k) * out.shape[2] + lo, k * here.shape[1]
            # Lines of memory begin here; what this piece leaves of one, the next has.
            over = (address(out) // size + to) % line
            begin, end = a - (a + over) % line, b - (b + over) % line
            if begin < 0:
                begin += line
                copy(here, out, row, k, lo, 0, min(begin, b))
            for i in range(begin, end, line):
                put_line(out, to + i, here, of + i)
            if lo + b == hi:
                copy(here, out, row, k, lo, max(begin, end), b)

    return far
