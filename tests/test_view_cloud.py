"""The picture of where many robots end: facts are read from what is drawn, not from pixels."""

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from trundle import load, simulate
from trundle.errors import ShapeError, TrundleError
from trundle.view import ends_of, plot_cloud
from trundle.view.labels import renderer_of

ROUNDING = 1e-9
ROBOT = load("differential")
RUN = simulate(ROBOT, twist=[0.3, 0.0, 0.3], duration=10.0, dt=0.1)
END = RUN.pose[-1]


def artists(figure: Figure, gid: str):
    return [each for each in figure.findobj() if each.get_gid() == gid]


def drawn(figure: Figure, gid: str) -> np.ndarray:
    (found,) = artists(figure, gid)
    return found.get_xydata()


def scattered(size: float, count: int = 500) -> np.ndarray:
    return END + size * np.random.default_rng(1).normal(0.0, (1.0, 0.5, 0.2), (count, 3))


# ---- numbers ----------------------------------------------------------------------------------


def test_the_ellipse_of_a_known_normal_distribution():
    """Half axes are 2.4477 standard deviations, turned by 30 deg, and hold 95 % of the points."""
    rng, turn = np.random.default_rng(0), math.radians(30)
    a, b = rng.normal(0.0, 0.2, 40_000), rng.normal(0.0, 0.05, 40_000)
    c, s = math.cos(turn), math.sin(turn)
    ends = ends_of([0, 0, 0], np.stack([1 + c * a - s * b, 2 + s * a + c * b, 0 * a], axis=1))
    # Standard deviations of 40,000 numbers are known to 0.35 %: three of these.
    np.testing.assert_allclose(ends.half_axes, [2.4477 * 0.2, 2.4477 * 0.05], rtol=0.011)
    assert ends.direction == pytest.approx(turn, abs=0.01)
    assert ends.inside == pytest.approx(0.95, abs=0.004)
    np.testing.assert_allclose(ends.mean, [1, 2, 0], atol=0.004)


def test_ends_on_a_line_and_in_one_point():
    line = ends_of([0, 0, 0], [[0, -1, 0], [0, 1, 0], [0, 2, 0]])
    assert line.half_axes[1] == pytest.approx(0, abs=1e-7)  # the root of a rounding error
    assert abs(line.direction) == pytest.approx(math.pi / 2)
    assert (line.farthest, line.inside) == (2, 1.0)
    point = ends_of([1, 1, 0], [[1, 1, 0]] * 3)
    assert (point.within, point.inside) == (0.0, 1.0)
    assert point.half_axes.tolist() == point.std[:2].tolist() == [0, 0]


def test_the_drawn_ellipse_is_the_one_told():
    ends = ends_of(END, scattered(0.1))
    apart = ends.ellipse() - ends.mean[:2]
    assert np.hypot(*apart.T).max() == pytest.approx(ends.half_axes[0])
    assert np.hypot(*apart.T).min() == pytest.approx(ends.half_axes[1], rel=1e-3)
    longest = apart[np.hypot(*apart.T).argmax()]
    assert math.tan(ends.direction) == pytest.approx(longest[1] / longest[0])


# ---- picture ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("size", "unit", "factor"),
    [(3.0, "m", 1.0), (0.02, "cm", 1e2), (1e-3, "mm", 1e3), (1e-6, "µm", 1e6)],
)
def test_ends_are_drawn_where_they_are_in_a_unit_that_suits(size, unit, factor):
    final = scattered(size)
    figure = plot_cloud(ROBOT, RUN, final)
    left, right = figure.axes
    assert (left.get_aspect(), right.get_aspect()) == (1.0, 1.0)
    assert left.get_xlabel() == "x [m]"
    assert right.get_xlabel() == f"x from the nominal end [{unit}]"
    (dots,) = [each for each in artists(figure, "dots") if each.axes is right]
    # Small differences of coordinates of a metre have fewer digits.
    tolerance = factor * 1e-12
    expected = factor * (final - END)[:, :2]
    np.testing.assert_allclose(dots.get_xydata()[:-1], expected, atol=tolerance)
    farthest = expected[np.hypot(*expected.T).argmax()]
    np.testing.assert_allclose(drawn(figure, "farthest robot")[0], farthest, atol=tolerance)
    np.testing.assert_allclose(drawn(figure, "mean")[0], expected.mean(axis=0), atol=tolerance)
    np.testing.assert_allclose(drawn(figure, "nominal end")[0], [0, 0])
    low, high = np.array([right.get_xlim(), right.get_ylim()]).T
    assert ((expected > low) & (expected < high)).all()


def test_paths_and_the_robot_at_both_ends():
    paths = np.stack([RUN.pose + np.array([0.0, 0.01 * k, 0.0]) for k in range(50)], axis=1)
    figure = plot_cloud(ROBOT, RUN, paths[-1], paths, ["noise 1 rad/s"])
    (fan,) = artists(figure, "paths")
    assert len(fan.get_segments()) == 30
    np.testing.assert_allclose(fan.get_segments()[3], paths[:, 3, :2])
    np.testing.assert_allclose(drawn(figure, "path"), RUN.pose[:, :2])
    robots = [each for k in range(9) for each in artists(figure, f"robot:{k}")]
    assert len(robots) == 2
    for robot, pose in zip(robots, (RUN.pose[0], END), strict=True):
        body = robot.get_paths()[0].vertices[:4]
        assert np.hypot(*(body.mean(axis=0) - pose[:2])) < ROBOT.reach
    (note,) = artists(figure, "note")
    assert note.get_text().endswith("noise 1 rad/s")
    assert "50 robots" in artists(figure, "title")[0].get_text()


def test_many_robots_are_not_one_blot_and_the_farthest_is_among_them():
    final = scattered(0.1, 20_000)
    final[-1, 0] += 5.0
    figure = plot_cloud(ROBOT, RUN, final)
    assert all(len(each.get_xydata()) <= 4001 for each in artists(figure, "dots"))
    np.testing.assert_allclose(
        drawn(figure, "farthest robot")[0], (final[-1] - END)[:2], atol=ROUNDING
    )


def test_robots_that_do_not_differ_are_told():
    figure = plot_cloud(ROBOT, RUN, [END] * 10)
    (remark,) = artists(figure, "remark")
    assert remark.get_text() == "all robots end at the nominal end"


@pytest.mark.parametrize("name", ["mecanum", "ackermann"])
def test_title_and_legend_stay_on_the_page(name):
    robot = load(name)
    run = simulate(robot, twist=[0.3, 0.0, 0.1], duration=5.0)
    final = run.pose[-1] + np.random.default_rng(2).normal(0.0, 0.01, (300, 3))
    figure = plot_cloud(robot, run, final, run.pose[:, None], ["front_left.radius to 0.5%"] * 8)
    for gid in ("title", "note", "legend"):
        (found,) = artists(figure, gid)
        box = found.get_window_extent(renderer_of(figure.axes[0]))
        assert figure.bbox.contains(box.x0, box.y0), gid
        assert figure.bbox.contains(box.x1, box.y1), gid
    (note,) = artists(figure, "note")
    bottom = note.get_window_extent(renderer_of(figure.axes[0])).y0
    assert all(axes.get_tightbbox(renderer_of(axes)).y1 < bottom for axes in figure.axes)


@pytest.mark.parametrize(
    ("final", "paths", "told"),
    [
        ([[0, 0]], None, "ends need poses"),
        (np.zeros((0, 3)), None, "ends need poses"),
        ([[0, 0, math.nan]], None, "finite"),
        ([END], [[0, 0, 0]], r"\(T, K, 3\)"),
        ([END], [[[0, math.inf, 0]]], "finite"),
        ([END], "paths", r"\(T, K, 3\)"),
    ],
)
def test_bad_input_is_told_in_words(final, paths, told):
    with pytest.raises(ShapeError, match=told):
        plot_cloud(ROBOT, RUN, final, paths)


def test_a_run_of_another_robot_is_refused():
    with pytest.raises(TrundleError, match="another robot"):
        plot_cloud(load("omni3"), RUN, [END])
