"""From the counters of the wheels to the pose, how far it may be off, and which wheel slips."""

from __future__ import annotations

from typing import Any, NamedTuple

from trundle.bridge.slip import SlipWatch
from trundle.bridge.uncertainty import make_resolution, make_tracker
from trundle.bridge.units import Counters, Numbers, shown
from trundle.limits import STILL, Twist
from trundle.robot import Robot

Pose = tuple[float, float, float]
Covariance = tuple[Pose, Pose, Pose]

# The upper triangle of a covariance of zeros.
_NONE: Numbers = (0.0,) * 6


class Odometry(NamedTuple):
    """What the counters have told so far.

    Attributes:
        time: time of the last reading [s].
        angles: steering angles at that time [rad].
        counts: the counters at that time; None before the first reading.
        pose: x, y, psi [m, m, rad]; psi is not wrapped.
        spread: upper triangle of the pose's covariance, without the counters' resolution.
        velocity: measured twist (u, v, r) over the last interval.
        moved_spread: upper triangle of the covariance of what the body moved by in it.
        interval: its length [s].
        slip: what the search for slipping wheels remembers.
        without: which wheels it left out.
        slipping: names of the wheels that disagree.
        residuals: (k) mismatch of the sensed wheels with the velocity [m/s].
        refused: how many readings were refused.
    """

    time: float
    angles: Numbers
    counts: tuple[int, ...] | None = None
    pose: Pose = (0.0, 0.0, 0.0)
    spread: Numbers = _NONE
    velocity: Twist = STILL
    moved_spread: Numbers = _NONE
    interval: float = 1.0
    slip: Numbers = ()
    without: frozenset[str] = frozenset()
    slipping: tuple[str, ...] = ()
    residuals: Numbers = ()
    refused: int = 0


class Odometer:
    """Odometry of one robot by its counters; it keeps nothing from cycle to cycle."""

    def __init__(
        self,
        robot: Robot,
        counters: Counters,
        wheel_noise: float,
        steering_noise: float,
        slip_threshold: float,
        without: frozenset[str],
    ) -> None:
        self._counters, self._without = counters, without
        self._steered = len(robot.steered)
        self._track = make_tracker(
            robot, wheel_noise, steering_noise, without, counters.resolutions
        )
        self._with_resolution = make_resolution(robot, counters.resolutions, without)
        self._slip = SlipWatch(
            robot, wheel_noise, steering_noise, slip_threshold, without, counters.resolutions
        )
        self._still = (0.0,) * len(robot.sensed)

    def start(self, time: float, pose: Pose, angles: Numbers) -> Odometry:
        """Return what is known before the first reading."""
        return Odometry(
            time,
            angles,
            pose=pose,
            slip=self._slip.start,
            without=self._without,
            residuals=self._still,
        )

    def step(
        self, last: Odometry, time: float, counts: Any, angles: Numbers, refusals: list[str]
    ) -> Odometry:
        """Return what is known after a reading; what is wrong with it is added to the refusals.

        A reading whose wheels have turned further than they can is taken for a reset of the
        counters: it is refused, and the next ones count from it.
        """
        read = self._counters.read(counts)
        if read is None:
            refusals.append(self._counters.fault(counts))
            return last._replace(refused=last.refused + 1)
        if last.counts is None or last.without - self._without:
            # The first reading, also of a wheel that was left out: what follows counts from it.
            spread = self._with_resolution(last.pose[2], last.spread, angles)
            known = last._replace(time=time, angles=angles, counts=read, spread=spread)
            return known._replace(slip=self._slip.start, without=self._without)
        interval = time - last.time
        if interval <= 0.0:
            return last  # the next reading makes it good
        turned = self._counters.turned(last.counts, read)
        if not self._counters.plausible(turned, interval):
            refusals.append(f"counts {shown(counts)}: the wheels cannot have turned so far since")
            refused = last.refused + 1
            return last._replace(time=time, angles=angles, counts=read, refused=refused)
        middle = angles
        if angles != last.angles:
            middle = tuple([0.5 * (a + b) for a, b in zip(last.angles, angles, strict=True)])
        told = self._track(*last.pose, *last.spread, *turned, *middle)
        # What another choice of wheels has seen says nothing of these.
        memory = last.slip if last.without == self._without else self._slip.start
        slip, slipping, residuals = self._slip.step(memory, turned, middle, interval)
        x, y, psi = told[:3]
        dx, dy, dpsi = told[9:12]
        return Odometry(
            time,
            angles,
            read,
            (x, y, psi),
            told[3:9],
            (dx / interval, dy / interval, dpsi / interval),
            told[12:],
            interval,
            slip,
            self._without,
            slipping,
            residuals,
            last.refused,
        )

    def covariance(self, known: Odometry) -> Covariance:
        """Return the covariance (3, 3) of the pose, with the counters' resolution."""
        return square(self._with_resolution(known.pose[2], known.spread, known.angles))


def velocity_covariance(known: Odometry) -> Covariance:
    """Return the covariance (3, 3) of the measured twist."""
    per = 1.0 / (known.interval * known.interval)
    return square(tuple([per * value for value in known.moved_spread]))


def square(triangle: Numbers) -> Covariance:
    """Return the symmetric matrix of an upper triangle."""
    xx, xy, xp, yy, yp, pp = triangle
    return (xx, xy, xp), (xy, yy, yp), (xp, yp, pp)
