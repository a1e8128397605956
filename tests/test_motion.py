"""Trajectories: derivatives, headings through standstills and cusps, the lectures' tables, files.

Expected values come from mpmath with 50 digits, sympy, closed forms and plain loops.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate

from geometry import Floats
from trundle import motion
from trundle.errors import FileError, ShapeError, TrundleError
from trundle.motion import Trajectory

# A few dozen operations on numbers of the size of the trajectory, each rounded at 1e-16.
ROUNDING = 1e-12
# Derivatives of headings divide by the square of a speed: digits go where it is small.
DIVIDED = 1e-9
# Central differences over 2 h lose h^2 to curvature and 1e-16 / h to rounding.
STEP, DIFFERENCE = 1e-4, 3e-6
# The tables give four or five digits.
FOUR_DIGITS = 1e-4

LECTURE_POINTS = [(0.0, 0.0), (2.0, 2.0), (0.0, 4.0)]
VIA_TIMES = (0.0, 30.0, 60.0)
ZIGZAG = [(0.0, 0.0), (2.0, 0.3), (1.0, 2.0), (-1.0, 1.5), (0.5, -1.0)]
ZIGZAG_TIMES = [0.0, 2.0, 3.5, 6.0, 9.0]

CLOSED: dict[str, Trajectory] = {
    "circle": motion.circle(3.0, 0.4),
    "clockwise circle": motion.circle(2.0, -0.5),
    "ellipse": motion.ellipse(3.0, 2.0, 0.4),
    "flat ellipse": motion.ellipse(2.0, 0.3, -0.4),
    "lissajous": motion.lissajous(3.0, 2.0, 0.8, 0.4),
    "lissajous 3:5": motion.lissajous(1.0, 1.5, 0.3, -0.5),
    "parabola": motion.lissajous(3.0, 2.0, 0.4, 0.8),
    "cusps 3:4": motion.lissajous(3.0, 2.0, -0.3, 0.4),
    "cusps 1:6": motion.lissajous(3.0, 2.0, 0.1, -0.6),
    "eight": motion.figure_eight(4.0, 0.5),
    "fat eight": motion.figure_eight(2.0, -0.5, width=3.0),
}
ENDING: dict[str, Trajectory] = {
    "line": motion.line((1.0, 2.0), (-1.0, 1.0), 4.0),
    "quintic": motion.quintic((0, 0), (1, 0), 2.0, start_velocity=(0, 1), end_velocity=(0, -1)),
    "quintic from rest": motion.quintic(
        (0, 0), (2, 1), 3.0, start_acceleration=(0, 1), end_acceleration=(0.5, 0)
    ),
    "via 1": motion.cubic_via(LECTURE_POINTS, VIA_TIMES, via_velocity=(0, 0)),
    "via 2": motion.cubic_via(LECTURE_POINTS, VIA_TIMES),
    "via with speed": motion.cubic_via(LECTURE_POINTS, (0.0, 2.0, 5.0), via_velocity=(-1, 1)),
    "five points": motion.via(ZIGZAG, ZIGZAG_TIMES),
    "waypoints": motion.waypoints(ZIGZAG, 1.0, 0.8),
    "no period": motion.lissajous(1.0, 1.0, 0.5, 0.5 * math.sqrt(2), duration=20.0),
}
OWN: dict[str, Trajectory] = {
    "fixed": motion.ellipse(3.0, 2.0, 0.4, heading=-2.0),
    "spinning": motion.figure_eight(4.0, 0.5, heading=motion.spin(-0.7, start=1.0)),
    "profile": motion.circle(3.0, 0.4, heading=motion.profile([0, 5, 20], [0, 2, -7])),
    "headings": motion.via(ZIGZAG, ZIGZAG_TIMES, heading=[0, 1, 7, -3, 2]),
    "turn on the spot": motion.line((1, 2, 0), (1, 2, 3), 4.0),
    "moved": motion.ellipse(3.0, 2.0, 0.4).moved(1.0, -2.0, 2.5),
    "stretched": motion.via(ZIGZAG, ZIGZAG_TIMES).stretched(1.7),
}
ALL = CLOSED | ENDING | OWN
each_closed = pytest.mark.parametrize("trajectory", CLOSED.values(), ids=CLOSED)
each_ending = pytest.mark.parametrize("trajectory", ENDING.values(), ids=ENDING)
each_trajectory = pytest.mark.parametrize("trajectory", ALL.values(), ids=ALL)


def times_of(trajectory: Trajectory, count: int = 400, seed: int = 71) -> Floats:
    """Return times in and around the span, none of them at a joint of two pieces."""
    draw = np.random.default_rng(seed)
    return np.sort(draw.uniform(-0.2, 1.3, count)) * trajectory.duration


def turn_between(a: Any, b: Any, whole: float = math.tau) -> Any:
    """Return how far two angles are apart modulo a whole turn (or half of one)."""
    return np.abs(np.remainder(np.asarray(a) - b + whole / 2, whole) - whole / 2)


# ---- derivatives ---------------------------------------------------------------------------


@each_trajectory
def test_the_derivatives_are_those_of_the_position(trajectory: Trajectory) -> None:
    t = times_of(trajectory)
    _, velocity, acceleration = trajectory.sample(t)
    for function, slope in (
        (trajectory.position, velocity),
        (trajectory.velocity, acceleration),
    ):
        before, after = function(t - STEP), function(t + STEP)
        found = (after - before) / (2 * STEP)
        # Where a leap lies between the two (a corner, the end of a motion) there is no slope.
        steps = np.abs(after - before)
        smooth = (steps <= 4 * STEP * (np.abs(slope) + 1e-2)).all(axis=1)
        assert smooth.mean() > 0.95
        size = 1 + np.abs(slope) + np.abs(found)
        # Errors grow with the third derivative, which sharp bends have a lot of.
        error = (np.abs(found - slope) / size)[smooth]
        assert np.quantile(error, 0.9) < DIFFERENCE
        assert error.max() < 3e-2


def exact_closed(name: str) -> tuple[Any, Any, Any]:
    """Return t, x(t), y(t) in symbols for a closed curve of the table, from its definition."""
    t = sympy.Symbol("t", real=True)
    sin, cos, r = sympy.sin, sympy.cos, sympy.Rational

    def lissajous(r_x: Any, r_y: Any, w_x: Any, w_y: Any) -> tuple[Any, Any, Any]:
        return t, r_x * sin(w_x * t), r_y - r_y * cos(w_y * t)

    return {
        "circle": lissajous(3, 3, r(2, 5), r(2, 5)),
        "clockwise circle": lissajous(2, 2, -r(1, 2), -r(1, 2)),
        "ellipse": lissajous(3, 2, r(2, 5), r(2, 5)),
        "flat ellipse": lissajous(2, r(3, 10), -r(2, 5), -r(2, 5)),
        "lissajous": lissajous(3, 2, r(4, 5), r(2, 5)),
        "lissajous 3:5": lissajous(1, r(3, 2), r(3, 10), -r(1, 2)),
        "parabola": lissajous(3, 2, r(2, 5), r(4, 5)),
        "cusps 3:4": lissajous(3, 2, -r(3, 10), r(2, 5)),
        "cusps 1:6": lissajous(3, 2, r(1, 10), -r(3, 5)),
        "eight": (t, 2 * sin(t / 2), sin(t)),
        "fat eight": (t, sin(-t / 2), r(3, 2) * sin(-t)),
    }[name]


@pytest.mark.parametrize("name", CLOSED)
def test_closed_curves_are_what_sympy_differentiates(name: str) -> None:
    t, x, y = exact_closed(name)
    psi = sympy.atan2(y.diff(t), x.diff(t))
    orders = [
        sympy.lambdify(t, [x.diff(t, n), y.diff(t, n), psi.diff(t, n)], "mpmath") for n in range(3)
    ]
    trajectory = CLOSED[name]
    with mpmath.workdps(50):
        for time in times_of(trajectory, 25).tolist():
            got = trajectory.sample(time)
            for n in range(3):
                wanted = np.array([float(value) for value in orders[n](mpmath.mpf(time))])
                assert got[n][:2] == pytest.approx(wanted[:2], abs=ROUNDING)
                if n == 0:
                    assert turn_between(got[0][2], wanted[2], math.pi) < DIVIDED
                else:
                    assert got[n][2] == pytest.approx(wanted[2], rel=DIVIDED, abs=DIVIDED)


@each_trajectory
def test_many_times_give_what_single_times_give(trajectory: Trajectory) -> None:
    t = times_of(trajectory, 60)
    together = trajectory.sample(t)
    for i, function in enumerate(
        (trajectory.position, trajectory.velocity, trajectory.acceleration)
    ):
        one = [function(float(time)) for time in t]
        assert one[0].shape == (3,)
        size = 1 + np.abs(together[i])
        # The processor's vector sine may differ from its scalar one in the last digit.
        assert (np.abs(np.array(one) - together[i]) / size).max() < ROUNDING
        np.testing.assert_array_equal(function(t), together[i])
        np.testing.assert_array_equal(function(t.reshape(4, 15)), together[i].reshape(4, 15, 3))
        assert function([]).shape == (0, 3)


def test_more_times_than_fit_in_a_block_are_the_same() -> None:
    t = np.linspace(-5.0, 25.0, 40_001)
    for trajectory in (CLOSED["ellipse"], ENDING["five points"]):
        whole = trajectory.sample(t)
        for some in (slice(0, 3), slice(8190, 8195), slice(39_990, None)):
            for got, wanted in zip(trajectory.sample(t[some]), whole, strict=True):
                np.testing.assert_allclose(got, wanted[some], rtol=0, atol=ROUNDING)


# ---- the heading along the path ------------------------------------------------------------


@each_closed
def test_the_heading_is_the_tangents_and_never_leaps(trajectory: Trajectory) -> None:
    t = np.linspace(-1.1, 2.3, 40_001) * trajectory.duration
    position, velocity, _ = trajectory.sample(t)
    moves = np.hypot(velocity[:, 0], velocity[:, 1]) > 1e-6
    course = np.arctan2(velocity[moves, 1], velocity[moves, 0])
    assert turn_between(position[moves, 2], course, math.pi).max() < DIVIDED
    allowed = 1.5 * np.abs(velocity[:, 2]).max() * (t[1] - t[0])
    assert allowed < 0.3  # so that no turn by pi could hide
    assert np.abs(np.diff(position[:, 2])).max() < allowed


@pytest.mark.parametrize(
    ("trajectory", "turns"),
    [
        (CLOSED["circle"], 1),
        (CLOSED["clockwise circle"], -1),
        (CLOSED["ellipse"], 1),
        (CLOSED["flat ellipse"], -1),
        (CLOSED["eight"], 0),
        (CLOSED["lissajous"], 0),
        (motion.circle(3.0, 0.4, duration=500.0), 500 * 0.4 / math.tau),
    ],
)
def test_full_turns_are_counted(trajectory: Trajectory, turns: float) -> None:
    psi = trajectory.position([0.0, trajectory.duration, -trajectory.duration])[:, 2]
    assert psi[1] - psi[0] == pytest.approx(math.tau * turns, abs=1e3 * ROUNDING)
    assert psi[2] - psi[0] == pytest.approx(-math.tau * turns, abs=1e3 * ROUNDING)


@pytest.mark.parametrize(
    ("trajectory", "psi"),
    [
        (CLOSED["circle"], 0.0),
        (CLOSED["clockwise circle"], math.pi),
        (CLOSED["flat ellipse"], math.pi),
        (CLOSED["parabola"], 0.0),
        (CLOSED["cusps 3:4"], math.pi),
        (CLOSED["eight"], math.pi / 4),
        (ENDING["line"], math.atan2(-1, -2)),
        (ENDING["quintic"], math.pi / 2),
        (ENDING["quintic from rest"], math.pi / 2),
        (ENDING["via 1"], math.pi / 4),
        (motion.line((0, 0), (-3, 0), 1.0), math.pi),
        (motion.line((0, 0), (-3, -0.0), 1.0), math.pi),
        (motion.via([(0, 0), (-3, -0.0)], [0, 1], [(-1, -0.0), (-1, 0)]), math.pi),
        (motion.line((0, 0), (0, -3), 1.0), -math.pi / 2),
    ],
)
def test_every_motion_begins_forwards(trajectory: Trajectory, psi: float) -> None:
    assert trajectory.position(0.0)[2] == pytest.approx(psi, abs=ROUNDING)


def test_a_parabola_there_and_back_keeps_its_tangent() -> None:
    """y = 2 r_y x^2 / r_x^2: the slope is that of the parabola, whichever way it is driven."""
    r_x, r_y, w = 3.0, 2.0, 0.4
    trajectory = motion.lissajous(r_x, r_y, w, 2 * w)
    cusp = math.pi / 2 / w
    t = np.concatenate([np.linspace(-30, 60, 1001), cusp + np.array([-1e-9, -1e-14, 0, 1e-12])])
    position, velocity, acceleration = trajectory.sample(t)
    k, sin, cos = 4 * r_y / r_x, np.sin(w * t), np.cos(w * t)
    np.testing.assert_allclose(position[:, 2], np.arctan(k * sin), rtol=0, atol=ROUNDING)
    wanted = k * w * cos / (1 + (k * sin) ** 2)
    np.testing.assert_allclose(velocity[:, 2], wanted, rtol=0, atol=10 * ROUNDING)
    wanted = -k * w * w * sin * (1 + k * k * (1 + cos**2)) / (1 + (k * sin) ** 2) ** 2
    np.testing.assert_allclose(acceleration[:, 2], wanted, rtol=0, atol=10 * ROUNDING)
    # Behind the cusp the robot faces against its motion.
    facing = np.cos(position[:, 2]) * velocity[:, 0] + np.sin(position[:, 2]) * velocity[:, 1]
    there, back = trajectory.position([cusp - 1.0, cusp + 1.0])
    np.testing.assert_allclose(there, back, atol=ROUNDING)
    np.testing.assert_array_equal(np.sign(facing[:1001]), np.sign(cos[:1001]))


def power_series(coefficients: list[tuple[float, float]]) -> Callable[[Any], list[list[Any]]]:
    """Return x, y and psi and two derivatives of x + iy = sum c_j t^j, in mpmath's digits."""

    def at(t: Any) -> list[list[Any]]:
        t = mpmath.mpf(t)
        z = [
            mpmath.fsum(
                mpmath.mpc(*c) * mpmath.ff(j, n) * t ** (j - n)
                for j, c in enumerate(coefficients)
                if j >= n
            )
            for n in range(4)
        ]
        first = z[2] / z[1]
        second = z[3] / z[1] - first**2
        return [
            [z[0].real, z[0].imag, mpmath.arg(z[1])],
            [z[1].real, z[1].imag, first.imag],
            [z[2].real, z[2].imag, second.imag],
        ]

    return at


def values(coefficients: list[tuple[float, float]], t: float) -> Floats:
    """Return a polynomial (x, y) and its first two derivatives (3, 2) at a time."""
    powers = np.array(coefficients)
    out = []
    for _ in range(3):
        out.append(sum(c * t**j for j, c in enumerate(powers)) if len(powers) else np.zeros(2))
        powers = powers[1:] * np.arange(1, len(powers))[:, None]
    return np.array(out)


# x + iy as a polynomial of t, by coefficients; a standstill of first to third kind at t = 0.
STANDSTILLS = {
    "moving off": [(0, 0), (0, 0), (1, 0.5), (0.2, 1.0), (-0.3, 0.1), (0.02, 0.03)],
    "softly": [(1, 0), (0, 0), (0, 0), (0.5, 0.2), (0.3, -1.0), (0.1, 0.4)],
    "very softly": [(0, 1), (0, 0), (0, 0), (0, 0), (-1, 0.3), (0.5, 0.5)],
    "moving": [(0, 0), (-1, 0.2), (1, 0.5), (0.2, 1.0), (-0.3, 0.1), (0.02, 0.03)],
}


@pytest.mark.parametrize("span", [0.01, 1.0, 300.0])
@pytest.mark.parametrize("name", STANDSTILLS)
@pytest.mark.parametrize("side", ["start", "end"])
def test_no_digit_is_lost_next_to_a_standstill(name: str, side: str, span: float) -> None:
    """A quintic is one polynomial, so that mpmath can be given the same one."""
    unit = STANDSTILLS[name]
    curve = [(x / span**j, y / span**j) for j, (x, y) in enumerate(unit)]
    flip = -1.0 if side == "end" else 1.0  # of time, so that the standstill comes last
    first, last = values(curve, 0.0), values(curve, span)
    for each in (first, last):
        each[1] *= flip
    if side == "end":
        first, last = last, first
    trajectory = motion.quintic(
        first[0], last[0], span,
        start_velocity=first[1], end_velocity=last[1],
        start_acceleration=first[2], end_acceleration=last[2],
    )  # fmt: skip
    exact = power_series(curve)
    with mpmath.workdps(50):
        for share in (1e-13, 1e-10, 1e-6, 1e-3, 0.1, 0.5, 1.0):
            since = share * span
            if side == "end":  # of 1 - 1e-13 there are but three digits
                since = span - (span - since)
            got = np.array(trajectory.sample(span - since if side == "end" else since))
            wanted = np.array([[float(v) for v in row] for row in exact(since)])
            backwards = math.pi if side == "end" else 0.0
            assert turn_between(got[0, 2], wanted[0, 2] + backwards) < DIVIDED
            for n in (1, 2):
                size = np.abs(wanted[n, 2]) + 1 / span**n
                assert abs(got[n, 2] - flip**n * wanted[n, 2]) < DIVIDED * size


def test_a_cusp_inside_a_piece_is_driven_through_backwards() -> None:
    """x = (t - 1)^2, y = (t - 1)^3 has the tangent (2, 3 (t - 1)) on both sides."""

    def at(t: float) -> tuple[Floats, Floats]:
        s = t - 1
        return np.array([s**2, s**3]), np.array([2 * s, 3 * s**2])

    (p, v), (q, w) = at(0.0), at(3.0)
    trajectory = motion.via([p, q], [0, 3], velocities=[v, w])
    t = np.array([0.0, 0.5, 1 - 1e-7, 1 - 1e-12, 1.0, 1 + 1e-12, 1 + 1e-7, 1.7, 3.0])
    slope = 1.5 * (t - 1)
    position, velocity, acceleration = trajectory.sample(t)
    # It begins forwards, which is along (-2, 3).
    np.testing.assert_allclose(position[:, 2], math.pi + np.arctan(slope), atol=DIVIDED)
    np.testing.assert_allclose(velocity[:, 2], 1.5 / (1 + slope**2), atol=DIVIDED)
    wanted = -2 * 1.5**2 * slope / (1 + slope**2) ** 2
    np.testing.assert_allclose(acceleration[:, 2], wanted, atol=DIVIDED)


def test_a_standstill_inside_a_piece_without_reversal() -> None:
    """Velocity (s^2, s^3), s = t - 1: it stops at s = 0 and goes on, tangent (1, s)."""

    def at(t: float) -> Floats:
        s = t - 1
        return np.array([[s**3 / 3, s**4 / 4], [s**2, s**3], [2 * s, 3 * s**2]])

    (p, v, a), (q, w, b) = at(0.0), at(3.0)
    trajectory = motion.quintic(
        p, q, 3.0,
        start_velocity=v, end_velocity=w, start_acceleration=a, end_acceleration=b,
    )  # fmt: skip
    t = np.array([0.0, 0.5, 1 - 1e-4, 1 - 1e-9, 1.0, 1 + 1e-9, 1 + 1e-4, 2.0, 3.0])
    position, velocity, _ = trajectory.sample(t)
    # Rounding splits the double zero by 1e-8, which leaves as many digits.
    np.testing.assert_allclose(position[:, 2], np.arctan(t - 1), atol=1e-7)
    np.testing.assert_allclose(velocity[:, 2], 1 / (1 + (t - 1) ** 2), atol=1e-6)


@pytest.mark.parametrize("stop", [(0.0, 0.0), None], ids=["stop", "smooth"])
def test_a_path_that_comes_back_on_itself_is_driven_back_backwards(stop: Any) -> None:
    trajectory = motion.cubic_via([(0, 0), (2, 1), (0, 0)], (0, 1, 2), stop)
    t = np.linspace(0, 2, 101)
    position, velocity, acceleration = trajectory.sample(t)
    np.testing.assert_allclose(position[:, 2], math.atan2(1, 2), atol=ROUNDING)
    assert not velocity[:, 2].any()
    assert not acceleration[:, 2].any()
    assert velocity[-10, 0] < 0


def test_reversals_on_a_line_wherever_they_are() -> None:
    trajectory = motion.via([(0, 0), (2, 1), (1, 0.5), (3, 1.5)], (0, 1, 2, 5))
    position, velocity, _ = trajectory.sample(np.linspace(0, 5, 501))
    assert (velocity[:, 0] < -0.1).any()
    np.testing.assert_allclose(position[:, 2], math.atan2(1, 2), atol=ROUNDING)


def test_at_a_corner_the_tangent_is_held_until_the_robot_moves_on() -> None:
    trajectory = ENDING["via 1"]
    t = np.array([29.0, 30.0, 300 * 0.1, 30 * (1 + 1e-15), 30.001, 31.0, 60.0])
    psi = trajectory.position(t)[:, 2]
    np.testing.assert_allclose(psi[:4], math.pi / 4, atol=ROUNDING)
    np.testing.assert_allclose(psi[4:], 3 * math.pi / 4, atol=ROUNDING)


@pytest.mark.parametrize(
    ("last", "turn"),
    [((2, 5), 90), ((2, -5), -90), ((-1, 3), 135), ((-1, -3), -135), ((9, 0), 0), ((-5, 0), 0)],
)
def test_a_corner_turns_the_shorter_way(last: tuple[float, float], turn: float) -> None:
    trajectory = motion.via([(0, 0), (2, 0), last], (0, 1, 2), np.zeros((3, 2)))
    psi = trajectory.position([0.5, 1.0, 1.5])[:, 2]
    np.testing.assert_allclose(np.degrees(psi), [0, 0, turn], atol=1e-9)


def test_corners_add_up_to_full_turns() -> None:
    square = [(0, 0), (2, 0), (2, 2), (0, 2), (0, 0), (2, 0), (2, 2)]
    trajectory = motion.via(square, range(7), np.zeros((7, 2)))
    psi = trajectory.position(np.arange(6) + 0.5)[:, 2]
    np.testing.assert_allclose(np.degrees(psi), [0, 90, 180, 270, 360, 450], atol=1e-9)


def test_corners_driven_backwards_turn_as_the_path_does() -> None:
    """There and back, then to the left of the motion: a turn to the left, still backwards."""
    trajectory = motion.via([(0, 0), (2, 0), (1, 0), (1, -1)], (0, 1, 2, 3), np.zeros((4, 2)))
    psi = trajectory.position([0.5, 1.5, 2.5])[:, 2]
    np.testing.assert_allclose(np.degrees(psi), [0, 0, 90], atol=1e-9)


def test_while_it_waits_it_faces_as_before() -> None:
    points = [(0, 0), (0, 0), (0, 2), (0, 2), (-2, 2)]
    trajectory = motion.via(points, (0, 1, 2, 3, 4), np.zeros((5, 2)))
    position, velocity, _ = trajectory.sample([0.5, 1.5, 2.5, 3.0, 3.5])
    np.testing.assert_allclose(np.degrees(position[:, 2]), [90, 90, 90, 90, 180], atol=1e-9)
    np.testing.assert_array_equal(velocity[[0, 2], :], 0.0)
    trajectory = motion.via([(0, 0), (2, 0), (2, 2), (2, 2)], (0, 1, 2, 3), np.zeros((4, 2)))
    psi = trajectory.position([0.5, 1.5, 2.5])[:, 2]
    np.testing.assert_allclose(np.degrees(psi), [0, 90, 90], atol=1e-9)


def test_on_a_line_nearly_stopping_makes_no_noise() -> None:
    """Velocity ((t - 1)^2 + 1e-8) (1, 0.37): rounding over such a speed would leave few digits."""
    (p, v), (q, w) = (((t - 1) ** 3 / 3 + 1e-8 * t, (t - 1) ** 2 + 1e-8) for t in (0.0, 2.0))
    along = np.array([1.0, 0.37])
    trajectory = motion.via([p * along, q * along], [0, 2], [v * along, w * along])
    position, velocity, acceleration = trajectory.sample(np.linspace(0, 2, 2001))
    np.testing.assert_allclose(position[:, 2], math.atan(0.37), atol=ROUNDING)
    np.testing.assert_allclose(velocity[:, 2], 0, atol=ROUNDING)
    np.testing.assert_allclose(acceleration[:, 2], 0, atol=ROUNDING)


quarters = st.integers(-8, 8).map(lambda n: n / 4)
pairs = st.tuples(quarters, quarters)


@given(
    points=st.lists(pairs, min_size=3, max_size=6),
    velocities=st.lists(st.one_of(st.just((0.0, 0.0)), pairs), min_size=6, max_size=6),
    gaps=st.lists(st.sampled_from([0.5, 1.0, 2.5]), min_size=5, max_size=5),
)
def test_any_cubics_have_their_tangent_as_heading(points: Any, velocities: Any, gaps: Any) -> None:
    """Speeds and places on a grid, so that exact standstills, cusps and retraced lines abound."""
    k = len(points)
    times = np.concatenate([[0.0], np.cumsum(gaps[: k - 1])])
    slopes = velocities[:k]
    if len(set(points)) == 1 and not np.any(slopes):
        return
    trajectory = motion.via(points, times, slopes)
    t = np.random.default_rng(72).uniform(0, times[-1], 200)
    position, velocity, acceleration = trajectory.sample(t)
    for i in range(3):
        assert np.isfinite(trajectory.sample(t)[i]).all()
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moves = speed > 1e-4
    x, y = velocity[moves, 0], velocity[moves, 1]
    assert turn_between(position[moves, 2], np.arctan2(y, x), math.pi).max(initial=0) < 1e-8
    bend = (x * acceleration[moves, 1] - y * acceleration[moves, 0]) / speed[moves] ** 2
    # Where the speed is 1e-4, twelve digits of the acceleration leave eight of the quotient.
    np.testing.assert_allclose(velocity[moves, 2], bend, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["quintic", "quintic from rest", "via 2", "five points"])
def test_the_heading_is_the_integral_of_its_rate(name: str) -> None:
    trajectory = ENDING[name]
    joints = [2.0, 3.5, 6.0] if name == "five points" else [30.0] if name == "via 2" else []
    ends = [0.0, *joints, trajectory.duration]
    turned = 0.0
    for a, b in itertools.pairwise(ends):
        for order in (0, 1):
            function = (trajectory.velocity, trajectory.acceleration)[order]
            got, _ = integrate.quad(
                lambda t, f=function: f(t)[2], a, b - 1e-12, limit=400, epsabs=1e-10
            )
            held = (trajectory.position, trajectory.velocity)[order]
            assert held(b - 1e-12)[2] - held(a)[2] == pytest.approx(got, abs=1e-7)
            turned += got if order == 0 else 0.0
    whole = trajectory.position(trajectory.duration)[2] - trajectory.position(0.0)[2]
    assert whole == pytest.approx(turned, abs=1e-7)


# ---- before, after, moved, stretched -------------------------------------------------------


@each_ending
def test_a_motion_that_ends_holds_its_ends_at_rest(trajectory: Trajectory) -> None:
    end = trajectory.duration
    for t, held in ((-3.0, 0.0), (-1e-9, 0.0), (end + 1e-9, end), (2 * end, end)):
        position, velocity, acceleration = trajectory.sample(t)
        np.testing.assert_array_equal(position, trajectory.position(held))
        assert not velocity.any()
        assert not acceleration.any()


@each_closed
def test_a_periodic_motion_goes_on(trajectory: Trajectory) -> None:
    t = times_of(trajectory, 30)
    period = trajectory.duration
    for now, later in zip(trajectory.sample(t), trajectory.sample(t + 3 * period), strict=True):
        np.testing.assert_allclose(later[:, :2], now[:, :2], atol=1e3 * ROUNDING)
        assert turn_between(later[:, 2], now[:, 2]).max() < 1e-8


def test_a_given_duration_does_not_end_a_circle() -> None:
    trajectory = motion.circle(3.0, 0.1, duration=60.0)
    assert trajectory.duration == 60.0
    assert trajectory.velocity(61.0)[2] == pytest.approx(0.1)


LECTURES = {
    "lecture circle": motion.circle(3.0, 0.4, heading="lecture"),
    "lecture via": motion.cubic_via(LECTURE_POINTS, VIA_TIMES, (0, 0), heading="lecture"),
}


@pytest.mark.parametrize("trajectory", (ALL | LECTURES).values(), ids=ALL | LECTURES)
def test_moved_is_turned_and_shifted(trajectory: Trajectory) -> None:
    x, y, turn = 1.5, -0.7, 0.9
    t = times_of(trajectory, 50)
    moved = trajectory.moved(x, y, turn)
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    for order, (was, now) in enumerate(zip(trajectory.sample(t), moved.sample(t), strict=True)):
        shift = [x, y] if order == 0 else [0, 0]
        np.testing.assert_allclose(now[:, :2], was[:, :2] @ rotation.T + shift, atol=ROUNDING)
        wanted = was[:, 2] + (turn if order == 0 else 0)
        off = now[:, 2] - wanted
        if trajectory.plain_heading and order == 0:
            standing = was[:, 2] == 0
            off = turn_between(off[~standing], 0.0)
        np.testing.assert_allclose(off, 0, atol=1e-9 * (1 + np.abs(wanted).max()))
    assert moved.duration == trajectory.duration


@pytest.mark.parametrize("trajectory", (ALL | LECTURES).values(), ids=ALL | LECTURES)
@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_stretched_is_the_same_path_in_more_time(trajectory: Trajectory, factor: float) -> None:
    t = times_of(trajectory, 50)
    slow = trajectory.stretched(factor)
    assert slow.duration == pytest.approx(factor * trajectory.duration)
    for order, (was, now) in enumerate(
        zip(trajectory.sample(t), slow.sample(factor * t), strict=True)
    ):
        wanted = was / factor**order
        np.testing.assert_allclose(now, wanted, rtol=1e-8, atol=1e-10)


# ---- other headings ------------------------------------------------------------------------


def test_a_fixed_heading_is_fixed() -> None:
    position, velocity, acceleration = OWN["fixed"].sample(np.linspace(-5, 40, 100))
    assert (position[:, 2] == -2.0).all()
    assert not velocity[:, 2].any()
    assert not acceleration[:, 2].any()


def test_a_spin_is_linear_in_time() -> None:
    t = np.linspace(-5, 40, 100)
    position, velocity, acceleration = OWN["spinning"].sample(t)
    np.testing.assert_allclose(position[:, 2], 1 - 0.7 * t, atol=ROUNDING)
    assert (velocity[:, 2] == -0.7).all()
    assert not acceleration[:, 2].any()


def test_a_profile_takes_its_angles_and_is_held_beyond() -> None:
    position, velocity, acceleration = OWN["profile"].sample([-1, 0, 5, 20, 21, 50])
    np.testing.assert_allclose(position[:, 2], [0, 0, 2, -7, -7, -7], atol=ROUNDING)
    np.testing.assert_allclose(velocity[[0, 1, 3, 4, 5], 2], 0, atol=ROUNDING)
    assert not acceleration[[0, 4, 5], 2].any()


def test_two_headings_are_joined_by_the_lines_own_profile() -> None:
    t = np.linspace(0, 4, 9)
    for trajectory in (
        motion.line((0, 0), (2, 0), 4.0, heading=[1.0, 3.0]),
        motion.line((0, 0, 1), (2, 0, 3), 4.0),
    ):
        position = trajectory.position(t)
        np.testing.assert_allclose(position[:, 2], 1 + position[:, 0], atol=ROUNDING)


def test_points_with_headings_take_them() -> None:
    psi = [0.0, 1.0, 7.0, -3.0, 2.0]
    for trajectory in (
        OWN["headings"],
        motion.via(np.column_stack([ZIGZAG, psi]), ZIGZAG_TIMES),
        motion.via(np.column_stack([ZIGZAG, psi]), ZIGZAG_TIMES, np.ones((5, 3))),
    ):
        np.testing.assert_allclose(trajectory.position(ZIGZAG_TIMES)[:, 2], psi, atol=ROUNDING)
    np.testing.assert_allclose(trajectory.velocity(ZIGZAG_TIMES[1])[2], 1.0, atol=ROUNDING)


def test_turning_on_the_spot() -> None:
    position, velocity, _ = OWN["turn on the spot"].sample([0.0, 2.0, 4.0])
    np.testing.assert_allclose(position, [[1, 2, 0], [1, 2, 1.5], [1, 2, 3]], atol=ROUNDING)
    np.testing.assert_allclose(velocity[:, 2], [0, 15 / 8 * 3 / 4, 0], atol=ROUNDING)


def test_the_lectures_heading_jumps_as_it_says() -> None:
    circle = motion.circle(3.0, 0.1, heading="lecture")
    assert circle.plain_heading
    assert not motion.circle(3.0, 0.1).plain_heading
    psi = circle.position(np.array([0.0, 10.0, 62.0, 63.0, 125.0]))[:, 2]
    np.testing.assert_allclose(psi, [0, 1, 6.2, 6.3 - math.tau, 12.5 - math.tau], atol=ROUNDING)
    psi = circle.position(np.linspace(-500, 500, 10_001))[:, 2]
    assert psi.min() >= 0
    assert psi.max() < math.tau
    assert circle.position(-1e-16)[2] == 0  # a hair below a whole turn
    via = LECTURES["lecture via"]
    position, velocity, acceleration = via.sample([0.0, 15.0, 30.0, 45.0, 60.0, 70.0])
    wanted = [0, math.pi / 4, 0, 3 * math.pi / 4, 0, 0]
    np.testing.assert_allclose(position[:, 2], wanted, atol=ROUNDING)
    np.testing.assert_allclose(velocity[:, 2], 0, atol=ROUNDING)
    assert not acceleration[:, 2].any()
    ellipse = motion.ellipse(3.0, 2.0, 0.1, heading="lecture")
    np.testing.assert_allclose(
        ellipse.velocity([1.0, 20.0])[:, 2],
        motion.ellipse(3.0, 2.0, 0.1).velocity([1.0, 20.0])[:, 2],
        atol=ROUNDING,
    )
    assert not ellipse.acceleration([1.0, 20.0])[:, 2].any()


# ---- the lectures' tables ------------------------------------------------------------------


def lecture_loop(
    trajectory: Trajectory,
    controller: str,
    *,
    plain: bool = True,
    believed: float = 30.0,
    com: tuple[float, float] = (0.0, 0.0),
) -> Floats:
    """Return the largest |error| (3,) of the lectures' loop: mass 30, I_cz 0.1, dt 0.1, 60 s."""
    mass, inertia, dt = 30.0, 0.1, 0.1
    gains = np.array([120.0, 120.0, 0.4]) if controller == "PD" else np.full(3, 4.0)

    def matrix(m: float, psi: float) -> Floats:
        c, s = math.cos(psi), math.sin(psi)
        p, q = -m * (com[1] * c + com[0] * s), m * (com[0] * c - com[1] * s)
        return np.array([[m, 0, p], [0, m, q], [p, q, inertia + m * (com[0] ** 2 + com[1] ** 2)]])

    def bias(m: float, psi: float, turning: float) -> Floats:
        return turning**2 * np.array([-matrix(m, psi)[1, 2], matrix(m, psi)[0, 2], 0.0])

    pose, rate, _ = trajectory.sample(0.0)
    largest = np.zeros(3)
    for k in range(601):
        wanted, wanted_rate, wanted_acceleration = trajectory.sample(0.1 * k)
        error = wanted - pose
        if not plain:
            error[2] = math.remainder(error[2], math.tau)
        largest = np.maximum(largest, np.abs(error))
        law = gains * error + gains * (wanted_rate - rate)
        psi, turning = float(pose[2]), float(rate[2])
        if controller == "PD":
            force = law
        else:
            force = matrix(believed, psi) @ (wanted_acceleration + law)
            force = force + bias(believed, psi, turning)
        acceleration = np.linalg.solve(matrix(mass, psi), force - bias(mass, psi, turning))
        pose = pose + dt * rate + dt**2 / 2 * acceleration
        rate = rate + dt * acceleration
    return largest


def lecture(name: str, **choices: Any) -> Trajectory:
    """Return a trajectory of the tables, with the lectures' heading unless told otherwise."""
    choices = {"heading": "lecture"} | choices
    return {
        "circle": lambda: motion.circle(3.0, 0.1, **choices),
        "via 1": lambda: motion.cubic_via(LECTURE_POINTS, VIA_TIMES, (0, 0), **choices),
        "via 2": lambda: motion.cubic_via(LECTURE_POINTS, VIA_TIMES, **choices),
        "ellipse": lambda: motion.ellipse(3.0, 2.0, 0.1, **choices),
        "lissajous": lambda: motion.lissajous(3.0, 3.0, 0.2, 0.1, **choices),
    }[name]()


# |x|, |y|, |psi| of the reference's tables; None where it gives no number.
TABLES = [
    ("circle", "PD", True, (7.4813e-3, 7.4813e-3, None)),
    ("circle", "computed torque", True, (3.4913e-5, 3.4913e-5, None)),
    ("via 1", "PD", True, (3.2190e-3, 3.1215e-3, 2.3562)),
    ("via 1", "computed torque", True, (1.0370e-5, 1.0370e-5, 2.3562)),
    ("via 2", "PD", True, (3.2190e-3, 1.6137e-3, 2.6781)),
    ("via 2", "computed torque", True, (1.0370e-5, 2.5926e-6, 2.6781)),
    ("ellipse", "PD", True, (7.4813e-3, 4.9875e-3, 2.3624e-3)),
    ("ellipse", "computed torque", True, (3.4913e-5, 2.3275e-5, 2.3624e-3)),
    ("lissajous", "PD", True, (2.9704e-2, 7.4813e-3, 6.2845)),
    ("lissajous", "PD", False, (2.9704e-2, 7.4813e-3, 4.6786e-2)),
    ("lissajous", "computed torque", True, (2.7723e-4, 3.4913e-5, 6.2845)),
    ("lissajous", "computed torque", False, (2.7723e-4, 3.4913e-5, 4.6786e-2)),
]


@pytest.mark.parametrize(("name", "controller", "plain", "wanted"), TABLES)
def test_the_tables_are_reproduced(name: str, controller: str, plain: bool, wanted: Any) -> None:
    got = lecture_loop(lecture(name), controller, plain=plain)
    for value, table in zip(got, wanted, strict=True):
        if table is not None:
            assert value == pytest.approx(table, rel=FOUR_DIGITS)


def test_the_rows_with_a_wrong_model_are_reproduced() -> None:
    circle = lecture("circle")
    assert lecture_loop(circle, "PD", believed=36.0)[:2] == pytest.approx(7.4813e-3, rel=1e-4)
    got = lecture_loop(circle, "computed torque", believed=36.0)[:2]
    assert got == pytest.approx(1.2467e-3, rel=FOUR_DIGITS)
    got = lecture_loop(circle, "PD", com=(0.05, 0.02))
    assert got == pytest.approx([7.448e-3, 7.543e-3, 0.128], rel=3e-3)  # three digits of |psi|


@pytest.mark.parametrize("name", ["ellipse", "lissajous", "via 1", "via 2"])
def test_the_true_heading_is_followed_far_better(name: str) -> None:
    """Feed-forward of psi_dd, and a tangent that is held at standstill, never wrapped."""
    plain = lecture_loop(lecture(name), "computed torque", plain=False)
    true = lecture_loop(lecture(name, heading="path"), "computed torque", plain=False)
    # At via 1 a corner remains, at which the robot has to turn by a quarter at once.
    assert true[2] < plain[2] / (1.4 if name == "via 1" else 10)
    np.testing.assert_allclose(true[:2], plain[:2], rtol=1e-6)


def test_the_lectures_eight_equations() -> None:
    """Two cubics a + b t + c t^2 + d t^3, the second in t - t_v: the 8 x 8 system, solved."""
    v, f = 7.0, 12.0 - 7.0
    rows = np.array(
        [
            [1, 0, 0, 0, 0, 0, 0, 0],  # first position
            [0, 1, 0, 0, 0, 0, 0, 0],  # first velocity
            [1, v, v**2, v**3, 0, 0, 0, 0],  # the via, reached
            [0, 0, 0, 0, 1, 0, 0, 0],  # the via, left
            [0, 1, 2 * v, 3 * v**2, 0, -1, 0, 0],  # velocity
            [0, 0, 2, 6 * v, 0, 0, -2, 0],  # acceleration
            [0, 0, 0, 0, 1, f, f**2, f**3],  # last position
            [0, 0, 0, 0, 0, 1, 2 * f, 3 * f**2],  # last velocity
        ],
        dtype=float,
    )
    points = np.array([(0.5, -1.0), (2.0, 2.0), (-1.0, 4.0)])
    right = np.zeros((8, 2))
    right[[0, 2, 3, 6]] = points[[0, 1, 1, 2]]
    first, second = np.linalg.solve(rows, right).reshape(2, 4, 2)
    trajectory = motion.cubic_via(points, (0, 7, 12))
    t = np.linspace(0, 12, 100)
    for order, got in enumerate(trajectory.sample(t)):
        for i in range(2):
            polynomials = [np.polynomial.Polynomial(c[:, i]).deriv(order) for c in (first, second)]
            wanted = np.where(t < 7, polynomials[0](t), polynomials[1](t - 7))
            np.testing.assert_allclose(got[:, i], wanted, atol=ROUNDING)


def test_a_via_with_its_velocity_is_two_cubics() -> None:
    trajectory = ENDING["via with speed"]
    position, velocity, _ = trajectory.sample([0.0, 2.0, 5.0])
    np.testing.assert_allclose(position[:, :2], LECTURE_POINTS, atol=ROUNDING)
    np.testing.assert_allclose(velocity[:, :2], [(0, 0), (-1, 1), (0, 0)], atol=ROUNDING)
    for a, b in ((0.0, 2.0), (2.0, 5.0)):  # a cubic's third difference is constant
        t = np.linspace(a, b - 1e-9, 9)
        thirds = np.diff(trajectory.position(t)[:, :2], n=3, axis=0)
        np.testing.assert_allclose(thirds, thirds[[0]].repeat(6, axis=0), atol=1e-8)


def test_splines_pass_their_points_smoothly() -> None:
    trajectory = ENDING["five points"]
    position, velocity, acceleration = trajectory.sample(ZIGZAG_TIMES)
    np.testing.assert_allclose(position[:, :2], ZIGZAG, atol=ROUNDING)
    np.testing.assert_allclose(velocity[[0, -1], :2], 0, atol=ROUNDING)
    before = trajectory.acceleration(np.array(ZIGZAG_TIMES[1:-1]) - 1e-9)
    np.testing.assert_allclose(before[:, :2], acceleration[1:-1, :2], atol=1e-6)


def test_a_line_has_the_minimum_jerk_profile() -> None:
    trajectory = motion.line((0, 0), (3, 4), 2.0)
    t = np.linspace(0, 2, 50)
    s = t / 2
    wanted = np.outer(10 * s**3 - 15 * s**4 + 6 * s**5, [3, 4])
    np.testing.assert_allclose(trajectory.position(t)[:, :2], wanted, atol=ROUNDING)
    speeds = np.hypot(*trajectory.velocity(np.linspace(0, 2, 10_001))[:, :2].T)
    assert speeds.max() == pytest.approx(15 / 8 * 5 / 2)
    accelerations = np.hypot(*trajectory.acceleration(np.linspace(0, 2, 10_001))[:, :2].T)
    assert accelerations.max() == pytest.approx(10 / math.sqrt(3) * 5 / 4, rel=1e-6)
    for i in (1, 2):
        np.testing.assert_allclose(trajectory.sample([0.0, 2.0])[i], 0, atol=ROUNDING)


def test_a_quintic_meets_all_twelve_conditions() -> None:
    draw = np.random.default_rng(73).uniform(-2, 2, (6, 3))
    trajectory = motion.quintic(
        draw[0], draw[1], 3.0,
        start_velocity=draw[2], end_velocity=draw[3],
        start_acceleration=draw[4], end_acceleration=draw[5],
    )  # fmt: skip
    got = np.array(trajectory.sample([0.0, 3.0])).reshape(6, 3)
    np.testing.assert_allclose(got, draw, atol=ROUNDING)
    sixth = np.diff(trajectory.position(np.linspace(0, 3, 20)), n=6, axis=0)
    np.testing.assert_allclose(sixth, 0, atol=1e-12)


# ---- waypoints -----------------------------------------------------------------------------

far = st.floats(-20, 20).map(lambda value: round(value, 2))


@given(
    points=st.lists(st.tuples(far, far), min_size=2, max_size=8),
    speed=st.floats(0.05, 20),
    acceleration=st.floats(0.05, 20),
)
def test_waypoints_keep_their_limits_and_reach_one(
    points: Any, speed: float, acceleration: float
) -> None:
    if any(a == b for a, b in itertools.pairwise(points)):
        return
    path = motion.waypoints(points, speed, acceleration, heading=0.0)
    t = np.linspace(0, path.duration, 4001)
    position, velocity, force = path.sample(t)
    v, a = np.hypot(*velocity[:, :2].T), np.hypot(*force[:, :2].T)
    # Between samples an extremum is missed by the square of the step.
    assert v.max() < speed * (1 + 1e-9)
    assert a.max() < acceleration * (1 + 1e-9)
    assert max(v.max() / speed, a.max() / acceleration) > 0.99
    np.testing.assert_allclose(position[[0, -1], :2], [points[0], points[-1]], atol=1e-9)
    np.testing.assert_allclose(velocity[[0, -1]], 0, atol=1e-9 * speed)
    for x, y in points:
        assert np.hypot(*(position[:, :2] - (x, y)).T).min() <= speed * (t[1] - t[0])


def test_the_limit_is_attained_to_the_last_digit() -> None:
    path = ENDING["waypoints"]
    joints = path.curve.breaks  # type: ignore[attr-defined]
    fastest = np.hypot(*path.acceleration(joints)[:, :2].T).max()
    t = np.linspace(0, path.duration, 200_001)
    quickest = np.hypot(*path.velocity(t)[:, :2].T).max()
    assert max(quickest / 1.0, fastest / 0.8) == pytest.approx(1.0, abs=1e-9)


def test_faster_limits_give_the_same_path_sooner() -> None:
    slow, fast = motion.waypoints(ZIGZAG, 0.5, 0.2), motion.waypoints(ZIGZAG, 1.0, 0.8)
    assert slow.duration == pytest.approx(2 * fast.duration, rel=1e-6)


@pytest.mark.parametrize(
    ("points", "most"),
    [
        ([(0, 0), (3, 0)], 4.501),  # one cubic: 3/2 of the mean speed
        ([(0, 0), (1, 0), (5, 0), (6, 0)], 8.0),
        ([(0, 0), (0.2, 0), (5, 0), (5, 0.3), (2, 3)], 14.0),
        ([(x, math.sin(x)) for x in np.linspace(0, 12, 25)], 17.0),
    ],
)
def test_waypoints_are_passed_without_idling(points: Any, most: float) -> None:
    """With both limits 1, a point needs its way plus one second; uneven spacing costs little."""
    path = motion.waypoints(points, 1.0, 1.0)
    way = sum(math.dist(a, b) for a, b in itertools.pairwise(points))
    assert way + 1 < path.duration < most


def test_waypoints_take_headings() -> None:
    path = motion.waypoints(ZIGZAG, 1.0, 0.8, heading=[0, 1, 2, 3, 4])
    assert path.position([0.0, path.duration])[:, 2].tolist() == pytest.approx([0, 4])
    assert path.duration == pytest.approx(ENDING["waypoints"].duration)


# ---- files ---------------------------------------------------------------------------------


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "path.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def table(header: str, *columns: Any) -> str:
    rows = ["\t".join(map(repr, row)) for row in zip(*map(list, columns), strict=True)]
    return "\n".join([header.replace(",", "\t"), *rows, ""])


def test_a_file_is_followed_row_by_row(tmp_path: Path) -> None:
    circle = motion.circle(3.0, 0.4)
    t = np.linspace(0, 20, 201)
    x, y, _ = circle.position(t).T.tolist()
    path = written(tmp_path, table("t,x,y", (t + 5).tolist(), x, y))
    trajectory = motion.from_csv(path)
    assert trajectory.duration == pytest.approx(20.0)
    np.testing.assert_allclose(trajectory.position(t)[:, :2].T, [x, y], atol=1e-9)
    between = np.linspace(0, 20, 1000)
    found, wanted = trajectory.sample(between), circle.sample(between)
    # Errors of h^4, h^3, h^2 in x and y; those of psi go with the slope, one order later.
    for i, error in enumerate((1e-6, 1e-4, 1e-2)):
        np.testing.assert_allclose(found[i][:, :2], wanted[i][:, :2], atol=error)
    for i, error in enumerate((1e-4, 1e-2)):
        np.testing.assert_allclose(found[i][:, 2], wanted[i][:, 2], atol=error)


@pytest.mark.parametrize("end", ["start", "end"])
def test_a_file_that_ends_at_rest_has_its_tangent_there(tmp_path: Path, end: str) -> None:
    exact = motion.quintic((0, 0), (2, 1), 4.0, start_acceleration=(0, 1))
    t = np.linspace(0, 4, 9)
    x, y, _ = exact.position(t if end == "start" else t[::-1]).T.tolist()
    trajectory = motion.from_csv(written(tmp_path, table("t,x,y", t.tolist(), x, y)))
    at = 0.0 if end == "start" else 4.0
    assert not trajectory.velocity(at)[:2].any()
    # Eight intervals tell the direction to a few degrees.
    assert turn_between(trajectory.position(at)[2], math.pi / 2, math.pi) < 0.15


HALF_TURNS = [0.0, 3.0, -3.0, 0.0]


@pytest.mark.parametrize(
    ("name", "cells", "wanted"),
    [
        ("psi", HALF_TURNS, [0, 3, math.tau - 3, math.tau]),
        ("psi_deg", [0, 90, 180, -90], [0, math.pi / 2, math.pi, 1.5 * math.pi]),
        ("heading_deg", [10, 0, -10, 350], np.radians([10, 0, -10, -10])),
        ("heading", [0, 1, 2, 3], [0, 1, 2, 3]),
    ],
)
def test_a_files_headings_are_unwrapped(tmp_path: Path, name: str, cells: Any, wanted: Any) -> None:
    text = table(f"time,x,y,{name},note", range(4), range(4), [0, 1, 0, 1], cells, range(4))
    path = written(tmp_path, text.replace("\t", ";"))
    psi = motion.from_csv(path).position(np.arange(4.0))[:, 2]
    np.testing.assert_allclose(psi, wanted, atol=ROUNDING)
    assert (motion.from_csv(path, heading=0.3).position(np.arange(4.0))[:, 2] == 0.3).all()
    assert motion.from_csv(path, heading="path").velocity(1.0)[2] != 0


def test_empty_lines_are_passed_over_and_counted(tmp_path: Path) -> None:
    assert (
        motion.from_csv(written(tmp_path, "\ufefft, x, y\r\n0,0,0\r\n\r\n1,1,1\r\n")).duration == 1
    )
    with pytest.raises(FileError, match=r"path\.csv: line 5, column 'y': 'two' is not a finite"):
        motion.from_csv(written(tmp_path, "t,x,y\n0,0,0\n\n1,1,1\n2,2,two\n"))


def test_two_rows_are_a_line_at_constant_speed(tmp_path: Path) -> None:
    trajectory = motion.from_csv(written(tmp_path, "t,x,y\n0,0,0\n2,0,-4\n"))
    np.testing.assert_allclose(trajectory.velocity([0.0, 1.0, 2.0])[:, 1], -2.0)
    np.testing.assert_allclose(trajectory.position(1.0), [0, -2, -math.pi / 2], atol=ROUNDING)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the first line must name the columns"),
        ("0,0,0\n1,1,1\n", "the first line must name the columns, such as t,x,y,psi"),
        ("t,x,y\n0,0,0\n", "a trajectory needs at least two rows, got 1"),
        ("t,x,z\n0,0,0\n1,1,1\n", "no column 'y'; it has t, x, z"),
        ("s,x,y\n0,0,0\n1,1,1\n", "no column 't'; it has s, x, y"),
        ("t,x,x,y\n0,0,0,0\n1,1,1,1\n", "the column 'x' is there 2 times"),
        ("t,x,y\n0,0,0\n1,1\n", "line 3 has 2 cells, but there are 3 columns"),
        ("t,x,y\n0,0,0\n1,nan,1\n", "line 3, column 'x': 'nan' is not a finite number"),
        ("t,x,y\n0,0,0\n1,,1\n", "line 3, column 'x': '' is not a finite number"),
        (
            "t,x,y\n0,0,0\n2,1,1\n1,2,2\n",
            "line 4: time must grow from row to row, got 1 s after 2 s",
        ),
        ("t,x,y\n0,0,0\n2,1,1\n2,2,2\n", "line 4: time must grow from row to row"),
        ("t,x,y\n0,0,0\n2,1,1e400\n", "'1e400' is not a finite number"),
        (b"t,x,y\n0,0,\xff\n", "the file must be UTF-8 text"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path, text: str | bytes, words: str) -> None:
    with pytest.raises(FileError) as caught:
        motion.from_csv(written(tmp_path, text))
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "path.csv"))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read: No such file"):
        motion.from_csv(tmp_path / "none.csv")


def test_rows_of_one_place_have_no_tangent(tmp_path: Path) -> None:
    path = written(tmp_path, "t,x,y\n0,1,1\n1,1,1\n2,1,1\n")
    with pytest.raises(TrundleError, match="a path of no length has no tangent"):
        motion.from_csv(path)
    assert motion.from_csv(path, heading=1.0).position(1.0).tolist() == [1, 1, 1]


# ---- words ---------------------------------------------------------------------------------

NAN, TWO = float("nan"), [(0, 0), (1, 0)]
THREE = [(0, 0), (1, 0), (2, 2)]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: motion.circle(0.0, 1.0), "radius must be positive, got 0 m"),
        (lambda: motion.circle(-2.0, 1.0), "radius must be positive, got -2 m"),
        (lambda: motion.circle(NAN, 1.0), "radius must be finite, got nan"),
        (lambda: motion.circle("3", 1.0), "radius must be a number [m], got '3'"),
        (lambda: motion.circle(True, 1.0), "radius must be a number [m], got True"),
        (lambda: motion.circle(10**400, 1.0), "radius must be finite, got inf"),
        (lambda: motion.circle(1e20, 1.0), "radius must be at most 1e+15 m, got 1e+20"),
        (lambda: motion.circle(1e-200, 1.0), "radius must be at least 1e-15 m, got 1e-200"),
        (lambda: motion.circle(1.0, 0.0), "rate must not be zero"),
        (lambda: motion.circle(1.0, 1.0, duration=0), "duration must be positive, got 0 s"),
        (lambda: motion.ellipse(1.0, -1.0, 1.0), "radius_y must be positive, got -1 m"),
        (lambda: motion.lissajous(1, 1, 1, 0), "rate_y must not be zero"),
        (
            lambda: motion.lissajous(1, 1, 1, math.pi),
            "rates 1 and 3.14159 rad/s have no period in common of up to 200 turns: give a dur",
        ),
        (lambda: motion.figure_eight(1, 1, width=0), "width must be positive, got 0 m"),
        (lambda: motion.line((0, 0), (1, 1), -1.0), "duration must be positive, got -1 s"),
        (lambda: motion.line((0, 0), (1, 1, 0), 1.0), "end must be (x, y), got shape (3,)"),
        (lambda: motion.line((0, 0, 0, 0), (1, 1), 1.0), "start must be (x, y) or (x, y, psi), "),
        (lambda: motion.line((0, 0), (0, 0), 1.0), "a path of no length has no tangent to head"),
        (lambda: motion.line((0.3, 0), (0.1 + 0.2, 0), 1.0), "a path of no length"),
        (lambda: motion.line((0, NAN), (0, 0), 1.0), "start must be finite numbers"),
        (
            lambda: motion.quintic((0, 0), (1, 1), 1.0, end_velocity=(1, 1, 1)),
            "end_velocity must be (x, y), got shape (3,)",
        ),
        (lambda: motion.cubic_via(TWO, (0, 1)), "points must be start, via and end, got 2 points"),
        (
            lambda: motion.cubic_via(THREE, (0, 70, 60)),
            "the via at 70 s lies outside the span from 0 s to 60 s",
        ),
        (
            lambda: motion.cubic_via(THREE, (0, 0, 60)),
            "the via at 0 s lies outside the span from 0 s to 60 s",
        ),
        (lambda: motion.cubic_via(THREE, (0, 30, 60), via_velocity=1.0), "via_velocity must be"),
        (
            lambda: motion.via(THREE, (0, 2, 1)),
            "times must grow from point to point: point 3 has 1 s, after 2 s",
        ),
        (lambda: motion.via(THREE, (5, 6, 7)), "times must begin at 0 s, got 5 s"),
        (lambda: motion.via(THREE, (0, 1)), "times must have shape (3,), one for each of the 3"),
        (lambda: motion.via([(0, 0)], [0]), "a trajectory needs at least two, got 1"),
        (lambda: motion.via([1, 2, 3], (0, 1, 2)), "points must have shape (k, 2), or (k, 3)"),
        (lambda: motion.via([(0, 0), (1, "a")], (0, 1)), "points must be an array of numbers"),
        (lambda: motion.via(THREE, (0, 1, 2), TWO), "velocities must have the shape of the po"),
        (lambda: motion.via([(1, 1)] * 3, (0, 1, 2)), "a path of no length has no tangent"),
        (lambda: motion.waypoints(THREE, 0, 1), "max_speed must be positive, got 0 m/s"),
        (lambda: motion.waypoints(THREE, 1, -1), "max_acceleration must be positive, got -1 m/s"),
        (
            lambda: motion.waypoints([(0, 0), (1, 2), (1, 2), (3, 3)], 1, 1),
            "points 2 and 3 are both (1, 2): leave one of them out",
        ),
        (lambda: motion.waypoints([(0, 0)], 1, 1), "needs at least two, got 1"),
        (lambda: motion.circle(1, 1, heading="pth"), "got 'pth': did you mean 'path'?"),
        (lambda: motion.circle(1, 1, heading=[0, 1]), "heading must be 'path', 'lecture', a num"),
        (lambda: motion.circle(1, 1, heading=NAN), "heading must be finite, got nan"),
        (lambda: motion.circle(1, 1, heading=True), "heading must be 'path', 'lecture', a num"),
        (
            lambda: motion.via(THREE, (0, 1, 2), heading=[0, 1]),
            "heading must have one value for each of the 3 points, got shape (2,)",
        ),
        (
            lambda: motion.line((0, 0, 0), (1, 1, 1), 1.0, heading="path"),
            "the points have headings: leave out heading=, or the third column",
        ),
        (lambda: motion.profile([0, 1], [0, 1, 2]), "times must have shape (3,), one for each"),
        (lambda: motion.profile([0], [0]), "angles must be two or more headings (k,)"),
        (lambda: motion.spin("fast"), "rate must be a number [rad/s], got 'fast'"),
        (lambda: motion.circle(1, 1).position(NAN), "t must be finite numbers, got nan or inf"),
        (lambda: motion.circle(1, 1).sample(np.array([0, np.inf])), "t must be finite numbers"),
        (lambda: motion.circle(1, 1).velocity("now"), "t must be an array of numbers, got 'now'"),
        (lambda: motion.circle(1, 1).moved(psi="left"), "psi must be a number [rad], got 'left'"),
        (lambda: motion.circle(1, 1).stretched(0), "factor must be positive, got 0"),
    ],
)
def test_bad_input_is_told_in_words(make: Callable[[], object], words: str) -> None:
    with pytest.raises(TrundleError) as caught:
        make()
    assert words in str(caught.value)


def test_shapes_are_shape_errors() -> None:
    with pytest.raises(ShapeError):
        motion.via(THREE, (0, 1))


@pytest.mark.parametrize(
    ("trajectory", "words"),
    [
        (
            motion.cubic_via(LECTURE_POINTS, VIA_TIMES),
            "Trajectory(cubics through 3 points, heading along the path, 60 s)",
        ),
        (
            motion.line((0, 0), (3, 4), 2.0, heading=math.pi / 2),
            "Trajectory(line of 5 m, heading at 90 deg, 2 s)",
        ),
        (
            motion.circle(1, 2, heading="lecture").stretched(2),
            "Trajectory(circle of radius 1 m at 2 rad/s, stretched 2 times, heading by the "
            "lecture's policy, 6.283 s)",
        ),
        (
            motion.circle(1, 2, heading=motion.spin(3)).moved(1, 2, math.pi),
            "Trajectory(circle of radius 1 m at 2 rad/s, moved to (1, 2) m and 180 deg, heading "
            "turning at 3 rad/s, 3.142 s)",
        ),
    ],
)
def test_a_trajectory_says_what_it_is(trajectory: Trajectory, words: str) -> None:
    assert repr(trajectory) == words


def test_a_trajectory_is_a_value() -> None:
    circle = motion.circle(3.0, 0.1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        circle.duration = 3.0  # type: ignore[misc]
    t = np.array([0.0, 1.0])
    circle.sample(t)
    assert t.tolist() == [0.0, 1.0]
    points = np.array(LECTURE_POINTS)
    trajectory = motion.cubic_via(points, VIA_TIMES)
    points[1] = 99.0
    np.testing.assert_allclose(trajectory.position(30.0)[:2], (2, 2))
