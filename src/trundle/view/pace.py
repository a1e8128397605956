"""How fast time passes in an animation, and which times of a run it shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trundle.se2 import Array
from trundle.simulation import Run

_MOST_FRAMES = 150
_SHORTEST, _LONGEST = 2.5, 15.0  # a run that is over sooner or later is shown slower or faster [s]


@dataclass(frozen=True)
class Pace:
    """Which times of a run are shown (F,) [s], for how long each [s], and how fast time passes."""

    times: Array
    delay: float
    speed: float


def pace(run: Run, fps: float, seconds: float | None = None, tick: float = 0.0) -> Pace:
    """Return the pace of an animation.

    Without ``seconds`` time passes as it does, if that takes from 2.5 s to 15 s; over 150 frames,
    each is shown longer.

    Args:
        run: the run.
        fps: frames per second.
        seconds: length of the animation [s].
        tick: what a delay is a multiple of [s]; 0 for any.

    >>> from trundle import load, simulate
    >>> run = simulate(load("omni3"), wheel_speeds=[1.0, 1.0, 1.0], duration=30.0)
    >>> found = pace(run, 20, tick=0.01)
    >>> len(found.times), found.delay, found.speed
    (150, 0.1, 2.0)
    """
    start, end = float(run.t[0]), float(run.t[-1])
    length, delay = seconds, 1 / fps
    if length is None:
        length = min(max(end - start, _SHORTEST), _LONGEST)
        delay = max(delay, length / _MOST_FRAMES)
    if tick:
        # Players take a delay below 0.02 s for a slip of the pen.
        delay = max(math.ceil(delay / tick - 1e-9), 2) * tick
    count = max(round(length / delay), 2)
    return Pace(np.linspace(start, end, count), delay, (end - start) / (count * delay))
