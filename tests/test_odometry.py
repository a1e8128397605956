"""Odometry: exact arcs, dead wheels, what is not seen, logs of every form, and recorded robots."""

import dataclasses
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from catalogue import CURVED, ROBOTS, each_robot, feasible_twists, steering_for
from geometry import Floats, turning
from trundle import Kinematics, dead_reckon, simulate
from trundle.errors import FileError, TrundleError, UnobservedMotionError
from trundle.odometry import READINGS, read_log, score
from trundle.robot import CasterWheel, Encoder, FixedWheel, OmniWheel, Robot
from trundle.simulation import write_log

# Sums of some hundred steps of numbers near 1, each rounded at 1e-16.
ROUNDING = 1e-12
START = (0.4, -0.3, 1.1)


def follow(moves: Floats, start: tuple[float, float, float] = START) -> Floats:
    """Return the poses along body increments (T, 3), each an arc: complex numbers, a plain loop."""
    z, psi = complex(start[0], start[1]), start[2]
    poses = [start]
    for dx, dy, dpsi in moves:
        chord = (np.exp(1j * dpsi) - 1) / (1j * dpsi) if dpsi else 1.0
        z += np.exp(1j * psi) * complex(dx, dy) * chord
        psi += dpsi
        poses.append((z.real, z.imag, psi))
    return np.array(poses)


# ---- dead reckoning ------------------------------------------------------------------------


def test_a_differential_drive_on_a_circle_by_hand() -> None:
    """Rims of 0.9 and 1.1 m on a track of 0.4 m: an arc of radius 2 m through 0.5 rad per row."""
    robot = trundle.load("differential", radius=0.1, track=0.4)
    poses = dead_reckon(robot, [[9.0, 11.0]] * 7, pose=(1.0, 2.0, 0.0))
    angles = 0.5 * np.arange(8)
    np.testing.assert_allclose(poses[:, 0], 1.0 + 2.0 * np.sin(angles), atol=ROUNDING)
    np.testing.assert_allclose(poses[:, 1], 2.0 + 2.0 * (1 - np.cos(angles)), atol=ROUNDING)
    np.testing.assert_allclose(poses[:, 2], angles, atol=ROUNDING)


@each_robot
@pytest.mark.parametrize("size", [0.05, 1.0, 30.0])
def test_every_robot_finds_its_way_back(robot: Robot, size: float) -> None:
    """Turns of the sensed wheels straight from geometry; arcs straight from complex numbers."""
    moves = size * feasible_twists(robot, (25,), seed=61)
    steering = steering_for(robot, feasible_twists(robot, (25,), seed=61))
    turns = np.array(
        [
            turning(robot, robot.sensed, move, angles)
            for move, angles in zip(moves, steering, strict=True)
        ]
    )
    poses = dead_reckon(robot, turns, steering if robot.steered else None, START)
    np.testing.assert_allclose(poses, follow(moves), atol=100 * ROUNDING * (1 + size))


@each_robot
def test_the_way_back_ends_at_the_start(robot: Robot) -> None:
    twist = feasible_twists(robot, (), seed=62)
    steering = steering_for(robot, twist)
    turns = np.outer(np.linspace(0.1, 0.4, 9), turning(robot, robot.sensed, twist, steering))
    both = np.concatenate([turns, -turns[::-1]])
    poses = dead_reckon(robot, both, steering if robot.steered else None, START)
    np.testing.assert_allclose(poses[-1], START, atol=ROUNDING)
    np.testing.assert_allclose(poses, poses[::-1], atol=ROUNDING)


def test_one_steering_angle_holds_for_all_rows() -> None:
    robot = ROBOTS["tricycle"]
    one = dead_reckon(robot, [[1.0]] * 5, steering=[0.3])
    rows = dead_reckon(robot, [[1.0]] * 5, steering=[[0.3]] * 5)
    np.testing.assert_array_equal(one, rows)


def test_no_rows_are_no_motion() -> None:
    np.testing.assert_array_equal(
        dead_reckon(ROBOTS["omni3"], np.zeros((0, 3)), pose=START), [START]
    )
    np.testing.assert_array_equal(
        dead_reckon(ROBOTS["tricycle"], np.zeros((0, 1)), np.zeros((0, 1)), START), [START]
    )


def dead_wheel(name: str, x: float, y: float, degrees: float) -> OmniWheel:
    return OmniWheel(
        name=name,
        x=x,
        y=y,
        heading=math.radians(degrees),
        radius=0.03,
        driven=False,
        encoder=Encoder(ticks_per_motor_turn=8192),
    )


def on_casters(*wheels: Any) -> Robot:
    return Robot(
        name="pushed", wheels=(CasterWheel(name="caster", x=0.0, y=0.0, radius=0.02), *wheels)
    )


def test_three_dead_wheels_see_a_robot_that_is_pushed() -> None:
    """Two ahead at y = +-0.15 and one across at x = -0.2: u = mean, r = difference / 0.3."""
    robot = on_casters(
        dead_wheel("left", 0.0, 0.15, 0),
        dead_wheel("right", 0.0, -0.15, 0),
        dead_wheel("back", -0.2, 0.0, 90),
    )
    left, right, back = 1.0, 1.6, -0.4
    u, r = 0.03 * (left + right) / 2, 0.03 * (right - left) / 0.3
    v = 0.03 * back + 0.2 * r
    poses = dead_reckon(robot, [[left, right, back]] * 4, pose=START)
    np.testing.assert_allclose(poses, follow(np.tile([u, v, r], (4, 1))), atol=ROUNDING)


def test_dead_wheels_of_a_mixture_count_with_its_driven_ones() -> None:
    """Order of the robot's wheels: two mecanum, then two dead wheels; one bad one is outvoted."""
    robot = ROBOTS["mixed"]
    assert [wheel.name for wheel in robot.sensed] == [
        "front_left", "front_right", "dead_left", "dead_right",
    ]  # fmt: skip
    turns = turning(robot, robot.sensed, (0.3, 0.2 * 0.5, 0.5))  # no side slip behind: v = 0.2 r
    poses = dead_reckon(robot, [turns], pose=START)
    np.testing.assert_allclose(poses, follow(np.array([[0.3, 0.1, 0.5]])), atol=ROUNDING)
    slipped = dead_reckon(robot, [turns + np.eye(4)[0]], pose=START)
    way = np.hypot(*(slipped[-1] - poses[-1])[:2])
    assert 0 < way < 0.05 / 2  # a slip of one rim by 0.05 m moves the estimate by less than half


def unobserved(robot: Robot, **more: Any) -> str:
    with pytest.raises(UnobservedMotionError) as caught:
        dead_reckon(robot, np.zeros((3, len(robot.sensed))), **more)
    return str(caught.value)


def test_too_few_sensed_wheels_name_the_motion_that_is_not_seen() -> None:
    cart = trundle.load("differential", track=0.4)
    wheels = [
        dataclasses.replace(wheel, measured=False) if wheel.name == "right" else wheel
        for wheel in cart.wheels
    ]
    told = unobserved(dataclasses.replace(cart, wheels=tuple(wheels)))
    assert "robot 'differential': the sensed wheels ('left') do not observe" in told
    assert "turning about the point (0, 0.2) m" in told
    assert "add an encoder" in told


@pytest.mark.parametrize(
    ("robot", "motions"),
    [
        (on_casters(), ["straight forward and back", "straight sideways", "turning on the spot"]),
        (on_casters(dead_wheel("a", 0.0, 0.0, 0)), ["straight sideways", "turning on the spot"]),
        (
            on_casters(dead_wheel("a", 0.0, 0.1, 0), dead_wheel("b", 0.0, -0.1, 0)),
            ["straight sideways"],
        ),
        (
            on_casters(dead_wheel("a", 0.0, 0.0, 0), dead_wheel("b", 0.0, 0.0, 90)),
            ["turning on the spot"],
        ),
        (trundle.load("mecanum_lecture", wheelbase=0.6, track=0.6), ["turning on the spot"]),
    ],
    ids=["none", "one", "parallel", "crossed", "mecanum"],
)
def test_each_motion_that_is_not_seen_is_named(robot: Robot, motions: list[str]) -> None:
    told = unobserved(robot)
    for motion in motions:
        assert motion in told


def test_a_bicycle_across_does_not_see_its_turning() -> None:
    bicycle = ROBOTS["bicycle"]
    assert "turning on the spot" in unobserved(bicycle, steering=[math.pi / 2])
    rows = [[0.1], [math.pi / 2], [0.2]]  # one row is enough
    assert "turning on the spot" in unobserved(bicycle, steering=rows)


def test_a_steered_wheels_angle_counts_with_weight_one() -> None:
    """Two rims and a front angle that disagree: a compromise, by hand.

    Bicycle with rear rim 1 m, front rim c: minimise (u - 1)^2 + (u cos b + r L sin b - c)^2 +
    (-u sin b + r L cos b)^2 over u and r L.
    """
    robot = trundle.load("bicycle", radius=1.0, wheelbase=1.0).with_wheels(measured=True)
    b, c = 0.4, 1.3
    rows = np.array([[1, 0], [math.cos(b), math.sin(b)], [-math.sin(b), math.cos(b)]])
    u, r = np.linalg.lstsq(rows, np.array([1.0, c, 0.0]), rcond=None)[0]
    assert [wheel.name for wheel in robot.sensed] == ["front", "rear"]
    poses = dead_reckon(robot, [[c, 1.0]], steering=[b], pose=START)
    np.testing.assert_allclose(poses, follow(np.array([[u, 0.0, r]])), atol=ROUNDING)


def test_the_x_drive_with_reversed_wheels_comes_home() -> None:
    """A square driven by model.md's wheel speeds: v_i = u sin th - v cos th - w R."""
    radius, arm = 0.05, 0.2
    th = np.radians([45.0, 315.0, 135.0, 225.0])
    legs = [(1.0, 0, 0), (0, 1.0, 0), (-1.0, 0, 0), (0, -1.0, 0), (0, 0, 2 * math.pi)]
    turns = [(u * np.sin(th) - v * np.cos(th) - w * arm) / radius for u, v, w in legs]
    poses = dead_reckon(trundle.load("omni4", radius=radius, arm=arm), turns)
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0), (0, 0)]
    np.testing.assert_allclose(poses[:, :2], corners, atol=ROUNDING)
    np.testing.assert_allclose(poses[-1, 2], 2 * math.pi, atol=ROUNDING)


# ---- logs ----------------------------------------------------------------------------------

ENCODER = Encoder(ticks_per_motor_turn=100, gear=2)  # pi / 100 rad for each tick
PER_TICK = math.pi / 100
CART = Robot(
    name="cart",
    wheels=(
        FixedWheel(name="left", x=0.0, y=0.2, radius=0.1, encoder=ENCODER),
        FixedWheel(name="right", x=0.0, y=-0.2, radius=0.1, encoder=ENCODER),
    ),
)
TICKS = np.array([[5, 10], [-3, 4], [0, 7], [20, -20]])
TIMES = [0.0, 0.1, 0.2, 0.4, 0.5]
STEPS = np.diff(TIMES)[:, None]


def running(steps: Floats, start: float = 0.0) -> Floats:
    return np.concatenate([[[start, start]], start + np.cumsum(steps, axis=0)])


def since(steps: Floats) -> Floats:
    return np.concatenate([[[77.0, 77.0]], steps])  # what the first row carries does not count


FORMS: dict[str, Floats] = {
    "counts": running(TICKS, start=1000),
    "ticks": since(TICKS),
    "angle": running(TICKS * PER_TICK, start=3.0),
    "radians": since(TICKS * PER_TICK),
    "turns": since(TICKS / 200),
    "speed": since(TICKS * PER_TICK / STEPS),
    "rpm": since(TICKS / 200 / (STEPS / 60)),
}


def lines(reading: str, values: Floats, delimiter: str = ",", **columns: Any) -> str:
    header = ["time", f"{reading}:left", f"{reading}:right", *columns]
    rows = [
        [repr(float(cell)) for cell in (time, *row, *(column[k] for column in columns.values()))]
        for k, (time, row) in enumerate(zip(TIMES, values, strict=True))
    ]
    return "".join(delimiter.join(cells) + "\n" for cells in [header, *rows])


@pytest.fixture
def log_file(tmp_path: Path) -> Callable[..., Path]:
    def write(text: str, encoding: str = "utf-8") -> Path:
        path = tmp_path / "log.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return write


WriteLog = Callable[..., Path]


@pytest.mark.parametrize("reading", READINGS)
def test_every_kind_of_reading_gives_the_same_turns(reading: str, log_file: WriteLog) -> None:
    assert set(FORMS) == set(READINGS)
    log = read_log(log_file(lines(reading, FORMS[reading])), CART)
    np.testing.assert_allclose(log.wheel_increments, TICKS * PER_TICK, atol=ROUNDING)
    np.testing.assert_array_equal(log.time, TIMES)
    assert log.truth is None
    assert log.steering is None


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_delimiters_marks_and_line_ends(
    delimiter: str, encoding: str, newline: str, log_file: WriteLog
) -> None:
    text = lines("ticks", FORMS["ticks"], delimiter).replace("\n", newline)
    log = read_log(log_file(text + newline, encoding), CART)
    np.testing.assert_allclose(log.wheel_increments, TICKS * PER_TICK, atol=ROUNDING)


def test_spaces_and_quotes_do_no_harm(log_file: WriteLog) -> None:
    text = 'time , "ticks:left", ticks:right\n 0, 0 ,0\n"0.1",1, 2\n'
    log = read_log(log_file(text.replace(', "', ',"')), CART)
    np.testing.assert_allclose(log.wheel_increments, [[PER_TICK, 2 * PER_TICK]], atol=ROUNDING)


@pytest.mark.parametrize("first", [0, 65_530, 32_760])
@pytest.mark.parametrize("signed", [False, True])
def test_counters_of_sixteen_bits_wrap_around(first: int, signed: bool, log_file: WriteLog) -> None:
    """Over the top and under the bottom, 0 to 65535 or -32768 to 32767."""
    counts = np.mod(running(TICKS * 1000, start=first), 65_536)
    if signed:
        counts = np.where(counts >= 32_768, counts - 65_536, counts)
    path = log_file(lines("counts", counts))
    log = read_log(path, CART, counter_bits=16)
    np.testing.assert_allclose(log.wheel_increments, TICKS * 1000 * PER_TICK, atol=1e-9)
    if np.abs(np.diff(counts, axis=0)).max() > 32_768:
        with pytest.raises(FileError, match=r"leaps by .* ticks in one row; say counter_bits=16"):
            read_log(path, CART)
    with pytest.raises(FileError, match="which no counter of 8 bits does"):
        read_log(path, CART, counter_bits=8)


def test_a_counter_of_32_bits_that_wraps_is_told(log_file: WriteLog) -> None:
    """A wheel that turns back from 0 counts 4294967295; of 33 bits, such a row is a row."""
    back = np.mod(running(-TICKS), 2**32)
    path = log_file(lines("counts", back))
    with pytest.raises(FileError, match=r"leaps by 42949.* ticks in one row; say counter_bits=32"):
        read_log(path, CART)
    log = read_log(path, CART, counter_bits=32)
    np.testing.assert_allclose(log.wheel_increments, -TICKS * PER_TICK, atol=1e-9)
    read_log(log_file(lines("counts", back + 2**32)), CART)


def test_a_file_without_a_header(log_file: WriteLog) -> None:
    path = log_file("0,9,0,0\n0.1,9,1,2\n0.2,9,3,4\n")
    log = read_log(path, CART, columns=["time", "-", "ticks:right", "ticks:left"])
    np.testing.assert_allclose(log.wheel_increments, np.array([[2, 1], [4, 3]]) * PER_TICK)
    with pytest.raises(
        FileError, match=r"no header: name its columns \(--columns\), such as time,x,y,psi,ticks"
    ):
        read_log(path, CART)
    with pytest.raises(FileError, match="line 1 has 4 cells, but there are 3 columns"):
        read_log(path, CART, columns=["time", "ticks:left", "ticks:right"])


@pytest.mark.parametrize("heading", ["psi", "psi_deg"])
def test_truth_is_read_with_the_log(heading: str, log_file: WriteLog) -> None:
    x, y, psi = np.arange(5.0), np.arange(5.0) / 3, np.linspace(-1.0, 1.0, 5)
    shown = np.degrees(psi) if heading == "psi_deg" else psi
    log = read_log(log_file(lines("ticks", FORMS["ticks"], x=x, y=y, **{heading: shown})), CART)
    assert log.truth is not None
    np.testing.assert_allclose(log.truth, np.stack([x, y, psi], axis=-1), atol=ROUNDING)


def test_half_a_truth_is_refused(log_file: WriteLog) -> None:
    path = log_file(lines("ticks", FORMS["ticks"], x=np.zeros(5), y=np.zeros(5)))
    with pytest.raises(FileError, match=r"truth needs x, y and psi \(or psi_deg\); only x, y are"):
        read_log(path, CART)


def test_columns_are_renamed(log_file: WriteLog) -> None:
    path = log_file("t,enc_l,enc_r\n0,0,0\n1,3,4\n")
    rename = {"time": "t", "ticks:left": "enc_l", "ticks:right": "enc_r"}
    log = read_log(path, CART, rename=rename)
    np.testing.assert_allclose(log.wheel_increments, np.array([[3, 4]]) * PER_TICK)
    with pytest.raises(FileError, match=r"no column 'encl'; it has t, enc_l, enc_r"):
        read_log(path, CART, rename={"ticks:left": "encl"})


@pytest.mark.parametrize("order", [("left", "right"), ("right", "left")])
def test_two_columns_may_change_their_names(order: tuple[str, str], log_file: WriteLog) -> None:
    """Left and right were swapped when the robot was wired."""
    values = {"left": "3", "right": "4"}
    header = ",".join(f"ticks:{name}" for name in order)
    row = ",".join(values[name] for name in order)
    path = log_file(f"{header}\n0,0\n{row}\n")
    rename = {"ticks:left": "ticks:right", "ticks:right": "ticks:left"}
    log = read_log(path, CART, rename=rename)
    np.testing.assert_allclose(log.wheel_increments, np.array([[4, 3]]) * PER_TICK)


def test_steering_is_read_in_radians_or_degrees(log_file: WriteLog) -> None:
    tricycle = ROBOTS["tricycle"]
    for name, values in (("steering:front", "0.5"), ("steering_deg:front", "28.64788975654116")):
        path = log_file(f"radians:front,{name}\n0,0\n1,{values}\n2,{values}\n")
        log = read_log(path, tricycle)
        assert log.steering is not None
        np.testing.assert_allclose(log.steering, [[0.5], [0.5]], atol=ROUNDING)
    with pytest.raises(
        FileError,
        match=r"no column for the steering angle of wheel 'front': name it steering:front",
    ):
        read_log(log_file("radians:front\n0\n1\n"), tricycle)


WRONG: dict[str, tuple[str, str]] = {
    "empty": ("", r"log\.csv: .*(empty|no header|two rows)"),
    "header only": ("time,ticks:left,ticks:right\n", "a log needs at least two rows, got 0"),
    "one row": ("time,ticks:left,ticks:right\n0,0,0\n", "a log needs at least two rows, got 1"),
    "missing column": (
        "time,ticks:left\n0,0\n1,1\n",
        "no column for wheel 'right': name one READING:right, where READING is counts, ticks, .*; "
        "the file has time, ticks:left",
    ),
    "column that is nearly right": (
        "time,ticks:left,right\n0,0,0\n1,1,1\n",
        r"Is it 'right'\? Then --map ticks:right=right",
    ),
    "text": (
        "time,ticks:left,ticks:right\n0,0,0\n1,1,2\n2,one,3\n",
        "line 4, column 'ticks:left': 'one' is not a finite number",
    ),
    "empty cell": (
        "time,ticks:left,ticks:right\n0,0,0\n1,,2\n",
        "line 3, column 'ticks:left': '' is not a finite number",
    ),
    "nan": (
        "time,ticks:left,ticks:right\n0,0,0\n1,1,nan\n",
        "line 3, column 'ticks:right': 'nan' is not a finite number",
    ),
    "inf": (
        "time,ticks:left,ticks:right\n0,0,0\ninf,1,2\n",
        "line 3, column 'time': 'inf' is not a finite number",
    ),
    "decimal comma": (
        "time;ticks:left;ticks:right\n0;0;0\n0,1;1;2\n",
        "line 3, column 'time': '0,1' is not a finite number",
    ),
    "digits of Python": (
        "time,ticks:left,ticks:right\n0,0,0\n1,1_0,2\n",
        "line 3, column 'ticks:left': '1_0' is not a finite number",
    ),
    "time backwards": (
        "time,ticks:left,ticks:right\n0,0,0\n2,1,1\n1.5,1,1\n",
        "time goes backwards in line 4: 1.5 s after 2 s",
    ),
    "ragged": (
        "time,ticks:left,ticks:right\n0,0,0\n1,1\n",
        r"line 3 has 2 cells, but there are 3 columns \(time, ticks:left, ticks:right\)",
    ),
    "twice": (
        "time,ticks:left,ticks:left,ticks:right\n0,0,0,0\n1,1,1,1\n",
        "the column 'ticks:left' is there 2 times",
    ),
    "speed without time": (
        "speed:left,speed:right\n0,0\n1,1\n",
        "column 'speed:left' is a speed, which needs a time column",
    ),
    "a quote that never ends": (
        'time,ticks:left,ticks:right\n0,0,0\n"1,1,1\n' + "2,2,2\n" * 30_000,
        r"log\.csv",
    ),
}


@pytest.mark.parametrize(("text", "told"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_with_a_log_in_words(text: str, told: str, log_file: WriteLog) -> None:
    path = log_file(text)
    with pytest.raises(FileError, match=told) as caught:
        read_log(path, CART)
    assert str(path) in str(caught.value)


def test_ticks_need_an_encoder(log_file: WriteLog) -> None:
    with pytest.raises(
        FileError, match="holds ticks, but wheel 'left' has no encoder: add encoder ="
    ):
        read_log(log_file(lines("ticks", FORMS["ticks"])), ROBOTS["differential"])


def test_a_robot_without_sensed_wheels_has_no_log(log_file: WriteLog) -> None:
    with pytest.raises(TrundleError, match="has no sensed wheel"):
        read_log(log_file(lines("ticks", FORMS["ticks"])), on_casters())


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read"):
        read_log(tmp_path / "missing.csv", CART)
    with pytest.raises(FileError, match="cannot be read"):
        read_log(tmp_path, CART)
    (tmp_path / "latin.csv").write_bytes(b"time,ticks:l\xe9ft\n0,0\n1,1\n")
    with pytest.raises(FileError, match="must be UTF-8 text"):
        read_log(tmp_path / "latin.csv", CART)


def test_time_may_stand_still(log_file: WriteLog) -> None:
    log = read_log(log_file("time,ticks:left,ticks:right\n0,0,0\n0,1,1\n1,1,1\n"), CART)
    assert log.wheel_increments.shape == (2, 2)


# A tick turns a wheel by 2 pi / 2048 at most, so that the path is known to a few of them.
@pytest.mark.parametrize("bits", [None, 12])
@pytest.mark.parametrize("name", ["mixed", "tricycle", "omni4", "swerve", "odd_differential"])
def test_a_run_written_as_a_log_is_reckoned_to_the_same_path(
    name: str, bits: int | None, tmp_path: Path
) -> None:
    robot = ROBOTS[name]
    twists = np.repeat(feasible_twists(robot, (10,), seed=63), 20, axis=0)
    run = simulate(robot, twist=twists, dt=0.02, pose=START)
    path = write_log(robot, run, tmp_path / "log.csv", counter_bits=bits)
    log = read_log(path, robot, counter_bits=bits)
    assert log.truth is not None
    poses = dead_reckon(robot, log.wheel_increments, log.steering, START)
    within = 0.01 if any(wheel.encoder for wheel in robot.sensed) else 1e-9
    np.testing.assert_allclose(poses, run.pose, atol=within)
    np.testing.assert_allclose(log.truth, run.pose, atol=ROUNDING)


# ---- score ---------------------------------------------------------------------------------


def test_the_score_by_hand() -> None:
    """Truth is the path turned by a small angle about its start: both are 7 m long."""
    off, poses = 0.06, np.array([[0, 0, 0], [3, 0, 0.1], [3, 4, 0.2]])
    turned = (poses[:, 0] + 1j * poses[:, 1]) * np.exp(1j * off)
    truth = np.stack([turned.real, turned.imag, [0, 0.1 - 2 * math.pi, 0.5]], axis=-1)
    found = score(poses, truth)
    apart = 2 * math.sin(off / 2)  # for each metre from the start: 0, 3 and 5 m
    assert found.distance == pytest.approx(7.0)
    assert found.end_error == pytest.approx(5 * apart)
    assert found.end_percent == pytest.approx(100 * 5 * apart / 7)
    assert found.rms_error == pytest.approx(apart * math.sqrt((9 + 25) / 3))
    assert found.end_heading_error == pytest.approx(-0.3)
    assert found.rms_heading_error == pytest.approx(math.sqrt(0.09 / 3))


def test_the_percentage_is_of_the_way_that_the_robot_went() -> None:
    """An estimate that is half too short is 50 % off, not 100 % of itself."""
    truth = np.stack([np.linspace(0, 10, 101), np.zeros(101), np.zeros(101)], axis=-1)
    assert score(truth * [0.5, 1.0, 1.0], truth).end_percent == pytest.approx(50.0)


def test_noise_of_the_measured_positions_does_not_lengthen_the_way() -> None:
    """A camera's millimetre at 100 Hz: the sum of its steps would be many times the way."""
    noise = np.random.default_rng(64).normal(scale=1e-3, size=(2001, 2))
    path = np.stack([np.linspace(0, 2, 2001), np.zeros(2001), np.zeros(2001)], axis=-1)
    truth = path + np.column_stack([noise, np.zeros(2001)])
    assert score(path, truth).distance == pytest.approx(2.0, rel=0.05)


def test_a_path_that_goes_nowhere_has_no_percentage() -> None:
    assert math.isnan(score([[0, 0, 0]] * 3, [[0, 0, 0]] * 3).end_percent)


# ---- recorded robots -----------------------------------------------------------------------

DATA = Path(os.environ.get("TRUNDLE_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
needs_data = pytest.mark.skipif(
    not (DATA / "optiodom").is_dir(),
    reason="the recorded robots are not there; TRUNDLE_DATA names their folder",
)
POSE = ["time", "x", "y", "psi"]


def recorded_cart() -> Robot:
    encoder = Encoder(ticks_per_motor_turn=64, gear=43.7)
    wheels = tuple(
        FixedWheel(name=name, x=0.0, y=y, radius=0.042, encoder=encoder)
        for name, y in (("right", -0.1), ("left", 0.1))
    )
    return Robot(name="recorded", wheels=wheels)


def recorded_mecanum() -> Robot:
    """The authors' wheels: l1 + l2 = 0.42 m over both sides, the right side counts backwards."""
    robot = trundle.load("mecanum", radius=0.03, wheelbase=0.21, track=0.21)
    wheels = tuple(
        dataclasses.replace(wheel, reversed=wheel.name.endswith("right")) for wheel in robot.wheels
    )
    return dataclasses.replace(robot, wheels=wheels)


def end_percents(robot: Robot, folder: str, readings: list[str]) -> list[float]:
    found = []
    for path in sorted((DATA / "optiodom" / folder).glob("*_run-*.csv")):
        log = read_log(path, robot, columns=POSE + readings)
        assert log.truth is not None
        poses = dead_reckon(robot, log.wheel_increments, pose=log.truth[0])
        found.append(score(poses, log.truth).end_percent)
    return found


@needs_data
def test_six_circles_of_a_differential_robot_with_nominal_geometry() -> None:
    ends = end_percents(
        recorded_cart(), "diff/circular/231220200121", ["ticks:right", "ticks:left"]
    )
    assert len(ends) == 6
    assert np.mean(ends) <= 1.3
    assert np.max(ends) <= 2.0  # none is far from the others


@needs_data
def test_two_half_circles_that_turn_either_way() -> None:
    robot, folder = recorded_cart(), "diff/circular/231220200157"
    assert max(end_percents(robot, folder, ["ticks:right", "ticks:left"])) <= 3.0
    turned = []
    for path in sorted((DATA / "optiodom" / folder).glob("*_run-*.csv")):
        log = read_log(path, robot, columns=[*POSE, "ticks:right", "ticks:left"])
        poses = dead_reckon(robot, log.wheel_increments)
        turned.append(poses[-1, 2])
        # The textbook's half-track formulas on the raw ticks.
        right, left = (math.tau / (64 * 43.7) * 0.042 * np.loadtxt(path, delimiter=",")[1:, 4:]).T
        moves = np.stack([(right + left) / 2, 0 * left, (right - left) / 0.2], axis=-1)
        np.testing.assert_allclose(poses, follow(moves, (0.0, 0.0, 0.0)), atol=1e-9)
    assert turned == pytest.approx([-math.pi, math.pi], abs=0.1)


# What plain least squares with nominal geometry reaches, in % of the measured way; the way's length
# depends a little on how the noise of the measured positions is kept out of it.
YARDSTICK, WAY = 11.8, 0.2


@needs_data
def test_twelve_squares_of_a_mecanum_robot_with_nominal_geometry() -> None:
    robot = recorded_mecanum()
    ends = end_percents(
        robot, "mecanum/square/231220200521", [f"turns:{wheel.name}" for wheel in robot.wheels]
    )
    assert len(ends) == 12
    assert np.mean(ends) == pytest.approx(YARDSTICK, abs=WAY)


@needs_data
def test_the_recorded_mecanum_robot_follows_its_authors_map() -> None:
    """1/4 [[1, -1, 1, -1], [-1, -1, 1, 1], -2 / (l1 + l2) [1, 1, 1, 1]] of the rim ways."""
    robot = recorded_mecanum()
    arm = 0.42
    theirs = np.array([[1, -1, 1, -1], [-1, -1, 1, 1], [-2 / arm] * 4]) / 4
    np.testing.assert_allclose(Kinematics(robot).W, 0.03 * theirs, atol=ROUNDING)
    path = DATA / "optiodom/mecanum/square/231220200521/231220200521_run-01.csv"
    log = read_log(path, robot, columns=POSE + [f"turns:{wheel.name}" for wheel in robot.wheels])
    turns = np.loadtxt(path, delimiter=",")[1:, 4:]
    moves = (2 * math.pi * 0.03 * turns) @ theirs.T
    poses = dead_reckon(robot, log.wheel_increments)
    np.testing.assert_allclose(poses, follow(moves, (0.0, 0.0, 0.0)), atol=1e-9)


def test_the_curved_robot_is_among_those_that_are_reckoned() -> None:
    assert CURVED in ROBOTS.values()
