"""The call that a control loop makes: in one piece, and without a closer look at what is given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from trundle.simulation.arithmetic import Function, as_is
from trundle.simulation.rollout.commands import Commands, Given
from trundle.simulation.rollout.loop import DONE, Arguments, Numbers
from trundle.simulation.rollout.plan import Plan
from trundle.simulation.rollout.result import Rollouts

Quick = Callable[[Any, Any], Rollouts | None]


def reader(plan: Plan, commands: Commands) -> Callable[[Numbers, str], Numbers] | None:
    """Return how commands are read, if nothing else is done about them, and poses are all kept."""
    poses = plan.steps > 0 and not plan.every and plan.reducer is None
    simple = poses and plan.drive.motion.kept == 3 and plan.drive.arrange is as_is
    if simple and isinstance(commands, Given) and commands.steering is None:
        return commands.read
    return None


def make_quick(
    read: Callable[[Numbers, str], Numbers], loop: Function, first: Arguments, dt: float
) -> Quick:
    """Return (commands, pose) -> where the robots go; or None, where they must be looked at.

    To look more closely, and to gather the arguments anew, takes longer than a robot's step.

    Args:
        read: from commands as they are given to those that the loop reads.
        loop: the compiled loop over the robots from lo to hi.
        first: what it was made for, of which commands and state change.
        dt: time from start to end [s].
    """
    _, steps, commands, moving, shared, own, table, key, start, every, out, sums, summed = first
    wanted, dtype, count, array = commands.shape, start.dtype, start.shape[1], np.ndarray
    poses = (count, 3)

    def quick(given: Any, pose: Any) -> Rollouts | None:
        if not isinstance(given, array) or given.dtype != dtype:
            return None
        values = read(given, "commands")
        if values.shape != wanted:
            return None
        state = start.copy()
        if pose is not None:
            if not isinstance(pose, array) or pose.shape != poses or pose.dtype.kind != "f":
                return None
            state[:3] = pose.T
        end = loop(
            0, count, 0, 0, steps, values, moving, shared, own, table, key, state, every, out,
            sums, summed,
        )  # fmt: skip
        # What is no number in what is given shows in the poses that follow.
        if end != DONE:
            return None
        buffer = state[:3]
        final = buffer.T
        return Rollouts(final, buffer, final, dt, None, "cpu")

    return quick
