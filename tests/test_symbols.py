"""One source, many readings: sympy, numpy and plain floats read the same rows and the same step."""

import dataclasses
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy

from catalogue import ROBOTS, each_robot
from geometry import rolling_rows, slip_rows
from trundle import se2
from trundle.robot import (
    WHEEL_KINDS,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
    Wheel,
)
from trundle.robot.wheels import across_row, contact_row

# The readings differ by the order of a few products of numbers near 1.
AGREE = 1e-12

WHEELS: dict[str, Wheel] = {
    "fixed": FixedWheel(name="a", x=0.31, y=-0.42, radius=0.07, heading=0.9),
    "fixed reversed": FixedWheel(name="a", x=0.3, y=0.4, radius=0.07, heading=-2.0, reversed=True),
    "skid": FixedWheel(
        name="a", x=0.31, y=-0.42, radius=0.07, heading=0.3, skid=True, track_factor=1.3
    ),
    "steered": SteeredWheel(name="a", x=-0.8, y=0.25, radius=0.3, heading=0.4, reversed=True),
    "omni": OmniWheel(name="a", x=0.2, y=0.9, radius=0.05, heading=2.2, roller=0.1),
    "mecanum": MecanumWheel(name="a", x=0.6, y=0.1, radius=0.05, heading=0.2, roller=-0.8),
} | {
    f"{wheel.kind} of the catalogue": wheel
    for wheel in ROBOTS["mixed"].wheels
    if wheel.kind == "caster"
}
each_wheel = pytest.mark.parametrize("wheel", WHEELS.values(), ids=WHEELS)


def flat(rows: Any) -> list[Any]:
    """Return all coefficients of a wheel's rows, None for a row that is not there."""
    out: list[Any] = []
    for row in (rows.rolling, rows.side_slip, rows.skid):
        out += [None] * 3 if row is None else list(row)
    return [*out, rows.gain]


def agree(got: list[Any], wanted: list[Any]) -> None:
    assert [value is None for value in got] == [value is None for value in wanted]
    numbers = [(float(a), float(b)) for a, b in zip(got, wanted, strict=True) if a is not None]
    for a, b in numbers:
        assert a == pytest.approx(b, abs=AGREE)


@each_wheel
def test_sympy_reads_the_rows_of_a_wheel_at_a_symbolic_angle(wheel: Wheel) -> None:
    beta = sympy.Symbol("beta", real=True)
    symbolic = flat(wheel.rows(beta, sympy))
    for angle in np.random.default_rng(41).uniform(-4.0, 4.0, 10).tolist():
        got = [None if row is None else sympy.sympify(row).subs(beta, angle) for row in symbolic]
        agree(got, flat(wheel.rows(angle, math)))
        agree(flat(wheel.rows(angle, np)), flat(wheel.rows(angle)))


def symbols_of(wheel: Wheel) -> tuple[SimpleNamespace, dict[sympy.Symbol, float]]:
    """Return a stand-in for the wheel with symbols for its quantities, and their values."""
    held: dict[str, Any] = {"spin_sign": getattr(wheel, "spin_sign", 1)}
    values = {}
    for field in dataclasses.fields(wheel):
        value = getattr(wheel, field.name)
        if isinstance(value, float):
            held[field.name] = sympy.Symbol(field.name, real=True)
            values[held[field.name]] = value
        else:
            held[field.name] = value
    return SimpleNamespace(**held), values


@each_wheel
def test_sympy_reads_the_rows_of_a_kind_with_every_quantity_a_symbol(wheel: Wheel) -> None:
    beta = sympy.Symbol("beta", real=True)
    stand_in, values = symbols_of(wheel)
    symbolic = flat(type(wheel).rows(stand_in, beta, sympy))
    for angle in (0.0, 0.7, -2.9):
        at = values | {beta: angle}
        got = [None if row is None else sympy.sympify(row).subs(at) for row in symbolic]
        agree(got, flat(wheel.rows(angle)))


def test_every_kind_of_wheel_is_read() -> None:
    read = {type(wheel) for wheel in WHEELS.values()}
    without_rows = {kind for kind in WHEEL_KINDS if kind.kind == "ball"}
    assert read | without_rows == set(WHEEL_KINDS)


@each_wheel
def test_numpy_reads_whole_batches_of_angles(wheel: Wheel) -> None:
    angles = np.random.default_rng(42).uniform(-4.0, 4.0, (2, 3))
    together = flat(wheel.rows(angles, np))
    for at in np.ndindex(2, 3):
        one = [None if row is None else np.broadcast_to(row, (2, 3))[at] for row in together]
        agree(one, flat(wheel.rows(float(angles[at]))))


def test_the_rows_of_a_steered_wheel_are_the_ones_of_the_book() -> None:
    """Siegwart and Nourbakhsh (2004), eqs. (3.15) and (3.16), in Cartesian form."""
    stand_in, _ = symbols_of(WHEELS["steered"])
    beta, u, v, r = sympy.symbols("beta u v r", real=True)
    rows = SteeredWheel.rows(stand_in, beta, sympy)
    x, y, theta = stand_in.x, stand_in.y, stand_in.heading + beta
    rolling = sympy.cos(theta) * (u - r * y) + sympy.sin(theta) * (v + r * x)
    sliding = -sympy.sin(theta) * (u - r * y) + sympy.cos(theta) * (v + r * x)
    for row, wanted in ((rows.rolling, rolling), (rows.side_slip, sliding)):
        assert row is not None
        got = row[0] * u + row[1] * v + row[2] * r
        assert sympy.simplify(got - wanted) == 0
    assert rows.gain == -stand_in.radius  # reversed


def test_the_row_of_a_swedish_wheel_is_the_one_of_the_book() -> None:
    """Siegwart and Nourbakhsh (2004), eq. (3.17), in Cartesian form."""
    stand_in, _ = symbols_of(WHEELS["mecanum"])
    u, v, r = sympy.symbols("u v r", real=True)
    rows = MecanumWheel.rows(stand_in, 0, sympy)
    axis = stand_in.heading + stand_in.roller
    wanted = sympy.cos(axis) * (u - r * stand_in.y) + sympy.sin(axis) * (v + r * stand_in.x)
    assert rows.rolling is not None
    got = rows.rolling[0] * u + rows.rolling[1] * v + rows.rolling[2] * r
    assert sympy.simplify(got - wanted) == 0
    assert sympy.simplify(rows.gain - stand_in.radius * sympy.cos(stand_in.roller)) == 0
    assert rows.side_slip is None


def test_the_two_rows_of_a_contact_are_a_quarter_turn_apart() -> None:
    x, y, angle = sympy.symbols("x y angle", real=True)
    ahead = contact_row(x, y, angle + sympy.pi / 2, sympy)
    across = across_row(x, y, angle, sympy)
    assert all(sympy.simplify(a - b) == 0 for a, b in zip(ahead, across, strict=True))


@each_robot
def test_the_rows_are_contact_velocities(robot: Robot) -> None:
    """Against geometry written apart, wheel by wheel."""
    steering = np.random.default_rng(43).uniform(-2.0, 2.0, len(robot.steered)).tolist()
    angles = dict(zip([wheel.name for wheel in robot.steered], steering, strict=True))
    rows, gains = rolling_rows(robot, robot.driven, steering)
    for wheel, row, gain in zip(robot.driven, rows, gains, strict=True):
        read = wheel.rows(angles.get(wheel.name, 0.0))
        assert read.rolling == pytest.approx(list(row), abs=AGREE)
        assert read.gain == pytest.approx(gain, abs=AGREE)
    slips = [wheel.rows(angles.get(wheel.name, 0.0)).side_slip for wheel in robot.wheels]
    held = [list(row) for row in slips if row is not None]
    if held:
        assert np.array(held) == pytest.approx(slip_rows(robot, steering)[: len(held)], abs=AGREE)


# ---- the motion step -----------------------------------------------------------------------

POSES = [(0.3, -1.2, 2.0), (0.0, 0.0, 0.0), (5.0, 4.0, -3.0)]
MOVES = [(0.4, -0.1, 0.9), (1.0, 0.0, 0.0), (0.0, 2.0, 1e-9), (-1.0, 0.3, -7.0), (0.5, 0.5, 1e-300)]
READINGS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "plain floats": (math.sin, math.cos),
    "numpy": (np.sin, np.cos),
    "sympy": (sympy.sin, sympy.cos),
}


def closed_form(pose: tuple[float, ...], move: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the pose after an arc: z' = z + e^(i psi) (dx + i dy) (e^(i dpsi) - 1) / (i dpsi)."""
    x, y, psi = pose
    dx, dy, dpsi = move
    with mpmath.workdps(50):
        turn = mpmath.mpc(0, dpsi)
        chord = mpmath.expm1(turn) / turn if dpsi else mpmath.mpf(1)
        gone = mpmath.mpc(dx, dy) * mpmath.expj(psi) * chord
        return float(x + gone.real), float(y + gone.imag), psi + dpsi


@pytest.mark.parametrize("reading", READINGS.values(), ids=READINGS)
@pytest.mark.parametrize("move", MOVES, ids=str)
def test_every_reading_of_the_step_is_the_exact_arc(
    reading: tuple[Callable[..., Any], Callable[..., Any]], move: tuple[float, float, float]
) -> None:
    step = se2.make_step(*reading)
    for pose in POSES:
        got = [float(value) for value in step(*pose, *move)]
        assert got == pytest.approx(closed_form(pose, move), abs=AGREE)


def test_sympy_reads_the_step_in_symbols() -> None:
    names = sympy.symbols("x y psi dx dy dpsi", real=True)
    symbolic = se2.make_step(sympy.sin, sympy.cos)(*names)
    random = np.random.default_rng(44)
    for values in random.normal(size=(10, 6)):
        got = [float(each.subs(dict(zip(names, values, strict=True)))) for each in symbolic]
        assert got == pytest.approx(se2.step(*values.tolist()), abs=AGREE)


def test_numpy_reads_the_step_in_batches() -> None:
    values = np.random.default_rng(45).normal(size=(6, 4, 3))
    together = np.stack(se2.step_arrays(*values), axis=-1)
    for at in np.ndindex(4, 3):
        assert together[at] == pytest.approx(se2.step(*values[:, *at].tolist()), abs=AGREE)


def test_wrap_stays_in_its_half_open_interval() -> None:
    angles = np.concatenate(
        [
            np.linspace(-20.0, 20.0, 4001),
            [k * math.pi for k in range(-9, 10)],
            [np.nextafter(math.pi, 4.0), np.nextafter(-math.pi, -4.0), np.nextafter(math.pi, 3.0)],
        ]
    )
    wrapped = se2.wrap(angles)
    assert (wrapped > -math.pi).all()
    assert (wrapped <= math.pi).all()
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angles), atol=AGREE)


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)], ids=str)
def test_rotation_turns_the_body_frame_into_the_inertial_one(shape: tuple[int, ...]) -> None:
    psi = np.random.default_rng(46).uniform(-4.0, 4.0, shape)
    J = se2.rotation(psi)
    assert J.shape == (*shape, 3, 3)
    u, v, r = 0.7, -0.4, 1.1
    turned = (J @ np.array([u, v, r])[:, None])[..., 0]
    inertial = complex(u, v) * np.exp(1j * psi)
    np.testing.assert_allclose(turned[..., 0], inertial.real, atol=AGREE)
    np.testing.assert_allclose(turned[..., 1], inertial.imag, atol=AGREE)
    np.testing.assert_allclose(turned[..., 2], r, atol=AGREE)
