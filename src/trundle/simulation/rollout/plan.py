"""A rollout made ready: checked, sized, and laid out as the loops read it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Integral, Real
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import robot_of
from trundle.robot import Robot
from trundle.simulation.arithmetic import array_arithmetic
from trundle.simulation.rollout.commands import Commands, Given, Policy
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.model import PolicyLaw, command_of, motion_of
from trundle.simulation.rollout.motions import CHORDS, Chord, Linear
from trundle.simulation.rollout.random import key_words
from trundle.simulation.rollout.recipe import Recipe
from trundle.simulation.rollout.reducers import Reducer
from trundle.simulation.rollout.saving import Every

_DTYPES = ("float64", "float32")


@dataclass(frozen=True, eq=False)
class Plan:
    """All that a rollout's loop takes but the poses that it starts from.

    Attributes:
        recipe: what the loop is made of.
        count: N, the number of robots.
        steps: T, the number of steps.
        dt: step [s].
        commands: as the loop reads them.
        moving: whether each step has its own.
        shared: (k,) constants of all robots.
        own: (k, N) constants of each.
        table: numbers that a reducer looks up.
        key: words that make the random numbers.
        every: steps between two rows that are kept, or 0.
        rows: how many rows are kept, or 0.
        arrange: from commands (T or 1, k, N or 1) to what the loop reads.
    """

    recipe: Recipe
    count: int
    steps: int
    dt: float
    commands: Numbers
    moving: bool
    shared: Numbers
    own: Numbers
    table: Numbers
    key: npt.NDArray[np.uint32]
    every: int
    rows: int
    arrange: Callable[[Numbers], Numbers]


def make_plan(
    robot: Robot,
    commands: Commands,
    *,
    dt: float,
    steps: int | None,
    pose: Numbers,
    method: str,
    save: Any,
    dtype: str,
) -> Plan:
    """Return a rollout made ready.

    Raises:
        TrundleError: something does not fit; the message says what.
    """
    robot_of(robot)
    _check(commands, dt, method, dtype)
    steps = _steps(commands, steps)
    every, reducer = _saved(save)
    width, what = command_of(robot, commands)
    given = _values(commands, width, what, robot)
    arrange: Callable[[Numbers], Numbers] = _as_is
    law, parts = None, []
    if isinstance(commands, Policy):
        law = PolicyLaw(commands.step, commands.parameters.shape[-1], width)
        parts.append(_with_step(commands.parameters, dt))
    if commands.noise is not None:
        parts.append(_sigma(commands.noise.sigma, width, what))
    motion, constants = motion_of(robot, commands, dt, method)
    if isinstance(motion, Linear) and not (law or parts or commands.moving or reducer):
        arrange = partial(_chords, motion, constants)
        motion, constants, given = Chord(), np.zeros(0), arrange(given)
    parts.append(constants)
    if reducer is not None:
        parts.append(reducer.constants)
    count = _count(pose, given, parts)
    recipe = Recipe(
        dtype=dtype,
        given=given.shape[1],
        command=width,
        own=tuple(part.ndim == 2 for part in parts for _ in range(len(part))),
        motion=motion,
        common=given.shape[2] == 1 and count > 1,
        noisy=commands.noise is not None,
        law=law,
        reduction=None if reducer is None else reducer.reduction,
    )
    return Plan(
        recipe=recipe,
        count=count,
        steps=steps,
        dt=float(dt),
        commands=given.astype(dtype, copy=False),
        moving=commands.moving,
        shared=np.concatenate([[], *(p for p in parts if p.ndim == 1)]).astype(dtype),
        own=np.concatenate(
            [
                np.zeros((0, count)),
                *(np.broadcast_to(p, (len(p), count)) for p in parts if p.ndim == 2),
            ]
        ).astype(dtype),
        table=np.zeros(0, dtype) if reducer is None else reducer.table.astype(dtype),
        key=seed_key(0 if commands.noise is None else commands.noise.seed),
        every=every,
        rows=steps // every + 1 if every else 0,
        arrange=arrange,
    )


def seed_key(seed: int) -> npt.NDArray[np.uint32]:
    """Return the key words of a seed, as the loops read them."""
    return np.array(key_words(seed), dtype=np.uint32)


def _check(commands: Commands, dt: float, method: str, dtype: str) -> None:
    if not isinstance(commands, Commands):
        raise TrundleError(
            "commands must say what they are: Constant(...) for each robot's own, Stream(...) for "
            f"one row a step, Policy(...) for a feedback law; got {type(commands).__name__}"
        )
    if not (isinstance(dt, Real) and math.isfinite(dt) and dt > 0):
        raise TrundleError(f"dt must be a positive number of seconds, got {dt!r}")
    if method not in CHORDS:
        raise TrundleError(f"method must be one of {', '.join(CHORDS)}, got {method!r}")
    if dtype not in _DTYPES:
        raise TrundleError(f"dtype must be 'float64' or 'float32', got {dtype!r}")


def _steps(commands: Commands, steps: int | None) -> int:
    rows = len(commands.values) if isinstance(commands, Given) and commands.moving else None
    if steps is None:
        if rows is None:
            raise TrundleError("give steps: these commands do not tell how long they last")
        return rows
    if isinstance(steps, bool) or not isinstance(steps, Integral) or steps < 0:
        raise TrundleError(f"steps must be a whole number from 0 on, got {steps!r}")
    if rows is not None and rows != steps:
        raise ShapeError(f"steps is {steps}, and the commands have rows for {rows} steps")
    return int(steps)


def _saved(save: object) -> tuple[int, Reducer | None]:
    """Return the steps between two rows that are kept, or 0, and the reducer, or None."""
    if isinstance(save, Every):
        return save.steps, None
    if isinstance(save, Reducer):
        return 0, save
    if save in ("final", "trajectory"):
        return int(save == "trajectory"), None
    raise TrundleError(
        f"save must be 'final', 'trajectory', Every(k) or a reducer such as Statistics(), "
        f"got {save!r}"
    )


def _values(commands: Commands, width: int, what: str, robot: Robot) -> Numbers:
    """Return the commands (T or 1, k, N or 1) as given, angles after speeds; none of a law's."""
    if not isinstance(commands, Given):
        return np.zeros((1, 0, 1))
    values, name = commands.values, "twist" if commands.is_twist else "wheel_speeds"
    if values.shape[1] != width:
        raise ShapeError(
            f"{name} of robot {robot.name!r} must have {width} values for each robot, {what}, got "
            f"{values.shape[1]}"
        )
    return values


def _sigma(sigma: Numbers, width: int, what: str) -> Numbers:
    """Return the standard deviations, (k,) or (k, N)."""
    if sigma.ndim == 0:
        return np.full(width, float(sigma))
    if sigma.ndim > 2 or sigma.shape[-1] != width:
        raise ShapeError(
            f"sigma must be one number, ({width},) or (N, {width}), of {what}, got {sigma.shape}"
        )
    return sigma.T


def _with_step(parameters: Numbers, dt: float) -> Numbers:
    """Return a law's constants: the step, and the parameters (k,) or (k, N)."""
    step = np.full((*parameters.shape[:-1], 1), float(dt))
    return np.concatenate([step, parameters], axis=-1).T


def _as_is(values: Numbers) -> Numbers:
    return values


def _chords(motion: Linear, constants: Numbers, given: Numbers) -> Numbers:
    """Return the chords (1, 3, N) of commands that do not change, and half their turns."""
    rows = constants.reshape(3, motion.count, *constants.shape[1:])
    dx, dy, half = np.einsum("ij...,j...->i...", rows, given[0].astype(np.float64))
    chord = CHORDS[motion.method](array_arithmetic("float64"), lambda function: function)
    a, b = chord(dx, dy, half)
    return np.stack([a, b, half])[None]


def _count(pose: Numbers, given: Numbers, parts: Sequence[Numbers]) -> int:
    """Return the number of robots, on which all that has one for each must agree."""
    counts = {
        "pose": len(pose) if pose.ndim == 2 else 1,
        "commands": given.shape[2],
        "the robots' own constants": max((p.shape[1] for p in parts if p.ndim == 2), default=1),
    }
    count: int = max(counts.values())
    for name, each in counts.items():
        if each not in (1, count):
            other = next(key for key, value in counts.items() if value == count)
            raise ShapeError(f"{name} has {each} robots, and {other} has {count}")
    return count
