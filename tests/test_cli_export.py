"""``trundle export``: what it writes and prints, and what it never overwrites."""

import os
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from trundle.exchange import c_files, ros2_controllers, urdf
from trundle.robot import load, save


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_controllers_are_printed(trundle, tmp_path):
    code, out, err = trundle("export", "omni4", "--to", "ros2_controllers", "--timeout", 0.2)
    assert (code, err) == (0, "")
    assert out == ros2_controllers(load("omni4"), timeout=0.2)
    assert list(tmp_path.iterdir()) == []


def test_a_urdf_is_printed(trundle):
    code, out, err = trundle("export", "omni3", "--to", "urdf", "--set", "arm=0.5")
    assert (code, err) == (0, "")
    assert out == urdf(load("omni3", arm=0.5))
    ET.fromstring(out.encode())


def test_json_holds_the_text_or_the_files(ask, tmp_path):
    printed = ask("export", "omni4", "--to", "ros2_controllers")
    assert printed == {
        "name": "omni4",
        "to": "ros2_controllers",
        "files": [],
        "text": ros2_controllers(load("omni4")),
    }
    written = ask("export", "omni4", "--to", "ros2_controllers", "--out", "here")
    assert written["text"] is None
    assert written["files"] == [str(Path("here") / "omni4_controllers.yaml")]
    assert (tmp_path / written["files"][0]).read_text() == printed["text"]


def test_firmware_goes_to_a_folder_of_the_robots_name(trundle, tmp_path):
    code, out, err = trundle("export", "mecanum", "--to", "c", "--max-speed", 1, "--timeout", 0.3)
    assert (code, err) == (0, "")
    made = {path.name: path.read_text() for path in (tmp_path / "mecanum-c").iterdir()}
    assert made == c_files(load("mecanum"), max_speed=1.0, timeout=0.3)
    for name in made:
        assert f"wrote mecanum-c{os.sep}{name}" in out
    assert "less mecanum-c" in out


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize("folder", ["mecanum-c", "my firmware's"])
def test_the_command_that_is_printed_compiles(trundle, folder):
    _, out, _ = trundle("export", "mecanum", "--to", "c", "--out", folder)
    command = next(line for line in out.splitlines() if "gcc" in line)
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_same_again_is_no_overwriting(trundle, tmp_path):
    trundle("export", "mecanum", "--to", "c")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "mecanum-c").iterdir()}
    code, out, _ = trundle("export", "mecanum", "--to", "c")
    assert code == 0
    assert "is up to date" in out
    assert "wrote" not in out
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_a_file_that_differs_stays_and_nothing_is_written(trundle, tmp_path):
    target = tmp_path / "mecanum-c"
    target.mkdir()
    (target / "trundle.c").write_text("mine\n")
    code, out, err = trundle("export", "mecanum", "--to", "c")
    assert (code, out) == (2, "")
    assert "trundle.c is there already and differs" in err
    assert "--force" in err
    assert {path.name: path.read_text() for path in target.iterdir()} == {"trundle.c": "mine\n"}
    code, out, _ = trundle("export", "mecanum", "--to", "c", "--force")
    assert code == 0
    assert (target / "trundle.c").read_text() == c_files(load("mecanum"))["trundle.c"]


@pytest.mark.parametrize(
    ("form", "path"), [("ros2_controllers", "a/b/x.yaml"), ("ros2_controllers", "x.yml"),
                       ("urdf", "deep/x.urdf"), ("urdf", "x.xml")]
)  # fmt: skip
def test_out_may_name_the_file(trundle, tmp_path, form, path):
    code, out, err = trundle("export", "omni4", "--to", form, "--out", path)
    assert (code, err) == (0, "")
    make = urdf if form == "urdf" else ros2_controllers
    assert (tmp_path / path).read_text() == make(load("omni4"))
    assert (f"--param-file {path}" if form != "urdf" else f"trundle show {path}") in out


@pytest.mark.parametrize("path", ["v1.5", "robot.v2", "there.d"])
def test_a_folder_may_have_a_dot(trundle, tmp_path, path):
    (tmp_path / "there.d").mkdir()
    assert trundle("export", "omni4", "--to", "ros2_controllers", "--out", path)[0] == 0
    assert (tmp_path / path / "omni4_controllers.yaml").is_file()


@pytest.mark.parametrize("form", ["c", "urdf", "ros2_controllers"])
def test_commands_and_files_are_in_one_line(trundle, monkeypatch, form):
    """However narrow the terminal, and where there is none and 80 columns are taken for it."""
    monkeypatch.setattr("trundle.cli.output.out._width", 80)
    name = "a folder with a name that takes more than one line of eighty columns, of course"
    _, out, _ = trundle("export", "mecanum", "--to", form, "--out", name)
    wrote, commands = out.split("\n\nNext\n")
    assert {line.partition(" ")[0] for line in wrote.splitlines()} == {"wrote"}
    for line in commands.splitlines():
        assert line.split()[0] in {"gcc", "less", "trundle", "ros2"}
        assert f"'{name}{os.sep}" in line


def test_a_robot_that_was_exported_as_urdf_is_read_back(trundle, ask):
    trundle("export", "mecanum", "--to", "urdf", "--out", "m.urdf")
    assert ask("show", "m.urdf")["wheel_matrix"] == ask("show", "mecanum")["wheel_matrix"]


def test_wild_names_stay_in_their_folder(trundle, tmp_path):
    wild = load("differential").with_wheels(radius=0.1)
    object.__setattr__(wild, "name", "../../ü */ \n'")
    save(wild, tmp_path / "wild.toml")
    code, _, err = trundle("export", "wild.toml", "--to", "c")
    assert (code, err) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == {"wild.toml", "u-c"}


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("omni4",), "--to is missing: choose c, ros2_controllers or urdf"),
        (("omni4", "--to", "C"), "--to takes c, ros2_controllers, urdf, got 'C'"),
        (("omni4", "--to", "ros2_controler"), "did you mean 'ros2_controllers'?"),
        (("omni5", "--to", "c"), "no robot 'omni5'"),
        (("omni3", "--to", "ros2_controllers"), "clockwise at positive speed"),
        (("swerve", "--to", "ros2_controllers"), "Try trundle export swerve --to c"),
        (("my swerve.toml", "--to", "ros2_controllers"), "trundle export 'my swerve.toml' --to c"),
        (("omni4", "--to", "ros2_controllers", "--out", "x.txt"), "ends in .yaml or .yml, or a f"),
        (("omni4", "--to", "urdf", "--out", "x.robot"), "a name that ends in .urdf or .xml, or a"),
        (("omni4", "--to", "c", "--out", "x.txt"), "--to c needs a folder"),
        (("omni4", "--to", "urdf", "--max-jerk", 1), "--max-jerk belongs to firmware"),
        (("mecanum", "--to", "ros2_controllers", "--max-speed", 1), "max_speed would be lost"),
        (("omni4", "--to", "urdf", "--out", "x.yaml"), "a name that ends in .urdf or .xml, or a"),
        (("omni4", "--to", "c", "--out", "x.c"), "--to c needs a folder"),
        (
            ("omni4", "--to", "c", "--out", "file"),
            "file: nothing can be written there: it is a file",
        ),
        (
            ("omni4", "--to", "urdf", "--out", "file/x.urdf"),
            "file: nothing can be written there: it is a file",
        ),
        (("omni4", "--to", "c", "--set", "arm"), "--set needs SIZE=VALUE"),
    ],
)
def test_mistakes_are_told_in_one_line(trundle, tmp_path, args, told):
    (tmp_path / "file").write_text("a file, no folder\n")
    save(load("swerve"), tmp_path / "my swerve.toml")
    code, out, err = trundle("export", *args)
    assert (code, out) == (2, "")
    assert told in " ".join(err.split())
    assert err.startswith("error: ")
    assert {path.name for path in tmp_path.iterdir()} == {"file", "my swerve.toml"}


@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf", "fast"])
def test_a_limit_is_a_positive_number(trundle, value):
    code, _, err = trundle("export", "omni4", "--to", "c", "--max-speed", value)
    assert code == 2
    assert "--max-speed" in err


def test_the_help_names_the_formats_and_limits(trundle):
    code, out, _ = trundle("export", "--help")
    assert code == 0
    for word in ("ros2_controllers", "urdf", "--max-yaw-deceleration", "--force", "Example"):
        assert word in out


def test_json_of_firmware_names_the_files(ask):
    made = ask("export", "omni3", "--to", "c", "--out", "fw")
    assert sorted(made["files"]) == sorted(
        str(Path("fw") / name) for name in c_files(load("omni3"))
    )
