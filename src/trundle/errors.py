"""What can go wrong for a reason that the user can mend; every message says what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class TrundleError(ValueError):
    """Base of every error that trundle raises on bad input."""


class RobotError(TrundleError):
    """A robot description is wrong; ``faults`` has one sentence for each thing to mend."""

    def __init__(self, faults: Iterable[str], where: str = "") -> None:
        self.faults = tuple(faults)
        head = f"{where}: " if where else ""
        if len(self.faults) == 1:
            super().__init__(head + self.faults[0])
        else:
            lines = "".join(f"\n  - {fault}" for fault in self.faults)
            super().__init__(f"{head}{len(self.faults)} faults{lines}")


class ShapeError(TrundleError):
    """An array has the wrong shape or holds values that are not finite numbers."""


class InfeasibleTwistError(TrundleError):
    """The robot cannot have the twist that was asked for (raised with ``strict=True``)."""


class OffCentreError(TrundleError):
    """The steering angles share no instantaneous centre, so the robot cannot roll."""


class UnobservedMotionError(TrundleError):
    """The sensed wheels do not observe every motion that the robot can make."""


class FileError(TrundleError):
    """A file cannot be read, written or understood."""


class UnobservedMotionWarning(UserWarning):
    """A twist was estimated although the wheels do not observe every motion."""


class TrajectoryWarning(UserWarning):
    """A trajectory's velocity or acceleration is not the rate of what it derives."""


class SpeedWarning(UserWarning):
    """Something runs much slower than it could; the message says how to get the speed."""


class StabilityWarning(UserWarning):
    """A simulated loop is unstable: its step is too long, or its gains are."""


class GuessWarning(UserWarning):
    """A robot's file leaves open what was then guessed; the message lists it."""


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """Return the end of a message that names the nearest known word, or "".

    >>> did_you_mean("raduis", ["radius", "arm"])
    ": did you mean 'radius'?"
    """
    close = difflib.get_close_matches(str(given), list(known), n=1)
    return f": did you mean {close[0]!r}?" if close else ""
