"""A matrix from elsewhere beside ours: the fewest changes that turn ours into it, in words.

Every change is tried on the inverse map ``B = R^-1 A`` (n, 3), where each one touches a single row
or column: a forward matrix is taken back to B first, since a pseudo-inverse spreads a change over
all columns.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.errors import FileError, ShapeError, TrundleError
from trundle.kinematics.constraints import finite, gains, rolling_matrix, steering_array
from trundle.kinematics.linear import pseudo_inverse
from trundle.kinematics.maps import motion_projector, wheel_matrix
from trundle.kinematics.model import Kinematics
from trundle.kinematics.words import join
from trundle.robot import Robot, RollingWheel, SwedishWheel
from trundle.se2 import Array

_NAMES = ("VX", "VY", "WZ")
# Computed twice in double precision, with nine digits in a file: far below every change here.
_EXACT = 1e-6
# Four digits printed. Coarser print is told from the decimals, up to a twentieth of an entry.
_PRINTED = 1e-3
_COARSE = 0.05
# A pseudo-inverse enlarges what rounding has left; what it finds is checked without this factor.
_SLACK = 10.0
# Prices: a change that is made often is cheap. Another order costs more than two other changes.
_ORDER, _TRANSPOSED, _RADIUS, _FACTOR, _LEANING, _ENTRY = 2.5, 1.5, 1.6, 2.5, 1.4, 1.5
_NEVER = 1e6
# What the yaw column may hold in place of our arm: the wheels' x and y, scaled.
_ARMS = (
    ("arm_difference", -1.0, 1.0),
    ("arm_difference", 1.0, -1.0),
    ("full_track", 1.0, 2.0),
    ("full_wheelbase", 2.0, 1.0),
    ("no_wheelbase", 0.0, 1.0),
    ("no_track", 1.0, 0.0),
)


@dataclass(frozen=True)
class Difference:
    """One difference: a code for programs, and a sentence for people."""

    code: str
    message: str


@dataclass(frozen=True)
class Comparison:
    """How a matrix from elsewhere compares with ours.

    Attributes:
        agrees: it is the same map; the wheels may stand in another order, and the digits may end
            where the print ended. Both are told in ``findings``.
        form: "forward" (wheels to twist) or "inverse" (twist to wheels).
        quantity: "wheel speeds in rad/s" or "rim speeds in m/s".
        order: names of the driven wheels in the order of the matrix.
        findings: the differences, the one of the most entries first.
        largest_difference: of an entry from ours, for twists that the robot can have.
        ours: our matrix in the same form, quantity and order.
    """

    agrees: bool
    form: str
    quantity: str
    order: tuple[str, ...]
    findings: tuple[Difference, ...]
    largest_difference: float
    ours: Array


def read_matrix(path: str | Path) -> Array:
    """Return the matrix (rows, columns) in a text file.

    A line is a row, with numbers between semicolons, commas, spaces or tabs; in a line with
    semicolons a comma is a decimal comma. ``#`` starts a comment; a first line without any number
    is a header.

    Raises:
        FileError: the file cannot be read, is empty or ragged, or holds what is not a number.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: the file must be UTF-8 text: {error}") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    lines = [(i, _fields(line)) for i, line in enumerate(text.splitlines(), start=1)]
    lines = [(i, fields) for i, fields in lines if fields]
    if lines and not any(_is_number(field) for field in lines[0][1]):
        del lines[0]
    if not lines:
        raise FileError(f"{path}: there is no number in the file")
    rows = [[_number(f"{path}: line {i}", j, f) for j, f in enumerate(fs, 1)] for i, fs in lines]
    for (i, _), row in zip(lines, rows, strict=True):
        if len(row) != len(rows[0]):
            raise FileError(
                f"{path}: line {i} has {len(row)} numbers, but line {lines[0][0]} has "
                f"{len(rows[0])}: every row of a matrix has the same length"
            )
    return np.array(rows)


def _fields(line: str) -> list[str]:
    # Slides and PDFs print a minus that is no hyphen.
    line = line.partition("#")[0].replace("\N{MINUS SIGN}", "-").strip()
    mark = next((mark for mark in ";," if mark in line), None)
    fields = [field.strip() for field in line.split(mark)]
    if mark and not fields[-1]:
        fields.pop()
    return [field.replace(",", ".") for field in fields] if mark == ";" else fields


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _number(where: str, column: int, field: str) -> float:
    if not _is_number(field):
        what = f"{field!r} is not a number" if field else "a number is missing"
        raise FileError(f"{where}, column {column}: {what}")
    if not math.isfinite(float(field)):
        raise FileError(f"{where}, column {column}: must be a finite number, got {field}")
    return float(field)


class _Ours(NamedTuple):
    """What we know of the robot at its steering angles."""

    robot: Robot
    steering: Array
    names: tuple[str, ...]
    radii: Array  # (n,)
    rollers: Array  # (n,), 0 without rollers
    weights: Array  # (n,) |R|
    allowed: Array  # (3, 3) projector onto the twists without side slip
    feasible: Array  # (3, 3) projector onto those that the wheels give
    inverse: Array  # (n, 3) R^-1 A
    mirrored: Array  # (n, 3) the same with all rollers mirrored

    @classmethod
    def of(cls, robot: Robot, steering: npt.ArrayLike | None) -> _Ours:
        Kinematics(robot).wheel_matrix(steering)  # raises where the angles share no centre
        angles = steering_array(robot, steering)
        wheels = robot.driven
        _, feasible = wheel_matrix(robot, angles)
        if np.trace(feasible) < 0.5:
            raise TrundleError(
                f"robot {robot.name!r}: no driven wheel moves it, so there is nothing to compare"
            )
        return cls(
            robot=robot,
            steering=angles,
            names=tuple(wheel.name for wheel in wheels),
            radii=np.array([wheel.radius for wheel in wheels]),
            rollers=np.array([w.roller if isinstance(w, SwedishWheel) else 0.0 for w in wheels]),
            weights=np.abs(gains(wheels)),
            allowed=motion_projector(robot, angles)[0],
            feasible=feasible,
            inverse=_inverse(robot, angles),
            mirrored=_inverse(robot, angles, mirrored=True),
        )

    def forward(self, inverse: Array) -> Array:
        """Return the forward map (3, n) that belongs to an inverse map (n, 3)."""
        rolling = self.weights[:, None] * inverse
        return pseudo_inverse(rolling @ self.allowed)[0] * self.weights

    def units(self, rim: bool) -> Array:
        """Return what (n,) one rad/s of each wheel is in the quantity of the matrix."""
        return self.radii if rim else np.ones(len(self.radii))

    @property
    def one_radius(self) -> bool:
        """Whether all driven wheels have the same radius."""
        return bool(np.ptp(self.radii) <= _EXACT * self.radii[0])

    @property
    def turns(self) -> bool:
        """Whether the robot can turn about its origin, so that the yaw arms say something."""
        return bool(self.feasible[2, 2] > 1 - _EXACT)

    @property
    def planar(self) -> bool:
        """Whether the robot has no sideways motion, so that VY may be left out."""
        return bool(np.abs(self.feasible[1]).max() < _EXACT)


def _inverse(
    robot: Robot, steering: Array, along: float = 1.0, across: float = 1.0, mirrored: bool = False
) -> Array:
    """Return R^-1 A (n, 3), with the driven wheels' x and y scaled or their rollers mirrored."""

    def changed(wheel: RollingWheel) -> RollingWheel:
        wheel = dataclasses.replace(wheel, x=along * wheel.x, y=across * wheel.y)
        if mirrored and isinstance(wheel, SwedishWheel):
            return dataclasses.replace(wheel, roller=-wheel.roller)
        return wheel

    driven = {wheel.name: changed(wheel) for wheel in robot.driven}
    wheels = tuple(driven.get(wheel.name, wheel) for wheel in robot.wheels)
    robot = dataclasses.replace(robot, wheels=wheels)
    rows = rolling_matrix(robot, robot.driven, steering)
    return np.asarray(rows / gains(robot.driven)[:, None])


class _Reading(NamedTuple):
    """One way to understand the pasted matrix."""

    form: str
    matrix: Array  # (3, n) forward, (n, 3) inverse
    transposed: bool
    short: bool  # VY was left out
    rim: bool  # base quantity, where rim speed and spin rate differ by more than one factor


def _readings(ours: _Ours, pasted: Array) -> list[_Reading]:
    n = len(ours.names)
    sizes = (3, 2) if ours.planar else (3,)
    found = []
    for transposed, matrix in ((False, pasted), (True, pasted.T)):
        for form, shaped in (("forward", matrix), ("inverse", matrix.T)):
            if shaped.ndim == 2 and shaped.shape[0] in sizes and shaped.shape[1] == n:
                short = shaped.shape[0] == 2
                full = np.insert(shaped, 1, 0.0, axis=0) if short else shaped
                full = full if form == "forward" else full.T
                bases = (False,) if ours.one_radius else (False, True)
                found += [_Reading(form, full, transposed, short, rim) for rim in bases]
    if found:
        return found
    also = f" (without VY: 2 x {n}, {n} x 2)" if ours.planar else ""
    shape = " x ".join(str(length) for length in pasted.shape)
    raise ShapeError(
        f"the matrix is {shape}, but robot {ours.robot.name!r} has {n} driven "
        f"wheel{'s' * (n != 1)}: a forward matrix is 3 x {n}, an inverse {n} x 3{also}"
    )


class _Frame(NamedTuple):
    """What was done to the twist: pasted inverse = ours @ matrix."""

    swap: bool
    signs: tuple[int, ...]  # of VX, VY, WZ
    column: int  # the one whose factor is not 1
    factor: float
    cost: float
    matrix: Array


def _frames() -> list[_Frame]:
    factors = [(2, 1.0, 0.0), (2, 2.0, 1.0), (2, 0.5, 1.0), (2, math.pi / 180, 1.0)]
    factors += [(j, factor, 1.2) for j in (0, 1) for factor in (2.0, 0.5)]
    frames = []
    for signs in itertools.product((1, -1), repeat=3):
        # All three at once are one change: the wheels turn the other way.
        negated = 1 if sum(signs) == -3 else signs.count(-1)
        for swap, (column, factor, price) in itertools.product((False, True), factors):
            matrix = np.diag(np.array(signs, dtype=np.float64))
            matrix[column, column] *= factor
            matrix = matrix[[1, 0, 2]] if swap else matrix
            frames.append(_Frame(swap, signs, column, factor, negated + swap + price, matrix))
    return frames


class _Changes(NamedTuple):
    """What each wheel's line of a matrix may be changed to."""

    names: tuple[str, ...]  # (k,)
    costs: Array  # (k,)
    lines: Array  # (k, n, 3)

    @classmethod
    def of(cls, own: Array, more: dict[str, tuple[float, Array]]) -> _Changes:
        """Return our own lines, reversed ones, those with one sign lost, and more."""
        found = {"": (0.0, own), "reversed": (1.0, -own)} | more
        for j, name in enumerate(_NAMES):
            found[name] = (_ENTRY, own * np.where(np.arange(3) == j, -1.0, 1.0))
        costs, lines = zip(*found.values(), strict=True)
        return cls(tuple(found), np.array(costs), np.stack(lines))


class _Variant(NamedTuple):
    """Our maps with the geometry of all wheels changed at once."""

    code: str
    cost: float
    arms: Array  # (n,) what each rim runs for one radian of yaw [m]
    inverse: _Changes  # rows of R^-1 A
    forward: _Changes  # columns of W


def _variants(ours: _Ours) -> list[_Variant]:
    found = [_variant(ours, "", 0.0, ours.inverse, ours.mirrored)]
    if ours.rollers.any():
        found.append(_variant(ours, "rollers_mirrored", 1.0, ours.mirrored, ours.inverse))
    for code, along, across in _ARMS if ours.turns else ():
        if code == "arm_difference" and not ours.rollers.any():
            continue
        rows = _inverse(ours.robot, ours.steering, along, across)
        if not any(np.allclose(rows, each.inverse.lines[0]) for each in found):
            found.append(_variant(ours, code, 1.1, rows, None))
    return found


def _variant(ours: _Ours, code: str, cost: float, own: Array, other: Array | None) -> _Variant:
    columns = ours.forward(own).T
    rows_more: dict[str, tuple[float, Array]] = {}
    columns_more: dict[str, tuple[float, Array]] = {}
    if other is not None and ours.rollers.any():
        rows_more = {
            "mirrored": (1.0, other),
            "mirrored reversed": (2.0, -other),
            "leaning": (_LEANING, np.column_stack([other[:, :2], own[:, 2]])),
        }
        # A mirrored roller mirrors the wheel's push about its drive direction.
        c, s = np.array([[math.cos(2 * w.heading), math.sin(2 * w.heading)]
                         for w in ours.robot.driven]).T  # fmt: skip
        u, v, r = columns.T
        columns_more = {"leaning": (_LEANING, np.column_stack([c * u + s * v, s * u - c * v, r]))}
    arms = np.asarray(own[:, 2] * ours.radii)
    inverse, forward = _Changes.of(own, rows_more), _Changes.of(columns, columns_more)
    return _Variant(code, cost, arms, inverse, forward)


class _Scale(NamedTuple):
    """The factor on the whole inverse map, and the quantity that goes with it."""

    factor: float
    rim: bool
    code: str
    cost: float


class _Explanation(NamedTuple):
    """Changes that turn our matrix into the pasted one."""

    reading: _Reading
    frame: _Frame
    variant: _Variant
    scale: _Scale
    order: tuple[int, ...]  # our wheel for each pasted one
    changes: tuple[str, ...]  # of each pasted wheel
    cost: float


def compare_matrix(
    robot: Robot, matrix: npt.ArrayLike, steering: npt.ArrayLike | None = None
) -> Comparison:
    """Return how a matrix from elsewhere compares with ours, with the differences in words.

    Looked for are the fewest changes that turn ours into it: rim speeds, order, reversed wheels,
    mirrored rollers, signs and order of the twist's components, the yaw arm, units and factors.

    Args:
        robot: the robot.
        matrix: (3, n) forward or (n, 3) inverse; robots without sideways motion may leave out VY.
            The columns of an inverse count only for twists that the robot can have.
        steering: (s,) steering angles [rad] of a robot that steers.

    Raises:
        ShapeError: the matrix fits neither form, or steering angles are missing.
        OffCentreError: the steering angles share no instantaneous centre.

    >>> from trundle import load
    >>> compare_matrix(load("differential"), [[0.025, 0.025], [-0.0625, 0.0625]]).findings[0].code
    'arm_doubled'
    """
    pasted = finite(matrix, "matrix")
    ours = _Ours.of(robot, steering)
    readings, variants = _readings(ours, pasted), _variants(ours)
    pairs = [(f, v) for f in _frames() for v in variants if f.factor == 1 or v.code == ""]
    pairs.sort(key=lambda pair: pair[0].cost + pair[1].cost)
    for step in range(3):
        best: _Explanation | None = None
        for reading in readings:
            tolerance = _tolerance(reading, step)
            if step < 2 or (tolerance > _PRINTED).any():
                best = _search(ours, reading, pairs, tolerance, best)
        if best is not None:
            return _told(ours, best, rounded=step > 0)
    return _unexplained(ours, readings)


def _tolerance(reading: _Reading, step: int) -> Array:
    """Return the relative tolerance (3,) of the entries of VX, VY and WZ."""
    if step < 2:
        return np.full(3, (_EXACT, _PRINTED)[step])
    rows = reading.matrix.T if reading.form == "forward" else reading.matrix
    decimals = max(len(f"{x:.12f}".rstrip("0").partition(".")[2]) for x in rows.ravel().tolist())
    # Half of the last digit printed, with room for the rounding of this very number.
    return np.clip(0.501 * 10.0**-decimals / (_sizes(rows) + 1e-300), _PRINTED, _COARSE)


def _sizes(lines: Array) -> Array:
    """Return the size (3,) of each component of lines (..., n, 3); VX and VY share a unit."""
    u, v, r = np.abs(lines).max(axis=-2)
    return np.array([max(u, v), max(u, v), r or max(u, v)])


def _search(
    ours: _Ours,
    reading: _Reading,
    pairs: list[tuple[_Frame, _Variant]],
    tolerance: Array,
    best: _Explanation | None,
) -> _Explanation | None:
    """Return the cheapest explanation of one reading, if it is cheaper than the best so far."""
    start = _TRANSPOSED if reading.transposed else 0.0
    for frame, variant in pairs:
        cost = start + frame.cost + variant.cost
        if best is not None and cost >= best.cost:
            break
        if reading.short and frame.swap:
            continue
        for scale, order, changes, price in _fits(ours, reading, frame, variant, tolerance):
            total = cost + scale.cost + price
            if best is None or total < best.cost:
                best = _Explanation(reading, frame, variant, scale, order, changes, total)
    return best


_Fit = tuple[_Scale, tuple[int, ...], tuple[str, ...], float]


def _fits(
    ours: _Ours, reading: _Reading, frame: _Frame, variant: _Variant, tolerance: Array
) -> Iterator[_Fit]:
    """Yield scale, order and changes of single wheels that explain a reading in a given frame."""
    units = ours.units(reading.rim)[:, None]
    rows = variant.inverse._replace(lines=units * variant.inverse.lines @ ours.feasible)
    if reading.form == "inverse":
        target = reading.matrix @ np.linalg.inv(frame.matrix) @ ours.feasible
        yield from _matches(ours, reading, target, rows, tolerance)
        return
    pasted = frame.matrix @ reading.matrix
    columns = variant.forward._replace(lines=variant.forward.lines / units)
    yield from _matches(ours, reading, pasted.T, columns, tolerance)
    # Back through the pseudo-inverse: a mirrored roller changes one row there, but every column.
    weights = ours.weights / units[:, 0]
    target = np.linalg.pinv(ours.feasible @ pasted / weights, rcond=_EXACT) / weights[:, None]
    slack = np.minimum(_SLACK * tolerance, 2 * _COARSE)
    for fit in _matches(ours, reading, target @ ours.feasible, rows, slack, inverse=True):
        scale, order, changes, _ = fit
        changed = np.empty((len(order), 3))
        for wheel, name in zip(order, changes, strict=True):
            changed[wheel] = variant.inverse.lines[variant.inverse.names.index(name), wheel]
        made = (ours.forward(changed).T / units)[list(order)]
        if (np.abs(pasted.T * scale.factor - made) <= tolerance * _sizes(made)).all():
            yield fit


def _matches(
    ours: _Ours,
    reading: _Reading,
    target: Array,
    changes: _Changes,
    tolerance: Array,
    inverse: bool = False,
) -> Iterator[_Fit]:
    """Yield scale, order and changes that turn our lines into the target's, line by line."""
    inverse = inverse or reading.form == "inverse"
    own = changes.lines[0]
    # Signs, order and (in a plane without constraints) mirrored rollers keep the norm of VX, VY.
    part = slice(0, 2) if own[:, :2].any() else slice(0, 3)
    ratio = float(np.linalg.norm(target[:, part]) / np.linalg.norm(own[:, part]))
    if ratio == 0:
        return
    scale = _named_scale(ours, reading, ratio if inverse else 1 / ratio, float(tolerance.max()))
    if scale is None:
        return
    lines = changes.lines * (scale.factor if inverse else 1 / scale.factor)
    near = np.abs(target[None, :, None] - lines[:, None]) <= tolerance * _sizes(lines[0])
    prices = np.where(near.all(axis=-1), changes.costs[:, None, None], _NEVER)
    order, cost = _assign(prices.min(axis=0))
    if cost < _NEVER:
        chosen = prices[:, np.arange(len(target)), list(order)].argmin(axis=0)
        yield scale, order, tuple(changes.names[i] for i in chosen), cost


def _assign(price: Array) -> tuple[tuple[int, ...], float]:
    """Return our wheel for each pasted one, and the price; our own order where that is possible."""
    n = len(price)
    own = float(np.trace(price))
    same = tuple(range(n))
    if own <= _ORDER:
        return same, own
    if (price.min(axis=0) >= _NEVER).any() or (price.min(axis=1) >= _NEVER).any():
        return same, _NEVER
    from scipy.optimize import linear_sum_assignment

    # Among equals, as many wheels as can be stay where they are.
    _, to = linear_sum_assignment(price + 0.01 * (1 - np.eye(n)))
    moved = float(price[np.arange(n), to].sum()) + _ORDER
    if own <= moved:
        return same, own
    return tuple(int(i) for i in to), moved


def _named_scale(ours: _Ours, reading: _Reading, ratio: float, tolerance: float) -> _Scale | None:
    """Return what the factor between the inverse maps stands for."""
    n, radius = len(ours.names), float(ours.radii[0])
    units = [(False, 1.0), (True, radius)] if ours.one_radius else [(reading.rim, 1.0)]
    factors = {1.0: "", 2.0: "factor", 0.5: "factor", float(n): "factor", 1 / n: "factor"}
    factors[1.0] = ""  # also where n is 1
    push = np.abs(np.cos(ours.rollers))
    if np.ptp(push) <= _EXACT and push[0] < 1 - _EXACT:
        factors[float(push[0])] = "roller_cosine"
    named = [
        _Scale(unit * factor, rim, code, float(code != ""))
        for factor, code in factors.items()
        for rim, unit in units
    ]
    if not units[0][0]:
        named.append(_Scale(30 / math.pi, False, "rpm", 1.0))
    off = [abs(ratio / scale.factor - 1) for scale in named]
    for scale, miss in zip(named, off, strict=True):
        if miss <= tolerance:
            return scale
    # The rounding of a name is left to a step with more tolerance; any factor on a transpose
    # explains what is a few numbers only.
    if reading.transposed or min(off) <= max(_PRINTED, 2 * tolerance):
        return None
    if ours.one_radius and 0.25 < ratio < 4:
        return _Scale(ratio, False, "radius", _RADIUS)
    rim, _ = min(units, key=lambda each: abs(math.log(ratio / each[1])))
    return _Scale(ratio, rim, "scale", _FACTOR)


def _matrix(ours: _Ours, form: str, rim: bool, order: tuple[int, ...]) -> Array:
    """Return our matrix (3, n) or (n, 3) in the form, quantity and order of the pasted one."""
    if form == "forward":
        return np.asarray((ours.forward(ours.inverse) / ours.units(rim))[:, list(order)])
    return np.asarray((ours.units(rim)[:, None] * ours.inverse)[list(order)])


def _result(
    ours: _Ours,
    reading: _Reading,
    rim: bool,
    order: tuple[int, ...],
    agrees: bool,
    findings: list[Difference],
) -> Comparison:
    mine = _matrix(ours, reading.form, rim, order)
    off = reading.matrix - mine
    off = off if reading.form == "forward" else off @ ours.feasible
    if reading.short:
        mine = np.delete(mine, 1, axis=0 if reading.form == "forward" else 1)
    mine.setflags(write=False)
    return Comparison(
        agrees=agrees,
        form=reading.form,
        quantity="rim speeds in m/s" if rim else "wheel speeds in rad/s",
        order=tuple(ours.names[i] for i in order),
        findings=tuple(findings),
        largest_difference=float(np.abs(off).max()),
        ours=mine,
    )


def _told(ours: _Ours, found: _Explanation, rounded: bool) -> Comparison:
    findings = [
        *_transposed_words(found),
        *_scale_words(ours, found),
        *_frame_words(ours, found),
        *_variant_words(ours, found),
        *_wheel_words(ours, found),
    ]
    agrees = not findings
    findings += _order_words(ours, found)
    if rounded:
        same = "it agrees" if agrees else "with these changes it agrees"
        findings.append(Difference("rounded", f"{same} to the digits given"))
    return _result(ours, found.reading, found.scale.rim, found.order, agrees, findings)


def _line(found: _Explanation, wheel: bool = False) -> str:
    """Return what a wheel's or a twist component's line of the matrix is called."""
    return "row" if (found.reading.form == "inverse") == wheel else "column"


def _times(found: _Explanation, factor: float) -> str:
    """Return how many times ours the entries are, for a factor on the inverse map."""
    factor = 1 / factor if found.reading.form == "forward" else factor
    return {2.0: "twice", 0.5: "half of"}.get(factor, f"{factor:.4g} times") + " ours"


def _quoted(ours: _Ours, wheels: Iterable[int]) -> str:
    return join([repr(ours.names[i]) for i in wheels])


def _transposed_words(found: _Explanation) -> list[Difference]:
    if not found.reading.transposed:
        return []
    form = found.reading.form
    other = {"forward": "inverse", "inverse": "forward"}[form]
    told = f"the matrix is transposed: it is the {form} matrix with rows and columns exchanged"
    return [Difference("transposed", f"{told}, which is not the {other} matrix")]


def _scale_words(ours: _Ours, found: _Explanation) -> list[Difference]:
    scale, forward, n = found.scale, found.reading.form == "forward", len(ours.names)
    radius = float(ours.radii[0])
    factor = scale.factor / (radius if scale.rim and ours.one_radius else 1.0)
    told, reasons = f"every entry is {_times(found, factor)}", []
    if scale.code == "":
        return []
    if scale.code == "radius":
        told = f"the matrix uses the radius {radius / factor:.4g} m in place of {radius:.4g} m"
    elif scale.code == "rpm":
        told = "the wheel speeds are in rev/min in place of rad/s: a factor of 60/(2 pi)"
    elif scale.code == "roller_cosine":
        reasons.append("the cosine of the roller angle is left out")
    elif factor == 0.5 and not scale.rim and ours.one_radius:
        reasons.append(f"the diameter {2 * radius:.4g} m in place of the radius {radius:.4g} m")
    if scale.code == "factor" and factor == 1 / n and forward:
        reasons.append(f"a sum over the {n} wheels in place of their mean")
    return [Difference(scale.code, f"{told}{': ' if reasons else ''}{join(reasons, 'or')}")]


_BACKWARDS = {
    "VX": ("+VX drives backwards", "driving forwards comes out as driving backwards"),
    "VY": ("+VY drives to the right", "driving to the left comes out as driving to the right"),
    "WZ": ("+WZ turns clockwise", "turning counter-clockwise comes out as clockwise"),
}


def _frame_words(ours: _Ours, found: _Explanation) -> list[Difference]:
    frame, line, forward = found.frame, _line(found), found.reading.form == "forward"
    told = []
    if frame.swap:
        told.append(Difference("axes_swapped", f"the {line}s VX and VY are swapped"))
    for name, sign in zip(_NAMES, frame.signs, strict=True):
        if sign < 0 and sum(frame.signs) != -3:
            swapped = frame.swap and name != "WZ"
            so = "" if swapped else f", so that {_BACKWARDS[name][forward]}"
            message = f"the {name} {line} has the wrong sign{so}"
            told.append(Difference(f"{name.lower()}_sign", message))
    if frame.factor != 1:
        told.append(_factor_words(ours, found))
    return told


def _factor_words(ours: _Ours, found: _Explanation) -> Difference:
    name, factor = _NAMES[found.frame.column], found.frame.factor
    told = f"the {name} {_line(found)} is {_times(found, factor)}"
    if name != "WZ":
        return Difference(f"{name.lower()}_factor", told)
    if factor not in (2.0, 0.5):
        return Difference("degrees", f"{told}: its yaw rate is in deg/s, a factor of 180/pi")
    arms = np.abs(found.variant.arms)
    if ours.turns and np.ptp(arms) <= _EXACT * arms[0]:
        told += f": the yaw arm is {factor * arms[0]:.4g} m in place of {arms[0]:.4g} m"
        if factor == 2 and np.allclose(arms, [abs(wheel.y) for wheel in ours.robot.driven]):
            told += ", the full track in place of half of it"
    return Difference("arm_doubled" if factor == 2 else "arm_halved", told)


_WRONG_ARM = {
    "arm_difference": "takes half the wheelbase and half the track with the wrong sign between",
    "full_track": "takes the full track in place of half of it",
    "full_wheelbase": "takes the full wheelbase in place of half of it",
    "no_wheelbase": "leaves out how far the wheels are in front or behind (x)",
    "no_track": "leaves out how far the wheels are to the side (y)",
}


def _variant_words(ours: _Ours, found: _Explanation) -> list[Difference]:
    code = found.variant.code
    if code not in _WRONG_ARM:
        return []
    told = f"the WZ {_line(found)} {_WRONG_ARM[code]}: {_arm_words(ours, found.variant.arms)}"
    return [Difference(code, told)]


def _arm_words(ours: _Ours, arms: Array) -> str:
    own = ours.inverse[:, 2] * ours.radii
    i = int(np.argmax(np.abs(arms - own)))
    turned = ", with the other sign" if arms[i] * own[i] < 0 else ""
    return (
        f"the yaw arm of {ours.names[i]!r} is {abs(arms[i]):.4g} m in place of "
        f"{abs(own[i]):.4g} m{turned}"
    )


def _wheel_words(ours: _Ours, found: _Explanation) -> list[Difference]:
    row, column, n = _line(found, wheel=True), _line(found), len(ours.names)
    change = dict(zip(found.order, found.changes, strict=True))
    flipped, other = sum(found.frame.signs) == -3, found.variant.code == "rollers_mirrored"
    backwards = [i for i in range(n) if ("reversed" in change[i]) != flipped]
    mirrored = [i for i in range(n) if ("mirrored" in change[i]) != other]
    told = []
    if len(backwards) == n > 1:
        message = "all wheels are reversed: every entry has the wrong sign"
        told.append(Difference("all_reversed", message))
    elif backwards:
        many = len(backwards) > 1
        message = f"{_quoted(ours, backwards)} {'are' if many else 'is'} reversed: the {row}"
        message += "s have the wrong sign" if many else " has the wrong sign"
        told.append(Difference("reversed", message))
    if mirrored:
        told.append(_mirrored_words(ours, mirrored, found))
    for i in range(n):
        where = f"{row} {ours.names[i]!r}"
        if change[i] == "leaning":
            message = f"{where} has the sign of a mirrored roller, but our yaw arm"
            told.append(Difference("roller_sign", message))
        elif change[i] in _NAMES:
            message = f"{where}, {column} {change[i]}: the entry has the wrong sign"
            told.append(Difference("entry_sign", message))
    return told


def _mirrored_words(ours: _Ours, which: list[int], found: _Explanation) -> Difference:
    degrees = np.degrees(ours.rollers[which[0]])
    angles = f"{-degrees:.4g} deg in place of {degrees:.4g} deg"
    row, many = _line(found, wheel=True), len(which) > 1
    if many and len(which) == np.count_nonzero(ours.rollers):
        arm = _arm_words(ours, ours.mirrored[:, 2] * ours.radii)
        told = f"all rollers are mirrored ({ours.names[which[0]]!r}: {angles}), so that {arm}"
        return Difference("rollers_mirrored", told)
    told = f"{row}{'s' * many} {_quoted(ours, which)} {'have' if many else 'has'} the sign of a "
    told += f"mirrored roller ({ours.names[which[0]]!r}: {angles})"
    if found.reading.form == "forward":
        told += "; in a forward matrix that changes every column"
    return Difference("roller_mirrored", told)


def _order_words(ours: _Ours, found: _Explanation) -> list[Difference]:
    moved = [k for k, wheel in enumerate(found.order) if wheel != k]
    if not moved:
        return []
    row = _line(found, wheel=True)
    told = f"the {row}s stand in the order {_quoted(ours, found.order)}, not in the robot's"
    if len(moved) == 2:
        told = f"order swapped: the {row}s of {_quoted(ours, moved)} have changed places"
    return [Difference("order", told)]


def _unexplained(ours: _Ours, readings: list[_Reading]) -> Comparison:
    """Return the reading that comes nearest, with the entries that differ most."""
    order = tuple(range(len(ours.names)))
    upright = [each for each in readings if not each.transposed] or readings
    tried = [(each, rim) for each in upright for rim in (False, True)]
    for reading, rim in tried:
        if reading.form == "forward":
            there_and_back = reading.matrix @ _matrix(ours, "inverse", rim, order)
            if np.allclose(there_and_back @ ours.feasible, ours.feasible, atol=_PRINTED):
                told = "it gives the right twist while no wheel slips, but is not the least-squares"
                told += " one: where wheels disagree it weighs them in another way"
                findings = [Difference("other_weights", told)]
                return _result(ours, reading, rim, order, False, findings)
    misses = [_misses(ours, reading, rim) for reading, rim in tried]
    nearest = int(np.argmin([float(np.minimum(miss, 1.0).mean()) for miss in misses]))
    (reading, rim), miss = tried[nearest], misses[nearest]
    wrong = int((miss > _PRINTED).sum())
    told = f"no simple change explains the difference: {wrong} of {miss.size} entries differ"
    findings = [Difference("unexplained", told)]
    for k in np.argsort(-miss, axis=None)[: min(3, wrong)]:
        findings.append(_entry_words(ours, reading, rim, divmod(int(k), miss.shape[1])))
    return _result(ours, reading, rim, order, False, findings)


def _misses(ours: _Ours, reading: _Reading, rim: bool) -> Array:
    """Return the differences from ours, relative to the entries of the same unit."""
    off = reading.matrix - _matrix(ours, reading.form, rim, tuple(range(len(ours.names))))
    if reading.form == "inverse":
        return np.asarray(np.abs(off @ ours.feasible) / _sizes(reading.matrix - off))
    return np.asarray(np.abs(off) / _sizes((reading.matrix - off).T)[:, None])


def _entry_words(ours: _Ours, reading: _Reading, rim: bool, at: tuple[int, int]) -> Difference:
    mine = _matrix(ours, reading.form, rim, tuple(range(len(ours.names))))
    i, j = at if reading.form == "inverse" else at[::-1]
    lines = (repr(ours.names[i]), _NAMES[j])
    row, column = lines if reading.form == "inverse" else lines[::-1]
    told = f"row {row}, column {column}: {reading.matrix[at]:.6g} in place of {mine[at]:.6g}"
    return Difference("entry", told)
