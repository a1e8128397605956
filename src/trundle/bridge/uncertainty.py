"""Dead reckoning with covariance: how far off the pose may be that the wheels tell.

Each sensed wheel's travel and each steered wheel's side slip are random walks along its way: their
variances grow with the metres, not with the steps. What they make of the body's increment is
``Q = B S B^T``, with B the estimator; and with F and G the derivatives of the exact arc step by the
pose and by the increment,

    P' = F P F^T + G Q G^T + D Q D^T / 12.

G Q G^T takes the error as spread evenly over the step; that it comes bit by bit, with different
parts of the arc still ahead, adds the last term: D is how much less the error at the end of the
step moves the pose than that at its start. So one long step gives what many short ones do.

All is one program in straight lines, which floats and arrays run.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from trundle.errors import TrundleError, UnobservedMotionError
from trundle.kinematics import Code, Estimate, Kinematics, Straight, step_lines
from trundle.robot import Robot, RollingWheel

_POSE = ("x", "y", "psi")
_SPREAD = ("p_xx", "p_xy", "p_xp", "p_yy", "p_yp", "p_pp")
# A count stands for any angle from one tick to the next: the variance of an even distribution.
_EVEN = 1.0 / 12.0
# Positions in general at which the wheels are asked what they observe.
_POSITIONS = 3
_SEED = 2004  # any fixed seed: what is observed does not hang on it


def make_tracker(
    robot: Robot,
    wheel_noise: float,
    steering_noise: float,
    without: frozenset[str] = frozenset(),
    resolutions: Sequence[float] = (),
) -> Callable[..., tuple[float, ...]]:
    """Return the function that takes a pose and its covariance one odometry step on.

    Args:
        robot: the robot.
        wheel_noise: variance of a wheel's travel over its length [m^2/m]: the increment [rad] of a
            wheel of radius a that turns by d has variance ``wheel_noise |d| / a``.
        steering_noise: variance of a steered wheel's side slip over its way [m^2/m].
        without: names of sensed wheels that are not to count.
        resolutions: (k) turn of each sensed wheel for one count [rad]; they widen the increment's
            covariance alone, since what one step counts too much the next counts too little.

    Returns:
        (x, y, psi, p_xx, p_xy, p_xp, p_yy, p_yp, p_pp, *increments, *steering) -> the same nine
        after the step, then the body's increment (dx, dy, dpsi) and the six entries of its
        covariance. Increments [rad] are those of all sensed wheels, in order; steering angles [rad]
        those at the middle of the step.

    Raises:
        UnobservedMotionError: the sensed wheels do not observe every motion.
        TrundleError: ``without`` names a wheel that is not sensed.

    Source: the propagation of Siegwart and Nourbakhsh, 2004, section 5.2.4, eqs. (5.6) to (5.10),
    with exact arcs and any wheels.

    >>> from trundle import load
    >>> track = make_tracker(load("differential", radius=0.05), 1e-4, 1e-4)
    >>> _, _, _, p_xx, *_ = track(*[0.0] * 9, 20.0, 20.0)  # a metre straight ahead
    >>> round(p_xx, 9)  # two wheels share the variance
    5e-05
    """
    return tracker_lines(robot, wheel_noise, steering_noise, without, resolutions).compile()


def tracker_lines(
    robot: Robot,
    wheel_noise: float,
    steering_noise: float,
    without: frozenset[str] = frozenset(),
    resolutions: Sequence[float] = (),
) -> Straight:
    """Return the program of ``make_tracker``."""
    wheels = counted(robot, without)
    code, estimate = Code(), Estimate.of(robot, wheels)
    turns, angles = turns_of(robot, without), names("s", len(robot.steered))
    moved = [code.name(each) for each in estimate.twist(code, turns, angles)]
    pose = step_lines(code, moved)
    rolling, slip = travel_variances(
        code, robot, estimate, moved, wheels, (turns, angles), wheel_noise, steering_noise
    )
    Q = [code.name(each) for each in estimate.covariance(code, rolling, slip, angles)]
    told = Q
    if resolutions:
        counts = _count_variances(robot, wheels, resolutions, 2.0)
        told = estimate.covariance(code, counts, ["0.0"] * len(robot.steered), angles)
        told = [code.sum(a, code.name(b)) for a, b in zip(Q, told, strict=True)]
    arguments = (*_POSE, *_SPREAD, *names("w", len(robot.sensed)), *angles)
    results = (*pose, *_spread_lines(code, Q), "dx", "dy", "dpsi", *told)
    return code.program("track", arguments, results)


def make_resolution(
    robot: Robot, resolutions: Sequence[float], without: frozenset[str] = frozenset()
) -> Callable[..., tuple[float, ...]]:
    """Return the function that adds what one reading of the counters leaves open.

    A reading lies anywhere within a count. Of the readings on the way, each count too much is one
    too little in the next step; what stays are the first and the last: add this once to the
    covariance at the start (of zeros), and once wherever the covariance is read.

    Args:
        robot: the robot.
        resolutions: (k) turn of each sensed wheel for one count [rad].
        without: names of sensed wheels that are not to count.

    Returns:
        (psi, spread, steering) -> the six entries of the spread (xx, xy, xp, yy, yp, pp) and of
        the reading together, at the pose's psi and the steering angles (s) [rad].

    >>> from trundle import load
    >>> read = make_resolution(load("differential", radius=0.05, track=0.4), (0.01, 0.01))
    >>> round(1e9 * read(0.0, (0.0,) * 6, ())[0], 3)  # (0.05 m * 0.01 rad)^2 / 12 / 2
    10.417
    """
    wheels = counted(robot, without)
    code, estimate = Code(), Estimate.of(robot, wheels)
    angles = names("s", len(robot.steered))
    counts = _count_variances(robot, wheels, resolutions, 1.0)
    body = estimate.covariance(code, counts, ["0.0"] * len(robot.steered), angles)
    code.lines += zip(("uu", "uv", "ur", "vv", "vr", "rr"), body, strict=True)
    code.lines += [("c", "cos(psi)"), ("s", "sin(psi)")]
    code.lines += [("across", "2.0 * c * s * uv")]
    results = (
        "p_xx + c * c * uu - across + s * s * vv",
        "p_xy + c * s * (uu - vv) + (c * c - s * s) * uv",
        "p_xp + c * ur - s * vr",
        "p_yy + s * s * uu + across + c * c * vv",
        "p_yp + s * ur + c * vr",
        "p_pp + rr",
    )
    add = code.program("add", ("psi", *_SPREAD, *angles), results).compile()

    def read(psi: float, spread: Sequence[float], steering: Sequence[float]) -> tuple[float, ...]:
        return add(psi, *spread, *steering)

    return read


def counted(robot: Robot, without: frozenset[str]) -> tuple[RollingWheel, ...]:
    """Return the sensed wheels that count.

    Raises:
        UnobservedMotionError: they do not observe every motion, at any steering angles.
        TrundleError: ``without`` names a wheel that is not sensed.
    """
    known = [wheel.name for wheel in robot.sensed]
    for name in sorted(without):
        if name not in known:
            raise TrundleError(
                f"without: robot {robot.name!r} has no sensed wheel {name!r}; it has "
                f"{', '.join(map(repr, known)) or 'none'}"
            )
    kept = tuple(wheel for wheel in robot.sensed if wheel.name not in without)
    wheels = tuple(
        dataclasses.replace(wheel, measured=False)
        if isinstance(wheel, RollingWheel) and wheel.name in without
        else wheel
        for wheel in robot.wheels
    )
    kinematics, angles = Kinematics(dataclasses.replace(robot, wheels=wheels)), None
    random = np.random.default_rng(_SEED)
    fault: UnobservedMotionError | None = None
    for _ in range(_POSITIONS if robot.steered else 1):
        if robot.steered:
            angles = kinematics.inverse(random.normal(size=3), limit=False).steering
        try:
            kinematics.odometry_matrix(angles)
            return kept
        except UnobservedMotionError as error:
            fault = error
    left_out = f"without {', '.join(map(repr, sorted(without)))}: " if without else ""
    raise UnobservedMotionError(f"{left_out}{fault}") from None


def travel_variances(
    code: Code,
    robot: Robot,
    estimate: Estimate,
    moved: Sequence[str],
    wheels: Sequence[RollingWheel],
    measured: tuple[Sequence[str], Sequence[str]],
    wheel_noise: float,
    steering_noise: float,
) -> tuple[list[str], list[str]]:
    """Return names of the variances of the rim travels along the rows, and of the side slips [m^2].

    A roller takes up what does not lie along its axis: a Swedish wheel's travel counts with the
    squared cosine of its roller angle. A steered wheel whose turning is not measured travels as
    the body's increment says.
    """
    turns, angles = measured
    ways = [code.name(f"sqrt({turn} * {turn})") for turn in turns]
    rolling = [
        code.product(repr(wheel_noise * float(gain) ** 2 / wheel.radius), way)
        for wheel, gain, way in zip(wheels, estimate.gains, ways, strict=True)
    ]
    travel = {
        wheel.name: code.product(repr(steering_noise * wheel.radius), way)
        for wheel, way in zip(wheels, ways, strict=True)
        if wheel.steers
    }
    for j in estimate.loose:
        along = code.linear(np.stack([estimate.along[j], estimate.across[j]]), moved)
        c, s = code.name(f"cos({angles[j]})"), code.name(f"sin({angles[j]})")
        way = code.sum(*(code.product(a, code.name(b)) for a, b in zip((c, s), along, strict=True)))
        far = code.name(f"sqrt({way} * {way})")
        travel[robot.steered[j].name] = code.product(repr(steering_noise), far)
    return rolling, [travel[wheel.name] for wheel in robot.steered]


def _spread_lines(code: Code, Q: Sequence[str]) -> list[str]:
    """Return expressions for the pose's new covariance, after the lines of the step.

    With m the motion and J its quarter turn, F has the column ``J m`` for psi. G has the rows
    ``X = (c, -s, g_x)``, ``Y = (s, c, g_y)`` and (0, 0, 1), with ``g = (k e + J m) / 2``, where e
    is the increment turned to the middle heading and k the chord's derivative by the half angle.
    From the step's start to its end an error's effect turns by dpsi, and its arm shrinks from m
    to 0: D has the rows ``(0, 0, a) - dpsi Y`` and ``(0, 0, b) + dpsi X``.
    """
    uu, uv, ur, vv, vr, rr = Q
    code.lines += [
        ("mx", "c * dx - s * dy"),
        ("my", "s * dx + c * dy"),
        # (cos h - sin h / h) / h: h over the square of what is never zero is 0 at h = 0.
        ("k", "(cos(nonzero) - chord) * half / (nonzero * nonzero)"),
        ("kc", "k * cos(middle)"),
        ("ks", "k * sin(middle)"),
        ("gx", "0.5 * (kc * dx - ks * dy - my)"),
        ("gy", "0.5 * (ks * dx + kc * dy + mx)"),
        ("xu", f"c * {uu} - s * {uv} + gx * {ur}"),
        ("xv", f"c * {uv} - s * {vv} + gx * {vr}"),
        ("xr", f"c * {ur} - s * {vr} + gx * {rr}"),
        ("yu", f"s * {uu} + c * {uv} + gy * {ur}"),
        ("yv", f"s * {uv} + c * {vv} + gy * {vr}"),
        ("yr", f"s * {ur} + c * {vr} + gy * {rr}"),
        ("xx", "c * xu - s * xv + gx * xr"),
        ("xy", "s * xu + c * xv + gy * xr"),
        ("yy", "s * yu + c * yv + gy * yr"),
        ("a", "my + dpsi * gy"),
        ("b", "-mx - dpsi * gx"),
        ("twelfth", f"{1 / 12!r} * dpsi"),
        ("turn", "twelfth * dpsi"),
        ("ar", f"{1 / 12!r} * a * {rr}"),
        ("br", f"{1 / 12!r} * b * {rr}"),
        ("xp", "p_xp - my * p_pp"),
        ("yp", "p_yp + mx * p_pp"),
    ]
    return [
        "p_xx - my * (p_xp + xp) + xx + turn * yy - 2.0 * twelfth * a * yr + a * ar",
        "p_xy - my * p_yp + mx * xp + xy - turn * xy + twelfth * (a * xr - b * yr) + a * br",
        "xp + xr",
        "p_yy + mx * (p_yp + yp) + yy + turn * xx + 2.0 * twelfth * b * xr + b * br",
        "yp + yr",
        f"p_pp + {rr}",
    ]


def _count_variances(
    robot: Robot, wheels: Sequence[RollingWheel], resolutions: Sequence[float], readings: float
) -> list[str]:
    """Return the variances of rim travels along the rows that so many readings leave [m^2]."""
    of = dict(zip((wheel.name for wheel in robot.sensed), resolutions, strict=True))
    gains = [wheel.rows(0.0).gain for wheel in wheels]
    return [
        repr(readings * _EVEN * float(of[wheel.name] * gain) ** 2)
        for wheel, gain in zip(wheels, gains, strict=True)
    ]


def turns_of(robot: Robot, without: frozenset[str]) -> tuple[str, ...]:
    """Return the names of the counted wheels' increments: ``w`` and their place."""
    return tuple(f"w{i}" for i, w in enumerate(robot.sensed) if w.name not in without)


def names(letter: str, count: int) -> tuple[str, ...]:
    """Return numbered names, such as s0 and s1."""
    return tuple(f"{letter}{i}" for i in range(count))
