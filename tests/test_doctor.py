"""The geometry doctor: each code on a robot that has the fault, and on none that has not."""

import dataclasses
import math

import numpy as np
import pytest

import trundle
from trundle.kinematics import diagnose
from trundle.robot import (
    CATALOG,
    CasterWheel,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
    load,
)


def codes(robot, steering=None):
    return [finding.code for finding in diagnose(robot, steering)]


def with_wheel(robot, index, **changes):
    wheels = list(robot.wheels)
    wheels[index] = dataclasses.replace(wheels[index], **changes)
    return dataclasses.replace(robot, wheels=tuple(wheels))


@pytest.mark.parametrize("name", CATALOG)
def test_only_the_lectures_mecanum_is_ill(name):
    assert codes(load(name)) == (["yaw_arm_cancels"] if name == "mecanum_lecture" else [])


def test_equal_half_sizes_leave_the_lectures_mecanum_without_yaw():
    robot = load("mecanum_lecture", wheelbase=0.6, track=0.6)
    found = {finding.code: finding for finding in diagnose(robot)}
    assert {"yaw_arm_cancels", "cannot_push", "unobserved_motion"} <= set(found)
    assert "turning on the spot" in found["cannot_push"].message
    assert trundle.mobility(robot).rank == 2


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.2, 0.0), (-0.7, 0.3)])
def test_the_yaw_arm_does_not_depend_on_the_origin(shift):
    def moved(robot):
        wheels = tuple(
            dataclasses.replace(w, x=w.x + shift[0], y=w.y + shift[1]) for w in robot.wheels
        )
        return dataclasses.replace(robot, wheels=wheels, body=None)

    assert "yaw_arm_cancels" in codes(moved(load("mecanum_lecture")))
    assert codes(moved(load("mecanum"))) == []


def test_one_roller_mounted_the_wrong_way_is_named():
    robot = with_wheel(load("mecanum"), 0, roller=math.radians(45))
    (found,) = [f for f in diagnose(robot) if f.code == "yaw_arm_cancels"]
    assert found.wheels == ("front_left",)


def test_almost_equal_half_sizes_are_ill_conditioned():
    # |d - l| = 2.5 mm at a reach of 0.43 m: condition near 0.43 / 0.0025.
    robot = load("mecanum_lecture", wheelbase=0.6, track=0.605)
    (found,) = [f for f in diagnose(robot) if f.code == "ill_conditioned"]
    assert float(found.message.split("number is ")[1].split(":")[0]) == pytest.approx(170, rel=0.1)


def test_rollers_near_the_drive_direction_cannot_push():
    robot = with_wheel(load("mecanum"), 2, roller=math.radians(85))
    (found,) = [f for f in diagnose(robot) if f.code == "cannot_push"]
    assert found.wheels == ("rear_left",)


def test_a_motion_that_nothing_drives_is_named():
    wheels = load("omni", angles=(0.0, math.pi)).wheels  # both drive along y
    found = {f.code: f.message for f in diagnose(Robot(name="two", wheels=wheels))}
    assert "straight forward and back" in found["cannot_push"]
    assert "straight forward and back" in found["unobserved_motion"]


def test_casters_alone_push_nothing_and_see_nothing():
    robot = Robot(name="cart", wheels=(CasterWheel(name="c", x=0.0, y=0.0, radius=0.05),))
    assert codes(robot) == ["cannot_push", "unobserved_motion"]


@pytest.mark.parametrize("name", ["omni3", "mecanum"])
def test_a_fixed_wheel_under_an_omnidirectional_robot_blocks_it(name):
    dead = FixedWheel(name="dead", x=0.05, y=0.0, radius=0.02, driven=False)
    robot = load(name)
    found = diagnose(dataclasses.replace(robot, wheels=(*robot.wheels, dead)))
    assert [(f.code, f.wheels) for f in found] == [("side_slip_blocks", ("dead",))]


def test_four_fixed_wheels_without_skid_block_each_other():
    found = diagnose(load("skid_steer").with_wheels(skid=False))
    blocked = [f.wheels for f in found if f.code == "side_slip_blocks"]
    assert blocked == [("front_left", "front_right"), ("rear_left", "rear_right")]
    assert "wheels_conflict" in [f.code for f in found]


def test_wheels_that_toe_in_can_only_turn_about_one_point():
    robot = with_wheel(load("differential"), 0, heading=math.radians(10))
    assert "wheels_conflict" in codes(robot)


def test_locked_wheels_conflict():
    wheels = tuple(
        FixedWheel(name=f"w{i}", x=math.cos(i), y=math.sin(i), heading=1.0 * i, radius=0.1)
        for i in range(3)
    )
    assert "wheels_conflict" in codes(Robot(name="locked", wheels=wheels))


def test_a_motor_across_the_only_motion_conflicts():
    across = FixedWheel(name="across", x=0.0, y=0.0, heading=math.pi / 2, radius=0.05)
    robot = Robot(name="crossed", wheels=(*load("differential").wheels, across))
    named = {w for f in diagnose(robot) if f.code == "wheels_conflict" for w in f.wheels}
    assert "across" in named


def test_equal_angles_of_a_car_are_off_centre_and_the_nearest_are_told():
    (found,) = diagnose(load("ackermann"), [0.3, 0.3])
    assert found.code == "off_centre_angles"
    told = [float(text) for text in found.message.split("(")[-1].split(" rad")[0].split(", ")]
    # With the rear axle at x = 0 the centre is at (0, y): cot(left) - cot(right) = -track / base.
    left, right = told
    assert 1 / math.tan(right) - 1 / math.tan(left) == pytest.approx(1.5 / 2.6, abs=1e-6)


def test_one_belt_for_four_wheels_front_against_rear_is_off_centre():
    at = [(0.5, 0.4), (0.5, -0.4), (-0.5, 0.4), (-0.5, -0.4)]
    wheels = tuple(
        SteeredWheel(
            name=f"w{i}", x=x, y=y, radius=0.1, steering_group="all", steering_ratio=np.sign(x)
        )
        for i, (x, y) in enumerate(at)
    )
    robot = Robot(name="naive", wheels=wheels)
    assert codes(robot) == ["off_centre_angles"]
    assert_it_drives_straight_only(robot)


def test_a_car_with_its_front_wheels_on_one_rod_is_off_centre():
    car = load("ackermann")
    wheels = tuple(
        dataclasses.replace(w, steering_group="rod") if isinstance(w, SteeredWheel) else w
        for w in car.wheels
    )
    robot = dataclasses.replace(car, wheels=wheels)
    assert codes(robot) == ["off_centre_angles"]
    assert_it_drives_straight_only(robot)


def assert_it_drives_straight_only(robot):
    """At angle 0 the wheels are parallel; at any other they share no centre."""
    can = trundle.mobility(robot)
    assert (can.kind, can.rank, can.holonomic, can.controllable) == ("(1,0)", 1, True, False)
    assert can.motions == ("straight forward and back",)
    found = trundle.Kinematics(robot).inverse([1.0, 0.0, 0.5])
    # Two solutions fall together there, which leaves the angle known to half the digits.
    np.testing.assert_allclose(found.twist, [1.0, 0.0, 0.0], atol=1e-7)


@pytest.mark.parametrize("name", ["mecanum", "omni3", "omni4"])
@pytest.mark.parametrize("index", [0, 1, 2])
def test_one_spin_against_the_others_is_suspect(name, index):
    robot = load(name)
    wheel = robot.wheels[index]
    found = diagnose(with_wheel(robot, index, reversed=not wheel.reversed))
    assert [(f.code, f.wheels) for f in found] == [("reversed_suspect", (wheel.name,))]


def test_motors_mirrored_on_one_side_are_usual():
    robot = load("mecanum")
    wheels = tuple(dataclasses.replace(w, reversed=w.y < 0) for w in robot.wheels)
    assert codes(dataclasses.replace(robot, wheels=wheels)) == []


def test_the_full_track_taken_for_half_stands_outside_the_body():
    robot = load("differential")
    wheels = tuple(dataclasses.replace(w, y=2 * w.y) for w in robot.wheels)
    (found,) = diagnose(dataclasses.replace(robot, wheels=wheels))
    assert (found.code, found.wheels) == ("outside_body", ("left", "right"))


def test_every_finding_has_words_and_a_remedy():
    ill = [
        load("mecanum_lecture", wheelbase=0.6, track=0.6),
        load("skid_steer").with_wheels(skid=False),
        Robot(name="cart", wheels=(CasterWheel(name="c", x=0.0, y=0.0, radius=0.05),)),
    ]
    for robot in ill:
        for finding in diagnose(robot):
            assert len(finding.message) > 30
            assert len(finding.remedy) > 20


def test_mixed_kinds_are_not_compared_with_each_other():
    wheels = (
        *load("mecanum").wheels[:2],
        *(OmniWheel(name=f"o{i}", x=-0.2, y=y, radius=0.05) for i, y in enumerate((0.1, -0.1))),
        MecanumWheel(name="odd", x=0.0, y=0.3, radius=0.05, roller=math.radians(-45)),
    )
    assert "reversed_suspect" not in codes(Robot(name="mix", wheels=wheels))
