"""How far the robots are spread, over all of them, at some of the steps."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral

import numpy as np

from trundle.errors import TrundleError
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.reducers.base import Collected, Reducer


@dataclass(frozen=True, eq=False)
class PoseSpread:
    """Mean and covariance of the poses (x, y, psi) of all robots, a row for each time.

    Attributes:
        mean: (rows, 3) means [m, m, rad].
        covariance: (rows, 3, 3) mean products of the deviations from the mean.
        dt: time between two rows [s].
    """

    mean: Numbers
    covariance: Numbers
    dt: float


class Spread(Reducer):
    """Mean and covariance of the poses of all robots at every so many steps, the start included.

    Sums are made in double precision, and do not depend on how many threads there are. The result
    is a ``PoseSpread`` of ``steps // every + 1`` rows. Headings are not wrapped.

    Args:
        every: steps between two rows.

    Raises:
        TrundleError: it is no whole number from 1 on.

    >>> from trundle import Constant, load, rollout
    >>> side_by_side = [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]
    >>> spread = rollout(
    ...     load("differential"),
    ...     Constant([1.0, 1.0]),
    ...     dt=0.1,
    ...     steps=10,
    ...     pose=side_by_side,
    ...     save=Spread(every=10),
    ...     device="numpy",
    ... ).reduced
    >>> spread.mean[:, 0].round(6).tolist()  # of x, at the start and at the end
    [0.0, 0.05]
    >>> spread.covariance[:, 1, 1].round(6).tolist()  # of y
    [1.0, 1.0]
    """

    def __init__(self, every: int = 1) -> None:
        if isinstance(every, bool) or not isinstance(every, Integral) or every < 1:
            raise TrundleError(
                f"Spread needs a whole number of steps from 1 on between its rows, got {every!r}"
            )
        self.summed = int(every)

    def result(self, collected: Collected) -> PoseSpread:
        """Return mean and covariance."""
        moments, every = collected.moments, self.summed
        assert moments is not None
        # With other reducers of this kind the loop may have made more rows.
        rows = slice(None, None, every // collected.summed)
        count = moments.count[rows, None, None]
        return PoseSpread(
            np.ascontiguousarray(moments.mean[rows]),
            moments.spread[rows] / count,
            every * collected.dt,
        )
