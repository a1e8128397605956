"""What the command shows: tables for people, JSON for machines."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.padding import Padding
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from trundle.errors import FileError
from trundle.se2 import Array


class _Console(Console):
    """A console for which a reader that has seen enough, as head does, is no fault."""

    def on_broken_pipe(self) -> None:
        """End quietly."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(0)


out = _Console(highlight=False)
err = Console(stderr=True, highlight=False)

_AXES = ("u [m/s]", "v [m/s]", "r [rad/s]")


def print_json(value: Any) -> None:
    """Print one JSON value, the only thing on stdout; nan becomes null."""
    print(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def plain(value: Any) -> Any:
    """Return arrays, numbers, paths and tuples as what JSON knows."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return (value or 0.0) if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def figure(value: float) -> str:
    """Return a number for reading: six digits, and no minus before zero."""
    return f"{0.0 if abs(value) < 5e-13 else value:.6g}"


def heading(text: str) -> None:
    """Print a heading."""
    out.print()
    out.print(Text(text, style="bold"))


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> None:
    """Print a table whose first ``left`` columns are words and the others numbers."""
    made = Table(
        box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0), show_header=any(columns)
    )
    for i, name in enumerate(columns):
        made.add_column(Text(name), justify="left" if i < left else "right", overflow="fold")
    for row in rows:
        made.add_row(*(Text(cell) for cell in row))
    out.print(made)


def sentence(*parts: str | tuple[str, str]) -> None:
    """Print a sentence, indented where it wraps."""
    out.print(Padding(Text.assemble(*parts), (0, 0, 0, 2)))


def verbatim(command: str, remark: str = "") -> None:
    """Print a command or a path to be copied: in one line however narrow the terminal."""
    out.print(Text.assemble("  ", command, (remark, "dim")), soft_wrap=True)


def matrix(values: Array, columns: Sequence[str]) -> None:
    """Print a (3, n) matrix with the names of its rows and columns."""
    shown = [[figure(value) for value in row] for row in values]
    width = max(len(text) for text in (*columns, *(cell for row in shown for cell in row), "")) + 2
    block = max((out.width - 3) // width, 1)
    for first in range(0, max(len(columns), 1), block):
        part = slice(first, first + block)
        rows = [[axis[0], *row[part]] for axis, row in zip(_AXES, shown, strict=True)]
        table(["", *columns[part]], rows)


def twist(*named: tuple[str, Array]) -> None:
    """Print twists side by side."""
    rows = [[axis, *(figure(values[i]) for _, values in named)] for i, axis in enumerate(_AXES)]
    table(["", *(name for name, _ in named)], rows)


def folder(path: Path | None) -> Path | None:
    """Return the output folder, made if need be.

    Raises:
        FileError: it cannot be made or written to.
    """
    if path is None:
        return None
    try:
        if path.is_file():
            raise FileError(f"{path}: nothing can be written there: it is a file, not a folder")
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".trundle"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileError(
            f"{path}: nothing can be written there: {error.strerror or error}"
        ) from None
    return path


def write(path: Path, text: str) -> None:
    """Write a text to a file.

    Raises:
        FileError: it cannot be written.
    """
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None


def told_files(files: Sequence[Path]) -> None:
    """Print which files were written."""
    if files:
        heading("Files")
        for file in files:
            verbatim(str(file))


def progress(quiet: bool) -> Progress:
    """Return a progress bar on stderr, which goes away when done."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TimeRemainingColumn(),
        console=err,
        transient=True,
        disable=quiet or not err.is_terminal,
    )
