"""Long curves, thinned to what a picture can show."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from trundle.se2 import Array

Indices = npt.NDArray[np.intp]

_MOST = 4000  # more points than a picture has pixels across


def thin(values: Array) -> Indices:
    """Return which (k,) of the values (T,) of a curve to draw, at most some 4000, in order.

    Of each stretch of values its least and its largest are kept, so that no peak is lost.

    >>> values = np.zeros(100_000)
    >>> values[31_415] = 1.0
    >>> kept = thin(values)
    >>> len(kept) <= 4100, 31_415 in kept
    (True, True)
    """
    count = len(values)
    if count <= _MOST:
        return np.arange(count)
    size = -(-2 * count // _MOST)
    whole = count // size * size
    blocks = values[:whole].reshape(-1, size)
    starts = np.arange(0, whole, size)
    found = [starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1)]
    return np.unique(np.concatenate([[0], *found, np.arange(whole, count), [count - 1]]))


def spread(count: int) -> Indices:
    """Return which (k,) of the points of a path to draw: at most some 4000, and the last.

    >>> spread(3).tolist(), len(spread(60_000))
    ([0, 1, 2], 4001)
    """
    every = np.arange(0, count, max(-(-count // _MOST), 1))
    return np.unique(np.append(every, count - 1))


def stretches(t: Array, marked: Array) -> list[tuple[float, float]]:
    """Return where a mark holds, as (start, length) in time; gaps too short to see are closed.

    Args:
        t: (T + 1,) times [s].
        marked: (T,) whether it holds from each time to the next.

    >>> stretches(np.arange(5.0), np.array([True, True, False, True]))
    [(0.0, 2.0), (3.0, 1.0)]
    """
    change = np.diff(np.concatenate([[0], np.asarray(marked, dtype=np.int8), [0]]))
    starts, ends = t[np.flatnonzero(change == 1)], t[np.flatnonzero(change == -1)]
    apart = starts[1:] - ends[:-1] > (t[-1] - t[0]) / _MOST
    starts = starts[np.concatenate([[True], apart])] if len(starts) else starts
    ends = ends[np.concatenate([apart, [True]])] if len(ends) else ends
    return [(float(a), float(b - a)) for a, b in zip(starts, ends, strict=True)]
