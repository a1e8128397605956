"""A robot's constants for the closed loop, as flat sequences of floats."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.dynamics import Dynamics, Reduced
from trundle.robot import RollingWheel
from trundle.se2 import Array
from trundle.simulation.tracking.compiled import Constants


class Plant(NamedTuple):
    """What moves: the body and its wheels, at the steering angles of a robot that has none."""

    dynamics: Dynamics
    here: Reduced
    body: list[float]  # mass, centre of mass (2), P (6)
    wheels: list[float]  # 11 numbers for each wheel that rolls
    acting: int  # 0 where neither limits nor friction come between command and body
    allocation: Array  # (n, 3) torques of least norm for a force on the body

    @property
    def G(self) -> Array:
        """The map (n, 3) from the twist to the driven wheels' speeds."""
        return np.asarray(self.here.G[self.here.driven])

    def constants(self, gains: list[float], plain: bool) -> Constants:
        """Return the constants of a closed loop with this plant.

        Args:
            gains: those of the law.
            plain: whether heading errors are the plain difference.
        """
        return Constants(gains, self.body, self.wheels, self.acting, 0.0 if plain else 1.0)


def plant_of(dynamics: Dynamics) -> Plant:
    """Return the constants of a robot that does not steer."""
    here = dynamics.reduced()
    P = here.inverse()
    body = [dynamics.mass, *dynamics.com, P[0, 0], P[0, 1], P[0, 2], P[1, 1], P[1, 2], P[2, 2]]
    rolling = [wheel for wheel in dynamics.robot.wheels if isinstance(wheel, RollingWheel)]
    table = np.zeros((len(rolling), 11))
    allocation = here.allocation()
    table[here.driven, :3] = allocation
    table[:, 3:6] = here.G
    table[here.driven, 6:9] = np.stack(dynamics.torque_limits, axis=-1)
    table[:, 9:] = np.stack(dynamics.friction_coefficients, axis=-1)
    plain = not (dynamics.torque_limits.any or table[:, 9:].any())
    return Plant(
        dynamics=dynamics,
        here=here,
        body=[float(value) for value in body],
        wheels=[float(value) for value in table.ravel()],
        acting=0 if plain else len(rolling),
        allocation=allocation,
    )
