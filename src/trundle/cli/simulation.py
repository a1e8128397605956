"""``trundle simulate``: a robot driven by known commands."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.text import Text

from trundle.cli import options
from trundle.cli.maps import why_missing
from trundle.cli.numbers import number
from trundle.cli.output import (
    figure,
    folder,
    out,
    print_json,
    progress,
    sentence,
    table,
    told_files,
)
from trundle.errors import FileError, TrundleError
from trundle.kinematics import Kinematics
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Run, write_log
from trundle.simulation import simulate as run_simulation

# Rims that slip less than this [m/s] fit together but for the digits that were typed.
_SLIP = 1e-6


def simulate(
    robot: options.RobotName,
    twist_given: options.GivenTwist = None,
    wheel_speeds: options.GivenSpeeds = None,
    commands: options.GivenFile = None,
    steering_deg: options.SteeringDeg = None,
    duration: options.Duration = None,
    dt: options.Step = 0.05,
    pose: Annotated[
        tuple[str, str, str],
        typer.Option("--pose", metavar="X Y PSI", help="Start pose [m, m, rad]."),
    ] = ("0", "0", "0"),
    method: Annotated[
        str, typer.Option("--method", help="exact, euler (the lectures' loop) or rk4.")
    ] = "exact",
    animation: Annotated[
        str, typer.Option("--animation", help="gif, mp4 (needs ffmpeg) or none.")
    ] = "gif",
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Drive a robot with known commands; --out leaves the run, a log and pictures.

    Example: `trundle simulate omni3 --wheel-speeds 0 -0.5 0.5 --pose 0.5 0.5 0.785 --out run`
    """
    made = options.robot_of(robot, sizes)
    if animation not in ("gif", "mp4", "none"):
        raise TrundleError(f"--animation takes gif, mp4 or none, got {animation!r}")
    chosen = commands_of(made, twist_given, wheel_speeds, commands, steering_deg)
    if duration is None and commands is None:
        duration = 10.0
    target = folder(out_dir)
    start = [number(value) for value in pose]
    run = run_simulation(made, **chosen, duration=duration, dt=dt, pose=start, method=method)
    files = _leave(made, run, target, animation, as_json) if target else []
    moved = np.diff(run.pose[:, :2], axis=0)
    length = float(np.hypot(moved[:, 0], moved[:, 1]).sum())
    notes = notes_of(made, chosen, run)
    if as_json:
        print_json(
            {
                "notes": notes,
                "duration": run.t[-1],
                "steps": len(run.t) - 1,
                "pose": run.pose[-1],
                "distance": length,
                "files": files,
            }
        )
        return
    end = run.pose[-1]
    rows = [
        ["start", *(figure(value) for value in run.pose[0])],
        ["end", *(figure(value) for value in end)],
    ]
    table(["", "x [m]", "y [m]", "psi [rad]"], rows)
    out.print(
        Text(
            f"{figure(length)} m in {figure(run.t[-1])} s, {len(run.t) - 1} steps, "
            f"turned {figure(math.degrees(end[2] - run.pose[0, 2]))} deg"
        )
    )
    for note in notes:
        sentence(("note", "yellow"), f"  {note}")
    told_files(files)
    if not files:
        out.print(Text("--out DIR leaves the run, a log and pictures there.", style="dim"))


def notes_of(robot: Robot, chosen: dict[str, Any], run: Run) -> list[str]:
    """Return what the user should know of the commands: what was driven instead, or disagrees."""
    kinematics = Kinematics(robot)
    if "twist" in chosen:
        asked = np.broadcast_to(chosen["twist"], run.twist.shape)
        miss = np.abs(asked - run.twist).max(axis=1)
        k = int(np.argmax(miss))
        if miss[k] <= 1e-9 * np.abs(asked).max(initial=0.0):
            return []
        given = ", ".join(figure(value) for value in run.twist[k])
        return [
            f"Asked for ({', '.join(figure(value) for value in asked[k])}), it drove ({given}). "
            f"{why_missing(robot, asked[k])}"
        ]
    notes = []
    steering = run.steering if robot.steered else None
    slip = np.abs(kinematics.residual(run.wheel_speeds, steering)).max(initial=0.0)
    if slip > _SLIP:
        notes.append(f"The wheels do not fit together: their rims slip by up to {slip:.3g} m/s.")
    for wheel, speeds in zip(robot.driven, run.wheel_speeds.T, strict=True):
        most = float(np.abs(speeds).max())
        if wheel.max_speed is not None and most > wheel.max_speed:
            notes.append(f"{wheel.name} turns at {most:.4g} rad/s and may do {wheel.max_speed:g}.")
    for steered, angles in zip(robot.steered, run.steering.T, strict=True):
        low, high = steered.steering_range
        if angles.min() < low or angles.max() > high:
            notes.append(f"{steered.name} steers beyond its limits.")
    return notes


def commands_of(
    robot: Robot,
    twist_given: tuple[str, str, str] | None,
    wheel_speeds: list[float] | None,
    commands: Path | None,
    steering_deg: list[float] | None,
) -> dict[str, Any]:
    """Return the command that was given, as arguments of the simulation."""
    ways = [bool(twist_given), bool(wheel_speeds), commands is not None]
    if sum(ways) != 1:
        raise TrundleError("give one of --twist VX VY WZ, --wheel-speeds W1 W2 ... or --commands")
    steering = options.steering_of(robot, steering_deg)
    if twist_given:
        if steering is not None:
            raise TrundleError("--steering-deg follows from --twist: leave it out")
        return {"twist": [number(value) for value in twist_given]}
    if wheel_speeds:
        return {"wheel_speeds": wheel_speeds, "steering": steering}
    assert commands is not None
    return _read_commands(robot, commands, steering)


def _read_commands(robot: Robot, path: Path, steering: Array | None) -> dict[str, Any]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            cells = [[cell.strip() for cell in row] for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"{path}: cannot be read: {error}") from None
    header, *body = cells or [[]]
    speeds, angles = [w.name for w in robot.driven], [f"{w.name}_deg" for w in robot.steered]
    twists = list(options.Twist)
    wanted = twists if set(twists) <= set(header) else speeds
    if missing := [name for name in wanted if name not in header]:
        raise FileError(
            f"{path}: no column {', '.join(missing)}; the header must have {', '.join(twists)} "
            f"or {', '.join(speeds)}"
        )
    known = {*twists} if wanted is twists else {*speeds, *angles}
    if strangers := [name for name in header if name not in known]:
        raise FileError(
            f"{path}: the columns {', '.join(strangers)} mean nothing here; there is one row per "
            f"--dt, with {', '.join(twists)} or {', '.join([*speeds, *angles])}"
        )
    columns = wanted + (angles if wanted is speeds and set(angles) <= set(header) else [])
    values = np.array(
        [_command_row(path, k, header, row, columns) for k, row in enumerate(body, 2)]
    )
    if len(values) == 0:
        raise FileError(f"{path}: there is no row of commands under the header")
    if wanted is twists:
        return {"twist": values}
    if len(columns) > len(speeds):
        steering = np.radians(values[:, len(speeds) :])
    return {"wheel_speeds": values[:, : len(speeds)], "steering": steering}


def _command_row(
    path: Path, line: int, header: list[str], row: list[str], columns: list[str]
) -> list[float]:
    if len(row) != len(header):
        raise FileError(f"{path}: line {line} has {len(row)} cells, the header {len(header)}")
    try:
        return [number(row[header.index(name)]) for name in columns]
    except typer.BadParameter as error:
        raise FileError(f"{path}: line {line}: {error}") from None


def _leave(robot: Robot, run: Run, target: Path, animation: str, quiet: bool) -> list[Path]:
    """Write the run, its log and its pictures."""
    from trundle.view import animate, plot_eta, plot_path, save

    files = [run.save(target / "run.csv"), run.save(target / "run.npz")]
    if robot.sensed:
        files.append(write_log(robot, run, target / "log.csv"))
    files.append(save(plot_eta(run), target / "eta.png"))
    files.append(save(plot_path(robot, run), target / "path.png"))
    if animation != "none":
        with progress(quiet) as bar:
            task = bar.add_task("drawing the animation")
            path = target / f"animation.{animation}"
            animate(
                robot,
                run,
                path,
                progress=lambda done, total: bar.update(task, completed=done, total=total),
            )
        files.append(path)
    return files
