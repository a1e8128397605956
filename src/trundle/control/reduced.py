"""Computed torque on the reduced dynamics of robots that cannot move sideways."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from trundle.control.gains import one_gain
from trundle.control.tracking import chase
from trundle.dynamics import Dynamics, to_body
from trundle.errors import TrundleError
from trundle.se2 import Array
from trundle.simulation import Measurement, Reference


@final
@dataclass(frozen=True)
class ReducedComputedTorque:
    """Trajectory tracking by wheel torques: Kanayama's speeds, and the torques that reach them.

    With nu = (u, r) and nu_c the speeds that bring the robot onto the trajectory::

        nu_c = (u_r cos(e_turn) + k_x e_ahead,  r_r + k_y u_r e_left + k_psi sin(e_turn))
        tau = torques for nu_dot = nu_c_dot + k_nu (nu_c - nu)

    nu_c_dot is written out, not differenced. The torques are those of the reduced dynamics,
    ``N^T M N nu_dot + N^T c``, with friction and a centre of mass off the axle.

    Args:
        k_x: gain on the distance ahead [1/s].
        k_y: gain on the distance to the left [1/m^2].
        k_psi: gain on the heading [1/s].
        k_nu: gain on the speeds [1/s].
        model: what the controller believes of the robot; the robot itself when left out.

    Source: Fierro and Lewis, Control of a nonholonomic mobile robot: backstepping kinematics into
    dynamics, Journal of Robotic Systems 14(3), 1997; there k_psi has the factor u_r, here the
    heading is held at standstill too.

    >>> import trundle
    >>> model = Dynamics(trundle.load("differential").with_body(mass=20.0))
    >>> at_rest = Measurement(0.0, np.zeros(3), np.zeros(3))
    >>> ahead = Reference(np.array([0.1, 0.0, 0.0]), np.zeros(3), np.zeros(3))
    >>> law = ReducedComputedTorque(k_x=2.0, k_nu=5.0, model=model)
    >>> law.step(None, at_rest, ahead)[0].round(
    ...     9
    ... ).tolist()  # 20 kg times 1 m/s^2 on two 5 cm wheels
    [0.5, 0.5]
    """

    k_x: float = 2.0
    k_y: float = 8.0
    k_psi: float = 3.0
    k_nu: float = 10.0
    model: Dynamics | None = None
    output: ClassVar[str] = "torques"

    def __post_init__(self) -> None:
        for name in ("k_x", "k_y", "k_psi", "k_nu"):
            object.__setattr__(self, name, one_gain(getattr(self, name), name))
        if not isinstance(self.model, Dynamics | None):
            raise TrundleError(
                "model must be a trundle.Dynamics: write model=trundle.Dynamics(robot), got "
                f"{type(self.model).__name__}"
            )
        if self.model is not None:
            _need_forward_drive(self.model.robot.name, self.model.reduced().allowed)

    def with_model(self, model: Dynamics) -> ReducedComputedTorque:
        """Return the controller with a model, if it has none of its own."""
        return self if self.model is not None else dataclasses.replace(self, model=model)

    def step(
        self, state: None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, None]:
        """Return the torques (n,) at the driven wheels; there is no memory.

        Raises:
            TrundleError: the controller has no model; ``track`` gives it the robot's.
        """
        if self.model is None:
            raise TrundleError(
                "computed torque needs a model: "
                "ReducedComputedTorque(model=trundle.Dynamics(robot))"
            )
        psi = float(measurement.pose[2])
        x_dot, y_dot, r = np.asarray(measurement.rate, dtype=np.float64).tolist()
        u, _ = to_body(math.cos(psi), math.sin(psi), x_dot, y_dot)
        wanted, change = self._speeds(measurement, reference, u, r)
        u_dot, r_dot = change + self.k_nu * (wanted - np.array([u, r]))
        # A sideways speed is measured with error, or left by the lecture's straight step.
        return self.model.torques([u, 0.0, r], [u_dot, 0.0, r_dot]), None

    def _speeds(
        self, measurement: Measurement, reference: Reference, u: float, r: float
    ) -> tuple[Array, Array]:
        """Return nu_c (2,) and its time derivative (2,)."""
        seen = chase(measurement, reference)
        u_r, c, s = seen.speed, math.cos(seen.turn), math.sin(seen.turn)
        # The reference's speed along its heading changes; so do the errors seen from the body.
        heading, rates = float(reference.position[2]), np.asarray(reference.velocity)
        u_r_dot, _ = to_body(math.cos(heading), math.sin(heading), *reference.acceleration[:2])
        _, across = to_body(math.cos(heading), math.sin(heading), rates[0], rates[1])
        u_r_dot += seen.yaw_rate * across
        ahead_dot = r * seen.left - u + u_r * c - across * s
        left_dot = -r * seen.ahead + u_r * s + across * c
        turn_dot = seen.yaw_rate - r
        wanted = np.array(
            [
                u_r * c + self.k_x * seen.ahead,
                seen.yaw_rate + self.k_y * u_r * seen.left + self.k_psi * s,
            ]
        )
        change = np.array(
            [
                u_r_dot * c - u_r * s * turn_dot + self.k_x * ahead_dot,
                float(reference.acceleration[2])
                + self.k_y * (u_r_dot * seen.left + u_r * left_dot)
                + self.k_psi * c * turn_dot,
            ]
        )
        return wanted, change


def _need_forward_drive(name: str, motions: Array) -> None:
    """Refuse a robot that cannot go straight ahead and turn about its origin.

    Args:
        name: the robot's name.
        motions: (3, 3) projector onto the twists that its wheels allow.

    Raises:
        TrundleError: u or r alone is not among them.
    """
    for twist, what in (((1.0, 0.0, 0.0), "straight ahead"), ((0.0, 0.0, 1.0), "about its origin")):
        if np.abs(motions @ twist - twist).max() > 1e-6:
            raise TrundleError(
                f"robot {name!r} cannot move {what}: this controller needs a robot whose origin "
                "lies on the axle and whose x axis points forward"
            )
