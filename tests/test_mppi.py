"""Model predictive path integral control: its equations, what it reaches, and its limits."""

import dataclasses
import warnings

import numpy as np
import pytest

import trundle
from trundle.control import MPPI
from trundle.control.goal import GoalCost, goal_parameters
from trundle.control.mppi import Plan
from trundle.errors import TrundleError
from trundle.robot import CATALOG
from trundle.simulation import Measurement, Reference
from trundle.simulation.rollout import devices

# Of doubles, over some dozen steps of sums.
ROUNDING = 1e-9
# Of floats: costs of some hundreds, whose differences are divided by a temperature of 1.
ROUNDING_OF_FLOATS = 2e-3
# Speeds that are scaled to their limit are beyond it by a rounding of doubles.
AT_LIMIT = 1 + 1e-9

CIRCLES = np.array([[1.5, 0.3, 0.3], [2.2, -0.5, 0.4], [0.2, 0.1, 0.05]])
SMALL = {"samples": 300, "horizon": 40, "device": "numpy"}


def measured(t=0.0, pose=(0.0, 0.0, 0.0)):
    return Measurement(t, np.array(pose, dtype=float), np.zeros(3))


def wanted(position, velocity=(0.0, 0.0, 0.0)):
    return Reference(np.array(position, dtype=float), np.array(velocity, dtype=float), np.zeros(3))


class Rest:
    """A trajectory that stands at a goal."""

    def __init__(self, goal):
        self.goal = np.array(goal, dtype=float)

    def position(self, t):
        return np.broadcast_to(self.goal, (*np.shape(t), 3)).copy()

    def velocity(self, t):
        return np.zeros((*np.shape(t), 3))

    acceleration = velocity


# ---- the equations, written a second time ----------------------------------------------------


def poses_of(twists, pose, dt):
    """Poses (K, T, 3) after each step, by the arcs' centres."""
    x, y, psi = (np.full(len(twists), value) for value in pose)
    out = []
    for u, v, r in np.moveaxis(twists, 0, -1):
        turn = np.where(np.abs(r * dt) < 1e-12, 1e-12, r * dt)
        ahead = (np.sin(turn) * u - (1 - np.cos(turn)) * v) / turn * dt
        left = ((1 - np.cos(turn)) * u + np.sin(turn) * v) / turn * dt
        c, s = np.cos(psi), np.sin(psi)
        x, y, psi = x + c * ahead - s * left, y + s * ahead + c * left, psi + r * dt
        out.append(np.stack([x, y, psi], axis=-1))
    return np.stack(out, axis=1)


def cost_of(poses, law, reference):
    """Costs (K,) of poses (K, T, 3)."""
    total = np.zeros(len(poses))
    for k in range(poses.shape[1]):
        goal = reference.position + (k + 1) * law.dt * reference.velocity
        error = poses[:, k] - goal
        turn = np.abs(np.exp(1j * error[:, 2]) - 1) ** 2  # 2 (1 - cos)
        total += law.weights @ np.stack([error[:, 0] ** 2, error[:, 1] ** 2, turn])
        for x, y, radius in law.obstacles:
            square = (poses[:, k, 0] - x) ** 2 + (poses[:, k, 1] - y) ** 2
            outer = (radius + law.clearance) ** 2
            n = np.clip((outer - square) / (outer - radius**2), 0, None)
            total += law.near * np.where(n > 1, 100.0, n**2)
    return total


def update_of(cost, twists, before, law):
    """Weights (K,) and the plan (T, 3) by the equations of the docstring, sample by sample."""
    inverse = np.diag(1 / np.square(law.sigma))
    total = np.array(
        [
            each + law.temperature / law.hold * np.sum((before @ inverse) * (drawn - before))
            for each, drawn in zip(cost, twists, strict=True)
        ]
    )
    weights = np.exp(-(total - total.min()) / law.temperature)
    weights /= weights.sum()
    return weights, sum(w * each for w, each in zip(weights, twists, strict=True))


@pytest.mark.parametrize(
    ("device", "dtype", "tolerance"),
    [("numpy", "float64", ROUNDING), ("cpu", "float32", ROUNDING_OF_FLOATS)],
)
def test_costs_weights_and_plan_are_those_of_the_equations(device, dtype, tolerance):
    if device == "cpu":
        pytest.importorskip("numba")
    law = MPPI(
        trundle.load("mecanum").with_wheels(max_speed=12.0), samples=200, horizon=30, hold=4,
        obstacles=CIRCLES, device=device, dtype=dtype, sigma=(0.4, 0.3, 0.8), temperature=20.0,
    )  # fmt: skip
    here, goal = measured(0.7, (0.1, -0.2, 3.0)), wanted((2.5, 0.5, -3.0), (0.2, 0.1, 0.3))
    ramp = np.linspace([0.2, -0.1, 0.3], [0.4, 0.1, -0.2], 30)
    seen = law.foresee(Plan(ramp, 5, 0.7), here, goal)

    np.testing.assert_allclose(
        seen.poses[:, 1:], poses_of(seen.twists, here.pose, law.dt), atol=tolerance
    )
    cost = cost_of(poses_of(seen.twists, here.pose, law.dt), law, goal)
    np.testing.assert_allclose(seen.cost, cost, rtol=tolerance)
    weights, plan = update_of(seen.cost, seen.twists, ramp, law)
    np.testing.assert_allclose(seen.weights, weights, atol=tolerance)
    np.testing.assert_allclose(seen.plan.twists, plan, atol=tolerance)
    np.testing.assert_allclose(
        seen.path[1:], poses_of(seen.plan.twists[None], here.pose, law.dt)[0], atol=ROUNDING
    )
    # The step is the same tick: its first twist is the command.
    twist, after = law.step(Plan(ramp, 5, 0.7), here, goal)
    np.testing.assert_array_equal(after.twists, seen.plan.twists)
    np.testing.assert_array_equal(twist, after.twists[0])
    assert after.tick == 6
    assert weights.max() < 0.5  # else the mean of the samples was not tested


def test_a_place_far_away_on_a_map_changes_nothing():
    far = np.array([1e6, -1e6, 0.0])  # where floats are a sixteenth of a metre apart
    found = []
    for origin in (np.zeros(3), far):
        law = MPPI(trundle.load("mecanum"), obstacles=CIRCLES + origin, **SMALL)
        here, goal = (origin + np.array(each) for each in ((0.1, -0.2, 3.0), (2.5, 0.5, 0.3)))
        seen = law.foresee(None, measured(pose=here), wanted(goal))
        np.testing.assert_allclose(seen.poses[:, 0], np.tile(here, (300, 1)), atol=ROUNDING)
        np.testing.assert_allclose(seen.path[0], here)
        found.append((seen.poses - origin, seen.cost, seen.plan.twists))
    for near, away in zip(*found, strict=True):
        np.testing.assert_allclose(away, near, rtol=ROUNDING_OF_FLOATS, atol=ROUNDING_OF_FLOATS)


def test_noise_has_its_deviation_and_is_held():
    sigma, hold = np.array([0.4, 0.2, 1.5]), 5
    law = MPPI(trundle.load("omni3"), samples=4000, horizon=23, sigma=sigma, hold=hold,
               device="numpy")  # fmt: skip
    ramp = np.linspace([0.0, 0.0, 0.0], [1.0, -1.0, 0.5], 23)
    noise = law.foresee(Plan(ramp, 0, 0.0), measured(), wanted((1, 0, 0))).twists - ramp
    held = noise[:, ::hold]
    # Of 4000 normals the mean is within 5 sigma / sqrt(4000), the deviation within 5 / sqrt(8000).
    assert (np.abs(held.mean(axis=0)) < 0.08 * sigma).all()
    assert (np.abs(held.std(axis=0) / sigma - 1) < 0.056).all()
    flat = held.reshape(4000, -1)
    between = np.corrcoef(flat.T) - np.eye(flat.shape[1])
    assert np.abs(between).max() < 0.08  # independent of each other
    again = np.repeat(held, hold, axis=1)[:, :23]
    np.testing.assert_allclose(noise, again, atol=1e-6)  # of floats near 1


def test_the_plan_goes_on_in_time():
    law = MPPI(trundle.load("omni3"), samples=50, horizon=8, sigma=(1e-6,) * 3, dt=0.1,
               weights=(0, 0, 0), dtype="float64", device="numpy")  # fmt: skip
    ramp = np.linspace([0.0, 0.0, 0.0], [0.7, -0.7, 1.4], 8)
    for late, expected in ((0.1, 1.0), (0.25, 2.5), (0.0, 0.0), (5.0, 7.0)):
        _, plan = law.step(Plan(ramp, 0, 2.0), measured(2.0 + late), wanted((1, 0, 0)))
        rows = np.minimum(np.arange(8) + expected, 7)
        # Samples are a millionth apart, and so the plan is as near to where it went on.
        np.testing.assert_allclose(plan.twists, rows[:, None] * ramp[1], atol=1e-5)


def test_the_default_cost_does_not_depend_on_how_commands_are_given():
    goal = goal_parameters(np.array([1, 0, 0.5]), np.zeros(3), np.ones(3), 10.0, 0.3, CIRCLES)
    robot, twist = trundle.load("omni3"), np.array([0.8, 0.1, 0.5])
    given = {"dt": 0.05, "save": GoalCost(goal), "device": "numpy"}
    held = trundle.rollout(robot, trundle.Constant(twist=twist), steps=40, **given).reduced
    each = trundle.Stream(twist=np.tile(twist, (40, 1)))
    np.testing.assert_allclose(held, trundle.rollout(robot, each, **given).reduced, rtol=ROUNDING)


# ---- what it reaches -------------------------------------------------------------------------

STEERING = {"steering_min": -0.6, "steering_max": 0.6}
SCENES = {
    # size of the scene [m]; the heading's weight, and how near the goal they come, in sizes. Those
    # that cannot move sideways trade what is left of y against the heading.
    "mecanum": ({}, 1.0, 0.2, 0.06),
    "omni3": ({}, 1.0, 0.2, 0.06),
    "swerve": ({}, 1.0, 0.2, 0.06),
    "differential": ({}, 1.0, 0.02, 0.12),
    "bicycle": (STEERING, 1.5, 0.02, 0.1),
    "ackermann": (STEERING, 4.0, 0.02, 0.2),
}
# By hand: 3 sizes at half a size per second cost 18, the squares of what is left summed over time;
# standing still for 7.5 s costs 67.5. They can go at twice that speed, and go around a circle.
OF_STANDING_STILL = 0.3


@pytest.mark.parametrize("name", SCENES)
def test_it_reaches_a_goal_around_a_circle(name):
    changes, size, heading, near = SCENES[name]
    robot = trundle.load(name)
    robot = robot.with_wheels(max_speed=size / robot.driven[0].radius, **changes)
    circle, goal = size * np.array([1.5, 0.1, 0.4]), size * np.array([3.0, 0.0, 0.0])
    law = MPPI(
        robot, obstacles=[circle], clearance=0.3 * size,
        weights=(1 / size**2, 1 / size**2, heading), sigma=(0.5 * size, 0.5 * size, 1.0), **SMALL,
    )  # fmt: skip
    run = trundle.track(robot, Rest(goal), law, duration=7.5, dt=0.05, pose=np.zeros(3))
    clearance = np.hypot(*(run.pose[:, :2] - circle[:2]).T) - circle[2]
    assert clearance.min() > 0
    assert np.hypot(*run.error[-1, :2]) < near * size
    still, at_goal = np.zeros((1, len(run.pose) - 1, 3)), wanted(goal)
    way = cost_of(run.pose[None, 1:], law, at_goal)
    assert way < OF_STANDING_STILL * cost_of(still, law, at_goal)
    assert not run.saturated.any()  # no command was more than the wheels can do


def test_a_cost_of_ones_own_is_minimised():
    def ring(t, pose, command, parameters):
        x, y, _, x_dot, y_dot, _, radius = parameters
        far = (pose[0] - x - t * x_dot) ** 2 + (pose[1] - y - t * y_dot) ** 2
        return 10 * (far - radius**2) ** 2 + 0.01 * command[2] ** 2

    robot = trundle.load("omni3")
    law = MPPI(robot, ring, parameters=[0.5], max_twist=(1, 1, 1), **SMALL)
    run = trundle.track(robot, Rest((1, 0, 0)), law, duration=3.0, dt=0.05, pose=np.zeros(3))
    assert np.abs(run.twist).max() <= AT_LIMIT
    # It goes to the ring; noise keeps it within some centimetres.
    assert abs(np.hypot(*run.error[-1, :2]) - 0.5) < 0.05


# ---- what the wheels can do ------------------------------------------------------------------


def limited(name):
    robot = trundle.load(name)
    fastest = 0.5 / robot.driven[0].radius
    return robot.with_wheels(max_speed=fastest, **(STEERING if robot.steered else {}))


@pytest.mark.parametrize("name", CATALOG)
def test_every_sample_and_every_command_is_within_the_limits(name):
    robot = limited(name)
    law = MPPI(robot, samples=40, horizon=12, hold=1, sigma=(1, 1, 2), device="numpy",
               dtype="float64")  # fmt: skip
    kinematics = trundle.Kinematics(robot)
    seen = law.foresee(None, measured(), wanted((1.0, 0.7, 0.4)))
    drawn = seen.twists.reshape(-1, 3)[:120]
    found = kinematics.inverse(drawn)
    np.testing.assert_allclose(found.residual, 0, atol=ROUNDING)
    most = np.array([wheel.max_speed for wheel in robot.driven])
    share = np.abs(found.wheel_speeds) / most
    assert share.max() <= AT_LIMIT
    assert share.max() > 1 - ROUNDING  # the limit is used

    state, pose = None, np.zeros(3)
    for k in range(4):
        twist, state = law.step(state, measured(0.05 * k, pose), wanted((3.0, 2.0, 1.0)))
        found = kinematics.inverse(twist)
        np.testing.assert_allclose(found.residual, 0, atol=ROUNDING)
        assert (np.abs(found.wheel_speeds) <= most * AT_LIMIT).all()


def test_steering_limits_hold_by_hand():
    # A bicycle of wheelbase 1: |r| <= |u| tan(limit).
    law = MPPI(limited("bicycle"), samples=500, horizon=10, device="numpy", dtype="float64")
    u, v, r = law.foresee(None, measured(), wanted((1, 1, 0))).twists.reshape(-1, 3).T
    bend = np.abs(r) - np.abs(u) * np.tan(0.6)
    assert bend.max() < ROUNDING
    assert (np.abs(bend) < ROUNDING).mean() > 0.2  # many would turn more tightly
    assert np.abs(v).max() < ROUNDING


# ---- the same numbers again ------------------------------------------------------------------


def test_the_same_seed_gives_the_same_commands_on_any_number_of_threads():
    numba = pytest.importorskip("numba")
    robot = trundle.load("mecanum").with_wheels(max_speed=12.0)
    law = MPPI(robot, samples=2100, obstacles=CIRCLES, device="cpu")
    goal, found = wanted((3, 0, 0)), []
    before = numba.get_num_threads()
    for threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
        numba.set_num_threads(threads)
        twist, state = law.step(None, measured(), goal)
        found.append((twist, law.step(state, measured(0.05), goal)[0]))
    numba.set_num_threads(before)
    np.testing.assert_array_equal(found[0], found[1])
    other = dataclasses.replace(law, seed=1)
    assert (other.step(None, measured(), goal)[0] != found[0][0]).any()
    # numpy draws the same samples.
    slow = dataclasses.replace(law, device="numpy")
    mine, theirs = (each.foresee(None, measured(), goal).twists for each in (law, slow))
    np.testing.assert_allclose(mine, theirs, atol=1e-5)  # of floats near 1


def test_without_numba_it_runs_in_numpy(monkeypatch):
    monkeypatch.setattr(devices, "has_numba", lambda: False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that says how to get the speed, once
        law = MPPI(trundle.load("differential"), samples=64, horizon=10)
    twist, _ = law.step(None, measured(), wanted((2, 0, 0)))
    assert twist[0] > 0
    assert twist[1] == 0


# ---- bad input -------------------------------------------------------------------------------

NAN = float("nan")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"robot": "omni3"}, "a Robot is needed"),
        ({"samples": 0}, "samples must be a whole number from 1 on, got 0"),
        ({"horizon": 2.5}, "horizon must be a whole number from 1 on, got 2.5"),
        ({"hold": 0}, "hold must be a whole number from 1 on"),
        ({"seed": -1}, "seed must be a whole number from 0 on, got -1"),
        ({"seed": 2**64}, r"seed must be below 2\*\*64"),
        ({"dt": 0.0}, "dt must be a positive number, got 0.0"),
        ({"temperature": NAN}, "temperature must be a positive number"),
        ({"sigma": (0.1, -0.2, 0.1)}, "sigma must not be negative"),
        ({"sigma": (0.1, 0.1)}, "sigma must be three numbers"),
        ({"sigma": (0, 0, 0)}, "nothing would be tried"),
        ({"sigma": (NAN, 1, 1)}, "sigma"),
        ({"weights": (1, 1, -1)}, "weights must not be negative"),
        ({"max_twist": (1, 1, 0)}, "max_twist must be positive"),
        ({"obstacles": [[1.0, 2.0]]}, "obstacles must be circles"),
        ({"obstacles": [[1.0, 2.0, -0.1]]}, "a radius must not be negative"),
        ({"parameters": [1.0]}, "parameters belong to a cost of one's own"),
        ({"cost": lambda *_: 0.0, "obstacles": [[1, 0, 1]]}, "yours takes parameters"),
        ({"cost": 3.0}, "cost must be a function"),
        ({"cost": lambda *_: "dear"}, "must return a number"),
        ({"device": "abacus"}, "device must be one of"),
        ({"dtype": "float16"}, "dtype must be"),
    ],
)
def test_what_does_not_fit_is_told(changes, message):
    good = {"robot": trundle.load("omni3"), "samples": 8, "horizon": 4, "device": "numpy"}
    with pytest.raises(TrundleError, match=message):
        MPPI(**(good | changes))


def test_what_is_measured_and_wanted_must_be_numbers():
    law = MPPI(trundle.load("omni3"), samples=8, horizon=4, device="numpy")
    with pytest.raises(TrundleError, match="pose"):
        law.step(None, measured(pose=(0, NAN, 0)), wanted((1, 0, 0)))
    with pytest.raises(TrundleError, match="time"):
        law.step(None, measured(NAN), wanted((1, 0, 0)))
    with pytest.raises(TrundleError, match="one pose"):
        law.step(None, measured(pose=np.zeros((8, 3))), wanted((1, 0, 0)))
    with pytest.raises(TrundleError, match="reference position"):
        law.step(None, measured(), wanted((NAN, 0, 0)))


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (Plan(np.zeros((5, 3)), 1, 0.0), r"another horizon: its twists must be \(4, 3\)"),
        (Plan(np.full((4, 3), NAN), 1, 0.0), "the plan's twists must be finite"),
        (Plan(np.zeros((4, 3)), 1, NAN), "the plan's time must be finite"),
        (np.zeros((4, 3)), "state must be the Plan of the last step"),
    ],
)
def test_a_state_must_be_a_plan_of_this_horizon(state, message):
    law = MPPI(trundle.load("omni3"), samples=8, horizon=4, device="numpy")
    with pytest.raises(TrundleError, match=message):
        law.step(state, measured(), wanted((1, 0, 0)))


def test_costs_must_be_finite():
    robot = trundle.load("omni3")
    law = MPPI(robot, weights=(1e38, 1e38, 0), samples=8, horizon=4, device="numpy")
    with pytest.raises(TrundleError, match="the cost of sample 0 is no finite number: inf"):
        law.step(None, measured(), wanted((100, 0, 0)))  # beyond float32
    law = MPPI(robot, lambda *_: np.nan, samples=8, horizon=4, device="numpy")
    with pytest.raises(TrundleError, match="no finite number"):
        law.step(None, measured(), wanted((1, 0, 0)))


@pytest.mark.parametrize("temperature", [1e-310, 1e-30, 1e308])
def test_any_temperature_gives_a_plan(temperature):
    law = MPPI(trundle.load("omni3"), temperature=temperature, samples=50, horizon=4,
               device="numpy", dtype="float64")  # fmt: skip
    with np.errstate(all="raise", under="ignore"):
        seen = law.foresee(None, measured(), wanted((2, 0, 0)))
    if temperature < 1:  # the best sample is the plan
        best = seen.twists[seen.cost.argmin()]
        np.testing.assert_allclose(seen.plan.twists, best, atol=ROUNDING)
    else:
        np.testing.assert_allclose(seen.weights, 1 / 50, rtol=ROUNDING)
