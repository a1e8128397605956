"""trundle's side of ``batches.py``: each is what a user of ``compile_rollout`` writes."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from _batch_tasks import (
    CIRCLES,
    DT,
    EFFORT,
    FOLLOW_GAIN,
    GOAL,
    MARGIN,
    MPPI_DT,
    MPPI_SIGMA,
    PATH_RADIUS,
    PATH_RATE,
    PENALTY,
    SIGMA,
    TEMPERATURE,
    TRACKING_DT,
    Numbers,
    Sizes,
    constant_speeds,
    few,
    first_plan,
    mecanum,
    spread,
    starts,
    streamed_speeds,
    tracked,
)
from _common import Job
from _peers_numpy import mean_plan, wheel_matrix

import trundle
from trundle import Constant, Policy, Stream, compile_rollout
from trundle.simulation import Measurement, Reference


def streamed(size: Sizes, dtype: str, stored: bool = False) -> Job:
    speeds = Stream.wheels_first(streamed_speeds(size, dtype))
    save = "trajectory" if stored else "final"
    return timed(size, compile_rollout(mecanum(), speeds, dt=DT, save=save, dtype=dtype))


def constant(size: Sizes, dtype: str) -> Job:
    speeds = Constant(constant_speeds(size).T)
    given = {"dt": DT, "steps": size.steps, "save": "trajectory", "dtype": dtype}
    return timed(size, compile_rollout(mecanum(), speeds, **given))


def noisy(size: Sizes, dtype: str) -> Job:
    speeds = Constant(constant_speeds(size).T).with_noise(SIGMA, seed=0)
    run = compile_rollout(mecanum(), speeds, dt=DT, steps=size.steps, dtype=dtype)
    job = timed(size, run)
    return Job(job.statement, job.names, spread(*run().final.T), job.count)


def computed_torque(size: Sizes, dtype: str) -> Job:
    robot, circle, controller = tracked()
    commands = trundle.Tracking(circle, controller, rate=[0.0, 0.0, 0.0])
    given = {"dt": TRACKING_DT, "steps": size.steps, "dtype": dtype}
    return timed(size, compile_rollout(robot, commands, pose=starts(size).T, **given))


def timed(size: Sizes, run: Any) -> Job:
    """Return a prepared call that writes into memory that is there."""
    out = run().buffer
    names = {"run": run, "out": out}
    return Job("run(out=out)", names, few(size, *run(out=out).final.T), size.steps * size.robots)


def cost(t: float, pose: Any, command: Any, parameters: Any) -> Any:  # noqa: ARG001
    """Return ``stage_cost``, as a user writes it for trundle."""
    x, y, _ = pose
    u, v, r = command
    goal_x, goal_y, _, _, _, _, a, b, c, d, e, f, g, h, i = parameters
    first = np.sqrt((x - a) * (x - a) + (y - b) * (y - b)) - c
    second = np.sqrt((x - d) * (x - d) + (y - e) * (y - e)) - f
    third = np.sqrt((x - g) * (x - g) + (y - h) * (y - h)) - i
    near = np.maximum(MARGIN - first, 0.0) + np.maximum(MARGIN - second, 0.0)
    near = near + np.maximum(MARGIN - third, 0.0)
    distance = (x - goal_x) * (x - goal_x) + (y - goal_y) * (y - goal_y)
    return distance + EFFORT * (u * u + v * v + r * r) + PENALTY * near


def mppi(size: Sizes) -> Job:
    """Return a tick with the peers' cost, plan and noise of every step."""
    controller = trundle.control.MPPI(
        mecanum(), cost, samples=size.samples, horizon=size.horizon, dt=MPPI_DT, hold=1,
        temperature=TEMPERATURE, sigma=[MPPI_SIGMA] * 3, parameters=np.ravel(CIRCLES),
    )  # fmt: skip

    here = Measurement(0.0, np.zeros(3), np.zeros(3))
    goal = Reference(np.array([*GOAL, 0.0]), np.zeros(3), np.zeros(3))
    _, first = controller.step(None, here, goal)
    plan = first._replace(twists=first_plan(size).astype(np.float64))
    number = itertools.count()

    def tick() -> Numbers:
        _, better = controller.step(plan._replace(tick=next(number)), here, goal)
        return better.twists

    return Job("tick()", {"tick": tick}, mean_plan(size, tick))


# ---- one robot -------------------------------------------------------------------------------

FORWARD, TURNING = (4.0, 4.0, 4.0, 4.0), (3.0, 5.0, 3.0, 5.0)  # wheel speeds, by turns [rad/s]


def prepared_call() -> Job:
    """Return two steps of a control loop, each with other wheel speeds and the last pose."""
    run = compile_rollout(mecanum(), Stream(np.zeros((1, 1, 4))), dt=DT)
    a, b = np.array([[FORWARD]]), np.array([[TURNING]])
    names = {"run": run, "a": a, "b": b, "pose": np.zeros((1, 3))}
    after = run(b, pose=run(a).pose).pose
    statement = "pose = run(a, pose=pose).pose; pose = run(b, pose=pose).pose"
    return Job(statement, names, after[0], count=2)


def plain_call() -> Job:
    """Return the same with trundle's function of plain floats."""
    step = trundle.Kinematics(mecanum()).bind().step
    a, b = (tuple(DT * speed for speed in each) for each in (FORWARD, TURNING))
    names = {"step": step, "a": a, "b": b, "x": 0.0, "y": 0.0, "psi": 0.0}
    statement = "x, y, psi = step(x, y, psi, *a); x, y, psi = step(x, y, psi, *b)"
    return Job(statement, names, step(*step(0.0, 0.0, 0.0, *a), *b), count=2)


def follow(t: float, pose: Any, parameters: Any) -> Any:
    """Return the wheel speeds that take a robot to a point that goes round a circle."""
    radius, w, gain = parameters[0], parameters[1], parameters[2]
    s, c = math.sin(w * t), math.cos(w * t)
    x_dot = radius * w * c + gain * (radius * s - pose[0])
    y_dot = radius * w * s + gain * (radius - radius * c - pose[1])
    r = -gain * pose[2]
    s, c = math.sin(pose[2]), math.cos(pose[2])
    u, v = c * x_dot + s * y_dot, c * y_dot - s * x_dot
    k = parameters[3:]
    return (
        k[0] * u + k[1] * v + k[2] * r,
        k[3] * u + k[4] * v + k[5] * r,
        k[6] * u + k[7] * v + k[8] * r,
        k[9] * u + k[10] * v + k[11] * r,
    )


def feedback(size: Sizes) -> Job:
    inverse = np.linalg.pinv(wheel_matrix())
    policy = Policy(follow, parameters=[PATH_RADIUS, PATH_RATE, FOLLOW_GAIN, *inverse.ravel()])

    def prepared(steps: int) -> Any:
        return compile_rollout(mecanum(), policy, dt=TRACKING_DT, steps=steps, method="euler")

    answer = prepared(size.loop_steps)().final[0]
    run = prepared(size.feedback_steps)
    return Job("run()", {"run": run}, answer, size.feedback_steps)


def error(size: Sizes) -> float:
    """Return how far float32 ends from float64 at most, in parts of the distance driven."""
    long = Sizes(**vars(size) | {"robots": size.error_robots, "steps": size.error_steps})
    speeds = streamed_speeds(long, "float32")
    final = {}
    for dtype in ("float32", "float64"):
        stream = Stream.wheels_first(speeds.astype(dtype, copy=False))
        final[dtype] = compile_rollout(mecanum(), stream, dt=DT, dtype=dtype)().final
    twists = np.einsum("ij,tjn->tin", wheel_matrix()[:2].astype(np.float32), speeds)
    driven = DT * np.hypot(twists[:, 0], twists[:, 1]).sum(axis=0, dtype=np.float64)
    off = final["float32"][:, :2] - final["float64"][:, :2]
    return float((np.hypot(*off.T) / driven).max())
