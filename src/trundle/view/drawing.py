"""A robot as painted polygons: what layout, path and animation have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.collections import PolyCollection

from trundle.robot import (
    BallWheel,
    CasterWheel,
    Robot,
    SteeredWheel,
    SwedishWheel,
    Wheel,
)
from trundle.se2 import Array, rotation
from trundle.view.shapes import Side, circle, outline, rectangle, rollers, treads
from trundle.view.stance import Stance
from trundle.view.style import (
    BLUE,
    BODY_EDGE,
    BODY_FACE,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    fade,
)

_FRONT = BODY_EDGE
_MARK = "#F0E442"  # Okabe and Ito's yellow: one roller or bar, so that the eye can follow it


@dataclass(frozen=True)
class Look:
    """What a wheel does, in words, and the colours that say so."""

    words: str
    face: str
    edge: str


DRIVEN = Look("driven wheel", BLUE, "#003F63")
DRIVEN_STEERED = Look("driven and steered wheel", ORANGE, "#7A3500")
STEERED = Look("steered wheel, not driven", fade(ORANGE, 0.72), ORANGE)
DEAD = Look("dead wheel: no motor,\nwith encoder", fade(GREEN, 0.75), GREEN)
FREE = Look("free wheel", "#D5D8DC", MUTED)
CASTER = Look("caster, with its pivot", "#D5D8DC", MUTED)
BALL = Look("ball", "#D5D8DC", MUTED)
LOOKS = (DRIVEN, DRIVEN_STEERED, STEERED, DEAD, FREE, CASTER, BALL)


def look_of(wheel: Wheel) -> Look:
    """Return the look of a wheel."""
    if isinstance(wheel, CasterWheel):
        return CASTER
    if isinstance(wheel, BallWheel):
        return BALL
    if isinstance(wheel, SteeredWheel):
        return DRIVEN_STEERED if wheel.driven else STEERED
    if wheel.driven:
        return DRIVEN
    return DEAD if wheel.sensed else FREE


@dataclass(frozen=True)
class Shape:
    """One painted polygon of a robot.

    Attributes:
        of: name of the wheel, or "" for the body.
        part: body, front, wheel, roller, tread, fork or pivot.
        points: (k, 2) in the body frame [m].
        face: fill colour.
        edge: colour of the outline.
        line: width of the outline [pt].
    """

    of: str
    part: str
    points: Array
    face: str
    edge: str
    line: float


def robot_shapes(
    robot: Robot, stance: Stance, side: Side = "top", *, marked: bool = False
) -> list[Shape]:
    """Return a robot's polygons from above, in the order in which they are painted.

    Args:
        robot: the robot.
        stance: how the wheels stand.
        side: which side of the wheels is drawn, the top or, seen through, the ground side.
        marked: paint one roller or bar of each wheel yellow, so that its turning is seen.
    """
    shapes = body_shapes(robot)
    for wheel in robot.wheels:
        shapes += _wheel_shapes(wheel, stance, robot.reach, side, marked)
    return shapes


def body_shapes(robot: Robot) -> list[Shape]:
    """Return the body's outline and a stripe at its front; without a body, the wheels' span."""
    body = robot.body
    if body is not None and body.length is not None and body.width is not None:
        corners = place(rectangle(body.length, body.width), (body.x, body.y, 0.0))
    else:
        at = np.array([(wheel.x, wheel.y) for wheel in robot.wheels])
        low, high = at.min(axis=0), at.max(axis=0)
        span = np.maximum(high - low, 0.2 * robot.reach)
        corners = rectangle(span[0], span[1]) + (low + high) / 2
    (left, low_y), (right, high_y) = corners[0], corners[2]
    depth, margin = 0.025 * min(right - left, high_y - low_y), 0.06 * (high_y - low_y)
    front = np.array(
        [
            (right - depth, low_y + margin),
            (right, low_y + margin),
            (right, high_y - margin),
            (right - depth, high_y - margin),
        ]
    )
    return [
        Shape("", "body", corners, BODY_FACE, BODY_EDGE, 1.2),
        Shape("", "front", front, _FRONT, _FRONT, 0.0),
    ]


def _wheel_shapes(
    wheel: Wheel, stance: Stance, reach: float, side: Side, marked: bool
) -> list[Shape]:
    look, angle, at = look_of(wheel), stance.angle[wheel.name], stance.contact(wheel)
    turn = stance.turn.get(wheel.name, 0.0)

    def shape(part: str, points: Array, face: str, edge: str, line: float) -> Shape:
        return Shape(wheel.name, part, place(points, (*at, angle)), face, edge, line)

    whole = outline(wheel, reach)
    if isinstance(wheel, SwedishWheel):
        found = [shape("wheel", whole, fade(look.face, 0.7), look.edge, 1.0)]
        parts, part, paint = rollers(wheel, turn, side), "roller", look.face
    elif isinstance(wheel, BallWheel):
        return [shape("wheel", whole, look.face, look.edge, 1.0)]
    else:
        found = [shape("wheel", whole, look.face, look.edge, 1.0)]
        parts, part, paint = treads(wheel, turn, side), "tread", fade(look.face, 0.35)
        if look.face in (CASTER.face, STEERED.face, DEAD.face):
            paint = fade(look.edge, 0.55)
    for k, points in parts.items():
        colour = _MARK if marked and k == 0 else paint
        found.append(shape(part, points, colour, look.edge, 0.4 if part == "roller" else 0.0))
    if isinstance(wheel, CasterWheel):
        found += _fork(wheel, at)
    if isinstance(wheel, SteeredWheel):
        found.append(shape("pivot", circle(0.16 * wheel.radius), "#FFFFFF", look.edge, 1.0))
    return found


def _fork(wheel: CasterWheel, at: tuple[float, float]) -> list[Shape]:
    """Return the caster's trail, from contact to pivot, and its pivot."""
    pivot = np.array([wheel.x, wheel.y])
    along = pivot - at
    length = float(np.hypot(*along)) or 1.0
    across = np.array([-along[1], along[0]]) / length * 0.10 * wheel.radius
    bar = np.array([at - across, pivot - across, pivot + across, at + across])
    disc = circle(0.26 * wheel.radius) + pivot
    return [
        Shape(wheel.name, "fork", bar, INK, INK, 0.0),
        Shape(wheel.name, "pivot", disc, "#FFFFFF", INK, 1.2),
    ]


def place(points: Array, pose: npt.ArrayLike) -> Array:
    """Return points (..., 2) of a frame as seen from the one in which it has a pose (3,).

    >>> place(np.array([1.0, 0.0]), (1.0, 2.0, np.pi / 2)).round(9).tolist()
    [1.0, 3.0]
    """
    pose = np.asarray(pose, dtype=np.float64)
    return np.asarray(points @ rotation(pose[2])[:2, :2].T + pose[:2])


def paint(
    shapes: Sequence[Shape], pose: npt.ArrayLike = (0.0, 0.0, 0.0), faded: float = 0.0
) -> PolyCollection:
    """Return a robot's polygons at a pose as one artist, mixed with white by ``faded``."""
    artist = PolyCollection([])
    repaint(artist, shapes, pose, faded)
    return artist


def repaint(
    artist: PolyCollection, shapes: Sequence[Shape], pose: npt.ArrayLike, faded: float = 0.0
) -> None:
    """Give an artist other polygons; an animation does so for every frame."""
    artist.set_verts([place(each.points, pose) for each in shapes])
    artist.set_facecolor([fade(each.face, faded) for each in shapes])
    artist.set_edgecolor([fade(each.edge, faded) for each in shapes])
    artist.set_linewidth([each.line for each in shapes])
