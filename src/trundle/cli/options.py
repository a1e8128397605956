"""The arguments and options that commands share."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.text import Text

from trundle.cli.numbers import number, positive
from trundle.cli.output import err
from trundle.errors import FileError, GuessWarning, TrundleError
from trundle.robot import Robot, load
from trundle.se2 import Array

RobotName = Annotated[
    str,
    typer.Argument(metavar="ROBOT", help="A catalogue name, or the path of a TOML file or a URDF."),
]
Sizes = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="SIZE=VALUE", help="Change a catalogue robot's size, as radius=0.1."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON value for machines.")]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for pictures and files; made if need be."),
]
GivenTwist = Annotated[
    tuple[str, str, str] | None,
    typer.Option("--twist", metavar="VX VY WZ", help="A constant twist."),
]
GivenSpeeds = Annotated[
    list[float] | None,
    typer.Option(
        "--wheel-speeds", metavar="W1 W2 ...", parser=number, help="Constant speeds [rad/s]."
    ),
]
GivenFile = Annotated[
    Path | None,
    typer.Option(
        "--commands",
        metavar="FILE.csv",
        help="One row per step, with a header: the driven wheels' names, or VX,VY,WZ; "
        "for steered wheels NAME_deg beside the speeds.",
    ),
]
Duration = Annotated[
    float | None,
    typer.Option("--duration", parser=positive, metavar="S", help="Length [s], 10 by default."),
]
Step = Annotated[float, typer.Option("--dt", parser=positive, metavar="S", help="Step [s].")]
SteeringDeg = Annotated[
    list[float] | None,
    typer.Option(
        "--steering-deg",
        metavar="DEG ...",
        parser=number,
        help="Steering angles [deg], in the order of the steered wheels.",
    ),
]
Twist = ("VX", "VY", "WZ")


def robot_of(name: str, sizes: list[str] | None = None) -> Robot:
    """Return the robot of the command line."""
    changes: dict[str, Any] = {}
    for item in sizes or []:
        key, equals, value = item.partition("=")
        if not equals:
            raise FileError(f"--set needs SIZE=VALUE, such as radius=0.1, got {item!r}")
        changes[key.strip()] = number(value)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GuessWarning)
        robot = load(name, **changes)
    for each in caught:
        err.print(Text.assemble(("warning: ", "yellow"), str(each.message)))
    return robot


def steering_of(robot: Robot, degrees: list[float] | None) -> Array | None:
    """Return the steering angles of the command line [rad], or None."""
    if degrees is None or len(degrees) == 0:
        return None
    names = [wheel.name for wheel in robot.steered]
    if len(degrees) != len(names):
        if not names:
            raise TrundleError(f"robot {robot.name!r} does not steer: leave out --steering-deg")
        raise TrundleError(
            f"robot {robot.name!r} has {len(names)} steering angle{'s' * (len(names) > 1)} "
            f"({', '.join(names)}), got {len(degrees)}"
        )
    return np.radians(degrees)
