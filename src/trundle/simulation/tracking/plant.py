"""A robot's constants for the closed loop, as flat sequences of floats."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from trundle.dynamics import Dynamics, Reduced
from trundle.errors import TrundleError
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.tracking.compiled import Constants
from trundle.simulation.tracking.laws import PER_WHEEL


class Plant(NamedTuple):
    """What moves: the body and its wheels, of a robot that does not steer."""

    dynamics: Dynamics
    here: Reduced
    body: tuple[float, ...]  # mass, centre of mass (2), P (6)
    wheels: tuple[float, ...]  # 11 numbers for each wheel that rolls
    unlimited: tuple[float, ...]  # the same without the driven wheels' limits
    acting: int  # 0 where neither limits nor friction come between command and body
    allocation: Array  # (n, 3) torques of least norm for a force on the body

    @property
    def G(self) -> Array:
        """The map (n, 3) from the twist to the driven wheels' speeds."""
        return np.asarray(self.here.G[self.here.driven])

    def constants(self, gains: tuple[float, ...], plain: bool, limited: bool = True) -> Constants:
        """Return the constants of a closed loop with this plant.

        Args:
            gains: those of the law.
            plain: whether heading errors are the plain difference.
            limited: whether torques are cut to their limits; not where they already are.
        """
        wheels = self.wheels if limited else self.unlimited
        return Constants(gains, self.body, wheels, self.acting, not plain)


@lru_cache(maxsize=32)
def plant_of(robot: Robot) -> Plant:
    """Return the constants of a robot that does not steer."""
    dynamics = Dynamics(robot)
    here = dynamics.reduced()
    table = wheel_table(dynamics, here)
    unlimited = table.copy()
    unlimited[here.driven, 6:9] = np.inf, np.inf, 0.0
    plain = not (dynamics.torque_limits.any or table[:, 9:].any())
    return Plant(
        dynamics=dynamics,
        here=here,
        body=tuple(body_numbers(dynamics, here).tolist()),
        wheels=tuple(table.ravel().tolist()),
        unlimited=tuple(unlimited.ravel().tolist()),
        acting=0 if plain else len(table),
        allocation=here.allocation(),
    )


def body_numbers(dynamics: Dynamics, here: Reduced) -> Array:
    """Return mass, centre of mass and the six numbers of P (..., 9)."""
    P = here.inverse()[..., *np.triu_indices(3)]
    return np.concatenate([np.asarray(dynamics.mass)[..., None], dynamics.com, P], axis=-1)


def wheel_table(dynamics: Dynamics, here: Reduced) -> Array:
    """Return the numbers (..., w, 11) of the wheels that roll, in order."""
    G = here.G
    table = np.zeros((*G.shape[:-1], PER_WHEEL))
    table[..., here.driven, :3] = here.allocation()
    table[..., 3:6] = G
    table[..., here.driven, 6:9] = np.stack(dynamics.torque_limits, axis=-1)
    table[..., 9:] = np.stack(dynamics.friction_coefficients, axis=-1)
    return table


def check_pushable(robot: Robot, plant: Plant) -> None:
    """Refuse forces on a robot whose wheels cannot give them all."""
    rank = int(np.linalg.matrix_rank(plant.allocation))
    if rank < 3:
        raise TrundleError(
            f"robot {robot.name!r}: its wheels can push it in {rank} of 3 ways, and this "
            "controller asks for forces in all: use one for robots that cannot move sideways, "
            "such as trundle.control.Kanayama or trundle.control.ReducedComputedTorque"
        )
