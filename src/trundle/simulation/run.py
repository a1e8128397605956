"""A run: what a robot did over time, in memory and in files."""

from __future__ import annotations

import csv
import dataclasses
import json
import zipfile
import zlib
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.errors import FileError
from trundle.se2 import Array, step_arrays

_BROKEN = (csv.Error, zipfile.BadZipFile, zlib.error)
_POSE = ("x", "y", "psi")
_TWIST = ("u", "v", "r")
_FORCE = ("F_x", "F_y", "M_z")
_FLAT = ("t", "energy", "work")  # one number for each time
_NAMES = ("driven", "steered", "reports")


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated motion: poses at T + 1 times, and the commands over the T steps between them.

    Attributes:
        t: (T + 1,) [s].
        pose: (T + 1, 3) x, y, psi in the inertial frame [m, m, rad]; psi is not wrapped.
        twist: (T, 3) u, v, r in the body frame at the start of each step [m/s, m/s, rad/s].
        wheel_speeds: (T, n) at the start of each step [rad/s].
        steering: (T, s) at the start of each step [rad].
        wheel_angles: (T + 1, n) turn of the motors since the start [rad].
        driven: names of the n driven wheels.
        steered: names of the s steered wheels.

    Runs in closed loop have more, None elsewhere:

    Attributes:
        desired: (T + 1, 3) poses of the trajectory.
        error: (T + 1, 3) desired minus actual; the heading by the shorter way round, or the plain
            difference with the lectures' heading.
        torques: (T, n) of the motors at the wheels, within their limits [N m].
        force: (T, 3) commanded F_x, F_y, M_z in the inertial frame [N, N, N m].
        energy: (T + 1,) kinetic energy [J].
        work: (T + 1,) work of the motors since the start [J], to the order of the method, at most
            the second.
        saturated: (T, n) true where a motor was at its torque limit; in runs of commanded twists
            true for all wheels where the twist could not be had.
        reports: what went wrong, a sentence each.

    >>> from trundle import load, simulate
    >>> run = simulate(load("omni3"), wheel_speeds=[0.5, 0.5, 0.5], duration=3.0, dt=0.1)
    >>> round(float(run.pose[-1, 2]), 9)
    1.0
    """

    t: Array
    pose: Array
    twist: Array
    wheel_speeds: Array
    steering: Array
    wheel_angles: Array
    driven: tuple[str, ...]
    steered: tuple[str, ...]
    desired: Array | None = None
    error: Array | None = None
    torques: Array | None = None
    force: Array | None = None
    energy: Array | None = None
    work: Array | None = None
    saturated: Array | None = None
    reports: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        """Return whether the other is a run with the same names and numbers."""
        if not isinstance(other, Run):
            return NotImplemented
        names = (field.name for field in dataclasses.fields(self))
        return all(np.array_equal(getattr(self, n), getattr(other, n)) for n in names)

    __hash__ = None  # type: ignore[assignment]

    def pose_at(self, t: npt.ArrayLike) -> Array:
        """Return the poses (F, 3) at times (F,) [s] in between.

        On the arc of the step's twist where that leads to the next pose, as the exact method has
        it; on the straight line between two poses for the other methods.
        """
        t = np.clip(np.asarray(t, dtype=np.float64), self.t[0], self.t[-1])
        if len(self.twist) == 0:
            return np.broadcast_to(self.pose[0], (*t.shape, 3)).copy()
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.twist) - 1)
        since, start = t - self.t[k], self.pose[k]
        moved = self.twist[k] * since[:, None]
        arc = np.stack(step_arrays(*start.T, *moved.T), axis=-1)
        full = self.twist * np.diff(self.t)[:, None]
        ends = np.stack(step_arrays(*self.pose[:-1].T, *full.T), axis=-1)
        if np.allclose(ends, self.pose[1:], atol=1e-9):
            return arc
        return np.column_stack([np.interp(t, self.t, self.pose[:, i]) for i in range(3)])

    def save(self, path: str | Path) -> Path:
        """Write the run to a ``.csv`` or ``.npz`` file and return its path.

        The CSV has one row per time; the last row has no commands. Reports stand in the first row
        of a last column, as a JSON list.

        Raises:
            FileError: the file cannot be written, or its name has another ending.
        """
        path = Path(path)
        writer = {".csv": _to_csv, ".npz": _to_npz}.get(path.suffix)
        if writer is None:
            raise FileError(f"{path}: a run is saved as .csv or .npz")
        try:
            writer(self, path)
        except OSError as error:
            raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None
        return path

    @classmethod
    def load(cls, path: str | Path) -> Run:
        """Return the run that ``save`` wrote.

        Raises:
            FileError: the file cannot be read, or holds no run.
        """
        path = Path(path)
        reader = {".csv": _from_csv, ".npz": _from_npz}.get(path.suffix)
        if reader is None:
            raise FileError(f"{path}: a run is read from .csv or .npz")
        try:
            return reader(path)
        except OSError as error:
            raise FileError(f"{path}: cannot be read: {error.strerror or error}") from None
        except (ValueError, KeyError, IndexError, OverflowError, EOFError, *_BROKEN):
            raise FileError(
                f"{path}: this is not a run that trundle wrote, or not all of it"
            ) from None


# What runs in closed loop have, and others do not.
_LATER = {field.name for field in dataclasses.fields(Run) if field.default is not MISSING}


class _Block(NamedTuple):
    """Columns of the CSV: a field of the run, and what its columns are called."""

    field: str
    prefix: str
    names: tuple[str, ...]
    per_step: bool = False  # one row less than there are times


def _blocks(driven: tuple[str, ...], steered: tuple[str, ...]) -> list[_Block]:
    return [
        _Block("t", "", ("t",)),
        _Block("pose", "", _POSE),
        _Block("wheel_angles", "wheel_angle:", driven),
        _Block("twist", "", _TWIST, per_step=True),
        _Block("wheel_speeds", "wheel_speed:", driven, per_step=True),
        _Block("steering", "steering:", steered, per_step=True),
        _Block("desired", "desired:", _POSE),
        _Block("error", "error:", _POSE),
        _Block("torques", "torque:", driven, per_step=True),
        _Block("force", "", _FORCE, per_step=True),
        _Block("energy", "", ("energy",)),
        _Block("work", "", ("work",)),
        _Block("saturated", "saturated:", driven, per_step=True),
    ]


def _to_csv(run: Run, path: Path) -> None:
    blocks = [b for b in _blocks(run.driven, run.steered) if getattr(run, b.field) is not None]
    header = [block.prefix + name for block in blocks for name in block.names]
    tables = [np.asarray(getattr(run, block.field), dtype=np.float64) for block in blocks]
    columns = [(t if t.ndim == 2 else t[:, None]).tolist() for t in tables]
    told = [json.dumps(run.reports, ensure_ascii=False)] if run.reports else []
    reports = [*told, *[""] * len(run.t)] if told else []
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header + ["report"] * bool(reports))
        for k in range(len(run.t)):
            row: list[str] = []
            for table, block in zip(columns, blocks, strict=True):
                row += map(repr, table[k]) if k < len(table) else [""] * len(block.names)
            writer.writerow(row + reports[k : k + 1])


def _from_csv(path: Path) -> Run:
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    reports: tuple[str, ...] = ()
    if header[-1] == "report":
        reports = tuple(json.loads(rows[0][-1]))
        header, rows = header[:-1], [row[:-1] for row in rows]
    cells = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])

    def named(prefix: str) -> tuple[str, ...]:
        return tuple(n.removeprefix(prefix) for n in header if n.startswith(prefix))

    driven, steered = named("wheel_speed:"), named("steering:")
    values: dict[str, Any] = {}
    for block in _blocks(driven, steered):
        names = [block.prefix + name for name in block.names]
        if block.field in _LATER and not set(names) <= set(header):
            continue
        table = cells[: -1 if block.per_step else None, [header.index(name) for name in names]]
        values[block.field] = table[:, 0] if block.field in _FLAT else table
    if "saturated" in values:
        values["saturated"] = values["saturated"].astype(bool)
    return Run(driven=driven, steered=steered, reports=reports, **values)


def _to_npz(run: Run, path: Path) -> None:
    values = {field.name: getattr(run, field.name) for field in dataclasses.fields(run)}
    values |= {name: np.array(values[name], dtype=str) for name in _NAMES}
    np.savez_compressed(path, **{k: v for k, v in values.items() if v is not None})


def _from_npz(path: Path) -> Run:
    with path.open("rb") as file:
        held = np.load(file, allow_pickle=False)
        if not isinstance(held, np.lib.npyio.NpzFile):
            raise ValueError("it holds one array")
        names = [f.name for f in dataclasses.fields(Run) if f.name in held or f.name not in _LATER]
        values: dict[str, Any] = {name: held[name] for name in names}
    values |= {name: tuple(values[name].tolist()) for name in _NAMES if name in values}
    return Run(**values)
