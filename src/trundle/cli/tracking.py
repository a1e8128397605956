"""``trundle track``: a controller keeps a robot on a trajectory."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.progress import Progress, TaskID
from rich.text import Text

from trundle.cli import options
from trundle.cli.numbers import number, positive
from trundle.cli.output import (
    folder,
    out,
    print_json,
    progress,
    sentence,
    table,
    told_files,
)
from trundle.cli.paths import PATHS, trajectory_of
from trundle.control import (
    PD,
    ComputedTorque,
    Controller,
    GoToPose,
    Kanayama,
    ReducedComputedTorque,
    ResolvedRate,
)
from trundle.dynamics import Dynamics
from trundle.errors import StabilityWarning, TrundleError, did_you_mean
from trundle.kinematics import mobility
from trundle.limits import Feasibility, feasibility
from trundle.motion import Trajectory, line
from trundle.robot import Robot
from trundle.simulation import Run
from trundle.simulation import track as run_tracking

_POSE = ("pd", "computed-torque")
_FORWARD = ("kanayama", "reduced-computed-torque")
_GOAL = "go-to-pose"
_ALL = (*_POSE, "resolved-rate", *_FORWARD, _GOAL)
_ROUNDING = 1e-11
Three = tuple[str, str, str] | None


def track(
    robot: options.RobotName,
    path: Annotated[
        str, typer.Option("--path", help=f"{', '.join(PATHS)}, or a CSV file with t, x, y (, psi).")
    ] = "circle",
    controller: Annotated[
        str | None,
        typer.Option(
            "--controller",
            help=f"{', '.join(_ALL)}; by default computed-torque, resolved-rate for robots that "
            "steer and can move every way, kanayama for those that cannot move sideways.",
        ),
    ] = None,
    compare: Annotated[
        bool,
        typer.Option("--compare", help="Run every tracking controller that suits the robot."),
    ] = False,
    kp: Annotated[
        Three,
        typer.Option(
            "--kp",
            metavar="X Y PSI",
            help="Proportional gains; for pd 4 m, 4 m, 4 I by default, for computed torque 4.",
        ),
    ] = None,
    kd: Annotated[
        Three,
        typer.Option("--kd", metavar="X Y PSI", help="Derivative gains; the same by default."),
    ] = None,
    heading: Annotated[
        str,
        typer.Option(
            "--heading", help="path, lecture (atan2 in 0 to 2 pi, no psi_dd) or an angle [rad]."
        ),
    ] = "path",
    scale: Annotated[
        float, typer.Option("--scale", parser=positive, help="Factor on the path's size.")
    ] = 1.0,
    stretch: Annotated[
        float, typer.Option("--stretch", parser=positive, help="Factor on the path's time.")
    ] = 1.0,
    duration: Annotated[
        float | None,
        typer.Option("--duration", parser=positive, metavar="S", help="Length [s]."),
    ] = None,
    dt: Annotated[
        float, typer.Option("--dt", parser=positive, metavar="S", help="Step [s].")
    ] = 0.01,
    method: Annotated[
        str, typer.Option("--method", help="semi-implicit, lecture, rk4 or adaptive.")
    ] = "semi-implicit",
    pose: Annotated[
        Three, typer.Option("--pose", metavar="X Y PSI", help="Start [m, m, rad], off the path.")
    ] = None,
    mass: Annotated[
        float | None, typer.Option("--mass", parser=positive, help="The body's mass [kg].")
    ] = None,
    inertia: Annotated[
        float | None,
        typer.Option("--inertia", parser=positive, help="Its inertia about com [kg m^2]."),
    ] = None,
    com: Annotated[
        tuple[str, str] | None,
        typer.Option("--com", metavar="X Y", help="Its centre of mass [m]."),
    ] = None,
    model_mass: Annotated[
        float | None,
        typer.Option(
            "--model-mass",
            parser=positive,
            help="Mass of the body for which the controllers are made [kg]; --mass by default.",
        ),
    ] = None,
    animation: Annotated[
        str, typer.Option("--animation", help="gif, mp4 (needs ffmpeg) or none.")
    ] = "gif",
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Keep a robot on a trajectory by a controller; --out leaves runs and pictures.

    Example: `trundle track omni3 --path via --compare --out run`

    The lectures' run: `trundle track omni3 --path circle --compare --heading lecture
    --method lecture --dt 0.1 --duration 60 --mass 30 --inertia 0.1 --com 0 0`
    """
    made = _weighed(options.robot_of(robot, sizes), mass, inertia, com)
    if animation not in ("gif", "mp4", "none"):
        raise TrundleError(f"--animation takes gif, mp4 or none, got {animation!r}")
    trajectory = trajectory_of(path, scale, stretch, heading)
    gains = {n: _numbers(given, f"--{n}") for n, given in (("kp", kp), ("kd", kd)) if given}
    names = _names(made, controller, compare)
    if model_mass is not None and not {*_POSE, "reduced-computed-torque"} & {*names}:
        raise TrundleError("--model-mass belongs to pd and to computed torque")
    chosen = {name: _controller(name, made, gains, model_mass) for name in names}
    start = _numbers(pose, "--pose") if pose else None
    target = folder(out_dir)
    runs, told = {}, []
    for name, law in chosen.items():
        goal = name == _GOAL
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", StabilityWarning)
            runs[name] = run_tracking(
                made,
                _goal(trajectory) if goal else trajectory,
                law,
                duration=duration,
                dt=dt,
                method=method,
                pose=trajectory.position(0.0) if goal and start is None else start,
            )
        told += [f"{name}: {each.message}" for each in caught]
        told += [f"{name}: {report}" for report in runs[name].reports]
    demand = feasibility(made, trajectory, duration=duration)
    told += demand.reports
    files = _leave(made, trajectory, runs, demand, target, animation, as_json) if target else []
    numbers = {name: _numbers_of(run) for name, run in runs.items()}
    if as_json:
        keyed = {
            name: {key.replace(" ", "_"): value for key, value in values.items()}
            for name, values in numbers.items()
        }
        gained = {name: _gains_of(law) for name, law in chosen.items()}
        print_json(
            {
                "runs": keyed,
                "gains": gained,
                "notes": told,
                "stretch": demand.stretch,
                "files": files,
            }
        )
        return
    sentence(f"{made.name}: {trajectory.name}, heading {trajectory.heading.words}")
    rows = [
        [f"{key} [{unit}]", *(_short(values[key]) for values in numbers.values())]
        for key, unit in _UNITS.items()
    ]
    table(["", *numbers], rows)
    for name, law in chosen.items():
        if told_gains := _gains_of(law):
            told_words = ", ".join(f"{key} {_listed(value)}" for key, value in told_gains.items())
            out.print(Text(f"{name}: {told_words}", style="dim"))
    for note in told:
        sentence(("note", "yellow"), f"  {note}")
    told_files(files)
    if not files:
        out.print(Text("--out DIR leaves the runs and pictures there.", style="dim"))


_UNITS = {
    "largest error of x": "m",
    "largest error of y": "m",
    "largest error of psi": "rad",
    "rms distance": "m",
    "rms torque": "N m",
    "work": "J",
}


def _numbers_of(run: Run) -> dict[str, float]:
    """Return what a run is judged by: errors, rms torque and work; nan where it has none."""
    assert run.error is not None
    far = np.hypot(run.error[:, 0], run.error[:, 1])
    torque = math.nan if run.torques is None else np.sqrt(np.mean(run.torques**2))
    work = math.nan if run.work is None else run.work[-1]
    values = (*np.abs(run.error).max(axis=0), np.sqrt(np.mean(far**2)), torque, work)
    return dict(zip(_UNITS, map(float, values), strict=True))


def _short(value: float) -> str:
    return "-" if math.isnan(value) else f"{0.0 if abs(value) < _ROUNDING else value:.4g}"


def _weighed(
    robot: Robot, mass: float | None, inertia: float | None, com: tuple[str, str] | None
) -> Robot:
    """Return the robot with the masses of the command line."""
    changes: dict[str, Any] = {"mass": mass, "inertia": inertia}
    if com is not None:
        changes["com"] = tuple(_numbers(com, "--com"))
    changes = {key: value for key, value in changes.items() if value is not None}
    return robot.with_body(**changes) if changes else robot


def _numbers(given: tuple[str, ...], option: str) -> list[float]:
    try:
        return [number(value) for value in given]
    except typer.BadParameter as error:
        raise TrundleError(f"{option}: {error}") from None


def _names(robot: Robot, controller: str | None, compare: bool) -> tuple[str, ...]:
    """Return the names of the controllers to run."""
    suits = _suiting(robot)
    if compare and controller is not None:
        raise TrundleError("give --controller or --compare, not both")
    if compare:
        return suits
    if controller is None:
        return (suits[-1] if suits == _POSE else suits[0],)
    if controller not in _ALL:
        raise TrundleError(
            f"no controller {controller!r}{did_you_mean(controller, _ALL)}; give one of "
            f"{', '.join(_ALL)}"
        )
    forces = (*_POSE, "reduced-computed-torque")
    if controller in forces and controller not in suits and suits != _POSE:
        reason = "steers" if robot.steered else "cannot be pushed sideways"
        raise TrundleError(
            f"robot {robot.name!r} {reason}, so {controller} does not suit it: "
            f"use --controller {' or '.join(suits)}"
        )
    return (controller,)


def _suiting(robot: Robot) -> tuple[str, ...]:
    """Return the controllers of trajectories that suit a robot."""
    can = mobility(robot)
    if robot.steered:
        return ("resolved-rate",) if can.maneuverability == 3 else _FORWARD[:1]
    return _POSE if can.omnidirectional else _FORWARD


def _controller(
    name: str, robot: Robot, gains: dict[str, list[float]], model_mass: float | None
) -> Controller:
    """Return a controller; without gains those of the lectures, scaled to the robot's mass."""
    if name not in _POSE and gains:
        raise TrundleError("--kp and --kd belong to pd and computed-torque")
    believed = robot if model_mass is None else robot.with_body(mass=model_mass)
    model = None if model_mass is None else Dynamics(believed)
    makers: dict[str, Callable[[], Controller]] = {
        "pd": lambda: PD(**_pd_gains(believed) | gains),
        "computed-torque": lambda: ComputedTorque(
            **{"kp": [4.0] * 3, "kd": [4.0] * 3} | gains, model=model
        ),
        "resolved-rate": ResolvedRate,
        "kanayama": Kanayama,
        "reduced-computed-torque": lambda: ReducedComputedTorque(model=model),
        _GOAL: GoToPose,
    }
    return makers[name]()


def _gains_of(law: Controller) -> dict[str, Any]:
    """Return a controller's gains by name."""
    if not dataclasses.is_dataclass(law):
        return {}
    values = {field.name: getattr(law, field.name) for field in dataclasses.fields(law)}
    return {name: value for name, value in values.items() if name != "model"}


def _listed(value: Any) -> str:
    return " ".join(f"{each:.4g}" for each in np.atleast_1d(value))


def _pd_gains(robot: Robot) -> dict[str, list[float]]:
    """Return gains of the lectures' ratio to mass and inertia: 120 for 30 kg."""
    felt = Dynamics(robot)
    values = [4 * felt.mass, 4 * felt.mass, 4 * felt.inertia]
    return {"kp": values, "kd": values}


def _goal(trajectory: Trajectory) -> Trajectory:
    """Return the end of a trajectory as a goal that stays."""
    end = trajectory.position(trajectory.duration)
    return line(end, end, trajectory.duration)


def _leave(
    robot: Robot,
    trajectory: Trajectory,
    runs: dict[str, Run],
    demand: Feasibility,
    target: Path,
    animation: str,
    quiet: bool,
) -> list[Path]:
    """Write the runs and their pictures."""
    from trundle.view import (
        animate,
        plot_comparison,
        plot_feasibility,
        plot_tracking,
        plot_trajectory,
        save,
    )

    files = [run.save(target / f"{name}.csv") for name, run in runs.items()]
    files.append(save(plot_trajectory(trajectory), target / "trajectory.png"))
    if demand.demands or not demand.feasible:
        files.append(save(plot_feasibility(demand), target / "feasibility.png"))
    files += [save(plot_tracking(robot, run), target / f"{name}.png") for name, run in runs.items()]
    if len(runs) > 1:
        files.append(save(plot_comparison(robot, runs), target / "comparison.png"))
    if animation == "none":
        return files
    with progress(quiet) as bar:
        for name, run in runs.items():
            task = bar.add_task(f"drawing {name}")
            to = target / f"{name}.{animation}"
            tell = partial(_tell, bar, task)
            files.append(animate(robot, run, to, progress=tell))
    return files


def _tell(bar: Progress, task: TaskID, done: int, total: int) -> None:
    bar.update(task, completed=done, total=total)
