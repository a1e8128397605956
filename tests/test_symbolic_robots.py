"""Robots in symbols: their numbers are the ones of trundle.kinematics, their form the lectures'."""

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy

import trundle
from catalogue import ROBOTS, each_robot, kinematics
from trundle import BallWheel, CasterWheel, FixedWheel, MecanumWheel, OmniWheel, Robot, SteeredWheel
from trundle.symbolic import (
    SymbolicRobot,
    bracket,
    generic_angles,
    integrability,
    numbers,
    pseudo_inverse,
    symbolic_robot,
)

# The readings differ by rounding in products of a few numbers near 1.
AGREE = 1e-12

a, l, d, kappa = sympy.symbols("a l d kappa", positive=True)
beta = sympy.Symbol("beta", real=True)


def omni(*degrees: float, turn: float = 90.0, arm: float = 0.2, radius: float = 0.05) -> Robot:
    wheels = [
        OmniWheel(
            name=f"w{i}",
            x=arm * math.cos(math.radians(angle)),
            y=arm * math.sin(math.radians(angle)),
            heading=math.radians(angle + turn),
            radius=radius,
        )
        for i, angle in enumerate(degrees)
    ]
    return Robot(name="omni", wheels=tuple(wheels))


EXTREMES: dict[str, Robot] = {
    "no drive": Robot(
        name="a", wheels=(FixedWheel(name="f", x=0.1, y=0.2, radius=0.1, driven=False),)
    ),
    "nothing but a ball": Robot(name="a", wheels=(BallWheel(name="b", x=0.0, y=0.0),)),
    "one wheel": Robot(name="a", wheels=(FixedWheel(name="f", x=0.0, y=0.0, radius=0.1),)),
    "one omni wheel": omni(20.0),
    "locked": Robot(
        name="a",
        wheels=tuple(
            FixedWheel(
                name=str(i), x=math.cos(i), y=math.sin(i), radius=0.1, heading=float(i) + 0.3
            )
            for i in range(3)
        ),
    ),
    "square mecanum": trundle.load("mecanum", wheelbase=0.4, track=0.4),
    "singular mecanum": trundle.load("mecanum_lecture", wheelbase=0.6, track=0.6),
    "five omni wheels": omni(0, 72, 144, 216, 288),
    "odd angles": omni(3.3, 111.1, 200.0),
    "clockwise": omni(0, 90, 180, 270, turn=-90),
    "two modules": trundle.load("swerve"),
    "six modules": Robot(
        name="a",
        wheels=tuple(
            SteeredWheel(name=f"{x}{y}", x=x, y=y, radius=0.1)
            for x in (-0.5, 0.0, 0.4)
            for y in (0.3, -0.3)
        ),
    ),
    "slanted rollers": Robot(
        name="a",
        wheels=tuple(
            MecanumWheel(name=f"{x}{y}", x=x, y=y, radius=0.1, roller=s * math.radians(50))
            for x, y, s in ((1.0, 0.5, -1), (1.0, -0.5, 1), (-1.0, 0.5, 1), (-1.0, -0.5, -1))
        ),
    ),
    "steered beside rollers": Robot(
        name="a",
        wheels=(
            SteeredWheel(name="s", x=0.2, y=0.0, radius=0.1, driven=False),
            OmniWheel(name="o", x=-0.2, y=0.1, radius=0.1),
            CasterWheel(name="c", x=-0.2, y=-0.1, radius=0.1),
        ),
    ),
    "skids off the origin": Robot(
        name="a",
        wheels=tuple(
            FixedWheel(name=str(x), x=x, y=y, radius=0.1, skid=True, track_factor=f)
            for x, y, f in ((0.5, 0.2, 1.2), (0.3, -0.2, 1.0), (-0.1, 0.2, 1.2))
        ),
    ),
}
EVERY = ROBOTS | EXTREMES
every_robot = pytest.mark.parametrize("name", EVERY)


@cache
def symbolic(name: str) -> SymbolicRobot:
    return symbolic_robot(EVERY[name])


def angles_of(robot: Robot) -> list[Any]:
    """Return steering angles of generic positions, which robots that do not steer have not."""
    if not robot.steered:
        return [None]
    found = [generic_angles(robot)]
    for twist in ((0.7, 0.2, 0.9), (-0.3, 0.1, 1.5)):
        answer = trundle.Kinematics(robot).inverse(twist, limit=False)
        found.append(answer.steering)
    return found


@every_robot
def test_w_at_the_robots_numbers_is_the_one_of_the_kinematics(name: str) -> None:
    robot, made = EVERY[name], symbolic(name)
    for steering in angles_of(robot):
        got = numbers(made.W, made.values(steering))
        assert got == pytest.approx(trundle.Kinematics(robot).wheel_matrix(steering), abs=AGREE)


@each_robot
def test_the_rows_at_the_robots_numbers_are_the_ones_of_the_kinematics(robot: Robot) -> None:
    made = symbolic(robot.name)
    for steering in angles_of(robot):
        A, R, C = kinematics(robot).constraints(steering)
        values = made.values(steering)
        assert numbers(made.A, values) == pytest.approx(A, abs=AGREE)
        assert numbers(made.R, values) == pytest.approx(np.diag(R), abs=AGREE)
        assert numbers(made.C, values) == pytest.approx(C, abs=AGREE)


@every_robot
def test_the_allowed_twists_keep_the_held_rows_in_symbols(name: str) -> None:
    made = symbolic(name)
    product = made.held * made.N
    assert made.held.rows + made.N.cols == 3
    # At other values than this robot's: every symbol stands for anything.
    random = np.random.default_rng(61)
    anything = {symbol: random.uniform(0.3, 2.0) for symbol in made.values(None)}
    assert numbers(product, anything) == pytest.approx(np.zeros(product.shape), abs=AGREE)
    assert np.linalg.matrix_rank(numbers(made.N, made.values(generic_angles(made.robot)))) == (
        made.N.cols
    )


@every_robot
def test_held_rows_take_in_every_side_slip_row(name: str) -> None:
    made = symbolic(name)
    values = made.values(generic_angles(made.robot))
    held, C = numbers(made.held, values), numbers(made.C, values)
    # Rows of unit directions: what is left of a dependent one is rounding.
    assert np.linalg.matrix_rank(np.vstack([held, C]), tol=1e-9) == len(held)


# ---- the form of the lectures ----------------------------------------------------------------


def same(got: Any, wanted: Any) -> bool:
    return all(sympy.simplify(entry) == 0 for entry in sympy.Matrix(got) - sympy.Matrix(wanted))


def test_the_differential_drive_is_the_lectures() -> None:
    W = [[a / 2, a / 2], [0, 0], [-a / (2 * d), a / (2 * d)]]
    assert sympy.Matrix(W) == symbolic("differential").W


def test_the_three_wheel_omni_robot_is_the_lectures() -> None:
    root = sympy.sqrt(3)
    W = a / 3 * sympy.Matrix([[0, -root, root], [2, -1, -1], [1 / l, 1 / l, 1 / l]])
    assert symbolic("omni3").W == W


def test_the_mecanum_robot_is_the_lectures() -> None:
    k = 1 / (d - l)
    W = a / 4 * sympy.Matrix([[1, 1, 1, 1], [1, -1, 1, -1], [-k, -k, k, k]])
    assert same(symbolic("mecanum_lecture").W, W)


def test_the_usual_rollers_have_the_sum_as_yaw_arm() -> None:
    """Lynch and Park, Modern Robotics, 2017, eq. (13.10), inverted; in this wheel order."""
    k = 1 / (d + l)
    W = a / 4 * sympy.Matrix([[1, 1, 1, 1], [-1, 1, 1, -1], [-k, k, -k, k]])
    assert same(symbolic("mecanum").W, W)


def test_the_slides_of_the_x_drive_hold() -> None:
    """v_i = v_x sin th_i - v_y cos th_i - w R, th = 45, 315, 135, 225 deg: the right inverse."""
    angles = [sympy.rad(angle) for angle in (45, 315, 135, 225)]
    inverse = sympy.Matrix([[sympy.sin(t), -sympy.cos(t), -l] for t in angles]) / a
    assert same(pseudo_inverse(symbolic("omni4")).matrix, inverse)


def test_a_tricycle_turns_about_its_rear_axle() -> None:
    """u = a omega cos(beta), r = u tan(beta) / l: Siegwart and Nourbakhsh, 2004, section 3.3.3."""
    W = sympy.Matrix([a * sympy.cos(beta), 0, a * sympy.sin(beta) / l])
    assert same(symbolic("tricycle").W, W)


def test_a_skid_steer_robot_divides_by_its_wider_track() -> None:
    W = a / 4 * sympy.Matrix([[1, 1, 1, 1], [0] * 4, [x / (kappa * d) for x in (-1, 1, -1, 1)]])
    assert symbolic("skid_steer").W == W


# ---- symbols ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("differential", "a d"),
        ("omni3", "a l"),
        ("mecanum", "a l d"),
        ("swerve", "a l d"),
        ("mixed", "a l d_1 d_2"),
        ("skid_steer", "a l d kappa"),
        ("square mecanum", "a l d"),
        ("singular mecanum", "a l"),
        ("odd angles", "a l alpha_1 alpha_2 alpha_3"),
        ("clockwise", "a l"),
        ("slanted rollers", "a l d phi_1"),
        ("curved", "a_1 a_2 l_1 l_2"),
        ("odd_differential", "a_1 a_2 l_1 l_2 d_1 d_2 theta_1"),
    ],
)
def test_symbols_are_few_and_plain(name: str, wanted: str) -> None:
    assert " ".join(str(each.symbol) for each in symbolic(name).quantities) == wanted


def test_formulas_that_hold_for_this_robots_sizes_only_say_so() -> None:
    told = {name: symbolic(name).general for name in EVERY}
    assert [name for name, general in told.items() if not general] == ["odd_differential"]


def test_linked_wheels_share_an_input() -> None:
    made = symbolic("four_wheel_steered")
    assert [str(symbol) for symbol in made.inputs.symbols] == ["beta_1", "beta_2"]
    made = symbolic("curved")
    assert made.inputs.angles == {"front": beta, "rear": -beta / 2}


def test_wheels_that_say_nothing_have_no_number() -> None:
    assert [each.wheel.name for each in symbolic("differential").wheels] == ["left", "right"]
    assert [each.wheel.name for each in symbolic("odd_omni").wheels] == ["a", "b", "c", "d"]


def test_a_position_that_is_singular_ahead_is_not_chosen() -> None:
    """The front wheels of a swerve drive share a line when it drives ahead; one side does not."""
    assert symbolic("swerve").held_by == (1, 3)
    assert symbolic("ackermann").held_by == (3, 1)


# ---- integrability and inverses --------------------------------------------------------------


def test_the_bracket_is_the_one_of_the_vector_fields() -> None:
    """Against the Lie bracket of the inertial fields J(psi) g_1 and J(psi) g_2, by derivatives."""
    psi = sympy.Symbol("psi", real=True)
    q = (*sympy.symbols("x y", real=True), psi)
    c, s = sympy.cos(psi), sympy.sin(psi)
    J = sympy.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    first, second = sympy.Matrix([1, 2, 3]), sympy.Matrix([-2, 5, 7])
    f, h = J * first, J * second
    assert same(J * bracket(first, second), h.jacobian(q) * f - f.jacobian(q) * h)


@each_robot
def test_integrability_agrees_with_the_mobility(robot: Robot) -> None:
    told, can = integrability(symbolic(robot.name)), trundle.mobility(robot)
    assert told.integrable == can.holonomic
    assert (told.dimension == 3) >= can.controllable


def test_a_differential_drive_gets_the_sideways_motion_by_a_bracket() -> None:
    told = integrability(symbolic("differential"))
    assert [found.parents for found in told.found] == [("g_1", "g_2")]
    assert list(told.found[0].twist) == [0, -1, 0]


def test_four_fixed_wheels_stay_on_a_line() -> None:
    robot = trundle.load("skid_steer")
    wheels = tuple(dataclasses.replace(wheel, skid=False) for wheel in robot.wheels)
    told = integrability(symbolic_robot(dataclasses.replace(robot, wheels=wheels)))
    assert (told.dimension, told.integrable, told.found) == (1, True, ())


@pytest.mark.parametrize(
    ("name", "kind", "rank"),
    [
        ("differential", "left", 2),
        ("tricycle", "left", 1),
        ("omni3", "inverse", 3),
        ("mecanum", "right", 3),
        ("odd_omni", "right", 3),
        ("skid_steer", "none", 2),
        ("swerve", "none", 1),
        ("no drive", "none", 0),
        ("singular mecanum", "none", 2),
    ],
)
def test_the_right_inverse_is_chosen(name: str, kind: str, rank: int) -> None:
    told = pseudo_inverse(symbolic(name))
    assert (told.kind, told.rank) == (kind, rank)


@pytest.mark.parametrize("name", ["differential", "tricycle", "mixed", "omni3", "omni4", "mecanum"])
def test_pseudo_inverses_have_the_properties_of_penrose(name: str) -> None:
    W, inverse = symbolic(name).W, pseudo_inverse(symbolic(name)).matrix
    assert same(W * inverse * W, W)
    assert same(inverse * W * inverse, inverse)
    assert same((W * inverse).T, W * inverse)
    assert same((inverse * W).T, inverse * W)
