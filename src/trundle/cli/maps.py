"""``trundle forward`` and ``trundle inverse``: between wheel speeds and twists."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.text import Text

from trundle.cli import options
from trundle.cli.numbers import number
from trundle.cli.output import (
    figure,
    folder,
    heading,
    out,
    print_json,
    sentence,
    table,
    told_files,
    twist,
)
from trundle.errors import TrundleError
from trundle.kinematics import Kinematics, mobility
from trundle.robot import Robot
from trundle.se2 import Array, point_twist

_RPM = 60 / math.tau


def forward(
    robot: options.RobotName,
    wheel_speeds: Annotated[
        list[float],
        typer.Argument(parser=number, metavar="W1 W2 ...", help="Wheel speeds [rad/s], in order."),
    ],
    steering_deg: options.SteeringDeg = None,
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Give the twist that wheel speeds make, and how far the wheels disagree.

    Example: `trundle forward omni3 0 -0.5 0.5`
    """
    made = options.robot_of(robot, sizes)
    kinematics = Kinematics(made)
    names = [wheel.name for wheel in made.driven]
    if len(wheel_speeds) != len(names):
        raise TrundleError(
            f"robot {made.name!r} has {len(names)} driven wheels ({', '.join(names)}): give that "
            f"many wheel speeds, got {len(wheel_speeds)}"
        )
    angles = options.steering_of(made, steering_deg)
    if made.steered and angles is None:
        steered = ", ".join(wheel.name for wheel in made.steered)
        raise TrundleError(
            f"robot {made.name!r} steers: add --steering-deg with the angles of {steered}"
        )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        given = kinematics.forward(wheel_speeds, angles)
    residual = kinematics.residual(wheel_speeds, angles)
    notes = [str(warning.message) for warning in told]
    files = _picture(made, angles, given, out_dir)
    if as_json:
        print_json({"twist": given, "residual": residual, "notes": notes, "files": files})
        return
    twist(("twist", given))
    heading("Wheels")
    rows = [
        [name, figure(speed), figure(miss)]
        for name, speed, miss in zip(names, wheel_speeds, residual, strict=True)
    ]
    table(["", "speed [rad/s]", "rim mismatch [m/s]"], rows)
    if np.abs(residual).max(initial=0.0) > 1e-9:
        out.print(Text("These speeds do not fit together: the twist is the least-squares one."))
    for note in notes:
        sentence(("note", "yellow"), f"  {note}.")
    told_files(files)


def inverse(
    robot: options.RobotName,
    vx: Annotated[float, typer.Argument(parser=number, metavar="VX", help="Forward [m/s].")],
    vy: Annotated[float, typer.Argument(parser=number, metavar="VY", help="To the left [m/s].")],
    wz: Annotated[
        float, typer.Argument(parser=number, metavar="WZ", help="Counter-clockwise [rad/s].")
    ],
    about: Annotated[
        tuple[str, str],
        typer.Option("--about", metavar="X Y", help="Body point whose velocity VX VY is [m]."),
    ] = ("0", "0"),
    steering_deg: Annotated[
        list[float] | None,
        typer.Option(
            "--steering-deg", metavar="DEG ...", parser=number, help="Present steering angles."
        ),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail where the twist cannot be met.")
    ] = False,
    limit: Annotated[
        bool, typer.Option("--limit/--no-limit", help="Keep the wheels' limits.")
    ] = True,
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Give wheel speeds (and steering angles) for a twist.

    Example: `trundle inverse omni3 0 0.5 0`
    """
    made = options.robot_of(robot, sizes)
    present = options.steering_of(made, steering_deg)
    asked = np.array([vx, vy, wz])
    at = [number(value) for value in about]
    found = Kinematics(made).inverse(asked, at, present, strict, limit)
    rpm = found.wheel_speeds * _RPM
    steered_to = found.steering if made.steered else None
    files = _picture(made, steered_to, point_twist(found.twist, [-each for each in at]), out_dir)
    if as_json:
        print_json(
            {
                "wheel_speeds": found.wheel_speeds,
                "rpm": rpm,
                "steering": found.steering,
                "residual": found.residual,
                "twist": found.twist,
                "driven": [wheel.name for wheel in made.driven],
                "steered": [wheel.name for wheel in made.steered],
                "files": files,
            }
        )
        return
    steering = {w.name: a for w, a in zip(made.steered, found.steering, strict=True)}
    speeds = {w.name: s for w, s in zip(made.driven, found.wheel_speeds, strict=True)}
    rows = [
        [
            name,
            figure(speeds[name]) if name in speeds else "",
            f"{speeds[name] * _RPM:.2f}" if name in speeds else "",
            *(
                [f"{math.degrees(steering[name]):.4f}" if name in steering else ""]
                if steering
                else []
            ),
        ]
        for name in dict.fromkeys([*speeds, *steering])
    ]
    table(["wheel", "rad/s", "rpm", "steering [deg]" if steering else ""], rows)
    heading("Twist")
    twist(("asked", asked), ("given", found.twist), ("missing", found.residual))
    if np.abs(found.residual).max() > 0:
        sentence(why_missing(made, asked, at, present))
    told_files(files)


def _picture(robot: Robot, steering: Array | None, moving: Array, out: Path | None) -> list[Path]:
    """Leave the robot from above with its instantaneous centre, where a folder is given."""
    target = folder(out)
    if target is None:
        return []
    from trundle.view import plot_layout, save

    return [save(plot_layout(robot, steering, moving), target / "layout.png")]


def why_missing(
    robot: Robot, asked: Array, about: Sequence[float] = (0.0, 0.0), present: Array | None = None
) -> str:
    """Return why a robot cannot have a twist: its wheels, its steering limits, its speed limits."""
    kinematics = Kinematics(robot)
    free = kinematics.inverse(asked, about, present, limit=False)
    limited = kinematics.inverse(asked, about, present)
    rounding = 1e-9 * float(np.abs(asked).max())
    if np.abs(free.residual).max() > rounding:
        can = mobility(robot)
        idle = f" Nothing drives: {'; '.join(can.undriven)}." if can.undriven else ""
        allowed = "; ".join(can.motions) or "none"
        return f"This robot cannot have that twist. Its wheels allow: {allowed}.{idle}"
    over = [
        f"{wheel.name} would turn at {abs(speed):.4g} rad/s and may do {wheel.max_speed:g}"
        for wheel, speed in zip(robot.driven, free.wheel_speeds, strict=True)
        if wheel.max_speed is not None and abs(speed) > wheel.max_speed
    ]
    share = float(np.linalg.norm(limited.twist) / np.linalg.norm(asked))
    if over and np.allclose(limited.twist, share * asked, atol=rounding):
        return f"The whole twist is scaled to {100 * share:.3g} %: {'; '.join(over)}."
    return "Its steering limits forbid that twist; this is the nearest within them."
