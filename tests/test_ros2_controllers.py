"""Settings of ros2_controllers: what each controller does with them is what the robot needs.

The controllers' equations are written here anew from their published sources, ros2_controllers
4.30 (July 2025) and later, and fed with nothing but the numbers and names of the YAML.
"""

import dataclasses
import importlib
import json
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

import trundle
from catalogue import ODD_DIFFERENTIAL, ROBOTS, SKEW_SKID
from trundle.exchange import joint_names, ros2_controllers
from trundle.robot import (
    CATALOG,
    BallWheel,
    CasterWheel,
    FixedWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
)

# Twelve digits are printed; speeds reach a hundred rad/s.
PRINTED = 1e-9
# Lengths that differ by a thousandth of the robot's size count as equal, and angles by 1e-3 rad:
# the wheel speeds, of some tens of rad/s, are then off by some parts in a thousand.
MEANT_EQUAL = 5e-3

FIT = {
    "differential": "diff_drive_controller",
    "tricycle": "tricycle_controller",
    "bicycle": "bicycle_steering_controller",
    "ackermann": "ackermann_steering_controller",
    "omni3_exercise": "omni_wheel_drive_controller",
    "omni4": "omni_wheel_drive_controller",
    "mecanum": "mecanum_drive_controller",
    "skid_steer": "diff_drive_controller",
}
Commands = tuple[dict[str, float], dict[str, float]]


def read(text: str) -> dict:
    """Read the part of YAML that is used: maps by indentation, JSON's scalars and lists."""
    root: dict = {}
    open_maps = [(-1, root)]
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        indent = len(line) - len(line.lstrip())
        key, colon, value = line.strip().partition(":")
        assert colon, line
        while indent <= open_maps[-1][0]:
            open_maps.pop()
        inside = open_maps[-1][1]
        assert key not in inside, f"{key} twice"
        if value:
            inside[key] = json.loads(value)
        else:
            inside[key] = {}
            open_maps.append((indent, inside[key]))
    return root


def settings(robot: Robot, **given: float) -> tuple[str, dict]:
    """Return the name of the controller and its parameters."""
    made = read(ros2_controllers(robot, **given))
    (name,) = made.keys() - {"controller_manager"}
    return name, made[name]["ros__parameters"]


def diff_drive(p: dict, u: float, _: float, r: float) -> Commands:
    """diff_drive_controller.cpp, update_and_write_commands."""
    separation = p.get("wheel_separation_multiplier", 1.0) * p["wheel_separation"]
    left = p.get("left_wheel_radius_multiplier", 1.0) * p["wheel_radius"]
    right = p.get("right_wheel_radius_multiplier", 1.0) * p["wheel_radius"]
    speeds = dict.fromkeys(p["left_wheel_names"], (u - r * separation / 2) / left)
    speeds |= dict.fromkeys(p["right_wheel_names"], (u + r * separation / 2) / right)
    return speeds, {}


def mecanum_drive(p: dict, u: float, v: float, r: float) -> Commands:
    """mecanum_drive_controller.cpp, update_and_write_commands."""
    k = p["kinematics"]
    offset, a = k["base_frame_offset"], k["wheels_radius"]
    arm = k["sum_of_robot_center_projection_on_X_Y_axis"]
    turned = complex(u, v) * complex(math.cos(offset["theta"]), math.sin(offset["theta"]))
    x, y = turned.real + offset["y"] * r, turned.imag - offset["x"] * r
    signs = {"front_left": (-1, -1), "front_right": (1, 1), "rear_right": (-1, 1)}
    signs["rear_left"] = (1, -1)
    return {
        p[f"{name}_wheel_command_joint_name"]: (x + side * y + turn * arm * r) / a
        for name, (side, turn) in signs.items()
    }, {}


def omni_wheel_drive(p: dict, u: float, v: float, r: float) -> Commands:
    """omni_wheel_drive_controller.cpp, compute_and_set_wheel_velocities."""
    step = 2 * math.pi / len(p["wheel_names"])
    speeds = {}
    for i, name in enumerate(p["wheel_names"]):
        angle = i * step + p["wheel_offset"]
        pull = math.sin(angle) * u - math.cos(angle) * v - r * p["robot_radius"]
        speeds[name] = pull / p["wheel_radius"]
    return speeds, {}


def tricycle(p: dict, u: float, _: float, r: float) -> Commands:
    """tricycle_controller.cpp, twist_to_ackermann."""
    if u == 0 and r != 0:
        angle = math.copysign(math.pi / 2, r)
        speed = abs(r) * p["wheelbase"] / p["wheel_radius"]
    else:
        angle = math.atan(r * p["wheelbase"] / u) if r and u else 0.0
        speed = u / (p["wheel_radius"] * math.cos(angle))
    return {p["traction_joint_name"]: speed}, {p["steering_joint_name"]: angle}


def steering_library(p: dict, u: float, _: float, r: float) -> Commands:
    """steering_kinematics.cpp, get_commands, at angles that have been reached."""
    wheelbase = p["wheelbase"]
    radius = p.get("traction_wheel_radius") or p["traction_wheels_radius"]
    phi = math.atan(r * wheelbase / u)
    speeds = [u / radius]
    if len(p["traction_joints_names"]) == 2:
        half = p["traction_track_width"] / 2
        bend = math.tan(phi) / wheelbase
        speeds = [u / radius * (1 + half * bend), u / radius * (1 - half * bend)]  # right, left
    angles = [phi]
    if len(p["steering_joints_names"]) == 2:
        top, across = 2 * wheelbase * math.sin(phi), p["steering_track_width"] * math.sin(phi)
        ahead = 2 * wheelbase * math.cos(phi)
        angles = [math.atan2(top, ahead + across), math.atan2(top, ahead - across)]
    return (
        dict(zip(p["traction_joints_names"], speeds, strict=True)),
        dict(zip(p["steering_joints_names"], angles, strict=True)),
    )


EQUATIONS: dict[str, Callable[[dict, float, float, float], Commands]] = {
    "diff_drive_controller": diff_drive,
    "mecanum_drive_controller": mecanum_drive,
    "omni_wheel_drive_controller": omni_wheel_drive,
    "tricycle_controller": tricycle,
    "bicycle_steering_controller": steering_library,
    "tricycle_steering_controller": steering_library,
    "ackermann_steering_controller": steering_library,
}
HOLONOMIC = ("mecanum_drive_controller", "omni_wheel_drive_controller")


def largest_error(robot: Robot, count: int = 12) -> float:
    """Return by how much a command's wheel speeds and angles are off, over random twists."""
    name, parameters = settings(robot)
    kin, rng = trundle.Kinematics(robot), np.random.default_rng(5)
    joints = joint_names(robot)
    worst = 0.0
    for _ in range(count):
        u, v, r = rng.uniform(-1, 1, 3)
        # The controllers steer by at most a quarter turn: a car's circles are not too small.
        u, r = (u, r) if not robot.steered else (u + math.copysign(0.5, u), 0.1 * r)
        twist = (u, v if name in HOLONOMIC else 0.0, r)
        needed = kin.inverse(twist, steering=[0.0] * len(robot.steered) or None, limit=False)
        assert np.abs(needed.residual).max() < MEANT_EQUAL, f"{name} commands what cannot be"
        speeds, angles = EQUATIONS[name](parameters, *twist)
        assert sorted(speeds) == sorted(joints[wheel.name].wheel for wheel in robot.driven)
        assert sorted(angles) == sorted(joints[wheel.name].steering for wheel in robot.steered)
        for wheel, speed in zip(robot.driven, needed.wheel_speeds, strict=True):
            worst = max(worst, abs(speeds[joints[wheel.name].wheel] - speed) * wheel.radius)
        for wheel, angle in zip(robot.steered, needed.steering, strict=True):
            worst = max(worst, abs(angles[joints[wheel.name].steering] - angle))
    return worst


@pytest.mark.parametrize("name", CATALOG)
def test_the_catalogue_gets_its_controllers(name):
    robot = trundle.load(name)
    if name not in FIT:
        with pytest.raises(trundle.TrundleError, match="fit"):
            ros2_controllers(robot)
        return
    assert settings(robot)[0] == FIT[name]
    assert largest_error(robot) < PRINTED


def moved(robot: Robot, x: float, y: float, angle: float) -> Robot:
    """Return the robot described in a frame from which its own is at (x, y), turned."""
    c, s = math.cos(angle), math.sin(angle)
    return dataclasses.replace(
        robot,
        wheels=tuple(
            dataclasses.replace(
                w,
                x=x + c * w.x - s * w.y,
                y=y + s * w.x + c * w.y,
                **({"heading": w.heading + angle} if hasattr(w, "heading") else {}),
            )
            for w in robot.wheels
        ),
    )


def changed(robot: Robot, names: str, **fields: object) -> Robot:
    """Return the robot with fields changed on the wheels that are named."""
    return dataclasses.replace(
        robot,
        wheels=tuple(
            dataclasses.replace(w, **fields) if w.name in names.split() else w for w in robot.wheels
        ),
    )


def omni_ring(n: int, offset: float, **fields: object) -> Robot:
    """Return n omni wheels on a ring that spin the body clockwise, in no order."""
    order = np.random.default_rng(n).permutation(n)
    wheels = []
    for i in order:
        at = offset + 2 * math.pi * float(i) / n
        place = {"x": 0.3 * math.cos(at), "y": 0.3 * math.sin(at), "heading": at - math.pi / 2}
        wheels.append(OmniWheel(name=f"w{i}", radius=0.06, **(place | fields)))
    return Robot(name="ring", wheels=tuple(wheels))


MECANUM = trundle.load("mecanum")
DIFFERENTIAL = trundle.load("differential")
ACKERMANN = trundle.load("ackermann")
TRICYCLE = trundle.load("tricycle")
DELTA = dataclasses.replace(  # one wheel steers in front, two drive behind
    ACKERMANN,
    name="delta",
    wheels=(
        SteeredWheel(name="front", x=1.0, y=0.0, radius=0.2, driven=False),
        FixedWheel(name="left", x=0.0, y=0.4, radius=0.15),
        FixedWheel(name="right", x=0.0, y=-0.4, radius=0.15),
    ),
)


def fitting() -> Iterator[tuple[str, Robot]]:
    yield "mecanum moved", moved(MECANUM, 0.3, -0.1, 0.0)
    yield "mecanum turned", moved(MECANUM, 0.0, 0.0, 0.7)
    yield "mecanum moved and turned", moved(MECANUM, -0.4, 1.3, -2.5)
    yield "mecanum seen from behind", MECANUM.with_wheels(heading=math.pi)
    yield "mecanum, all reversed", MECANUM.with_wheels(reversed=True)
    yield "mecanum, all reversed, moved", moved(MECANUM.with_wheels(reversed=True), 1.0, 0.2, 2.0)
    yield (
        "mecanum, one side mounted the other way",
        changed(MECANUM, "front_left rear_left", heading=math.pi, reversed=True),
    )
    for n in (3, 4, 5, 7):
        yield f"ring of {n}", omni_ring(n, 0.0)
        yield f"ring of {n}, turned", omni_ring(n, 2.0 * n)
    yield "differential, right reversed", changed(DIFFERENTIAL, "right", reversed=True)
    yield "differential, both reversed", DIFFERENTIAL.with_wheels(reversed=True)
    yield "differential, uneven radii", changed(DIFFERENTIAL, "left", radius=0.06)
    yield "differential, left turned round", changed(DIFFERENTIAL, "left", heading=math.pi)
    yield (
        "differential, sides swapped",
        changed(changed(DIFFERENTIAL, "left", y=-0.2), "right", y=0.2),
    )
    yield "six-wheel skid-steer", moved(SKEW_SKID, 0.35, 0.0, 0.0)
    yield "skid-steer, wide", trundle.load("skid_steer", track_factor=1.6)
    yield "delta", DELTA
    yield "delta, wheels the other way", changed(DELTA, "left", heading=math.pi, reversed=True)
    yield (
        "ackermann, two tracks",
        changed(changed(ACKERMANN, "front_left", y=0.7), "front_right", y=-0.7),
    )
    nearly = changed(TRICYCLE, "rear_left rear_right", x=1e-17)
    yield "tricycle, axle at x = 0 but for rounding", changed(nearly, "front", y=-1e-17)
    yield "tricycle, small", trundle.load("tricycle", radius=0.04, wheelbase=0.2, track=0.1)


FITTING = dict(fitting())


@pytest.mark.parametrize("robot", FITTING.values(), ids=FITTING)
def test_what_is_exported_drives_as_the_robot_needs(robot):
    assert largest_error(robot) < PRINTED


def mecanum_odometry(p: dict, speeds: dict[str, float]) -> tuple[float, float, float]:
    """mecanum_drive_controller, odometry.cpp, update."""
    k = p["kinematics"]
    corners = ("front_left", "rear_left", "rear_right", "front_right")
    fl, rl, rr, fr = (speeds[p[f"{c}_wheel_command_joint_name"]] for c in corners)
    quarter = 0.25 * k["wheels_radius"]
    x, y = quarter * (fl + rl + rr + fr), quarter * (-fl + rl - rr + fr)
    r = quarter / k["sum_of_robot_center_projection_on_X_Y_axis"] * (-fl - rl + rr + fr)
    offset = k["base_frame_offset"]
    back = complex(math.cos(offset["theta"]), -math.sin(offset["theta"]))
    lever = back * complex(-offset["x"], -offset["y"])
    base = back * complex(x, y) + complex(lever.imag, -lever.real) * r
    return base.real, base.imag, r


def omni_odometry(p: dict, speeds: dict[str, float]) -> tuple[float, float, float]:
    """omni_wheel_drive_controller, odometry.cpp, compute_robot_velocity."""
    step = 2 * math.pi / len(p["wheel_names"])
    at = [i * step + p["wheel_offset"] for i in range(len(p["wheel_names"]))]
    rows = [[math.sin(a), -math.cos(a), -p["robot_radius"]] for a in at]
    rims = [speeds[name] * p["wheel_radius"] for name in p["wheel_names"]]
    return tuple(np.linalg.lstsq(rows, rims, rcond=None)[0])


@pytest.mark.parametrize(
    "robot",
    [robot for robot in FITTING.values() if settings(robot)[0] in HOLONOMIC],
    ids=[name for name, robot in FITTING.items() if settings(robot)[0] in HOLONOMIC],
)
def test_their_odometry_is_the_robots(robot):
    name, parameters = settings(robot)
    odometry = mecanum_odometry if name.startswith("mecanum") else omni_odometry
    speeds = np.random.default_rng(3).uniform(-10, 10, len(robot.driven))  # they disagree, too
    names = [joint_names(robot)[wheel.name].wheel for wheel in robot.driven]
    found = odometry(parameters, dict(zip(names, speeds, strict=True)))
    expected = trundle.Kinematics(robot).forward(speeds)
    np.testing.assert_allclose(found, expected, atol=PRINTED, rtol=PRINTED)


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_a_robot_with_one_wheel_changed_fits_or_is_refused(robot):
    rng = np.random.default_rng(11)
    fields = {
        "x": lambda w: w.x + rng.choice([0.1, -0.03]),
        "y": lambda w: w.y + rng.choice([0.1, -0.03]),
        "radius": lambda w: 1.2 * w.radius,
        "heading": lambda w: w.heading + rng.choice([0.2, math.pi / 2, math.pi]),
        "reversed": lambda w: not w.reversed,
        "roller": lambda w: rng.choice([-w.roller, w.roller + 0.3]),
        "driven": lambda w: not w.driven,
        "skid": lambda _: True,
    }
    accepted, refused = 0, []
    for wheel in robot.wheels:
        for field, change in fields.items():
            if not hasattr(wheel, field) or (field == "driven" and not wheel.may_drive):
                continue
            if getattr(wheel, field) is None:
                continue
            other = changed(robot, wheel.name, **{field: change(wheel)})
            try:
                assert largest_error(other, 3) < MEANT_EQUAL, f"{wheel.name}.{field}"
                accepted += 1
            except trundle.TrundleError as error:
                refused.append(str(error))
    assert accepted or refused
    for told in refused:
        assert "fit" in told or "drives no wheel" in told
        assert "\n" not in told


def test_coordinates_rounded_to_millimetres_are_meant():
    """Three wheels at 120 degrees whose coordinates have three digits, as files have."""
    ring = omni_ring(3, 0.0)
    rough = dataclasses.replace(
        ring,
        wheels=tuple(dataclasses.replace(w, x=round(w.x, 3), y=round(w.y, 3)) for w in ring.wheels),
    )
    assert "were taken as equal" in ros2_controllers(rough)
    assert PRINTED < largest_error(rough) < 1e-3  # m/s of the rim, at twists of 1 m/s and 1 rad/s


NO_FIT = {
    "one wheel reversed": (
        changed(MECANUM, "rear_left", reversed=True),
        "no sign for a wheel, and a positive speed of 'rear_left'",
    ),
    "uneven radii": (
        changed(MECANUM, "rear_left", radius=0.06),
        "one radius for its wheels, but that of 'front_left' is 0.05 m and that of 'rear_left'",
    ),
    "mirrored": (trundle.load("mecanum_lecture"), "swap its front wheels with the rear ones"),
    "one roller": (changed(MECANUM, "rear_left", roller=-math.pi / 4), "it should be at 45 deg"),
    "thirty degrees": (
        changed(MECANUM, "rear_left", roller=math.radians(30)),
        "rollers are at 45 deg, those of 'rear_left' at 30 deg",
    ),
    "skew wheel": (changed(MECANUM, "rear_left", heading=0.3), "wheels are parallel"),
    "not a rectangle": (changed(MECANUM, "rear_left", x=-0.5), "one yaw arm"),
    "counter-clockwise": (trundle.load("omni3"), "clockwise at positive speed"),
    "one the other way": (
        changed(omni_ring(4, 0.0), "w2", reversed=True),
        "a positive speed of 'w2' drives the other way",
    ),
    "uneven arms": (changed(omni_ring(4, 0.0), "w0", x=0.5), "'w0' is 0.5 m away, 'w3' 0.3 m"),
    "uneven angles": (
        trundle.load("omni", angles=[0.0, 2.0, 4.0]).with_wheels(reversed=True),
        "spread evenly",
    ),
    "ring beside the origin": (
        moved(omni_ring(3, 0.0), 0.2, 0.0, 0.0),
        "take 0.2 from every x and 0 from every y",
    ),
    "held omni": (
        dataclasses.replace(
            omni_ring(3, 0.0),
            wheels=(
                *omni_ring(3, 0.0).wheels,
                FixedWheel(name="dead", x=0.0, y=0.0, radius=0.03, driven=False),
            ),
        ),
        "dead may not slip sideways",
    ),
    "axle ahead": (moved(DIFFERENTIAL, 0.1, 0.0, 0.0), "take 0.1 from every x"),
    "axle beside": (moved(DIFFERENTIAL, 0.0, 0.1, 0.0), "take 0.1 from every y"),
    "askew": (ODD_DIFFERENTIAL, "drives along 40 deg"),
    "cannot turn": (
        trundle.load("skid_steer").with_wheels(skid=False),
        "give skid = true",
    ),
    "one wheel": (
        Robot(
            name="one",
            wheels=(
                FixedWheel(name="a", x=0.0, y=0.2, radius=0.1),
                BallWheel(name="b", x=0.1, y=0.0),
            ),
        ),
        "as many driven wheels left of the body's x axis as right of it, got 1 and 0 of 1",
    ),
    "signs on a side": (
        changed(trundle.load("skid_steer"), "front_left", reversed=True),
        "positive speed of 'front_left' drives",
    ),
    "nothing driven": (
        Robot(name="cart", wheels=(CasterWheel(name="c", x=0.0, y=0.0, radius=0.1),)),
        "drives no wheel",
    ),
    "rear steering": (trundle.load("rear_steered"), "behind it, as those of the robot"),
    "tricycle, origin ahead": (moved(TRICYCLE, -0.4, 0.0, 0.0), "take -0.4 from every x"),
    "tricycle, reversed": (changed(TRICYCLE, "front", reversed=True), "no sign for a wheel"),
    "tricycle, askew": (changed(TRICYCLE, "front", heading=0.5), "steering angle 0 must be"),
    "tricycle, beside": (changed(TRICYCLE, "front", y=0.1), "'front' is at y = 0.1 m"),
    "linked": (
        changed(ACKERMANN, "front_left front_right", steering_group="rack"),
        "those of the robot are linked",
    ),
    "driven all round": (ACKERMANN.with_wheels(driven=True), "steers and drives front_left"),
    "swerve": (trundle.load("swerve"), "it steers 4 wheels"),
    "synchro": (trundle.load("synchro"), "it steers 3 wheels"),
    "several kinds": (trundle.load("omni_steer"), "several kinds (steered, omni)"),
}  # fmt: skip


@pytest.mark.parametrize(("robot", "why"), NO_FIT.values(), ids=NO_FIT)
def test_a_misfit_is_told(robot, why):
    with pytest.raises(trundle.TrundleError) as told:
        ros2_controllers(robot)
    assert why in str(told.value)
    assert robot.name in str(told.value)


def test_limits_of_a_differential_drive_are_signed():
    _, parameters = settings(
        DIFFERENTIAL, timeout=0.25, max_speed=1.0, max_reverse_speed=0.4, max_acceleration=0.5,
        max_deceleration=2.0, max_reverse_acceleration=0.3, max_yaw_rate=1.5,
        max_yaw_acceleration=3.0, max_jerk=5.0,
    )  # fmt: skip
    assert parameters["cmd_vel_timeout"] == 0.25
    assert parameters["linear"]["x"] == {
        "max_velocity": 1.0,
        "min_velocity": -0.4,
        "max_acceleration": 0.5,
        "max_deceleration": -2.0,
        "max_acceleration_reverse": -0.3,
        "max_deceleration_reverse": 2.0,
        "max_jerk": 5.0,
        "min_jerk": -5.0,
    }
    assert parameters["angular"]["z"] == {
        "max_velocity": 1.5,
        "min_velocity": -1.5,
        "max_acceleration": 3.0,
        "max_deceleration": -3.0,
        "max_acceleration_reverse": -3.0,
        "max_deceleration_reverse": 3.0,
    }


def test_limits_of_a_tricycle_are_its_front_wheels():
    robot = changed(
        TRICYCLE, "front", max_speed=8.0, steering_min=-1.0, steering_max=1.0, steering_rate=2.0
    )
    radius = robot.steered[0].radius
    _, parameters = settings(robot, timeout=0.3, max_speed=1.0, max_acceleration=0.5)
    assert parameters["cmd_vel_timeout"] == 300  # milliseconds, a whole number
    assert isinstance(parameters["cmd_vel_timeout"], int)
    assert parameters["traction"] == {
        "max_velocity": 8.0,  # the wheel's own, less than 1 m/s over 0.1 m
        "max_acceleration": 0.5 / radius,
        "max_deceleration": 0.5 / radius,
    }
    # A file gives degrees on a grid, so that a radian is a little off.
    assert parameters["steering"] == pytest.approx(
        {"min_position": -1.0, "max_position": 1.0, "max_velocity": 2.0}
    )
    one_sided = settings(changed(TRICYCLE, "front", steering_max=0.3))[1]["steering"]
    assert one_sided == pytest.approx({"min_position": -math.pi / 2, "max_position": 0.3})


@pytest.mark.parametrize(
    ("robot", "given", "why"),
    [
        (MECANUM, {"max_speed": 1.0}, "no limits of speed or acceleration, so max_speed would"),
        (ACKERMANN, {"max_jerk": 1.0}, "so max_jerk would be lost"),
        (TRICYCLE, {"max_yaw_rate": 1.0}, "so max_yaw_rate would be lost"),
        (TRICYCLE, {"max_reverse_speed": 1.0}, "not max_reverse_speed"),
        (DIFFERENTIAL, {"max_deceleration": 1.0}, "only where max_acceleration is given"),
        (DIFFERENTIAL, {"max_reverse_speed": 1.0}, "only where max_speed is given"),
        (DIFFERENTIAL, {"max_spede": 1.0}, "did you mean 'max_speed'?"),
        (DIFFERENTIAL, {"max_speed": -1.0}, "max_speed must be positive, got -1 m/s"),
        (DIFFERENTIAL, {"timeout": 0.0}, "timeout must be positive and finite, got 0 s"),
        (DIFFERENTIAL, {"timeout": math.nan}, "timeout must be positive"),
        (DIFFERENTIAL, {"timeout": "1"}, "timeout must be a number [s], got '1'"),
        ("differential", {}, "give a Robot"),
    ],
)
def test_what_cannot_be_kept_is_refused(robot, given, why):
    with pytest.raises(trundle.TrundleError) as told:
        ros2_controllers(robot, **given)
    assert why in str(told.value)


WILD = ["int", "a b", "*/", "on"]


def test_wild_names_stay_texts_and_are_told():
    robot = dataclasses.replace(
        MECANUM,
        name='null: "#" \n- {',
        wheels=tuple(
            dataclasses.replace(w, name=n) for w, n in zip(MECANUM.wheels, WILD, strict=True)
        ),
    )
    text = ros2_controllers(robot)
    made = read(text)["mecanum_drive_controller"]["ros__parameters"]
    assert made["front_left_wheel_command_joint_name"] == "int_joint"
    assert made["front_right_wheel_command_joint_name"] == "a_b_joint"
    assert made["rear_left_wheel_command_joint_name"] == "wheel_joint"
    assert made["rear_right_wheel_command_joint_name"] == "on_joint"
    assert "wheel 'a b' is called a_b" in text
    assert largest_error(robot) < PRINTED


def test_a_wheels_name_stays_as_it_is_in_a_comment():
    text = ros2_controllers(changed(DIFFERENTIAL, "left", name="*/ \\"))
    assert r"wheel '*/ \' is called wheel" in text
    text = ros2_controllers(changed(DIFFERENTIAL, "left", name="a\n- b", reversed=True))
    assert r"backwards at 'a\x0a- b', which" in text


def test_wheels_that_are_not_in_the_file_are_not_told():
    caster = CasterWheel(name="ball & pin", x=0.1, y=0.0, radius=0.02)
    robot = dataclasses.replace(DIFFERENTIAL, wheels=(*DIFFERENTIAL.wheels, caster))
    assert ros2_controllers(robot) == ros2_controllers(DIFFERENTIAL)
    steered = changed(TRICYCLE, "front", name="front & only")
    assert "wheel 'front & only' is called front_only" in ros2_controllers(steered)


def every_text() -> Iterator[str]:
    for robot in FITTING.values():
        yield ros2_controllers(robot)
    yield ros2_controllers(DIFFERENTIAL, max_speed=1e-5, max_yaw_rate=1e22, timeout=1e-3)
    names = ["1e3", "null", "🤖", "a: [b]", "\ud800", "a\u2028b", "- x", "% &*!|>'\"@`"]
    for name in names:
        yield ros2_controllers(changed(DIFFERENTIAL, "left", name=name))


def test_a_yaml_reader_reads_the_same():
    yaml = pytest.importorskip("yaml")
    for text in every_text():
        assert yaml.safe_load(text.encode("utf-8")) == read(text)
        fast = getattr(importlib.import_module("yaml"), "CSafeLoader", None)  # libyaml, as in ROS
        if fast is not None:
            assert yaml.load(text.encode("utf-8"), Loader=fast) == read(text)


def test_doubles_have_a_point():
    """ROS tells 1 from 1.0: a whole number for a parameter that is a double is refused."""
    for text in every_text():
        for name, value in walk(read(text)):
            whole = name in ("update_rate",) or (
                name == "cmd_vel_timeout" and "tricycle_controller:" in text
            )
            if isinstance(value, int | float) and not isinstance(value, bool):
                assert isinstance(value, int) == whole, name


def walk(values: dict) -> Iterator[tuple[str, object]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from walk(value)
        else:
            yield name, value
