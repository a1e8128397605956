"""A rollout made ready, called over and over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.simulation.rollout import devices
from trundle.simulation.rollout.commands import Commands
from trundle.simulation.rollout.exchange import (
    explain_nonfinite,
    read_commands,
    read_parameters,
    read_seed,
    read_start,
)
from trundle.simulation.rollout.loop import DONE, LOST, TOO_FAR, Arguments, Numbers
from trundle.simulation.rollout.memory import ask_for
from trundle.simulation.rollout.plan import Plan
from trundle.simulation.rollout.quick import Quick, make_quick, reader
from trundle.simulation.rollout.recipe import Recipe
from trundle.simulation.rollout.reducers import Collected
from trundle.simulation.rollout.reducers.moments import (
    COLUMNS,
    Moments,
    join_rows,
    moments_at,
    moments_of,
)
from trundle.simulation.rollout.result import Rollouts

# Robot-steps between two looks at the keyboard: a fraction of a second of work.
_AT_ONCE = {"cpu": 20_000_000, "numpy": 1_000_000, "cuda": 2_000_000_000}
# Rows of sums over the robots of a lane, made before they are joined: some megabytes.
_SUMS = 100_000


class PreparedRollout:
    """A rollout made ready by ``compile_rollout``."""

    def __init__(self, plan: Plan, commands: Commands, pose: Numbers | None, device: str) -> None:
        self._plan, self._commands, self._device = plan, commands, device
        self._between = plan.dt * (plan.every or plan.steps)
        dtype, count, reducer = np.dtype(plan.recipe.dtype), plan.count, plan.reducer
        own = (plan.recipe.state + sum(plan.recipe.own)) * count * dtype.itemsize
        ask_for(own, f"{count} robots in {dtype}", "take fewer at once")
        self._at_once, self._lanes = max(_AT_ONCE[device] // max(count, 1), 1), 1
        if reducer is not None and reducer.summed:
            self._lanes = devices.lanes(device, plan.recipe, count)
            self._at_once = min(self._at_once, max(_SUMS // self._lanes, 1) * reducer.summed)
        self._first = Arguments(
            0, plan.steps, plan.commands, int(plan.moving), *plan.constants(plan.parts), plan.table,
            plan.key, plan.start(pose), plan.every, np.zeros((0, 3, count), dtype),
            np.zeros((self._lanes, 0, COLUMNS)), 0 if reducer is None else reducer.summed,
        )  # fmt: skip
        self._run: Callable[[Arguments], int]
        self._quick: Quick | None
        self._make_loop(plan.recipe)

    def _make_loop(self, recipe: Recipe) -> None:
        """Make what runs, from the plan's recipe or a wider one."""
        plan, self._quick = self._plan, None
        self._run = devices.make_run(self._device, recipe)
        loop = devices.whole_loop(self._device, recipe, plan.count, plan.steps)
        read = reader(plan, self._commands)
        if loop is not None and read is not None and plan.steps <= self._at_once:
            self._quick = make_quick(read, loop, self._first, self._between)

    def __call__(
        self,
        commands: npt.ArrayLike | None = None,
        *,
        pose: npt.ArrayLike | None = None,
        seed: int | None = None,
        parameters: npt.ArrayLike | None = None,
        out: Numbers | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> Rollouts:
        """Return where the robots go.

        Args:
            commands: other commands, an array of the shape and layout of the first.
            pose: other starts, (N, 3) or (3,).
            seed: another seed of the noise.
            parameters: other parameters of the law or, without one, of the reducer, of the shape
                of the first.
            out: array for the poses, as in ``rollout``.
            progress: called a few times a second with the steps that are done, and all of them.

        Raises:
            TrundleError: something does not fit; the message says what.
        """
        if self._quick and seed is None and parameters is None and out is None and progress is None:
            found = self._quick(commands, pose)
            if found is not None:
                return found
        plan, given = self._plan, self._exchanged(commands, seed, parameters)
        if out is not None:
            if isinstance(out, np.ndarray) and np.may_share_memory(out, given.commands):
                raise ShapeError("out must not lie in the memory of the commands: they are read")
            # It may lie where the poses are written, and be read twice.
            pose = None if pose is None else np.array(pose)
        given = given._replace(state=self._start(pose), out=self._room(out))
        if plan.every:
            given.out[0] = given.state[:3]
        moments: list[Moments] = []
        end = self._advance(given, moments, progress)
        if end == TOO_FAR:
            # Some robot turned by half a turn or more in a step: once more, now ready for that.
            self._make_loop(replace(plan.recipe, wide=True))
            given = given._replace(state=self._start(pose))
            end = self._advance(given, moments, progress)
        if end == LOST:
            raise TrundleError(explain_nonfinite(plan, given.commands, given.state, pose))
        return self._result(given, out, moments)

    def _exchanged(
        self, commands: npt.ArrayLike | None, seed: int | None, parameters: npt.ArrayLike | None
    ) -> Arguments:
        """Return the loop's arguments, some of them in place of the first ones."""
        plan, given = self._plan, self._first
        if commands is not None:
            given = given._replace(commands=read_commands(plan, self._commands, commands))
        if seed is not None:
            given = given._replace(key=read_seed(plan, seed))
        if parameters is not None:
            shared, own = read_parameters(plan, parameters)
            given = given._replace(shared=shared, own=own)
        return given

    def _advance(
        self,
        given: Arguments,
        moments: list[Moments],
        progress: Callable[[int, int], None] | None,
    ) -> int:
        """Advance all robots by all steps, some at a time, so that an interrupt is heard."""
        total, spread, done, end = given.steps, self._plan.recipe.spread, 0, DONE
        moments[:] = [moments_at(given.state[:3])] if spread else []
        while done < total and end == DONE:
            steps = min(self._at_once, total - done)
            sums = self._sums(done, steps) if given.summed else given.sums
            end = self._advanced(given._replace(first=done, steps=steps, sums=sums))
            if spread and end == DONE:
                moments.append(moments_of(sums))
            done += steps
            if progress is not None:
                progress(done, total)
        return end

    def _advanced(self, given: Arguments) -> int:
        """Advance all robots by some steps; what a user's law raises is told."""
        try:
            return self._run(given)
        except (TrundleError, MemoryError):
            raise
        except Exception as error:
            if self._plan.recipe.law is None:
                raise
            name = type(error).__name__
            raise TrundleError(f"the policy failed on the way: {name}: {error}") from error

    def _sums(self, first: int, steps: int) -> Numbers:
        """Return room for the sums of so many steps."""
        summed = self._first.summed
        rows = (first + steps) // summed - first // summed
        return np.zeros((self._lanes, rows, COLUMNS))

    def _start(self, pose: npt.ArrayLike | None) -> Numbers:
        """Return the states for other starts, or again for the first ones."""
        return self._first.state.copy() if pose is None else read_start(self._plan, pose)

    def _room(self, out: Numbers | None) -> Numbers:
        """Return the array for trajectories: the given one, or fresh memory."""
        plan, dtype = self._plan, self._plan.recipe.dtype
        shape = (plan.rows, 3, plan.count) if plan.every else (3, plan.count)
        if out is not None:
            found = devices.as_array(self._device, out) if plan.every else out
            if not hasattr(found, "shape") or found.shape != shape or found.dtype != dtype:
                got = f"{out.dtype} {out.shape}" if isinstance(out, np.ndarray) else repr(out)
                raise ShapeError(f"out must be an array of {dtype} with shape {shape}, got {got}")
            if isinstance(out, np.ndarray) and not (out.flags.c_contiguous and out.flags.writeable):
                raise ShapeError("out must be contiguous in C order, and writeable")
            return found if plan.every else self._first.out
        if not plan.every:
            return self._first.out
        poses = 3 * plan.count * plan.rows * np.dtype(dtype).itemsize
        ask_for(
            poses + self._first.state.nbytes,
            f"{plan.rows} poses of {plan.count} robots in {dtype}",
            "keep Every(k) steps, take dtype='float32', or a reducer",
        )
        return np.empty(shape, dtype)

    def _result(self, given: Arguments, out: Numbers | None, moments: list[Moments]) -> Rollouts:
        plan, final = self._plan, given.state[:3]
        if plan.every:
            # Poses in a GPU's memory stay there, as they lie.
            buffer: Any = given.out
            pose = np.swapaxes(buffer, 1, 2) if isinstance(buffer, np.ndarray) else buffer
        else:
            if out is not None:
                out[:] = final
                final = out
            buffer, pose = final, final.T
        reduced = None
        if plan.reducer is not None:
            registers = given.state[plan.recipe.moved :].astype(np.float64)
            joined = join_rows(moments) if moments else None
            reduced = plan.reducer.result(
                Collected(registers, plan.steps, plan.dt, plan.recipe.dtype, joined, given.summed)
            )
        return Rollouts(pose, buffer, final.T, self._between, reduced, self._device)
