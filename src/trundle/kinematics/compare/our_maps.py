"""What the robot offers: its own maps at its steering angles, and those of a changed robot.

Maps are compared as the inverse map ``B = R^-1 A`` (n, 3) of the n driven wheels, where a change
of one wheel or of one component of the twist touches a single row or column; a pseudo-inverse
would spread it over all columns.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.errors import TrundleError
from trundle.kinematics.constraints import gains, rolling_matrix, steering_array
from trundle.kinematics.linear import pseudo_inverse
from trundle.kinematics.maps import motion_projector, wheel_matrix
from trundle.kinematics.model import Kinematics
from trundle.robot import Robot, RollingWheel, SwedishWheel
from trundle.se2 import Array

# What the rows of a forward matrix, and the columns of an inverse, belong to.
COMPONENTS = ("VX", "VY", "WZ")
# Computed twice in double precision, with nine digits in a file: far below every change here.
EXACT = 1e-6


@dataclass(frozen=True)
class OurMaps:
    """The maps of a robot with n driven wheels, at its steering angles.

    Attributes:
        robot: the robot.
        steering: (s,) steering angles [rad].
        names: of the driven wheels.
        radii: (n,) of the driven wheels [m].
        rollers: (n,) roller angles [rad], zero for wheels without rollers.
        weights: (n,) size of the diagonal of R: speed along the rolling row for one rad/s [m].
        allowed: (3, 3) projector onto the twists without side slip.
        feasible: (3, 3) projector onto those of them that the driven wheels give.
        inverse: (n, 3) inverse map, twist to wheel speeds [rad/s].
        mirrored: (n, 3) the same with all rollers mirrored.
    """

    robot: Robot
    steering: Array
    names: tuple[str, ...]
    radii: Array
    rollers: Array
    weights: Array
    allowed: Array
    feasible: Array
    inverse: Array
    mirrored: Array

    def matrix(self, form: str, rim: bool, order: Sequence[int] | None = None) -> Array:
        """Return our matrix, (3, n) "forward" or (n, 3) "inverse", for wheels in an order."""
        wheels = list(range(len(self.names)) if order is None else order)
        if form == "forward":
            return np.asarray((self.forward(self.inverse) / self.units(rim))[:, wheels])
        return np.asarray((self.units(rim)[:, None] * self.inverse)[wheels])

    def forward(self, inverse: Array) -> Array:
        """Return the forward map (3, n) that belongs to an inverse map (n, 3)."""
        rolling = self.weights[:, None] * inverse
        return pseudo_inverse(rolling @ self.allowed)[0] * self.weights

    def units(self, rim: bool) -> Array:
        """Return what (n,) one rad/s of each wheel is in rim speed [m/s], or in rad/s: one."""
        return self.radii if rim else np.ones(len(self.radii))

    def arms(self, inverse: Array) -> Array:
        """Return what (n,) each rim runs for one radian of yaw [m], by an inverse map (n, 3)."""
        return np.asarray(inverse[:, 2] * self.radii)

    @property
    def one_radius(self) -> bool:
        """Whether all driven wheels have the same radius."""
        return bool(np.ptp(self.radii) <= EXACT * self.radii[0])

    @property
    def has_rollers(self) -> bool:
        """Whether mirrored rollers would make another robot."""
        return bool(self.rollers.any())

    @property
    def turns(self) -> bool:
        """Whether the robot can turn about its origin, so that the yaw arms say something."""
        return bool(self.feasible[2, 2] > 1 - EXACT)

    @property
    def planar(self) -> bool:
        """Whether the robot has no sideways motion, so that VY may be left out."""
        return bool(np.abs(self.feasible[1]).max() < EXACT)


def our_maps(robot: Robot, steering: npt.ArrayLike | None) -> OurMaps:
    """Return the maps of a robot at steering angles (s,) [rad].

    Raises:
        ShapeError: the steering angles of a robot that steers are missing.
        OffCentreError: the steering angles share no instantaneous centre.
        TrundleError: no driven wheel moves the robot.
    """
    Kinematics(robot).wheel_matrix(steering)  # raises where the angles share no centre
    angles = steering_array(robot, steering)
    wheels = robot.driven
    _, feasible = wheel_matrix(robot, angles)
    if np.trace(feasible) < 0.5:
        raise TrundleError(
            f"robot {robot.name!r}: no driven wheel moves it, so there is nothing to compare"
        )
    return OurMaps(
        robot=robot,
        steering=angles,
        names=tuple(wheel.name for wheel in wheels),
        radii=np.array([wheel.radius for wheel in wheels]),
        rollers=np.array([w.roller if isinstance(w, SwedishWheel) else 0.0 for w in wheels]),
        weights=np.abs(gains(wheels)),
        allowed=motion_projector(robot, angles)[0],
        feasible=feasible,
        inverse=inverse_of(robot, angles),
        mirrored=inverse_of(robot, angles, mirrored=True),
    )


def inverse_of(
    robot: Robot, steering: Array, along: float = 1.0, across: float = 1.0, mirrored: bool = False
) -> Array:
    """Return R^-1 A (n, 3), with the driven wheels' x and y scaled or their rollers mirrored."""

    def changed(wheel: RollingWheel) -> RollingWheel:
        wheel = dataclasses.replace(wheel, x=along * wheel.x, y=across * wheel.y)
        if mirrored and isinstance(wheel, SwedishWheel):
            return dataclasses.replace(wheel, roller=-wheel.roller)
        return wheel

    driven = {wheel.name: changed(wheel) for wheel in robot.driven}
    wheels = tuple(driven.get(wheel.name, wheel) for wheel in robot.wheels)
    robot = dataclasses.replace(robot, wheels=wheels)
    rows = rolling_matrix(robot, robot.driven, steering)
    return np.asarray(rows / gains(robot.driven)[:, None])
