"""Straight-line programs: one text of a calculation that Python runs and other languages print."""

from __future__ import annotations

import itertools
import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trundle.se2 import Array

# Coefficients that differ by this much of their size are one number, and one this small beside its
# row is zero: the maps come from pseudo-inverses, whose last digits are rounding.
_ROUNDING = 1e-14
# A size this near to a short decimal is that decimal: a few units in the last place.
_LAST_DIGIT = 1e-15
_NAME = re.compile(r"[A-Za-z_]\w*")

FUNCTIONS = ("sin", "cos", "sqrt", "hypot", "atan2")


@dataclass(frozen=True)
class Straight:
    """A program without branches and loops: lines that name values, and results.

    Expressions have names, numbers as ``repr`` writes floats, ``+ - * /``, parentheses and calls of
    ``sin``, ``cos``, ``sqrt``, ``hypot`` and ``atan2``: the same text is Python and C.

    Attributes:
        name: name of the function.
        arguments: names of its arguments.
        lines: pairs (name, expression), each of the arguments and of names above it; each name is
            given once and used.
        results: expressions of what it returns.

    >>> half = Straight("half", ("x",), (("t0", "0.5 * x"),), ("t0", "-t0"))
    >>> half.compile()(3.0)
    (1.5, -1.5)
    """

    name: str
    arguments: tuple[str, ...]
    lines: tuple[tuple[str, str], ...]
    results: tuple[str, ...]

    def compile(self, module: Any = math) -> Callable[..., tuple[Any, ...]]:
        """Return the function that runs the lines and returns the results.

        Args:
            module: where sines and roots come from: math for floats, numpy for arrays.
        """
        source = "\n".join(
            [
                f"def make({', '.join(FUNCTIONS)}):",
                f"    def {self.name}({', '.join(self.arguments)}):",
                *(f"        {name} = {expression}" for name, expression in self.lines),
                f"        return ({''.join(f'{result}, ' for result in self.results)})",
                f"    return {self.name}",
            ]
        )
        scope: dict[str, Any] = {}
        exec(source, scope)
        functions = [getattr(module, each, None) for each in FUNCTIONS[:-1]]
        atan2 = getattr(module, "atan2", None) or module.arctan2
        made: Callable[..., tuple[Any, ...]] = scope["make"](*functions, atan2)
        return made


@dataclass
class Code:
    """Lines of a straight-line program, in which values that recur are named once."""

    lines: list[tuple[str, str]] = field(default_factory=list)
    _named: dict[str, str] = field(default_factory=dict)

    def name(self, expression: str) -> str:
        """Return the name of an expression's value, computing it at most once."""
        if expression.isidentifier() or _is_number(expression):
            return expression
        if expression not in self._named:
            self._named[expression] = f"t{len(self._named)}"
            self.lines.append((self._named[expression], expression))
        return self._named[expression]

    def product(self, *factors: str) -> str:
        """Return the name of a product of names and numbers, or the number that it is."""
        numbers = [float(each) for each in factors if not each.isidentifier()]
        names = sorted(each for each in factors if each.isidentifier())
        size = math.prod(numbers)
        if not size:
            return "0.0"
        if not names:
            return repr(size)
        return self.name(" * ".join(names if size == 1 else [repr(size), *names]))

    def sum(self, *terms: str, minus: Sequence[str] = ()) -> str:
        """Return the name of a sum of names and numbers less others, or the number that it is."""
        number = sum(float(each) for each in terms if not each.isidentifier())
        number -= sum(float(each) for each in minus if not each.isidentifier())
        plus = [repr(number)] * (number != 0) + [each for each in terms if each.isidentifier()]
        less = [each for each in minus if each.isidentifier()]
        text = " + ".join(plus) + "".join(f" - {each}" for each in less)
        if not less:
            return text if len(plus) == 1 else self.name(text) if plus else "0.0"
        return self.name(text if plus else f"-{text[3:]}")

    def program(self, name: str, arguments: Sequence[str], results: Sequence[str]) -> Straight:
        """Return the program of the lines that its results need."""
        needed = {used for result in results for used in _NAME.findall(result)}
        kept = []
        for line in reversed(self.lines):
            if line[0] in needed:
                kept.append(line)
                needed.update(_NAME.findall(line[1]))
        return Straight(name, tuple(arguments), tuple(reversed(kept)), tuple(results))

    def linear(self, matrix: Array, inputs: Sequence[str]) -> list[str]:
        """Return expressions for ``matrix @ inputs``.

        A factor that a whole row shares is taken out of it; other products are named, since
        another row often needs them with the same or the other sign.
        """
        rows, factors = [], []
        names = list(dict.fromkeys(inputs))
        if len(names) < len(inputs):
            columns = [[matrix[:, i] for i, n in enumerate(inputs) if n == name] for name in names]
            matrix = np.stack([np.sum(each, axis=0) for each in columns], axis=-1)
        for row in _without_rounding(matrix).tolist():
            sizes = {abs(coefficient) for coefficient in row if coefficient}
            shared = sizes.pop() if len(sizes) == 1 else 1.0
            factors.append(shared)
            rows.append(self._terms([coefficient / shared for coefficient in row], names))
        self._share_pairs(rows)
        return [self._sum(terms, factor) for terms, factor in zip(rows, factors, strict=True)]

    def _terms(self, row: Sequence[float], inputs: Sequence[str]) -> dict[str, int]:
        """Return a row as named terms with their signs."""
        terms = {}
        for coefficient, name in zip(row, inputs, strict=True):
            if size := abs(coefficient) * (name != "0.0"):
                term = name if size == 1 else self.name(f"{size!r} * {name}")
                terms[term] = 1 if coefficient > 0 else -1
        return terms

    def _share_pairs(self, rows: list[dict[str, int]]) -> None:
        """Replace the pair of terms that most rows share, up to sign, until none recurs."""
        while True:
            pairs = Counter(
                (a, b, row[a] * row[b])
                for row in rows
                for a, b in itertools.combinations(sorted(row), 2)
            )
            if not pairs or max(pairs.values()) < 2:
                return
            a, b, sign = max(pairs, key=pairs.__getitem__)
            sharing = [row for row in rows if row.get(a, 0) * row.get(b, 0) == sign]
            # Of a - b and b - a, the one that more rows add: the others subtract it.
            if sum(row[b] - row[a] for row in sharing) > 0:
                a, b = b, a
            total = self.name(f"{a} {'+' if sign > 0 else '-'} {b}")
            for row in sharing:
                row[total] = row.pop(a)
                del row[b]

    def _sum(self, terms: dict[str, int], factor: float) -> str:
        if not terms:
            return "0.0"
        if len(terms) == 1 and factor != 1:
            [(term, sign)] = terms.items()
            return f"{sign * factor!r} * {term}"
        # A positive term goes first, where there is one: it needs no negation.
        ordered = sorted(terms.items(), key=lambda each: -each[1])
        text = "".join(f" {'+' if sign > 0 else '-'} {term}" for term, sign in ordered)
        text = text[3:] if text.startswith(" + ") else f"-{text[3:]}"
        if factor == 1:
            return text
        return f"{factor!r} * ({text})"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _without_rounding(matrix: Array) -> Array:
    """Return a matrix in which sizes that differ by rounding are equal: 1.0, not 1 - 2e-16."""
    largest = np.abs(matrix).max(axis=-1, keepdims=True, initial=0.0)
    kept = np.where(np.abs(matrix) > _ROUNDING * largest, np.abs(matrix), 0.0)
    sizes, at = np.unique(kept, return_inverse=True)
    first = np.flatnonzero(np.diff(sizes, prepend=0.0) > _ROUNDING * sizes)
    for group in np.split(sizes, first)[1:]:
        middle = float(np.median(group))
        decimal = float(f"{middle:.14g}")
        group[:] = decimal if math.isclose(decimal, middle, rel_tol=_LAST_DIGIT) else middle
    return np.asarray(np.copysign(sizes[at.reshape(matrix.shape)], matrix))
