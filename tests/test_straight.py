"""Programs in straight lines: the same numbers as the arrays, in text that is Python and C."""

import dataclasses
import math
import re

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from catalogue import CURVED, ROBOTS, each_plane_robot, each_robot, feasible_twists, steering_for
from trundle.errors import TrundleError, UnobservedMotionWarning
from trundle.kinematics import Code, Straight, straight_lines
from trundle.robot import FixedWheel, OmniWheel, Robot, SteeredWheel

Floats = NDArray[np.float64]

# Sums of a few products of numbers of size 1; normal equations square the condition number, which
# is below 30 for these robots.
ROUNDING = 1e-12
# The map grows as one over what the angles miss of hiding a motion, and so do rounding errors.
PER_MISS = 1e-14


def deaf(robot: Robot, count: int) -> Robot:
    """Return the robot without motor and encoder on its first wheels that have a motor."""
    names = [wheel.name for wheel in robot.driven][:count]
    wheels = tuple(
        dataclasses.replace(wheel, driven=False) if wheel.name in names else wheel
        for wheel in robot.wheels
    )
    return dataclasses.replace(robot, wheels=wheels)


# A wheel that steers and is not measured makes the normal equations depend on its angle.
LOOSE = {
    f"{robot.name} less {count}": deaf(robot, count)
    for robot in ROBOTS.values()
    for count in range(1, len(robot.driven))
    if robot.steered and robot is not CURVED
}
each_loose = pytest.mark.parametrize("robot", LOOSE.values(), ids=LOOSE)


def assert_forward_agrees(robot: Robot, steering: Floats, tolerance: float = ROUNDING) -> None:
    kinematics = trundle.Kinematics(robot)
    forward = straight_lines(robot).forward.compile()
    for angles in steering:
        speeds = np.random.default_rng(4).normal(size=len(robot.driven)) * 10
        wanted = kinematics.forward(speeds, angles if robot.steered else None)
        got = forward(*speeds.tolist(), *angles.tolist())
        np.testing.assert_allclose(got, wanted, atol=tolerance * (1 + np.abs(wanted).max()))


@each_loose
@pytest.mark.filterwarnings("ignore::trundle.errors.UnobservedMotionWarning")
def test_forward_agrees_at_any_angles(robot: Robot) -> None:
    angles = np.random.default_rng(5).uniform(-4.0, 4.0, (20, len(robot.steered)))
    assert_forward_agrees(robot, angles, 100 * ROUNDING)


@each_plane_robot
@pytest.mark.filterwarnings("ignore::trundle.errors.UnobservedMotionWarning")
def test_forward_agrees_at_angles_that_share_no_centre_and_at_quarter_turns(robot: Robot) -> None:
    random = np.random.default_rng(6)
    quarters = random.integers(-4, 5, (20, len(robot.steered))) * (math.pi / 4)
    assert_forward_agrees(robot, quarters)
    assert_forward_agrees(robot, random.uniform(-4.0, 4.0, (20, len(robot.steered))))


@each_loose
@pytest.mark.filterwarnings("ignore::trundle.errors.UnobservedMotionWarning")
def test_what_is_not_observed_is_zero_as_with_arrays(robot: Robot) -> None:
    """Where wheels point across or along, few of them may tell too little."""
    random = np.random.default_rng(7)
    quarters = random.integers(-2, 3, (40, len(robot.steered))) * (math.pi / 2)
    assert_forward_agrees(robot, quarters, 100 * ROUNDING)


@pytest.mark.parametrize("miss", [1e-1, 1e-3, 1e-5, 1e-7, -1e-7, 1e-8])
def test_a_bicycle_whose_front_wheel_is_all_but_across(miss: float) -> None:
    """The rear wheel rolls by 0.3 m; the front wheel's angle says how far round that goes."""
    forward = straight_lines(trundle.load("bicycle")).forward.compile()
    u, v, r = forward(1.0, math.pi / 2 - miss)
    assert (u, v) == pytest.approx((0.3, 0.0), rel=ROUNDING)
    assert r == pytest.approx(0.3 / math.tan(miss), rel=PER_MISS / abs(miss))


@pytest.mark.parametrize("miss", [0.0, 1e-17, 1e-12, -1e-10])
def test_a_bicycle_whose_front_wheel_is_across(miss: float) -> None:
    """Rolling and standing are both told, with equal weight: half the speed, and no turn."""
    robot = trundle.load("bicycle")
    u, v, r = straight_lines(robot).forward.compile()(1.0, math.pi / 2 + miss)
    assert (u, v, r) == pytest.approx((0.15, 0.0, 0.0), abs=1e-9)  # of the angle's size
    with pytest.warns(UnobservedMotionWarning):
        wanted = trundle.Kinematics(robot).forward([1.0], [math.pi / 2 + miss])
    np.testing.assert_allclose((u, v, r), wanted, atol=1e-9)


def test_one_fades_into_the_other_without_a_number_that_is_none() -> None:
    forward = straight_lines(trundle.load("bicycle")).forward.compile()
    for miss in np.geomspace(1e-10, 1e-7, 2000):
        u, v, r = forward(1.0, math.pi / 2 - float(miss))
        assert 0.15 * (1 - 1e-6) <= u <= 0.3 * (1 + 1e-6)
        assert 0.0 <= r <= 0.3 / miss * (1 + 1e-6)
        assert v == 0.0


def test_rows_that_leave_two_motions_open() -> None:
    """One omni wheel ahead and a wheel that steers and tells nothing: a plane of what is open."""
    robot = Robot(
        name="blind",
        wheels=(
            OmniWheel(name="omni", x=0.0, y=0.0, radius=0.1),
            SteeredWheel(name="free", x=0.5, y=0.2, radius=0.1, driven=False),
        ),
    )
    forward = straight_lines(robot).forward.compile()
    for angle in (0.0, 0.3, math.pi / 2, -2.0):
        with pytest.warns(UnobservedMotionWarning):
            wanted = trundle.Kinematics(robot).forward([2.0], [angle])
        np.testing.assert_allclose(forward(2.0, angle), wanted, atol=ROUNDING)


# ---- linked steering -------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["synchro", "four_wheel_steered"])
def test_linked_wheels_roll_along_their_contact_velocities(name: str) -> None:
    """Told from geometry: the direction of each wheel's velocity, or half a turn from it."""
    robot = trundle.load(name)
    inverse = straight_lines(robot).inverse.compile()
    for twist in feasible_twists(robot, (50,)):
        found = np.array(inverse(*twist.tolist()))
        speeds, angles = np.split(found, [len(robot.driven)])
        for wheel, speed, angle in zip(robot.steered, speeds, angles, strict=True):
            u, v = twist[0] - twist[2] * wheel.y, twist[1] + twist[2] * wheel.x
            rim = speed * wheel.radius * np.exp(1j * (wheel.heading + angle))
            assert rim == pytest.approx(complex(u, v), abs=ROUNDING * (1 + abs(twist).max()))
        groups = {w.steering_group for w in robot.steered}
        for group in groups:
            members = [
                angle / wheel.steering_ratio
                for wheel, angle in zip(robot.steered, angles, strict=True)
                if wheel.steering_group == group
            ]
            assert max(members) - min(members) == pytest.approx(0.0, abs=ROUNDING)


def test_a_curved_family_has_no_straight_lines_but_can_be_bound() -> None:
    with pytest.raises(TrundleError, match="curved family of twists"):
        straight_lines(CURVED)
    bound = trundle.Kinematics(CURVED).bind()
    twist = feasible_twists(CURVED, ())
    angles = steering_for(CURVED, twist)
    wanted = trundle.Kinematics(CURVED).forward([1.0, 2.0], angles)
    np.testing.assert_allclose(bound.forward(1.0, 2.0, *angles), wanted, atol=ROUNDING)


def test_skidding_wheels_that_a_steered_motor_holds_have_no_straight_lines() -> None:
    robot = Robot(
        name="odd",
        wheels=(
            FixedWheel(name="left", x=0.0, y=0.2, radius=0.1, skid=True),
            FixedWheel(name="right", x=0.1, y=-0.2, radius=0.1, skid=True),
            SteeredWheel(name="front", x=0.5, y=0.0, radius=0.1),
        ),
    )
    with pytest.raises(TrundleError, match="skidding wheels slip depends on the steering angle"):
        straight_lines(robot)
    kinematics = trundle.Kinematics(robot)
    np.testing.assert_allclose(
        kinematics.bind().forward(1.0, 2.0, 3.0, 0.4),
        kinematics.forward([1.0, 2.0, 3.0], [0.4]),
        atol=ROUNDING,
    )


# ---- the text --------------------------------------------------------------------------------

TOKEN = re.compile(r"(?P<name>[A-Za-z_]\w*)|(?P<number>\d+\.\d*(e[-+]\d+)?|\d+e[-+]\d+)|[-+*/(), ]")
FUNCTIONS = {"sin", "cos", "sqrt", "hypot", "atan2"}


def programs(robot: Robot) -> list[Straight]:
    lines = straight_lines(robot)
    return [lines.inverse, lines.forward, lines.step]


@each_plane_robot
def test_expressions_are_python_and_c(robot: Robot) -> None:
    for program in programs(robot):
        known = set(program.arguments)
        for name, expression in [*program.lines, *(("", result) for result in program.results)]:
            at = 0
            while at < len(expression):
                token = TOKEN.match(expression, at)
                assert token, f"{expression!r} has {expression[at:]!r}"
                assert "**" not in expression
                assert "//" not in expression
                if word := token["name"]:
                    called = expression[token.end() :].startswith("(")
                    assert word in (FUNCTIONS if called else known)
                if token["number"]:
                    assert repr(float(token["number"])) == token["number"]
                at = token.end()
            assert name not in known
            known |= {name} - {""}


@each_plane_robot
def test_every_line_is_used(robot: Robot) -> None:
    for program in programs(robot):
        below = list(program.results)
        for name, expression in reversed(program.lines):
            assert any(re.search(rf"\b{name}\b", text) for text in below), name
            below.append(expression)


@each_robot
def test_programs_run_on_arrays(robot: Robot) -> None:
    if robot is CURVED:
        return
    for program in programs(robot):
        values = np.random.default_rng(8).normal(size=(len(program.arguments), 3))
        at_once = [np.broadcast_to(x, 3) for x in program.compile(np)(*values)]
        one = program.compile()
        for i in range(3):
            wanted = one(*values[:, i].tolist())
            np.testing.assert_allclose([x[i] for x in at_once], wanted, rtol=1e-9, atol=ROUNDING)


def test_equal_inputs_add_up() -> None:
    code = Code()
    results = code.linear(np.array([[1.0, 2.0, 3.0]]), ["a", "b", "a"])
    assert code.program("sum", ("a", "b"), results).compile()(5.0, 7.0) == (34.0,)


def test_a_line_that_no_result_needs_is_left_out() -> None:
    code = Code()
    used, _ = code.name("2.0 * a"), code.name("3.0 * a")
    assert code.program("f", ("a",), [used]).lines == (("t0", "2.0 * a"),)
