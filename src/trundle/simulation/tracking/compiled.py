"""The loops compiled by numba, where it is installed and a run is long enough to pay for it."""

from __future__ import annotations

import importlib.util
from functools import cache
from typing import NamedTuple

import numpy as np

from trundle.motion import Course
from trundle.se2 import Array
from trundle.simulation.arithmetic import Function
from trundle.simulation.tracking.laws import Law
from trundle.simulation.tracking.loops import COLUMNS, into_columns, into_rows, make_loop

# Python's floats take some five microseconds an evaluation, compiling takes about a second, once
# for each law and method.
_WORTH_COMPILING = 20_000


class Constants(NamedTuple):
    """What does not change over a run: all that the loops take between reference and time."""

    gains: tuple[float, ...]  # of the law
    body: tuple[float, ...]  # mass, centre of mass and P
    wheels: tuple[float, ...]  # 11 for each wheel that rolls
    acting: int  # of wheels that come between command and body
    wraps: bool  # whether heading errors go the shorter way round

    @property
    def hindered(self) -> bool:
        """Whether limits or friction stand between command and body."""
        return self.acting > 0


@cache
def _compiled(method: str, law: Law, hindered: bool) -> Function:
    import numba

    # Inlined before compiling: a third faster to compile and to run than calls.
    part = numba.njit(error_model="numpy", inline="always", no_cpython_wrapper=True)
    made: Function = numba.njit(error_model="numpy")(
        make_loop(method, law, hindered, into_columns, part)
    )
    return made


@cache
def plain_loop(method: str, law: Law, hindered: bool) -> Function:
    """Return the loop of a method for a law in Python's floats."""
    return make_loop(method, law, hindered, into_rows, lambda function: function)


def run_loop(
    method: str,
    law: Law,
    course: Course,
    constants: Constants,
    dts: Array,
    start: Array,
    notes: Array,
) -> int:
    """Run a closed loop and return how many steps it made.

    Args:
        method: one of ``LOOPS``.
        law: the control law.
        course: what is desired at T + 1 times, or 2 T + 1 for "rk4".
        constants: of law, body and wheels.
        dts: (T,) steps [s].
        start: (6,) pose and twist.
        notes: (18, T + 1) contiguous, to be filled.
    """
    if len(course.position) < _WORTH_COMPILING or not importlib.util.find_spec("numba"):
        return run_plain(method, law, course, constants, dts, start, notes)
    gains, body, wheels, *rest = constants
    flat = (each.T.ravel() for each in course)
    lists = (np.array(each) for each in (gains, body, wheels))
    loop = _compiled(method, law, constants.hindered)
    return int(loop(*flat, *lists, *rest, dts, start, notes.reshape(-1)))


def run_plain(
    method: str,
    law: Law,
    course: Course,
    constants: Constants,
    dts: Array,
    start: Array,
    notes: Array,
) -> int:
    """Do what ``run_loop`` does, in Python's floats."""
    rows = bytearray(8 * COLUMNS * (len(dts) + 1))
    flat = (each.T.ravel().tolist() for each in course)
    loop = plain_loop(method, law, constants.hindered)
    steps = loop(*flat, *constants, dts.tolist(), start.tolist(), rows)
    notes[:] = np.frombuffer(rows).reshape(-1, COLUMNS).T
    return int(steps)
