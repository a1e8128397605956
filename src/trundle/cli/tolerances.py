"""``--vary NAME=SPREAD``: robots that are not quite as described."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import typer

from trundle.cli.numbers import number
from trundle.errors import TrundleError, did_you_mean
from trundle.kinematics import mobility
from trundle.robot import FixedWheel, Robot, RollingWheel, Wheel
from trundle.se2 import Array

# Numbers of a wheel that tell where its robot goes.
_FIELDS = ("radius", "x", "y", "track_factor")
_POSITIVE = ("radius", "arm", "track", "wheelbase")


@dataclass(frozen=True)
class Tolerance:
    """How well a number of the robot is known.

    Attributes:
        name: of the number, as ``rollout`` has its parameters.
        given: the spread as it was typed.
        spread: standard deviation, in the unit of the number or as a share of it.
        relative: whether it is a share.
    """

    name: str
    given: str
    spread: float
    relative: bool


def tolerances_of(items: list[str]) -> list[Tolerance]:
    """Return the tolerances of the command line.

    Raises:
        TrundleError: one is not NAME=SPREAD, or comes twice.
    """
    found = [_tolerance(item) for item in items]
    names = [each.name for each in found]
    for name in names:
        if names.count(name) > 1:
            raise TrundleError(f"--vary has {name!r} twice")
    return found


def _tolerance(item: str) -> Tolerance:
    name, equals, given = (part.strip() for part in item.partition("="))
    if not (name and equals):
        raise TrundleError(f"--vary needs NAME=SPREAD, such as radius=1%, got {item!r}")
    relative = given.endswith("%")
    try:
        spread = number(given.removesuffix("%"))
    except typer.BadParameter as error:
        raise TrundleError(f"--vary {item}: {error}") from None
    if spread < 0:
        raise TrundleError(f"--vary {item}: a spread must not be negative")
    return Tolerance(name, given, spread / 100 if relative else spread, relative)


def draw_robots(
    robot: Robot, tolerances: list[Tolerance], count: int, seed: int
) -> dict[str, Array]:
    """Return the numbers (N,) of robots within tolerances, as ``rollout`` takes its parameters.

    The deviations are normal. Those of a wheel alone add to those that it shares with others. Each
    name has its own random numbers, so that one more tolerance leaves the others' as they were.

    Raises:
        TrundleError: a name is not known, or a spread so wide that a size would not be positive.
    """
    wheels = [wheel for wheel in robot.wheels if isinstance(wheel, RollingWheel)]
    sizes, own, whole = _sizes(robot), dict[str, Array](), dict[str, Array]()
    for each in tolerances:
        deviation = each.spread * _normal(seed, each.name, count)
        if each.name in sizes:
            whole[each.name] = _deviating(each, sizes[each.name], sizes[each.name], deviation)
            continue
        wheel_name, _, field = each.name.rpartition(".")
        chosen = [w for w in wheels if wheel_name in ("", w.name) and _has(w, field)]
        if not chosen:
            raise TrundleError(_unknown(robot, wheels, sizes, each))
        if each.relative and not any(getattr(wheel, field) for wheel in chosen):
            raise TrundleError(
                f"--vary {each.name}={each.given}: {each.name} is 0, so a percentage says nothing; "
                "give a standard deviation"
            )
        for wheel in chosen:
            described, name = getattr(wheel, field), f"{wheel.name}.{field}"
            own[name] = _deviating(each, own.get(name, described), described, deviation)
    _check_rolling(robot, own, tolerances)
    # Sizes come last: they move the wheels from where these stand.
    return own | whole


def _deviating(
    tolerance: Tolerance, values: Array | float, described: float, deviation: Array
) -> Array:
    """Return values with a deviation added; a share is one of the number as described."""
    found = np.asarray(values + deviation * (described if tolerance.relative else 1.0))
    if tolerance.name.rpartition(".")[2] in _POSITIVE and found.min() <= 0:
        raise TrundleError(
            f"--vary {tolerance.name}={tolerance.given} is too wide: normal deviations give one of "
            f"{len(found)} robots {tolerance.name} = {found.min():.3g} m"
        )
    return found


def _check_rolling(robot: Robot, own: dict[str, Array], tolerances: list[Tolerance]) -> None:
    """Refuse displacements that hold the robot fast, as wheels whose axles are not in line do."""

    def first(wheel: Wheel, axis: str) -> float:
        values = own.get(f"{wheel.name}.{axis}")
        return float(getattr(wheel, axis) if values is None else values[0])

    wheels = [dataclasses.replace(w, x=first(w, "x"), y=first(w, "y")) for w in robot.wheels]
    displaced = dataclasses.replace(robot, wheels=tuple(wheels))
    if mobility(displaced).degree < mobility(robot).degree:
        names = [each.name for each in tolerances if each.name.rpartition(".")[2] in ("x", "y")]
        raise TrundleError(
            f"--vary {' and '.join(names)}: wheels displaced like this do not roll together: "
            f"robot {robot.name!r} could no longer turn without slip, which is not simulated"
        )


def _normal(seed: int, name: str, count: int) -> Array:
    return np.random.default_rng([seed, *name.encode()]).standard_normal(count)


def _sizes(robot: Robot) -> dict[str, float]:
    """Return the sizes of a whole robot that are not zero [m]."""
    at = np.array([(wheel.x, wheel.y) for wheel in robot.wheels])
    sizes = {"arm": np.hypot(*at.T).max(), "track": np.ptp(at[:, 1]), "wheelbase": np.ptp(at[:, 0])}
    return {name: float(size) for name, size in sizes.items() if size > 0}


def _has(wheel: RollingWheel, field: str) -> bool:
    if field == "track_factor":
        return isinstance(wheel, FixedWheel) and wheel.skid
    return field in _FIELDS


def _unknown(
    robot: Robot, wheels: list[RollingWheel], sizes: dict[str, float], tolerance: Tolerance
) -> str:
    common = [field for field in _FIELDS if any(_has(wheel, field) for wheel in wheels)]
    known = [*common, *sizes]
    each = [f"{wheel.name}.{field}" for wheel in wheels for field in common if _has(wheel, field)]
    close = did_you_mean(tolerance.name, [*known, *each])
    others = f"; give one of {', '.join(known)}, or of one wheel, such as {each[0]}"
    return (
        f"--vary {tolerance.name}={tolerance.given}: nothing of that name tells where robot "
        f"{robot.name!r} goes{close or others}"
    )
