"""The covariance of dead reckoning: against simulated runs, numerical propagation and laws."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

import trundle
from catalogue import ROBOTS, feasible_twists, seen_from, steering_for
from trundle.bridge.uncertainty import make_resolution, make_tracker, tracker_lines
from trundle.errors import TrundleError, UnobservedMotionError
from trundle.robot import CATALOG, FixedWheel, Robot, RollingWheel, SteeredWheel, SwedishWheel

Floats = NDArray[np.float64]

RUNS = 1000
WHEEL_NOISE, STEERING_NOISE = 2e-5, 1e-5  # [m]
COUNT = 5e-4  # rim travel of one count [m]
STEPS = 60  # of each part of a path
# Directions with less than this share of the largest variance are those that no error takes.
RANK = 1e-9
# The noise within a step is right to the fourth order of its turn: here up to 0.1 rad.
STEP = 1e-5
ROUNDING = 1e-12

robots = pytest.mark.parametrize("name", CATALOG)
PATHS = ("forward", "reverse", "spot", "mixture")


# ---- an independent simulation: geometry alone ----------------------------------------------


def row(x: float, y: float, angle: Floats | float) -> Floats:
    """Return the velocity of a body point along a direction, as a row."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c, s, x * s - y * c], axis=-1)


def rolling_row(wheel: RollingWheel, angle: float) -> tuple[Floats, float]:
    """Return the row along which a wheel is held, and the rim's share of it."""
    roller = wheel.roller if isinstance(wheel, SwedishWheel) else 0.0
    return row(wheel.x, wheel.y, wheel.heading + angle + roller), math.cos(roller)


def allowed(robot: Robot) -> Floats:
    """Return a basis of the twists that fixed wheels leave; skidding ones by their mean."""
    held = [
        row(w.x, w.y, w.heading + math.pi / 2)
        for w in robot.wheels
        if isinstance(w, FixedWheel) and not w.skid
    ]
    skid = [
        row(w.x, w.y, w.heading + math.pi / 2)
        for w in robot.wheels
        if isinstance(w, FixedWheel) and w.skid
    ]
    if skid:
        held.append(np.mean(skid, axis=0))
    if not held:
        return np.eye(3)
    _, size, vectors = np.linalg.svd(np.array(held))
    return np.asarray(vectors[int((size > 1e-9).sum()) :].T)


def travel(wheel: RollingWheel, angle: float, moved: Floats) -> Floats:
    """Return the rim's way forwards [m] at body increments (..., 3)."""
    along, share = rolling_row(wheel, angle)
    return np.asarray(moved @ along) / share


def sign(wheel: RollingWheel) -> float:
    return -1.0 if wheel.reversed else 1.0


def nominal(name: str, path: str) -> Floats:
    """Return the body increments (T, 3) that are asked for, feasible for the robot."""
    robot = ROBOTS[name]
    size = 0.02 * max(robot.reach, 0.2)
    bend = 0.01
    parts = {
        "forward": [size, 0.3 * size, bend],
        "reverse": [-size, -0.1 * size, 0.7 * bend],
        "spot": [0.0, 0.0, 3 * bend],
    }
    if name == "bicycle":  # across, its front wheel tells nothing
        parts["spot"] = [0.3 * size, 0.0, bend]
    if name == "synchro":  # never turns
        parts["spot"] = [0.0, size, 0.0]
    legs = list(parts.values()) if path == "mixture" else [parts[path]]
    spaces = {"synchro": np.eye(3)[:, :2], "four_wheel_steered": np.eye(3)[:, [0, 2]]}
    N = spaces.get(name, allowed(robot))
    ramp = 1.0 + 0.3 * np.sin(np.linspace(0.0, 3.0, STEPS))
    increments = np.concatenate([ramp[:, None] * np.array(leg) for leg in legs])
    return np.asarray(increments @ N @ N.T)


def simulate(
    name: str, path: str, random: np.random.Generator, noise: float = 1.0, count: float = COUNT
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return true poses (runs, 3), readings (T + 1, k, runs) [rad], angles (T, s), counts (k,)."""
    robot, asked = ROBOTS[name], nominal(name, path)
    N, angles = allowed(robot), steering_for(robot, asked)
    sensed = robot.sensed
    turned = random.uniform(0.0, 1.0, (len(sensed), RUNS))
    per = np.array([count / wheel.radius for wheel in sensed])
    turned *= per[:, None]
    pose = np.zeros((3, RUNS))
    readings = [np.floor(turned / per[:, None]) * per[:, None]]
    for moved, now in zip(asked, angles, strict=True):
        angle = dict(zip((w.name for w in robot.steered), now, strict=True))
        body, rims = shoved(robot, N, moved, angle, noise, random)
        for i, wheel in enumerate(sensed):
            if wheel.driven:
                turned[i] += sign(wheel) * rims[wheel.name] / wheel.radius
                continue
            seen = travel(wheel, angle.get(wheel.name, 0.0), body)
            seen = seen + random.normal(size=RUNS) * np.sqrt(noise * WHEEL_NOISE * np.abs(seen))
            turned[i] += sign(wheel) * seen / wheel.radius
        pose = moved_along(pose, body.T)
        readings.append(np.floor(turned / per[:, None]) * per[:, None])
    return pose.T, np.array(readings), angles, per


def shoved(
    robot: Robot,
    N: Floats,
    moved: Floats,
    angle: dict[str, float],
    noise: float,
    random: np.random.Generator,
) -> tuple[Floats, dict[str, float]]:
    """Return how bodies (runs, 3) really move where motors turn wheels as asked, and rim ways."""
    rows, told, rims = [], [], {}
    for wheel in robot.driven:
        along, share = rolling_row(wheel, angle.get(wheel.name, 0.0))
        way = float(moved @ along) / share
        rims[wheel.name] = way
        slip = random.normal(size=RUNS) * math.sqrt(noise * WHEEL_NOISE * abs(way))
        rows.append(along)
        told.append(share * (way + slip))
    for wheel in robot.steered:
        along, across = (
            row(wheel.x, wheel.y, wheel.heading + angle[wheel.name] + quarter)
            for quarter in (0.0, math.pi / 2)
        )
        way = abs(float(moved @ along))
        rows.append(across)
        told.append(random.normal(size=RUNS) * math.sqrt(noise * STEERING_NOISE * way))
    return (N @ np.linalg.pinv(np.array(rows) @ N) @ np.array(told)).T, rims


def moved_along(pose: Floats, body: Floats) -> Floats:
    """Return poses (3, ...) moved by increments (3, ...) along arcs, in complex numbers."""
    turn = body[2]
    small = np.abs(turn) < 1e-6
    safe = np.where(small, 1.0, turn)
    chord = np.where(small, 1.0 + 0.5j * turn, (np.exp(1j * safe) - 1.0) / (1j * safe))
    way = np.exp(1j * pose[2]) * chord * (body[0] + 1j * body[1])
    return np.stack([pose[0] + way.real, pose[1] + way.imag, pose[2] + turn])


# ---- the tracker over many runs -------------------------------------------------------------


def matrix(entries: list[Floats]) -> Floats:
    xx, xy, xp, yy, yp, pp = np.broadcast_arrays(*entries)
    return np.stack(
        [np.stack(r, axis=-1) for r in ((xx, xy, xp), (xy, yy, yp), (xp, yp, pp))], axis=-2
    )


def entries_of(P: Floats) -> list[float]:
    return [float(P[i, j]) for i in range(3) for j in range(i, 3)]


def tracked(
    name: str, readings: Floats, angles: Floats, per: Floats, noise: float = 1.0
) -> tuple[Floats, Floats]:
    """Return the estimated poses (runs, 3) and their covariances (runs, 3, 3)."""
    robot = ROBOTS[name]
    track = tracker_lines(robot, noise * WHEEL_NOISE, noise * STEERING_NOISE).compile(np)
    read = make_resolution(robot, per.tolist())
    first = read(0.0, (0.0,) * 6, tuple(angles[0]))
    state = [np.zeros(RUNS)] * 3 + [np.full(RUNS, entry) for entry in first]
    for turns, now in zip(np.diff(readings, axis=0), angles, strict=True):
        state = list(track(*state, *turns, *now)[:9])
    last = np.array(
        [read(float(psi), (0.0,) * 6, tuple(angles[-1])) for psi in np.broadcast_to(state[2], RUNS)]
    )
    return np.stack(state[:3], axis=-1), matrix(state[3:]) + matrix(list(last.T))


def squared_error(error: Floats, P: Floats) -> tuple[float, int]:
    """Return the mean normalised error squared, and the rank that it has to be near."""
    values, vectors = np.linalg.eigh(P)
    kept = values > RANK * values[:, -1:]
    seen = (np.swapaxes(vectors, -1, -2) @ error[..., None])[..., 0]
    rank = int(np.median(kept.sum(axis=-1)))
    parts = np.where(kept, seen**2 / np.where(kept, values, 1.0), 0.0)
    return float(parts.sum(axis=-1).mean()), rank


def band(rank: int, share: float) -> tuple[float, float]:
    low, high = chi2.interval(share, rank * RUNS)
    return float(low) / RUNS, float(high) / RUNS


# ---- covariance against simulated runs ------------------------------------------------------

# The band of each robot's mixed path holds 95 %; of the many single paths and coarse counters,
# where one in twenty would fall out by chance, it holds 99.99 %.
BAND, SURE = 0.95, 0.9999
SEED = 7


def error_squared(name: str, path: str, count: float = COUNT) -> tuple[float, int]:
    random = np.random.default_rng([SEED, len(path), *map(ord, name)])
    pose, readings, angles, per = simulate(name, path, random, count=count)
    found, P = tracked(name, readings, angles, per)
    return squared_error(found - pose, P)


@robots
def test_the_error_of_a_thousand_runs_is_what_the_covariance_says(name: str) -> None:
    mean, rank = error_squared(name, "mixture")
    low, high = band(rank, BAND)
    assert low < mean < high


@robots
@pytest.mark.parametrize("path", PATHS[:-1])
def test_the_covariance_is_right_forwards_in_reverse_and_on_the_spot(name: str, path: str) -> None:
    mean, rank = error_squared(name, path)
    low, high = band(rank, SURE)
    assert low < mean < high


@pytest.mark.parametrize("name", ["differential", "omni3", "two_steered", "ackermann"])
def test_the_counters_resolution_enters_once_at_either_end(name: str) -> None:
    """Counts longer than a step: taken anew at every step they would drown all else."""
    coarse = 12 * COUNT
    mean, rank = error_squared(name, "forward", coarse)
    low, high = band(rank, SURE)
    assert low < mean < high


def test_without_the_resolution_coarse_counters_are_trusted_too_much() -> None:
    random = np.random.default_rng(SEED)
    pose, readings, angles, per = simulate("differential", "forward", random, count=12 * COUNT)
    found, P = tracked("differential", readings, angles, 1e-6 * per)
    mean, rank = squared_error(found - pose, P)
    assert mean > 2 * band(rank, SURE)[1]


# ---- covariance against numerical propagation ------------------------------------------------

START = (0.3, -0.2, 2.0)
P_START = np.array([[3e-4, 2e-5, -1e-5], [2e-5, 2e-4, 4e-5], [-1e-5, 4e-5, 1e-4]])
NUDGE = 1e-6  # finite differences of smooth functions of size 1: to about 1e-10
DIFFERENCES = 1e-6
# A whole step is right but for the fourth order of its turn.
ONE_STEP = 1e-3


def one_step(robot: Robot, size: float) -> tuple[list[float], list[float]]:
    """Return increments of the sensed wheels [rad] and steering angles of a random motion."""
    moved = feasible_twists(robot, (), seed=3)
    moved *= size / max(float(np.abs(moved).max()), 1e-9)
    angles = steering_for(robot, moved)
    at = dict(zip((w.name for w in robot.steered), angles, strict=True))
    turns = [
        sign(w) * float(travel(w, at.get(w.name, 0.0), moved)) / w.radius for w in robot.sensed
    ]
    return turns, angles.tolist()


def jacobian(function: Callable[[Floats], Floats], at: Floats) -> Floats:
    nudges = NUDGE * np.eye(len(at))
    columns = [(function(at + nudge) - function(at - nudge)) / (2 * NUDGE) for nudge in nudges]
    return np.stack(columns, axis=-1)


@robots
@pytest.mark.parametrize("size", [0.0, 0.1, 1.0])
def test_one_step_equals_the_sum_over_its_parts_by_finite_differences(
    name: str, size: float
) -> None:
    """Each part's wheels err on their own; their rows' errors move the pose by differences."""
    robot = ROBOTS[name]
    turns, angles = one_step(robot, size)
    parts = 200
    odometry = trundle.Kinematics(robot).bind().step
    part = np.array(turns) / parts
    rolled = np.array([w.radius for w in robot.sensed]) * np.abs(part)
    at = dict(zip((w.name for w in robot.steered), angles, strict=True))
    body = trundle.Kinematics(robot).odometry_matrix(angles if robot.steered else None) @ part

    def by_pose(pose: Floats) -> Floats:
        return np.array(odometry(*pose, *part, *angles))

    def by_turns(turn: Floats) -> Floats:
        return np.array(odometry(*pose, *turn, *angles))

    pose, P = np.array(START), P_START
    for _ in range(parts):
        F, G = jacobian(by_pose, pose), jacobian(by_turns, part)
        radii = np.array([w.radius for w in robot.sensed])
        S = np.diag(WHEEL_NOISE * rolled / radii**2)
        Q = G @ S @ G.T
        for i, wheel in enumerate(robot.steered):
            way = abs(float(travel(wheel, at[wheel.name], body)))
            effect = slip_effect(robot, angles, i)
            g = jacobian(partial(moved_along, pose), body) @ effect
            Q = Q + STEERING_NOISE * way * np.outer(g, g)
        P = F @ P @ F.T + Q
        pose = by_pose(pose)
    track = make_tracker(robot, WHEEL_NOISE, STEERING_NOISE)
    got = track(*START, *entries_of(P_START), *turns, *angles)
    np.testing.assert_allclose(got[:3], pose, atol=ROUNDING * parts)
    tolerance = (ONE_STEP * size**4 + DIFFERENCES) * float(np.abs(P).max())
    np.testing.assert_allclose(matrix([np.asarray(x) for x in got[3:9]]), P, atol=tolerance)


def slip_effect(robot: Robot, angles: list[float], i: int) -> Floats:
    """Return the twist (3,) that a side slip of 1 at steered wheel i makes, by least squares."""
    N = allowed(robot)
    at = dict(zip((w.name for w in robot.steered), angles, strict=True))
    rolling = [rolling_row(wheel, at.get(wheel.name, 0.0))[0] for wheel in robot.sensed]
    across = [row(w.x, w.y, w.heading + at[w.name] + math.pi / 2) for w in robot.steered]
    return np.asarray(N @ np.linalg.pinv(np.array(rolling + across) @ N)[:, len(rolling) + i])


# ---- laws ------------------------------------------------------------------------------------


def driven_on(robot: Robot, size: float, steps: int) -> tuple[float, ...]:
    """Return the tracker's state after a motion, driven in so many equal steps."""
    turns, angles = one_step(robot, size)
    track = make_tracker(robot, WHEEL_NOISE, STEERING_NOISE)
    state: tuple[float, ...] = (*START, *entries_of(P_START))
    for _ in range(steps):
        state = track(*state, *(turn / steps for turn in turns), *angles)[:9]
    return state


@robots
def test_the_covariance_does_not_depend_on_the_step(name: str) -> None:
    coarse, fine = (driven_on(ROBOTS[name], 1.0, steps) for steps in (10, 300))
    np.testing.assert_allclose(coarse, fine, rtol=STEP, atol=STEP * max(fine[3], fine[6]))


@robots
def test_the_covariance_is_positive_semidefinite(name: str) -> None:
    robot, random = ROBOTS[name], np.random.default_rng(5)
    track = make_tracker(robot, WHEEL_NOISE, STEERING_NOISE)
    state: tuple[float, ...] = (0.0,) * 9
    for size in (0.1, -0.5, 3.0, 1e-9, 0.0, -20.0):
        turns, angles = one_step(robot, size)
        uneven = np.array(turns) * random.uniform(0.5, 1.5, len(turns))
        told = track(*state, *uneven, *angles)
        for entries in (told[3:9], told[12:]):
            values = np.linalg.eigvalsh(matrix([np.asarray(x) for x in entries]))
            assert values[0] >= -ROUNDING * (values[-1] + 1e-30)
        state = told[:9]


@robots
def test_the_covariance_turns_with_the_body_frame(name: str) -> None:
    """A frame turned by an angle in the body, a start heading less by as much: the same path."""
    angle = 0.7
    turned = seen_from(ROBOTS[name], 0.0, 0.0, angle)
    turns, angles = one_step(ROBOTS[name], 0.5)
    here, there = (make_tracker(r, WHEEL_NOISE, STEERING_NOISE) for r in (ROBOTS[name], turned))
    one = here(*START, *entries_of(P_START), *turns, *angles)
    x, y, psi = START
    other = there(x, y, psi + angle, *entries_of(P_START), *turns, *angles)
    np.testing.assert_allclose(one[:2], other[:2], atol=ROUNDING)
    np.testing.assert_allclose(one[3:9], other[3:9], rtol=1e-9, atol=ROUNDING * max(one[3:9]))


@robots
def test_the_pose_is_that_of_the_plain_step(name: str) -> None:
    robot = ROBOTS[name]
    turns, angles = one_step(robot, 0.7)
    wanted = trundle.Kinematics(robot).bind().step(*START, *turns, *angles)
    got = make_tracker(robot, 0.0, 0.0)(*START, *(0.0,) * 6, *turns, *angles)
    np.testing.assert_allclose(got[:3], wanted, atol=ROUNDING)
    assert got[3:9] == (0.0,) * 6


def test_the_increments_covariance_holds_the_resolution_of_two_readings() -> None:
    """Two wheels on an axle of 0.4 m: r = (right - left) / 0.4."""
    robot = trundle.load("differential", radius=0.05, track=0.4)
    told = make_tracker(robot, 0.0, 0.0, resolutions=(0.02, 0.02))(*(0.0,) * 9, 0.0, 0.0)
    count = (0.05 * 0.02) ** 2 / 12
    assert told[12] == pytest.approx(2 * count / 2)
    assert told[17] == pytest.approx(2 * count * 2 / 0.4**2)
    assert told[3:9] == (0.0,) * 6


# ---- wheels that are left out ----------------------------------------------------------------


def test_without_one_wheel_the_others_go_on() -> None:
    robot = trundle.load("mecanum")
    turns = [0.3, 0.5, 0.4, 0.7]
    moved = trundle.Kinematics(robot).odometry_matrix() @ turns
    fitting = trundle.Kinematics(robot).rolling_speeds(moved)
    broken = [*fitting[:2], 1e6, fitting[3]]  # its reading does not count
    track = make_tracker(robot, 1e-4, 1e-4, frozenset({"rear_left"}))
    got = track(*(0.0,) * 9, *broken)
    np.testing.assert_allclose(got[9:12], moved, atol=ROUNDING)
    full = make_tracker(robot, 1e-4, 1e-4)(*(0.0,) * 9, *fitting)
    assert got[8] > full[8]


def test_a_module_of_a_swerve_drive_still_resists_side_slip_when_it_is_not_read() -> None:
    robot = trundle.load("swerve")
    turns, angles = one_step(robot, 0.2)
    whole = make_tracker(robot, 1e-4, 1e-4)(*(0.0,) * 9, *turns, *angles)
    part = make_tracker(robot, 1e-4, 1e-4, frozenset({"front_left", "rear_right"}))
    got = part(*(0.0,) * 9, 0.0, *turns[1:3], 0.0, *angles)
    np.testing.assert_allclose(got[9:12], whole[9:12], atol=ROUNDING)


def test_what_the_others_do_not_observe_is_told() -> None:
    with pytest.raises(UnobservedMotionError, match=r"without 'left': .*do not observe"):
        make_tracker(trundle.load("differential"), 1e-4, 1e-4, frozenset({"left"}))
    with pytest.raises(TrundleError, match="no sensed wheel 'caster'; it has 'left', 'right'"):
        make_tracker(trundle.load("differential"), 1e-4, 1e-4, frozenset({"caster"}))
    bicycle = trundle.load("bicycle")
    assert [w.name for w in bicycle.steered if isinstance(w, SteeredWheel)] == ["front"]
    make_tracker(bicycle, 1e-4, 1e-4)  # observes all but at exactly 90 deg
