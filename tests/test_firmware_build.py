"""Firmware as a user gets it: compilers take it, any name may be in it, bad settings are told."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

import trundle
from firmware_tools import HERE, WARNINGS, call, needs, write
from firmware_vectors import ENCODER, bare, gentle, limited
from golden_text import agrees_with_golden
from trundle import FixedWheel, SteeredWheel
from trundle.errors import TrundleError, UnobservedMotionError
from trundle.exchange import c_files
from trundle.robot import CATALOG, Robot

CASES = {"bare": bare, "gentle": gentle, "limited": limited}
DOCS = Path(__file__).parents[1] / "docs" / "firmware.md"
each_robot = pytest.mark.parametrize("name", CATALOG)


def firmware(name: str, kind: str, folder: Path) -> Path:
    case = CASES[kind](name)
    return write(folder, c_files(case.robot, **case.settings))


# ---- compilers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "kind"),
    [*((name, "limited") for name in CATALOG), ("mecanum", "bare"), ("ackermann", "gentle"),
     ("swerve", "bare"), ("mixed", "bare")],
)  # fmt: skip
def test_compilers_and_checkers_have_nothing_to_say(name, kind, tmp_path):
    needs("gcc", "clang", "cppcheck", "nm")
    source = firmware(name, kind, tmp_path) / "trundle.c"
    for real in ((), ("-DTRUNDLE_FLOAT",)):
        compiled = tmp_path / "trundle.o"
        call("gcc", *WARNINGS, *real, "-O2", "-c", source, "-o", compiled)
        # No data that is written: neither d (given), b (zeros) nor c (common), whatever the case.
        assert re.findall(r" [dbc] \w+", call("nm", compiled), re.IGNORECASE) == []
        call("clang", *WARNINGS, *real, "-fsyntax-only", source)
    call(
        "cppcheck", "--quiet", "--error-exitcode=1", "--std=c99", "--inline-suppr",
        "--enable=warning,style,performance,portability",
        "--suppress=missingIncludeSystem", source,
    )  # fmt: skip


@each_robot
def test_avr_compilers_have_nothing_to_say(name, tmp_path):
    needs("avr-gcc")
    source = firmware(name, "limited", tmp_path) / "trundle.c"
    call("avr-gcc", *WARNINGS, "-Os", "-mmcu=atmega2560", "-c", source, "-o", tmp_path / "t.o")


ARDUINO = """\
#include <stddef.h>
#include <stdint.h>
uint32_t micros(void);
void setup(void);
void loop(void);
"""
DESK = """\
#include "Arduino.h"
static uint32_t now;
uint32_t micros(void) { return now += 4096; }
int main(void) {
  setup();
  for (int i = 0; i < 1000; i++) {
    loop();
  }
  return 0;
}
"""
CPP = ("-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion")


@pytest.mark.parametrize("name", ["differential", "mecanum", "ackermann", "swerve"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_example_is_a_sketch_that_runs(name, real, tmp_path):
    needs("gcc", "g++")
    folder = firmware(name, "limited", tmp_path)
    write(folder, {"Arduino.h": ARDUINO, "desk.cpp": DESK})
    flags = ["-DTRUNDLE_FLOAT"] if real == "float" else []
    call("gcc", *WARNINGS, *flags, "-c", folder / "trundle.c", "-o", folder / "trundle.o")
    sketch = ["-x", "c++", "-include", folder / "Arduino.h", folder / "example.ino", "-x", "none"]
    program = folder / "program"
    call(
        "g++", *CPP, *flags, *sketch, folder / "desk.cpp", folder / "trundle.o", "-lm",
        "-o", program,
    )  # fmt: skip
    call(program)


def test_a_mixture_of_float_and_double_does_not_link(tmp_path):
    needs("gcc", "g++")
    folder = firmware("mecanum", "bare", tmp_path)
    write(folder, {"Arduino.h": ARDUINO, "desk.cpp": DESK})
    call("gcc", "-DTRUNDLE_FLOAT", "-c", folder / "trundle.c", "-o", folder / "trundle.o")
    with pytest.raises(AssertionError, match=r"undefined reference to .trundle_step"):
        call(
            "g++", "-x", "c++", "-include", folder / "Arduino.h", folder / "example.ino",
            "-x", "none", folder / "desk.cpp", folder / "trundle.o", "-lm", "-o", folder / "run",
        )  # fmt: skip


def test_fast_math_is_refused(tmp_path):
    needs("gcc")
    folder = firmware("mecanum", "bare", tmp_path)
    with pytest.raises(AssertionError, match="compile it without -ffast-math"):
        call("gcc", "-ffast-math", "-c", folder / "trundle.c", "-o", folder / "trundle.o")


# ---- names -------------------------------------------------------------------------------------

HOSTILE = [
    "int", "a b", "a_b", "A-B", "*/ #error", "/* x", "für", "車", "\n#error line", "\\", "??/",
    "TRUNDLE_WHEEL", "1st", " ", "x" * 300, '"', "%n%s", "@ROBOT@", "//: if steered", "\u202e",
]  # fmt: skip


@pytest.mark.parametrize("robot_name", ["*/ int x; /*", "\n#error line", "??/", "@PLACES@", "車"])
def test_no_name_breaks_the_c(robot_name, tmp_path):
    needs("gcc", "cppcheck")
    names = [name if name.strip() else "blank" for name in HOSTILE]
    wheels = tuple(
        FixedWheel(name=name, x=0.0, y=1.0 + i, radius=0.1) for i, name in enumerate(names)
    )
    files = c_files(Robot(name=robot_name, wheels=wheels))
    folder = write(tmp_path, files)
    call("gcc", *WARNINGS, "-c", folder / "trundle.c", "-o", folder / "trundle.o")
    places = re.findall(r"^    (TRUNDLE_WHEEL_\w+) = (\d+)", files["trundle.h"], re.MULTILINE)
    assert [int(place) for _, place in places] == list(range(len(names)))
    assert len({name for name, _ in places}) == len(names)
    assert all(len(name) < 64 for name, _ in places)


def test_places_have_the_wheels_names():
    header = c_files(trundle.load("tricycle"))["trundle.h"]
    for line in ("WHEEL_FRONT = 0", "STEERED_FRONT = 0", "COUNTER_FRONT = 0"):
        assert f"    TRUNDLE_{line}" in header


# ---- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"max_sped": 1.0}, "the bridge in C has no 'max_sped': did you mean 'max_speed'?"),
        ({"max_speed": -1.0}, "max_speed must be positive"),
        ({"max_speed": float("nan")}, "max_speed must be"),
        ({"timeout": 0.0}, "timeout must be from a microsecond to 600 s in C, got 0.0"),
        ({"timeout": float("inf")}, "timeout must be from a microsecond to 600 s in C, got inf"),
        ({"timeout": True}, "timeout must be from a microsecond"),
        ({"max_interval": "soon"}, "max_interval must be from a microsecond"),
        ({"counter_bits": None}, "counter_bits must be from 8 to 32 in C, got None"),
        ({"counter_bits": 64}, "counter_bits must be from 8 to 32 in C, got 64"),
        ({"encoder": 2048}, "encoder must be an Encoder, got 2048"),
        ({"without": ("left",)}, "the bridge in C has no 'without'"),
    ],
)
def test_impossible_settings_are_told(settings, message):
    with pytest.raises(TrundleError, match=re.escape(message)):
        c_files(trundle.load("mecanum"), **settings)


def linked(ratio: float, track: float) -> Robot:
    """Return a robot whose rear wheels steer with a share of the front wheels' angle."""
    wheels = tuple(
        SteeredWheel(
            name=f"{'front' if x > 0 else 'rear'} {y:g}",
            x=x,
            y=y,
            radius=0.1,
            steering_group=f"{y:g}",
            steering_ratio=1.0 if x > 0 else ratio,
        )
        for x in (0.5, -0.5)
        for y in sorted({track / 2, -track / 2})
    )
    return Robot(name="linked", wheels=wheels)


def test_linked_steering_without_formulas_is_refused_with_the_reason():
    with pytest.raises(TrundleError, match="linked steering allows only a curved set of twists"):
        c_files(linked(-0.5, track=0.0))
    with pytest.raises(TrundleError, match=r"'rear -0\.3' of one group steer by different angles"):
        c_files(linked(-0.5, track=0.6))
    assert "trundle_inverse" in c_files(linked(-1.0, track=0.6))["trundle.c"]


def test_a_robot_that_cannot_be_commanded_or_measured_is_refused():
    free = trundle.load("differential").with_wheels(driven=False)
    with pytest.raises(TrundleError, match="'differential': no wheel is driven"):
        c_files(free)
    blind = trundle.load("differential").with_wheels(measured=False)
    with pytest.raises(TrundleError, match="'differential': no wheel is measured"):
        c_files(blind)
    wheels = trundle.load("mecanum").wheels
    half = [dataclasses.replace(wheel, measured=False) for wheel in wheels[1:]]
    with pytest.raises(UnobservedMotionError):
        c_files(Robot(name="half", wheels=(wheels[0], *half)))
    with pytest.raises(TrundleError, match="a Robot is needed"):
        c_files("mecanum")


# ---- texts -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "kind"), [("mecanum", "bare"), ("mixed", "gentle"), ("swerve", "limited")]
)
@pytest.mark.parametrize("file", ["trundle.h", "trundle.c", "README.md", "example.ino"])
def test_the_text_is_as_it_was_read(name, kind, file):
    case = CASES[kind](name)
    agrees_with_golden(f"firmware/{name}_{file}", c_files(case.robot, **case.settings)[file])


@each_robot
def test_texts_are_tidy(name):
    for file, text in c_files(limited(name).robot).items():
        assert text.endswith("\n"), file
        assert "@" not in text, file
        assert "//:" not in text, file
        assert "\n\n\n" not in text, file
        for line in text.splitlines():
            assert line == line.rstrip(), f"{file}: {line!r}"
            assert len(line) <= 100 or file == "README.md", f"{file}: {line!r}"


@pytest.mark.parametrize("settings", [{}, {"encoder": ENCODER, "timeout": 0.25}])
def test_the_readme_has_ten_lines_at_most(settings):
    text = c_files(trundle.load("mecanum"), **settings)["README.md"]
    assert len(text.splitlines()) <= 10
    assert ("stand-in" in text) == (not settings)
    assert f"command for {settings.get('timeout', 0.5):g} s" in text


# ---- docs --------------------------------------------------------------------------------------


def test_the_c_of_the_docs_compiles_and_runs(tmp_path):
    needs("gcc")
    blocks = re.findall(r"^```c\n(.*?)^```$", DOCS.read_text(), re.MULTILINE | re.DOTALL)
    assert blocks
    files = c_files(trundle.load("mecanum"), max_speed=1.0, max_acceleration=0.5)
    for i, block in enumerate(blocks):
        folder = write(tmp_path / str(i), files | {"main.c": block})
        program = folder / "main"
        call(
            "gcc", *WARNINGS, folder / "main.c", folder / "trundle.c", "-lm", "-o", program,
            f"-I{HERE}",
        )  # fmt: skip
        shown = re.findall(r"^// prints: (.*)$", block, re.MULTILINE)
        assert call(program).splitlines() == shown
