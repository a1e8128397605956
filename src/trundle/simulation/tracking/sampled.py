"""Controllers that are called once a step: their command is held while the body moves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.dynamics import to_body, to_inertial
from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.motion import Course
from trundle.se2 import Array
from trundle.simulation.arithmetic import Function, Jit
from trundle.simulation.tracking.adaptive import run_adaptive
from trundle.simulation.tracking.compiled import Constants, run_plain
from trundle.simulation.tracking.loops import COLUMNS
from trundle.simulation.tracking.plant import Plant
from trundle.simulation.tracking.recorded import Motion, new_block
from trundle.simulation.tracking.signals import Controller, Measurement, Reference, reference


def held(_: Jit) -> Function:
    """Return the law of a command between two calls: a force that is held in the body frame."""
    return lambda force, *_: (force[0], force[1], force[2])


def run_sampled(
    controller: Controller,
    plant: Plant,
    course: Course,
    t: Array,
    plain: bool,
    start: Array,
    method: str,
) -> Motion:
    """Return the motion under a controller that is called at the start of each step.

    Args:
        controller: commands forces or torques.
        plant: what moves.
        course: what is desired at T + 1 times, or 2 T + 1 for "rk4".
        t: (T + 1,) times [s].
        plain: whether heading errors are the plain difference.
        start: (6,) pose and twist.
        method: one of the methods of ``track``.
    """
    T, n = len(t) - 1, len(plant.G)
    stride = (len(course.position) - 1) // T
    block, asked = new_block(n, T + 1), np.empty((n, T))
    notes = block[:COLUMNS]
    state, memory, steps = start, None, T
    for k in range(T):
        part = Course(*(each[stride * k : stride * (k + 1) + 1] for each in course))
        measured = _measured(float(t[k]), state)
        command, memory = call(controller, memory, measured, reference(part, 0, plain))
        asked[:, k], force = _as_force(controller.output, command, plant, state)
        constants = plant.constants(tuple(force.tolist()), plain, controller.output == "force")
        made, moved = _hold(method, constants, part, t[k : k + 2], state)
        made[15:] += notes[15:, k : k + 1] if k else 0.0
        notes[:, k : k + 2] = made
        if not moved:
            steps = k
            break
        # What the wheels do not allow is rounding, or the lecture's straight step.
        notes[3:6, k + 1] = plant.here.allowed @ made[3:6, 1]
        state = notes[:6, k + 1].copy()
    return Motion(steps, block, asked[:, :steps], straight=method == "lecture")


def _measured(time: float, state: Array) -> Measurement:
    c, s = math.cos(state[2]), math.sin(state[2])
    rate = np.array([*to_inertial(c, s, state[3], state[4]), state[5]])
    return Measurement(time, state[:3].copy(), rate)


def call(
    controller: Controller, memory: Any, measurement: Measurement, wanted: Reference
) -> tuple[npt.ArrayLike, Any]:
    """Return the controller's command and its memory.

    Raises:
        TrundleError: it returned something else.
    """
    answer = controller.step(memory, measurement, wanted)
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise TrundleError(
            f"step(state, measurement, reference) must return command and state, got {answer!r}"
        )
    return answer


def _as_force(
    output: str, command: npt.ArrayLike, plant: Plant, state: Array
) -> tuple[Array, Array]:
    """Return the torques (n,) that a command asks for, and the force (3,) in the body frame."""
    n = len(plant.G)
    values = as_command(command, 3 if output == "force" else n, output)
    if output == "torques":
        given = plant.dynamics.torque_limits.held(values, plant.G @ state[3:])
        return values, given @ plant.G
    X, Y = to_body(math.cos(state[2]), math.sin(state[2]), values[0], values[1])
    force = np.array([X, Y, values[2]])
    return plant.allocation @ force, force


def as_command(command: npt.ArrayLike, width: int, output: str) -> Array:
    """Return a controller's command as an array (width,).

    Raises:
        ShapeError: it has another shape or is not finite.
    """
    values = finite(command, f"the controller's {output}")
    if values.shape != (width,):
        raise ShapeError(
            f"the controller's {output} must be {width} finite numbers, got {values.tolist()}"
        )
    return values


def _hold(
    method: str, constants: Constants, part: Course, times: Array, state: Array
) -> tuple[Array, int]:
    """Return the notes (18, 2) of a step under a held force, and 0 where the motion outgrew it."""
    notes = np.empty((COLUMNS, 2))
    if method == "adaptive":
        first, last = Course(*(e[:1] for e in part)), Course(*(e[-1:] for e in part))
        moved = run_adaptive(
            held, lambda time: last if time >= times[1] else first, constants, times, state, notes
        )
    else:
        moved = run_plain(method, held, part, constants, np.diff(times), state, notes)
    return notes, moved
