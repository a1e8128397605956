"""The live view of a drive: what is shown, line by line, and the terminal that shows it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from rich.console import Console
from rich.control import Control
from rich.text import Text

from trundle.bridge import Output, State
from trundle.cli.driving import FASTER, MOVES, QUIT, SLOWER, STOP, Hand, Pose, idle_keys
from trundle.cli.minimap import Canvas, Window, draw_robot, follow, outline, placed
from trundle.robot import Encoder, Robot

# Widths in characters: numbers, their labels, and all of it.
_NUMBER, _LABEL = 10, 11
PANEL = _LABEL + 3 * _NUMBER
# Less than this is too narrow for a map beside the numbers.
_NARROW = PANEL + 26
_GOOD, _WARN, _BAD, _PATH, _DIM = "green", "yellow", "bold red", "cyan", "dim"
_BAR = " ▏▎▍▌▋▊▉█"
# What was in force for one cycle is shown so long, or nobody could read it [s].
_LINGER = 0.6
# A sentence is read in so long [s].
_READ = 4.0
# The path keeps so many points; then every second one goes.
_POINTS = 600
_TURN = math.tau / 60


@dataclass(frozen=True)
class Shown:
    """What a drive shows at a moment.

    Attributes:
        output, state: of the bridge.
        truth: the true pose.
        hand: the key that is held.
        rate: cycles in a second.
    """

    output: Output
    state: State
    truth: Pose
    hand: Hand
    rate: float


@dataclass
class Dashboard:
    """The lines of the live view; it remembers the paths and what was lately in force.

    Attributes:
        robot: the robot.
        full: (n) wheel speeds at which the bars are full [rad/s].
        encoder: of the wheels that have none of their own.
        ascii_only: draw without special characters.
    """

    robot: Robot
    full: Sequence[float]
    encoder: Encoder
    ascii_only: bool = False
    _window: Window | None = None
    _path: list[tuple[float, float]] = field(default_factory=list)
    _true: list[tuple[float, float]] = field(default_factory=list)
    _lately: dict[str, dict[str, float]] = field(default_factory=dict)
    _told: tuple[str, float] = ("", -math.inf)

    def __post_init__(self) -> None:
        self._corners = outline(self.robot)
        self._idle = idle_keys(self.robot)
        self._size = max(math.dist(self._corners[0], corner) for corner in self._corners)

    def lines(self, shown: Shown, width: int, height: int) -> list[Text]:
        """Return the lines of the view, not wider and not more than given."""
        self._remember(shown)
        rows = max(height - 3, 1)
        panel = self._panel(shown)
        if len(panel) > rows:  # what says most stays: headings and empty lines go first
            panel = [line for line in panel if line.plain.strip()]
        if len(panel) > rows:
            panel = panel[:rows]
        panel += [Text()] * (rows - len(panel))
        body = panel
        if width >= _NARROW:
            map_ = self._map(shown, width - PANEL - 3, rows)
            body = [
                Text.assemble(left, "  ", right) for left, right in zip(map_, panel, strict=True)
            ]
        lines = [self._head(shown, width), *body, *self._foot(shown, width)]
        for line in lines:
            line.truncate(width - 1, overflow="crop", pad=True)
        return lines[:height]

    # ---- head and foot --------------------------------------------------------------------

    def _head(self, shown: Shown, width: int) -> Text:
        left = Text.assemble(" ", (self.robot.name, "bold"), ("  simulated", _DIM))
        word, style = _doing(shown)
        right = Text.assemble(
            (word, style),
            (f"   {shown.state.time:8.1f} s  {shown.rate:4.0f} Hz ", _DIM),
        )
        gap = width - 1 - left.cell_len - right.cell_len
        return Text.assemble(left, " " * max(gap, 1), right)

    def _foot(self, shown: Shown, width: int) -> list[Text]:
        hand = shown.hand
        told, at = self._told
        first = Text.assemble(
            (f" {hand.factor * hand.speed:.3g} m/s", "bold"),
            ", ",
            (f"{hand.factor * hand.turn:.3g} rad/s", "bold"),
            (", the most" if hand.factor >= hand.most else "", _DIM),
            ("    hold letters or arrows to drive, let go to stop", _DIM),
        )
        if told and shown.state.time - at < _READ:
            first = Text(f" {told}", _WARN)
        keys = [  # what is cut off where it is narrow comes last
            ("x", "quit"), ("i ,", "drive"),
            *([("j l", "turn")] if "j" not in self._idle else []),
            ("u o m .", "arcs"),
            *([("J L", "sideways")] if "J" not in self._idle else []),
            ("space", "stop"), ("+ -", "speed"),
        ]  # fmt: skip
        line = Text(" ")
        for key, what in keys:
            line.append(key, "bold")
            line.append(f" {what}  ", _DIM)
        return [first, line]

    # ---- numbers --------------------------------------------------------------------------

    def _panel(self, shown: Shown) -> list[Text]:
        return [
            *self._pose(shown),
            Text(),
            *self._twist(shown),
            Text(),
            *self._wheels(shown),
            Text(),
            *self._status(shown),
        ]

    def _pose(self, shown: Shown) -> list[Text]:
        (x, y, psi), (tx, ty, tpsi) = shown.output.pose, shown.truth
        sigma = [math.sqrt(max(row[i], 0.0)) for i, row in enumerate(shown.output.covariance)]
        heads = _heads("POSE", "odometry", "true", "1 sigma")
        heads.highlight_words(["odometry"], _PATH)  # as the paths on the map
        heads.highlight_words(["true"], _WARN)
        turned, really = (math.degrees(math.remainder(a, math.tau)) for a in (psi, tpsi))
        return [
            heads,
            _row("x [m]", x, tx, sigma[0]),
            _row("y [m]", y, ty, sigma[1]),
            _row("psi [deg]", turned, really, math.degrees(sigma[2]), digits=1),
        ]

    def _twist(self, shown: Shown) -> list[Text]:
        asked = STOP if shown.output.stale else shown.state.command
        given, measured = shown.output.twist, shown.output.velocity
        names = ("u [m/s]", "v [m/s]", "r [rad/s]")
        rows = zip(names, asked, given, measured, strict=True)
        return [_heads("TWIST", "asked", "given", "measured"), *(_row(*row) for row in rows)]

    def _wheels(self, shown: Shown) -> list[Text]:
        output, steers = shown.output, bool(self.robot.steered)
        driven = {wheel.name: i for i, wheel in enumerate(self.robot.driven)}
        steered = {wheel.name: i for i, wheel in enumerate(self.robot.steered)}
        lines = [_heads("WHEEL", "rad/s", "RPM", "deg" if steers else "")]
        slipping = self._now("slip")
        for wheel in self.robot.wheels:
            i, k = driven.get(wheel.name, -1), steered.get(wheel.name, -1)
            if i < 0 and k < 0:
                continue
            style = _BAD if wheel.name in slipping else ""
            line = Text(_short(wheel.name, _LABEL), style)
            speed = output.wheel_speeds[i] if i >= 0 else None
            line.append(_number(speed, 2))
            line.append(_number(None if speed is None else speed / _TURN, 1))
            if steers:
                angle = math.degrees(output.steering[k]) if k >= 0 else None
                line.append(_number(angle, 1))
            elif speed is not None:
                line.append("  ")
                line.append_text(self._bar(abs(speed) / self.full[i], _NUMBER - 2))
            lines.append(line)
        return lines

    def _bar(self, share: float, width: int) -> Text:
        share = min(max(share, 0.0), 1.0)
        style = _WARN if share > 0.98 else _GOOD
        eighths = round(share * width * 8)
        if self.ascii_only:
            return Text("#" * round(share * width), style)
        full, rest = divmod(eighths, 8)
        return Text(("█" * full + (_BAR[rest] if rest else "")).ljust(width), style)

    def _status(self, shown: Shown) -> list[Text]:
        limits, slipping = self._now("limits"), self._now("slip")
        refused = shown.state.refused, shown.state.refused_counts
        free = PANEL - _LABEL
        standing_in = any(wheel.encoder is None for wheel in self.robot.sensed)
        ticks = f"{self.encoder.ticks_per_motor_turn:g} ticks a turn, a stand-in"
        return [
            Text.assemble(
                ("LIMIT".ljust(_LABEL), _DIM),
                (_short(", ".join(limits) or "none in force", free), _WARN if limits else _DIM),
            ),
            Text.assemble(
                ("SLIP".ljust(_LABEL), _DIM),
                (_short(self._slipping(slipping), free), _BAD if slipping else _DIM),
            ),
            Text.assemble(
                ("REFUSED".ljust(_LABEL), _DIM),
                (f"{refused[0]} commands, {refused[1]} readings", _WARN if any(refused) else _DIM),
            ),
            *([Text("ENCODERS".ljust(_LABEL) + _short(ticks, free), _DIM)] if standing_in else []),
        ]

    def _slipping(self, names: list[str]) -> str:
        text, every = ", ".join(names) or "none", len(self.robot.sensed)
        whole = len(names) == every or len(text) > PANEL - _LABEL
        return f"{len(names)} of {every} wheels" if whole else text

    # ---- map ------------------------------------------------------------------------------

    def _map(self, shown: Shown, width: int, height: int) -> list[Text]:
        pose = shown.output.pose
        canvas = Canvas(width - 2, max(height - 2, 1))
        here = placed(self._corners, pose)
        every = [*self._path, *here]
        box = (
            min(x for x, _ in every), min(y for _, y in every),
            max(x for x, _ in every), max(y for _, y in every),
        )  # fmt: skip
        self._window = window = follow(self._window, self._size, pose, box, canvas)
        canvas.polyline(window.dots(self._true, canvas), _WARN)
        canvas.polyline(window.dots(self._path, canvas), _PATH)
        if math.dist(shown.truth[:2], pose[:2]) > 2 * window.size:
            draw_robot(canvas, window, self.robot, shown.truth, shown.output.steering, _WARN)
        draw_robot(canvas, window, self.robot, pose, shown.output.steering, "bold")
        corners = "++++-|" if self.ascii_only else "╭╮╰╯─│"
        side = Text(corners[5], _DIM)
        rows = [Text.assemble(side, row, side) for row in canvas.rows(self.ascii_only)]
        title, scale = " from above, x to the right ", _scale(window, self.ascii_only)
        top = corners[0] + corners[4] + title + corners[4] * (width - len(title) - 3) + corners[1]
        foot = corners[4] * (width - len(scale) - 3) + scale + corners[4]
        return [Text(top, _DIM), *rows, Text(corners[2] + foot + corners[3], _DIM)]

    # ---- memory ---------------------------------------------------------------------------

    def _remember(self, shown: Shown) -> None:
        near = self._window.size if self._window else 0.0  # a dot
        for path, (x, y, _) in ((self._path, shown.output.pose), (self._true, shown.truth)):
            if not path or math.dist(path[-1], (x, y)) > near:
                path.append((x, y))
            if len(path) > _POINTS:
                del path[1:-1:2]

    def note(self, output: Output, time: float) -> None:
        """Remember what a cycle tells, so that it stays long enough to be read."""
        for kind, names in (("limits", output.limits), ("slip", output.slipping)):
            known = self._lately.setdefault(kind, {})
            known.update(dict.fromkeys(names, time))
            for name in [name for name, last in known.items() if time - last > _LINGER]:
                del known[name]

    def idle(self, key: str) -> str:
        """Return why a key does nothing, or an empty text."""
        if key in (*MOVES, *FASTER, *SLOWER, *QUIT, "suspend"):
            return self._idle.get(key, "")
        return f"{key if key.isprintable() else repr(key)} does nothing"

    def tell(self, text: str, time: float) -> None:
        """Show a sentence until it is read, or the next key comes."""
        self._told = text, time

    def _now(self, kind: str) -> list[str]:
        return list(self._lately.get(kind, ()))


def _doing(shown: Shown) -> tuple[str, str]:
    """Return what the robot does, in a word, and its style."""
    if shown.output.twist != STOP:
        if shown.output.stale:
            return "stopping: no key", _WARN
        return ("stopping", _WARN) if shown.state.command == STOP else ("driving", _GOOD)
    if not shown.output.stale and shown.state.command != STOP:
        return "held back", _WARN
    waits = math.isinf(shown.state.command_time)
    return ("press a key", _GOOD) if waits else ("at rest", _DIM)


def _heads(first: str, *names: str) -> Text:
    return Text(first.ljust(_LABEL) + "".join(name.rjust(_NUMBER) for name in names), _DIM)


def _row(label: str, *values: float, digits: int = 3) -> Text:
    numbers = "".join(_number(value, digits) for value in values)
    return Text.assemble((label.ljust(_LABEL), _DIM), numbers)


def _number(value: float | None, digits: int) -> str:
    """Return a number in ten characters, with fewer digits where it is large."""
    if value is None:
        return "-".rjust(_NUMBER)
    text = f"{value:.{digits}f}"
    if len(text) > _NUMBER - 1:
        text = f"{value:.3g}"
    if float(text) == 0:
        text = text.lstrip("-")
    return text.rjust(_NUMBER)


def _short(text: str, width: int) -> str:
    return (text if len(text) <= width else text[: width - 2] + "..").ljust(width)


def _scale(window: Window, ascii_only: bool) -> str:
    """Return a bar of a round length, with the length."""
    length = next(
        step for step in (k * 10.0**n for n in range(-4, 5) for k in (1, 2, 5))
        if step / window.size >= 10
    )  # fmt: skip
    cells = max(round(length / window.size / 2), 3)
    ends = "|-|" if ascii_only else "├─┤"
    return f" {ends[0]}{ends[1] * (cells - 2)}{ends[2]} {length:g} m "


class Screen:
    """A terminal on which only the lines that changed are drawn again."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last: list[Text] = []
        self._size = (0, 0)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in characters."""
        return self._console.size.width, self._console.size.height

    def draw(self, lines: Sequence[Text], size: tuple[int, int]) -> None:
        """Show lines made for a size."""
        console = self._console
        with console:  # written at once
            if size != self._size:
                console.control(Control.clear(), Control.home())
                self._last, self._size = [], size
            for i, line in enumerate(lines):
                if i >= len(self._last) or self._last[i] != line:
                    console.control(Control.move_to(0, i))
                    console.print(line, end="", no_wrap=True, overflow="crop", soft_wrap=False)
        self._last = list(lines)


@contextmanager
def screen(console: Console) -> Iterator[Screen]:
    """Give the whole terminal, without cursor; what was there comes back, whatever ends this."""
    console.set_alt_screen(True)
    console.show_cursor(False)
    try:
        yield Screen(console)
    finally:
        console.show_cursor(True)
        console.set_alt_screen(False)
