"""``trundle export``: a robot as firmware, as settings of ROS controllers, or as a URDF."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from trundle.cli import options
from trundle.cli.numbers import positive
from trundle.cli.output import folder, heading, out, print_json, verbatim, write
from trundle.errors import FileError, TrundleError, did_you_mean
from trundle.robot import Robot

# Formats that are one file, and how its name ends; firmware is a folder of files.
_ONE_FILE = {"ros2_controllers": "_controllers.yaml", "urdf": ".urdf"}
_FORMATS = ("c", *_ONE_FILE)
_SUFFIXES = {"ros2_controllers": (".yaml", ".yml"), "urdf": (".urdf", ".xml")}
# What nobody calls a folder of firmware; of the other formats any suffix of letters is a file's.
_SOURCES = (".c", ".h", ".cpp", ".hpp", ".ino", ".txt", ".md", ".yaml", ".yml", ".urdf", ".xml")


def _limit(metavar: str, help: str) -> typer.models.OptionInfo:
    made: typer.models.OptionInfo = typer.Option(
        parser=positive, metavar=metavar, help=help, rich_help_panel="Limits (firmware and ROS)"
    )
    return made


def export(
    robot: options.RobotName,
    to: Annotated[
        str | None, typer.Option("--to", metavar="FORMAT", help=f"{', '.join(_FORMATS)}.")
    ] = None,
    out_path: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Folder for the files; made if need be. A name.yaml or name.urdf is the file. "
            "Without it firmware goes to ./ROBOT-c, the others are printed.",
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite files that are there and differ.")
    ] = False,
    timeout: Annotated[
        float | None, _limit("S", "Age at which a command is stale [s], 0.5 by default.")
    ] = None,
    max_speed: Annotated[float | None, _limit("V", "Largest speed [m/s].")] = None,
    max_reverse_speed: Annotated[
        float | None, _limit("V", "Largest speed in reverse [m/s].")
    ] = None,
    max_yaw_rate: Annotated[float | None, _limit("R", "Largest yaw rate [rad/s].")] = None,
    max_acceleration: Annotated[float | None, _limit("A", "Largest acceleration [m/s^2].")] = None,
    max_deceleration: Annotated[
        float | None, _limit("A", "Largest braking [m/s^2]; the acceleration's by default.")
    ] = None,
    max_reverse_acceleration: Annotated[
        float | None, _limit("A", "Largest acceleration in reverse [m/s^2].")
    ] = None,
    max_reverse_deceleration: Annotated[
        float | None, _limit("A", "Largest braking in reverse [m/s^2].")
    ] = None,
    max_yaw_acceleration: Annotated[
        float | None, _limit("A", "Largest yaw acceleration [rad/s^2].")
    ] = None,
    max_yaw_deceleration: Annotated[
        float | None, _limit("A", "Largest yaw braking [rad/s^2].")
    ] = None,
    max_jerk: Annotated[float | None, _limit("J", "Largest jerk [m/s^3].")] = None,
    max_yaw_jerk: Annotated[float | None, _limit("J", "Largest yaw jerk [rad/s^3].")] = None,
    sizes: options.Sizes = None,
    as_json: options.Json = False,
) -> None:
    """Export a robot to other programs: the same equations, in their language and conventions.

    * `c`: C99 for a microcontroller: kinematics, odometry, limits, watchdog, a main loop.
    * `ros2_controllers`: the YAML of the controller that fits, or why none does.
    * `urdf`: wheel joints and simple visuals; trundle reads it back.

    Example: `trundle export mecanum --to c --max-speed 1 --max-acceleration 0.5`

    Example: `trundle export differential --to ros2_controllers --out my_robot.yaml`
    """
    form = _format(to)
    given = {
        "timeout": timeout,
        "max_speed": max_speed,
        "max_reverse_speed": max_reverse_speed,
        "max_yaw_rate": max_yaw_rate,
        "max_acceleration": max_acceleration,
        "max_deceleration": max_deceleration,
        "max_reverse_acceleration": max_reverse_acceleration,
        "max_reverse_deceleration": max_reverse_deceleration,
        "max_yaw_acceleration": max_yaw_acceleration,
        "max_yaw_deceleration": max_yaw_deceleration,
        "max_jerk": max_jerk,
        "max_yaw_jerk": max_yaw_jerk,
    }
    settings = {name: value for name, value in given.items() if value is not None}
    if settings and form == "urdf":
        option = next(iter(settings)).replace("_", "-")
        raise TrundleError(f"--{option} belongs to firmware and controllers, not to --to urdf")
    made = options.robot_of(robot, sizes)
    texts = _texts(made, form, settings, robot)
    if form in _ONE_FILE and out_path is None:
        (text,) = texts.values()
        if as_json:
            print_json({"name": made.name, "to": form, "files": [], "text": text})
        else:
            print(text, end="")
        return
    placed = _placed(made, form, out_path, texts)
    written, kept = _write_all(placed, force)
    if as_json:
        print_json({"name": made.name, "to": form, "files": [*written, *kept], "text": None})
        return
    for file in written:
        out.print(Text(f"wrote {file}"), soft_wrap=True)
    for file in kept:
        out.print(Text(f"{file} is up to date"), soft_wrap=True)
    heading("Next")
    for line in _next_steps(form, texts, list(placed)):
        verbatim(line)


def _format(to: str | None) -> str:
    if to is None:
        raise TrundleError(f"--to is missing: choose {', '.join(_FORMATS[:-1])} or {_FORMATS[-1]}")
    if to not in _FORMATS:
        raise TrundleError(
            f"--to takes {', '.join(_FORMATS)}, got {to!r}{did_you_mean(to, _FORMATS)}"
        )
    return to


def _texts(robot: Robot, form: str, settings: Mapping[str, float], asked: str) -> dict[str, str]:
    """Return the text of each file, by its name, of the robot that was asked for."""
    # Loaded when used: printing firmware takes its time, and no other command needs it.
    from trundle.exchange import c_files, ros2_controllers, urdf

    if form == "c":
        return c_files(robot, **settings)
    name = f"{_stem(robot)}{_ONE_FILE[form]}"
    if form == "urdf":
        return {name: urdf(robot)}
    try:
        return {name: ros2_controllers(robot, **settings)}
    except TrundleError as error:
        # The library does not know how the command was given the robot.
        command = f"trundle export {shlex.quote(asked)} "
        raise TrundleError(str(error).replace("trundle export ROBOT ", command)) from None


def _stem(robot: Robot) -> str:
    from trundle.exchange import plain_name

    return plain_name(robot.name, "robot")


def _placed(
    robot: Robot, form: str, out_path: Path | None, texts: Mapping[str, str]
) -> dict[Path, str]:
    """Return the text of each file, by its path."""
    if out_path is None:
        out_path = Path(f"{_stem(robot)}-c")
    suffix = "" if _is_folder(out_path) else out_path.suffix.lower()
    if suffix in _SUFFIXES.get(form, ()):
        folder(out_path.parent)
        return dict.fromkeys([out_path], *texts.values())
    named = _SUFFIXES.get(form)
    if suffix in _SOURCES or (named and suffix[1:].isalpha()):
        wanted = f"a name that ends in {' or '.join(named)}, or a folder" if named else "a folder"
        raise TrundleError(f"--out {out_path}: --to {form} needs {wanted}")
    return {out_path / name: text for name, text in texts.items()}


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # a name that no file can have
        return False


def _write_all(texts: Mapping[Path, str], force: bool) -> tuple[list[Path], list[Path]]:
    """Write what is not there yet; return what was written, and what was there already.

    Raises:
        FileError: a file is there and differs; then nothing is written.
    """
    kept = [path for path, text in texts.items() if _content(path) == text]
    differ = [path for path in texts if path not in kept and os.path.lexists(path)]
    if differ and not force:
        raise FileError(
            f"{differ[0]} is there already and differs: choose another --out, or --force to "
            "overwrite it"
        )
    folder(next(iter(texts)).parent)
    written = [path for path in texts if path not in kept]
    for path in written:
        write(path, texts[path])
    return written, kept


def _content(path: Path) -> str | None:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError):  # not there, or not a text
        return None


def _next_steps(form: str, texts: Mapping[str, str], files: list[Path]) -> list[str]:
    """Return the commands with which to go on."""
    shown = [shlex.quote(str(file)) for file in files]
    if form == "urdf":
        return [f"trundle show {shown[0]}"]
    if form == "ros2_controllers":
        (text,) = texts.values()
        start = next(line for line in text.splitlines() if "ros2 run" in line)
        return [start.lstrip("# ").replace("THIS_FILE", shown[0])]
    source = next(name for name, file in zip(shown, files, strict=True) if file.suffix == ".c")
    readme = [
        f"less {name}" for name, file in zip(shown, files, strict=True) if file.suffix == ".md"
    ]
    return [f"gcc -std=c99 -Wall -Wextra -Werror -c {source}", *readme]
