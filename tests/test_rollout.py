"""Rollouts of many robots: each goes where ``simulate`` takes it alone, whatever the layout.

``simulate`` multiplies steps as complex numbers and is proven elsewhere; what it does not do, noise
and feedback, is held against solutions in closed form.
"""

import importlib.util
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from catalogue import CURVED, ROBOTS, feasible_twists, kinematics
from geometry import Floats
from trundle import (
    Constant,
    Every,
    Policy,
    Robot,
    Stream,
    TrundleError,
    compile_rollout,
    load,
    rollout,
    simulate,
)
from trundle.simulation.rollout import keeping
from trundle.simulation.rollout import prepared as prepared_calls

HAS_NUMBA = importlib.util.find_spec("numba") is not None
needs_numba = pytest.mark.skipif(not HAS_NUMBA, reason="numba is not installed")
DEVICES = ("numpy", pytest.param("cpu", marks=needs_numba))
each_device = pytest.mark.parametrize("device", DEVICES)
each_robot = pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
METHODS = ("exact", "euler", "rk4")

# Some dozens of steps of numbers near 1, each rounded at 1e-16, in another order of operations.
ROUNDING = 1e-13
# What the package promises of floats, as a share of the distance driven.
OF_DISTANCE = 1e-4
# Those of a few steps near the origin, whose numbers have seven digits.
FLOAT_ROUNDING = 2e-6

DT, STEPS, COUNT = 0.1, 7, 3
DIFFERENTIAL, MECANUM = load("differential"), load("mecanum")
RADIUS, TRACK = DIFFERENTIAL.driven[0].radius, DIFFERENTIAL.driven[0].y * 2


def taking_wheel_speeds() -> list[Robot]:
    """Return the robots that wheel speeds and steering angles drive one way only."""
    return [r for r in ROBOTS.values() if trundle.mobility(r).degree == 1 or not r.steered]


def starts(count: int = COUNT) -> Floats:
    return np.random.default_rng(3).normal(size=(count, 3))


def courses(robot: Robot, steps: int = STEPS) -> tuple[Floats, Floats, Floats]:
    """Return twists (T, N, 3) within all limits, and the speeds and angles that give them."""
    twists = 0.2 * feasible_twists(robot, (steps, COUNT), seed=5)
    found = [[kinematics(robot).inverse(twist) for twist in row] for row in twists]
    speeds = np.array([[one.wheel_speeds for one in row] for row in found])
    angles = np.array([[one.steering for one in row] for row in found])
    return twists, speeds, angles.reshape(steps, COUNT, len(robot.steered))


def alone(robot: Robot, pose: Floats, method: str = "exact", **commands: Floats | None) -> Floats:
    """Return the trajectories (T + 1, N, 3) of robots that ``simulate`` drives one by one."""
    runs = [
        simulate(
            robot,
            dt=DT,
            pose=pose[i],
            method=method,
            **{k: None if v is None else v[:, i] for k, v in commands.items()},
        ).pose
        for i in range(len(pose))
    ]
    return np.stack(runs, axis=1)


def random_speeds(*shape: int, robot: Robot = MECANUM, size: float = 20.0) -> Floats:
    speeds = np.random.default_rng(8).normal(size=(*shape, len(robot.driven)))
    return size * speeds


# ---- each robot goes where it goes alone -----------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("robot", taking_wheel_speeds(), ids=lambda robot: robot.name)
def test_streamed_wheel_speeds_drive_as_simulate_does(robot, method):
    _, speeds, angles = courses(robot)
    steering = angles if robot.steered else None
    got = rollout(
        robot, Stream(speeds, steering=steering), dt=DT, pose=starts(), method=method,
        save="trajectory", device="numpy",
    )  # fmt: skip
    wanted = alone(robot, starts(), method, wheel_speeds=speeds, steering=steering)
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("robot", taking_wheel_speeds(), ids=lambda robot: robot.name)
def test_constant_wheel_speeds_are_a_stream_of_the_same(robot):
    _, speeds, angles = courses(robot, steps=1)
    steering = angles[0] if robot.steered else None
    held = [np.repeat(each, 30, axis=0) for each in (speeds, angles)]
    wanted = alone(
        robot, starts(), wheel_speeds=held[0], steering=held[1] if robot.steered else None
    )
    got = rollout(
        robot, Constant(speeds[0], steering=steering), dt=DT, steps=30, pose=starts(),
        device="numpy",
    )  # fmt: skip
    np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    "robot", [r for r in ROBOTS.values() if r is not CURVED], ids=lambda robot: robot.name
)
def test_twists_drive_as_simulate_does(robot):
    twists = courses(robot)[0]
    got = rollout(
        robot, Stream(twist=twists), dt=DT, pose=starts(), save="trajectory", device="numpy"
    )
    np.testing.assert_allclose(
        got.pose, alone(robot, starts(), twist=twists), rtol=0, atol=ROUNDING
    )
    one = rollout(robot, Constant(twist=twists[0]), dt=DT, steps=1, pose=starts(), device="numpy")
    np.testing.assert_allclose(one.pose, got.pose[1], rtol=0, atol=ROUNDING)


def test_what_the_wheels_do_not_allow_of_a_twist_is_left_out():
    got = rollout(DIFFERENTIAL, Constant(twist=[0.3, 5.0, 0.0]), dt=DT, steps=10, device="numpy")
    np.testing.assert_allclose(got.pose, [[0.3, 0.0, 0.0]], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("method", METHODS)
def test_held_commands_go_like_streamed_ones(method):
    """Long constant commands are taken to chords beforehand, short and streamed ones are not."""
    speeds, steps = random_speeds(COUNT), 60
    given = {"dt": DT, "pose": starts(), "method": method, "device": "numpy"}
    held = rollout(MECANUM, Constant(speeds), steps=steps, save="trajectory", **given).pose
    streamed = rollout(MECANUM, Stream(np.repeat(speeds[None], steps, axis=0)), **given).pose
    wanted = alone(MECANUM, starts(), method, wheel_speeds=np.repeat(speeds[None], steps, axis=0))
    np.testing.assert_allclose(held, wanted, rtol=0, atol=10 * ROUNDING)
    np.testing.assert_allclose(streamed, wanted[-1], rtol=0, atol=10 * ROUNDING)


# ---- shapes, layouts and types of commands ---------------------------------------------------


@pytest.fixture(scope="module")
def streamed() -> tuple[Floats, Floats]:
    """Return commands (T, N, 4) and where ``simulate`` goes with them (T + 1, N, 3)."""
    speeds = random_speeds(STEPS, COUNT)
    return speeds, alone(MECANUM, starts(), wheel_speeds=speeds)


@each_device
def test_the_layout_of_commands_does_not_matter(streamed, device):
    speeds, wanted = streamed
    first = np.ascontiguousarray(speeds.swapaxes(1, 2))
    twice = np.repeat(first, 2, axis=2)[:, :, ::2]
    layouts = [Stream(speeds), Stream.wheels_first(first)]
    if device == "numpy":  # others cost a compilation, and read no other way
        layouts += [
            Stream.wheels_first(twice),
            Stream(speeds.tolist()),
            Stream(np.asfortranarray(speeds)),
            Stream(speeds[::-1][::-1]),
            Stream(speeds.astype(">f8")),
            Stream.wheels_first(first[:, ::-1][:, ::-1]),
        ]
    for commands in layouts:
        got = rollout(MECANUM, commands, dt=DT, pose=starts(), device=device)
        np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


@each_device
def test_whole_numbers_are_commands(device):
    whole = np.arange(STEPS * COUNT * 4).reshape(STEPS, COUNT, 4) % 7
    wanted = alone(MECANUM, starts(), wheel_speeds=whole.astype(float))
    got = rollout(MECANUM, Stream(whole), dt=DT, pose=starts(), device=device)
    np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


@each_device
def test_given_arrays_are_not_changed(streamed, device):
    speeds, pose = Stream.wheels_first(streamed[0].swapaxes(1, 2).copy()), starts()
    before = speeds.values.copy()
    for _ in range(2):
        rollout(MECANUM, speeds, dt=DT, pose=pose, device=device)
    np.testing.assert_array_equal(speeds.values, before)
    np.testing.assert_array_equal(pose, starts())


@each_device
def test_one_row_is_for_all_robots(device):
    speeds = random_speeds(STEPS)
    each = np.repeat(speeds[:, None], COUNT, axis=1)
    wanted = alone(MECANUM, starts(), wheel_speeds=each)[-1]
    got = rollout(MECANUM, Stream(speeds), dt=DT, pose=starts(), device=device)
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)
    held = rollout(MECANUM, Constant(speeds[0]), dt=DT, steps=1, pose=starts(), device=device)
    wanted = alone(MECANUM, starts(), wheel_speeds=each[:1])[-1]
    np.testing.assert_allclose(held.pose, wanted, rtol=0, atol=ROUNDING)


def test_one_start_is_for_all_robots_and_the_origin_for_none(streamed):
    speeds, _ = streamed
    for pose in ([1.0, 2.0, 3.0], None):
        wanted = alone(MECANUM, np.tile(pose or [0.0] * 3, (COUNT, 1)), wheel_speeds=speeds)
        got = rollout(MECANUM, Stream(speeds), dt=DT, pose=pose, device="numpy")
        np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


@each_device
def test_the_order_of_robots_does_not_matter(streamed, device):
    speeds, wanted = streamed
    order = [2, 0, 1]
    got = rollout(MECANUM, Stream(speeds[:, order]), dt=DT, pose=starts()[order], device=device)
    np.testing.assert_allclose(got.pose, wanted[-1][order], rtol=0, atol=ROUNDING)


@each_device
def test_two_calls_are_one(streamed, device):
    speeds, wanted = streamed
    half = rollout(MECANUM, Stream(speeds[:3]), dt=DT, pose=starts(), device=device)
    got = rollout(MECANUM, Stream(speeds[3:]), dt=DT, pose=half.pose, device=device)
    np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


@each_device
def test_negated_commands_lead_back(streamed, device):
    speeds, _ = streamed
    there = rollout(MECANUM, Stream(speeds), dt=DT, pose=starts(), device=device)
    back = rollout(MECANUM, Stream(-speeds[::-1]), dt=DT, pose=there.pose, device=device)
    np.testing.assert_allclose(back.pose, starts(), rtol=0, atol=ROUNDING)
    assert np.abs(there.pose - starts()).max() > 0.1


def test_no_steps_leave_robots_where_they_are():
    got = rollout(
        MECANUM, Constant(np.ones(4)), dt=DT, steps=0, pose=starts(), device="numpy",
        save="trajectory",
    )  # fmt: skip
    np.testing.assert_array_equal(got.pose, starts()[None])
    np.testing.assert_array_equal(got.final, starts())
    empty = rollout(MECANUM, Stream(np.zeros((0, COUNT, 4))), dt=DT, pose=starts(), device="numpy")
    np.testing.assert_array_equal(empty.pose, starts())


# ---- what is kept ----------------------------------------------------------------------------


@each_device
@pytest.mark.parametrize("every", [1, 2, 3, STEPS, STEPS + 1])
def test_every_so_many_poses_are_kept(streamed, device, every):
    speeds, wanted = streamed
    got = rollout(MECANUM, Stream(speeds), dt=DT, pose=starts(), save=Every(every), device=device)
    assert got.pose.shape == (STEPS // every + 1, COUNT, 3)
    np.testing.assert_allclose(got.pose, wanted[::every], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(got.final, wanted[-1], rtol=0, atol=ROUNDING)
    assert got.dt == pytest.approx(every * DT, rel=1e-15)


@each_device
@pytest.mark.parametrize("save", ["final", "trajectory"])
def test_out_is_written_and_used_again(streamed, device, save):
    speeds, wanted = streamed
    given: dict[str, Any] = {"dt": DT, "pose": starts(), "save": save, "device": device}
    first = rollout(MECANUM, Stream(speeds), **given)
    assert np.shares_memory(first.pose, first.buffer)
    again = rollout(MECANUM, Stream(-speeds), out=first.buffer, **given)
    assert again.buffer is first.buffer
    assert np.shares_memory(again.pose, first.buffer)
    assert np.abs(again.pose - np.squeeze(wanted[-1])).max() > 0.1
    last = rollout(MECANUM, Stream(speeds), out=again.buffer, **given)
    wanted = wanted if save == "trajectory" else wanted[-1]
    np.testing.assert_allclose(last.pose, wanted, rtol=0, atol=ROUNDING)
    assert last.buffer.shape == (*wanted.shape[:-2], 3, COUNT)


def test_two_results_do_not_share_memory(streamed):
    prepared = compile_rollout(MECANUM, Stream(streamed[0]), dt=DT, pose=starts(), device="numpy")
    first = prepared()
    kept = first.pose.copy()
    prepared(-streamed[0])
    np.testing.assert_array_equal(first.pose, kept)


# ---- floats, blocks, threads and large turns -------------------------------------------------


@needs_numba
@pytest.mark.parametrize("kind", ["random", "straight", "spinning"])
def test_floats_are_right_to_a_share_of_the_distance(kind):
    steps, count, rng = 1000, 64, np.random.default_rng(4)
    twists = rng.normal(size=(steps, count, 3))
    if kind == "straight":
        twists[...] = (20.0, 3.0, 0.0) * rng.uniform(1, 2, (count, 3))
    if kind == "spinning":  # 3000 rad
        twists[...] = (1.0, 0.3, 30.0) * rng.uniform(0.9, 1.1, (count, 3))
    pose = rng.uniform(-1, 1, (count, 3))
    given: dict[str, Any] = {"dt": DT, "pose": pose, "device": "cpu"}
    exact = rollout(MECANUM, Stream(twist=twists), **given).pose
    floats = rollout(MECANUM, Stream(twist=twists), dtype="float32", **given)
    assert floats.pose.dtype == np.float32
    driven = DT * np.linalg.norm(twists[..., :2], axis=-1).sum(axis=0)
    off = np.linalg.norm((floats.pose - exact)[:, :2], axis=-1)
    assert (off <= OF_DISTANCE * driven).all()
    if kind != "straight":
        assert off.max() > 0


@needs_numba
def test_blocks_of_robots_have_no_borders():
    steps, rng = 4, np.random.default_rng(4)
    speeds, pose = rng.normal(size=(steps, 1025, 4)), rng.normal(size=(1025, 3))
    commands = Stream(speeds)
    whole = rollout(MECANUM, commands, dt=DT, pose=pose, device="cpu").pose
    apart = rollout(MECANUM, commands, dt=DT, pose=pose, device="numpy").pose
    np.testing.assert_allclose(whole, apart, rtol=0, atol=ROUNDING)
    for count in (1, 2, 3, 255, 256, 257, 1023, 1024, 1025):
        some = Stream(speeds[:, -count:])
        got = rollout(MECANUM, some, dt=DT, pose=pose[-count:], device="cpu").pose
        np.testing.assert_allclose(got, apart[-count:], rtol=0, atol=ROUNDING)


@needs_numba
def test_threads_do_not_change_a_number():
    import numba

    speeds, most, found = random_speeds(20, 5000), numba.get_num_threads(), []
    for threads in (1, most):
        numba.set_num_threads(threads)
        found.append(rollout(MECANUM, Stream(speeds), dt=DT, device="cpu").pose)
    numba.set_num_threads(most)
    np.testing.assert_array_equal(*found)


@each_device
def test_more_than_half_a_turn_in_a_step(device):
    """Also where it happens in the middle of a run, after steps that turned less."""
    speeds = random_speeds(40, COUNT)
    speeds[20, 1] = (-900.0, 900.0, -900.0, 900.0)  # many turns in a step
    wanted = alone(MECANUM, starts(), wheel_speeds=speeds)
    turns = np.abs(np.diff(wanted[:, :, 2], axis=0))
    assert turns[20, 1] > 2 * math.pi
    assert turns[:20].max() < 3.0
    given: dict[str, Any] = {"dt": DT, "pose": starts(), "save": "trajectory", "device": device}
    prepared = compile_rollout(MECANUM, Stream(speeds), **given)
    for _ in range(2):  # the second call is ready for it
        np.testing.assert_allclose(prepared().pose, wanted, rtol=0, atol=10 * ROUNDING)
    exact = rollout(DIFFERENTIAL, Constant([-900.0, 900.0]), dt=DT, steps=3, device="numpy")
    np.testing.assert_allclose(exact.pose[:, :2], 0.0, atol=ROUNDING)


# ---- feedback --------------------------------------------------------------------------------

GAIN = 0.8
QUARTER = math.pi / 2


def turn_to(t, pose, parameters):  # noqa: ARG001
    (gain,) = parameters
    return 0.5, 0.0, gain * (QUARTER - pose[2])


def mixed_functions(t, pose, parameters):
    slow = np.where(pose[0] > 0.0, 1.0, -1.0) * np.minimum(GAIN, 0.9)
    return slow + math.sin(t) + parameters[0], np.cos(pose[2]) + math.sqrt(4.0) * parameters[1]


def branching(t, pose, parameters):  # noqa: ARG001
    if pose[0] > 0.0 and t < 0.35:
        return 2.0, 1.0
    return (1.0, 3.0) if pose[1] > 0.0 else (3.0, 1.0)


def helped(t, pose, parameters):  # noqa: ARG001
    return helper(pose[0]), math.atan2(pose[1], pose[0])


def helper(x):
    return math.sin(x) + GAIN


def step_by_step(law: Any, parameters: Floats, steps: int, twist: bool) -> Floats:
    """Return the final poses of robots whose law is asked in Python before every step."""
    out = []
    matrix = np.array([[0.5, 0.5], [0.0, 0.0], [-1 / TRACK, 1 / TRACK]]) * RADIUS
    for i, pose in enumerate(starts()):
        for k in range(steps):
            command = np.array(law(k * DT, tuple(pose), tuple(parameters[i])), dtype=float)
            u, v, r = command if twist else matrix @ command
            pose = np.array(trundle.se2.step(*pose, DT * u, DT * v, DT * r))
        out.append(pose)
    return np.array(out)


@pytest.mark.parametrize(
    ("device", "dtype"),
    [("numpy", "float64"), ("numpy", "float32"), pytest.param("cpu", "float32", marks=needs_numba)],
)
def test_a_law_with_twists_and_parameters_of_each_robot(device, dtype):
    gains = np.array([[0.5], [1.0], [2.0]])
    for given in (gains, gains[1]):
        law = Policy(turn_to, output="twist", parameters=given)
        got = rollout(MECANUM, law, dt=DT, steps=20, pose=starts(), device=device, dtype=dtype)
        each = np.broadcast_to(given, (COUNT, 1))
        wanted = step_by_step(turn_to, each, 20, twist=True)
        assert got.pose.dtype == dtype
        # The law's own difference equation has the heading in closed form.
        psi = QUARTER + (1 - each[:, 0] * DT) ** 20 * (starts()[:, 2] - QUARTER)
        atol = ROUNDING if dtype == "float64" else FLOAT_ROUNDING
        np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=atol)
        np.testing.assert_allclose(got.pose[:, 2], psi, rtol=0, atol=atol)


@pytest.mark.parametrize(
    ("device", "law"),
    [
        *(("numpy", law) for law in (mixed_functions, branching, helped)),
        *(pytest.param("cpu", law, marks=needs_numba) for law in (branching, helped)),
    ],
)
def test_laws_are_plain_python(device, law):
    parameters = np.array([[0.1, 0.2], [0.3, -0.2], [0.0, 0.5]])
    got = rollout(
        DIFFERENTIAL, Policy(law, parameters=parameters), dt=DT, steps=9, pose=starts(),
        device=device,
    )  # fmt: skip
    wanted = step_by_step(law, parameters, 9, twist=False)
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)


def law_of(gain, function):
    return lambda t, pose, parameters: (gain * function(pose[0]), gain)  # noqa: ARG005


@pytest.mark.parametrize("function", [np.sin, math.sin])
def test_a_law_may_close_over_numbers_and_functions(function):
    law = law_of(1.5, function)
    got = rollout(DIFFERENTIAL, Policy(law), dt=DT, steps=9, pose=starts(), device="numpy")
    wanted = step_by_step(law, np.zeros((COUNT, 0)), 9, twist=False)
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)


def far_off(t, pose, parameters):  # noqa: ARG001
    return np.linalg.norm(np.array([pose[0], pose[1]])), max(pose[0], 0.1)


def test_numpy_does_not_mix_up_robots():
    """Read over all robots at once, the norm would be that of all their positions together."""
    got = rollout(DIFFERENTIAL, Policy(far_off), dt=DT, steps=9, pose=starts(), device="numpy")
    wanted = step_by_step(far_off, np.zeros((COUNT, 0)), 9, twist=False)
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)


# ---- noise -----------------------------------------------------------------------------------


def test_noise_spreads_a_straight_drive_as_theory_says():
    """To first order: x sums the mean of both wheels, psi their difference, y the sums of psi."""
    count, steps, speed, sigma = 20_000, 40, 10.0, 0.05
    commands = Constant([speed, speed]).with_noise(sigma, seed=5)
    final = rollout(
        DIFFERENTIAL, commands, dt=0.01, steps=steps, pose=np.zeros((count, 3)), device="numpy"
    ).pose
    each = RADIUS * 0.01 * sigma
    turn = each * math.sqrt(2) / TRACK
    run = RADIUS * 0.01 * speed
    # Step k turns by its own amount; y sees half of it in the step, and all of it later.
    lever = np.arange(steps) + 0.5
    wanted = [each * math.sqrt(steps / 2), run * turn * math.sqrt((lever**2).sum())]
    wanted.append(turn * math.sqrt(steps))
    # Of the mean and the spread of so many numbers: four of their own deviations.
    mean = final.mean(axis=0) - [steps * run, 0.0, 0.0]
    assert (np.abs(mean) < 4 * np.array(wanted) / math.sqrt(count)).all()
    np.testing.assert_allclose(final.std(axis=0), wanted, rtol=4 / math.sqrt(2 * count))
    correlation = np.corrcoef(final[:, 1:].T)[0, 1]
    known = lever.sum() / math.sqrt(steps * (lever**2).sum())
    assert abs(correlation - known) < 4 * (1 - known**2) / math.sqrt(count)


def test_each_wheel_and_each_robot_has_its_own_sigma():
    count = 4000
    own = np.repeat([[0.0, 0.0], [0.0, 0.3], [0.2, 0.2]], count, axis=0)
    pose = np.zeros((3 * count, 3))
    given: dict[str, Any] = {"dt": DT, "steps": 1, "pose": pose, "device": "numpy"}
    final = rollout(DIFFERENTIAL, Constant([0.0, 0.0]).with_noise(own, seed=1), **given).pose
    still, one, both = final[:, 2].reshape(3, count)
    np.testing.assert_array_equal(still, 0.0)
    per = RADIUS * DT / TRACK
    within = 4 / math.sqrt(2 * count)
    np.testing.assert_allclose(one.std(), 0.3 * per, rtol=within)
    np.testing.assert_allclose(both.std(), 0.2 * math.sqrt(2) * per, rtol=within)
    shared = rollout(DIFFERENTIAL, Constant([0.0, 0.0]).with_noise([0, 0.3], seed=1), **given).pose
    np.testing.assert_allclose(
        shared[count : 2 * count], final[count : 2 * count], rtol=0, atol=ROUNDING
    )


def test_seeds_make_the_noise():
    commands = Constant(np.ones((COUNT, 4))).with_noise(0.5, seed=1)
    given: dict[str, Any] = {"dt": DT, "steps": 5, "device": "numpy"}
    prepared = compile_rollout(MECANUM, commands, **given)
    first, other = prepared().pose, prepared(seed=2).pose
    np.testing.assert_array_equal(prepared(seed=1).pose, first)
    assert np.abs(first - other).min() > 1e-6
    anew = rollout(MECANUM, Constant(np.ones((COUNT, 4))).with_noise(0.5, seed=2), **given).pose
    np.testing.assert_array_equal(anew, other)
    assert len(np.unique(first)) == first.size  # each robot's is its own


def test_noise_depends_on_neither_number_nor_layout_of_robots():
    speeds, sigma = random_speeds(STEPS, 300), 0.2
    given: dict[str, Any] = {"dt": DT, "device": "numpy"}
    all_of_them = rollout(MECANUM, Stream(speeds).with_noise(sigma, seed=7), **given).pose
    few = rollout(MECANUM, Stream(speeds[:, :5]).with_noise(sigma, seed=7), **given).pose
    np.testing.assert_array_equal(few, all_of_them[:5])
    floats = rollout(
        MECANUM, Stream(speeds).with_noise(sigma, seed=7), dtype="float32", **given
    ).pose
    np.testing.assert_allclose(floats, all_of_them, rtol=0, atol=10 * FLOAT_ROUNDING)


@needs_numba
def test_noise_is_the_same_compiled_and_cut_otherwise(monkeypatch):
    speeds = random_speeds(STEPS, COUNT)
    commands = Stream(speeds).with_noise(0.2, seed=7)
    wanted = rollout(MECANUM, commands, dt=DT, device="numpy").pose
    got = rollout(MECANUM, commands, dt=DT, device="cpu").pose
    np.testing.assert_allclose(got, wanted, rtol=0, atol=10 * ROUNDING)
    monkeypatch.setitem(prepared_calls._AT_ONCE, "cpu", 2 * COUNT)
    cut = rollout(MECANUM, commands, dt=DT, device="cpu").pose
    np.testing.assert_array_equal(cut, got)


@needs_numba
@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("count", [3, 1003, 5000])
def test_poses_are_kept_alike_wherever_they_go(count, dtype):
    """Large arrays are written past the caches, line by line: none is left out, none outside."""
    speeds = random_speeds(1, count)[0]
    prepared = compile_rollout(
        MECANUM, Constant(speeds), dt=DT, steps=40, save=Every(2), dtype=dtype, device="cpu"
    )
    wanted = prepared().buffer
    assert wanted.nbytes < keeping._BEYOND_CACHES
    steps = 2 * -(-keeping._BEYOND_CACHES // wanted[0].nbytes)
    large = compile_rollout(
        MECANUM, Constant(speeds), dt=DT, steps=steps, save=Every(2), dtype=dtype, device="cpu"
    )
    size, untouched = 3 * count * (steps // 2 + 1), -1.5
    for offset in (0, 1, 5, 15):
        memory = np.full(size + 40, untouched, dtype)
        out = memory[offset : offset + size].reshape(-1, 3, count)
        large(out=out)
        np.testing.assert_array_equal(out[: len(wanted)], wanted)
        np.testing.assert_array_equal(out[-1], large().final.T)
        assert (memory[:offset] == untouched).all()
        assert (memory[offset + size :] == untouched).all()
        assert not (out == untouched).any()


# ---- the prepared call -----------------------------------------------------------------------


@each_device
def test_a_prepared_call_takes_other_commands_and_starts(streamed, device):
    speeds, wanted = streamed
    prepared = compile_rollout(MECANUM, Stream(np.zeros_like(speeds)), dt=DT, device=device)
    out = np.empty((3, COUNT))
    for _ in range(3):
        got = prepared(speeds, pose=starts(), out=out)
        assert got.buffer is out
        np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)
        np.testing.assert_array_equal(prepared().pose, np.zeros((COUNT, 3)))


@each_device
def test_a_quick_call_and_a_careful_one_give_the_same(device):
    prepared = compile_rollout(MECANUM, Stream(np.zeros((1, 3, 4))), dt=DT, device=device)
    speeds, pose = random_speeds(1, 3), starts()[:3]
    careful = prepared(speeds, pose=pose, out=np.empty((3, 3))).pose
    for given in (speeds, speeds.tolist()):
        for start in (pose, pose.tolist(), pose.astype(np.float32).astype(float), pose[:, ::-1]):
            wanted = prepared(speeds, pose=np.array(start), out=np.empty((3, 3))).pose
            np.testing.assert_array_equal(prepared(given, pose=start).pose, wanted)
    fast = np.full_like(speeds, 0.0)
    fast[0, 0] = [-4000.0, 4000.0, -4000.0, 4000.0]  # more than half a turn in a step
    wanted = rollout(MECANUM, Stream(fast), dt=DT, pose=pose, device="numpy").pose
    for _ in range(2):
        np.testing.assert_allclose(prepared(fast, pose=pose).pose, wanted, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(prepared(speeds, pose=pose).pose, careful, rtol=0, atol=ROUNDING)
    with pytest.raises(TrundleError, match="value 1 of robot 2 in step 0 is nan"):
        prepared(np.where(np.arange(12).reshape(1, 3, 4) == 9, np.nan, speeds), pose=pose)


def test_a_prepared_call_keeps_the_layout_of_its_commands(streamed):
    speeds, wanted = streamed
    first = speeds.swapaxes(1, 2)
    prepared = compile_rollout(
        MECANUM, Stream.wheels_first(0 * first), dt=DT, pose=starts(), device="numpy"
    )
    np.testing.assert_allclose(prepared(first).pose, wanted[-1], rtol=0, atol=ROUNDING)
    held = compile_rollout(
        MECANUM, Constant(0 * speeds[0]), dt=DT, steps=50, pose=starts(), device="numpy"
    )
    fifty = np.repeat(speeds[:1], 50, axis=0)
    wanted = alone(MECANUM, starts(), wheel_speeds=fifty)
    np.testing.assert_allclose(held(speeds[0]).pose, wanted[-1], rtol=0, atol=10 * ROUNDING)


def test_a_prepared_call_takes_other_parameters():
    first, second = np.array([[1.0], [2.0], [0.5]]), np.array([[0.1], [0.2], [0.3]])
    prepared = compile_rollout(
        MECANUM, Policy(turn_to, output="twist", parameters=first), dt=DT, steps=9, pose=starts(),
        device="numpy",
    )  # fmt: skip
    for gains in (second, first):
        wanted = step_by_step(turn_to, gains, 9, twist=True)
        got = prepared(parameters=gains).pose
        np.testing.assert_allclose(got, wanted, rtol=0, atol=ROUNDING)


# ---- without numba, and interrupted ----------------------------------------------------------


def test_without_numba_numpy_serves_and_says_so(monkeypatch, streamed):
    from trundle.errors import SpeedWarning
    from trundle.simulation.rollout import devices

    monkeypatch.setattr(devices, "has_numba", lambda: False)
    devices._tell_how.cache_clear()
    with pytest.warns(SpeedWarning, match=r"pip install 'trundle\[fast\]'"):
        got = rollout(MECANUM, Stream(streamed[0]), dt=DT, pose=starts())
    assert got.device == "numpy"
    np.testing.assert_allclose(got.pose, streamed[1][-1], rtol=0, atol=ROUNDING)
    rollout(MECANUM, Stream(streamed[0]), dt=DT)  # once is enough
    with pytest.raises(TrundleError, match="compiles its loops with numba"):
        rollout(MECANUM, Stream(streamed[0]), dt=DT, device="cpu")


INTERRUPTED = """
import trundle, numpy as np
robot = trundle.load("differential")
commands = trundle.Constant(np.ones((20_000, 2)))
run = lambda steps: trundle.rollout(robot, commands, dt=0.01, steps=steps, device={device!r})
run(100)
print("ready", flush=True)
try:
    run(10**9)
except KeyboardInterrupt:
    print("heard", run(2).pose.shape, flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals are sent otherwise there")
@each_device
def test_an_interrupt_is_heard(device):
    paths = [str(Path(trundle.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    child = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED.format(device=device)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        time.sleep(0.5)
        sent = time.monotonic()
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=60)
        # A fraction of a second of work, and the rest of a busy machine's.
        assert time.monotonic() - sent < 10.0
    finally:
        child.kill()
    assert out == "heard (20000, 3)\n"
    assert err == ""
    assert child.returncode == 0
