"""The sum of a cost over a rollout's steps."""

from __future__ import annotations

import copy
import types
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.commands import numbers
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import Values
from trundle.simulation.rollout.reading import (
    as_read,
    plain_function,
    reason_of,
    what_it_reads,
)
from trundle.simulation.rollout.reducers.base import Collected, Reducer

_WANTED = "a function (t, pose, command, parameters) that returns a number"


class CostSum(Reducer):
    """The sum of a cost over all steps: ``sum of cost(t, pose, command, parameters)``.

    Args:
        cost: a function of the time at the end of a step [s], the tuple (x, y, psi) there [m, m,
            rad], the tuple of the step's command as the robot received it (noise included) and the
            tuple of parameters; it returns a number. Like a policy it is compiled where numba is
            installed; numpy reads it over all robots at once, or if it cannot be, as with ``if``,
            for one robot after the other.
        parameters: (k,) numbers, or (N, k) where each robot has its own.

    The result is (N,), one sum for each robot. With "float32" it is compensated, as positions are.

    Raises:
        TrundleError: the cost is no plain function of four arguments, fails, or gives no number.
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
        self.cost = plain_function(cost, "t, pose, command, parameters")
        self.parameters = finite(values, "parameters", values.shape[-1])
        self._command = 0  # how many numbers a command is, once that was checked

    def reduction(self, dtype: str) -> _Sum:
        """Return the function that adds a step's cost."""
        counts = self._command, self.parameters.shape[-1]
        return _Sum(self.cost, counts, dtype == "float32", what_it_reads(self.cost))

    def constants(self, dt: float, first: int) -> list[Numbers]:
        """Return the step, and the parameters."""
        return [np.array([float(dt)]), self.parameters.T]

    def check(self, command: int) -> None:
        """Try the cost once with plain numbers."""
        self._command = command
        zero, name = np.float64(0), self.cost.__name__
        rows = np.atleast_2d(self.parameters)
        parameters = tuple(rows[0]) if len(rows) else ()
        try:
            with np.errstate(all="ignore"):
                value = self.cost(zero, (zero,) * 3, (zero,) * command, parameters)
        except (ArithmeticError, ValueError):
            return  # it may be defined elsewhere
        except Exception as error:
            raise TrundleError(f"cost {name!r}: {type(error).__name__}: {error}") from error
        _number(value, name)

    def with_parameters(self, parameters: Numbers) -> CostSum:
        """Return the same cost with other parameters, finite numbers."""
        changed = copy.copy(self)
        changed.parameters = parameters
        return changed

    def result(self, collected: Collected) -> Numbers:
        """Return the sums (N,)."""
        total: Numbers = collected.registers[0]
        if not np.isfinite(total).all():
            robot = int(np.flatnonzero(~np.isfinite(total))[0])
            raise TrundleError(f"the cost of robot {robot} is no finite number: {total[robot]}")
        return total


@dataclass(frozen=True)
class _Sum:
    """The sum so far, and if compensated what it has lost to rounding.

    Attributes:
        cost: the user's function.
        counts: how many numbers its command and its parameters are.
        compensated: whether the sum is.
        reads: what the function reads from around it.
    """

    cost: types.FunctionType
    counts: tuple[int, int]
    compensated: bool
    reads: tuple[Any, ...]

    @property
    def start(self) -> tuple[float, ...]:
        """What the registers hold before the first step."""
        return (0.0, 0.0) if self.compensated else (0.0,)

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""
        number = m.number
        cost = _tried(jit(as_read(self.cost, m, jit)), self.cost.__name__, self.counts, m)

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


# ---- costs tried out before a loop is made of them --------------------------------------------


def _number(value: Any, name: str) -> Any:
    """Return what a cost gave for one robot, which must be a number."""
    if np.ndim(value) or np.asarray(value).dtype.kind not in "biuf":
        raise TrundleError(f"cost {name!r} must return a number, got {value!r}")
    return value


def _tried(cost: Function, name: str, counts: tuple[int, int], m: Arithmetic) -> Function:
    """Return a cost that was compiled alone, so that what is wrong in it is told, not the loop."""
    if isinstance(cost, types.FunctionType):
        return _over_robots(cost, name)
    if hasattr(cost, "nopython_signatures"):  # compiled for the processor
        _compile(cost, name, counts, m)
    return cost


def _compile(cost: Any, name: str, counts: tuple[int, int], m: Arithmetic) -> None:
    from numba import from_dtype
    from numba import types as numba_types

    number = from_dtype(np.dtype(cast(type, m.number)))
    takes = (number, *(numba_types.UniTuple(number, k) for k in (3, *counts)))
    try:
        cost.compile(takes)
    except Exception as error:
        raise TrundleError(
            f"cost {name!r} cannot be compiled: {reason_of(error)}; device='numpy' reads any Python"
        ) from error
    given = cost.overloads[takes].signature.return_type
    if not isinstance(given, numba_types.Integer | numba_types.Float | numba_types.Boolean):
        raise TrundleError(f"cost {name!r} must return a number, got {given}")


def _over_robots(cost: Function, name: str) -> Function:
    """Return a cost that numpy reads over all robots, or one robot after the other.

    The latter where it cannot read arrays, as with ``if``, or where that gives some robots
    something else, as with sums.
    """

    def of_robot(i: int, t: Any, *given: Values) -> Any:
        own = (tuple(v[i] if np.ndim(v) else v for v in values) for values in given)
        try:
            value = cost(t, *own)
        except Exception as error:
            raise TrundleError(f"cost {name!r}: {type(error).__name__}: {error}") from error
        return _number(value, name)

    def over_robots(t: Any, pose: Values, command: Values, parameters: Values) -> Any:
        given = pose, command, parameters
        if not np.ndim(pose[0]):
            return of_robot(0, t, *given)
        count = len(pose[0])
        some = sorted({0, count // 2, count - 1})
        alone = [of_robot(i, t, *given) for i in some]
        try:
            value = np.broadcast_to(cost(t, *given), (count,))
            close = np.finfo(pose[0].dtype).eps ** 0.5
            if np.allclose(value[some], alone, close, close, equal_nan=True):
                return value
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            pass
        return np.array([of_robot(i, t, *given) for i in range(count)])

    return over_robots
