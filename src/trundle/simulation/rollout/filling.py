"""Random numbers of many robots, compiled: a row of them for each number."""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout import written
from trundle.simulation.rollout.random import make_normals_of, make_words


def make_fill(count: int, m: Arithmetic, part: Jit) -> Function:
    """Return (noise, words, key, first, a, b, t): fill in normal numbers, columns a to b.

    Column i of ``noise`` (count, width) is for robot first + i. Its words go to ``words``, of the
    same shape, before: in one loop, both would need more registers than there are.

    Args:
        count: how many numbers a robot gets, a multiple of 4.
        m: elementary functions.
        part: the compiler of what becomes part of a loop.
    """
    words_of, normals_of = make_words(count, m, part), make_normals_of(count, m, part)
    put, column = part(written.put(count)), part(written.column(count))

    def fill(noise: Any, words: Any, key: Any, first: int, a: int, b: int, t: int) -> None:
        for i in range(np.uintp(a), np.uintp(b)):
            put(words, i, words_of(key, first + np.intp(i), t))
        for i in range(np.uintp(a), np.uintp(b)):
            put(noise, i, normals_of(column(words, i)))

    return part(fill)
