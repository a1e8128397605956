"""``trundle show`` and ``trundle check``: what follows from a robot's wheels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.text import Text

from trundle.cli import options
from trundle.cli.output import (
    figure,
    folder,
    heading,
    matrix,
    out,
    print_json,
    sentence,
    table,
    told_files,
)
from trundle.kinematics import (
    Explanation,
    Finding,
    Kinematics,
    Mobility,
    compare_matrix,
    consistent_angles,
    diagnose,
    explain,
    mobility,
    read_matrix,
)
from trundle.odometry import write_columns
from trundle.robot import Robot, RollingWheel, Wheel
from trundle.se2 import Array, wrap

Explain = Annotated[
    bool, typer.Option("--explain", help="Say every row of W and of the constraints in words.")
]
MatrixFile = Annotated[
    Path, typer.Argument(metavar="MATRIX.csv", help="The matrix, one row a line.")
]


def show(
    robot: options.RobotName,
    steering_deg: options.SteeringDeg = None,
    explained: Explain = False,
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Show a robot: wheels, W, what it can and cannot do and why, and warnings.

    Example: `trundle show ackermann --steering-deg 18.4 15.6 --explain --out pictures`
    """
    made = options.robot_of(robot, sizes)
    given = options.steering_of(made, steering_deg)
    target = folder(out_dir)
    angles = consistent_angles(made) if given is None else given
    can = mobility(made)
    warnings = diagnose(made, given)
    lost = any(each.code == "off_centre_angles" for each in warnings)
    W = None if lost or angles is None else Kinematics(made).wheel_matrix(angles)
    told = explain(made, angles) if explained and W is not None else None
    files = _pictures(made, angles, given, target) if target else []
    if as_json:
        print_json(_show_json(made, angles, W, can, warnings, told, files))
        return
    _show_wheels(made)
    _show_matrix(made, angles, W)
    _show_mobility(can)
    for title, texts in told.sections if told else ():
        heading(title)
        for text in texts:
            sentence(text)
    _show_warnings(warnings)
    told_files(files)


def _show_json(
    robot: Robot,
    angles: Array | None,
    W: Array | None,
    can: Mobility,
    warnings: tuple[Finding, ...],
    told: Explanation | None,
    files: list[Path],
) -> dict[str, Any]:
    return {
        "name": robot.name,
        "wheels": [
            {"name": w.name, "kind": w.kind, "x": w.x, "y": w.y, "driven": w.driven}
            for w in robot.wheels
        ],
        "driven": [wheel.name for wheel in robot.driven],
        "steered": [wheel.name for wheel in robot.steered],
        "sensed": [wheel.name for wheel in robot.sensed],
        "steering": angles,
        "wheel_matrix": W,
        "rank": can.rank,
        "mobility": {
            "degree": can.degree,
            "steerability": can.steerability,
            "maneuverability": can.maneuverability,
            "class": can.kind,
        },
        "omnidirectional": can.omnidirectional,
        "holonomic": can.holonomic,
        "controllable": can.controllable,
        "motions": can.motions,
        "undriven": can.undriven,
        "reasons": can.reasons,
        "warnings": [
            {"code": w.code, "message": w.message, "remedy": w.remedy, "wheels": w.wheels}
            for w in warnings
        ],
        "explanation": list(told or ()),
        "files": files,
    }


def _show_wheels(robot: Robot) -> None:
    heading(robot.name)
    rows = []
    for wheel in robot.wheels:
        rolling = isinstance(wheel, RollingWheel)
        notes = [
            "driven" * wheel.driven,
            "reversed" * (rolling and getattr(wheel, "reversed", False)),
            "skids" * bool(getattr(wheel, "skid", False)),
            "dead wheel" * (wheel.sensed and not wheel.driven),
        ]
        rows.append(
            [
                wheel.name,
                wheel.kind,
                ", ".join(note for note in notes if note),
                figure(wheel.x),
                figure(wheel.y),
                _if_there(getattr(wheel, "radius", None)),
                _if_there(_direction(wheel), math.degrees(1)),
                _if_there(getattr(wheel, "roller", None), math.degrees(1)),
            ]
        )
    columns = ["wheel", "kind", "", "x [m]", "y [m]", "radius", "heading [deg]", "roller"]
    table(columns, rows, left=3)


def _direction(wheel: Wheel) -> float | None:
    heading = getattr(wheel, "heading", None)
    return None if heading is None else float(wrap(heading))


def _if_there(value: float | None, scale: float = 1.0) -> str:
    return "" if value is None else figure(scale * value)


def _show_matrix(robot: Robot, angles: Array | None, W: Array | None) -> None:
    if W is None:
        heading("W: none, the wheels share no instantaneous centre")
        return
    at = ""
    if robot.steered and angles is not None:
        at = f" at steering {', '.join(f'{a:.4g}' for a in np.degrees(angles))} deg"
    heading(f"W{at}:  (u, v, r) = W · wheel speeds [rad/s]")
    matrix(W, [wheel.name for wheel in robot.driven])


def _show_mobility(can: Mobility) -> None:
    heading("What it can do")
    answer = {True: "yes", False: "no"}
    rows = [
        ["class", can.kind],
        ["rank of W", str(can.rank)],
        ["omnidirectional", answer[can.omnidirectional]],
        ["holonomic (Lie brackets)", answer[can.holonomic]],
        ["reaches every pose", answer[can.controllable]],
        ["allowed motions", "; ".join(can.motions) or "none"],
    ]
    if can.undriven:
        rows.append(["not driven", "; ".join(can.undriven)])
    table(["", ""], rows, left=2)
    for reason in can.reasons:
        sentence(reason)


def _show_warnings(warnings: tuple[Finding, ...]) -> None:
    if not warnings:
        return
    heading("Warnings")
    for each in warnings:
        sentence((each.code, "yellow"), f"  {each.message}.")
        sentence(("Remedy", "dim"), f"  {each.remedy}.")


def _pictures(robot: Robot, angles: Array | None, given: Array | None, target: Path) -> list[Path]:
    from trundle.view import plot_layout, plot_reachable, save

    steering = angles if robot.steered else None
    return [
        save(plot_layout(robot, steering), target / "layout.png"),
        save(plot_reachable(robot, given), target / "reachable.png"),
    ]


def check(
    robot: options.RobotName,
    matrix_file: MatrixFile,
    steering_deg: options.SteeringDeg = None,
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Compare a matrix from elsewhere with this robot's, and name the difference in words.

    Forward (3 rows) or inverse (3 columns), in rad/s or rim speeds, the wheels in any order.

    Example: `trundle check omni4 slides.csv`
    """
    made = options.robot_of(robot, sizes)
    angles = options.steering_of(made, steering_deg)
    if angles is None and made.steered:
        angles = consistent_angles(made)
    pasted = read_matrix(matrix_file)
    target = folder(out_dir)
    found = compare_matrix(made, pasted, angles)
    files = []
    if target:
        columns = {f"column_{j + 1}": column for j, column in enumerate(found.ours.T)}
        files.append(write_columns(target / "ours.csv", columns))
    if as_json:
        print_json(
            {
                "agrees": found.agrees,
                "form": found.form,
                "quantity": found.quantity,
                "order": found.order,
                "findings": [{"code": f.code, "message": f.message} for f in found.findings],
                "largest_difference": found.largest_difference,
                "ours": found.ours,
                "files": files,
            }
        )
        return
    verdict = ("agrees", "bold green") if found.agrees else ("differs", "bold red")
    out.print(
        Text.assemble(
            f"{matrix_file} read as the {found.form} matrix of {made.name}, {found.quantity}: ",
            verdict,
        )
    )
    for each in found.findings:
        sentence((each.code, "yellow"), f"  {each.message}")
    heading(f"trundle's {found.form} matrix in that form, wheels {', '.join(found.order)}")
    table([""] * found.ours.shape[1], [[figure(v) for v in row] for row in found.ours], left=0)
    told_files(files)
