"""A simulated robot driven by keys: what they ask for, the cycles, and the record of the drive."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass, replace

import numpy as np

from trundle.bridge import Bridge, Output, Reading, SimulatedRobot
from trundle.kinematics import Kinematics
from trundle.odometry import Counts
from trundle.robot import Encoder, Robot
from trundle.se2 import Array
from trundle.simulation import Run

Twist = tuple[float, float, float]
Pose = tuple[float, float, float]
STOP: Twist = (0.0, 0.0, 0.0)

# What a key asks for, in shares of the speed, the speed sideways and the turning speed. The letters
# around k are those of teleop_twist_keyboard, where capitals move sideways.
MOVES: dict[str, Twist] = {
    "i": (1, 0, 0), "u": (1, 0, 1), "o": (1, 0, -1), "j": (0, 0, 1), "l": (0, 0, -1),
    ",": (-1, 0, 0), "m": (-1, 0, -1), ".": (-1, 0, 1),
    "I": (1, 0, 0), "U": (1, 1, 0), "O": (1, -1, 0), "J": (0, 1, 0), "L": (0, -1, 0),
    "<": (-1, 0, 0), "M": (-1, 1, 0), ">": (-1, -1, 0),
    "up": (1, 0, 0), "down": (-1, 0, 0), "left": (0, 0, 1), "right": (0, 0, -1),
    "w": (1, 0, 0), "s": (-1, 0, 0), "a": (0, 0, 1), "d": (0, 0, -1),
    "q": (0, 1, 0), "e": (0, -1, 0),
    "k": STOP, "space": STOP,
}  # fmt: skip
FASTER, SLOWER = ("+", "="), ("-", "_")
QUIT = ("x", "X", "escape", "interrupt")

_STEP = 1.1  # of the speeds
_LEAST = 0.01  # times the speeds at the start
# A key that repeats is let go when so many of its intervals pass without it, and at least so long.
_INTERVALS, _LET_GO = 3.0, 0.2
# A key does something if this share of what it asks for remains.
_ANY = 1e-6
# Half of what a counter of 32 bits counts, the width on both sides here.
_HALF = 2.0**31


@dataclass(frozen=True)
class Hand:
    """Which key is held, and the speeds that keys ask for.

    Terminals tell when a key comes, not when it is let go: a key that repeats and then stays away
    is taken for let go. One that comes once is left to the bridge, for which its command gets
    stale.

    Attributes:
        speed: of keys ahead and sideways [m/s].
        turn: of keys that turn [rad/s].
        timeout: age at which the bridge takes a command for stale [s].
        most: largest factor, with which the speeds are at their limits.
        key: the key that is held, or "".
        since: when it came last [s].
        interval: between its last two coming [s]; infinite where it came once.
        factor: what the speeds were changed by.
    """

    speed: float
    turn: float
    timeout: float
    most: float = math.inf
    key: str = ""
    since: float = 0.0
    interval: float = math.inf
    factor: float = 1.0

    def press(self, key: str, time: float) -> Hand:
        """Return the hand after a key came; keys that mean nothing change nothing."""
        if key in FASTER:
            return replace(self, factor=min(_STEP * self.factor, self.most))
        if key in SLOWER:
            return replace(self, factor=max(self.factor / _STEP, _LEAST))
        if key not in MOVES:
            return self
        repeats = key == self.key and time - self.since < self.timeout
        return replace(
            self, key=key, since=time, interval=time - self.since if repeats else math.inf
        )

    def let_go(self, time: float) -> bool:
        """Return whether the key that was held has stayed away."""
        wait = max(_INTERVALS * self.interval, _LET_GO)
        return self.key != "" and time - self.since > wait

    def released(self) -> Hand:
        """Return the hand with no key."""
        return replace(self, key="", interval=math.inf)

    @property
    def command(self) -> Twist:
        """The twist (u, v, r) that the held key asks for."""
        along, across, about = MOVES.get(self.key, STOP)
        speed, turn = self.factor * self.speed, self.factor * self.turn
        return speed * along, speed * across, turn * about


def idle_keys(robot: Robot) -> dict[str, str]:
    """Return the keys that do nothing on a robot, each with a sentence that tells why.

    >>> from trundle import load
    >>> idle_keys(load("differential"))["J"]
    'differential cannot move sideways: J, L, q, e do nothing'
    """
    kinematics = Kinematics(robot)
    why: dict[str, list[str]] = {}
    for key, twist in MOVES.items():
        given = kinematics.inverse(twist, limit=False).twist
        if twist == STOP or np.abs(given).max() > _ANY:
            continue
        along, across, _ = map(bool, twist)
        reason = "go" if along else "move sideways" if across else "turn on the spot"
        why.setdefault(reason, []).append(key)
    return {
        key: f"{robot.name} cannot {reason}: {', '.join(keys)} do nothing"
        for reason, keys in why.items()
        for key in keys
    }


class Record:
    """The numbers of a drive, a row for each cycle, kept small enough for hours."""

    def __init__(self, robot: Robot) -> None:
        n, s, k = len(robot.driven), len(robot.steered), len(robot.sensed)
        self._widths = (1, 3, 3, 3, n, s, k, s)
        self._numbers = array("d")

    def add(self, time: float, truth: Pose, output: Output, reading: Reading) -> None:
        """Add the row of a cycle."""
        assert reading.counts is not None
        assert reading.steering is not None
        seen = (*reading.counts, *reading.steering)
        told = (*output.pose, *output.velocity, *output.wheel_speeds, *output.steering)
        self._numbers.extend((time, *truth, *told, *seen))

    def columns(self) -> list[Array]:
        """Return the blocks of columns, the time as (T,), the others as (T, ...).

        In order: time, true pose, pose, velocity, wheel speeds, steering told, counts, steering
        seen.
        """
        table = np.array(self._numbers).reshape(-1, sum(self._widths))
        time, *others = np.split(table, np.cumsum(self._widths)[:-1], axis=1)
        return [time[:, 0], *others]


class Desk:
    """A bridge and a simulated robot that misses no reading, cycle by cycle, and their record.

    Attributes:
        output, state: of the bridge, after the last cycle.
        truth: the true pose.
        slipped: names of the wheels that disagreed at some time.
    """

    def __init__(self, bridge: Bridge, simulated: SimulatedRobot) -> None:
        self.bridge, self._simulated = bridge, simulated
        self._robot_state = simulated.start(time=0.0)
        self._record = Record(bridge.robot)
        self.state = bridge.start(time=0.0)
        self.slipped: set[str] = set()
        self.output = self._bridge_step(0.0, None, simulated.read(self._robot_state))

    def cycle(self, time: float, command: Twist | None = None) -> Output:
        """Bring the robot and the bridge to a time [s] and return what the bridge says."""
        reading, self._robot_state = self._simulated.step(
            self._robot_state, time, self.output.wheel_speeds, self.output.steering
        )
        self.output = self._bridge_step(time, command, reading)
        self.slipped.update(self.output.slipping)
        return self.output

    def _bridge_step(self, time: float, command: Twist | None, reading: Reading) -> Output:
        output, self.state = self.bridge.step(
            self.state, time, command=command, counts=reading.counts, steering=reading.steering
        )
        self._record.add(time, self.truth, output, reading)
        return output

    @property
    def truth(self) -> Pose:
        """The true pose."""
        return self._robot_state.pose

    @property
    def rests(self) -> bool:
        """Whether the robot is told to stand still."""
        return self.output.twist == STOP

    def run(self) -> tuple[Run, Array]:
        """Return the drive as odometry tells it, and the true poses (T + 1, 3)."""
        robot = self.bridge.robot
        t, truth, pose, velocity, speeds, steering, *_ = self._record.columns()
        angles = np.zeros(speeds.shape)
        np.cumsum(speeds[:-1] * np.diff(t)[:, None], axis=0, out=angles[1:])
        run = Run(
            t=t,
            pose=pose,
            twist=velocity[1:],
            wheel_speeds=speeds[:-1],
            steering=steering[:-1],
            wheel_angles=angles,
            driven=tuple(wheel.name for wheel in robot.driven),
            steered=tuple(wheel.name for wheel in robot.steered),
        )
        return run, truth

    def log(self, encoder: Encoder) -> dict[str, Array | Counts]:
        """Return the columns of a log: what the sensors showed, and the true poses.

        Wheels with an encoder of their own give counts, the others the angle of the ticks counted.
        The counts run on below zero and beyond the counter, so that nobody need know its width.

        Args:
            encoder: of the wheels that have none of their own.
        """
        t, truth, *_, counts, steering = self._record.columns()
        columns: dict[str, Array | Counts] = {"time": t}
        columns |= dict(zip(("x", "y", "psi"), truth.T, strict=True))
        robot = self.bridge.robot
        for wheel, column in zip(robot.sensed, counts.T, strict=True):
            moved = (np.diff(column, prepend=column[0]) + _HALF) % (2 * _HALF) - _HALF
            counted = np.cumsum(moved)
            if wheel.encoder is not None:
                columns[f"counts:{wheel.name}"] = counted.astype(np.int64)
            else:
                columns[f"angle:{wheel.name}"] = counted * encoder.radians_per_tick
        for wheel, column in zip(robot.steered, steering.T, strict=True):
            middle = (column[1:] + column[:-1]) / 2
            columns[f"steering:{wheel.name}"] = np.concatenate([column[:1], middle])
        return columns
