"""Robots that differ in their numbers: one description, in which some are arrays."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import RobotError, ShapeError, TrundleError, did_you_mean
from trundle.kinematics import finite
from trundle.robot import Body, Robot, Wheel
from trundle.se2 import Array

# Sizes of a whole robot, and the coordinates of the wheels that they scale.
_SIZES = {"arm": ("x", "y"), "track": ("y",), "wheelbase": ("x",)}
_BODY = ("mass", "inertia", "com")
_CHECKED = 1000


def vary(robot: Robot, parameters: Mapping[str, npt.ArrayLike]) -> Robot:
    """Return a robot some of whose numbers are arrays (N,).

    It is a value for computing with, not a description: its matrices are stacks (N, ...).

    Args:
        robot: the robot as described.
        parameters: (N,) values by what they are: "radius" and other numbers of a wheel, for every
            wheel that has them; "front_left.radius" for one wheel; "mass" and "inertia" of the
            body, (N, 2) for its "com"; "arm", the distance of the outermost wheel from the origin,
            "track" and "wheelbase", the distances between the outermost wheels across and along,
            which move all wheels in proportion [m].

    Raises:
        TrundleError: a name is not known, or a value is not possible.

    >>> import trundle
    >>> robots = vary(trundle.load("differential"), {"track": [0.40, 0.41]})
    >>> [wheel.y.tolist() for wheel in robots.driven], batch_of(robots)
    ([[0.2, 0.205], [-0.2, -0.205]], (2,))
    """
    if not isinstance(parameters, Mapping):
        raise TrundleError(
            f"parameters must be a dictionary such as {{'radius': [...]}}, got {parameters!r}"
        )
    wheels, body, counts = list(robot.wheels), robot.body, {}
    # Sizes first, then all wheels, then single ones: what is told more closely holds.
    for name, given in sorted(parameters.items(), key=lambda item: _closeness(item[0])):
        if not isinstance(name, str):
            raise TrundleError(f"parameters have names such as 'radius', got {name!r}")
        values = finite(given, name, 2 if name == "com" else None)
        if values.ndim != (2 if name == "com" else 1) or len(values) == 0:
            shape = "(N, 2)" if name == "com" else "(N,)"
            raise ShapeError(f"parameter {name!r} must have shape {shape}, got {values.shape}")
        counts[name] = len(values)
        if name in _BODY:
            body = _of_body(robot, body, name, values)
        elif name in _SIZES:
            wheels = _sized(robot, wheels, name, values)
        else:
            wheels = _of_wheels(robot, wheels, name, values)
    if "arm" in counts and counts.keys() & {"track", "wheelbase"}:
        raise TrundleError("give arm, or track and wheelbase: both move the wheels")
    count = max(counts.values(), default=1)
    for name, each in counts.items():
        if each != count:
            other = next(key for key, value in counts.items() if value == count)
            raise ShapeError(f"parameter {name!r} has {each} robots, and {other!r} has {count}")
    return _with(robot, wheels=tuple(wheels), body=body)  # type: ignore[no-any-return]


def _closeness(name: object) -> tuple[bool, bool]:
    return name not in _SIZES, "." in str(name)


def batch_of(robot: Robot) -> tuple[int, ...]:
    """Return (N,) of a robot some of whose numbers are arrays, () of one that is as described."""
    values = [value for wheel in robot.wheels for value in vars(wheel).values()]
    if robot.body is not None:
        values += [robot.body.mass, robot.body.inertia, *(robot.body.com or ())]
    return np.broadcast_shapes(*(value.shape for value in values if isinstance(value, np.ndarray)))


def spread_out(robot: Robot, batch: tuple[int, ...]) -> Robot:
    """Return a robot all of whose numbers are arrays of a batch, () for one that is as described.

    Matrices of few of these numbers are stacks then, too.
    """
    if not batch:
        return robot

    def spread(value: Any, names: set[str]) -> Any:
        changes = {name: np.broadcast_to(getattr(value, name), batch) for name in names}
        return _with(value, **changes)

    wheels = tuple(spread(w, _numbers(w) | _arrays(w)) for w in robot.wheels)
    body = robot.body
    if body is not None and body.com is not None:
        x, y = (np.broadcast_to(each, batch) for each in body.com)
        body = _with(spread(body, {"mass", "inertia"}), com=(x, y))
    made: Robot = _with(robot, wheels=wheels, body=body)
    return made


def _arrays(wheel: Wheel) -> set[str]:
    return {name for name, value in vars(wheel).items() if isinstance(value, np.ndarray)}


def _of_body(robot: Robot, body: Body | None, name: str, values: Array) -> Body:
    if body is None:
        raise RobotError([f"it has no body, whose {name} could vary"], f"robot {robot.name!r}")
    for end in (values.min(axis=0), values.max(axis=0)):
        _check(robot.body, name, tuple(end.tolist()) if name == "com" else float(end))
    made: Body = _with(body, **{name: tuple(values.T) if name == "com" else values})
    return made


def _sized(robot: Robot, wheels: list[Wheel], name: str, values: Array) -> list[Wheel]:
    axes = _SIZES[name]
    places = np.array([[getattr(wheel, axis) for axis in axes] for wheel in robot.wheels])
    size = float(np.hypot(*places.T).max() if name == "arm" else np.ptp(places))
    if size <= 0:
        raise RobotError([f"its wheels have no {name} that could vary"], f"robot {robot.name!r}")
    if values.min() <= 0:
        raise TrundleError(f"parameter {name!r} must be positive, got {values.min():g} m")
    scale = values / size
    return [_with(w, **{axis: getattr(w, axis) * scale for axis in axes}) for w in wheels]


def _of_wheels(robot: Robot, wheels: list[Wheel], name: str, values: Array) -> list[Wheel]:
    wheel_name, _, field = name.rpartition(".")
    numbers = {f for wheel in robot.wheels for f in _numbers(wheel)}
    names = {wheel.name for wheel in robot.wheels}
    if wheel_name and wheel_name not in names:
        raise TrundleError(
            f"parameter {name!r}: no wheel is called {wheel_name!r}"
            f"{did_you_mean(wheel_name, names)}"
        )
    chosen = [w.name for w in robot.wheels if wheel_name in ("", w.name) and field in _numbers(w)]
    if not chosen:
        known = [*numbers, *_BODY, *_SIZES]
        raise TrundleError(
            f"parameter {name!r}: no wheel has such a number{did_you_mean(field, known)}"
        )
    out = []
    for described, wheel in zip(robot.wheels, wheels, strict=True):
        if described.name in chosen:
            for each in _some(values):
                _check(described, field, float(each))
            wheel = _with(wheel, **{field: values})
        out.append(wheel)
    return out


def _check(described: Any, name: str, value: object) -> None:
    """Let the description's own checks see a value."""
    dataclasses.replace(described, **{name: value})


def _some(values: Array) -> Array:
    """Return the values that are checked: of thousands some, the outermost among them."""
    unique = np.unique(values)
    some: Array = unique[np.unique(np.linspace(0, len(unique) - 1, _CHECKED).astype(int))]
    return some


def _numbers(wheel: Wheel) -> set[str]:
    """Return the fields of a wheel that are numbers, and may be arrays of them."""
    fields = (each.name for each in dataclasses.fields(wheel))
    return {name for name in fields if isinstance(getattr(wheel, name), float)}


def _with(value: Any, **changes: Any) -> Any:
    """Return a copy of a frozen value with fields that its checks, made for numbers, do not see."""
    made = copy.copy(value)
    for name, change in changes.items():
        object.__setattr__(made, name, change)
    return made
