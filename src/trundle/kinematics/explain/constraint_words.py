"""The rolling and side-slip rows in words, and the motions that they leave."""

from __future__ import annotations

from trundle.kinematics.explain.numbers import TWIST, combination, degrees, factored, number
from trundle.kinematics.explain.wheel_words import row_direction
from trundle.kinematics.linear import basis
from trundle.kinematics.maps import motion_projector
from trundle.kinematics.words import join, motions_in_words
from trundle.robot import FixedWheel, Robot, RollingWheel, Rows, SwedishWheel, Wheel
from trundle.se2 import Array


def constraint_words(wheel: RollingWheel, rows: Rows, steering: float | None) -> list[str]:
    """Return a wheel's rows, for its steering angle [rad], None for no steering."""
    at = degrees(row_direction(wheel, steering))
    told = [_rolling_words(wheel, rows, at)]
    along, across = _velocity(wheel)
    formula = f"cos({at}) {across} - sin({at}) {along}"
    if rows.side_slip is not None:
        row = combination(rows.side_slip, TWIST)
        told.append(f"{wheel.name} does not slip sideways: {formula} = 0, that is {row} = 0.")
    elif rows.skid is not None:
        row = combination(rows.skid, TWIST)
        slips = f"{wheel.name} may slip sideways, at {formula}, that is {row}"
        told.append(f"{slips}; no row holds it.")
    return told


def motions_left(robot: Robot, steering: Array) -> str:
    """Return which motions the side-slip rows leave at steering angles (s,) [rad]."""
    allowed, _ = motion_projector(robot, steering)
    free = basis(allowed)
    count = free.shape[1]
    if count == 3:
        return "No row forbids a motion of the plane."
    if count == 0:
        return "Together they leave no motion."
    motions = join([each.replace(" and ", " or ") for each in motions_in_words(free)])
    return f"Together they leave {count} motion{'s' * (count > 1)} of 3: {motions}."


def _rolling_words(wheel: RollingWheel, rows: Rows, at: str) -> str:
    factor = wheel.track_factor if isinstance(wheel, FixedWheel) else 1.0
    along, across = _velocity(wheel, factor)
    row, spin = combination(rows.rolling or (), TWIST), factored([rows.gain], ["omega"])
    told = (
        f"{wheel.name} rolls: cos({at}) {along} + sin({at}) {across} = {spin}, "
        f"that is {row} = {spin}."
    )
    if isinstance(wheel, SwedishWheel):
        told += " The contact is held along the roller's axis; across it the roller turns freely."
    if factor != 1:
        told += f" The track counts {number(factor)} times, because the wheels slip in turns."
    if not (wheel.driven or wheel.sensed):
        told += " It is neither driven nor measured: the row only tells its speed."
    return told


def _velocity(wheel: Wheel, track_factor: float = 1.0) -> tuple[str, str]:
    """Return the contact's velocity along x and along y as text."""
    along = factored([1.0, -wheel.y * track_factor], ["u", "r"])
    across = factored([1.0, wheel.x], ["v", "r"])
    along, across = (f"({each})" if " " in each else each for each in (along, across))
    return along, across
