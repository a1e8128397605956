"""Reducers of rollouts: against numpy over the stored trajectory, and against what is known."""

# Costs take four arguments, whether they need them or not.
# ruff: noqa: ARG001, ARG005

import functools
import importlib.util
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import trundle
from trundle import (
    Box,
    Collision,
    Constant,
    CostSum,
    Disc,
    FirstExit,
    GridCollision,
    Policy,
    Spread,
    Statistics,
    Stream,
    TrundleError,
    compile_rollout,
    load,
    rollout,
)

# The loops of numpy and of compiled code differ by rounding only; a step is right to about ten
# roundings, and 50 steps of some decimetres add up.
TOLERANCE = {"float64": 1e-12, "float32": 2e-5}
DT, STEPS, ROBOTS = 0.05, 50, 600  # more robots than a block of the compiled loop
ROBOT = load("mecanum")
CIRCLES = np.array([[0.6, 0.1, 0.1], [-0.5, 0.4, 0.2], [0.0, -0.8, 0.3]])
ORIGIN, RESOLUTION = np.array([-0.9, -0.6]), 0.1
GRID = np.random.default_rng(5).uniform(0.02, 1.0, (13, 19))

needs_numba = pytest.mark.skipif(
    importlib.util.find_spec("numba") is None, reason="numba is not installed"
)
DEVICES = ("numpy", pytest.param("cpu", marks=needs_numba))


def drift(t, pose, parameters):
    """Return a twist towards a point that depends on time; for ``Policy``."""
    (gain,) = parameters
    return gain * (0.5 - pose[0]), 0.3 * gain, 0.5 + 0.1 * t


def cost(t, pose, command, parameters):
    """Return a cost of everything that a cost may depend on."""
    x, y = parameters
    dx, dy = pose[0] - x, pose[1] - y
    return dx * dx + dy * dy + 0.01 * command[1] * command[0] + 0.1 * t * pose[2]


def starts():
    """Return starts all around the origin."""
    return np.random.default_rng(1).normal(0.0, 0.3, (ROBOTS, 3))


def constant():
    """Return wheel speeds, each robot's own."""
    return Constant(np.random.default_rng(2).uniform(-8.0, 8.0, (ROBOTS, 4)))


def policy():
    """Return a law with gains of each robot, and noise."""
    gains = np.linspace(0.5, 1.5, ROBOTS)[:, None]
    law = Policy(drift, output="twist", parameters=gains)
    return law.with_noise(0.1, seed=4)


def reducers():
    """Return one of each."""
    return (
        CostSum(cost, parameters=np.stack([np.linspace(0, 1, ROBOTS), np.zeros(ROBOTS)], axis=1)),
        Statistics(),
        Spread(every=7),
        FirstExit(Disc(0.1, -0.1, 0.7)),
        Collision(CIRCLES, robot_radius=0.05),
        GridCollision(GRID, ORIGIN, RESOLUTION, robot_radius=0.05),
    )


# ---- the same things by numpy, from a stored trajectory (T + 1, N, 3) --------------------------


def first_time(happened):
    """Return the end of the first step at which something happened, (T, N) -> (N,)."""
    return np.where(happened.any(axis=0), (happened.argmax(axis=0) + 1) * DT, np.inf)


def outside_disc(poses, x, y, radius):
    """Whether poses are outside of a disc."""
    return np.hypot(poses[..., 0] - x, poses[..., 1] - y) > radius


def clearance_to_circles(poses):
    """Return the distance to the nearest rim."""
    away = poses[..., None, :2] - CIRCLES[:, :2]
    return (np.linalg.norm(away, axis=-1) - CIRCLES[:, 2]).min(axis=-1) - 0.05


def clearance_in_grid(poses):
    """Return the grid's distance: interpolated along x, then along y."""
    columns, rows = np.arange(GRID.shape[1]), np.arange(GRID.shape[0])
    place = (poses[..., :2] - ORIGIN) / RESOLUTION
    shape = place.shape[:-1]
    x, y = place.reshape(-1, 2).T
    along = np.array([np.interp(x, columns, row) for row in GRID])
    found = [np.interp(b, rows, along[:, k]) for k, b in enumerate(y)]
    return np.reshape(found, shape) - 0.05


def assert_contacts(found, clearances, scale):
    """Compare with clearances (T, N); robots that all but touch may be told either way."""
    np.testing.assert_allclose(found.clearance, clearances.min(axis=0), rtol=0, atol=scale)
    clear = (abs(np.minimum.accumulate(clearances)) > scale).all(axis=0)
    assert clear.mean() > 0.9
    expected = first_time(clearances <= 0)
    assert np.isfinite(expected).any()
    np.testing.assert_allclose(found.time[clear], expected[clear], rtol=1e-12)


# ---- against stored trajectories ---------------------------------------------------------------


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_reducers_tell_what_the_trajectory_tells(device, dtype):
    given = {"dt": DT, "steps": STEPS, "pose": starts(), "dtype": dtype, "device": device}
    poses = rollout(ROBOT, policy(), save="trajectory", **given).pose.astype(float)
    result = rollout(ROBOT, policy(), save=reducers()[1:], **given)
    over_time, spread, exits, circles, grid = result.reduced
    after, scale = poses[1:], TOLERANCE[dtype]
    np.testing.assert_allclose(result.pose, poses[-1], rtol=0, atol=scale)

    for found, expected in (
        (over_time.mean, after.mean(axis=0)),
        (over_time.std, after.std(axis=0)),
        (over_time.smallest, after.min(axis=0)),
        (over_time.largest, after.max(axis=0)),
    ):
        np.testing.assert_allclose(found, expected, rtol=0, atol=scale)

    np.testing.assert_allclose(spread.mean, poses[::7].mean(axis=1), rtol=0, atol=scale)
    covariances = [np.cov(row.T, bias=True) for row in poses[::7]]
    np.testing.assert_allclose(spread.covariance, covariances, rtol=0, atol=scale)
    assert spread.dt == pytest.approx(7 * DT)

    times = first_time(outside_disc(after, 0.1, -0.1, 0.7))
    assert 0.1 < np.isfinite(times).mean() < 1
    np.testing.assert_allclose(exits.time, times, rtol=1e-12)
    left = np.isfinite(times)
    there = after[np.rint(times[left] / DT).astype(int) - 1, left]
    np.testing.assert_allclose(exits.pose[left], there, rtol=0, atol=scale)
    assert np.isnan(exits.pose[~left]).all()

    assert_contacts(circles, clearance_to_circles(after), scale)
    # The grid's steepest cell turns a metre into less than fifteen.
    assert_contacts(grid, clearance_in_grid(after), 15 * scale)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_cost_is_the_sum_along_the_trajectory(device, dtype):
    given = {"dt": DT, "steps": STEPS, "pose": starts(), "dtype": dtype, "device": device}
    law, where = constant(), reducers()[0]
    poses = rollout(ROBOT, law, save="trajectory", **given).pose.astype(float)[1:]
    total = rollout(ROBOT, law, save=where, **given).reduced
    commands = law.values[0]
    expected = sum(
        cost((t + 1) * DT, poses[t].T, commands, where.parameters.T) for t in range(STEPS)
    )
    # Fifty terms of up to about ten.
    np.testing.assert_allclose(total, expected, rtol=0, atol=100 * TOLERANCE[dtype])


# ---- what is known -----------------------------------------------------------------------------


def straight(save, **kwargs):
    """Return what a reducer makes of a robot that goes along x at 1 m/s for 5 s."""
    line = Constant(twist=[1.0, 0.0, 0.0])
    return rollout(ROBOT, line, dt=0.01, steps=500, save=save, device="numpy", **kwargs).reduced


def test_a_straight_line_leaves_disc_and_box_at_known_times():
    # The last step inside ends at 2.00 s of 2.005, and at 3.25 of 3.255.
    assert straight(FirstExit(Disc(1.0, 0.0, 1.005))).time == pytest.approx(2.01)
    exits = straight(FirstExit(Box(-1.0, 3.255, -1.0, 1.0)))
    assert exits.time == pytest.approx(3.26)
    np.testing.assert_allclose(exits.pose, [[3.26, 0.0, 0.0]], atol=1e-12)


def test_a_straight_line_touches_a_circle_at_a_known_time():
    # The robot's rim touches at x = 4 - 0.5 - 0.305, and the least clearance is at the end: 5 m.
    contacts = straight(Collision([[4.0, 0.0, 0.5], [0.0, 9.0, 1.0]], robot_radius=0.305))
    assert contacts.time == pytest.approx(3.2)
    assert contacts.clearance == pytest.approx(-0.805)


def test_a_straight_line_reaches_a_wall_of_a_grid_at_a_known_time():
    wall = np.tile(3.0 - np.arange(4.0), (2, 1))  # to x = 3, from x = 0 on; beyond it 0
    contacts = straight(GridCollision(wall, [0.0, -0.5], 1.0, robot_radius=0.255))
    assert contacts.time == pytest.approx(2.75)
    assert contacts.clearance == pytest.approx(-0.255)


def test_the_cost_of_time_is_the_sum_of_the_steps_ends():
    assert straight(CostSum(lambda t, pose, command, parameters: t)) == pytest.approx(
        0.01 * 500 * 501 / 2
    )


def near_or_far(t, pose, command, parameters):
    """Return a cost that numpy reads of plain numbers only."""
    far = math.exp(min(pose[0], 1.0)) - 1.0
    if pose[0] > 0.5:
        far = far + 2.0
    return far


def where_far(t, pose, command, parameters):
    """Return a cost that is an array without axes."""
    return np.where(pose[0] > 0.5, 2.0, 0.0)


def fails(t, pose, command, parameters):
    """Return nothing: it breaks."""
    return pose.x


def fails_later(t, pose, command, parameters):
    """Return 0 at first."""
    if pose[0] > 0.01:
        raise ValueError("too late")
    return 0.0


@pytest.mark.parametrize("device", DEVICES)
def test_costs_with_branches_are_read_too(device):
    # At 1 m/s, from 0.05, -2 and 1 on: x after ten steps of 0.1 s.
    given = {"dt": 0.1, "steps": 10, "pose": [[0.05, 0, 0], [-2.0, 0, 0], [1.0, 0, 0]]}
    law = Constant(twist=[1.0, 0.0, 0.0])
    save = CostSum(near_or_far), CostSum(where_far)
    smooth, chosen = rollout(ROBOT, law, save=save, device=device, **given).reduced
    x = np.arange(1, 11)[:, None] / 10 + np.array([0.05, -2.0, 1.0])
    far = x > 0.5
    np.testing.assert_array_equal(chosen, 2.0 * far.sum(axis=0))
    expected = (np.expm1(np.minimum(x, 1.0)) + 2.0 * far).sum(axis=0)
    np.testing.assert_allclose(smooth, expected, rtol=1e-12)


@needs_numba
def test_a_cost_that_was_compiled_before_is_read():
    import numba

    given = {"dt": 0.1, "steps": 3, "pose": starts(), "device": "numpy"}
    two = (CostSum(each, parameters=[0.1, 0.2]) for each in (numba.njit(cost), cost))
    compiled, plain = rollout(ROBOT, constant(), save=tuple(two), **given).reduced
    np.testing.assert_array_equal(compiled, plain)


@needs_numba
def test_a_cost_that_cannot_be_compiled_is_told():
    def by_name(t, pose, command, parameters):
        return {"x": pose[0], 1: pose[1]}["x"]

    with pytest.raises(TrundleError, match="cost 'by_name' cannot be compiled"):
        rollout(ROBOT, constant(), dt=0.1, steps=3, save=CostSum(by_name), device="cpu")
    read = rollout(ROBOT, constant(), dt=0.1, steps=3, save=CostSum(by_name), device="numpy")
    assert np.isfinite(read.reduced).all()


def test_float32_sums_keep_what_they_would_lose():
    def tenth(t, pose, command, parameters):
        return 0.0 * pose[0] + 0.1

    still = Constant(twist=[0.0, 0.0, 0.0])
    total = rollout(
        ROBOT, still, dt=0.01, steps=50_000, save=CostSum(tenth), dtype="float32", device="numpy"
    ).reduced
    # 0.1 itself and the result are rounded to 24 bits.
    tolerance = 2 * 2.0**-24
    plain = np.cumsum(np.full(50_000, 0.1, np.float32))[-1]
    assert abs(plain - 5000) > 100 * 5000 * tolerance
    assert total == pytest.approx(5000, rel=tolerance)


def test_float32_statistics_hold_far_from_the_origin():
    given = {"dt": 0.01, "steps": 5000, "pose": [1000.0, 0.0, 0.0], "device": "numpy"}
    circle = Constant(twist=[0.1, 0.0, 1.0])  # a radius of 0.1 m
    over_time = rollout(ROBOT, circle, save=Statistics(), dtype="float32", **given).reduced
    after = rollout(ROBOT, circle, save="trajectory", **given).pose[1:]
    # At 1000 m, poses are rounded to 6e-5 m; that is independent of the deviation.
    np.testing.assert_allclose(over_time.mean, after.mean(axis=0), rtol=0, atol=6e-5)
    np.testing.assert_allclose(over_time.std[:, :2], after.std(axis=0)[:, :2], rtol=0, atol=1e-5)


@pytest.mark.parametrize("device", DEVICES)
def test_spread_of_a_normal_cloud_far_away(device):
    count, sigma = 40_000, np.array([1e-3, 2e-3, 5e-4])
    cloud = np.random.default_rng(3).normal(0.0, sigma, (count, 3)) + np.array([1e6, -1e6, 0.0])
    still = Constant(twist=[0.0, 0.0, 0.0])
    spread = rollout(
        ROBOT, still, dt=0.1, steps=3, pose=cloud, save=Spread(), device=device
    ).reduced
    # Five standard deviations of an estimate from so many: sigma^2 sqrt(2 / N).
    tolerance = 5 * np.outer(sigma, sigma) * np.sqrt(2 / count)
    assert (abs(spread.covariance - np.diag(sigma**2)) < tolerance).all()
    # Poses are rounded to 1e-10 m there, and robots that stand still keep their moments.
    np.testing.assert_allclose(spread.covariance, np.cov(cloud.T, bias=True)[None].repeat(4, 0),
                               rtol=0, atol=1e-15)  # fmt: skip


@needs_numba
def test_spread_does_not_depend_on_the_number_of_threads():
    import numba

    call = compile_rollout(
        ROBOT, constant(), dt=DT, steps=STEPS, pose=starts(), save=Spread(), device="cpu"
    )
    before = numba.get_num_threads()
    found = []
    try:
        for threads in {1, before}:
            numba.set_num_threads(threads)
            found.append(call().reduced)
    finally:
        numba.set_num_threads(before)
    for each in found[1:]:
        np.testing.assert_array_equal(each.covariance, found[0].covariance)


def test_spreads_of_different_steps_go_together():
    two, three = straight((Spread(2), Spread(3)))
    np.testing.assert_allclose(two.mean[:, 0], 0.02 * np.arange(251), atol=1e-12)
    np.testing.assert_allclose(three.mean[:, 0], 0.03 * np.arange(167), atol=1e-12)


def test_without_steps_nothing_happens():
    still = Constant(twist=[1.0, 0.0, 0.0])
    total, over_time, spread, exits, circles, grid = rollout(
        ROBOT, still, dt=0.1, steps=0, pose=starts(), save=reducers(), device="numpy"
    ).reduced
    assert (total == 0).all()
    assert np.isnan(over_time.mean).all()
    assert spread.mean.shape == (1, 3)
    assert np.isinf(exits.time).all()
    assert np.isinf(circles.time).all()
    assert np.isinf(grid.clearance).all()


def test_other_parameters_of_a_cost_in_a_prepared_call():
    call = compile_rollout(
        ROBOT, constant(), dt=DT, steps=5, save=CostSum(cost, parameters=[0.0, 0.0]), device="numpy"
    )
    expected = rollout(
        ROBOT, constant(), dt=DT, steps=5, save=CostSum(cost, parameters=[1.0, 2.0]), device="numpy"
    ).reduced
    np.testing.assert_array_equal(call(parameters=[1.0, 2.0]).reduced, expected)
    with pytest.raises(TrundleError, match="parameters"):
        call(parameters=[1.0])


# ---- memory ------------------------------------------------------------------------------------

MEASURE = """
import sys, tracemalloc
import numpy as np
from trundle import Constant, FirstExit, Disc, Spread, Statistics, load, rollout
def peak(steps):
    tracemalloc.start()
    rollout(load("mecanum"), Constant(np.ones((5000, 4))), dt=0.01, steps=steps,
            save=(Statistics(), FirstExit(Disc(0, 0, 1)), Spread(every=steps // 10)),
            device="numpy")
    found = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found
peak(20)
print(peak(200), peak(2000))
"""


def test_peak_memory_does_not_grow_with_the_number_of_steps():
    source = str(Path(trundle.__file__).parents[1])
    path = os.pathsep.join(filter(None, [source, os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-c", MEASURE], capture_output=True, text=True, check=True,
        env=os.environ | {"PYTHONPATH": path},
    )  # fmt: skip
    few, many = map(int, done.stdout.split())
    # Storing the trajectory would take ten times as much; some rows of sums differ.
    assert many < 1.1 * few


# ---- bad input ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: CostSum(3.0), "cost must be a function"),
        (lambda: CostSum(lambda t, pose: 0.0), "must take"),
        (lambda: CostSum(functools.partial(cost, 0.0)), "a plain Python function"),
        (lambda: CostSum(np.hypot), "a plain Python function"),
        (lambda: CostSum(cost, parameters=[[[1.0]]]), r"\(k,\) or \(N, k\)"),
        (lambda: CostSum(cost, parameters=[np.nan, 0.0]), "parameters"),
        (lambda: Spread(every=0), "whole number of steps"),
        (lambda: Spread(every=1.5), "whole number of steps"),
        (lambda: Disc(0.0, 0.0, 0.0), "radius must be positive"),
        (lambda: Disc(0.0, np.nan, 1.0), "y must be a finite number"),
        (lambda: Box(1.0, 0.0, 0.0, 1.0), "x_min must be below x_max"),
        (lambda: FirstExit("disc"), "a Disc or a Box"),
        (lambda: Collision([1.0, 2.0, 3.0]), r"circles must be \(k, 3\)"),
        (lambda: Collision(np.zeros((0, 3))), r"circles must be \(k, 3\)"),
        (lambda: Collision([[0.0, 0.0, -1.0]]), "circle 0: radius"),
        (lambda: Collision([[0.0, np.inf, 1.0]]), "circles"),
        (lambda: Collision([[0.0, 0.0, 1.0]], robot_radius=-0.1), "robot_radius"),
        (lambda: GridCollision([[1.0]], [0.0, 0.0], 0.1), "two rows and two columns"),
        (lambda: GridCollision([[1.0, np.nan]] * 2, [0.0, 0.0], 0.1), "distance"),
        (lambda: GridCollision(GRID, [0.0], 0.1), "origin"),
        (lambda: GridCollision(GRID, [0.0, 0.0], 0.0), "resolution must be positive"),
    ],
)
def test_bad_reducers(make, message):
    with pytest.raises(TrundleError, match=message):
        make()


@pytest.mark.parametrize(
    ("save", "message"),
    [
        (CostSum(lambda t, pose, command, parameters: None), "must return a number, got None"),
        (CostSum(lambda t, pose, command, parameters: pose), "must return a number"),
        (CostSum(fails), "cost 'fails': AttributeError"),
        (CostSum(fails_later), "cost 'fails_later': ValueError: too late"),
        (CostSum(lambda t, pose, command, parameters: np.inf), "no finite number"),
        (CostSum(cost, parameters=np.zeros((7, 2))), "the reducer's numbers has 7"),
        ((), "tuple of reducers"),
        ((Statistics(), "final"), "tuple of reducers"),
        (Statistics, "tuple of reducers"),
    ],
)
def test_what_cannot_be_saved(save, message):
    with pytest.raises(TrundleError, match=message):
        rollout(ROBOT, Stream(np.ones((3, 5, 4))), dt=0.1, save=save, device="numpy")
