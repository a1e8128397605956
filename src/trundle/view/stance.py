"""How a robot's wheels stand at one instant: where each points, and how far it has turned."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from trundle.robot import CasterWheel, Robot, RollingWheel, Wheel
from trundle.se2 import Array, point_twist


@dataclass(frozen=True)
class Stance:
    """How a robot's wheels stand at one instant.

    Attributes:
        angle: each wheel's drive direction in the body frame [rad], by name.
        turn: how far each wheel has turned forward [rad], by name; 0 where it is not told.
    """

    angle: Mapping[str, float]
    turn: Mapping[str, float] = field(default_factory=dict)

    def contact(self, wheel: Wheel) -> tuple[float, float]:
        """Return where a wheel touches the ground, in the body frame [m]."""
        if isinstance(wheel, CasterWheel) and wheel.trail:
            angle = self.angle[wheel.name]
            return (
                wheel.x - wheel.trail * math.cos(angle),
                wheel.y - wheel.trail * math.sin(angle),
            )
        return wheel.x, wheel.y


def stand(
    robot: Robot,
    steering: Array,
    swivel: Mapping[str, float] | None = None,
    turn: Mapping[str, float] | None = None,
) -> Stance:
    """Return the stance at steering angles (s,) [rad].

    Args:
        robot: the robot.
        steering: (s,) angles of the steered wheels [rad].
        swivel: casters' angles in the body frame [rad], by name; else those of the description.
        turn: how far wheels have turned forward [rad], by name.
    """
    steered = {wheel.name: float(steering[i]) for i, wheel in enumerate(robot.steered)}
    angle = {}
    for wheel in robot.wheels:
        heading = wheel.heading if isinstance(wheel, RollingWheel | CasterWheel) else 0.0
        angle[wheel.name] = heading + steered.get(wheel.name, 0.0)
    return Stance(angle | dict(swivel or {}), dict(turn or {}))


def trailing(robot: Robot, twist: Array) -> dict[str, float]:
    """Return the swivel angles at which casters follow a constant twist, by name.

    With v_p the pivot's velocity, of direction chi, and g_dot = 0, the side-slip condition
    n . v_p = b (r + g_dot) gives ``sin(chi - g) = b r / |v_p|``; a caster for which there is no
    such angle is left out.

    >>> import numpy as np
    >>> from trundle import load
    >>> trailing(load("differential"), np.array([-1.0, 0.0, 0.0]))["caster"] == math.pi
    True
    """
    found = {}
    for wheel in robot.wheels:
        if not isinstance(wheel, CasterWheel):
            continue
        u, v, r = (float(each) for each in point_twist(twist, (wheel.x, wheel.y)))
        speed, across = math.hypot(u, v), (wheel.trail or 0.0) * r
        if speed > abs(across):
            found[wheel.name] = math.atan2(v, u) - math.asin(across / speed)
    return found
