"""What a rollout keeps of the poses."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral

from trundle.errors import TrundleError


@dataclass(frozen=True)
class Every:
    """Keep the pose of every so many steps, the start's among them.

    >>> Every(10).rows(steps=100)
    11
    """

    steps: int

    def __post_init__(self) -> None:
        """Check the number of steps."""
        if isinstance(self.steps, bool) or not isinstance(self.steps, Integral) or self.steps < 1:
            raise TrundleError(f"Every needs a whole number of steps from 1 on, got {self.steps!r}")

    def rows(self, steps: int) -> int:
        """Return how many poses of a robot are kept."""
        return steps // self.steps + 1
