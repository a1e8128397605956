"""Documents as LaTeX: a whole file that compiles."""

from __future__ import annotations

import re
from typing import Any

from trundle.symbolic.document.layout import Line, lines_of, signed
from trundle.symbolic.document.parts import DOLLAR, Document, Law, Step, Table, Value
from trundle.symbolic.latex import to_latex

_HEAD = r"""\documentclass[a4paper,10pt]{article}
\usepackage[margin=18mm]{geometry}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage{amsmath,amssymb,array,longtable}
\setcounter{MaxMatrixCols}{24}
\setlength{\parindent}{0pt}
\setlength{\parskip}{0.5em}
\allowdisplaybreaks
"""
_SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "#": r"\#", "_": r"\_", "{": r"\{",
    "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "$": r"\$",
}  # fmt: skip


def render_latex(document: Document) -> str:
    r"""Return a document as a complete LaTeX file.

    >>> print(render_latex(Document("Robot", "A sentence.", ())).splitlines()[0])
    \documentclass[a4paper,10pt]{article}
    """
    body = [rf"\title{{{_text(document.title)}}}", r"\date{}", r"\begin{document}", r"\maketitle"]
    body += [_text(document.summary), ""] if document.summary else []
    for section in document.sections:
        body += ["", rf"\section*{{{_text(section.heading)}}}"]
        for step in section.steps:
            body += _step(step)
    return _HEAD + "\n".join([*body, r"\end{document}", ""]).replace(DOLLAR, r"\$")


def _step(step: Step) -> list[str]:
    heading = [rf"\paragraph{{{_text(step.heading)}}}"] if step.heading else []
    text = [_text(step.text).replace("\n", "\n\n")] if step.text else []
    out = ["", *heading, *text]
    for formula in step.formulas:
        out += [r"\[", formula_latex(formula), r"\]"]
    if step.table:
        out += _table(step.table)
    return out


def formula_latex(formula: Law | Value) -> str:
    r"""Return a formula as LaTeX without delimiters; several lines become an array.

    >>> import sympy
    >>> formula_latex(Value("x", sympy.Symbol("a") / 2))
    'x = \\frac{a}{2}'
    """
    rows = formula_rows(formula)
    if len(rows) == 1:
        return rows[0]
    return "\\begin{array}{l}\n" + " \\\\[4pt]\n".join(rows) + "\n\\end{array}"


def formula_rows(formula: Law | Value) -> list[str]:
    """Return the lines of a formula as LaTeX."""
    if isinstance(formula, Law):
        return [formula.latex]
    return [row for line in lines_of(formula) for row in _rows(line)]


def _rows(line: Line) -> list[str]:
    first = f"{line.left} = {to_latex(line.parts[0])}"
    if line.numbers is not None:
        first += f" = {to_latex(line.numbers)}"
    out = [first]
    for part in line.parts[1:]:
        sign, rest = signed(part)
        out.append(rf"\qquad {sign} {to_latex(rest)}")
    return [*out, rf"\text{{({line.note})}}"] if line.note else out


def _table(table: Table) -> list[str]:
    columns = "l" * (len(table.head) - 1) + r">{\raggedright\arraybackslash}p{0.4\linewidth}"
    rows = [" & ".join(_cell(cell) for cell in row) + r" \\" for row in table.rows]
    head = " & ".join(rf"\textbf{{{_cell(cell)}}}" for cell in table.head) + r" \\ \hline"
    return [rf"\begin{{longtable}}{{{columns}}}", head, *rows, r"\end{longtable}"]


def _cell(cell: Any) -> str:
    return _text(cell) if isinstance(cell, str) else f"${to_latex(cell)}$"


def _text(sentence: str) -> str:
    """Return sentences with special signs escaped, but for the LaTeX between dollar signs."""
    parts = sentence.split("$")
    return "".join(f"${part}$" if i % 2 else _escaped(part) for i, part in enumerate(parts))


def _escaped(text: str) -> str:
    return re.sub(r"[\\&%#_{}~^$]", lambda found: _SPECIAL[found.group(0)], text)
