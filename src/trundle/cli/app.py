"""The command's entry: its sub-commands, and how mistakes are told."""

from __future__ import annotations

import os
from importlib import metadata
from typing import Annotated

import typer
from rich.text import Text

from trundle.cli import (
    derive,
    describe,
    export,
    files,
    maps,
    replay,
    rollout,
    showcase,
    simulation,
    teleop,
    tracking,
)
from trundle.cli.numbers import NumbersCommand
from trundle.cli.output import err
from trundle.errors import TrundleError

app = typer.Typer(
    name="trundle",
    no_args_is_help=True,
    invoke_without_command=True,
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help=(
        "Wheeled mobile robots, described by their wheels.\n\n"
        "ROBOT is a name of the catalogue (`trundle catalog`) or a TOML file "
        "(`trundle init` writes one to start from). Lengths are metres, angles radians unless "
        "an option ends in `-deg`; VX is forward, VY left, WZ counter-clockwise.\n\n"
        "Start with `trundle show omni3` and `trundle demo`."
    ),
)


@app.callback()
def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        print(metadata.version("trundle"))
        raise typer.Exit


for command in (
    files.catalog,
    describe.show,
    describe.check,
    files.init,
    maps.forward,
    maps.inverse,
    simulation.simulate,
    rollout.rollout,
    tracking.track,
    derive.derive,
    export.export,
    replay.odometry,
    teleop.teleop,
    showcase.demo,
):
    app.command(cls=NumbersCommand)(command)


def run(args: list[str] | None = None) -> int:
    """Run the command and return its exit code."""
    try:
        app(args=args, standalone_mode=True)
    except TrundleError as error:
        err.print(Text.assemble(("error: ", "bold red"), str(error)))
        return 2
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except Exception as error:
        if os.environ.get("TRUNDLE_DEBUG"):
            raise
        err.print(
            Text.assemble(
                ("This is a fault of trundle, not yours: ", "bold red"),
                f"{type(error).__name__}: {error}\n"
                "Please report it with the command that you gave; TRUNDLE_DEBUG=1 shows where.",
            )
        )
        return 1
    return 0
