"""What the ground does to the wheels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.dynamics.loads import wheel_loads
from trundle.dynamics.reduced import REPEATED, Reduced, apply, rolling_wheels
from trundle.kinematics import gains
from trundle.robot import Robot
from trundle.se2 import Array


class GroundForces(NamedTuple):
    """Forces of the ground on the k wheels in order, zero for those that it only carries.

    Attributes:
        along: (..., k) force along the drive direction, for Swedish wheels along the axis of the
            roller on the ground [N].
        side: (..., k) force across it, that keeps the wheel from slipping sideways [N].
        load: (k,) weight on each wheel at rest [N]; nan where the body would tip.
        friction: (..., k) coefficient of friction that the wheel needs not to slip.
    """

    along: Array
    side: Array
    load: Array
    friction: Array


def ground_forces(
    robot: Robot, here: Reduced, speed_rate: Array, torques: Array, net: Array
) -> GroundForces:
    """Return the ground's forces on the wheels.

    Args:
        robot: the robot.
        here: its equations at the steering angles.
        speed_rate: (..., w) acceleration of the wheels that roll [rad/s^2].
        torques: (..., w) net torques on them, of motors and friction [N m].
        net: (..., 3) what the side forces must give in all: M zeta_dot + c - G^T tau.
    """
    wheels, rolling = robot.wheels, rolling_wheels(robot)
    pushing = (torques - here.spin * speed_rate) / gains(rolling)
    # Where wheels share the side force in more than one way, the least.
    share = np.asarray(np.linalg.pinv(np.swapaxes(here.C, -1, -2), rcond=REPEATED))
    holding = apply(share, net)
    shape = (*pushing.shape[:-1], len(wheels))
    along, side = np.zeros(shape), np.zeros(shape)
    along[..., [wheels.index(wheel) for wheel in rolling]] = pushing
    side[..., [i for i, w in enumerate(wheels) if w.rows().side_slip is not None]] = holding
    load = wheel_loads(robot)
    demand = np.hypot(along, side)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(demand > 0, demand / np.maximum(load, 0.0), 0.0)
    return GroundForces(along, side, load, needed)
