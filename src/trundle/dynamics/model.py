"""The dynamics of one robot: what users hold."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from trundle.dynamics.batches import together
from trundle.dynamics.friction import coefficients
from trundle.dynamics.ground import GroundForces, ground_forces
from trundle.dynamics.motors import Limits, Motors, torque_limits
from trundle.dynamics.planar import inertial_lever
from trundle.dynamics.reduced import (
    Reduced,
    apply,
    friction_of,
    reduce,
    rigid_bias,
    rolling_wheels,
)
from trundle.errors import TrundleError
from trundle.kinematics import Kinematics, finite, robot_of, steering_array
from trundle.robot import Robot, total_mass
from trundle.se2 import Array


class Dynamics:
    """Equations of motion of a robot: of its body in the plane, and of its wheels.

    Poses are (x, y, psi) and rates (x_dot, y_dot, psi_dot) in the inertial frame, twists (u, v, r)
    in the body frame, torques those of the n motors at their wheels, positive with positive wheel
    speed. Leading axes are batch.

    Args:
        robot: the robot; its body needs mass, inertia and com.

    Attributes:
        robot: the robot.
        mass: of body and wheels together [kg].
        com: (2,) their centre of mass in the body frame [m].
        inertia: about the vertical through it [kg m^2].

    Raises:
        RobotError: a value of the body is missing.

    Source: the lectures' planar base by Denavit-Hartenberg and Newton-Euler; for the wheels the
    principle of virtual work on the constraint rows, Siciliano, Sciavicco, Villani and Oriolo,
    Robotics: Modelling, Planning and Control, 2009, section 11.4.

    >>> import trundle
    >>> robot = trundle.load("omni3").with_body(mass=30.0, inertia=0.1, com=(0.0, 0.0))
    >>> Dynamics(robot).inverse_dynamics([0.0] * 3, [0.0] * 3, [1.0, 0.0, 2.0]).round(9).tolist()
    [30.0, 0.0, 0.2]
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot_of(robot)
        self.mass, self.com, self.inertia = total_mass(robot)
        self.com.setflags(write=False)
        self._wheels = rolling_wheels(robot)

    def __repr__(self) -> str:
        """Return the robot's name and its mass."""
        return f"Dynamics({self.robot.name!r}: {self.mass:g} kg)"

    # ---- the body in the inertial frame ------------------------------------------------------

    def mass_matrix(self, pose: npt.ArrayLike) -> Array:
        """Return M(q) (..., 3, 3) of body and wheels, without the wheels' spin.

        ``M = [[m, 0, -m (y_c c + x_c s)], [0, m, m (x_c c - y_c s)], [., ., I + m |com|^2]]``

        Args:
            pose: (..., 3) x, y, psi [m, m, rad].

        >>> import trundle
        >>> robot = trundle.load("omni3").with_body(mass=2.0, inertia=0.5, com=(0.5, 0.0))
        >>> Dynamics(robot).mass_matrix([0.0, 0.0, 0.0]).tolist()
        [[2.0, 0.0, -0.0], [0.0, 2.0, 1.0], [-0.0, 1.0, 1.0]]
        """
        psi = finite(pose, "pose", 3)[..., 2]
        lever_x, lever_y = self._lever(psi)
        out = np.zeros((*psi.shape, 3, 3))
        out[..., 0, 0] = out[..., 1, 1] = self.mass
        out[..., 0, 2] = out[..., 2, 0] = lever_x
        out[..., 1, 2] = out[..., 2, 1] = lever_y
        out[..., 2, 2] = self.inertia + self.mass * (self.com @ self.com)
        return out

    def bias(self, pose: npt.ArrayLike, rate: npt.ArrayLike) -> Array:
        """Return n(q, q_dot) (..., 3) of ``M q_ddot + n = (F_x, F_y, M_z)`` [N, N, N m].

        ``n = -m psi_dot^2 (x_c c - y_c s, y_c c + x_c s, 0)``

        >>> import trundle
        >>> robot = trundle.load("omni3").with_body(mass=2.0, inertia=0.5, com=(0.5, 0.0))
        >>> Dynamics(robot).bias([0.0, 0.0, 0.0], [0.0, 0.0, 3.0]).tolist()
        [-9.0, -0.0, 0.0]
        """
        pose, rate = finite(pose, "pose", 3), finite(rate, "rate", 3)
        together({"pose": pose, "rate": rate})
        psi, turn = pose[..., 2], rate[..., 2]
        lever_x, lever_y = self._lever(psi)
        square = turn * turn
        return np.stack([-square * lever_y, square * lever_x, np.zeros_like(square)], axis=-1)

    def inverse_dynamics(
        self, pose: npt.ArrayLike, rate: npt.ArrayLike, acceleration: npt.ArrayLike
    ) -> Array:
        """Return the forces (F_x, F_y, M_z) (..., 3) that an acceleration (..., 3) takes.

        ``M(q) q_ddot + n(q, q_dot)``, in the inertial frame and about the body's origin.
        """
        M, n = self.mass_matrix(pose), self.bias(pose, rate)
        wanted = finite(acceleration, "acceleration", 3)
        together({"pose and rate": n, "acceleration": wanted})
        return apply(M, wanted) + n

    def forward_dynamics(
        self, pose: npt.ArrayLike, rate: npt.ArrayLike, force: npt.ArrayLike
    ) -> Array:
        """Return the acceleration (..., 3) that forces (F_x, F_y, M_z) (..., 3) cause.

        ``M(q)^-1 (F - n(q, q_dot))``, of a body that nothing else holds.

        >>> import trundle
        >>> model = Dynamics(trundle.load("omni3"))
        >>> pose, rate, wanted = [0.0, 0.0, 0.3], [0.1, 0.0, 2.0], [1.0, -2.0, 0.5]
        >>> model.forward_dynamics(pose, rate, model.inverse_dynamics(pose, rate, wanted)).round(9)
        array([ 1. , -2. ,  0.5])
        """
        M, n = self.mass_matrix(pose), self.bias(pose, rate)
        given = finite(force, "force", 3)
        together({"pose and rate": n, "force": given})
        net = given - n
        return np.asarray(np.linalg.solve(M, net[..., None])[..., 0])

    # ---- the wheels --------------------------------------------------------------------------

    @property
    def wheel_mass_matrix(self) -> Array:
        """The matrix M_w (n, n) of ``M_w omega_dot + c_w(omega) = tau`` [kg m^2].

        ``M_w = W^T M W + J``: by virtual work the body's mass and that of free wheels as the
        driven wheels feel it, and their own inertia J.

        Raises:
            TrundleError: the robot steers, or has a motion that no motor drives: use ``torques``
                and ``twist_acceleration``.

        >>> import trundle
        >>> body = {"mass": 30.0, "inertia": 0.1, "com": (0.0, 0.0)}
        >>> model = Dynamics(trundle.load("differential", radius=0.1).with_body(**body))
        >>> model.wheel_mass_matrix.round(6).tolist()  # m a^2 / 4 +- I a^2 / track^2
        [[0.08125, 0.06875], [0.06875, 0.08125]]
        """
        here, W = self._reduced, self._W
        return np.asarray(W.T @ here.M_free @ W + np.diag(here.spin[here.driven]))

    def wheel_bias(self, wheel_speeds: npt.ArrayLike) -> Array:
        """Return c_w(omega) (..., n) [N m]: Coriolis torques, and the friction of all wheels.

        ``c_w = W^T (c(zeta) + G_f^T friction_f) + friction_d`` at zeta = W omega, with f the free
        and d the driven wheels.

        Raises:
            TrundleError: the robot steers, or has a motion that no motor drives.
        """
        omega = finite(wheel_speeds, "wheel_speeds", len(self.robot.driven))
        here, W = self._reduced, self._W
        twist = omega @ W.T
        friction = friction_of(self._wheels, twist @ here.G.T)
        own = friction_of(self.robot.driven, omega)
        passive = np.where(here.driven, 0.0, friction)
        return np.asarray((rigid_bias(self.mass, self.com, twist) + passive @ here.G) @ W + own)

    def wheel_acceleration(self, wheel_speeds: npt.ArrayLike, torques: npt.ArrayLike) -> Array:
        """Return omega_dot (..., n) [rad/s^2] for torques (..., n) [N m].

        All wheels keep to one motion of the body: where there are more driven wheels than
        motions, torques that only work against each other accelerate nothing.

        Raises:
            TrundleError: the robot steers, or has a motion that no motor drives.

        >>> import trundle
        >>> robot = trundle.load("mecanum", radius=0.1).with_body(mass=40.0)
        >>> model = Dynamics(robot)
        >>> model.wheel_acceleration([0.0] * 4, [1.0, 1.0, 1.0, 1.0]).round(6).tolist()
        [10.0, 10.0, 10.0, 10.0]
        >>> model.wheel_acceleration([0.0] * 4, [1.0, 1.0, -1.0, -1.0]).round(6).any()
        np.False_
        """
        omega = finite(wheel_speeds, "wheel_speeds", len(self.robot.driven))
        here = self._reduced
        acceleration = self.twist_acceleration(omega @ self._W.T, torques)
        return np.asarray(acceleration @ here.G[here.driven].T)

    # ---- twists and torques, at any steering -------------------------------------------------

    def reduced(
        self, steering: npt.ArrayLike | None = None, steering_rate: npt.ArrayLike | None = None
    ) -> Reduced:
        """Return the matrices of the equations of motion on the twists that the wheels allow.

        Args:
            steering: (..., s) steering angles [rad].
            steering_rate: (..., s) their rates [rad/s], such that the wheels keep a common
                centre; zero when left out.

        Raises:
            OffCentreError: the angles share no instantaneous centre.

        >>> import trundle
        >>> model = Dynamics(trundle.load("differential").with_body(mass=20.0))
        >>> model.reduced().inverse()[0, 0].round(12)  # 1 / mass
        np.float64(0.05)
        """
        angles = steering_array(self.robot, steering)
        rate = np.zeros(len(self.robot.steered))
        if steering_rate is not None:
            rate = finite(steering_rate, "steering_rate", len(rate))
            together({"steering": angles, "steering_rate": rate})
        if not self.robot.steered:
            return self._straight
        self._kinematics.wheel_matrix(angles)  # refuses angles that share no centre
        return reduce(self.robot, angles, rate)

    def twist_acceleration(
        self,
        twist: npt.ArrayLike,
        torques: npt.ArrayLike,
        steering: npt.ArrayLike | None = None,
        steering_rate: npt.ArrayLike | None = None,
    ) -> Array:
        """Return (u_dot, v_dot, r_dot) (..., 3) of the reduced dynamics.

        ``N (N^T M N)^-1 N^T (G_d^T tau - c)``, and what turning the wheels adds.

        Args:
            twist: (..., 3) u, v, r, what the wheels do not allow is left out [m/s, m/s, rad/s].
            torques: (..., n) of the motors at the driven wheels [N m].
            steering: (..., s) steering angles [rad].
            steering_rate: (..., s) their rates [rad/s]; zero when left out.

        >>> import trundle
        >>> model = Dynamics(trundle.load("differential").with_body(mass=20.0))
        >>> model.twist_acceleration([0.0, 0.0, 0.0], [0.5, 0.5]).round(12).tolist()  # 20 N, 20 kg
        [1.0, 0.0, 0.0]
        """
        zeta, tau, here = self._given(twist, torques, "torques", steering, steering_rate)
        turning = apply(here.turn, zeta)
        net = here.push(tau) - self._bias(here, zeta) - apply(here.M, turning)
        return apply(here.inverse(), net) + turning

    def torques(
        self,
        twist: npt.ArrayLike,
        acceleration: npt.ArrayLike,
        steering: npt.ArrayLike | None = None,
        steering_rate: npt.ArrayLike | None = None,
    ) -> Array:
        """Return the motors' torques (..., n) [N m] of least norm for an acceleration (..., 3).

        ``tau = (N^T G_d^T)^+ N^T (M zeta_dot + c)``. What the wheels do not allow is left out, and
        where the motors cannot push every way, they give what is nearest in kinetic energy;
        ``twist_acceleration`` of the torques shows it.

        Args:
            twist: (..., 3) u, v, r [m/s, m/s, rad/s].
            acceleration: (..., 3) u_dot, v_dot, r_dot [m/s^2, m/s^2, rad/s^2].
            steering: (..., s) steering angles [rad].
            steering_rate: (..., s) their rates [rad/s].

        Source: the lectures' tau_w = W^T F_B, which is the same for wheels of one radius that
        neither spin nor rub.

        >>> import trundle
        >>> model = Dynamics(trundle.load("differential").with_body(mass=20.0))
        >>> model.torques([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]).round(12).tolist()
        [0.5, 0.5]
        """
        zeta, wanted, here = self._given(
            twist, acceleration, "acceleration", steering, steering_rate, 3
        )
        turning = apply(here.turn, zeta)
        possible = turning + apply(here.allowed, wanted - turning)
        return apply(here.allocation(), apply(here.M, possible) + self._bias(here, zeta))

    def ground_forces(
        self,
        twist: npt.ArrayLike,
        torques: npt.ArrayLike,
        steering: npt.ArrayLike | None = None,
        steering_rate: npt.ArrayLike | None = None,
    ) -> GroundForces:
        """Return the ground's forces on the wheels: what pushes the body and what holds it.

        The side forces are the Lagrange multipliers of ``C zeta = 0``; where the wheels share
        them in more than one way (two wheels on one axle), those of least norm.

        Args:
            twist: (..., 3) u, v, r, what the wheels do not allow is left out [m/s, m/s, rad/s].
            torques: (..., n) of the motors [N m].
            steering: (..., s) steering angles [rad].
            steering_rate: (..., s) their rates [rad/s].

        >>> import trundle
        >>> bike = trundle.load("bicycle").with_body(mass=80.0, com=(0.5, 0.0))
        >>> forces = Dynamics(bike).ground_forces([4.0, 0.0, 0.0], [0.0], [0.0])
        >>> forces.load.round(3).tolist(), forces.friction.round(12).tolist()
        ([392.266, 392.266], [0.0, 0.0])
        """
        zeta, tau, here = self._given(twist, torques, "torques", steering, steering_rate)
        acceleration = self.twist_acceleration(twist, torques, steering, steering_rate)
        speed_rate = apply(here.G, acceleration)
        friction = friction_of(self._wheels, apply(here.G, zeta))
        motor = np.zeros(np.broadcast_shapes(friction.shape, (*tau.shape[:-1], 1)))
        motor[..., here.driven] = tau
        net = apply(here.M, acceleration) + self._bias(here, zeta) - here.push(tau)
        return ground_forces(self.robot, here, speed_rate, motor - friction, net)

    def friction_torque(self, wheel_speeds: npt.ArrayLike) -> Array:
        """Return the friction torques (..., n) of the driven wheels, motors included [N m]."""
        omega = finite(wheel_speeds, "wheel_speeds", len(self.robot.driven))
        return friction_of(self.robot.driven, omega)

    @property
    def friction_coefficients(self) -> tuple[Array, Array]:
        """Viscous [N m s/rad] and Coulomb [N m] friction (w,) of all wheels that roll, in order."""
        return coefficients(self._wheels)

    def kinetic_energy(self, twist: npt.ArrayLike, steering: npt.ArrayLike | None = None) -> Array:
        """Return the kinetic energy (...) of body and spinning wheels at twists (..., 3) [J].

        ``zeta^T M zeta / 2``. Together with the motors' work and the friction's it balances.
        """
        zeta = finite(twist, "twist", 3)
        together({"twist": zeta, "steering": steering_array(self.robot, steering)})
        here = self.reduced(steering)
        return np.asarray(0.5 * (zeta * apply(here.M, zeta)).sum(axis=-1))

    # ---- motors ------------------------------------------------------------------------------

    @cached_property
    def torque_limits(self) -> Limits:
        """What the motors can give, from ``max_torque`` and from voltage and current."""
        return torque_limits(self.robot)

    @cached_property
    def motors(self) -> Motors:
        """The DC motors of the driven wheels: torques from voltages and back.

        Raises:
            TrundleError: a driven wheel has no motor.
        """
        return Motors(self.robot)

    # ---- what the methods above share --------------------------------------------------------

    def _lever(self, psi: Array) -> tuple[Array, Array]:
        return inertial_lever(self.mass, self.com[0], self.com[1], np.cos(psi), np.sin(psi))

    @cached_property
    def _straight(self) -> Reduced:
        return reduce(self.robot, np.zeros(0), np.zeros(0))

    @property
    def _reduced(self) -> Reduced:
        """The reduced equations of a robot that does not steer.

        Raises:
            TrundleError: it steers.
        """
        if self.robot.steered:
            raise TrundleError(
                f"robot {self.robot.name!r} steers, so these matrices depend on its angles: use "
                "torques(), twist_acceleration() and ground_forces() with steering=..."
            )
        driven = np.linalg.matrix_rank(self._straight.allocation())
        if driven < (allowed := round(float(np.trace(self._straight.allowed)))):
            raise TrundleError(
                f"robot {self.robot.name!r}: its driven wheels push {driven} of the {allowed} "
                "motions that it has, so they do not tell how it moves: use torques() and "
                "twist_acceleration()"
            )
        return self._straight

    @cached_property
    def _kinematics(self) -> Kinematics:
        return Kinematics(self.robot)

    @property
    def _W(self) -> Array:
        return self._kinematics.W

    def _given(
        self,
        twist: npt.ArrayLike,
        other: npt.ArrayLike,
        name: str,
        steering: npt.ArrayLike | None,
        steering_rate: npt.ArrayLike | None,
        last: int | None = None,
    ) -> tuple[Array, Array, Reduced]:
        """Return twist and the other quantity as arrays, and the equations that go with them."""
        zeta = finite(twist, "twist", 3)
        values = finite(other, name, len(self.robot.driven) if last is None else last)
        here = self.reduced(steering, steering_rate)
        given = {"twist": zeta, name: values}
        if self.robot.steered:
            given["steering"] = here.allowed[..., 0]
        batch = together(given)
        # What would slip sideways is rounding, or a step of an integrator: it is left out.
        return apply(here.allowed, zeta), np.broadcast_to(values, (*batch, values.shape[-1])), here

    def _bias(self, here: Reduced, zeta: Array) -> Array:
        friction = friction_of(self._wheels, apply(here.G, zeta))
        return here.bias(rigid_bias(self.mass, self.com, zeta), friction)
