"""Many robots at once: what users call."""

from __future__ import annotations

from collections.abc import Mapping

import numpy.typing as npt

from trundle.robot import Robot
from trundle.simulation.rollout import devices
from trundle.simulation.rollout.commands import Commands
from trundle.simulation.rollout.exchange import read_pose
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.plan import make_plan
from trundle.simulation.rollout.prepared import PreparedRollout
from trundle.simulation.rollout.reducers import Reducer
from trundle.simulation.rollout.result import Rollouts
from trundle.simulation.rollout.saving import Every


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
