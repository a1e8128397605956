"""Numbers on the command line: negative ones without ``--``, lists after an option."""

from __future__ import annotations

import math
import os
import re
import sys
from typing import Any

import typer
from typer.core import TyperCommand

# A minus sign that the option parser does not take for an option; people may type it too.
_MINUS = "\u2212"
# Options that take several numbers at once.
_LISTS = ("--steering-deg", "--wheel-speeds")
_NEGATIVE = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)


def number(text: Any) -> float:
    """Return a finite number; anything else is the user's mistake."""
    if isinstance(text, float):
        return text
    shown = str(text).replace(_MINUS, "-")
    try:
        value = float(shown)
    except ValueError:
        raise typer.BadParameter(f"{shown!r} is not a number") from None
    if not math.isfinite(value):
        raise typer.BadParameter(f"{shown!r} is not a finite number")
    return value


def positive(text: Any) -> float:
    """Return a positive number."""
    if (value := number(text)) <= 0:
        raise typer.BadParameter(f"must be positive, got {value:g}")
    return value


def _is_number(text: str) -> bool:
    try:
        float(text.replace(_MINUS, "-"))
    except ValueError:
        return False
    return True


class NumbersCommand(TyperCommand):
    """A command whose numbers may be negative, and whose list options take several at once.

    ``--steering-deg 20 -17``, ``--steering-deg 20,-17`` and the option given twice are the same.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Spread lists of numbers over repeated options, and hide the minus of numbers."""
        spread: list[str] = []
        current, fresh = "", False
        for arg in args:
            name, equals, value = arg.partition("=")
            if arg in _LISTS:
                current, fresh = arg, True
                continue
            if equals and name in _LISTS:
                current, fresh, arg = name, True, value
            parts = [part for part in re.split(r"[,\s]+", arg) if part] or [arg]
            if current and (fresh or all(map(_is_number, parts))):
                spread += [item for part in parts for item in (current, _hide(part))]
                # A list in one argument is whole; numbers after it are something else.
                current, fresh = "" if equals or len(parts) > 1 else current, False
            else:
                current = ""
                spread.append(_hide(arg))
        return super().parse_args(ctx, spread + [current] * fresh)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; a reader that has seen enough, as head does, is no fault."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit from None


def _hide(arg: str) -> str:
    return _MINUS + arg[1:] if _NEGATIVE.match(arg) else arg
