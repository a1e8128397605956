"""Robots that a controller keeps on a trajectory, by the planar dynamics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from trundle.simulation.arithmetic import Arithmetic, Function, Jit
from trundle.simulation.rollout.motions import Values, make_sum
from trundle.simulation.tracking.laws import (
    PER_WHEEL,
    Law,
    make_respond,
    make_shorter,
    make_wheel,
)

# Numbers of the constants before the gains: the step, half of it, and those of the body.
_BODY = 9


@dataclass(frozen=True)
class ClosedLoop:
    """One step of ``track``'s semi-implicit method; the command is what is desired, nine numbers.

    Attributes:
        law: the control law.
        gains: how many constants the law takes.
        wheels: how many wheels stand between command and body; 0 without limits and friction.
        wraps: whether heading errors go the shorter way round.
    """

    law: Law
    gains: int
    wheels: int
    wraps: bool
    kept: ClassVar[int] = 6
    arcs: ClassVar[bool] = True

    @property
    def constants(self) -> int:
        """How many constants the function takes: steps, body, gains, wheels."""
        return 2 + _BODY + self.gains + PER_WHEEL * self.wheels

    def make(self, m: Arithmetic, jit: Jit, compensated: bool) -> Function:
        """Return (state, command, constants) -> the new state, and half of the step's turn."""
        ground = self._make_ground(m, jit) if self.wheels else None
        respond = jit(make_respond(self.law, ground, jit))
        shorter = make_shorter(m, jit) if self.wraps else jit(lambda error: error)
        sin, cos, sinc, near_cos = m.sin, m.cos, m.sinc, m.near_cos
        moved, posed = make_sum(jit, compensated), 6 if compensated else 3
        gains, wheels = 2 + _BODY, 2 + _BODY + self.gains

        def step(state: Values, command: Values, constants: Values) -> tuple[Values, Any]:
            dt, half_dt, psi = constants[0], constants[1], state[2]
            u, v, r = state[posed], state[posed + 1], state[posed + 2]
            c, s = cos(psi), sin(psi)
            a_u, a_v, a_r, _, _, _ = respond(
                constants[gains:wheels], constants[2:gains], constants[wheels:], 0,
                command[0] - state[0], command[1] - state[1], shorter(command[2] - psi),
                command[3] - (c * u - s * v), command[4] - (s * u + c * v), command[5] - r,
                command[6], command[7], command[8], c, s, u, v, r,
            )  # fmt: skip
            u, v, r = u + dt * a_u, v + dt * a_v, r + dt * a_r
            half = half_dt * r
            # The exact arc, its chord turned from the heading at the start by half of the turn:
            # cheaper than sine and cosine of the heading at its middle.
            chord = sinc(half)
            c_half, s_half = near_cos(half), half * chord
            length = dt * chord
            c, s = length * (c * c_half - s * s_half), length * (s * c_half + c * s_half)
            pose = moved(state[:posed], c * u - s * v, s * u + c * v, half)
            return pose + (u, v, r), half  # noqa: RUF005

        return jit(step)

    def _make_ground(self, m: Arithmetic, jit: Jit) -> Function:
        """Return the function of all wheels, one after the other without a loop."""
        wheel = jit(make_wheel(m, jit))

        def from_wheel(i: int) -> Function:
            j = PER_WHEEL * i

            def last(wheels: Any, _: int, X: Any, Y: Any, Z: Any, u: Any, v: Any, r: Any) -> Any:
                return wheel(wheels, j, X, Y, Z, u, v, r)

            if i + 1 == self.wheels:
                return jit(last)
            later = from_wheel(i + 1)

            def with_later(
                wheels: Any, count: int, X: Any, Y: Any, Z: Any, u: Any, v: Any, r: Any
            ) -> Any:
                x, y, z = wheel(wheels, j, X, Y, Z, u, v, r)
                more_x, more_y, more_z = later(wheels, count, X, Y, Z, u, v, r)
                return x + more_x, y + more_y, z + more_z

            return jit(with_later)

        return from_wheel(0)
