"""``track``: a robot, a trajectory and a controller in closed loop."""

from __future__ import annotations

import warnings
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.dynamics import to_body
from trundle.errors import StabilityWarning, TrundleError
from trundle.kinematics import finite, robot_of
from trundle.motion import AnyTrajectory, Course, length, sample
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.run import Run
from trundle.simulation.times import step_times
from trundle.simulation.tracking.adaptive import run_adaptive
from trundle.simulation.tracking.compiled import run_loop
from trundle.simulation.tracking.kinematic import track_twist
from trundle.simulation.tracking.loops import COLUMNS, LOOPS
from trundle.simulation.tracking.plant import Plant, check_pushable, plant_of
from trundle.simulation.tracking.recorded import Motion, motion_run, new_block
from trundle.simulation.tracking.sampled import run_sampled
from trundle.simulation.tracking.signals import Controller, ModelController, ScalarController
from trundle.simulation.tracking.stability import instability

TRACK_METHODS = (*LOOPS, "adaptive")
OUTPUTS = ("force", "torques", "twist")


def track(
    robot: Robot,
    trajectory: AnyTrajectory,
    controller: Controller,
    *,
    duration: float | None = None,
    dt: float = 0.01,
    method: str = "semi-implicit",
    pose: npt.ArrayLike | None = None,
    rate: npt.ArrayLike | None = None,
) -> Run:
    """Return the run of a robot that a controller keeps on a trajectory.

    The body moves by ``M q_ddot + n = F``, with the wheels' inertia, friction and torque limits.
    PD and computed torque are evaluated wherever the method asks; other controllers are called
    once a step, and their command is held over it. Controllers that command twists drive the
    kinematics: the wheels turn as told, within their speed and steering limits, and each step is
    an exact arc whatever the method.

    Args:
        robot: the robot; for forces and torques its body needs mass, inertia and com.
        trajectory: any value with position(t), velocity(t) and acceleration(t) -> (3,) or (T, 3)
            in the inertial frame; where ``plain_heading`` is true, heading errors are plain
            differences.
        controller: such as ``trundle.control.PD(kp, kd)``.
        duration: length of the run [s]; without it the trajectory's own ``duration``.
        dt: step [s].
        method: "semi-implicit" (Euler) and "lecture" (constant acceleration over the step), both of
            first order in dt; "rk4", of fourth; "adaptive", scipy's DOP853, to ten digits.
        pose: (3,) start [m, m, rad]; on the trajectory when left out.
        rate: (3,) start rates [m/s, m/s, rad/s]; the trajectory's when left out.

    Returns:
        The run, with ``error`` (desired minus actual), ``torques``, ``energy`` and ``reports``.

    Raises:
        TrundleError: something does not fit together; the message says what.

    Warns:
        StabilityWarning: the step is too long for the gains of PD or computed torque, or they are
            unstable. Other controllers and "adaptive" are not looked at.

    >>> import trundle
    >>> from trundle.control import ComputedTorque
    >>> robot, circle = trundle.load("omni3"), trundle.motion.circle(radius=3.0, rate=0.1)
    >>> run = track(robot, circle, ComputedTorque(kp=[4, 4, 4], kd=[4, 4, 4]), duration=5.0)
    >>> bool(np.abs(run.error).max() < 1e-6)
    True
    """
    task = _task(robot, trajectory, controller, duration, dt, method, pose, rate)
    if task.output == "twist":
        return track_twist(robot, controller, task.course, task.t, task.plain, task.start)
    if robot.steered:
        raise TrundleError(
            f"robot {robot.name!r} steers: drive it by a controller that commands twists, such as "
            "trundle.control.Kanayama"
        )
    plant = plant_of(robot)
    if isinstance(controller, ModelController):
        controller = controller.with_model(plant.dynamics)
    if task.output == "force":
        check_pushable(robot, plant)
    motion = _dynamic(controller, plant, trajectory, task, method)
    stride = (len(task.course.position) - 1) // (len(task.t) - 1)
    return motion_run(plant, motion, task.t, task.course.position[::stride])


class _Task(NamedTuple):
    """What is asked, checked."""

    t: Array  # (T + 1,)
    course: Course  # what is desired at these times, for "rk4" at the half steps between too
    start: Array  # (6,) pose and rate
    plain: bool
    output: str


def _task(
    robot: Robot,
    trajectory: AnyTrajectory,
    controller: Controller,
    duration: float | None,
    dt: float,
    method: str,
    pose: npt.ArrayLike | None,
    rate: npt.ArrayLike | None,
) -> _Task:
    robot_of(robot)
    if not isinstance(method, str) or method not in TRACK_METHODS:
        raise TrundleError(f"method must be one of {', '.join(TRACK_METHODS)}, got {method!r}")
    output = getattr(controller, "output", None)
    if isinstance(controller, type):
        raise TrundleError(f"give a controller, such as {controller.__name__}(...), not its class")
    if output not in OUTPUTS or not callable(getattr(controller, "step", None)):
        raise TrundleError(
            f"a controller has step(state, measurement, reference) -> command, state, and an "
            f"output that is one of {', '.join(OUTPUTS)}; got {controller!r}"
        )
    t = step_times(length(trajectory, duration), dt)
    times = t
    if method == "rk4" and output != "twist":
        times = np.empty(2 * len(t) - 1)
        times[::2], times[1::2] = t, (t[:-1] + t[1:]) / 2
    course = sample(trajectory, times)
    start = np.concatenate(
        [_three(pose, "pose", course.position[0]), _three(rate, "rate", course.velocity[0])]
    )
    return _Task(t, course, start, bool(getattr(trajectory, "plain_heading", False)), output)


def _three(given: npt.ArrayLike | None, name: str, default: Array) -> Array:
    if given is None:
        return default
    values = finite(given, name)
    if values.shape != (3,):
        raise TrundleError(f"{name} must be three numbers, got shape {values.shape}")
    return values


def _dynamic(
    controller: Controller, plant: Plant, trajectory: AnyTrajectory, task: _Task, method: str
) -> Motion:
    x, y, psi, x_dot, y_dot, r = task.start
    u, v = to_body(np.cos(psi), np.sin(psi), x_dot, y_dot)
    start = np.array([x, y, psi, *(plant.here.allowed @ [u, v, r])])
    if not isinstance(controller, ScalarController):
        return run_sampled(controller, plant, task.course, task.t, task.plain, start, method)
    law = controller.scalar_law
    constants = plant.constants(tuple(controller.scalar_constants.tolist()), task.plain)
    block = new_block(len(plant.G), len(task.t))
    notes = block[:COLUMNS]
    if method == "adaptive":
        at = partial(_course_at, trajectory)
        steps = run_adaptive(law, at, constants, task.t, start, notes)
        return Motion(steps, block, continuous=True)
    if told := instability(method, law, constants, float(task.t[1] - task.t[0])):
        warnings.warn(told, StabilityWarning, stacklevel=3)
    steps = run_loop(method, law, task.course, constants, np.diff(task.t), start, notes)
    return Motion(steps, block, continuous=method == "rk4", straight=method == "lecture")


def _course_at(trajectory: AnyTrajectory, time: float) -> Course:
    return sample(trajectory, [time])
