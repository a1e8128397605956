"""``trundle demo``: the lectures' drives in motion, a log replayed, controllers compared."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from trundle.cli import options
from trundle.cli.output import folder, heading, print_json, progress, sentence, table, write
from trundle.control import PD, ComputedTorque, Controller
from trundle.kinematics import mobility
from trundle.motion import circle
from trundle.odometry import Score, read_log, score
from trundle.robot import Encoder, Robot, load
from trundle.simulation import Run, replay, simulate, track, write_log

# Where the lectures' simulations start.
_START = (0.5, 0.5, math.pi / 4)
_COUNTER_BITS = 12


@dataclass(frozen=True)
class _Scene:
    """A robot, its commands, and what they show."""

    name: str
    robot: str
    shows: str
    commands: dict[str, Any]
    duration: float = 10.0


def _waves(t: float) -> tuple[float, float, float]:
    return 0.5, 0.0, 0.6 * math.cos(0.6 * t)


def _crab_and_turn(t: float) -> tuple[float, float, float]:
    return 0.4 * math.cos(0.5 * t), 0.4 * math.sin(0.5 * t), 0.35


_SCENES = (
    _Scene(
        "omni3_spot", "omni3", "equal wheel speeds turn it on the spot",
        {"wheel_speeds": (0.5, 0.5, 0.5)},
    ),
    _Scene(
        "omni3_forward", "omni3", "(0, -c, c) drives it forward",
        {"wheel_speeds": (0.0, -0.5, 0.5)},
    ),
    _Scene(
        "omni3_sideways", "omni3", "(2, -1, -1) c drives it purely sideways",
        {"wheel_speeds": (0.5, -0.25, -0.25)},
    ),
    _Scene("differential", "differential", "a winding path", {"twist": _waves}),
    _Scene("ackermann", "ackermann", "a car: exact left and right angles",
           {"twist": lambda t: (1.5, 0.0, 0.35 * math.sin(0.5 * t))}),
    _Scene("mecanum", "mecanum", "any path, with any heading", {"twist": _crab_and_turn}),
    _Scene("omni4", "omni4", "X-drive with reversed wheels", {"twist": (0.3, 0.0, 0.5)}),
    _Scene("two_steered", "two_steered", "two wheels that steer and drive",
           {"twist": _crab_and_turn}),
    _Scene("swerve", "swerve", "four such modules", {"twist": _crab_and_turn}),
)  # fmt: skip


def demo(
    out_dir: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for the gallery.")
    ] = Path("gallery"),
    as_json: options.Json = False,
) -> None:
    """Simulate the lectures' drives, replay a log, track a circle, and leave a gallery.

    Example: `trundle demo --out gallery`
    """
    target = folder(out_dir)
    assert target is not None
    files: list[Path] = []
    drawn: set[str] = set()
    rows = []
    with progress(as_json) as bar:
        task = bar.add_task("drawing the gallery", total=len(_SCENES) + 2)
        for scene in _SCENES:
            robot = load(scene.robot)
            run = simulate(robot, **scene.commands, duration=scene.duration, dt=0.05, pose=_START)
            files += _draw(robot, run, scene.name, target)
            if scene.robot not in drawn:
                drawn.add(scene.robot)
                files += _draw_robot(robot, run, target)
            end = run.pose[-1]
            rows.append(
                [
                    scene.name,
                    mobility(robot).kind,
                    scene.shows,
                    f"{end[0]:.3f}, {end[1]:.3f}, {math.degrees(end[2]):.1f} deg",
                ]
            )
            bar.advance(task)
        error, made = _replay(target)
        files += made
        bar.advance(task)
        largest, made = _compare_and_derive(target)
        files += made
        bar.advance(task)
    if as_json:
        print_json({"files": files, "replay": vars(error), "tracking": largest})
        return
    heading("Simulated, from the pose (0.5, 0.5, 45 deg)")
    table(["", "class", "what it shows", "end x, y, heading"], rows, left=4)
    heading("Replayed: the log of a differential robot, its ticks counted in 12 bits")
    sentence(
        f"{error.distance:.2f} m driven; odometry ends {1000 * error.end_error:.2f} mm off "
        f"({error.end_percent:.1g} %)"
    )
    heading("Controlled: the lectures' circle, omni3 with 30 kg, steps of 0.1 s")
    sentence(
        "largest error "
        + ", ".join(f"{1000 * value:.4g} mm by {name}" for name, value in largest.items())
    )
    heading(f"{len(files)} files in {target}")
    sentence("NAME.gif and NAME_path.png for each row above: the robot in motion")
    sentence("ROBOT_layout.png: the robot from above, with rollers, force lines and centre")
    sentence("ROBOT_eta.png: pose over time; ROBOT_reachable.png: the twists within the limits")
    sentence("log.csv and replay.png: the log, and its path over the truth")
    sentence("tracking.png: PD and computed torque side by side")
    sentence("omni3_derived.html: its equations, from the wheels to M and n")


def _draw(robot: Robot, run: Run, name: str, target: Path) -> list[Path]:
    """Leave the path and an animation of a run."""
    from trundle.view import animate, plot_path, save

    return [
        save(plot_path(robot, run), target / f"{name}_path.png"),
        animate(robot, run, target / f"{name}.gif"),
    ]


def _draw_robot(robot: Robot, run: Run, target: Path) -> list[Path]:
    """Leave the pictures of a robot, at the steering angles with which its run begins."""
    from trundle.view import plot_eta, plot_layout, plot_reachable, save

    steering = run.steering[0] if robot.steered else None
    return [
        save(plot_layout(robot, steering), target / f"{robot.name}_layout.png"),
        save(plot_reachable(robot), target / f"{robot.name}_reachable.png"),
        save(plot_eta(run), target / f"{robot.name}_eta.png"),
    ]


def _replay(target: Path) -> tuple[Score, list[Path]]:
    """Record a drive as a real robot would, replay the log, and compare."""
    from trundle.view import plot_path, save

    encoder = Encoder(ticks_per_motor_turn=64, gear=43.7)
    robot = load("differential").with_wheels(encoder=encoder)
    run = simulate(robot, twist=_waves, duration=30.0, dt=0.02, pose=_START)
    log_file = write_log(robot, run, target / "log.csv", counter_bits=_COUNTER_BITS)
    log = read_log(log_file, robot, counter_bits=_COUNTER_BITS)
    assert log.truth is not None
    replayed = replay(robot, log, log.truth[0])
    figure = plot_path(robot, replayed, log.truth)
    return score(replayed.pose, log.truth), [log_file, save(figure, target / "replay.png")]


def _compare_and_derive(target: Path) -> tuple[dict[str, float], list[Path]]:
    """Leave the lectures' second part: controllers compared, and the equations derived."""
    from trundle.symbolic import document, render_html
    from trundle.view import plot_comparison, save

    robot = load("omni3").with_body(mass=30.0, inertia=0.1, com=(0.0, 0.0))
    path = circle(radius=3.0, rate=0.1)
    laws: dict[str, Controller] = {
        "PD": PD([120, 120, 0.4], [120, 120, 0.4]),
        "computed torque": ComputedTorque([4] * 3, [4] * 3),
    }
    runs = {
        name: track(robot, path, law, duration=60.0, dt=0.1, method="lecture")
        for name, law in laws.items()
    }
    page = target / "omni3_derived.html"
    write(page, render_html(document(robot, steps=True)))
    files = [save(plot_comparison(robot, runs), target / "tracking.png"), page]
    errors = {name: run.error for name, run in runs.items() if run.error is not None}
    return {name: float(abs(error[:, 0]).max()) for name, error in errors.items()}, files
