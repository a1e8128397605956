"""``trundle track``: the lectures' numbers from the command line, its files, and its refusals."""

import numpy as np
import pytest

from trundle.simulation import Run

# The table of the lectures' motion control is printed with five digits.
DIGITS = 1e-4
LECTURE = [
    *("--heading", "lecture", "--method", "lecture", "--dt", "0.1", "--duration", "60"),
    *("--mass", "30", "--inertia", "0.1", "--com", "0", "0"),
]


# Largest |error| of x and y, PD and computed torque, of the lectures' second part.
TABLE = {
    "circle": (7.4813e-3, 7.4813e-3, 3.4913e-5, 3.4913e-5),
    "via-stop": (3.2190e-3, 3.1215e-3, 1.0370e-5, 1.0370e-5),
    "via": (3.2190e-3, 1.6137e-3, 1.0370e-5, 2.5926e-6),
    "ellipse": (7.4813e-3, 4.9875e-3, 3.4913e-5, 2.3275e-5),
    "lissajous": (2.9704e-2, 7.4813e-3, 2.7723e-4, 3.4913e-5),
}


@pytest.mark.parametrize("path", TABLE)
def test_the_lectures_table(ask, path):
    runs = ask("track", "omni3", "--path", path, "--compare", *LECTURE)["runs"]
    got = [
        runs[law][f"largest_error_of_{axis}"] for law in ("pd", "computed-torque") for axis in "xy"
    ]
    np.testing.assert_allclose(got, TABLE[path], rtol=DIGITS)


def test_a_wrong_mass_in_the_model(ask):
    told = ask("track", "omni3", "--controller", "computed-torque", "--model-mass", 36, *LECTURE)
    largest = told["runs"]["computed-torque"]["largest_error_of_x"]
    assert largest == pytest.approx(1.2467e-3, rel=DIGITS)


def test_pd_made_for_another_mass_errs_in_proportion(ask):
    """Its gains are made for 30 kg: with 60 kg the same force bends the path half as well."""
    args = ["track", "omni3", "--controller", "pd", *LECTURE]
    light = ask(*args)
    args[args.index("--mass") + 1] = "60"
    heavy = ask(*args, "--model-mass", "30")
    assert light["gains"]["pd"]["kp"] == heavy["gains"]["pd"]["kp"] == [120, 120, 0.4]
    errors = [told["runs"]["pd"]["largest_error_of_x"] for told in (light, heavy)]
    # By the transfer function m w^2 / (k_p - m w^2 + ...): twice, to a few percent.
    assert errors[1] / errors[0] == pytest.approx(2.0, rel=0.02)


def test_a_heading_that_jumps_is_told(ask):
    told = ask("track", "omni3", "--path", "via-stop", *LECTURE)
    assert any("desired heading jumps by up to" in note for note in told["notes"])


def test_files_are_left(trundle, tmp_path):
    code, out, _ = trundle(
        "track", "omni3", "--compare", "--duration", 2, "--dt", 0.05, "--out", tmp_path / "new"
    )
    assert code == 0
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {
        "pd.csv", "pd.png", "pd.gif", "computed-torque.csv", "computed-torque.png",
        "computed-torque.gif", "trajectory.png", "comparison.png",
    }  # fmt: skip
    assert all(name in "".join(out.split()) for name in names)
    kept = Run.load(tmp_path / "new" / "pd.csv")
    assert kept.error.shape == (41, 3)


@pytest.mark.parametrize(
    ("robot", "controller"),
    [
        ("omni3", "computed-torque"),
        ("mecanum", "computed-torque"),
        ("differential", "kanayama"),
        ("ackermann", "kanayama"),
        ("skid_steer", "kanayama"),
        ("swerve", "resolved-rate"),
    ],
)
def test_a_controller_that_suits_is_taken(ask, robot, controller):
    told = ask("track", robot, "--duration", 1, "--dt", 0.05)
    assert list(told["runs"]) == [controller]
    assert told["runs"][controller]["largest_error_of_x"] < 1e-6


def test_a_file_is_a_path(ask, tmp_path):
    path = tmp_path / "mine.csv"
    t = np.linspace(0, 10, 51)
    np.savetxt(path, np.stack([t, 0.2 * t, 0 * t], -1), delimiter=",", header="t,x,y", comments="")
    told = ask("track", "differential", "--path", path, "--controller", "kanayama")
    assert told["runs"]["kanayama"]["rms_distance"] < 1e-3


def test_go_to_pose_ends_at_the_end(ask, tmp_path):
    for start in ([], ["--pose", "0", "1", "0"]):
        args = ["--path", "line", "--controller", "go-to-pose", *start]
        ask("track", "differential", *args, "--out", tmp_path, "--animation", "none")
        driven = Run.load(tmp_path / "go-to-pose.csv")
        np.testing.assert_allclose(driven.pose[0], [0.0, float(bool(start)), 0.0])
        np.testing.assert_allclose(driven.pose[-1], [4.0, 0.0, 0.0], atol=0.02)


def test_limits_are_told(trundle, tmp_path):
    robot = tmp_path / "weak.toml"
    assert trundle("init", robot, "--like", "omni3")[0] == 0
    text = robot.read_text().replace('kind = "omni"', 'kind = "omni"\nmax_torque = 0.05')
    robot.write_text(text)
    code, out, _ = trundle("track", robot, "--duration", 5, "--stretch", 0.3)
    assert code == 0
    assert "torque limits" in out
    assert "stretch time by" in out


def test_a_step_too_long_is_told(ask):
    told = ask("track", "omni3", "--controller", "pd", "--dt", 2, "--duration", 8)
    assert any("too long for these gains" in note for note in told["notes"])


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (["omni3", "--path", "cirle"], "did you mean 'circle'?"),
        (["omni3", "--controller", "pid"], "no controller 'pid'"),
        (["differential", "--controller", "pd"], "use --controller kanayama"),
        (["swerve", "--controller", "computed-torque"], "steers"),
        (["omni3", "--method", "ode45"], "method must be one of"),
        (["omni3", "--heading", "pathh"], "did you mean 'path'?"),
        (["omni3", "--animation", "avi"], "--animation takes"),
        (["omni3", "--controller", "pd", "--compare"], "not both"),
        (["differential", "--kp", "1", "1", "1"], "--kp and --kd belong to"),
        (["omni3", "--kp", "1", "-1", "1"], "kp must not be negative"),
        (["omni3", "--controller", "go-to-pose", "--model-mass", "3"], "--model-mass belongs"),
        (["omni3", "--kp", "1", "2", "x"], "--kp: 'x' is not a number"),
        (["omni3", "--mass", "-3"], "must be positive"),
        (["omni3", "--path", "nowhere.csv"], "nowhere.csv"),
        (["omni3", "--duration", "1e9"], "more than"),
    ],
)
def test_bad_input_is_told(trundle, args, expected):
    code, _, err = trundle("track", *args)
    assert code == 2
    assert expected in " ".join(err.split())
    assert "Traceback" not in err
