"""Twists drawn around a plan, each brought to what a robot's wheels can do."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation.arithmetic import (
    PLAIN,
    Function,
    array_arithmetic,
    as_is,
    compiled_arithmetic,
    number_and_integer,
)
from trundle.simulation.rollout import devices, written
from trundle.simulation.rollout.bounds import Bounds, twist_bounds
from trundle.simulation.rollout.filling import make_fill
from trundle.simulation.rollout.intrinsics import choices, read_bits
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.random import key_words, make_normals
from trundle.simulation.rollout.threads import run_all, thread_count

# Samples computed together: their noise stays in the nearest cache.
_BLOCK = 256
# Samples times steps that take longer than it takes to wake a thread.
_WORTH_SHARING = 20_000
# The random function gives four numbers, and a twist takes three: three calls serve four twists.
_FOUR = 4


@dataclass(frozen=True, eq=False)
class TwistSampler:
    """Draws twists around a plan: normal noise, and what the wheels leave of it.

    Attributes:
        bounds: what is left of a twist.
        constants: of the bounds.
        dtype: "float32" or "float64".
        device: "cpu" or "numpy".
    """

    bounds: Bounds
    constants: Array
    dtype: str
    device: str

    def bounded(self, twist: npt.ArrayLike) -> Array:
        """Return what the wheels leave of a twist (3,), in full precision."""
        leave = _plain(self.bounds)
        return np.array(leave(np.asarray(twist).tolist(), self.constants.tolist()))

    @classmethod
    def of(cls, robot: Robot, max_twist: Array | None, dtype: str, device: str) -> TwistSampler:
        """Return the sampler of a robot.

        Args:
            robot: the robot.
            max_twist: (3,) largest (u, v, r) beside the wheels' own limits, or None.
            dtype: "float32" or "float64".
            device: "cpu", "numpy" or "auto".

        Raises:
            TrundleError: the robot is not driven, or there is no such device.
        """
        return cls(*twist_bounds(robot, max_twist), dtype, devices.choose(device))

    def fill(
        self,
        out: Numbers,
        plan: Numbers,
        sigma: npt.ArrayLike,
        *,
        hold: int = 1,
        seed: int,
        stream: int = 0,
    ) -> None:
        """Fill in samples around a plan; they depend on seed, stream and their place alone.

        Args:
            out: (T, 3, K) of the dtype, filled in.
            plan: (T, 3) twists.
            sigma: (3,) standard deviations of the noise.
            hold: over how many steps each number is held.
            seed: of the noise, below 2^64.
            stream: number of the noise among those of one seed.
        """
        key = np.array(key_words(seed + (stream << 64)), dtype=np.uint32)
        plan, sigma, constants = (
            np.ascontiguousarray(each, dtype=self.dtype) for each in (plan, sigma, self.constants)
        )
        if self.device == "numpy":
            with np.errstate(over="ignore"):  # the random words wrap around, as they should
                _fill_arrays(self.bounds, out, plan, sigma, constants, key, hold)
        else:
            _fill_compiled(self.bounds, out, plan, sigma, constants, key, hold)


@cache
def _plain(bounds: Bounds) -> Function:
    return bounds.make(PLAIN, as_is)


def _fill_arrays(
    bounds: Bounds, out: Numbers, plan: Numbers, sigma: Numbers, constants: Numbers, key: Any,
    hold: int,
) -> None:  # fmt: skip
    m = array_arithmetic(out.dtype.name)
    normals, leave = make_normals(_FOUR, m, as_is), bounds.make(m, as_is)
    samples = np.arange(out.shape[2], dtype=np.uint32)
    noise: Any = ()
    for t, wanted in enumerate(plan):
        number, rest = divmod(t, hold)
        at = 3 * (number % _FOUR)
        if at == rest == 0:
            calls = (normals(key, samples, 3 * (number // _FOUR) + k) for k in range(3))
            noise = tuple(itertools.chain.from_iterable(calls))
        noisy = tuple(wanted[i] + sigma[i] * noise[at + i] for i in range(3))
        out[t] = leave(noisy, constants)


def _fill_compiled(
    bounds: Bounds, out: Numbers, plan: Numbers, sigma: Numbers, constants: Numbers, key: Any,
    hold: int,
) -> None:  # fmt: skip
    loop, (steps, _, count) = _loop(bounds, out.dtype.name), out.shape
    given, blocks = (out, plan, sigma, constants, key, hold), -(-count // _BLOCK)
    threads = 1 if count * steps < _WORTH_SHARING else min(thread_count(), blocks)
    edges = [_BLOCK * (blocks * k // threads) for k in range(threads)] + [count]
    run_all(loop, [(*each, *given) for each in itertools.pairwise(edges)], threads)


@cache
def _loop(bounds: Bounds, dtype: str) -> Function:
    """Return the loop over the samples from lo to hi; it lets other threads run meanwhile."""
    import numba

    from trundle.simulation.rollout import cpu

    def part(function: Any) -> Any:
        return numba.njit(inline="always", fastmath=cpu.FAST, error_model="numpy")(function)

    m = compiled_arithmetic(dtype, part, read_bits(), False, choices())
    number, _ = number_and_integer(dtype)
    fill, leave = make_fill(_FOUR, m, part), bounds.make(m, part)
    constants_of = part(written.constants((False,) * bounds.constants))
    size, four = _BLOCK, _FOUR

    @numba.njit(fastmath=cpu.FAST, error_model="numpy")  # type: ignore[untyped-decorator]
    def block(
        lo: int, hi: int, out: Any, plan: Any, sigma: Any, constants: Any, key: Any, hold: int
    ) -> None:
        count, steps = hi - lo, len(plan)
        noise, words = np.empty((3, four, size), number), np.empty((four, size), np.uint32)
        given = constants_of(constants, constants, 0)
        for first in range(0, steps, four * hold):
            for k in range(3):
                fill(noise[k], words, key, lo, 0, count, 3 * (first // (four * hold)) + k)
            for t in range(first, min(first + four * hold, steps)):
                at = 3 * ((t - first) // hold)
                a = noise[at // four, at % four]
                b = noise[(at + 1) // four, (at + 1) % four]
                c = noise[(at + 2) // four, (at + 2) % four]
                u, v, r = out[t, 0][lo:hi], out[t, 1][lo:hi], out[t, 2][lo:hi]
                for i in range(count):
                    u[i], v[i], r[i] = leave(
                        (
                            plan[t, 0] + sigma[0] * a[i],
                            plan[t, 1] + sigma[1] * b[i],
                            plan[t, 2] + sigma[2] * c[i],
                        ),
                        given,
                    )

    @numba.njit(error_model="numpy", nogil=True)  # type: ignore[untyped-decorator]
    def loop(
        lo: int, hi: int, out: Any, plan: Any, sigma: Any, constants: Any, key: Any, hold: int
    ) -> None:
        for start in range(lo, hi, size):
            block(start, min(hi, start + size), out, plan, sigma, constants, key, hold)

    made: Function = loop
    return made
