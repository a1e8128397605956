"""Any trajectory, looked at over many times."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Real
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.motion.trajectory import Trajectory
from trundle.se2 import Array


class AnyTrajectory(Protocol):
    """Where to be: pose, velocity and acceleration over time.

    (x, y, psi) in the inertial frame and its derivatives; a time gives (3,), times (T,) give
    (T, 3).
    """

    def position(self, t: Any, /) -> Array:
        """Return x, y, psi [m, m, rad]."""

    def velocity(self, t: Any, /) -> Array:
        """Return the first derivative of ``position``."""

    def acceleration(self, t: Any, /) -> Array:
        """Return the second derivative of ``position``."""


class Course(NamedTuple):
    """A trajectory at some times: position, velocity and acceleration, each (T, 3)."""

    position: Array
    velocity: Array
    acceleration: Array


def sample(trajectory: AnyTrajectory, t: npt.ArrayLike) -> Course:
    """Return a trajectory at times (T,) [s].

    Raises:
        TrundleError: this is no trajectory, or it gives wrong shapes or values.

    >>> from trundle import motion
    >>> sample(motion.circle(1.0, 1.0), [0.0, 0.1]).velocity.shape
    (2, 3)
    """
    if isinstance(trajectory, Trajectory):
        return Course(*trajectory.sample(t))
    _check(trajectory)
    times = finite(t, "t")
    return Course(*(_values(getattr(trajectory, name), times, name) for name in Course._fields))


def _check(trajectory: object) -> None:
    """Refuse what is no trajectory."""
    for name in Course._fields:
        if not callable(getattr(trajectory, name, None)):
            raise TrundleError(
                f"a trajectory has position(t), velocity(t) and acceleration(t); {trajectory!r} "
                f"has no {name}"
            )


def length(trajectory: AnyTrajectory, duration: float | None) -> float:
    """Return the duration that is given, else the trajectory's own [s].

    Raises:
        TrundleError: there is neither, or it is not a positive number.
    """
    _check(trajectory)
    own = getattr(trajectory, "duration", None) if duration is None else duration
    if own is None:
        raise TrundleError("give a duration: this trajectory does not tell how long it lasts")
    if isinstance(own, bool) or not isinstance(own, Real) or not 0 < float(own) < np.inf:
        raise TrundleError(f"duration must be a positive number of seconds, got {own!r}")
    return float(own)


def _values(function: Callable[[Any], npt.ArrayLike], t: Array, name: str) -> Array:
    """Return a function's values (T, 3): in one call where it takes arrays of times."""
    first = finite(function(float(t[0])), f"{name}(t)")
    if first.shape != (3,):
        raise ShapeError(f"{name}(t) must have shape (3,) at one time, got {first.shape}")
    try:
        values = np.asarray(function(t), dtype=np.float64)
    except Exception:  # noqa: BLE001  a user's function may fail in any way on an array of times
        values = first
    # With three times nobody can tell rows from columns.
    if values.shape == (len(t), 3) and len(t) != 3:
        return finite(values, f"{name}(t)")
    rows = [finite(function(float(time)), f"{name}(t)") for time in t]
    for time, row in zip(t, rows, strict=True):
        if row.shape != (3,):
            raise ShapeError(f"{name}(t) must have shape (3,), got {row.shape} at t = {time:g} s")
    return np.array(rows)
