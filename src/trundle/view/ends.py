"""Where many robots under the same commands end, in a few numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError
from trundle.se2 import Array

SHARE = 0.95


@dataclass(frozen=True, eq=False)
class Ends:
    """Where N robots end, and how far that is from where the nominal robot does.

    Attributes:
        nominal: (3,) pose x, y, psi in which the nominal robot ends [m, m, rad].
        mean: (3,) mean of the poses.
        std: (3,) their standard deviations.
        half_axes: (2,) half axes of the ellipse about the mean that holds 95 % of the positions, if
            these are normally distributed; the longer first [m].
        direction: of the longer axis from the x axis, in (-pi/2, pi/2] [rad].
        inside: share of the positions that lie in the ellipse.
        off: (N,) distances of the positions from the nominal one [m].
        within: the distance that 95 % of them do not exceed [m].
        farthest: number of the robot that is farthest off.
    """

    nominal: Array
    mean: Array
    std: Array
    half_axes: Array
    direction: float
    inside: float
    off: Array
    within: float
    farthest: int

    def ellipse(self, points: int = 121) -> Array:
        """Return points (k, 2) of the ellipse, closed [m]."""
        angle = np.linspace(0, 2 * np.pi, points)
        a, b = self.half_axes[:, None] * (np.cos(angle), np.sin(angle))
        c, s = math.cos(self.direction), math.sin(self.direction)
        return np.column_stack([self.mean[0] + c * a - s * b, self.mean[1] + s * a + c * b])


def ends_of(nominal: npt.ArrayLike, final: npt.ArrayLike) -> Ends:
    """Return where many robots end, in a few numbers.

    With C the covariance of the positions p, the ellipse is ``(p - mean)^T C^-1 (p - mean) = k``,
    where ``k = -2 ln(1 - 0.95)`` is the quantile of chi squared with two degrees of freedom: its
    half axes are the square roots of k times the eigenvalues of C.

    Args:
        nominal: (3,) pose in which the nominal robot ends [m, m, rad].
        final: (N, 3) poses in which the others end.

    Raises:
        ShapeError: they have other shapes, or are not finite.

    Source: Thrun, Burgard and Fox, Probabilistic Robotics, 2005, section 3.2.1, for normal
    distributions of several variables.

    >>> ends = ends_of([1.0, 0.0, 0.0], [[0.9, 0.0, 0.0], [1.1, 0.0, 0.0]])
    >>> ends.std.round(6).tolist(), ends.half_axes.round(6).tolist(), round(ends.within, 6)
    ([0.1, 0.0, 0.0], [0.244775, 0.0], 0.1)
    """
    end, poses = np.asarray(nominal, dtype=np.float64), np.asarray(final, dtype=np.float64)
    if end.shape != (3,) or poses.ndim != 2 or poses.shape[1] != 3 or not len(poses):
        raise ShapeError(f"ends need poses (3,) and (N, 3), got {end.shape} and {poses.shape}")
    if not (np.isfinite(end).all() and np.isfinite(poses).all()):
        raise ShapeError("ends need finite poses, got nan or inf")
    mean = poses.mean(axis=0)
    apart = poses - mean
    values, vectors = np.linalg.eigh(apart[:, :2].T @ apart[:, :2] / len(poses))
    variances, axes = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    size = -2.0 * math.log(1 - SHARE)
    off = np.hypot(*(poses[:, :2] - end[:2]).T)
    direction = math.atan2(axes[1, 0], axes[0, 0])
    if not -math.pi / 2 < direction <= math.pi / 2:
        direction -= math.copysign(math.pi, direction)
    return Ends(
        nominal=end,
        mean=mean,
        std=np.sqrt(np.mean(apart**2, axis=0)),
        half_axes=np.sqrt(size * variances),
        direction=direction,
        inside=_share_inside(apart[:, :2] @ axes, variances, size),
        off=off,
        within=float(np.quantile(off, SHARE)),
        farthest=int(off.argmax()),
    )


def _share_inside(along: Array, variances: Array, size: float) -> float:
    """Return the share of points, given along the axes, in the ellipse; a flat one is a line."""
    wide = variances > 1e-18 * max(float(variances[0]), 1e-300)
    squares = np.square(along[:, wide]) / variances[wide]
    return float((squares.sum(axis=1) <= size).mean())
