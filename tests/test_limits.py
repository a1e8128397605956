"""What trajectories demand of robots, by hand, and the pace at which they keep to the limits."""

import dataclasses
import math
import warnings
from typing import Any

import numpy as np
import pytest

import trundle
from geometry import Floats, rolling_rows
from trundle import motion, track
from trundle.control import ComputedTorque, ReducedComputedTorque
from trundle.errors import TrajectoryWarning, TrundleError
from trundle.limits import Demand, Feasibility, feasibility
from trundle.robot import Motor, OmniWheel, Robot

# Sums of a few products, each rounded at 1e-16 of numbers up to 100.
ROUNDING = 1e-10
# Slopes of sampled angles by central differences, at steps of 1e-2 s of motions of some 1/s.
SAMPLED = 2e-3
# Stretches are found by halving to 1e-9.
HALVED = 1e-8
G = 9.80665

DIFFERENTIAL = trundle.load("differential", radius=0.05, track=0.4).with_body(
    mass=20.0, inertia=0.9, com=(0.0, 0.0)
)
OMNI = trundle.load("omni3").with_body(mass=30.0, inertia=0.5, com=(0.0, 0.0))
TRICYCLE = trundle.load("tricycle", radius=0.1, wheelbase=0.8, track=0.5)
SWERVE = trundle.load("swerve")


def demand(found: Feasibility, name: str) -> Demand:
    (one,) = [each for each in found.demands if each.name == name]
    return one


# ---- a circle by hand ----------------------------------------------------------------------


def test_wheel_speeds_on_a_circle() -> None:
    """2 m at 0.3 rad/s: the wheels roll on circles of 1.8 and 2.2 m."""
    found = feasibility(DIFFERENTIAL.with_wheels(max_speed=10.0), motion.circle(2.0, 0.3))
    speeds = demand(found, "wheel speed")
    assert speeds.wheels == ("left", "right")
    assert speeds.unit == "rad/s"
    np.testing.assert_allclose(speeds.limits, 10.0)
    wanted = [0.3 * 1.8 / 0.05, 0.3 * 2.2 / 0.05]
    np.testing.assert_allclose(speeds.values, np.tile(wanted, (len(found.t), 1)), atol=ROUNDING)
    np.testing.assert_allclose(speeds.share, speeds.values / 10.0, atol=ROUNDING)
    assert found.stretch == speeds.stretch == pytest.approx(1.32, abs=ROUNDING)
    assert not found.feasible
    assert found.follows
    said = " ".join(found.reports)
    assert "wheel speed of right: 13.2 of at most 10 rad/s" in said
    assert "1.32 times" in said
    assert "Stretch time by 1.32" in said


def test_wheel_accelerations_on_a_line() -> None:
    """The minimum-jerk line of 2 m in 4 s: up to 10 / sqrt(3) lengths / duration^2."""
    robot = DIFFERENTIAL.with_wheels(max_acceleration=5.0)
    found = feasibility(robot, motion.line((0, 0), (2, 0), 4.0), dt=0.001)
    turns = demand(found, "wheel acceleration")
    most = 10 / math.sqrt(3) * 2.0 / 4.0**2 / 0.05
    assert np.abs(turns.values).max() == pytest.approx(most, rel=1e-6)
    assert found.stretch == pytest.approx(math.sqrt(most / 5.0), rel=1e-6)


def test_wheel_accelerations_of_an_omnidirectional_robot_on_a_circle() -> None:
    """Facing one way on a circle, wheel i at theta_i turns by w^2 r sin(w t - theta_i) / a."""
    robot = OMNI.with_wheels(max_acceleration=100.0)
    r, w = 1.5, 0.8
    found = feasibility(robot, motion.circle(r, w, heading=0.4))
    values = demand(found, "wheel acceleration").values
    for i, wheel in enumerate(robot.driven):
        theta = wheel.heading + 0.4
        inward = -(w**2) * r * np.stack([np.sin(w * found.t), -np.cos(w * found.t)])
        wanted = (inward[0] * math.cos(theta) + inward[1] * math.sin(theta)) / wheel.radius
        np.testing.assert_allclose(values[:, i], wanted, atol=ROUNDING)


def test_the_torque_on_a_circle_is_that_of_m_w2_r() -> None:
    """The least torques that push with m w^2 r towards the centre."""
    r, w = 1.5, 0.8
    found = feasibility(OMNI.with_wheels(max_torque=1.0), motion.circle(r, w))
    torque = demand(found, "torque")
    A, gains = rolling_rows(OMNI, OMNI.driven, [])
    # Seen from the body the centre is to the left, and the yaw rate does not change.
    wanted = np.linalg.lstsq(
        (A / gains[:, None]).T, np.array([0.0, 30.0 * w**2 * r, 0.0]), rcond=None
    )[0]
    np.testing.assert_allclose(torque.values, np.tile(wanted, (len(found.t), 1)), atol=ROUNDING)
    # Without friction all torques fall with the square of the stretch.
    assert found.stretch == pytest.approx(math.sqrt(np.abs(wanted).max() / 1.0), rel=HALVED)
    assert torque.stretch == found.stretch


def test_torques_with_friction_and_spin_on_a_line() -> None:
    """m a of body and wheels, shared by two, and each wheel's friction."""
    robot = DIFFERENTIAL.with_wheels(
        max_torque=10.0, spin_inertia=0.01, viscous_friction=0.02, coulomb_friction=0.1
    )
    path = motion.line((0, 0), (3, 0), 3.0)
    found = feasibility(robot, path)
    a, v = path.acceleration(found.t)[:, 0], path.velocity(found.t)[:, 0]
    omega = v / 0.05
    wanted = 0.05 / 2 * (20.0 + 2 * 0.01 / 0.05**2) * a
    wanted += 0.02 * omega + 0.1 * np.sign(omega)
    values = demand(found, "torque").values
    np.testing.assert_allclose(values, np.stack([wanted, wanted], axis=-1), atol=ROUNDING)


def on_one_axle() -> Robot:
    """Return a differential drive that stands on its two wheels alone, in balance."""
    return dataclasses.replace(DIFFERENTIAL, wheels=DIFFERENTIAL.wheels[:2])


@pytest.mark.parametrize(("r", "w"), [(2.0, 0.5), (0.5, -2.0)])
def test_friction_on_a_circle_is_v2_over_r_g(r: float, w: float) -> None:
    """Both wheels of one axle hold the same share of m w^2 r with half of m g."""
    found = feasibility(on_one_axle().with_wheels(friction=0.4), motion.circle(r, w))
    needed = demand(found, "friction with the ground")
    np.testing.assert_allclose(needed.values, w**2 * r / G, rtol=1e-9)
    np.testing.assert_allclose(needed.share, w**2 * r / G / 0.4, rtol=1e-9)
    assert found.stretch == pytest.approx(math.sqrt(w**2 * r / G / 0.4), rel=HALVED)


def test_a_caster_that_carries_nothing_changes_no_friction() -> None:
    """The centre of mass over the axle, as on many differential drives: the caster is idle."""
    found = feasibility(DIFFERENTIAL.with_wheels(friction=0.4), motion.circle(2.0, 0.5))
    needed = demand(found, "friction with the ground")
    np.testing.assert_allclose(needed.values, 0.5**2 * 2.0 / G, rtol=1e-6)


def test_friction_counts_what_pushes_and_what_holds() -> None:
    """On a circle at growing speed: sqrt((dv/dt)^2 + (v^2/r)^2) / g with wheels close together.

    The track is small against the radius, so that both wheels push alike.
    """

    class Growing:
        """A circle of 5 m at 0.2 + 0.1 t rad/s, facing along the path."""

        duration = 4.0

        def position(self, t: Any) -> Floats:
            a = 0.2 * t + 0.05 * t**2
            return np.stack([5 * np.sin(a), 5 - 5 * np.cos(a), a], axis=-1)

        def velocity(self, t: Any) -> Floats:
            a, w = 0.2 * t + 0.05 * t**2, 0.2 + 0.1 * t
            return np.stack([5 * w * np.cos(a), 5 * w * np.sin(a), w], axis=-1)

        def acceleration(self, t: Any) -> Floats:
            a, w = 0.2 * t + 0.05 * t**2, 0.2 + 0.1 * t
            x = 5 * 0.1 * np.cos(a) - 5 * w**2 * np.sin(a)
            y = 5 * 0.1 * np.sin(a) + 5 * w**2 * np.cos(a)
            return np.stack([x, y, 0.1 + 0 * t], axis=-1)

    robot = trundle.load("differential", radius=0.05, track=0.002).with_body(
        mass=20.0, inertia=1e-6, com=(0.0, 0.0)
    )
    robot = dataclasses.replace(robot, wheels=robot.wheels[:2]).with_wheels(friction=1.0)
    found = feasibility(robot, Growing())
    needed = demand(found, "friction with the ground").values
    wanted = np.hypot(5 * 0.1, 5 * (0.2 + 0.1 * found.t) ** 2) / G
    np.testing.assert_allclose(needed, np.stack([wanted, wanted], axis=-1), rtol=1e-5)


# ---- steering ------------------------------------------------------------------------------


def steered_by_hand(path: Any, t: Floats, wheelbase: float) -> Floats:
    """Return the front wheel's angle atan(l kappa) along the path, with the path's curvature."""
    x_d, y_d, _ = path.velocity(t).T
    x_dd, y_dd, _ = path.acceleration(t).T
    curvature = (x_d * y_dd - y_d * x_dd) / np.hypot(x_d, y_d) ** 3
    return np.arctan(wheelbase * curvature)


@pytest.mark.parametrize("dt", [0.01, 0.005])
def test_steering_angle_and_rate_of_a_tricycle(dt: float) -> None:
    robot = TRICYCLE.with_wheels(steering_rate=0.5, steering_min=-1.2, steering_max=1.2)
    path = motion.ellipse(3.0, 2.0, 0.5)
    found = feasibility(robot, path, dt=dt)
    angle = steered_by_hand(path, found.t, 0.8)
    np.testing.assert_allclose(demand(found, "steering angle").values[:, 0], angle, atol=ROUNDING)
    h = 1e-5
    rate = steered_by_hand(path, found.t + h, 0.8) - steered_by_hand(path, found.t - h, 0.8)
    rate /= 2 * h
    got = demand(found, "steering rate")
    # One-sided differences at both ends, as where nothing lies beyond.
    np.testing.assert_allclose(got.values[1:-1, 0], rate[1:-1], atol=SAMPLED)
    assert got.stretch == pytest.approx(np.abs(rate).max() / 0.5, rel=SAMPLED)
    # Along the path the front wheel is faster than the axle: v / cos(angle).
    fast = feasibility(robot.with_wheels(max_speed=1.0), path)
    v = np.hypot(*path.velocity(fast.t)[:, :2].T)
    wanted = v / np.cos(steered_by_hand(path, fast.t, 0.8)) / 0.1
    np.testing.assert_allclose(demand(fast, "wheel speed").values[:, 0], wanted, atol=1e-9)


def test_a_steering_angle_that_is_out_of_reach_is_told_and_no_pace_helps() -> None:
    """A circle of 1 m takes atan(0.8) = 38.7 deg of a wheel that turns to 5.7 deg."""
    robot = TRICYCLE.with_wheels(steering_min=-0.1, steering_max=0.1)
    found = feasibility(robot, motion.circle(1.0, 0.3))
    angle = demand(found, "steering angle")
    np.testing.assert_allclose(angle.values, math.atan(0.8), atol=ROUNDING)
    assert found.stretch == math.inf
    assert not found.feasible
    assert "steering angle of front" in " ".join(found.reports)
    assert "at any pace" in " ".join(found.reports)


def test_a_steering_range_that_does_not_lie_about_zero() -> None:
    """Turns to the left only, up to 1.2 rad and at least by 0.2 rad."""
    robot = TRICYCLE.with_wheels(steering_min=0.2, steering_max=1.2)
    near, far = motion.circle(1.0, 0.3), motion.circle(1.0, -0.3)
    assert feasibility(robot, near).stretch == 0.0
    assert feasibility(robot, near).feasible
    for wrong in (far, motion.circle(10.0, 0.1)):  # 38.7 deg to the right; 4.6 deg to the left
        assert not feasibility(robot, wrong).feasible


def test_a_wheel_that_steers_in_no_range_at_all() -> None:
    """Locked straight ahead it follows a straight line, and no circle; nothing is 0 / 0."""
    robot = TRICYCLE.with_wheels(steering_min=0.0, steering_max=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ahead = feasibility(robot, motion.line((0, 0), (2, 0), 2.0))
        round_about = feasibility(robot, motion.circle(1.0, 0.3))
    assert ahead.feasible
    assert not round_about.feasible
    assert np.isfinite(demand(ahead, "steering angle").share).all()


@pytest.mark.parametrize("dt", [0.01, 0.002])
def test_from_rest_a_wheel_stands_ready_for_where_it_will_go(dt: float) -> None:
    """A straight line at 45 deg, facing along x: no wheel turns while the robot moves."""
    robot = SWERVE.with_wheels(steering_rate=1.0)
    found = feasibility(robot, motion.line((0, 0), (2, 2), 4.0, heading=0.0), dt=dt)
    np.testing.assert_allclose(demand(found, "steering rate").values, 0.0, atol=1e-6)
    assert found.feasible


def test_a_corner_at_a_standstill_is_not_measured_by_the_step() -> None:
    """The wheels turn by 90 deg while the robot stands: at once, or at no pace, but not at 78 %."""
    robot = SWERVE.with_wheels(steering_rate=1.0)
    path = motion.cubic_via([(0, 0), (2, 2), (0, 4)], (0, 4, 8), via_velocity=(0, 0), heading=0.0)
    stretches = [feasibility(robot, path, dt=dt).stretch for dt in (0.02, 0.01, 0.005)]
    assert stretches[0] == pytest.approx(stretches[2]) or math.isinf(stretches[0])


# ---- the pace ------------------------------------------------------------------------------

MOTOR = Motor(torque_constant=0.05, resistance=2.0, gear=20.0, max_voltage=5.0, max_current=0.6)
LOSSY: dict[str, Any] = {"viscous_friction": 0.01, "coulomb_friction": 0.01, "spin_inertia": 0.01}
LIMITED: dict[str, tuple[Robot, Any]] = {
    "speed": (DIFFERENTIAL.with_wheels(max_speed=5.0), motion.ellipse(2, 1, 0.8)),
    "acceleration": (OMNI.with_wheels(max_acceleration=2.0), motion.circle(1, 1.2, heading=0.0)),
    "torque": (OMNI.with_wheels(max_torque=0.7, **LOSSY), motion.figure_eight(3, 0.8)),
    "motor": (DIFFERENTIAL.with_wheels(motor=MOTOR, **LOSSY), motion.ellipse(2, 1, 1.5)),
    "friction": (
        DIFFERENTIAL.with_body(com=(-0.05, 0.0)).with_wheels(friction=0.1),
        motion.ellipse(2, 1, 1.5),
    ),
    "steering rate": (TRICYCLE.with_wheels(steering_rate=0.2), motion.ellipse(3, 2, 0.6)),
    "all of them": (
        SWERVE.with_wheels(max_speed=6.0, max_acceleration=9.0, steering_rate=0.4, max_torque=3.0,
                           friction=0.3, **LOSSY),
        motion.ellipse(2, 1, 0.7, heading=motion.spin(0.3), duration=1.5),
    ),
}  # fmt: skip
LOOK = 0.02  # s between two looks at a trajectory
each_limited = pytest.mark.parametrize(("robot", "path"), LIMITED.values(), ids=LIMITED)
SIMPLE = {name: case for name, case in LIMITED.items() if name != "all of them"}
each_simple = pytest.mark.parametrize(("robot", "path"), SIMPLE.values(), ids=SIMPLE)


@each_limited
def test_stretched_as_told_a_trajectory_is_just_feasible(robot: Robot, path: Any) -> None:
    """Looked at as often as before it uses all of a limit, and a per mille faster too much."""
    found = feasibility(robot, path, dt=LOOK)
    assert 1.0 < found.stretch < math.inf
    assert not found.feasible
    looks = {"dt": LOOK * found.stretch}
    just = feasibility(robot, path.stretched(found.stretch), **looks)
    assert just.stretch == pytest.approx(1.0, abs=HALVED)
    assert just.feasible
    assert just.reports == ()
    most = max(each.share.max() for each in just.demands)
    assert most == pytest.approx(1.0, abs=1e-6)
    faster = feasibility(robot, path.stretched(0.999 * found.stretch), **looks)
    assert not faster.feasible
    assert faster.reports[-1].startswith("Stretch time by 1.001")


@each_simple
def test_stretched_as_told_a_trajectory_is_feasible_however_often_one_looks(
    robot: Robot, path: Any
) -> None:
    """The peak between two looks is missed by a part in ten thousand; nobody stretches again."""
    stretch = feasibility(robot, path, dt=LOOK).stretch
    assert feasibility(robot, path.stretched(stretch), dt=LOOK).feasible


@each_simple
def test_the_pace_of_a_stretched_trajectory_is_the_inverse(robot: Robot, path: Any) -> None:
    found = feasibility(robot, path, dt=LOOK)
    slow = feasibility(robot, path.stretched(2.0), dt=2 * LOOK)
    assert slow.stretch == pytest.approx(found.stretch / 2, rel=1e-6)
    for here, there in zip(found.demands, slow.demands, strict=True):
        assert here.stretch / 2 == pytest.approx(there.stretch, rel=1e-6)


def test_the_motor_is_limited_by_voltage_at_speed_and_by_current_at_rest() -> None:
    """U = R tau / (N k) + N k omega, i = tau / (N k), by hand along the path."""
    robot, path = LIMITED["motor"]
    found = feasibility(robot, path)
    torque, told = demand(found, "torque"), demand(found, "voltage")
    path_speeds = demand(feasibility(robot.with_wheels(max_speed=1.0), path), "wheel speed").values
    per_ampere = 20.0 * 0.05
    voltage = 2.0 * torque.values / per_ampere + per_ampere * path_speeds
    np.testing.assert_allclose(told.values, voltage, atol=ROUNDING)
    np.testing.assert_allclose(told.share, np.abs(voltage) / 5.0, atol=ROUNDING)
    np.testing.assert_allclose(torque.share, np.abs(torque.values) / 0.6, atol=ROUNDING)
    assert (told.share > torque.share).any()
    slow = feasibility(DIFFERENTIAL.with_wheels(motor=MOTOR), motion.line((0, 0), (1, 0), 1.0))
    share = demand(slow, "torque")
    assert share.share[0] == pytest.approx(share.values[0] / 0.6)


def test_a_feasible_trajectory_is_followed_without_a_limit_reached() -> None:
    """What feasibility promises holds in closed loop; faster by a tenth it fails."""
    robot = OMNI.with_wheels(max_torque=0.7, viscous_friction=0.01, spin_inertia=0.01)
    path = motion.figure_eight(3.0, 0.8)
    stretch = feasibility(robot, path).stretch
    law = ComputedTorque([4] * 3, [4] * 3)
    slow = track(robot, path.stretched(1.001 * stretch), law, dt=0.005, method="rk4")
    assert slow.reports == ()
    assert slow.torques is not None
    assert np.abs(slow.torques).max() == pytest.approx(0.7, rel=3e-3)
    fast = track(robot, path.stretched(0.9 * stretch), law, dt=0.005, method="rk4")
    assert len(fast.reports) == 1


def test_a_feasible_trajectory_of_a_differential_drive_takes_the_torques_told() -> None:
    robot = DIFFERENTIAL.with_body(com=(0.1, 0.0)).with_wheels(max_torque=5.0, spin_inertia=0.01)
    path = motion.ellipse(2.0, 1.0, 0.8)
    found = feasibility(robot, path, dt=0.002)
    run = track(robot, path, ReducedComputedTorque(), dt=0.002)
    assert run.torques is not None
    # Torques are held over a step.
    told = demand(found, "torque").values
    np.testing.assert_allclose(run.torques, told[: len(run.torques)], atol=2e-3)


def test_a_path_at_another_pace_has_no_limit_to_lose() -> None:
    for heading in ("path", 0.3):
        found = feasibility(OMNI, motion.circle(1.0, 0.5, heading=heading))
        assert found.stretch == 0.0
        assert found.demands == ()
        assert found.feasible
        assert found.reports == ()


def test_friction_that_eats_all_torque_is_told_at_any_pace() -> None:
    robot = DIFFERENTIAL.with_wheels(max_torque=0.1, coulomb_friction=0.2)
    found = feasibility(robot, motion.circle(2.0, 0.3))
    assert found.stretch == math.inf
    assert not found.feasible
    assert "torque of" in found.reports[0]
    assert found.reports[0].endswith("at any pace.")


def test_without_masses_the_limits_of_the_wheels_are_left() -> None:
    bare = Robot(name="bare", wheels=OMNI.wheels)
    robot = bare.with_wheels(max_speed=1.0, max_acceleration=1.0, max_torque=1.0, friction=0.1)
    found = feasibility(robot, motion.circle(1.0, 0.5))
    assert [each.name for each in found.demands] == ["wheel speed", "wheel acceleration"]


def test_only_wheels_with_a_limit_are_looked_at() -> None:
    wheels = [dataclasses.replace(wheel) for wheel in OMNI.wheels]
    wheels[1] = dataclasses.replace(wheels[1], max_speed=2.0)
    found = feasibility(dataclasses.replace(OMNI, wheels=tuple(wheels)), motion.circle(1.0, 0.5))
    speeds = demand(found, "wheel speed")
    assert speeds.wheels == (wheels[1].name,)
    assert speeds.values.shape == (len(found.t), 1)


# ---- motions that no wheel allows ----------------------------------------------------------


def test_a_heading_that_is_impossible_is_told() -> None:
    """Facing along x on a circle of 1 m at 1 rad/s: sin(t) m/s sideways are missing."""
    found = feasibility(DIFFERENTIAL, motion.circle(1.0, 1.0, heading=0.0))
    assert not found.follows
    assert not found.feasible
    wanted = np.stack([0 * found.t, np.sin(found.t), 0 * found.t], axis=-1)
    np.testing.assert_allclose(found.miss, wanted, atol=ROUNDING)
    assert "1 m/s sideways are missing" in found.reports[0]
    assert "heading along the path" in found.reports[0]


def test_what_is_possible_is_not_called_missing() -> None:
    for name in ("differential", "tricycle", "ackermann", "bicycle", "swerve", "skid_steer"):
        found = feasibility(trundle.load(name), motion.ellipse(5.0, 4.0, 0.2), dt=0.05)
        assert found.follows, name
        assert found.feasible, name


def test_a_skidding_robot_needs_friction_on_a_circle() -> None:
    """What holds it on its circle are side forces of the ground: m v^2 / r of m g at the least."""
    robot = trundle.load("skid_steer").with_wheels(friction=0.01)
    found = feasibility(robot, motion.circle(1.0, 1.0))
    assert not found.feasible
    needed = demand(found, "friction with the ground").values
    assert needed.max(axis=1).min() > 1.0 / G * (1 - 1e-6)


def test_a_robot_that_would_tip_says_so() -> None:
    """Two wheels carry a body whose masses lie ahead of the axle: no load, so no friction."""
    robot = on_one_axle().with_body(com=(0.1, 0.0)).with_wheels(friction=0.5)
    found = feasibility(robot, motion.circle(2.0, 0.3))
    assert not found.feasible
    assert "nan" not in " ".join(found.reports)
    assert "tip" in " ".join(found.reports)


# ---- trajectories and bad input ------------------------------------------------------------


class Own:
    """A circle of a user: functions of one time, without a duration."""

    def position(self, t: float) -> list[float]:
        return [math.sin(t), 1 - math.cos(t), t]

    def velocity(self, t: float) -> list[float]:
        return [math.cos(t), math.sin(t), 1.0]

    def acceleration(self, t: float) -> list[float]:
        return [-math.sin(t), math.cos(t), 0.0]


def test_own_trajectories_are_looked_at_too() -> None:
    robot = DIFFERENTIAL.with_wheels(max_speed=10.0, max_acceleration=3.0, max_torque=1.0)
    own = feasibility(robot, Own(), duration=2.0)
    wanted = feasibility(robot, motion.circle(1.0, 1.0), duration=2.0)
    np.testing.assert_array_equal(own.t, wanted.t)
    assert own.t[-1] == 2.0
    for here, there in zip(own.demands, wanted.demands, strict=True):
        np.testing.assert_allclose(here.values, there.values, atol=ROUNDING)
    assert own.stretch == pytest.approx(wanted.stretch, rel=HALVED)
    with pytest.raises(TrundleError, match="give a duration"):
        feasibility(robot, Own())


def test_the_whole_of_a_trajectory_is_looked_at() -> None:
    path = motion.line((0, 0), (2, 0), 4.0)
    for dt in (0.01, 0.03, 1.7, 100.0):
        found = feasibility(DIFFERENTIAL, path, dt=dt)
        assert found.t[0] == 0.0
        assert found.t[-1] == 4.0
        assert np.diff(found.t).max() <= max(dt, 2.0) * 1.2


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, "long", [1.0], None])
@pytest.mark.parametrize("name", ["dt", "duration"])
def test_bad_times_are_refused(name: str, value: Any) -> None:
    if name == "duration" and value is None:
        return  # the trajectory's own
    with pytest.raises(TrundleError, match=name):
        feasibility(DIFFERENTIAL, motion.circle(1.0, 1.0), **{name: value})


def test_too_many_times_are_refused() -> None:
    with pytest.raises(TrundleError, match="longer dt"):
        feasibility(DIFFERENTIAL, motion.circle(1.0, 1.0), duration=1e6)


@pytest.mark.parametrize("path", [None, "circle", 3.0])
def test_what_is_no_trajectory_is_refused(path: Any) -> None:
    with pytest.raises(TrundleError, match="position"):
        feasibility(DIFFERENTIAL, path, duration=1.0)


def test_what_is_no_robot_is_refused() -> None:
    with pytest.raises(TrundleError, match="a Robot is needed"):
        feasibility("differential", motion.circle(1.0, 1.0))  # type: ignore[arg-type]


def test_wheels_of_which_one_is_free() -> None:
    """A free wheel has no motor: it may have a speed limit of none, and friction all the same."""
    extra = OmniWheel(name="loose", x=0.0, y=0.0, radius=0.05, driven=False, friction=0.5)
    robot = dataclasses.replace(OMNI, wheels=(*OMNI.wheels, extra))
    found = feasibility(robot, motion.circle(1.0, 1.0))
    needed = demand(found, "friction with the ground")
    assert needed.wheels == ("loose",)
    # Nothing drives it and nothing brakes it.
    np.testing.assert_allclose(needed.values, 0.0, atol=ROUNDING)


def test_a_wheel_without_weight_cannot_push_at_any_pace() -> None:
    """The centre of mass lies between two of three wheels: the third carries nothing."""
    robot = trundle.load("omni3").with_wheels(friction=0.5)
    second, third = robot.wheels[1], robot.wheels[2]
    edge = ((second.x + third.x) / 2, (second.y + third.y) / 2)
    found = feasibility(robot.with_body(com=edge), motion.circle(1.0, 0.2))
    assert found.stretch == math.inf
    assert any("wheel_1 carries no weight" in told for told in found.reports)


class Mistaken:
    """A trajectory whose velocity is twice what it should be."""

    duration = 5.0

    def position(self, t: float) -> Floats:
        return np.array([math.sin(t), 0.0, 0.0])

    def velocity(self, t: float) -> Floats:
        return np.array([2 * math.cos(t), 0.0, 0.0])

    def acceleration(self, t: float) -> Floats:
        return np.array([-2 * math.sin(t), 0.0, 0.0])


def test_a_wrong_derivative_of_an_own_trajectory_is_told() -> None:
    with pytest.warns(TrajectoryWarning, match="velocity.t. is not the rate of position"):
        feasibility(trundle.load("omni3"), Mistaken())


def test_any_trajectory_can_be_stretched() -> None:
    slow = motion.stretched(Mistaken(), 2.0)
    assert slow.duration == 10.0  # type: ignore[attr-defined]
    np.testing.assert_allclose(slow.position(3.0), [math.sin(1.5), 0.0, 0.0])
    np.testing.assert_allclose(slow.velocity(3.0), [math.cos(1.5), 0.0, 0.0])
    np.testing.assert_allclose(slow.acceleration(3.0), [-0.5 * math.sin(1.5), 0.0, 0.0])
    own = motion.stretched(motion.circle(1.0, 1.0), 3.0)
    np.testing.assert_allclose(own.velocity(0.0)[:2], [1 / 3, 0.0], atol=ROUNDING)
    for factor in (0.0, -1.0, math.nan, "x"):
        with pytest.raises(TrundleError, match="factor"):
            motion.stretched(motion.circle(1.0, 1.0), factor)  # type: ignore[arg-type]
    with pytest.raises(TrundleError, match="not its class"):
        feasibility(trundle.load("omni3"), Mistaken)  # type: ignore[arg-type]
