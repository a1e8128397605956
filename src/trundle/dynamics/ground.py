"""What the ground does to the wheels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.dynamics.loads import GRAVITY, wheel_loads
from trundle.dynamics.reduced import (
    REPEATED,
    Reduced,
    apply,
    holding_wheels,
    rolling_wheels,
)
from trundle.kinematics import gains
from trundle.robot import Robot, total_mass
from trundle.se2 import Array


class GroundForces(NamedTuple):
    """Forces of the ground on the k wheels in order, zero for those that it only carries.

    Attributes:
        along: (..., k) force along the drive direction, for Swedish wheels along the axis of the
            roller on the ground [N].
        side: (..., k) force across it, that keeps the wheel from slipping sideways [N]; for wheels
            that may skid their even share of what holds the robot.
        load: (k,) weight on each wheel at rest [N]; nan where the body would tip.
        friction: (..., k) coefficient of friction that the wheel needs not to slip.
    """

    along: Array
    side: Array
    load: Array
    friction: Array


# What is less than this share of the robot's weight is rounding.
_ROUNDING = 1e-9


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
    share = np.asarray(np.linalg.pinv(np.swapaxes(here.holding, -1, -2), rcond=REPEATED))
    holding = apply(share, net)
    shape = (*np.broadcast_shapes(pushing.shape[:-1], holding.shape[:-1]), len(wheels))
    along, side = np.zeros(shape), np.zeros(shape)
    along[..., [wheels.index(wheel) for wheel in rolling]] = pushing
    side[..., holding_wheels(robot)] = holding
    load = wheel_loads(robot)
    demand = np.hypot(along, side)
    weight = total_mass(robot).mass * GRAVITY
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(demand > _ROUNDING * weight, demand / load, 0.0)
    return GroundForces(along, side, load, needed)
