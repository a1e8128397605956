"""How close robots come to obstacles that a grid of distances tells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.reducers.base import Collected, Reducer
from trundle.simulation.rollout.reducers.collision import (
    Contact,
    Contacts,
    contacts_of,
    read_radius,
)

# Places in a table are told as numbers, and a float32 holds so many whole numbers.
_MOST = 2**24


class GridCollision(Reducer):
    """The least clearance of each robot to what a distance grid tells, and the first contact.

    Between the grid's points distances are interpolated bilinearly; beyond its border they are
    those of the nearest point of the border. Robots are looked at after each step, not at the
    start. The result is a ``Contacts``.

    Args:
        distance: (rows, columns) distances to the nearest obstacle [m], negative inside of one:
            rows along y, columns along x, two of each at least.
        origin: (2,) place x, y of ``distance[0, 0]`` in the inertial frame [m].
        resolution: distance between two neighbouring points of the grid [m].
        robot_radius: radius of a circle about the robot's origin that holds the robot [m].

    Raises:
        TrundleError: a number is not finite, the resolution is not positive, a radius is negative.
        ShapeError: the grid or its origin has another shape.

    >>> from trundle import Constant, load, rollout
    >>> to_wall_at_x_1 = np.tile([1.0, 0.5, 0.0], (2, 1))
    >>> wall = GridCollision(to_wall_at_x_1, origin=[0.0, 0.0], resolution=0.5, robot_radius=0.301)
    >>> contacts = rollout(
    ...     load("differential"),
    ...     Constant([2.0, 2.0]),
    ...     dt=0.1,
    ...     steps=80,
    ...     save=wall,
    ...     device="numpy",
    ... ).reduced
    >>> contacts.time.round(6), contacts.clearance.round(6)
    (array([7.]), array([-0.101]))
    """

    def __init__(
        self,
        distance: npt.ArrayLike,
        origin: npt.ArrayLike,
        resolution: float,
        robot_radius: float = 0.0,
    ) -> None:
        shape = np.shape(distance)
        if len(shape) != 2 or min(shape) < 2:
            raise ShapeError(
                f"distance must have two rows and two columns, or more of them, got {shape}"
            )
        if shape[0] * shape[1] > _MOST:
            raise ShapeError(f"distance must have at most {_MOST} points, got {shape}")
        self.shape = shape
        self.table = finite(distance, "distance", shape[1]).ravel()
        self.origin = finite(origin, "origin", 2)
        if self.origin.shape != (2,):
            raise ShapeError(f"origin must be x and y, got {self.origin.shape}")
        self.resolution = float(finite(np.atleast_1d(resolution), "resolution", 1)[0])
        if self.resolution <= 0:
            raise TrundleError(f"resolution must be positive, got {self.resolution:g} m")
        self.robot_radius = read_radius(robot_radius)

    def reduction(self, dtype: str) -> Contact:
        """Return the function that keeps the least clearance."""
        return Contact(_InGrid())

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return where the grid lies, in the plane and in the table."""
        if first + self.table.size > _MOST:
            raise TrundleError(f"the distance grids together have more than {_MOST} points")
        rows, columns = self.shape
        return [
            np.array([*self.origin, 1 / self.resolution, self.robot_radius, columns, rows, first])
        ]

    def result(self, collected: Collected) -> Contacts:
        """Return times and clearances."""
        return contacts_of(collected)


@dataclass(frozen=True)
class _InGrid:
    """Clearance that a grid in the table tells."""

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (x, y, constants, table) -> the grid's distance without the robot's radius."""
        number, whole, minimum, maximum = m.number, m.whole, m.minimum, m.maximum
        zero, two, first_cell = m.number(0), m.number(2), m.whole(0)
        one = m.number(1)

        @jit
        def cell(place: Any, count: Any) -> tuple[Any, Any]:
            """Return the cell that a place lies in, and how far: from 0 to 1."""
            inside = minimum(maximum(place, zero), count - one)
            # Once more as whole numbers: what is no number must not be looked up anywhere.
            number_of_cell = minimum(maximum(whole(inside), first_cell), whole(count - two))
            return number_of_cell, inside - number(number_of_cell)

        def clearance(x: Any, y: Any, constants: Values, table: Any) -> Any:
            left, bottom, per_cell, radius, columns, rows, first = constants
            i, right = cell((x - left) * per_cell, columns)
            j, up = cell((y - bottom) * per_cell, rows)
            below = whole(first) + j * whole(columns) + i
            above = below + whole(columns)
            low = table[below] + right * (table[below + 1] - table[below])
            high = table[above] + right * (table[above + 1] - table[above])
            return low + up * (high - low) - radius

        return jit(clearance)
