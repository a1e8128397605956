"""Documents as text for a terminal, at most 100 columns wide."""

from __future__ import annotations

import textwrap
import unicodedata
from typing import Any, NamedTuple

import sympy

from trundle.symbolic.document.layout import ROOM, Line, lines_of, pretty_form, signed, width
from trundle.symbolic.document.parts import DOLLAR, Document, Law, Step, Table, Value
from trundle.symbolic.document.plain_math import plain_math, plain_text
from trundle.symbolic.latex import to_latex

_WIDTH = 100
_INDENT = "    "
_GAP = "   "


class _Block(NamedTuple):
    """Lines of equal width, and which of them stands level with the text around."""

    lines: list[str]
    level: int


def render_text(document: Document) -> str:
    """Return a document as text.

    >>> from trundle.symbolic.document.parts import Section
    >>> step = Step("Radius", "It is known.", (Value("a", sympy.Rational(1, 2)),))
    >>> print(render_text(Document("Robot", "", (Section("Sizes", (step,)),))))
    Robot
    =====
    <BLANKLINE>
    Sizes
    -----
    <BLANKLINE>
    Radius. It is known.
    <BLANKLINE>
        a = 1/2
    <BLANKLINE>
    """
    out = [document.title, "=" * len(document.title), ""]
    if document.summary:
        out += [*_wrapped(document.summary), ""]
    for section in document.sections:
        out += [section.heading, "-" * len(section.heading), ""]
        for step in section.steps:
            out += _step(step)
    return "\n".join(line.rstrip() for line in out).replace(DOLLAR, "$")


def _step(step: Step) -> list[str]:
    sentences = ". ".join(part for part in (step.heading, step.text) if part)
    out = [*_wrapped(sentences), ""] if sentences else []
    tall = True
    for formula in step.formulas:
        lines = formula_lines(formula)
        # Short formulas stand together, tall ones apart.
        if len(lines) == 1 and not tall:
            out.pop()
        tall = len(lines) > 1
        out += [*_indented(lines), ""]
    if step.table:
        out += [_INDENT + line for line in _table(step.table)]
        out.append("")
    return out


def _indented(lines: list[str]) -> list[str]:
    """Return lines a little to the right, or less so where they are wide."""
    room = _WIDTH - max(map(width, lines))
    return [_INDENT[:room] + line for line in lines] if room > 0 else lines


def _wrapped(sentences: str) -> list[str]:
    # Accents have no width, so that a line of them is a little shorter than it could be.
    return [
        line
        for paragraph in sentences.split("\n")
        for line in textwrap.wrap(plain_text(paragraph), _WIDTH, break_on_hyphens=False)
    ]


def formula_lines(formula: Law | Value) -> list[str]:
    """Return a formula as lines of text.

    >>> formula_lines(Value("x", sympy.Symbol("a") / 2))
    ['    a', 'x = ─', '    2']
    """
    if isinstance(formula, Law):
        return [plain_math(formula.latex)]
    out: list[str] = []
    for line in lines_of(formula):
        made = _line(line)
        # Tall lines need air between them.
        if out and (len(made) > 1 or out[-1:] != [""]) and len(made) > 1:
            out.append("")
        out += made
    return out


def _line(line: Line) -> list[str]:
    left = _Block([plain_math(line.left) + " = "], 0)
    first = _beside(left, _drawn(line.parts[0]))
    if line.numbers is not None:
        first = _beside(_beside(first, _Block([" = "], 0)), _drawn(line.numbers))
    out = _folded(first.lines)
    indent = " " * (width(left.lines[0]) - 2)
    for part in line.parts[1:]:
        sign, rest = signed(part)
        out += _folded(_beside(_Block([indent + (sign + "  ")[:2]], 0), _drawn(rest)).lines)
    return [*out, f"({line.note})"] if line.note else out


def _drawn(expression: Any) -> _Block:
    if isinstance(expression, sympy.Rational) and not expression.is_Integer:
        return _Block([str(expression)], 0)
    form = pretty_form(expression)
    lines = [str(line) for line in form.picture]
    most = max(map(width, lines))
    return _Block([line + " " * (most - width(line)) for line in lines], form.baseline)


def _beside(first: _Block, second: _Block) -> _Block:
    level = max(first.level, second.level)
    below = max(len(first.lines) - first.level, len(second.lines) - second.level)
    rows = []
    for block in (first, second):
        blank = " " * width(block.lines[0])
        above = [blank] * (level - block.level)
        under = [blank] * (below - len(block.lines) + block.level)
        rows.append([*above, *block.lines, *under])
    return _Block([a + b for a, b in zip(*rows, strict=True)], level)


def _folded(lines: list[str]) -> list[str]:
    """Return lines as they are, or cut into pieces where they are wider than the page."""
    if max(map(width, lines)) <= ROOM:
        return lines
    out: list[str] = []
    rest = lines
    while any(line.strip() for line in rest):
        if out:
            out.append("")
            rest = [_INDENT + line for line in rest]
        cuts = [_cut(line) for line in rest]
        out += [line[:cut].rstrip() for line, cut in zip(rest, cuts, strict=True)]
        rest = [line[cut:] for line, cut in zip(rest, cuts, strict=True)]
    return out


def _cut(line: str) -> int:
    """Return how many signs of a line fill the page's columns."""
    cut = min(len(line), ROOM)
    while cut < len(line) and (width(line[:cut]) < ROOM or unicodedata.combining(line[cut])):
        cut += 1
    return cut


def _table(table: Table) -> list[str]:
    rows = [[_cell(cell) for cell in row] for row in (table.head, *table.rows)]
    columns = range(len(table.head))
    most = [max(width(row[j]) for row in rows) for j in columns]
    last = _WIDTH - len(_INDENT) - sum(most[:-1]) - len(_GAP) * (len(most) - 1)
    most[-1] = min(most[-1], max(last, 20))
    out = []
    for row in rows:
        tail = textwrap.wrap(row[-1], most[-1], break_on_hyphens=False) or [""]
        cells = [cell + " " * (most[j] - width(cell)) for j, cell in enumerate(row[:-1])]
        out.append(_GAP.join([*cells, tail[0]]))
        blank = [" " * size for size in most[:-1]]
        out += [_GAP.join([*blank, more]) for more in tail[1:]]
    rule = "─" * min(sum(most) + len(_GAP) * (len(most) - 1), _WIDTH - len(_INDENT))
    return [out[0], rule, *out[1:]]


def _cell(cell: Any) -> str:
    if isinstance(cell, str):
        return plain_text(cell)
    return plain_math(to_latex(cell))
