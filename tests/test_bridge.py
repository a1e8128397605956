"""The bridge: limits that keep the path, the watchdog, units, counters, and what it refuses."""

import itertools
import math

import numpy as np
import pytest

import trundle
from catalogue import ROBOTS, each_plane_robot, each_robot
from trundle import Bridge, Encoder, Kinematics, OmniWheel, Robot, TrundleError
from trundle.errors import UnobservedMotionError
from trundle.robot import CATALOG

ENCODER = Encoder(ticks_per_motor_turn=512, gear=10.0)
DT = 0.02
# What a limit may be missed by: rounding of a few dozen operations.
ROUNDING = 1e-9
LIMITS = {
    "max_speed": 1.0,
    "max_reverse_speed": 0.5,
    "max_yaw_rate": 2.0,
    "max_acceleration": 1.0,
    "max_deceleration": 2.0,
    "max_reverse_acceleration": 0.7,
    "max_reverse_deceleration": 1.5,
    "max_yaw_acceleration": 3.0,
    "max_yaw_deceleration": 5.0,
}
each_of_catalogue = pytest.mark.parametrize("name", CATALOG)


def drive(bridge, commands, dt=DT, state=None):
    """Return the outputs of a command for each cycle."""
    state = state or bridge.start()
    outputs = []
    for command in commands:
        output, state = bridge.step(state, state.time + dt, command)
        outputs.append(output)
    return outputs, state


def feasible(robot, twist):
    """Return the nearest twist without limits, from the arrays' inverse kinematics."""
    return np.array(Kinematics(robot).inverse(twist, limit=False).twist)


# ---- the wheels do what the twist says ----------------------------------------------------------


@each_plane_robot
def test_wheel_speeds_and_angles_give_the_twist_that_is_told(robot):
    bridge = Bridge(robot, max_acceleration=2.0, max_yaw_acceleration=4.0)
    rng = np.random.default_rng(3)
    state = bridge.start()
    for command in rng.normal(size=(12, 3)):
        for _ in range(20):
            output, state = bridge.step(state, state.time + DT, command)
        if np.linalg.norm(output.twist) < 1e-6:
            continue
        # The wheels' own rows, wheel by wheel: a contact rolls as fast as its wheel turns.
        angle = dict(zip((w.name for w in robot.steered), output.steering, strict=True))
        for wheel, speed in zip(robot.driven, output.wheel_speeds, strict=True):
            rows = wheel.rows(angle.get(wheel.name, 0.0))
            assert np.dot(rows.rolling, output.twist) == pytest.approx(
                rows.gain * speed, abs=ROUNDING
            )
        for wheel in robot.wheels:
            slip = wheel.rows(angle.get(wheel.name, 0.0)).side_slip
            if slip is not None:
                assert np.dot(slip, output.twist) == pytest.approx(0.0, abs=ROUNDING)


@each_plane_robot
def test_without_limits_a_command_is_the_kinematics_answer(robot):
    bridge = Bridge(robot)
    for command in np.random.default_rng(8).normal(size=(10, 3)):
        output, _ = bridge.step(bridge.start(), DT, command)
        wanted = feasible(robot, command)
        assert np.array(output.twist) == pytest.approx(wanted, abs=ROUNDING)


# ---- saturation keeps direction and curvature ---------------------------------------------------


@each_of_catalogue
@pytest.mark.parametrize("signs", [*itertools.product((1, -1), repeat=3)])
def test_a_saturated_command_keeps_direction_and_curvature_from_rest_on(name, signs):
    robot = trundle.load(name).with_wheels(max_speed=30.0)
    bridge = Bridge(robot, **LIMITS)
    command = np.multiply(signs, (37.0, 21.0, 55.0))
    outputs, _ = drive(bridge, [command] * 200)
    wanted = feasible(robot, command)
    wanted /= np.linalg.norm(wanted)
    moving = [np.array(o.twist) for o in outputs if any(o.twist)]
    assert len(moving) > 150
    for twist in moving:
        assert twist / np.linalg.norm(twist) == pytest.approx(wanted, abs=1e-9)
    u, v, r = moving[-1]
    ahead = LIMITS["max_reverse_speed"] if u < 0 else LIMITS["max_speed"]
    body = max(math.hypot(u / ahead, v / LIMITS["max_speed"]), abs(r) / LIMITS["max_yaw_rate"])
    wheels = max(abs(w) for w in outputs[-1].wheel_speeds) / 30.0
    assert max(body, wheels) == pytest.approx(1.0, abs=1e-9)  # as fast as may be, and no faster


@each_plane_robot
@pytest.mark.parametrize("jerk", [{}, {"max_jerk": 8.0, "max_yaw_jerk": 30.0}])
def test_no_limit_is_exceeded_whatever_is_asked(robot, jerk):
    robot = robot.with_wheels(max_speed=25.0, max_acceleration=60.0)
    bridge = Bridge(robot, **LIMITS, **jerk)
    rng = np.random.default_rng(17)
    before, state = None, bridge.start()
    for command in rng.uniform(-4, 4, size=(25, 3)):
        for _ in range(int(rng.integers(1, 60))):
            output, state = bridge.step(state, state.time + DT, command)
            u, v, r = output.twist
            ahead = LIMITS["max_reverse_speed"] if u < 0 else LIMITS["max_speed"]
            assert math.hypot(u / ahead, v / LIMITS["max_speed"]) <= 1 + ROUNDING
            assert abs(r) <= LIMITS["max_yaw_rate"] + ROUNDING
            assert all(abs(w) <= 25.0 * (1 + ROUNDING) for w in output.wheel_speeds)
            if before is not None:
                assert _acceleration_share(before.twist, output.twist, DT) <= 1 + 1e-6
            before = output


def _acceleration_share(before, after, dt):
    """Return the largest share of LIMITS' accelerations that a change takes."""
    shares = []
    for axis, (a, b) in enumerate(zip(before, after, strict=True)):
        slower = abs(b) < abs(a) if a * b >= 0 else True
        yaw = axis == 2
        if yaw:
            limit = LIMITS["max_yaw_deceleration" if slower else "max_yaw_acceleration"]
        elif axis == 0 and (a if slower else b) < 0:
            limit = LIMITS["max_reverse_deceleration" if slower else "max_reverse_acceleration"]
        else:
            limit = LIMITS["max_deceleration" if slower else "max_acceleration"]
        shares.append(abs(b - a) / dt / limit)
    return max(math.hypot(shares[0], shares[1]), shares[2])


def test_forward_and_reverse_have_limits_of_their_own():
    bridge = Bridge(trundle.load("differential"), **LIMITS)
    outputs, state = drive(bridge, [(5.0, 0.0, 0.0)] * 100)
    ups = np.diff([o.twist[0] for o in outputs])
    assert ups.max() == pytest.approx(1.0 * DT)
    assert outputs[-1].twist[0] == pytest.approx(1.0)
    outputs, state = drive(bridge, [(-5.0, 0.0, 0.0)] * 200, state=state)
    speeds = [1.0, *(o.twist[0] for o in outputs)]
    falls = -np.diff(speeds)
    assert falls[: int(1.0 / (2.0 * DT))] == pytest.approx(2.0 * DT)  # braking ahead
    assert outputs[-1].twist[0] == pytest.approx(-0.5)
    assert falls[30:55] == pytest.approx(0.7 * DT)  # then faster in reverse
    outputs, _ = drive(bridge, [(0.0, 0.0, 0.0)] * 200, state=state)
    assert np.diff([o.twist[0] for o in outputs]).max() == pytest.approx(1.5 * DT)


def test_jerk_is_limited_and_the_target_is_met_without_overshoot():
    bridge = Bridge(
        trundle.load("mecanum"),
        max_acceleration=1.0,
        max_yaw_acceleration=9.0,
        max_jerk=2.0,
        max_yaw_jerk=99.0,
    )
    outputs, _ = drive(bridge, [(1.0, 0.5, 0.3)] * 200)
    twists = np.array([[0, 0, 0], [0, 0, 0], *(o.twist for o in outputs)])
    along = twists @ (1.0, 0.5, 0.0) / math.hypot(1.0, 0.5)
    jerk = np.diff(along, 2) / DT**2
    assert np.abs(jerk).max() <= 2.0 + 1e-6
    assert along.max() <= math.hypot(1.0, 0.5) + ROUNDING
    assert along[-1] == pytest.approx(math.hypot(1.0, 0.5), abs=ROUNDING)
    # Not slower than the limits make it: v / a + a / j, and the rounding of a few cycles.
    least = math.hypot(1.0, 0.5) / 1.0 + 1.0 / 2.0
    assert np.argmax(along > along[-1] - 1e-6) * DT <= least + 4 * DT


# ---- steering -----------------------------------------------------------------------------------


def test_steering_turns_at_rest_before_the_robot_moves():
    robot = trundle.load("swerve").with_wheels(steering_rate=2.0)
    bridge = Bridge(robot, max_acceleration=1.0)
    outputs, _ = drive(bridge, [(0.0, 0.5, 0.0)] * 120)
    turning = [o for o in outputs if "steering rate" in o.limits]
    assert all(o.twist == (0.0, 0.0, 0.0) for o in turning)
    assert len(turning) == math.ceil(math.pi / 2 / (2.0 * DT)) - 1
    assert outputs[-1].twist == pytest.approx((0.0, 0.5, 0.0))


@pytest.mark.parametrize("name", ["tricycle", "ackermann", "two_steered", "swerve", "omni_steer"])
def test_no_wheel_steers_faster_than_it_can(name):
    robot = trundle.load(name).with_wheels(steering_rate=1.5)
    bridge = Bridge(robot, max_acceleration=1.0, max_yaw_acceleration=4.0, max_speed=1.0)
    rng, state = np.random.default_rng(4), bridge.start()
    angles = np.zeros(len(robot.steered))
    for command in rng.uniform(-1, 1, size=(8, 3)):
        for _ in range(400):
            output, state = bridge.step(state, state.time + DT, command)
            assert np.abs(np.array(output.steering) - angles).max() <= 1.5 * DT * (1 + ROUNDING)
            angles = np.array(output.steering)
        # It gets there: no wheel is caught between two angles.
        assert np.array(output.twist) / np.linalg.norm(output.twist) == pytest.approx(
            np.array(feasible(robot, command)) / np.linalg.norm(feasible(robot, command)), abs=1e-6
        )


def test_a_car_at_its_steering_limit_keeps_its_speed_and_its_tightest_curve():
    robot = trundle.load("tricycle", wheelbase=0.8).with_wheels(
        steering_min=-math.radians(30), steering_max=math.radians(30)
    )
    output, _ = Bridge(robot).step(Bridge(robot).start(), DT, (0.5, 0.0, 2.0))
    assert output.limits == ("steering range",)
    assert output.steering == pytest.approx((math.radians(30),))
    # tan(angle) = wheelbase * r / u
    assert output.twist == pytest.approx((0.5, 0.0, 0.5 * math.tan(math.radians(30)) / 0.8))
    asked = (-0.5, 0.0, 2.0)
    output, _ = Bridge(robot).step(Bridge(robot).start(), DT, asked)
    assert output.twist == pytest.approx((-0.5, 0.0, 0.5 * math.tan(math.radians(30)) / 0.8))


def test_linked_steering_on_a_curved_set_is_refused_with_a_reason():
    with pytest.raises(TrundleError, match="curved"):
        Bridge(ROBOTS["curved"])


# ---- the watchdog -------------------------------------------------------------------------------


@each_robot
def test_a_robot_without_commands_stands_within_timeout_and_braking(robot):
    if robot.name == "curved":
        return
    rng = np.random.default_rng(11)
    for dt, timeout in ((0.02, 0.5), (0.013, 0.25), (0.05, 0.21)):
        bridge = Bridge(robot, timeout=timeout, **LIMITS)
        phase = rng.uniform(0, dt)
        _, state = drive(bridge, [(-0.5, 0.6, 1.0)] * 300, dt)
        last = state.time
        u, v, r = state.twist
        ahead = LIMITS["max_reverse_deceleration" if u < 0 else "max_deceleration"]
        braking = max(math.hypot(u / ahead, v / 2.0), abs(r) / 5.0)
        time = last + phase
        curve = np.array(state.twist)
        while True:
            output, state = bridge.step(state, time)
            if time - last < timeout - dt:
                assert np.array(output.twist) == pytest.approx(curve, abs=ROUNDING)
                assert not output.stale
            if not any(output.twist):
                break
            # Its path keeps its curvature on the way to rest.
            assert np.cross(output.twist, curve) == pytest.approx(np.zeros(3), abs=ROUNDING)
            time += dt
        assert output.stale
        assert output.wheel_speeds == pytest.approx(np.zeros(len(robot.driven)), abs=ROUNDING)
        assert time - last <= timeout + braking + ROUNDING
        assert time - last >= timeout + braking - 2 * dt  # nor does it stop harder than it may


def test_a_command_that_comes_in_time_keeps_the_robot_going():
    bridge = Bridge(trundle.load("omni3"), timeout=0.1)
    state = bridge.start()
    for k in range(200):
        command = (0.3, 0.0, 0.0) if k % 5 == 0 else None
        output, state = bridge.step(state, k * DT, command)
        assert output.twist == (0.3, 0.0, 0.0)


def test_the_first_command_after_a_stop_ramps_also_after_a_long_silence():
    bridge = Bridge(trundle.load("differential"), max_acceleration=1.0, max_interval=0.05)
    state = bridge.start(time=0.0)
    output, state = bridge.step(state, 3600.0, (1.0, 0.0, 0.0))
    assert output.twist == pytest.approx((0.05, 0.0, 0.0))
    output, state = bridge.step(state, 3600.02, (1.0, 0.0, 0.0))
    assert output.twist == pytest.approx((0.07, 0.0, 0.0))
    # Silence in full motion: the next cycle, however late, tells rest.
    output, state = bridge.step(state, 4000.0)
    assert output.twist == (0.0, 0.0, 0.0)
    assert output.stale


def test_before_the_first_command_the_robot_stands():
    bridge = Bridge(trundle.load("swerve"))
    output, state = bridge.step(bridge.start(), 1.0)
    assert output.stale
    assert output.twist == (0.0, 0.0, 0.0)
    assert state.refused == 0


# ---- what is refused ----------------------------------------------------------------------------

BAD_COMMANDS = [
    (math.nan, 0.0, 0.0),
    (0.0, math.inf, 0.0),
    (0.0, 0.0, -math.inf),
    (1e9, 0.0, 0.0),
    (1.0, 2.0),
    (1.0, 2.0, 3.0, 4.0),
    "abc",
    "123",
    1.0,
    (None, 0.0, 0.0),
    ("1", "2", "3"),
    (10**400, 0, 0),
    (1j, 0, 0),
    np.zeros((3, 1)),
    np.array(5.0),
    {},
    object(),
]


@pytest.mark.parametrize("bad", BAD_COMMANDS, ids=lambda bad: repr(bad)[:20])
def test_a_bad_command_is_refused_and_counted_and_the_last_good_one_stands(bad):
    bridge = Bridge(trundle.load("mecanum"), timeout=0.5)
    _, state = bridge.step(bridge.start(), 0.0, (0.2, 0.1, 0.3))
    output, after = bridge.step(state, 0.1, bad)
    assert output.twist == (0.2, 0.1, 0.3)
    assert (state.refused, after.refused) == (0, 1)
    assert len(output.refusals) == 1
    # It does not keep the old command young.
    output, after = bridge.step(after, 0.55, bad)
    assert output.stale
    assert after.refused == 2


@pytest.mark.parametrize("bad", [0.1, 0.15])
def test_a_bad_time_is_told_and_moves_nothing(bad):
    bridge = Bridge(trundle.load("mecanum"), max_acceleration=1.0)
    _, state = drive(bridge, [(1.0, 0.0, 0.0)] * 10)
    output, after = bridge.step(state, bad, (1.0, 0.0, 0.0))
    assert output.twist == state.twist
    assert after.time == state.time
    assert "time" in output.refusals[0]


BAD_COUNTS = [
    (1, 2, 3),
    (1, 2, 3, math.nan),
    (1, 2, 3, 4.5),
    (1, 2, 3, None),
    (1, 2, 3, 2**40),
    "1234",
    7,
    np.zeros((4, 1)),
    (1, 2, 3, 10**400),
]


@pytest.mark.parametrize("bad", BAD_COUNTS, ids=lambda bad: repr(bad)[:20])
def test_bad_counts_are_refused_and_counted_and_lose_nothing(bad):
    bridge = Bridge(trundle.load("mecanum"), encoder=ENCODER)
    state = bridge.start()
    _, state = bridge.step(state, 0.1, counts=(0, 0, 0, 0))
    output, state = bridge.step(state, 0.2, counts=bad)
    assert state.refused_counts == 1
    assert len(output.refusals) == 1
    output, state = bridge.step(state, 0.3, counts=(1000, 1000, 1000, 1000))
    assert output.pose == pytest.approx((0.05 * 1000 * ENCODER.radians_per_tick, 0, 0))


def test_counts_without_an_encoder_are_refused_with_the_wheels_names():
    bridge = Bridge(trundle.load("mecanum"))
    output, state = bridge.step(bridge.start(), 0.1, counts=(0, 0, 0, 0))
    assert "front_left" in output.refusals[0]
    assert state.refused_counts == 1


def test_a_counter_that_starts_anew_moves_the_robot_no_metre():
    robot = trundle.load("differential").with_wheels(max_speed=20.0)
    bridge = Bridge(robot, encoder=ENCODER)
    state = bridge.start()
    turn = round(0.02 * 10.0 / ENCODER.radians_per_tick)
    count, told = 1_000_000, []
    for k in range(1, 50):
        count = 0 if k == 25 else count + turn
        output, state = bridge.step(state, k * DT, counts=(count, count))
        told.append(output.pose[0])
    assert state.refused_counts == 1
    assert told[-1] == pytest.approx(0.05 * turn * 47 * ENCODER.radians_per_tick)


# ---- settings -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"timeout": 0.0}, "timeout must be positive"),
        ({"timeout": math.nan}, "timeout must be finite"),
        ({"max_speed": -1.0}, "max_speed must be positive"),
        ({"max_acceleration": "fast"}, "max_acceleration must be a number"),
        ({"max_sped": 1.0}, "did you mean 'max_speed'"),
        ({"counter_bits": 4}, "counter_bits must be"),
        ({"without": ["front"]}, "no sensed wheel 'front'"),
    ],
)
def test_impossible_settings_are_told(settings, words):
    with pytest.raises(TrundleError, match=words):
        Bridge(trundle.load("mecanum"), **settings)


def test_a_bridge_needs_a_robot():
    with pytest.raises(TrundleError, match="needs a Robot"):
        Bridge("mecanum")


# ---- units --------------------------------------------------------------------------------------


def x_drive(arm=0.17, radius=0.05):
    """Return the slides' X-drive: contacts at 45, 315, 135, 225 deg, tangential, all reversed."""
    places = {"FL": 45, "FR": 315, "RL": 135, "RR": 225}
    return Robot(
        name="x_drive",
        wheels=tuple(
            OmniWheel(
                name=name,
                x=arm * math.cos(math.radians(at)),
                y=arm * math.sin(math.radians(at)),
                heading=math.radians(at + 90),
                radius=radius,
                reversed=True,
                encoder=ENCODER,
            )
            for name, at in places.items()
        ),
    )


@pytest.mark.parametrize("command", [(0.3, 0, 0), (0, -0.2, 0), (0, 0, 1.1), (0.3, 0.2, -0.7)])
def test_the_slides_x_drive_from_command_to_rpm_to_counts_to_odometry(command):
    arm, radius = 0.17, 0.05
    bridge = Bridge(x_drive(arm, radius), timeout=10.0, counter_bits=16)
    output, state = bridge.step(bridge.start(), 0.0, command, counts=(0, 0, 0, 0))
    u, v, r = command
    # Slides: v_i = v_x sin th_i - v_y cos th_i - w R, rev/min = v_i 60 / (2 pi a).
    places = np.radians([45, 315, 135, 225])
    rim = u * np.sin(places) - v * np.cos(places) - r * arm
    assert output.rim_speeds == pytest.approx(rim)
    assert output.rpm == pytest.approx(rim * 60 / (2 * math.pi * radius))
    assert output.motor_rpm == pytest.approx(np.array(output.rpm) * 10.0)
    assert output.wheel_speeds == pytest.approx(rim / radius)
    # Contact of each wheel moves as the wheel says: reversed, so against its heading.
    for place, speed in zip(places, output.wheel_speeds, strict=True):
        contact = np.array([u - r * arm * math.sin(place), v + r * arm * math.cos(place)])
        heading = place + math.pi / 2
        moved = contact @ (math.cos(heading), math.sin(heading))
        assert moved == pytest.approx(-radius * speed, abs=ROUNDING)
    # Counters that wrap, read every cycle; a third of the readings is missed.
    turned, rng = np.zeros(4), np.random.default_rng(0)
    for k in range(1, 501):
        turned += rim / radius * DT
        ticks = np.floor(turned / ENCODER.radians_per_tick).astype(int)
        shown = (ticks + 2**15) % 2**16 - 2**15
        missed = rng.random() < 0.3 and k < 500
        output, state = bridge.step(state, k * DT, counts=None if missed else shown.tolist())
    truth = trundle.dead_reckon(x_drive(arm, radius), np.tile(rim / radius * DT, (500, 1)))[-1]
    tick = radius * ENCODER.radians_per_tick
    # One tick of each wheel turns the body by less than tick / arm, and what it then drives, too.
    turn, way = 2 * tick / arm, math.hypot(u, v) * 10.0
    assert abs(output.pose[2] - truth[2]) < turn
    assert np.abs(np.array(output.pose) - truth)[:2].max() < 2 * tick + turn * way
    assert state.refused_counts == 0


@each_plane_robot
def test_odometry_by_counts_comes_to_the_resolution_of_the_counters(robot):
    bridge = Bridge(robot, encoder=ENCODER, timeout=100.0, max_acceleration=1.0)
    kin = Kinematics(robot)
    state, pose = bridge.start(), np.zeros(3)
    turned = np.zeros(len(robot.sensed))
    ticks = np.array([(w.encoder or ENCODER).radians_per_tick for w in robot.sensed])
    for k in range(300):
        command = (0.3, 0.1, 0.4) if k < 150 else (-0.2, 0.2, -0.5)
        counts = np.round(turned / ticks).astype(int)
        output, state = bridge.step(state, (k + 1) * DT, command, counts)
        speeds = kin.rolling_speeds(output.twist, output.steering, sensed=True)
        pose = trundle.se2.step(*pose, *(np.array(output.twist) * DT))
        turned = turned + speeds * DT
    counts = np.round(turned / ticks).astype(int)
    output, state = bridge.step(state, 301 * DT, counts=counts)
    tick = 0.3 * ticks.max()
    # Steering angles are taken as told in the cycle before: exact where they do not change.
    slack = 0.02 if robot.steered else 0.0
    reach = min(math.hypot(w.x, w.y) or 0.1 for w in robot.wheels) or 0.1
    assert np.abs(np.array(output.pose) - pose).max() < 10 * tick / reach + slack


def test_ticks_of_a_cycle_are_those_of_its_length():
    bridge = Bridge(trundle.load("differential", radius=0.05), encoder=ENCODER)
    _, state = bridge.step(bridge.start(), 0.0, (0.1, 0.0, 0.0))
    output, _ = bridge.step(state, 0.04)
    assert output.ticks == pytest.approx([2.0 * 0.04 / ENCODER.radians_per_tick] * 2)


# ---- a pure step --------------------------------------------------------------------------------


@each_of_catalogue
def test_a_step_changes_nothing_and_gives_the_same_again(name):
    bridge = Bridge(trundle.load(name), encoder=ENCODER, **LIMITS)
    state = bridge.start(pose=(1.0, 2.0, 0.5))
    counts = tuple(range(len(bridge.robot.sensed)))
    for k in range(5):
        first = bridge.step(state, k * DT, (0.3, 0.2, 0.1), [c * k for c in counts])
        again = bridge.step(state, k * DT, (0.3, 0.2, 0.1), [c * k for c in counts])
        assert first == again
        state = first[1]
    assert hash(state.twist) == hash(again[1].twist)


# ---- wheels taken out ---------------------------------------------------------------------------


def test_a_wheel_taken_out_is_not_read_and_the_rest_goes_on():
    bridge = Bridge(trundle.load("mecanum"), encoder=ENCODER)
    _, state = bridge.step(bridge.start(), 0.0, counts=(0, 0, 0, 0))
    rest = bridge.without("rear_left")
    output, _ = rest.step(state, 0.1, counts=(100, 100, math.nan, 100))
    assert output.pose == pytest.approx((0.05 * 100 * ENCODER.radians_per_tick, 0, 0), abs=1e-12)


def test_a_wheel_that_is_needed_cannot_be_taken_out():
    with pytest.raises(UnobservedMotionError, match=r"do not observe"):
        Bridge(trundle.load("omni3")).without("wheel_1")


# ---- clocks that fail ---------------------------------------------------------------------------


@pytest.mark.parametrize("broken", [math.nan, None, "now", math.inf])
def test_a_clock_that_shows_no_time_does_not_keep_the_robot_going(broken):
    bridge = Bridge(trundle.load("differential"), timeout=0.5, **LIMITS)
    _, state = drive(bridge, [(0.8, 0.0, 0.3)] * 100)
    told = []
    for _ in range(100):
        output, state = bridge.step(state, broken)
        told.append(output.twist[0])
    assert told[10] == pytest.approx(0.8)
    # As with a good clock: it stands after timeout + v / deceleration, counted in cycles.
    assert np.argmin(np.array(told) > 0) <= math.ceil((0.5 + 0.8 / 2.0) / DT) + 1
    assert output.stale


def test_a_clock_that_is_set_back_makes_old_commands_stale_and_goes_on():
    bridge = Bridge(trundle.load("differential"), encoder=ENCODER, timeout=0.5, **LIMITS)
    state, count = bridge.start(time=1000.0), 0
    for k in range(1, 101):
        count += 50
        _, state = bridge.step(state, 1000.0 + k * DT, (0.8, 0.0, 0.0), (count, count))
    way = state.pose[0]
    count += 50
    output, state = bridge.step(state, 5.0, None, (count, count))
    assert output.stale
    assert output.twist[0] == pytest.approx(0.8 - 2.0 * DT)
    assert state.pose[0] == pytest.approx(way + 50 * 0.05 * ENCODER.radians_per_tick)
    output, state = bridge.step(state, 5.0 + DT, (0.8, 0.0, 0.0))
    assert not output.stale


def test_a_clock_that_stands_for_some_cycles_loses_no_way():
    bridge = Bridge(trundle.load("differential"), encoder=ENCODER, timeout=0.5)
    state = bridge.start()
    for k in range(1, 201):
        coarse = math.floor(k * 0.01 / 0.0156) * 0.0156
        output, state = bridge.step(state, coarse, (0.3, 0.0, 0.0), (k * 40, k * 40))
    output, state = bridge.step(state, 3.0, None, (200 * 40, 200 * 40))
    # The first reading is the start from which the others count.
    assert output.pose[0] == pytest.approx(199 * 40 * 0.05 * ENCODER.radians_per_tick)
    assert state.refused_counts == 0


# ---- stories ------------------------------------------------------------------------------------


@each_plane_robot
def test_with_limited_jerk_a_robot_that_braked_goes_on_and_never_back(robot):
    # A ramp must not begin with the watchdog's deceleration, nor carry an axis beyond zero.
    bridge = Bridge(robot, timeout=0.1, max_jerk=2.0, max_yaw_jerk=20.0, **LIMITS)
    wanted = feasible(robot, (0.9, 0.2, 0.3))
    for pause in (0.2, 0.4, 2.0):
        _, state = drive(bridge, [(0.9, 0.2, 0.3)] * 200)
        _, state = drive(bridge, [None] * round(pause / DT), state=state)
        outputs, state = drive(bridge, [(0.9, 0.2, 0.3)] * 400, state=state)
        twists = np.array([o.twist for o in outputs])
        assert (twists * np.sign(wanted) >= -ROUNDING).all()
        assert np.cross(wanted, twists[-1]) == pytest.approx(np.zeros(3), abs=1e-6)
        assert np.linalg.norm(twists[-1]) > 0.2
        for output in outputs:
            angle = dict(zip((w.name for w in robot.steered), output.steering, strict=True))
            for wheel in robot.wheels:
                slip = wheel.rows(angle.get(wheel.name, 0.0)).side_slip
                if slip is not None:
                    assert np.dot(slip, output.twist) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("name", ["tricycle", "swerve", "two_steered"])
def test_a_reversal_turns_no_wheel(name):
    # Where several axes pass through zero at once, what rounding leaves of them has no direction.
    robot = trundle.load(name).with_wheels(steering_rate=2.0)
    bridge = Bridge(robot, **LIMITS)
    outputs, state = drive(bridge, [(0.5, 0.0, 0.3)] * 150)
    angles = outputs[-1].steering
    outputs, _ = drive(bridge, [(-0.5, 0.0, -0.3)] * 150, state=state)
    assert outputs[-1].twist == pytest.approx((-0.5, 0.0, -0.3))
    for output in outputs:
        assert output.steering == pytest.approx(angles, abs=0.01)


@each_of_catalogue
def test_any_sensed_wheel_may_be_taken_out_while_the_robot_drives(name):
    robot = trundle.load(name)
    bridge, count = Bridge(robot, encoder=ENCODER), len(robot.sensed)
    state = bridge.start()
    for k in range(1, 10):
        _, state = bridge.step(state, k * DT, (0.2, 0.0, 0.1), [7 * k] * count)
    for wheel in robot.sensed:
        try:
            rest = bridge.without(wheel.name)
        except UnobservedMotionError:
            continue
        output, after = rest.step(state, 10 * DT, (0.2, 0.0, 0.1), [70] * count)
        assert output.refusals == ()
        assert np.isfinite(output.pose).all()
        # Taken in again, it counts from its first reading on.
        again, _ = bridge.step(after, 11 * DT, (0.2, 0.0, 0.1), [77] * count)
        assert np.abs(np.subtract(again.pose, output.pose)).max() < 0.01


def test_the_time_of_day_as_a_clock_makes_no_command_stale():
    bridge = Bridge(trundle.load("omni3"), timeout=0.1)
    state = bridge.start(time=1.79e9)
    for k in range(500):
        output, state = bridge.step(state, 1.79e9 + k * DT, (0.3, 0.0, 0.0) if k % 5 == 0 else None)
        assert output.twist == (0.3, 0.0, 0.0)


@pytest.mark.parametrize("kind", [np.int64, np.uint16, np.int8, np.float32, float])
def test_counts_may_be_numbers_of_any_whole_kind(kind):
    bridge = Bridge(trundle.load("mecanum"), encoder=ENCODER, counter_bits=16)
    state = bridge.start()
    _, state = bridge.step(state, 0.1, counts=[kind(0)] * 4)
    output, state = bridge.step(state, 0.2, counts=[kind(100)] * 4)
    assert state.refused_counts == 0
    assert output.pose[0] == pytest.approx(0.05 * 100 * ENCODER.radians_per_tick)


class Hostile:
    """An object that raises whatever one does with it."""

    def __getattr__(self, name):
        raise RuntimeError(name)

    def __iter__(self):
        raise KeyError

    def __repr__(self):
        raise OSError


STRANGE = [
    Hostile(),
    [Hostile()] * 4,
    (10**5000, 0, 0),
    b"abcd",
    {"u": 1.0, "v": 0.0, "r": 0.0},
    {0.1, 0.2, 0.3},
    (True, False, True),
    (x for x in itertools.count()),
    np.ma.masked_array([1.0, 2.0, 3.0], mask=[0, 1, 0]),
    np.array([1 + 2j, 0, 0]),
]


@pytest.mark.parametrize("which", range(len(STRANGE)))
def test_no_object_makes_a_step_raise(which):
    strange = STRANGE[which]
    bridge = Bridge(trundle.load("swerve"), encoder=ENCODER, counter_bits=None)
    state = bridge.start()
    for arguments in (
        {"command": strange},
        {"counts": strange},
        {"counts": (1, 2, 3, 4), "steering": strange},
    ):
        output, _ = bridge.step(state, DT, **arguments)
        assert len(output.refusals) == 1
        assert len(output.refusals[0]) < 150
    assert bridge.step(state, strange)[1].time == pytest.approx(state.time, abs=0.2)


@pytest.mark.parametrize("dt", [0.15, 0.25, 0.4])
def test_cycles_longer_than_a_ramp_goes_on_for_stop_in_time_too(dt):
    bridge = Bridge(trundle.load("differential"), timeout=0.5, **LIMITS)
    _, state = drive(bridge, [(1.0, 0.0, 0.0)] * 60, dt)
    last, time = state.time, state.time
    while any(state.twist):
        time += dt
        _, state = bridge.step(state, time)
    assert time - last <= 0.5 + 1.0 / 2.0 + ROUNDING
