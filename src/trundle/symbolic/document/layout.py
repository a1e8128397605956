"""Where a formula breaks: a wide matrix is told entry by entry, a long sum line by line."""

from __future__ import annotations

import dataclasses
import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy.printing.pretty.pretty import PrettyPrinter

from trundle.symbolic.document.parts import Value
from trundle.symbolic.document.plain_math import plain_math
from trundle.symbolic.latex import to_latex

# Columns of text for a formula.
ROOM = 100
_ZEROS = "the other entries are zero"
_PRINTER = {"use_unicode": True, "wrap_line": False, "full_prec": False}


@dataclass(frozen=True, eq=False)
class Line:
    """``left = part + part = numbers``: one line, or one for each part.

    Attributes:
        left: LaTeX.
        parts: expressions whose sum is the right-hand side, one a line; or one matrix.
        numbers: the same with numbers, on the same line, or None.
        note: words after it.
    """

    left: str
    parts: tuple[Any, ...]
    numbers: Any = None
    note: str = ""


def left_latex(value: Value) -> str:
    """Return the left-hand side as LaTeX."""
    return value.left if isinstance(value.left, str) else to_latex(value.left)


@lru_cache(maxsize=2048)
def lines_of(value: Value) -> tuple[Line, ...]:
    """Return the lines in which ``left = right`` is written.

    >>> a = sympy.Symbol("a")
    >>> [line.left for line in lines_of(Value("W", sympy.Matrix([[a] * 3])))]
    ['W']
    >>> long = sympy.Matrix([[sympy.sin(a + i) ** i for i in range(12)]])
    >>> [line.left for line in lines_of(Value("W", long))][1:3]
    ['W_{1,2}', 'W_{1,3}']
    """
    left = left_latex(value)
    used = width(plain_math(left)) + 3
    right = value.right
    if used + pretty_width(right) > ROOM:
        right = right.as_explicit() if isinstance(right, sympy.MatMul) else right
        lines = _entries(left, right) if _is_matrix(right) else [Line(left, _broken(right, used))]
        return (*lines, *_number_lines(left, value.numbers))
    if value.numbers is None:
        return (Line(left, (right,)),)
    if used + pretty_width(right) + 3 + pretty_width(value.numbers) <= ROOM:
        return (Line(left, (right,), value.numbers),)
    return (Line(left, (right,)), *_number_lines(left, value.numbers))


def _number_lines(left: str, numbers: Any) -> list[Line]:
    if numbers is None:
        return []
    used = width(plain_math(left)) + 3
    if used + pretty_width(numbers) <= ROOM:
        return [Line(left, (numbers,))]
    return _entries(left, numbers) if _is_matrix(numbers) else [Line(left, _broken(numbers, used))]


def _is_matrix(expression: Any) -> bool:
    return isinstance(expression, sympy.MatrixBase)


def _entries(left: str, matrix: Any) -> list[Line]:
    """Return a line for each entry that is not zero."""
    lines = []
    for i in range(matrix.rows):
        for j in range(matrix.cols):
            if matrix[i, j] != 0:
                comma = "," if max(matrix.shape) > 9 else ""
                index = f"{i + 1}" if matrix.cols == 1 else f"{i + 1}{comma}{j + 1}"
                name = entry_name(left, index)
                lines.append(Line(name, _broken(matrix[i, j], width(plain_math(name)) + 3)))
    if len(lines) < len(matrix):
        lines[-1] = dataclasses.replace(lines[-1], note=_ZEROS)
    return lines


def entry_name(left: str, index: str) -> str:
    r"""Return the LaTeX of an entry's name.

    >>> entry_name("W", "12"), entry_name("n_{0}", "3")
    ('W_{12}', '\\left(n_{0}\\right)_{3}')
    """
    whole = left if re.fullmatch(r"\\?[A-Za-z]+", left) else rf"\left({left}\right)"
    return f"{whole}_{{{index}}}"


def _broken(expression: Any, used: int) -> tuple[Any, ...]:
    """Return an expression as parts of its sum, each of which fits in a line if it can."""
    if used + pretty_width(expression) <= ROOM:
        return (expression,)
    parts: list[Any] = []
    for term in _terms(expression, used):
        if parts and used + pretty_width(parts[-1] + term) <= ROOM:
            parts[-1] = parts[-1] + term
        else:
            parts.append(term)
    return tuple(parts)


def _terms(expression: Any, used: int) -> list[Any]:
    """Return the terms of a sum, or of a product with one sum; wide ones taken apart further."""
    if expression.is_Mul:
        sums = [each for each in expression.args if each.is_Add]
        if len(sums) != 1:
            return [expression]
        factor = sympy.Mul(*(each for each in expression.args if not each.is_Add))
        terms = [factor * term for term in sums[0].as_ordered_terms()]
    elif expression.is_Add:
        terms = list(expression.as_ordered_terms())
    else:
        return [expression]
    return [
        part
        for term in terms
        for part in ([term] if used + pretty_width(term) <= ROOM else _terms(term, used))
    ]


def signed(part: Any) -> tuple[str, Any]:
    """Return the sign that a part of a sum begins with, and what follows it.

    A sum that begins with a minus keeps it, and the sign is empty.

    >>> a, b = sympy.symbols("a b")
    >>> signed(-a), signed(a - b), signed(b - 2 * a)
    (('-', a), ('+', a - b), ('', -2*a + b))
    """
    if part.is_Add:
        first = part.as_ordered_terms()[0]
        return ("" if first.could_extract_minus_sign() else "+"), part
    return ("-", -part) if part.could_extract_minus_sign() else ("+", part)


def pretty_form(expression: Any) -> Any:
    """Return sympy's two-dimensional form of an expression: lines and a baseline."""
    return PrettyPrinter(_PRINTER)._print(expression)


def pretty_width(expression: Any) -> int:
    """Return how many columns an expression takes."""
    return int(pretty_form(expression).width())


def width(text: str) -> int:
    """Return how many columns a text takes; accents take none.

    >>> width("q\u0307 = 1")
    5
    """
    return sum(not unicodedata.combining(sign) for sign in text)
