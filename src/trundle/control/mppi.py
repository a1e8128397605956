"""Model predictive path integral control: the best of many futures, at every tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any, ClassVar, NamedTuple, final

import numpy as np
import numpy.typing as npt

from trundle.control.goal import GoalCost, goal_parameters
from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite, robot_of
from trundle.robot import Robot
from trundle.se2 import Array, chain
from trundle.simulation import (
    CostSum,
    Measurement,
    PreparedRollout,
    Reference,
    Stream,
    TwistSampler,
    compile_rollout,
    rollout,
)

# So many temperatures dearer than the best, a sample's share is 1e-304; exp is a normal number yet.
_NOTHING = 700.0


class Plan(NamedTuple):
    """What MPPI remembers from tick to tick.

    Attributes:
        twists: (T, 3) planned twists (u, v, r) in the body frame [m/s, m/s, rad/s].
        tick: how many plans came before.
        t: time at which the plan begins [s].
    """

    twists: Array
    tick: int
    t: float


class Foresight(NamedTuple):
    """The futures of one tick.

    Attributes:
        poses: (K, T + 1, 3) where each sample goes.
        twists: (K, T, 3) its commands, as the wheels allow them.
        cost: (K,) what it costs.
        weights: (K,) its share in the plan; they add up to 1.
        plan: the new plan.
        path: (T + 1, 3) where the plan goes.
    """

    poses: Array
    twists: Array
    cost: Array
    weights: Array
    plan: Plan
    path: Array


class _Prepared(NamedTuple):
    """What is made once of a controller's choices."""

    sampler: TwistSampler
    rollout: PreparedRollout
    spare: list[npt.NDArray[Any]]  # rooms for samples: fresh memory costs as much as filling it


@final
@dataclass(frozen=True, eq=False)
class MPPI:
    """Model predictive path integral control: many futures are tried, the cheap ones averaged.

    Around the plan U of the last tick, K sequences of twists V_k = U + E_k are drawn, with normal
    noise of covariance Sigma that is held over h steps each, and brought to what the wheels can do:
    projected on the twists that they allow, bent no more than steering limits permit, and scaled
    where a wheel would turn too fast. With the cost c of where they lead, ::

        S_k = sum_t c(t, pose, twist) + lambda / h sum_t u_t^T Sigma^-1 (v_kt - u_t)
        w_k = exp(-(S_k - min S) / lambda) / sum_j exp(-(S_j - min S) / lambda)
        U   = sum_k w_k V_k

    The first twist is the command; the next plan begins where time has come to. The second sum is
    the derivation's price of effort: lambda / (2 h) u^T Sigma^-1 u in each step. In the sources
    h = 1; noise that is held reaches further with the same deviation, and gives smoother plans.

    Without ``cost`` it is the distance to the reference, which moves on at its velocity over the
    horizon, and the nearness of circles: ``w_x e_x^2 + w_y e_y^2 + 2 w_psi (1 - cos e_psi)``, and
    for each circle ``w_near n^2``. With d from its centre, R = radius + clearance, ::

        n = max(0, (R ^ 2 - d ^ 2) / (R ^ 2 - radius ^ 2))

    falls from 1 at its edge to 0 at the clearance; inside of the circle n^2 counts as 100. These
    costs are taken from where the robot is, so that "float32" holds on maps of any size.

    Args:
        robot: the robot.
        cost: in place of that, a function (t, pose, command, parameters) -> number as in
            ``CostSum``; t counts from the tick, and the parameters are the reference's position
            and velocity (6), then one's own. It is given positions in the inertial frame as they
            are: far from the origin, a kilometre or more, take "float64".
        samples: K.
        horizon: T, how many steps each looks ahead.
        dt: length of these steps [s].
        temperature: lambda, in the unit of the costs: low ones follow the best samples, high ones
            the average.
        sigma: (3,) standard deviations of u, v and r [m/s, m/s, rad/s].
        weights: (3,) w_x, w_y [1/m^2] and w_psi.
        obstacles: (k, 3) circles: centre x, y and radius [m], in the inertial frame.
        clearance: how near a circle the robot's origin may come for nothing [m].
        near: w_near.
        parameters: (k,) of one's own cost.
        max_twist: (3,) largest u, v, r [m/s, m/s, rad/s], beside the limits of the wheels.
        hold: h, over how many steps noise is held.
        seed: of the noise, below 2^64; the same seed gives the same commands on any number of
            threads.
        dtype: "float32" or "float64", of the rollouts.
        device: "cpu", "numpy", or "auto".

    Raises:
        TrundleError: something does not fit; the message says what.

    Wheels without ``max_speed`` set no limit: then ``max_twist`` should.

    Source: Williams, Aldrich and Theodorou, Model predictive path integral control: from theory to
    parallel computation, Journal of Guidance, Control, and Dynamics 40(2), 2017; in this form
    Williams, Wagener, Goldfain, Drews, Rehg, Boots and Theodorou, Information theoretic MPC for
    model-based reinforcement learning, ICRA 2017, algorithm 2.

    >>> import trundle
    >>> law = MPPI(trundle.load("omni3"), samples=256, horizon=20, device="numpy")
    >>> here = Measurement(0.0, np.zeros(3), np.zeros(3))
    >>> ahead = Reference(np.array([2.0, 0.0, 0.0]), np.zeros(3), np.zeros(3))
    >>> twist, plan = law.step(None, here, ahead)
    >>> bool(twist[0] > 0.05), plan.twists.shape
    (True, (20, 3))
    """

    robot: Robot
    cost: Callable[..., Any] | None = None
    samples: int = 2000
    horizon: int = 56
    dt: float = 0.05
    temperature: float = 1.0
    sigma: npt.ArrayLike = (0.5, 0.5, 1.0)
    weights: npt.ArrayLike = (1.0, 1.0, 0.2)
    obstacles: npt.ArrayLike = ()
    clearance: float = 0.3
    near: float = 10.0
    parameters: npt.ArrayLike = ()
    max_twist: npt.ArrayLike | None = None
    hold: int = 8
    seed: int = 0
    dtype: str = "float32"
    device: str = "auto"
    _prepared: _Prepared = field(init=False, repr=False)
    output: ClassVar[str] = "twist"

    def __post_init__(self) -> None:
        robot_of(self.robot)
        for name in ("samples", "horizon", "hold"):
            _whole(getattr(self, name), name, 1)
        _whole(self.seed, "seed", 0)
        if self.seed >= 2**64:
            raise TrundleError(f"seed must be below 2**64, got {self.seed}")
        for name in ("dt", "temperature", "clearance", "near"):
            _positive(getattr(self, name), name)
        numbers = {
            "sigma": _three(self.sigma, "sigma", least=0.0),
            "weights": _three(self.weights, "weights", least=0.0),
            "obstacles": _circles(self.obstacles),
            "parameters": _row(self.parameters),
        }
        if not numbers["sigma"].any():
            raise TrundleError("sigma must not be zero throughout: nothing would be tried")
        if self.max_twist is not None:
            numbers["max_twist"] = _three(self.max_twist, "max_twist", least=None)
        for name, values in numbers.items():
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.cost is None and numbers["parameters"].size:
            raise TrundleError("parameters belong to a cost of one's own: give cost, too")
        if self.cost is not None and numbers["obstacles"].size:
            raise TrundleError("obstacles belong to the default cost: yours takes parameters")
        object.__setattr__(self, "_prepared", self._prepare())

    def step(
        self, state: Plan | None, measurement: Measurement, reference: Reference
    ) -> tuple[Array, Plan]:
        """Return the twist (u, v, r) in the body frame, and the plan.

        Raises:
            TrundleError: what is measured or wanted is not finite, or a cost; or the state is that
                of another horizon.
        """
        spare = self._prepared.spare
        room = spare.pop() if spare else self._room()
        _, plan = self._choose(room, state, measurement, reference)
        spare.append(room)
        return plan.twists[0], plan

    def foresee(
        self, state: Plan | None, measurement: Measurement, reference: Reference
    ) -> Foresight:
        """Return what a step looks at, for pictures: all samples, their weights, and the plan.

        >>> import trundle
        >>> law = MPPI(trundle.load("omni3"), samples=100, horizon=20, device="numpy")
        >>> here = Measurement(0.0, np.zeros(3), np.zeros(3))
        >>> ahead = Reference(np.array([2.0, 0.0, 0.0]), np.zeros(3), np.zeros(3))
        >>> law.foresee(None, here, ahead).poses.shape
        (100, 21, 3)
        """
        room = self._room()
        (cost, weights), plan = self._choose(room, state, measurement, reference)
        pose = np.asarray(measurement.pose, dtype=np.float64)
        ways = rollout(
            self.robot, Stream.wheels_first(twist=room), dt=self.dt, pose=pose, save="trajectory",
            device="numpy",
        )  # fmt: skip
        path = chain(self.dt * plan.twists, pose)
        poses, twists = ways.pose.swapaxes(0, 1), room.transpose(2, 0, 1)
        return Foresight(poses, twists, cost, weights, plan, path)

    def _choose(
        self, room: Any, state: Plan | None, measurement: Measurement, reference: Reference
    ) -> tuple[tuple[Array, Array], Plan]:
        """Fill the room (T, 3, K) with samples; return costs and weights (K,), and the plan."""
        (now, pose), prepared = _measured(measurement), self._prepared
        twists, tick = self._go_on(state, now)
        seed = int(self.seed)
        prepared.sampler.fill(room, twists, self.sigma, hold=self.hold, seed=seed, stream=tick)
        # Seen from the robot, so that floats have no large coordinates to be rounded at.
        origin = np.array([*pose[:2], 0.0]) if self.cost is None else np.zeros(3)
        goal = self._goal(reference, origin)
        made = prepared.rollout(room, pose=pose - origin, parameters=goal)
        cost = np.asarray(made.reduced, dtype=np.float64)
        flat = room.reshape(3 * self.horizon, self.samples)
        weights = self._weights(cost, self._effort(twists, flat))
        mean = (flat @ weights.astype(flat.dtype)).astype(np.float64).reshape(twists.shape)
        mean[0] = prepared.sampler.bounded(mean[0])
        return (cost, weights), Plan(mean, tick + 1, now)

    def _weights(self, cost: Array, effort: Array) -> Array:
        """Return each sample's share (K,) in the plan."""
        temperature = float(self.temperature)
        with np.errstate(over="ignore", invalid="ignore"):  # told below, or clipped
            total = cost + temperature * effort
            if not np.isfinite(total).all():
                k = int(np.flatnonzero(~np.isfinite(total))[0])
                raise TrundleError(f"the cost of sample {k} is no finite number: {total[k]}")
            above = np.minimum(total - total.min(), _NOTHING * temperature)
        weights = np.exp(-above / temperature)
        return np.asarray(weights / weights.sum())

    def _effort(self, twists: Array, flat: Any) -> Array:
        """Return the sum (K,) over all steps of u^T Sigma^-1 (v - u) / hold."""
        variance = np.square(self.sigma)
        price = np.divide(1.0 / self.hold, variance, out=np.zeros(3), where=variance > 0)
        with np.errstate(over="ignore", invalid="ignore"):  # told with the costs
            scaled = twists * price
            return np.asarray(scaled.ravel().astype(flat.dtype) @ flat - (scaled * twists).sum())

    def _go_on(self, state: Plan | None, now: float) -> tuple[Array, int]:
        """Return the plan (T, 3) from now on, its last twist held, and its number."""
        if state is None:
            return np.zeros((self.horizon, 3)), 0
        if not isinstance(state, Plan):
            raise TrundleError(f"state must be the Plan of the last step, or None, got {state!r}")
        if np.shape(state.twists) != (self.horizon, 3):
            raise ShapeError(
                f"the state is a plan of another horizon: its twists must be ({self.horizon}, 3), "
                f"got {np.shape(state.twists)}"
            )
        finite(state.twists, "the plan's twists")
        finite(state.t, "the plan's time")
        at = np.arange(self.horizon) + max(now - state.t, 0.0) / self.dt
        last = self.horizon - 1
        before = np.minimum(at.astype(np.intp), last)
        share = np.clip(at - before, 0.0, 1.0)[:, None]
        after = np.minimum(before + 1, last)
        return (1.0 - share) * state.twists[before] + share * state.twists[after], state.tick

    def _goal(self, reference: Reference, origin: Array) -> Array:
        """Return the parameters of the cost, as seen from an origin (x, y, 0)."""
        goal = finite(reference.position, "reference position", 3)
        rate = finite(reference.velocity, "reference velocity", 3)
        if self.cost is not None:
            return np.concatenate([goal, rate, np.asarray(self.parameters)])
        weights, circles = np.asarray(self.weights), np.asarray(self.obstacles) - origin
        return goal_parameters(goal - origin, rate, weights, self.near, self.clearance, circles)

    def _room(self) -> Any:
        return np.empty((self.horizon, 3, self.samples), self.dtype)

    def _prepare(self) -> _Prepared:
        at_rest = Reference(np.zeros(3), np.zeros(3), np.zeros(3))
        goal = self._goal(at_rest, np.zeros(3))
        cost = GoalCost(goal) if self.cost is None else CostSum(self.cost, parameters=goal)
        ready = compile_rollout(
            self.robot, Stream.wheels_first(twist=np.zeros_like(self._room())), dt=self.dt,
            pose=np.zeros(3), save=cost, dtype=self.dtype, device=self.device,
        )  # fmt: skip
        most = None if self.max_twist is None else np.asarray(self.max_twist)
        sampler = TwistSampler.of(self.robot, most, self.dtype, self.device)
        return _Prepared(sampler=sampler, rollout=ready, spare=[])


def _measured(measurement: Measurement) -> tuple[float, Array]:
    """Return time and pose (3,)."""
    now, pose = finite(measurement.t, "measured time"), finite(measurement.pose, "measured pose", 3)
    if now.ndim or pose.ndim != 1:
        raise ShapeError(f"one time and one pose (3,) are measured, got {now.shape}, {pose.shape}")
    return float(now), pose


def _whole(value: object, name: str, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise TrundleError(f"{name} must be a whole number from {least} on, got {value!r}")


def _positive(value: object, name: str) -> None:
    if isinstance(value, bool) or not isinstance(value, Real) or not 0 < float(value) < np.inf:
        raise TrundleError(f"{name} must be a positive number, got {value!r}")


def _three(values: npt.ArrayLike, name: str, least: float | None) -> Array:
    """Return three numbers; none below the least, or all positive."""
    given = finite(values, name)
    if given.shape != (3,):
        raise ShapeError(f"{name} must be three numbers, got shape {given.shape}")
    if least is None and not (given > 0).all():
        raise TrundleError(f"{name} must be positive, got {given.tolist()}")
    if least is not None and (given < least).any():
        raise TrundleError(f"{name} must not be negative, got {given.tolist()}")
    return given


def _circles(values: npt.ArrayLike) -> Array:
    given = finite(values, "obstacles")
    if given.size == 0:
        return np.zeros((0, 3))
    if given.ndim != 2 or given.shape[1] != 3:
        raise ShapeError(f"obstacles must be circles (k, 3), x, y, radius, got {given.shape}")
    if (given[:, 2] < 0).any():
        raise TrundleError(f"obstacles: a radius must not be negative, got {given[:, 2].min():g} m")
    return given


def _row(values: npt.ArrayLike) -> Array:
    given = finite(values, "parameters")
    if given.ndim != 1:
        raise ShapeError(f"parameters must be (k,) numbers, got shape {given.shape}")
    return given
