"""Planar poses and twists as plain arrays: the last axis is (x, y, psi) or (u, v, r)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Added to the square of the half angle h so that sin(h) / h is 1 at h = 0 without a branch. It is
# far below what rounding makes of every h that a robot turns; and where h = 0 the derivative is of
# a smooth function, 0, so that gradients of the step are right there, too.
NEVER_ZERO = 2.0**-54

# Steps computed together: so few that their arrays stay in the processor's cache, so many that
# numpy's cost per call does not count.
_BLOCK = 16384


def make_step(
    sin: Callable[[Any], Any], cos: Callable[[Any], Any]
) -> Callable[..., tuple[Any, Any, Any]]:
    """Return the exact SE(2) step in the arithmetic of the given ``sin`` and ``cos``.

    The step moves a pose by the body increment (dx, dy, dpsi) = dt (u, v, r) of a twist that is
    constant over the step, with h = dpsi / 2::

        [x']   [x]   sin h  [cos(psi + h)  -sin(psi + h)] [dx]
        [y'] = [y] + ----- [sin(psi + h)   cos(psi + h)] [dy],    psi' = psi + dpsi
                       h

    It is branch-free, so that floats, arrays, symbols and compiled code can all read it.

    Source: the SE(2) exponential, Lynch and Park, Modern Robotics, 2017, section 13.4, eq. (13.35),
    with the half-angle identities.

    >>> step = make_step(math.sin, math.cos)
    >>> x, y, psi = step(0.0, 0.0, 0.0, math.pi, 0.0, math.pi)  # half a circle of diameter 2
    >>> round(x, 12), round(y, 12)
    (0.0, 2.0)
    """

    def step(x: Any, y: Any, psi: Any, dx: Any, dy: Any, dpsi: Any) -> tuple[Any, Any, Any]:
        half = 0.5 * dpsi
        nonzero = (half * half + NEVER_ZERO) ** 0.5
        chord = sin(nonzero) / nonzero
        middle = psi + half
        c = chord * cos(middle)
        s = chord * sin(middle)
        return x + c * dx - s * dy, y + s * dx + c * dy, psi + dpsi

    return step


step = make_step(math.sin, math.cos)
step_arrays = make_step(np.sin, np.cos)


def make_sinc(
    sin: Callable[[Any], Any], sqrt: Callable[[Any], Any], tiny: Any
) -> Callable[[Any], Any]:
    """Return sin(h) / h, which is 1 at h = 0, without a branch.

    Args:
        sin: the sine.
        sqrt: the square root.
        tiny: ``NEVER_ZERO`` in the type of number that they are read in.
    """

    def sinc(h: Any) -> Any:
        nonzero = sqrt(h * h + tiny)
        return sin(nonzero) / nonzero

    return sinc


def make_chord(sinc: Callable[[Any], Any]) -> Callable[..., tuple[Any, Any]]:
    """Return the first half of the step: from an increment (dx, dy, 2 half) to the arc's chord.

    ``(a, b) = sin h / h (dx, dy)``, seen from the heading at the arc's middle. Where the increment
    does not change, the chord does not, and only ``make_turned`` is left to do at each step.

    >>> chord, turned = (
    ...     make_chord(make_sinc(math.sin, math.sqrt, NEVER_ZERO)),
    ...     make_turned(math.sin, math.cos),
    ... )
    >>> a, b = chord(math.pi, 0.0, math.pi / 2)
    >>> x, y = turned(0.0 + math.pi / 2, a, b)
    >>> round(x, 12), round(y, 12)
    (0.0, 2.0)
    """

    def chord(dx: Any, dy: Any, half: Any) -> tuple[Any, Any]:
        shrunk = sinc(half)
        return shrunk * dx, shrunk * dy

    return chord


def make_turned(
    sin: Callable[[Any], Any], cos: Callable[[Any], Any]
) -> Callable[..., tuple[Any, Any]]:
    """Return the second half of the step: the chord (a, b) turned to the heading at its middle."""

    def turned(angle: Any, a: Any, b: Any) -> tuple[Any, Any]:
        c, s = cos(angle), sin(angle)
        return c * a - s * b, s * a + c * b

    return turned


def rotation(psi: npt.ArrayLike) -> Array:
    """Return J(psi), which turns a twist in the body frame into eta_dot in the inertial frame.

    ``J(psi) = [[c, -s, 0], [s, c, 0], [0, 0, 1]]``; psi (...,) in rad gives (..., 3, 3).

    >>> rotation(0.0).tolist()
    [[1.0, -0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    psi = np.asarray(psi, dtype=np.float64)
    c, s = np.cos(psi), np.sin(psi)
    out = np.zeros((*psi.shape, 3, 3))
    out[..., 0, 0], out[..., 0, 1] = c, -s
    out[..., 1, 0], out[..., 1, 1] = s, c
    out[..., 2, 2] = 1.0
    return out


def wrap(angle: npt.ArrayLike) -> Array:
    """Return the angle in (-pi, pi] that points the same way.

    >>> float(wrap(3 * math.pi)) == math.pi
    True
    """
    angle = np.asarray(angle, dtype=np.float64)
    wrapped = np.pi - np.mod(np.pi - angle, 2 * np.pi)
    # Just above pi the remainder rounds to a whole turn.
    return np.where(wrapped <= -np.pi, np.pi, wrapped)


def chain(
    increments: npt.ArrayLike,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
    dt: npt.ArrayLike = 1.0,
) -> Array:
    """Return the poses that body increments lead through, exactly, by prefix sums.

    Args:
        increments: (T, 3) body increments (dx, dy, dpsi) [m, m, rad], each of a constant twist.
        pose: (3,) start pose (x, y, psi) in the inertial frame [m, m, rad].
        dt: () or (T,) factor on the increments: the steps [s] where they are twists.

    Returns:
        (T + 1, 3) poses in the inertial frame; psi is not wrapped.

    >>> chain([[1.0, 0.0, 0.0], [0.0, 0.0, math.pi / 2], [1.0, 0.0, 0.0]])[-1].round(12).tolist()
    [1.0, 1.0, 1.570796326795]
    >>> circle = chain(np.tile([1e-3, 0.0, math.tau / 40_000], (40_000, 1)))
    >>> bool(np.abs(circle[-1, :2]).max() < 1e-9)  # back at its start after 40 m
    True
    """
    increments = np.asarray(increments, dtype=np.float64)
    dt = np.broadcast_to(np.asarray(dt, dtype=np.float64), len(increments))
    out = np.empty((len(increments) + 1, 3))
    out[0] = pose
    for first in range(0, len(increments), _BLOCK):
        block, steps = out[first : first + _BLOCK + 1], slice(first, first + _BLOCK)
        dx, dy, dpsi = np.multiply(increments[steps].T, dt[steps], order="C")
        psi = _sums(block[0, 2], dpsi)
        moved_x, moved_y, _ = step_arrays(0.0, 0.0, psi[:-1], dx, dy, dpsi)
        block[:, 0] = _sums(block[0, 0], moved_x)
        block[:, 1] = _sums(block[0, 1], moved_y)
        block[:, 2] = psi
    return out


def _sums(start: float, steps: Array) -> Array:
    """Return a start value and the sums (T + 1,) that steps (T,) lead to from it."""
    out = np.empty(len(steps) + 1)
    out[0], out[1:] = start, steps
    return np.cumsum(out, out=out)


def point_twist(twist: npt.ArrayLike, point: npt.ArrayLike) -> Array:
    """Return the twist with (u, v) taken at a body point instead of at the body's origin.

    Args:
        twist: (..., 3) (u, v, r) of the body's origin, in the body frame [m/s, m/s, rad/s].
        point: (2,) body point (x, y) [m].

    >>> point_twist([0.0, 0.0, 2.0], (1.0, 0.0)).tolist()
    [0.0, 2.0, 2.0]
    """
    twist = np.asarray(twist, dtype=np.float64)
    x, y = np.asarray(point, dtype=np.float64)
    u, v, r = twist[..., 0], twist[..., 1], twist[..., 2]
    return np.stack([u - r * y, v + r * x, r], axis=-1)
