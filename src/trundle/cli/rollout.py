"""``trundle rollout``: where do many robots end that are not quite alike?"""

from __future__ import annotations

import csv
import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.text import Text

from trundle.cli import options
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
from trundle.cli.simulation import commands_of, notes_of
from trundle.cli.tolerances import Tolerance, draw_robots, tolerances_of
from trundle.errors import FileError, SpeedWarning, TrundleError
from trundle.robot import Robot
from trundle.se2 import Array
from trundle.simulation import Constant, Every, Rollouts, Run, Stream, compile_rollout
from trundle.simulation import simulate as run_simulation

_PATHS, _ROWS = 30, 400  # drawn, and points of each
# A table of more rows is slow to write, and no program for tables opens it.
_MOST_CSV = 100_000
_PATIENCE = 1.0  # how long nothing need be shown [s]
_MISSES = 1e-9  # of a step: 0.1 is no binary number


def _nonnegative(text: Any) -> float:
    if (value := number(text)) < 0:
        raise typer.BadParameter(f"must not be negative, got {value:g}")
    return value


def rollout(
    robot: options.RobotName,
    twist_given: options.GivenTwist = None,
    wheel_speeds: options.GivenSpeeds = None,
    commands: options.GivenFile = None,
    steering_deg: options.SteeringDeg = None,
    duration: options.Duration = None,
    dt: options.Step = 0.05,
    robots: Annotated[
        int, typer.Option("--robots", min=1, max=10_000_000, metavar="N", help="How many.")
    ] = 10_000,
    noise: Annotated[
        float,
        typer.Option(
            "--noise",
            parser=_nonnegative,
            metavar="SIGMA",
            help="Standard deviation of each wheel's speed [rad/s], drawn anew in every step.",
        ),
    ] = 0.0,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="NAME=SPREAD",
            help="A number of the robot that is known to so much: a percentage, or a standard "
            "deviation in its unit. radius=1% is the same error for all wheels, "
            "left.radius=1% that of one; track, wheelbase and arm move all wheels.",
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="The same seed gives the same robots and noise.")
    ] = 0,
    dtype: Annotated[str, typer.Option("--dtype", help="float64 or float32.")] = "float64",
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Drive many robots with the same commands, with noise and tolerances: where do they end?

    Every robot gets the wheel speeds that the robot as described needs.

    Example: `trundle rollout mecanum --twist 0.3 0 0.5 --noise 0.2 --vary radius=1%
    --vary track=0.005 --vary front_left.radius=0.5% --out run`
    """
    made = options.robot_of(robot, sizes)
    chosen = commands_of(made, twist_given, wheel_speeds, commands, steering_deg)
    tolerances = tolerances_of(vary or [])
    if not tolerances and not noise:
        raise TrundleError(
            "all robots are the same: give --noise, or --vary such as --vary radius=1%"
        )
    if dtype not in ("float64", "float32"):
        raise TrundleError(f"--dtype takes float64 or float32, got {dtype!r}")
    target = folder(out_dir)
    run = _nominal(made, chosen, 10.0 if duration is None and commands is None else duration, dt)
    numbers = draw_robots(made, tolerances, robots, seed)
    drive = _Drive(made, run, numbers, robots, noise, seed, dtype)
    done = _driven(drive, as_json)
    files = _leave(drive, done, _asked(noise, tolerances), target) if target else []
    notes = [*done.notes, *notes_of(made, chosen, run)]
    if as_json:
        print_json(_told(drive, done) | {"notes": notes, "files": files})
        return
    _show(drive, done)
    for note in notes:
        sentence(("note", "yellow"), f"  {note}")
    told_files(files)
    if not files:
        out.print(Text("--out DIR leaves a picture and all final poses there.", style="dim"))


@dataclass(frozen=True, eq=False)
class _Drive:
    """What is driven: the nominal run, and how the robots differ from it."""

    robot: Robot
    run: Run
    numbers: dict[str, Array]
    robots: int
    noise: float
    seed: int
    dtype: str

    @property
    def steps(self) -> int:
        return len(self.run.twist)

    def prepared(self, robots: int, save: str | Every) -> Any:
        """Return the rollout of the first so many robots, made ready."""
        run, steers = self.run, bool(self.robot.steered)
        alike = (run.wheel_speeds == run.wheel_speeds[0]).all()
        alike &= (run.steering == run.steering[0]).all()
        rows: Any = 0 if alike else slice(None)
        kind = Constant if alike else Stream
        commands = kind(run.wheel_speeds[rows], steering=run.steering[rows] if steers else None)
        if self.noise:
            sigma = [self.noise] * len(self.robot.driven) + [0.0] * len(self.robot.steered)
            commands = commands.with_noise(sigma, seed=self.seed)
        return compile_rollout(
            self.robot,
            commands,
            dt=float(run.t[1]),
            steps=self.steps,
            pose=np.zeros((robots, 3)),
            save=save,
            dtype=self.dtype,
            parameters={name: values[:robots] for name, values in self.numbers.items()},
        )


@dataclass(frozen=True, eq=False)
class _Done:
    """What came of it: where all robots end, the paths of some, how long it took, and remarks."""

    final: Array
    paths: Array
    device: str
    seconds: float
    notes: list[str]


def _nominal(robot: Robot, chosen: dict[str, Any], duration: float | None, dt: float) -> Run:
    """Return the run of the robot as described, in steps of one length."""
    if duration is not None:
        dt = duration / max(math.ceil(duration / dt - _MISSES), 1)
    return run_simulation(robot, **chosen, duration=duration, dt=dt)


def _driven(drive: _Drive, quiet: bool) -> _Done:
    """Drive some robots and keep their paths, which compiles the loop; then all, on the clock."""
    with warnings.catch_warnings(record=True) as caught, progress(quiet) as bar:
        warnings.simplefilter("always", SpeedWarning)
        task = bar.add_task("making the loop ready", total=None)
        few, every = min(drive.robots, _PATHS), max(drive.steps // _ROWS, 1)
        some: Rollouts = drive.prepared(few, Every(every))()
        ready = drive.prepared(drive.robots, "final")
        began = time.perf_counter()
        bar.update(task, description="driving the robots", visible=False)

        def tell(done: int, total: int) -> None:
            late = time.perf_counter() - began > _PATIENCE
            bar.update(task, completed=done, total=total, visible=late)

        every_one: Rollouts = ready(progress=tell)
        seconds = time.perf_counter() - began
    paths = np.concatenate([some.pose, some.final[None]])
    notes = [f"{each.message}." for each in caught if issubclass(each.category, SpeedWarning)]
    return _Done(every_one.final, paths, every_one.device, seconds, notes)


def _ends(drive: _Drive, done: _Done) -> Any:
    from trundle.view import ends_of

    return ends_of(drive.run.pose[-1], done.final)


def _told(drive: _Drive, done: _Done) -> dict[str, Any]:
    """Return what came of it for machines."""
    ends = _ends(drive, done)
    return {
        "robots": drive.robots,
        "steps": drive.steps,
        "duration": drive.run.t[-1],
        "nominal": ends.nominal,
        "mean": ends.mean,
        "standard_deviation": ends.std,
        "ellipse": {
            "half_axes": ends.half_axes,
            "direction": ends.direction,
            "inside": ends.inside,
        },
        "within_95_percent": ends.within,
        "farthest": {
            "robot": ends.farthest,
            "pose": done.final[ends.farthest],
            "distance": ends.off[ends.farthest],
        },
        "device": done.device,
        "seconds": done.seconds,
        "robot_steps_per_second": drive.robots * drive.steps / done.seconds,
    }


def _show(drive: _Drive, done: _Done) -> None:
    """Print what came of it for people."""
    ends = _ends(drive, done)
    shift = math.hypot(*(ends.mean - ends.nominal)[:2])
    rows = [
        ("nominal", ends.nominal, "-"),
        ("mean", ends.mean, figure(shift)),
        ("standard deviation", ends.std, "-"),
        (
            f"farthest, robot {ends.farthest}",
            done.final[ends.farthest],
            figure(ends.off[ends.farthest]),
        ),
    ]
    table(
        ["", "x [m]", "y [m]", "psi [rad]", "off by [m]"],
        [[name, *(figure(value) for value in pose), off] for name, pose, off in rows],
    )
    sentence(f"95 % of the robots end within {figure(ends.within)} m of the nominal end.")
    _show_ellipse(ends)
    rate = drive.robots * drive.steps / done.seconds
    words = f"{rate / 1e6:.3g} million" if rate >= 1e6 else f"{rate:.3g}"
    sentence(
        f"{drive.robots} robots, {drive.steps} steps of {figure(drive.run.t[1])} s: {words} "
        f"robot-steps per second ({done.device}, {drive.dtype})."
    )


def _show_ellipse(ends: Any) -> None:
    a, b = (figure(value) for value in ends.half_axes)
    if a == "0":
        return
    sentence(
        f"The 95 % ellipse about the mean has half axes of {a} m and {b} m, the longer at "
        f"{figure(round(math.degrees(ends.direction), 1))} deg from x; {100 * ends.inside:.1f} % "
        "of the robots end in it."
    )


def _asked(noise: float, tolerances: list[Tolerance]) -> list[str]:
    """Return noise and tolerances in words."""
    words = [f"{each.name} to {each.given}" for each in tolerances]
    return [*([f"noise {noise:g} rad/s"] if noise else []), *words]


def _leave(drive: _Drive, done: _Done, asked: list[str], target: Path) -> list[Path]:
    """Write all final poses with the numbers of each robot, and the picture."""
    from trundle.view import plot_cloud, save

    columns = dict(zip(("x", "y", "psi"), np.asarray(done.final, dtype=np.float64).T, strict=True))
    columns |= drive.numbers
    files = [_written(target / "final.npz", lambda path: np.savez_compressed(path, **columns))]
    if drive.robots <= _MOST_CSV:
        files.append(_written(target / "final.csv", lambda path: _to_csv(path, columns)))
    picture = plot_cloud(drive.robot, drive.run, done.final, done.paths, asked)
    return [*files, save(picture, target / "cloud.png")]


def _to_csv(path: Path, columns: dict[str, Array]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["robot", *columns])
        writer.writerows(_rows(columns))


def _rows(columns: dict[str, Array]) -> list[list[str]]:
    rows = np.column_stack(list(columns.values())).tolist()
    return [[str(k), *map(repr, row)] for k, row in enumerate(rows)]


def _written(path: Path, write: Callable[[Path], None]) -> Path:
    try:
        write(path)
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None
    return path
