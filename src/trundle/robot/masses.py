"""What a robot weighs: body and wheels taken together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trundle.errors import RobotError
from trundle.robot.robot import Robot
from trundle.se2 import Array

_NEEDED = ("mass", "inertia", "com")


class TotalMass(NamedTuple):
    """Mass [kg], centre of mass (2,) in the body frame [m], inertia about it [kg m^2].

    Of a description whose numbers are batches, they are batches too.
    """

    mass: float
    com: Array
    inertia: float


def missing_masses(robot: Robot) -> list[str]:
    """Return the keys of the body that dynamics needs and the description leaves out."""
    return [name for name in _NEEDED if robot.body is None or getattr(robot.body, name) is None]


def total_mass(robot: Robot) -> TotalMass:
    """Return mass, centre of mass and inertia of body and wheels together.

    ``I = I_b + m_b |c_b - c|^2 + sum_i (I_yaw,i + m_i |d_i - c|^2)``, with each wheel's mass at
    its contact point (a caster's at its pivot).

    Raises:
        RobotError: the body's mass, inertia or centre of mass is missing.

    Source: the parallel-axis theorem, Craig, Introduction to Robotics, 3rd edition, 2005,
    section 6.3.

    >>> import trundle
    >>> robot = trundle.load("omni3").with_body(mass=27.0, inertia=1.0, com=(0.0, 0.0))
    >>> total = total_mass(robot.with_wheels(mass=1.0))
    >>> total.mass, round(total.inertia, 9)  # three wheels 0.3 m from the centre
    (30.0, 1.27)
    """
    missing = missing_masses(robot)
    if missing or robot.body is None:
        fault = (
            f"the body's {', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing: "
            "dynamics needs mass [kg], inertia about the centre of mass [kg m^2] and com, the "
            "centre of mass [x, y] [m]; write them under [body], or call robot.with_body(mass=..., "
            "inertia=..., com=...)"
        )
        raise RobotError([fault], f"robot {robot.name!r}")
    body = robot.body
    parts = [(body.mass, *body.com), *((w.mass, w.x, w.y) for w in robot.wheels)]  # type: ignore[misc]
    mass, x, y = (
        np.stack(np.broadcast_arrays(*each), axis=-1) for each in zip(*parts, strict=True)
    )
    total = mass.sum(axis=-1)
    com = np.stack([(mass * x).sum(axis=-1), (mass * y).sum(axis=-1)], axis=-1) / total[..., None]
    own = body.inertia + sum(wheel.yaw_inertia for wheel in robot.wheels)  # type: ignore[operator]
    away = np.square(x - com[..., :1]) + np.square(y - com[..., 1:])
    inertia = own + (mass * away).sum(axis=-1)
    if total.ndim == 0:
        return TotalMass(float(total), com, float(inertia))
    return TotalMass(total, com, np.broadcast_to(inertia, total.shape))  # type: ignore[arg-type]
