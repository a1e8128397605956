"""Documents as one HTML file that needs nothing else: formulas are MathML."""

from __future__ import annotations

import html
import re
from functools import cache
from typing import Any

from trundle.symbolic.document.page import CSS
from trundle.symbolic.document.parts import DOLLAR, Document, Law, Step, Table, Value
from trundle.symbolic.document.tex import formula_rows
from trundle.symbolic.latex import to_latex

# Brackets are drawn as borders: without a font for mathematics they would not grow.
_BRACKETED = re.compile(
    r'<mo stretchy="true" fence="true" form="prefix">\[</mo>(<mtable>(?:(?!<mtable>).)*?</mtable>)'
    r'<mo stretchy="true" fence="true" form="postfix">\]</mo>',
    re.DOTALL,
)
_THIN = '<mspace width="0.17em" />'
# The name of a function keeps a thin space from the factor before it.
_FUNCTION = re.compile(r"(<msup>)?(<mi>(?:sin|cos|tan)</mi>)")
_BARE = re.compile(r"(<mi>(?:sin|cos|tan)</mi>)(?=<mi>|<msub>)")


def render_html(document: Document) -> str:
    """Return a document as one HTML file.

    >>> print(render_html(Document("Robot", "A sentence.", ())).splitlines()[0])
    <!DOCTYPE html>
    """
    title = html.escape(document.title)
    body = [f"<h1>{title}</h1>"]
    body += [f"<p>{_text(document.summary)}</p>"] if document.summary else []
    if len(document.sections) > 1:
        items = [
            f'<li><a href="#s{i}">{html.escape(each.heading)}</a></li>'
            for i, each in enumerate(document.sections)
        ]
        body.append(f"<nav><ol>{''.join(items)}</ol></nav>")
    for i, section in enumerate(document.sections):
        body.append(f'<section id="s{i}">\n<h2>{html.escape(section.heading)}</h2>')
        body += [_step(step) for step in section.steps]
        body.append("</section>")
    head = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8" />\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1" />\n'
        f"<title>{title}</title>\n<style>\n{CSS}</style>\n</head>\n<body>\n<main>\n"
    )
    page = head + "\n".join(body) + "\n</main>\n</body>\n</html>\n"
    return page.replace(DOLLAR, "$")


def _step(step: Step) -> str:
    out = [f"<h3>{_text(step.heading)}</h3>"] if step.heading else []
    out += [f"<p>{_text(part)}</p>" for part in step.text.split("\n") if part]
    out += [f'<div class="formula">{_formula(formula)}</div>' for formula in step.formulas]
    if step.table:
        out.append(_table(step.table))
    return "\n".join(out)


def _formula(formula: Law | Value) -> str:
    return "\n".join(mathml(row, display=True) for row in formula_rows(formula))


@cache
def mathml(latex: str, display: bool = False) -> str:
    """Return LaTeX as MathML.

    >>> mathml("a").partition(">")[2]
    '<mrow><mi>a</mi></mrow></math>'
    """
    from latex2mathml.converter import convert

    made = str(convert(latex, display="block" if display else "inline"))
    before = ""
    while before != made:  # a matrix in a matrix takes another turn
        before, made = made, _BRACKETED.sub(_as_matrix, made)
    made = _FUNCTION.sub(rf"{_THIN}\1\2", made)
    return _BARE.sub(rf"\1{_THIN}", made)


def _as_matrix(found: re.Match[str]) -> str:
    return found.group(1).replace("<mtable>", '<mtable class="matrix">', 1)


def _table(table: Table) -> str:
    head = "".join(f"<th>{_text(cell)}</th>" for cell in table.head)
    rows = "\n".join(
        f"<tr>{''.join(f'<td>{_cell(cell)}</td>' for cell in row)}</tr>" for row in table.rows
    )
    return (
        f'<div class="table"><table>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{rows}\n</tbody></table></div>"
    )


def _cell(cell: Any) -> str:
    return _text(cell) if isinstance(cell, str) else mathml(to_latex(cell))


def _text(sentence: str) -> str:
    """Return sentences with the LaTeX between dollar signs as MathML."""
    parts = sentence.split("$")
    return "".join(mathml(part) if i % 2 else html.escape(part) for i, part in enumerate(parts))
