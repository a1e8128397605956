"""A wheel in symbols, and its rows from the same source that numpy reads."""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import sympy

from trundle.robot import Robot, Rows, Wheel
from trundle.symbolic.inputs import Inputs, steering_inputs
from trundle.symbolic.places import Place, places, radii, track_factors
from trundle.symbolic.quantities import Namer
from trundle.symbolic.tidy import tidy


class SymbolicWheel(NamedTuple):
    """A wheel that pushes or holds, its number in the formulas, and its values in symbols."""

    number: int
    wheel: Wheel
    place: Place
    radius: Any
    roller: Any
    steering: Any
    track_factor: Any

    def rows(self) -> Rows:
        """Return the wheel's constraint rows in symbols."""
        return _rows(self)


@lru_cache(maxsize=1024)
def _rows(each: SymbolicWheel) -> Rows:
    wheel = each.wheel
    held = {field.name: getattr(wheel, field.name) for field in dataclasses.fields(wheel)}
    held |= {
        "x": each.place.x,
        "y": each.place.y,
        "radius": sympy.Integer(1) if each.radius is None else each.radius,
        "heading": each.place.heading,
        "roller": each.roller,
        "track_factor": each.track_factor,
        "spin_sign": getattr(wheel, "spin_sign", 1),
    }
    made = type(wheel).rows(SimpleNamespace(**held), each.steering, sympy)  # type: ignore[arg-type]
    return Rows(*(_tidy(part) for part in made))


def _tidy(part: Any) -> Any:
    if part is None:
        return None
    return tuple(map(tidy, part)) if isinstance(part, tuple) else tidy(part)


def says_something(wheel: Wheel) -> bool:
    """Return whether a wheel pushes the robot or holds it: only such wheels have symbols."""
    rows = wheel.rows()
    return wheel.driven or rows.side_slip is not None or rows.skid is not None


def symbolic_wheels(robot: Robot, namer: Namer) -> tuple[tuple[SymbolicWheel, ...], Inputs]:
    """Return the wheels that push or hold in symbols, and the steering inputs.

    >>> import trundle
    >>> wheels, _ = symbolic_wheels(trundle.load("differential"), Namer())
    >>> [each.rows().rolling for each in wheels]
    [(1, 0, -d), (1, 0, d)]
    """
    wheels = [wheel for wheel in robot.wheels if says_something(wheel)]
    inputs = steering_inputs(wheels)
    made = []
    for i, (wheel, place, radius, factor) in enumerate(
        zip(
            wheels,
            places(wheels, namer),
            radii(wheels, namer),
            track_factors(wheels, namer),
            strict=True,
        ),
        1,
    ):
        roller = namer.angle(
            f"phi_{i}", getattr(wheel, "roller", 0.0), f"roller angle of wheel {i}"
        )
        steering = inputs.angles.get(wheel.name, sympy.Integer(0))
        made.append(SymbolicWheel(i, wheel, place, radius, roller, steering, factor))
    return tuple(made), inputs
