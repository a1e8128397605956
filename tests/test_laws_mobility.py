"""Laws of mobility: the five classes, degenerate robots, holonomy, and angles off one centre.

Expected classes are those of Campion, Bastin and d'Andrea-Novel (1996, table II) and of Siegwart
and Nourbakhsh (2004, section 3.3), counted by hand for each drive.
"""

import dataclasses
import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from catalogue import (
    CURVED,
    ROBOTS,
    all_reversed,
    each_robot,
    feasible_twists,
    kinematics,
    mirrored,
    reordered,
    scaled,
    seen_from,
    steering_for,
)
from geometry import slip_rows, turned
from trundle import Kinematics, mobility
from trundle.errors import OffCentreError
from trundle.kinematics.mobility import bracket
from trundle.robot import (
    BallWheel,
    CasterWheel,
    FixedWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
    Wheel,
)

# Rows that share a centre leave only rounding; those that miss by a degree leave 1e-2.
SHARED = 1e-9


# Controllable: the motors determine every motion that is left (else it drifts), and the brackets of
# what is left give the whole plane.
class Expected(NamedTuple):
    kind: str
    rank: int
    omnidirectional: bool
    holonomic: bool
    controllable: bool


OMNI = Expected("(3,0)", 3, True, True, True)
CAR = Expected("(1,1)", 1, False, False, True)
CLASSES = {
    "differential": Expected("(2,0)", 2, False, False, True),
    "tricycle": CAR,
    "bicycle": CAR,
    "ackermann": CAR,
    "rear_steered": CAR,
    "four_wheel_steered": CAR,
    "omni3": OMNI,
    "omni3_exercise": OMNI,
    "omni": OMNI,
    "omni4": OMNI,
    "mecanum": OMNI,
    "mecanum_lecture": OMNI,
    "two_steered": Expected("(1,2)", 1, False, False, True),
    # Every direction, but the body never turns: the heading of the start is kept for ever.
    "synchro": Expected("(1,1)", 1, False, False, False),
    "swerve": Expected("(1,2)", 1, False, False, True),
    "omni_steer": Expected("(2,1)", 2, False, False, True),
    # Without slip four fixed wheels leave straight motion; they turn because they slip.
    "skid_steer": Expected("(1,0)", 2, False, False, True),
    "mixed": Expected("(2,0)", 2, False, False, True),
    "odd_omni": OMNI,
    "odd_swerve": Expected("(1,2)", 1, False, False, True),
    "odd_differential": Expected("(2,0)", 2, False, False, True),
    "odd_omni_steer": Expected("(2,1)", 2, False, False, True),
    "skew_skid": Expected("(1,0)", 2, False, False, True),
    "curved": CAR,
}


def fixed(name: str, x: float, y: float, degrees: float = 0.0, driven: bool = True) -> FixedWheel:
    heading = math.radians(degrees)
    return FixedWheel(name=name, x=x, y=y, radius=0.1, heading=heading, driven=driven)


def omni(name: str, x: float, y: float, degrees: float) -> OmniWheel:
    return OmniWheel(name=name, x=x, y=y, radius=0.1, heading=math.radians(degrees))


def steered(name: str, x: float, y: float, group: str | None = None, ratio: float = 1.0) -> Wheel:
    return SteeredWheel(name=name, x=x, y=y, radius=0.1, steering_group=group, steering_ratio=ratio)


def caster(name: str, x: float, y: float) -> CasterWheel:
    return CasterWheel(name=name, x=x, y=y, radius=0.05)


def made_of(*wheels: Wheel) -> Robot:
    return Robot(name="made", wheels=wheels)


def check(robot: Robot, expected: Expected) -> None:
    found = mobility(robot)
    assert (
        Expected(found.kind, found.rank, found.omnidirectional, found.holonomic, found.controllable)
        == expected
    ), "\n".join(found.reasons)
    assert found.kind == f"({found.degree},{found.steerability})"
    assert found.maneuverability == found.degree + found.steerability


@each_robot
def test_the_class_of_each_robot(robot: Robot) -> None:
    check(robot, CLASSES[robot.name])


DEGENERATE = {
    # Two axles that cross at a point: the robot turns about it and does nothing else.
    "locked on a circle": (
        made_of(fixed("a", 0.0, 0.5), fixed("b", 0.5, 0.0, 90)),
        Expected("(1,0)", 1, False, True, False),
    ),
    # Three axles that share no point.
    "locked": (
        made_of(fixed("a", 0.0, 0.5), fixed("b", 0.5, 0.1, 90), fixed("c", -0.5, -0.5, 45)),
        Expected("(0,0)", 0, False, True, False),
    ),
    # Parallel axles: a line, integrable, so holonomic in the strict sense.
    "four fixed wheels": (
        made_of(*(fixed(f"{x}{y}", x, y) for x in (-0.3, 0.3) for y in (-0.2, 0.2))),
        Expected("(1,0)", 1, False, True, False),
    ),
    "four fixed wheels without motors": (
        made_of(*(fixed(f"{x}{y}", x, y, driven=False) for x in (-0.3, 0.3) for y in (0.2, -0.2))),
        Expected("(1,0)", 0, False, True, False),
    ),
    "bicycle with a locked front wheel": (
        made_of(fixed("front", 1.0, 0.0), fixed("rear", 0.0, 0.0)),
        Expected("(1,0)", 1, False, True, False),
    ),
    "locked front wheel at 30 deg": (
        made_of(fixed("front", 1.0, 0.0, 30, driven=False), fixed("rear", 0.0, 0.0)),
        Expected("(1,0)", 1, False, True, False),
    ),
    "one fixed wheel": (
        made_of(fixed("a", 0.3, 0.2, 25), BallWheel(name="b", x=0.0, y=0.0)),
        # It gives one twist and leaves turning free, which nothing drives.
        Expected("(2,0)", 1, False, False, False),
    ),
    # Swedish wheels never hold a motion: no constraint, but two motors leave one motion to drift.
    "two omni wheels": (
        made_of(omni("a", 0.3, 0.2, 0), omni("b", -0.2, 0.1, 60), caster("c", 0.0, 0.0)),
        Expected("(3,0)", 2, False, True, False),
    ),
    # Four omni wheels whose axes all pass through the centre push it, and never turn it.
    "omni wheels that push through the centre": (
        made_of(*(omni(str(k), math.cos(k), math.sin(k), math.degrees(k)) for k in range(4))),
        Expected("(3,0)", 2, False, True, False),
    ),
    "mecanum with d = l": (
        trundle.load("mecanum_lecture", wheelbase=0.6, track=0.6),
        Expected("(3,0)", 2, False, True, False),
    ),
    "casters only": (
        made_of(caster("a", 0.3, 0.0), caster("b", -0.3, 0.1)),
        Expected("(3,0)", 0, False, True, False),
    ),
    "a ball": (
        made_of(BallWheel(name="a", x=0.0, y=0.0)),
        Expected("(3,0)", 0, False, True, False),
    ),
    # One wheel steers against a locked pair that shares a centre: only the turn about it is left,
    # and the wheel has one angle that goes with it.
    "a steered wheel beside a locked pair": (
        made_of(fixed("a", 0.0, 0.5), fixed("b", 0.5, 0.0, 90), steered("s", -0.4, -0.6)),
        Expected("(1,0)", 1, False, True, False),
    ),
    "one steered wheel": (
        made_of(steered("a", 0.4, 0.1), caster("b", 0.0, 0.0)),
        Expected("(2,1)", 1, False, False, False),  # it may turn about the wheel's contact
    ),
}


@pytest.mark.parametrize(("robot", "expected"), DEGENERATE.values(), ids=DEGENERATE)
def test_the_class_of_degenerate_robots(robot: Robot, expected: Expected) -> None:
    check(robot, expected)


LINKED = {
    # A belt on wheels side by side: parallel wheels leave one straight line, turned by the belt.
    "belt of two": (
        made_of(steered("a", 0.3, 0.2, "g"), steered("b", -0.3, -0.2, "g")),
        Expected("(1,1)", 1, False, False, False),
    ),
    "counter-phase pair": (
        made_of(steered("a", 0.4, 0.0, "g"), steered("b", -0.4, 0.0, "g", -1.0)),
        Expected("(1,1)", 1, False, False, True),
    ),
    # The rear half as far, the other way: the centre runs along a curve.
    "half as far": (CURVED, CAR),
    # One belt that turns three wheels, one wheel that steers alone: it must follow.
    "belt and a free wheel": (
        made_of(
            *(steered(str(k), math.cos(k), math.sin(k), "g") for k in range(3)),
            steered("c", 0.0, 0.5),
        ),
        Expected("(1,1)", 1, False, False, False),
    ),
    # With two on the belt it turns as well: their axles can lie on one line.
    "belt of two and a free wheel": (
        made_of(steered("a", 0.3, 0.2, "g"), steered("b", -0.3, -0.2, "g"), steered("c", 0, 0.5)),
        CAR,
    ),
    # A group of one is a wheel that steers alone, at whatever ratio.
    "groups of one": (
        made_of(steered("a", 0.3, 0.0, "g", 2.0), steered("b", -0.3, 0.0, "h", -0.7)),
        Expected("(1,2)", 1, False, False, True),
    ),
    # On one spot two linked wheels are one wheel.
    "twin wheels": (
        made_of(steered("a", 0.4, 0.0, "g"), steered("b", 0.4, 0.0, "g"), caster("c", 0.0, 0.0)),
        Expected("(2,1)", 1, False, False, False),
    ),
}


@pytest.mark.parametrize(("robot", "expected"), LINKED.values(), ids=LINKED)
def test_the_class_of_linked_steering(robot: Robot, expected: Expected) -> None:
    check(robot, expected)


CHANGES = {
    "turned": lambda robot: seen_from(robot, 0.0, 0.0, 0.8),
    "shifted": lambda robot: seen_from(robot, 2.3, -1.7, 0.0),
    "moved far": lambda robot: seen_from(robot, 40.0, 30.0, -2.0),
    "mirrored": mirrored,
    "reversed": all_reversed,
    "reordered": lambda robot: reordered(robot, reversed(range(len(robot.wheels)))),
    "a centimetre": lambda robot: scaled(robot, 0.01),
    "a hundred metres": lambda robot: scaled(robot, 100.0),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
@each_robot
def test_the_class_does_not_depend_on_how_the_robot_is_described(robot: Robot, change) -> None:
    check(change(robot), CLASSES[robot.name])


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
@pytest.mark.parametrize(("robot", "expected"), DEGENERATE.values(), ids=DEGENERATE)
def test_degenerate_classes_do_not_depend_on_the_description(
    robot: Robot, expected: Expected, change
) -> None:
    check(change(robot), expected)


# ---- what is told in words -----------------------------------------------------------------


def test_the_reasons_say_where_the_two_tests_of_holonomy_differ() -> None:
    told = " ".join(mobility(DEGENERATE["four fixed wheels"][0]).reasons)
    assert "W has rank 1, less than 3: the lectures call it non-holonomic." in told
    assert "holonomic in the strict sense" in told
    assert "two tests differ" in told
    told = " ".join(mobility(ROBOTS["differential"]).reasons)
    assert "truly non-holonomic" in told
    assert "Every pose can be reached." in told


def test_a_robot_that_nothing_drives_is_not_said_to_reach_every_pose() -> None:
    told = " ".join(mobility(DEGENERATE["casters only"][0]).reasons)
    assert "Every pose can be reached." not in told


@pytest.mark.parametrize(
    ("name", "motions"),
    [
        ("differential", {"straight forward and back", "turning on the spot"}),
        ("synchro", {"straight forward and back", "straight sideways"}),
        ("mecanum", {"straight forward and back", "straight sideways", "turning on the spot"}),
        ("four_wheel_steered", {"straight forward and back", "turning on the spot"}),
    ],
)
def test_the_motions_are_those_a_person_names(name: str, motions: set[str]) -> None:
    assert set(mobility(ROBOTS[name]).motions) == motions


def test_a_robot_locked_on_a_circle_names_its_centre() -> None:
    """The axles are the line x = 0 and the line y = 0.2."""
    robot = made_of(fixed("a", 0.0, 0.5), fixed("b", 0.5, 0.2, 90))
    assert mobility(robot).motions == ("turning about the point (0, 0.2) m",)


def test_skidding_wheels_are_named_as_what_lets_the_robot_turn() -> None:
    told = " ".join(mobility(ROBOTS["skid_steer"]).reasons)
    assert "4 wheels that may skid" in told
    assert "Class (1,0)" in told


def as_matrix(twist: Sequence[float]) -> NDArray[np.float64]:
    u, v, r = twist
    return np.array([[0.0, -r, u], [r, 0.0, v], [0.0, 0.0, 0.0]])


def test_the_lie_bracket_is_the_commutator_of_matrices() -> None:
    for first, second in np.random.default_rng(35).normal(size=(10, 2, 3)):
        a, b = as_matrix(first), as_matrix(second)
        np.testing.assert_allclose(as_matrix(bracket(first, second)), a @ b - b @ a, atol=SHARED)


# ---- angles that share no centre -----------------------------------------------------------


def nearest_told(message: str) -> list[float]:
    """Return the angles [rad] that the message gives as the nearest."""
    found = re.search(r"\(([-0-9., ]+) rad\)", message)
    assert found is not None, message
    return [float(angle) for angle in found.group(1).split(",")]


def misfit(robot: Robot, steering: Sequence[float]) -> float:
    """Return the third singular value of the side-slip rows: 0 where the axles share a centre."""
    sizes = np.linalg.svd(slip_rows(robot, steering), compute_uv=False)
    return float(sizes[2]) if len(sizes) > 2 else 0.0


OFF_CENTRE = [
    ("ackermann", [0.3, 0.3]),
    ("ackermann", [-0.5, -0.5]),
    ("ackermann", [0.1, 1.2]),
    ("rear_steered", [0.4, 0.4]),
    ("swerve", [0.0, 0.5, -0.5, 1.0]),
    ("odd_swerve", [0.2, 0.9, -0.3]),
    ("synchro", [0.3, 0.3, 0.1]),
    ("four_wheel_steered", [0.3, 0.3, -0.3, -0.3]),
]


@pytest.mark.parametrize(("name", "angles"), OFF_CENTRE, ids=str)
def test_angles_off_one_centre_raise_and_name_the_nearest(name: str, angles: list[float]) -> None:
    robot = ROBOTS[name]
    with pytest.raises(OffCentreError, match=f"share no instantaneous centre: robot '{name}'") as e:
        kinematics(robot).wheel_matrix(angles)
    assert ", ".join(f"{math.degrees(angle):.6g}" for angle in angles) in str(e.value)
    near = np.array(nearest_told(str(e.value)))
    assert misfit(robot, near) < SHARED
    kinematics(robot).wheel_matrix(near)
    distance = float(np.sum(turned(near - angles) ** 2))
    assert distance < 2.0
    # Of 2000 random twists near and far, none has angles that are nearer.
    for twist in feasible_twists(robot, (2000,), seed=31) * [1.0, 1.0, 3.0]:
        other = turned(steering_for(robot, twist) - angles)
        assert float(np.sum(other**2)) > distance - SHARED


def test_the_nearest_angles_of_equal_ackermann_angles_lie_around_them() -> None:
    with pytest.raises(OffCentreError) as caught:
        kinematics(ROBOTS["ackermann"]).wheel_matrix([0.3, 0.3])
    left, right = nearest_told(str(caught.value))
    assert left > 0.3 > right  # a left turn: the left wheel is nearer to the centre
    assert 1 / math.tan(right) - 1 / math.tan(left) == pytest.approx(1.5 / 2.6, abs=1e-6)


def test_one_bad_row_of_a_batch_is_enough() -> None:
    good = steering_for(ROBOTS["ackermann"], np.array([1.0, 0.0, 0.2]))
    with pytest.raises(OffCentreError, match=r"17\.1887, 17\.1887 deg"):
        kinematics(ROBOTS["ackermann"]).wheel_matrix([good, [0.3, 0.3], good])


def test_a_robot_that_no_angles_help_says_so() -> None:
    robot = made_of(
        fixed("a", 0.0, 0.5), fixed("b", 0.5, 0.1, 90), fixed("c", -0.5, -0.5, 45),
        steered("s", 1.0, 0.0),
    )  # fmt: skip
    with pytest.raises(OffCentreError, match="at these or any other angles"):
        Kinematics(robot).wheel_matrix([0.0])


@pytest.mark.parametrize("size", [1e-2, 1.0, 1e2])
@pytest.mark.parametrize("about", [(0.0, 0.0), (30.0, -20.0)], ids=str)
def test_a_hundredth_of_a_degree_off_is_seen(size: float, about: tuple[float, float]) -> None:
    """An Ackermann car of any size, described from any origin near it."""
    robot = scaled(seen_from(ROBOTS["ackermann"], *about, 0.0), size)
    good = steering_for(ROBOTS["ackermann"], np.array([1.0, 0.0, 0.4]))
    Kinematics(robot).wheel_matrix(good)
    with pytest.raises(OffCentreError):
        Kinematics(robot).wheel_matrix(good + np.radians([0.01, -0.01]))


@each_robot
def test_angles_to_six_digits_are_good_enough(robot: Robot) -> None:
    """Logs and people write six decimals of a radian."""
    steering = np.round(steering_for(robot, feasible_twists(robot, (20,), seed=33)), 6)
    kinematics(robot).wheel_matrix(steering if robot.steered else None)


def test_ackermann_at_the_same_angle_as_a_bicycle_is_told_apart_from_it() -> None:
    """The class is found at angles that share a centre, never at random ones."""
    robot = dataclasses.replace(ROBOTS["ackermann"], name="car")
    assert mobility(robot).degree == 1
