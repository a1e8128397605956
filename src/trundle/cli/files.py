"""``trundle catalog`` and ``trundle init``: robots to start from."""

from __future__ import annotations

import inspect
import json
import os
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from trundle.cli import options
from trundle.cli.output import folder, out, print_json, progress, table, told_files
from trundle.errors import FileError, did_you_mean
from trundle.kinematics import mobility
from trundle.robot import CATALOG, json_schema, load, save, to_toml

_SCHEMA = "robot.schema.json"


def catalog(out_dir: options.Out = None, as_json: options.Json = False) -> None:
    """List the robots of the catalogue; --out leaves a picture of each.

    Example: `trundle catalog`
    """
    files = _draw_all(folder(out_dir), as_json)
    if as_json:
        print_json(list(CATALOG))
        return
    rows = []
    for name, make in CATALOG.items():
        sizes = ", ".join(
            f"{key}={item.default:g}" if isinstance(item.default, float) else key
            for key, item in inspect.signature(make).parameters.items()
        )
        first = (inspect.getdoc(make) or "").splitlines()[0].rstrip(".")
        rows += [[name, mobility(load(name)).kind, first], ["", "", f"[{sizes}]"]]
    table(["name", "class", "what it is [sizes, changed with --set]"], rows, left=3)
    out.print()
    out.print(Text("trundle show NAME explains a robot; trundle init --like NAME copies it."))
    told_files(files)


def _draw_all(target: Path | None, quiet: bool) -> list[Path]:
    if target is None:
        return []
    from trundle.view import plot_layout, save

    with progress(quiet) as bar:
        return [
            save(plot_layout(load(name)), target / f"{name}.png")
            for name in bar.track(CATALOG, description="drawing the robots")
        ]


def init(
    path: Annotated[Path, typer.Argument(metavar="[FILE]", help="The file to write.")] = Path(
        "robot.toml"
    ),
    like: Annotated[
        str, typer.Option("--like", metavar="NAME", help="The catalogue robot to start from.")
    ] = "differential",
    sizes: options.Sizes = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    schema: Annotated[
        bool, typer.Option("--schema", help=f"Write {_SCHEMA} beside it, for editors.")
    ] = False,
    out_dir: options.Out = None,
    as_json: options.Json = False,
) -> None:
    """Write a robot file to start from.

    Example: `trundle init my_robot.toml --like mecanum --set track=0.25 --schema`
    """
    target = folder(out_dir)
    path = target / path if target else path
    if like not in CATALOG:
        raise FileError(
            f"--like takes a catalogue name: {', '.join(CATALOG)}; got {like!r}"
            f"{did_you_mean(like, CATALOG)}"
        )
    if os.path.lexists(path) and not force:
        raise FileError(f"{path} is there already: choose another name, or --force to overwrite it")
    robot = options.robot_of(like, sizes)
    written = [save(robot, path)]
    if schema:
        written.append(_write_schema(path))
    if as_json:
        print_json({"files": written, "robot": to_toml(robot)})
        return
    for file in written:
        out.print(Text(f"wrote {file}"))
    out.print(Text(f"Edit it, then look at it: trundle show {path}"))


def _write_schema(path: Path) -> Path:
    """Write the schema beside a robot file, and the line by which editors find it."""
    target = path.with_name(_SCHEMA)
    try:
        target.write_text(json.dumps(json_schema(), indent=2) + "\n", encoding="utf-8")
        path.write_text(f"#:schema ./{_SCHEMA}\n" + path.read_text(encoding="utf-8"), "utf-8")
    except OSError as error:
        raise FileError(f"{target}: cannot be written: {error.strerror or error}") from None
    return target
