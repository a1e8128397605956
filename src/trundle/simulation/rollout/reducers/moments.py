"""Means and covariances of all robots' poses, from sums that the loops make.

The robots are dealt into lanes, always in the same way; each lane is summed by one thread, in
order, as deviations from the pose of its first robot, and the lanes are joined in order: so the
result does not depend on how many threads there are, and nothing cancels far from the origin.

Source: Chan, Golub and LeVeque, "Algorithms for computing the sample variance: analysis and
recommendations", The American Statistician 37(3), 1983.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.simulation.rollout.loop import Numbers

# Of each lane and row: how many robots, the first robot's pose, sums of the deviations from it,
# and of their products xx, xy, xpsi, yy, ypsi, psipsi.
COLUMNS = 13
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
# Robots of the start that are summed at once, so that no second copy of all of them is made.
_AT_ONCE = 65_536


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of the poses of N robots, a row for each time.

    Attributes:
        count: (rows,) how many robots.
        mean: (rows, 3) means of x, y, psi.
        spread: (rows, 3, 3) sums of the products of deviations from the mean.
    """

    count: Numbers
    mean: Numbers
    spread: Numbers

    def join(self, other: Moments) -> Moments:
        """Return the moments of the robots of both."""
        count = self.count + other.count
        apart = other.mean - self.mean
        share = other.count / count
        products = apart[:, :, None] * apart[:, None, :]
        return Moments(
            count,
            self.mean + share[:, None] * apart,
            self.spread + other.spread + (self.count * share)[:, None, None] * products,
        )


def join_rows(parts: list[Moments]) -> Moments:
    """Return the rows of all, one after the other."""
    return Moments(
        np.concatenate([part.count for part in parts]),
        np.concatenate([part.mean for part in parts]),
        np.concatenate([part.spread for part in parts]),
    )


def moments_of(sums: Numbers) -> Moments:
    """Return the moments of all robots from the sums (lanes, rows, COLUMNS) of the loops."""
    joined = _of_lane(sums[0])
    for lane in sums[1:]:
        joined = joined.join(_of_lane(lane))
    return joined


def moments_at(poses: Numbers) -> Moments:
    """Return the moments, in one row, of poses (3, N)."""
    sums = np.zeros((-(-poses.shape[1] // _AT_ONCE), 1, COLUMNS))
    for k, lane in enumerate(sums):
        add_poses(lane[0], poses[:, k * _AT_ONCE : (k + 1) * _AT_ONCE])
    return moments_of(sums)


def add_poses(row: Numbers, poses: Numbers) -> None:
    """Add poses (3, N) to one row of sums (COLUMNS,)."""
    if row[0] == 0:
        row[1:4] = poses[:, 0]
    apart = poses.astype(np.float64) - row[1:4, None]
    row[0] += poses.shape[1]
    row[4:7] += apart.sum(axis=1)
    row[7:] += [apart[i] @ apart[j] for i, j in _PAIRS]


def _of_lane(lane: Numbers) -> Moments:
    count, first, total = lane[:, 0], lane[:, 1:4], lane[:, 4:7]
    products = np.empty((len(lane), 3, 3))
    for k, (i, j) in enumerate(_PAIRS):
        products[:, i, j] = products[:, j, i] = lane[:, 7 + k]
    mean = total / count[:, None]
    return Moments(count, first + mean, products - total[:, :, None] * mean[:, None, :])
