"""``trundle rollout``: numbers against sums done by hand, its files, and its refusals."""

import csv
import math
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from trundle.simulation.rollout import devices

ROUNDING = 1e-9
ROBOTS = 4000
# A standard deviation found from N normal numbers is itself known to 1 / sqrt(2 N): five of these.
FOUND_STD = 5 / math.sqrt(2 * ROBOTS)
# A mean is known to so many standard deviations.
FOUND_MEAN = 5 / math.sqrt(ROBOTS)
STRAIGHT = ("--twist", 0.3, 0, 0, "--duration", 10)


@pytest.fixture
def _no_numba(monkeypatch):
    """Block the compiler: numpy gives the same results, and takes no time to get ready."""
    monkeypatch.setitem(sys.modules, "numba", None)
    devices._tell_how.cache_clear()
    yield
    devices._tell_how.cache_clear()


pytestmark = pytest.mark.usefixtures("_no_numba")


@pytest.fixture
def roll(ask):
    return lambda *args: ask("rollout", *args, "--robots", ROBOTS)


def final(folder) -> dict[str, np.ndarray]:
    return dict(np.load(folder / "final.npz"))


# ---- numbers ----------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", ["differential", "mecanum", "ackermann"])
def test_a_radius_known_to_a_percent_gives_a_percent_of_the_distance(roll, robot):
    told = roll(robot, *STRAIGHT, "--vary", "radius=1%")
    np.testing.assert_allclose(told["nominal"], [3, 0, 0], atol=ROUNDING)
    std = told["standard_deviation"]
    assert std[0] == pytest.approx(0.03, rel=FOUND_STD)
    assert std[1:] == pytest.approx([0, 0], abs=ROUNDING)
    assert told["mean"][0] == pytest.approx(3, abs=0.03 * FOUND_MEAN)
    # 95 % of normal numbers are within 1.96 of their standard deviations.
    assert told["within_95_percent"] == pytest.approx(1.96 * 0.03, rel=2 * FOUND_STD)
    # The root of 5.991, the 95 % quantile of chi squared with two degrees of freedom.
    assert told["ellipse"]["half_axes"] == pytest.approx([2.4477 * std[0], 0], abs=1e-5)
    assert told["ellipse"]["direction"] == pytest.approx(0, abs=ROUNDING)
    assert told["farthest"]["distance"] == pytest.approx(abs(told["farthest"]["pose"][0] - 3))


def test_noise_in_every_step_adds_up_as_its_square(roll):
    """A differential drive of track b: the heading's rate errs by a (n_r - n_l) / b."""
    told = roll("differential", *STRAIGHT, "--noise", 0.02, "--dt", 0.1, "--set", "radius=0.1",
                "--set", "track=0.4", "--seed", 3)  # fmt: skip
    assert told["steps"] == 100
    sums = 0.1 * 0.02 * 0.1 * math.sqrt(100)  # of the way of one rim: a, sigma, dt, sqrt(T)
    turn = math.sqrt(2) * sums / 0.4
    # Across go the headings' sums at 0.3 m/s, whose square is a third of the last heading's.
    expected = [sums / math.sqrt(2), 0.3 * 10 * turn / math.sqrt(3), turn]
    # A hundred steps are not yet a continuous motion, by a part in a hundred.
    assert told["standard_deviation"] == pytest.approx(expected, rel=FOUND_STD + 0.01)


def test_a_track_that_is_off_turns_all_the_more(roll, tmp_path):
    """The heading is a (w_r - w_l) T / b: exactly, robot by robot."""
    roll("differential", "--wheel-speeds", 1, 2, "--duration", 8, "--set", "radius=0.1",
         "--set", "track=0.4", "--vary", "track=0.01", "--out", tmp_path)  # fmt: skip
    ends = final(tmp_path)
    assert ends["track"].std() == pytest.approx(0.01, rel=FOUND_STD)
    np.testing.assert_allclose(ends["psi"], 0.1 * 8 / ends["track"], rtol=ROUNDING)


def test_one_wheels_own_error_adds_to_that_of_all(roll, tmp_path):
    args = ("differential", *STRAIGHT, "--set", "radius=0.05", "--vary", "radius=1%")
    roll(*args, "--vary", "left.radius=0.0002", "--out", tmp_path / "both")
    roll(*args, "--out", tmp_path / "one")
    both, one = final(tmp_path / "both"), final(tmp_path / "one")
    np.testing.assert_array_equal(both["right.radius"], one["right.radius"])
    np.testing.assert_array_equal(one["left.radius"], one["right.radius"])
    own = both["left.radius"] - both["right.radius"]
    assert own.std() == pytest.approx(0.0002, rel=FOUND_STD)
    assert abs(np.corrcoef(own, one["right.radius"])[0, 1]) < FOUND_MEAN


def test_the_same_seed_gives_the_same_robots(roll):
    def mean(seed, *more):
        args = ("--noise", 0.1, "--vary", "radius=1%", "--seed", seed, *more)
        return roll("mecanum", *STRAIGHT, "--dt", 0.5, *args)["mean"]

    assert mean(1) == mean(1) != mean(2)
    # Sums in single precision are right to seven digits.
    assert mean(1, "--dtype", "float32") == pytest.approx(mean(1), abs=1e-5)


def test_commands_from_a_file_and_a_duration_that_dt_does_not_divide(roll, tmp_path):
    file = tmp_path / "there_and_back.csv"
    file.write_text("VX,VY,WZ\n1,0,0\n1,0,0\n-1,0,0\n")
    told = roll("differential", "--commands", file, "--dt", 1, "--vary", "radius=1%")
    assert told["nominal"] == pytest.approx([1, 0, 0])
    assert told["standard_deviation"][0] == pytest.approx(0.01, rel=FOUND_STD)
    odd = roll("differential", "--twist", 1, 0, 0, "--duration", 1, "--dt", 0.3, "--vary", "x=0")
    assert (odd["steps"], odd["duration"]) == (4, 1.0)
    assert odd["mean"] == pytest.approx([1, 0, 0])


def test_one_robot(ask):
    told = ask("rollout", "omni3", *STRAIGHT, "--noise", 0.1, "--robots", 1)
    assert told["mean"] == told["farthest"]["pose"]
    assert told["standard_deviation"] == [0, 0, 0]


# ---- what is printed and left -----------------------------------------------------------------


def test_people_are_told_and_files_are_left(trundle, tmp_path):
    args = ("rollout", "differential", *STRAIGHT, "--vary", "radius=1%", "--robots", 50)
    code, out, err = trundle(*args, "--out", tmp_path)
    assert (code, err) == (0, "")
    for words in ("nominal", "standard deviation", "farthest, robot", "psi [rad]", "95 % ellipse",
                  "robot-steps per second ("):  # fmt: skip
        assert words in out
    assert {path.name for path in tmp_path.iterdir()} == {"final.npz", "final.csv", "cloud.png"}
    with (tmp_path / "final.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["robot", "x", "y", "psi", "left.radius", "right.radius"]
    np.testing.assert_array_equal([float(row["x"]) for row in rows], final(tmp_path)["x"])
    assert [row["robot"] for row in rows] == [str(k) for k in range(50)]


def test_a_table_too_long_for_people_is_left_out(ask, tmp_path):
    ask("rollout", "differential", *STRAIGHT, "--dt", 10, "--vary", "radius=1%", "--robots",
        100_001, "--out", tmp_path)  # fmt: skip
    assert {path.name for path in tmp_path.iterdir()} == {"final.npz", "cloud.png"}
    assert len(final(tmp_path)["x"]) == 100_001


def test_without_a_compiler_the_command_says_how_to_get_the_speed(ask):
    (note,) = ask("rollout", "omni3", *STRAIGHT, "--noise", 0.1, "--robots", 5)["notes"]
    assert "pip install 'trundle[fast]'" in note


def test_what_the_robot_cannot_do_is_told(ask):
    told = ask("rollout", "differential", "--twist", 0.3, 0.1, 0, "--noise", 1, "--robots", 5)
    assert any("Asked for (0.3, 0.1, 0)" in note for note in told["notes"])


def test_help_teaches_with_an_example(trundle):
    code, out, _ = trundle("rollout", "--help")
    assert code == 0
    assert "trundle rollout mecanum" in out.split("Example")[1]
    assert all(option in out for option in ("--robots", "--noise", "--vary", "--seed"))


# ---- what goes wrong --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("--noise", "1"), "give one of --twist"),
        (STRAIGHT, "all robots are the same"),
        ((*STRAIGHT, "--noise", "-1"), "must not be negative"),
        ((*STRAIGHT, "--noise", "much"), "'much' is not a number"),
        ((*STRAIGHT, "--vary", "radius"), "NAME=SPREAD"),
        ((*STRAIGHT, "--vary", "radius=wide"), "'wide' is not a number"),
        ((*STRAIGHT, "--vary", "radius=-1%"), "must not be negative"),
        ((*STRAIGHT, "--vary", "radius=nan%"), "not a finite number"),
        ((*STRAIGHT, "--vary", "raduis=1%"), "did you mean 'radius'"),
        ((*STRAIGHT, "--vary", "lefd.radius=1%"), "did you mean 'left.radius'"),
        ((*STRAIGHT, "--vary", "mass=1%"), "give one of radius, x, y, arm"),
        ((*STRAIGHT, "--vary", "caster.radius=1%"), "nothing of that name"),
        ((*STRAIGHT, "--vary", "radius=1%", "--vary", "radius=2%"), "'radius' twice"),
        ((*STRAIGHT, "--vary", "left.x=1%"), "a percentage says nothing"),
        ((*STRAIGHT, "--vary", "left.x=0.01"), "displaced like this do not roll together"),
        ((*STRAIGHT, "--vary", "radius=60%"), "is too wide"),
        ((*STRAIGHT, "--vary", "track=1"), "is too wide"),
        ((*STRAIGHT, "--noise", "1", "--robots", "0"), "--robots"),
        ((*STRAIGHT, "--noise", "1", "--robots", "1e4"), "--robots"),
        ((*STRAIGHT, "--noise", "1", "--seed", "-1"), "--seed"),
        ((*STRAIGHT, "--noise", "1", "--dtype", "float16"), "float64 or float32"),
        ((*STRAIGHT, "--noise", "1", "--dt", "1e-9"), "take longer steps"),
        ((*STRAIGHT, "--noise", "1", "--dt", "0"), "positive"),
    ],
)
def test_mistakes_exit_with_2_and_say_why(trundle, args, told):
    code, out, err = trundle("rollout", "differential", *args)
    assert (code, out) == (2, "")
    assert told in " ".join(err.replace("│", " ").split())
    assert "Traceback" not in err


LONG = """
import sys
sys.modules["numba"] = None
from trundle.cli.app import run
print("here", flush=True)
sys.exit(run(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there Ctrl-C reaches the whole console")
def test_an_interrupt_ends_it_without_a_traceback():
    args = "rollout differential --twist 1 0 0 --noise 1 --robots 1000000 --duration 100000"
    with subprocess.Popen(
        [sys.executable, "-c", LONG, *args.split()],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as running:  # fmt: skip
        try:
            assert running.stdout.readline() == "here\n"
            time.sleep(2.0)
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=10)
        finally:
            running.kill()
    assert running.returncode == 130
    assert (out, err.strip()) == ("", "")
