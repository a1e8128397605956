"""Motions and angles in words that a person understands."""

from __future__ import annotations

import math

import numpy as np

from trundle.se2 import Array

# Below a thousandth of a motion a component is not worth a word.
_SMALL = 1e-3


def motion_in_words(twist: Array) -> str:
    """Return a twist's direction as a motion: along a line, or a turn about a point.

    >>> motion_in_words(np.array([1.0, 0.0, 0.0]))
    'straight forward and back'
    >>> motion_in_words(np.array([0.0, -0.5, 1.0]))
    'turning about the point (0.5, 0) m'
    """
    u, v, r = (float(value) for value in twist)
    speed = math.hypot(u, v)
    if abs(r) <= _SMALL * speed:
        return _line(math.degrees(math.atan2(v, u)) % 180)
    centre = np.array([-v / r, u / r])
    if math.hypot(*centre) <= _SMALL:
        return "turning on the spot"
    x, y = (f"{0.0 if abs(c) < _SMALL else c:.3g}" for c in centre)
    return f"turning about the point ({x}, {y}) m"


def _line(degrees: float) -> str:
    # The direction of a line is known modulo half a turn; a twentieth of a degree is not worth a
    # number.
    near = 0.05
    if degrees < near or degrees > 180 - near:
        return "straight forward and back"
    if abs(degrees - 90) < near:
        return "straight sideways"
    return f"straight along {degrees:.3g} deg"


def motions_in_words(basis: Array) -> tuple[str, ...]:
    """Return the space that a basis (3, k) spans as simple motions, one for each dimension."""
    return tuple(motion_in_words(twist) for twist in simple_motions(basis))


def simple_motions(basis: Array) -> Array:
    """Return (k, 3) twists that span the same space, with as many zeros as can be.

    >>> simple_motions(np.eye(3)).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    rows = np.array(basis, dtype=np.float64).T
    done = 0
    for column in range(3):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) < _SMALL:
            continue
        rows[[done, pivot]] = rows[[pivot, done]]
        rows[done] /= rows[done, column]
        others = [i for i in range(len(rows)) if i != done]
        rows[others] -= np.outer(rows[others, column], rows[done])
        done += 1
    return np.asarray(rows)


def join(items: tuple[str, ...] | list[str], last: str = "and") -> str:
    """Return items as a list in a sentence.

    >>> join(["a", "b", "c"])
    'a, b and c'
    """
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {last} {items[-1]}"
