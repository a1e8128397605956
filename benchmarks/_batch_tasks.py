"""What every candidate of ``batches.py`` is given: the robot, its commands, sizes and formulas.

The formulas are those that the peers read, in numpy and in jax alike; trundle has its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import trundle
from trundle.control import ComputedTorque

Numbers = npt.NDArray[Any]


@dataclass(frozen=True)
class Sizes:
    """How much there is to do: robots, steps, and what fewer robots and steps slow loops take."""

    robots: int
    steps: int
    few_robots: int
    samples: int  # of a tick
    horizon: int  # steps of a sample
    ticks: int  # that a tick's answer is the mean of
    feedback_steps: int
    loop_steps: int
    error_robots: int
    error_steps: int


FULL = Sizes(100_000, 100, 20, 2000, 56, 200, 1_000_000, 2000, 10_000, 1000)
SMOKE = Sizes(3000, 20, 5, 400, 20, 200, 1000, 200, 500, 100)

# ---- streamed and constant wheel commands ----------------------------------------------------

DT = 0.02  # [s]
RADIUS, WHEELBASE, TRACK = 0.05, 0.4, 0.3  # [m], as of trundle.load("mecanum")
SIGMA = 0.5  # of the commands' noise [rad/s]


def mecanum() -> trundle.Robot:
    return trundle.load("mecanum", radius=RADIUS, wheelbase=WHEELBASE, track=TRACK)


def increments() -> Numbers:
    """Return the matrix (3, 4) from wheel speeds to a step's dx, dy and half of its dpsi.

    It is written by hand: wheels front left, front right, rear left, rear right.
    """
    arm = (WHEELBASE + TRACK) / 2
    W = (
        RADIUS
        / 4
        * np.array([[1, 1, 1, 1], [-1, 1, 1, -1], [-1 / arm, 1 / arm, -1 / arm, 1 / arm]])
    )
    return DT * W * np.array([[1.0], [1.0], [0.5]])


def constant_speeds(size: Sizes) -> Numbers:
    """Return each robot's wheel speeds (4, N) [rad/s], in single precision."""
    rng = np.random.default_rng(1)
    return rng.uniform(-5.0, 5.0, (4, size.robots)).astype(np.float32)


def streamed_speeds(size: Sizes, dtype: str) -> Numbers:
    """Return wheel speeds (T, 4, N) that change around a mean of each robot and wheel.

    They are single numbers, widened where doubles are asked for: all are given the same.
    """
    rng = np.random.default_rng(2)
    speeds = rng.random((size.steps, 4, size.robots), dtype=np.float32)
    speeds *= np.float32(2.0)
    speeds += constant_speeds(size)
    return speeds.astype(dtype, copy=False)


def exact_step(xp: Any, x: Any, y: Any, psi: Any, dx: Any, dy: Any, half: Any) -> Any:
    """Return the pose after the exact arc of a twist held over a step.

    sin(h) / h is three terms of its series: at a few degrees a step that is exact to rounding, and
    quicker than any function of the libraries.
    """
    z = half * half
    chord = 1 - z * (1 / 6 - z * (1 / 120))
    middle = psi + half
    c, s = xp.cos(middle) * chord, xp.sin(middle) * chord
    return x + (c * dx - s * dy), y + (s * dx + c * dy), psi + 2 * half


# ---- computed torque on the planar dynamics --------------------------------------------------

TRACKING_DT = 0.01  # [s]
MASS, INERTIA, COM = 10.0, 0.5, 0.05  # [kg], about the centre of mass [kg m^2], its x [m]
BELIEVED = 1.05 * MASS  # the controller's mass
PATH_RADIUS, PATH_RATE = 3.0, 0.1  # [m], [rad/s]
KP = KD = 4.0  # [1/s^2], [1/s]


def tracked() -> tuple[trundle.Robot, Any, ComputedTorque]:
    """Return robot, trajectory and controller, as trundle has them."""
    robot = mecanum().with_body(mass=MASS, inertia=INERTIA, com=(COM, 0.0))
    believed = trundle.Dynamics(robot.with_body(mass=BELIEVED))
    circle = trundle.motion.circle(PATH_RADIUS, PATH_RATE, heading=0.0)
    return robot, circle, ComputedTorque([KP] * 3, [KD] * 3, model=believed)


def starts(size: Sizes) -> Numbers:
    """Return where the tracking robots start, at rest: (3, N) poses, in single precision."""
    rng = np.random.default_rng(3)
    return rng.uniform(-0.5, 0.5, (3, size.robots)).astype(np.float32)


def circle_table(steps: int) -> Numbers:
    """Return position, velocity and acceleration (T, 6) on the circle, x and y by turns."""
    r, w = PATH_RADIUS, PATH_RATE
    angle = w * TRACKING_DT * np.arange(steps)
    s, c = np.sin(angle), np.cos(angle)
    return np.stack([r * s, r - r * c, r * w * c, r * w * s, -r * w**2 * s, r * w**2 * c], axis=-1)


def tracking_step(xp: Any, state: Any, desired: Any) -> Any:
    """Return (x, y, psi, u, v, r) after a step: computed torque, then the new twist's exact arc.

    The body's M = [[m, 0, 0], [0, m, m x], [0, m x, I + m x^2]] is inverted by hand.
    """
    x, y, psi, u, v, r = state
    X, Y, X_d, Y_d, X_dd, Y_dd = desired
    m, mx, I = MASS, MASS * COM, INERTIA + MASS * COM**2
    m_, mx_, I_ = BELIEVED, BELIEVED * COM, INERTIA + BELIEVED * COM**2
    c, s = xp.cos(psi), xp.sin(psi)
    a_x = X_dd + KD * (X_d - (c * u - s * v)) + KP * (X - x)
    a_y = Y_dd + KD * (Y_d - (s * u + c * v)) + KP * (Y - y)
    a_r = -KD * r - KP * psi
    rv, ru, rr = r * v, r * u, r * r
    a_u, a_v = c * a_x + s * a_y + rv, c * a_y - s * a_x - ru
    # The force that the controller's model needs, less what the body's own turning takes.
    f_u = m_ * (a_u - rv) - mx_ * rr + (m * rv + mx * rr)
    f_v = m_ * (a_v + ru) + mx_ * a_r - m * ru
    f_r = mx_ * (a_v + ru) + I_ * a_r - mx * ru
    over = TRACKING_DT / (m * I - mx * mx)
    u = u + (TRACKING_DT / m) * f_u
    v = v + (I * over * f_v - mx * over * f_r)
    r = r + (m * over * f_r - mx * over * f_v)
    dt = TRACKING_DT
    return *exact_step(xp, x, y, psi, dt * u, dt * v, (0.5 * dt) * r), u, v, r


# ---- a tick of MPPI --------------------------------------------------------------------------

MPPI_DT, TEMPERATURE, MPPI_SIGMA = 0.05, 3.0, 0.3  # [s], in the cost's unit, [m/s, rad/s]
GOAL = (4.0, 0.5)  # [m]
EFFORT = 0.05  # cost of a twist's square
CIRCLES = ((1.5, 0.3, 0.3), (2.2, -0.5, 0.4), (3.0, 0.6, 0.35))  # x, y, radius [m]
MARGIN, PENALTY = 0.3, 20.0  # [m], cost per metre nearer than that


def first_plan(size: Sizes) -> Numbers:
    """Return the twists (T, 3) that a tick starts from."""
    plan = np.zeros((size.horizon, 3), np.float32)
    plan[:, 0] = 0.5
    return plan


def stage_cost(xp: Any, x: Any, y: Any, u: Any, v: Any, r: Any) -> Any:
    """Return the cost of a pose and a twist: distance to the goal, effort, nearness to circles."""
    cost = (x - GOAL[0]) ** 2 + (y - GOAL[1]) ** 2 + EFFORT * (u * u + v * v + r * r)
    for a, b, radius in CIRCLES:
        gap = xp.sqrt((x - a) ** 2 + (y - b) ** 2) - radius
        cost = cost + PENALTY * xp.maximum(MARGIN - gap, 0)
    return cost


# ---- one robot that follows a circle by feedback ---------------------------------------------

FOLLOW_GAIN = 2.0  # [1/s]


# ---- answers ---------------------------------------------------------------------------------


def few(size: Sizes, x: Any, y: Any, psi: Any) -> list[float]:
    """Return the poses of the first robots, which every candidate has."""
    rows = [np.asarray(each)[: size.few_robots] for each in (x, y, psi)]
    return [float(value) for value in np.concatenate(rows)]


def spread(x: Any, y: Any, psi: Any) -> list[float]:
    """Return mean and standard deviation of positions and headings, where noise differs."""
    rows = [np.asarray(each, dtype=np.float64) for each in (x, y, psi)]
    return [float(f(each)) for each in rows for f in (np.mean, np.std)]
