"""Compiled loops shared out among threads; they let each other run."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

from trundle.simulation.arithmetic import Function


def thread_count() -> int:
    """Return how many threads numba would take, so that its settings hold here too."""
    import numba

    return int(numba.get_num_threads())


def run_all(function: Function, calls: Sequence[tuple[Any, ...]], threads: int) -> list[Any]:
    """Return the results of calls, in any order: each thread takes the next one that is left.

    The calling thread takes part: to wake another one costs more than a small call.
    """
    left = iter(calls)
    helpers = min(threads, len(calls)) - 1
    running = [_pool().submit(_take, function, left) for _ in range(helpers)]
    results = _take(function, left)
    for each in running:
        results += each.result()
    return results


def _take(function: Function, left: Iterator[tuple[Any, ...]]) -> list[Any]:
    return [function(*call) for call in left]


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="rollout")


if hasattr(os, "register_at_fork"):
    # A child process has none of the threads that its parent's pool counts on.
    os.register_at_fork(after_in_child=_pool.cache_clear)
