"""Many robots at once: what users call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.robot import Robot
from trundle.simulation.arithmetic import as_is
from trundle.simulation.rollout import devices
from trundle.simulation.rollout.commands import Commands, Given, numbers
from trundle.simulation.rollout.loop import DONE, LOST, TOO_FAR, Arguments, Numbers
from trundle.simulation.rollout.memory import ask_for
from trundle.simulation.rollout.plan import Plan, as_type, make_plan, seed_key
from trundle.simulation.rollout.reducers import Collected, Reducer
from trundle.simulation.rollout.reducers.moments import (
    COLUMNS,
    Moments,
    join_rows,
    moments_at,
    moments_of,
)
from trundle.simulation.rollout.saving import Every

# Robot-steps between two looks at the keyboard: a fraction of a second of work.
_AT_ONCE = {"cpu": 20_000_000, "numpy": 1_000_000, "cuda": 2_000_000_000}
# Rows of sums over the robots of a lane, made before they are joined: some megabytes.
_SUMS = 100_000


class Rollouts(NamedTuple):
    """Where N robots went.

    Attributes:
        pose: (N, 3) final poses (x, y, psi) in the inertial frame [m, m, rad], or (rows, N, 3)
            where trajectories were kept: a view of ``buffer``.
        buffer: (3, N), or (rows, 3, N), as the loop wrote it: for each row of time and each of x,
            y and psi all robots beside each other. It can be passed back as ``out``.
        final: (N, 3) final poses.
        dt: time between two rows of the poses [s].
        reduced: what the reducer made of them, or None.
        device: what computed them: "numpy", "cpu" or "cuda".
    """

    pose: Numbers
    buffer: Numbers
    final: Numbers
    dt: float
    reduced: Any
    device: str


def rollout(
    robot: Robot,
    commands: Commands,
    *,
    dt: float,
    steps: int | None = None,
    pose: npt.ArrayLike | None = None,
    method: str = "exact",
    save: str | Every | Reducer | tuple[Reducer, ...] = "final",
    dtype: str = "float64",
    device: str = "auto",
    parameters: Mapping[str, npt.ArrayLike] | None = None,
    out: Numbers | None = None,
) -> Rollouts:
    """Return where many robots go under their commands.

    Args:
        robot: the robot.
        commands: Constant, Stream or Policy, perhaps with noise; or Tracking.
        dt: step [s].
        steps: number of steps; a Stream tells it.
        pose: (3,) start x, y, psi of all robots [m, m, rad], or (N, 3). When left out, the origin,
            or the start of what is tracked.
        method: "exact", "euler" or "rk4", as in ``simulate``.
        save: "final" poses, the whole "trajectory", ``Every(k)`` steps, a reducer such
            as ``Statistics()``, or a tuple of reducers.
        dtype: "float64" or "float32". With "float32" sums are compensated: positions are right to
            about seven digits after any number of steps.
        device: "cpu" compiles the loops with numba, "cuda" runs them on a GPU, "numpy" needs
            neither; "auto" takes "cpu" where numba is installed.
        parameters: what the robots differ in, by name, each (N,): "radius" and other numbers of
            the wheels, "front_left.radius" of one, "arm", "track" and "wheelbase" [m], "mass" and
            "inertia" of the body, and its "com" (N, 2).
        out: array for the poses, contiguous and of the dtype: (3, N), or (rows, 3, N); such as the
            ``buffer`` of an earlier result. Fresh memory costs more than the motion does. With
            "cuda", trajectories may lie in the GPU's memory: then they stay there, and ``pose`` is
            the array itself.

    Returns:
        The poses, and what a reducer made of them.

    Raises:
        TrundleError: something does not fit; the message says what.

    >>> import numpy as np
    >>> from trundle import Constant, load
    >>> speeds = np.array([[1.0, 1.0], [1.0, 2.0]])  # of two robots
    >>> rollout(load("differential"), Constant(speeds), dt=0.1, steps=10).pose.round(3) + 0.0
    array([[0.05 , 0.   , 0.   ],
           [0.075, 0.005, 0.125]])
    """
    return compile_rollout(
        robot, commands, dt=dt, steps=steps, pose=pose, method=method, save=save, dtype=dtype,
        device=device, parameters=parameters,
    )(out=out)  # fmt: skip


def compile_rollout(
    robot: Robot,
    commands: Commands,
    *,
    dt: float,
    steps: int | None = None,
    pose: npt.ArrayLike | None = None,
    method: str = "exact",
    save: str | Every | Reducer | tuple[Reducer, ...] = "final",
    dtype: str = "float64",
    device: str = "auto",
    parameters: Mapping[str, npt.ArrayLike] | None = None,
) -> PreparedRollout:
    """Return a rollout made ready, to be called in a loop with other commands, poses and seeds.

    The arguments are those of ``rollout``. The call itself takes a few microseconds more than the
    motion.

    >>> import numpy as np
    >>> from trundle import Stream, load
    >>> one_step = compile_rollout(load("differential"), Stream(np.zeros((1, 1, 2))), dt=0.1)
    >>> pose = np.zeros((1, 3))
    >>> for _ in range(10):
    ...     pose = one_step(np.array([[[1.0, 1.0]]]), pose=pose).pose
    >>> pose.round(6) + 0.0
    array([[0.05, 0.  , 0.  ]])
    """
    start = None if pose is None else read_pose(pose)
    plan = make_plan(
        robot, commands, dt=dt, steps=steps, pose=start, method=method, save=save, dtype=dtype,
        parameters=parameters or {},
    )  # fmt: skip
    return PreparedRollout(plan, commands, start, devices.choose(device))


class PreparedRollout:
    """A rollout made ready by ``compile_rollout``."""

    def __init__(self, plan: Plan, commands: Commands, pose: Numbers | None, device: str) -> None:
        self._plan, self._commands, self._device = plan, commands, device
        self._moving, self._dtype = int(plan.moving), np.dtype(plan.recipe.dtype)
        self._between = plan.dt * (plan.every or plan.steps)
        number = self._dtype.itemsize
        own = (plan.recipe.state + sum(plan.recipe.own)) * plan.count * number
        ask_for(own, f"{plan.count} robots in {plan.recipe.dtype}", "take fewer at once")
        self._run, self._start = devices.make_run(device, plan.recipe), plan.start(pose)
        self._poses = (plan.count, 3) if plan.drive.motion.kept == 3 and plan.steps else None
        self._shared, self._own = plan.constants(plan.parts)
        self._reducer = plan.reducer
        self._size = 3 * plan.count * number * plan.rows + self._start.nbytes
        self._at_once = max(_AT_ONCE[device] // max(plan.count, 1), 1)
        self._nothing = np.zeros((0, 3, plan.count), plan.recipe.dtype)
        self._no_sums, self._lanes, self._summed = np.zeros((1, 0, COLUMNS)), 1, 0
        if plan.reducer is not None and plan.reducer.summed:
            self._summed = plan.reducer.summed
            self._lanes = devices.lanes(device, plan.recipe, plan.count)
            rows = max(_SUMS // self._lanes, 1)
            self._at_once = min(self._at_once, rows * self._summed)
        whole = 0 < plan.steps <= self._at_once and not plan.every and self._reducer is None
        # How commands are read, where nothing else needs to be done about them.
        self._simple: Callable[[Numbers, str], Numbers] | None = None
        plain = whole and self._poses is not None and plan.drive.arrange is as_is
        if plain and isinstance(commands, Given) and commands.steering is None:
            self._simple = commands.read

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
        plan = self._plan
        extra = (seed, parameters, out, progress)
        if self._simple is not None and not any(each is not None for each in extra):
            found = self._at_once_done(commands, pose)
            if found is not None:
                return found
        values = plan.commands if commands is None else self._read_commands(commands)
        key = plan.key if seed is None else self._read_seed(seed)
        constants = self._shared, self._own
        if parameters is not None:
            constants = plan.constants(plan.parts | self._read_parameters(parameters))
        if out is not None:
            if isinstance(out, np.ndarray) and np.may_share_memory(out, values):
                raise ShapeError("out must not lie in the memory of the commands: they are read")
            # It may lie where the poses are written, and be read twice.
            pose = None if pose is None else np.array(pose)
        state, kept = self._read_start(pose), self._read_out(out)
        if plan.every:
            kept[0] = state[:3]
        moments: list[Moments] = []
        end = self._advance(values, constants, key, state, kept, moments, progress)
        if end == TOO_FAR:
            # Some robot turned by half a turn or more in a step: once more, now ready for that.
            self._run = devices.make_run(self._device, replace(plan.recipe, wide=True))
            state = self._read_start(pose)
            end = self._advance(values, constants, key, state, kept, moments, progress)
        if end == LOST:
            raise TrundleError(
                explain_nonfinite(values, plan.drive.arrange is not as_is, state, pose)
            )
        return self._result(state, kept, out, moments)

    def _at_once_done(self, commands: object, pose: npt.ArrayLike | None) -> Rollouts | None:
        """Return where the robots go, where commands come as expected; or None.

        This is what a control loop calls; to look more closely takes longer than to move.
        """
        if not isinstance(commands, np.ndarray) or commands.dtype != self._dtype:
            return None
        plan = self._plan
        values = self._simple(commands, "commands")  # type: ignore[misc]
        if values.shape != plan.commands.shape:
            return None
        state = self._read_start(pose)
        given = Arguments(
            0, plan.steps, values, self._moving, self._shared, self._own, plan.table, plan.key,
            state, 0, self._nothing, self._no_sums, 0,
        )  # fmt: skip
        if self._run(given) != DONE:
            return None
        final = state[:3]
        return Rollouts(final.T, final, final.T, self._between, None, self._device)

    def _advance(
        self,
        commands: Numbers,
        constants: tuple[Numbers, Numbers],
        key: npt.NDArray[np.uint32],
        state: Numbers,
        kept: Numbers,
        moments: list[Moments],
        progress: Callable[[int, int], None] | None,
    ) -> int:
        """Advance all robots by all steps, some at a time, so that an interrupt is heard."""
        plan, first, end = self._plan, 0, DONE
        moments[:] = [moments_at(state[:3])] if plan.recipe.spread else []
        while first < plan.steps and end == DONE:
            steps = min(self._at_once, plan.steps - first)
            sums = self._sums(first, steps) if self._summed else self._no_sums
            end = self._advanced(
                Arguments(
                    first, steps, commands, self._moving, *constants, plan.table, key, state,
                    plan.every, kept, sums, self._summed,
                )
            )  # fmt: skip
            if plan.recipe.spread and end == DONE:
                moments.append(moments_of(sums))
            first += steps
            if progress is not None:
                progress(first, plan.steps)
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
        rows = (first + steps) // self._summed - first // self._summed
        return np.zeros((self._lanes, rows, COLUMNS))

    def _read_commands(self, given: npt.ArrayLike) -> Numbers:
        """Return other commands as the loop reads them."""
        plan, last = self._plan, self._commands
        if not isinstance(last, Given) or last.steering is not None:
            raise TrundleError("only wheel speeds or twists that were given can be exchanged")
        if not (isinstance(given, np.ndarray) and given.dtype == self._dtype):
            given = numbers(given, "commands")
        values = last.read(given, "commands")
        if values.shape != last.values.shape:
            raise ShapeError(
                f"commands must have the shape of the first ones: got {np.shape(given)}"
            )
        return as_type(plan.drive.arrange(values), plan.recipe.dtype)

    def _read_start(self, pose: npt.ArrayLike | None) -> Numbers:
        """Return the states for other starts, or again for the first ones."""
        if pose is None:
            return self._start.copy()
        if isinstance(pose, np.ndarray) and pose.shape == self._poses and pose.dtype.kind == "f":
            # The usual case in a loop. What is no number in it shows in the poses that follow.
            state = self._start.copy()
            state[:3] = pose.T
            return state
        start, count = read_pose(pose), self._plan.count
        if start.ndim == 2 and len(start) not in (1, count):
            raise ShapeError(f"pose must be of {count} robots, got {start.shape}")
        return self._plan.start(start)

    def _read_seed(self, seed: int) -> npt.NDArray[np.uint32]:
        if not self._plan.recipe.noisy:
            raise TrundleError("seed is of noise, and these commands have none: use with_noise")
        return seed_key(seed)

    def _read_parameters(self, parameters: npt.ArrayLike) -> dict[str, Numbers]:
        """Return the constants of law or reducer with other parameters."""
        plan, values = self._plan, finite(parameters, "parameters")
        if values.ndim not in (1, 2):
            raise ShapeError(f"parameters must be (k,) or (N, k) numbers, got {values.shape}")
        if plan.drive.law_constants is not None:
            name, made = "law", plan.drive.law_constants(values)
        elif self._reducer is not None:
            return self._read_reducer(self._reducer.with_parameters(values))
        else:
            raise TrundleError("neither a law nor a reducer takes parameters here")
        if made.shape != plan.parts[name].shape:
            raise ShapeError("parameters must have the shape of the first ones")
        return {name: made}

    def _read_reducer(self, reducer: Reducer) -> dict[str, Numbers]:
        """Return the constants of another reducer, which must be alike."""
        plan = self._plan
        parts = {f"reduction {i}": p for i, p in enumerate(reducer.constants(plan.dt, 0))}
        if any(part.shape != plan.parts[name].shape for name, part in parts.items()):
            raise ShapeError("parameters must have the shape of the first ones")
        return parts

    def _read_out(self, out: Numbers | None) -> Numbers:
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
            return found if plan.every else self._nothing
        if not plan.every:
            return self._nothing
        ask_for(
            self._size,
            f"{plan.rows} poses of {plan.count} robots in {dtype}",
            "keep Every(k) steps, take dtype='float32', or a reducer",
        )
        return np.empty(shape, dtype)

    def _result(
        self, state: Numbers, kept: Numbers, out: Numbers | None, moments: list[Moments]
    ) -> Rollouts:
        plan = self._plan
        final = state[:3]
        if plan.every:
            # Poses in a GPU's memory stay there, as they lie.
            buffer, pose = kept, np.swapaxes(kept, 1, 2) if isinstance(kept, np.ndarray) else kept
        else:
            if out is not None:
                out[:] = final
                final = out
            buffer, pose = final, final.T
        reduced = None
        if self._reducer is not None:
            registers = state[plan.recipe.moved :].astype(np.float64)
            joined = join_rows(moments) if moments else None
            reduced = self._reducer.result(
                Collected(registers, plan.steps, plan.dt, plan.recipe.dtype, joined, self._summed)
            )
        return Rollouts(pose, buffer, final.T, self._between, reduced, self._device)


def read_pose(pose: npt.ArrayLike) -> Numbers:
    """Return starts, (3,) or (N, 3)."""
    start = finite(pose, "pose", 3)
    if start.ndim > 2 or start.size == 0:
        raise ShapeError(f"pose must be (3,), or (N, 3) of at least one robot, got {start.shape}")
    return start


def explain_nonfinite(
    commands: Numbers, held: bool, state: Numbers, pose: npt.ArrayLike | None
) -> str:
    """Return why poses are no numbers: commands, starts, or what grew beyond all numbers."""
    if pose is not None and not np.isfinite(np.asarray(pose, dtype=np.float64)).all():
        return "pose must be finite numbers, got nan or inf"
    bad = np.argwhere(~np.isfinite(commands))
    if len(bad) and held:
        return f"commands of robot {bad[0, 2]} must be finite numbers, and not too large for dt"
    if len(bad):
        t, k, i = (int(each) for each in bad[0])
        return (
            f"commands must be finite numbers: value {k} of robot {i} in step {t} is "
            f"{commands[t, k, i]}"
        )
    robot = int(np.argwhere(~np.isfinite(state[:3]).all(axis=0))[0, 0])
    return f"the pose of robot {robot} outgrew every number, or its law gave no number"
