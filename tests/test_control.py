"""The controllers: error dynamics and equilibria, by hand and against a published model."""

import dataclasses
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import trundle
from geometry import Floats, misfits, rolling_rows
from trundle import Dynamics, motion, track
from trundle.control import (
    PD,
    ComputedTorque,
    GoToPose,
    Kanayama,
    Measurement,
    ReducedComputedTorque,
    Reference,
    ResolvedRate,
)
from trundle.errors import ShapeError, TrundleError
from trundle.robot import Robot

# Sums of some thousand steps of numbers near 1, each rounded at 1e-16.
ROUNDING = 1e-12
# The adaptive method is good to ten digits a step.
INTEGRATED = 1e-8
# Five-point differences of the commanded speeds over 1e-3 s, along a path of second order.
DIFFERENTIATED = 1e-5


class Resting:
    """A trajectory that stays at a pose."""

    def __init__(self, *pose: float) -> None:
        self.pose = np.array(pose or (0.0, 0.0, 0.0))

    def position(self, t: Any) -> Floats:
        return np.broadcast_to(self.pose, (*np.shape(t), 3))

    def velocity(self, t: Any) -> Floats:
        return np.zeros((*np.shape(t), 3))

    acceleration = velocity


def turned(psi: float) -> Floats:
    c, s = math.cos(psi), math.sin(psi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


# ---- PD ------------------------------------------------------------------------------------

CENTRED: dict[str, Any] = {"mass": 30.0, "inertia": 0.5, "com": (0.0, 0.0)}


def test_pd_is_a_spring_and_a_damper() -> None:
    """F = K_p e + K_d e_d in the inertial frame, whichever way the robot faces."""
    random = np.random.default_rng(21)
    kp, kd = random.uniform(0.0, 100.0, (2, 3))
    for _ in range(20):
        pose, rate, at, going, rising = random.uniform(-1.5, 1.5, (5, 3))
        force, state = PD(kp, kd).step(
            None, Measurement(0.0, pose, rate), Reference(at, going, rising)
        )
        np.testing.assert_allclose(force, kp * (at - pose) + kd * (going - rate), atol=1e-11)
        assert state is None


@pytest.mark.parametrize(
    ("kp", "kd"), [((40, 60, 2), (90, 50, 3)), ((120, 10, 0.4), (20, 30, 0.1))]
)
def test_pd_holds_a_pose_as_springs_and_dampers_do(kp: Any, kd: Any) -> None:
    """m x_dd + k_d x_d + k_p x = 0 in each direction by itself, from an offset at rest."""
    robot = trundle.load("omni3").with_body(**CENTRED)
    e0 = np.array([0.3, -0.2, 0.8])
    goal = np.array([1.0, 2.0, 0.5])
    run = track(
        robot, Resting(*goal), PD(kp, kd), duration=5.0, dt=0.05, method="adaptive",
        pose=goal - e0,
    )  # fmt: skip
    assert run.error is not None
    for i, inertia in enumerate((30.0, 30.0, 0.5)):
        wanted = free_decay(kp[i] / inertia, kd[i] / inertia, e0[i], 0.0, run.t)
        np.testing.assert_allclose(run.error[:, i], wanted, atol=INTEGRATED)


def free_decay(k: float, c: float, e0: float, v0: float, t: Floats) -> Floats:
    """Return e(t) of e_dd + c e_d + k e = 0, by its characteristic roots."""
    root = np.sqrt(complex(c * c / 4 - k))
    if abs(root) < 1e-9:
        return np.asarray((e0 + (v0 + c / 2 * e0) * t) * np.exp(-c / 2 * t))
    one, two = -c / 2 + root, -c / 2 - root
    a = (v0 - two * e0) / (one - two)
    return np.asarray((a * np.exp(one * t) + (e0 - a) * np.exp(two * t)).real)


def test_pd_comes_to_rest_at_the_goal_wherever_the_masses_are() -> None:
    """Kinetic energy and that of the springs never grow together; both end at zero."""
    kp, kd = np.array([60.0, 90.0, 5.0]), np.array([50.0, 60.0, 4.0])
    robot = trundle.load("mecanum").with_body(mass=30.0, inertia=0.5, com=(0.2, -0.1))
    run = track(
        robot, Resting(0.4, -0.3, 0.2), PD(kp, kd), duration=30.0, dt=0.1, method="adaptive",
        pose=(-0.5, 0.5, -2.0), rate=(0.5, 1.0, 3.0),
    )  # fmt: skip
    assert run.error is not None
    assert run.energy is not None
    stored = run.energy + 0.5 * (kp * run.error**2).sum(axis=1)
    assert np.diff(stored).max() < INTEGRATED
    assert np.abs(run.error[-1]).max() < 1e-6
    assert run.energy[-1] < 1e-10


@pytest.mark.parametrize("w", [0.1, 0.7, 2.0])
@pytest.mark.parametrize(("kp", "kd"), [(120.0, 120.0), (300.0, 20.0)])
def test_pd_stays_behind_on_a_circle_by_its_transfer_function(
    w: float, kp: float, kd: float
) -> None:
    """E / X_des = m s^2 / (m s^2 + k_d s + k_p) at s = i w, in x and y a quarter turn apart."""
    m, r, s = 30.0, 1.5, 1j * w
    share = m * s**2 / (m * s**2 + kd * s + kp)
    t = np.linspace(0.0, 6.0, 25)
    # x = r sin(w t) = Im(r e^(s t)) and y = r - Re(r e^(s t)); the errors are their shares.
    wave = share * r * np.exp(s * t)
    wanted = np.stack([wave.imag, -wave.real, 0 * t], axis=-1)
    wanted_d = np.stack([(s * wave).imag, -(s * wave).real, 0 * t], axis=-1)
    path = motion.circle(r, w)
    run = track(
        trundle.load("omni3").with_body(**CENTRED), path, PD([kp, kp, 5.0], [kd, kd, 5.0]),
        duration=6.0, dt=0.25, method="adaptive",
        pose=path.position(0.0) - wanted[0], rate=path.velocity(0.0) - wanted_d[0],
    )  # fmt: skip
    np.testing.assert_allclose(run.error, wanted, atol=INTEGRATED)
    assert run.error is not None
    amplitude = m * w**2 * r / math.hypot(kp - m * w**2, kd * w)
    np.testing.assert_allclose(np.hypot(*run.error[:, :2].T), amplitude, atol=INTEGRATED)


# ---- computed torque -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["omni3", "mecanum", "omni4"])
def test_computed_torque_makes_each_error_decay_by_itself(name: str) -> None:
    """e_dd + k_d e_d + k_p e = 0, with the masses aside, spinning wheels and viscous friction."""
    robot = (
        trundle.load(name)
        .with_body(mass=30.0, inertia=0.7, com=(0.15, -0.08))
        .with_wheels(spin_inertia=0.02, viscous_friction=0.05, mass=1.0, yaw_inertia=0.01)
    )
    kp, kd = np.array([4.0, 9.0, 2.0]), np.array([4.0, 3.0, 6.0])  # critical, slow, over
    e0, v0 = np.array([0.2, -0.3, 1.5]), np.array([-0.5, 0.2, 0.7])
    path = motion.ellipse(1.5, 1.0, 0.8)
    run = track(
        robot, path, ComputedTorque(kp, kd), duration=4.0, dt=0.05, method="adaptive",
        pose=path.position(0.0) - e0, rate=path.velocity(0.0) - v0,
    )  # fmt: skip
    assert run.error is not None
    for i in range(3):
        wanted = free_decay(kp[i], kd[i], e0[i], v0[i], run.t)
        np.testing.assert_allclose(run.error[:, i], wanted, atol=INTEGRATED)


def test_computed_torque_is_the_model_written_out() -> None:
    """F = M (q_dd_des + K_d e_d + K_p e) + n of the lectures, in matrices."""
    random = np.random.default_rng(22)
    m, inertia, (x_bc, y_bc) = 20.0, 0.8, (0.2, -0.1)
    model = Dynamics(trundle.load("omni4").with_body(mass=m, inertia=inertia, com=(x_bc, y_bc)))
    kp, kd = np.array([4.0, 9.0, 2.0]), np.array([4.0, 3.0, 6.0])
    law = ComputedTorque(kp, kd, model=model)
    for _ in range(20):
        pose, rate, at, going, rising = random.uniform(-1.5, 1.5, (5, 3))
        c, s = math.cos(pose[2]), math.sin(pose[2])
        a, b = -m * (y_bc * c + x_bc * s), m * (x_bc * c - y_bc * s)
        M = np.array([[m, 0, a], [0, m, b], [a, b, inertia + m * (x_bc**2 + y_bc**2)]])
        n = rate[2] ** 2 * np.array([-b, a, 0.0])
        force, state = law.step(None, Measurement(0.0, pose, rate), Reference(at, going, rising))
        wanted = M @ (rising + kd * (going - rate) + kp * (at - pose)) + n
        np.testing.assert_allclose(force, wanted, atol=1e-11)
        assert state is None


@pytest.mark.parametrize("law", ["PD", "computed torque"])
def test_step_by_hand_commands_what_track_commands(law: str) -> None:
    robot = trundle.load("mecanum").with_body(mass=20.0, inertia=0.8, com=(0.2, -0.1))
    kp, kd = [4.0, 9.0, 2.0], [4.0, 3.0, 6.0]
    controller: Any = PD(kp, kd)
    if law != "PD":
        controller = ComputedTorque(kp, kd, model=Dynamics(robot))
    path = motion.figure_eight(4.0, 0.5)
    run = track(robot, path, controller, duration=3.0, dt=0.1, pose=(0.3, 0.2, -2.8))
    assert run.force is not None
    for k in range(0, 30, 3):
        q_d = turned(run.pose[k, 2]) @ run.twist[k]
        t = float(run.t[k])
        reference = Reference(path.position(t), path.velocity(t), path.acceleration(t))
        force, _ = controller.step(None, Measurement(t, run.pose[k], q_d), reference)
        np.testing.assert_allclose(run.force[k], force, atol=1e-10)


# ---- robots that cannot move sideways: Kanayama --------------------------------------------

DIFFERENTIAL = trundle.load("differential")


def chased(pose: Floats, at: Floats) -> Floats:
    """Return (ahead, left, turn) of the reference from the robot."""
    e = turned(pose[2]).T @ (at - pose)
    e[2] = math.atan2(math.sin(e[2]), math.cos(e[2]))
    return np.asarray(e)


def reference_at(heading: float, speed: float, yaw_rate: float, at: Any) -> Reference:
    rate = turned(heading) @ [speed, 0.0, yaw_rate]
    return Reference(np.array([at[0], at[1], heading]), rate, np.zeros(3))


@pytest.mark.parametrize("speed", [0.8, 0.0, -0.8])
def test_kanayamas_law_never_lets_its_lyapunov_function_grow(speed: float) -> None:
    """V = k_y (ahead^2 + left^2) / 2 + turn^2 / 2 falls by k_x k_y ahead^2 + k_psi turn^2.

    With the error's kinematics of the source, ahead_d = r left - u + u_r cos(turn),
    left_d = -r ahead + u_r sin(turn), turn_d = r_r - r; forwards, at a standstill and backwards.
    """
    random = np.random.default_rng(23)
    law = Kanayama(k_x=1.3, k_y=5.0, k_psi=2.1)
    for _ in range(50):
        pose, at = random.uniform(-2.0, 2.0, (2, 3))
        yaw_rate = float(random.uniform(-1.0, 1.0))
        reference = reference_at(at[2], speed, yaw_rate, at)
        (u, v, r), state = law.step(None, Measurement(0.0, pose, np.zeros(3)), reference)
        assert v == 0.0
        assert state is None
        ahead, left, turn = chased(pose, at)
        ahead_d = r * left - u + speed * math.cos(turn)
        left_d = -r * ahead + speed * math.sin(turn)
        V_d = law.k_y * (ahead * ahead_d + left * left_d) + turn * (yaw_rate - r)
        falls = law.k_x * law.k_y * ahead**2 + law.k_psi * turn**2
        assert V_d == pytest.approx(-falls, abs=1e-11)


def test_on_the_trajectory_kanayamas_law_commands_its_speeds() -> None:
    pose = np.array([1.0, 2.0, 0.7])
    for speed, yaw_rate in ((0.5, 0.3), (-0.4, 0.2), (0.0, 0.0)):
        reference = reference_at(0.7, speed, yaw_rate, pose)
        twist, _ = Kanayama().step(None, Measurement(0.0, pose, np.zeros(3)), reference)
        np.testing.assert_allclose(twist, [speed, 0.0, yaw_rate], atol=ROUNDING)


class Backwards:
    """A trajectory driven through facing the other way: the speed is negative."""

    def __init__(self, trajectory: Any) -> None:
        self.trajectory = trajectory

    def position(self, t: Any) -> Floats:
        return np.asarray(self.trajectory.position(t)) + np.array([0.0, 0.0, math.pi])

    def velocity(self, t: Any) -> Floats:
        return self.trajectory.velocity(t)

    def acceleration(self, t: Any) -> Floats:
        return self.trajectory.acceleration(t)


EIGHT = motion.figure_eight(4.0, 0.6)
OFFSETS = [(0.5, 0.3, 0.4), (-0.6, 0.5, 2.0), (0.2, -0.9, -2.9), (0.0, 0.4, math.pi)]


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("path", [EIGHT, Backwards(EIGHT)], ids=["forwards", "backwards"])
def test_kanayamas_law_reaches_the_trajectory_from_anywhere(path: Any, offset: Any) -> None:
    law, dt = Kanayama(), 0.02
    run = track(DIFFERENTIAL, path, law, duration=12.0, dt=dt, pose=path.position(0.0) - offset)
    assert run.error is not None
    assert run.reports == ()
    # Each step holds the twist: the robot lags by up to half a step of its motion.
    speed = float(np.hypot(*path.velocity(run.t)[:, :2].T).max())
    turning = float(np.abs(path.acceleration(run.t)).max())
    assert np.abs(run.error[-100:]).max() < dt * (speed + turning)
    ends = [chased(p, at) for p, at in zip(run.pose, path.position(run.t), strict=True)]
    V = np.array([law.k_y * (a**2 + b**2) / 2 + c**2 / 2 for a, b, c in ends])
    # V never grows but by what a step's error of first order adds at the end.
    assert np.diff(V).max() < 4 * dt**2
    assert V[-1] < 1e-4 < 0.1 < V[0]


def test_the_rest_of_kanayamas_error_is_that_of_the_step() -> None:
    ends = []
    for dt in (0.04, 0.02, 0.01):
        run = track(DIFFERENTIAL, EIGHT, Kanayama(), duration=9.0, dt=dt, pose=(0.2, -0.3, 0.1))
        assert run.error is not None
        ends.append(float(np.abs(run.error[run.t > 7.0]).max()))
    assert np.log2(np.array(ends[:-1]) / ends[1:]) == pytest.approx([1, 1], abs=0.15)


def test_at_a_standstill_kanayamas_law_comes_alongside_and_turns_in() -> None:
    """A reference at rest leaves the sideways error, which no law of this form takes away."""
    run = track(DIFFERENTIAL, Resting(), Kanayama(), duration=10.0, dt=0.01, pose=(-0.5, 0.2, 0.6))
    ahead, _, turn = chased(run.pose[-1], np.zeros(3))
    assert abs(ahead) < 1e-6
    assert abs(turn) < 1e-6
    assert np.abs(run.twist[-1]).max() < 1e-6
    distance = np.hypot(*run.pose[:, :2].T)
    assert distance[-1] < distance[0]


@pytest.mark.parametrize(
    "name", ["tricycle", "bicycle", "ackermann", "rear_steered", "swerve", "omni_steer", "mecanum"]
)
def test_kanayamas_law_drives_every_robot_whose_wheels_allow_it(name: str) -> None:
    robot = trundle.load(name)
    path = motion.ellipse(8.0, 5.0, 0.2)
    run = track(robot, path, Kanayama(), duration=10.0, dt=0.025, pose=(-0.3, 0.4, 0.3))
    assert run.error is not None
    assert run.torques is not None
    assert run.reports == ()
    assert np.abs(run.error[-100:]).max() < 0.025 * 2.0  # a step at 1.6 m/s
    assert run.torques.shape == (400, len(robot.driven))
    assert np.isfinite(run.torques).all()
    for k in range(0, 400, 40):
        slip = misfits(robot, run.twist[k], run.wheel_speeds[k], run.steering[k])
        assert max(slip.values()) < 1e-9, slip


def test_wheel_limits_are_kept_and_reported() -> None:
    robot = DIFFERENTIAL.with_wheels(max_speed=8.0)
    path = motion.circle(1.0, 0.5)  # 0.5 m/s: 8 and 12 rad/s
    run = track(robot, path, Kanayama(), duration=5.0, dt=0.01)
    assert np.abs(run.wheel_speeds).max() <= 8.0 + 1e-9
    assert run.saturated is not None
    assert run.saturated.shape == (500, 2)
    assert run.saturated[100:].all()
    assert "could not have the twist" in run.reports[0]


def test_torques_of_a_robot_that_is_told_its_twist() -> None:
    """On a line at growing speed: two wheels push body and wheels, m a = (tau_l + tau_r) / a_w."""

    class Growing(Resting):
        def position(self, t: Any) -> Floats:
            return np.multiply.outer(0.5 * 0.4 * np.asarray(t) ** 2, [1.0, 0.0, 0.0])

        def velocity(self, t: Any) -> Floats:
            return np.multiply.outer(0.4 * np.asarray(t), [1.0, 0.0, 0.0])

        def acceleration(self, t: Any) -> Floats:
            return np.broadcast_to([0.4, 0.0, 0.0], (*np.shape(t), 3))

    robot = DIFFERENTIAL.with_body(mass=20.0).with_wheels(spin_inertia=0.01)
    run = track(robot, Growing(), Kanayama(), duration=4.0, dt=0.01)
    assert run.torques is not None
    radius = 0.05
    push = 0.4 * (20.0 + 2 * 0.01 / radius**2) * radius / 2
    np.testing.assert_allclose(run.torques[200:], push, rtol=1e-3)


# ---- going to a pose -----------------------------------------------------------------------


def test_the_way_to_a_pose_never_lets_its_lyapunov_function_grow() -> None:
    """V = (rho^2 + gamma^2 + k_delta delta^2) / 2 falls by k_rho (rho cos gamma)^2 + k_gamma gamma^2.

    In polar coordinates rho_d = -u cos(gamma), gamma_d = u sin(gamma) / rho - r and
    delta_d = u sin(gamma) / rho.
    """  # noqa: E501  one equation
    random = np.random.default_rng(24)
    law = GoToPose(k_rho=0.7, k_gamma=2.2, k_delta=1.4)
    for _ in range(50):
        pose, goal = random.uniform(-2.0, 2.0, (2, 3))
        reference = Reference(goal, np.zeros(3), np.zeros(3))
        (u, v, r), state = law.step(None, Measurement(0.0, pose, np.zeros(3)), reference)
        assert v == 0.0
        assert state is None
        way = complex(*(goal - pose)[:2])
        rho = abs(way)
        gamma = np.angle(way * np.exp(-1j * pose[2]))
        delta = np.angle(way * np.exp(-1j * goal[2]))
        both = u * math.sin(gamma) / rho
        V_d = -rho * u * math.cos(gamma) + gamma * (both - r) + law.k_delta * delta * both
        falls = law.k_rho * (rho * math.cos(gamma)) ** 2 + law.k_gamma * gamma**2
        assert V_d == pytest.approx(-falls, abs=1e-11)


@pytest.mark.parametrize("heading", [0.0, 1.0, math.pi, -2.0])
@pytest.mark.parametrize("direction", np.arange(8) * math.pi / 4)
def test_a_pose_is_reached_from_all_around(direction: float, heading: float) -> None:
    goal = (1.0, -2.0, 0.7)
    start = (1.0 + 1.5 * math.cos(direction), -2.0 + 1.5 * math.sin(direction), heading)
    run = track(DIFFERENTIAL, Resting(*goal), GoToPose(), duration=20.0, dt=0.05, pose=start)
    assert run.error is not None
    assert np.abs(run.error[-1]).max() < 1e-2
    assert np.abs(run.twist[-1]).max() < 1e-2
    assert run.reports == ()


def test_at_the_pose_the_robot_stays_and_only_turns() -> None:
    stays = track(DIFFERENTIAL, Resting(), GoToPose(), duration=1.0, dt=0.1, pose=(0, 0, 0))
    np.testing.assert_array_equal(stays.pose, 0.0)
    turns = track(DIFFERENTIAL, Resting(), GoToPose(), duration=8.0, dt=0.02, pose=(0, 0, 2.0))
    np.testing.assert_allclose(turns.pose[:, :2], 0.0, atol=ROUNDING)
    assert abs(turns.pose[-1, 2]) < 1e-6


# ---- computed torque on the reduced dynamics -----------------------------------------------
#
# Dhaouadi and Abu Hatab, Dynamic Modelling of Differential-Drive Mobile Robots using Lagrange and
# Newton-Euler Methodologies: A Unified Framework, Advances in Robotics and Automation 2(2), 2013:
# R radius, L half track, d from the axle ahead to the centre of mass of the body of mass m_c,
# m = m_c + 2 m_w, I = I_c + m_c d^2 + 2 m_w L^2 + 2 I_m, I_w of a wheel about its axle.

R, L, D = 0.07, 0.25, 0.12
M_C, M_W, I_C, I_M, I_W = 18.0, 0.9, 0.9, 0.004, 0.006
M_ALL = M_C + 2 * M_W
I_ALL = I_C + M_C * D**2 + 2 * M_W * L**2 + 2 * I_M
PUBLISHED = (
    trundle.load("differential", radius=R, track=2 * L)
    .with_body(mass=M_C, inertia=I_C, com=(D, 0.0))
    .with_wheels(spin_inertia=I_W)
)
PUBLISHED = dataclasses.replace(
    PUBLISHED,
    wheels=tuple(
        dataclasses.replace(wheel, mass=M_W, yaw_inertia=I_M) if wheel.driven else wheel
        for wheel in PUBLISHED.wheels
    ),
)


def published(state: Floats, left: float, right: float) -> Floats:
    """Return d/dt (x, y, psi, v, omega) of the published model."""
    _, _, psi, v, omega = state
    push, turn = (right + left) / R, L * (right - left) / R
    v_d = (push + M_C * D * omega**2) / (M_ALL + 2 * I_W / R**2)
    omega_d = (turn - M_C * D * omega * v) / (I_ALL + 2 * L**2 * I_W / R**2)
    return np.array([v * math.cos(psi), v * math.sin(psi), omega, v_d, omega_d])


def published_run(torques: Callable[[float, Floats], Any], start: Any, t: Floats) -> Floats:
    """Return the states (T + 1, 5) under torques (left, right) held over each step, by scipy."""
    states = [np.array(start, dtype=np.float64)]
    for a, b in itertools.pairwise(t):
        left, right = torques(a, states[-1])
        found = integrate.solve_ivp(
            lambda _, s, left=left, right=right: published(s, left, right), (a, b), states[-1],
            method="DOP853", rtol=1e-11, atol=1e-12,
        )  # fmt: skip
        states.append(found.y[:, -1])
    return np.array(states)


def given(t: float) -> list[float]:
    return [0.5 * math.sin(3 * t) + 0.2, 0.6 * math.cos(2 * t)]


class Given:
    output = "torques"

    def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
        return given(measurement.t), state


@pytest.mark.parametrize(
    ("method", "dt", "tolerance"), [("adaptive", 0.05, INTEGRATED), ("rk4", 0.01, 1e-6)]
)
def test_a_differential_drive_moves_by_the_published_model(
    method: str, dt: float, tolerance: float
) -> None:
    run = track(
        PUBLISHED, Resting(), Given(), duration=2.0, dt=dt, method=method,
        pose=(0.1, 0.2, 0.3), rate=(0.4 * math.cos(0.3), 0.4 * math.sin(0.3), 0.5),
    )  # fmt: skip
    wanted = published_run(lambda t, _: given(t), (0.1, 0.2, 0.3, 0.4, 0.5), run.t)
    np.testing.assert_allclose(run.pose, wanted[:, :3], atol=tolerance)
    np.testing.assert_allclose(run.twist[:, [0, 2]], wanted[:-1, 3:], atol=tolerance)
    np.testing.assert_allclose(run.twist[:, 1], 0.0, atol=1e-9)
    # Kinetic energy: body with its centre of mass ahead, wheels about the axle's middle, spins.
    v, omega = wanted[:, 3:].T
    energy = 0.5 * (M_ALL + 2 * I_W / R**2) * v**2
    energy += 0.5 * (I_ALL + 2 * L**2 * I_W / R**2) * omega**2
    np.testing.assert_allclose(run.energy, energy, atol=20 * tolerance)  # type: ignore[arg-type]


@pytest.mark.parametrize("path", [EIGHT, Backwards(EIGHT)], ids=["forwards", "backwards"])
def test_the_closed_loop_on_the_published_model(path: Any) -> None:
    """The controller looks at the published model's state and pushes the published model."""
    controller = ReducedComputedTorque(model=Dynamics(PUBLISHED))

    def torques(t: float, state: Floats) -> Any:
        x, y, psi, v, omega = state
        rate = np.array([v * math.cos(psi), v * math.sin(psi), omega])
        reference = Reference(path.position(t), path.velocity(t), path.acceleration(t))
        return controller.step(None, Measurement(t, np.array([x, y, psi]), rate), reference)[0]

    start = path.position(0.0) - np.array([0.2, -0.3, -0.4])
    rate = turned(start[2]) @ [0.3, 0.0, 0.1]
    run = track(
        PUBLISHED, path, ReducedComputedTorque(), duration=1.5, dt=0.01, method="rk4",
        pose=start, rate=rate,
    )  # fmt: skip
    wanted = published_run(torques, [*start, 0.3, 0.1], run.t)
    # A step of rk4 at 0.01 s; the torques leap at the start.
    np.testing.assert_allclose(run.pose, wanted[:, :3], atol=1e-7)


def kanayama_speeds(pose: Floats, at: Floats, going: Floats, law: Any) -> Floats:
    """Return the speeds nu_c (2,) of the source, on this page's own arithmetic."""
    ahead, left, turn = chased(pose, at)
    speed = (turned(at[2]).T @ going)[0]
    return np.array(
        [
            speed * math.cos(turn) + law.k_x * ahead,
            going[2] + law.k_y * speed * left + law.k_psi * math.sin(turn),
        ]
    )


@pytest.mark.parametrize("backwards", [False, True])
def test_the_speeds_approach_those_commanded_at_the_rate_that_is_asked(backwards: bool) -> None:
    """nu_d = nu_c_d + k_nu (nu_c - nu) on the published model; nu_c_d by differencing nu_c."""
    random = np.random.default_rng(25)
    path = Backwards(EIGHT) if backwards else EIGHT
    law = ReducedComputedTorque(k_x=1.5, k_y=6.0, k_psi=2.5, k_nu=7.0, model=Dynamics(PUBLISHED))
    for t in np.linspace(0.3, 9.0, 12):
        pose = path.position(t) + random.uniform(-0.4, 0.4, 3)
        v, omega = random.uniform(-1.0, 1.0, 2)

        def measured(pose: Floats, v: float, omega: float, t: float) -> Measurement:
            return Measurement(
                t, pose, np.array([v * math.cos(pose[2]), v * math.sin(pose[2]), omega])
            )

        reference = Reference(path.position(t), path.velocity(t), path.acceleration(t))
        torques, _ = law.step(None, measured(pose, v, omega, t), reference)
        state_d = published(np.array([*pose, v, omega]), *torques)

        def nu_c(h: float, t: float = t, pose: Floats = pose, d: Floats = state_d) -> Floats:
            # The pose to second order: its second derivative turns the velocity.
            v, omega = d[0] / math.cos(pose[2]), d[2]
            later = pose + h * d[:3]
            across = np.array([-math.sin(pose[2]), math.cos(pose[2]), 0.0])
            later = later + 0.5 * h * h * v * omega * across
            return kanayama_speeds(later, path.position(t + h), path.velocity(t + h), law)

        h = 1e-3
        change = (8 * (nu_c(h) - nu_c(-h)) - (nu_c(2 * h) - nu_c(-2 * h))) / (12 * h)
        wanted = change + law.k_nu * (nu_c(0.0) - [v, omega])
        np.testing.assert_allclose(state_d[3:], wanted, atol=DIFFERENTIATED)


@pytest.mark.parametrize("method", ["lecture", "semi-implicit", "rk4"])
@pytest.mark.parametrize("offset", [(0.3, -0.3, 0.4), (-0.4, 0.2, -2.0)])
def test_the_errors_decay_with_the_centre_of_mass_ahead(method: str, offset: Any) -> None:
    path = motion.ellipse(3.0, 2.0, 0.4)
    start = path.position(0.0) - offset
    run = track(
        PUBLISHED, path, ReducedComputedTorque(), duration=14.0, dt=0.01, method=method,
        pose=start, rate=(0.0, 0.0, 0.0),
    )  # fmt: skip
    assert run.error is not None
    # Torques are held over a step; the lecture's step is straight, others are exact arcs.
    assert np.abs(run.error[-100:]).max() < 1e-3
    assert run.torques is not None
    assert run.torques.shape == (1400, 2)


def test_a_wrong_model_leaves_an_error() -> None:
    """Where the centre of mass is believed on the axle, the robot is off its trajectory."""
    path = motion.ellipse(3.0, 2.0, 0.4)
    believed = Dynamics(PUBLISHED.with_body(com=(0.0, 0.0), mass=2 * M_C))
    ends = []
    for model in (None, believed):
        run = track(PUBLISHED, path, ReducedComputedTorque(model=model), duration=5.0, dt=0.02)
        assert run.error is not None
        ends.append(float(np.abs(run.error[-100:]).max()))
    assert ends[1] > 10 * ends[0]


def test_reduced_computed_torque_makes_up_for_friction() -> None:
    robot = PUBLISHED.with_wheels(viscous_friction=0.05)
    run = track(robot, motion.circle(2.0, 0.4), ReducedComputedTorque(), duration=8.0, dt=0.01)
    assert run.error is not None
    assert np.abs(run.error[-100:]).max() < 1e-4
    # Steady: each motor gives its wheel's friction, and the turning takes the rest.
    A, gains = rolling_rows(robot, robot.driven, [])
    assert run.torques is not None
    speeds = A @ np.array([0.8, 0.0, 0.4]) / gains
    left, right = run.torques[-1]
    push, turn = (right + left) / R, L * (right - left) / R
    drag = 0.05 * speeds / R
    assert push - drag.sum() == pytest.approx(-M_C * D * 0.4**2, rel=1e-3)
    assert turn - L * (drag[1] - drag[0]) == pytest.approx(M_C * D * 0.4 * 0.8, rel=1e-3)


# ---- refusals ------------------------------------------------------------------------------

BAD_GAINS = [
    ([1, 2], "three gains"), (4.0, "three gains"), ([[1, 1, 1]], "three gains"),
    ([-1.0, 0.0, 0.0], r"must not be negative, got \[-1.0, 0.0, 0.0\]"),
    ([math.nan, 1, 1], "finite"), ([math.inf, 1, 1], "finite"), ("fast", "array of numbers"),
    ([1, "a", 2], "array of numbers"), (None, "finite"),
]  # fmt: skip


@pytest.mark.parametrize("controller", [PD, ComputedTorque])
@pytest.mark.parametrize(("gains", "match"), BAD_GAINS)
def test_bad_gains_are_refused_by_name(controller: Any, gains: Any, match: str) -> None:
    with pytest.raises(ShapeError, match=f"^kp .*{match}"):
        controller(gains, [1, 1, 1])
    with pytest.raises(ShapeError, match=f"^kd .*{match}"):
        controller(kp=[1, 1, 1], kd=gains)


SINGLE_GAINS = [
    (kind, field.name)
    for kind in (Kanayama, GoToPose, ReducedComputedTorque)
    for field in dataclasses.fields(kind)
    if field.name != "model"
]


@pytest.mark.parametrize(("controller", "name"), SINGLE_GAINS)
@pytest.mark.parametrize("gain", [0.0, -1.0, math.nan, math.inf, "fast", [1.0, 2.0], None])
def test_a_bad_gain_is_refused_by_name(controller: Any, name: str, gain: Any) -> None:
    with pytest.raises(ShapeError, match=f"^{name} must be"):
        controller(**{name: gain})


def test_gains_are_kept_as_numbers() -> None:
    """A controller is a value: its gains do not change with the array that they came from."""
    gains = np.array([1.0, 2.0, 3.0])
    law = PD(gains, gains)
    gains[:] = 9.0
    assert law == PD([1, 2, 3], [1, 2, 3])
    assert Kanayama(k_x=2) == Kanayama(k_x=2.0)


NOWHERE = (Measurement(0.0, np.zeros(3), np.zeros(3)), Reference(*np.zeros((3, 3))))


def test_computed_torque_without_a_model_says_what_it_needs() -> None:
    with pytest.raises(TrundleError, match=r"ComputedTorque\(kp, kd, model=trundle.Dynamics"):
        ComputedTorque([1] * 3, [1] * 3).step(None, *NOWHERE)
    with pytest.raises(TrundleError, match=r"ReducedComputedTorque\(model=trundle.Dynamics"):
        ReducedComputedTorque().step(None, *NOWHERE)


@pytest.mark.parametrize("model", [DIFFERENTIAL, "differential", 3.0])
def test_a_model_that_is_none_is_refused(model: Any) -> None:
    with pytest.raises(TrundleError, match=r"model must be a trundle\.Dynamics"):
        ComputedTorque([1] * 3, [1] * 3, model=model)
    with pytest.raises(TrundleError, match=r"model must be a trundle\.Dynamics"):
        ReducedComputedTorque(model=model)


def off_axle() -> Robot:
    """Return a differential drive whose origin lies ahead of its axle."""
    return dataclasses.replace(
        DIFFERENTIAL,
        wheels=tuple(dataclasses.replace(wheel, x=wheel.x - 0.3) for wheel in DIFFERENTIAL.wheels),
    )


def test_reduced_computed_torque_wants_the_origin_on_the_axle() -> None:
    with pytest.raises(TrundleError, match=r"cannot move about its origin.*axle"):
        ReducedComputedTorque(model=Dynamics(off_axle()))
    with pytest.raises(TrundleError, match=r"cannot move about its origin.*axle"):
        track(off_axle(), EIGHT, ReducedComputedTorque(), duration=0.1)


def test_reduced_computed_torque_refuses_robots_that_steer() -> None:
    with pytest.raises(TrundleError, match=r"'bicycle' steers.*Kanayama"):
        track(trundle.load("bicycle"), EIGHT, ReducedComputedTorque(), duration=0.1)


def test_a_model_of_another_robot_is_refused_where_its_torques_do_not_fit() -> None:
    other = Dynamics(trundle.load("mecanum"))
    with pytest.raises(TrundleError, match="the controller's torques must be 2 finite numbers"):
        track(DIFFERENTIAL, EIGHT, ReducedComputedTorque(model=other), duration=0.1)


def test_a_model_that_steers_is_refused() -> None:
    """Its force depends on steering angles that no pose tells."""
    model = Dynamics(trundle.load("swerve"))
    with pytest.raises(TrundleError, match="'swerve' steers"):
        track(trundle.load("omni3"), EIGHT, ComputedTorque([1] * 3, [1] * 3, model=model),
              duration=0.1)  # fmt: skip
    with pytest.raises(TrundleError, match="'swerve' steers"):
        ReducedComputedTorque(model=model)


def test_a_model_of_a_robot_that_cannot_move_sideways_is_no_model_for_poses() -> None:
    """Its mass matrix is whole, but it would compensate friction along its own wheels only."""
    model = Dynamics(DIFFERENTIAL)
    run = track(
        trundle.load("omni3"), motion.circle(1.0, 0.3),
        ComputedTorque([4] * 3, [4] * 3, model=model), duration=0.5,
    )  # fmt: skip
    assert np.isfinite(run.pose).all()


# ---- resolved rate -------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["omni3", "mecanum", "two_steered", "swerve"])
def test_resolved_rate_lets_each_error_die_out_by_itself(name: str) -> None:
    """e_dot = -k e, the command held over each step: e shrinks by 1 - k dt a step."""
    path = motion.line((0, 0, 0.3), (2, 1, 0.8), 5.0)
    k, dt = np.array([1.0, 2.0, 0.5]), 0.01
    law = ResolvedRate(k)
    start = path.position(0.0) - [0.02, -0.03, 0.01]
    run = track(trundle.load(name), path, law, dt=dt, pose=start)
    assert run.error is not None
    # Held commands follow the moving reference and the turning body with an error of order dt.
    for axis in range(3):
        wanted = run.error[0, axis] * np.exp(-k[axis] * run.t)
        np.testing.assert_allclose(run.error[:, axis], wanted, atol=5 * dt * 0.1)
    assert np.abs(run.error[-1]).max() < 0.01
    assert not any("sideways" in report for report in run.reports)


def test_a_sideways_trajectory_under_a_law_that_goes_forward_is_told() -> None:
    path = motion.circle(1.0, 0.3, heading=0.0)
    run = track(trundle.load("differential"), path, Kanayama(), duration=3.0)
    most = 0.3 * math.sin(0.9)  # the way turns by 0.9 rad in three seconds, the robot does not
    assert any(f"{most:.3g} m/s across its heading" in each for each in run.reports)
