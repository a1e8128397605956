"""Symbols for a robot's sizes and angles, each with its number for this robot."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import sympy

# Degrees and lengths that differ by less than rounding are the same.
_DIGITS = 11


class Quantity(NamedTuple):
    """A symbol, its number for this robot in SI units, and what it stands for."""

    symbol: Any
    value: float
    unit: str
    meaning: str


def exact(value: float) -> Any:
    """Return a number as the fraction that its shortest decimal form says.

    >>> exact(0.15)
    3/20
    """
    return sympy.Rational(repr(float(value)))


def exact_angle(angle: float) -> Any | None:
    """Return an angle whose sine is a plain root as a fraction of pi, or None.

    These are the multiples of 15 degrees.

    >>> exact_angle(math.radians(-45)), exact_angle(math.radians(40))
    (-pi/4, None)
    """
    steps = math.degrees(angle) / 15
    if not same(steps, round(steps)):
        return None
    turned = round(steps) % 24
    return sympy.Rational(turned - 24 * (turned > 12), 12) * sympy.pi


_ORDER = ("a", "l", "d", "kappa", "alpha", "theta", "phi")


class Namer:
    """The symbols given so far: one for each size, found again by its number.

    With ``shared``, lengths of different kinds that are equal have one symbol too.
    """

    def __init__(self, shared: bool = False) -> None:
        self.shared = shared
        self.quantities: dict[str, Quantity] = {}

    def length(self, name: str, value: float, meaning: str) -> Any:
        """Return the symbol of a length between contact points and origin."""
        for each in self.quantities.values() if self.shared else ():
            if each.unit == "m" and same(each.value, value) and each.symbol.name[0] != "a":
                return each.symbol
        return self.symbol(name, value, "m", meaning, positive=True)

    def angle(self, name: str, value: float, meaning: str) -> Any:
        """Return an angle as a fraction of pi where it is one, else as a symbol."""
        known = exact_angle(value)
        if known is not None:
            return known
        letter = name.partition("_")[0]
        for each in self.quantities.values():
            if each.symbol.name.partition("_")[0] != letter:
                continue
            for sign in (1, -1):
                # The same line, the same way or backwards.
                turn = exact_angle(value - sign * each.value)
                if turn is not None and turn % sympy.pi == 0:
                    return sign * each.symbol + turn
        return self.symbol(name, value, "rad", meaning, real=True)

    def in_order(self) -> tuple[Quantity, ...]:
        """Return the symbols as a table lists them: radii, lengths, angles."""

        def place(each: Quantity) -> tuple[int, str]:
            return _ORDER.index(each.symbol.name.partition("_")[0]), each.symbol.name

        return tuple(sorted(self.quantities.values(), key=place))

    def symbol(self, name: str, value: float, unit: str, meaning: str, **what: bool) -> Any:
        """Return the symbol of this name, entered with its number."""
        made = Quantity(sympy.Symbol(name, **what), value, unit, meaning)
        return self.quantities.setdefault(name, made).symbol


def same(a: float, b: float) -> bool:
    """Return whether two sizes differ by rounding only."""
    return math.isclose(a, b, rel_tol=10.0**-_DIGITS, abs_tol=10.0**-_DIGITS)
