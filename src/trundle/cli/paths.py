"""The trajectories that ``--path`` names: the lectures', or those of a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer

from trundle.cli.numbers import number
from trundle.errors import TrundleError, did_you_mean
from trundle.motion import (
    Trajectory,
    circle,
    cubic_via,
    ellipse,
    figure_eight,
    from_csv,
    line,
    lissajous,
)

# The lectures' sizes and rates [m, rad/s].
_RADIUS, _RATE = 3.0, 0.1
_POINTS, _TIMES = ((0.0, 0.0), (2.0, 2.0), (0.0, 4.0)), (0.0, 30.0, 60.0)

PATHS: dict[str, Callable[[float, Any], Trajectory]] = {
    "circle": lambda k, heading: circle(k * _RADIUS, _RATE, heading=heading),
    "ellipse": lambda k, heading: ellipse(k * _RADIUS, k * 2.0, _RATE, heading=heading),
    "lissajous": lambda k, heading: lissajous(
        k * _RADIUS, k * _RADIUS, 2 * _RATE, _RATE, heading=heading
    ),
    "eight": lambda k, heading: figure_eight(2 * k * _RADIUS, _RATE, heading=heading),
    "line": lambda k, heading: line((0.0, 0.0), (k * 4.0, 0.0), 20.0, heading=heading),
    "via": lambda k, heading: cubic_via(_scaled(k), _TIMES, heading=heading),
    "via-stop": lambda k, heading: cubic_via(_scaled(k), _TIMES, (0.0, 0.0), heading=heading),
}


def _scaled(k: float) -> list[tuple[float, float]]:
    return [(k * x, k * y) for x, y in _POINTS]


def trajectory_of(path: str, scale: float, stretch: float, heading: str) -> Trajectory:
    """Return the trajectory that ``--path`` and its options name.

    Args:
        path: a name, or the path of a CSV file.
        scale: factor on the size of a named one.
        stretch: factor on the time.
        heading: "path", "lecture", or an angle [rad].
    """
    kind: Any = heading
    if heading not in ("path", "lecture"):
        try:
            kind = number(heading)
        except typer.BadParameter:
            raise TrundleError(
                f"--heading takes path, lecture or an angle [rad], got {heading!r}"
                f"{did_you_mean(heading, ('path', 'lecture'))}"
            ) from None
    if path in PATHS:
        made = PATHS[path](scale, kind)
    elif Path(path).suffix == ".csv":
        if scale != 1:
            raise TrundleError("--scale belongs to named paths: scale the file's columns instead")
        made = from_csv(path, heading=None if heading == "path" else kind)
    else:
        raise TrundleError(
            f"no path {path!r}{did_you_mean(path, PATHS)}; give one of {', '.join(PATHS)}, or a "
            "CSV file with the columns t, x, y and perhaps psi"
        )
    return made if stretch == 1 else made.stretched(stretch)
