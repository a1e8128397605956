"""What passes between a controller and the robot: measurement, reference, command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from trundle.motion import Course
from trundle.se2 import Array, wrap

if TYPE_CHECKING:
    from trundle.dynamics import Dynamics
    from trundle.simulation.tracking.laws import Law


class Measurement(NamedTuple):
    """What a controller is told of the robot.

    Attributes:
        t: time [s].
        pose: (3,) x, y, psi in the inertial frame [m, m, rad].
        rate: (3,) their rates [m/s, m/s, rad/s].
    """

    t: float
    pose: Array
    rate: Array


class Reference(NamedTuple):
    """What a controller is to reach.

    Attributes:
        position: (3,) desired x, y, psi in the inertial frame [m, m, rad].
        velocity: (3,) its first derivative.
        acceleration: (3,) its second derivative.
        plain_heading: whether heading errors are the plain difference, as in the lectures,
            instead of the shorter way round.
    """

    position: Array
    velocity: Array
    acceleration: Array
    plain_heading: bool = False

    def error(self, pose: npt.ArrayLike) -> Array:
        """Return desired minus actual pose (..., 3), the heading by the shorter way round.

        >>> here = Reference(np.array([1.0, 0.0, 3.0]), np.zeros(3), np.zeros(3))
        >>> here.error([0.0, 0.0, -3.0]).round(6).tolist()
        [1.0, 0.0, -0.283185]
        """
        error = np.asarray(self.position - np.asarray(pose, dtype=np.float64))
        if not self.plain_heading:
            error[..., 2] = wrap(error[..., 2])
        return error


class Controller(Protocol):
    """A law from what is measured and wanted to a command.

    ``output`` says what its commands are: "force" (F_x, F_y, M_z) on the body in the inertial
    frame [N, N, N m], "torques" of the n motors at the wheels [N m], or "twist" (u, v, r) in the
    body frame [m/s, m/s, rad/s]. ``state`` is None at the start, and what it returned last later.
    """

    @property
    def output(self) -> str:
        """What the commands are."""

    def step(
        self, state: Any, measurement: Measurement, reference: Reference, /
    ) -> tuple[npt.ArrayLike, Any]:
        """Return the command, and the state for the next step."""


@runtime_checkable
class ScalarController(Controller, Protocol):
    """A controller of forces whose law is written in scalars, so that the loops can evaluate it.

    It has no memory, and its ``step`` gives what its law gives.
    """

    @property
    def scalar_law(self) -> Law:
        """The law; ``laws.Law`` says what it takes and returns."""

    @property
    def scalar_constants(self) -> Array:
        """The law's constants."""


@runtime_checkable
class ModelController(Controller, Protocol):
    """A controller that takes a model of the robot where it has none of its own."""

    def with_model(self, model: Dynamics, /) -> Controller:
        """Return the controller with a model."""


def reference(course: Course, k: int, plain: bool) -> Reference:
    """Return what is desired at one of a course's times."""
    at, going, rising = (each[k].copy() for each in course)
    return Reference(at, going, rising, plain)
