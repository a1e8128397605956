"""Any trajectory, looked at over many times."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from numbers import Real
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrajectoryWarning, TrundleError
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
    course = Course(*(_values(getattr(trajectory, name), times, name) for name in Course._fields))
    _compare(trajectory, course, times)
    return course


# Where derivatives are compared with differences: so few times that it costs nothing, so many that
# a corner does not decide.
_LOOKS, _STEP, _DIFFER = 7, 1e-5, 1e-2


def _compare(trajectory: AnyTrajectory, course: Course, t: Array) -> None:
    """Warn where velocity or acceleration of x and y are not the rates of what they derive."""
    if len(t) < _LOOKS:
        return
    at = np.linspace(1, len(t) - 2, _LOOKS).astype(int)
    step = _STEP * max(float(t[-1] - t[0]), 1e-300)
    for name, rate in (("position", "velocity"), ("velocity", "acceleration")):
        function = getattr(trajectory, name)
        ends = [
            np.array([np.array(function(float(time)))[:2] for time in t[at] + side])
            for side in (-step, step)
        ]
        slope = (ends[1] - ends[0]) / (2 * step)
        given = getattr(course, rate)[at, :2]
        size = 1e-6 + np.maximum(np.abs(slope), np.abs(given)).max()
        wrong = (np.abs(slope - given) > _DIFFER * size).any(axis=1)
        if wrong.sum() > _LOOKS // 2:
            k = int(np.flatnonzero(wrong)[0])
            warnings.warn(
                f"{rate}(t) is not the rate of {name}(t): at t = {t[at[k]]:.4g} s it gives "
                f"{given[k].round(6).tolist()} for x and y, and {name}(t) changes by "
                f"{slope[k].round(6).tolist()} a second",
                TrajectoryWarning,
                stacklevel=5,
            )


def _check(trajectory: object) -> None:
    """Refuse what is no trajectory."""
    if isinstance(trajectory, type):
        raise TrundleError(f"give a trajectory, such as {trajectory.__name__}(...), not its class")
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
