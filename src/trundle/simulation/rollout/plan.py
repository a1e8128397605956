"""A rollout made ready: checked, sized, and laid out as the loops read it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import robot_of
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.rollout.commands import Commands, Policy, whole_seed
from trundle.simulation.rollout.drive import Drive, drive
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import CHORDS
from trundle.simulation.rollout.random import key_words
from trundle.simulation.rollout.recipe import Recipe
from trundle.simulation.rollout.reducers import Reducer, Several
from trundle.simulation.rollout.saving import Every

_DTYPES = ("float64", "float32")
_WORTH_HOLDING = 8
# As many as the counter of the random numbers tells apart.
_MOST_STEPS = 2**32


@dataclass(frozen=True, eq=False)
class Plan:
    """All that a rollout's loop takes.

    Attributes:
        recipe: what the loop is made of.
        drive: how the commands drive the robot.
        count: N, the number of robots.
        steps: T, the number of steps.
        dt: step [s].
        commands: as the loop reads them.
        moving: whether each step has its own.
        parts: the constants of law, noise, motion and reduction, each (k,) or (k, N).
        table: numbers that a reducer looks up.
        key: words that make the random numbers.
        every: steps between two rows that are kept, or 0.
        rows: how many rows are kept, or 0.
        reducer: what is made of the poses, or None.
    """

    recipe: Recipe
    drive: Drive
    count: int
    steps: int
    dt: float
    commands: Numbers
    moving: bool
    parts: dict[str, Numbers]
    table: Numbers
    key: npt.NDArray[np.uint32]
    every: int
    rows: int
    reducer: Reducer | None

    def constants(self, parts: dict[str, Numbers]) -> tuple[Numbers, Numbers]:
        """Return the constants (k,) that robots share, and those (k, N) that each has."""
        dtype, each = self.recipe.dtype, parts.values()
        shared = np.concatenate([[], *(part for part in each if part.ndim == 1)])
        rows = [np.broadcast_to(p, (len(p), self.count)) for p in each if p.ndim == 2]
        own = np.concatenate([np.zeros((0, self.count)), *rows])
        return as_type(shared, dtype), as_type(own, dtype)

    def start(self, pose: Array | None) -> Numbers:
        """Return the states (K, N) that the robots start with."""
        recipe, kept = self.recipe, self.drive.start(pose)
        state = np.zeros((recipe.state, self.count), recipe.dtype)
        kept = as_type(kept, recipe.dtype)
        state[:3] = kept[:3]
        state[recipe.moved - len(kept) + 3 : recipe.moved] = kept[3:]
        if recipe.reduction is not None:
            state[recipe.moved :] = np.array(recipe.reduction.start)[:, None]
        return state


def make_plan(
    robot: Robot,
    commands: Commands,
    *,
    dt: float,
    steps: int | None,
    pose: Array | None,
    method: str,
    save: Any,
    dtype: str,
    parameters: Mapping[str, npt.ArrayLike],
) -> Plan:
    """Return a rollout made ready.

    Raises:
        TrundleError: something does not fit; the message says what.
    """
    robot_of(robot)
    _check(dt, steps, method, dtype)
    every, reducer = _saved(save)
    noise = getattr(commands, "noise", None)
    # For a few steps it takes longer to find the chords than to follow the arcs.
    reads = reducer is not None and reducer.reads_command
    held = noise is None and not reads and (steps or 0) >= _WORTH_HOLDING
    driven = drive(
        robot, commands, parameters=parameters, dt=dt, steps=steps, method=method, held=held
    )
    steps = _steps(commands, driven, steps)
    parts = {}
    if isinstance(commands, Policy) and driven.law_constants is not None:
        parts["law"] = driven.law_constants(commands.parameters)
    if noise is not None:
        parts["noise"] = _sigma(noise.sigma, driven.width, driven.what)
    parts |= {f"motion {i}": constants for i, constants in enumerate(driven.constants)}
    if reducer is not None:
        reducer.check(driven.width)
        parts |= {f"reduction {i}": each for i, each in enumerate(reducer.constants(dt, 0))}
    given = driven.given
    count = _count(pose, given, parts)
    recipe = Recipe(
        dtype=dtype,
        given=given.shape[1],
        command=driven.width,
        own=tuple(part.ndim == 2 for part in parts.values() for _ in range(len(part))),
        motion=driven.motion,
        common=given.shape[2] == 1 and count > 1,
        noisy=noise is not None,
        law=driven.law,
        reduction=None if reducer is None else reducer.reduction(dtype),
        spread=reducer is not None and reducer.summed > 0,
        keeps=every > 0,
    )
    return Plan(
        recipe=recipe,
        drive=driven,
        count=count,
        steps=steps,
        dt=float(dt),
        commands=as_type(given, dtype),
        moving=len(given) > 1 or commands.moving,
        parts=parts,
        table=np.zeros(0, dtype) if reducer is None else reducer.table.astype(dtype),
        key=seed_key(0 if noise is None else noise.seed),
        every=every,
        rows=steps // every + 1 if every else 0,
        reducer=reducer,
    )


def as_type(values: Numbers, dtype: str) -> Numbers:
    """Return numbers of a type; what it cannot hold is infinite, which is told later."""
    if values.dtype == dtype:
        return values
    with np.errstate(over="ignore"):
        return values.astype(dtype, copy=False)


def seed_key(seed: int) -> npt.NDArray[np.uint32]:
    """Return the key words of a seed, as the loops read them."""
    return np.array(key_words(whole_seed(seed)), dtype=np.uint32)


def _check(dt: object, steps: object, method: object, dtype: object) -> None:
    if isinstance(dt, bool) or not (isinstance(dt, Real) and math.isfinite(dt) and float(dt) > 0):
        raise TrundleError(f"dt must be a positive number of seconds, got {dt!r}")
    whole = isinstance(steps, Integral) and not isinstance(steps, bool) and int(steps) >= 0
    if steps is not None and not whole:
        raise TrundleError(f"steps must be a whole number from 0 on, got {steps!r}")
    if not isinstance(method, str) or method not in CHORDS:
        raise TrundleError(f"method must be one of {', '.join(CHORDS)}, got {method!r}")
    if not isinstance(dtype, str) or dtype not in _DTYPES:
        raise TrundleError(f"dtype must be 'float64' or 'float32', got {dtype!r}")


def _steps(commands: Commands, driven: Drive, steps: int | None) -> int:
    rows = len(driven.given) if commands.moving else None
    if steps is None:
        if rows is None:
            raise TrundleError("give steps: these commands do not tell how long they last")
        return rows
    if steps > _MOST_STEPS:
        raise TrundleError(f"steps must be at most {_MOST_STEPS:g}, got {steps:g}")
    if rows is not None and rows != steps and not (steps == 0 and rows == 1):
        raise ShapeError(f"steps is {steps}, and the commands have rows for {rows} steps")
    return int(steps)


def _saved(save: object) -> tuple[int, Reducer | None]:
    """Return the steps between two rows that are kept, or 0, and the reducer, or None."""
    if isinstance(save, Every):
        return save.steps, None
    if isinstance(save, Reducer):
        return 0, save
    if isinstance(save, tuple) and save and all(isinstance(each, Reducer) for each in save):
        return 0, Several(save)
    if isinstance(save, str) and save in ("final", "trajectory"):
        return int(save == "trajectory"), None
    raise TrundleError(
        f"save must be 'final', 'trajectory', Every(k), a reducer such as Statistics(), or a "
        f"tuple of reducers, got {save!r}"
    )


def _sigma(sigma: Numbers, width: int, what: str) -> Numbers:
    """Return the standard deviations, (k,) or (k, N)."""
    if sigma.ndim == 0:
        return np.full(width, float(sigma))
    if sigma.ndim > 2 or sigma.shape[-1] != width:
        raise ShapeError(
            f"sigma must be one number, ({width},) or (N, {width}), of {what}, got {sigma.shape}"
        )
    return sigma.T


def _count(pose: Array | None, given: Numbers, parts: dict[str, Numbers]) -> int:
    """Return the number of robots, on which all that has one for each must agree."""
    counts = [("pose", len(pose) if pose is not None and pose.ndim == 2 else 1)]
    counts += [("commands", given.shape[2])]
    for name, part in parts.items():
        counts += [(_IN_WORDS[name.split()[0]], part.shape[1] if part.ndim == 2 else 1)]
    count: int = max(each for _, each in counts)
    for name, each in counts:
        if each not in (1, count):
            other = next(key for key, value in counts if value == count)
            raise ShapeError(f"{name} has {each} robots, and {other} has {count}")
    return count


_IN_WORDS = {
    "law": "the law's parameters",
    "noise": "sigma",
    "motion": "what the robots differ in",
    "reduction": "the reducer's numbers",
}
