"""How far an estimated path ends from the measured truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.se2 import Array, wrap


@dataclass(frozen=True)
class Score:
    """The error of a path against truth.

    Attributes:
        distance: length of the estimated path [m].
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

    The distance is that of the estimated path: measured positions carry noise, which lengthens
    their path with every sample.

    >>> score([[0, 0, 0], [2, 0, 0]], [[0, 0, 0], [2, 0.1, 0]]).end_percent
    5.0
    """
    poses, truth = np.asarray(poses, dtype=np.float64), np.asarray(truth, dtype=np.float64)
    distance = float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum())
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
