"""Columns of numbers as a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from trundle.errors import FileError
from trundle.se2 import Array

Counts = npt.NDArray[np.int64]


def write_columns(path: str | Path, columns: Mapping[str, Array | Counts]) -> Path:
    """Write columns (T,) under their names and return the path.

    Raises:
        FileError: the file cannot be written.
    """
    path = Path(path)
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None
    return path
