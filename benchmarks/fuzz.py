"""Robot files and command lines that nobody would write: trundle must refuse them in words.

    python benchmarks/fuzz.py --minutes 10

Files of the catalogue (TOML and URDF) and command lines of every sub-command are changed at random
and tried in this process. A defect is a traceback, an exit code other than 0 and 2, a case that
takes longer than its limit, or a file that is accepted wrongly: its robot has a number that is not
finite or not in range, or does not survive being saved and loaded. Of each defect the smallest
input that was found is printed. The same seed gives the same cases.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import io
import math
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import typer

import trundle
from trundle.cli.app import app, run
from trundle.exchange import urdf
from trundle.robot import CATALOG, Robot, RollingWheel, to_toml
from trundle.robot import save as save_robot

# A case does the work of milliseconds; a second more than covers a loaded machine.
FILE_LIMIT_S = 5.0
# Some commands simulate, draw or compile for half a minute, more on a machine that is busy.
COMMAND_LIMIT_S = 180.0
# Enough for any honest case, little enough that a dishonest one does not take the machine along.
MEMORY_BYTES = 6 * 2**30
SHRINK_S = 20.0

_NUMBERS = """
0 -0.0 1 -1 0.05 1e-300 5e-324 1e-9 1e9 1e154 1e155 1e308 -1e308 1e400 nan inf -inf 90 45 180 -45
89.999999999 360 1e16 0x10 1_000 1,5 1.5.2 --1 +1 .5 5. 1e 00 9223372036854775808
"""
NUMBERS = (*_NUMBERS.split(), "9" * 400)
_WORDS = r"""
true false on null none [] {} [[]] '' "" "x" 'a "*/" int __proto__ 2020-01-01 ../../x fixed steered
omni mecanum caster ball left right name kind wheel body radius x y heading_deg /dev/null . .. ~ -h
-- = omni3 swerve \ " ' # [ ] { } , < > & /> <joint> package://x 1 2 3 z continuous revolute
"""
WORDS = (
    *_WORDS.split(), "\n", "\r", "\t", "\x00", "\ud800", "\u202e", "🤖", "é", "\ufeff", "a" * 5000,
    " ", "",
)  # fmt: skip
LINES = (
    "[body]", "[[wheel]]", "[wheel]", "radius = -1", "x = nan", "driven = true", "driven = false",
    'kind = "steered"', 'steering_group = "g"', "steering_ratio = -0.5", "steering_min_deg = 10",
    "steering_max_deg = -10", "reversed = true", "skid = true", "track_factor = 2.0",
    "roller_deg = 45", "roller_deg = 90", "heading_deg = 1e300", "max_speed = 1e-320",
    "encoder = { ticks_per_motor_turn = 64, gear = 43.7 }", "encoder = {}", "measured = false",
    "mass = 1e308", "motor = { }", 'name = "int"', 'name = "../x"', "com = [0.1, 0.2]",
    "com = [nan, 0]", "a.b.c = 1", "x.y = 2", "trail = 1e-300", "inertia = 5",
)  # fmt: skip


class TooLong(BaseException):
    """A case took longer than its limit."""


class WrongError(Exception):
    """A file was accepted that should not have been."""


@contextlib.contextmanager
def limit(seconds: float) -> Iterator[None]:
    """End what runs inside after some seconds; a system without alarms waits."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def end(*_: object) -> None:
        raise TooLong(f"longer than {seconds:g} s")

    signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


@dataclass
class Defect:
    """One kind of failure, with the smallest input that showed it."""

    kind: str
    where: str
    case: Any
    count: int = 1
    told: str = ""


@dataclass
class Tally:
    """What has been tried, and what came of it."""

    cases: Counter[str] = field(default_factory=Counter)
    accepted: Counter[str] = field(default_factory=Counter)
    seconds: Counter[str] = field(default_factory=Counter)
    slowest: dict[str, float] = field(default_factory=dict)
    defects: dict[tuple[str, str], Defect] = field(default_factory=dict)


# ---- changed texts ---------------------------------------------------------------------------


def mutated(text: str, rng: random.Random, others: list[str]) -> str:
    """Return a text with a few changes, most of them small."""
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        text = rng.choice(CHANGES)(text, rng, others)
    return text


def _number(text: str, rng: random.Random, _: list[str]) -> str:
    return _replaced(text, rng, r"(?<![\w.])-?\d+(\.\d+)?(e[-+]?\d+)?", NUMBERS)


def _word(text: str, rng: random.Random, _: list[str]) -> str:
    return _replaced(text, rng, r"\"[^\"\n]*\"|\b[a-z_]+\b", WORDS)


def _replaced(text: str, rng: random.Random, pattern: str, values: list[str]) -> str:
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    spot = rng.choice(found)
    value = rng.choice(values)
    if spot[0].startswith('"') and rng.random() < 0.7:
        value = '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return text[: spot.start()] + value + text[spot.end() :]


def _line(text: str, rng: random.Random, others: list[str]) -> str:
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    do = rng.randrange(5)
    if do == 0:
        del lines[at]
    elif do == 1:
        lines.insert(at, rng.choice(lines))
    elif do == 2:
        lines.insert(at, rng.choice(LINES))
    elif do == 3:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines[at:at] = rng.choice(others).split("\n")[: rng.randrange(12)]
    return "\n".join(lines)


def _letter(text: str, rng: random.Random, _: list[str]) -> str:
    at = rng.randrange(len(text) + 1)
    do = rng.randrange(4)
    if do == 0:
        return text[:at] + text[at + rng.choice((1, 1, 2, 20)) :]
    if do == 1:
        return text[:at] + rng.choice(WORDS) + text[at:]
    if do == 2:
        return (
            text[:at]
            + chr(rng.choice((0, 9, 34, 39, 60, 62, 91, 128, 0x2028, 0x1F916)))
            + text[at:]
        )
    return text[:at] if rng.random() < 0.3 else text[:at] + text[at:][:1] * 2 + text[at + 1 :]


CHANGES: tuple[Callable[[str, random.Random, list[str]], str], ...] = (
    _number, _number, _number, _word, _word, _line, _line, _letter,
)  # fmt: skip


# ---- files -----------------------------------------------------------------------------------


def try_file(text: str, suffix: str) -> bool:
    """Load a file and look at the robot; return whether it was accepted."""
    path = Path(f"case{suffix}")
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with limit(FILE_LIMIT_S):
        try:
            robot = trundle.load(path)
        except trundle.TrundleError as error:
            if not str(error).strip():
                raise WrongError("refused without a word") from None
            return False
        look_at(robot)
    return True


def look_at(robot: Robot) -> None:
    """Raise WrongError where a robot that was accepted should not have been."""
    for owner, name, value in numbers_of(robot):
        if not math.isfinite(value):
            raise WrongError(f"{owner}.{name} is {value}")
    for wheel in robot.wheels:
        if isinstance(wheel, RollingWheel) and not wheel.radius > 0:
            raise WrongError(f"radius {wheel.radius}")
        if wheel.mass < 0:
            raise WrongError(f"mass {wheel.mass}")
    if len({wheel.name for wheel in robot.wheels}) != len(robot.wheels):
        raise WrongError("two wheels of one name")
    if trundle.load(save_robot(robot, "again.toml")) != robot:
        raise WrongError("saved and loaded, it is another robot")


def numbers_of(item: Any, owner: str = "robot") -> Iterator[tuple[str, str, float]]:
    """Yield every number of a description, with what it belongs to."""
    for each in dataclasses.fields(item):
        value = getattr(item, each.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, float | int):
                yield owner, each.name, float(part)
            elif dataclasses.is_dataclass(part):
                yield from numbers_of(part, getattr(part, "name", each.name))


# ---- command lines ---------------------------------------------------------------------------


def commands() -> dict[str, list[Any]]:
    """Return each sub-command's parameters, as the command itself knows them."""
    group = typer.main.get_command(app)
    # Both run for long by design; teleop waits for keys.
    return {n: c.params for n, c in group.commands.items() if n not in ("demo", "teleop")}  # type: ignore[attr-defined]


def argument(rng: random.Random) -> str:
    """Return a value for an argument or an option."""
    kind = rng.randrange(10)
    if kind < 4:
        return rng.choice(("0", "0.5", "-1", "1", "2", "1e-3", "-.2", *NUMBERS))
    if kind < 6:
        return rng.choice((*CATALOG, "case.toml", "case.urdf", *CSV, "no.toml", "."))
    if kind < 8:
        sizes = ("radius", "track", "wheelbase", "arm", "track_factor", "angles", "bogus", "")
        return f"{rng.choice(sizes)}{rng.choice('==:')}{rng.choice((*NUMBERS, *WORDS))}"
    return rng.choice(WORDS)


# Command lines that end well, to change; ROBOT becomes a robot of the catalogue or a file.
GOOD = """
show ROBOT --explain
show ackermann --steering-deg 18.4 15.6 --explain --json
show ROBOT --out pictures
check ROBOT matrix.csv
init new.toml --like mecanum --set track=0.25 --schema
forward ROBOT 0 -0.5 0.5
forward omni3 0 -0.5 0.5 --json
inverse ROBOT 0.2 0.1 0.3
inverse tricycle 0.2 0 0.3 --steering-deg 10
simulate ROBOT --twist 0.1 0 0.2 --duration 1 --dt 0.1 --animation none
simulate omni3 --wheel-speeds 0 -0.5 0.5 --pose 0.5 0.5 0.785 --duration 1 --method euler --json
simulate differential --commands speeds.csv
rollout ROBOT --twist 0.1 0 0.2 --robots 10 --duration 1 --noise 0.1 --vary radius=1% --seed 3
rollout mecanum --wheel-speeds 1 1 1 1 --robots 5 --duration 1 --vary left.radius=1% --dtype float32
track ROBOT --duration 1 --animation none --dt 0.02
track omni3 --path eight --controller pd --kp 1 2 3 --kd 1 1 1 --duration 1 --pose 0 0 1 --json
track omni3 --path via --mass 30 --inertia 0.1 --com 0 0 --model-mass 20 --duration 1 --method rk4
derive differential --what kinematics --format c
derive ROBOT --what kinematics --format text
odometry differential log.csv
odometry case.toml log.csv --columns time,ticks:left,ticks:right --counter-bits 16 --pose 0 0 1
odometry differential log.csv --map radians:left=ticks:left --map radians:right=ticks:right --json
export ROBOT --to c --max-speed 1 --max-acceleration 0.5 --timeout 0.2 --out fw --force
export ROBOT --to ros2_controllers
export differential --to ros2_controllers --max-speed 1 --max-acceleration 1 --max-deceleration 2
export ROBOT --to urdf --set radius=0.1
export case.toml --to urdf --json
catalog --json
"""
CSV = {
    "log.csv": "time,ticks:left,ticks:right\n0,0,0\n0.1,3,4\n0.2,7,9\n",
    "matrix.csv": "0.025,0.025\n0,0\n-0.125,0.125\n",
    "speeds.csv": "left,right\n1,2\n2,1\n0,0\n",
}


def command_line(rng: random.Random, known: dict[str, list[Any]]) -> list[str]:
    """Return a command line that is nearly right."""
    if rng.random() < 0.7:
        line = rng.choice(GOOD.strip().split("\n")).split()
        line = [robot(rng) if part == "ROBOT" else part for part in line]
    else:
        line = from_parameters(rng, known)
    for _ in range(rng.choice((0, 1, 1, 2, 4))):
        at = rng.randrange(len(line) + 1)
        do = rng.randrange(6)
        if do == 0:
            line[at:at] = [argument(rng)]
        elif do == 1:
            line[at : at + 1] = []
        elif do == 2 and line[:1] and line[0] in known:
            line[at:at] = option(rng, rng.choice(known[line[0]]))
        elif at:
            line[at : at + 1] = [argument(rng)]
    return tamed(line)


def robot(rng: random.Random) -> str:
    return rng.choice((*CATALOG, *["case.toml"] * 9, *["case.urdf"] * 5))


def from_parameters(rng: random.Random, known: dict[str, list[Any]]) -> list[str]:
    """Return a command line made of what the sub-command says that it takes."""
    name = rng.choice((*known, "nosuch"))
    line = [name]
    for parameter in known.get(name, []):
        if parameter.param_type_name == "option":
            line += option(rng, parameter) if rng.random() < 2.2 / len(known[name]) else []
        elif "robot" in str(parameter.name):
            line.append(robot(rng))
        else:
            line += [argument(rng) for _ in range(max(parameter.nargs, 1))]
    return line


def option(rng: random.Random, parameter: Any) -> list[str]:
    """Return an option with values."""
    if parameter.param_type_name != "option" or parameter.is_flag:
        return [rng.choice(parameter.opts)]
    return [rng.choice(parameter.opts), *(argument(rng) for _ in range(max(parameter.nargs, 1)))]


def tamed(line: list[str]) -> list[str]:
    """Keep every file that is written in this folder, and pictures of the catalogue away."""
    if line[:1] == ["catalog"]:
        line = [part for part in line if part != "--out"]
    return [part.lstrip("/~").replace("\0", "") if part[:1] in "/~" else part for part in line]


def try_command(line: list[str]) -> bool:
    """Run a command line; return whether it ended well."""
    told, erred = io.StringIO(), io.StringIO()
    with (
        limit(COMMAND_LIMIT_S),
        contextlib.redirect_stdout(told),
        contextlib.redirect_stderr(erred),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        code = run(list(line))
    if code not in (0, 2):
        raise WrongError(f"exit code {code}")
    if "Traceback" in erred.getvalue() + told.getvalue():
        raise WrongError("a traceback was printed")
    if "--json" in line and code == 0 and re.search(r"\b(NaN|Infinity)\b", told.getvalue()):
        raise WrongError("JSON that is none")
    return code == 0


# ---- looking for defects ---------------------------------------------------------------------


def attempt(tally: Tally, kind: str, case: Any, trial: Callable[[Any], bool]) -> None:
    """Try one case, and keep what it shows."""
    start = time.perf_counter()
    found = failure(case, trial)
    took = time.perf_counter() - start
    tally.cases[kind] += 1
    tally.seconds[kind] += took  # type: ignore[assignment]
    tally.slowest[kind] = max(took, tally.slowest.get(kind, 0.0))
    if isinstance(found, bool):
        tally.accepted[kind] += found
        return
    where, told = found
    known = tally.defects.get((kind, where))
    if known is None:
        small = shrunk(case, where, trial) if "TooLong" not in where else case
        tally.defects[kind, where] = Defect(kind, where, small, told=told + files_of(small))
        print(f"  {kind}: {where}\n    {small!r}"[:1500], file=sys.stderr, flush=True)
    else:
        known.count += 1


def files_of(case: Any) -> str:
    """Return the files that a command line names, as they are."""
    inputs = (Path(part) for part in case if part in ("case.toml", "case.urdf", *CSV))
    named = [path for path in inputs if isinstance(case, list) and path.is_file()]
    return "".join(f"\n  {path}: {path.read_bytes()[:1500]!r}" for path in named)


def failure(case: Any, trial: Callable[[Any], bool]) -> bool | tuple[str, str]:
    """Return whether the case was accepted, or where it failed and how."""
    try:
        return trial(case)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 - any failure is what is looked for
        frames = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in frames if f"{os.sep}trundle{os.sep}" in frame.filename]
        spot = "" if isinstance(error, WrongError) else _spot(ours)
        text = (
            re.sub(r"[-+]?\d[\d.e+-]*", "N", str(error))[:80]
            if isinstance(error, WrongError)
            else ""
        )
        return f"{type(error).__name__} {spot}{text}", f"{type(error).__name__}: {error}"[:300]


def _spot(frames: list[traceback.FrameSummary]) -> str:
    if not frames:
        return "outside trundle"
    last = frames[-1]
    return f"{last.filename.rpartition(f'{os.sep}trundle{os.sep}')[2]}:{last.lineno}"


def shrunk(case: Any, where: str, trial: Callable[[Any], bool]) -> Any:
    """Return a smaller case that fails in the same place."""
    parts = list(case) if isinstance(case, list) else case.split("\n")
    back: Callable[[list[str]], Any] = list if isinstance(case, list) else "\n".join
    end = time.perf_counter() + SHRINK_S
    size = max(len(parts) // 2, 1)
    while time.perf_counter() < end:
        smaller = False
        for at in range(0, len(parts), size):
            fewer = parts[:at] + parts[at + size :]
            if fewer and time.perf_counter() < end and _same(back(fewer), where, trial):
                parts, smaller = fewer, True
                break
        if not smaller:
            if size == 1:
                break
            size //= 2
    return back(parts)


def _same(case: Any, where: str, trial: Callable[[Any], bool]) -> bool:
    found = failure(case, trial)
    return not isinstance(found, bool) and found[0] == where


def seeds() -> dict[str, list[str]]:
    """Return the texts to start from, by the suffix of their files."""
    robots = [trundle.load(name) for name in CATALOG]
    return {".toml": [to_toml(r) for r in robots], ".urdf": [urdf(r) for r in robots]}


# Shares of the time.
SHARES = {"toml": 0.3, "urdf": 0.2, "command": 0.5}


def fuzz(minutes: float, seed: int, only: str | None = None) -> Tally:
    """Try cases for some minutes."""
    rng, tally = random.Random(seed), Tally()
    texts, known = seeds(), commands()
    spent = dict.fromkeys(SHARES, 0.0)
    end = time.perf_counter() + 60 * minutes
    while time.perf_counter() < end:
        which = only or min(spent, key=lambda each: spent[each] / SHARES[each])
        start = time.perf_counter()
        if which == "command":
            for suffix in (".toml", ".urdf"):
                text = rng.choice(texts[suffix])
                text = mutated(text, rng, texts[suffix]) if rng.random() < 0.3 else text
                Path(f"case{suffix}").write_bytes(text.encode("utf-8", "surrogatepass"))
            for name, text in CSV.items():
                text = mutated(text, rng, list(CSV.values())) if rng.random() < 0.3 else text
                Path(name).write_bytes(text.encode("utf-8", "surrogatepass"))
            line = command_line(rng, known)
            name = line[0] if line and line[0] in known else "(other)"
            attempt(tally, f"trundle {name}", line, try_command)
            tidy()
        else:
            suffix = f".{which}"
            text = mutated(rng.choice(texts[suffix]), rng, texts[suffix])
            attempt(tally, which.upper(), text, lambda case, s=suffix: try_file(case, s))
        spent[which] += time.perf_counter() - start
    return tally


def tidy() -> None:
    """Remove what a command wrote, but the inputs of the next."""
    for path in Path().iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink()


def report(tally: Tally, seed: int) -> None:
    """Print the tables."""
    print(f"trundle on inputs that are changed at random, seed {seed}\n")
    print("| input of trundle | cases | accepted | slowest [s] | defects |")
    print("| --- | --- | --- | --- | --- |")
    for kind in sorted(tally.cases):
        count = sum(1 for defect in tally.defects.values() if defect.kind == kind)
        print(
            f"| {kind} | {tally.cases[kind]:,} | {tally.accepted[kind]:,} "
            f"| {tally.slowest[kind]:.2f} | {count} |"
        )
    total = sum(tally.cases.values())
    print(f"\n{total:,} cases in {sum(tally.seconds.values()):.0f} s, {len(tally.defects)} defects")
    for defect in tally.defects.values():
        print(f"\n{defect.kind}: {defect.where} ({defect.count} times)\n  {defect.told}")
        print(f"  smallest input: {defect.case!r}"[:3000])


def limit_memory() -> None:
    """Let no case take the machine's memory, where the system can be asked for that."""
    with contextlib.suppress(ImportError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=("toml", "urdf", "command"))
    parser.add_argument("--smoke", action="store_true", help="a few seconds, to see that it runs")
    given = parser.parse_args()
    os.environ["TRUNDLE_DEBUG"] = "1"
    os.environ["MPLBACKEND"] = "Agg"
    limit_memory()
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        deep = Path(folder, *"abcdef")  # for paths that go up
        deep.mkdir(parents=True)
        os.chdir(deep)
        try:
            tally = fuzz(0.05 if given.smoke else given.minutes, given.seed, given.only)
        finally:
            os.chdir(home)
    report(tally, given.seed)
    return bool(tally.defects) and not given.smoke


if __name__ == "__main__":
    sys.exit(main())
