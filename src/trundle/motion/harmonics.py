"""Curves that are sums of sines and cosines of time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from trundle.se2 import Array


@final
@dataclass(frozen=True, eq=False)
class Harmonics:
    """``p(t) = centre + sum_j sines_j sin(rates_j t) + cosines_j cos(rates_j t)``.

    Attributes:
        centre: (2,) [m].
        rates: (m,) [rad/s].
        sines, cosines: (2, m) [m].
        period: time after which it repeats itself [s]; None where its rates have none in common.
    """

    centre: Array
    rates: Array
    sines: Array
    cosines: Array
    period: float | None

    @property
    def speed_bound(self) -> float:
        """A speed that it nowhere exceeds [m/s]."""
        return self._bound(1)

    @property
    def acceleration_bound(self) -> float:
        """An acceleration that it nowhere exceeds [m/s^2]."""
        return self._bound(2)

    def _bound(self, order: int) -> float:
        sizes = np.hypot(self.sines, self.cosines)
        return float(math.hypot(*(sizes @ np.abs(self.rates) ** order)))

    def derivatives(self, t: Array, count: int) -> Array:
        """Return position, velocity and so on (count, 2, T) at times (T,)."""
        m = len(self.rates)
        waves = np.empty((2 * m, len(t)))
        for j, rate in enumerate(self.rates.tolist()):
            np.multiply(t, rate, out=waves[m + j])
            np.sin(waves[m + j], out=waves[j])
            np.cos(waves[m + j], out=waves[m + j])
        out = (self._weights(count) @ waves).reshape(count, 2, len(t))
        out[0] += self.centre[:, None]
        return out

    def _weights(self, count: int) -> Array:
        """Return the factors (2 count, 2 m) of sines and cosines in each derivative."""
        sines, cosines = self.sines, self.cosines
        rows = []
        for _ in range(count):
            rows.append(np.concatenate([sines, cosines], axis=1))
            sines, cosines = -cosines * self.rates, sines * self.rates
        return np.concatenate(rows)

    def velocity(self) -> Harmonics:
        """Return its velocity as a curve."""
        return replace(
            self,
            centre=np.zeros(2),
            sines=-self.cosines * self.rates,
            cosines=self.sines * self.rates,
        )

    def moved(self, x: float, y: float, psi: float) -> Harmonics:
        """Return the curve turned by psi about the origin, then shifted by (x, y)."""
        turn = turning_matrix(psi)
        return replace(
            self,
            centre=turn @ self.centre + [x, y],
            sines=turn @ self.sines,
            cosines=turn @ self.cosines,
        )

    def stretched(self, factor: float) -> Harmonics:
        """Return the curve run through in ``factor`` times the time."""
        period = None if self.period is None else factor * self.period
        return replace(self, rates=self.rates / factor, period=period)


def turning_matrix(psi: float) -> Array:
    """Return the matrix (2, 2) that turns a vector of the plane by psi."""
    c, s = math.cos(psi), math.sin(psi)
    return np.array([[c, -s], [s, c]])
