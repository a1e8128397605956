"""What a layout shows, in metres, before any of it is drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trundle.robot import Robot, RollingWheel, SwedishWheel, Wheel
from trundle.se2 import Array
from trundle.view.centre import Centre
from trundle.view.drawing import Shape
from trundle.view.shapes import radius_of
from trundle.view.stance import Stance

# A centre farther from the wheels than this many times the robot's reach would make it a dot.
_FAR_CENTRE = 3.0
_FRAME = (0.42, 0.5, 0.35)  # lengths of the frame's arrows, in the robot's reach, the best first
_ACROSS = 20.0  # half the length of a line across the whole picture, in the robot's reach


@dataclass(frozen=True)
class Sketch:
    """What a layout shows, before any of it is drawn."""

    robot: Robot
    stance: Stance
    centre: Centre
    shapes: list[Shape]

    def bounds(self) -> tuple[Array, Array]:
        """Return the corners of the box [m] that the picture must hold."""
        points = [shape.points for shape in self.shapes]
        points += [np.array(self.drive_arrow(wheel)) for wheel in self.arrowed]
        points.append(np.array([tip for tip, _ in self.frame_tips]))
        if self.centre_in_view is not None:
            points.append(np.array([self.centre_in_view]))
        every = np.vstack(points)
        return every.min(axis=0), every.max(axis=0)

    @property
    def size(self) -> float:
        """The robot's reach [m], wheels included."""
        return self.robot.reach + max(radius_of(w, self.robot.reach) for w in self.robot.wheels)

    @property
    def arrowed(self) -> list[RollingWheel]:
        """The wheels whose sense of turning matters: those with a motor or an encoder."""
        rolling = [w for w in self.robot.wheels if isinstance(w, RollingWheel)]
        return [wheel for wheel in rolling if wheel.driven or wheel.sensed]

    @property
    def pushing(self) -> list[RollingWheel]:
        """The wheels with a force line: those with a motor."""
        return list(self.robot.driven)

    @property
    def held(self) -> list[Wheel]:
        """The wheels with a zero line: those that resist side slip."""
        return [wheel for wheel in self.robot.wheels if wheel.rows().side_slip is not None]

    @property
    def frame_tips(self) -> list[tuple[tuple[float, float], str]]:
        """The tips of the body frame's axes, with their names."""
        taken = [shape.points for shape in self.shapes if shape.part == "wheel"]
        taken += [np.array(self.drive_arrow(wheel)) for wheel in self.arrowed]
        points = np.vstack(taken)

        def free(share: float) -> float:
            away = np.hypot(points[:, 0] - share * self.size, points[:, 1])
            return min(float(away.min()) / self.size, 0.1)

        length = max(_FRAME, key=free) * self.size
        return [((length, 0.0), "x"), ((0.0, length), "y")]

    @property
    def centre_in_view(self) -> tuple[float, float] | None:
        """The instantaneous centre, where it is near enough to be drawn."""
        point = self.centre.point
        near = point is not None and math.hypot(*point) <= _FAR_CENTRE * self.size
        return point if near else None

    def drive_arrow(self, wheel: RollingWheel) -> tuple[Array, Array]:
        """Return tail and tip of the arrow along which positive motor speed drives."""
        angle, at = self.stance.angle[wheel.name], np.array(self.stance.contact(wheel))
        forward = wheel.spin_sign * np.array([math.cos(angle), math.sin(angle)])
        length = float(np.clip(0.8 * wheel.radius, 0.14 * self.size, 0.26 * self.size))
        tail = at + 1.08 * wheel.radius * forward
        return tail, tail + length * forward

    def force_line(self, wheel: RollingWheel) -> Array:
        """Return the ends (2, 2) of the line along which a wheel can push."""
        roller = wheel.roller if isinstance(wheel, SwedishWheel) else 0.0
        angle = self.stance.angle[wheel.name] + roller
        half = _ACROSS if isinstance(wheel, SwedishWheel) else 0.62
        return self._through(wheel, angle, max(half * self.size, 2.0 * wheel.radius))

    def zero_line(self, wheel: Wheel) -> Array:
        """Return the ends (2, 2) of the line across a wheel."""
        return self._through(
            wheel, self.stance.angle[wheel.name] + math.pi / 2, _ACROSS * self.size
        )

    def _through(self, wheel: Wheel, angle: float, half: float) -> Array:
        along = half * np.array([math.cos(angle), math.sin(angle)])
        at = np.array(self.stance.contact(wheel))
        return np.array([at - along, at + along])
