"""From the twists over each step to the poses: exact, Euler and RK4, all by prefix sums.

With known commands the heading does not depend on the position, so every method is a cumulative
sum of headings and then one of displacements: no loop over time.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from trundle.se2 import Array, chain
from trundle.simulation.commands import Samples

Integrator = Callable[[Samples, Array, Array], Array]


def exact(twist: Samples, dt: Array, pose: Array) -> Array:
    """Return the poses (T + 1, 3) when each step keeps the twist of its start.

    Exact for constant and sampled commands; of first order in dt for functions of time.
    """
    return chain(twist.start, pose, dt)


def euler(twist: Samples, dt: Array, pose: Array) -> Array:
    """Return the poses (T + 1, 3) of eta' = eta + dt J(psi) zeta, of first order in dt.

    Source: the lectures' simulation loop.
    """
    psi = _headings(twist.start[:, 2] * dt, pose)
    return _positions(psi, _inertial(psi[:-1], twist.start) * dt[:, None], pose)


def rk4(twist: Samples, dt: Array, pose: Array) -> Array:
    """Return the poses (T + 1, 3) of the classical Runge-Kutta method, of fourth order in dt.

    Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd edition,
    1993, section II.1, table 1.2.
    """
    first, middle, last = twist
    psi = _headings((first[:, 2] + 4 * middle[:, 2] + last[:, 2]) / 6 * dt, pose)
    at = psi[:-1]
    slope = (
        _inertial(at, first)
        + 2 * _inertial(at + dt / 2 * first[:, 2], middle)
        + 2 * _inertial(at + dt / 2 * middle[:, 2], middle)
        + _inertial(at + dt * middle[:, 2], last)
    ) / 6
    return _positions(psi, slope * dt[:, None], pose)


def _headings(turns: Array, pose: Array) -> Array:
    return np.concatenate([[pose[2]], pose[2] + np.cumsum(turns)])


def _inertial(psi: Array, twist: Array) -> Array:
    """Return the velocity (T, 2) in the inertial frame."""
    c, s = np.cos(psi), np.sin(psi)
    u, v = twist[:, 0], twist[:, 1]
    return np.stack([c * u - s * v, s * u + c * v], axis=-1)


def _positions(psi: Array, steps: Array, pose: Array) -> Array:
    out = np.empty((len(psi), 3))
    out[0, :2] = pose[:2]
    out[1:, :2] = pose[:2] + np.cumsum(steps, axis=0)
    out[:, 2] = psi
    return out


METHODS: dict[str, Integrator] = {"exact": exact, "euler": euler, "rk4": rk4}
