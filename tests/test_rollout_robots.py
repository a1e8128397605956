"""Robots that steer, that differ in their numbers, and that controllers keep on a trajectory.

Robots that differ are built one by one with ``dataclasses.replace`` and driven alone by
``simulate``, or by ``track``, whose equations are proven elsewhere.
"""

import dataclasses
import importlib.util
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import trundle
from catalogue import CURVED, ROBOTS
from geometry import Floats
from masses import each_unsteered
from trundle import Constant, Motor, Robot, Stream, Tracking, load, motion, rollout, simulate, track
from trundle.control import PD, ComputedTorque
from trundle.errors import StabilityWarning
from trundle.robot import MecanumWheel

needs_numba = pytest.mark.skipif(
    importlib.util.find_spec("numba") is None, reason="numba is not installed"
)

# Some dozens of steps of numbers near 1, each rounded at 1e-16, in another order of operations.
ROUNDING = 1e-13
# The same closed loop in another order of operations: a few hundred steps.
SAME_LOOP = 1e-10
# Floats have seven digits, of which a closed loop near rest keeps all but one or two.
FLOATS = 2e-5

DT, STEPS, COUNT = 0.1, 12, 3


def starts(count: int = COUNT) -> Floats:
    return np.random.default_rng(3).normal(size=(count, 3))


# ---- robots that differ ----------------------------------------------------------------------


def placed(robot: Robot, x: float = 1.0, y: float = 1.0) -> Robot:
    """Return the robot with its wheels' coordinates scaled."""
    wheels = tuple(
        dataclasses.replace(wheel, x=x * wheel.x, y=y * wheel.y) for wheel in robot.wheels
    )
    return dataclasses.replace(robot, wheels=wheels)


def with_wheels(robot: Robot, name: str, **new: float) -> Robot:
    """Return the robot with numbers of one wheel, or with "" of every wheel that has them."""
    wheels = tuple(
        dataclasses.replace(wheel, **new)
        if name in ("", wheel.name) and all(hasattr(wheel, field) for field in new)
        else wheel
        for wheel in robot.wheels
    )
    return dataclasses.replace(robot, wheels=wheels)


def extent(robot: Robot, axis: str) -> float:
    return float(np.ptp([getattr(wheel, axis) for wheel in robot.wheels]))


def outermost(robot: Robot) -> float:
    return max(float(np.hypot(wheel.x, wheel.y)) for wheel in robot.wheels)


Build = Callable[[Robot, float], Robot]
BUILD: dict[str, Build] = {
    "radius": lambda robot, value: with_wheels(robot, "", radius=value),
    "arm": lambda robot, value: placed(robot, value / outermost(robot), value / outermost(robot)),
    "track": lambda robot, value: placed(robot, y=value / extent(robot, "y")),
    "wheelbase": lambda robot, value: placed(robot, x=value / extent(robot, "x")),
    "track_factor": lambda robot, value: with_wheels(robot, "", track_factor=value),
}
DIFFERING: list[tuple[str, dict[str, list[float]]]] = [
    ("mecanum", {"radius": [0.04, 0.05, 0.06]}),
    ("mecanum", {"radius": [0.04, 0.05, 0.06], "track": [0.3, 0.35, 0.4]}),
    ("mecanum", {"wheelbase": [0.3, 0.45, 0.5], "track": [0.3, 0.35, 0.4]}),
    ("mecanum", {"arm": [0.3, 0.35, 0.4]}),
    ("differential", {"track": [0.3, 0.35, 0.4]}),
    ("omni3", {"radius": [0.04, 0.05, 0.06]}),
    ("omni3", {"arm": [0.2, 0.25, 0.3], "radius": [0.04, 0.05, 0.06]}),
    ("skid_steer", {"track_factor": [1.2, 1.5, 1.9], "track": [0.3, 0.35, 0.4]}),
]


def each_alone(robot: Robot, given: dict[str, list[float]], **commands: Any) -> Floats:
    """Return the trajectories (T + 1, N, 3) of robots built and driven one by one."""
    runs = []
    for i, pose in enumerate(starts()):
        built = robot
        for name, values in given.items():
            wheel, _, field = name.rpartition(".")
            if wheel:
                built = with_wheels(built, wheel, **{field: values[i]})
            else:
                built = BUILD[name](built, values[i])
        own = {name: value[:, i] for name, value in commands.items()}
        runs.append(simulate(built, dt=DT, pose=pose, **own).pose)
    return np.stack(runs, axis=1)


def some_speeds(robot: Robot) -> Floats:
    speeds = np.random.default_rng(8).normal(size=(STEPS, COUNT, len(robot.driven)))
    return np.asarray(4.0 * speeds)


@pytest.mark.parametrize(
    ("name", "given"), DIFFERING, ids=lambda v: v if isinstance(v, str) else "+".join(v)
)
def test_robots_that_differ_are_those_built_one_by_one(name, given):
    robot = load(name)
    speeds = some_speeds(robot)
    got = rollout(
        robot, Stream(speeds), dt=DT, pose=starts(), parameters=given, save="trajectory",
        device="numpy",
    )  # fmt: skip
    wanted = each_alone(robot, given, wheel_speeds=speeds)
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)
    twists = np.random.default_rng(9).normal(size=(STEPS, COUNT, 3)) * (0.3, 0.0, 0.5)
    got = rollout(
        robot, Stream(twist=twists), dt=DT, pose=starts(), parameters=given, device="numpy"
    )
    wanted = each_alone(robot, given, twist=twists)
    np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


def test_one_wheel_may_differ_alone():
    robot = load("mecanum")
    wheel = next(w for w in robot.wheels if isinstance(w, MecanumWheel))
    given = {f"{wheel.name}.{k}": v for k, v in {
        "radius": [0.04, 0.05, 0.06], "roller": [0.7, 0.8, 0.9], "x": [0.2, 0.25, 0.3],
        "heading": [0.0, 0.02, -0.03],
    }.items()}  # fmt: skip
    speeds = some_speeds(robot)
    wanted = each_alone(robot, given, wheel_speeds=speeds)
    got = rollout(robot, Stream(speeds), dt=DT, pose=starts(), parameters=given, device="numpy")
    np.testing.assert_allclose(got.pose, wanted[-1], rtol=0, atol=ROUNDING)


def test_one_command_for_robots_that_differ():
    """Also where all else is shared, and where constant commands are taken to chords."""
    robot, given = load("differential"), {"radius": [0.04, 0.05, 0.06]}
    for steps in (STEPS, 80):
        speeds = np.tile([3.0, 4.0], (steps, COUNT, 1))
        wanted = each_alone(robot, given, wheel_speeds=speeds)[-1]
        got = rollout(
            robot, Constant([3.0, 4.0]), dt=DT, steps=steps, pose=starts(), parameters=given,
            device="numpy",
        )  # fmt: skip
        np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("name", ["ackermann", "tricycle"])
def test_robots_that_steer_may_differ(name):
    """Angles share a centre for the described robot, so that only radii and one size may differ."""
    robot, rng = load(name), np.random.default_rng(2)
    wheelbase = extent(robot, "x")
    given = {"radius": [0.9 * robot.driven[0].radius, 0.3, 0.2]}
    if name == "tricycle":  # any angle of its one wheel has a centre
        given["wheelbase"] = [0.9 * wheelbase, wheelbase, 1.1 * wheelbase]
    kinematics = trundle.Kinematics(robot)
    turns = rng.uniform(-0.5, 0.5, (STEPS, COUNT))
    found = [[kinematics.inverse([1.0, 0.0, turn]) for turn in row] for row in turns]
    angles = np.array([[one.steering for one in row] for row in found])
    speeds = np.array([[one.wheel_speeds for one in row] for row in found])
    got = rollout(
        robot, Stream(speeds, steering=angles), dt=DT, pose=starts(), parameters=given,
        device="numpy",
    )  # fmt: skip
    wanted = each_alone(robot, given, wheel_speeds=speeds, steering=angles)[-1]
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=ROUNDING)


@needs_numba
def test_robots_that_steer_compiled():
    robot, rng = load("ackermann"), np.random.default_rng(2)
    kinematics = trundle.Kinematics(robot)
    found = [[kinematics.inverse([1.0, 0.0, r]) for r in row] for row in rng.normal(size=(5, 3))]
    angles = np.array([[one.steering for one in row] for row in found])
    speeds = np.array([[one.wheel_speeds for one in row] for row in found])
    got = rollout(
        robot, Stream(speeds, steering=angles), dt=DT, pose=starts(), dtype="float32", device="cpu"
    )
    wanted = each_alone(robot, {}, wheel_speeds=speeds, steering=angles)[-1]
    np.testing.assert_allclose(got.pose, wanted, rtol=0, atol=FLOATS)


def test_a_curved_space_of_motions_takes_speeds_and_angles():
    angle = np.linspace(-0.6, 0.6, STEPS)
    angles = np.stack([angle, -0.5 * angle], axis=-1)
    speeds = np.ones((STEPS, 2))
    got = rollout(CURVED, Stream(speeds, steering=angles), dt=DT, device="numpy")
    wanted = simulate(CURVED, wheel_speeds=speeds, steering=angles, dt=DT).pose[-1]
    np.testing.assert_allclose(got.pose, wanted[None], rtol=0, atol=ROUNDING)
    assert ROBOTS["curved"] is CURVED


# ---- tracking --------------------------------------------------------------------------------

CIRCLE = motion.circle(radius=2.0, rate=0.4)
LAWS = {
    "PD": PD(kp=[9.0, 8.0, 2.0], kd=[9.0, 7.0, 2.0]),
    "ComputedTorque": ComputedTorque(kp=[4.0, 3.0, 5.0], kd=[4.0, 3.0, 4.0]),
}
each_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
SHORT, LONG = 0.01, 200
POSE, RATE = np.array([2.2, -0.3, 1.4]), np.array([0.1, 0.5, 0.2])


def plain() -> Robot:
    return load("omni3").with_body(mass=12.0, inertia=0.6, com=(0.0, 0.0))


def hindered() -> Robot:
    """Return a robot with its mass off centre, friction, and motors that are too weak."""
    robot = load("mecanum").with_body(mass=20.0, inertia=1.1, com=(0.07, -0.04))
    return robot.with_wheels(
        mass=0.4, viscous_friction=0.02, coulomb_friction=0.01, spin_inertia=0.002, max_torque=0.3
    )


def tracked(robot: Robot, law: Any, trajectory: Any = CIRCLE, **given: Any) -> Floats:
    """Return the trajectory (T + 1, 3) of a robot by ``track``."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StabilityWarning)  # gains are not the matter here
        return track(
            robot, trajectory, law, duration=SHORT * LONG, dt=SHORT, method="semi-implicit",
            **given,
        ).pose  # fmt: skip


def together(robot: Robot, law: Any, trajectory: Any = CIRCLE, **given: Any) -> Floats:
    rate = given.pop("rate", None)
    given = {"dt": SHORT, "steps": LONG, "save": "trajectory", "device": "numpy"} | given
    return rollout(robot, Tracking(trajectory, law, rate=rate), **given).pose


@each_law
@pytest.mark.parametrize("robot", [plain(), hindered()], ids=["plain", "hindered"])
def test_tracking_is_track(robot, law):
    wanted = tracked(robot, law, pose=POSE, rate=RATE)
    got = together(robot, law, pose=POSE, rate=RATE)
    np.testing.assert_allclose(got[:, 0], wanted, rtol=0, atol=SAME_LOOP)
    on_it = together(robot, law)
    np.testing.assert_allclose(on_it[:, 0], tracked(robot, law), rtol=0, atol=SAME_LOOP)


@each_unsteered
def test_tracking_is_track_for_every_robot(robot):
    law = LAWS["ComputedTorque"]
    try:
        wanted = tracked(robot, law, pose=POSE)
    except trundle.TrundleError:
        with pytest.raises(trundle.TrundleError):
            together(robot, law, pose=POSE)
        return
    np.testing.assert_allclose(together(robot, law, pose=POSE)[:, 0], wanted, atol=SAME_LOOP)


def test_limits_bind_in_these_loops():
    strong = hindered().with_wheels(max_torque=None)
    apart = tracked(strong, LAWS["PD"], pose=POSE) - tracked(hindered(), LAWS["PD"], pose=POSE)
    assert np.abs(apart).max() > 1e-3


def test_motors_bound_the_torque_by_their_speed():
    motor = Motor(torque_constant=0.02, resistance=1.5, max_voltage=12.0, gear=4.0)
    robot = hindered().with_wheels(motor=motor, max_torque=None)
    wanted = tracked(robot, LAWS["PD"], pose=POSE)
    np.testing.assert_allclose(
        together(robot, LAWS["PD"], pose=POSE)[:, 0], wanted, rtol=0, atol=SAME_LOOP
    )


@needs_numba
def test_tracking_compiled():
    law, robot = LAWS["ComputedTorque"], hindered()
    poses = POSE + 0.3 * starts()
    rates = RATE + 0.1 * starts()
    got = together(robot, law, pose=poses, rate=rates, dtype="float32", device="cpu")
    wanted = [tracked(robot, law, pose=p, rate=r) for p, r in zip(poses, rates, strict=True)]
    np.testing.assert_allclose(got, np.stack(wanted, axis=1), rtol=0, atol=FLOATS)


@each_law
def test_each_robot_has_its_own_controller_and_start(law):
    laws = [dataclasses.replace(law, kp=tuple(k * np.array(law.kp))) for k in (0.5, 1.0, 2.0)]
    poses = POSE + 0.3 * starts()
    got = together(hindered(), laws, pose=poses)
    wanted = [tracked(hindered(), own, pose=p) for own, p in zip(laws, poses, strict=True)]
    np.testing.assert_allclose(got, np.stack(wanted, axis=1), rtol=0, atol=SAME_LOOP)


@each_law
def test_given_numbers_in_place_of_a_trajectory(law):
    course = motion.sample(CIRCLE, np.arange(LONG) * SHORT)
    numbers = np.concatenate(course, axis=-1)
    wanted = tracked(plain(), law, pose=POSE)
    each = np.repeat(numbers[:, None], COUNT, axis=1)
    for given in (numbers, each):
        got = together(plain(), law, given, pose=POSE)
        np.testing.assert_allclose(got[:, -1], wanted, rtol=0, atol=SAME_LOOP)


@each_law
def test_plain_headings_are_not_wrapped(law):
    lecture = motion.circle(radius=2.0, rate=0.4, heading="lecture")
    far = POSE + np.array([0.0, 0.0, 2 * np.pi])
    for trajectory in (lecture, CIRCLE):
        wanted = tracked(plain(), law, trajectory, pose=far)
        got = together(plain(), law, trajectory, pose=far)
        np.testing.assert_allclose(got[:, 0], wanted, rtol=0, atol=SAME_LOOP)


VARYING: dict[str, tuple[Any, Callable[[Robot, Any], Robot]]] = {
    "mass": ([15.0, 20.0, 30.0], lambda robot, m: robot.with_body(mass=m)),
    "inertia": ([0.8, 1.1, 2.0], lambda robot, inertia: robot.with_body(inertia=inertia)),
    "com": (
        [[0.0, 0.1], [0.05, 0.0], [-0.1, 0.03]],
        lambda robot, c: robot.with_body(com=tuple(c)),
    ),
    "radius": ([0.04, 0.05, 0.06], lambda robot, radius: robot.with_wheels(radius=radius)),
    "coulomb_friction": ([0.0, 0.01, 0.02], lambda robot, t: robot.with_wheels(coulomb_friction=t)),
    "track": ([0.3, 0.35, 0.4], BUILD["track"]),
}


@each_law
@pytest.mark.parametrize("name", VARYING)
def test_robots_with_masses_that_differ(law, name):
    """A controller with a model believes in the robot as described, whatever the robots are."""
    values, build = VARYING[name]
    robot = hindered()
    if isinstance(law, ComputedTorque):
        law = law.with_model(trundle.Dynamics(robot))
    got = together(robot, law, pose=POSE, parameters={name: values})
    wanted = [tracked(build(robot, value), law, pose=POSE) for value in values]
    np.testing.assert_allclose(got, np.stack(wanted, axis=1), rtol=0, atol=SAME_LOOP)
    assert np.abs(got[:, 0] - got[:, 2]).max() > 1e-6
