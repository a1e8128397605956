"""The closed loop: the lecture's tables, independent loops, orders, energy, limits, files."""

import dataclasses
import importlib.util
import itertools
import math
import re
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import trundle
from catalogue import ODD_OMNI, mirrored, reordered
from geometry import Floats, rolling_rows, wheel_matrix
from masses import each_unsteered, motions, newton_euler, torques_for
from trundle import Dynamics, Run, motion, track
from trundle.control import PD, ComputedTorque, Kanayama, Measurement, Reference
from trundle.errors import RobotError, ShapeError, StabilityWarning, TrundleError
from trundle.robot import Motor, Robot
from trundle.simulation import TRACK_METHODS
from trundle.simulation.tracking import compiled

# Sums of some thousand steps of numbers near 1, each rounded at 1e-16.
ROUNDING = 1e-12
# The same loop in another order of operations, over 600 steps of the lecture's stiff gains.
SAME_LOOP = 1e-10
# Two integrators with tolerances of 1e-10 and 1e-12 a step.
INTEGRATED = 1e-8
# Slopes of measured errors over halvings of a step that is not yet tiny.
ORDER = 0.15
REFERENCE: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}

FIXED_STEP = tuple(method for method in TRACK_METHODS if method != "adaptive")
each_method = pytest.mark.parametrize("method", TRACK_METHODS)
each_fixed_step = pytest.mark.parametrize("method", FIXED_STEP)


# ---- the lecture's tables ------------------------------------------------------------------

LECTURE_PD = PD(kp=[120, 120, 0.4], kd=[120, 120, 0.4])
LECTURE_CT = ComputedTorque(kp=[4, 4, 4], kd=[4, 4, 4])
# Their wheels have nothing in common: three and four, omni and mecanum, some turned round.
OMNIDIRECTIONAL = ("omni3", "mecanum", "omni4")


def lecture_robot(name: str = "omni3", **body: Any) -> Robot:
    return trundle.load(name).with_body(**{"mass": 30.0, "inertia": 0.1, "com": (0.0, 0.0)} | body)


def lecture_paths(heading: str = "lecture") -> dict[str, motion.Trajectory]:
    points, times = [(0, 0), (2, 2), (0, 4)], (0, 30, 60)
    return {
        "circle": motion.circle(3.0, 0.1, heading=heading),
        "ellipse": motion.ellipse(3.0, 2.0, 0.1, heading=heading),
        "Lissajous": motion.lissajous(3.0, 3.0, 0.2, 0.1, heading=heading),
        "via 1": motion.cubic_via(points, times, via_velocity=(0, 0), heading=heading),
        "via 2": motion.cubic_via(points, times, heading=heading),
    }


class Wrapped:
    """A trajectory whose heading errors go the shorter way round."""

    def __init__(self, trajectory: motion.Trajectory) -> None:
        self.position = trajectory.position
        self.velocity = trajectory.velocity
        self.acceleration = trajectory.acceleration


def lecture_errors(robot: Robot, trajectory: Any, controller: Any) -> list[float]:
    """Return the largest |x|, |y|, |psi| errors over the lecture's 600 steps."""
    run = track(robot, trajectory, controller, duration=60.0, dt=0.1, method="lecture")
    assert len(run.t) == 601
    assert run.error is not None
    return np.abs(run.error).max(axis=0).tolist()


def assert_printed(values: list[float], printed: str) -> None:
    """Compare numbers with a row of a printed table, each to the digits that it has there."""
    texts = printed.split(" / ")
    for value, text in zip(values, texts, strict=False):
        digits = len(re.sub(r"e.*|\.|^0\.0*", "", text))
        assert float(f"{value:.{digits - 1}e}") == float(text), (value, text)


# Printed after an independent loop: x / y / psi; psi has no column in the first table.
PRINTED = [
    ("circle", LECTURE_PD, "7.4813e-3 / 7.4813e-3"),
    ("circle", LECTURE_CT, "3.4913e-5 / 3.4913e-5"),
    ("via 1", LECTURE_PD, "3.2190e-3 / 3.1215e-3 / 2.3562"),
    ("via 1", LECTURE_CT, "1.0370e-5 / 1.0370e-5 / 2.3562"),
    ("via 2", LECTURE_PD, "3.2190e-3 / 1.6137e-3 / 2.6781"),
    ("via 2", LECTURE_CT, "1.0370e-5 / 2.5926e-6 / 2.6781"),
    ("ellipse", LECTURE_PD, "7.4813e-3 / 4.9875e-3 / 2.3624e-3"),
    ("ellipse", LECTURE_CT, "3.4913e-5 / 2.3275e-5 / 2.3624e-3"),
    ("Lissajous", LECTURE_PD, "2.9704e-2 / 7.4813e-3 / 6.2845"),
    ("Lissajous", LECTURE_CT, "2.7723e-4 / 3.4913e-5 / 6.2845"),
]


@pytest.mark.parametrize("name", OMNIDIRECTIONAL)
@pytest.mark.parametrize(("path", "controller", "printed"), PRINTED)
def test_the_lectures_table(name: str, path: str, controller: Any, printed: str) -> None:
    assert_printed(lecture_errors(lecture_robot(name), lecture_paths()[path], controller), printed)


@pytest.mark.parametrize("name", OMNIDIRECTIONAL)
@pytest.mark.parametrize(
    ("controller", "printed"),
    [
        (LECTURE_PD, "2.9704e-2 / 7.4813e-3 / 4.6786e-2"),
        (LECTURE_CT, "2.7723e-4 / 3.4913e-5 / 4.6786e-2"),
    ],
)
def test_the_lectures_lissajous_with_a_wrapped_heading_error(
    name: str, controller: Any, printed: str
) -> None:
    wrapped = Wrapped(lecture_paths()["Lissajous"])
    assert_printed(lecture_errors(lecture_robot(name), wrapped, controller), printed)


@pytest.mark.parametrize("name", OMNIDIRECTIONAL)
def test_the_lectures_circle_with_a_wrong_mass(name: str) -> None:
    """The PD controller believes nothing of the mass; computed torque believes 36 kg, not 30."""
    believed = Dynamics(lecture_robot(name, mass=36.0))
    controller = ComputedTorque(kp=[4, 4, 4], kd=[4, 4, 4], model=believed)
    errors = lecture_errors(lecture_robot(name), lecture_paths()["circle"], controller)
    assert_printed(errors[:1], "1.2467e-3")


@pytest.mark.parametrize("name", OMNIDIRECTIONAL)
def test_the_lectures_circle_with_the_centre_of_mass_beside_the_centre(name: str) -> None:
    robot = lecture_robot(name, com=(0.05, 0.02))
    errors = lecture_errors(robot, lecture_paths()["circle"], LECTURE_PD)
    assert_printed(errors, "7.448e-3 / 7.543e-3 / 0.128")


@pytest.mark.parametrize("path", ["circle", "ellipse", "Lissajous", "via 2"])
def test_the_true_heading_leaves_no_more_error_than_the_lectures_step(path: str) -> None:
    """psi_dd fed forward, the tangent held, errors wrapped: psi is as good as x and y.

    A step keeps the acceleration that it began with and so lacks dt / 2 jerk of it on average.
    ``e_dd + 4 e_d + 4 e`` answers without overshoot: that lets e come to dt / 2 jerk / k_p.
    """
    trajectory = lecture_paths("path")[path]
    errors = lecture_errors(lecture_robot(), trajectory, LECTURE_CT)
    t = np.linspace(0.0, 60.0, 6001)
    jerk = np.abs(np.diff(trajectory.acceleration(t), axis=0) / t[1]).max(axis=0)
    assert (np.array(errors) <= 0.1 / 2 * jerk / 4.0 + ROUNDING).all()
    by_the_lecture = lecture_errors(lecture_robot(), lecture_paths()[path], LECTURE_CT)
    if path != "circle":  # whose psi_dd is zero
        assert errors[2] < by_the_lecture[2] / 10


def test_the_true_heading_at_a_corner() -> None:
    """The path turns by 90 deg while it stands still at via 1: nobody can follow that at once.

    Elsewhere the heading has no error; the lecture's has 135 deg at the end, where atan2(0, 0) = 0.
    """
    run = track(lecture_robot(), lecture_paths("path")["via 1"], LECTURE_CT, duration=60.0, dt=0.1,
                method="lecture")  # fmt: skip
    assert run.error is not None
    psi = run.error[:, 2]
    assert np.abs(psi[run.t < 29.95]).max() < ROUNDING
    assert np.abs(psi).max() == pytest.approx(math.pi / 2, abs=ROUNDING)
    assert np.abs(psi[run.t > 50.0]).max() < 1e-12 + math.pi / 2 * (1 + 2 * 20) * math.exp(-2 * 20)


# ---- independent loops ---------------------------------------------------------------------


def inertial_model(m: float, inertia: float, com: tuple[float, float]) -> Callable[..., Any]:
    """Return the function that gives M(q) and n(q, q_d) of the lectures, in matrices."""
    x_bc, y_bc = com

    def model(psi: float, psi_d: float) -> tuple[Floats, Floats]:
        c, s = math.cos(psi), math.sin(psi)
        a, b = -m * (y_bc * c + x_bc * s), m * (x_bc * c - y_bc * s)
        M = np.array([[m, 0, a], [0, m, b], [a, b, inertia + m * (x_bc**2 + y_bc**2)]])
        n = np.array([-m * psi_d**2 * (x_bc * c - y_bc * s),
                      -m * psi_d**2 * (y_bc * c + x_bc * s), 0.0])  # fmt: skip
        return M, n

    return model


Model = Callable[[float, float], tuple[Floats, Floats]]
Force = Callable[[Floats, Floats, Floats, Floats, Floats], Floats]


def short_way(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


def pd_force(kp: Any, kd: Any) -> Force:
    def force(q: Floats, q_d: Floats, at: Floats, going: Floats, _: Floats) -> Floats:
        e = at - q
        e[2] = short_way(e[2])
        return np.diag(kp) @ e + np.diag(kd) @ (going - q_d)

    return force


def computed_torque_force(kp: Any, kd: Any, model: Model) -> Force:
    def force(q: Floats, q_d: Floats, at: Floats, going: Floats, rising: Floats) -> Floats:
        e = at - q
        e[2] = short_way(e[2])
        M, n = model(q[2], q_d[2])
        return M @ (rising + np.diag(kd) @ (going - q_d) + np.diag(kp) @ e) + n

    return force


BESIDE: dict[str, Any] = {"mass": 30.0, "inertia": 0.7, "com": (0.15, -0.08)}
BELIEVED: dict[str, Any] = {"mass": 24.0, "inertia": 0.9, "com": (-0.05, 0.1)}
KP, KD = (90.0, 70.0, 6.0), (80.0, 110.0, 5.0)
FAST = motion.ellipse(1.5, 1.0, 0.8)
# Away from the trajectory in all three, and standing still.
OFF: dict[str, Any] = {"pose": (-0.4, 0.3, 2.9), "rate": (0.0, 0.0, 0.0)}


def beside(name: str = "omni3") -> Robot:
    return trundle.load(name).with_body(**BESIDE)


def laws() -> dict[str, tuple[Any, Force]]:
    """Return trundle's controllers, and the same laws written in matrices."""
    plant, believed = (
        inertial_model(b["mass"], b["inertia"], b["com"]) for b in (BESIDE, BELIEVED)
    )
    other = Dynamics(trundle.load("omni3").with_body(**BELIEVED))
    return {
        "PD": (PD(KP, KD), pd_force(KP, KD)),
        "computed torque": (
            ComputedTorque((9, 4, 6), (5, 4, 7)),
            computed_torque_force((9, 4, 6), (5, 4, 7), plant),
        ),
        "computed torque, wrong model": (
            ComputedTorque((9, 4, 6), (5, 4, 7), model=other),
            computed_torque_force((9, 4, 6), (5, 4, 7), believed),
        ),
    }


each_law = pytest.mark.parametrize("law", laws())


def start_of(trajectory: Any, off: dict[str, Any]) -> tuple[Floats, Floats]:
    q = np.array(off.get("pose", trajectory.position(0.0)), dtype=np.float64)
    q_d = np.array(off.get("rate", trajectory.velocity(0.0)), dtype=np.float64)
    return q, q_d


@each_law
def test_the_lectures_loop_in_matrices_agrees_step_by_step(law: str) -> None:
    controller, force = laws()[law]
    dt, steps = 0.05, 400
    run = track(beside(), FAST, controller, duration=steps * dt, dt=dt, method="lecture", **OFF)
    model = inertial_model(BESIDE["mass"], BESIDE["inertia"], BESIDE["com"])
    q, q_d = start_of(FAST, OFF)
    for k in range(steps):
        t = k * dt
        at, going, rising = FAST.position(t), FAST.velocity(t), FAST.acceleration(t)
        F = force(q, q_d, at, going, rising)
        M, n = model(q[2], q_d[2])
        c, s = math.cos(q[2]), math.sin(q[2])
        twist = [c * q_d[0] + s * q_d[1], -s * q_d[0] + c * q_d[1], q_d[2]]
        assert run.error is not None
        assert run.force is not None
        np.testing.assert_allclose(run.pose[k], q, atol=SAME_LOOP, rtol=0)
        np.testing.assert_allclose(run.twist[k], twist, atol=SAME_LOOP, rtol=0)
        np.testing.assert_allclose(run.error[k], [*(at - q)[:2], short_way(at[2] - q[2])],
                                   atol=SAME_LOOP, rtol=0)  # fmt: skip
        np.testing.assert_allclose(run.force[k], F, atol=100 * SAME_LOOP, rtol=0)  # gains near 100
        q_dd = np.linalg.solve(M, F - n)
        q, q_d = q + dt * q_d + 0.5 * dt**2 * q_dd, q_d + dt * q_dd
    np.testing.assert_allclose(run.pose[steps], q, atol=SAME_LOOP, rtol=0)


# Times of the reference run: whole steps of everything that is compared with it.
TIMES = np.linspace(0.0, 3.2, 33)


@cache
def reference_run(law: str) -> Floats:
    """Return the poses (33, 3) of the closed loop in the inertial frame, by scipy."""
    model = inertial_model(BESIDE["mass"], BESIDE["inertia"], BESIDE["com"])
    force = laws()[law][1]

    def slope(time: float, state: Floats) -> Floats:
        q, q_d = state[:3], state[3:]
        M, n = model(q[2], q_d[2])
        F = force(q, q_d, FAST.position(time), FAST.velocity(time), FAST.acceleration(time))
        return np.concatenate([q_d, np.linalg.solve(M, F - n)])

    start = np.concatenate(start_of(FAST, OFF))
    found = integrate.solve_ivp(slope, (0.0, TIMES[-1]), start, t_eval=TIMES, **REFERENCE)
    return np.asarray(found.y[:3].T)


@each_law
@pytest.mark.parametrize(("method", "dt"), [("adaptive", 0.1), ("rk4", 0.0025)])
def test_the_closed_loop_by_scipy_agrees(law: str, method: str, dt: float) -> None:
    run = track(beside(), FAST, laws()[law][0], duration=3.2, dt=dt, method=method, **OFF)
    at = run.pose[:: round(0.1 / dt)]
    np.testing.assert_allclose(at, reference_run(law), atol=INTEGRATED, rtol=0)


@pytest.mark.parametrize(("method", "order"), [("lecture", 1), ("semi-implicit", 1), ("rk4", 4)])
@each_law
def test_the_order_of_convergence(law: str, method: str, order: int) -> None:
    end, errors = reference_run(law)[16], []
    for dt in (0.02, 0.01, 0.005, 0.0025)[order // 4 :]:
        run = track(beside(), FAST, laws()[law][0], duration=1.6, dt=dt, method=method, **OFF)
        errors.append(float(np.abs(run.pose[-1] - end).max()))
    found = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert found[-1] == pytest.approx(order, abs=ORDER), found


# ---- wheels between command and body -------------------------------------------------------

LOSSY: dict[str, Any] = {
    "spin_inertia": 0.02,
    "viscous_friction": 0.03,
    "coulomb_friction": 0.01,
    "max_torque": 0.8,
}
# Coulomb friction is smoothed within this wheel speed [rad/s], as its docstring says.
SLOW = 0.01


def lossy(name: str = "mecanum", **more: Any) -> Robot:
    if name == "omni3":  # larger wheels
        more = {"max_torque": 4.0} | more
    return beside(name).with_wheels(**(LOSSY | more))


def wheel_torques(robot: Robot, force: Floats, psi: float) -> Floats:
    """Return the torques (n,) of least norm for a force (3,) in the inertial frame."""
    A, gains = rolling_rows(robot, robot.driven, [])
    G = A / gains[:, None]
    c, s = math.cos(psi), math.sin(psi)
    body = [c * force[0] + s * force[1], -s * force[0] + c * force[1], force[2]]
    return np.asarray(np.linalg.lstsq(G.T, np.array(body), rcond=None)[0])


def driven_model(robot: Robot) -> Callable[[Floats, Floats], Floats]:
    """Return zeta_dot of an omnidirectional robot from twist and net torques, by hand."""
    A, gains = rolling_rows(robot, robot.driven, [])
    G = A / gains[:, None]
    body = robot.body
    assert body is not None
    assert body.mass is not None
    assert body.inertia is not None
    assert body.com is not None
    m, (x, y) = body.mass, body.com
    spin = np.diag([wheel.spin_inertia for wheel in robot.driven])
    M = m * np.array([[1, 0, -y], [0, 1, x], [-y, x, x * x + y * y + body.inertia / m]])
    M += G.T @ spin @ G

    def acceleration(twist: Floats, torques: Floats) -> Floats:
        u, v, r = twist
        # Of the centre of mass, in a frame that turns: m (a + r x v), and the moment about O.
        bias = m * np.array([-r * v - r * r * x, r * u - r * r * y, r * (x * u + y * v)])
        return np.linalg.solve(M, G.T @ torques - bias)

    return acceleration


def friction_by_hand(robot: Robot, speeds: Floats) -> Floats:
    return np.array(
        [
            w.viscous_friction * s + w.coulomb_friction * s / math.hypot(s, SLOW)
            for w, s in zip(robot.driven, speeds, strict=True)
        ]
    )


@pytest.mark.parametrize("name", ["mecanum", "omni3"])
def test_wheels_that_lose_and_limit_by_scipy(name: str) -> None:
    """Least-norm torques, cut off, less friction, on a body with spinning wheels."""
    robot = lossy(name)
    most = {wheel.max_torque for wheel in robot.driven}.pop()
    A, gains = rolling_rows(robot, robot.driven, [])
    accelerate, force = driven_model(robot), pd_force(KP, KD)

    def slope(t: float, state: Floats) -> Floats:
        q, zeta = state[:3], state[3:]
        c, s = math.cos(q[2]), math.sin(q[2])
        q_d = np.array([c * zeta[0] - s * zeta[1], s * zeta[0] + c * zeta[1], zeta[2]])
        F = force(q, q_d, FAST.position(t), FAST.velocity(t), FAST.acceleration(t))
        torques = np.clip(wheel_torques(robot, F, q[2]), -most, most)
        torques -= friction_by_hand(robot, A @ zeta / gains)
        return np.concatenate([q_d, accelerate(zeta, torques)])

    run = track(robot, FAST, PD(KP, KD), duration=1.0, dt=0.02, method="adaptive", **OFF)
    found = integrate.solve_ivp(
        slope, (0.0, 1.0), [*OFF["pose"], 0.0, 0.0, 0.0], t_eval=run.t, method="LSODA",
        rtol=1e-9, atol=1e-10, max_step=2e-3,
    )  # fmt: skip
    # Both integrators step over the kinks where limits begin and end, to their own tolerance.
    np.testing.assert_allclose(run.pose, found.y[:3].T, atol=1e-6, rtol=0)
    assert run.saturated is not None
    assert run.saturated.any()
    assert not run.saturated.all()


@pytest.mark.parametrize("name", ["mecanum", "omni3"])
def test_torques_stay_within_their_limits_and_are_marked_where_they_do_not(name: str) -> None:
    robot = lossy(name)
    most = {wheel.max_torque for wheel in robot.driven}.pop()
    run = track(robot, FAST, PD(KP, KD), duration=4.0, dt=0.01, **OFF)
    assert run.torques is not None
    assert run.saturated is not None
    assert run.force is not None
    asked = np.array(
        [wheel_torques(robot, F, pose[2]) for F, pose in zip(run.force, run.pose[:-1], strict=True)]
    )
    np.testing.assert_allclose(run.torques, np.clip(asked, -most, most), atol=1e-11)
    np.testing.assert_array_equal(run.saturated, np.abs(asked) > most + 1e-9)
    assert 0.1 < run.saturated.mean() < 0.99
    assert len(run.reports) == 1
    said = run.reports[0]
    assert "torque limits" in said
    assert "feasibility" in said
    for i, wheel in enumerate(robot.driven):
        assert f"{wheel.name} {100 * run.saturated[:, i].mean():.3g} %" in said
    first = run.t[np.flatnonzero(run.saturated.any(axis=1))[0]]
    assert f"t = {first:.4g} s" in said
    assert run.error is not None
    assert f"{np.hypot(*run.error[:, :2].T).max():.3g} m" in said


def test_a_motor_gives_less_torque_the_faster_it_turns() -> None:
    motor = Motor(torque_constant=0.05, resistance=2.0, gear=10.0, max_voltage=8.0, max_current=3.0)
    robot = beside("omni3").with_wheels(motor=motor)
    run = track(robot, FAST, PD(KP, KD), duration=4.0, dt=0.01, **OFF)
    assert run.torques is not None
    assert run.force is not None
    assert run.saturated is not None
    per_ampere, volts_per_speed = 10 * 0.05, 10 * 0.05
    most = per_ampere * (8.0 - volts_per_speed * run.wheel_speeds) / 2.0
    least = per_ampere * (-8.0 - volts_per_speed * run.wheel_speeds) / 2.0
    current = per_ampere * 3.0
    asked = np.array(
        [wheel_torques(robot, F, pose[2]) for F, pose in zip(run.force, run.pose[:-1], strict=True)]
    )
    given = np.clip(np.clip(asked, least, most), -current, current)
    np.testing.assert_allclose(run.torques, given, atol=1e-11)
    by_voltage = (given == most) | (given == least)
    assert by_voltage.any()
    assert (np.abs(given) == current).any()
    assert not run.saturated.all()


def test_limits_that_are_never_reached_change_nothing() -> None:
    free, wide = beside("mecanum"), beside("mecanum").with_wheels(max_torque=1e6)
    runs = [track(r, FAST, PD(KP, KD), duration=2.0, dt=0.01, **OFF) for r in (free, wide)]
    np.testing.assert_allclose(runs[0].pose, runs[1].pose, atol=ROUNDING)
    assert runs[1].reports == ()
    assert runs[1].saturated is not None
    assert not runs[1].saturated.any()


class Held:
    """Torques that do not change."""

    output = "torques"

    def __init__(self, torques: Any) -> None:
        self.torques = torques

    def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
        return self.torques, state


class Resting:
    """A trajectory that stays at the origin, and does not say for how long."""

    def position(self, t: Any) -> Floats:
        return np.zeros((*np.shape(t), 3))

    velocity = acceleration = position


@pytest.mark.parametrize("name", ["mecanum", "omni4"])
@each_method
def test_motors_that_work_against_each_other_stay_within_their_limits(
    name: str, method: str
) -> None:
    """Four motors at their limits push as hard as without limits, whatever they share.

    The torques of least norm with the same effect are larger than the limit at one wheel.
    """
    robot = beside(name)
    A, gains = rolling_rows(robot, robot.driven, [])
    against = np.sign(np.linalg.svd((A / gains[:, None]).T)[2][-1])
    torques = against * [1.0, 1.0, 1.0, -1.0]
    wanted = driven_model(robot)(np.zeros(3), torques)
    for limits in ({}, {"max_torque": 1.0}, {"max_torque": 1.0, "viscous_friction": 1e-9}):
        limited = robot.with_wheels(**limits) if limits else robot
        run = track(limited, Resting(), Held(torques), duration=1e-4, dt=1e-4, method=method)
        assert run.torques is not None
        np.testing.assert_allclose(run.torques[0], torques)
        # From rest for a ten-thousandth of a second: u = a t, to the share that it turns.
        gained = 2 * run.energy[-1]  # type: ignore[index]
        A_body = np.asarray(wanted)
        body = Dynamics(limited).reduced().M
        assert gained == pytest.approx(A_body @ body @ A_body * 1e-8, rel=1e-3), limits


@each_unsteered
@pytest.mark.parametrize("most", [None, 1.0])
def test_torques_accelerate_every_robot_by_newtons_laws(robot: Robot, most: float | None) -> None:
    """Each part with its own motion, all forces between them unknown, on one short step."""
    moving, dt = motions(robot)[0], 1e-6
    torques = torques_for(robot)
    limited = robot if most is None else robot.with_wheels(max_torque=most)
    given = torques if most is None else np.clip(torques, -most, most)
    wanted = newton_euler(robot, moving, given).twist_acceleration
    run = track(limited, Resting(), Held(torques), duration=2 * dt, dt=dt, method="rk4",
                rate=moving.twist)  # fmt: skip
    # The acceleration's own change over the step, most of it by Coulomb friction near rest.
    got = (run.twist[1] - run.twist[0]) / dt
    np.testing.assert_allclose(got, wanted, atol=1e-3 * (1 + np.abs(wanted).max()))
    np.testing.assert_allclose(run.twist[0], moving.twist, atol=1e-12)
    np.testing.assert_allclose(run.torques, np.tile(given, (2, 1)), atol=1e-12)


# ---- energy --------------------------------------------------------------------------------


def losses(robot: Robot, run: Run) -> float:
    """Return what friction took [J], wheel by wheel, in the run's own sums."""
    turns = np.diff(run.wheel_angles, axis=0)
    taken = [friction_by_hand(robot, speeds) for speeds in run.wheel_speeds]
    return float((np.array(taken) * turns).sum())


def kinetic(robot: Robot, twist: Floats) -> float:
    """Return the kinetic energy of body and spinning wheels [J], part by part."""
    body = robot.body
    assert body is not None
    assert body.mass is not None
    assert body.inertia is not None
    assert body.com is not None
    u, v, r = twist
    x, y = body.com
    speed = math.hypot(u - r * y, v + r * x)
    A, gains = rolling_rows(robot, robot.driven, [])
    spins = A @ twist / gains
    inertia = np.array([wheel.spin_inertia for wheel in robot.driven])
    return 0.5 * (body.mass * speed**2 + body.inertia * r**2 + float(inertia @ spins**2))


def test_kinetic_energy_is_that_of_the_parts() -> None:
    robot = lossy()
    run = track(robot, FAST, PD(KP, KD), duration=1.0, dt=0.01, **OFF)
    assert run.energy is not None
    for k in range(0, 100, 9):
        wanted = kinetic(robot, run.twist[k])
        assert run.energy[k] == pytest.approx(wanted, rel=1e-12)


def test_on_a_straight_line_the_energy_balances_to_rounding() -> None:
    """Without turning, each semi-implicit step's work is exactly its gain and its losses."""
    robot = lossy(max_torque=None).with_body(com=(0.0, 0.0))
    path = motion.line((0, 0), (2, 1), 4.0, heading=0.3)
    run = track(robot, path, PD(KP, KD), dt=0.01, pose=(0.1, -0.2, 0.3))
    assert run.energy is not None
    assert run.work is not None
    gained = run.energy[-1] - run.energy[0]
    assert run.work[-1] > 1.0
    assert run.work[-1] - losses(robot, run) == pytest.approx(gained, abs=1e-12 * 100)


@each_method
def test_the_energy_balances_ever_better_with_shorter_steps(method: str) -> None:
    """Work minus losses is the change of kinetic energy; the sums over steps are of first order."""
    robot = lossy()
    missing = []
    for dt in (0.01, 0.0025):
        run = track(robot, FAST, PD(KP, KD), duration=1.0, dt=dt, method=method, **OFF)
        assert run.energy is not None
        assert run.work is not None
        assert run.work[0] == 0.0
        gained = run.energy[-1] - run.energy[0]
        missing.append(abs(run.work[-1] - losses(robot, run) - gained))
        assert run.work[-1] > 1.0  # J
    # A quarter of the step leaves at most a third; the losses and the gain are some joules.
    assert missing[1] < max(missing[0] / 3, 1e-3)
    assert missing[1] < 0.05


def test_the_energy_of_a_robot_told_its_twist_balances_too() -> None:
    """On the trajectory from the start: no jump of the twist."""
    robot = trundle.load("differential").with_wheels(spin_inertia=0.01, viscous_friction=0.02)
    missing = []
    for dt in (0.01, 0.005):
        run = track(robot, motion.ellipse(2.0, 1.0, 0.5), Kanayama(), duration=2.0, dt=dt)
        assert run.energy is not None
        assert run.work is not None
        gained = run.energy[-1] - run.energy[0]
        missing.append(abs(run.work[-1] - losses(robot, run) - gained))
        assert abs(gained) > 0.1
    assert missing[1] < 0.6 * missing[0]
    assert missing[1] < 0.02


def test_a_robot_that_is_told_its_twist_at_rest_takes_its_kinetic_energy_from_the_motors() -> None:
    """However short the step in which it comes to speed; no wheel loses anything."""
    robot = trundle.load("differential").with_body(mass=20.0, inertia=0.9, com=(0.0, 0.0))
    for dt in (0.02, 0.001):
        run = track(robot, motion.circle(2.0, 0.4), Kanayama(), duration=0.1, dt=dt,
                    rate=(0.0, 0.0, 0.0))  # fmt: skip
        assert run.energy is not None
        assert run.work is not None
        u, _, r = run.twist[-1]
        assert run.energy[0] == 0.0
        assert run.energy[-1] == pytest.approx(0.5 * (20.0 * u**2 + 0.9 * r**2), rel=1e-9)
        assert run.work[-1] == pytest.approx(run.energy[-1], rel=1e-9)


# ---- Python's floats and numba -------------------------------------------------------------

needs_numba = pytest.mark.skipif(
    importlib.util.find_spec("numba") is None, reason="numba is not installed"
)
READINGS = {"Python": 10**9, "numba": 0}


@pytest.fixture
def reading(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    def choose(name: str) -> None:
        monkeypatch.setattr(compiled, "_WORTH_COMPILING", READINGS[name])

    return choose


FIELDS = (
    "t", "pose", "twist", "wheel_speeds", "wheel_angles", "desired", "error", "torques", "force",
    "energy", "work",
)  # fmt: skip


@needs_numba
@each_fixed_step
@pytest.mark.parametrize("law", ["PD", "computed torque, wrong model"])
def test_pythons_floats_and_numba_agree(
    law: str, method: str, reading: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One compiled loop serves every robot: with limits and friction, and without."""
    compilations = []
    inner = compiled._compiled

    def counted(*args: Any) -> Any:
        compilations.append(args)
        return inner(*args)

    monkeypatch.setattr(compiled, "_compiled", counted)
    controller = laws()[law][0]
    for robot in (lossy("mecanum"), beside("omni3")):
        runs = []
        for name in READINGS:
            reading(name)
            runs.append(
                track(robot, FAST, controller, duration=10.0, dt=0.005, method=method, **OFF)
            )
        python, numba = runs
        assert len(python.t) == 2001
        for field in FIELDS:
            got, wanted = getattr(numba, field), getattr(python, field)
            size = max(1.0, float(np.abs(wanted).max()))
            np.testing.assert_allclose(got, wanted, atol=ROUNDING * size, rtol=0, err_msg=field)
        np.testing.assert_array_equal(python.saturated, numba.saturated)
        assert python.reports == numba.reports
    assert len(compilations) == 2  # once for each robot, never for Python's floats


@needs_numba
def test_a_motion_that_outgrows_all_numbers_ends_alike_in_both_readings(
    reading: Callable[[str], None],
) -> None:
    runs = []
    for name in READINGS:
        reading(name)
        with pytest.warns(StabilityWarning):
            runs.append(track(beside(), FAST, PD(KP, KD), duration=500.0, dt=1.0, **OFF))
    assert len(runs[0].t) == len(runs[1].t) < 501
    assert runs[0].reports == runs[1].reports
    assert np.isfinite(runs[1].pose).all()


def test_long_runs_alone_are_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> Any:
        raise AssertionError("compiled")

    monkeypatch.setattr(compiled, "_compiled", refuse)
    track(beside(), FAST, PD(KP, KD), duration=5.0, dt=0.01)


@pytest.mark.parametrize("law", ["PD", "computed torque"])
@each_method
def test_running_twice_gives_the_same(law: str, method: str) -> None:
    runs = [
        track(lossy(), FAST, laws()[law][0], duration=0.5, dt=0.01, method=method, **OFF)
        for _ in range(2)
    ]
    assert runs[0] == runs[1]


# ---- the same loop described otherwise -----------------------------------------------------


@each_fixed_step
def test_the_order_of_the_wheels_does_not_matter(method: str) -> None:
    robot, order = lossy("mecanum"), (2, 0, 3, 1)
    runs = [
        track(r, FAST, PD(KP, KD), duration=2.0, dt=0.01, method=method, **OFF)
        for r in (robot, reordered(robot, order))
    ]
    np.testing.assert_allclose(runs[1].pose, runs[0].pose, atol=1e-10)
    assert runs[0].torques is not None
    assert runs[1].torques is not None
    np.testing.assert_allclose(runs[1].torques, runs[0].torques[:, order], atol=1e-8)
    assert runs[1].driven == tuple(runs[0].driven[i] for i in order)


class Mirrored:
    """A trajectory seen in a mirror along the x axis."""

    def __init__(self, trajectory: Any) -> None:
        self.trajectory = trajectory

    def position(self, t: Any) -> Floats:
        return self.trajectory.position(t) * [1, -1, -1]

    def velocity(self, t: Any) -> Floats:
        return self.trajectory.velocity(t) * [1, -1, -1]

    def acceleration(self, t: Any) -> Floats:
        return self.trajectory.acceleration(t) * [1, -1, -1]


@each_fixed_step
@pytest.mark.parametrize("law", ["PD", "computed torque"])
def test_a_mirrored_robot_runs_the_mirrored_path(law: str, method: str) -> None:
    robot = lossy("mecanum")
    assert robot.body is not None
    x, y = BESIDE["com"]
    other = dataclasses.replace(mirrored(robot), body=dataclasses.replace(robot.body, com=(x, -y)))
    pose, rate = np.array(OFF["pose"]), np.array([0.3, -0.1, 0.4])
    controller = laws()[law][0]
    here = track(
        robot, FAST, controller, duration=2.0, dt=0.01, method=method, pose=pose, rate=rate
    )
    there = track(
        other, Mirrored(FAST), controller, duration=2.0, dt=0.01, method=method,
        pose=pose * [1, -1, -1], rate=rate * [1, -1, -1],
    )  # fmt: skip
    np.testing.assert_allclose(there.pose, here.pose * [1, -1, -1], atol=1e-10)
    np.testing.assert_allclose(there.energy, here.energy, atol=1e-9)  # type: ignore[arg-type]


@each_method
@pytest.mark.parametrize("controller", [PD((90, 90, 6), (80, 80, 5)), LECTURE_CT])
def test_moving_the_trajectory_moves_the_run(controller: Any, method: str) -> None:
    """With equal gains along x and y no direction is special; nor is a place."""
    x, y, psi = 2.0, -1.0, 2.4
    path = motion.ellipse(1.5, 1.0, 0.8)
    turn = np.array([[math.cos(psi), -math.sin(psi)], [math.sin(psi), math.cos(psi)]])
    pose, rate = np.array([0.1, -0.2, 0.4]), np.array([0.2, 0.1, -0.3])

    def moved(q: Floats, at: Any = (0.0, 0.0, 0.0)) -> Floats:
        out = np.array(q, dtype=np.float64)
        out[..., :2] = q[..., :2] @ turn.T
        return out + np.asarray(at)

    settings: dict[str, Any] = {"duration": 2.0, "dt": 0.02, "method": method}
    here = track(lossy(), path, controller, pose=pose, rate=rate, **settings)
    there = track(
        lossy(), path.moved(x, y, psi), controller, pose=moved(pose, (x, y, psi)),
        rate=moved(rate), **settings,
    )  # fmt: skip
    # The adaptive method's steps differ with the numbers; each is good to 1e-10.
    tolerance = 1e-7 if method == "adaptive" else 1e-10
    np.testing.assert_allclose(there.pose, moved(here.pose, (x, y, psi)), atol=tolerance)
    assert here.error is not None
    np.testing.assert_allclose(there.error, moved(here.error), atol=tolerance)
    np.testing.assert_allclose(there.torques, here.torques, atol=100 * tolerance)  # type: ignore[arg-type]


def test_wheels_of_any_make_move_the_body_alike() -> None:
    """Without limits, friction and spin the body feels the force alone."""
    runs = [
        track(robot.with_body(**BESIDE), FAST, PD(KP, KD), duration=2.0, dt=0.01, **OFF)
        for robot in (*map(trundle.load, OMNIDIRECTIONAL), _omni_with_body())
    ]
    for run in runs[1:]:
        np.testing.assert_allclose(run.pose, runs[0].pose, atol=1e-10)


def _omni_with_body() -> Robot:
    body = trundle.load("omni3").body
    return dataclasses.replace(ODD_OMNI, body=body)


# ---- what a run holds ----------------------------------------------------------------------


@each_method
def test_the_shapes_of_a_run(method: str) -> None:
    robot = beside("mecanum").with_wheels(max_torque=1e6)
    run = track(robot, FAST, PD(KP, KD), duration=0.55, dt=0.1, method=method)
    T, n = 6, 4
    np.testing.assert_allclose(run.t, [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55])
    shapes = {
        "pose": (T + 1, 3), "twist": (T, 3), "wheel_speeds": (T, n), "steering": (T, 0),
        "wheel_angles": (T + 1, n), "desired": (T + 1, 3), "error": (T + 1, 3),
        "torques": (T, n), "force": (T, 3), "energy": (T + 1,), "work": (T + 1,),
        "saturated": (T, n),
    }  # fmt: skip
    for name, shape in shapes.items():
        assert getattr(run, name).shape == shape, name
    np.testing.assert_allclose(run.desired, FAST.position(run.t), atol=ROUNDING)
    np.testing.assert_allclose(run.pose[0], FAST.position(0.0))
    difference = FAST.position(run.t) - run.pose
    np.testing.assert_allclose(run.error, difference, atol=ROUNDING)
    W = wheel_matrix(robot, [])
    np.testing.assert_allclose(run.wheel_speeds @ W.T, run.twist, atol=ROUNDING)
    assert run.driven == tuple(wheel.name for wheel in robot.driven)
    assert run.reports == ()


def test_heading_errors_go_the_shorter_way_round() -> None:
    """From -3 to a desired 3 rad: 0.28 rad to the right, not 6 to the left."""
    path = motion.circle(1.0, 0.2, heading=3.0)
    run = track(beside(), path, LECTURE_CT, duration=6.0, dt=0.01, pose=(0.0, 0.0, -3.0))
    assert run.error is not None
    assert run.error[0, 2] == pytest.approx(6.0 - 2 * math.pi, abs=ROUNDING)
    assert np.abs(run.error[:, 2]).max() < 0.3
    assert run.pose[-1, 2] == pytest.approx(3.0 - 2 * math.pi, abs=1e-3)


def test_a_trajectory_may_ask_for_the_plain_difference() -> None:
    class Plain(Wrapped):
        plain_heading = True

    path = Plain(motion.circle(1.0, 0.2, heading=3.0))
    run = track(beside(), path, LECTURE_CT, duration=8.0, dt=0.01, pose=(0.0, 0.0, -3.0))
    assert run.error is not None
    assert run.error[0, 2] == 6.0
    assert run.pose[-1, 2] == pytest.approx(3.0, abs=1e-3)


@pytest.mark.parametrize("ending", ["csv", "npz"])
def test_a_run_in_closed_loop_is_saved_and_loaded(tmp_path: Path, ending: str) -> None:
    runs = {
        "limited": track(lossy(), FAST, PD(KP, KD), duration=1.0, dt=0.02, **OFF),
        "told its twist": track(
            trundle.load("tricycle"), motion.circle(2.0, 0.3), Kanayama(), duration=1.0, dt=0.02
        ),
        "without masses": track(
            Robot(name="bare", wheels=trundle.load("differential").wheels),
            motion.circle(2.0, 0.3), Kanayama(), duration=1.0, dt=0.02,
        ),
    }  # fmt: skip
    with pytest.warns(StabilityWarning):
        runs["ended early"] = track(lossy(max_torque=1e9), FAST, PD(KP, KD), duration=500, dt=1.0)
    assert len(runs["limited"].reports) == 1
    assert runs["without masses"].torques is None
    assert runs["ended early"].reports
    for name, run in runs.items():
        back = Run.load(run.save(tmp_path / f"run.{ending}"))
        for field in dataclasses.fields(Run):
            wanted, got = getattr(run, field.name), getattr(back, field.name)
            assert (wanted is None) == (got is None), (name, field.name)
            if isinstance(wanted, np.ndarray):
                assert wanted.dtype == got.dtype, (name, field.name)
                np.testing.assert_array_equal(got, wanted, err_msg=f"{name}: {field.name}")
            else:
                assert got == wanted, (name, field.name)
        assert back == run


@pytest.mark.parametrize("ending", ["csv", "npz"])
def test_reports_of_a_run_that_ends_at_once_are_not_lost(tmp_path: Path, ending: str) -> None:
    run = track(beside(), FAST, Pusher(1e30), duration=1.0, dt=0.1)
    assert len(run.t) == 1
    two = dataclasses.replace(run, reports=("One thing.", 'Another, "quoted".\nAnd a line.'))
    for each in (run, two):
        assert Run.load(each.save(tmp_path / f"run.{ending}")) == each


# ---- own controllers -----------------------------------------------------------------------


@dataclasses.dataclass
class Pusher:
    """A force along x that does not change."""

    size: float
    output: str = "force"

    def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
        return [self.size, 0.0, 0.0], state


class Own:
    """A PD law of a user, called once a step."""

    output = "force"

    def __init__(self) -> None:
        self.called: list[float] = []

    def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
        self.called.append(measurement.t)
        e = reference.error(measurement.pose)
        return KP * e + KD * (reference.velocity - measurement.rate), state


@pytest.mark.parametrize("robot", [lossy("mecanum"), beside("omni3")], ids=["lossy", "plain"])
@pytest.mark.parametrize("method", ["lecture", "semi-implicit"])
def test_an_own_pd_law_does_as_the_built_in_one(robot: Robot, method: str) -> None:
    """These methods look at the law once a step, too."""
    settings: dict[str, Any] = {"duration": 2.0, "dt": 0.01, "method": method, **OFF}
    own = Own()
    runs = [track(robot, FAST, controller, **settings) for controller in (own, PD(KP, KD))]
    np.testing.assert_array_equal(own.called, runs[0].t[:-1])
    for field in FIELDS:
        np.testing.assert_allclose(
            getattr(runs[0], field), getattr(runs[1], field), atol=1e-9, err_msg=field
        )
    assert runs[0].reports == runs[1].reports


@pytest.mark.parametrize("method", ["rk4", "adaptive"])
def test_an_own_law_is_held_over_each_step(method: str) -> None:
    """A constant force in the body frame, by hand: a straight line of constant acceleration."""
    run = track(beside().with_body(com=(0.0, 0.0)), Resting(), Pusher(6.0), duration=2.0, dt=0.5,
                method=method)  # fmt: skip
    np.testing.assert_allclose(run.pose[:, 0], 0.5 * 6.0 / BESIDE["mass"] * run.t**2, atol=1e-10)
    np.testing.assert_allclose(run.pose[:, 1:], 0.0, atol=1e-12)
    assert run.force is not None
    np.testing.assert_allclose(run.force, np.tile([6.0, 0.0, 0.0], (4, 1)), atol=1e-12)


class Integrating:
    """A PID law: its memory is the integral of the error."""

    output = "force"

    def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
        e = reference.error(measurement.pose)
        total = (np.zeros(3) if state is None else state) + 0.01 * e
        force = KP * e + KD * (reference.velocity - measurement.rate) + [40.0, 40.0, 3.0] * total
        return force, total


def test_the_memory_of_an_own_controller_takes_the_error_to_zero() -> None:
    """A PD law stays behind on a steady friction; an integral makes up for it."""
    robot = beside().with_wheels(viscous_friction=0.5).with_body(com=(0.0, 0.0))

    class Ramp(Resting):
        def position(self, t: Any) -> Floats:
            return np.multiply.outer(np.asarray(t), [0.3, 0.0, 0.0])

        def velocity(self, t: Any) -> Floats:
            return np.broadcast_to([0.3, 0.0, 0.0], (*np.shape(t), 3))

    A, gains = rolling_rows(robot, robot.driven, [])
    G = A / gains[:, None]
    drag = (G.T @ (0.5 * (G @ [0.3, 0.0, 0.0])))[0]
    ends = {}
    for controller in (PD(KP, KD), Integrating()):
        run = track(robot, Ramp(), controller, duration=30.0, dt=0.01)
        assert run.error is not None
        ends[type(controller).__name__] = run.error[-1, 0]
    assert ends["PD"] == pytest.approx(drag / KP[0], rel=1e-6)
    assert abs(ends["Integrating"]) < 1e-4 < ends["PD"] / 100


def test_an_own_controller_of_torques() -> None:
    """Equal torques on the wheels of a differential drive: 20 kg pushed by 0.5 N m / 5 cm twice."""
    robot = trundle.load("differential").with_body(mass=20.0)
    run = track(robot, Resting(), Held([0.5, 0.5]), duration=2.0, dt=0.1, method="rk4")
    np.testing.assert_allclose(run.pose[:, 0], 0.5 * 1.0 * run.t**2, atol=1e-12)
    np.testing.assert_allclose(run.torques, 0.5)
    np.testing.assert_allclose(run.work, 20.0 * run.pose[:, 0], rtol=1e-9)  # type: ignore[arg-type]
    np.testing.assert_allclose(run.energy, run.work, atol=1e-9)  # type: ignore[arg-type]


def test_an_own_controller_of_twists() -> None:
    class Turning:
        output = "twist"

        def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
            return [0.4, 0.0, 0.5], state

    run = track(trundle.load("differential"), Resting(), Turning(), duration=2.0, dt=0.25)
    z = (run.pose[:, 0] + 1j * run.pose[:, 1]) / (0.4 / 0.5)
    np.testing.assert_allclose(z, 1j * (1 - np.exp(0.5j * run.t)), atol=ROUNDING)
    np.testing.assert_allclose(run.twist, np.tile([0.4, 0.0, 0.5], (8, 1)), atol=ROUNDING)
    # Half a track of 0.2 m on wheels of 5 cm.
    np.testing.assert_allclose(run.wheel_speeds, np.tile([6.0, 10.0], (8, 1)), atol=ROUNDING)


def test_a_controller_cannot_change_what_it_is_told() -> None:
    class Scribbling:
        output = "force"

        def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
            for array in (*measurement[1:], *reference[:3]):
                array[:] = 99.0
            return np.zeros(3), state

    run = track(beside(), FAST, Scribbling(), duration=0.5, dt=0.1, pose=(0, 0, 0), rate=(0, 0, 0))
    np.testing.assert_array_equal(run.pose, 0.0)
    np.testing.assert_allclose(run.desired, FAST.position(run.t))
    Scribbling.output = "twist"
    run = track(beside(), FAST, Scribbling(), duration=0.5, dt=0.1, pose=(0, 0, 0), rate=(0, 0, 0))
    np.testing.assert_array_equal(run.pose, 0.0)
    np.testing.assert_allclose(run.desired, FAST.position(run.t))


# ---- own trajectories ----------------------------------------------------------------------


def own_trajectory(change: Callable[[Callable[[Any], Any]], Callable[[Any], Any]]) -> Any:
    """Return the fast ellipse by three own functions, each changed."""

    class Own:
        position = staticmethod(change(FAST.position))
        velocity = staticmethod(change(FAST.velocity))
        acceleration = staticmethod(change(FAST.acceleration))

    return Own()


def one_time_only(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda t: [float(value) for value in function(float(t))]


def branching(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda t: function(t) if t >= 0 else np.zeros(3)


def transposed(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda t: np.asarray(function(t)).T


def same_array(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    held = np.zeros(3)

    def fill(t: Any) -> Floats:
        held[:] = function(float(t))
        return held

    return fill


@pytest.mark.parametrize("change", [one_time_only, branching, transposed, same_array])
@pytest.mark.parametrize(("method", "steps"), [("semi-implicit", 2), ("rk4", 10), ("adaptive", 3)])
def test_own_trajectories_of_any_form(change: Any, method: str, steps: int) -> None:
    settings: dict[str, Any] = {"duration": steps * 0.1, "dt": 0.1, "method": method, **OFF}
    wanted = track(beside(), FAST, LECTURE_CT, **settings)
    run = track(beside(), own_trajectory(change), LECTURE_CT, **settings)
    np.testing.assert_allclose(run.pose, wanted.pose, atol=1e-9)
    np.testing.assert_allclose(run.desired, wanted.desired, atol=ROUNDING)


def test_a_trajectory_may_tell_how_long_it_lasts() -> None:
    class Lasting(Resting):
        duration = 0.5

    assert track(beside(), Lasting(), LECTURE_CT, dt=0.1).t[-1] == 0.5
    assert track(beside(), Lasting(), LECTURE_CT, dt=0.1, duration=0.2).t[-1] == 0.2
    with pytest.raises(TrundleError, match="give a duration"):
        track(beside(), Resting(), LECTURE_CT)


# ---- stability -----------------------------------------------------------------------------


def named_step(method: str, controller: Any, dt: float, robot: Robot | None = None) -> float:
    """Return the step [s] that the warning names."""
    with pytest.warns(StabilityWarning) as told:
        track(robot or lecture_robot(), Resting(), controller, duration=5 * dt, dt=dt,
              method=method)  # fmt: skip
    found = re.search(r"below ([\d.e-]+) s", str(told[0].message))
    assert found is not None, str(told[0].message)
    return float(found[1])


K, C = 4.0, 3.0  # e_dd + C e_d + K e = 0
# From the characteristic polynomials of one step, by the Jury test.
LIMITS = {
    # det = 1 - C h + K h^2 / 2 < 1 and 1 + trace + det = 4 - 2 C h > 0
    "lecture": min(2 * C / K, 2 / C),
    # v' = v - h (K x + C v), x' = x + h v':  4 - 2 C h - K h^2 > 0
    "semi-implicit": (-C + math.sqrt(C * C + 4 * K)) / K,
}


@pytest.mark.parametrize("method", LIMITS)
def test_the_longest_stable_step_is_that_of_the_jury_test(method: str) -> None:
    controller = ComputedTorque([K] * 3, [C] * 3)
    limit = LIMITS[method]
    # Two digits are printed.
    assert named_step(method, controller, 1.5 * limit) == pytest.approx(limit, rel=0.05)


@each_fixed_step
@pytest.mark.parametrize("law", ["PD", "computed torque, wrong model"])
def test_the_step_that_is_named_parts_stable_from_unstable(law: str, method: str) -> None:
    controller = laws()[law][0]
    limit = named_step(method, controller, 2.0, beside())
    small = {"pose": (1e-5, -1e-5, 1e-5)}

    def later(dt: float) -> float:
        run = track(beside(), Resting(), controller, duration=400 * dt, dt=dt, method=method,
                    **small)  # type: ignore[arg-type]  # fmt: skip
        assert run.error is not None
        return float(np.abs(run.error[-1]).max())

    # The printed step has two digits: a tenth off on either side is surely beyond them.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert later(0.9 * limit) < 1e-6
    with pytest.warns(StabilityWarning, match="too long"):
        assert later(1.1 * limit) > 1e-4


def test_gains_without_damping_are_no_reason_to_warn_where_nothing_grows() -> None:
    """The semi-implicit step keeps an oscillation as it is; rk4 lets it die out slowly."""
    for method in ("semi-implicit", "rk4"):
        track(beside(), Resting(), PD(KP, (0, 0, 0)), duration=0.1, dt=0.01, method=method)
        track(beside(), Resting(), PD((0, 0, 0), (0, 0, 0)), duration=0.1, dt=0.01, method=method)


def test_the_lectures_step_without_damping_is_stable_at_no_step() -> None:
    """det = 1 + K h^2 / 2 > 1 for every h: no shorter step mends it."""
    with pytest.warns(StabilityWarning, match="unstable at any step"):
        track(beside(), Resting(), PD(KP, (0, 0, 0)), duration=0.5, dt=0.05, method="lecture")


@pytest.mark.parametrize("believed", [0.001, 0.002, 0.05, 2.0])
def test_a_model_with_too_much_friction_is_unstable_at_any_step(believed: float) -> None:
    """The controller pushes along with the turning, harder than it damps."""
    robot, kd = lecture_robot(), 0.05
    A, gains = rolling_rows(robot, robot.driven, [])
    ahead = believed * np.sum((A[:, 2] / gains) ** 2) / 0.1  # 1/s that the model feeds back
    assert ahead > kd
    model = Dynamics(robot.with_wheels(viscous_friction=believed))
    controller = ComputedTorque([4] * 3, [kd] * 3, model=model)
    for method in ("semi-implicit", "rk4"):
        with pytest.warns(StabilityWarning, match="unstable at any step"):
            track(robot, Resting(), controller, duration=0.1, dt=0.01, method=method)


def test_a_step_too_long_for_friction_is_not_blamed_on_gains() -> None:
    """Smoothed Coulomb friction is stiff near rest: 0.05 N m within 0.01 rad/s."""
    robot = beside("mecanum").with_wheels(coulomb_friction=0.05)
    with pytest.warns(StabilityWarning, match="friction"):
        track(robot, Resting(), PD([0] * 3, [0] * 3), duration=0.1, dt=0.02)


def test_gains_beyond_all_numbers_are_warned_of_too() -> None:
    with pytest.warns(StabilityWarning):
        track(beside(), Resting(), PD([1e22] * 3, [1e22] * 3), duration=0.1, dt=0.01)


def test_the_warning_points_at_the_call() -> None:
    with pytest.warns(StabilityWarning) as told:
        track(beside(), Resting(), PD(KP, KD), duration=4.0, dt=2.0)
    assert Path(told[0].filename).name == Path(__file__).name


@each_fixed_step
def test_a_motion_that_outgrows_all_numbers_ends_the_run_early(method: str) -> None:
    with pytest.warns(StabilityWarning, match="too long for these gains"):
        run = track(beside(), FAST, PD(KP, KD), duration=1000.0, dt=1.0, method=method)
    steps = len(run.t) - 1
    assert 1 < steps < 1000
    for field in dataclasses.fields(Run):
        values = getattr(run, field.name)
        if isinstance(values, np.ndarray):
            assert len(values) in (steps, steps + 1), field.name
            assert np.isfinite(values).all(), field.name
    (said,) = run.reports
    assert f"t = {run.t[-1]:.4g} s of 1000 s" in said
    assert "shorter step" in said


@each_fixed_step
def test_an_own_law_that_outgrows_all_numbers_ends_the_run_early(method: str) -> None:
    class Running:
        output = "force"

        def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
            return 1e5 * (1.0 + measurement.rate), state

    run = track(beside(), FAST, Running(), duration=10.0, dt=0.1, method=method)
    assert len(run.t) < 101
    assert np.isfinite(run.pose).all()
    assert "beyond all bounds" in run.reports[0]


def test_an_own_law_of_twists_that_outgrows_all_numbers_ends_the_run_early() -> None:
    class Running:
        output = "twist"

        def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
            return [1e13 * (1.0 + abs(measurement.rate[0])), 0.0, 0.0], state

    run = track(beside(), Resting(), Running(), duration=10.0, dt=0.1)
    assert len(run.t) < 101
    assert np.isfinite(run.pose).all()
    assert "beyond all bounds" in run.reports[0]


# ---- refusals ------------------------------------------------------------------------------

OMNI = trundle.load("omni3")
DIFFERENTIAL = trundle.load("differential")
BARE = Robot(name="bare", wheels=OMNI.wheels)


def refused(match: str, robot: Any, controller: Any, trajectory: Any = FAST, **more: Any) -> None:
    with pytest.raises(TrundleError, match=match):
        track(robot, trajectory, controller, **({"duration": 0.1} | more))


@pytest.mark.parametrize("controller", [PD([1] * 3, [1] * 3), LECTURE_CT], ids=["PD", "CT"])
def test_forces_are_refused_for_robots_that_cannot_move_sideways(controller: Any) -> None:
    refused("'differential'.*2 of 3 ways.*Kanayama.*ReducedComputedTorque", DIFFERENTIAL,
            controller)  # fmt: skip
    refused("'skid_steer'.*2 of 3 ways", trundle.load("skid_steer"), controller)


def test_forces_and_torques_are_refused_for_robots_that_steer() -> None:
    for name in ("swerve", "tricycle", "omni_steer"):
        refused(f"'{name}' steers.*Kanayama", trundle.load(name), LECTURE_CT)
        refused(f"'{name}' steers.*Kanayama", trundle.load(name), Held([1.0]))


def test_missing_masses_are_told() -> None:
    for controller in (LECTURE_PD, LECTURE_CT, Own()):
        with pytest.raises(RobotError, match=r"'bare': .*mass, inertia, com are missing"):
            track(BARE, FAST, controller, duration=0.1)


def test_what_is_no_robot_is_refused() -> None:
    refused("a Robot is needed.*'omni3'", "omni3", LECTURE_CT)


@pytest.mark.parametrize("method", ["euler", None, 3, ["rk4"]])
def test_an_unknown_method_is_refused(method: Any) -> None:
    refused("method must be one of lecture, semi-implicit, rk4, adaptive", OMNI, LECTURE_CT,
            method=method)  # fmt: skip


@pytest.mark.parametrize("dt", [0.0, -0.1, math.nan, math.inf, "0.1", None, [0.1]])
def test_a_bad_step_is_refused(dt: Any) -> None:
    refused("dt must be a positive number of seconds", OMNI, LECTURE_CT, dt=dt)


@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf, "long", [1.0], 1j])
def test_a_bad_duration_is_refused(duration: Any) -> None:
    refused("duration must be a positive number of seconds", OMNI, LECTURE_CT, duration=duration)


def test_too_many_steps_are_refused() -> None:
    refused("take longer steps", OMNI, LECTURE_CT, duration=1e9, dt=1e-3)


@pytest.mark.parametrize(("name", "unit"), [("pose", "m"), ("rate", "m/s")])
def test_a_bad_start_is_refused(name: str, unit: str) -> None:
    refused(f"{name} must be three numbers", OMNI, LECTURE_CT, **{name: (1.0, 2.0)})
    refused(f"{name} must be finite", OMNI, LECTURE_CT, **{name: (1.0, math.nan, 0.0)})
    refused(f"{name} must be an array of numbers", OMNI, LECTURE_CT, **{name: unit})


def trajectory_of(position: Callable[[float], Any]) -> Any:
    class Bad(Resting):
        pass

    bad = Bad()
    bad.position = position  # type: ignore[method-assign,assignment]
    return bad


@pytest.mark.parametrize(
    ("position", "match"),
    [
        (lambda _: [math.nan, 0.0, 0.0], "position.*finite"),
        (lambda t: [math.nan if t > 0.05 else 0.0, 0.0, 0.0], "position.*finite"),
        (lambda _: None, "position"),
        (lambda _: [0.0, 0.0], r"position.*\(3,\).*\(2,\)"),
        (lambda _: 0.0, r"position.*\(3,\)"),
        (lambda _: ["a", "b", "c"], "position.*numbers"),
        (lambda t: [0.0] * (3 if t < 0.05 else 2), "position"),
    ],
)
def test_a_trajectory_that_gives_other_than_poses_is_refused(position: Any, match: str) -> None:
    refused(match, OMNI, LECTURE_CT, trajectory_of(position))


def test_what_is_no_trajectory_is_refused() -> None:
    for nothing in (None, "circle", [0.0, 0.0, 0.0]):
        refused("position.*velocity.*acceleration", OMNI, LECTURE_CT, nothing)


@pytest.mark.parametrize(
    "sample",
    [
        lambda _: 3,
        lambda t: np.full((3, len(t), 3), np.nan),
        lambda _: np.zeros((3, 2)),
        lambda: 0,
        lambda t: [[[0.0] * 3] * len(t)] * 3,
    ],
)
def test_an_own_method_called_sample_is_checked_or_not_used(sample: Any) -> None:
    """A class of a user may have a method of that name for its own ends."""
    own = Resting()
    own.sample = sample  # type: ignore[attr-defined]
    try:
        run = track(OMNI, own, LECTURE_CT, duration=0.1)
    except TrundleError as error:
        assert "sample" in str(error)  # noqa: PT017  either is well
    else:
        np.testing.assert_array_equal(run.desired, 0.0)


@pytest.mark.parametrize("controller", [None, object(), "PD", 3.0])
def test_what_is_no_controller_is_refused(controller: Any) -> None:
    refused(r"step\(state, measurement, reference\).*force, torques, twist", OMNI, controller)


@pytest.mark.parametrize("controller", [PD, Kanayama, Own])
def test_a_class_in_place_of_a_controller_is_refused(controller: Any) -> None:
    refused("controller", OMNI, controller)


def test_an_unknown_output_is_refused() -> None:
    refused("force, torques, twist", OMNI, Pusher(1.0, output="acceleration"))


class Answering:
    def __init__(self, output: str, answer: Any) -> None:
        self.output, self.answer = output, answer

    def step(self, state: Any, measurement: Measurement, reference: Reference) -> Any:
        return self.answer


@pytest.mark.parametrize("output", ["force", "torques", "twist"])
def test_a_step_that_returns_no_pair_is_refused(output: str) -> None:
    for answer in (None, np.zeros(3), [1.0, 2.0, 3.0], ([0.0] * 3,), 1.0):
        refused("must return command and state", OMNI, Answering(output, answer))


@pytest.mark.parametrize("output", ["force", "torques", "twist"])
def test_a_command_that_is_no_three_numbers_is_refused(output: str) -> None:
    for command in ([0.0, 0.0], [math.nan, 0.0, 0.0], "push", [[1.0], 0.0, 0.0], 1.0, None):
        with pytest.raises(ShapeError, match=f"the controller's {output} must be"):
            track(OMNI, FAST, Answering(output, (command, None)), duration=0.1)


def test_complex_commands_are_refused() -> None:
    with pytest.raises(ShapeError, match="the controller's force must be"):
        track(OMNI, FAST, Answering("force", (np.array([1j, 0, 0]), None)), duration=0.1)
