"""What the geometry doctor says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """A warning about a robot's geometry.

    Attributes:
        code: a fixed word for programs, such as "yaw_arm_cancels".
        message: what was found, with the robot's wheels and numbers.
        remedy: what to do about it.
        wheels: names of the wheels concerned.
    """

    code: str
    message: str
    remedy: str
    wheels: tuple[str, ...] = ()
