"""Logs of wheel motion from CSV files.

A column's name tells what it holds: ``time``, the truth ``x``, ``y``, ``psi`` (or ``psi_deg``),
``steering:WHEEL`` (or ``steering_deg:WHEEL``), and for each sensed wheel ``READING:WHEEL``, where
READING is one of ``READINGS``.
"""

from __future__ import annotations

import csv
import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trundle.errors import FileError
from trundle.robot import Robot, RollingWheel
from trundle.se2 import Array

READINGS: dict[str, str] = {
    "counts": "running tick counter",
    "ticks": "ticks since the row before",
    "angle": "wheel angle [rad]",
    "radians": "turn since the row before [rad]",
    "turns": "turns since the row before",
    "speed": "wheel speed since the row before [rad/s]",
    "rpm": "wheel speed since the row before [rev/min]",
}
_RUNNING = ("counts", "angle")
_RATES = ("speed", "rpm")
SKIP = "-"
# Widths of counters. More than half their range in one row, and never out of it, is rather a
# wrap-around than a motion.
_WIDTHS = (16, 32)


@dataclass(frozen=True, eq=False)
class Log:
    """A recorded motion: T + 1 rows, and the wheels' turning between them.

    Attributes:
        time: (T + 1,) [s], or None.
        wheel_increments: (T, k) turn of the sensed wheels between rows [rad].
        steering: (T, s) steering angles at the middle of the intervals [rad], or None.
        truth: (T + 1, 3) measured x, y, psi [m, m, rad], or None.
    """

    time: Array | None
    wheel_increments: Array
    steering: Array | None
    truth: Array | None


def read_log(
    path: str | Path,
    robot: Robot,
    columns: Sequence[str] | None = None,
    rename: Mapping[str, str] | None = None,
    counter_bits: int | None = None,
) -> Log:
    """Return the log in a CSV file, for the sensed wheels of a robot.

    Args:
        path: a file with commas, semicolons or tabs; a header row unless ``columns`` is given.
        robot: the robot that was recorded; ticks need the wheels' encoders.
        columns: names of all columns of a file without a header, "-" for those to skip.
        rename: names of columns in the file, by the names that they should have.
        counter_bits: width of ``counts`` that wrap around, such as 16.

    Raises:
        FileError: the file cannot be read, a column is missing, a cell is no finite number, or
            time goes backwards; file, line and column are named.
    """
    path = Path(path)
    header, table, first_line = _read_table(path, columns)
    names = {given: name for name, given in (rename or {}).items()}
    if strangers := [given for given in names if given not in header]:
        raise FileError(f"{path}: no column {strangers[0]!r}; it has {', '.join(header)}")
    header = [names.get(name, name) for name in header]
    _check_header(path, header)
    rows = _Rows(path, header, table, first_line)
    time = rows.column("time") if "time" in header else None
    if time is not None and (back := np.flatnonzero(np.diff(time) < 0)).size:
        k = int(back[0])
        raise FileError(
            f"{path}: time goes backwards in line {first_line + k + 1}: "
            f"{time[k + 1]:g} s after {time[k]:g} s"
        )
    turning = [_turning(rows, wheel, time, counter_bits) for wheel in robot.sensed]
    if not turning:
        raise FileError(f"robot {robot.name!r} has no sensed wheel")
    return Log(
        time=time,
        wheel_increments=np.column_stack(turning),
        steering=_steering(rows, robot),
        truth=_truth(rows),
    )


@dataclass(frozen=True)
class _Rows:
    path: Path
    header: list[str]
    table: list[list[str]]
    first_line: int

    def column(self, name: str) -> Array:
        """Return a column as finite numbers."""
        index = self.header.index(name)
        out = np.empty(len(self.table))
        for k, row in enumerate(self.table):
            out[k] = _number(row[index])
            if not math.isfinite(out[k]):
                raise FileError(
                    f"{self.path}: line {self.first_line + k}, column {name!r}: "
                    f"{row[index]!r} is not a finite number"
                )
        return out

    def one_of(self, *names: str) -> str | None:
        """Return the name that the header has, or None."""
        return next((name for name in names if name in self.header), None)


def _read_table(
    path: Path, columns: Sequence[str] | None
) -> tuple[list[str], list[list[str]], int]:
    """Return header, rows of cells and the line number of the first row."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(f"{path}: the file must be UTF-8 text") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
    lines = text.splitlines()
    start = lines[0] if lines else ""
    delimiter = max(",;\t", key=start.count)
    try:
        table = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    except csv.Error as error:
        raise FileError(f"{path}: this is not a table: {error}") from None
    while table and not any(table[-1]):
        table.pop()
    if columns is not None:
        header, first_line = [name.strip() for name in columns], 1
    elif table and all(math.isnan(_number(cell)) for cell in table[0]):
        header, table, first_line = table[0], table[1:], 2
    else:
        raise FileError(
            f"{path}: the file has no header: name its columns (--columns), such as {_example()}"
        )
    if len(table) < 2:
        raise FileError(f"{path}: a log needs at least two rows, got {len(table)}")
    for k, row in enumerate(table):
        if len(row) != len(header):
            raise FileError(
                f"{path}: line {first_line + k} has {len(row)} cells, but there are "
                f"{len(header)} columns ({', '.join(header)})"
            )
    return header, table, first_line


def _number(cell: str) -> float:
    """Return a cell's number, nan where it holds none; 1_0 is Python's, not a log's."""
    try:
        return math.nan if "_" in cell else float(cell)
    except ValueError:
        return math.nan


def _example() -> str:
    return "time,x,y,psi,ticks:left,ticks:right"


def _check_header(path: Path, header: list[str]) -> None:
    named = [name for name in header if name != SKIP]
    twice = sorted({name for name in named if named.count(name) > 1})
    if twice:
        raise FileError(f"{path}: the column {twice[0]!r} is there {named.count(twice[0])} times")


def _turning(
    rows: _Rows, wheel: RollingWheel, time: Array | None, counter_bits: int | None
) -> Array:
    """Return how far a wheel turned between the rows (T,) [rad]."""
    name = rows.one_of(*(f"{reading}:{wheel.name}" for reading in READINGS))
    if name is None:
        close = difflib.get_close_matches(wheel.name, rows.header, n=1)
        hint = f" Is it {close[0]!r}? Then --map ticks:{wheel.name}={close[0]}." if close else ""
        raise FileError(
            f"{rows.path}: no column for wheel {wheel.name!r}: name one READING:{wheel.name}, "
            f"where READING is {', '.join(READINGS)}; the file has {', '.join(rows.header)}.{hint}"
        )
    reading = name.split(":")[0]
    values = rows.column(name)
    moved = np.diff(values) if reading in _RUNNING else values[1:]
    if reading in ("counts", "ticks"):
        if wheel.encoder is None:
            raise FileError(
                f"{rows.path}: column {name!r} holds ticks, but wheel {wheel.name!r} has no "
                "encoder: add encoder = { ticks_per_motor_turn = ..., gear = ... } to it"
            )
        if reading == "counts":
            moved = _unwrapped(rows, name, values, counter_bits)
        return np.asarray(moved * wheel.encoder.radians_per_tick)
    if reading in _RATES:
        if time is None:
            raise FileError(f"{rows.path}: column {name!r} is a speed, which needs a time column")
        return np.asarray(moved * np.diff(time) * (1.0 if reading == "speed" else math.tau / 60))
    return np.asarray(moved * (math.tau if reading == "turns" else 1.0))


def _unwrapped(rows: _Rows, name: str, counts: Array, bits: int | None) -> Array:
    """Return how far a running counter moved between the rows, wrap-around taken out."""
    moved = np.diff(counts)
    if bits is None:
        far = int(np.argmax(np.abs(moved)))
        for width in _WIDTHS:
            half = 2.0 ** (width - 1)
            inside = counts.min() >= -half and counts.max() < 2 * half
            if inside and abs(moved[far]) > half:
                raise FileError(
                    f"{rows.path}: line {rows.first_line + far + 1}, column {name!r}: the counter "
                    f"leaps by {moved[far]:.0f} ticks in one row; say counter_bits={width} "
                    f"(--counter-bits {width}) if it wraps around, 64 if it does not"
                )
        return moved
    span = 2.0**bits
    if counts.min() < -span / 2 or counts.max() >= span:
        raise FileError(
            f"{rows.path}: column {name!r} holds counts from {counts.min():.0f} to "
            f"{counts.max():.0f}, which no counter of {bits} bits does"
        )
    return np.asarray(moved - span * np.round(moved / span))


def _steering(rows: _Rows, robot: Robot) -> Array | None:
    columns = []
    for wheel in robot.steered:
        plain, degrees = f"steering:{wheel.name}", f"steering_deg:{wheel.name}"
        name = rows.one_of(plain, degrees)
        if name is None:
            raise FileError(
                f"{rows.path}: no column for the steering angle of wheel {wheel.name!r}: name it "
                f"{plain} [rad] or {degrees}; the file has {', '.join(rows.header)}"
            )
        values = rows.column(name)[1:]
        columns.append(np.radians(values) if name == degrees else values)
    return np.column_stack(columns) if columns else None


def _truth(rows: _Rows) -> Array | None:
    heading = rows.one_of("psi", "psi_deg")
    found = [name for name in ("x", "y") if name in rows.header] + ([heading] if heading else [])
    if not found:
        return None
    if len(found) < 3:
        raise FileError(
            f"{rows.path}: truth needs x, y and psi (or psi_deg); only {', '.join(found)} are there"
        )
    truth = np.column_stack([rows.column(name) for name in found])
    if heading == "psi_deg":
        truth[:, 2] = np.radians(truth[:, 2])
    return truth
