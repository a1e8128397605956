"""Simulation: orders of convergence, commands, the lectures' runs, files, casters."""

import dataclasses
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import integrate, optimize

import trundle
from catalogue import CURVED, ROBOTS, each_robot, each_steered, feasible_twists
from geometry import Floats, misfits, wheel_matrix
from trundle import Run, simulate
from trundle.errors import FileError, ShapeError, TrundleError
from trundle.robot import CasterWheel, FixedWheel, Robot, SteeredWheel
from trundle.simulation import caster_angles

# Sums of a thousand steps of numbers near 1, each rounded at 1e-16.
ROUNDING = 1e-12
# Slopes of measured errors, over three halvings of a step that is not yet tiny.
ORDER = 0.15
# Tolerances of the reference integrator (DOP853), well below the errors measured against it.
REFERENCE = {"rtol": 1e-13, "atol": 1e-13, "method": "DOP853"}

START = (0.5, -0.2, 0.7)
METHODS = ("exact", "euler", "rk4")


def circle(pose: tuple[float, float, float], twist: Floats, t: float) -> Floats:
    """Return the pose at a constant twist: z + e^(i psi) (u + iv) (e^(i r t) - 1) / (i r)."""
    u, v, r = twist
    z = complex(pose[0], pose[1])
    chord = (np.exp(1j * r * t) - 1) / (1j * r) if r else t
    z += np.exp(1j * pose[2]) * complex(u, v) * chord
    return np.array([z.real, z.imag, pose[2] + r * t])


def reference(twist: Callable[[float], Floats], duration: float) -> Floats:
    """Return the end pose of eta_dot = J(psi) zeta(t), by a step-controlled integrator."""

    def slope(t: float, pose: Floats) -> list[float]:
        u, v, r = twist(t)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        return [c * u - s * v, s * u + c * v, r]

    return np.asarray(integrate.solve_ivp(slope, (0.0, duration), START, **REFERENCE).y[:, -1])


def slopes(errors: list[float]) -> list[float]:
    return [math.log2(a / b) for a, b in itertools.pairwise(errors)]


# ---- orders of convergence -----------------------------------------------------------------


@each_robot
@pytest.mark.parametrize("dt", [0.1, 0.07, 5.0])
def test_exact_has_no_error_for_a_constant_twist(robot: Robot, dt: float) -> None:
    twist = feasible_twists(robot, ())
    duration = 2.0
    if robot is CURVED:  # whose inverse is a search for each step
        duration = 1.5 * dt
    run = simulate(robot, twist=twist, duration=duration, dt=dt, pose=START)
    # The curved robot's twists are met to the digits of a search only.
    np.testing.assert_allclose(
        run.twist,
        np.tile(twist, (len(run.t) - 1, 1)),
        atol=1e-6 if robot is CURVED else ROUNDING,
    )
    for time, pose in zip(run.t, run.pose, strict=True):
        np.testing.assert_allclose(pose, circle(START, run.twist[0], time), atol=ROUNDING)


def speeds_in_time(t: Any) -> Floats:
    return np.stack([3 + np.sin(2 * t), np.cos(t), 2 - t, np.sin(3 * t + 1)], axis=-1)


@pytest.mark.parametrize(("method", "order"), [("exact", 1), ("euler", 1), ("rk4", 4)])
def test_the_order_of_convergence_with_wheel_speeds_in_time(method: str, order: int) -> None:
    robot = trundle.load("mecanum")
    W = wheel_matrix(robot, [])
    end = reference(lambda t: W @ speeds_in_time(t), 2.0)
    errors = [
        float(np.abs(simulate(
            robot, wheel_speeds=speeds_in_time, duration=2.0, dt=dt, pose=START, method=method
        ).pose[-1] - end).max())
        for dt in (0.2, 0.1, 0.05, 0.025)
    ]  # fmt: skip
    assert slopes(errors) == pytest.approx([order] * 3, abs=ORDER)


@pytest.mark.parametrize(("method", "order"), [("exact", 1), ("euler", 1), ("rk4", 4)])
def test_the_order_of_convergence_with_steering_in_time(method: str, order: int) -> None:
    robot = trundle.load("tricycle", wheelbase=0.8, radius=0.1)

    def steering(t: Any) -> Floats:
        return 0.6 * np.sin(np.asarray(t) + 0.3)[..., None]

    def speed(t: Any) -> Floats:
        return 10 + 4 * np.cos(2 * np.asarray(t))[..., None]

    end = reference(lambda t: wheel_matrix(robot, steering(t)) @ speed(t), 2.0)
    errors = [
        float(np.abs(simulate(
            robot, wheel_speeds=speed, steering=steering, duration=2.0, dt=dt, pose=START,
            method=method,
        ).pose[-1] - end).max())
        for dt in (0.2, 0.1, 0.05, 0.025)
    ]  # fmt: skip
    assert slopes(errors) == pytest.approx([order] * 3, abs=ORDER)


@pytest.mark.parametrize("name", ["swerve", "two_steered", "omni4", "ackermann"])
@pytest.mark.parametrize(("method", "order"), [("exact", 1), ("rk4", 4)])
def test_the_order_of_convergence_with_twists_in_time(name: str, method: str, order: int) -> None:
    sideways = 0.0 if name == "ackermann" else 1.0

    def twist(t: Any) -> Floats:
        return np.stack([1 + t, sideways * np.sin(t), 0.7 * np.cos(2 * t)], axis=-1)

    end = reference(twist, 2.0)
    errors = [
        float(np.abs(simulate(
            ROBOTS[name], twist=twist, duration=2.0, dt=dt, pose=START, method=method
        ).pose[-1] - end).max())
        for dt in (0.2, 0.1, 0.05)
    ]  # fmt: skip
    assert slopes(errors) == pytest.approx([order] * 2, abs=ORDER)


def test_euler_on_a_circle_by_hand() -> None:
    """Each step turns by r dt and goes u dt: the corners of a polygon."""
    u, r, dt = 1.0, 0.5, 0.1
    robot = trundle.load("differential")
    run = simulate(robot, twist=[u, 0.0, r], duration=3.0, dt=dt, pose=START, method="euler")
    z = complex(*START[:2])
    for k in range(30):
        z += u * dt * np.exp(1j * (START[2] + r * dt * k))
    assert complex(*run.pose[-1, :2]) == pytest.approx(z, abs=ROUNDING)


@pytest.mark.parametrize("method", METHODS)
def test_the_start_pose_only_moves_the_path(method: str) -> None:
    robot = trundle.load("omni3")
    here = simulate(robot, wheel_speeds=[1.0, -2.0, 0.5], duration=1.0, method=method)
    there = simulate(robot, wheel_speeds=[1.0, -2.0, 0.5], duration=1.0, method=method, pose=START)
    moved = complex(*START[:2]) + np.exp(1j * START[2]) * (here.pose[:, 0] + 1j * here.pose[:, 1])
    np.testing.assert_allclose(there.pose[:, 0] + 1j * there.pose[:, 1], moved, atol=ROUNDING)
    np.testing.assert_allclose(there.pose[:, 2], here.pose[:, 2] + START[2], atol=ROUNDING)


def test_the_way_back_ends_where_the_way_began() -> None:
    robot, speeds = trundle.load("mecanum"), np.random.default_rng(51).normal(size=(50, 4)) * 10
    there = simulate(robot, wheel_speeds=speeds, dt=0.05, pose=START)
    back = simulate(robot, wheel_speeds=-speeds[::-1], dt=0.05, pose=there.pose[-1])
    np.testing.assert_allclose(back.pose[-1], START, atol=ROUNDING)


def test_running_twice_gives_the_same() -> None:
    runs = [
        simulate(trundle.load("omni4"), wheel_speeds=speeds_in_time, duration=1.0, method="rk4")
        for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0].pose, runs[1].pose)


# ---- the lectures --------------------------------------------------------------------------

LECTURE = {"duration": 10.0, "dt": 0.1, "pose": (0.5, 0.5, math.pi / 4)}


@pytest.mark.parametrize(
    ("name", "W", "speeds"),
    [
        ("differential", [[0.1, 0.1], [0, 0], [-1 / 3, 1 / 3]], (0.5, 0.3)),
        (
            "omni3",
            [
                [0, -0.2 / math.sqrt(3), 0.2 / math.sqrt(3)],
                [0.4 / 3, -0.2 / 3, -0.2 / 3],
                [2 / 9, 2 / 9, 2 / 9],
            ],
            (0.5, -0.2, 0.3),
        ),
        (
            "mecanum_lecture",
            [[0.05] * 4, [0.05, -0.05, 0.05, -0.05], [-0.25, -0.25, 0.25, 0.25]],
            (0.5, 0.1, 0.4, 0.2),
        ),
    ],
)
def test_the_lectures_loop(name: str, W: list[list[float]], speeds: tuple[float, ...]) -> None:
    """The lectures' Euler loop in plain Python: a = 0.2, l = 0.3 (mecanum: d = 0.5), dt = 0.1."""
    sizes = {"radius": 0.2, "track": 0.6} if name == "differential" else {}
    run = simulate(trundle.load(name, **sizes), wheel_speeds=speeds, method="euler", **LECTURE)  # type: ignore[arg-type]
    x, y, psi = LECTURE["pose"]  # type: ignore[misc]
    u, v, r = (sum(a * w for a, w in zip(row, speeds, strict=True)) for row in W)
    for k in range(100):
        assert run.pose[k] == pytest.approx((x, y, psi), abs=ROUNDING)
        x += 0.1 * (math.cos(psi) * u - math.sin(psi) * v)
        y += 0.1 * (math.sin(psi) * u + math.cos(psi) * v)
        psi += 0.1 * r
    assert run.pose[-1] == pytest.approx((x, y, psi), abs=ROUNDING)


@pytest.mark.parametrize("method", METHODS)
def test_equal_speeds_turn_omni3_on_the_spot(method: str) -> None:
    run = simulate(trundle.load("omni3"), wheel_speeds=[0.5] * 3, method=method, **LECTURE)  # type: ignore[arg-type]
    np.testing.assert_allclose(run.pose[:, :2], 0.5, atol=ROUNDING)
    np.testing.assert_allclose(run.pose[:, 2], math.pi / 4 + run.t / 3, atol=ROUNDING)


@pytest.mark.parametrize("method", METHODS)
def test_opposite_speeds_drive_omni3_straight_ahead(method: str) -> None:
    run = simulate(trundle.load("omni3"), wheel_speeds=[0, -0.5, 0.5], method=method, **LECTURE)  # type: ignore[arg-type]
    way = 0.2 / math.sqrt(3) * run.t  # 0.11547 m/s
    np.testing.assert_allclose(run.pose[:, 0], 0.5 + way / math.sqrt(2), atol=ROUNDING)
    np.testing.assert_allclose(run.pose[:, 1], 0.5 + way / math.sqrt(2), atol=ROUNDING)
    np.testing.assert_allclose(run.pose[:, 2], math.pi / 4, atol=ROUNDING)


def test_the_exercise_turns_once_on_the_spot() -> None:
    T, l, r_w = 5.0, 0.5, 0.1
    speeds = [-2 * math.pi * l / (T * r_w)] * 3
    run = simulate(trundle.load("omni3_exercise"), wheel_speeds=speeds, duration=T)
    np.testing.assert_allclose(run.pose[-1], [0.0, 0.0, 2 * math.pi], atol=ROUNDING)
    np.testing.assert_allclose(run.pose[:, :2], 0.0, atol=ROUNDING)


def test_the_exercise_drives_a_line() -> None:
    """Its wheels spin clockwise, so (0, c, -c) goes forward at 2 r_w c / sqrt(3)."""
    c, r_w = 2.0, 0.1
    run = simulate(trundle.load("omni3_exercise"), wheel_speeds=[0, c, -c], duration=3.0)
    np.testing.assert_allclose(run.pose[-1], [3 * 2 * r_w * c / math.sqrt(3), 0, 0], atol=ROUNDING)


@pytest.mark.parametrize("method", METHODS)
def test_the_exercise_drives_a_circle(method: str) -> None:
    """cos(2 pi t / T - alpha_i): a circle of radius r_w T / (2 pi), to the left, not turning."""
    T, r_w = 4.0, 0.1
    alphas = np.radians([0.0, 120.0, 240.0])

    def speeds(t: Any) -> Floats:
        return np.cos(2 * np.pi * np.asarray(t)[..., None] / T - alphas)

    run = simulate(trundle.load("omni3_exercise"), wheel_speeds=speeds, duration=T, dt=T / 400,
                   method=method)  # fmt: skip
    radius = r_w * T / (2 * math.pi)
    centre = complex(radius, 0.0)
    arm = run.pose[:, 0] + 1j * run.pose[:, 1] - centre
    # rk4 is Simpson's rule here; the others lag half a step of 1/400 of a turn.
    error = 1e-9 if method == "rk4" else 2 * math.pi / 800
    np.testing.assert_allclose(np.abs(arm), radius, atol=radius * error * 1.01)
    np.testing.assert_allclose(np.unwrap(np.angle(arm)) - np.angle(arm[0]),
                               2 * np.pi * run.t / T, atol=2.1 * error)  # fmt: skip
    np.testing.assert_allclose(run.pose[:, 2], 0.0, atol=ROUNDING)


# ---- commands ------------------------------------------------------------------------------


def test_constant_sampled_and_function_commands_agree() -> None:
    robot, speeds = trundle.load("omni3"), [0.3, -0.2, 0.9]
    runs = [
        simulate(robot, wheel_speeds=speeds, duration=1.0, dt=0.1),
        simulate(robot, wheel_speeds=np.tile(speeds, (10, 1)), dt=0.1),
        simulate(robot, wheel_speeds=np.tile(speeds, (10, 1)), duration=1.0, dt=0.1),
        simulate(robot, wheel_speeds=lambda _: speeds, duration=1.0, dt=0.1),
    ]
    for run in runs[1:]:
        for field in ("t", "pose", "twist", "wheel_speeds", "wheel_angles", "steering"):
            np.testing.assert_allclose(getattr(run, field), getattr(runs[0], field), atol=ROUNDING)


def at_times(t: Floats) -> Floats:
    return np.stack([np.sin(t), t, t**2], axis=-1)


FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "of a time or of times": at_times,
    "of one time": lambda t: [math.sin(t), t, t**2],
    "that branches": lambda t: [math.sin(t), t, t**2] if t > -1 else [0, 0, 0],
    "transposed for times": lambda t: np.array([np.sin(t), t, t**2]),
    "transposed list for times": lambda t: [np.sin(t), t, t**2],
    "with a constant": lambda t: [np.sin(t), t + 0.0, t**2 * 1.0],
    "of whole numbers": lambda t: (np.sin(t), t, t * t),
}


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 10])
@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_functions_of_any_form_are_called_rightly(
    function: Callable[[Any], Any], steps: int
) -> None:
    run = simulate(
        trundle.load("omni3"), wheel_speeds=function, duration=steps * 0.25, dt=0.25, method="rk4"
    )
    np.testing.assert_allclose(run.wheel_speeds, at_times(run.t[:-1]), atol=ROUNDING)


@pytest.mark.parametrize("method", METHODS)
def test_a_transposed_function_is_not_taken_for_the_other_form(method: str) -> None:
    """Four wheels and four times make a square; its first and last rows are zero either way."""

    def pulse(t: Any) -> list[Any]:
        return [0 * t, t**2 * (3 - t), 0 * t, 0 * t]

    run = simulate(trundle.load("omni"), wheel_speeds=pulse, duration=3.0, dt=1.0, method=method)
    np.testing.assert_array_equal(run.wheel_speeds, [[0, 0, 0, 0], [0, 2, 0, 0], [0, 4, 0, 0]])


def test_a_function_that_fills_the_same_array_again() -> None:
    held = np.zeros(2)

    def command(t: Any) -> Floats:
        held[:] = float(t)
        return held

    run = simulate(trundle.load("differential"), wheel_speeds=command, duration=1.0, dt=0.25)
    np.testing.assert_array_equal(run.wheel_speeds[:, 0], run.t[:-1])


def test_a_run_keeps_its_own_commands() -> None:
    speeds = np.ones((4, 2))
    run = simulate(trundle.load("differential"), wheel_speeds=speeds, dt=0.1)
    speeds[:] = 7.0
    np.testing.assert_array_equal(run.wheel_speeds, np.ones((4, 2)))


def test_euler_and_exact_take_a_function_at_the_start_of_each_step() -> None:
    for method in ("exact", "euler"):
        run = simulate(
            trundle.load("differential"),
            wheel_speeds=lambda t: [t, t],
            duration=1.0,
            dt=0.25,
            method=method,
        )
        np.testing.assert_allclose(run.wheel_speeds[:, 0], [0.0, 0.25, 0.5, 0.75], atol=ROUNDING)
        np.testing.assert_allclose(run.wheel_angles[-1], 0.25 * 1.5, atol=ROUNDING)


def test_rk4_turns_the_wheels_by_the_integral_of_their_speeds() -> None:
    run = simulate(
        trundle.load("differential"),
        wheel_speeds=lambda t: [3 * t**2, 1 - t],
        duration=2.0,
        dt=0.5,
        method="rk4",
    )
    # Simpson's rule is exact for cubics.
    np.testing.assert_allclose(run.wheel_angles[:, 0], run.t**3, atol=ROUNDING)
    np.testing.assert_allclose(run.wheel_angles[:, 1], run.t - run.t**2 / 2, atol=ROUNDING)


@pytest.mark.parametrize(
    ("duration", "dt", "steps"),
    [(1.05, 0.1, 11), (0.3, 0.1, 3), (0.7, 0.1, 7), (0.05, 0.1, 1), (1.0, 1.0, 1), (2.1, 0.7, 3)],
)
def test_the_last_step_is_shorter(duration: float, dt: float, steps: int) -> None:
    run = simulate(
        trundle.load("differential"), twist=[1.0, 0.0, 0.4], duration=duration, dt=dt, pose=START
    )
    assert len(run.t) == steps + 1
    assert run.t[-1] == duration
    assert (np.diff(run.t) > 0).all()
    np.testing.assert_allclose(np.diff(run.t)[:-1], dt, atol=ROUNDING)
    np.testing.assert_allclose(run.pose[-1], circle(START, [1.0, 0, 0.4], duration), atol=ROUNDING)
    np.testing.assert_allclose(run.wheel_angles[-1], duration * run.wheel_speeds[0], atol=ROUNDING)


@pytest.mark.parametrize("name", ["differential", "swerve"])
@pytest.mark.parametrize("method", METHODS)
def test_no_rows_are_no_motion(name: str, method: str) -> None:
    run = simulate(ROBOTS[name], twist=np.zeros((0, 3)), pose=START, method=method)
    np.testing.assert_array_equal(run.pose, [START])
    assert run.wheel_speeds.shape == (0, len(ROBOTS[name].driven))


def test_numbers_of_numpy_are_seconds() -> None:
    robot = trundle.load("differential")
    run = simulate(robot, wheel_speeds=[1, 1], duration=np.int64(1), dt=np.float32(0.25))
    assert len(run.t) == 5


# ---- twists as commands --------------------------------------------------------------------


@each_robot
@pytest.mark.parametrize("method", METHODS)
def test_each_contact_moves_as_its_wheel_says_at_every_step(robot: Robot, method: str) -> None:
    twists = np.random.default_rng(52).normal(size=(6 if robot is not CURVED else 1, 3))
    run = simulate(robot, twist=twists, dt=0.1, method=method)
    for twist, speeds, angles in zip(run.twist, run.wheel_speeds, run.steering, strict=True):
        assert max(misfits(robot, twist, speeds, angles).values()) < ROUNDING


def wander(t: Any) -> Floats:
    """A smooth twist whose direction turns more than a whole turn, and that reverses."""
    t = np.asarray(t)
    return np.stack([np.cos(1.3 * t), np.sin(1.3 * t), 0.4 * np.cos(t)], axis=-1)


@pytest.mark.parametrize("name", ["swerve", "two_steered", "synchro", "odd_swerve", "omni_steer"])
@pytest.mark.parametrize("method", METHODS)
def test_steering_has_no_half_turn_jumps(name: str, method: str) -> None:
    run = simulate(ROBOTS[name], twist=wander, duration=8.0, dt=0.01, method=method)
    # A wheel that the body's centre passes turns fast, but never half a turn in a hundredth.
    assert np.abs(np.diff(run.steering, axis=0)).max() < 1.0


@pytest.mark.parametrize("name", ["tricycle", "bicycle", "ackermann", "swerve", "two_steered"])
def test_a_robot_that_reverses_turns_its_wheels_backwards(name: str) -> None:
    run = simulate(ROBOTS[name], twist=lambda t: [math.cos(t), 0.0, 0.0], duration=3.0, dt=0.01)
    assert (run.wheel_speeds[0] > 0).all()
    assert (run.wheel_speeds[-1] < 0).all()
    np.testing.assert_allclose(run.steering, 0.0, atol=ROUNDING)


REVERSALS: dict[str, Callable[[Any], Any]] = {
    "backwards from rest": lambda t: np.stack([-np.sin(t), 0 * t, 0 * t], axis=-1),
    "turned round in the first half step": lambda t: np.stack([0.02 - t, 0 * t, 0 * t], axis=-1),
    "sideways from rest": lambda t: np.stack([0 * t, -np.sin(t), 0 * t], axis=-1),
    "across the cut of the angle": lambda t: np.stack([0 * t - 1, t - 0.02, 0 * t], axis=-1),
}


@pytest.mark.parametrize("twist", REVERSALS.values(), ids=REVERSALS)
@pytest.mark.parametrize("name", ["swerve", "two_steered", "tricycle"])
def test_rk4_takes_one_branch_of_the_steering_angle_over_a_step(
    name: str, twist: Callable[[Any], Any]
) -> None:
    """Start, middle and end of a step must mean the same flip: the wheels turn by their speeds."""
    run = simulate(ROBOTS[name], twist=twist, duration=1.0, dt=0.1, method="rk4")
    speeds = run.wheel_speeds
    trapezoid = 0.05 * (speeds[:-1] + speeds[1:])
    # Speeds here change by about 2 rad/s in a step: the trapezoid's own error is far below 0.02.
    np.testing.assert_allclose(np.diff(run.wheel_angles, axis=0)[:-1], trapezoid, atol=0.02)


def test_a_reversal_within_wide_steering_limits_does_not_jump() -> None:
    """At +-200 deg both the angle and its half-turn flip are allowed: the present one is kept."""
    robot = trundle.load("swerve").with_wheels(steering_min=-3.5, steering_max=3.5)
    run = simulate(robot, twist=[[1.0, 0, 0], [-1.0, 0, 0], [1.0, 0, 0]], dt=0.1)
    np.testing.assert_allclose(run.steering, 0.0, atol=ROUNDING)
    assert np.sign(run.wheel_speeds[:, 0]).tolist() == [1.0, -1.0, 1.0]


def test_steering_is_held_while_the_robot_stands() -> None:
    run = simulate(ROBOTS["tricycle"], twist=[[1.0, 0, 1.0], [0.0, 0, 0], [1.0, 0, 1.0]], dt=0.1)
    np.testing.assert_allclose(run.steering, math.atan(0.8), atol=ROUNDING)


def test_steering_is_held_while_a_command_that_cannot_be_gives_standstill() -> None:
    run = simulate(ROBOTS["tricycle"], twist=[[1.0, 0, 1.0], [0.0, 1.0, 0], [1.0, 0, 1.0]], dt=0.1)
    np.testing.assert_allclose(run.steering, math.atan(0.8), atol=ROUNDING)


def test_a_module_that_the_body_turns_about_is_held() -> None:
    robot = ROBOTS["swerve"]
    first = robot.steered[0]
    run = simulate(robot, twist=[[1.0, 1.0, 0], [first.y, -first.x, 1.0], [1.0, 1.0, 0]], dt=0.1)
    np.testing.assert_allclose(run.steering[:, 0], math.pi / 4, atol=ROUNDING)


@each_steered
def test_a_steered_robot_is_driven_by_speeds_and_angles(robot: Robot) -> None:
    twist = feasible_twists(robot, ())
    asked = simulate(robot, twist=twist, duration=1.0, dt=0.5, pose=START)
    run = simulate(
        robot,
        wheel_speeds=asked.wheel_speeds[0],
        steering=asked.steering[0],
        duration=1.0,
        dt=0.5,
        pose=START,
    )
    np.testing.assert_allclose(run.pose, asked.pose, atol=1e-9)
    rows = simulate(
        robot, wheel_speeds=asked.wheel_speeds, steering=asked.steering, dt=0.5, pose=START
    )
    np.testing.assert_allclose(rows.pose, asked.pose, atol=1e-9)


def test_an_infeasible_twist_drives_the_nearest() -> None:
    run = simulate(trundle.load("differential"), twist=[0.3, 0.7, 0.0], duration=1.0)
    np.testing.assert_allclose(run.pose[-1], [0.3, 0.0, 0.0], atol=ROUNDING)


def test_wheel_speed_limits_hold_along_a_run() -> None:
    robot = trundle.load("differential", radius=0.1).with_wheels(max_speed=5.0)
    run = simulate(robot, twist=[2.0, 0.0, 1.0], duration=1.0)
    assert np.abs(run.wheel_speeds).max() == pytest.approx(5.0)
    assert run.twist[0, 0] / run.twist[0, 2] == pytest.approx(2.0)  # the curvature is kept


# ---- what is wrong comes out in words ------------------------------------------------------

CART, TRICYCLE = ROBOTS["differential"], ROBOTS["tricycle"]
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no command": ({"duration": 1.0}, "give either wheel_speeds or twist"),
    "two commands": (
        {"wheel_speeds": [1, 1], "twist": [1, 0, 0], "duration": 1.0},
        "give either wheel_speeds or twist",
    ),
    "method": (
        {"wheel_speeds": [1, 1], "duration": 1.0, "method": "rk2"},
        "method must be one of exact, euler, rk4, got 'rk2'",
    ),
    "method list": ({"wheel_speeds": [1, 1], "duration": 1.0, "method": ["rk4"]}, "method must be"),
    "no duration": ({"wheel_speeds": [1, 1]}, "give a duration"),
    "minus duration": ({"wheel_speeds": [1, 1], "duration": -1.0}, "duration must be a positive"),
    "nan duration": ({"wheel_speeds": [1, 1], "duration": math.nan}, "duration must be a positive"),
    "text duration": ({"wheel_speeds": [1, 1], "duration": "1"}, "duration must be a positive"),
    "zero dt": ({"wheel_speeds": [1, 1], "duration": 1.0, "dt": 0.0}, "dt must be a positive"),
    "inf dt": ({"wheel_speeds": [1, 1], "duration": 1.0, "dt": math.inf}, "dt must be a positive"),
    "too many steps": ({"wheel_speeds": [1, 1], "duration": 1e9, "dt": 1e-9}, "steps"),
    "endless steps": ({"wheel_speeds": [1, 1], "duration": 1e300, "dt": 1e-300}, "steps"),
    "three speeds": (
        {"wheel_speeds": [1, 1, 1], "duration": 1.0, "dt": 0.5},
        r"wheel_speeds must have shape \(2,\) or \(2, 2\), one row per step, got \(3,\)",
    ),
    "rows and duration": (
        {"wheel_speeds": np.ones((3, 2)), "duration": 1.0, "dt": 0.25},
        r"wheel_speeds must have shape \(2,\) or \(4, 2\)",
    ),
    "nan speed": ({"wheel_speeds": [1, math.nan], "duration": 1.0}, "wheel_speeds must be finite"),
    "function of three": (
        {"wheel_speeds": lambda _: [1, 1, 1], "duration": 1.0},
        r"wheel_speeds at t = 0 s must have shape \(2,\), got \(3,\)",
    ),
    "function of one": (
        {"wheel_speeds": lambda _: 1.0, "duration": 1.0},
        r"wheel_speeds at t = 0 s must have shape \(2,\), got \(\)",
    ),
    "function of text": ({"wheel_speeds": lambda _: "ab", "duration": 1.0}, "wheel_speeds must be"),
    "function of nan": (
        {"wheel_speeds": lambda _: [math.nan, 1], "duration": 1.0}, "wheel_speeds must be finite"
    ),
    "twist and steering": (
        {"twist": [1, 0, 0], "steering": [0.1], "duration": 1.0},
        "steering follows from the twist",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("given", "told"), WRONG.values(), ids=WRONG)
def test_wrong_commands_in_words(given: dict[str, Any], told: str) -> None:
    with pytest.raises(TrundleError, match=told):
        simulate(CART, **given)


def test_a_steered_robot_asks_for_its_angles() -> None:
    with pytest.raises(TrundleError, match="'tricycle' steers: give steering, the angles of front"):
        simulate(TRICYCLE, wheel_speeds=[1.0], duration=1.0)
    with pytest.raises(ShapeError, match=r"steering must have shape \(1,\)"):
        simulate(TRICYCLE, wheel_speeds=[1.0], steering=[0.1, 0.2], duration=1.0)
    with pytest.raises(ShapeError, match="steering"):
        simulate(CART, wheel_speeds=[1.0, 1.0], steering=[0.1], duration=1.0)


def test_steering_off_one_centre_is_refused() -> None:
    with pytest.raises(TrundleError, match="share no instantaneous centre"):
        simulate(ROBOTS["ackermann"], wheel_speeds=[1.0, 1.0], steering=[0.3, 0.3], duration=1.0)


# ---- files ---------------------------------------------------------------------------------

AWKWARD = Robot(
    name="awkward",
    wheels=(
        FixedWheel(name='left, "quoted"', x=0.0, y=0.2, radius=0.1),
        FixedWheel(name="wheel_speed:rïght\n", x=0.0, y=-0.2, radius=0.1),
        SteeredWheel(name="steering:fr;ont", x=1.0, y=0.0, radius=0.1, driven=False),
    ),
)


@pytest.mark.parametrize("ending", ["csv", "npz"])
@pytest.mark.parametrize(
    "robot",
    [ROBOTS["differential"], ROBOTS["swerve"], ROBOTS["bicycle"], AWKWARD],
    ids=lambda robot: robot.name,
)
def test_a_run_comes_back_equal(robot: Robot, ending: str, tmp_path: Path) -> None:
    run = simulate(robot, twist=lambda t: [math.cos(t), 0.0, 0.1 + t / 3], duration=0.35, dt=0.1)
    path = run.save(tmp_path / f"run.{ending}")
    back = Run.load(path)
    for field in dataclasses.fields(Run):
        got, wanted = getattr(back, field.name), getattr(run, field.name)
        if isinstance(wanted, np.ndarray):
            assert got.shape == wanted.shape
            assert got.dtype == np.float64
            np.testing.assert_array_equal(got, wanted)
        else:
            assert got == wanted


@pytest.mark.parametrize("ending", ["csv", "npz"])
def test_a_run_without_steps_comes_back_equal(ending: str, tmp_path: Path) -> None:
    run = simulate(CART, wheel_speeds=np.zeros((0, 2)), pose=START)
    back = Run.load(run.save(tmp_path / f"run.{ending}"))
    np.testing.assert_array_equal(back.pose, [START])
    assert back.wheel_speeds.shape == (0, 2)
    assert back.driven == ("left", "right")


def test_the_csv_is_for_people_and_spreadsheets(tmp_path: Path) -> None:
    run = simulate(TRICYCLE, wheel_speeds=[2.0], steering=[0.1], duration=0.2, dt=0.1)
    lines = run.save(tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "t,x,y,psi,wheel_angle:front,u,v,r,wheel_speed:front,steering:front"
    assert len(lines) == 4
    assert lines[1].startswith("0.0,0.0,0.0,0.0,0.0,0.2") or lines[1].startswith("0.0,0.0,0.0,0.0")
    assert lines[3].endswith(",,,,,")


def test_two_runs_can_be_compared() -> None:
    run = simulate(CART, wheel_speeds=[1.0, 1.0], duration=1.0)
    assert isinstance(run == simulate(CART, wheel_speeds=[1.0, 1.0], duration=1.0), bool)


def good_npz(tmp_path: Path) -> bytes:
    run = simulate(CART, wheel_speeds=[1.0, 1.0], duration=1.0)
    return run.save(tmp_path / "good.npz").read_bytes()


BROKEN: dict[str, Callable[[Path], tuple[str, bytes]]] = {
    "empty csv": lambda _: ("run.csv", b""),
    "header only": lambda _: ("run.csv", b"t,x,y,psi\n"),
    "another csv": lambda _: ("run.csv", b"t,x,y\n1,2,3\n"),
    "text in csv": lambda _: ("run.csv", b"t,x,y,psi,u,v,r\n0,0,zero,0,1,0,0\n1,1,1,1,,,\n"),
    "ragged csv": lambda _: ("run.csv", b"t,x,y,psi,u,v,r\n0,0,0,0,1,0,0\n1,1\n"),
    "no utf-8": lambda _: ("run.csv", b"t,x,y,psi\n\xff\xfe,0,0,0\n"),
    "one huge cell": lambda _: ("run.csv", b't,x,y\n"' + b"1" * 200_000 + b'",2,3\n'),
    "empty npz": lambda _: ("run.npz", b""),
    "text as npz": lambda _: ("run.npz", b"t,x,y\n"),
    "cut npz": lambda at: ("run.npz", good_npz(at)[:300]),
    "start of a zip": lambda _: ("run.npz", b"PK\x03\x04 and no more"),
    "damaged npz": lambda at: ("run.npz", good_npz(at)[:200] + b"x" * 60 + good_npz(at)[260:]),
}


@pytest.mark.parametrize("make", BROKEN.values(), ids=BROKEN)
def test_broken_runs_are_told_in_words(
    make: Callable[[Path], tuple[str, bytes]], tmp_path: Path
) -> None:
    name, data = make(tmp_path)
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(
        FileError, match=r"this is not a run that trundle wrote|cannot be read"
    ) as e:
        Run.load(path)
    assert str(path) in str(e.value)


def test_an_array_or_another_archive_is_no_run(tmp_path: Path) -> None:
    with (tmp_path / "array.npz").open("wb") as file:
        np.save(file, np.ones(3))
    np.savez(tmp_path / "other.npz", a=1)
    for name in ("array.npz", "other.npz"):
        with pytest.raises(FileError, match="this is not a run that trundle wrote"):
            Run.load(tmp_path / name)


def test_files_that_cannot_be(tmp_path: Path) -> None:
    run = simulate(CART, wheel_speeds=[1.0, 1.0], duration=0.1)
    with pytest.raises(FileError, match=r"run\.txt: a run is saved as \.csv or \.npz"):
        run.save(tmp_path / "run.txt")
    with pytest.raises(FileError, match=r"run\.txt: a run is read from \.csv or \.npz"):
        Run.load(tmp_path / "run.txt")
    for ending in ("csv", "npz"):
        with pytest.raises(FileError, match="cannot be written"):
            run.save(tmp_path / "no folder" / f"run.{ending}")
        with pytest.raises(FileError, match="cannot be read"):
            Run.load(tmp_path / f"missing.{ending}")
        (tmp_path / f"folder.{ending}").mkdir()
        with pytest.raises(FileError, match="cannot be read"):
            Run.load(tmp_path / f"folder.{ending}")


# ---- casters -------------------------------------------------------------------------------

TRAIL = 0.04


def with_caster(trail: float | None = TRAIL, degrees: float = 0.0) -> Robot:
    caster = CasterWheel(
        name="caster", x=-0.3, y=0.1, radius=0.02, trail=trail, heading=math.radians(degrees)
    )
    robot = trundle.load("omni3")
    return dataclasses.replace(robot, wheels=(*robot.wheels, caster))


@pytest.mark.parametrize("dt", [0.5, 0.1, 0.003])
@pytest.mark.parametrize("degrees", [0.0, 80.0, -170.0])
def test_a_caster_on_a_straight_line_follows_the_closed_form(degrees: float, dt: float) -> None:
    """b g' = V sin(chi - g) has tan((g - chi)/2) = tan((g0 - chi)/2) exp(-V t / b)."""
    u, v = 0.06, 0.08
    run = simulate(with_caster(degrees=degrees), twist=[u, v, 0.0], duration=2.0, dt=dt)
    chi, start = math.atan2(v, u), math.radians(degrees)
    wanted = chi + 2 * np.arctan(np.tan((start - chi) / 2) * np.exp(-0.1 * run.t / TRAIL))
    got = caster_angles(with_caster(degrees=degrees), run)[:, 0]
    np.testing.assert_allclose(np.exp(1j * got), np.exp(1j * wanted), atol=1e-9)


def test_a_caster_obeys_its_own_law_on_any_path() -> None:
    """n . v_p = b (r + g'), integrated apart."""
    robot = with_caster(degrees=40.0)

    def twist(t: Any) -> Floats:
        return np.stack([0.3 + 0.1 * t, 0.2 * np.sin(t), 0.8 * np.cos(t)], axis=-1)

    def slope(t: float, g: Floats) -> list[float]:
        u, v, r = twist(t)
        across = -math.sin(g[0]) * (u - r * 0.1) + math.cos(g[0]) * (v + r * -0.3)
        return [across / TRAIL - r]

    run = simulate(robot, twist=twist, duration=3.0, dt=0.001)
    wanted = integrate.solve_ivp(slope, (0.0, 3.0), [math.radians(40.0)], t_eval=run.t, **REFERENCE)
    got = caster_angles(robot, run)[:, 0]
    # The course is held over each step of a millisecond, in which it turns by about 1e-3.
    np.testing.assert_allclose(np.unwrap(got), wanted.y[0], atol=5e-3)


def test_a_caster_on_a_circle_settles_where_it_no_longer_swivels() -> None:
    """At rest in the body: n . v_p = b r."""
    u, r = 0.2, 0.5
    run = simulate(with_caster(), twist=[u, 0.0, r], duration=20.0, dt=0.001)

    def swivel(g: float) -> float:
        return -math.sin(g) * (u - r * 0.1) + math.cos(g) * r * -0.3 - TRAIL * r

    wanted = optimize.brentq(swivel, -1.5, 0.5)
    got = caster_angles(with_caster(), run)[-1, 0]
    assert math.remainder(got - wanted, 2 * math.pi) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("twist", [(-0.5, 0.0, 0.0), (0.0, -0.5, 0.0), (0.3, 0.3, 0.0)], ids=str)
def test_a_caster_ends_behind_the_motion(twist: tuple[float, float, float]) -> None:
    """Also from straight against it, where it stands on the edge of tipping."""
    run = simulate(with_caster(), twist=twist, duration=3.0)
    got = caster_angles(with_caster(), run)[-1, 0]
    course = math.atan2(twist[1], twist[0])
    assert math.remainder(got - course, 2 * math.pi) == pytest.approx(0.0, abs=1e-3)


def test_a_caster_without_a_trail_follows_at_once_and_rests_at_standstill() -> None:
    robot = with_caster(trail=None)
    run = simulate(robot, twist=[[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], dt=0.1)
    got = caster_angles(robot, run)[:, 0]
    np.testing.assert_allclose(got, [0.0, math.pi / 2, math.pi / 2, 0.0], atol=ROUNDING)


def test_a_standing_caster_keeps_its_angle() -> None:
    robot = with_caster(degrees=30.0)
    run = simulate(robot, twist=[0.0, 0.0, 0.0], duration=1.0)
    np.testing.assert_allclose(caster_angles(robot, run), math.radians(30.0), atol=ROUNDING)
    assert caster_angles(CART, simulate(CART, wheel_speeds=[1, 1], duration=0.1)).shape == (11, 1)
    assert caster_angles(ROBOTS["omni3"], run).shape == (len(run.t), 0)
