"""What a run in closed loop came to, in a few numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.errors import TrundleError
from trundle.se2 import Array
from trundle.simulation import Run


@dataclass(frozen=True)
class Outcome:
    """How well a run kept to its trajectory, and what it took.

    Attributes:
        largest: largest distance from the trajectory [m].
        rms: root mean square of the distance [m].
        largest_turn: largest magnitude of the heading's error [rad].
        rms_turn: root mean square of the heading's error [rad].
        rms_torque: root mean square over wheels and time [N m]; None where torques are unknown.
        work: of the motors over the run [J]; None where torques are unknown.
    """

    largest: float
    rms: float
    largest_turn: float
    rms_turn: float
    rms_torque: float | None
    work: float | None


def errors_of(run: Run, what: str) -> tuple[Array, Array, Array]:
    """Return the trajectory (T + 1, 3) of a run, its errors (T + 1, 3), and distances (T + 1,).

    Raises:
        TrundleError: the run has no trajectory.
    """
    if not isinstance(run, Run):
        raise TrundleError(f"{what} must be a Run, as trundle.track makes it, got {run!r}")
    if run.desired is None or run.error is None:
        raise TrundleError(
            f"{what} has no trajectory that it was to follow: trundle.track makes runs that have "
            "one; trundle.view.plot_path draws others"
        )
    return run.desired, run.error, np.hypot(run.error[:, 0], run.error[:, 1])


def outcome_of(run: Run) -> Outcome:
    """Return what a run in closed loop came to.

    >>> import trundle
    >>> run = trundle.track(
    ...     trundle.load("differential"),
    ...     trundle.motion.circle(radius=2.0, rate=0.3),
    ...     trundle.control.Kanayama(),
    ...     duration=5.0,
    ...     pose=[0.0, -0.3, 0.0],
    ... )
    >>> round(outcome_of(run).largest, 6)
    0.3
    """
    _, error, distance = errors_of(run, "run")
    return Outcome(
        largest=float(distance.max()),
        rms=_rms(distance),
        largest_turn=float(np.abs(error[:, 2]).max()),
        rms_turn=_rms(error[:, 2]),
        rms_torque=None if run.torques is None else _rms(run.torques),
        work=None if run.work is None else float(run.work[-1]),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.square(values).mean())) if values.size else 0.0
