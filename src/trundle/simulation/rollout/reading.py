"""Functions that users write, read with the elementary functions of a reader."""

from __future__ import annotations

import inspect
import math
import types
from typing import Any, cast

import numpy as np

from trundle.errors import TrundleError
from trundle.simulation.arithmetic import Arithmetic, Function, Jit, as_is
from trundle.simulation.rollout.motions import Values

_NAMES = {
    "sin": (math.sin, np.sin),
    "cos": (math.cos, np.cos),
    "sqrt": (math.sqrt, np.sqrt),
    "minimum": (np.minimum,),
    "maximum": (np.maximum,),
    "where": (np.where,),
    "floor": (np.floor,),
}


def plain_function(function: object, takes: str) -> types.FunctionType:
    """Return a user's function, also where it was compiled already.

    Args:
        function: the function.
        takes: its arguments in words, "t, pose, parameters".

    Raises:
        TrundleError: it is no plain function of so many arguments.
    """
    plain = getattr(function, "py_func", function)
    if not isinstance(plain, types.FunctionType):
        raise TrundleError(
            f"a plain Python function ({takes}) is needed, got {function!r}; put methods and other "
            "callables inside of one"
        )
    try:
        inspect.signature(plain).bind(*takes.split(", "))
    except TypeError as error:
        raise TrundleError(f"{plain.__name__} must take ({takes}): {error}") from None
    return plain


def as_read(function: Function, m: Arithmetic, jit: Jit = as_is) -> Function:
    """Return a user's function in which sines and the like are those of a reader.

    So that ``math.sin`` and ``numpy.sin`` alike become vectors on the processor, read arrays in
    numpy, and run on a GPU. Floats that are written in it are numbers of the reader's type, too: a
    double would widen every float that it meets. Functions of the user's own that it calls are read
    likewise.

    Args:
        function: a plain function that computes with ``math`` or numpy.
        m: the reader's functions.
        jit: the reader's compiler, for the functions that it calls.
    """
    sqrt = m.sqrt
    hypot = jit(lambda x, y: sqrt(x * x + y * y))  # a call into a library makes no vectors
    names = {**{name: getattr(m, name) for name in _NAMES}, "hypot": hypot}
    ours: dict[Any, Any] = {f: names[name] for name, each in _NAMES.items() for f in each}
    ours |= {math.hypot: hypot, np.hypot: hypot}
    known: dict[Any, Any] = {**ours, math: _module(math, names), np: _module(np, names)}
    begun: set[Function] = set()  # a function that calls itself is left as it is

    def replaced(value: Any) -> Any:
        if isinstance(value, float):
            return m.number(value)
        if type(value) is tuple:
            return tuple(map(replaced, value))
        if isinstance(value, types.FunctionType) and value not in begun and _is_own(value):
            return jit(read(value))
        try:
            return known.get(value, value)
        except TypeError:  # not hashable, so none of these
            return value

    def read(each: types.FunctionType) -> Function:
        begun.add(each)
        used, cells = _names_in(each.__code__), each.__closure__ or ()
        around = {
            name: replaced(value) if name in used else value
            for name, value in each.__globals__.items()
        }
        inner = tuple(types.CellType(replaced(cell.cell_contents)) for cell in cells)
        code = each.__code__
        code = code.replace(co_consts=tuple(replaced(value) for value in code.co_consts))
        made = types.FunctionType(
            code, around, each.__name__, replaced(each.__defaults__), inner or None
        )
        made.__kwdefaults__ = each.__kwdefaults__
        begun.discard(each)
        return made

    return read(cast(types.FunctionType, function))


def what_it_reads(function: Function) -> tuple[Any, ...]:
    """Return what a function reads from around it: a loop made of it holds as long as that."""
    seen: set[Any] = set()

    def of(value: Any) -> Any:
        if isinstance(value, types.FunctionType) and value not in seen and _is_own(value):
            seen.add(value)
            around = (value.__globals__.get(name) for name in sorted(_names_in(value.__code__)))
            cells = (cell.cell_contents for cell in value.__closure__ or ())
            return value.__code__, *map(of, (*around, *cells, *(value.__defaults__ or ())))
        if isinstance(value, np.ndarray):
            return value.shape, value.dtype.str, value.tobytes()
        if type(value) is tuple:
            return tuple(map(of, value))
        if isinstance(value, bool | int | float | str):
            return type(value).__name__, value
        return id(value)

    return (of(function),)


def _is_own(function: types.FunctionType) -> bool:
    """Whether a function is a user's, and not of a library that readers have their own of."""
    return (function.__module__ or "").partition(".")[0] not in ("numpy", "math")


def _names_in(code: types.CodeType) -> set[str]:
    """Return the names that a function reads, those of functions within it among them."""
    inner = (_names_in(each) for each in code.co_consts if isinstance(each, types.CodeType))
    return set(code.co_names).union(*inner)


# ---- laws tried out before a loop is made of them --------------------------------------------


def tried(law: Function, name: str, count: int, parameters: int, m: Arithmetic) -> Function:
    """Return a law that was compiled alone, so that what is wrong in it is told, not the loop.

    Args:
        law: function (t, pose, parameters), as a reader's compiler made it, or plain.
        name: what the user calls it.
        count: how many numbers it must return.
        parameters: how many it takes.
        m: the reader's functions.

    Raises:
        TrundleError: it cannot be compiled, or returns something else; the message says why.
    """
    if isinstance(law, types.FunctionType):
        return _over_robots(law, name, count)
    if hasattr(law, "nopython_signatures"):  # compiled for the processor
        _try_out(law, name, count, parameters, m)
    return law


def _try_out(law: Any, name: str, count: int, parameters: int, m: Arithmetic) -> None:
    from numba import from_dtype
    from numba import types as numba_types

    number = from_dtype(np.dtype(cast(type, m.number)))
    takes = (number, *(numba_types.UniTuple(number, k) for k in (3, parameters)))
    try:
        law.compile(takes)
    except Exception as error:
        raise TrundleError(
            f"policy {name!r} cannot be compiled: {reason_of(error)}; device='numpy' reads any "
            "Python"
        ) from error
    given = law.overloads[takes].signature.return_type
    plain = numba_types.Integer, numba_types.Float, numba_types.Boolean
    if not isinstance(given, numba_types.BaseTuple):
        raise TrundleError(_unlike(name, count, f"{given}"))
    if len(given) != count or not all(isinstance(each, plain) for each in given):
        raise TrundleError(_unlike(name, count, f"({', '.join(map(str, given))})"))


def reason_of(error: Exception) -> str:
    """Return what numba says, without the steps in which it found that out."""
    told = (line.strip() for line in str(error).splitlines())
    lines = [line for line in told if line and not line.startswith(("Failed in", "During", "File"))]
    return " ".join(lines[:2]) or type(error).__name__


def _unlike(name: str, count: int, given: str) -> str:
    return f"policy {name!r} must return a tuple of {count} numbers, got {given}"


def _over_robots(law: Function, name: str, count: int) -> Function:
    """Return a law that numpy reads over all robots, or one robot after the other.

    The latter where it cannot read arrays, as with ``if``, or where that gives some robots
    something else, as with sums.
    """

    def checked(t: Any, pose: Values, parameters: Values) -> Values:
        try:
            values = law(t, pose, parameters)
        except Exception as error:
            raise TrundleError(f"policy {name!r}: {type(error).__name__}: {error}") from error
        if not isinstance(values, tuple) or len(values) != count:
            raise TrundleError(_unlike(name, count, repr(values)))
        kinds = [np.asarray(v).dtype.kind for v in values if np.ndim(v) == 0]
        if len(kinds) != count or not set(kinds) <= set("biuf"):
            raise TrundleError(_unlike(name, count, repr(values)))
        return values

    def of_robot(i: int, t: Any, pose: Values, parameters: Values) -> Values:
        each = ((t,), pose, parameters)
        (now,), *own = (tuple(v[i] if np.ndim(v) else v for v in values) for values in each)
        return checked(now, *own)

    def over_robots(t: Any, pose: Values, parameters: Values) -> Values:
        if not np.ndim(pose[0]):
            return checked(t, pose, parameters)
        some = sorted({0, 1, len(pose[0]) // 2, len(pose[0]) - 1} & set(range(len(pose[0]))))
        alone = [of_robot(i, t, pose, parameters) for i in some]
        try:
            values = law(t, pose, parameters)
            here = [[float(np.broadcast_to(v, pose[0].shape)[i]) for v in values] for i in some]
            close = np.finfo(pose[0].dtype).eps ** 0.5
            if np.shape(here) == np.shape(alone) and np.allclose(
                here, alone, close, close, equal_nan=True
            ):
                return cast(Values, values)
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            pass
        robots = (of_robot(i, t, pose, parameters) for i in range(len(pose[0])))
        return tuple(map(np.array, zip(*robots, strict=True)))

    return over_robots


def _module(like: types.ModuleType, names: dict[str, Any]) -> types.ModuleType:
    made = types.ModuleType(like.__name__)
    made.__dict__.update(vars(like))
    made.__dict__.update({name: f for name, f in names.items() if hasattr(like, name)})
    return made
