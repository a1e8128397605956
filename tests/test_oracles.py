"""Published numbers of other projects, books and courses: see oracles/README.md."""

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from trundle.robot import Robot

Floats = NDArray[np.float64]
Case = Mapping[str, Any]

ORACLES: dict[str, Any] = tomllib.loads(
    (Path(__file__).parent / "oracles" / "vectors.toml").read_text(encoding="utf-8")
)
CASES: list[Case] = ORACLES["case"]
SOURCES = {source["id"] for source in ORACLES["source"]}
LEAST_VECTORS, LEAST_SOURCES = 60, 3  # what the project promises


def case_id(case: Case) -> str:
    return f"{case['source']}:{case['name']}"


def robot_of(case: Case) -> Robot:
    return trundle.robot_from_dict(ORACLES["robot"][case["robot"]])


def wheels_of(case: Case) -> Sequence[Mapping[str, Any]]:
    wheels: Sequence[Mapping[str, Any]] = ORACLES["robot"][case["robot"]]["wheel"]
    return wheels


def rotation(heading: float) -> Floats:
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def wheel_motion(
    case: Case, wheel_speeds: Sequence[float], steering: Sequence[float]
) -> tuple[Floats, Floats]:
    """Return what a half turn of a steered wheel with its speed's sign cannot change.

    First the spins as vectors along x and y of the wheel, then twice the angles of steered wheels
    without a motor. A source that prints no wheel speeds gives an empty first part.
    """
    speeds, angles = iter(wheel_speeds), iter(steering)
    spins: list[float] = []
    loose: list[float] = []
    for wheel in wheels_of(case):
        angle = next(angles) if wheel["kind"] == "steered" else 0.0
        if not wheel.get("driven", True):
            loose.append(2.0 * angle)
        elif wheel_speeds:
            speed = next(speeds)
            spins += [speed * math.cos(angle), speed * math.sin(angle)]
    return np.array(spins), np.array(loose)


def wrapped(angle: Floats) -> Floats:
    """Return angles in (-pi, pi]."""
    return np.angle(np.exp(1j * angle))


def inverse_error(case: Case) -> float:
    given = trundle.Kinematics(robot_of(case)).inverse(
        np.array(case["twist"]), about=tuple(case.get("about", (0.0, 0.0)))
    )
    wanted = case.get("wheel_speeds", [])
    turned = case.get("steering", [])
    speeds = list(given.wheel_speeds) if wanted else []
    assert len(speeds) == len(wanted)
    assert len(given.steering) == len(turned)
    got_spins, got_loose = wheel_motion(case, speeds, list(given.steering))
    spins, loose = wheel_motion(case, wanted, turned)
    halves = wrapped(got_loose - loose) / 2.0
    return float(np.abs(np.concatenate([got_spins - spins, halves])).max())


def forward_error(case: Case) -> float:
    kin = trundle.Kinematics(robot_of(case))
    steering = np.array(case["steering"]) if "steering" in case else None
    twist = kin.forward(np.array(case["wheel_speeds"]), steering)
    turned = rotation(case.get("heading", 0.0)) @ twist
    return float(np.abs(turned - case["twist"]).max())


def matrix_error(case: Case) -> float:
    kin = trundle.Kinematics(robot_of(case))
    if "forward" in case:
        turned = rotation(case.get("heading", 0.0)) @ kin.W
        return float(np.abs(turned - np.array(case["forward"])).max())
    columns = [kin.inverse(unit).wheel_speeds for unit in np.eye(3)]
    return float(np.abs(np.stack(columns, axis=-1) - np.array(case["inverse"])).max())


def icr_error(case: Case) -> float:
    matrix = trundle.Kinematics(robot_of(case)).wheel_matrix(np.array(case["steering"]))
    u, v, r = matrix @ np.ones(matrix.shape[1])
    return float(np.abs(np.array([-v / r, u / r]) - case["icr"]).max())


def odometry_error(case: Case) -> float:
    increments = np.array(case["wheel_increments"])
    poses = trundle.dead_reckon(
        robot_of(case),
        increments,
        steering=np.array(case["steering"]) if "steering" in case else None,
        pose=tuple(case["pose"]),
    )
    assert poses.shape == (len(increments) + 1, 3)
    assert poses[0] == pytest.approx(case["pose"], abs=0.0)
    error = poses[-1] - np.array(case["expected_pose"])
    error[2] = wrapped(error[2:])[0]
    return float(np.abs(error).max())


ERRORS: Mapping[str, Callable[[Case], float]] = {
    "inverse": inverse_error,
    "forward": forward_error,
    "matrix": matrix_error,
    "icr": icr_error,
    "odometry": odometry_error,
}


@pytest.mark.parametrize("case", CASES, ids=case_id)
def test_published_number(case: Case) -> None:
    assert ERRORS[case["what"]](case) <= case["tolerance"]


def test_there_are_enough_vectors_from_enough_sources() -> None:
    printed = [case for case in CASES if case["origin"] == "printed"]
    assert len(printed) >= LEAST_VECTORS
    assert len({case["source"] for case in printed}) >= LEAST_SOURCES


def test_every_vector_is_told_apart_and_has_its_source() -> None:
    assert len({case_id(case) for case in CASES}) == len(CASES)
    assert {case["source"] for case in CASES} == SOURCES
    assert {case["robot"] for case in CASES} == set(ORACLES["robot"])
    assert {case["origin"] for case in CASES} <= {"printed", "formula"}


@pytest.mark.parametrize("source", ORACLES["source"], ids=lambda source: source["id"])
def test_a_source_says_where_and_how(source: Mapping[str, str]) -> None:
    assert all(source[key].strip() for key in ("title", "where", "note"))
