"""How far an estimated path ends from the measured truth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.kinematics import finite
from trundle.se2 import Array, wrap

# Steps shorter than this share of the path's extent are as much noise as motion.
_NOISE = 0.01


@dataclass(frozen=True)
class Score:
    """The error of a path against truth.

    Attributes:
        distance: length of the true path [m].
        end_error: distance between the two ends [m].
        end_percent: end error in % of the distance; nan for a path that goes nowhere.
        rms_error: root mean square of the distance between the paths [m].
        end_heading_error: estimated less true heading at the end, in (-pi, pi] [rad].
        rms_heading_error: root mean square of the heading error [rad].
    """

    distance: float
    end_error: float
    end_percent: float
    rms_error: float
    end_heading_error: float
    rms_heading_error: float


def score(poses: npt.ArrayLike, truth: npt.ArrayLike) -> Score:
    """Return the error of poses (T, 3) against true poses (T, 3) at the same times.

    Raises:
        ShapeError: poses and truth are not such arrays, or not of one length.

    >>> score([[0, 0, 0], [2, 0.1, 0]], [[0, 0, 0], [2, 0, 0]]).end_percent
    5.0
    """
    poses, truth = _path(poses, "poses"), _path(truth, "truth")
    if len(poses) != len(truth):
        raise ShapeError(f"poses and truth must have one length, got {len(poses)} and {len(truth)}")
    distance = path_length(truth[:, :2])
    apart = np.hypot(*(poses[:, :2] - truth[:, :2]).T)
    heading: Array = wrap(poses[:, 2] - truth[:, 2])
    return Score(
        distance=distance,
        end_error=float(apart[-1]),
        end_percent=100 * float(apart[-1]) / distance if distance > 0 else float("nan"),
        rms_error=float(np.sqrt(np.mean(apart**2))),
        end_heading_error=float(heading[-1]),
        rms_heading_error=float(np.sqrt(np.mean(heading**2))),
    )


def _path(values: npt.ArrayLike, name: str) -> Array:
    array = finite(values, name, 3)
    if array.ndim != 2 or len(array) == 0:
        raise ShapeError(f"{name} must have shape (T, 3), got {array.shape}")
    return array


def path_length(points: Array) -> float:
    """Return the length of a measured path (T, 2), over steps that exceed its noise.

    Noise lengthens a path with every sample: a motion capture at 100 Hz nearly doubles it.

    >>> path_length(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]))
    7.0
    """
    step = _NOISE * float(np.hypot(*np.ptp(points, axis=0)))
    total, (x, y) = 0.0, points[0].tolist()
    for px, py in points.tolist():
        moved = math.hypot(px - x, py - y)
        if moved >= step:
            total, x, y = total + moved, px, py
    return total + math.hypot(*(points[-1] - (x, y)))
