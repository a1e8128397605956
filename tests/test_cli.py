"""The command: what it prints, its JSON, its exit codes, and that bad input never bites."""

import json
import math

import numpy as np
import pytest

from trundle.cli.app import run
from trundle.robot import CATALOG, load, to_toml


def test_catalog_lists_the_names(ask):
    assert ask("catalog") == list(CATALOG)


@pytest.mark.parametrize("name", CATALOG)
def test_show_works_for_the_whole_catalogue(trundle, name):
    code, out, err = trundle("show", name, "--explain")
    assert (code, err) == (0, "")
    assert "What it can do" in out


def test_show_gives_the_lectures_w_and_class(ask):
    shown = ask("show", "omni3")
    root3 = math.sqrt(3)
    expected = 0.2 / 3 * np.array([[0, -root3, root3], [2, -1, -1], [1 / 0.3] * 3])
    np.testing.assert_allclose(shown["wheel_matrix"], expected, atol=1e-12)
    assert shown["rank"] == 3
    assert shown["mobility"] == {
        "degree": 3,
        "steerability": 0,
        "maneuverability": 3,
        "class": "(3,0)",
    }
    assert shown["omnidirectional"] is True
    assert shown["holonomic"] is True
    assert shown["warnings"] == []


def test_show_warns_of_the_lectures_mecanum_with_equal_half_sizes(ask):
    shown = ask("show", "mecanum_lecture", "--set", "wheelbase=0.6", "--set", "track=0.6")
    assert shown["rank"] == 2
    assert "yaw_arm_cancels" in [warning["code"] for warning in shown["warnings"]]
    assert all(warning["message"] for warning in shown["warnings"])


@pytest.mark.parametrize(
    "angles",
    [
        ("--steering-deg", "20", "20"),
        ("--steering-deg", "20,20"),
        ("--steering-deg=20 20",),
        ("--steering-deg", "20", "--steering-deg", "20"),
    ],
)
def test_off_centre_angles_have_no_w(ask, angles):
    shown = ask("show", "ackermann", *angles)
    assert shown["wheel_matrix"] is None
    assert [warning["code"] for warning in shown["warnings"]] == ["off_centre_angles"]


def test_inverse_answers_the_lectures_open_question(ask):
    found = ask("inverse", "omni3", 0, 0.5, 0)
    np.testing.assert_allclose(found["wheel_speeds"], [2.5, -1.25, -1.25], atol=1e-12)
    np.testing.assert_allclose(found["rpm"], np.array([2.5, -1.25, -1.25]) * 30 / math.pi)
    assert found["steering"] == []
    assert found["residual"] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("v", ["-0.5", "-.5", "-5e-1"])
def test_negative_numbers_need_no_dashes(ask, v):
    np.testing.assert_allclose(
        ask("inverse", "omni3", 0, v, 0)["wheel_speeds"], [-2.5, 1.25, 1.25], atol=1e-12
    )


def test_inverse_of_a_car_gives_exact_angles(ask):
    steering = ask("inverse", "ackermann", 1, 0, 0.25)["steering"]
    # The centre is at (0, 4): half track 0.75, wheelbase 2.6.
    np.testing.assert_allclose(steering, [math.atan(2.6 / 3.25), math.atan(2.6 / 4.75)])


def test_an_infeasible_twist_tells_the_residual_or_fails_when_strict(ask, trundle):
    np.testing.assert_allclose(ask("inverse", "differential", 0, 1, 0)["residual"], [0, 1, 0])
    code, out, err = trundle("inverse", "differential", 0, 1, 0, "--strict")
    assert (code, out) == (2, "")
    assert "cannot have the twist" in err


def test_forward_gives_twist_and_residual(ask):
    found = ask("forward", "omni3", 0, -0.5, 0.5)
    np.testing.assert_allclose(found["twist"], [0.2 / math.sqrt(3), 0, 0], atol=1e-12)
    np.testing.assert_allclose(found["residual"], 0, atol=1e-12)
    found = ask("forward", "tricycle", 2, "--steering-deg", -30)
    # a omega = 0.2 m/s along -30 deg at 0.8 m before the rear axle.
    np.testing.assert_allclose(
        found["twist"], [0.2 * math.cos(math.pi / 6), 0, -0.2 * 0.5 / 0.8], atol=1e-12
    )


def test_simulate_leaves_everything_in_its_folder(ask, tmp_path):
    out = tmp_path / "run"
    done = ask(
        "simulate", "omni3", "--wheel-speeds", 0.5, 0.5, 0.5, "--duration", 1, "--dt", 0.1,
        "--out", out,
    )  # fmt: skip
    assert done["pose"][2] == pytest.approx(1 / 3)
    names = {"run.csv", "run.npz", "log.csv", "eta.png", "path.png", "animation.gif"}
    assert {path.name for path in out.iterdir()} == names
    assert all((out / name).stat().st_size > 100 for name in names)


def test_the_log_of_a_simulation_replays_to_its_path(ask, tmp_path):
    for name in ("mixed", "tricycle", "omni4"):
        out = tmp_path / name
        twist = ("0.3", "0", "0.4")
        ask("simulate", name, "--twist", *twist, "--duration", 5, "--out", out,
            "--animation", "none")  # fmt: skip
        error = ask("odometry", name, out / "log.csv")["error"]
        # Dead wheels count in ticks of 2 pi 0.03 m / 2048: a tenth of a millimetre.
        assert error["end_error"] < 1e-3


def test_odometry_maps_columns(ask, tmp_path):
    robot = tmp_path / "two.toml"
    robot.write_text(to_toml(load("differential", radius=0.1, track=0.5)))
    log = tmp_path / "log.csv"
    log.write_text("0;0;0;skip\n1;1;2;skip\n2;1;2;skip\n")
    found = ask("odometry", robot, log, "--columns", "time,radians:left,radians:right,-")
    # Twice rims 0.1 and 0.2 m: 0.3 m of path, a turn of 0.2 / 0.5 rad.
    assert found["pose"][2] == pytest.approx(0.4)
    assert found["pose"][0] == pytest.approx(0.3 / 0.4 * math.sin(0.4))
    log.write_text("stamp,l,r\n0,0,0\n1,1,2\n2,1,2\n")
    named = ask("odometry", robot, log, "--map", "radians:left=l", "--map", "radians:right=r")
    assert named["pose"] == pytest.approx(found["pose"])


def test_simulated_commands_come_from_a_file(ask, tmp_path):
    file = tmp_path / "commands.csv"
    file.write_text("VX,VY,WZ\n1,0,0\n0,1,0\n")
    done = ask("simulate", "mecanum", "--commands", file, "--dt", 1)
    np.testing.assert_allclose(done["pose"], [1, 1, 0], atol=1e-12)
    file.write_text("front,front_deg\n10,90\n")
    done = ask("simulate", "tricycle", "--commands", file, "--dt", 1)
    # The front wheel runs 1 m across at 0.8 m from the rear axle's middle.
    np.testing.assert_allclose(done["pose"], [0, 0, 1 / 0.8], atol=1e-9)


def test_init_writes_a_robot_that_loads_and_never_overwrites(trundle, tmp_path):
    path = tmp_path / "mine.toml"
    assert trundle("init", path, "--like", "mecanum", "--set", "track=0.25", "--schema")[0] == 0
    assert load(path) == load("mecanum", track=0.25)
    assert json.loads((tmp_path / "robot.schema.json").read_text())["title"] == "Robot"
    before = path.read_text()
    code, _, err = trundle("init", path)
    assert (code, path.read_text()) == (2, before)
    assert "--force" in err


def test_check_names_the_lost_minus_of_the_slides(ask, tmp_path):
    path = tmp_path / "slides.csv"
    rows = [
        (-math.sin(math.radians(th)), -math.cos(math.radians(th)), -0.2)
        for th in (45, 315, 135, 225)
    ]
    path.write_text("\n".join(",".join(map(repr, row)) for row in rows))
    found = ask("check", "omni4", path)
    assert found["agrees"] is False
    assert "VX" in " ".join(finding["message"] for finding in found["findings"])


def test_demo_makes_the_gallery(ask, tmp_path):
    done = ask("demo", "--out", tmp_path / "gallery")
    assert all((tmp_path / "gallery").joinpath(file).exists() for file in done["files"])
    assert len(done["files"]) > 10
    assert done["replay"]["end_percent"] < 0.1


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("inverse", "omni3", "nan", "0", "0"), "not a finite number"),
        (("inverse", "omni3", "0", "-inf", "0"), "not a finite number"),
        (("inverse", "omni3", "0", "left", "0"), "not a number"),
        (("inverse", "omni3", "0", "0"), "WZ"),
        (("inverse", "omni3", "0", "0", "0", "--bogus"), "--bogus"),
        (("forward", "omni3", "1", "2"), "3 driven wheels"),
        (("forward", "tricycle", "1"), "front"),
        (("show", "omni3", "--steering-deg", "3"), "does not steer"),
        (("show", "ackermann", "--steering-deg", "3"), "front_left, front_right"),
        (("show", "ackermann", "--steering-deg", "nan", "3"), "not a finite number"),
        (("show", "omni33"), "did you mean 'omni3'"),
        (("show", "missing.toml"), "missing.toml"),
        (("show", "omni3", "--set", "size=1"), "size"),
        (("show", "omni3", "--set", "arm"), "SIZE=VALUE"),
        (("show", "omni3", "--set", "arm=-1", "--set", "radius=0"), "radius must be positive"),
        (("simulate", "omni3"), "--twist"),
        (
            ("simulate", "omni3", "--twist", "1", "0", "0", "--wheel-speeds", "1", "1", "1"),
            "one of",
        ),
        (("simulate", "omni3", "--twist", "1", "0", "0", "--dt", "0"), "positive"),
        (("simulate", "omni3", "--twist", "1", "0", "0", "--method", "rk5"), "rk4"),
        (("simulate", "omni3", "--twist", "1", "0", "0", "--animation", "avi"), "gif, mp4 or none"),
        (("simulate", "omni3", "--commands", "none.csv"), "none.csv"),
        (("odometry", "differential", "none.csv"), "none.csv"),
        (("check", "omni3", "none.csv"), "none.csv"),
        (("init", "x.toml", "--like", "hovercraft"), "catalogue name"),
        (("fly",), "fly"),
    ],
)
def test_mistakes_exit_with_2_and_say_why(trundle, args, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = trundle(*args)
    assert code == 2
    assert out == ""
    assert told in " ".join(err.split())
    assert "Traceback" not in err


def test_a_folder_that_cannot_be_made_is_told_before_the_work(trundle, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    for args in (
        ("show", "omni3", "--out", blocked / "sub"),
        ("simulate", "omni3", "--twist", "1", "0", "0", "--out", blocked),
        ("demo", "--out", blocked),
    ):
        code, out, err = trundle(*args)
        assert (code, out) == (2, "")
        assert "nothing can be written there" in err


def test_our_own_faults_exit_with_1(trundle, monkeypatch):
    def broken(_):
        raise ZeroDivisionError("boom")

    monkeypatch.setattr("trundle.cli.files.print_json", broken)
    code, out, err = trundle("catalog", "--json")
    assert (code, out) == (1, "")
    assert "fault of trundle" in err
    assert "boom" in err


@pytest.mark.parametrize(
    "command",
    ["catalog", "show", "check", "init", "forward", "inverse", "simulate", "odometry", "demo"],
)
def test_help_teaches_with_an_example(trundle, command):
    code, out, _ = trundle(command, "--help")
    assert code == 0
    assert f"trundle {command}" in out.split("Example")[1]


def test_simulate_says_what_it_drove_instead(ask, tmp_path):
    (note,) = ask("simulate", "differential", "--twist", 0, 0.3, 0)["notes"]
    assert "Asked for (0, 0.3, 0), it drove (0, 0, 0)" in note
    assert "turning on the spot" in note
    assert ask("simulate", "differential", "--twist", 0.3, 0, 0.1)["notes"] == []
    (note,) = ask("simulate", "mecanum", "--wheel-speeds", 1, 1, 1, 5)["notes"]
    assert "do not fit together" in note
    slow = tmp_path / "slow.toml"
    slow.write_text(to_toml(load("differential", radius=0.05).with_wheels(max_speed=10.0)))
    (note,) = ask("simulate", slow, "--twist", 1, 0, 0)["notes"]
    assert "scaled to 50 %" in note
    assert "left would turn at 20 rad/s and may do 10" in note
    assert len(ask("simulate", slow, "--wheel-speeds", 11, 11)["notes"]) == 2


def test_commands_with_columns_that_mean_nothing_are_refused(trundle, tmp_path):
    file = tmp_path / "commands.csv"
    file.write_text("time,VX,VY,WZ\n0,1,0,0\n1,1,0,0\n")
    code, _, err = trundle("simulate", "mecanum", "--commands", file)
    assert code == 2
    assert "the columns time mean nothing here" in " ".join(err.split())


def test_the_usual_slips_of_toml_are_named(trundle, tmp_path):
    file = tmp_path / "slip.toml"
    good = to_toml(load("bicycle"))
    for text, told in (
        (good.replace("[[wheel]]", "[wheel]"), "two brackets"),
        (good.replace("radius = 0.3", "radius = 0,3"), "a decimal point, not a comma"),
        (good.replace('"fixed"', "fixed"), "texts need quotes"),
    ):
        file.write_text(text)
        code, _, err = trundle("show", file)
        assert code == 2
        assert told in " ".join(err.split())


def test_every_digit_of_w_is_shown_however_narrow(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.setattr("trundle.cli.output.out.width", 40)
    assert run(["show", "mecanum"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("0.0357143") == 4


def test_every_command_leaves_its_files_in_the_folder(trundle, tmp_path):
    matrix = tmp_path / "matrix.csv"
    matrix.write_text("1,2,3\n4,5,6\n7,8,9\n")
    for args, names in (
        (("catalog",), {f"{name}.png" for name in CATALOG}),
        (("inverse", "ackermann", 1, 0, 0.25), {"layout.png"}),
        (("forward", "tricycle", 2, "--steering-deg", -30), {"layout.png"}),
        (("check", "omni3", matrix), {"ours.csv"}),
        (("init", "mine.toml"), {"mine.toml"}),
        (("show", "swerve"), {"layout.png", "reachable.png"}),
    ):
        out = tmp_path / args[0]
        code, _, err = trundle(*args, "--out", out)
        assert (code, err) == (0, "")
        assert {path.name for path in out.iterdir()} == names
