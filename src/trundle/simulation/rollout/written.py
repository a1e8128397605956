"""Functions over tuples of a known length, written out.

A compiler makes vectors of ``(a[0, i], a[1, i])``, not of a loop over the rows; so the few
functions that differ only in how many rows there are, are written out for the number needed.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from trundle.simulation.arithmetic import Function


@cache
def _function(arguments: str, value: str) -> Function:
    made: Function = eval(f"lambda {arguments}: {value}")
    return made


def _tuple(item: str, count: int) -> str:
    return f"({''.join(item.format(k=k) + ', ' for k in range(count))})"


def row_slices(count: int) -> Function:
    """Return (array, lo, hi) -> the rows' parts, each contiguous."""
    return _function("a, lo, hi", _tuple("a[{k}][lo:hi]", count))


def step_slices(count: int) -> Function:
    """Return (array, t, lo, hi) -> the parts of the rows of step t."""
    return _function("a, t, lo, hi", _tuple("a[t, {k}][lo:hi]", count))


def step_values(count: int) -> Function:
    """Return (array, t, lo, hi) -> the values of step t, which all robots share."""
    return _function("a, t, lo, hi", _tuple("a[t, {k}, 0]", count))


def step_column(count: int) -> Function:
    """Return (array, t, i) -> the values of step t for robot i."""
    return _function("a, t, i", _tuple("a[t, {k}, i]", count))


def pick(count: int) -> Function:
    """Return (rows, i) -> the value i of each row of a tuple."""
    return _function("rows, i", _tuple("rows[{k}][i]", count))


def all_of(_: int) -> Function:
    """Return (rows, i) -> the rows, where they are values that all robots share."""
    return _function("rows, i", "rows")


def column(count: int) -> Function:
    """Return (array, i) -> the values of column i."""
    return _function("a, i", _tuple("a[{k}, i]", count))


def constants(own: tuple[bool, ...]) -> Function:
    """Return (shared, own, i) -> the constants of robot i, each from where it stands.

    Args:
        own: for each constant, whether every robot has its own: a row in the tuple ``own``.
    """
    places, counts = [], {False: 0, True: 0}
    for each in own:
        places.append(f"own[{counts[each]}][i]" if each else f"shared[{counts[each]}]")
        counts[each] += 1
    return _function("shared, own, i", f"({''.join(place + ', ' for place in places)})")


def put(count: int) -> Function:
    """Return (array, i, values): write the values into column i."""
    lines = "".join(f"    a[{k}, i] = values[{k}]\n" for k in range(count))
    names: dict[str, Any] = {}
    exec(f"def put(a, i, values):\n{lines or '    pass'}", names)
    made: Function = names["put"]
    return made


def dot(count: int) -> Function:
    """Return (row, start, values) -> the sum of row[start + k] values[k]."""
    terms = (f"row[start + {k}] * values[{k}]" for k in range(count))
    return _function("row, start, values", " + ".join(terms))


def scaled_sum(count: int) -> Function:
    """Return (a, b, c) -> a[k] + b[k] c[k]."""
    return _function("a, b, c", _tuple("a[{k}] + b[{k}] * c[{k}]", count))


def converted(count: int) -> Function:
    """Return (number, values) -> the values as numbers of a type."""
    return _function("number, values", _tuple("number(values[{k}])", count))
