"""What a rollout returns."""

from __future__ import annotations

from typing import Any, NamedTuple

from trundle.simulation.rollout.loop import Numbers


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
