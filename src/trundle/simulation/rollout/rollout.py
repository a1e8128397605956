"""Many robots at once: what users call."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.robot import Robot
from trundle.simulation.rollout import devices
from trundle.simulation.rollout.commands import Commands, Given, numbers
from trundle.simulation.rollout.loop import Arguments, Numbers
from trundle.simulation.rollout.memory import ask_for
from trundle.simulation.rollout.plan import Plan, make_plan, seed_key
from trundle.simulation.rollout.reducers import Reducer
from trundle.simulation.rollout.saving import Every

# Robot-steps between two looks at the keyboard: a fraction of a second of work.
_AT_ONCE = {"cpu": 20_000_000, "numpy": 1_000_000, "cuda": 2_000_000_000}


@dataclass(frozen=True, eq=False)
class Rollouts:
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
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
    method: str = "exact",
    save: str | Every | Reducer = "final",
    dtype: str = "float64",
    device: str = "auto",
    out: Numbers | None = None,
) -> Rollouts:
    """Return where many robots go under their commands.

    Args:
        robot: the robot.
        commands: Constant, Stream or Policy, perhaps with noise.
        dt: step [s].
        steps: number of steps; a Stream tells it.
        pose: (3,) start x, y, psi of all robots [m, m, rad], or (N, 3).
        method: "exact", "euler" or "rk4", as in ``simulate``.
        save: "final" poses, the whole "trajectory", ``Every(k)`` steps, or a reducer.
        dtype: "float64" or "float32". With "float32" sums are compensated: positions are right to
            about seven digits after any number of steps.
        device: "cpu" compiles the loops with numba, "cuda" runs them on a GPU, "numpy" needs
            neither; "auto" takes "cpu" where numba is installed.
        out: array for the poses, contiguous and of the dtype: (3, N), or (rows, 3, N); such as the
            ``buffer`` of an earlier result. Fresh memory costs more than the motion does.

    Returns:
        The poses, and what a reducer made of them.

    Raises:
        TrundleError: something does not fit; the message says what.

    >>> import numpy as np
    >>> from trundle import Constant, load
    >>> speeds = np.array([[1.0, 1.0], [1.0, 2.0]])  # of two robots
    >>> rollout(load("differential"), Constant(speeds), dt=0.1, steps=10).pose.round(6).tolist()
    [[0.05, 0.0, 0.0], [0.074805, 0.004681, 0.125]]
    """
    return compile_rollout(
        robot, commands, dt=dt, steps=steps, pose=pose, method=method, save=save, dtype=dtype,
        device=device,
    )(out=out)  # fmt: skip


def compile_rollout(
    robot: Robot,
    commands: Commands,
    *,
    dt: float,
    steps: int | None = None,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
    method: str = "exact",
    save: str | Every | Reducer = "final",
    dtype: str = "float64",
    device: str = "auto",
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
    >>> pose.round(6).tolist()
    [[0.05, 0.0, 0.0]]
    """
    start = read_pose(pose)
    plan = make_plan(
        robot, commands, dt=dt, steps=steps, pose=start, method=method, save=save, dtype=dtype
    )
    return PreparedRollout(plan, commands, start, save, devices.choose(device))


class PreparedRollout:
    """A rollout made ready by ``compile_rollout``."""

    def __init__(
        self, plan: Plan, commands: Commands, pose: Numbers, save: object, device: str
    ) -> None:
        self._plan, self._commands, self._device = plan, commands, device
        self._recipe = plan.recipe
        self._start = np.zeros((plan.recipe.state, plan.count), plan.recipe.dtype)
        self._start[:3] = pose.T if pose.ndim == 2 else pose[:, None]
        self._reducer = save if isinstance(save, Reducer) else None
        if plan.recipe.reduction is not None:
            self._start[plan.recipe.moved :] = np.array(plan.recipe.reduction.start)[:, None]
        row = 3 * plan.count * np.dtype(plan.recipe.dtype).itemsize
        self._size = row * max(plan.rows, 1) + self._start.nbytes
        self._at_once = max(_AT_ONCE[device] // max(plan.count, 1), 1)
        self._nothing = np.zeros((0, 3, plan.count), plan.recipe.dtype)

    def __call__(
        self,
        commands: Numbers | None = None,
        *,
        pose: npt.ArrayLike | None = None,
        seed: int | None = None,
        out: Numbers | None = None,
    ) -> Rollouts:
        """Return where the robots go.

        Args:
            commands: other commands, an array of the shape and layout of the first.
            pose: other starts, (N, 3) or (3,).
            seed: another seed of the noise.
            out: array for the poses, as in ``rollout``.

        Raises:
            TrundleError: something does not fit; the message says what.
        """
        plan = self._plan
        values = plan.commands if commands is None else self._read_commands(commands)
        key = plan.key if seed is None else seed_key(seed)
        state, kept = self._start.copy(), self._read_out(out)
        if pose is not None:
            start = read_pose(pose)
            if start.ndim == 2 and len(start) != plan.count:
                raise ShapeError(f"pose must be of {plan.count} robots, got {start.shape}")
            state[:3] = start.T if start.ndim == 2 else start[:, None]
        if plan.every:
            kept[0] = state[:3]
        start = state.copy() if self._recipe.watched else state
        if self._advance(values, key, state, kept):
            # Some robot turned by half a turn or more in a step: once more, now ready for that.
            self._recipe, state = replace(self._recipe, wide=True), start
            self._advance(values, key, state, kept)
        if not np.isfinite(state[:3]).all():
            raise TrundleError(explain_nonfinite(values, state))
        return self._result(state, kept, out)

    def _advance(
        self, commands: Numbers, key: npt.NDArray[np.uint32], state: Numbers, kept: Numbers
    ) -> bool:
        """Advance all robots by all steps, some at a time, so that an interrupt is heard."""
        plan, first = self._plan, 0
        while first < plan.steps:
            steps = min(self._at_once, plan.steps - first)
            given = Arguments(
                first, steps, commands, int(plan.moving), plan.shared, plan.own, plan.table, key,
                state, plan.every, kept,
            )  # fmt: skip
            if devices.run(self._device, self._recipe, given):
                return True
            first += steps
        return False

    def _read_commands(self, given: npt.ArrayLike) -> Numbers:
        """Return other commands as the loop reads them."""
        plan, last = self._plan, self._commands
        if not isinstance(last, Given) or last.steering is not None:
            raise TrundleError("only wheel speeds or twists that were given can be exchanged")
        values = last.read(numbers(given, "commands"), "commands")
        if values.shape != last.values.shape:
            raise ShapeError(
                f"commands must have the shape of the first ones: got {np.shape(given)}"
            )
        return plan.arrange(values).astype(plan.recipe.dtype, copy=False)

    def _read_out(self, out: Numbers | None) -> Numbers:
        """Return the array for trajectories: the given one, or fresh memory."""
        plan, dtype = self._plan, self._plan.recipe.dtype
        shape = (plan.rows, 3, plan.count) if plan.every else (3, plan.count)
        if out is not None:
            if not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != dtype:
                got = f"{out.dtype} {out.shape}" if isinstance(out, np.ndarray) else repr(out)
                raise ShapeError(f"out must be an array of {dtype} with shape {shape}, got {got}")
            if not (out.flags.c_contiguous and out.flags.writeable):
                raise ShapeError("out must be contiguous in C order, and writeable")
            return out if plan.every else self._nothing
        if not plan.every:
            return self._nothing
        ask_for(
            self._size,
            f"{plan.rows} poses of {plan.count} robots in {dtype}",
            "keep Every(k) steps, take dtype='float32', or a reducer",
        )
        return np.empty(shape, dtype)

    def _result(self, state: Numbers, kept: Numbers, out: Numbers | None) -> Rollouts:
        plan = self._plan
        final = state[:3]
        if plan.every:
            buffer, pose = kept, np.swapaxes(kept, 1, 2)
        else:
            if out is not None:
                out[:] = final
                final = out
            buffer, pose = final, final.T
        reduced = None
        if self._reducer is not None:
            registers = state[plan.recipe.moved :].astype(np.float64)
            reduced = self._reducer.result(registers, plan.steps, plan.dt)
        between = plan.dt * (plan.every or plan.steps)
        return Rollouts(pose, buffer, final.T, between, reduced, self._device)


def read_pose(pose: npt.ArrayLike) -> Numbers:
    """Return starts, (3,) or (N, 3)."""
    start = finite(pose, "pose", 3)
    if start.ndim > 2 or start.size == 0:
        raise ShapeError(f"pose must be (3,), or (N, 3) of at least one robot, got {start.shape}")
    return start


def explain_nonfinite(commands: Numbers, state: Numbers) -> str:
    """Return why poses are no numbers: the commands, or what grew beyond all numbers."""
    bad = np.argwhere(~np.isfinite(commands))
    if len(bad):
        t, k, i = (int(each) for each in bad[0])
        return (
            f"commands must be finite numbers: value {k} of robot {i} in step {t} is "
            f"{commands[t, k, i]}"
        )
    robot = int(np.argwhere(~np.isfinite(state[:3]).all(axis=0))[0, 0])
    return f"the pose of robot {robot} outgrew every number, or its law gave no number"
