"""Resolved-rate control: twists for robots that can move every way, if need be by steering."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
import numpy.typing as npt

from trundle.control.gains import three_gains
from trundle.dynamics import to_body
from trundle.se2 import Array
from trundle.simulation import Measurement, Reference


@final
@dataclass(frozen=True)
class ResolvedRate:
    """Trajectory tracking by twists: each error dies out by itself, ``e_dot = -K e``.

    ``zeta = J(psi)^T (q_dot_des + K e)``, e = desired minus actual pose. It suits robots that can
    move sideways: omni, mecanum, and those that steer all their wheels.

    Args:
        k: (3,) gains on x, y and psi [1/s].

    Source: Whitney, Resolved motion rate control of manipulators and human prostheses, IEEE
    Transactions on Man-Machine Systems 10(2), 1969; the law is that of Lynch and Park, Modern
    Robotics, 2017, section 13.4.1 for omnidirectional robots.

    >>> here = Measurement(0.0, np.array([0.0, 0.0, np.pi / 2]), np.zeros(3))
    >>> ahead = Reference(np.array([0.1, 0.0, np.pi / 2]), np.zeros(3), np.zeros(3))
    >>> ResolvedRate(k=[2, 2, 2]).step(None, here, ahead)[0].round(9).tolist()
    [0.0, -0.2, 0.0]
    """

    k: npt.ArrayLike = (2.0, 2.0, 2.0)
    output: ClassVar[str] = "twist"

    def __post_init__(self) -> None:
        object.__setattr__(self, "k", three_gains(self.k, "k"))

    def step(
        self, state: None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, None]:
        """Return the twist (u, v, r) in the body frame; there is no memory."""
        error, psi = reference.error(measurement.pose), float(measurement.pose[2])
        x_dot, y_dot, r = (reference.velocity + np.asarray(self.k) * error).tolist()
        u, v = to_body(math.cos(psi), math.sin(psi), x_dot, y_dot)
        return np.array([u, v, r]), None
