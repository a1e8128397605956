"""What a document is made of: sections of steps, each with a sentence and formulas."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, NamedTuple

# Stands for a dollar sign of the user's in a text, where others begin and end LaTeX.
DOLLAR = "\ue000"


def literal(text: str) -> str:
    """Return a user's text, such as a name, so that it stands in a sentence as it is.

    >>> literal("US$ robot") == "US$ robot"
    False
    """
    return " ".join(text.split()).replace("$", DOLLAR)


@dataclass(frozen=True)
class Law:
    """A formula that holds for every robot, in LaTeX.

    Of LaTeX it uses what ``plain_math`` reads.
    """

    latex: str


@dataclass(frozen=True, eq=False)
class Value:
    """``left = right``, and what that is with this robot's numbers.

    Attributes:
        left: LaTeX, or a sympy expression.
        right: a sympy expression or matrix.
        numbers: the same with numbers, or None.
    """

    left: Any
    right: Any
    numbers: Any = None


class Table(NamedTuple):
    """A table; its cells are text, in which ``$...$`` is LaTeX, or sympy expressions."""

    head: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True, eq=False)
class Step:
    """A step: a heading, sentences, and then formulas or a table.

    Attributes:
        heading: a few words; empty where the step goes on from the one before.
        text: sentences, in which ``$...$`` is LaTeX.
        formulas: what follows them.
        table: a table after the formulas.
        detail: whether it is shown only where every intermediate step is asked for.
    """

    heading: str
    text: str = ""
    formulas: tuple[Law | Value, ...] = ()
    table: Table | None = None
    detail: bool = False


@dataclass(frozen=True, eq=False)
class Section:
    """A heading and its steps."""

    heading: str
    steps: tuple[Step, ...]


@dataclass(frozen=True, eq=False)
class Document:
    """A title, a sentence, and sections."""

    title: str
    summary: str
    sections: tuple[Section, ...]

    def results(self) -> Document:
        """Return the document without the steps that are only details."""
        sections = tuple(
            Section(each.heading, tuple(step for step in each.steps if not step.detail))
            for each in self.sections
        )
        return dataclasses.replace(self, sections=sections)
