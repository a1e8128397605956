"""The commands of many robots, as values."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from trundle.errors import ShapeError, TrundleError
from trundle.simulation.rollout.loop import Numbers
from trundle.simulation.rollout.reading import plain_function


@dataclass(frozen=True)
class Noise:
    """Independent normal numbers that are added to the commands of every robot and step.

    Attributes:
        sigma: standard deviation of every command value, (n,) or (N, n), or one for all.
        seed: what the numbers depend on, with the robot's and the step's number.
    """

    sigma: Numbers
    seed: int


class Commands:
    """What all commands have: noise, or none."""

    noise: Noise | None = None
    moving = False

    def with_noise(self, sigma: npt.ArrayLike, *, seed: int) -> Self:
        """Return these commands with normal noise, generated while the robots move.

        It takes the place of noise that they had. One number holds for steering angles, too.

        Args:
            sigma: standard deviation in the unit of the commands: one number, one for each value
                of a command (n,), or each robot's own (N, n).
            seed: a whole number; the same seed gives the same noise on any number of threads, and
                within rounding on every device.

        >>> noisy = Constant([1.0, 1.0]).with_noise(0.1, seed=3)
        >>> noisy.noise.seed
        3
        """
        values = numbers(sigma, "sigma")
        if not np.isfinite(values).all():
            raise ShapeError("sigma must be finite numbers, got nan or inf")
        if values.size and values.min() < 0:
            raise TrundleError(f"sigma must not be negative, got {values.min():g}")
        noisy = copy.copy(self)
        noisy.noise = Noise(values, whole_seed(seed))
        return noisy


class Given(Commands):
    """Commands that are known beforehand.

    Attributes:
        values: (T or 1, k, N or 1) wheel speeds or twists, in the layout of the loops.
        steering: (T or 1, s, N or 1) steering angles, or None.
        is_twist: whether the values are twists.
        moving: whether each step has its own.
        read: the function from the array that a user gives to the values' layout.
    """

    def __init__(
        self,
        read: Callable[[Numbers, str], Numbers],
        wheel_speeds: npt.ArrayLike | None,
        twist: npt.ArrayLike | None,
        steering: npt.ArrayLike | None,
        *,
        moving: bool,
    ) -> None:
        if (wheel_speeds is None) == (twist is None):
            raise TrundleError("give either wheel_speeds or twist")
        if twist is not None and steering is not None:
            raise TrundleError("steering follows from the twist: leave it out")
        self.read, self.moving, self.is_twist = read, moving, twist is not None
        name = "twist" if self.is_twist else "wheel_speeds"
        given = twist if self.is_twist else wheel_speeds
        assert given is not None
        self.values = read(numbers(given, name), name)
        self.steering = (
            None if steering is None else read(numbers(steering, "steering"), "steering")
        )


class Constant(Given):
    """Commands that each robot keeps for all steps.

    Args:
        wheel_speeds: (N, n) wheel speeds [rad/s], a row for each robot, or (n,) for all robots.
        twist: in place of them (N, 3) or (3,) twists u, v, r [m/s, m/s, rad/s]; what the wheels do
            not allow of them is left out.
        steering: (N, s) or (s,) steering angles [rad], beside the wheel speeds of a robot that
            steers.

    >>> Constant([[1.0, 1.0], [1.0, 2.0]]).values.shape  # two robots
    (1, 2, 2)
    """

    def __init__(
        self,
        wheel_speeds: npt.ArrayLike | None = None,
        *,
        twist: npt.ArrayLike | None = None,
        steering: npt.ArrayLike | None = None,
    ) -> None:
        super().__init__(_held, wheel_speeds, twist, steering, moving=False)


class Stream(Given):
    """Commands for every step, held over it; the array is read at each rollout, where it lies.

    Args:
        wheel_speeds: (T, N, n) wheel speeds [rad/s], a row for each step and robot, or (T, n) for
            all robots. ``Stream.wheels_first`` takes the layout that is read fastest.
        twist: in place of them (T, N, 3) or (T, 3) twists u, v, r [m/s, m/s, rad/s].
        steering: (T, N, s) or (T, s) steering angles [rad], beside the wheel speeds.

    >>> Stream(np.zeros((100, 5, 4))).values.shape  # 100 steps of 5 robots
    (100, 4, 5)
    """

    def __init__(
        self,
        wheel_speeds: npt.ArrayLike | None = None,
        *,
        twist: npt.ArrayLike | None = None,
        steering: npt.ArrayLike | None = None,
    ) -> None:
        super().__init__(_rows, wheel_speeds, twist, steering, moving=True)

    @classmethod
    def wheels_first(
        cls,
        wheel_speeds: npt.ArrayLike | None = None,
        *,
        twist: npt.ArrayLike | None = None,
        steering: npt.ArrayLike | None = None,
    ) -> Stream:
        """Return commands from arrays (T, n, N): for each step and wheel a row of all robots.

        The loops read this layout as it stands, several robots at once, where an array of the
        rollout's dtype is contiguous: no copy is made.

        >>> Stream.wheels_first(np.zeros((100, 4, 5), dtype=np.float32)).values.shape
        (100, 4, 5)
        """
        made = cls.__new__(cls)
        Given.__init__(made, _whole, wheel_speeds, twist, steering, moving=True)
        return made


class Policy(Commands):
    """A feedback law: it reads a robot's pose at every step and gives its command.

    Args:
        step: a function (t, pose, parameters) -> command: time [s], the tuple (x, y, psi), the
            tuple of the robot's parameters; it returns a tuple of numbers. It is compiled where
            numba is installed, so it computes with plain numbers and the functions of ``math`` or
            numpy. Without numba it is read over all robots at once, or if it cannot be, as with
            ``if``, for one robot after the other.
        output: "wheel_speeds" [rad/s] (for robots that steer, the steering angles [rad] follow
            them) or "twist" (u, v, r) [m/s, m/s, rad/s].
        parameters: (k,) numbers, or (N, k) where each robot has its own.

    >>> def turn_to_north(t, pose, parameters):
    ...     (gain,) = parameters
    ...     return 0.5, 0.0, gain * (np.pi / 2 - pose[2])
    >>> Policy(turn_to_north, output="twist", parameters=[2.0]).is_twist
    True
    """

    def __init__(
        self,
        step: Callable[..., Any],
        *,
        output: str = "wheel_speeds",
        parameters: npt.ArrayLike = (),
    ) -> None:
        if output not in ("wheel_speeds", "twist"):
            raise TrundleError(f"output must be 'wheel_speeds' or 'twist', got {output!r}")
        values = numbers(parameters, "parameters")
        if values.ndim not in (1, 2):
            raise ShapeError(f"parameters must be (k,) or (N, k) numbers, got {values.shape}")
        self.step = plain_function(step, "t, pose, parameters")
        self.is_twist, self.parameters = output == "twist", values


def whole_seed(seed: object) -> int:
    """Return a seed.

    Raises:
        TrundleError: it is not a whole number from 0 on, or more than the generator tells apart.
    """
    whole = isinstance(seed, int | np.integer) and not isinstance(seed, bool)
    if not whole or not 0 <= seed < 2**128:  # type: ignore[operator]
        raise TrundleError(f"seed must be a whole number from 0 on, below 2**128, got {seed!r}")
    return int(seed)  # type: ignore[call-overload, no-any-return]


def numbers(values: npt.ArrayLike, name: str) -> Numbers:
    """Return an array of floats, float32 kept as it is; a copy only where one is needed.

    Raises:
        ShapeError: it is not an array of numbers.
    """
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "iufO":
            raise TypeError
        return given if given.dtype == np.float32 else np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"{name} must be an array of numbers, got {values!r}") from None


def _held(values: Numbers, name: str) -> Numbers:
    """Return (N, k) or (k,) as (1, k, N or 1)."""
    if values.ndim not in (1, 2):
        raise ShapeError(f"constant {name} must have shape (N, k) or (k,), got {values.shape}")
    # A copy: what a robot keeps does not change with the user's array.
    return np.array(np.atleast_2d(values).T, order="C")[None]


def _rows(values: Numbers, name: str) -> Numbers:
    """Return (T, N, k) or (T, k) as (T, k, N or 1)."""
    if values.ndim not in (2, 3):
        raise ShapeError(f"a stream of {name} has shape (T, N, k) or (T, k), got {values.shape}")
    return values[:, :, None] if values.ndim == 2 else values.swapaxes(1, 2)


def _whole(values: Numbers, name: str) -> Numbers:
    """Return (T, k, N) as it is."""
    if values.ndim != 3:
        raise ShapeError(f"{name} with the wheels first has shape (T, k, N), got {values.shape}")
    return values
