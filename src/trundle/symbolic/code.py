"""What a printed function computes: named matrices of groups of arguments."""

from __future__ import annotations

import keyword
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy

from trundle.errors import TrundleError


@dataclass(frozen=True)
class Group:
    """An array argument: its name, and the symbols that its entries are."""

    name: str
    symbols: tuple[Any, ...]


class Output(NamedTuple):
    """An array that a function gives: its name and its matrix; a vector has one column."""

    name: str
    matrix: Any
    vector: bool = False


@dataclass(frozen=True, eq=False)
class Function:
    """A function to be printed.

    Attributes:
        name: its name in the code.
        summary: one line that says what it computes.
        arguments: its array arguments.
        outputs: what it gives.

    Raises:
        TrundleError: a name is no identifier or is there twice, or a symbol is in no argument.

    >>> x = sympy.Symbol("x")
    >>> Function("f", "the square", (Group("q", (x,)),), (Output("y", sympy.Matrix([x])),)).name
    'f'
    """

    name: str
    summary: str
    arguments: tuple[Group, ...]
    outputs: tuple[Output, ...]

    def __post_init__(self) -> None:
        names = [self.name, *(each.name for each in self.arguments)]
        names += [each.name for each in self.outputs]
        symbols = [symbol for each in self.arguments for symbol in each.symbols]
        names += [symbol.name for symbol in symbols]
        for name in names:
            if not name.isidentifier() or keyword.iskeyword(name):
                raise TrundleError(f"{name!r} cannot be a name in code")
            if names.count(name) > 1:
                raise TrundleError(f"{name!r} is the name of two things in the code")
        used = set().union(*(each.matrix.free_symbols for each in self.outputs))
        if strangers := used - set(symbols):
            raise TrundleError(
                f"no argument holds {', '.join(sorted(str(each) for each in strangers))}"
            )


def common(function: Function, prefix: str = "t") -> tuple[list[tuple[Any, Any]], list[Any]]:
    """Return sub-expressions that come back, with new symbols, and the outputs in terms of them.

    >>> x = sympy.Symbol("x")
    >>> f = Function("f", "", (Group("q", (x,)),), (Output("y", sympy.Matrix([x**2, x**2 + 1])),))
    >>> common(f)
    ([(t0, x**2)], [Matrix([
    [    t0],
    [t0 + 1]])])
    """
    taken = {each.name for each in function.outputs} | {function.name}
    taken |= {each.name for each in function.arguments}
    taken |= {str(symbol) for each in function.arguments for symbol in each.symbols}
    fresh: Iterator[Any] = sympy.numbered_symbols(prefix, real=True)
    matrices = [sympy.Matrix(each.matrix) for each in function.outputs]
    parts, reduced = sympy.cse(matrices, symbols=(s for s in fresh if s.name not in taken))
    return parts, reduced


def used_symbols(parts: Sequence[tuple[Any, Any]], reduced: Sequence[Any]) -> set[Any]:
    """Return the symbols that the printed lines read."""
    expressions = [value for _, value in parts] + list(reduced)
    return set().union(*(expression.free_symbols for expression in expressions))
