"""Bad and awkward input: near-singular layouts, any text in files, wrong shapes, broken files."""

import copy
import dataclasses
import math
import re
import tomllib
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import trundle
from catalogue import ROBOTS, each_robot, kinematics, seen_from, steering_for
from geometry import Floats, misfits, turning
from trundle import Kinematics, dead_reckon, mobility, simulate
from trundle.errors import (
    FileError,
    RobotError,
    ShapeError,
    TrundleError,
    UnobservedMotionError,
    UnobservedMotionWarning,
)
from trundle.odometry import score
from trundle.robot import (
    CATALOG,
    BallWheel,
    Body,
    CasterWheel,
    Encoder,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
    Wheel,
    from_catalog,
    json_schema,
    load,
    robot_from_dict,
    save,
    to_toml,
)

EPSILON = 2.3e-16
# A condition number multiplies the rounding of inputs; a few dozen operations add theirs.
OPERATIONS = 100
# Rows that differ by less than a millionth count as one (steering angles come from sensors), so a
# contact may miss what its wheel says by as much of the speed.
COUNTED_AS_ONE = 1e-5

bounded = settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])
few = settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])


# ---- near-singular layouts -----------------------------------------------------------------


@given(exponent=st.floats(-12.0, 0.0), twist=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
@bounded
def test_a_mecanum_robot_whose_yaw_arm_nearly_cancels(
    exponent: float, twist: tuple[float, float, float]
) -> None:
    arm = 10.0**exponent
    robot = load("mecanum_lecture", wheelbase=0.6, track=0.6 + 2 * arm)
    kin = Kinematics(robot)
    assert np.isfinite(kin.W).all()
    found = kin.inverse(twist)
    assert np.isfinite(found.wheel_speeds).all()
    lost = np.abs(found.residual).max() > 0 or mobility(robot).rank < 3
    if lost:
        assert arm < 1e-8  # only a motion that no geometry in a file can tell is given up
        assert mobility(robot).rank == 2
        np.testing.assert_allclose(found.residual, [0.0, 0.0, twist[2]], atol=1e-6)
        return
    size = np.abs(twist).max()
    back = kin.forward(found.wheel_speeds)
    assert np.abs(back - twist).max() <= OPERATIONS * EPSILON / arm * (size + 1e-300)


@given(
    exponent=st.floats(-12.0, 0.0),
    turn=st.sampled_from(["along", "across", "heading"]),
    sign=st.sampled_from([1.0, -1.0]),
)
@bounded
def test_axles_that_nearly_coincide(exponent: float, turn: str, sign: float) -> None:
    off = sign * 10.0**exponent
    third = FixedWheel(
        name="third",
        x=off if turn == "along" else 0.0,
        y=0.1 + (off if turn == "across" else 0.0),
        radius=0.05,
        heading=off if turn == "heading" else 0.0,
        driven=False,
    )
    robot = Robot(name="three", wheels=(*load("differential").wheels, third))
    kin, found = Kinematics(robot), mobility(robot)
    assert np.isfinite(kin.W).all()
    assert found.kind in ("(2,0)", "(1,0)")
    if turn == "across" or abs(off) < 1e-11:
        assert found.kind == "(2,0)"  # as if the third wheel were not there
    elif abs(off) > 1e-7:
        assert found.kind == "(1,0)"  # straight on, or round where the axles cross
    given_back = kin.inverse([0.4, 0.0, 0.3])
    worst = misfits(robot, given_back.twist, given_back.wheel_speeds)
    assert max(worst.values()) <= COUNTED_AS_ONE


@given(exponent=st.floats(-14.0, 0.0), twist=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
@few
def test_steered_wheels_near_one_spot(exponent: float, twist: tuple[float, float, float]) -> None:
    assume(np.abs(twist).max() > 1e-3)
    robot = load("two_steered", wheelbase=10.0**exponent)
    found = Kinematics(robot).inverse(twist)
    assert np.isfinite(found.wheel_speeds).all()
    assert np.isfinite(found.steering).all()
    np.testing.assert_allclose(found.twist + found.residual, twist, atol=1e-12)
    worst = misfits(robot, found.twist, found.wheel_speeds, found.steering)
    assert max(worst.values()) <= COUNTED_AS_ONE


def test_steered_wheels_on_one_spot() -> None:
    wheels = tuple(SteeredWheel(name=n, x=0.0, y=0.0, radius=0.1) for n in ("a", "b"))
    robot = Robot(name="twins", wheels=wheels)
    assert mobility(robot).kind == "(2,1)"
    found = Kinematics(robot).inverse([0.3, 0.4, 0.0])
    np.testing.assert_allclose(found.steering, math.atan2(0.4, 0.3))
    np.testing.assert_allclose(found.wheel_speeds, 5.0)


@given(
    robot=st.sampled_from(list(ROBOTS.values())),
    exponent=st.floats(-3.0, 3.0),
    twist=st.tuples(*[st.floats(-2.0, 2.0)] * 3),
)
@bounded
def test_robots_from_a_millimetre_to_a_kilometre(
    robot: Robot, exponent: float, twist: tuple[float, float, float]
) -> None:
    from catalogue import scaled

    assume(robot.name != "curved")
    size = 10.0**exponent
    other, asked = scaled(robot, size), np.array(twist) * [size, size, 1.0]
    found = Kinematics(other).inverse(asked)
    assert np.isfinite(found.wheel_speeds).all()
    assert np.isfinite(found.steering).all()
    speed = np.abs(asked).max() * max(1.0, other.reach) + 1e-300
    np.testing.assert_allclose(found.twist + found.residual, asked, atol=1e-12 * speed)
    worst = misfits(other, found.twist, found.wheel_speeds, found.steering)
    assert max(worst.values()) <= 1e-9 * speed
    assert mobility(other).kind == mobility(robot).kind


@given(
    robot=st.sampled_from(list(ROBOTS.values())),
    place=st.tuples(*[st.floats(-1e3, 1e3)] * 2),
    weights=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)
@bounded
def test_an_origin_far_away(
    robot: Robot, place: tuple[float, float], weights: tuple[float, float, float]
) -> None:
    assume(robot.name != "curved")
    assume(all(getattr(wheel, "track_factor", 1.0) == 1.0 for wheel in robot.wheels))
    near = kinematics(robot).inverse(weights).twist  # feasible, at the old origin
    u, v, r = near
    x, y = place
    moved = np.array([u - r * y, v + r * x, r])
    found = Kinematics(seen_from(robot, x, y, 0.0)).inverse(moved)
    # The far origin's lever arm hides the robot's own size in as many digits.
    lost = OPERATIONS * EPSILON * (1.0 + math.hypot(x, y)) ** 2
    np.testing.assert_allclose(found.twist, moved, atol=10 * lost * (1.0 + np.abs(moved).max()))


# ---- random layouts ------------------------------------------------------------------------

lengths = st.floats(-2.0, 2.0)
radii = st.floats(0.01, 0.5)
headings = st.sampled_from([0.0, math.pi / 2, math.pi, -math.pi / 4, 0.3, 1e-9]) | st.floats(-4, 4)
rollers = st.sampled_from([math.pi / 4, -math.pi / 4, 0.0]) | st.floats(-1.4, 1.4)
spots = st.tuples(lengths, lengths) | st.sampled_from([(0.0, 0.0), (0.5, 0.0), (0.5, 1e-12)])


@st.composite
def layouts(draw: st.DrawFn) -> Robot:
    """Draw any mixture of up to five wheels that steer alone or not at all."""
    wheels: list[Wheel] = []
    for i in range(draw(st.integers(1, 5))):
        (x, y), kind = draw(spots), draw(st.integers(0, 5))
        common: dict[str, Any] = {"name": str(i), "x": x, "y": y}
        rolling = common | {
            "radius": draw(radii),
            "heading": draw(headings),
            "reversed": draw(st.booleans()),
            "driven": draw(st.booleans()),
        }
        if kind == 0:
            wheels.append(FixedWheel(**rolling))
        elif kind == 1:
            wheels.append(SteeredWheel(**rolling))
        elif kind == 2:
            wheels.append(OmniWheel(**rolling))
        elif kind == 3:
            wheels.append(MecanumWheel(**rolling, roller=draw(rollers)))
        elif kind == 4:
            wheels.append(CasterWheel(**common, radius=draw(radii), trail=0.1))
        else:
            wheels.append(BallWheel(**common))
    return Robot(name="any", wheels=tuple(wheels))


@given(robot=layouts(), twist=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
def test_any_layout_gives_finite_answers_that_its_contacts_obey(
    robot: Robot, twist: tuple[float, float, float]
) -> None:
    kin, told = Kinematics(robot), mobility(robot)
    found = kin.inverse(twist)
    assert found.wheel_speeds.shape == (len(robot.driven),)
    assert found.steering.shape == (len(robot.steered),)
    for values in (found.wheel_speeds, found.steering, found.twist, found.residual):
        assert np.isfinite(values).all()
    assert 0 <= told.degree <= 3
    assert 0 <= told.rank <= 3
    assert told.maneuverability == told.degree + told.steerability
    assert told.reasons
    size = 4.0 * np.abs(twist).max()
    worst = misfits(robot, found.twist, found.wheel_speeds, found.steering)
    assert max(worst.values(), default=0.0) <= COUNTED_AS_ONE * (1.0 + size)
    again = kin.inverse(found.twist)
    np.testing.assert_allclose(again.twist, found.twist, atol=COUNTED_AS_ONE * (1.0 + size))
    bound = kin.bind().inverse(*twist)
    assert np.isfinite(bound).all()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnobservedMotionWarning)
        steering = found.steering if robot.steered else None
        assert np.isfinite(kin.forward(found.wheel_speeds, steering)).all()


@given(robot=layouts(), twist=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
def test_odometry_is_right_or_says_what_it_cannot_see(
    robot: Robot, twist: tuple[float, float, float]
) -> None:
    """An estimate either gives the motion back or is refused: never a silent guess."""
    kin = Kinematics(robot)
    found = kin.inverse(twist)
    steering = found.steering if robot.steered else None
    try:
        to_increment = kin.odometry_matrix(steering)
    except UnobservedMotionError:
        return
    turns = turning(robot, robot.sensed, found.twist, found.steering)
    given_back = to_increment @ turns
    condition = 1.0 + np.abs(to_increment).max(initial=0.0)
    size = 1.0 + np.abs(twist).max()
    np.testing.assert_allclose(given_back, found.twist, atol=1e-9 * condition * size)


def test_wheels_that_all_but_coincide_do_not_lead_the_search_astray() -> None:
    """A search for steering angles once ended in numbers that were none, and in a traceback."""
    wheels = (
        FixedWheel(name="0", x=0.5, y=0.0, driven=False, radius=0.5),
        FixedWheel(name="1", x=0.0, y=0.0, driven=False, radius=0.5, heading=math.pi / 2),
        SteeredWheel(name="2", x=0.5, y=1e-12, driven=False, radius=0.5),
    )
    found = Kinematics(Robot(name="any", wheels=wheels)).inverse([0.0, 0.0, 1.0])
    assert np.isfinite(np.concatenate([found.twist, found.steering])).all()


# ---- files: what is written comes back -----------------------------------------------------

texts = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12)
names = texts.filter(lambda text: bool(text.strip()))
sizes = st.floats(1e-6, 1e6)
places = st.floats(-1e6, 1e6)
angles = st.floats(-4.0, 4.0) | st.floats(-100.0, 100.0)


def maybe(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.none() | strategy


@st.composite
def valid_robots(draw: st.DrawFn, angles: st.SearchStrategy[float] = angles) -> Robot:
    """Draw any robot that a description may be."""
    wheels: list[Wheel] = []
    labels = draw(st.lists(names, min_size=1, max_size=4, unique=True))
    encoders = st.builds(Encoder, ticks_per_motor_turn=sizes, gear=sizes)
    for label in labels:
        common: dict[str, Any] = {"name": label, "x": draw(places), "y": draw(places)}
        rolling = common | {
            "radius": draw(sizes),
            "heading": draw(angles),
            "reversed": draw(st.booleans()),
            "driven": draw(maybe(st.booleans())),
            "measured": draw(maybe(st.booleans())),
            "encoder": draw(maybe(encoders)),
            "max_speed": draw(maybe(sizes)),
            "max_acceleration": draw(maybe(sizes)),
        }
        kind = draw(st.integers(0, 5))
        if kind == 0:
            skid = draw(st.booleans())
            factor = draw(st.floats(1.0, 3.0)) if skid else 1.0
            wheels.append(FixedWheel(**rolling, skid=skid, track_factor=factor))
        elif kind == 1:
            group = draw(maybe(names))
            low, high = sorted([draw(angles), draw(angles)])
            wheels.append(
                SteeredWheel(
                    **rolling,
                    steering_group=group,
                    steering_ratio=draw(st.sampled_from([1.0, -1.0, 0.3])) if group else 1.0,
                    steering_min=draw(maybe(st.just(low))),
                    steering_max=draw(maybe(st.just(high))),
                    steering_rate=draw(maybe(st.floats(1e-3, 100.0))),
                )
            )
        elif kind == 2:
            wheels.append(OmniWheel(**rolling, roller=draw(st.floats(-1.5, 1.5))))
        elif kind == 3:
            wheels.append(MecanumWheel(**rolling, roller=draw(st.floats(-1.5, 1.5))))
        elif kind == 4:
            more = {"radius": draw(sizes), "trail": draw(maybe(sizes)), "heading": draw(angles)}
            wheels.append(CasterWheel(**common, **more))
        else:
            wheels.append(BallWheel(**common, radius=draw(maybe(sizes))))
    body = st.builds(Body, length=sizes, width=sizes, x=places, y=places)
    return Robot(name=draw(names), wheels=tuple(wheels), body=draw(maybe(body)))


@given(robot=valid_robots())
@settings(max_examples=120, suppress_health_check=[HealthCheck.too_slow])
def test_a_robot_written_to_toml_comes_back_equal(robot: Robot) -> None:
    assert robot_from_dict(tomllib.loads(to_toml(robot))) == robot


@given(robot=valid_robots(angles=st.floats(-1e5, 1e5)))
@few
def test_angles_of_many_turns_come_back_equal(robot: Robot) -> None:
    assert robot_from_dict(tomllib.loads(to_toml(robot))) == robot


@pytest.mark.parametrize("heading", [9000.0, -12345.678, 54321.0])
def test_an_angle_of_thousands_of_turns_comes_back_equal(heading: float) -> None:
    for k in range(50):
        wheel = FixedWheel(name="a", x=0.0, y=0.0, radius=1.0, heading=heading + 0.1 * k)
        robot = Robot(name="r", wheels=(wheel,))
        assert robot_from_dict(tomllib.loads(to_toml(robot))) == robot


@given(degrees=st.floats(-360.0, 360.0).map(lambda value: round(value, 9)))
def test_degrees_in_a_file_come_back_as_they_were_written(degrees: float) -> None:
    wheel = {"name": "a", "kind": "fixed", "x": 0, "y": 0, "radius": 1, "heading_deg": degrees}
    text = to_toml(robot_from_dict({"name": "r", "wheel": [wheel]}))
    assert tomllib.loads(text)["wheel"][0].get("heading_deg", 0.0) == degrees


@given(robot=valid_robots())
@few
def test_a_saved_file_comes_back_equal(robot: Robot, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.mktemp("robots") / "robot.toml"
    assert load(save(robot, path)) == robot


@each_robot
def test_every_robot_of_the_tests_comes_back_equal(robot: Robot, tmp_path: Path) -> None:
    assert load(save(robot, tmp_path / "robot.toml")) == robot


@pytest.mark.parametrize(
    "name", ['say "hi"', "back\\slash", "two\nlines", "tab\there", "\u0000", "\x7f", "日本 🤖", "'"]
)
def test_awkward_names_come_back(name: str, tmp_path: Path) -> None:
    wheel = SteeredWheel(name=name, x=0.0, y=0.0, radius=1.0, steering_group=name)
    robot = Robot(name=name, wheels=(wheel,))
    assert load(save(robot, tmp_path / "robot.toml")) == robot


def test_half_a_character_is_refused_in_words(tmp_path: Path) -> None:
    """Text with a lone surrogate (from a broken JSON, say) cannot stand in a UTF-8 file."""
    with pytest.raises(TrundleError):
        save(
            Robot(name="\ud800", wheels=(BallWheel(name="a", x=0.0, y=0.0),)),
            tmp_path / "robot.toml",
        )


# ---- files: what is wrong comes out in words -----------------------------------------------

scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.integers(10**300, 10**310)
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["fixed", "steered", "mecanum", "swedish", "caster", "omni", "ball"])
)
garbage = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=4)
    ),
    max_leaves=8,
)
KEYS = (
    "name", "kind", "x", "y", "heading_deg", "radius", "roller_deg", "reversed", "driven", "trail",
    "encoder", "steering_group", "steering_ratio", "steering_min_deg", "steering_max_deg", "skid",
    "track_factor", "max_speed", "measured", "steering_rate_deg", "colour", "heading",
)  # fmt: skip
GOOD_WHEEL = {"name": "a", "kind": "fixed", "x": 0.1, "y": 0.2, "radius": 0.1}


@given(data=st.dictionaries(st.sampled_from(["name", "body", "wheel", "x"]), garbage))
@bounded
def test_any_garbage_gives_a_robot_error(data: dict[str, Any]) -> None:
    with pytest.raises(RobotError) as caught:
        robot_from_dict(data)
    assert caught.value.faults


@given(
    kind=st.sampled_from(["fixed", "steered", "omni", "mecanum", "swedish", "caster", "ball"]),
    changes=st.dictionaries(st.sampled_from(KEYS), garbage, min_size=1, max_size=5),
    body=garbage,
)
@settings(max_examples=200, suppress_health_check=[HealthCheck.too_slow])
def test_a_wheel_with_garbage_is_a_robot_or_a_robot_error(
    kind: str, changes: dict[str, Any], body: Any
) -> None:
    wheel = GOOD_WHEEL | {"kind": kind} | changes
    before = copy.deepcopy(wheel)
    faults: tuple[str, ...] = ()
    try:
        robot_from_dict({"name": "r", "wheel": [wheel, GOOD_WHEEL | {"name": "z"}], "body": body})
    except RobotError as error:
        faults = error.faults
    assert len(set(faults)) == len(faults), "each fault is told once"
    assert all(fault.strip() for fault in faults)
    assert repr(wheel) == repr(before)


@given(
    text=st.text(max_size=60) | st.sampled_from(["[[wheel]]", "a = ", "name = 'x'\n[[wheel]]\n"])
)
@few
def test_any_text_in_a_file_gives_an_error_in_words(text: str, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.mktemp("garbage") / "robot.toml"
    path.write_text(text, encoding="utf-8", errors="replace")
    with pytest.raises((FileError, RobotError)) as caught:
        load(path)
    assert str(path) in str(caught.value)


@given(data=st.binary(max_size=60))
@few
def test_any_bytes_in_a_file_give_an_error_in_words(data: bytes, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.mktemp("garbage") / "robot.toml"
    path.write_bytes(data)
    with pytest.raises((FileError, RobotError)):
        load(path)


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    """Notepad on Windows writes one."""
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xef\xbb\xbf" + to_toml(ROBOTS["omni3"]).encode())
    assert load(path) == ROBOTS["omni3"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name = ", "not valid TOML"),
        ("[[wheel]\n", "not valid TOML"),
        ("name = 'a'\nname = 'b'\n", "not valid TOML"),
        ("", "at least one wheel"),
        ("wheel = 3", "write [[wheel]] above each"),
        ("wheel = [1]", "wheel 1 must be a table"),
        ("a = " + "[" * 4000 + "]" * 4000, "TOML"),
        ("[[wheel]]\nkind = 'fixed'\nx = " + "9" * 400, "x"),
        ("x = " + "9" * 5000, "TOML"),
    ],
    ids=["cut", "bracket", "twice", "empty", "number", "list", "deep", "huge", "too huge"],
)
def test_broken_files(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((FileError, RobotError), match=re.escape(told)) as caught:
        load(path)
    assert str(path) in str(caught.value)


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_bytes(b"name = '\xff\xfe'")
    with pytest.raises(FileError, match=r"robot\.toml: the file must be UTF-8 text"):
        load(path)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read"):
        load(tmp_path)


@pytest.mark.parametrize("name", ["missing.toml", "no/such/folder/robot.toml", "x" * 300 + ".toml"])
def test_a_file_that_is_not_there(name: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read"):
        load(tmp_path / name)


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b.toml", "a\0b", "", "."])
def test_a_name_that_no_file_can_have(name: str) -> None:
    with pytest.raises(FileError):
        load(name)


@pytest.mark.parametrize("thing", [None, 3, 2.5, b"omni3", ["omni3"]], ids=repr)
def test_a_name_must_be_a_text_or_a_path(thing: Any) -> None:
    with pytest.raises(TrundleError):
        load(thing)


def test_a_name_that_is_nearly_right_is_guessed() -> None:
    with pytest.raises(FileError, match=r"no robot 'mecanun': did you mean 'mecanum'\?"):
        load("mecanun")
    with pytest.raises(FileError, match="Give the path of a TOML file or one of differential, tri"):
        load("qwertz")


def test_a_robot_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be written"):
        save(ROBOTS["omni3"], tmp_path / "no" / "folder.toml")
    with pytest.raises(FileError, match="cannot be written"):
        save(ROBOTS["omni3"], tmp_path)


@pytest.mark.parametrize("data", [None, [], 3, "text", [GOOD_WHEEL]], ids=repr)
def test_a_description_must_be_a_table(data: Any) -> None:
    with pytest.raises(RobotError):
        robot_from_dict(data)


def test_keys_that_are_no_texts() -> None:
    with pytest.raises(RobotError):
        robot_from_dict({"name": "r", "wheel": [GOOD_WHEEL], 3: 4})
    with pytest.raises(RobotError):
        robot_from_dict({"name": "r", "wheel": [GOOD_WHEEL | {3: 4}]})


# ---- the faults of a description -----------------------------------------------------------


def faults_of(*wheels: dict[str, Any], **others: Any) -> tuple[str, ...]:
    with pytest.raises(RobotError) as caught:
        robot_from_dict({"name": "r", "wheel": list(wheels)} | others)
    return caught.value.faults


WRONG = {
    "negative radius": ({"radius": -0.05}, "wheel 'a': radius must be positive, got -0.05 m"),
    "zero radius": ({"radius": 0}, "wheel 'a': radius must be positive, got 0 m"),
    "nan": ({"x": math.nan}, "wheel 'a': x must be finite, got nan"),
    "inf": ({"y": -math.inf}, "wheel 'a': y must be finite, got -inf"),
    "text": ({"x": "1.0"}, "wheel 'a': x must be a number [m], got '1.0'"),
    "true": ({"x": True}, "wheel 'a': x must be a number [m], got True"),
    "degrees": (
        {"heading_deg": "north"}, "wheel 'a': heading_deg must be a number [deg], got 'north'"
    ),
    "flag": ({"reversed": 1}, "wheel 'a': reversed must be true or false, got 1"),
    "kind": (
        {"kind": "round"},
        "wheel 'a': kind must be one of fixed, steered, caster, omni, mecanum, ball, swedish; "
        "got 'round'",
    ),
    "typo": ({"radios": 0.1}, "wheel 'a': unknown key 'radios': did you mean 'radius'?"),
    "radians": ({"heading": 1}, "wheel 'a': unknown key 'heading': did you mean 'heading_deg'?"),
    "not of the kind": (
        {"trail": 0.1}, "wheel 'a': key 'trail' does not belong to fixed wheels, only to caster"
    ),
    "roller at 90 deg": (
        {"kind": "mecanum", "roller_deg": 90},
        "wheel 'a': roller_deg must not be 90 deg: the roller would turn freely along the drive "
        "direction and the wheel could not push, got 90 deg",
    ),
    "roller at -90 deg": (
        {"kind": "omni", "roller_deg": -90},
        "wheel 'a': roller_deg must not be 90 deg: the roller would turn freely along the drive "
        "direction and the wheel could not push, got -90 deg",
    ),
    "no roller": ({"kind": "mecanum"}, "wheel 'a': roller_deg is missing"),
    "no swedish roller": ({"kind": "swedish"}, "wheel 'a': roller_deg is missing"),
    "driven caster": (
        {"kind": "caster", "driven": True},
        "wheel 'a': driven must be false: a driven caster is not supported",
    ),
    "steering limits": (
        {"kind": "steered", "steering_min_deg": 30, "steering_max_deg": -30},
        "wheel 'a': steering_min_deg must not exceed the largest angle, got 30 and -30 deg",
    ),
    "ratio alone": (
        {"kind": "steered", "steering_ratio": 2},
        "wheel 'a': steering_ratio needs a steering_group",
    ),
    "ratio zero": (
        {"kind": "steered", "steering_ratio": 0, "steering_group": "g"},
        "wheel 'a': steering_ratio must not be zero",
    ),
    "track factor": (
        {"skid": True, "track_factor": 0.5},
        "wheel 'a': track_factor must be at least 1, got 0.5",
    ),
    "track factor without skid": (
        {"track_factor": 1.5}, "wheel 'a': track_factor belongs to wheels with skid = true"
    ),
    "encoder": (
        {"encoder": 64},
        "wheel 'a': encoder must be a table such as { ticks_per_motor_turn = 64, gear = 43.7 }, "
        "got 64",
    ),
    "empty encoder": ({"encoder": {}}, "wheel 'a': encoder.ticks_per_motor_turn is missing"),
    "ticks": (
        {"encoder": {"ticks_per_motor_turn": 0}},
        "wheel 'a': encoder.ticks_per_motor_turn must be positive, got 0 ticks",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("change", "told"), WRONG.values(), ids=WRONG)
def test_each_fault_in_words(change: dict[str, Any], told: str) -> None:
    assert faults_of(GOOD_WHEEL | change) == (told,)


@pytest.mark.parametrize("key", ["name", "x", "y", "radius", "kind"])
def test_each_missing_key_in_words(key: str) -> None:
    wheel = {k: v for k, v in GOOD_WHEEL.items() if k != key}
    (told,) = faults_of(wheel)
    assert key in told
    assert "missing" in told
    assert told.startswith("wheel 1" if key == "name" else "wheel 'a'")


def test_all_faults_at_once_each_with_wheel_and_key() -> None:
    faults = faults_of(
        GOOD_WHEEL | {"radius": -1, "colour": "red", "reversed": "no"},
        {"kind": "mecanum", "x": "far", "y": 0, "radius": 0.1, "roller_deg": 90},
        {"name": "c", "kind": "wheel"},
        GOOD_WHEEL | {"name": "d", "heading_deg": math.inf},
        body={"length": 0.5, "mass": -1, "colour": 3},
        colour=1,
    )
    text = "\n".join(faults)
    for told in (
        "wheel 'a': radius must be positive",
        "wheel 'a': unknown key 'colour'",
        "wheel 'a': reversed must be true or false",
        "wheel 2: name is missing",
        "wheel 2: x must be a number [m], got 'far'",
        "wheel 2: roller_deg must not be 90 deg",
        "wheel 'c': kind must be one of",
        "wheel 'd': heading_deg must be finite, got inf",
        "body: mass must be positive, got -1 kg",
        "body: unknown key 'colour'",
        "body: width is missing",
        "unknown key 'colour'",
    ):
        assert told in text
    assert len(faults) == 12


def test_one_name_for_two_wheels_is_told_beside_other_faults() -> None:
    faults = faults_of(GOOD_WHEEL, GOOD_WHEEL | {"radius": -1})
    assert "wheel 'a': radius must be positive, got -1 m" in faults
    assert any("'a': the name is used 2 times" in fault for fault in faults)


def test_one_name_for_two_wheels() -> None:
    assert faults_of(GOOD_WHEEL, GOOD_WHEEL) == (
        "wheel 'a': the name is used 2 times; names must differ",
    )


@pytest.mark.parametrize("name", ["", "   ", 3, ["a"], None])
def test_a_robot_without_a_name_says_so_once(name: Any) -> None:
    faults = faults_of(GOOD_WHEEL, name=name)
    assert len(faults) == 1
    assert faults[0].startswith("name ")


def test_a_list_of_no_wheels() -> None:
    for wheels in ([], ()):
        with pytest.raises(RobotError, match="robot 'r': a robot needs at least one wheel"):
            Robot(name="r", wheels=wheels)
    with pytest.raises(RobotError, match="at least one wheel"):
        robot_from_dict({"name": "r", "wheel": []})
    with pytest.raises(RobotError, match="at least one wheel"):
        robot_from_dict({"name": "r"})


def test_swedish_is_another_name_for_omni_and_mecanum() -> None:
    base = {"name": "a", "x": 0.3, "y": 0.1, "radius": 0.1}
    for roller, kind in ((0, "omni"), (0.0, "omni"), (45, "mecanum"), (-30, "mecanum")):
        swedish = robot_from_dict(
            {"name": "r", "wheel": [base | {"kind": "swedish", "roller_deg": roller}]}
        )
        plain = robot_from_dict(
            {"name": "r", "wheel": [base | {"kind": kind, "roller_deg": roller}]}
        )
        assert swedish == plain
        assert swedish.wheels[0].kind == kind


NOT_IN_PYTHON = {
    "encoder": lambda: FixedWheel(name="a", x=0, y=0, radius=1, encoder=5),  # type: ignore[arg-type]
    "steering group": lambda: SteeredWheel(name="a", x=0, y=0, radius=1, steering_group=3),  # type: ignore[arg-type]
    "body": lambda: Robot(name="r", wheels=(BallWheel(name="a", x=0, y=0),), body=3),  # type: ignore[arg-type]
    "wheels none": lambda: Robot(name="r", wheels=None),  # type: ignore[arg-type]
    "wheels one": lambda: Robot(name="r", wheels=BallWheel(name="a", x=0, y=0)),  # type: ignore[arg-type]
    "wheels other": lambda: Robot(name="r", wheels=("wheel",)),  # type: ignore[arg-type]
    "name": lambda: BallWheel(name=3, x=0, y=0),  # type: ignore[arg-type]
    "huge": lambda: BallWheel(name="a", x=10**400, y=0),
    "huge angle": lambda: FixedWheel(name="a", x=0, y=0, radius=1, heading=1e308),
    "complex": lambda: BallWheel(name="a", x=1j, y=0),  # type: ignore[arg-type]
    "array": lambda: BallWheel(name="a", x=np.zeros(2), y=0),  # type: ignore[arg-type]
    "catalogue angles": lambda: load("omni", angles="abc"),
    "catalogue angle": lambda: load("omni", angles=3),
    "catalogue no angles": lambda: load("omni", angles=[]),
    "catalogue nan": lambda: load("omni", angles=[0.0, math.nan]),
    "catalogue positions": lambda: load("swerve", positions=[(1,)]),
    "catalogue position": lambda: load("swerve", positions=[1, 2]),
    "catalogue text": lambda: load("omni3", radius="0.1"),
    "catalogue negative": lambda: load("omni3", radius=-0.1),
    "catalogue negative track": lambda: load("differential", track=-0.4),
    "catalogue inf": lambda: load("mecanum", wheelbase=math.inf),
    "catalogue no such size": lambda: load("mecanum", colour=3),
    "no such field": lambda: load("mecanum").with_wheels(colour=3),
    "field of no wheel": lambda: load("mecanum").with_wheels(radius=-1.0),
}


@pytest.mark.parametrize("make", NOT_IN_PYTHON.values(), ids=NOT_IN_PYTHON)
def test_what_python_cannot_build_either(make: Callable[[], object]) -> None:
    with pytest.raises(RobotError):
        make()


def test_numbers_of_numpy_are_numbers() -> None:
    robot = load("differential", track=np.float64(0.5), radius=np.float32(0.25))
    assert robot.wheels[0].y == 0.25
    assert load("differential", track=np.int64(1)).wheels[0].y == 0.5


def test_an_unknown_size_names_the_sizes() -> None:
    with pytest.raises(
        RobotError, match=r"catalogue robot 'omni3': no size 'colour'; it has radius, arm"
    ):
        from_catalog("omni3", colour=3)


def test_a_canonical_angle_keeps_its_rule() -> None:
    """An angle that rounds to 0 deg on the grid of a file is no positive one."""
    with pytest.raises(RobotError, match="steering_rate must be positive"):
        SteeredWheel(name="a", x=0.0, y=0.0, radius=1.0, steering_rate=1e-15)


def test_places_beyond_all_robots_break_nothing() -> None:
    robot = Robot(name="r", wheels=(SteeredWheel(name="a", x=1e200, y=0.0, radius=1.0),))
    assert robot.reach == pytest.approx(1e200)


def test_the_schema_knows_the_keys_of_every_kind() -> None:
    """Editors complete with it: TOML's keys are those that the reader takes."""
    text = repr(json_schema())
    for key in ("heading_deg", "roller_deg", "steering_group", "trail", "ticks_per_motor_turn"):
        assert key in text
    assert "'heading'" not in text


@pytest.mark.parametrize("name", CATALOG)
def test_every_catalogue_robot_meets_the_schema_of_its_kind(name: str) -> None:
    from trundle.robot.schema import robot_model

    robot_model().model_validate(tomllib.loads(to_toml(load(name))))


# ---- wrong shapes to every public function -------------------------------------------------

CAR, CART, OMNI = ROBOTS["ackermann"], ROBOTS["differential"], ROBOTS["omni3"]
TWO = np.zeros((2, 2))

CALLS: dict[str, tuple[str, Callable[[Any], object]]] = {
    "forward": ("wheel_speeds", lambda bad: kinematics(OMNI).forward(bad)),
    "forward of a car": ("steering", lambda bad: kinematics(CAR).forward([1.0, 1.0], bad)),
    "residual": ("wheel_speeds", lambda bad: kinematics(OMNI).residual(bad)),
    "residual of a car": ("steering", lambda bad: kinematics(CAR).residual([1.0, 1.0], bad)),
    "inverse": ("twist", lambda bad: kinematics(OMNI).inverse(bad)),
    "inverse of a car": ("twist", lambda bad: kinematics(CAR).inverse(bad)),
    "inverse about": ("about", lambda bad: kinematics(OMNI).inverse([1.0, 0, 0], about=bad)),
    "inverse with steering": (
        "steering", lambda bad: kinematics(CAR).inverse([1.0, 0.0, 0.0], steering=bad)
    ),
    "wheel_matrix": ("steering", lambda bad: kinematics(CAR).wheel_matrix(bad)),
    "constraints": ("steering", lambda bad: kinematics(CAR).constraints(bad)),
    "odometry_matrix": ("steering", lambda bad: kinematics(CAR).odometry_matrix(bad)),
    "rolling_speeds": ("twist", lambda bad: kinematics(OMNI).rolling_speeds(bad)),
    "rolling_speeds of a car": (
        "steering",
        lambda bad: kinematics(CAR).rolling_speeds([1.0, 0.0, 0.0], bad),
    ),
    "left_inverse": ("steering", lambda bad: kinematics(CAR).left_inverse(bad)),
    "right_inverse": ("steering", lambda bad: kinematics(CAR).right_inverse(bad)),
    "dead_reckon": ("wheel_increments", lambda bad: dead_reckon(OMNI, bad)),
    "dead_reckon a car": ("steering", lambda bad: dead_reckon(CAR, TWO, steering=bad)),
    "dead_reckon from": ("pose", lambda bad: dead_reckon(CART, TWO, pose=bad)),
    "simulate": ("wheel_speeds", lambda bad: simulate(OMNI, wheel_speeds=bad, duration=1.0)),
    "simulate a twist": ("twist", lambda bad: simulate(CAR, twist=bad, duration=1.0)),
    "simulate a car": (
        "steering", lambda bad: simulate(CAR, wheel_speeds=[1.0, 1.0], steering=bad, duration=1.0)
    ),
    "simulate from": (
        "pose", lambda bad: simulate(CART, wheel_speeds=[1.0, 1.0], duration=1.0, pose=bad)
    ),
    "score": ("poses", lambda bad: score(bad, np.zeros((2, 3)))),
    "score against": ("truth", lambda bad: score(np.zeros((2, 3)), bad)),
}  # fmt: skip
BAD: dict[str, Any] = {
    "a text": "abc",
    "a scalar": 1.0,
    "nothing": [],
    "too long": np.zeros(17),
    "wrong rows": np.zeros((4, 17)),
    "nan": [math.nan] * 3,
    "inf": [[math.inf] * 3] * 2,
    "ragged": [[1.0, 2.0], [3.0]],
    "texts": [["a", "b", "c"]],
    "a table": {"u": 1.0},
    "an object": object(),
    "four axes of nothing": np.zeros((0, 0, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize("bad", BAD.values(), ids=BAD)
@pytest.mark.parametrize(("parameter", "call"), CALLS.values(), ids=CALLS)
def test_wrong_input_names_the_parameter(
    parameter: str, call: Callable[[Any], object], bad: Any
) -> None:
    with pytest.raises(TrundleError, match=rf"\b{parameter}\b"):
        call(bad)


def test_batches_that_do_not_go_together() -> None:
    speeds, angles = np.ones((4, 2)), np.zeros((5, 2))
    with pytest.raises(ShapeError, match="steering"):
        kinematics(CAR).forward(speeds, angles)
    with pytest.raises(ShapeError, match="steering"):
        kinematics(CAR).residual(speeds, angles)
    with pytest.raises(ShapeError, match="steering"):
        kinematics(CAR).inverse(np.ones((4, 3)), steering=angles)
    with pytest.raises(ShapeError, match="steering"):
        kinematics(CAR).rolling_speeds(np.ones((4, 3)), angles)
    with pytest.raises(ShapeError, match="about"):
        kinematics(OMNI).inverse(np.ones((4, 3)), about=np.zeros((4, 2)))
    with pytest.raises(ShapeError, match="steering"):
        dead_reckon(CAR, np.ones((4, 2)), steering=np.zeros((5, 2)))
    with pytest.raises(ShapeError, match="steering"):
        dead_reckon(CAR, np.ones((4, 2)), steering=np.zeros((1, 4, 2)))
    with pytest.raises(TrundleError, match="truth"):
        score(np.zeros((1, 3)), np.zeros((5, 3)))


def test_steering_given_to_a_robot_without_steering() -> None:
    with pytest.raises(ShapeError, match="steering of a robot without steering must have 0 values"):
        kinematics(OMNI).forward([1.0, 1.0, 1.0], [0.1])


def test_messages_of_wrong_shapes() -> None:
    with pytest.raises(
        ShapeError, match=r"wheel_speeds must have 3 values on the last axis, got shape \(2,\)"
    ):
        kinematics(OMNI).forward([1.0, 2.0])
    with pytest.raises(ShapeError, match="twist must be finite numbers, got nan or inf"):
        kinematics(OMNI).inverse([0.0, math.nan, 0.0])
    with pytest.raises(ShapeError, match="twist must be an array of numbers, got 'fast'"):
        kinematics(OMNI).inverse("fast")
    with pytest.raises(
        ShapeError, match=r"shape \(T, 3\), one column for each sensed wheel \(wheel_1,"
    ):
        dead_reckon(OMNI, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("shape", [(0, 3), (2, 0, 3)], ids=str)
@each_robot
def test_batches_of_nothing_give_nothing(robot: Robot, shape: tuple[int, ...]) -> None:
    found = kinematics(robot).inverse(np.zeros(shape))
    assert found.wheel_speeds.shape == (*shape[:-1], len(robot.driven))
    assert found.steering.shape == (*shape[:-1], len(robot.steered))
    steering = found.steering if robot.steered else None
    twist = kinematics(robot).forward(found.wheel_speeds, steering)
    assert twist.shape == shape
    assert kinematics(robot).inverse(np.zeros(shape), strict=True).residual.shape == shape


def test_every_error_is_one_of_ours() -> None:
    """One base class, and ValueError above it, so that callers may catch either."""
    from trundle import errors

    kinds = [
        kind
        for kind in vars(errors).values()
        if isinstance(kind, type) and issubclass(kind, Exception) and not issubclass(kind, Warning)
    ]
    assert all(issubclass(kind, TrundleError) for kind in kinds)
    assert issubclass(TrundleError, ValueError)


def test_kinematics_of_what_is_no_robot() -> None:
    with pytest.raises(TrundleError):
        Kinematics("omni3")  # type: ignore[arg-type]


def test_robots_and_wheels_cannot_be_changed() -> None:
    for item, name in ((ROBOTS["omni3"], "name"), (ROBOTS["omni3"].wheels[0], "radius")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(item, name, 3)


def test_twists_given_as_whole_numbers_are_numbers() -> None:
    whole: Floats = kinematics(OMNI).inverse([1, 0, 2]).wheel_speeds
    np.testing.assert_array_equal(whole, kinematics(OMNI).inverse([1.0, 0.0, 2.0]).wheel_speeds)
    assert steering_for(CAR, np.array([1.0, 0.0, 0.0])).tolist() == [0.0, 0.0]
    assert trundle.load("omni3") == OMNI
