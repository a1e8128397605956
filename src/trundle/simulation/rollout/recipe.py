"""What a rollout's loop is made of, and the one function that advances a robot by a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.motions import Motion, Values
from trundle.simulation.rollout.written import scaled_sum


class Law(Protocol):
    """A feedback law: hashable, with so many constants of a robot."""

    @property
    def constants(self) -> int:
        """How many constants the function takes."""

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, constants) -> the command."""


class Reduction(Protocol):
    """What is made of pose and command after every step: hashable, with registers for it."""

    @property
    def start(self) -> tuple[float, ...]:
        """What the registers hold before the first step."""

    def make(self, m: Arithmetic, jit: Jit) -> Function:
        """Return (t, pose, command, registers, constants, table) -> the new registers."""


@dataclass(frozen=True)
class Recipe:
    """The choices that make a loop: all that is compiled, and nothing that is not.

    Attributes:
        dtype: "float32" or "float64".
        given: how many numbers the commands give for each robot and step; 0 for a feedback law.
        command: how many numbers a command is.
        own: for each constant, whether every robot has its own.
        motion: how a command moves a robot.
        common: whether all robots share the commands.
        noisy: whether noise is added to the command.
        law: the feedback law that makes the command, or None.
        reduction: what is made of pose and command after every step, or None.
        wide: whether a robot may turn by half a turn or more within a step.
        spread: whether poses are summed over all robots.
        keeps: whether poses are kept on the way.
    """

    dtype: str
    given: int
    command: int
    own: tuple[bool, ...]
    motion: Motion
    common: bool = False
    noisy: bool = False
    law: Law | None = None
    reduction: Reduction | None = None
    wide: bool = False
    spread: bool = False
    keeps: bool = False

    @property
    def noise(self) -> int:
        """How many random numbers a step takes: a multiple of 4, or none."""
        return 4 * -(-self.command // 4) if self.noisy else 0

    @property
    def compensated(self) -> bool:
        """Whether positions carry what their sums lose."""
        return self.dtype == "float32"

    @property
    def watched(self) -> bool:
        """Whether the loop must see that no robot turns further in a step than sinc is read for."""
        return self.motion.arcs and not self.wide

    @property
    def moved(self) -> int:
        """How many numbers the motion keeps of a robot; the pose comes first."""
        return self.motion.kept + (3 if self.compensated else 0)

    @property
    def state(self) -> int:
        """How many numbers are kept of a robot: the motion's, and the registers."""
        return self.moved + (0 if self.reduction is None else len(self.reduction.start))


def make_advance(recipe: Recipe, m: Arithmetic, jit: Jit) -> Function:
    """Return (t, state, given, noise, constants, table) -> the state after step t, and a turn.

    The turn is half of that which a step's arc makes. The constants stand in the order law, noise,
    motion, reduction.
    """
    command, first = _make_command(recipe, m, jit)
    move, last = recipe.motion.make(m, jit, recipe.compensated), first + recipe.motion.constants
    reduction, size = recipe.reduction, recipe.moved

    def advance(
        t: Any, state: Values, given: Values, noise: Values, constants: Values, _: Any
    ) -> Any:
        wanted = command(t, state, given, noise, constants)
        return move(state, wanted, constants[first:last])

    if reduction is None:
        return jit(advance)
    reduce = reduction.make(m, jit)

    def advance_and_reduce(
        t: Any, state: Values, given: Values, noise: Values, constants: Values, table: Any
    ) -> tuple[Values, Any]:
        wanted = command(t, state, given, noise, constants)
        moved, half = move(state[:size], wanted, constants[first:last])
        registers = reduce(t, moved[:3], wanted, state[size:], constants[last:], table)
        return moved + registers, half

    return jit(advance_and_reduce)


def _make_command(recipe: Recipe, m: Arithmetic, jit: Jit) -> tuple[Function, int]:
    """Return (t, state, given, noise, constants) -> the command, and the constants it takes."""

    def known(t: Any, state: Values, given: Values, noise: Values, constants: Values) -> Values:  # noqa: ARG001
        return given

    wanted, first = jit(known), 0
    if recipe.law is not None:
        law, first = recipe.law.make(m, jit), recipe.law.constants

        def fed_back(
            t: Any,
            state: Values,
            given: Values,  # noqa: ARG001
            noise: Values,  # noqa: ARG001
            constants: Values,
        ) -> Any:
            return law(t, state[:3], constants[:first])

        wanted = jit(fed_back)
    if not recipe.noisy:
        return wanted, first
    add, last = jit(scaled_sum(recipe.command)), first + recipe.command

    def noisy(t: Any, state: Values, given: Values, noise: Values, constants: Values) -> Any:
        without = wanted(t, state, given, noise, constants)
        return add(without, constants[first:last], noise)

    return jit(noisy), last
