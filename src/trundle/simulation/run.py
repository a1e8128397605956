"""A run: what a robot did over time, in memory and in files."""

from __future__ import annotations

import csv
import dataclasses
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.errors import FileError
from trundle.se2 import Array, step_arrays

_BROKEN = (csv.Error, zipfile.BadZipFile, zlib.error)
_POSE = ("x", "y", "psi")
_TWIST = ("u", "v", "r")


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

        The CSV has one row per time; the last row has no commands.

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


def _blocks(run: Run) -> list[tuple[str, tuple[str, ...], Array]]:
    """Return the columns of the CSV: prefix, names and values of each block."""
    return [
        ("", ("t",), run.t[:, None]),
        ("", _POSE, run.pose),
        ("wheel_angle:", run.driven, run.wheel_angles),
        ("", _TWIST, run.twist),
        ("wheel_speed:", run.driven, run.wheel_speeds),
        ("steering:", run.steered, run.steering),
    ]


def _to_csv(run: Run, path: Path) -> None:
    blocks = _blocks(run)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([prefix + name for prefix, names, _ in blocks for name in names])
        columns = [values.tolist() for _, _, values in blocks]
        for k in range(len(run.t) - 1):
            writer.writerow([repr(value) for block in columns for value in block[k]])
        ends = [
            block[-1] if len(block) == len(run.t) else [""] * values.shape[1]
            for block, (_, _, values) in zip(columns, blocks, strict=True)
        ]
        writer.writerow([value for end in ends for value in end])


def _from_csv(path: Path) -> Run:
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])

    def block(prefix: str, names: tuple[str, ...]) -> Array:
        return table[:, [header.index(prefix + name) for name in names]]

    def named(prefix: str) -> tuple[str, ...]:
        return tuple(n.removeprefix(prefix) for n in header if n.startswith(prefix))

    driven, steered = named("wheel_speed:"), named("steering:")
    return Run(
        t=block("", ("t",))[:, 0],
        pose=block("", _POSE),
        twist=block("", _TWIST)[:-1],
        wheel_speeds=block("wheel_speed:", driven)[:-1],
        steering=block("steering:", steered)[:-1],
        wheel_angles=block("wheel_angle:", driven),
        driven=driven,
        steered=steered,
    )


def _to_npz(run: Run, path: Path) -> None:
    values = {field.name: getattr(run, field.name) for field in dataclasses.fields(run)}
    values |= {name: np.array(values[name], dtype=str) for name in ("driven", "steered")}
    np.savez_compressed(path, **values)


def _from_npz(path: Path) -> Run:
    with path.open("rb") as file:
        held = np.load(file, allow_pickle=False)
        if not isinstance(held, np.lib.npyio.NpzFile):
            raise ValueError("it holds one array")
        values: dict[str, Any] = {f.name: held[f.name] for f in dataclasses.fields(Run)}
    values |= {name: tuple(values[name].tolist()) for name in ("driven", "steered")}
    return Run(**values)
