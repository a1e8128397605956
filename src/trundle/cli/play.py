"""Keys and how long each is held, written down: a drive without a keyboard."""

from __future__ import annotations

import typer

from trundle.cli.driving import FASTER, MOVES, SLOWER, STOP, Desk, Hand, idle_keys
from trundle.cli.numbers import number
from trundle.errors import TrundleError
from trundle.robot import Robot

# A script drives at most so long, and then has so long to come to rest [s].
_LONGEST, _TO_REST = 3600.0, 60.0
# The end of a cycle may miss the end of a key by rounding.
_ROUNDING = 1e-9


def script_of(text: str) -> list[tuple[str, float]]:
    """Return the keys of ``--play`` and how long each is held [s]."""
    keys = []
    for word in text.split():
        key, _, held = word.rpartition(":") if ":" in word[1:] else (word, "", "0")
        if key not in (*MOVES, *FASTER, *SLOWER):
            raise TrundleError(f"--play: there is no key {key!r}; keys are {' '.join(MOVES)} + -")
        if key in MOVES and word == key:
            raise TrundleError(f"--play: how long is {key!r} held? Write {key}:1 for a second")
        if key not in MOVES and word != key:
            raise TrundleError(
                f"--play: {word!r}: + and - are pressed, not held: write {key} alone"
            )
        try:
            seconds = number(held)
        except typer.BadParameter as error:
            raise TrundleError(f"--play: {word!r}: {error}") from None
        if seconds < 0:
            raise TrundleError(f"--play: {word!r}: a key cannot be held for {seconds:g} s")
        keys.append((key, seconds))
    if sum(seconds for _, seconds in keys) > _LONGEST:
        raise TrundleError(f"--play drives for at most {_LONGEST:g} s")
    return keys


def play(desk: Desk, hand: Hand, keys: list[tuple[str, float]], period: float) -> None:
    """Hold one key after the other, then let go until the robot stands still."""
    cycle = 0
    end = 0.0
    for key, seconds in keys:
        end += seconds
        hand = hand.press(key, cycle * period)
        while (cycle + 1) * period <= end * (1 + _ROUNDING):
            cycle += 1
            desk.cycle(cycle * period, hand.command)
    last = cycle + _TO_REST / period
    while cycle < last:
        cycle += 1
        desk.cycle(cycle * period, STOP)
        if desk.rests:
            break


def unheard(robot: Robot, hand: Hand, keys: list[tuple[str, float]]) -> list[str]:
    """Return what a script's keys asked for in vain, a sentence for each reason."""
    idle = idle_keys(robot)
    told = []
    for key, _ in keys:
        pressed = hand.press(key, 0.0)
        if key in idle:
            told.append(idle[key])
        elif key not in MOVES and pressed.factor == hand.factor:
            which = "high" if key in FASTER else "low"
            told.append(f"the speed is as {which} as it may be: {key} does nothing")
        hand = pressed
    return list(dict.fromkeys(told))
