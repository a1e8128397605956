"""The kinematics of one robot: what users hold."""

from __future__ import annotations

import warnings
from functools import cached_property

import numpy as np
import numpy.typing as npt

from trundle.errors import (
    OffCentreError,
    ShapeError,
    TrundleError,
    UnobservedMotionError,
    UnobservedMotionWarning,
)
from trundle.kinematics.centre import off_centre_words, share_centre
from trundle.kinematics.constraints import (
    finite,
    gains,
    robot_of,
    rolling_matrix,
    side_slip_matrix,
    steering_array,
)
from trundle.kinematics.inverse import Inverse, InverseSolver
from trundle.kinematics.linear import RANK_TOLERANCE, basis
from trundle.kinematics.maps import estimator, wheel_matrix
from trundle.kinematics.plain import Plain, bind
from trundle.kinematics.words import join, motions_in_words
from trundle.robot import Robot
from trundle.se2 import Array


class Kinematics:
    """Forward and inverse kinematics of a robot, between wheel speeds and the body's twist.

    Twists are (u, v, r): forward and lateral velocity of the body's origin and yaw rate, in the
    body frame [m/s, m/s, rad/s]. Wheel speeds are the motors' [rad/s], driven wheels in order;
    steering angles [rad] are in the order of the steered wheels. Leading axes are batch.

    Args:
        robot: the robot.

    Source: the constraint rows of ``trundle.robot.Wheel.rows``, stacked as in Siegwart and
    Nourbakhsh, Introduction to Autonomous Mobile Robots, 2004, section 3.2.4.

    >>> from trundle import load
    >>> kin = Kinematics(load("omni3"))
    >>> kin.inverse([0.0, 0.5, 0.0]).wheel_speeds.round(12).tolist()
    [2.5, -1.25, -1.25]
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot_of(robot)
        self._gains = gains(robot.driven)
        if not robot.steered:
            none = np.zeros(0)
            self._W = wheel_matrix(robot, none)[0]
            self._W.setflags(write=False)
            self._estimator, self._unobserved = estimator(robot, robot.driven, none)

    def __repr__(self) -> str:
        """Return the robot's name and how many wheels drive it."""
        return f"Kinematics({self.robot.name!r}: {len(self.robot.driven)} driven wheels)"

    @cached_property
    def _solver(self) -> InverseSolver:
        return InverseSolver(self.robot)

    @property
    def feasible(self) -> Array:
        """The map (3, 3) from a twist to the nearest one that some steering allows.

        >>> from trundle import load
        >>> Kinematics(load("differential")).feasible.round(12).tolist()
        [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        """
        return self._solver.feasible

    @property
    def W(self) -> Array:
        """The wheel configuration matrix (3, n): twist = W @ wheel_speeds.

        ``W = N (A N)^+ R``: the side-slip rows of all wheels hold exactly, the rolling rows of
        the driven wheels in the least-squares sense.

        Raises:
            TrundleError: the robot steers, so W depends on the angles: use ``wheel_matrix``.
        """
        if self.robot.steered:
            names = join([wheel.name for wheel in self.robot.steered])
            raise TrundleError(
                f"robot {self.robot.name!r} steers, so W depends on its steering angles: call "
                f"wheel_matrix(steering) with the angles of {names} [rad]"
            )
        return self._W

    def wheel_matrix(self, steering: npt.ArrayLike | None = None) -> Array:
        """Return W (..., 3, n) at steering angles (..., s) [rad].

        Raises:
            OffCentreError: the angles share no instantaneous centre; the nearest that do are told.

        >>> from trundle import load
        >>> W = Kinematics(load("tricycle", radius=0.1)).wheel_matrix([0.0])
        >>> bool(np.allclose(W, [[0.1], [0.0], [0.0]]))
        True
        """
        angles = steering_array(self.robot, steering)
        if not self.robot.steered:
            return np.broadcast_to(self._W, (*angles.shape[:-1], *self._W.shape))
        if not (together := share_centre(self.robot, angles)).all():
            first = np.argwhere(~together)[0]
            raise OffCentreError(off_centre_words(self.robot, angles[tuple(first)]))
        return wheel_matrix(self.robot, angles)[0]

    def constraints(self, steering: npt.ArrayLike | None = None) -> tuple[Array, Array, Array]:
        """Return A (..., n, 3), the diagonal of R (n,) and C (..., m, 3).

        ``A zeta = R omega`` for the driven wheels, and ``C zeta = 0`` for all wheels that resist
        side slip, in the order of the wheels.

        >>> from trundle import load
        >>> A, R, C = Kinematics(load("differential", radius=0.05, track=0.4)).constraints()
        >>> A.tolist(), R.tolist()
        ([[1.0, 0.0, -0.2], [1.0, 0.0, 0.2]], [0.05, 0.05])
        """
        angles = steering_array(self.robot, steering)
        return (
            rolling_matrix(self.robot, self.robot.driven, angles),
            self._gains,
            side_slip_matrix(self.robot, self.robot.wheels, angles),
        )

    def forward(self, wheel_speeds: npt.ArrayLike, steering: npt.ArrayLike | None = None) -> Array:
        """Return the twist (..., 3) that wheel speeds (..., n) [rad/s] and angles (..., s) tell.

        Least squares in rim speeds [m/s], with the rows as they stand in A and R. Fixed wheels'
        side-slip rows hold exactly; a steered wheel's rows enter with weight 1, since its angle
        is measured with error. Warns where the wheels do not observe every motion.

        >>> from trundle import load
        >>> round(float(Kinematics(load("omni3")).forward([0.5, 0.5, 0.5])[2]), 6)
        0.333333
        """
        speeds = finite(wheel_speeds, "wheel_speeds", len(self.robot.driven))
        twist, unobserved = self._estimate(speeds, steering)
        blind = np.trace(unobserved, axis1=-2, axis2=-1) > 0.5
        if blind.any():
            first = unobserved[tuple(np.argwhere(blind)[0])]
            warnings.warn(
                f"robot {self.robot.name!r}: the driven wheels do not observe "
                f"{join(motions_in_words(basis(first))) or 'every motion'}; it is taken as zero",
                UnobservedMotionWarning,
                stacklevel=2,
            )
        return twist

    def residual(self, wheel_speeds: npt.ArrayLike, steering: npt.ArrayLike | None = None) -> Array:
        """Return the mismatch (..., n) [m/s] of each wheel with the twist that fits best.

        ``R omega - A zeta`` with zeta from ``forward``, rim speeds along the direction in which
        the wheel is held (a Swedish wheel's roller axis): zero where all wheels agree; slip, or a
        broken encoder, where not.

        >>> from trundle import load
        >>> kin = Kinematics(load("skid_steer", radius=0.1))
        >>> (kin.residual([1.0, 1.0, 1.0, 2.0]).round(6) + 0.0).tolist()  # rear_right is too fast
        [0.0, -0.05, 0.0, 0.05]
        """
        speeds = finite(wheel_speeds, "wheel_speeds", len(self.robot.driven))
        twist, _ = self._estimate(speeds, steering)
        angles = steering_array(self.robot, steering)
        rolling = rolling_matrix(self.robot, self.robot.driven, angles)
        rim = self._gains * speeds
        return np.asarray(rim - (rolling @ twist[..., None])[..., 0])

    def odometry_matrix(self, steering: npt.ArrayLike | None = None) -> Array:
        """Return the map (..., 3, k) from increments [rad] of the k sensed wheels to the body's.

        The same least squares as ``forward``, with the sensed wheels in place of the driven ones.

        Raises:
            UnobservedMotionError: too few wheels are sensed; the unobserved motion is named.

        >>> from trundle import load
        >>> Kinematics(load("mixed")).odometry_matrix().shape  # two driven and two dead wheels
        (3, 4)
        """
        angles = steering_array(self.robot, steering)
        to_increment, unobserved = estimator(self.robot, self.robot.sensed, angles)
        blind = np.trace(unobserved, axis1=-2, axis2=-1) > 0.5
        if blind.any():
            first = unobserved[tuple(np.argwhere(blind)[0])]
            names = join([repr(wheel.name) for wheel in self.robot.sensed]) or "none"
            raise UnobservedMotionError(
                f"robot {self.robot.name!r}: the sensed wheels ({names}) do not observe "
                f"{join(motions_in_words(basis(first)))}; add an encoder to a wheel that turns "
                "with it"
            )
        return to_increment

    def rolling_speeds(
        self, twist: npt.ArrayLike, steering: npt.ArrayLike | None = None, sensed: bool = False
    ) -> Array:
        """Return how fast the driven (or the sensed) wheels roll along at a twist [rad/s].

        ``R^-1 A zeta``, whether or not the twist is feasible: (..., 3) gives (..., n).

        >>> from trundle import load
        >>> Kinematics(load("differential", radius=0.05)).rolling_speeds([0.1, 0.0, 0.0]).tolist()
        [2.0, 2.0]
        """
        twist = finite(twist, "twist", 3)
        angles = steering_array(self.robot, steering, twist.shape[:-1])
        wheels = self.robot.sensed if sensed else self.robot.driven
        rolling = rolling_matrix(self.robot, wheels, angles)
        rim = (rolling @ twist[..., None])[..., 0]
        return np.asarray(rim / gains(wheels))

    def _estimate(self, speeds: Array, steering: npt.ArrayLike | None) -> tuple[Array, Array]:
        """Return the twist and the projector onto the motions that are not observed."""
        angles = steering_array(self.robot, steering, speeds.shape[:-1])
        if self.robot.steered:
            to_twist, unobserved = estimator(self.robot, self.robot.driven, angles)
        else:
            to_twist, unobserved = self._estimator, self._unobserved
        return np.asarray((to_twist @ speeds[..., None])[..., 0]), unobserved

    def inverse(
        self,
        twist: npt.ArrayLike,
        about: npt.ArrayLike = (0.0, 0.0),
        steering: npt.ArrayLike | None = None,
        strict: bool = False,
        limit: bool = True,
    ) -> Inverse:
        """Return the wheel speeds and steering angles for a twist.

        Args:
            twist: (..., 3) twist asked; u and v are the velocity of the body point ``about``.
            about: (2,) body point [m].
            steering: (..., s) present steering angles [rad]. Each wheel then takes the nearer of
                its angle and the half-turn flip, and holds its angle at standstill; without them
                the angle is that of the wheel's velocity.
            strict: raise where the twist cannot be met, instead of giving the nearest.
            limit: keep steering limits, and scale the whole twist where a wheel would exceed its
                ``max_speed``, so that the path keeps its curvature.

        Returns:
            ``wheel_speeds`` (..., n), ``steering`` (..., s), ``twist`` (..., 3) given and
            ``residual`` (..., 3), the twist asked minus the twist given.

        Raises:
            InfeasibleTwistError: with ``strict``, where the residual is not zero.

        >>> from trundle import load
        >>> kin = Kinematics(load("differential", radius=0.05, track=0.4))
        >>> kin.inverse([0.1, 0.2, 0.0]).residual.round(12).tolist()
        [0.0, 0.2, 0.0]
        """
        return self._solver.solve(twist, about, steering, strict, limit)

    def steady_steering(self, twist: npt.ArrayLike) -> Array:
        """Return steering angles (T, s) [rad] along feasible twists (T, 3) in order of time.

        Each wheel takes the nearer of its angle and the half-turn flip to where it stood before,
        within its limits, and holds its angle at standstill.

        >>> from trundle import load
        >>> kin = Kinematics(load("tricycle"))
        >>> kin.steady_steering([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]).tolist()
        [[0.0], [0.0], [0.0]]
        """
        along = finite(twist, "twist", 3)
        if along.ndim != 2:
            raise ShapeError(f"twist must have shape (T, 3), got {along.shape}")
        return self._solver.follow(along)

    def left_inverse(self, steering: npt.ArrayLike | None = None) -> Array:
        """Return (W^T W)^-1 W^T (..., n, 3), the lectures' inverse for fewer than 3 wheels.

        Raises:
            TrundleError: W^T W is singular: the columns of W are not independent.

        >>> from trundle import load
        >>> kin = Kinematics(load("differential"))
        >>> bool(np.allclose(kin.left_inverse() @ kin.W, np.eye(2)))
        True
        """
        W = self.wheel_matrix(steering)
        rank, n = np.linalg.matrix_rank(W, tol=RANK_TOLERANCE).min(), W.shape[-1]
        if rank < n:
            raise TrundleError(
                f"the left inverse needs rank W = n, but W has rank {rank} and n = {n} wheels"
            )
        transposed = np.swapaxes(W, -1, -2)
        return np.asarray(np.linalg.solve(transposed @ W, transposed))

    def right_inverse(self, steering: npt.ArrayLike | None = None) -> Array:
        """Return W^T (W W^T)^-1 (..., n, 3), the lectures' inverse for more than 3 wheels.

        Raises:
            TrundleError: W W^T is singular: the wheels do not give every twist.

        >>> from trundle import load
        >>> Kinematics(load("mecanum")).right_inverse().shape
        (4, 3)
        """
        W = self.wheel_matrix(steering)
        rank = np.linalg.matrix_rank(W, tol=RANK_TOLERANCE).min()
        if rank < 3:
            raise TrundleError(
                f"the right inverse needs rank W = 3, but W has rank {rank}: the wheels do not "
                "give every twist"
            )
        transposed = np.swapaxes(W, -1, -2)
        return np.asarray(np.swapaxes(np.linalg.solve(W @ transposed, W), -1, -2))

    def bind(self) -> Plain:
        """Return the same maps as plain functions of floats, for control loops.

        ``inverse(u, v, r)`` gives n wheel speeds, then s angles; ``forward(*wheel_speeds,
        *steering)`` gives (u, v, r); ``step(x, y, psi, *wheel_increments, *steering)`` gives the
        next (x, y, psi). No limits and no checks.

        >>> from trundle import load
        >>> plain = Kinematics(load("omni3")).bind()
        >>> [round(w, 12) for w in plain.inverse(0.0, 0.5, 0.0)]
        [2.5, -1.25, -1.25]
        """
        return bind(self.robot, self._solver)
