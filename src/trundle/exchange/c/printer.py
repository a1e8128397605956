"""Straight-line programs as C99 functions."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from trundle.errors import TrundleError
from trundle.kinematics import Straight

_WIDTH = 92
_TOKEN = re.compile(
    r"(?P<number>(?:\d+\.\d*|\d+(?=e))(?:e[+-]?\d+)?)"
    r"|(?P<name>[A-Za-z_]\w*)|(?P<sign>[-+*/(),])|(?P<space> +)"
)
# trundle.c defines these as the functions of math.h for its type of number.
_FUNCTIONS = {"sin": "SIN", "cos": "COS", "sqrt": "SQRT", "hypot": "HYPOT", "atan2": "ATAN2"}
# Beyond these a float is zero or infinite, and so is a double on an AVR.
_LEAST, _LARGEST = 1.2e-38, 3.4e38


class Slots(NamedTuple):
    """An array argument of a C function: its name, and how many numbers it has."""

    name: str
    size: int


def function(
    straight: Straight, name: str, arguments: Sequence[Slots], results: Sequence[Slots]
) -> str:
    """Return the C function that runs a straight-line program from arrays to arrays.

    An array that is both argument and result is read before it is written.

    Args:
        straight: the program.
        name: name of the C function.
        arguments: arrays that hold the program's arguments, in order.
        results: arrays that take its results, in order.

    >>> from trundle.kinematics import Straight
    >>> made = Straight("turn", ("u", "r"), (("t0", "0.5 * r"),), ("sin(t0) + u", "-t0"))
    >>> print(function(made, "turn", [Slots("twist", 2)], [Slots("out", 2)]))
    void turn(const trundle_real twist[2], trundle_real out[2])
    {
        const trundle_real u = twist[0];
        const trundle_real r = twist[1];
        const trundle_real t0 = R(0.5) * r;
        out[0] = SIN(t0) + u;
        out[1] = -t0;
    }
    <BLANKLINE>
    """
    places = [f"{each.name}[{i}]" for each in arguments for i in range(each.size)]
    texts = [*(text for _, text in straight.lines), *straight.results]
    read = set().union(*map(_names, texts))
    body = [
        f"const trundle_real {argument} = {place};"
        for argument, place in zip(straight.arguments, places, strict=True)
        if argument in read
    ]
    body += [f"const trundle_real {line} = {expression(text)};" for line, text in straight.lines]
    filled = [f"{each.name}[{i}]" for each in results for i in range(each.size)]
    body += [
        f"{place} = {expression(text)};"
        for place, text in zip(filled, straight.results, strict=True)
    ]
    text = "\n".join(body)
    for each in arguments:
        if f"{each.name}[" not in text:
            body.insert(0, f"(void){each.name};")
    return "\n".join(
        [prototype(name, arguments, results), "{", *(wrapped(line) for line in body), "}", ""]
    )


def prototype(name: str, arguments: Sequence[Slots], results: Sequence[Slots]) -> str:
    """Return a function's head; an array that is argument and result is there once."""
    both = [each for each in arguments if each in results]
    only = [f"const {_slots(each)}" for each in arguments if each not in both]
    out = [_slots(each) for each in results if each not in both]
    return head(name, [*map(_slots, both), *only, *out])


def _slots(each: Slots) -> str:
    return f"trundle_real {each.name}[{each.size}]"


def head(name: str, parameters: Sequence[str]) -> str:
    """Return the head of a function without result, broken between parameters where it is long."""
    kept = ", ".join(each.replace(" ", "\0") for each in parameters)
    return wrapped(f"void {name}({kept})", indent="").replace("\0", " ")


def expression(text: str) -> str:
    """Return the expression of a straight-line program as C.

    Raises:
        TrundleError: it holds something else than names, numbers, + - * / and known functions.

    >>> expression("0.05 * hypot(t0, 1e-07)")
    'R(0.05) * HYPOT(t0, R(1e-07))'
    """
    return "".join(_printed(text))


def number(value: float) -> str:
    """Return a number as a constant in C.

    Raises:
        TrundleError: it is no number, or so large or small that a float cannot hold it.

    >>> number(0.05), number(-2.0), number(1e-50)
    ('R(0.05)', 'R(-2.0)', 'R(0.0)')
    """
    if not abs(value) < _LARGEST:
        raise TrundleError(f"the number {value:g} is too large for a float in C")
    return f"R({value!r})" if abs(value) > _LEAST else "R(0.0)"


def _printed(text: str) -> Iterator[str]:
    for kind, token, called in _tokens(text):
        if kind == "number":
            yield number(float(token))
        elif called:
            if token not in _FUNCTIONS:
                raise TrundleError(f"there is no {token}() in the printed C, in {text!r}")
            yield _FUNCTIONS[token]
        else:
            yield token


def _tokens(text: str) -> Iterator[tuple[str, str, bool]]:
    """Yield kind and text of each token, and whether it is a name that is called."""
    at = 0
    while at < len(text):
        found = _TOKEN.match(text, at)
        if found is None:
            raise TrundleError(f"{text[at:]!r} cannot be printed as C, in {text!r}")
        at = found.end()
        kind = found.lastgroup or ""
        yield kind, found[0], kind == "name" and text.startswith("(", at)


def _names(text: str) -> set[str]:
    return {token for kind, token, called in _tokens(text) if kind == "name" and not called}


def wrapped(line: str, indent: str = "    ") -> str:
    """Return a line of C, indented, and broken between its words where it is long."""
    return textwrap.fill(
        line,
        _WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}    ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def remark(text: str) -> str:
    """Return a sentence as a comment of C, broken where it is long."""
    return textwrap.fill(
        f"/* {text} */",
        _WIDTH,
        subsequent_indent=" * ",
        break_long_words=False,
        break_on_hyphens=False,
    )
