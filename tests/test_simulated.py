"""The simulated robot: its motion, motors, counters, noise and faults."""

import dataclasses
import math

import numpy as np
import pytest

import trundle
from catalogue import CURVED, ODD_DIFFERENTIAL, ODD_OMNI, ODD_OMNI_STEER, ODD_SWERVE, SKEW_SKID
from geometry import allowed_twists
from trundle.bridge import SimulatedRobot
from trundle.robot import CATALOG, Encoder, FixedWheel, OmniWheel, Robot, SteeredWheel

ENCODER = Encoder(ticks_per_motor_turn=2048)
TICK = math.tau / 2048
QUIET = {"encoder": ENCODER, "motor_lag": 0.0, "wheel_noise": 0.0, "steering_noise": 0.0}
# Sums of some hundred steps of a metre or so, each rounded.
ROUNDED = 1e-12
# Robots that steer solve their normal equations at each step: a few digits fewer.
SOLVED = 1e-10
RUNS = 1000
# Four standard deviations of the variance of so many normal samples, sqrt(2 / RUNS).
VARIANCE_BAND = 4 * math.sqrt(2 / RUNS)

ROBOTS = {name: trundle.load(name) for name in CATALOG} | {
    robot.name: robot
    for robot in (ODD_OMNI, ODD_SWERVE, ODD_DIFFERENTIAL, ODD_OMNI_STEER, SKEW_SKID, CURVED)
}
each_robot = pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)


def drive(sim, state, speeds, steering=(), duration=1.0, steps=20):
    """Return the readings and the states of held commands."""
    readings, states = [], [state]
    start = state.time
    for k in range(1, steps + 1):
        reading, state = sim.step(state, start + duration * k / steps, speeds, steering)
        readings.append(reading)
        states.append(state)
    return readings, states


def held(robot, twist=(0.3, 0.1, 0.4)):
    """Return wheel speeds and steering angles of a twist near the given one."""
    found = trundle.Kinematics(robot).inverse(twist)
    return found.wheel_speeds.tolist(), found.steering.tolist()


# ---- motion ---------------------------------------------------------------------------------


@each_robot
def test_held_commands_lead_where_simulate_does(robot):
    speeds, steering = held(robot)
    run = trundle.simulate(
        robot, wheel_speeds=speeds, steering=steering or None, duration=1.0, dt=0.05,
        pose=(0.2, -0.1, 0.7),
    )  # fmt: skip
    sim = SimulatedRobot(robot, **QUIET)
    state = sim.start(time=3.0, pose=(0.2, -0.1, 0.7), steering=steering)
    _, states = drive(sim, state, speeds, steering)
    assert states[-1].time == 4.0
    np.testing.assert_allclose(states[-1].pose, run.pose[-1], atol=SOLVED)
    np.testing.assert_allclose(states[-1].twist, run.twist[-1], atol=SOLVED)


@each_robot
def test_dead_reckoning_of_the_counts_finds_the_way_back(robot):
    random = np.random.default_rng(11)
    sim = SimulatedRobot(robot, **QUIET, counter_bits=None)
    speeds, steering = held(robot)
    state = sim.start(steering=steering)
    counts, middle, steps = [sim.read(state).counts], [], 30
    for k in range(1, steps + 1):
        scale = float(random.uniform(-1, 1))  # stopping, starting and backing on the same path
        before = state.steering
        reading, state = sim.step(state, 0.05 * k, [scale * w for w in speeds], steering)
        counts.append(reading.counts)
        middle.append(np.add(before, reading.steering) / 2)
    turns = np.diff(np.array(counts), axis=0) * [
        (wheel.encoder or ENCODER).radians_per_tick for wheel in robot.sensed
    ]
    found = trundle.dead_reckon(robot, turns, np.array(middle) if robot.steered else None)
    # Counters tell each wheel's turn to a tick at either end; the lever arms are about a metre.
    resolution = 10 * TICK * max(wheel.radius for wheel in robot.sensed)
    np.testing.assert_allclose(found[-1], state.pose, atol=resolution)


def test_off_centre_angles_give_the_least_squares_motion():
    robot = trundle.load("swerve")
    angles, turns = [0.3, -0.5, 1.2, 2.0], np.array([1.0, 2.0, -0.5, 0.7])
    rows, told = [], []
    for wheel, angle, turn in zip(robot.steered, angles, turns, strict=True):
        c, s = math.cos(angle), math.sin(angle)
        rows += [[c, s, wheel.x * s - wheel.y * c], [-s, c, wheel.x * c + wheel.y * s]]
        told += [wheel.radius * turn, 0.0]
    expected = np.linalg.lstsq(np.array(rows), np.array(told), rcond=None)[0]
    sim = SimulatedRobot(robot, **QUIET)
    state = sim.start(steering=angles)
    _, state = sim.step(state, 1.0, turns, angles)
    np.testing.assert_allclose(state.twist, expected, atol=ROUNDED)


def test_wheels_that_disagree_move_a_mecanum_by_least_squares():
    robot = trundle.load("mecanum")
    rows = np.array([wheel.rows().rolling for wheel in robot.driven])
    gains = np.array([wheel.rows().gain for wheel in robot.driven])
    speeds = np.array([5.0, -2.0, 3.0, 7.0])
    expected = np.linalg.lstsq(rows, gains * speeds, rcond=None)[0]
    sim = SimulatedRobot(robot, **QUIET)
    _, state = sim.step(sim.start(), 1.0, speeds)
    np.testing.assert_allclose(state.twist, expected, atol=ROUNDED)


def test_what_no_wheel_tells_does_not_happen():
    bicycle = SimulatedRobot(trundle.load("bicycle", radius=0.3), **QUIET)
    across = [math.pi / 2]  # the front wheel holds it, and nothing tells the yaw rate
    _, state = bicycle.step(bicycle.start(steering=across), 1.0, [1.0], across)
    assert state.pose[2] == pytest.approx(0.0, abs=SOLVED)
    two = Robot(
        name="two",
        wheels=(
            OmniWheel(name="a", x=0.3, y=0.0, radius=0.1, heading=math.pi / 2),
            OmniWheel(name="b", x=-0.3, y=0.0, radius=0.1, heading=math.pi / 2),
        ),
    )
    sim = SimulatedRobot(two, **QUIET)
    _, state = sim.step(sim.start(), 1.0, [1.0, 1.0])
    np.testing.assert_allclose(state.pose, (0.0, 0.1, 0.0), atol=ROUNDED)


def test_a_robot_whose_wheels_hold_each_other_stays():
    locked = Robot(
        name="locked",
        wheels=(
            FixedWheel(name="a", x=0.0, y=0.0, radius=0.1),
            FixedWheel(name="b", x=1.0, y=0.0, radius=0.1, heading=1.0),
            FixedWheel(name="c", x=0.0, y=1.0, radius=0.1, heading=2.0),
            SteeredWheel(name="d", x=0.5, y=0.5, radius=0.1),
        ),
    )
    assert allowed_twists(locked, [0.0]).shape[1] == 0
    sim = SimulatedRobot(locked, **QUIET)
    _, state = sim.step(sim.start(), 1.0, [1.0, 1.0, 1.0, 1.0], [0.3])
    assert state.pose == (0.0, 0.0, 0.0)


# ---- motors and servos ----------------------------------------------------------------------


def test_motors_follow_with_a_lag_that_does_not_depend_on_the_step():
    lag, speed, radius = 0.2, 10.0, 0.05
    sim = SimulatedRobot(
        trundle.load("differential", radius=radius), encoder=ENCODER, motor_lag=lag, wheel_noise=0.0
    )
    way = radius * speed * (1.0 - lag * (1 - math.exp(-1.0 / lag)))  # of w' = (w* - w) / lag
    for steps in (1, 7, 50):
        _, states = drive(sim, sim.start(), [speed, speed], steps=steps)
        assert states[-1].pose[0] == pytest.approx(way, abs=ROUNDED)
        expected = speed * (1 - math.exp(-1.0 / lag))
        assert states[-1].wheel_speeds == pytest.approx((expected, expected), abs=ROUNDED)


def test_a_servo_goes_at_its_rate_and_stops_at_its_limits():
    robot = trundle.load("tricycle").with_wheels(
        steering_rate=2.0, steering_min=-0.5, steering_max=0.5
    )
    sim = SimulatedRobot(robot, **QUIET)
    _, states = drive(sim, sim.start(), [0.0], [0.9], duration=0.4, steps=4)
    assert [state.steering[0] for state in states] == pytest.approx([0.0, 0.2, 0.4, 0.5, 0.5])
    assert sim.start(steering=[2.0]).steering == pytest.approx((0.5,))


def test_linked_wheels_keep_together_at_the_rate_of_the_slowest():
    slow = trundle.load("four_wheel_steered").with_wheels(steering_rate=1.0)
    first = dataclasses.replace(slow.wheels[0], steering_rate=0.25)
    robot = dataclasses.replace(slow, wheels=(first, *slow.wheels[1:]))
    sim = SimulatedRobot(robot, **QUIET)
    _, state = sim.step(sim.start(), 1.0, [0.0] * 4, [0.4, 0.4, -0.4, -0.4])
    assert state.steering == pytest.approx((0.25, 0.4, -0.25, -0.4))


def test_odometry_at_mean_angles_is_right_while_wheels_without_a_rate_turn():
    robot = trundle.load("tricycle", radius=0.1, wheelbase=0.8)
    sim = SimulatedRobot(robot, **QUIET)
    _, state = sim.step(sim.start(), 1.0, [1.0], [0.6])
    assert state.steering == (0.6,)
    assert state.pose[2] == pytest.approx(0.1 * math.sin(0.3) / 0.8, abs=ROUNDED)


# ---- counters -------------------------------------------------------------------------------


def test_counters_show_whole_ticks():
    sim = SimulatedRobot(trundle.load("differential", radius=0.05), **QUIET, seed=5)
    readings, states = drive(sim, sim.start(), [1.0, -0.7], steps=200)
    for reading, state in zip(readings, states[1:], strict=True):
        for count, turn in zip(reading.counts, (state.time, -0.7 * state.time), strict=True):
            signed = count - 2**32 if count >= 2**31 else count
            assert abs(signed * TICK - turn) < TICK


def test_the_first_tick_comes_anywhere():
    """Runs begin anywhere inside a tick, so that the error of a count has no bias."""
    robot = trundle.load("differential")
    count = 100
    starts = np.concatenate(
        [SimulatedRobot(robot, **QUIET, seed=seed).start().turned for seed in range(count)]
    )
    assert 0 <= min(starts) < 0.1 * TICK
    assert 0.9 * TICK < max(starts) < TICK
    # Four standard deviations of the mean of uniform numbers.
    assert np.mean(starts) == pytest.approx(TICK / 2, abs=4 * TICK / math.sqrt(12 * 2 * count))


@pytest.mark.parametrize("bits", [8, 16, 32])
def test_counters_wrap_around(bits):
    robot = trundle.load("differential").with_wheels(encoder=Encoder(ticks_per_motor_turn=1e9))
    narrow = SimulatedRobot(robot, motor_lag=0.0, counter_bits=bits)
    wide = SimulatedRobot(robot, motor_lag=0.0, counter_bits=None)
    shown, _ = drive(narrow, narrow.start(), [30.0, -30.0])
    true, _ = drive(wide, wide.start(), [30.0, -30.0])
    assert min(true[-1].counts) < -(2**bits) / 2 < 2**bits / 2 < max(true[-1].counts)
    for a, b in zip(shown, true, strict=True):
        assert a.counts == tuple(count % 2**bits for count in b.counts)


def test_a_wheels_own_encoder_comes_before_the_given_one():
    robot = trundle.load("mixed")  # its dead wheels have 2048 ticks
    sim = SimulatedRobot(robot, **QUIET | {"encoder": Encoder(ticks_per_motor_turn=1e6)})
    speeds, _ = held(robot, (0.06, 0.0, 0.0))
    reading, _ = sim.step(sim.start(), 1.0, speeds)
    driven, dead = reading.counts[:2], reading.counts[2:]
    assert driven == pytest.approx([1.2 * 1e6 / math.tau] * 2, abs=1)
    assert dead == pytest.approx([2.0 * 2048 / math.tau] * 2, abs=1)


def test_missed_readings_lose_nothing_but_themselves():
    robot = trundle.load("differential")
    sim = SimulatedRobot(robot, encoder=ENCODER, missed=0.3)
    whole = SimulatedRobot(robot, encoder=ENCODER)
    readings, states = drive(sim, sim.start(), [1.0, 1.0], steps=RUNS)
    others, same = drive(whole, whole.start(), [1.0, 1.0], steps=RUNS)
    assert states == same
    kept = [pair for pair in zip(readings, others, strict=True) if pair[0].counts is not None]
    assert all(a == b for a, b in kept)
    # Four standard deviations of a binomial share.
    assert len(kept) / RUNS == pytest.approx(0.7, abs=4 * math.sqrt(0.3 * 0.7 / RUNS))


# ---- noise ----------------------------------------------------------------------------------


def ends(robot, speeds, steering=(), steps=4, **settings):
    """Return the true poses (RUNS, 3) and the sensed turns (RUNS, k) after a second."""
    poses, turns = [], []
    sim = SimulatedRobot(robot, encoder=ENCODER, motor_lag=0.0, **settings)
    for run in range(RUNS):
        start = sim.start(steering=steering)._replace(steps=steps * run)  # noise not yet used
        _, states = drive(sim, start, speeds, steering, steps=steps)
        poses.append(states[-1].pose)
        turns.append(np.subtract(states[-1].turned, start.turned))
    return np.array(poses), np.array(turns)


@pytest.mark.parametrize("steps", [1, 8])
def test_wheel_noise_grows_with_the_way_and_not_with_the_steps(steps):
    noise, track = 1e-4, 0.4
    robot = trundle.load("differential", radius=0.05, track=track)
    poses, turns = ends(robot, [20.0, -20.0], steps=steps, wheel_noise=noise)  # 1 m at each rim
    # Heading: the sum of two rims' errors over the track; x: their mean.
    assert np.var(poses[:, 2]) == pytest.approx(2 * noise / track**2, rel=VARIANCE_BAND)
    assert np.mean(poses[:, 2]) == pytest.approx(
        -2 / track, abs=4 * math.sqrt(2 * noise / track**2 / RUNS)
    )
    assert np.abs(turns - [20.0, -20.0]).max() < ROUNDED  # the encoders do not see it


def test_dead_wheels_read_what_they_roll_and_noise():
    noise, radius = 1e-4, 0.03
    robot = trundle.load("mixed")
    speeds, _ = held(robot, (0.5, 0.0, 0.0))
    poses, turns = ends(robot, speeds, wheel_noise=noise)
    dead = robot.sensed[2]
    x, psi = poses[:, 0], poses[:, 2]
    # It drives nearly straight: the dead wheel rolls x - y_wheel psi to first order in the noise,
    # and the second order (psi^2 of 0.1^2) is below the hundredth that is left to it here.
    error = turns[:, 2] - (x - dead.y * psi) / radius
    variance = noise * 0.5 / radius**2
    assert np.var(error) == pytest.approx(variance, rel=VARIANCE_BAND + 0.01)


def test_steered_wheels_slip_sideways():
    noise, wheelbase = 1e-4, 1.0
    robot = trundle.load("bicycle", radius=0.1, wheelbase=wheelbase)
    poses, _ = ends(robot, [10.0], [0.0], wheel_noise=0.0, steering_noise=noise)  # 1 m ahead
    assert np.var(poses[:, 2]) == pytest.approx(noise / wheelbase**2, rel=VARIANCE_BAND)


def test_at_rest_nothing_moves():
    for robot in ROBOTS.values():
        sim = SimulatedRobot(robot, encoder=ENCODER)
        _, states = drive(sim, sim.start(), [0.0] * len(robot.driven), [0.0] * len(robot.steered))
        assert states[-1].pose == (0.0, 0.0, 0.0)


# ---- values ---------------------------------------------------------------------------------


@each_robot
def test_a_step_is_pure(robot):
    speeds, steering = held(robot)
    first, second = (SimulatedRobot(robot, encoder=ENCODER, seed=3) for _ in range(2))
    _, states = drive(first, first.start(), speeds, steering)
    assert drive(second, second.start(), speeds, steering)[1] == states
    again = first.step(states[5], states[6].time, speeds, steering)
    assert again[1] == states[6]
    other = SimulatedRobot(robot, encoder=ENCODER, seed=4)
    assert drive(other, other.start(), speeds, steering)[1][-1].pose != states[-1].pose
    assert isinstance(hash(states[-1]), int)


def test_no_time_is_no_motion():
    sim = SimulatedRobot(trundle.load("swerve"), encoder=ENCODER)
    _, states = drive(sim, sim.start(), [3.0] * 4, [0.2] * 4)
    _, state = sim.step(states[-1], states[-1].time, [9.0] * 4, [0.2] * 4)
    assert state._replace(steps=0) == states[-1]._replace(steps=0)


# ---- faults ---------------------------------------------------------------------------------


def test_a_wheel_that_slips_spins_faster_and_the_others_carry_the_robot():
    robot = trundle.load("mecanum")
    speeds, _ = held(robot, (0.5, 0.0, 0.0))
    sim = SimulatedRobot(robot, **QUIET, slip={"front_left": 0.2})
    reading, state = sim.step(sim.start(), 1.0, speeds)
    assert state.pose == pytest.approx((0.5, 0.0, 0.0), abs=ROUNDED)
    turns = np.array(reading.counts) * TICK
    np.testing.assert_allclose(turns, [10.0 / 0.8, 10.0, 10.0, 10.0], atol=TICK)
    residual = trundle.Kinematics(robot).residual(turns)
    # A quarter of what its rim spins too far, along the roller's axis.
    too_far = 0.05 * (10.0 / 0.8 - 10.0) * math.cos(math.pi / 4)
    np.testing.assert_allclose(np.abs(residual), too_far / 4, atol=TICK * 0.05)


def test_a_stuck_wheel_drags():
    robot = trundle.load("skid_steer", radius=0.1)
    sim = SimulatedRobot(robot, **QUIET, stuck=["rear_right"])
    reading, state = sim.step(sim.start(), 1.0, [1.0] * 4)
    assert reading.counts[3] == 0
    assert state.wheel_speeds[3] == 0.0
    # Two left rims at 0.1 m, two right ones at 0.1 and 0 m: their means are 0.1 and 0.05 m.
    np.testing.assert_allclose(state.twist, (0.075, 0.0, -0.05 / 0.5), atol=ROUNDED)


def test_a_dead_wheel_may_drag_too():
    robot = trundle.load("mixed")
    speeds, _ = held(robot, (0.3, 0.0, 0.0))
    sim = SimulatedRobot(robot, **QUIET, slip={"dead_left": -1.0}, stuck="dead_right")
    reading, _ = sim.step(sim.start(), 1.0, speeds)
    assert reading.counts[2] * TICK == pytest.approx(5.0, abs=TICK)  # half of 0.3 m / 0.03 m
    assert reading.counts[3] == 0


# ---- errors ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"encoder": None}, "no encoder on 'left', 'right', so there are no counts: add encoder ="),
        ({"slip": {"lft": 0.1}}, r"no wheel 'lft' .*: did you mean 'left'\?; it has left, right"),
        ({"slip": {"left": 1.0}}, "wheel 'left': its slip must be a number below 1, got 1.0"),
        ({"slip": {"left": math.nan}}, "must be a number below 1, got nan"),
        ({"stuck": ["caster"]}, "no wheel 'caster' that could slip or be stuck"),
        ({"motor_lag": -0.1}, "motor_lag must be a finite number, 0 or more, got -0.1"),
        ({"wheel_noise": math.inf}, "wheel_noise must be a finite number"),
        ({"steering_noise": "much"}, "steering_noise must be a finite number"),
        ({"counter_bits": 7}, "counter_bits must be from 8 to 64, or None, got 7"),
        ({"counter_bits": True}, "counter_bits must be from 8 to 64, or None, got True"),
        ({"seed": -1}, "seed must be a whole number, 0 or more, got -1"),
        ({"missed": 1.5}, "missed must be a share from 0 to 1, got 1.5"),
    ],
)
def test_impossible_settings_are_told(settings, message):
    with pytest.raises(trundle.TrundleError, match=message):
        SimulatedRobot(trundle.load("differential"), **{"encoder": ENCODER} | settings)


def test_a_robot_without_sensed_wheels_is_told():
    robot = trundle.load("differential").with_wheels(measured=False)
    with pytest.raises(trundle.TrundleError, match="no sensed wheel, so it gives no counts"):
        SimulatedRobot(robot, encoder=ENCODER)


@pytest.mark.parametrize(
    ("time", "speeds", "steering", "message"),
    [
        (-0.1, [1.0], [0.0], "time must not go backwards: -0.1 s after 0 s"),
        (math.nan, [1.0], [0.0], "time must not go backwards"),
        (0.1, [1.0, 2.0], [0.0], "wheel_speeds must be 1 numbers, got 2"),
        (0.1, [math.nan], [0.0], "wheel_speeds must be finite numbers"),
        (0.1, None, [0.0], "wheel_speeds must be 1 numbers, got None"),
        (0.1, [1.0], [], "steering must be 1 numbers, got 0"),
    ],
)
def test_bad_commands_are_told(time, speeds, steering, message):
    sim = SimulatedRobot(trundle.load("tricycle"), encoder=ENCODER)
    with pytest.raises(trundle.TrundleError, match=message):
        sim.step(sim.start(), time, speeds, steering)
