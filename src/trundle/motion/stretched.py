"""The same path at another pace, for any trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from trundle.motion.checks import positive
from trundle.motion.course import AnyTrajectory, length
from trundle.motion.trajectory import Trajectory
from trundle.se2 import Array


@final
@dataclass(frozen=True)
class _Stretched:
    """``p(t / factor)``."""

    of: AnyTrajectory
    factor: float
    duration: float | None

    @property
    def plain_heading(self) -> bool:
        """Whether heading errors are plain differences."""
        return bool(getattr(self.of, "plain_heading", False))

    def position(self, t: Any) -> Array:
        """Return x, y, psi [m, m, rad]."""
        return np.asarray(self.of.position(np.divide(t, self.factor)))

    def velocity(self, t: Any) -> Array:
        """Return the first derivative of ``position``."""
        return np.asarray(self.of.velocity(np.divide(t, self.factor))) / self.factor

    def acceleration(self, t: Any) -> Array:
        """Return the second derivative of ``position``."""
        return np.asarray(self.of.acceleration(np.divide(t, self.factor))) / self.factor**2


def stretched(trajectory: AnyTrajectory, factor: float) -> AnyTrajectory:
    """Return any trajectory run through in ``factor`` times the time.

    Velocities are divided by the factor, accelerations by its square. Those of ``trundle.motion``
    have it as a method.

    Args:
        trajectory: any value with position(t), velocity(t) and acceleration(t).
        factor: of time; 2 takes twice as long.

    Raises:
        TrundleError: the factor is not positive, or this is no trajectory.

    >>> from trundle import motion
    >>> slow = stretched(motion.line((0, 0), (4, 0), 2.0), 2.0)
    >>> slow.position(2.0).round(9).tolist()
    [2.0, 0.0, 0.0]
    """
    by = positive(factor, "factor", "")
    if isinstance(trajectory, Trajectory):
        return trajectory.stretched(by)
    own = getattr(trajectory, "duration", None)
    length(trajectory, 1.0 if own is None else own)  # refuses what is no trajectory
    return _Stretched(trajectory, by, None if own is None else by * float(own))
