"""The wheels' rows stacked into matrices, over batches of steering angles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.robot import Robot, RollingWheel, Rows, Wheel
from trundle.se2 import Array

# Far beyond any speed, angle or length in SI units, and far enough from overflow for products.
_LARGEST = 1e100


def finite(values: npt.ArrayLike, name: str, last: int | None = None) -> Array:
    """Return a copy of values as an array of floats whose last axis has the right length.

    Raises:
        ShapeError: it is not such an array, or holds values that are not finite.
    """
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "iufO":
            raise TypeError
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"{name} must be an array of numbers, got {values!r}") from None
    if last is not None and (array.ndim == 0 or array.shape[-1] != last):
        raise ShapeError(
            f"{name} must have {last} values on the last axis, got shape {array.shape}"
        )
    if not np.isfinite(array).all():
        raise ShapeError(f"{name} must be finite numbers, got nan or inf")
    if np.abs(array).max(initial=0.0) > _LARGEST:
        raise ShapeError(
            f"{name} must lie between -{_LARGEST:g} and {_LARGEST:g}, got "
            f"{array.flat[int(np.abs(array).argmax())]:.3g}"
        )
    return array


def robot_of(robot: object) -> Robot:
    """Return the robot that was given.

    Raises:
        TrundleError: it is something else, such as a name.
    """
    if not isinstance(robot, Robot):
        raise TrundleError(f"a Robot is needed, such as trundle.load('omni3'), got {robot!r}")
    return robot


def one_steering(robot: Robot, steering: npt.ArrayLike | None) -> Array:
    """Return the steering angles (s,) of one position.

    Raises:
        ShapeError: they are missing, or a batch.
    """
    angles = steering_array(robot_of(robot), steering)
    if angles.ndim != 1:
        raise ShapeError(f"steering must be the angles of one position, got shape {angles.shape}")
    return angles


def steering_array(
    robot: Robot, steering: npt.ArrayLike | None, batch: tuple[int, ...] = ()
) -> Array:
    """Return steering angles (..., s); robots that do not steer may leave them out.

    Args:
        robot: the robot.
        steering: the angles, or None.
        batch: leading axes of what the angles go with.

    Raises:
        ShapeError: they are missing or have the wrong shape.
    """
    names = [wheel.name for wheel in robot.steered]
    if steering is None:
        if names:
            raise ShapeError(
                f"robot {robot.name!r} steers: give the steering angles of {', '.join(names)} [rad]"
            )
        return np.zeros(0)
    angles = finite(
        steering, f"steering of {', '.join(names) or 'a robot without steering'}", len(names)
    )
    try:
        np.broadcast_shapes(angles.shape[:-1], batch)
    except ValueError:
        raise ShapeError(
            f"steering of shape {angles.shape} does not go with a batch of shape {batch}"
        ) from None
    return angles


def wheel_rows(robot: Robot, steering: Array) -> dict[str, Rows]:
    """Return each wheel's rows by the wheel's name, at steering angles (..., s)."""
    angle = {wheel.name: steering[..., i] for i, wheel in enumerate(robot.steered)}
    return {wheel.name: wheel.rows(angle.get(wheel.name, 0.0), np) for wheel in robot.wheels}


def stack(rows: Iterable[Sequence[npt.ArrayLike]], batch: tuple[int, ...]) -> Array:
    """Return k rows of three coefficients as one array (*batch, k, 3)."""
    rows = list(rows)
    out = np.empty((*batch, len(rows), 3))
    for i, row in enumerate(rows):
        for j, coefficient in enumerate(row):
            out[..., i, j] = coefficient
    return out


def rolling_matrix(robot: Robot, wheels: Sequence[Wheel], steering: Array) -> Array:
    """Return A (..., k, 3), so that A zeta = R omega for the given wheels."""
    rows = wheel_rows(robot, steering)
    return stack((rows[w.name].rolling or (0.0, 0.0, 0.0) for w in wheels), steering.shape[:-1])


def gains(wheels: Sequence[RollingWheel]) -> Array:
    """Return the diagonal of R (..., k): signed rim speed along the row for one rad/s [m]."""
    made = abreast([wheel.rows(0.0, np).gain for wheel in wheels])
    made.setflags(write=False)
    return made


def abreast(values: Sequence[npt.ArrayLike]) -> Array:
    """Return k numbers, or k batches of numbers (...,), along the last axis."""
    if not values:
        return np.zeros(0)
    return np.stack(np.broadcast_arrays(*values), axis=-1).astype(np.float64)


def side_slip_matrix(robot: Robot, wheels: Iterable[Wheel], steering: Array) -> Array:
    """Return C (..., k, 3) of the given wheels, so that C zeta = 0."""
    rows = wheel_rows(robot, steering)
    chosen = (rows[wheel.name].side_slip for wheel in wheels)
    return stack((row for row in chosen if row is not None), steering.shape[:-1])


def skid_matrices(robot: Robot, batch: tuple[int, ...] = ()) -> tuple[Array, Array]:
    """Return rolling and side-slip rows (*batch, k, 3) of the wheels that are allowed to skid."""
    rows = [wheel.rows(0.0, np) for wheel in robot.wheels]
    skids = [row for row in rows if row.skid is not None]
    return (
        stack((row.rolling or (0.0, 0.0, 0.0) for row in skids), batch),
        stack((row.skid or (0.0, 0.0, 0.0) for row in skids), batch),
    )


# Wheels whose places differ by less than this share of their radius stand at one spot: no wheel is
# placed so well, and with angles rounded to sixteen digits little would be left to see.
_ONE_SPOT = 1e-9


def frame(robot: Robot) -> Array:
    """Return the map (3, 3) to twists from coordinates in which a robot of any size looks alike.

    They are u and v of the wheels' centroid and the speed that yaw gives at the outermost wheel:
    ranks that are decided there depend neither on the origin nor on the unit of length. Wheels that
    are all but at one spot have their radius in place of that distance. Of wheels whose places are
    batches, their means are taken.
    """
    wheels = [wheel for wheel in robot.wheels if wheel.rows(0.0, np) != Rows()] or robot.wheels
    place = np.array([(np.mean(wheel.x), np.mean(wheel.y)) for wheel in wheels])
    x, y = place.mean(axis=0)
    far = float(np.hypot(*(place - (x, y)).T).max())
    radii = [getattr(wheel, "radius", None) for wheel in wheels]
    size = max(1.0 if radius is None else float(np.mean(radius)) for radius in radii)
    length = far if far > _ONE_SPOT * size else size
    return np.array([[1.0, 0.0, y / length], [0.0, 1.0, -x / length], [0.0, 0.0, 1 / length]])
