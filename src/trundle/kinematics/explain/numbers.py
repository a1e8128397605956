"""Numbers, points and linear combinations as text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from trundle.robot import Wheel

# Names of the twist's components.
TWIST = ("u", "v", "r")
# Coefficients this much smaller than the rest of their row are rounding.
ZERO = 1e-9


def number(value: float) -> str:
    """Return a number in four digits.

    >>> number(0.0353553)
    '0.03536'
    """
    return f"{value:.4g}"


def degrees(angle: float) -> str:
    """Return an angle [rad] in degrees.

    >>> degrees(-math.pi / 4)
    '-45 deg'
    """
    return f"{number(round(math.degrees(angle), 9) + 0.0)} deg"


def point(wheel: Wheel) -> str:
    """Return where a wheel stands.

    >>> from trundle.robot import BallWheel
    >>> point(BallWheel(name="ball", x=0.2, y=-0.0))
    '(0.2, 0) m'
    """
    # A picometre is the rounding of a cosine.
    x, y = (number(round(c, 12) + 0.0) for c in (wheel.x, wheel.y))
    return f"({x}, {y}) m"


def combination(coefficients: Iterable[float], names: Sequence[str]) -> str:
    """Return a linear combination, every term with its own coefficient.

    >>> combination([0.5, -1.0, 0.0], ["u", "v", "r"])
    '0.5 u - v'
    """
    return _each(_terms(coefficients, names))


def factored(coefficients: Iterable[float], names: Sequence[str]) -> str:
    """Return a linear combination; a size that all terms share is taken out.

    >>> factored([-0.5, 0.5], ["left", "right"])
    '0.5 (right - left)'
    """
    terms = _terms(coefficients, names)
    sizes = {number(abs(value)) for value, _ in terms}
    if len(sizes) != 1 or len(terms) == 1:
        return _each(terms)
    size = sizes.pop()
    sign = -1.0 if all(value < 0 for value, _ in terms) else 1.0
    # Those counted forwards come first: "right - left".
    terms.sort(key=lambda term: sign * term[0] < 0)
    inner = _signed((sign * value, name) for value, name in terms)
    outer = "" if size == "1" else f"{size} "
    if sign < 0 or outer:
        return f"{'-' if sign < 0 else ''}{outer}({inner})"
    return inner


def _terms(coefficients: Iterable[float], names: Sequence[str]) -> list[tuple[float, str]]:
    """Return the coefficients that are not rounding, with their names."""
    values = [float(value) for value in coefficients]
    largest = max(map(abs, values), default=0.0)
    return [(v, name) for v, name in zip(values, names, strict=True) if abs(v) > ZERO * largest]


def _each(terms: Iterable[tuple[float, str]]) -> str:
    sizes = ((value, number(abs(value)), name) for value, name in terms)
    return _signed(
        (value, name if size == "1" else f"{size} {name}") for value, size, name in sizes
    )


def _signed(terms: Iterable[tuple[float, str]]) -> str:
    """Return a sum; of a term's value only the sign counts."""
    text = "".join(f" {'+' if value > 0 else '-'} {term}" for value, term in terms)
    if not text:
        return "0"
    return text[3:] if text.startswith(" + ") else f"-{text[3:]}"
