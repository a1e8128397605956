"""From a robot and its commands to the constants of the loops."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.kinematics import Kinematics, mobility, motion_projector
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.rollout.commands import Commands, Given, Policy
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Linear, Motion
from trundle.simulation.rollout.written import converted


@dataclass(frozen=True)
class PolicyLaw:
    """A policy's function, with the step and the policy's parameters as its constants."""

    step: Any
    parameters: int
    command: int

    @property
    def constants(self) -> int:
        """How many constants the function takes."""
        return 1 + self.parameters

    def make(self, m: Any, jit: Any) -> Any:
        """Return (t, pose, constants) -> the command."""
        number, step, as_numbers = m.number, jit(self.step), jit(converted(self.command))

        def law(t: Any, pose: Any, constants: Any) -> Any:
            return as_numbers(number, step(number(t) * constants[0], pose, constants[1:]))

        return jit(law)


def motion_of(robot: Robot, commands: Commands, dt: float, method: str) -> tuple[Motion, Numbers]:
    """Return how the commands move the robot, and the constants of that."""
    check_driven(robot)
    matrix = allowed_twists(robot) if is_twist(commands) else Kinematics(robot).W
    scaled = dt * matrix * np.array([[1.0], [1.0], [0.5]])
    return Linear(matrix.shape[1], method), scaled.ravel()


def is_twist(commands: Commands) -> bool:
    """Whether the commands are twists."""
    if isinstance(commands, Policy):
        return commands.output == "twist"
    return isinstance(commands, Given) and commands.is_twist


@lru_cache(maxsize=32)
def check_driven(robot: Robot) -> None:
    """Refuse robots with a motion that nothing drives.

    Raises:
        TrundleError: the robot has too few driven wheels; the motions are named.
    """
    if not robot.driven:
        raise TrundleError(f"robot {robot.name!r} has no driven wheel: nothing moves it")
    if undriven := mobility(robot).undriven:
        raise TrundleError(
            f"robot {robot.name!r} has too few driven wheels: nothing drives "
            f"{' and '.join(undriven)}, so that the wheels do not tell where it goes"
        )


@lru_cache(maxsize=32)
def allowed_twists(robot: Robot) -> Array:
    """Return the projector (3, 3) onto the twists that the wheels allow at some steering angle."""
    if not robot.steered:
        return motion_projector(robot, np.zeros(0))[0]
    raise TrundleError("steered robots: to do")


def command_of(robot: Robot, commands: Commands) -> tuple[int, str]:
    """Return how many numbers a command has, and what they are."""
    if is_twist(commands):
        return 3, "(u, v, r)"
    names = ", ".join(wheel.name for wheel in robot.driven)
    return len(robot.driven), f"the speeds of {names}"
