"""Pictures and animations: facts are read from what is drawn, not from pixels."""

import dataclasses
import itertools
import math
import shutil
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from trundle import load
from trundle.errors import FileError, OffCentreError, ShapeError, TrundleError
from trundle.robot import (
    CATALOG,
    BallWheel,
    CasterWheel,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    Robot,
    RollingWheel,
    SteeredWheel,
    SwedishWheel,
)
from trundle.simulation import simulate
from trundle.view import animate, plot_eta, plot_layout, plot_path, plot_reachable, save
from trundle.view.labels import renderer_of
from trundle.view.motion import at_times
from trundle.view.shapes import rollers, treads

# Outlines are a few products of sines and cosines.
ROUNDING = 1e-9
# A reachable set over all steering angles is traced by 720 rays and a projection per ray.
TRACED = 1e-4
# What a slide or a page is glad to hold.
LARGEST_GIF = 3_000_000

# ---- reading what is drawn --------------------------------------------------------------------


def artist(figure: Figure, gid: str):
    found = [each for each in figure.findobj() if each.get_gid() == gid]
    assert len(found) == 1, f"{len(found)} artists {gid!r}"
    return found[0]


def gids(figure: Figure, part: str) -> list[str]:
    return [g for each in figure.findobj() if (g := each.get_gid()) and g.startswith(part + ":")]


def corners(figure: Figure, gid: str) -> np.ndarray:
    return artist(figure, gid).get_xy()[:-1]


def drive_arrow(figure: Figure, name: str) -> np.ndarray:
    arrow = artist(figure, f"drive:{name}")
    return np.subtract(arrow.xy, arrow.xyann)


def direction(line: np.ndarray) -> float:
    """Return the direction of a line through two points, in [0, pi)."""
    dx, dy = line[-1] - line[0]
    return math.atan2(dy, dx) % math.pi


def same_line(first: float, second: float) -> bool:
    return abs(math.remainder(first - second, math.pi)) < ROUNDING


def note(figure: Figure) -> str:
    return artist(figure, "note").get_text()


@pytest.fixture(scope="module")
def layouts() -> dict[str, Figure]:
    return {name: plot_layout(load(name)) for name in CATALOG}


# ---- layout -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CATALOG)
def test_wheels_are_drawn_where_they_are_and_true_to_size(layouts, name):
    robot = load(name)
    for wheel in robot.wheels:
        drawn = corners(layouts[name], f"wheel:{wheel.name}")
        x, y = wheel.x, wheel.y
        if isinstance(wheel, CasterWheel):  # the pivot is given, the contact trails behind it
            x -= wheel.trail * math.cos(wheel.heading)
            y -= wheel.trail * math.sin(wheel.heading)
        assert drawn.mean(axis=0) == pytest.approx((x, y), abs=ROUNDING)
        side = drawn[1] - drawn[0]
        assert np.hypot(*side) == pytest.approx(2 * wheel.radius, abs=ROUNDING)
        assert math.atan2(side[1], side[0]) == pytest.approx(
            math.remainder(wheel.heading, 2 * math.pi), abs=ROUNDING
        )


@pytest.mark.parametrize("name", CATALOG)
def test_every_wheel_shows_what_its_kind_has(layouts, name):
    figure, robot = layouts[name], load(name)
    for wheel in robot.wheels:
        swedish = isinstance(wheel, SwedishWheel)
        assert (f"roller:{wheel.name}" in gids(figure, "roller")) == swedish
        pivoted = isinstance(wheel, SteeredWheel | CasterWheel)
        assert (f"pivot:{wheel.name}" in gids(figure, "pivot")) == pivoted
        assert (f"force:{wheel.name}" in gids(figure, "force")) == wheel.driven
        arrowed = wheel.driven or wheel.sensed
        assert (f"drive:{wheel.name}" in gids(figure, "drive")) == arrowed


@pytest.mark.parametrize("name", CATALOG)
def test_names_cover_neither_wheels_nor_each_other(layouts, name):
    figure, robot = layouts[name], load(name)
    axes = figure.axes[0]
    wanted = [f"label:{w.name}" for w in robot.wheels] + ["label:frame:x", "label:frame:y"]
    boxes = {gid: artist(figure, gid).get_window_extent(renderer_of(axes)) for gid in wanted}
    for gid, box in boxes.items():
        assert axes.get_window_extent().contains(box.x0, box.y0), f"{gid} leaves the axes"
        assert axes.get_window_extent().contains(box.x1, box.y1), f"{gid} leaves the axes"
        for other, second in boxes.items():
            assert other == gid or not box.overlaps(second), f"{gid} covers {other}"
        for wheel in robot.wheels:
            patch = artist(figure, f"wheel:{wheel.name}")
            path = patch.get_path().transformed(patch.get_transform())
            assert not path.intersects_bbox(box, filled=True), f"{gid} covers {wheel.name}"


@pytest.mark.parametrize("name", CATALOG)
def test_titles_and_legends_stay_on_the_page(layouts, name):
    for figure in (layouts[name], plot_reachable(load(name))):
        renderer = renderer_of(figure.axes[0])
        texts = [artist(figure, "title"), artist(figure, "note")]
        texts += [legend for axes in figure.axes if (legend := axes.get_legend())]
        for text in texts:
            box = text.get_window_extent(renderer)
            assert figure.bbox.contains(box.x0, box.y0)
            assert figure.bbox.contains(box.x1, box.y1)


def long_axis(points: np.ndarray) -> float:
    """Return the direction of a barrel, in [0, pi)."""
    values, vectors = np.linalg.eigh(np.cov(points.T))
    return math.atan2(*vectors[::-1, np.argmax(values)]) % math.pi


@pytest.mark.parametrize("slant", [-60, -45, 0, 30, 45, 135])
def test_the_roller_on_the_ground_lies_along_its_axis(slant):
    wheel = MecanumWheel(name="w", x=0, y=0, radius=0.1, roller=math.radians(slant))
    below, above = rollers(wheel)[0], rollers(wheel, side="top")[0]
    assert same_line(long_axis(below), math.radians(slant))
    # Half a turn about the axle keeps the axle's coordinate and turns the other one round.
    assert same_line(long_axis(above), -math.radians(slant))


def test_rollers_stay_on_their_wheel():
    for slant in range(-85, 86, 5):
        wheel = MecanumWheel(name="w", x=0, y=0, radius=0.1, roller=math.radians(slant))
        points = np.vstack([*rollers(wheel, 0.3).values()])
        # A slanted barrel has flat ends, which may stand out by a hair.
        assert np.abs(points[:, 0]).max() < 1.05 * wheel.radius
        assert np.abs(points[:, 1]).max() < 0.45 * wheel.radius


@pytest.mark.parametrize(
    "parts",
    [
        lambda turn, side: rollers(OmniWheel(name="w", x=0, y=0, radius=0.1), turn, side),
        lambda turn, side: treads(FixedWheel(name="w", x=0, y=0, radius=0.1), turn, side),
    ],
    ids=["rollers", "treads"],
)
def test_a_wheel_that_turns_forward_moves_its_top_forward_and_its_ground_side_back(parts):
    for side, way in (("top", 1), ("ground", -1)):
        before, after = parts(0.0, side), parts(0.2, side)
        moved = [after[k].mean(axis=0) - before[k].mean(axis=0) for k in before.keys() & after]
        assert len(moved) >= 3
        assert all(way * step[0] > 0 for step in moved)
        assert np.abs(np.array(moved)[:, 1]).max() < ROUNDING


def test_arrows_show_the_way_of_positive_motor_speed(layouts):
    # Lecture: wheel 1 at (l, 0) drives along +y; the exercise's spins the other way round.
    assert drive_arrow(layouts["omni3"], "wheel_1")[1] > 0
    assert drive_arrow(layouts["omni3_exercise"], "wheel_1")[1] < 0
    # Slides: front left at 45 deg, tangential (heading 135 deg), reversed: towards -45 deg.
    way = drive_arrow(layouts["omni4"], "front_left")
    assert math.atan2(way[1], way[0]) == pytest.approx(-math.pi / 4, abs=ROUNDING)


def test_force_lines_run_along_the_roller_axis_through_the_contact(layouts):
    for name, slant in (("front_left", -45), ("front_right", 45), ("rear_left", 45)):
        line = artist(layouts["mecanum"], f"force:{name}").get_xydata()
        assert same_line(direction(line), math.radians(slant))
        wheel = next(w for w in load("mecanum").wheels if w.name == name)
        assert line.mean(axis=0) == pytest.approx((wheel.x, wheel.y), abs=ROUNDING)


def test_zero_lines_belong_to_the_wheels_that_cannot_slip_sideways(layouts):
    assert gids(layouts["mecanum"], "zero") == []
    assert gids(layouts["skid_steer"], "zero") == []
    line = artist(layouts["differential"], "zero:left").get_xydata()
    assert np.abs(line[:, 0]).max() < ROUNDING  # the axle: x = 0
    assert set(gids(layouts["tricycle"], "zero")) == {
        "zero:front", "zero:rear_left", "zero:rear_right",
    }  # fmt: skip


# Wheelbase 2.6 m and track 1.5 m; u / r = 4 m puts the centre at (0, 4); the front axle's wheels
# stand across the lines to it: tan = 2.6 / (4 -+ 0.75).
def test_the_instantaneous_centre_of_a_car():
    figure = plot_layout(load("ackermann"), twist=[1.0, 0.0, 0.25])
    marker = artist(figure, "centre").get_xydata()[0]
    assert marker == pytest.approx((0, 4), abs=ROUNDING)
    for name, y in (("front_left", 0.75), ("front_right", -0.75)):
        side = np.subtract(*corners(figure, f"wheel:{name}")[[1, 0]])
        assert math.atan2(side[1], side[0]) == pytest.approx(math.atan2(2.6, 4 - y), abs=ROUNDING)
        line = artist(figure, f"centre:{name}").get_xydata()
        assert line[0] == pytest.approx((0, 4), abs=ROUNDING)
        assert line[1] == pytest.approx((2.6, y), abs=ROUNDING)
    assert gids(figure, "zero") == []
    low, high = figure.axes[0].get_ylim()
    assert low < 4 < high


def test_the_centre_of_a_motion_with_side_velocity():
    # Where u - r y = 0 and v + r x = 0.
    figure = plot_layout(load("swerve"), twist=[0.3, 0.1, 1.0])
    assert artist(figure, "centre").get_xydata()[0] == pytest.approx((-0.1, 0.3), abs=ROUNDING)


def test_the_steering_angle_alone_gives_a_tricycles_centre():
    # (0, L / tan(beta)), Siegwart and Nourbakhsh, section 3.3.3; L = 0.8 m.
    figure = plot_layout(load("tricycle"), steering=[math.radians(-40)])
    marker = artist(figure, "centre").get_xydata()[0]
    assert marker == pytest.approx((0, -0.8 / math.tan(math.radians(40))), abs=1e-6)


def test_a_centre_far_away_is_told_and_does_not_shrink_the_robot():
    figure = plot_layout(load("ackermann"), twist=[1.0, 0.0, 0.02])
    assert "centre" not in [each.get_gid() for each in figure.findobj()]
    words = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert any("(0, 50) m" in text and "outside the picture" in text for text in words)
    assert np.ptp(figure.axes[0].get_ylim()) < 5


def test_wheels_without_a_common_centre_are_told():
    assert "share no centre" in note(plot_layout(load("ackermann"), steering=[0.4, -0.4]))
    assert "infinity" in note(plot_layout(load("ackermann"), steering=[0.0, 0.0]))
    sideways = plot_layout(load("differential"), twist=[0.0, 1.0, 1.0])
    words = [text.get_text() for text in sideways.axes[0].get_legend().get_texts()]
    assert any("slip sideways" in text for text in words)


def test_a_caster_trails_behind_its_pivot_in_the_motion_shown():
    # Backwards: the contact, 0.02 m behind the pivot at (-0.16, 0), lies ahead of it now.
    figure = plot_layout(load("differential"), twist=[-1.0, 0.0, 0.0])
    at = corners(figure, "wheel:caster").mean(axis=0)
    assert at == pytest.approx((-0.16 + 0.02, 0), abs=ROUNDING)


def test_names_are_not_read_as_formulas():
    wheel = FixedWheel(name="a$_$", x=0, y=0, radius=0.1)
    figure = plot_layout(Robot(name="$\\broken$", wheels=(wheel, BallWheel(name="b", x=0.3, y=0))))
    figure.canvas.draw()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"steering": [0.1]}, "steering of front_left, front_right must be 2 angles, got shape"),
        ({"steering": [0.1, math.nan]}, "all finite"),
        ({"twist": [1.0, 0.0]}, "twist must be (u, v, r), got shape (2,)"),
        ({"twist": "fast"}, "twist must be (u, v, r), got 'fast'"),
    ],
)
def test_bad_input_is_told_in_words(given, words):
    with pytest.raises(ShapeError) as error:
        plot_layout(load("ackermann"), **given)
    assert words in str(error.value)


# ---- reachable twists -------------------------------------------------------------------------


def outlines(figure: Figure) -> list[np.ndarray]:
    patches = [each for each in figure.findobj() if each.get_gid() == "reachable"]
    return [patch.get_xy()[:-1] for patch in patches]


def assert_same_corners(found: np.ndarray, expected: list[tuple[float, float]]) -> None:
    assert len(found) == len(expected)
    for corner in expected:
        assert np.hypot(*(found - corner).T).min() < ROUNDING, f"{corner} is not in {found}"


def test_a_mecanum_robots_corners():
    # Rim 0.05 m x 8 rad/s = 0.4 m/s; |u +- v| <= 0.4, and the yaw arm is 0.2 + 0.15 = 0.35 m.
    robot = load("mecanum", radius=0.05, wheelbase=0.4, track=0.3).with_wheels(max_speed=8.0)
    uv, ur, vr = outlines(plot_reachable(robot))
    rim, yaw = 0.4, 0.4 / 0.35
    assert_same_corners(uv, [(rim, 0), (0, rim), (-rim, 0), (0, -rim)])
    for section in (ur, vr):
        assert_same_corners(section, [(rim, 0), (0, yaw), (-rim, 0), (0, -yaw)])


def test_three_omni_wheels_reach_a_hexagon():
    # Rim 0.2 m x 5 rad/s = 1 m/s; |v| <= 1 and |sqrt3/2 u +- v/2| <= 1.
    uv, _, _ = outlines(plot_reachable(load("omni3").with_wheels(max_speed=5.0)))
    far, near = 2 / math.sqrt(3), 1 / math.sqrt(3)
    assert_same_corners(uv, [(far, 0), (near, 1), (-near, 1), (-far, 0), (-near, -1), (near, -1)])


def test_one_slow_wheel_sets_its_own_edges():
    # Left wheel at most 0.05 x 2 = 0.1 m/s, right 0.4 m/s;
    # u = (right + left) / 2, r = (right - left) / 0.4.
    robot = load("differential", radius=0.05, track=0.4).with_wheels(max_speed=8.0)
    left = dataclasses.replace(robot.wheels[0], max_speed=2.0)
    robot = dataclasses.replace(robot, wheels=(left, *robot.wheels[1:]))
    (ur,) = outlines(plot_reachable(robot))
    assert_same_corners(ur, [(0.25, 0.75), (0.15, 1.25), (-0.25, -0.75), (-0.15, -1.25)])


def test_without_a_limit_ten_radians_per_second_are_taken_and_told():
    figure = plot_reachable(load("differential", radius=0.05, track=0.4))
    assert "10 rad/s" in artist(figure, "title").get_text()
    assert "assumed" in note(figure)
    assert_same_corners(outlines(figure)[0], [(0.5, 0), (0, 2.5), (-0.5, 0), (0, -2.5)])
    limited = plot_reachable(load("differential").with_wheels(max_speed=7.0))
    assert "7 rad/s" in artist(limited, "title").get_text()
    assert "assumed" not in note(limited)


def test_a_component_that_follows_is_told():
    # Dead wheels 0.2 m behind the origin hold v = 0.2 r.
    axes = plot_reachable(load("mixed")).axes[0]
    assert axes.get_title("left") == "v = 0.2 r"


def test_steering_that_is_held_leaves_a_line():
    # Straight on, at the rear wheels' 0.3 m x 10 rad/s.
    figure = plot_reachable(load("ackermann"), steering=[0.0, 0.0])
    assert_same_corners(outlines(figure)[0], [(3, 0), (-3, 0)])
    with pytest.raises(OffCentreError):
        plot_reachable(load("ackermann"), steering=[0.4, -0.4])


def test_a_swerve_drive_reaches_a_disc():
    # Every wheel turns into the motion: sqrt(u^2 + v^2) = 0.05 m x 10 rad/s at r = 0.
    uv, _, _ = outlines(plot_reachable(load("swerve", radius=0.05)))
    assert np.hypot(*uv.T) == pytest.approx(0.5, rel=TRACED)


def test_steering_limits_leave_a_bow_tie():
    # The inner wheel's limit sets the least radius: R = L / tan(beta) + track / 2.
    limits = {"steering_min": -0.6, "steering_max": 0.6, "max_speed": 10.0}
    robot = load("ackermann", radius=0.3, wheelbase=2.6, track=1.5).with_wheels(**limits)
    (ur,) = outlines(plot_reachable(robot))
    least = 2.6 / math.tan(0.6) + 0.75
    moving = np.abs(ur[:, 0]) > 0.1
    sharpest = np.abs(ur[moving, 1] / ur[moving, 0]).max()
    assert sharpest <= (1 + TRACED) / least
    assert sharpest == pytest.approx(1 / least, rel=0.02)  # between two rays, half a degree apart


def test_a_motion_that_no_motor_limits_is_told():
    # A bicycle turns about its driven rear wheel without turning it.
    axes = plot_reachable(load("bicycle")).axes[0]
    assert "the motors do not limit r" in axes.get_title("left")
    (strip,) = outlines(axes.figure)
    assert np.abs(strip[:, 0]).max() == pytest.approx(3.0, rel=TRACED)


def test_a_robot_without_a_motor_says_so():
    wheels = (BallWheel(name="a", x=0, y=0), BallWheel(name="b", x=1, y=0))
    figure = plot_reachable(Robot(name="tray", wheels=wheels))
    assert "no motor" in artist(figure, "remark").get_text()


# ---- runs -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def mixed_run():
    robot = load("mixed")
    return robot, simulate(robot, twist=[0.3, 0.1, 0.5], duration=4.0, dt=0.02)


def test_eta_shows_the_run_over_time_with_units(mixed_run):
    _, run = mixed_run
    figure = plot_eta(run)
    assert [axes.get_ylabel() for axes in figure.axes] == ["x [m]", "y [m]", "ψ [rad]"]
    assert figure.axes[2].get_xlabel() == "t [s]"
    for k, axes in enumerate(figure.axes):
        (line,) = axes.get_lines()
        assert np.array_equal(line.get_xdata(), run.t)
        assert np.array_equal(line.get_ydata(), run.pose[:, k])


def test_rounding_is_not_shown_as_motion():
    run = simulate(load("omni3"), wheel_speeds=[0.5, 0.5, 0.5], duration=3.0)
    low, high = plot_eta(run).axes[0].get_ylim()
    assert high - low > 0.01


def test_path_and_truth_are_drawn_with_the_robot_along_them(mixed_run):
    robot, run = mixed_run
    figure = plot_path(robot, run, truth=run.pose[::5] + np.array([0.05, 0.0, 0.0]))
    axes = figure.axes[0]
    assert axes.get_aspect() == 1.0
    assert np.array_equal(artist(figure, "path").get_xydata(), run.pose[:, :2])
    assert np.allclose(artist(figure, "truth").get_xdata(), run.pose[::5, 0] + 0.05)
    assert artist(figure, "start").get_xydata()[0] == pytest.approx(run.pose[0, :2])
    assert artist(figure, "end").get_xydata()[0] == pytest.approx(run.pose[-1, :2])
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words == ["truth", "path", "start", "end"]
    robots = sorted(gids(figure, "robot"))
    assert 3 <= len(robots) <= 8
    # The body is the first polygon: its middle is the origin of this robot's frame.
    for gid, pose in ((robots[0], run.pose[0]), (robots[-1], run.pose[-1])):
        body = artist(figure, gid).get_paths()[0].vertices[:4]
        assert body.mean(axis=0) == pytest.approx(pose[:2], abs=ROUNDING)
        side = body[1] - body[0]
        assert math.atan2(side[1], side[0]) == pytest.approx(pose[2], abs=ROUNDING)


def test_a_robot_that_would_be_a_dot_is_drawn_larger_and_the_picture_says_so():
    robot = load("differential")
    figure = plot_path(robot, simulate(robot, twist=[1.0, 0.0, 0.0], duration=50.0, dt=0.1))
    body = artist(figure, "robot:0").get_paths()[0].vertices[:4]
    times = np.hypot(*(body[1] - body[0])) / robot.body.length
    assert times > 2
    assert f"drawn {times:.0f} times its size" in note(figure)


@pytest.mark.parametrize("truth", [np.zeros((4, 2)), np.zeros(3), np.full((2, 3), np.nan), "no"])
def test_truth_of_the_wrong_shape_is_refused(mixed_run, truth):
    with pytest.raises(ShapeError, match="truth"):
        plot_path(*mixed_run, truth=truth)


def test_a_run_of_another_robot_is_refused(mixed_run):
    _, run = mixed_run
    with pytest.raises(TrundleError, match="another robot: its driven wheels are front_left"):
        plot_path(load("differential"), run)


def test_wheels_turn_and_steer_as_the_run_says():
    robot = load("ackermann")
    run = simulate(robot, twist=[1.0, 0.0, 0.25], duration=2.0, dt=0.1)
    stance = at_times(robot, run, np.array([2.0])).stances[0]
    for wheel in robot.wheels:
        assert isinstance(wheel, RollingWheel)
        # About the centre (0, 4): angle and way of each wheel on its own circle.
        arm = math.hypot(wheel.x, 4 - wheel.y)
        assert stance.angle[wheel.name] == pytest.approx(
            math.atan2(wheel.x, 4 - wheel.y), abs=ROUNDING
        )
        assert stance.turn[wheel.name] == pytest.approx(0.25 * arm * 2 / 0.3, abs=ROUNDING)


def test_a_reversed_wheel_turns_backwards_when_its_motor_turns_forwards():
    robot = load("omni4")
    run = simulate(robot, wheel_speeds=[1.0] * 4, duration=1.0)
    assert at_times(robot, run, np.array([1.0])).stances[0].turn["front_left"] == pytest.approx(-1)


def test_casters_swing_round_behind_the_motion():
    robot = load("differential")
    run = simulate(robot, twist=[0.3, 0.0, 0.0], duration=2.0)
    stance = at_times(robot, run, np.array([2.0])).stances[0]
    assert math.remainder(stance.angle["caster"], 2 * math.pi) == pytest.approx(0, abs=1e-6)


# ---- animations -------------------------------------------------------------------------------


def frames_of(path) -> list[np.ndarray]:
    with Image.open(path) as film:
        found = []
        for k in range(film.n_frames):
            film.seek(k)
            found.append(np.asarray(film.convert("RGB")).astype(int))
        return found


@pytest.mark.parametrize("name", ["mecanum", "ackermann", "two_steered"])
def test_an_animation_has_its_frames_and_moves(tmp_path, name):
    robot = load(name)
    run = simulate(robot, twist=[0.3, 0.0, 0.4], duration=3.0)
    told = []
    path = animate(
        robot, run, tmp_path / "film.gif", fps=10, seconds=1.2,
        progress=lambda done, total: told.append((done, total)),
    )  # fmt: skip
    frames = frames_of(path)
    assert len(frames) == 12  # 10 / s x 1.2 s
    assert told == [(k, 12) for k in range(1, 13)]
    assert all((a != b).any() for a, b in itertools.pairwise(frames))
    assert (frames[0][5, 300] == 255).all()  # the ground stays white
    assert path.stat().st_size < LARGEST_GIF
    with Image.open(path) as film:
        assert film.info["duration"] == 100
        assert film.info["loop"] == 0


def test_wheels_turn_in_the_animation_of_a_robot_that_stays(tmp_path):
    # Four omni wheels against each other: the robot rests, and every wheel slips round.
    robot = load("omni")
    run = simulate(robot, wheel_speeds=[1.0, -1.0, 1.0, -1.0], duration=1.0)
    assert np.abs(run.pose).max() < ROUNDING
    frames = frames_of(animate(robot, run, tmp_path / "film.gif", fps=5, seconds=1.0))
    below_the_clock = slice(80, None)
    assert (frames[0][below_the_clock] != frames[2][below_the_clock]).any()


def test_time_passes_as_it_does_unless_the_run_is_very_short_or_long(tmp_path):
    robot = load("omni3")
    for duration, count, milliseconds in ((4.0, 80, 50), (12.0, 150, 80)):
        run = simulate(robot, wheel_speeds=[0.0, 0.0, 0.0], duration=duration)
        path = animate(robot, run, tmp_path / "film.gif")
        with Image.open(path) as film:
            # Pillow joins frames that are alike; here only the clock moves.
            assert film.n_frames <= count
            total = 0
            for k in range(film.n_frames):
                film.seek(k)
                total += film.info["duration"]
        assert total == pytest.approx(1000 * duration, abs=milliseconds)


@pytest.mark.parametrize(
    ("given", "words"),
    [({"fps": 0}, "fps must be positive"), ({"seconds": -1.0}, "seconds must be positive"),
     ({"fps": math.nan}, "fps must be positive")],
)  # fmt: skip
def test_impossible_paces_are_refused(tmp_path, mixed_run, given, words):
    with pytest.raises(TrundleError, match=words):
        animate(*mixed_run, tmp_path / "film.gif", **given)


def test_mp4_plays_back(tmp_path, mixed_run):
    if shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed: MP4 cannot be written here")
    path = animate(*mixed_run, tmp_path / "film.mp4", fps=10, seconds=1.0)
    assert path.read_bytes()[4:8] == b"ftyp"
    again = subprocess.run(
        ["ffmpeg", "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "gray", "-"],
        capture_output=True, check=True,
    )  # fmt: skip
    assert len(again.stdout) == 10 * 800 * 560


def test_mp4_without_ffmpeg_says_what_to_do(tmp_path, mixed_run, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileError, match=r"film\.mp4: MP4 needs the program ffmpeg"):
        animate(*mixed_run, tmp_path / "film.mp4", seconds=0.2)


def test_a_failing_ffmpeg_is_told(tmp_path, mixed_run, monkeypatch):
    if sys.platform == "win32":
        pytest.skip("the stand-in for ffmpeg is a shell script")
    stand_in = tmp_path / "ffmpeg"
    stand_in.write_text("#!/bin/sh\necho 'no such encoder' >&2\nexit 1\n")
    stand_in.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda _: str(stand_in))
    with pytest.raises(FileError, match="cannot be written: no such encoder"):
        animate(*mixed_run, tmp_path / "film.mp4", seconds=1.0)


# ---- files ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ending", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_pictures_are_saved_by_their_ending(tmp_path, layouts, ending, start):
    path = save(layouts["differential"], tmp_path / f"robot{ending}")
    assert path.read_bytes().startswith(start)


def test_what_cannot_be_written_is_told(tmp_path, layouts, mixed_run):
    figure = layouts["differential"]
    with pytest.raises(FileError, match="there is no folder"):
        save(figure, tmp_path / "missing" / "robot.png")
    with pytest.raises(FileError, match=r"saved as \.png, \.svg or \.pdf"):
        save(figure, tmp_path / "robot.txt")
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(FileError, match=r"folder\.png: cannot be written"):
        save(figure, tmp_path / "folder.png")
    with pytest.raises(FileError, match="there is no folder"):
        animate(*mixed_run, tmp_path / "missing" / "film.gif")
    (tmp_path / "folder.gif").mkdir()
    with pytest.raises(FileError, match=r"folder\.gif: cannot be written"):
        animate(*mixed_run, tmp_path / "folder.gif", seconds=0.2)
    with pytest.raises(FileError, match=r"saved as \.gif or \.mp4"):
        animate(*mixed_run, tmp_path / "film.avi")


def test_pictures_leave_no_trace_in_matplotlib(mixed_run):
    before = dict(mpl.rcParams)
    plot_path(*mixed_run)
    plot_layout(mixed_run[0])
    assert dict(mpl.rcParams) == before
    program = "import sys, trundle.view; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_a_failed_animation_leaves_the_old_file(tmp_path, monkeypatch):
    robot = load("omni3")
    run = simulate(robot, wheel_speeds=[1.0, 1.0, 1.0], duration=1.0)
    old = tmp_path / "old.mp4"
    old.write_bytes(b"precious")
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(FileError, match="ffmpeg"):
        animate(robot, run, old)
    assert old.read_bytes() == b"precious"
    kept = tmp_path / "kept.gif"
    kept.write_bytes(b"precious")

    def stop(done, _):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(robot, run, kept, progress=stop)
    assert kept.read_bytes() == b"precious"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept.gif", "old.mp4"]
