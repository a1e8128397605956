"""Trajectories from CSV files."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from trundle.errors import FileError
from trundle.motion.checks import SMALLEST
from trundle.motion.headings import HeadingChoice, Profile
from trundle.motion.points import through
from trundle.motion.splines import free_spline
from trundle.motion.trajectory import Trajectory
from trundle.se2 import Array

_TIME = ("t", "time")
_HEADING = ("psi", "psi_deg", "heading", "heading_deg")


def from_csv(path: str | Path, *, heading: HeadingChoice = None) -> Trajectory:
    r"""Return the trajectory through the rows of a CSV file.

    A cubic spline of time with continuous velocity and acceleration through all rows. Time counts
    from the first row. An end at which the spline would be slower than a quarter of the mean speed
    of its interval is taken as one at rest.

    Args:
        path: a file with a header and commas, semicolons or tabs. Columns ``t`` [s] (or ``time``),
            growing, ``x`` and ``y`` [m]; and for headings ``psi`` [rad] or ``psi_deg`` (or
            ``heading``, ``heading_deg``). Steps of psi beyond half a turn are taken as wrapped.
            Other columns are left out.
        heading: "path", "lecture", a number [rad], ``spin`` or ``profile`` in place of the file's;
            if left out the file's where it has some, otherwise "path".

    Raises:
        FileError: the file cannot be read or understood; file, line and column are named.
        TrundleError: the heading is not usable.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "line.csv")
    ...     _ = file.write_text("t,x,y\n0,0,1\n1,2,1\n2,4,1\n")
    ...     from_csv(file).velocity(0.5).round(9).tolist()
    [2.0, 0.0, 0.0]
    """
    path = Path(path)
    table = _read(path)
    time = table.column(_one_of(table, _TIME))
    if (back := np.flatnonzero(np.diff(time) < SMALLEST)).size:
        k = int(back[0])
        raise FileError(
            f"{path}: line {table.lines[k + 1]}: time must grow from row to row, got "
            f"{time[k + 1]:g} s after {time[k]:g} s"
        )
    time = time - time[0]
    curve = free_spline(time, np.column_stack([table.column("x"), table.column("y")]))
    named = [name for name in _HEADING if name in table.header]
    if heading is None and named:
        psi = table.column(named[0])
        psi = np.unwrap(np.radians(psi) if named[0].endswith("_deg") else psi)
        heading = Profile(free_spline(time, psi[:, None]))
    return through(f"spline through {len(time)} rows of {path.name}", curve, heading)


class _Table(NamedTuple):
    path: Path
    header: list[str]
    rows: list[list[str]]
    lines: list[int]  # in the file, of each row

    def column(self, name: str) -> Array:
        """Return a column as finite numbers."""
        if name not in self.header:
            raise FileError(f"{self.path}: no column {name!r}; it has {', '.join(self.header)}")
        index = self.header.index(name)
        out = np.empty(len(self.rows))
        for k, row in enumerate(self.rows):
            out[k] = _number(row[index])
            if not math.isfinite(out[k]):
                raise FileError(
                    f"{self.path}: line {self.lines[k]}, column {name!r}: {row[index]!r} is not a "
                    "finite number"
                )
        return out


def _one_of(table: _Table, names: tuple[str, ...]) -> str:
    return next((name for name in names if name in table.header), names[0])


def _read(path: Path) -> _Table:
    """Return header and rows of a file; empty lines are passed over."""
    rows, lines = _cells(path)
    if not rows or not all(math.isnan(_number(cell)) for cell in rows[0]):
        raise FileError(f"{path}: the first line must name the columns, such as t,x,y,psi")
    header = rows[0]
    if twice := [name for name in header if name and header.count(name) > 1]:
        raise FileError(f"{path}: the column {twice[0]!r} is there {header.count(twice[0])} times")
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(header):
            raise FileError(
                f"{path}: line {line} has {len(row)} cells, but there are {len(header)} columns "
                f"({', '.join(header)})"
            )
    if len(rows) < 3:
        raise FileError(f"{path}: a trajectory needs at least two rows, got {len(rows) - 1}")
    return _Table(path, header, rows[1:], lines[1:])


def _cells(path: Path) -> tuple[list[list[str]], list[int]]:
    """Return the cells of the lines that hold some, and the numbers of those lines."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(f"{path}: the file must be UTF-8 text") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    given = text.splitlines()
    first = given[0] if given else ""
    reader = csv.reader(given, delimiter=max(",;\t", key=first.count))
    rows, lines = [], []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells):
                rows.append(cells)
                lines.append(reader.line_num)
    except csv.Error as error:
        raise FileError(f"{path}: line {reader.line_num}: {error}") from None
    return rows, lines


def _number(cell: str) -> float:
    """Return a cell's number, nan where it holds none; 1_0 is Python's, not a table's."""
    try:
        return math.nan if "_" in cell else float(cell)
    except ValueError:
        return math.nan
