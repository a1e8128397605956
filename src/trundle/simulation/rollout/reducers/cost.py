"""The sum of a cost over a rollout's steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.commands import numbers
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.reading import as_read
from trundle.simulation.rollout.reducers.base import Collected, Reducer

_WANTED = "a function (t, pose, command, parameters) that returns a number"


class CostSum(Reducer):
    """The sum of a cost over all steps: ``sum of cost(t, pose, command, parameters)``.

    Args:
        cost: a function of the time at the end of a step [s], the tuple (x, y, psi) there [m, m,
            rad], the tuple of the step's command as the robot received it (noise included) and the
            tuple of parameters; it returns a number. Like a policy it is compiled where numba is
            installed; without ``if``, numpy reads it over all robots at once.
        parameters: (k,) numbers, or (N, k) where each robot has its own.

    The result is (N,), one sum for each robot. With "float32" it is compensated, as positions are.

    Raises:
        TrundleError: the cost is no function, or gives no number.
        ShapeError: the parameters have another shape.

    >>> from trundle import Constant, load, rollout
    >>> def distance_to_line(t, pose, command, parameters):
    ...     (y,) = parameters
    ...     return abs(pose[1] - y)
    >>> cost = CostSum(distance_to_line, parameters=[1.0])
    >>> straight_on = Constant([1.0, 1.0])
    >>> robot = load("differential")
    >>> rollout(robot, straight_on, dt=0.1, steps=10, save=cost, device="numpy").reduced
    array([10.])
    """

    reads_command = True

    def __init__(self, cost: Callable[..., Any], *, parameters: npt.ArrayLike = ()) -> None:
        if not callable(cost):
            raise TrundleError(f"cost must be {_WANTED}, got {cost!r}")
        values = numbers(parameters, "parameters")
        if values.ndim not in (1, 2):
            raise ShapeError(f"parameters must be (k,) or (N, k) numbers, got {values.shape}")
        self.cost, self.parameters = cost, finite(values, "parameters", values.shape[-1])

    def reduction(self, dtype: str) -> _Sum:
        """Return the function that adds a step's cost."""
        return _Sum(self.cost, dtype == "float32")

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return the step, and the parameters."""
        return [np.array([float(dt)]), self.parameters.T]

    def check(self, command: int) -> None:
        """Try the cost once with plain numbers."""
        zero = np.float64(0)
        rows = np.atleast_2d(self.parameters)
        parameters = tuple(rows[0]) if len(rows) else ()
        try:
            with np.errstate(all="ignore"):
                value = self.cost(zero, (zero,) * 3, (zero,) * command, parameters)
        except (ArithmeticError, ValueError):
            return  # it may be defined elsewhere
        except Exception as error:
            raise TrundleError(f"cost must be {_WANTED}: {error}") from error
        if np.ndim(value) or not isinstance(value, int | float | np.number | np.bool_):
            raise TrundleError(f"cost must be {_WANTED}, got {value!r}")

    def with_parameters(self, parameters: Numbers) -> CostSum:
        """Return the same cost with other parameters."""
        return CostSum(self.cost, parameters=parameters)

    def result(self, collected: Collected) -> Numbers:
        """Return the sums (N,)."""
        total: Numbers = collected.registers[0]
        if not np.isfinite(total).all():
            robot = int(np.flatnonzero(~np.isfinite(total))[0])
            raise TrundleError(f"the cost of robot {robot} is no finite number: {total[robot]}")
        return total


@dataclass(frozen=True)
class _Sum:
    """The sum so far, and if compensated what it has lost to rounding."""

    cost: Function
    compensated: bool

    @property
    def start(self) -> tuple[float, ...]:
        """What the registers hold before the first step."""
        return (0.0, 0.0) if self.compensated else (0.0,)

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        number, cost = m.number, jit(as_read(self.cost, m))

        @jit
        def value(t: Any, pose: Values, command: Values, constants: Values) -> Any:
            return number(cost(number(t + 1) * constants[0], pose, command, constants[1:]))

        def add(
            t: Any, pose: Values, command: Values, registers: Values, constants: Values, _: Any
        ) -> Values:
            return (registers[0] + value(t, pose, command, constants),)

        def add_compensated(
            t: Any, pose: Values, command: Values, registers: Values, constants: Values, _: Any
        ) -> Values:
            wanted = value(t, pose, command, constants) - registers[1]
            total = registers[0] + wanted
            return total, (total - registers[0]) - wanted

        return jit(add_compensated if self.compensated else add)
