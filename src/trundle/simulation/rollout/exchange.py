"""What a prepared call takes in place of what it was made with, as the loop reads it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.simulation.arithmetic import as_is
from trundle.simulation.rollout.commands import Commands, Given, numbers
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.plan import Plan, as_type, seed_key
from trundle.simulation.rollout.reducers import Reducer


def read_commands(plan: Plan, first: Commands, given: npt.ArrayLike) -> Numbers:
    """Return other commands, an array of the shape and layout of the first.

    Raises:
        TrundleError: the first were not given, but made by a law.
        ShapeError: the shape is another.
    """
    if not isinstance(first, Given) or first.steering is not None:
        raise TrundleError("only wheel speeds or twists that were given can be exchanged")
    dtype = plan.recipe.dtype
    if not (isinstance(given, np.ndarray) and given.dtype == dtype):
        given = numbers(given, "commands")
    values = first.read(given, "commands")
    if values.shape != first.values.shape:
        raise ShapeError(f"commands must have the shape of the first ones: got {np.shape(given)}")
    return as_type(plan.drive.arrange(values), dtype)


def read_pose(pose: npt.ArrayLike) -> Numbers:
    """Return starts, (3,) or (N, 3)."""
    start = finite(pose, "pose", 3)
    if start.ndim > 2 or start.size == 0:
        raise ShapeError(f"pose must be (3,), or (N, 3) of at least one robot, got {start.shape}")
    return start


def read_start(plan: Plan, pose: npt.ArrayLike) -> Numbers:
    """Return the states (K, N) for other starts, (3,) or (N, 3)."""
    start, count = read_pose(pose), plan.count
    if start.ndim == 2 and len(start) not in (1, count):
        raise ShapeError(f"pose must be of {count} robots, got {start.shape}")
    return plan.start(start)


def read_seed(plan: Plan, seed: int) -> npt.NDArray[np.uint32]:
    """Return the key words of another seed."""
    if not plan.recipe.noisy:
        raise TrundleError("seed is of noise, and these commands have none: use with_noise")
    return seed_key(seed)


def read_parameters(plan: Plan, parameters: npt.ArrayLike) -> tuple[Numbers, Numbers]:
    """Return all constants, (k,) and (k, N), with other parameters of law or reducer."""
    values = finite(parameters, "parameters")
    if values.ndim not in (1, 2):
        raise ShapeError(f"parameters must be (k,) or (N, k) numbers, got {values.shape}")
    if plan.drive.law_constants is not None:
        parts = {"law": plan.drive.law_constants(values)}
    elif plan.reducer is not None:
        parts = _of_reducer(plan, plan.reducer.with_parameters(values))
    else:
        raise TrundleError("neither a law nor a reducer takes parameters here")
    if any(part.shape != plan.parts[name].shape for name, part in parts.items()):
        raise ShapeError("parameters must have the shape of the first ones")
    return plan.constants(plan.parts | parts)


def _of_reducer(plan: Plan, reducer: Reducer) -> dict[str, Numbers]:
    return {f"reduction {i}": part for i, part in enumerate(reducer.constants(plan.dt, 0))}


def explain_nonfinite(
    plan: Plan, commands: Numbers, state: Numbers, pose: npt.ArrayLike | None
) -> str:
    """Return why poses are no numbers: commands, starts, or what grew beyond all numbers."""
    if pose is not None and not np.isfinite(np.asarray(pose, dtype=np.float64)).all():
        return "pose must be finite numbers, got nan or inf"
    bad = np.argwhere(~np.isfinite(commands))
    if len(bad) and plan.drive.arrange is not as_is:
        return f"commands of robot {bad[0, 2]} must be finite numbers, and not too large for dt"
    if len(bad):
        t, k, i = (int(each) for each in bad[0])
        return (
            f"commands must be finite numbers: value {k} of robot {i} in step {t} is "
            f"{commands[t, k, i]}"
        )
    robot = int(np.argwhere(~np.isfinite(state[:3]).all(axis=0))[0, 0])
    return f"the pose of robot {robot} outgrew every number, or its law gave no number"
