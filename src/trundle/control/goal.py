"""A cost for controllers that look ahead: far from a goal, and near circles, is dear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.se2 import Array
from trundle.simulation import Function, Jit, Reducer

# What a touch costs, over what standing just outside of the circle does.
_TOUCH = 100.0
# Numbers before those of the circles.
_BEFORE = 10


def goal_parameters(
    goal: Array, rate: Array, weights: Array, near: float, clearance: float, circles: Array
) -> Array:
    """Return the numbers of the cost.

    Args:
        goal: (3,) where to be [m, m, rad].
        rate: (3,) how that moves on [m/s, m/s, rad/s].
        weights: (3,) w_x, w_y and w_psi.
        near: w_near.
        clearance: from the circles' edges [m].
        circles: (k, 3) centre x, y and radius [m].
    """
    inner, outer = circles[:, 2] ** 2, (circles[:, 2] + clearance) ** 2
    rows = np.stack([circles[:, 0], circles[:, 1], outer, 1.0 / (outer - inner)], axis=-1)
    return np.concatenate([goal, rate, weights, [near], rows.ravel()])


class GoalCost(Reducer):
    """The sum over all steps of what the distance to a goal and the nearness of circles cost.

    With e = pose - goal, where the goal moves on at its velocity, and for each circle n, which
    falls from 1 at its edge to 0 at the clearance::

        w_x e_x^2 + w_y e_y^2 + 2 w_psi (1 - cos e_psi) + w_near sum n^2
        n = max(0, (R^2 - d^2) / (R^2 - radius^2)),  R = radius + clearance

    for the distance d to its centre, of which no root is taken. The heading's error is that of the
    shorter way, without a branch. Inside of a circle n^2 counts as 100.

    Args:
        parameters: as ``goal_parameters`` returns them.
    """

    def __init__(self, parameters: Array) -> None:
        self.parameters = parameters

    def reduction(self, dtype: str) -> _NearGoal:
        """Return the function that adds a step's cost."""
        return _NearGoal((len(self.parameters) - _BEFORE) // 4)

    def constants(self, dt: float, first: int) -> list[Array]:
        """Return the step, and the parameters."""
        return [np.array([float(dt)]), self.parameters]

    def with_parameters(self, parameters: Array) -> GoalCost:
        """Return the same cost with other parameters."""
        return GoalCost(parameters)

    def result(self, collected: Any) -> Array:
        """Return the sums (K,)."""
        return np.asarray(collected.registers[0])


@dataclass(frozen=True)
class _NearGoal:
    """The cost so far, of so many circles."""

    circles: int
    start = (0.0,)

    def make(self, m: Any, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        number, cos = m.number, m.cos
        one, two = m.number(1), m.number(2)
        near = _near(self.circles, m, jit)

        def add(t: Any, pose: Any, _: Any, registers: Any, constants: Any, __: Any) -> Any:
            time = number(t + 1) * constants[0]
            goal, rate, weight = constants[1:4], constants[4:7], constants[7:10]
            x = pose[0] - goal[0] - time * rate[0]
            y = pose[1] - goal[1] - time * rate[1]
            turn = pose[2] - goal[2] - time * rate[2]
            far = weight[0] * (x * x) + weight[1] * (y * y)
            far = far + weight[2] * (two * (one - cos(turn)))
            return (registers[0] + far + constants[_BEFORE] * near(pose, constants),)

        return jit(add)


def _near(circles: int, m: Any, jit: Jit) -> Function:
    """Return (pose, constants) -> what the circles cost."""
    maximum, where = m.maximum, m.where
    zero, one, touch = m.number(0), m.number(1), m.number(_TOUCH)

    def from_circle(k: int) -> Function:
        if k == circles:
            return jit(lambda pose, constants: zero)  # noqa: ARG005
        later = from_circle(k + 1)
        a, b, outer, slope = (1 + _BEFORE + 4 * k + i for i in range(4))

        def near(pose: Any, constants: Any) -> Any:
            x, y = pose[0] - constants[a], pose[1] - constants[b]
            depth = maximum((constants[outer] - (x * x + y * y)) * constants[slope], zero)
            price = where(depth > one, touch, depth * depth)
            return price + later(pose, constants)

        return jit(near)

    return from_circle(0)
