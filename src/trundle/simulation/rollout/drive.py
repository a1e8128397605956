"""How a robot's commands drive it: what the loop is given, and how that moves the robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import mobility, motion_projector, motion_space, wheel_matrix
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.arithmetic import Arithmetic, Function, Jit, array_arithmetic, as_is
from trundle.simulation.rollout.commands import Commands, Given, Policy
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.motions import CHORDS, Chord, Linear, Motion, Values
from trundle.simulation.rollout.reading import as_read, tried, what_it_reads
from trundle.simulation.rollout.recipe import Law
from trundle.simulation.rollout.steered import check_centres, steered_motion
from trundle.simulation.rollout.tracking import Tracking, plant_for
from trundle.simulation.rollout.varied import batch_of, vary
from trundle.simulation.rollout.written import converted


class Drive(NamedTuple):
    """How commands drive a robot.

    Attributes:
        motion: how a command moves the robot.
        constants: those of the motion, group by group, each (k,) or (k, N).
        width: how many numbers a command is.
        what: these numbers in words.
        given: (T or 1, k, N or 1) what the loop is given; of a feedback law nothing.
        start: from starts (3,), (N, 3) or None to states (k, N or 1).
        law: the feedback law, or None.
        law_constants: from the law's parameters, as given, to its constants (k,) or (k, N).
        arrange: from other commands (T or 1, k, N or 1) to what the loop is given.
    """

    motion: Motion
    constants: list[Numbers]
    width: int
    what: str
    given: Numbers
    start: Callable[[Array | None], Array]
    law: Law | None = None
    law_constants: Callable[[Numbers], Numbers] | None = None
    arrange: Callable[[Numbers], Numbers] = as_is


# Traces of projectors are whole numbers.
_HALF = 0.5


@dataclass(frozen=True)
class PolicyLaw:
    """A policy's function; its constants are the step and the policy's parameters."""

    step: Any
    parameters: int
    command: int
    reads: tuple[Any, ...]

    @property
    def constants(self) -> int:
        """How many constants the function takes."""
        return 1 + self.parameters

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, constants) -> the command."""
        step, as_numbers = jit(as_read(self.step, m, jit)), jit(converted(self.command))
        step = tried(step, self.step.__name__, self.command, self.parameters, m)
        number = m.number

        def law(t: Any, pose: Values, constants: Values) -> Any:
            return as_numbers(number, step(number(t) * constants[0], pose, constants[1:]))

        return jit(law)


def drive(
    robot: Robot,
    commands: Commands,
    *,
    parameters: Mapping[str, npt.ArrayLike],
    dt: float,
    steps: int | None,
    method: str,
    held: bool,
) -> Drive:
    """Return how commands drive a robot.

    Args:
        robot: the robot.
        commands: its commands.
        parameters: what the robots differ in.
        dt: step [s].
        steps: number of steps, where it is known.
        method: how a step goes along its arc.
        held: whether nothing asks for the commands themselves, so that constant ones can be taken
            to chords beforehand.

    Raises:
        TrundleError: robot and commands do not fit together; the message says why.
    """
    if isinstance(commands, Tracking):
        return _tracked(robot, commands, parameters, dt, steps, method)
    if not isinstance(commands, Given | Policy):
        raise TrundleError(
            "commands must say what they are: Constant(...) for each robot's own, Stream(...) for "
            "one row a step, Policy(...) for a feedback law, Tracking(...) for a controller; got "
            f"{type(commands).__name__}"
        )
    check_driven(robot)
    motion, constants = _motion(robot, vary(robot, parameters), commands.is_twist, dt, method)
    made = Drive(
        motion=motion,
        constants=[constants],
        width=3 if commands.is_twist else len(robot.driven) + len(robot.steered),
        what="(u, v, r)" if commands.is_twist else _names(robot),
        given=np.zeros((1, 0, 1)),
        start=_posed,
    )
    if isinstance(commands, Policy):
        law = PolicyLaw(
            commands.step, commands.parameters.shape[-1], made.width, what_it_reads(commands.step)
        )
        return made._replace(law=law, law_constants=partial(_with_step, dt=dt))
    made = made._replace(given=_checked(robot, commands, made))
    if held and not commands.moving and isinstance(made.motion, Linear):
        to_chords = partial(_chords, made.motion, constants)
        return made._replace(
            motion=Chord(), constants=[], given=to_chords(made.given), arrange=to_chords
        )
    return made


def _motion(
    robot: Robot, varied: Robot, is_twist: bool, dt: float, method: str
) -> tuple[Motion, Numbers]:
    """Return how commands move robots, and the constants (k,), or (k, N) where robots differ."""
    if robot.steered and is_twist and batch_of(varied):
        raise TrundleError(
            f"robot {robot.name!r} steers: what robots differ in does not change their twists; "
            "give wheel_speeds and steering"
        )
    if robot.steered and not is_twist:
        return steered_motion(robot, varied, dt, method)
    if robot.steered:
        matrix = allowed_twists(robot)
    else:
        none = np.zeros((*batch_of(varied), 0))
        _check_motions(robot, motion_projector(varied, none)[0])
        matrix = motion_projector(varied, none)[0] if is_twist else wheel_matrix(varied, none)[0]
    scaled = dt * matrix * np.array([[1.0], [1.0], [0.5]])
    return Linear(matrix.shape[-1], method), scaled.reshape(*matrix.shape[:-2], -1).T


def _check_motions(robot: Robot, allowed: Array) -> None:
    """Refuse robots that differ so that their wheels allow other motions (N, 3, 3) at all."""
    degree = np.trace(allowed, axis1=-2, axis2=-1)
    wanted = np.trace(motion_projector(robot, np.zeros(0))[0])
    other = np.flatnonzero(np.abs(degree - wanted) > _HALF)
    if len(other):
        raise TrundleError(
            f"parameters leave robot {other[0]} with {degree.flat[other[0]]:.0f} motions where "
            f"{robot.name!r} has {wanted:.0f}: its wheels' axles no longer share a line"
        )


def _names(robot: Robot) -> str:
    speeds = "the speeds of " + ", ".join(wheel.name for wheel in robot.driven)
    if not robot.steered:
        return speeds
    return speeds + ", and the steering angles of " + ", ".join(w.name for w in robot.steered)


def _tracked(
    robot: Robot,
    commands: Tracking,
    parameters: Mapping[str, npt.ArrayLike],
    dt: float,
    steps: int | None,
    method: str,
) -> Drive:
    if method != "exact":
        raise TrundleError(f"Tracking takes the exact arc of each new twist: leave out {method!r}")
    if commands.noise is not None:
        raise TrundleError("Tracking takes no noise: vary the starts, the robot or the controllers")
    plant = plant_for(robot)
    desired = commands.desired(steps, dt)
    varied = vary(robot, parameters)
    motion, constants = commands.motion(plant, varied, batch_of(varied), dt)
    return Drive(
        motion=motion,
        constants=constants,
        width=9,
        what="desired x, y, psi and their derivatives",
        given=desired,
        start=partial(commands.start, desired, plant=plant),
    )


def _posed(pose: Array | None) -> Array:
    """Return starts (3, N or 1); the origin where none are given."""
    return np.zeros((3, 1)) if pose is None else np.atleast_2d(pose).T


def _checked(robot: Robot, commands: Given, made: Drive) -> Numbers:
    """Return the commands (T or 1, k, N or 1), angles after speeds."""
    values, angles, name = commands.values, commands.steering, "wheel_speeds"
    width = made.width
    if commands.is_twist:
        name = "twist"
    elif robot.steered:
        width -= len(robot.steered)
        if angles is None:
            raise ShapeError(
                f"robot {robot.name!r} steers: give steering, the angles of "
                f"{', '.join(wheel.name for wheel in robot.steered)} [rad], beside wheel_speeds"
            )
    elif angles is not None:
        raise TrundleError(f"robot {robot.name!r} does not steer: leave out steering")
    if values.shape[1] != width:
        raise ShapeError(
            f"{name} of robot {robot.name!r} must have {width} values for each robot, "
            f"{made.what}, got {values.shape[1]}"
        )
    return values if angles is None else _beside(robot, values, angles)


def _beside(robot: Robot, speeds: Numbers, angles: Numbers) -> Numbers:
    if angles.shape[1] != len(robot.steered):
        raise ShapeError(
            f"steering of robot {robot.name!r} must have {len(robot.steered)} angles for each "
            f"robot, got {angles.shape[1]}"
        )
    if not np.isfinite(angles).all():
        raise ShapeError("steering must be finite numbers, got nan or inf")
    check_centres(robot, angles)
    try:
        batch = np.broadcast_shapes(speeds.shape[::2], angles.shape[::2])
    except ValueError:
        raise ShapeError(
            f"wheel_speeds for {speeds.shape[::2]} steps and robots do not go with steering for "
            f"{angles.shape[::2]}"
        ) from None
    both = (np.broadcast_to(each, (batch[0], each.shape[1], batch[1])) for each in (speeds, angles))
    return np.concatenate(list(both), axis=1)


def _with_step(parameters: Numbers, dt: float) -> Numbers:
    """Return a law's constants: the step, and the parameters (k,) or (k, N)."""
    step = np.full((*parameters.shape[:-1], 1), float(dt))
    return np.concatenate([step, parameters], axis=-1).T


def _chords(motion: Linear, constants: Numbers, given: Numbers) -> Numbers:
    """Return the chords (1, 3, N) of commands that do not change, and half their turns."""
    count, own = given.shape[2], constants.shape[1] if constants.ndim == 2 else 1
    if 1 not in (count, own) and count != own:
        raise ShapeError(f"commands have {count} robots, and what robots differ in has {own}")
    rows = constants.reshape(3, motion.count, *constants.shape[1:])
    chord = CHORDS[motion.method](array_arithmetic("float64"), as_is)
    # What is no number is told afterwards, of chords as of all commands.
    with np.errstate(all="ignore"):
        dx, dy, half = np.einsum("ij...,j...->i...", rows, given[0].astype(np.float64))
        a, b = chord(dx, dy, half)
    return np.stack([a, b, half])[None]


@lru_cache(maxsize=32)
def check_driven(robot: Robot) -> None:
    """Refuse robots with a motion that nothing drives.

    Raises:
        TrundleError: the robot has too few driven wheels; the motions are named.
    """
    if not robot.driven:
        raise TrundleError(f"robot {robot.name!r} has no driven wheel: nothing moves it")
    if undriven := mobility(robot).undriven:
        raise TrundleError(
            f"robot {robot.name!r} has too few driven wheels: nothing drives "
            f"{' and '.join(undriven)}, so that the wheels do not tell where it goes"
        )


@lru_cache(maxsize=32)
def allowed_twists(robot: Robot) -> Array:
    """Return the projector (3, 3) onto the twists that the wheels allow at some steering angle.

    Raises:
        TrundleError: linked wheels allow some of these twists only.
    """
    if not robot.steered:
        return motion_projector(robot, np.zeros(0))[0]
    space, whole = motion_space(robot)
    if not whole:
        raise TrundleError(
            f"robot {robot.name!r}: its linked steering allows some twists only; give wheel_speeds "
            "and steering"
        )
    return np.asarray(space @ space.T)
