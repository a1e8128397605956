"""Pictures of runs in closed loop: numbers are read back from what is drawn."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from matplotlib.figure import Figure

import trundle
from trundle import motion
from trundle.control import PD, ComputedTorque, Kanayama
from trundle.errors import StabilityWarning, TrundleError
from trundle.limits import feasibility
from trundle.robot import Body, MecanumWheel, Motor, Robot
from trundle.view import (
    animate,
    plot_comparison,
    plot_feasibility,
    plot_path,
    plot_tracking,
    plot_trajectory,
)
from trundle.view.film import Stage
from trundle.view.motion import at_times
from trundle.view.thin import spread, stretches, thin

# Products of a few sines and cosines.
ROUNDING = 1e-9
CELL = 5e-4  # cells of a sheet have four digits
# A picture is at most some 4000 pixels wide, and lines keep their ends.
MOST_POINTS = 4100

# ---- reading what is drawn --------------------------------------------------------------------


def artists(figure: Figure, gid: str):
    return [each for each in figure.findobj() if each.get_gid() == gid]


def artist(figure: Figure, gid: str):
    (found,) = artists(figure, gid)
    return found


def gids(figure: Figure, start: str) -> list[str]:
    return [g for each in figure.findobj() if (g := each.get_gid()) and g.startswith(start)]


def text(figure: Figure, gid: str) -> str:
    return artist(figure, gid).get_text()


def heads(figure: Figure) -> list[str]:
    """Return what stands above the panels, from the top."""
    return [words for axes in figure.axes if (words := axes.get_title("left"))]


def panel(figure: Figure, start: str):
    (found,) = [axes for axes in figure.axes if axes.get_title("left").startswith(start)]
    return found


def legend_words(axes) -> list[str]:
    return [each.get_text() for each in axes.get_legend().get_texts()]


def bars(figure: Figure, name: str) -> list[tuple[float, float]]:
    """Return the times from which and to which a wheel is marked to be at its limit."""
    paths = artist(figure, f"saturated:{name}").get_paths()
    spans = [path.vertices[:, 0] for path in paths]
    return [(float(x.min()), float(x.max())) for x in spans]


def drawn(figure: Figure, gid: str) -> np.ndarray:
    return artist(figure, gid).get_xydata()


# ---- runs -------------------------------------------------------------------------------------

CIRCLE = motion.circle(radius=3.0, rate=0.1)
SMALL_CIRCLE = motion.circle(radius=2.0, rate=0.3)
LECTURE = {"duration": 60.0, "dt": 0.1, "method": "lecture"}
LECTURE_PD = PD(kp=[120, 120, 0.4], kd=[120, 120, 0.4])
LECTURE_CT = ComputedTorque(kp=[4, 4, 4], kd=[4, 4, 4])


@pytest.fixture(scope="module")
def lecture():
    """Return the lectures' robot and its two runs on the circle."""
    robot = trundle.load("omni3").with_body(mass=30.0, inertia=0.1, com=(0.0, 0.0))
    runs = {
        "PD": trundle.track(robot, CIRCLE, LECTURE_PD, **LECTURE),
        "computed torque": trundle.track(robot, CIRCLE, LECTURE_CT, **LECTURE),
    }
    return robot, runs


@pytest.fixture(scope="module")
def saturated():
    robot = trundle.load("omni3").with_wheels(max_torque=0.8)
    return robot, trundle.track(
        robot, SMALL_CIRCLE, LECTURE_CT, duration=15.0, pose=[0.0, -0.5, 0.3]
    )


@pytest.fixture(scope="module")
def chasing():
    """Return a differential drive that starts beside its circle, under twists."""
    robot = trundle.load("differential")
    return robot, trundle.track(
        robot, SMALL_CIRCLE, Kanayama(), duration=10.0, dt=0.02, pose=[0.0, -0.3, 0.2]
    )


@pytest.fixture(scope="module")
def lost():
    """Return a run whose step is far too long."""
    robot = trundle.load("omni3")
    with pytest.warns(StabilityWarning):
        run = trundle.track(
            robot, CIRCLE, PD(kp=[120] * 3, kd=[120] * 3), duration=60.0, dt=1.0, method="lecture"
        )
    return robot, run


# ---- the sheet of one run ---------------------------------------------------------------------


def test_the_sheet_shows_path_errors_torques_and_energy(lecture):
    robot, runs = lecture
    run = runs["PD"]
    figure = plot_tracking(robot, run)
    assert figure.axes[0].get_aspect() == 1.0
    assert np.array_equal(drawn(figure, "path"), run.pose[:, :2])
    assert np.array_equal(drawn(figure, "desired"), run.desired[:, :2])
    for k, name in enumerate("xyψ"):
        line = drawn(figure, f"error:{name}")
        assert np.array_equal(line[:, 0], run.t)
        assert np.array_equal(line[:, 1], run.error[:, k])
    for i, wheel in enumerate(robot.driven):
        line = drawn(figure, f"wheel torques:{wheel.name}")
        assert np.array_equal(line, np.column_stack([run.t[:-1], run.torques[:, i]]))
    assert np.array_equal(drawn(figure, "energy")[:, 1], run.energy)
    assert np.array_equal(drawn(figure, "work")[:, 1], run.work)
    assert 3 <= len(gids(figure, "robot:")) <= 8
    assert [words.split(" [")[0] for words in heads(figure)] == [
        "position error, desired minus actual", "heading error", "wheel torques", "energy",
    ]  # fmt: skip


def test_title_and_notes_tell_the_result(lecture):
    robot, runs = lecture
    # The reference's table: 7.4813e-3 m and 3.4913e-5 m, the same along x and y of a circle.
    assert text(plot_tracking(robot, runs["PD"]), "title").endswith("error 0.0075 m, 0 rad")
    figure = plot_tracking(robot, runs["computed torque"])
    assert "largest error 3.5e-05 m" in text(figure, "title")
    assert "60 s in 600 steps" in text(figure, "note")


def test_a_tiny_error_fills_its_panel_in_a_unit_that_can_be_read(lecture):
    robot, runs = lecture
    figure = plot_tracking(robot, runs["computed torque"])
    axes = panel(figure, "position error")
    assert axes.get_title("left").endswith("[µm]")
    high = axes.get_ylim()[1]
    assert 3.4913e-5 < high < 2 * 3.4913e-5
    figure.canvas.draw()
    ticks = dict(zip(axes.get_yticks(), axes.get_yticklabels(), strict=True))
    for at, label in ticks.items():
        assert float(label.get_text().replace("−", "-")) == pytest.approx(1e6 * at)
    # The heading has an axis of its own, on which rounding is zero.
    heading = panel(figure, "heading error")
    assert heading.get_title("left").endswith("[rad]")
    assert heading.get_ylim()[1] > 0.1


def test_limits_are_drawn_and_bars_mark_when_each_motor_was_at_its(saturated):
    robot, run = saturated
    figure = plot_tracking(robot, run)
    axes = panel(figure, "wheel torques")
    assert axes.get_title("left").endswith("dashed: limits, bars: at a limit")
    levels = {float(line.get_ydata()[0]) for line in artists(figure, "limit:wheel_1")}
    assert levels == {-0.8, 0.8}
    assert axes.get_ylim()[0] < -0.8 < 0.8 < axes.get_ylim()[1]
    for i, wheel in enumerate(robot.driven):
        marked = bars(figure, wheel.name)
        middles = (run.t[:-1] + run.t[1:]) / 2
        inside = np.zeros(len(middles), dtype=bool)
        for start, end in marked:
            inside |= (middles > start) & (middles < end)
        assert 0 < inside.sum() < len(inside)
        assert np.array_equal(inside, run.saturated[:, i])
    assert "Motors were at their torque limits" in " ".join(text(figure, "reports").split())


def test_limits_that_are_not_near_are_not_drawn(lecture):
    robot, runs = lecture
    strong = robot.with_wheels(max_torque=50.0)
    figure = plot_tracking(strong, runs["PD"])
    assert gids(figure, "limit:") == []
    assert gids(figure, "saturated:") == []
    assert panel(figure, "wheel torques").get_title("left") == "wheel torques [N m]"


def test_limits_of_motors_fall_with_speed():
    # tau <= k_t N (U - k_e N omega) / R, with k_e = k_t.
    motor = Motor(torque_constant=0.02, resistance=2.0, gear=10.0, max_voltage=3.0)
    robot = trundle.load("mecanum").with_wheels(motor=motor)
    path = motion.lissajous(2.0, 1.5, 0.6, 0.3)
    run = trundle.track(robot, path, LECTURE_CT, duration=5.0, pose=[0.0, -0.5, 0.3])
    figure = plot_tracking(robot, run)
    i, wheel = next((i, w) for i, w in enumerate(robot.driven) if w.name == "rear_left")
    expected = 0.02 * 10.0 * (3.0 - 0.02 * 10.0 * run.wheel_speeds[:, i]) / 2.0
    highest = max(artists(figure, f"limit:{wheel.name}"), key=lambda line: line.get_ydata().max())
    assert highest.get_ydata() == pytest.approx(expected, abs=ROUNDING)


def test_without_masses_wheel_speeds_are_shown(chasing):
    robot, _ = chasing
    light = dataclasses.replace(robot, body=None)
    run = trundle.track(light, SMALL_CIRCLE, Kanayama(), duration=2.0)
    figure = plot_tracking(light, run)
    assert heads(figure)[2:] == ["wheel speeds [rad/s]"]
    assert "masses are not known" in text(figure, "note")
    line = drawn(figure, "wheel speeds:left")
    assert np.array_equal(line[:, 1], run.wheel_speeds[:, 0])


def test_twists_that_were_cut_are_marked_at_the_wheel_speeds():
    robot = trundle.load("differential").with_wheels(max_speed=13.5)
    run = trundle.track(
        robot, SMALL_CIRCLE, Kanayama(), duration=10.0, dt=0.02, pose=[0.0, -0.3, 0.2]
    )
    figure = plot_tracking(robot, run)
    assert run.saturated[0, 0]
    assert not run.saturated[-1, 0]
    cut = np.flatnonzero(run.saturated[:, 0])
    # Both wheels are slowed down together: one bar for the two.
    marked = bars(figure, "")
    assert (marked[0][0], marked[-1][1]) == (0.0, pytest.approx(run.t[cut[-1] + 1]))
    assert {float(line.get_ydata()[0]) for line in artists(figure, "limit:left")} == {13.5}
    assert "bars" not in panel(figure, "wheel torques").get_title("left")


def test_a_brief_peak_does_not_flatten_the_rest(chasing):
    robot, run = chasing
    figure = plot_tracking(robot, run)
    axes = panel(figure, "wheel torques")
    # The start beside the path takes one step of a torque far above all later ones.
    peak = np.abs(run.torques[0]).max()
    assert peak > 5 * np.abs(run.torques[3:]).max()
    assert axes.get_ylim()[1] < 2 * np.abs(run.torques[1:]).max() < peak
    assert text(figure, "word") == f"peak {peak:.3g} N m at t = 0 s"


def test_a_robot_that_steers_shows_its_steering():
    robot = trundle.load("ackermann")
    run = trundle.track(robot, motion.circle(10.0, 0.2), Kanayama(), duration=3.0, dt=0.02)
    figure = plot_tracking(robot, run)
    assert [words.split(" [")[0] for words in heads(figure)[2:]] == [
        "steering angles", "wheel torques", "energy",
    ]  # fmt: skip
    # About the rear axle on a circle of 10 m: tan = wheelbase / (10 m - half the track).
    line = drawn(figure, "steering angles:front_left")
    assert line[-1, 1] == pytest.approx(math.atan2(2.6, 10.0 - 0.75), abs=1e-6)


def wheels(count: int) -> Robot:
    """Return a robot on ``count`` mecanum wheels, two and two, with names that try a picture."""
    made = tuple(
        MecanumWheel(
            name=("_hidden", "$odd_", "a_rather_long_name_for_a_wheel", "w4", *"5678")[k],
            x=0.3 * (k // 2), y=0.3 * (-1) ** k, radius=0.1, max_torque=0.4 + 0.05 * k,
            roller=math.radians(45 * (-1) ** (k + 1 + k // 2)),
        )
        for k in range(count)
    )  # fmt: skip
    return Robot(name="many", wheels=made, body=Body(mass=30.0, inertia=2.0, com=(0.4, 0.0)))


@pytest.mark.parametrize("count", [4, 6, 8])
def test_many_wheels_with_any_names(count):
    robot = wheels(count)
    run = trundle.track(robot, CIRCLE, LECTURE_CT, duration=3.0, pose=[0.0, -0.3, 0.2])
    assert run.saturated.any()
    figure = plot_tracking(robot, run)
    words = legend_words(panel(figure, "wheel torques"))
    assert words[:3] == ["_hidden", "$odd_", "a_rather_long…"]
    assert len(words) == count
    colours = {artist(figure, g).get_color() for g in gids(figure, "wheel torques:")}
    assert len(colours) == count
    assert_on_the_page(figure)


def test_one_driven_wheel_and_one_step():
    robot = trundle.load("tricycle")
    run = trundle.track(robot, motion.circle(5.0, 0.1), Kanayama(), duration=0.01, dt=0.01)
    figure = plot_tracking(robot, run)
    assert "in 1 step " in text(figure, "note") + " "
    assert artist(figure, "wheel torques:front").get_marker() == "o"
    assert_on_the_page(figure)


def test_a_lost_run_is_shown_as_long_as_it_can_be_seen(lost):
    robot, run = lost
    assert np.abs(run.pose).max() > 1e4
    for figure in (plot_tracking(robot, run), plot_path(robot, run)):
        (low_x, high_x), (low_y, high_y) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
        assert max(high_x - low_x, high_y - low_y) < 50
        assert artists(figure, "end") == []
        assert "lost" in text(figure, "note")
    figure = plot_tracking(robot, run)
    start, end = panel(figure, "position error").get_xlim()
    seen = (run.t >= start) & (run.t < end)
    assert 2 < seen.sum() < len(run.t)
    assert np.abs(run.pose[seen, :2]).max() < 50
    assert np.abs(panel(figure, "position error").get_ylim()).max() < 50
    assert "grew beyond all bounds" in text(figure, "reports")


def test_a_robot_that_spins_ever_faster_is_lost_too(lecture):
    robot, runs = lecture
    run = runs["PD"]
    pose = run.pose.copy()
    pose[300:, 2] += 7.0
    figure = plot_tracking(robot, dataclasses.replace(run, pose=pose))
    assert panel(figure, "heading error").get_xlim() == (0.0, pytest.approx(run.t[300]))


def test_a_run_of_many_steps_is_thinned_and_keeps_its_peaks(lecture):
    robot, runs = lecture
    few, steps = runs["PD"], 60_000
    every = np.linspace(0.0, len(few.t) - 1.0, steps + 1).astype(int)
    error = few.error[every]
    error[31_415, 0] = 0.7
    fields = {
        name: getattr(few, name)[every]
        for name in ("pose", "wheel_angles", "desired", "energy", "work")
    } | {
        name: getattr(few, name)[every[:-1].clip(max=len(few.t) - 2)]
        for name in ("twist", "wheel_speeds", "steering", "torques", "force", "saturated")
    }
    run = dataclasses.replace(few, t=np.linspace(0.0, 60.0, steps + 1), error=error, **fields)
    figure = plot_tracking(robot, run)
    assert "60 s in 60000 steps" in text(figure, "note")
    for axes in figure.axes:
        assert all(len(line.get_xdata()) <= MOST_POINTS for line in axes.get_lines())
    line = drawn(figure, "error:x")
    assert line[line[:, 1].argmax()] == pytest.approx([31.415, 0.7])
    assert np.array_equal(drawn(figure, "path")[[0, -1]], run.pose[[0, -1], :2])


def test_what_cannot_be_drawn_is_refused(lecture, chasing):
    robot, runs = lecture
    plain = trundle.simulate(robot, twist=[0.1, 0.0, 0.0], duration=1.0)
    with pytest.raises(TrundleError, match=r"no trajectory .* trundle\.track makes runs"):
        plot_tracking(robot, plain)
    with pytest.raises(TrundleError, match="run must be a Run"):
        plot_tracking(robot, "run")
    with pytest.raises(TrundleError, match="another robot"):
        plot_tracking(chasing[0], runs["PD"])
    with pytest.raises(TrundleError, match="a Robot is needed"):
        plot_tracking("omni3", runs["PD"])


# ---- comparison -------------------------------------------------------------------------------


def cells(figure: Figure, name: str) -> list[str]:
    found = sorted(artists(figure, f"number:{name}"), key=lambda each: each.get_position()[0])
    return [each.get_text().replace("−", "-") for each in found]


def test_runs_are_compared_over_time_on_axes_that_show_both(lecture):
    robot, runs = lecture
    figure = plot_comparison(robot, runs)
    for name, run in runs.items():
        assert np.array_equal(drawn(figure, f"path:{name}"), run.pose[:, :2])
        distance = drawn(figure, f"distance:{name}")
        assert distance[:, 1] == pytest.approx(np.hypot(*run.error[:, :2].T))
        assert drawn(figure, f"heading:{name}")[:, 1] == pytest.approx(np.abs(run.error[:, 2]))
        torque = drawn(figure, f"torque:{name}")
        assert torque[:, 1] == pytest.approx(np.abs(run.torques).max(axis=1))
        colours = {artist(figure, f"{what}:{name}").get_color() for what in ("path", "torque")}
        assert len(colours) == 1
    assert np.array_equal(drawn(figure, "desired"), runs["PD"].desired[:, :2])
    axes = panel(figure, "distance")
    assert axes.get_yscale() == "log"
    low, high = axes.get_ylim()
    assert low < 3.4913e-5 < 7.4813e-3 < high < 0.1
    # Rounding is no size that errors could differ by.
    assert panel(figure, "heading").get_yscale() == "linear"
    assert text(figure, "title") == (
        "omni3: largest error from 3.5e-05 m (computed torque) to 0.0075 m (PD)"
    )


def test_the_table_has_the_numbers_of_each_run(lecture):
    robot, runs = lecture
    figure = plot_comparison(robot, runs)
    # The reference's largest errors; they are those of the distance on a circle about the origin.
    assert float(cells(figure, "PD")[0]) == pytest.approx(7.4813e-3, rel=CELL)
    assert float(cells(figure, "computed torque")[0]) == pytest.approx(3.4913e-5, rel=CELL)
    for name, run in runs.items():
        _, rms, turn, rms_turn, torque, work = cells(figure, name)
        squares = run.error[:, 0] ** 2 + run.error[:, 1] ** 2
        assert float(rms) == pytest.approx(math.sqrt(squares.mean()), rel=CELL)
        assert (turn, rms_turn) == ("0", "0")
        mean = float((run.torques**2).mean())
        assert float(torque) == pytest.approx(math.sqrt(mean), rel=CELL)
        assert float(work) == pytest.approx(run.work[-1], rel=CELL)


def test_errors_of_one_size_are_on_a_linear_axis(lecture):
    robot, runs = lecture
    weaker = trundle.track(
        robot, CIRCLE, PD(kp=[80, 80, 0.4], kd=[120, 120, 0.4]), duration=30.0, dt=0.05
    )
    figure = plot_comparison(robot, {"strong": runs["PD"], "weak": weaker})
    assert panel(figure, "distance").get_yscale() == "linear"
    assert "weak: ends at t = 30 s" in text(figure, "note")
    assert panel(figure, "distance").get_xlim() == (0.0, 60.0)


def test_runs_without_torques_are_compared_too(chasing):
    robot, run = chasing
    bare = dataclasses.replace(run, torques=None, energy=None, work=None)
    figure = plot_comparison(robot, {"heavy": run, "light": bare})
    assert cells(figure, "light")[-2:] == ["–", "–"]
    assert gids(figure, "torque:") == ["torque:heavy"]
    both = plot_comparison(robot, {"a": bare, "b": bare})
    assert [words.split(" [")[0] for words in heads(both)] == [
        "distance from the trajectory", "heading error, its magnitude",
    ]  # fmt: skip


def test_a_lost_run_beside_a_good_one(lost, lecture):
    robot, runs = lecture
    figure = plot_comparison(robot, {"good": runs["PD"], "lost": lost[1]})
    (low, high) = figure.axes[0].get_ylim()
    assert high - low < 50
    assert "lost: lost at t = " in text(figure, "note")
    assert np.abs(panel(figure, "largest torque").get_ylim()).max() < 1e4


def test_comparisons_that_make_no_sense_are_refused(lecture, chasing):
    robot, runs = lecture
    run = runs["PD"]
    with pytest.raises(TrundleError, match="runs must be 2 to 8 to be compared, got 1"):
        plot_comparison(robot, {"PD": run})
    with pytest.raises(TrundleError, match="a dictionary from names to runs, got a list"):
        plot_comparison(robot, [run, run])
    with pytest.raises(TrundleError, match="another robot"):
        plot_comparison(robot, {"a": run, "b": chasing[1]})
    elsewhere = trundle.track(robot, SMALL_CIRCLE, LECTURE_CT, duration=5.0, dt=0.1)
    with pytest.raises(TrundleError, match="'a' and 'b' were to follow different trajectories"):
        plot_comparison(robot, {"a": run, "b": elsewhere})
    plain = trundle.simulate(robot, twist=[0.1, 0.0, 0.0], duration=1.0)
    with pytest.raises(TrundleError, match="run 'b' has no trajectory"):
        plot_comparison(robot, {"a": run, "b": plain})


# ---- feasibility ------------------------------------------------------------------------------


def test_shares_of_the_limits_and_what_lies_above():
    # 0.4 m/s on wheels of 0.2 m: 2 rad/s where the limit is 1 rad/s.
    robot = trundle.load("omni3").with_wheels(max_speed=1.0, max_acceleration=5.0)
    found = feasibility(robot, motion.circle(1.0, 0.4, heading=0.0))
    figure = plot_feasibility(found)
    assert text(figure, "title") == "Not feasible: stretch time by 2"
    line = drawn(figure, "share:wheel speed")
    # The wheels stand every 120 degrees: the nearest to the motion's direction counts.
    t = line[:, 0]
    of_wheels = [np.abs(np.cos(0.4 * t + math.tau * k / 3 + math.pi / 2)) for k in range(3)]
    assert line[:, 1] == pytest.approx(2.0 * np.max(of_wheels, axis=0), abs=1e-6)
    above = artist(figure, "over:wheel speed").get_paths()[0].vertices[:, 1]
    assert above.min() == pytest.approx(1.0)
    assert above.max() == pytest.approx(2.0, rel=1e-4)
    assert artist(figure, "over:wheel acceleration").get_paths() == []
    assert set(artist(figure, "limit").get_ydata()) == {1.0}
    speed, acceleration = legend_words(figure.axes[0])
    assert speed.splitlines()[::2] == ["wheel speed", "stretch time by 2"]
    assert speed.splitlines()[1].startswith("200 % (wheel_")
    # Acceleration 0.4^2 / 0.2 = 0.8 rad/s^2 of 5, and it falls with the square of the pace.
    factor = math.sqrt(5.0 / 0.8)
    assert acceleration.splitlines()[2] == f"up to {factor:.4g} times faster"
    figure.canvas.draw()
    ticks = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert "100 %" in ticks
    assert len(figure.axes) == 1


def test_a_share_far_above_the_limit_is_on_a_logarithmic_axis():
    robot = trundle.load("omni3").with_wheels(max_speed=0.1, max_acceleration=5.0)
    figure = plot_feasibility(feasibility(robot, motion.circle(1.0, 0.4, heading=0.0)))
    assert figure.axes[0].get_yscale() == "log"
    assert figure.axes[0].get_ylim()[1] > 20.0


def test_motion_that_the_wheels_cannot_follow_is_shown():
    robot = trundle.load("differential")
    path = motion.circle(1.0, 0.5, heading=0.0)
    figure = plot_feasibility(feasibility(robot, path))
    assert "the wheels cannot move" in text(figure, "title")
    assert "no limits" in text(figure, "remark")
    line = drawn(figure, "miss:sideways")
    assert line[:, 1] == pytest.approx(0.5 * np.sin(0.5 * line[:, 0]), abs=ROUNDING)
    assert drawn(figure, "miss:forward")[:, 1] == pytest.approx(0.0, abs=ROUNDING)


def test_what_is_feasible_says_by_how_much():
    robot = trundle.load("omni3").with_wheels(max_speed=4.0)
    figure = plot_feasibility(feasibility(robot, motion.circle(1.0, 0.4, heading=0.0)))
    assert text(figure, "title") == "Feasible, and up to 2 times faster"
    steady = trundle.load("ackermann").with_wheels(steering_rate=1.0)
    held = plot_feasibility(feasibility(steady, motion.circle(10.0, 0.2)))
    assert text(held, "title") == "Feasible: no limit is touched"
    assert legend_words(held.axes[0])[0].splitlines()[2] == "kept at any pace"
    with pytest.raises(TrundleError, match="plot_feasibility draws what"):
        plot_feasibility(robot)


# ---- trajectories -----------------------------------------------------------------------------


def test_a_trajectory_shows_where_when_and_how_fast():
    figure = plot_trajectory(CIRCLE)
    assert text(figure, "title") == "Circle of radius 3 m at 0.1 rad/s"
    assert "18.85 m in 62.83 s" in text(figure, "note")
    assert figure.axes[0].get_aspect() == 1.0
    for what, value in (("speed", 0.3), ("yaw rate", 0.1), ("acceleration", 0.03)):
        assert drawn(figure, what)[:, 1] == pytest.approx(value, abs=ROUNDING)
    assert [words.split("[")[1] for words in heads(figure)] == ["m/s]", "rad/s]", "mm/s²]"]
    for gid in gids(figure, "mark:"):
        t = float(gid.removeprefix("mark:"))
        on_circle = (3 * math.sin(0.1 * t), 3 - 3 * math.cos(0.1 * t))
        # Drawn on the line between two of 4001 points.
        assert drawn(figure, gid)[0] == pytest.approx(on_circle, abs=1e-5)
        assert text(figure, f"time:{t:g}") == f"{t:g} s"
    assert len(gids(figure, "mark:")) >= 4
    arrows = artist(figure, "heading")
    centre = arrows.XY - (0.0, 3.0)
    along = np.stack([-centre[:, 1], centre[:, 0]])  # counter-clockwise
    pointing = np.stack([arrows.U, arrows.V])
    cosines = (along * pointing).sum(axis=0) / np.hypot(*along) / np.hypot(*pointing)
    assert cosines == pytest.approx(1.0)


class Turning:
    """A user's own trajectory: on the spot, at 2 rad/s."""

    def position(self, t):
        return np.array([1.0, 2.0, 2.0 * t])

    def velocity(self, t):
        return np.array([0.0, 0.0, 2.0])

    def acceleration(self, t):
        return np.zeros(3)


def test_a_trajectory_of_ones_own_that_turns_on_the_spot():
    figure = plot_trajectory(Turning(), duration=2.0)
    assert text(figure, "title") == "Turning"
    assert gids(figure, "mark:") == []
    low, high = figure.axes[0].get_xlim()
    assert low < 1.0 < high < low + 5.0
    assert drawn(figure, "yaw rate")[:, 1] == pytest.approx(2.0)
    assert drawn(figure, "yaw rate")[-1, 0] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("given", "duration", "words"),
    [
        (Turning(), None, "give a duration"),
        (Turning(), -1.0, "duration must be a positive number of seconds, got -1"),
        (Turning(), math.inf, "duration must be a positive number of seconds, got inf"),
        (Turning(), "long", "duration must be a positive number of seconds, got 'long'"),
        (3, 1.0, "3 has no position"),
    ],
)
def test_what_is_no_trajectory_is_refused(given, duration, words):
    with pytest.raises(TrundleError, match=words):
        plot_trajectory(given, duration)


# ---- path and animation -----------------------------------------------------------------------


def test_a_path_has_its_trajectory_in_another_line_than_the_truth(chasing):
    robot, run = chasing
    figure = plot_path(robot, run, truth=run.pose + 0.01)
    words = legend_words(figure.axes[0])
    assert words == ["desired", "truth", "path", "start", "end"]
    assert np.array_equal(drawn(figure, "desired"), run.desired[:, :2])
    desired, truth = artist(figure, "desired"), artist(figure, "truth")
    assert desired._dash_pattern != truth._dash_pattern  # matplotlib tells them in no other way


def test_the_animation_shows_where_the_robot_should_be(chasing, tmp_path):
    robot, run = chasing
    stage = Stage(robot, run, at_times(robot, run, np.array([0.0, 4.0])), 1.0)
    assert np.array_equal(drawn(stage.figure, "desired"), run.desired[:, :2])
    assert "ring" in text(stage.figure, "note")
    # On the circle of 2 m at 0.3 rad/s.
    for k, t in enumerate((0.0, 4.0)):
        stage.show(k)
        where = (2 * math.sin(0.3 * t), 2 - 2 * math.cos(0.3 * t))
        assert stage.ring.get_xydata()[0] == pytest.approx(where, abs=ROUNDING)
    low, high = stage.axes.get_ylim()
    assert low < -0.3 < run.desired[:, 1].max() < high
    frames = [np.asarray(frame) for frame in stage.frames()]
    assert all((a != b).any() for a, b in itertools.pairwise(frames))
    assert animate(robot, run, tmp_path / "run.gif", fps=5, seconds=0.4).stat().st_size > 0


def test_the_animation_of_a_lost_run_stays_where_it_began(lost):
    robot, run = lost
    stage = Stage(robot, run, at_times(robot, run, np.array([0.0, 10.0])), 1.0)
    assert max(np.ptp(stage.axes.get_xlim()), np.ptp(stage.axes.get_ylim())) < 50
    assert "lost at t = " in text(stage.figure, "note")
    assert len(list(stage.frames())) == 2


# ---- thinning ---------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 3999, 4000, 4001, 8001, 60_001, 2_000_003])
def test_thinned_curves_keep_ends_and_peaks(count):
    values = np.zeros(count)
    values[count // 3], values[count // 2] = 5.0, -5.0
    kept = thin(values)
    assert len(kept) <= MOST_POINTS
    assert (kept[0], kept[-1]) == (0, count - 1)
    assert (np.diff(kept) > 0).all()
    assert (values[kept].min(), values[kept].max()) == (values.min(), values.max())
    assert len(spread(count)) <= MOST_POINTS
    assert (spread(count)[0], spread(count)[-1]) == (0, count - 1)


def test_marks_that_flicker_are_joined():
    t = np.linspace(0.0, 60.0, 60_001)
    marked = np.arange(60_000) % 3 > 0  # gaps of a millisecond, less than a pixel
    assert stretches(t, marked) == [(pytest.approx(0.001), pytest.approx(59.999))]
    assert stretches(t, np.zeros(60_000, dtype=bool)) == []
    assert stretches(t, np.ones(60_000, dtype=bool)) == [(0.0, 60.0)]


# ---- the page ---------------------------------------------------------------------------------


def assert_on_the_page(figure: Figure) -> None:
    """Check that no text leaves the page, and that no two that are written apart overlap."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    boxes = {each: each.get_window_extent(renderer) for each in figure.texts}
    for axes in figure.axes:
        boxes[axes] = axes.get_tightbbox(renderer)
        if legend := axes.get_legend():
            boxes[legend] = legend.get_window_extent(renderer)
    for box in boxes.values():
        assert figure.bbox.contains(box.x0, box.y0)
        assert figure.bbox.contains(box.x1, box.y1)
    parts = [(each, boxes[each]) for each in (*figure.texts, *figure.axes) if boxes[each].width > 0]
    for (one, first), (two, second) in itertools.combinations(parts, 2):
        assert not first.padded(-0.5).overlaps(second.padded(-0.5)), f"{one} overlaps {two}"


def test_sheets_fill_their_page_and_nothing_overlaps(lecture, saturated, chasing, lost):
    robot, runs = lecture
    for given in ((robot, runs["PD"]), saturated, chasing, lost):
        assert_on_the_page(plot_tracking(*given))
    many = {f"computed torque, number {k} of many": runs["PD"] for k in range(8)}
    assert_on_the_page(plot_comparison(robot, many))
    assert_on_the_page(plot_trajectory(motion.figure_eight(4.0, 0.5, heading=motion.spin(0.5))))
    car = trundle.load("ackermann").with_wheels(
        max_speed=3.0, steering_min=-1.2, steering_max=1.2, steering_rate=0.3
    )
    assert_on_the_page(plot_feasibility(feasibility(car, motion.figure_eight(20.0, 0.25))))
    sideways = feasibility(car, motion.circle(10.0, 0.2, heading=0.0))
    assert_on_the_page(plot_feasibility(sideways))
