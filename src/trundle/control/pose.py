"""Controllers in pose space: PD and computed torque."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from trundle.control.gains import three_gains
from trundle.dynamics import Dynamics, body_bias, to_body, to_inertial
from trundle.errors import TrundleError
from trundle.se2 import Array
from trundle.simulation import Function, Jit, Law, Measurement, Reference


def pd_law(jit: Jit) -> Function:
    """Return ``F = K_p e + K_d e_dot`` in scalars, as the force in the body frame."""
    turned = jit(to_body)

    def law(  # all laws take the same
        k: Any, e_x: Any, e_y: Any, e_psi: Any, d_x: Any, d_y: Any, d_psi: Any,
        _a_x: Any, _a_y: Any, _a_psi: Any, c: Any, s: Any, _u: Any, _v: Any, _r: Any,
    ) -> Any:  # fmt: skip
        X, Y = turned(c, s, k[0] * e_x + k[3] * d_x, k[1] * e_y + k[4] * d_y)
        return X, Y, k[2] * e_psi + k[5] * d_psi

    return law


def computed_torque_law(jit: Jit) -> Function:
    """Return ``F = M (q_ddot_des + K_d e_dot + K_p e) + n`` in scalars, in the body frame.

    After the gains, k holds the model: the six numbers of M in the body frame, mass and centre of
    mass, and the six of the wheels' viscous friction.
    """
    turned, bias = jit(to_body), jit(body_bias)

    def law(
        k: Any, e_x: Any, e_y: Any, e_psi: Any, d_x: Any, d_y: Any, d_psi: Any,
        a_x: Any, a_y: Any, a_psi: Any, c: Any, s: Any, u: Any, v: Any, r: Any,
    ) -> Any:  # fmt: skip
        # Not in place: where arrays are read, that would write into the reference.
        a_x = a_x + (k[0] * e_x + k[3] * d_x)
        a_y = a_y + (k[1] * e_y + k[4] * d_y)
        a_r = a_psi + k[2] * e_psi + k[5] * d_psi
        a_u, a_v = turned(c, s, a_x, a_y)
        a_u, a_v = a_u + r * v, a_v - r * u  # the body frame turns
        b_x, b_y, b_z = bias(k[12], k[13], k[14], u, v, r)
        return (
            (k[6] * a_u + k[7] * a_v + k[8] * a_r) + (b_x + k[15] * u + k[16] * v + k[17] * r),
            (k[7] * a_u + k[9] * a_v + k[10] * a_r) + (b_y + k[16] * u + k[18] * v + k[19] * r),
            (k[8] * a_u + k[10] * a_v + k[11] * a_r) + (b_z + k[17] * u + k[19] * v + k[20] * r),
        )

    return law


_PLAIN: dict[Law, Function] = {
    law: law(lambda function: function) for law in (pd_law, computed_torque_law)
}


def _force(law: Law, constants: Array, measurement: Measurement, reference: Reference) -> Array:
    """Return the force (3,) in the inertial frame that a law commands."""
    rate, psi = np.asarray(measurement.rate), measurement.pose[2]
    c, s = np.cos(psi), np.sin(psi)
    u, v = to_body(c, s, rate[0], rate[1])
    X, Y, Z = _PLAIN[law](
        constants, *reference.error(measurement.pose), *(reference.velocity - rate),
        *reference.acceleration, c, s, u, v, rate[2],
    )  # fmt: skip
    return np.array([*to_inertial(c, s, X, Y), Z])


@final
@dataclass(frozen=True)
class PD:
    """Proportional-derivative control: a force towards the trajectory, without a model.

    ``F = K_p e + K_d e_dot``, e = desired minus actual pose, the heading by the shorter way.

    Args:
        kp: (3,) gains on x, y [N/m] and psi [N m/rad].
        kd: (3,) gains on their rates [N s/m, N m s/rad].

    Source: the lectures' motion control; Siciliano, Sciavicco, Villani and Oriolo, Robotics:
    Modelling, Planning and Control, 2009, section 8.5.1.

    >>> at_rest = Measurement(0.0, np.zeros(3), np.zeros(3))
    >>> ahead = Reference(np.array([0.1, 0.0, 0.0]), np.zeros(3), np.zeros(3))
    >>> force, _ = PD(kp=[120, 120, 0.4], kd=[120, 120, 0.4]).step(None, at_rest, ahead)
    >>> force.tolist()
    [12.0, 0.0, 0.0]
    """

    kp: npt.ArrayLike
    kd: npt.ArrayLike
    output: ClassVar[str] = "force"
    scalar_law: ClassVar[Law] = staticmethod(pd_law)

    def __post_init__(self) -> None:
        object.__setattr__(self, "kp", three_gains(self.kp, "kp"))
        object.__setattr__(self, "kd", three_gains(self.kd, "kd"))

    @property
    def scalar_constants(self) -> Array:
        """The law's constants."""
        return np.array([*self.kp, *self.kd])  # type: ignore[misc]

    def step(
        self, state: None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, None]:
        """Return the force (F_x, F_y, M_z) in the inertial frame; there is no memory."""
        return _force(pd_law, self.scalar_constants, measurement, reference), None


@final
@dataclass(frozen=True)
class ComputedTorque:
    """Computed torque: the force that a model needs for the acceleration wanted.

    ``F = M(q) (q_ddot_des + K_d e_dot + K_p e) + n(q, q_dot)``, with the spinning wheels' inertia
    and their viscous friction. With a true model each error obeys
    ``e_ddot + k_d e_dot + k_p e = 0`` by itself.

    Args:
        kp: (3,) gains [1/s^2].
        kd: (3,) gains [1/s]; 2 sqrt(kp) damps critically.
        model: what the controller believes of the robot; the robot itself when left out.

    Source: the lectures' motion control; Craig, Introduction to Robotics, 3rd edition, 2005,
    section 10.4.

    >>> import trundle
    >>> model = trundle.Dynamics(trundle.load("omni3").with_body(mass=30.0))
    >>> at_rest = Measurement(0.0, np.zeros(3), np.zeros(3))
    >>> ahead = Reference(np.array([0.1, 0.0, 0.0]), np.zeros(3), np.zeros(3))
    >>> law = ComputedTorque(kp=[4, 4, 4], kd=[4, 4, 4], model=model)
    >>> force, _ = law.step(None, at_rest, ahead)
    >>> force.round(9).tolist()
    [12.0, 0.0, 0.0]
    """

    kp: npt.ArrayLike
    kd: npt.ArrayLike
    model: Dynamics | None = None
    output: ClassVar[str] = "force"
    scalar_law: ClassVar[Law] = staticmethod(computed_torque_law)

    def __post_init__(self) -> None:
        object.__setattr__(self, "kp", three_gains(self.kp, "kp"))
        object.__setattr__(self, "kd", three_gains(self.kd, "kd"))
        if not isinstance(self.model, Dynamics | None):
            raise TrundleError(
                "model must be a trundle.Dynamics: write model=trundle.Dynamics(robot), got "
                f"{type(self.model).__name__}"
            )

    def with_model(self, model: Dynamics) -> ComputedTorque:
        """Return the controller with a model, if it has none of its own."""
        return self if self.model is not None else dataclasses.replace(self, model=model)

    @property
    def scalar_constants(self) -> Array:
        """The law's constants.

        Raises:
            TrundleError: the controller has no model yet.
        """
        if self.model is None:
            raise TrundleError(
                "computed torque needs a model: "
                "ComputedTorque(kp, kd, model=trundle.Dynamics(robot))"
            )
        here, upper = self.model.reduced(), np.triu_indices(3)
        viscous, _ = self.model.friction_coefficients
        D = here.G.T @ (viscous[:, None] * here.G)
        rigid = [self.model.mass, *self.model.com]
        return np.array([*self.kp, *self.kd, *here.M[upper], *rigid, *D[upper]])  # type: ignore[misc]

    def step(
        self, state: None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, None]:
        """Return the force (F_x, F_y, M_z) in the inertial frame; there is no memory.

        Raises:
            TrundleError: the controller has no model; ``track`` gives it the robot's.
        """
        return _force(computed_torque_law, self.scalar_constants, measurement, reference), None
