"""How close robots come to circles, and when they touch them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.reducers.base import Collected, Reducer, first_times

# Beyond every distance, and a number in both types.
_LARGE = 3e38


@dataclass(frozen=True, eq=False)
class Contacts:
    """How close N robots came to obstacles.

    Attributes:
        time: (N,) end of the first step after which the robot touched one [s]; infinity if never.
        clearance: (N,) least distance between the robot's circle and an obstacle [m], negative
            where they overlapped; infinity without any step.
    """

    time: Numbers
    clearance: Numbers


class Collision(Reducer):
    """The least clearance of each robot to circles, and the time of the first contact.

    Robots are looked at after each step, not at the start. The result is a ``Contacts``.

    Args:
        circles: (k, 3) centres and radii x, y, radius in the inertial frame [m]. Other numbers
            need no new compilation, another count does.
        robot_radius: radius of a circle about the robot's origin that holds the robot [m].

    Raises:
        TrundleError: a radius is negative, or a number is not finite.
        ShapeError: the circles have another shape.

    >>> from trundle import Constant, load, rollout
    >>> ahead = Collision([[1.0, 0.0, 0.2]], robot_radius=0.301)
    >>> contacts = rollout(
    ...     load("differential"),
    ...     Constant([2.0, 2.0]),
    ...     dt=0.1,
    ...     steps=80,
    ...     save=ahead,
    ...     device="numpy",
    ... ).reduced
    >>> contacts.time.round(6), contacts.clearance.round(6)
    (array([5.]), array([-0.301]))
    """

    def __init__(self, circles: npt.ArrayLike, robot_radius: float = 0.0) -> None:
        values = finite(circles, "circles", 3)
        if values.ndim != 2 or not len(values):
            raise ShapeError(
                f"circles must be (k, 3): x, y and radius of one or more, got {values.shape}"
            )
        for k, (_, _, radius) in enumerate(values):
            if radius < 0:
                raise TrundleError(f"circle {k}: radius must not be negative, got {radius:g} m")
        self.circles, self.robot_radius = values, read_radius(robot_radius)

    def reduction(self, dtype: str) -> Contact:
        """Return the function that keeps the least clearance."""
        return Contact(_ToCircles(len(self.circles)))

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return the circles, each as large as if the robot were a point."""
        return [(self.circles + np.array([0.0, 0.0, self.robot_radius])).ravel()]

    def result(self, collected: Collected) -> Contacts:
        """Return times and clearances."""
        return contacts_of(collected)


def read_radius(radius: float) -> float:
    """Return a robot's radius."""
    value = float(finite(np.atleast_1d(radius), "robot_radius", 1)[0])
    if value < 0:
        raise TrundleError(f"robot_radius must not be negative, got {value:g} m")
    return value


def contacts_of(collected: Collected) -> Contacts:
    """Return what the registers of a ``Contact`` hold."""
    steps, clearance = collected.registers
    if not collected.steps:
        clearance = np.full_like(clearance, np.inf)
    return Contacts(first_times(steps, collected.dt), clearance)


@dataclass(frozen=True)
class Contact:
    """How many steps it took to the first contact, -1 if there was none; the least clearance.

    Attributes:
        clearance: makes the function (x, y, constants, table) of a robot's clearance; hashable.
    """

    clearance: Any
    start = (-1.0, _LARGE)

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        number, where, minimum = m.number, m.where, m.minimum
        zero, one, two = m.number(0), m.number(1), m.number(2)
        clearance = self.clearance.make(m, jit)

        def reduce(
            t: Any, pose: Values, _: Values, registers: Values, constants: Values, table: Any
        ) -> Values:  # fmt: skip
            least = minimum(registers[1], clearance(pose[0], pose[1], constants, table))
            # 1 at the first contact: then -1 becomes the number of steps.
            now = where(registers[0] < zero, one, zero) * where(least > zero, zero, one)
            return registers[0] + now * (number(t) + two), least

        return jit(reduce)


@dataclass(frozen=True)
class _ToCircles:
    """Clearance to so many circles, one after the other: compilers make vectors of that."""

    count: int

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (x, y, constants, table) -> the distance to the nearest circle's rim."""
        sqrt, minimum = m.sqrt, m.minimum

        @jit
        def to_circle(x: Any, y: Any, circle_x: Any, circle_y: Any, radius: Any) -> Any:
            dx, dy = x - circle_x, y - circle_y
            return sqrt(dx * dx + dy * dy) - radius

        return jit(_nearest(self.count)(to_circle, minimum))


@cache
def _nearest(count: int) -> Callable[[Function, Function], Function]:
    """Return a function of ``to_circle`` and ``minimum`` that makes the function, written out."""
    nearest = "to_circle(x, y, c[0], c[1], c[2])"
    lines = [f"        least = {nearest}"]
    for k in range(1, count):
        x, y, radius = (f"c[{3 * k + i}]" for i in range(3))
        lines.append(f"        least = minimum(least, to_circle(x, y, {x}, {y}, {radius}))")
    source = ["def make(to_circle, minimum):", "    def nearest(x, y, c, table):", *lines]
    names: dict[str, Any] = {}
    exec("\n".join([*source, "        return least", "    return nearest"]), names)
    made: Callable[[Function, Function], Function] = names["make"]
    return made
