"""From velocity commands to turning wheels, and back: one cycle of a robot's control loop."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from trundle.bridge.drive import Drive, Driver
from trundle.bridge.odometer import Odometer
from trundle.bridge.output import Output
from trundle.bridge.state import State
from trundle.bridge.units import Counters, Numbers, Units, items, shown
from trundle.errors import ShapeError, TrundleError, did_you_mean
from trundle.kinematics import finite
from trundle.limits import Twist, TwistLimits, limit_names
from trundle.robot import Encoder, Quantity, Robot

# No wheeled robot goes so fast [m/s, rad/s]: such a command comes from a fault.
_BEYOND = 1000.0
# A command is late when it is by more than this share of the timeout, which rounding is not.
_ROUNDING = 1e-9
# Nor is it by so many times what the time's own digits leave open.
_DIGITS = 4.0
# A clock that goes back by more than this has been set anew [s].
_BACK = 1.0


class Bridge:
    """The way from velocity commands (u, v, r) to wheel speeds, and from counters to a pose.

    A cycle takes the state of the last one and gives the next: nothing is kept inside, nothing
    waits and no clock is read, so that a test needs no hardware and no sleep.

    Args:
        robot: the robot.
        timeout: age at which a command is stale [s]. The robot then brakes at its deceleration,
            and is told to rest by timeout + v / max_deceleration.
        encoder: the encoder of wheels without one of their own.
        counter_bits: width of the counters, which wrap around; None for such that do not.
        wheel_noise: variance of a wheel's travel for each metre of it [m].
        steering_noise: variance of a steered wheel's side slip for each metre of its way [m].
        slip_threshold: how unlikely a mismatch of the wheels must be to be told, in standard
            deviations.
        max_interval: longest interval between two cycles over which a ramp goes on [s].
        without: names of sensed wheels that odometry leaves out.
        limits: the fields of ``trundle.limits.TwistLimits``: max_speed, max_acceleration, ...

    Raises:
        TrundleError: a setting is impossible, or the robot's linked steering has no formula.
        UnobservedMotionError: the sensed wheels do not observe every motion.

    >>> import trundle
    >>> robot = trundle.load("differential", radius=0.05, track=0.4)
    >>> bridge = Bridge(robot, timeout=0.5, max_speed=1.0, max_acceleration=2.0)
    >>> state = bridge.start(time=0.0)
    >>> output, state = bridge.step(state, 0.1, command=(0.4, 0.0, 0.0))
    >>> output.twist, [round(speed, 9) for speed in output.wheel_speeds]
    ((0.2, 0.0, 0.0), [4.0, 4.0])
    >>> output.limits
    ('acceleration',)
    """

    def __init__(
        self,
        robot: Robot,
        *,
        timeout: float = 0.5,
        encoder: Encoder | None = None,
        counter_bits: int | None = 32,
        wheel_noise: float = 1e-4,
        steering_noise: float = 1e-4,
        slip_threshold: float = 5.0,
        max_interval: float = 0.1,
        without: Iterable[str] = (),
        **limits: float | None,
    ) -> None:
        if not isinstance(robot, Robot):
            raise TrundleError(f"a bridge needs a Robot, such as load(...) gives, got {robot!r}")
        if not isinstance(encoder, Encoder | None):
            raise TrundleError(f"encoder must be an Encoder or None, got {encoder!r}")
        self._settings: dict[str, Any] = {
            "timeout": timeout,
            "encoder": encoder,
            "counter_bits": counter_bits,
            "wheel_noise": wheel_noise,
            "steering_noise": steering_noise,
            "slip_threshold": slip_threshold,
            "max_interval": max_interval,
        }
        known = [*self._settings, *limit_names()]
        self._settings |= limits
        for name in limits:
            if name not in limit_names():
                raise TrundleError(f"a bridge has no {name!r}{did_you_mean(name, known)}")
        self.robot, self.limits = robot, TwistLimits(**limits)
        self.timeout = _sound("timeout", timeout, "s")
        self.max_interval = _sound("max_interval", max_interval, "s")
        self.left_out = _names(robot, without)
        self._driver = Driver(robot, self.limits)
        self._units = Units(robot, encoder)
        self._odometer = Odometer(
            robot,
            Counters(robot, encoder, counter_bits, self.left_out),
            _sound("wheel_noise", wheel_noise, "m", zero=True),
            _sound("steering_noise", steering_noise, "m", zero=True),
            _sound("slip_threshold", slip_threshold),
            self.left_out,
        )

    def __repr__(self) -> str:
        """Return the robot's name and the timeout."""
        return f"Bridge({self.robot.name!r}, timeout={self.timeout:g} s)"

    def without(self, *names: str) -> Bridge:
        """Return the same bridge that no longer reads these sensed wheels; states stay valid.

        Raises:
            UnobservedMotionError: the other wheels do not observe every motion.

        >>> import trundle
        >>> sorted(Bridge(trundle.load("mecanum")).without("rear_left").left_out)
        ['rear_left']
        """
        return Bridge(self.robot, without=self.left_out | set(names), **self._settings)

    def start(
        self,
        time: float = 0.0,
        pose: Sequence[float] = (0.0, 0.0, 0.0),
        steering: Sequence[float] | None = None,
    ) -> State:
        """Return the state of a robot that stands.

        Args:
            time: time of a clock that never goes back [s].
            pose: x, y, psi [m, m, rad].
            steering: present steering angles [rad], in order; 0 without.

        Raises:
            ShapeError: a value is not finite, or there are too many or too few.
        """
        x, y, psi = _floats("pose", pose, 3)
        count = len(self.robot.steered)
        angles = (0.0,) * count if steering is None else _floats("steering", steering, count)
        (now,) = _floats("time", (time,), 1)
        known = self._odometer.start(now, (x, y, psi), angles)
        return State(now, self._driver.wheels.inputs_of(angles), known)

    def step(
        self,
        state: State,
        time: float,
        command: Sequence[float] | None = None,
        counts: Sequence[int] | None = None,
        steering: Sequence[float] | None = None,
    ) -> tuple[Output, State]:
        """Return what the robot is to do now, and the state after this cycle.

        A bad command, reading or time is refused, never raised: the last good command stands until
        it is stale, and the output tells what was refused, and why.

        Args:
            state: the state after the last cycle.
            time: time of this cycle [s].
            command: twist (u, v, r) asked [m/s, m/s, rad/s]; None where none came.
            counts: (k) counters of the sensed wheels; None where the reading was missed.
            steering: (s) measured steering angles [rad]; without them those told count.
        """
        refusals: list[str] = []
        known = state.odometry
        asked, asked_at, refused = state.command, state.command_time, state.refused
        now, elapsed, lost = _clock(state, time, self.max_interval, refusals)
        if lost:
            asked_at = -math.inf
            known = known._replace(time=now - elapsed - (state.time - known.time))
        if command is not None:
            good = _good(command, 3, _BEYOND)
            if good is None:
                refused += 1
                refusals.append(f"command {shown(command)}: not three numbers up to {_BEYOND:g}")
            else:
                (u, v, r), asked_at = good, now
                asked = u, v, r
        drive, stale = self._drive(state, asked, asked_at, now, elapsed)
        if counts is not None:
            angles = self._driver.wheels.angles(state.steering)
            if steering is not None:
                measured = _good(steering, len(angles), _BEYOND)
                if measured is None:
                    refusals.append(f"steering {shown(steering)}: not {len(angles)} angles")
                angles = angles if measured is None else measured
            known = self._odometer.step(known, now, counts, angles, refusals)
        u, v, r = drive.change
        rate = (u / elapsed, v / elapsed, r / elapsed) if elapsed else state.rate
        cycle = elapsed or state.cycle
        after = State(
            now, drive.steering, known, asked, asked_at, drive.twist, rate, cycle, refused
        )
        return self._output(after, drive, stale, elapsed, tuple(refusals)), after

    def _drive(
        self, state: State, asked: Twist, asked_at: float, now: float, elapsed: float
    ) -> tuple[Drive, bool]:
        """Return what the wheels are told, and whether the command is stale."""
        # What is told holds until the next cycle, which is as far away as the last one.
        late = now - asked_at + elapsed - self.timeout
        if now > asked_at and late > _ROUNDING * self.timeout + _DIGITS * math.ulp(now):
            return self._driver.brake(state.twist, state.steering, min(elapsed, late)), True
        dt = min(elapsed, self.max_interval)
        u, v, r = state.rate
        last = u * dt, v * dt, r * dt
        return self._driver.step(state.twist, last, state.steering, asked, dt), False

    def _output(
        self, state: State, drive: Drive, stale: bool, elapsed: float, refusals: tuple[str, ...]
    ) -> Output:
        wheels = self._driver.wheels
        angles = wheels.angles(drive.steering)
        return Output(
            wheels.speeds(drive.twist, angles),
            angles,
            drive.twist,
            drive.limits,
            stale,
            refusals,
            state.odometry,
            elapsed,
            self._units,
            self._odometer,
        )


def _clock(state: State, time: Any, usual: float, refusals: list[str]) -> tuple[float, float, bool]:
    """Return the time of a cycle, its length, and whether the clock was lost.

    A clock that goes back a little has stopped for a moment. One that shows no time goes on as
    before, so that commands grow old; so does one that jumps back, and what came before it is
    stale.
    """
    now = time if type(time) is float else (_good((time,), 1, math.inf) or (math.nan,))[0]
    if state.time <= now < math.inf:
        return now, now - state.time, False
    refusals.append(f"time {shown(time)}: not a time after {state.time:g} s")
    if state.time - _BACK <= now <= state.time:
        return state.time, 0.0, False
    cycle = state.cycle or usual
    if math.isfinite(now):
        return now, cycle, True
    return state.time + cycle, cycle, False


def _good(values: Any, count: int, largest: float) -> Numbers | None:
    """Return so many numbers of at most a size as floats, or None."""
    if type(values) is tuple and len(values) == count:
        for value in values:
            if type(value) is not float or not -largest <= value <= largest:
                break
        else:
            return values  # as a control loop gives them: nothing is to be done
    try:
        found = tuple([x if type(x) is float else _number(x) for x in items(values, count)])
    except Exception:  # noqa: BLE001 - whatever a stranger's object raises, it is refused
        return None
    if len(found) != count:
        return None
    for value in found:
        if not -largest <= value <= largest:
            return None
    return found


def _number(value: Any) -> float:
    """Return a number as a float; texts and truth values are none, although float() reads them."""
    if isinstance(value, str | bytes | bool):
        raise TypeError
    return float(value)


def _sound(name: str, value: Any, unit: str = "", zero: bool = False) -> float:
    """Return a setting that must be a positive number, or not negative where it may be zero.

    Raises:
        TrundleError: it is not.
    """
    if fault := Quantity(unit=unit, positive=not zero, nonnegative=True).fault(value):
        raise TrundleError(f"{name} {fault}")
    return float(value)


def _floats(name: str, values: Any, count: int) -> Numbers:
    """Return so many finite numbers.

    Raises:
        ShapeError: they are not finite, or too many or too few.
    """
    found = finite(values, name, count)
    if found.shape != (count,):
        raise ShapeError(f"{name} must be {count} numbers, got shape {found.shape}")
    return tuple(found.tolist())


def _names(robot: Robot, without: Iterable[str]) -> frozenset[str]:
    """Return names of sensed wheels.

    Raises:
        TrundleError: the robot has no such sensed wheel.
    """
    names = frozenset((without,) if isinstance(without, str) else without or ())
    known = [wheel.name for wheel in robot.sensed]
    for name in sorted(names - set(known)):
        raise TrundleError(
            f"robot {robot.name!r} has no sensed wheel {name!r}{did_you_mean(name, known)}"
        )
    return names
