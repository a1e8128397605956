"""Derivations as documents: what stands in them, and how they are written out."""

from trundle.symbolic.document.codes import LANGUAGES, code, functions
from trundle.symbolic.document.html import render_html
from trundle.symbolic.document.parts import Document, Law, Section, Step, Table, Value
from trundle.symbolic.document.tex import render_latex
from trundle.symbolic.document.text import render_text
from trundle.symbolic.document.write import TOPICS, document

__all__ = [
    "LANGUAGES",
    "TOPICS",
    "Document",
    "Law",
    "Section",
    "Step",
    "Table",
    "Value",
    "code",
    "document",
    "functions",
    "render_html",
    "render_latex",
    "render_text",
]
