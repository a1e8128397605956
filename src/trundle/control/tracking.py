"""Controllers for robots that cannot move sideways: they command forward speed and yaw rate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, final

import numpy as np

from trundle.control.gains import one_gain
from trundle.dynamics import to_body
from trundle.se2 import Array, wrap
from trundle.simulation import Measurement, Reference


class Chase(NamedTuple):
    """A reference as a robot that only goes forward sees it, from its own body.

    Attributes:
        ahead: how far ahead the reference is [m].
        left: how far to the left [m].
        turn: its heading relative to the robot's [rad].
        speed: its speed along its own heading [m/s], negative when it goes backwards.
        yaw_rate: its yaw rate [rad/s].
    """

    ahead: float
    left: float
    turn: float
    speed: float
    yaw_rate: float


def chase(measurement: Measurement, reference: Reference) -> Chase:
    """Return the reference in the robot's body frame."""
    e_x, e_y, turn = reference.error(measurement.pose).tolist()
    psi, heading = float(measurement.pose[2]), float(reference.position[2])
    ahead, left = to_body(math.cos(psi), math.sin(psi), e_x, e_y)
    x_dot, y_dot, yaw_rate = np.asarray(reference.velocity, dtype=np.float64).tolist()
    speed, _ = to_body(math.cos(heading), math.sin(heading), x_dot, y_dot)
    return Chase(ahead, left, turn, speed, yaw_rate)


def sinc(angle: float) -> float:
    """Return sin(angle) / angle, 1 at 0."""
    return math.sin(angle) / angle if angle else 1.0


@final
@dataclass(frozen=True)
class Kanayama:
    """Trajectory tracking for robots that drive forward and turn.

    With e = (ahead, left, turn) of the reference in the body frame and u_r, r_r its speeds::

        u = u_r cos(e_turn) + k_x e_ahead
        r = r_r + k_y u_r e_left sin(e_turn) / e_turn + k_psi e_turn

    The first source has ``r = r_r + u_r (k_y e_left + k_psi sin(e_turn))``; without the factor u_r
    on k_psi the heading is held at standstill too, and the reference may go backwards.

    Args:
        k_x: gain on the distance ahead [1/s].
        k_y: gain on the distance to the left [1/m^2].
        k_psi: gain on the heading [1/s].

    Source: Kanayama, Kimura, Miyazaki and Noguchi, A stable tracking control method for an
    autonomous mobile robot, ICRA 1990, eq. (8); in this form, with its proof of stability,
    Siciliano, Sciavicco, Villani and Oriolo, Robotics: Modelling, Planning and Control, 2009,
    section 11.6.1, the nonlinear controller.

    >>> on_the_way = Measurement(0.0, np.zeros(3), np.zeros(3))
    >>> moving = Reference(np.array([0.1, 0.0, 0.0]), np.array([0.5, 0.0, 0.0]), np.zeros(3))
    >>> twist, _ = Kanayama().step(None, on_the_way, moving)
    >>> twist.round(9).tolist()
    [0.7, 0.0, 0.0]
    """

    k_x: float = 2.0
    k_y: float = 8.0
    k_psi: float = 3.0
    output: ClassVar[str] = "twist"

    def __post_init__(self) -> None:
        for name in ("k_x", "k_y", "k_psi"):
            object.__setattr__(self, name, one_gain(getattr(self, name), name))

    def step(
        self, state: None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, None]:
        """Return the twist (u, 0, r) in the body frame; there is no memory."""
        seen = chase(measurement, reference)
        u = seen.speed * math.cos(seen.turn) + self.k_x * seen.ahead
        steer = self.k_y * seen.speed * seen.left * sinc(seen.turn)
        return np.array([u, 0.0, seen.yaw_rate + steer + self.k_psi * seen.turn]), None


@final
@dataclass(frozen=True)
class GoToPose:
    """Drive to a pose at rest, seen from the robot in polar coordinates.

    With rho the distance to the goal, gamma the angle from the robot's heading to the goal and
    delta = gamma plus the robot's heading relative to the goal's::

        u = k_rho rho cos(gamma)
        r = k_gamma gamma + k_rho sin(gamma) cos(gamma) (gamma + k_delta delta) / gamma

    The goal is the trajectory's position; its velocity is not used. The robot arrives forwards,
    turning in from behind. At the goal the angles have no meaning: within ``near`` of it, the
    robot only turns to the goal's heading, which the source leaves open.

    Args:
        k_rho: gain on the distance [1/s].
        k_gamma: gain on the direction to the goal [1/s].
        k_delta: weight of the goal's heading.
        near: distance at which the goal counts as reached [m]; there it only turns.

    Source: Aicardi, Casalino, Bicchi and Balestrino, Closed loop steering of unicycle-like vehicles
    via Lyapunov techniques, IEEE Robotics and Automation Magazine, 1995; Siciliano, Sciavicco,
    Villani and Oriolo, 2009, section 11.6.2, posture regulation.

    >>> here = Measurement(0.0, np.zeros(3), np.zeros(3))
    >>> ahead = Reference(np.array([2.0, 0.0, 0.0]), np.zeros(3), np.zeros(3))
    >>> GoToPose(k_rho=0.5).step(None, here, ahead)[0].tolist()
    [1.0, 0.0, 0.0]
    """

    k_rho: float = 0.8
    k_gamma: float = 3.0
    k_delta: float = 1.5
    near: float = 1e-3
    output: ClassVar[str] = "twist"

    def __post_init__(self) -> None:
        for name in ("k_rho", "k_gamma", "k_delta", "near"):
            object.__setattr__(self, name, one_gain(getattr(self, name), name))

    def step(
        self, state: None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, None]:
        """Return the twist (u, 0, r) in the body frame; there is no memory."""
        seen = chase(measurement, reference)
        rho = math.hypot(seen.ahead, seen.left)
        if rho < self.near:
            return np.array([0.0, 0.0, self.k_gamma * seen.turn]), None
        gamma = math.atan2(seen.left, seen.ahead)
        delta = float(wrap(gamma - seen.turn))
        u = self.k_rho * rho * math.cos(gamma)
        meet = sinc(gamma) * math.cos(gamma) * (gamma + self.k_delta * delta)
        return np.array([u, 0.0, self.k_gamma * gamma + self.k_rho * meet]), None
