"""A robot's rows in sentences, with its own numbers: what each wheel does, W, and the constraints.

Every sentence is made from the rows, so that it is true of any mixture of wheels.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.kinematics.constraints import gains, rolling_matrix, steering_array, wheel_rows
from trundle.kinematics.linear import ANGLE_TOLERANCE, basis, null_projector
from trundle.kinematics.maps import motion_projector, wheel_matrix
from trundle.kinematics.model import Kinematics
from trundle.kinematics.words import join, motion_in_words, motions_in_words
from trundle.robot import CasterWheel, FixedWheel, Robot, RollingWheel, Rows, SwedishWheel, Wheel
from trundle.se2 import Array, wrap

_TWIST = ("u", "v", "r")
_MOTION = {"u": "forward speed", "v": "sideways speed", "r": "yaw rate"}
# Coefficients this much smaller than the rest of their row are rounding.
_ZERO = 1e-9


@dataclass(frozen=True)
class Explanation:
    """A robot in sentences; iterating goes through all of them.

    Attributes:
        wheels: one text for each wheel: its force line, its lever arm, its degrees of freedom.
        matrix: one text for each of the three rows of W.
        constraints: one text for each rolling and side-slip row, then the motions they leave.
    """

    wheels: tuple[str, ...]
    matrix: tuple[str, ...]
    constraints: tuple[str, ...]

    def __iter__(self) -> Iterator[str]:
        """Go through all texts in order."""
        return itertools.chain(self.wheels, self.matrix, self.constraints)

    @property
    def sections(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The three parts, each with a title."""
        return (
            ("Wheels", self.wheels),
            ("Rows of W (a wheel's name stands for its speed in rad/s)", self.matrix),
            ("Constraints (omega is the wheel's speed in rad/s)", self.constraints),
        )


def explain(robot: Robot, steering: npt.ArrayLike | None = None) -> Explanation:
    """Return every row of W and of the constraints in sentences with this robot's numbers.

    Args:
        robot: the robot.
        steering: (s,) steering angles [rad] of a robot that steers.

    Raises:
        ShapeError: the steering angles of a robot that steers are missing.
        OffCentreError: the steering angles share no instantaneous centre.

    >>> from trundle import load
    >>> explain(load("differential")).matrix[0]
    'u = 0.025 (left + right): forward speed is the mean of the rim speeds.'
    """
    angles = steering_array(robot, steering)
    Kinematics(robot).wheel_matrix(steering)  # raises where the angles share no centre
    rows = wheel_rows(robot, angles)
    steered = dict(zip((wheel.name for wheel in robot.steered), angles.tolist(), strict=True))
    return Explanation(
        wheels=tuple(
            _wheel_words(wheel, rows[wheel.name], steered.get(wheel.name)) for wheel in robot.wheels
        ),
        matrix=_matrix_words(robot, angles),
        constraints=_constraint_words(robot, angles, rows),
    )


def _number(value: float) -> str:
    return f"{value:.4g}"


def _degrees(angle: float) -> str:
    return f"{_number(round(math.degrees(angle), 9) + 0.0)} deg"


def _point(wheel: Wheel) -> str:
    # A picometre is the rounding of a cosine.
    x, y = (_number(round(c, 12) + 0.0) for c in (wheel.x, wheel.y))
    return f"({x}, {y}) m"


def _sum(coefficients: Iterable[float], names: Sequence[str]) -> str:
    """Return a linear combination as text; a size that all terms share is taken out."""
    values = list(coefficients)
    largest = max(map(abs, values), default=0.0)
    terms = [(v, name) for v, name in zip(values, names, strict=True) if abs(v) > _ZERO * largest]
    if not terms:
        return "0"
    sizes = {_number(abs(value)) for value, _ in terms}
    if len(sizes) > 1 or len(terms) == 1:
        return _terms((value, _term(_number(abs(value)), name)) for value, name in terms)
    size, sign = sizes.pop(), 1.0
    if all(value < 0 for value, _ in terms):
        sign = -1.0
    # Those counted forwards come first: "right - left".
    terms.sort(key=lambda term: sign * term[0] < 0)
    inner = _terms((sign * value, name) for value, name in terms)
    outer = "" if size == "1" else f"{size} "
    if sign < 0 or outer:
        return f"{'-' if sign < 0 else ''}{outer}({inner})"
    return inner


def _term(size: str, name: str) -> str:
    return name if size == "1" else f"{size} {name}"


def _terms(signed: Iterable[tuple[float, str]]) -> str:
    text = "".join(f" {'+' if value > 0 else '-'} {term}" for value, term in signed)
    return text[3:] if text.startswith(" + ") else f"-{text[3:]}"


def _wheel_words(wheel: Wheel, rows: Rows, steering: float | None) -> str:
    told = [f"{wheel.name} ({_kind(wheel, steering)}): {_push(wheel, rows, steering)}."]
    if isinstance(wheel, RollingWheel) and wheel.reversed:
        told.append("It is mounted reversed: at positive motor speed it drives backwards.")
    if wheel.sensed and not wheel.driven:
        told.append("Its turning is measured, for odometry.")
    told.append(f"Alone on the ground it has {_freedom(wheel)}.")
    return " ".join(told)


def _kind(wheel: Wheel, steering: float | None) -> str:
    if isinstance(wheel, SwedishWheel):
        return f"{wheel.kind}, heading {_degrees(wheel.heading)}, roller {_degrees(wheel.roller)}"
    if isinstance(wheel, RollingWheel):
        turned = "" if steering is None else f", steered by {_degrees(steering)}"
        skid = ", may skid" if isinstance(wheel, FixedWheel) and wheel.skid else ""
        return f"{wheel.kind}, heading {_degrees(wheel.heading)}{turned}{skid}"
    return wheel.kind


def _push(wheel: Wheel, rows: Rows, steering: float | None) -> str:
    if rows.rolling is None or not isinstance(wheel, RollingWheel):
        return f"at {_point(wheel)} it follows every motion and restricts none"
    if not wheel.driven:
        held = "" if rows.side_slip is None else ", and holds its point against side slip"
        return f"at {_point(wheel)} it rolls freely{held}"
    line = f"it pushes along the line at {_degrees(_direction(wheel, steering))}"
    arm = float(rows.rolling[2])
    if abs(arm) <= _ZERO:
        return f"{line} through {_point(wheel)}, which meets the origin: no lever arm"
    way = "counter-clockwise" if arm * rows.gain > 0 else "clockwise"
    return (
        f"{line} through {_point(wheel)}; its lever arm about the origin is "
        f"{_number(abs(arm))} m, {way} at positive speed"
    )


def _direction(wheel: RollingWheel, steering: float | None) -> float:
    """Return the direction of the wheel's rolling row in the body frame, in (-pi, pi] [rad]."""
    roller = wheel.roller if isinstance(wheel, SwedishWheel) else 0.0
    return float(wrap(wheel.heading + roller + (steering or 0.0)))


def _freedom(wheel: Wheel) -> str:
    if isinstance(wheel, SwedishWheel):
        return "3 degrees of freedom: the wheel, the roller and turning about the contact"
    if isinstance(wheel, FixedWheel) and wheel.skid:
        return "3 degrees of freedom: rolling, slipping sideways and turning about the contact"
    if isinstance(wheel, RollingWheel):
        return "2 degrees of freedom: rolling and turning about the contact"
    if isinstance(wheel, CasterWheel):
        return "3 degrees of freedom: rolling, turning about the contact and about the pivot"
    return "3 degrees of freedom: rolling in two directions and turning about the contact"


def _constraint_words(robot: Robot, steering: Array, rows: dict[str, Rows]) -> tuple[str, ...]:
    angle = dict(zip((wheel.name for wheel in robot.steered), steering.tolist(), strict=True))
    told = []
    for wheel in robot.wheels:
        if isinstance(wheel, RollingWheel):
            direction = _direction(wheel, angle.get(wheel.name))
            told.append(_rolling_words(wheel, rows[wheel.name], direction))
            told.append(_slip_words(wheel, rows[wheel.name], direction))
    return (*(each for each in told if each), _left_words(robot, steering))


def _velocity(wheel: Wheel, track_factor: float = 1.0) -> tuple[str, str]:
    """Return the contact's velocity along x and along y as text."""
    along = _sum([1.0, -wheel.y * track_factor], ["u", "r"])
    across = _sum([1.0, wheel.x], ["v", "r"])
    along, across = (f"({each})" if " " in each else each for each in (along, across))
    return along, across


def _rolling_words(wheel: RollingWheel, rows: Rows, direction: float) -> str:
    factor = wheel.track_factor if isinstance(wheel, FixedWheel) else 1.0
    along, across = _velocity(wheel, factor)
    at, spin = _degrees(direction), _sum([rows.gain], ["omega"])
    row = _row(rows.rolling)
    told = f"{wheel.name} rolls: cos({at}) {along} + sin({at}) {across} = {spin}"
    told += f", that is {row} = {spin}."
    if isinstance(wheel, SwedishWheel):
        told += " The contact is held along the roller's axis; across it the roller turns freely."
    if factor != 1:
        told += f" The track counts {_number(factor)} times, because the wheels slip in turns."
    if not (wheel.driven or wheel.sensed):
        told += " It is neither driven nor measured: the row only tells its speed."
    return told


def _slip_words(wheel: RollingWheel, rows: Rows, direction: float) -> str:
    along, across = _velocity(wheel)
    at = _degrees(direction)
    formula = f"cos({at}) {across} - sin({at}) {along}"
    if rows.side_slip is not None:
        row = _row(rows.side_slip)
        return f"{wheel.name} does not slip sideways: {formula} = 0, that is {row} = 0."
    if rows.skid is not None:
        row = _row(rows.skid)
        return f"{wheel.name} may slip sideways, at {formula}, that is {row}; no row holds it."
    return ""


def _row(row: Sequence[float] | None) -> str:
    values = [float(value) for value in row or ()]
    largest = max(map(abs, values))
    return _terms(
        (value, _term(_number(abs(value)), name))
        for value, name in zip(values, _TWIST, strict=True)
        if abs(value) > _ZERO * largest
    )


def _left_words(robot: Robot, steering: Array) -> str:
    allowed, _ = motion_projector(robot, steering)
    free = basis(allowed)
    count = free.shape[1]
    if count == 3:
        return "No row forbids a motion of the plane."
    motions = join([each.replace(" and ", " or ") for each in motions_in_words(free)])
    if not motions:
        return "Together they leave no motion."
    return f"Together they leave {count} motion{'s' * (count > 1)} of 3: {motions}."


def _matrix_words(robot: Robot, steering: Array) -> tuple[str, ...]:
    wheels = robot.driven
    if not wheels:
        return tuple(f"{name} = 0: no wheel is driven." for name in _TWIST)
    W, feasible = wheel_matrix(robot, steering)
    names = [wheel.name for wheel in wheels]
    radii = np.array([wheel.radius for wheel in wheels])
    inverse = rolling_matrix(robot, wheels, steering) / gains(wheels)[:, None]
    told = []
    for name, row, unit in zip(_TWIST, W, np.eye(3), strict=True):
        if np.abs(row).max() <= _ZERO * np.abs(W).max():
            told.append(f"{name} = 0: {_why_zero(robot, steering, name, unit)}.")
            continue
        why = _why_line(name, row / radii, names)
        if name == "r":
            turn = feasible @ unit / (unit @ feasible @ unit)
            why = _why_turn(row / radii, names, radii * (inverse @ turn), turn)
        told.append(f"{name} = {_sum(row, names)}: {why}.")
    return tuple(told)


def _why_line(name: str, weights: Array, names: list[str]) -> str:
    """Return what forward or sideways speed is in rim speeds, for weights (n,) of them."""
    if mean := _mean(weights, names):
        return f"{_MOTION[name]} is {mean}"
    rims = _sum(weights, names)
    return f"in rim speeds [m/s], {_MOTION[name]} is {rims}"


def _mean(weights: Array, names: list[str], total: float = 1.0) -> str:
    """Return the mean of rim speeds in words where the weights are one, else ""."""
    counted = np.abs(weights) > _ZERO * np.abs(weights).max()
    sizes = np.abs(weights[counted])
    if np.ptp(sizes) > _ZERO * sizes.max():
        return ""
    which = [name for name, counts in zip(names, counted, strict=True) if counts]
    backwards = [name for name, weight in zip(names, weights, strict=True)
                 if weight < -_ZERO * sizes.max()]  # fmt: skip
    share = float(sizes.sum()) / total
    of = "" if len(which) == len(names) else f" of {join(which)}"
    one = len(which) == 1
    told = "the rim speed" if one else f"the mean of the rim speeds{of}"
    told = f"the rim speed of {which[0]}" if one else told
    if abs(share - 1) > _ZERO:
        told = f"{_number(share)} times {told}"
    if backwards:
        those = "all" if len(backwards) == len(which) and not one else f"those of {join(backwards)}"
        told += ", counted backwards" if one else f", {those} counted backwards"
    return told


def _why_turn(weights: Array, names: list[str], rims: Array, turn: Array) -> str:
    """Return why arms divide in the yaw row.

    Args:
        weights: (n,) the row's coefficients on the rim speeds.
        names: of the wheels.
        rims: (n,) rim speeds [m/s] while the robot turns at 1 rad/s.
        turn: (3,) the twist with r = 1 that is meant.
    """
    motion = motion_in_words(turn)
    arms = np.abs(rims)
    arm = float(arms.max())
    if np.ptp(arms) <= _ZERO * arm and (mean := _mean(weights, names, 1 / arm)):
        comma = "," if "," in mean else ""
        rim = "the rim runs" if len(names) == 1 else "each rim runs"
        return (
            f"yaw rate is {mean}{comma} over the arm of {_number(arm)} m. In one radian of "
            f"{motion} {rim} {_number(arm)} m, so the arm divides"
        )
    runs = [f"{_number(rim)} m at {name}" for rim, name in zip(rims, names, strict=True)]
    return (
        f"one radian of {motion} runs the rims by {join(runs)}; the row turns these back "
        "into one radian, so the arms divide"
    )


def _why_zero(robot: Robot, steering: Array, name: str, unit: Array) -> str:
    """Return why no wheel speed gives a component of the twist."""
    holding = [wheel for wheel in robot.wheels if _slip_rows([wheel], robot, steering).size]
    sets = [
        [w for w in holding if _forbid([w], robot, steering, unit)],
        [w for w in holding if not w.steers],
        holding,
    ]
    for wheels in sets:
        if wheels and _forbid(wheels, robot, steering, unit):
            at = " at these angles" if any(wheel.steers for wheel in wheels) else ""
            names = join([wheel.name for wheel in wheels])
            return f"no driven wheel gives {name}: the side slip of {names} forbids it{at}"
    allowed, _ = motion_projector(robot, steering)
    if unit @ allowed @ unit <= _ZERO:
        return f"the wheels that may skid move so that they slip least, and that leaves no {name}"
    return f"no row forbids {name}, but no driven wheel gives it either"


def _slip_rows(wheels: Sequence[Wheel], robot: Robot, steering: Array) -> Array:
    rows = wheel_rows(robot, steering)
    found = [rows[wheel.name].side_slip for wheel in wheels]
    return np.array([row for row in found if row is not None], dtype=np.float64).reshape(-1, 3)


def _forbid(wheels: Sequence[Wheel], robot: Robot, steering: Array, unit: Array) -> bool:
    projector, _ = null_projector(_slip_rows(wheels, robot, steering), ANGLE_TOLERANCE)
    return bool(unit @ projector @ unit <= _ZERO)
