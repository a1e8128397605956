"""``trundle odometry``: a log of wheel motion replayed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from trundle.cli import options
from trundle.cli.numbers import number
from trundle.cli.output import (
    figure,
    folder,
    heading,
    print_json,
    table,
    told_files,
)
from trundle.errors import TrundleError
from trundle.odometry import read_log, score
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run, replay


def odometry(
    robot: options.RobotName,
    log_file: Annotated[
        Path, typer.Argument(metavar="LOG.csv", help="A log, by default with a header row.")
    ],
    columns: Annotated[
        str | None,
        typer.Option(
            "--columns",
            metavar="NAME,NAME,...",
            help="Names of all columns of a file without a header; - skips one.",
        ),
    ] = None,
    rename: Annotated[
        list[str] | None,
        typer.Option("--map", metavar="NAME=COLUMN", help="The column of the file that NAME is."),
    ] = None,
    counter_bits: Annotated[
        int | None,
        typer.Option("--counter-bits", min=2, max=64, help="Width of counts that wrap around."),
    ] = None,
    pose: Annotated[
        tuple[str, str, str] | None,
        typer.Option("--pose", metavar="X Y PSI", help="Start pose; default: the truth's, or 0."),
    ] = None,
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Replay a log of wheel motion, and compare the path with the truth if it is there.

    A column's name tells what it holds: `time`; the truth `x`, `y`, `psi` or `psi_deg`;
    `steering:WHEEL` or `steering_deg:WHEEL`, the angle at the middle of the row's interval; and
    `READING:WHEEL` for each sensed wheel. READING is `counts` (a running tick counter), `ticks`
    (since the row before), `angle` [rad], `radians` or `turns` (since the row before), `speed`
    [rad/s] or `rpm`. Counts and ticks need the wheel's encoder in the robot file.

    Example: `trundle odometry my.toml log.csv --map ticks:left=enc_l --map ticks:right=enc_r`

    Example without a header: `trundle odometry my.toml run.csv --columns
    time,x,y,psi,ticks:right,ticks:left --out replay`
    """
    made = options.robot_of(robot, sizes)
    log = read_log(
        log_file,
        made,
        columns=None if columns is None else columns.split(","),
        rename=_renamed(rename),
        counter_bits=counter_bits,
    )
    target = folder(out_dir)
    start = np.zeros(3) if log.truth is None else log.truth[0]
    if pose is not None:
        start = np.array([number(value) for value in pose])
    run = replay(made, log, start)
    poses = run.pose
    error = None if log.truth is None else score(poses, log.truth)
    files = _leave(made, run, log.truth, target) if target else []
    if as_json:
        print_json(
            {
                "rows": len(poses),
                "pose": poses[-1],
                "error": None if error is None else vars(error),
                "files": files,
            }
        )
        return
    rows = [["start", *map(figure, poses[0])], ["end", *map(figure, poses[-1])]]
    if log.truth is not None:
        rows.append(["true end", *map(figure, log.truth[-1])])
    table(["", "x [m]", "y [m]", "psi [rad]"], rows)
    if error is not None:
        heading("Error against truth")
        told = [
            ["end", f"{error.end_error:.4g} m", f"{error.end_percent:.3g} % of the distance"],
            ["root mean square", f"{error.rms_error:.4g} m", ""],
            ["heading at the end", f"{math.degrees(error.end_heading_error):.4g} deg", ""],
            ["heading, root mean square", f"{math.degrees(error.rms_heading_error):.4g} deg", ""],
            ["distance", f"{error.distance:.4g} m", ""],
        ]
        table(["", "", ""], told, left=1)
    told_files(files)


def _renamed(items: list[str] | None) -> dict[str, str]:
    renamed = {}
    for item in items or []:
        name, equals, column = item.rpartition("=")
        if not equals or not name:
            raise TrundleError(f"--map needs NAME=COLUMN, such as ticks:left=enc_l, got {item!r}")
        renamed[name.strip()] = column.strip()
    return renamed


def _leave(robot: Robot, run: Run, truth: Array | None, target: Path) -> list[Path]:
    from trundle.view import plot_eta, plot_path, save

    return [
        run.save(target / "run.csv"),
        save(plot_eta(run), target / "eta.png"),
        save(plot_path(robot, run, truth), target / "path.png"),
    ]
