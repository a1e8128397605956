"""A simulated robot: wheel speeds in, encoder counts out, as the real one would answer a bridge."""

from __future__ import annotations

import math
import operator
import random
from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from typing import Any, NamedTuple

from trundle.bridge.ground import Ground, Standing, Vector
from trundle.bridge.servos import Servos
from trundle.bridge.units import Numbers
from trundle.errors import TrundleError, did_you_mean
from trundle.robot import Encoder, Robot, RollingWheel
from trundle.se2 import step as step_pose

_STREAM = 64  # bits that count the steps of one seed


class Reading(NamedTuple):
    """What the sensors show at the end of a step.

    Attributes:
        counts: (k) encoder counters of the sensed wheels, in order; None where the reading is lost.
        steering: (s) steering angles [rad]; None where the reading is lost.
    """

    counts: tuple[int, ...] | None
    steering: Numbers | None


class SimulatedState(NamedTuple):
    """Where a simulated robot is, and what its wheels do.

    Attributes:
        time: [s].
        pose: the true x, y, psi [m, m, rad]; psi is not wrapped.
        twist: mean (u, v, r) of the last step [m/s, m/s, rad/s].
        wheel_speeds: (n) of the driven wheels' motors [rad/s].
        steering: (s) angles [rad].
        turned: (k) turn of the sensed wheels [rad], which the counters show in whole ticks.
        steps: how many steps there were: with the seed it tells the noise of the next.
    """

    time: float
    pose: Vector
    twist: Vector
    wheel_speeds: Numbers
    steering: Numbers
    turned: Numbers
    steps: int


class _Wheel(NamedTuple):
    """A wheel's noise and faults in plain floats."""

    variance: float  # of what is rolled, for a turn of one radian [rad^2]
    spin: float = 1.0  # turn of the motor for a turn that the ground feels; 0 for a stuck wheel
    grip: float = 1.0  # the inverse; 0 for a stuck wheel

    def noise(self, turn: float, random: random.Random) -> float:
        """Return by how much a wheel that should roll a turn [rad] rolls differently [rad]."""
        return math.sqrt(self.variance * abs(turn)) * random.gauss(0.0, 1.0)


class SimulatedRobot:
    """A robot on the desk, with the motors, sensors and faults that a real one has.

    Motors follow their commands with a first-order lag, solved exactly over a step; the rims roll
    with noise; the body follows them by least squares over the driven wheels' rolling and the
    steered wheels' side slip, and moves along the arc of the step's mean twist. ``step`` is pure:
    the noise depends on the seed and on the number of the step alone.

    Args:
        robot: the robot.
        encoder: that of the sensed wheels which have none of their own.
        motor_lag: time constant of the motors [s].
        wheel_noise: variance of what a wheel rolls, per metre [m]; with 1e-4 it is off by 1 cm
            after 1 m.
        steering_noise: variance of a steered wheel's slip to the side, per metre [m].
        counter_bits: width of the counters, which wrap around to 0; None: they do not.
        seed: of the noise.
        slip: wheels that slip, each with the share of its turn that the ground does not feel: the
            wheel spins the faster for it. Below 0 the wheel drags: it spins too slowly.
        stuck: wheels that do not turn; a driven one drags on the ground.
        missed: share of the readings that are lost.

    Raises:
        TrundleError: a sensed wheel has no encoder, or a setting is impossible.

    Source: for the noise, Chong and Kleeman, Accurate odometry and error modelling for a mobile
    robot, ICRA 1997: variances grow with the distance.

    >>> from trundle import Encoder, load
    >>> robot = SimulatedRobot(
    ...     load("differential", radius=0.05),
    ...     encoder=Encoder(ticks_per_motor_turn=1000),
    ...     motor_lag=0.0,
    ...     wheel_noise=0.0,
    ... )
    >>> state = robot.start()
    >>> reading, state = robot.step(state, 1.0, (10.0, 10.0))
    >>> state.pose, reading.counts  # 10 rad are 1591.5 ticks
    ((0.5, 0.0, 0.0), (1592, 1592))
    """

    def __init__(
        self,
        robot: Robot,
        *,
        encoder: Encoder | None = None,
        motor_lag: float = 0.05,
        wheel_noise: float = 1e-4,
        steering_noise: float = 1e-4,
        counter_bits: int | None = 32,
        seed: int = 0,
        slip: Mapping[str, float] | None = None,
        stuck: Iterable[str] = (),
        missed: float = 0.0,
    ) -> None:
        self.robot = robot
        self._lag = _not_negative(motor_lag, "motor_lag")
        wheel_noise = _not_negative(wheel_noise, "wheel_noise")
        self._steering_noise = _not_negative(steering_noise, "steering_noise")
        self._mask = _mask(counter_bits)
        self._seed = _whole(seed)
        self._missed = _not_negative(missed, "missed")
        if self._missed > 1:
            raise TrundleError(f"missed must be a share from 0 to 1, got {missed:g}")
        self._resolutions = _resolutions(robot, encoder)
        faults = _faults(robot, slip or {}, stuck)
        self._driven = tuple(_constants(wheel, wheel_noise, faults) for wheel in robot.driven)
        self._sensed = tuple(_constants(wheel, wheel_noise, faults) for wheel in robot.sensed)
        places = {wheel.name: i for i, wheel in enumerate(robot.driven)}
        self._motors = tuple(places.get(wheel.name, -1) for wheel in robot.sensed)
        self._servos = Servos(robot)
        self._ground = Ground(robot)
        self._noisy = wheel_noise > 0 or self._steering_noise > 0

    def start(
        self,
        time: float = 0.0,
        pose: Sequence[float] = (0.0, 0.0, 0.0),
        steering: Sequence[float] | None = None,
    ) -> SimulatedState:
        """Return the state at rest, with all counters at 0, each somewhere inside its tick.

        Args:
            time: [s].
            pose: (x, y, psi) in the inertial frame [m, m, rad].
            steering: (s) angles [rad]; default: 0, or the nearest within the limits.

        Raises:
            TrundleError: they are not so many finite numbers.
        """
        x, y, psi = _numbers(pose, 3, "pose")
        angles = [0.0] * len(self.robot.steered) if steering is None else steering
        uniform = random.Random(self._seed << _STREAM).random
        return SimulatedState(
            time=_numbers([time], 1, "time")[0],
            pose=(x, y, psi),
            twist=(0.0, 0.0, 0.0),
            wheel_speeds=(0.0,) * len(self._driven),
            steering=self._servos.within(_numbers(angles, len(self.robot.steered), "steering")),
            turned=tuple(uniform() * size for size in self._resolutions),
            steps=0,
        )

    def step(
        self,
        state: SimulatedState,
        time: float,
        wheel_speeds: Sequence[float],
        steering: Sequence[float] = (),
    ) -> tuple[Reading, SimulatedState]:
        """Return the reading and the state at a time, with commands held since the state's.

        Args:
            state: the state.
            time: [s], not before the state's.
            wheel_speeds: (n) commands of the motors [rad/s].
            steering: (s) commanded steering angles [rad].

        Raises:
            TrundleError: time goes backwards, or a command is not so many finite numbers.
        """
        time = float(time)
        dt = time - state.time
        if not 0 <= dt < math.inf:
            raise TrundleError(f"time must not go backwards: {time:g} s after {state.time:g} s")
        wanted = _numbers(wheel_speeds, len(self._driven), "wheel_speeds")
        angles = _numbers(steering, len(state.steering), "steering")
        speeds, turns = self._spin(state.wheel_speeds, wanted, dt)
        middle, angles = self._servos.move(state.steering, angles, dt)
        noise = random.Random(self._seed << _STREAM | state.steps + 1)
        standing = self._ground.at(middle)
        moved = self._roll(turns, standing, noise)
        twist = (moved[0] / dt, moved[1] / dt, moved[2] / dt) if dt > 0 else state.twist
        seen = self._sense(turns, standing.rolled(moved), noise)
        after = SimulatedState(
            time=time,
            pose=step_pose(*state.pose, *moved),
            twist=twist,
            wheel_speeds=speeds,
            steering=angles,
            turned=tuple(map(operator.add, state.turned, seen)),
            steps=state.steps + 1,
        )
        if self._missed and noise.random() < self._missed:
            return Reading(None, None), after
        return self.read(after), after

    def read(self, state: SimulatedState) -> Reading:
        """Return what the sensors show in a state: whole ticks, as the counters hold them."""
        counts = [
            math.floor(turn / size)
            for turn, size in zip(state.turned, self._resolutions, strict=True)
        ]
        if self._mask:
            counts = [count & self._mask for count in counts]
        return Reading(tuple(counts), state.steering)

    def _spin(self, speeds: Numbers, wanted: Numbers, dt: float) -> tuple[Numbers, Numbers]:
        """Return the motors' speeds after a step and what they turned: w' = (w* - w) / lag."""
        left = math.exp(-dt / self._lag) if self._lag else 0.0
        late = self._lag * (1.0 - left)
        after, turns = [], []
        for wheel, speed, command in zip(self._driven, speeds, wanted, strict=True):
            target = wheel.spin * command
            after.append(target + left * (speed - target))
            turns.append(target * dt + late * (speed - target))
        return tuple(after), tuple(turns)

    def _roll(self, turns: Numbers, standing: Standing, noise: random.Random) -> Vector:
        """Return the body increment [m, m, rad] of what the wheels roll and slip."""
        rolled = [wheel.grip * turn for wheel, turn in zip(self._driven, turns, strict=True)]
        moved = standing.increment(rolled)
        if not self._noisy:
            return moved
        rolled = [
            turn + wheel.noise(turn, noise)
            for wheel, turn in zip(self._driven, rolled, strict=True)
        ]
        slipped = [
            math.sqrt(self._steering_noise * travel) * noise.gauss(0.0, 1.0)
            for travel in standing.travels(moved)
        ]
        return standing.increment(rolled, slipped)

    def _sense(self, turns: Numbers, rolled: Sequence[float], noise: random.Random) -> list[float]:
        """Return what the sensed wheels turn [rad]: those with a motor as it does, others roll."""
        seen = []
        for wheel, motor, turn in zip(self._sensed, self._motors, rolled, strict=True):
            if motor >= 0:
                seen.append(turns[motor])
            else:
                seen.append(wheel.spin * (turn + wheel.noise(turn, noise)))
        return seen


def _constants(wheel: RollingWheel, noise: float, faults: Mapping[str, float]) -> _Wheel:
    made = _Wheel(variance=noise / wheel.radius)
    slip = faults.get(wheel.name)
    if slip is None:
        return made
    grip = 1.0 - slip
    return made._replace(spin=1.0 / grip if grip else 0.0, grip=grip)


def _faults(robot: Robot, slip: Mapping[str, float], stuck: Iterable[str]) -> dict[str, float]:
    """Return the slip of the wheels that have one; 1 for those that are stuck."""
    names = [wheel.name for wheel in robot.wheels if isinstance(wheel, RollingWheel)]
    stuck = [stuck] if isinstance(stuck, str) else list(stuck)
    for name in (*slip, *stuck):
        if name not in names:
            raise TrundleError(
                f"robot {robot.name!r} has no wheel {name!r} that could slip or be stuck"
                f"{did_you_mean(name, names)}; it has {', '.join(names)}"
            )
    for name, share in slip.items():
        if not (_is_number(share) and math.isfinite(share) and share < 1):
            raise TrundleError(f"wheel {name!r}: its slip must be a number below 1, got {share!r}")
    return {name: float(share) for name, share in slip.items()} | dict.fromkeys(stuck, 1.0)


def _resolutions(robot: Robot, encoder: Encoder | None) -> Numbers:
    """Return the turn of each sensed wheel for one tick [rad]."""
    if not robot.sensed:
        raise TrundleError(
            f"robot {robot.name!r} has no sensed wheel, so it gives no counts: leave out "
            "measured = false, or add a wheel with an encoder"
        )
    found = [wheel.encoder or encoder for wheel in robot.sensed]
    without = [repr(w.name) for w, e in zip(robot.sensed, found, strict=True) if e is None]
    if without:
        raise TrundleError(
            f"robot {robot.name!r}: no encoder on {', '.join(without)}, so there are no counts: "
            "add encoder = { ticks_per_motor_turn = ..., gear = ... } to each in the robot file, "
            "or give one for all, encoder=Encoder(ticks_per_motor_turn=...)"
        )
    return tuple(each.radians_per_tick for each in found if each is not None)


def _mask(bits: Any) -> int:
    """Return the bits that a counter shows, 0 for one that does not wrap around."""
    if bits is None:
        return 0
    if type(bits) is not int or not 8 <= bits <= 64:
        raise TrundleError(f"counter_bits must be from 8 to 64, or None, got {bits!r}")
    return (1 << bits) - 1


def _whole(seed: Any) -> int:
    if type(seed) is not int or seed < 0:
        raise TrundleError(f"seed must be a whole number, 0 or more, got {seed!r}")
    return seed


def _not_negative(value: Any, name: str) -> float:
    if not _is_number(value) or not 0 <= value < math.inf:
        raise TrundleError(f"{name} must be a finite number, 0 or more, got {value!r}")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _numbers(values: Any, count: int, name: str) -> Numbers:
    """Return so many finite numbers as floats."""
    try:
        made = tuple(map(float, values))
    except (TypeError, ValueError, OverflowError):
        raise TrundleError(f"{name} must be {count} numbers, got {values!r}") from None
    if len(made) != count:
        raise TrundleError(f"{name} must be {count} numbers, got {len(made)}")
    if not all(map(math.isfinite, made)):
        raise TrundleError(f"{name} must be finite numbers, got {made}")
    return made
