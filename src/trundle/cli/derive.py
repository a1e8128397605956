"""``trundle derive``: a robot's equations, derived step by step."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from trundle.cli import options
from trundle.cli.output import folder, out, print_json, write
from trundle.errors import TrundleError, did_you_mean
from trundle.robot import Robot
from trundle.se2 import Array

# Formats, and the suffix of their files; the last two are printed code.
_SUFFIXES = {"text": ".txt", "latex": ".tex", "html": ".html", "numpy": ".py", "c": ".c"}
_CODE = ("numpy", "c")
_TOPICS = ("kinematics", "pseudo-inverse", "dynamics")


def derive(
    robot: options.RobotName,
    what: Annotated[
        str | None,
        typer.Option("--what", help=f"{', '.join(_TOPICS)}; all of them by default."),
    ] = None,
    steps: Annotated[
        bool, typer.Option("--steps", help="Show every intermediate step, not the results only.")
    ] = False,
    form: Annotated[
        str | None,
        typer.Option(
            "--format",
            help="text, latex or html; numpy or c for the code of W, M and n. "
            "By default what the suffix of --out says, else text.",
        ),
    ] = None,
    steering_deg: options.SteeringDeg = None,
    sizes: options.Sizes = None,
    out_path: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="PATH", help="File to write, or folder for it; made if need be."
        ),
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Derive a robot's equations, in symbols and with its numbers, as a document to follow.

    Kinematics from the wheels' rows to W; the lectures' pseudo-inverses; dynamics from the
    Denavit-Hartenberg table to M, n and the wheel torques.

    Example: `trundle derive omni3 --what kinematics --steps --out omni3.html`
    """
    chosen = _format(form, out_path)
    if what is not None and what not in _TOPICS:
        raise TrundleError(
            f"--what takes {', '.join(_TOPICS)}, got {what!r}{did_you_mean(what, _TOPICS)}"
        )
    if chosen in _CODE and (steps or steering_deg):
        option = "--steps" if steps else "--steering-deg"
        raise TrundleError(f"{option} belongs to documents, not to --format {chosen}")
    made = options.robot_of(robot, sizes)
    angles = options.steering_of(made, steering_deg)
    file = _file(out_path, chosen)
    text = _written(made, what, steps, chosen, angles)
    if file is not None:
        write(file, text)
    if as_json:
        files = [] if file is None else [file]
        print_json(
            {"name": made.name, "format": chosen, "files": files, "text": None if file else text}
        )
    elif file is not None:
        out.print(Text(f"wrote {file}"))
    else:
        print(text)


def _format(form: str | None, out_path: Path | None) -> str:
    """Return the format that --format or the suffix of --out names; they must not differ."""
    if form is not None and form not in _SUFFIXES:
        raise TrundleError(
            f"--format takes {', '.join(_SUFFIXES)}, got {form!r}{did_you_mean(form, _SUFFIXES)}"
        )
    suffix = "" if out_path is None or out_path.is_dir() else out_path.suffix.lower()
    named = next((name for name, known in _SUFFIXES.items() if known == suffix), None)
    if suffix and (named is None or form not in (None, named)):
        wanted = ", ".join(f"{known} for {name}" for name, known in _SUFFIXES.items())
        raise TrundleError(f"--out {out_path}: the suffix must be {wanted}")
    return form or named or "text"


def _file(out_path: Path | None, form: str) -> Path | None:
    """Return the file to write: the one that is named, or derive.* in the folder that is."""
    if out_path is None:
        return None
    if out_path.is_dir() or not out_path.suffix:
        target = folder(out_path)
        assert target is not None
        return target / f"derive{_SUFFIXES[form]}"
    folder(out_path.parent)
    return out_path


def _written(robot: Robot, what: str | None, steps: bool, form: str, steering: Array | None) -> str:
    # Loaded when used: sympy takes its time, and no other command needs it.
    from trundle.symbolic import code, document, render_html, render_latex, render_text

    if form in _CODE:
        return code(robot, form, what)
    made = document(robot, what, steps, steering)
    render = {"text": render_text, "latex": render_latex, "html": render_html}[form]
    return render(made)
