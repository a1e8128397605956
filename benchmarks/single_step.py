"""One step in a control loop: trundle's plain functions beside robotpy-wpimath.

wpimath is timed twice: as a bare bound method with arguments built beforehand, and as a control
loop uses it, which has floats and wants floats. trundle's plain functions take and return floats.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from _common import Job, Results, machine, measure, publish, read_options, serve, table, verdict

import trundle

RADIUS, WHEELBASE, TRACK = 0.05, 0.4, 0.3  # [m]
CORNERS = [(x, y) for x in (WHEELBASE / 2, -WHEELBASE / 2) for y in (TRACK / 2, -TRACK / 2)]
TWIST = (0.7, -0.3, 0.9)  # (u, v, r) [m/s, m/s, rad/s]
TURNS = (0.20, 0.24, 0.22, 0.28)  # wheel increments of one step [rad]
START = (0.1, 0.2, 0.3)  # (x, y, psi) [m, m, rad]
# The gyroscope's turn that agrees with these increments: the yaw row of a mecanum robot.
YAW = RADIUS / (2 * (WHEELBASE + TRACK)) * (-TURNS[0] + TURNS[1] - TURNS[2] + TURNS[3])

# Both sides compute in doubles on numbers of size 1.
ROUNDING = 1e-12
REQUIRED = {"mecanum inverse": 0.4, "swerve inverse": 0.5, "mecanum odometry": 0.55}


def kinematics(name: str) -> trundle.Kinematics:
    sizes = {"radius": RADIUS, "wheelbase": WHEELBASE, "track": TRACK}
    return trundle.Kinematics(trundle.load(name, **sizes))


def floats(names: str, values: tuple[float, ...]) -> dict[str, object]:
    return dict(zip(names.split(), values, strict=True))


# ---- trundle and numpy -----------------------------------------------------------------------


def plain_inverse(robot: str) -> Job:
    inverse = kinematics(robot).bind().inverse
    names = {"inverse": inverse, **floats("u v r", TWIST)}
    return Job("inverse(u, v, r)", names, inverse(*TWIST))


def array_inverse(robot: str, count: int = 1) -> Job:
    inverse, twist = kinematics(robot).inverse, np.tile(TWIST, (count, 1))
    found = inverse(twist)
    return Job(
        "inverse(twist)",
        {"inverse": inverse, "twist": twist if count > 1 else twist[0]},
        [*found.wheel_speeds[0], *found.steering[0]],
        count,
    )


def numpy_mecanum_inverse() -> Job:
    arm = (WHEELBASE + TRACK) / 2
    J = np.array([[1, -1, -arm], [1, 1, arm], [1, 1, -arm], [1, -1, arm]]) / RADIUS
    return Job("J @ twist", {"J": J, "twist": np.array(TWIST)}, J @ TWIST)


def numpy_swerve_inverse() -> Job:
    J = np.array([[1, 0, -y] for _, y in CORNERS] + [[0, 1, x] for x, _ in CORNERS])
    names = {"J": J, "twist": np.array(TWIST), "hypot": np.hypot, "arctan2": np.arctan2}
    a, b = np.split(J @ TWIST, 2)
    return Job(
        f"m = J @ twist; hypot(m[:4], m[4:]) / {RADIUS}; arctan2(m[4:], m[:4])",
        names,
        [*np.hypot(a, b) / RADIUS, *np.arctan2(b, a)],
    )


def plain_step() -> Job:
    step = kinematics("mecanum").bind().step
    names = {"step": step, **floats("x y psi", START), **floats("a b c d", TURNS)}
    return Job("x, y, psi = step(x, y, psi, a, b, c, d)", names, step(*START, *TURNS))


# ---- wpimath: rim speeds [m/s] and distances [m], so that radii are divided out ----------------


def corners() -> list[Any]:
    from wpimath.geometry import Translation2d

    return [Translation2d(x, y) for x, y in CORNERS]


def wpimath_mecanum_inverse(bare: bool) -> Job:
    from wpimath.kinematics import ChassisSpeeds, MecanumDriveKinematics

    method = MecanumDriveKinematics(*corners()).toWheelSpeeds
    s = method(ChassisSpeeds(*TWIST))
    answer = [rim / RADIUS for rim in (s.frontLeft, s.frontRight, s.rearLeft, s.rearRight)]
    if bare:
        names = {"to_wheel_speeds": method, "speeds": ChassisSpeeds(*TWIST)}
        return Job("to_wheel_speeds(speeds)", names, answer)
    names = {"to_wheel_speeds": method, "ChassisSpeeds": ChassisSpeeds, **floats("u v r", TWIST)}
    statement = (
        "s = to_wheel_speeds(ChassisSpeeds(u, v, r)); "
        "s.frontLeft, s.frontRight, s.rearLeft, s.rearRight"
    )
    return Job(statement, names, answer)


def wpimath_swerve_inverse(bare: bool) -> Job:
    from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics

    method = SwerveDrive4Kinematics(*corners()).toSwerveModuleStates
    states = method(ChassisSpeeds(*TWIST))
    answer = [s.speed / RADIUS for s in states] + [s.angle.radians() for s in states]
    if bare:
        names = {"to_states": method, "speeds": ChassisSpeeds(*TWIST)}
        return Job("to_states(speeds)", names, answer)
    names = {"to_states": method, "ChassisSpeeds": ChassisSpeeds, **floats("u v r", TWIST)}
    statement = "[(s.speed, s.angle.radians()) for s in to_states(ChassisSpeeds(u, v, r))]"
    return Job(statement, names, answer)


def wpimath_odometry(form: str) -> Job:
    from wpimath.geometry import Pose2d, Rotation2d
    from wpimath.kinematics import (
        MecanumDriveKinematics,
        MecanumDriveOdometry,
        MecanumDriveWheelPositions,
    )

    def positions(turns: tuple[float, ...]) -> Any:
        at = MecanumDriveWheelPositions()
        at.frontLeft, at.frontRight, at.rearLeft, at.rearRight = (RADIUS * t for t in turns)
        return at

    here, there = Rotation2d(START[2]), Rotation2d(START[2] + YAW)
    rest, moved = positions((0.0,) * 4), positions(TURNS)
    pose = Pose2d(START[0], START[1], here)
    update = MecanumDriveOdometry(MecanumDriveKinematics(*corners()), here, rest, pose).update
    after = update(there, moved)
    answer = [after.X(), after.Y(), after.rotation().radians()]
    if form == "standing":
        names = {"update": update, "rotation": there, "positions": moved}
        return Job("update(rotation, positions)", names, answer)
    if form == "moving":
        names = {"update": update, "r1": here, "p1": rest, "r2": there, "p2": moved}
        return Job("update(r1, p1); update(r2, p2)", names, answer, count=2)
    statement = (
        "psi += dpsi; a += da; b += db; c += dc; d += dd; w = Positions(); "
        "w.frontLeft = a; w.frontRight = b; w.rearLeft = c; w.rearRight = d; "
        "p = update(Rotation2d(psi), w); p.X(), p.Y(), p.rotation().radians()"
    )
    state = floats("psi a b c d", (START[2] + YAW, *(RADIUS * turn for turn in TURNS)))
    change = floats("dpsi da db dc dd", (YAW, *(RADIUS * turn for turn in TURNS)))
    classes = {"Positions": MecanumDriveWheelPositions, "Rotation2d": Rotation2d}
    return Job(statement, {"update": update, **state, **change, **classes}, answer)


# ---- the comparison --------------------------------------------------------------------------

PLAIN, NUMPY = "trundle, plain floats", "numpy, by hand"
ARRAY, BATCH = "trundle, checked arrays", "trundle, 1000 in one array"
BARE, USED, MOVING = "wpimath, bare", "wpimath, floats to floats", "wpimath, bare, moving"

TASKS: dict[str, dict[str, Callable[[], Job]]] = {
    "mecanum inverse": {
        PLAIN: partial(plain_inverse, "mecanum"),
        ARRAY: partial(array_inverse, "mecanum"),
        BATCH: partial(array_inverse, "mecanum", 1000),
        NUMPY: numpy_mecanum_inverse,
        BARE: partial(wpimath_mecanum_inverse, True),
        USED: partial(wpimath_mecanum_inverse, False),
    },
    "swerve inverse": {
        PLAIN: partial(plain_inverse, "swerve"),
        ARRAY: partial(array_inverse, "swerve"),
        BATCH: partial(array_inverse, "swerve", 1000),
        NUMPY: numpy_swerve_inverse,
        BARE: partial(wpimath_swerve_inverse, True),
        USED: partial(wpimath_swerve_inverse, False),
    },
    "mecanum odometry": {
        PLAIN: plain_step,
        BARE: partial(wpimath_odometry, "standing"),
        MOVING: partial(wpimath_odometry, "moving"),
        USED: partial(wpimath_odometry, "used"),
    },
}
NOTES = f"""\
Four wheels at (±{WHEELBASE / 2:g}, ±{TRACK / 2:g}) m with a radius of {RADIUS:g} m. Ratios are
medians over rounds in which every candidate, in a process of its own, takes its turn; in
parentheses their quartiles. "Bare" is the bound method alone with arguments built beforehand,
"floats to floats" with what a control loop adds. The odometry step is the forward kinematics
and the exact arc; in the bare call wpimath gets the same reading again and again, its cheapest
case, and with "moving" a new one each time. wpimath's heading comes from a gyroscope, trundle's
from the wheels."""


def rows(task: str, candidates: list[str], results: Results) -> list[list[str]]:
    out = []
    for name in candidates:
        key = f"{task}: {name}"
        row = [f"{name}", f"{1e9 * results.median(key):.0f}", "", ""]
        if (bare := f"{task}: {BARE}") in results.times:
            row[2] = "1" if key == bare else results.ratio_text(key, bare)
            if name == PLAIN:
                row[3] = verdict(results.ratio(key, bare)[0], REQUIRED[task])
        out.append(row)
    return out


def main() -> None:
    jobs = {f"{task}: {name}": job for task, all_ in TASKS.items() for name, job in all_.items()}
    options = read_options(__doc__, processes=3, rounds=25, seconds=0.01)
    if options.candidate:
        serve(jobs[options.candidate]())
        return
    packages = ["numpy"]
    if find_spec("wpimath"):
        packages.append("robotpy-wpimath")
    else:
        print("robotpy-wpimath is not installed: trundle and numpy alone.\n")
        jobs = {name: job for name, job in jobs.items() if "wpimath" not in name}
    results = measure(jobs, options)
    parts = [f"## One step from Python\n\n{machine(*packages)}.\n{NOTES}"]
    for task, all_ in TASKS.items():
        here = [name for name in all_ if f"{task}: {name}" in jobs]
        results.assert_agreement([f"{task}: {name}" for name in here], ROUNDING)
        header = [task, "ns per call", "ratio to the bare call", "required"]
        parts.append(table(header, rows(task, here, results)))
    publish("single_step", "\n\n".join(parts), options)


if __name__ == "__main__":
    main()
