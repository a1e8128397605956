"""The outlines of wheels and rollers as seen from above, as polygons in the wheel's own frame.

A wheel's frame has its origin at the contact point, x along the drive direction and y to its
left. Wheels are true to size: their length is twice the radius. A width is not part of a robot's
description; the one drawn is a fixed share of the radius.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from trundle.robot import BallWheel, CasterWheel, RollingWheel, SwedishWheel, Wheel
from trundle.se2 import Array

Side = Literal["ground", "top"]

# Width over radius: a car's tyre is about 0.65, a mecanum wheel for hobby robots 0.8 to 1.
_WIDTH = {"fixed": 0.55, "steered": 0.55, "omni": 0.6, "mecanum": 0.8, "caster": 0.5}
_BALL_RADIUS = 0.06  # of the robot's reach, where a ball has no radius of its own
_ROLLERS, _TREADS = 10, 8  # around the rim; an even number of rollers, for two rows
# Below this slant the rollers stand one behind the other, as on an omni wheel.
_SLANTED = math.radians(30)
# Points of half a barrel's outline: (along, across), as shares of half length and half width.
_BARREL = ((1.0, 0.0), (1.0, 0.55), (0.55, 0.9), (0.0, 1.0))


def radius_of(wheel: Wheel, reach: float) -> float:
    """Return the radius [m] with which a wheel is drawn."""
    if isinstance(wheel, RollingWheel | CasterWheel):
        return wheel.radius
    own = wheel.radius if isinstance(wheel, BallWheel) else None
    return own or _BALL_RADIUS * reach


def width_of(wheel: Wheel, reach: float) -> float:
    """Return the width [m] with which a wheel is drawn."""
    radius = radius_of(wheel, reach)
    return 2 * radius if wheel.kind == "ball" else _WIDTH.get(wheel.kind, 0.6) * radius


def rectangle(length: float, width: float) -> Array:
    """Return the corners (4, 2) of a rectangle about the origin, counter-clockwise.

    >>> rectangle(2.0, 1.0).tolist()
    [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]]
    """
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (length / 2, width / 2)


def circle(radius: float, points: int = 32) -> Array:
    """Return a regular polygon (points, 2) about the origin that looks like a circle."""
    angle = np.arange(points) * (2 * np.pi / points)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def outline(wheel: Wheel, reach: float) -> Array:
    """Return a wheel's outline from above (k, 2) [m]; a rectangle, or a circle for a ball."""
    radius = radius_of(wheel, reach)
    if isinstance(wheel, BallWheel):
        return circle(radius)
    return rectangle(2 * radius, width_of(wheel, reach))


def rollers(wheel: SwedishWheel, turn: float = 0.0, side: Side = "ground") -> dict[int, Array]:
    """Return the rollers on one side of a Swedish wheel, projected onto the ground.

    The roller that touches the ground lies along its axis, at ``wheel.roller`` from the drive
    direction. On top of the wheel the same roller has turned half about the axle, so it slants
    the other way. When the wheel turns forward, its top moves forward and its ground side back.

    Args:
        wheel: the wheel.
        turn: how far the wheel has turned forward [rad].
        side: "ground" for the rollers below, seen through the wheel, or "top".

    Returns:
        The polygons (k, 2) [m] of the rollers in sight, by the roller's number.
    """
    # An axis has no sign: the same roller with a positive cosine.
    slant = math.remainder(wheel.roller, math.pi)
    half_length, half_width, row = _roller_size(wheel.radius, width_of(wheel, 0.0), slant)
    along, across = _barrel(half_length, half_width)
    tangent = along * math.cos(slant) - across * math.sin(slant)
    axle = along * math.sin(slant) + across * math.cos(slant)
    rim = wheel.radius - half_width
    sign = 1.0 if side == "ground" else -1.0
    return {
        k: np.column_stack(
            [sign * (tangent * math.cos(g) - rim * math.sin(g)), axle + row * (-1) ** k]
        )
        for k, g in _in_sight(turn, _ROLLERS)
    }


def treads(wheel: Wheel, turn: float = 0.0, side: Side = "top") -> dict[int, Array]:
    """Return the bars across a standard wheel's tyre, which show how far it has turned.

    The arguments and the answer are those of ``rollers``.
    """
    radius, width = radius_of(wheel, 0.0), width_of(wheel, 0.0)
    sign = 1.0 if side == "ground" else -1.0
    return {
        k: rectangle(0.16 * radius * math.cos(g), 0.8 * width)
        - (sign * 0.97 * radius * math.sin(g), 0.0)
        for k, g in _in_sight(turn, _TREADS)
    }


def _in_sight(turn: float, count: int) -> list[tuple[int, float]]:
    """Return the number and angle from the side's middle of each part of the rim in sight."""
    angles = [math.remainder(turn + k * 2 * math.pi / count, 2 * math.pi) for k in range(count)]
    return [(k, angle) for k, angle in enumerate(angles) if abs(angle) < 0.48 * math.pi]


def _roller_size(radius: float, width: float, slant: float) -> tuple[float, float, float]:
    """Return half the length and half the diameter [m] of rollers that leave gaps.

    The third value is how far [m] every other roller stands to one side: rollers without slant
    stand in two rows, so that one of them always touches the ground.
    """
    if abs(slant) < _SLANTED:
        half_width = 0.21 * width
        spacing = 2 * math.pi * (radius - half_width) / (_ROLLERS / 2)
        return 0.36 * spacing, half_width, 0.25 * width
    spacing = 2 * math.pi * radius / _ROLLERS
    half_width = 0.36 * spacing * abs(math.sin(slant))
    half_length = (width / 2 - half_width * math.cos(slant)) / abs(math.sin(slant))
    return half_length, half_width, 0.0


def _barrel(half_length: float, half_width: float) -> tuple[Array, Array]:
    """Return the outline of a barrel: coordinates along its axis and across it."""
    quarter = np.array(_BARREL)
    upper = np.vstack([quarter, (quarter * (-1, 1))[-2::-1]])
    whole = np.vstack([upper, -upper[1:-1]])
    return whole[:, 0] * half_length, whole[:, 1] * half_width
