"""A matrix in a text file, as people paste it from slides, papers and spreadsheets."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from trundle.errors import FileError
from trundle.se2 import Array


def read_matrix(path: str | Path) -> Array:
    """Return the matrix (rows, columns) in a text file.

    A line is a row, with numbers between semicolons, commas, spaces or tabs; in a line with
    semicolons a comma is a decimal comma. ``#`` starts a comment; a first line without any number
    is a header.

    Raises:
        FileError: the file cannot be read, is empty or ragged, or holds what is not a number.
    """
    path = Path(path)
    lines = _lines(path)
    if lines and not any(_is_number(field) for field in lines[0][1]):
        del lines[0]
    if not lines:
        raise FileError(f"{path}: there is no number in the file")
    first, rows = lines[0][0], []
    for line, fields in lines:
        where = f"{path}: line {line}"
        rows.append([_number(f"{where}, column {j}", text) for j, text in enumerate(fields, 1)])
    for (line, _), row in zip(lines, rows, strict=True):
        if len(row) != len(rows[0]):
            raise FileError(
                f"{path}: line {line} has {len(row)} numbers, but line {first} has "
                f"{len(rows[0])}: every row of a matrix has the same length"
            )
    return np.array(rows)


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Return the lines that are not empty, each with its place in the file and its fields."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(f"{path}: the file must be UTF-8 text") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    lines = ((i, _fields(line)) for i, line in enumerate(text.splitlines(), start=1))
    return [(i, fields) for i, fields in lines if fields]


def _fields(line: str) -> list[str]:
    # Slides and PDFs print a minus that is no hyphen.
    line = line.partition("#")[0].replace("\N{MINUS SIGN}", "-").strip()
    mark = next((mark for mark in ";," if mark in line), None)
    fields = [field.strip() for field in line.split(mark)]
    if mark and not fields[-1]:
        fields.pop()
    return [field.replace(",", ".") for field in fields] if mark == ";" else fields


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _number(where: str, field: str) -> float:
    if not field:
        raise FileError(f"{where}: a number is missing")
    if not _is_number(field):
        raise FileError(f"{where}: {field!r} is not a number")
    if not math.isfinite(float(field)):
        raise FileError(f"{where}: must be a finite number, got {field}")
    return float(field)
