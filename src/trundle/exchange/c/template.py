"""Texts with marked places, filled in: ``@NAME@``, and lines for some robots only."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from importlib import resources

_MARK = re.compile(r"^//: (?:if (?P<word>\w+)|(?P<other>else)|(?P<end>end))$")
_PLACE = re.compile(r"@([A-Z_]+)@")


def template(name: str) -> str:
    """Return the text of a template file."""
    return (resources.files(__package__) / "templates" / name).read_text(encoding="utf-8")


def filled(text: str, places: Mapping[str, str], true: Collection[str]) -> str:
    """Return a text with its places filled, and with the lines whose condition is true.

    A line ``//: if WORD`` starts lines that are kept where the word is among the true ones, up to
    ``//: else`` or ``//: end``; such lines may stand inside others.

    >>> print(
    ...     filled(
    ...         '''a @B@
    ... //: if odd
    ... c
    ... //: else
    ... d
    ... //: end''',
    ...         {"B": "bee"},
    ...         true=(),
    ...     )
    ... )
    a bee
    d
    """
    kept: list[bool] = []
    out = []
    for line in text.split("\n"):
        mark = _MARK.match(line)
        if mark is None:
            if all(kept):
                out.append(_PLACE.sub(lambda found: places[found[1]], line))
        elif mark["word"]:
            kept.append(mark["word"] in true)
        elif mark["other"]:
            kept[-1] = not kept[-1]
        else:
            kept.pop()
    return "\n".join(out)
