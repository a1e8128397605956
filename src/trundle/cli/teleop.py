"""``trundle teleop``: a simulated robot driven from the keyboard."""

from __future__ import annotations

import errno
import math
import os
import shlex
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated

import numpy as np
import typer

from trundle.bridge import Bridge, SimulatedRobot
from trundle.cli import options
from trundle.cli.driving import MOVES, QUIT, STOP, Desk, Hand
from trundle.cli.keys import Clock, keyboard
from trundle.cli.live import Dashboard, Shown, screen
from trundle.cli.numbers import number, positive
from trundle.cli.output import folder, out, print_json, sentence, table, told_files, verbatim
from trundle.cli.play import play, script_of, unheard
from trundle.errors import FileError, TrundleError
from trundle.kinematics import Kinematics
from trundle.odometry import score, write_columns
from trundle.robot import Encoder, Robot

# Speed at which keys drive at first [m/s]; what turns does so as fast at the outermost wheel, or
# half a metre out on robots that are smaller.
_SPEED, _LEAST_ARM = 0.5, 0.5
# Pictures in a second; more would be noise to the eye and work for the terminal.
_PICTURES = 12.0
# Ramps go on over at most a tenth of a second; more than 500 Hz no terminal gives.
_RATES = (10.0, 500.0)
_FILES = ("run.csv", "log.csv", "path.png")
_GONE = (errno.EIO, errno.EBADF, errno.EPIPE, errno.ENXIO)
_HANGUP = 1
# Signals after the first for which a program that should end may be waiting for its terminal.
_DEAF = 2


def teleop(
    robot: options.RobotName,
    keys: Annotated[
        str | None,
        typer.Option(
            "--play",
            metavar='"KEY:S ..."',
            help='Keys and how long each is held, as "i:2 l:1", instead of the keyboard and the '
            "live view; it takes no time.",
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", parser=positive, metavar="M/S", help="Speed of the keys.")
    ] = _SPEED,
    timeout: Annotated[
        float,
        typer.Option(
            "--timeout",
            parser=positive,
            metavar="S",
            help="Without a key for so long, the robot brakes; longer than the keyboard waits "
            "before a held key repeats.",
        ),
    ] = 0.7,
    max_speed: Annotated[
        float, typer.Option("--max-speed", parser=positive, metavar="M/S", help="Largest speed.")
    ] = 1.0,
    max_acceleration: Annotated[
        float,
        typer.Option(
            "--max-acceleration", parser=positive, metavar="M/S^2", help="Largest acceleration."
        ),
    ] = 1.0,
    max_deceleration: Annotated[
        float,
        typer.Option(
            "--max-deceleration", parser=positive, metavar="M/S^2", help="Largest braking."
        ),
    ] = 2.0,
    rate: Annotated[
        float, typer.Option("--rate", parser=positive, metavar="HZ", help="Cycles in a second.")
    ] = 50.0,
    slip: Annotated[
        list[str] | None,
        typer.Option(
            "--slip",
            metavar="WHEEL=SHARE",
            help="Let a wheel spin without moving the robot: by 0.2 of its turn, say. Below 0 it "
            "drags: it turns less than the floor passes.",
        ),
    ] = None,
    ticks_per_turn: Annotated[
        float,
        typer.Option(
            "--ticks-per-turn",
            parser=positive,
            metavar="TICKS",
            help="Of encoders that the robot file does not have.",
        ),
    ] = 2048.0,
    sizes: options.Sizes = None,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Drive a simulated robot from the keyboard; --out leaves the run, a log and a picture.

    Hold a key to drive, let go to stop:

    * `i` `,` or up and down: ahead and back
    * `j` `l` or left and right: turn
    * `u` `o` `m` `.`: arcs, ahead and back
    * `J` `L`: sideways, with `U` `O` `M` `>` between, on robots that can
    * `w` `a` `s` `d` and `q` `e`: ahead, back, turn and sideways for the left hand
    * space: stop; `+` `-`: faster and slower; `x`: quit

    Commands go through `trundle.Bridge`: limits on speed and acceleration, wheel speeds, encoder
    counts, odometry. The robot behind it is simulated: motors lag, wheels and floor are uneven,
    counters count whole ticks. The limits on yaw follow from those on speed.

    Example: `trundle teleop mecanum --out drive`

    Example without a keyboard: `trundle teleop mecanum --play "i:2 o:1.5 J:1" --out drive`
    """
    made = options.robot_of(robot, sizes)
    if not _RATES[0] <= rate <= _RATES[1]:
        raise TrundleError(f"--rate takes {_RATES[0]:g} to {_RATES[1]:g} Hz, got {rate:g}")
    script = None if keys is None else script_of(keys)
    if script is None:
        _check_terminal()
    target = _fresh(out_dir)
    encoder = Encoder(ticks_per_motor_turn=ticks_per_turn)
    arm = max(made.reach, _LEAST_ARM)
    bridge = Bridge(
        made,
        timeout=timeout,
        encoder=encoder,
        max_speed=max_speed,
        max_acceleration=max_acceleration,
        max_deceleration=max_deceleration,
        max_yaw_rate=max_speed / arm,
        max_yaw_acceleration=max_acceleration / arm,
        max_yaw_deceleration=max_deceleration / arm,
    )
    desk = Desk(bridge, SimulatedRobot(made, encoder=encoder, slip=_slips(slip)))
    notes, speed = _capped(speed, max_speed)
    hand = Hand(speed=speed, turn=speed / arm, timeout=timeout, most=max_speed / speed)
    ended = 0
    with ExitStack() as deaf:  # from a drive by hand to its files, signals are only noted
        if script is not None:
            play(desk, hand, script, 1.0 / rate)
            notes += unheard(made, hand, script)
        else:
            full = _full(made, max_speed, max_speed / arm)
            view = Dashboard(made, full, encoder, out.options.ascii_only)
            came = deaf.enter_context(_signals([]))
            ended = _drive(desk, hand, view, 1.0 / rate, notes, came)
        files = _leave(desk, target, encoder) if target else []
    files += _picture(desk, target) if target else []
    if ended != _HANGUP:
        _tell(desk, files, robot, encoder, notes, as_json)
    if ended:
        raise typer.Exit(128 + ended)


def _capped(speed: float, most: float) -> tuple[list[str], float]:
    """Return the speed of the keys [m/s], and a note where it is not what was asked."""
    if speed <= most:
        return [], speed
    note = f"--speed {speed:g} is beyond --max-speed: keys drive at {most:g} m/s"
    return [note], most


# ---- by hand --------------------------------------------------------------------------------


def _check_terminal() -> None:
    if not (sys.stdin.isatty() and sys.stdout.isatty()) or out.is_dumb_terminal:
        raise TrundleError(
            "teleop reads the keyboard and draws on the terminal, and there is none here: run it "
            'in a terminal, or give the keys as --play "i:2 l:1"'
        )


def _drive(
    desk: Desk, hand: Hand, view: Dashboard, period: float, notes: list[str], ended: list[int]
) -> int:
    """Drive until a key or a signal ends it, and return the signal's number, or 0."""
    for note in notes:
        view.tell(note, 0.0)
    # A terminal that has gone, or that takes nothing any more, is no reason to lose the drive.
    try:
        with _signals(ended, patience=_DEAF), ExitStack() as terminal:
            _cycles(desk, hand, view, Clock(period), terminal, ended)
    except KeyboardInterrupt:
        pass
    except (EOFError, OSError) as error:
        if isinstance(error, OSError) and error.errno not in _GONE:
            raise
        return _HANGUP
    return 0 if not ended or ended[0] == signal.SIGINT else ended[0]


def _cycles(
    desk: Desk, hand: Hand, view: Dashboard, clock: Clock, terminal: ExitStack, ended: list[int]
) -> None:
    shown, keys = terminal.enter_context(screen(out)), terminal.enter_context(keyboard())
    draw_at = 0.0
    while not ended:
        pressed = clock.wait(keys)
        if any(key in QUIT for key in pressed):
            return
        if "suspend" in pressed and hasattr(signal, "SIGTSTP"):
            terminal.close()
            os.killpg(os.getpgrp(), signal.SIGTSTP)  # goes on from here when it is resumed
            shown, keys = terminal.enter_context(screen(out)), terminal.enter_context(keyboard())
        now = clock.time()
        command = None
        for key in pressed:
            hand = hand.press(key, now)
            view.tell(view.idle(key), now)
            command = hand.command if key in MOVES else command
        if hand.let_go(now):
            hand, command = hand.released(), STOP
        output = desk.cycle(now, command)
        view.note(output, now)
        if now >= draw_at:
            draw_at = now + 1.0 / _PICTURES
            size = shown.size
            moment = Shown(output, desk.state, desk.truth, hand, clock.rate)
            shown.draw(view.lines(moment, *size), size)


@contextmanager
def _signals(came: list[int], patience: float = math.inf) -> Iterator[list[int]]:
    """Note the signals that should end the program in a list, and give the list.

    Args:
        came: the list.
        patience: with more signals than that, the program is interrupted all the same.
    """

    def note(number: int, _: FrameType | None) -> None:
        came.append(number)
        if len(came) > patience:
            raise KeyboardInterrupt

    names = ("SIGINT", "SIGTERM", "SIGHUP")
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = [(each, signal.signal(each, note)) for each in numbers]
    try:
        yield came
    finally:
        for each, handler in before:
            signal.signal(each, handler)


def _full(robot: Robot, max_speed: float, max_yaw_rate: float) -> list[float]:
    """Return the wheel speeds of full bars [rad/s]: the limits, or what the largest twists ask."""
    ahead, sideways = [max_speed, 0.0, 0.0], [0.0, max_speed, 0.0]
    twists = [ahead, sideways, [0.0, 0.0, max_yaw_rate], [max_speed, 0.0, max_yaw_rate]]
    asked = np.abs(Kinematics(robot).inverse(twists, limit=False).wheel_speeds)
    fastest = float(asked.max(initial=0.0)) or 1.0  # one scale, so that bars can be compared
    return [wheel.max_speed or fastest for wheel in robot.driven]


# ---- what is left ---------------------------------------------------------------------------


def _fresh(path: Path | None) -> Path | None:
    """Return the output folder, made if need be; it must not hold another drive."""
    if path is not None and (there := [name for name in _FILES if os.path.lexists(path / name)]):
        raise FileError(
            f"{path}: {there[0]} is there already, and a drive is not overwritten: name another "
            "folder, or move it away"
        )
    return folder(path)


def _slips(items: list[str] | None) -> dict[str, float]:
    slips = {}
    for item in items or []:
        name, equals, share = item.rpartition("=")
        if not equals:
            raise TrundleError(f"--slip needs WHEEL=SHARE, such as left=0.2, got {item!r}")
        slips[name.strip()] = number(share)
    return slips


def _leave(desk: Desk, target: Path, encoder: Encoder) -> list[Path]:
    """Write the run by odometry and the log of the sensors."""
    run, _ = desk.run()
    return [
        run.save(target / "run.csv"),
        write_columns(target / "log.csv", desk.log(encoder)),
    ]


def _picture(desk: Desk, target: Path) -> list[Path]:
    """Write the picture of the run by odometry and the true path; an interrupt leaves it out."""
    try:
        from trundle.view import plot_path, save

        return [save(plot_path(desk.bridge.robot, *desk.run()), target / "path.png")]
    except KeyboardInterrupt:
        return []


def _tell(
    desk: Desk, files: list[Path], name: str, encoder: Encoder, notes: list[str], as_json: bool
) -> None:
    """Print where the robot is, and how far odometry is off."""
    output, time = desk.output, desk.state.time
    run, truth = desk.run()
    error = score(run.pose, truth)
    sigma = [math.sqrt(max(row[i], 0.0)) for i, row in enumerate(output.covariance)]
    slipped = sorted(desk.slipped)
    if as_json:
        print_json(
            {
                "duration": time,
                "distance": error.distance,
                "pose": output.pose,
                "truth": desk.truth,
                "sigma": sigma,
                "slipping": slipped,
                "refused": [desk.state.refused, desk.state.refused_counts],
                "notes": notes,
                "files": files,
            }
        )
        return
    told = {"odometry": output.pose, "true": desk.truth, "1 sigma": sigma}
    rows = [[what, *(f"{value:.4f}" for value in values)] for what, values in told.items()]
    table(["where it is", "x [m]", "y [m]", "psi [rad]"], rows)
    sentence(
        f"{error.distance:.3g} m driven in {time:.3g} s; odometry is "
        f"{1000 * error.end_error:.3g} mm and {math.degrees(abs(error.end_heading_error)):.2g} deg "
        "off"
    )
    if any(wheel.encoder is None for wheel in desk.bridge.robot.sensed):
        ticks = f"{encoder.ticks_per_motor_turn:g}"
        sentence((f"encoders of {ticks} ticks a turn stand in: the robot file has none", "dim"))
    if slipped:
        notes = [*notes, f"the wheels did not agree: {', '.join(slipped)}"]
    for note in notes:
        sentence(("note", "yellow"), f"  {note}")
    told_files(files)
    if files:
        again = shlex.join(["trundle", "odometry", name, str(files[1])])
        verbatim(again, "  drives the log again")
    else:
        sentence(("--out DIR leaves the run, a log and a picture there", "dim"))
