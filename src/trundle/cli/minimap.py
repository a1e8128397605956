"""A small map drawn with characters: a path, and the robot's outline to scale."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rich.text import Text

from trundle.robot import Robot

Point = tuple[float, float]
Pose = tuple[float, float, float]

# A character of braille has 2 x 4 dots, from U+2800 on; each dot is a bit of it.
_WIDE, _HIGH, _BRAILLE = 2, 4, 0x2800
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
# The robot's length in dots, at the start and at the least; and the steps between.
_LARGE, _SMALL, _ZOOM = 22.0, 6.0, 1.25
# Share of the map that is kept free around what it shows.
_MARGIN = 0.06
_CORNER = 1.15  # an outline over the span of the contact points, where the robot has no body


class Canvas:
    """Dots in a rectangle of characters, y up; what is drawn later has its style.

    >>> canvas = Canvas(2, 1)
    >>> canvas.line((0.0, 0.0), (3.0, 3.0), "cyan")
    >>> canvas.rows()[0].plain
    '⡠⠊'
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.lines = columns, rows
        self.width, self.height = columns * _WIDE, rows * _HIGH
        self._bits = [[0] * columns for _ in range(rows)]
        self._styles = [[""] * columns for _ in range(rows)]

    def dot(self, x: float, y: float, style: str) -> None:
        """Set the dot at (x, y), counted from the left and from below, if it is inside."""
        column, row = math.floor(x), self.height - 1 - math.floor(y)
        if 0 <= column < self.width and 0 <= row < self.height:
            at = row // _HIGH, column // _WIDE
            self._bits[at[0]][at[1]] |= _DOTS[row % _HIGH][column % _WIDE]
            self._styles[at[0]][at[1]] = style

    def line(self, start: Point, end: Point, style: str) -> None:
        """Set the dots from one point to another; far outside there are none."""
        (x, y), (dx, dy) = start, (end[0] - start[0], end[1] - start[1])
        length = max(abs(dx), abs(dy))
        if not length <= 4 * (self.width + self.height):
            return
        count = math.ceil(length)
        for k in range(count + 1):
            share = k / count if count else 0.0
            self.dot(x + share * dx, y + share * dy, style)

    def polyline(self, points: Sequence[Point], style: str) -> None:
        """Set the dots along points."""
        for start, end in itertools.pairwise(points):
            self.line(start, end, style)

    def rows(self, ascii_only: bool = False) -> list[Text]:
        """Return the lines of characters from above."""
        lines = []
        for bits, styles in zip(self._bits, self._styles, strict=True):
            line = Text()
            for style, cells in itertools.groupby(zip(bits, styles, strict=True), lambda c: c[1]):
                line.append("".join([_mark(bit, ascii_only) for bit, _ in cells]), style)
            lines.append(line)
        return lines


def _mark(bits: int, ascii_only: bool) -> str:
    if not bits:
        return " "
    return "*" if ascii_only else chr(_BRAILLE + bits)


@dataclass(frozen=True)
class Window:
    """What the map shows: the world point at its centre, and its scale.

    Attributes:
        x, y: [m].
        size: of a dot [m].
    """

    x: float
    y: float
    size: float

    def dots(self, points: Iterable[Point], canvas: Canvas) -> list[Point]:
        """Return world points [m] in the dots of a canvas."""
        left, below = canvas.width / 2 - self.x / self.size, canvas.height / 2 - self.y / self.size
        return [(left + x / self.size, below + y / self.size) for x, y in points]


def follow(
    window: Window | None, robot_size: float, pose: Pose, box: Sequence[float], canvas: Canvas
) -> Window:
    """Return the window that shows a robot: the last one as long as that is possible.

    It steps to smaller scales while all of the path then fits; after that it moves along.

    Args:
        window: the last window, or None.
        robot_size: of the robot [m].
        pose: of the robot.
        box: least x, least y, largest x, largest y of the path and the robot [m].
        canvas: what the window is shown on.
    """
    middle = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    if window is None:
        window = Window(*middle, robot_size / _LARGE)
    if _fits(window, box, canvas):
        return window
    size = window.size
    while _ZOOM * size <= robot_size / _SMALL:
        size *= _ZOOM
        wider = Window(*middle, size)
        if _fits(wider, box, canvas):
            return wider
    half = robot_size / 2
    here = pose[0] - half, pose[1] - half, pose[0] + half, pose[1] + half
    kept = Window(window.x, window.y, size)
    return kept if _fits(kept, here, canvas) else Window(pose[0], pose[1], size)


def _fits(window: Window, box: Sequence[float], canvas: Canvas) -> bool:
    wide = (0.5 - _MARGIN) * canvas.width * window.size
    high = (0.5 - _MARGIN) * canvas.height * window.size
    return (
        window.x - wide <= box[0]
        and box[2] <= window.x + wide
        and window.y - high <= box[1]
        and box[3] <= window.y + high
    )


def outline(robot: Robot) -> list[Point]:
    """Return the corners of a robot's body, or of a rectangle around its wheels [m]."""
    body = robot.body
    if body is not None and body.length is not None and body.width is not None:
        half, side, x, y = body.length / 2, body.width / 2, body.x, body.y
    else:
        xs, ys = [wheel.x for wheel in robot.wheels], [wheel.y for wheel in robot.wheels]
        x, y = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
        least = 0.3 * robot.reach
        half = max(_CORNER * (max(xs) - min(xs)) / 2, least)
        side = max(_CORNER * (max(ys) - min(ys)) / 2, least)
    return [(x + half, y + side), (x - half, y + side), (x - half, y - side), (x + half, y - side)]


def placed(points: Iterable[Point], pose: Pose) -> list[Point]:
    """Return body points in the inertial frame."""
    x, y, psi = pose
    c, s = math.cos(psi), math.sin(psi)
    return [(x + c * a - s * b, y + s * a + c * b) for a, b in points]


def draw_robot(
    canvas: Canvas,
    window: Window,
    robot: Robot,
    pose: Pose,
    steering: Sequence[float],
    style: str,
) -> None:
    """Draw a robot's outline, a line from its middle to its front, and its wheels."""
    corners = outline(robot)
    closed = [*corners, corners[0]]
    canvas.polyline(window.dots(placed(closed, pose), canvas), style)
    (x, y), (back, _) = corners[0], corners[1]
    middle = y - (corners[0][1] - corners[3][1]) / 2
    nose = [((x + back) / 2, middle), (x, middle)]
    canvas.polyline(window.dots(placed(nose, pose), canvas), style)
    angles = {
        wheel.name: wheel.heading + angle
        for wheel, angle in zip(robot.steered, steering, strict=False)
    }
    for wheel in robot.wheels:
        radius = getattr(wheel, "radius", None) or 0.0
        if wheel.driven or wheel.steers:
            angle = angles.get(wheel.name, getattr(wheel, "heading", 0.0))
            dx, dy = radius * math.cos(angle), radius * math.sin(angle)
            ends = [(wheel.x - dx, wheel.y - dy), (wheel.x + dx, wheel.y + dy)]
            canvas.polyline(window.dots(placed(ends, pose), canvas), style)
