"""Commands that say what is desired, and the controllers that see to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self, cast

import numpy as np
import numpy.typing as npt

from trundle.dynamics import Dynamics, reduce
from trundle.errors import ShapeError, TrundleError
from trundle.kinematics import finite
from trundle.motion import AnyTrajectory, sample
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.rollout.closed_loop import ClosedLoop
from trundle.simulation.rollout.commands import Commands, numbers
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.varied import spread_out
from trundle.simulation.tracking.plant import (
    Plant,
    body_numbers,
    check_pushable,
    plant_of,
    wheel_table,
)
from trundle.simulation.tracking.signals import ModelController, ScalarController


class Tracking(Commands):
    """Robots that controllers keep on a trajectory, by the planar dynamics of body and wheels.

    Each step is that of ``track(..., method="semi-implicit")``: torques are shared out among the
    driven wheels, cut off by their motors, and friction eats some of them.

    Args:
        trajectory: what all robots are to follow; or (T, 9) or (T, N, 9) numbers, for each step
            the desired x, y, psi and their first and second derivatives in the inertial frame.
        controller: a controller such as PD or ComputedTorque, or a sequence of N, one for each
            robot, which differ in their gains and models.
        rate: (3,) or (N, 3) rates at the start [m/s, m/s, rad/s]; the trajectory's when left out.

    >>> from trundle import motion
    >>> from trundle.control import PD
    >>> on_a_circle = Tracking(motion.circle(radius=3.0, rate=0.1), PD([9, 9, 1], [9, 9, 1]))
    """

    moving = True

    def __init__(
        self,
        trajectory: AnyTrajectory | npt.ArrayLike,
        controller: Any,
        *,
        rate: npt.ArrayLike | None = None,
    ) -> None:
        several = isinstance(controller, Sequence)
        self.controllers = tuple(controller) if several else (controller,)
        self.several = several
        laws = {getattr(each, "scalar_law", None) for each in self.controllers}
        if not self.controllers or None in laws or len(laws) > 1:
            raise TrundleError(
                "controller must be one that rollouts can compile, PD or ComputedTorque, or a "
                f"sequence of one kind of them; got {controller!r}"
            )
        self.rate = None if rate is None else finite(rate, "rate", 3)
        if self.rate is not None and self.rate.ndim > 2:
            raise ShapeError(f"rate must be (3,) or (N, 3), got {self.rate.shape}")
        self.trajectory = trajectory

    def with_noise(self, sigma: npt.ArrayLike, *, seed: int) -> Self:
        """Refuse: what is desired has no noise."""
        raise TrundleError("Tracking takes no noise: vary the starts, the robot or the controllers")

    def desired(self, steps: int | None, dt: float) -> Numbers:
        """Return what is desired at the start of each step (T, 9, N or 1)."""
        if not hasattr(self.trajectory, "position"):
            rows = numbers(self.trajectory, "trajectory")
            if rows.ndim not in (2, 3) or rows.shape[-1] != 9:
                raise ShapeError(f"desired numbers must be (T, 9) or (T, N, 9), got {rows.shape}")
            if rows.size == 0 or not np.isfinite(rows).all():
                raise ShapeError("desired numbers must be finite, of one step at least")
            return rows[:, :, None] if rows.ndim == 2 else np.swapaxes(rows, 1, 2)
        if steps is None:
            raise TrundleError("give steps: a trajectory is sampled at every step")
        course = sample(cast(AnyTrajectory, self.trajectory), np.arange(max(steps, 1)) * dt)
        return np.concatenate(course, axis=-1)[:, :, None]

    @property
    def wraps(self) -> bool:
        """Whether heading errors go the shorter way round."""
        return not getattr(self.trajectory, "plain_heading", False)

    def start(self, desired: Numbers, pose: Array | None, plant: Plant) -> Array:
        """Return the states (6, N or 1) that the robots start with: pose and twist."""
        first = np.asarray(desired[0], dtype=np.float64).T
        pose = first[:, :3] if pose is None else np.atleast_2d(pose)
        rate = first[:, 3:6] if self.rate is None else np.atleast_2d(self.rate)
        try:
            pose, rate = np.broadcast_arrays(pose, rate)
        except ValueError:
            raise ShapeError(f"pose has {len(pose)} robots, and rate has {len(rate)}") from None
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        twist = np.stack(
            [c * rate[:, 0] + s * rate[:, 1], c * rate[:, 1] - s * rate[:, 0], rate[:, 2]]
        )
        return np.concatenate([pose.T, plant.here.allowed @ twist])

    def motion(
        self, plant: Plant, varied: Robot, batch: tuple[int, ...], dt: float
    ) -> tuple[ClosedLoop, list[Numbers]]:
        """Return how the robots move, and the constants of that, group by group.

        Args:
            plant: the robot as described, which controllers without a model believe in.
            varied: the same, in which some numbers may be arrays.
            batch: () or (N,), the shape of these.
            dt: step [s].
        """
        gains = np.stack([self._constants(each, plant) for each in self.controllers], axis=-1)
        varied = spread_out(varied, batch)
        dynamics = Dynamics(varied)
        none = np.zeros((*batch, 0))
        here = reduce(varied, none, none)
        table = wheel_table(dynamics, here)
        hindered = dynamics.torque_limits.any or table[..., 9:].any()
        wheels = table.reshape(*batch, -1).T if hindered else np.zeros(0)
        made = ClosedLoop(
            law=self.controllers[0].scalar_law,
            gains=len(gains),
            wheels=table.shape[-2] if hindered else 0,
            wraps=self.wraps,
        )
        own = gains if self.several else gains[:, 0]
        return made, [np.array([dt, dt / 2]), body_numbers(dynamics, here).T, own, wheels]

    def _constants(self, controller: ScalarController, plant: Plant) -> Array:
        if isinstance(controller, ModelController):
            controller = cast(ScalarController, controller.with_model(plant.dynamics))
        return controller.scalar_constants


def plant_for(robot: Robot) -> Plant:
    """Return the constants of a robot that forces can keep on a trajectory.

    Raises:
        TrundleError: it steers, or its wheels cannot push it every way.
    """
    if robot.steered:
        raise TrundleError(
            f"robot {robot.name!r} steers: rollouts by the dynamics are for robots that do not; "
            "take a Policy that commands twists"
        )
    plant = plant_of(robot)
    check_pushable(robot, plant)
    return plant
