"""robotpy-wpimath run beside trundle on random motions of three drives.

wpimath counts rim speeds and wheel distances in metres, so all wheels here have radius 1: rad/s and
m/s agree. Frames agree: x forward, y left, counter-clockwise. Its odometry takes the heading from a
gyroscope, which is given the true heading.
"""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from trundle.robot import Robot

# There are no builds of it for some machines, as pyproject.toml tells.
pytest.importorskip(
    "wpimath.kinematics", reason="robotpy-wpimath is not installed", exc_type=ImportError
)

from wpimath.geometry import Pose2d, Rotation2d, Translation2d
from wpimath.kinematics import (
    ChassisSpeeds,
    DifferentialDriveKinematics,
    DifferentialDriveOdometry,
    DifferentialDriveWheelSpeeds,
    MecanumDriveKinematics,
    MecanumDriveOdometry,
    MecanumDriveWheelPositions,
    MecanumDriveWheelSpeeds,
    SwerveDrive4Kinematics,
    SwerveDrive4Odometry,
    SwerveModulePosition,
    SwerveModuleState,
)

Floats = NDArray[np.float64]

MOTIONS = 200
RNG_SEED = 20_240_917
# Both sides compute in doubles on numbers below 10: a thousand roundings of 1e-15 at most.
ROUNDING = 1e-11
# wpimath's arcs switch to a Taylor series below 1e-9 rad, and errors add up over the steps.
ODOMETRY_ROUNDING = 1e-9

HALF_TRACK = 0.31
CORNERS = ((0.27, 0.22), (0.29, -0.24), (-0.25, 0.21), (-0.28, -0.23))  # FL, FR, RL, RR, uneven
ROLLERS = (-45.0, 45.0, 45.0, -45.0)
NAMES = ("front_left", "front_right", "rear_left", "rear_right")
START = (0.4, -0.7, 0.9)


def robot(kind: str, places: Sequence[tuple[float, float]], **extra: Sequence[float]) -> Robot:
    """Return a robot of wheels of one kind with radius 1 at places."""
    wheels = [
        {"name": name, "kind": kind, "x": x, "y": y, "radius": 1.0}
        | {key: values[i] for key, values in extra.items()}
        for i, (name, (x, y)) in enumerate(zip(NAMES, places, strict=False))
    ]
    return trundle.robot_from_dict({"name": f"beside_wpimath_{kind}", "wheel": wheels})


DIFFERENTIAL = robot("fixed", ((0.0, HALF_TRACK), (0.0, -HALF_TRACK)))
MECANUM = robot("mecanum", CORNERS, roller_deg=ROLLERS)
SWERVE = robot("steered", CORNERS)


def wpimath_differential() -> DifferentialDriveKinematics:
    return DifferentialDriveKinematics(2 * HALF_TRACK)


def wpimath_mecanum() -> MecanumDriveKinematics:
    return MecanumDriveKinematics(*(Translation2d(x, y) for x, y in CORNERS))


def wpimath_swerve() -> SwerveDrive4Kinematics:
    return SwerveDrive4Kinematics(*(Translation2d(x, y) for x, y in CORNERS))


def twists(free: Sequence[float] = (1.0, 1.0, 1.0)) -> Floats:
    """Return random twists (MOTIONS, 3) up to 3 m/s and 3 rad/s; zero in `free` rules one out."""
    return np.random.default_rng(RNG_SEED).uniform(-3.0, 3.0, (MOTIONS, 3)) * free


def points() -> Floats:
    """Return random body points (MOTIONS, 2) to turn about [m]."""
    return np.random.default_rng(RNG_SEED + 1).uniform(-1.0, 1.0, (MOTIONS, 2))


def rims(speeds: MecanumDriveWheelSpeeds) -> list[float]:
    return [speeds.frontLeft, speeds.frontRight, speeds.rearLeft, speeds.rearRight]


def as_twist(speeds: ChassisSpeeds) -> list[float]:
    return [speeds.vx, speeds.vy, speeds.omega]


def module_velocities(wheel_speeds: Floats, steering: Floats) -> Floats:
    """Return the velocity vectors (..., 4, 2) of swerve modules."""
    return np.stack([wheel_speeds * np.cos(steering), wheel_speeds * np.sin(steering)], axis=-1)


def half_turns_apart(angle: Floats) -> Floats:
    """Return how far angles are from the nearest multiple of half a turn."""
    return np.abs(np.angle(np.exp(2j * angle))) / 2.0


def test_differential_inverse() -> None:
    theirs = wpimath_differential()
    asked = twists(free=(1.0, 0.0, 1.0))
    wanted = []
    for u, v, r in asked.tolist():
        speeds = theirs.toWheelSpeeds(ChassisSpeeds(u, v, r))
        wanted.append([speeds.left, speeds.right])
    ours = trundle.Kinematics(DIFFERENTIAL).inverse(asked).wheel_speeds
    np.testing.assert_allclose(ours, wanted, rtol=0, atol=ROUNDING)


def test_differential_forward() -> None:
    theirs = wpimath_differential()
    speeds = twists()[:, :2]
    wanted = [
        as_twist(theirs.toChassisSpeeds(DifferentialDriveWheelSpeeds(*pair)))
        for pair in speeds.tolist()
    ]
    ours = trundle.Kinematics(DIFFERENTIAL).forward(speeds)
    np.testing.assert_allclose(ours, wanted, rtol=0, atol=ROUNDING)


def test_mecanum_inverse() -> None:
    theirs = wpimath_mecanum()
    asked = twists()
    wanted = [rims(theirs.toWheelSpeeds(ChassisSpeeds(*twist))) for twist in asked.tolist()]
    ours = trundle.Kinematics(MECANUM).inverse(asked).wheel_speeds
    np.testing.assert_allclose(ours, wanted, rtol=0, atol=ROUNDING)


def test_mecanum_inverse_about_a_point() -> None:
    theirs = wpimath_mecanum()
    kin = trundle.Kinematics(MECANUM)
    for twist, (x, y) in zip(twists().tolist(), points().tolist(), strict=True):
        wanted = rims(theirs.toWheelSpeeds(ChassisSpeeds(*twist), Translation2d(x, y)))
        ours = kin.inverse(twist, about=(x, y)).wheel_speeds
        np.testing.assert_allclose(ours, wanted, rtol=0, atol=ROUNDING)


def test_mecanum_forward() -> None:
    """Four free wheel speeds contradict each other: both sides take the least squares of rims."""
    theirs = wpimath_mecanum()
    speeds = np.random.default_rng(RNG_SEED + 2).uniform(-3.0, 3.0, (MOTIONS, 4))
    wanted = [
        as_twist(theirs.toChassisSpeeds(MecanumDriveWheelSpeeds(*four))) for four in speeds.tolist()
    ]
    ours = trundle.Kinematics(MECANUM).forward(speeds)
    np.testing.assert_allclose(ours, wanted, rtol=0, atol=ROUNDING)


def test_swerve_inverse() -> None:
    theirs = wpimath_swerve()
    asked = twists()
    wanted_speeds, wanted_angles = [], []
    for twist in asked.tolist():
        states = theirs.toSwerveModuleStates(ChassisSpeeds(*twist))
        wanted_speeds.append([state.speed for state in states])
        wanted_angles.append([state.angle.radians() for state in states])
    ours = trundle.Kinematics(SWERVE).inverse(asked)
    np.testing.assert_allclose(
        module_velocities(ours.wheel_speeds, ours.steering),
        module_velocities(np.array(wanted_speeds), np.array(wanted_angles)),
        rtol=0,
        atol=ROUNDING,
    )
    apart = half_turns_apart(ours.steering - np.array(wanted_angles))
    assert (apart * np.abs(wanted_speeds)).max() < ROUNDING


def test_swerve_inverse_about_a_point() -> None:
    theirs = wpimath_swerve()
    kin = trundle.Kinematics(SWERVE)
    for twist, (x, y) in zip(twists().tolist(), points().tolist(), strict=True):
        states = theirs.toSwerveModuleStates(ChassisSpeeds(*twist), Translation2d(x, y))
        wanted = [[s.speed * s.angle.cos(), s.speed * s.angle.sin()] for s in states]
        ours = kin.inverse(twist, about=(x, y))
        np.testing.assert_allclose(
            module_velocities(ours.wheel_speeds, ours.steering), wanted, rtol=0, atol=ROUNDING
        )


def test_swerve_forward() -> None:
    """Free speeds and angles contradict each other: both sides take the same least squares."""
    theirs = wpimath_swerve()
    random = np.random.default_rng(RNG_SEED + 3)
    speeds = random.uniform(-3.0, 3.0, (MOTIONS, 4))
    angles = random.uniform(-math.pi, math.pi, (MOTIONS, 4))
    wanted = []
    for four, turned in zip(speeds.tolist(), angles.tolist(), strict=True):
        states = tuple(
            SwerveModuleState(speed, Rotation2d(angle))
            for speed, angle in zip(four, turned, strict=True)
        )
        wanted.append(as_twist(theirs.toChassisSpeeds(states)))
    ours = trundle.Kinematics(SWERVE).forward(speeds, angles)
    np.testing.assert_allclose(ours, wanted, rtol=0, atol=ROUNDING)


def path(free: Sequence[float] = (1.0, 1.0, 1.0)) -> tuple[Floats, Floats]:
    """Return small steps of motion (MOTIONS, 3) and the headings after each (MOTIONS,)."""
    steps = 0.05 * twists(free)
    return steps, START[2] + np.cumsum(steps[:, 2])


def as_pose(pose: Pose2d) -> list[float]:
    return [pose.X(), pose.Y(), pose.rotation().radians()]


def assert_same_poses(ours: Floats, theirs: Sequence[Sequence[float]]) -> None:
    difference = ours - np.array(theirs)
    difference[:, 2] = np.angle(np.exp(1j * difference[:, 2]))
    assert np.abs(difference).max() < ODOMETRY_ROUNDING


def start() -> tuple[Rotation2d, Pose2d]:
    return Rotation2d(START[2]), Pose2d(START[0], START[1], Rotation2d(START[2]))


def test_differential_odometry() -> None:
    steps, headings = path(free=(1.0, 0.0, 1.0))
    turns = trundle.Kinematics(DIFFERENTIAL).inverse(steps).wheel_speeds
    gyro, pose = start()
    theirs = DifferentialDriveOdometry(gyro, 0.0, 0.0, pose)
    wanted = [list(START)]
    for heading, (left, right) in zip(headings, np.cumsum(turns, axis=0).tolist(), strict=True):
        wanted.append(as_pose(theirs.update(Rotation2d(heading), left, right)))
    assert_same_poses(trundle.dead_reckon(DIFFERENTIAL, turns, pose=START), wanted)


def mecanum_positions(rolled: Sequence[float]) -> MecanumDriveWheelPositions:
    at = MecanumDriveWheelPositions()
    at.frontLeft, at.frontRight, at.rearLeft, at.rearRight = rolled
    return at


def test_mecanum_odometry() -> None:
    steps, headings = path()
    turns = trundle.Kinematics(MECANUM).inverse(steps).wheel_speeds
    gyro, pose = start()
    theirs = MecanumDriveOdometry(wpimath_mecanum(), gyro, mecanum_positions([0.0] * 4), pose)
    wanted = [list(START)]
    for heading, rolled in zip(headings, np.cumsum(turns, axis=0).tolist(), strict=True):
        wanted.append(as_pose(theirs.update(Rotation2d(heading), mecanum_positions(rolled))))
    assert_same_poses(trundle.dead_reckon(MECANUM, turns, pose=START), wanted)


def swerve_positions(
    rolled: Sequence[float], steering: Sequence[float]
) -> tuple[SwerveModulePosition, ...]:
    return tuple(
        SwerveModulePosition(distance, Rotation2d(angle))
        for distance, angle in zip(rolled, steering, strict=True)
    )


def test_swerve_odometry() -> None:
    """wpimath takes a step's angles from the newer reading, as trundle takes them from the row."""
    steps, headings = path()
    moved = trundle.Kinematics(SWERVE).inverse(steps)
    rolled = np.cumsum(moved.wheel_speeds, axis=0)
    gyro, pose = start()
    at_rest = swerve_positions([0.0] * 4, [0.0] * 4)
    theirs = SwerveDrive4Odometry(wpimath_swerve(), gyro, at_rest, pose)
    wanted = [list(START)]
    for heading, distance, angle in zip(
        headings, rolled.tolist(), moved.steering.tolist(), strict=True
    ):
        wanted.append(
            as_pose(theirs.update(Rotation2d(heading), swerve_positions(distance, angle)))
        )
    ours = trundle.dead_reckon(SWERVE, moved.wheel_speeds, steering=moved.steering, pose=START)
    assert_same_poses(ours, wanted)
