"""Compilers, emulators and numbers for the tests of firmware.

A firmware folder is compiled together with ``tests/firmware/harness.c`` and a ``vectors.h`` for one
target, run there, and what the harness wrote is read back bit by bit.
"""

from __future__ import annotations

import re
import shutil
import struct
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

HERE = Path(__file__).parent / "firmware"
WARNINGS = (
    "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wdouble-promotion",
    "-Wshadow", "-Wundef", "-Wstrict-prototypes", "-Wmissing-prototypes",
)  # fmt: skip
# A program that hangs fails; those that end take a tenth of a second.
SECONDS = 60
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LINE = re.compile(r"^([0-9a-f]{2,16})\W*$")


@dataclass(frozen=True)
class Target:
    """Where firmware runs: its compiler, flags and more sources, and the command that runs it.

    Attributes:
        compiler: the compiler's command.
        flags: what it needs for this target.
        sources: files of ``tests/firmware`` that belong to the target.
        run: the command that runs a program, which stands in place of "PROGRAM".
        real: how ``struct`` reads a trundle_real there.
    """

    compiler: str
    flags: tuple[str, ...]
    sources: tuple[str, ...] = ()
    run: tuple[str, ...] = ("PROGRAM",)
    real: str = "<d"

    @property
    def tools(self) -> tuple[str, ...]:
        """The commands that must be installed."""
        return tuple(each for each in (self.compiler, self.run[0]) if each != "PROGRAM")

    def as_float(self) -> Target:
        """Return the target with TRUNDLE_FLOAT defined."""
        return Target(self.compiler, (*self.flags, "-DTRUNDLE_FLOAT"), self.sources, self.run, "<f")


_CHECKED = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1", "-DHOST")
HOST = Target("gcc", _CHECKED)
CORTEX_M3 = Target(
    "arm-none-eabi-gcc",
    ("-Os", "-mcpu=cortex-m3", "-mthumb", "-nostartfiles", f"-T{HERE / 'cortex_m3.ld'}",
     "--specs=nosys.specs"),
    ("cortex_m3.c",),
    ("qemu-system-arm", "-M", "mps2-an385", "-display", "none", "-monitor", "none",
     "-serial", "none", "-semihosting-config", "enable=on,target=native", "-kernel", "PROGRAM"),
)  # fmt: skip
AVR = Target(
    "avr-gcc",
    ("-Os", "-mmcu=atmega1284p"),
    ("avr.c",),
    ("simavr", "-m", "atmega1284p", "-f", "20000000", "PROGRAM"),
    "<f",  # a double has 32 bits there
)


def needs(*tools: str) -> None:
    """Skip the test, and say why, where a tool is missing."""
    if missing := [tool for tool in tools if shutil.which(tool) is None]:
        pytest.skip(f"not installed: {', '.join(missing)}")


def call(*command: str | Path) -> str:
    """Return what a command writes; fail with that where it fails."""
    done = subprocess.run(
        [str(part) for part in command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}"
    return done.stdout


def write(folder: Path, files: dict[str, str]) -> Path:
    """Write files into a new folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return folder


def build(target: Target, folder: Path, sources: Sequence[Path], *more: str) -> Path:
    """Compile and link sources beside the firmware in a folder; return the program."""
    needs(*target.tools)
    program = folder / "program.elf"
    own = [HERE / each for each in target.sources]
    call(
        target.compiler, *WARNINGS, *target.flags, *more, f"-I{folder}", folder / "trundle.c",
        *sources, *own, "-lm", "-o", program,
    )  # fmt: skip
    return program


def run(target: Target, program: Path) -> list[bytes]:
    """Run a program on its target; return the values that it wrote, each as its bytes."""
    told = call(*(str(program) if part == "PROGRAM" else part for part in target.run))
    lines = (_LINE.match(_COLOUR.sub("", line)) for line in told.splitlines())
    return [bytes.fromhex(line[1]) for line in lines if line]


def reals(target: Target, values: Sequence[bytes]) -> list[float]:
    """Return the numbers of type trundle_real that a program wrote."""
    return [float(struct.unpack(target.real, value)[0]) for value in values]
