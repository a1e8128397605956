"""Wheel speeds in the units of motors, and encoder counters as turns of the wheels."""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.limits import IMPLAUSIBLE
from trundle.robot import Encoder, Robot

_RPM = 60.0 / math.tau
# Counters that do not wrap around count up to this.
_LARGEST = 1 << 53
# Characters of a refused value that are told.
_WORDS = 60

Numbers = tuple[float, ...]


class Units:
    """The radii and gears of a robot's driven wheels.

    All values have the motors' signs: with ``reversed`` a positive one drives backwards.
    """

    def __init__(self, robot: Robot, encoder: Encoder | None) -> None:
        self._radii = tuple(wheel.radius for wheel in robot.driven)
        encoders = [wheel.encoder or encoder for wheel in robot.driven]
        shafts = [w.motor or e for w, e in zip(robot.driven, encoders, strict=True)]
        self._gears = tuple(1.0 if shaft is None else shaft.gear for shaft in shafts)
        self._per_tick = tuple(0.0 if e is None else 1.0 / e.radians_per_tick for e in encoders)

    def rim_speeds(self, speeds: Sequence[float]) -> Numbers:
        """Return the speeds of the wheels' rims [m/s]: radius times wheel speed."""
        return tuple(radius * speed for radius, speed in zip(self._radii, speeds, strict=True))

    def rpm(self, speeds: Sequence[float]) -> Numbers:
        """Return the wheels' turns per minute."""
        return tuple(_RPM * speed for speed in speeds)

    def motor_rpm(self, speeds: Sequence[float]) -> Numbers:
        """Return the motor shafts' turns per minute, before the gear."""
        return tuple(_RPM * gear * speed for gear, speed in zip(self._gears, speeds, strict=True))

    def ticks(self, speeds: Sequence[float], dt: float) -> Numbers:
        """Return the encoder ticks of a cycle of dt [s]; 0 for a wheel without an encoder."""
        return tuple(dt * per * speed for per, speed in zip(self._per_tick, speeds, strict=True))


class Counters:
    """The counters of a robot's sensed wheels, which wrap around.

    Args:
        robot: the robot.
        encoder: that of wheels without one of their own, or None.
        bits: width of the counters; None for counters that never wrap around.
        without: names of wheels that are not read.
    """

    def __init__(
        self, robot: Robot, encoder: Encoder | None, bits: int | None, without: frozenset[str]
    ) -> None:
        if bits is not None and not (isinstance(bits, int | np.integer) and 8 <= bits <= 64):
            raise TrundleError(f"counter_bits must be from 8 to 64, or None, got {bits!r}")
        self._turns = 0 if bits is None else 1 << int(bits)
        self._read = tuple(wheel.name not in without for wheel in robot.sensed)
        encoders = [wheel.encoder or encoder for wheel in robot.sensed]
        self.resolutions = tuple(0.0 if e is None else e.radians_per_tick for e in encoders)
        self.missing = tuple(
            wheel.name
            for wheel, e in zip(robot.sensed, encoders, strict=True)
            if e is None and wheel.name not in without
        )
        self._all_read = all(self._read) and not self.missing
        self._range = (-self._turns // 2, self._turns) if bits else (-_LARGEST, _LARGEST)
        self._limited = tuple(
            (i, IMPLAUSIBLE * wheel.max_speed, self.resolutions[i])
            for i, wheel in enumerate(robot.sensed)
            if wheel.driven and wheel.max_speed
        )

    def read(self, counts: Any) -> tuple[int, ...] | None:
        """Return counts as whole numbers, or None where they are none or beyond the counters.

        Counters may be shown signed or unsigned. Wheels that are not read show 0.
        """
        low, high = self._range
        if self._all_read and type(counts) is tuple and len(counts) == len(self._read):
            for value in counts:
                if type(value) is not int or not low <= value < high:
                    break
            else:
                return counts  # as a control loop gives them: nothing is to be done
        try:
            values = tuple(items(counts, len(self._read)))
            found = [
                (value if type(value) is int else _whole(value)) if read else 0
                for value, read in zip(values, self._read, strict=True)
            ]
        except Exception:  # noqa: BLE001 - whatever a stranger's object raises, it is refused
            return None
        if self.missing or not all(low <= value < high for value in found):
            return None
        return tuple(found)

    def fault(self, counts: Any) -> str:
        """Return what is wrong with counts that cannot be read."""
        if self.missing:
            return f"counts: no encoder is known of {', '.join(map(repr, self.missing))}"
        wide = f"of {self._turns.bit_length() - 1} bits" if self._turns else ""
        return f"counts {shown(counts)}: not {len(self._read)} whole numbers {wide}".rstrip()

    def turned(self, before: tuple[int, ...], now: tuple[int, ...]) -> Numbers:
        """Return the turns [rad] of the wheels between two readings.

        Of the differences that wrapping around leaves open, the smallest is taken.
        """
        whole, half = self._turns, self._turns // 2
        each = zip(before, now, self.resolutions, strict=True)
        if not whole:
            return tuple([(b - a) * size for a, b, size in each])
        return tuple([((b - a + half) % whole - half) * size for a, b, size in each])

    def plausible(self, turned: Numbers, time: float) -> bool:
        """Return whether the wheels can have turned so far in a time [s]."""
        for i, largest, tick in self._limited:
            if abs(turned[i]) > largest * time + 2 * tick:
                return False
        return True


def _whole(value: Any) -> int:
    """Return a whole number.

    Raises:
        TypeError: it is none.
    """
    if isinstance(value, bool):
        raise TypeError
    try:
        return operator.index(value)
    except TypeError:
        if float(value).is_integer() and not isinstance(value, str | bytes):
            return int(value)
        raise


def items(values: Any, count: int) -> Iterable[Any]:
    """Return the items of a list, tuple, array or the like, at most one more than wanted.

    Raises:
        TypeError: there is no order in it, or it is a text.
    """
    if type(values) is tuple:
        return values
    if isinstance(values, str | bytes | bytearray | Mapping | Set):
        raise TypeError
    if hasattr(values, "tolist"):
        values = values.tolist()
    return itertools.islice(values, count + 1)


def shown(value: Any) -> str:
    """Return a value in words, not too many of them."""
    try:
        text = repr(value)
    except Exception:  # noqa: BLE001 - a stranger's object
        text = f"of type {type(value).__name__}"
    return text if len(text) <= _WORDS else f"{text[: _WORDS - 3]}..."
