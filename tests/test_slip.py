"""The search for slipping wheels: residuals, how rarely noise alone is told, who is to blame."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2, norm

import trundle
from catalogue import feasible_twists, steering_for
from trundle.bridge.slip import SlipWatch, chi_square
from trundle.errors import UnobservedMotionError
from trundle.robot import CATALOG, Robot

Floats = NDArray[np.float64]

NOISE = 1e-4  # [m]
DEVIATIONS = 5.0
DT = 0.02  # [s]
SECOND = 50  # steps
ROUNDING = 1e-12

# How many rows are too many: rolling rows of sensed wheels and side-slip rows of steered wheels,
# less the motions that the fixed wheels' side slip leaves.
REDUNDANT = {
    "differential": 0, "tricycle": 0, "bicycle": 0, "ackermann": 2, "rear_steered": 2,
    "four_wheel_steered": 5, "omni3": 0, "omni3_exercise": 0, "omni": 1, "omni4": 1, "mecanum": 1,
    "mecanum_lecture": 1, "two_steered": 1, "synchro": 3, "swerve": 5, "omni_steer": 1,
    "skid_steer": 2, "mixed": 2,
}  # fmt: skip
SEEING = [name for name, count in REDUNDANT.items() if count]
# Robots in which leaving out one wheel tells it from all others.
TELLING = ["swerve", "four_wheel_steered", "synchro"]


def watch(robot: Robot, **changes: object) -> SlipWatch:
    settings = {"wheel_noise": NOISE, "steering_noise": NOISE, "threshold": DEVIATIONS}
    return SlipWatch(robot, **(settings | changes))  # type: ignore[arg-type]


def driving(robot: Robot, speed: float = 0.8) -> tuple[list[float], list[float]]:
    """Return increments [rad] and angles of a drive in which every wheel turns."""
    twist = feasible_twists(robot, (), seed=11)
    twist = twist * speed / float(np.hypot(*twist[:2]))
    angles = steering_for(robot, twist)
    kinematics = trundle.Kinematics(robot)
    turns = kinematics.rolling_speeds(twist, angles if robot.steered else None, sensed=True)
    return (DT * turns).tolist(), angles.tolist()


def spread(robot: Robot, turns: list[float]) -> Floats:
    """Return the standard deviations of increments [rad] by noise."""
    radii = np.array([wheel.radius for wheel in robot.sensed])
    return np.asarray(np.sqrt(NOISE * np.abs(turns) / radii))


def straight(robot: Robot, speed: float = 1.0) -> tuple[list[float], list[float]]:
    kinematics = trundle.Kinematics(robot)
    found = kinematics.inverse([speed, 0.0, 0.0], limit=False)
    angles = found.steering if robot.steered else None
    turns = kinematics.rolling_speeds([speed, 0.0, 0.0], angles, sensed=True)
    return (DT * turns).tolist(), found.steering.tolist()


@pytest.mark.parametrize("name", CATALOG)
def test_how_many_rows_are_too_many(name: str) -> None:
    assert watch(trundle.load(name)).redundancy == REDUNDANT[name]


@pytest.mark.parametrize("freedom", range(1, 9))
@pytest.mark.parametrize("deviations", [1.0, 3.0, 5.0, 6.0])
def test_the_bound_is_that_of_the_chi_square_law(freedom: int, deviations: float) -> None:
    wanted = chi2.isf(2 * norm.sf(deviations), freedom)
    assert chi_square(freedom, deviations) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("name", [n for n in CATALOG if n != "mixed"])
def test_residuals_are_those_of_the_kinematics(name: str) -> None:
    """Where all sensed wheels have motors: the mismatch that ``residual`` tells."""
    robot = trundle.load(name)
    turns, angles = driving(robot)
    turned = np.array(turns) * np.random.default_rng(3).uniform(0.8, 1.2, len(turns))
    kinematics = trundle.Kinematics(robot)
    wanted = kinematics.residual(turned / DT, angles if robot.steered else None)
    _, _, got = watch(robot).step(watch(robot).start, turned.tolist(), angles, DT)
    np.testing.assert_allclose(got, wanted, atol=ROUNDING)


@pytest.mark.parametrize("name", SEEING)
@pytest.mark.parametrize("share", [1.2, 0.8, 0.0])
def test_a_slipping_or_stuck_wheel_is_told_within_a_second(name: str, share: float) -> None:
    robot = trundle.load(name)
    turns, angles = straight(robot)
    for i, wheel in enumerate(robot.sensed):
        search = watch(robot)
        past, slipping = search.start, ()
        turned = [turn * (share if i == j else 1.0) for j, turn in enumerate(turns)]
        for _ in range(SECOND):
            past, slipping, _ = search.step(past, turned, angles, DT)
        if abs(turns[i]) * wheel.radius > 0.5 * DT:  # it turns in this motion
            assert wheel.name in slipping
            assert slipping == (wheel.name,) or name not in TELLING


@pytest.mark.parametrize("name", ["mecanum", "omni4", "two_steered", "omni_steer"])
def test_one_row_too_many_cannot_tell_one_wheel_from_another(name: str) -> None:
    robot = trundle.load(name)
    turns, angles = straight(robot)
    search = watch(robot)
    past, slipping = search.start, ()
    for _ in range(2 * SECOND):
        past, slipping, _ = search.step(past, [1.4 * turns[0], *turns[1:]], angles, DT)
    assert slipping == tuple(wheel.name for wheel in robot.sensed)


@pytest.mark.parametrize("name", SEEING)
def test_noise_alone_is_rarely_told(name: str) -> None:
    """At 3 deviations 0.27 % of the time; unequal wheels may double it, chance add a half."""
    robot = trundle.load(name)
    turns, angles = driving(robot)
    random = np.random.default_rng(list(map(ord, name)))
    search, told, steps = watch(robot, threshold=3.0), 0, 30_000
    noisy = np.array(turns) + random.normal(size=(steps, len(turns))) * spread(robot, turns)
    # A wheel that slides sideways by d on its way s stands as if its angle were off by d / s.
    u, v, r = trundle.Kinematics(robot).odometry_matrix(angles or None) @ turns
    ways = np.array([math.hypot(u - r * w.y, v + r * w.x) for w in robot.steered])
    slides = random.normal(size=(steps, len(angles))) * np.sqrt(NOISE / ways)
    past = search.start
    for turned, seen in zip(noisy.tolist(), (angles + slides).tolist(), strict=True):
        past, slipping, _ = search.step(past, turned, seen, DT)
        told += bool(slipping)
    assert told / steps < 3 * math.erfc(3.0 / math.sqrt(2.0))


@pytest.mark.parametrize("name", ["mecanum", "swerve", "ackermann"])
def test_five_deviations_are_not_reached_by_noise_in_ten_minutes(name: str) -> None:
    robot = trundle.load(name)
    turns, angles = driving(robot)
    random = np.random.default_rng(29)
    noisy = np.array(turns) + random.normal(size=(30_000, len(turns))) * spread(robot, turns)
    search = watch(robot)
    past = search.start
    for turned in noisy.tolist():
        past, slipping, _ = search.step(past, turned, angles, DT)
        assert not slipping


def test_coarse_counters_are_not_taken_for_slip() -> None:
    """Counts of 5 mm at a crawl: the rounded increments never fit together."""
    robot, count = trundle.load("mecanum"), 0.1
    crawl = np.array([0.011, 0.013, 0.012, 0.014])
    fitting = trundle.Kinematics(robot).rolling_speeds(
        trundle.Kinematics(robot).odometry_matrix() @ crawl
    )
    start = np.array([0.01, 0.04, 0.06, 0.09])
    turned = start + np.arange(3000)[:, None] * fitting
    increments = np.diff(np.floor(turned / count) * count, axis=0)
    told = {}
    for resolutions in ((), (count,) * 4):
        search = watch(robot, wheel_noise=1e-6, steering_noise=1e-6, resolutions=resolutions)
        past, told[resolutions] = search.start, 0
        for each in increments.tolist():
            past, slipping, _ = search.step(past, each, (), DT)
            told[resolutions] += bool(slipping)
    assert told[(count,) * 4] == 0
    assert told[()] > 0


def test_slip_that_ended_is_forgotten() -> None:
    robot = trundle.load("swerve")
    turns, angles = straight(robot)
    search = watch(robot)
    past = search.start
    for _ in range(SECOND):
        past, slipping, _ = search.step(past, [1.2 * turns[0], *turns[1:]], angles, DT)
    assert slipping == ("front_left",)
    for _ in range(3 * SECOND):
        past, slipping, _ = search.step(past, turns, angles, DT)
    assert slipping == ()


def test_a_wheel_that_is_left_out_is_not_told() -> None:
    robot = trundle.load("swerve")
    turns, angles = straight(robot)
    search = watch(robot, without=frozenset({"front_left"}))
    past = search.start
    for _ in range(SECOND):
        past, slipping, residuals = search.step(past, [0.0, *turns[1:]], angles, DT)
    assert slipping == ()
    assert residuals == pytest.approx((0.0,) * 4, abs=ROUNDING)
    past = search.start
    for _ in range(SECOND):
        past, slipping, _ = search.step(past, [0.0, *turns[1:3], 1.3 * turns[3]], angles, DT)
    assert "rear_right" in slipping


def test_a_standing_robot_does_not_slip() -> None:
    for name in CATALOG:
        robot = trundle.load(name)
        search = watch(robot)
        still = [0.0] * len(robot.sensed), [0.0] * len(robot.steered)
        _, slipping, residuals = search.step(search.start, *still, DT)
        assert slipping == ()
        assert all(residual == 0.0 for residual in residuals)


def test_a_wheel_that_hides_a_motion_cannot_be_left_out() -> None:
    with pytest.raises(UnobservedMotionError, match="without 'wheel_1'"):
        watch(trundle.load("omni3"), without=frozenset({"wheel_1"}))
