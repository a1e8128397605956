"""The keyboard, key by key: termios on Linux and macOS, msvcrt on Windows."""

from __future__ import annotations

import os
import re
import select
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_WINDOWS_ARROWS = {"H": "up", "P": "down", "M": "right", "K": "left"}
_NAMES = {"\x03": "interrupt", "\x1a": "suspend", "\x1b": "escape", " ": "space"}
# Escape sequences of terminals: ESC [ parameters and a last letter, or ESC O and a letter.
_SEQUENCE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*([@-~])|O(.))", re.DOTALL)
# An escape key comes alone; what a terminal sends for an arrow comes at once.
_ALONE = 0.05
# How often a keyboard that cannot be waited for is looked at [s].
_LOOK = 0.002
# A cycle as late as this comes after the program was suspended [s].
_PAUSE = 1.0
_SMOOTH = 0.05


class Keyboard(Protocol):
    """What gives the keys that were pressed."""

    def read(self, timeout: float) -> list[str]:
        """Return the keys pressed since the last call, waiting for one up to a time [s].

        A key is its character, or its name: up, down, left, right, space, escape, interrupt
        (Ctrl-C), suspend (Ctrl-Z).
        """


@contextmanager
def keyboard() -> Iterator[Keyboard]:
    """Give the keyboard, without echo and without waiting for whole lines.

    The terminal is as it was when this ends, whatever ends it.
    """
    if sys.platform == "win32":
        yield _WindowsKeyboard()
        return
    import termios

    stream = sys.stdin.fileno()
    try:
        before = termios.tcgetattr(stream)
    except termios.error:
        raise EOFError from None
    try:
        termios.tcsetattr(stream, termios.TCSADRAIN, _raw(termios, before))
        yield _Terminal(stream)
    finally:
        with suppress(termios.error):  # the terminal may have gone
            termios.tcsetattr(stream, termios.TCSADRAIN, before)


def _raw(termios: Any, before: list[Any]) -> list[Any]:
    """Return a terminal's settings with which keys come at once and unseen.

    Ctrl-C and Ctrl-Z come as keys, too: they end and suspend in good order.
    """
    iflag, oflag, cflag, lflag, *speeds, characters = before
    lflag &= ~(termios.ECHO | termios.ICANON | termios.ISIG | termios.IEXTEN)
    iflag &= ~(termios.ICRNL | termios.IXON)
    characters = list(characters)
    characters[termios.VMIN], characters[termios.VTIME] = 1, 0
    return [iflag, oflag, cflag, lflag, *speeds, characters]


class _Terminal:
    def __init__(self, stream: int) -> None:
        self._stream = stream

    def read(self, timeout: float) -> list[str]:
        text = self._text(timeout)
        while text.endswith(("\x1b", "\x1b[", "\x1bO")) and (more := self._text(_ALONE)):
            text += more
        return list(keys_of(text))

    def _text(self, timeout: float) -> str:
        if not select.select([self._stream], [], [], max(timeout, 0.0))[0]:
            return ""
        data = os.read(self._stream, 1024)
        if not data:  # the terminal has gone
            raise EOFError
        return data.decode(errors="ignore")


def keys_of(text: str) -> Iterator[str]:
    r"""Yield the keys in what a terminal sends; sequences of other keys are left out.

    >>> list(keys_of("i\x1b[A \x1b[5~\x1bOD\x1b"))
    ['i', 'up', 'space', 'left', 'escape']
    """
    at = 0
    while at < len(text):
        found = _SEQUENCE.match(text, at)
        if found:
            at = found.end()
            if name := _ARROWS.get(found[1] or found[2]):
                yield name
            continue
        yield _NAMES.get(text[at], text[at])
        at += 1


class _WindowsKeyboard:
    def read(self, timeout: float) -> list[str]:
        import msvcrt

        console: Any = msvcrt
        end = time.monotonic() + timeout
        while not console.kbhit() and time.monotonic() < end:
            time.sleep(_LOOK)
        keys = []
        while console.kbhit():
            key = console.getwch()
            if key in "\x00\xe0":
                key = _WINDOWS_ARROWS.get(console.getwch(), "")
            if key:
                keys.append(_NAMES.get(key, key))
        return keys


class Clock:
    """Cycles of equal length, and the keys that come between them.

    A cycle that comes late does not delay the next one; time in which the program was suspended
    does not count.

    Args:
        period: of the cycles [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._begin = self._last = time.perf_counter()
        self._next = self._begin + period
        self._mean = period

    def wait(self, keys: Keyboard) -> list[str]:
        """Return the keys pressed until the next cycle begins."""
        pressed = keys.read(0.0)
        while (left := self._next - time.perf_counter()) > 0:
            pressed += keys.read(left)
        return pressed

    def time(self) -> float:
        """Return the time of the cycle that begins now [s], and set the next one."""
        now = time.perf_counter()
        gap = now - self._last
        if gap > _PAUSE:
            self._begin += gap - self._period
            gap = self._period
        self._last, self._next = now, self._next + self._period
        if self._next < now:
            self._next = now + self._period
        self._mean += _SMOOTH * (gap - self._mean)
        return now - self._begin

    @property
    def rate(self) -> float:
        """Cycles in a second, over the last few [Hz]."""
        return 1.0 / self._mean
