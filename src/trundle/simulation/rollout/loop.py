"""What every loop takes, whatever it runs on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[Any]


# How a loop ends: well; some robot turned too far in a step for the recipe; some pose is no number.
DONE, TOO_FAR, LOST = 0, 1, 2


class Arguments(NamedTuple):
    """The arrays of a call, in the layout of the loops: robots along the last axis.

    Attributes:
        first: the first step to take.
        steps: how many to take.
        commands: (T, given, N) numbers of each step, (1, given, N) for all steps; the last axis is
            1 where all robots share them.
        moving: 1 where each step has its own commands, 0 where they are held.
        shared: (k,) constants that all robots share.
        own: (k, N) constants of each robot.
        table: numbers that a reducer looks up.
        key: (5,) words that make the random numbers.
        state: (K, N) states, advanced in place.
        every: how many steps lie between two rows of ``out``; 0 where the recipe keeps none.
        out: (rows, 3, N) poses, filled in.
        sums: (lanes, rows, 13) sums over the robots of each lane, of rows for those of these steps
            whose number, counted from 1, ``summed`` divides; zeros, filled in as
            ``reducers.moments`` tells.
        summed: how many steps lie between two rows of ``sums``; 0 where none are made.
    """

    first: int
    steps: int
    commands: Numbers
    moving: int
    shared: Numbers
    own: Numbers
    table: Numbers
    key: npt.NDArray[np.uint32]
    state: Numbers
    every: int
    out: Numbers
    sums: Numbers
    summed: int
