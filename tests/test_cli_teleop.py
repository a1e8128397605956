"""``trundle teleop``: by a script, by the keys of a real terminal, and what it draws."""

import dataclasses
import math
import os
import re
import select
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import trundle
from trundle.bridge import Bridge, SimulatedRobot
from trundle.cli.driving import MOVES, Desk, Hand, idle_keys
from trundle.cli.keys import keys_of
from trundle.cli.live import Dashboard, Shown
from trundle.cli.minimap import Canvas, Window, follow, outline
from trundle.robot import CATALOG, Encoder, load

ENCODER = Encoder(ticks_per_motor_turn=2048)
TIMEOUT = 0.7


# ---- by a script ----------------------------------------------------------------------------


def test_a_script_drives_and_comes_to_rest(ask):
    told = ask("teleop", "differential", "--play", "i:2")
    # 0.5 m/s, reached at 1 m/s^2 and left at 2 m/s^2: half of 0.5 s, 1.5 s, half of 0.25 s.
    way = 0.125 + 0.75 + 0.0625
    # Noise of 1e-4 m per metre on each of two wheels: 7 mm, taken four times; and the lag of the
    # motors, 0.05 s, of which a cycle after rest is left.
    assert told["truth"][0] == pytest.approx(way, abs=0.03)
    assert told["pose"][0] == pytest.approx(way, abs=0.02)
    assert told["distance"] == pytest.approx(way, abs=0.03)
    assert told["duration"] == pytest.approx(2.25, abs=0.021)  # a cycle more or less
    assert told["slipping"] == []
    assert told["refused"] == [0, 0]
    assert told["files"] == []


@pytest.mark.parametrize("robot", CATALOG)
def test_the_whole_catalogue_drives(ask, robot):
    told = ask("teleop", robot, "--play", "i:1 u:1 l:0.5 L:0.5 down:0.5")
    assert told["refused"] == [0, 0]
    assert told["slipping"] == []
    # Standard deviations from the truth: of some hundred drives one is off by four of them.
    away = np.abs(np.subtract(told["pose"], told["truth"]))
    assert (away < 4 * np.array(told["sigma"]) + 1e-3).all()


def test_keys_change_the_speed(ask):
    slow = ask("teleop", "omni3", "--play", "- - i:1")
    fast = ask("teleop", "omni3", "--play", "+ + i:1")
    assert fast["distance"] > slow["distance"] + 0.05


def test_a_slipping_wheel_is_told(ask, trundle):
    told = ask("teleop", "mecanum", "--play", "i:2", "--slip", "front_left=0.3")
    assert "front_left" in told["slipping"]
    _, out, _ = trundle("teleop", "mecanum", "--play", "i:2", "--slip", "front_left=0.3")
    assert "the wheels did not agree: " in out


def test_out_leaves_a_run_a_log_and_a_picture(ask, tmp_path):
    target = tmp_path / "drive"
    told = ask("teleop", "ackermann", "--play", "i:2 u:2", "--out", target)
    assert told["files"] == [str(target / name) for name in ("run.csv", "log.csv", "path.png")]
    run = trundle_run(target / "run.csv")
    assert run.pose[-1].tolist() == told["pose"]
    assert run.t[-1] == told["duration"]
    assert run.driven == ("rear_left", "rear_right")
    again = ask("odometry", "ackermann", target / "log.csv")
    # The log's angles are those of whole ticks, summed up: a few digits fewer.
    np.testing.assert_allclose(again["pose"], told["pose"], atol=1e-9)
    assert again["error"]["end_error"] == pytest.approx(
        math.dist(told["pose"][:2], told["truth"][:2]), abs=1e-9
    )


def trundle_run(path):
    return trundle.simulation.Run.load(path)


def test_encoders_of_the_robot_file_leave_counts(ask, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    robot = load("differential").with_wheels(encoder=Encoder(ticks_per_motor_turn=500, gear=30))
    trundle.robot.save(robot, "mine.toml")
    told = ask("teleop", "mine.toml", "--play", "m:2", "--out", "drive")
    header = (tmp_path / "drive" / "log.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header == "time,x,y,psi,counts:left,counts:right"
    again = ask("odometry", "mine.toml", "drive/log.csv", "--counter-bits", "32")
    np.testing.assert_allclose(again["pose"], told["pose"], atol=1e-9)


def test_counts_run_on_below_zero(ask, tmp_path, monkeypatch):
    """A reversed wheel counts down from 0; who drives the log again need not know the counter."""
    monkeypatch.chdir(tmp_path)
    made = load("differential")
    left, right, *others = made.with_wheels(encoder=Encoder(ticks_per_motor_turn=500)).wheels
    left = dataclasses.replace(left, reversed=True)
    trundle.robot.save(dataclasses.replace(made, wheels=(left, right, *others)), "mine.toml")
    told = ask("teleop", "mine.toml", "--play", "i:1 l:1 m:1", "--out", "drive")
    again = ask("odometry", "mine.toml", "drive/log.csv")
    np.testing.assert_allclose(again["pose"], told["pose"], atol=1e-9)  # rounding of sums
    column = np.loadtxt("drive/log.csv", delimiter=",", skiprows=1)[:, 4]
    assert column.min() < 0
    assert np.abs(np.diff(column)).max() < 100  # 1 m/s of a wheel of 5 cm: 32 ticks in a cycle


def test_a_speed_beyond_the_limit_is_capped_and_told(ask, trundle):
    told = ask("teleop", "differential", "--play", "i:3", "--speed", 5)
    most = ask("teleop", "differential", "--play", "i:3", "--speed", 1)
    assert told["truth"] == most["truth"]
    assert told["notes"] == ["--speed 5 is beyond --max-speed: keys drive at 1 m/s"]
    assert most["notes"] == []
    _, out, _ = trundle("teleop", "differential", "--play", "i:0.1", "--speed", 5)
    assert told["notes"][0] in out


def test_plus_ends_at_the_limit(ask):
    played = "+ + + + + + + + + i:0.1"  # 0.5 m/s is doubled by seven and a bit of 1.1
    told = ask("teleop", "differential", "--play", played)
    assert told["notes"] == ["the speed is as high as it may be: + does nothing"]
    assert ask("teleop", "differential", "--play", "+ + i:0.1")["notes"] == []
    hand = Hand(speed=0.5, turn=1.0, timeout=TIMEOUT, most=2.0)
    for _ in range(20):
        hand = hand.press("+", 0.0)
    assert hand.press("i", 0.0).command == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("robot", "played", "notes"),
    [
        ("differential", "i:0.1 J:0.1 L:0.1", ["move sideways: J, L, q, e do nothing"]),
        ("differential", "i:0.1 U:0.1", []),
        ("bicycle", "left:0.1 q:0.1",
         ["turn on the spot: j, l, left, right, a, d do nothing",
          "move sideways: J, L, q, e do nothing"]),
        ("mecanum", "J:0.1 q:0.1 j:0.1 k:0.1", []),
    ],
)  # fmt: skip
def test_keys_that_do_nothing_are_told(ask, robot, played, notes):
    told = ask("teleop", robot, "--play", played)
    assert told["notes"] == [f"{robot} cannot {note}" for note in notes]


def test_a_wheel_that_drags_turns_too_little(ask):
    """Below 0, 1 - slip is what the floor passes for a turn: 1.5 m for each metre that is told."""
    slips = ("--slip", "left=-0.5", "--slip", "right=-0.5")
    told = ask("teleop", "differential", "--play", "i:2", *slips)
    # 1.4 m are told for a drive of 2.1 m or so, each within the noise of millimetres.
    assert told["truth"][0] == pytest.approx(1.5 * told["pose"][0], rel=0.02)


def test_the_help_tells_what_a_negative_slip_is(trundle):
    assert "Below 0 it drags" in " ".join(trundle("teleop", "--help")[1].split())


def test_the_command_for_the_log_is_in_one_line(trundle, tmp_path, monkeypatch):
    target = tmp_path / ("a folder with a long name " * 4)
    monkeypatch.setattr("trundle.cli.output.out._width", 80)
    _, out, _ = trundle("teleop", "differential", "--play", "i:0.1", "--out", target)
    lines = [line.strip() for line in out.splitlines()]
    assert str(target / "run.csv") in lines
    assert f"trundle odometry differential '{target / 'log.csv'}'  drives the log again" in lines


def test_an_interrupted_picture_leaves_the_drive(ask, tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("trundle.view.plot_path", interrupt)
    told = ask("teleop", "differential", "--play", "i:0.1", "--out", tmp_path / "drive")
    assert told["files"] == [str(tmp_path / "drive" / name) for name in ("run.csv", "log.csv")]


def test_a_file_is_no_folder(trundle, tmp_path):
    (tmp_path / "afile").write_text("")
    code, _, err = trundle("teleop", "omni3", "--play", "i:0.2", "--out", tmp_path / "afile")
    assert code == 2
    assert "afile: nothing can be written there: it is a file, not a folder" in " ".join(
        err.split()
    )


def test_a_drive_is_not_overwritten(trundle, tmp_path):
    target = tmp_path / "drive"
    assert trundle("teleop", "omni3", "--play", "i:0.2", "--out", target)[0] == 0
    before = (target / "run.csv").read_bytes()
    code, _, err = trundle("teleop", "omni3", "--play", "i:1", "--out", target)
    assert code == 2
    assert "run.csv is there already, and a drive is not overwritten" in err
    assert (target / "run.csv").read_bytes() == before


@pytest.mark.parametrize("play", ["", "+", "k:0.5"])
def test_a_drive_that_goes_nowhere_is_a_drive(ask, play, tmp_path):
    told = ask("teleop", "swerve", "--play", play, "--out", tmp_path / "drive")
    assert told["distance"] == 0.0
    assert len(told["files"]) == 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--play", "z:1"], "--play: there is no key 'z'; keys are i u o"),
        (["--play", "i"], "--play: how long is 'i' held? Write i:1 for a second"),
        (["--play", "i:1 +:2"], "--play: '+:2': + and - are pressed, not held: write + alone"),
        (["--play", "i:-1"], "--play: 'i:-1': a key cannot be held for -1 s"),
        (["--play", "i:long"], "--play: 'i:long': 'long' is not a number"),
        (["--play", "i:1e9"], "--play drives for at most 3600 s"),
        (["--play", "i:1", "--slip", "left"], "--slip needs WHEEL=SHARE, such as left=0.2"),
        (["--play", "i:1", "--slip", "lft=0.2"], "no wheel 'lft'"),
        (["--play", "i:1", "--slip", "left=1"], "its slip must be a number below 1, got 1.0"),
        (["--play", "i:1", "--rate", "1"], "--rate takes 10 to 500 Hz, got 1"),
        ([], 'or give the keys as --play "i:2 l:1"'),
    ],
)
def test_mistakes_are_told(trundle, arguments, message):
    code, out, err = trundle("teleop", "differential", *arguments)
    assert code == 2
    assert message in " ".join(err.split())
    assert out == ""


_INTERRUPTED_IMPORT = """
import sys
from trundle.cli import main
class Interrupt:
    def find_spec(self, name, *_):
        if name == "typer":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupt())
main()
"""


def test_an_interrupt_while_all_is_loaded_is_no_traceback():
    done = subprocess.run(
        [sys.executable, "-c", _INTERRUPTED_IMPORT], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


# ---- keys -----------------------------------------------------------------------------------


def test_what_terminals_send_for_keys():
    assert list(keys_of("iI,<")) == ["i", "I", ",", "<"]
    assert list(keys_of("\x1b[A\x1bOB\x1b[1;5C")) == ["up", "down", "right"]
    assert list(keys_of("\x1b[15~\x1b[200~x\x1b[I")) == ["x"]  # F5, a paste, the window's focus
    assert list(keys_of(" \x03\x1a\x1b")) == ["space", "interrupt", "suspend", "escape"]


def test_a_key_that_repeats_and_stays_away_is_let_go():
    hand = Hand(speed=0.5, turn=1.0, timeout=TIMEOUT).press("i", 1.0)
    assert not hand.let_go(50.0)  # it came once: the bridge's watchdog sees to it
    hand = hand.press("i", 1.5)  # the keyboard waits before it repeats
    assert not hand.let_go(2.1)
    for k in range(1, 4):
        hand = hand.press("i", 1.5 + 0.03 * k)
    assert not hand.let_go(1.59 + 0.19)
    assert hand.let_go(1.59 + 0.21)
    assert hand.released().command == (0.0, 0.0, 0.0)


def test_another_key_is_no_repetition():
    hand = Hand(speed=0.5, turn=1.0, timeout=TIMEOUT).press("i", 1.0).press("u", 1.1)
    assert hand.command == (0.5, 0.0, 1.0)
    assert not hand.let_go(1.6)
    assert hand.press("?", 1.2) == hand
    assert hand.press("+", 1.2).command == pytest.approx((0.55, 0.0, 1.1))
    assert hand.press("-", 1.2).command == pytest.approx((0.5 / 1.1, 0.0, 1 / 1.1))


def test_the_keys_of_teleop_twist_keyboard():
    """The letters, each with the signs of x, y and yaw that its users know."""
    known = {
        "i": (1, 0, 0), "o": (1, 0, -1), "j": (0, 0, 1), "l": (0, 0, -1), "u": (1, 0, 1),
        ",": (-1, 0, 0), ".": (-1, 0, 1), "m": (-1, 0, -1),
        "O": (1, -1, 0), "I": (1, 0, 0), "J": (0, 1, 0), "L": (0, -1, 0), "U": (1, 1, 0),
        "<": (-1, 0, 0), ">": (-1, -1, 0), "M": (-1, 1, 0),
    }  # fmt: skip
    assert {key: MOVES[key] for key in known} == known


# ---- what is drawn --------------------------------------------------------------------------


def driven(name, seconds=1.0, command=(0.5, 0.2, 0.4)):
    """Return a dashboard and what it shows after a drive."""
    robot = load(name)
    desk = Desk(
        Bridge(robot, encoder=ENCODER, max_acceleration=1.0), SimulatedRobot(robot, encoder=ENCODER)
    )
    view = Dashboard(robot, [10.0] * len(robot.driven), ENCODER)
    for k in range(1, round(50 * seconds) + 1):
        view.note(desk.cycle(k / 50, command), k / 50)
    hand = Hand(speed=0.5, turn=1.0, timeout=TIMEOUT)
    return view, Shown(desk.output, desk.state, desk.truth, hand, 50.0)


@pytest.mark.parametrize("size", [(80, 24), (120, 40), (60, 16), (20, 5), (300, 100), (10, 1)])
@pytest.mark.parametrize("name", ["omni3", "swerve", "mixed", "ackermann"])
def test_lines_fit_the_terminal(name, size):
    view, shown = driven(name, 0.2)
    lines = view.lines(shown, *size)
    assert len(lines) == min(size[1], max(size[1], 1))
    assert {line.cell_len for line in lines} == {size[0] - 1}


@pytest.mark.parametrize("name", CATALOG)
def test_everything_is_there_at_80_by_24(name):
    view, shown = driven(name)
    text = "\n".join(line.plain.rstrip() for line in view.lines(shown, 80, 24))
    for wheel in (*view.robot.driven, *view.robot.steered):
        assert wheel.name[:9] in text
    for word in ("odometry", "1 sigma", "measured", "LIMIT", "SLIP", "REFUSED", "x quit", "50 Hz"):
        assert word in text
    assert f"{shown.output.pose[0]:.3f}" in text
    assert f"{shown.output.wheel_speeds[0]:.2f}" in text
    assert f"{shown.output.rpm[0]:.1f}" in text
    assert any("⠀" < mark <= "⣿" for mark in text)  # the robot, in braille


def test_numbers_stand_out_from_their_labels():
    view, shown = driven("omni3")
    line = view.lines(shown, 60, 24)[2]  # x, without a map beside it
    assert line.plain.startswith("x [m] ")
    assert "dim" in {str(span.style) for span in line.spans if span.start == 0}
    assert not [span for span in line.spans if span.end > 11]
    assert not line.style


def test_a_terminal_without_special_characters_gets_none():
    view, shown = driven("mecanum")
    plain = dataclasses.replace(view, ascii_only=True)
    text = "\n".join(line.plain for line in plain.lines(shown, 100, 30))
    assert text.isascii()
    assert "*" in text


def test_numbers_keep_their_columns():
    view, shown = driven("omni3")
    far = dataclasses.replace(shown, truth=(-123456.789, 1e12, 700.0))
    lines = [line.plain for line in view.lines(far, 80, 24)]
    assert {len(line) for line in lines} == {79}
    assert "-1.23e+05" in lines[2]
    assert "1e+12" in lines[3]


@pytest.mark.parametrize(
    ("command", "stale", "twist", "word"),
    [
        ((0.5, 0.0, 0.0), False, (0.3, 0.0, 0.0), "driving"),
        ((0.5, 0.0, 0.0), True, (0.3, 0.0, 0.0), "stopping: no key"),
        ((0.0, 0.0, 0.0), False, (0.3, 0.0, 0.0), "stopping"),
        ((0.0, 0.5, 0.0), False, (0.0, 0.0, 0.0), "held back"),
        ((0.5, 0.0, 0.0), True, (0.0, 0.0, 0.0), "at rest"),
    ],
)
def test_what_the_robot_does_is_told(command, stale, twist, word):
    view, shown = driven("differential", 0.1)
    shown = dataclasses.replace(
        shown,
        output=shown.output._replace(stale=stale, twist=twist),
        state=shown.state._replace(command=command),
    )
    assert f" {word} " in view.lines(shown, 80, 24)[0].plain


def shown_at(view, shown, time, width=80):
    """Return the lines that are shown at another time."""
    shown = dataclasses.replace(shown, state=shown.state._replace(time=time))
    return [line.plain.rstrip() for line in view.lines(shown, width, 24)]


def test_keys_that_do_nothing_are_told_until_that_is_read():
    view, shown = driven("differential")
    assert [view.idle(key) for key in ("i", "U", "+", "k", "x", "suspend")] == [""] * 6
    assert view.idle("z") == "z does nothing"
    assert view.idle("\x01") == "'\\x01' does nothing"
    view.tell(view.idle("J"), 1.0)
    told = "differential cannot move sideways: J, L, q, e do nothing"
    assert shown_at(view, shown, 2.0)[-2] == f" {told}"
    later = shown_at(view, shown, 9.0)
    assert later[-2].endswith("let go to stop")
    assert "sideways" not in later[-1]


def test_a_robot_is_not_offered_what_it_cannot_do():
    assert idle_keys(load("mecanum")) == {}
    view, shown = driven("bicycle")
    assert "turn" not in shown_at(view, shown, 1.0)[-1]


def test_the_speed_at_its_limit_is_told():
    view, shown = driven("omni3")
    assert "the most" not in shown_at(view, shown, 1.0)[-2]
    shown = dataclasses.replace(shown, hand=dataclasses.replace(shown.hand, most=1.0))
    assert "0.5 m/s, 1 rad/s, the most" in shown_at(view, shown, 1.0)[-2]


@pytest.mark.parametrize("width", [60, 20])
def test_how_to_quit_is_told_where_it_is_narrow(width):
    view, shown = driven("mecanum")
    assert shown_at(view, shown, 1.0, width)[-1].startswith(" x quit")


@pytest.mark.parametrize(
    ("slipping", "told"),
    [
        (["front_left"], "front_left"),
        (["front_left", "front_right", "rear_left"], "3 of 4 wheels"),
        (["front_left", "front_right", "rear_left", "rear_right"], "4 of 4 wheels"),
        ([], "none"),
    ],
)
def test_slipping_wheels_are_told_or_counted(slipping, told):
    view, shown = driven("mecanum")
    odometry = shown.output.odometry._replace(slipping=tuple(slipping))
    view.note(shown.output._replace(odometry=odometry), 1.0)
    (line,) = [line for line in shown_at(view, shown, 1.0) if " SLIP " in line]
    assert line.endswith(f" {told}")


# ---- the map --------------------------------------------------------------------------------


def test_dots_go_where_they_should():
    canvas = Canvas(2, 2)
    canvas.dot(0, 0, "")  # below left: dot 7 of the lower left character
    canvas.dot(3, 7, "")  # above right: dot 4 of the upper right one
    canvas.dot(4, 0, "")  # outside
    canvas.dot(-1, 0, "")
    assert [row.plain for row in canvas.rows()] == [" ⠈", "⡀ "]
    far = Canvas(2, 2)
    far.line((math.nan, 0.0), (1.0, 1.0), "")
    far.line((0.0, 0.0), (1e300, 0.0), "")
    assert [row.plain for row in far.rows()] == ["  ", "  "]


def test_the_map_keeps_the_robot_in_view_and_stays_calm():
    canvas = Canvas(34, 20)
    window, path, changes = None, [], 0
    for k in range(2000):
        x, y = 0.05 * k, 3 * math.sin(0.02 * k)
        path.append((x, y))
        xs, ys = zip(*path, strict=True)
        box = (min(xs) - 0.25, min(ys) - 0.25, max(xs) + 0.25, max(ys) + 0.25)
        before, window = window, follow(window, 0.5, (x, y, 0.0), box, canvas)
        changes += window != before
        [(dot_x, dot_y)] = window.dots([(x, y)], canvas)
        assert 0 <= dot_x < canvas.width
        assert 0 <= dot_y < canvas.height
    assert 0.5 / window.size > 5  # the outline is still seen
    assert changes < 60  # in 2000 pictures


def test_the_outline_is_the_body_or_goes_round_the_wheels():
    body = load("mecanum").body
    corners = np.array(outline(load("mecanum")))
    assert np.ptp(corners, axis=0) == pytest.approx([body.length, body.width])
    bare = dataclasses.replace(load("mecanum"), body=None)
    inside = np.array(outline(bare))
    for wheel in bare.wheels:
        assert (inside.min(axis=0) < (wheel.x, wheel.y)).all()
        assert (inside.max(axis=0) > (wheel.x, wheel.y)).all()
    window = Window(0.0, 0.0, 0.1)
    assert window.dots([(0.0, 0.0)], Canvas(10, 5)) == [(10.0, 10.0)]


# ---- a real terminal ------------------------------------------------------------------------

# A machine under load is slow; nothing waits for so long but a fault [s].
PATIENCE = 30.0
needs_terminal = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")


_COMMAND = "import sys; from trundle.cli.app import run; sys.exit(run())"


class Terminal:
    """A pseudo-terminal of 80 x 24 in which the command runs."""

    def __init__(self, *arguments, before=""):
        import fcntl
        import struct
        import termios

        self.termios = termios
        self.master, self.slave = os.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.told = ""
        environment = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES")}
        self.process = subprocess.Popen(
            [sys.executable, "-c", before + _COMMAND, "teleop", *map(str, arguments)],
            stdin=self.slave,
            stdout=self.slave,
            stderr=self.slave,
            env=environment | {"TERM": "xterm-256color", "PYTHONIOENCODING": "utf-8"},
            start_new_session=True,
        )

    def type(self, keys):
        os.write(self.master, keys.encode())

    def wait(self, pattern, press=""):
        """Wait until what is told since the last call matches; hold a key meanwhile."""
        end = time.monotonic() + PATIENCE
        start = len(self.told)
        while not (found := re.search(pattern, self.told[start:])):
            assert time.monotonic() < end, f"no {pattern!r} in {self.told[start:]!r}"
            if press:
                self.type(press)
            if select.select([self.master], [], [], 0.03)[0]:
                try:
                    self.told += os.read(self.master, 65536).decode(errors="replace")
                except OSError:  # the other side is closed
                    assert re.search(pattern, self.told[start:]), self.told[start:]
        return found

    def end(self):
        """Return the exit code, once the terminal is seen to be as it was before."""
        code = self.process.wait(PATIENCE)
        while select.select([self.master], [], [], 0)[0]:
            self.told += os.read(self.master, 65536).decode(errors="replace")
        assert self.termios.tcgetattr(self.slave) == self.before
        assert self.told.index("\x1b[?1049h") < self.told.rindex("\x1b[?1049l")
        assert self.told.rindex("\x1b[?25h") > self.told.rindex("\x1b[?25l")
        return code

    def close(self):
        self.process.kill()
        self.process.wait()
        for side in (self.master, self.slave):
            os.close(side)


@pytest.fixture
def terminal():
    made = []

    def start(*arguments, **settings):
        made.append(Terminal(*arguments, **settings))
        return made[-1]

    yield start
    for each in made:
        each.close()


@needs_terminal
def test_keys_of_a_real_terminal_drive_the_robot(terminal, tmp_path):
    shell = terminal("omni3", "--max-deceleration", "0.5", "--out", tmp_path / "drive")
    shell.wait("press a key")
    assert shell.termios.tcgetattr(shell.slave) != shell.before
    shell.wait("driving", press="i")
    shell.wait(r"0\.500 +0\.500", press="\x1b[A")  # asked and given
    shell.wait(r"stopping[\s\x1b]")  # let go; "stopping: no key" would be the watchdog
    shell.wait("at rest")
    shell.type("\x1a")  # nothing resumes a program here, so it goes on at once
    shell.wait(re.escape("\x1b[?1049l") + r"[\s\S]*" + re.escape("\x1b[?1049h"))
    shell.wait("at rest")
    shell.type("x")
    shell.wait(r"where it is[\s\S]*drives the log again")
    assert shell.end() == 0
    run = trundle.simulation.Run.load(tmp_path / "drive" / "run.csv")
    assert run.pose[-1, 0] > 0.05
    assert np.median(np.diff(run.t)) == pytest.approx(0.02, rel=0.2)


@needs_terminal
@pytest.mark.parametrize(("end", "code"), [("\x03", 0), (signal.SIGTERM, 143)])
def test_the_terminal_is_restored_whatever_ends_the_drive(terminal, end, code):
    shell = terminal("differential")
    shell.wait("press a key")
    if isinstance(end, str):
        shell.type(end)
    else:
        shell.process.send_signal(end)
    shell.wait("where it is")
    assert shell.end() == code


@needs_terminal
def test_a_fault_restores_the_terminal(terminal):
    """What goes wrong in the middle of a drive is told on a terminal that works."""
    broken = "from trundle.cli.live import Screen; Screen.draw = lambda *_: 1 / 0; "
    shell = terminal("differential", before=broken)
    shell.wait("ZeroDivisionError")
    assert shell.end() == 1
    assert "This is a fault of trundle, not yours" in shell.told


@needs_terminal
def test_mistakes_are_told_before_the_screen_is_taken(terminal):
    shell = terminal("differential", "--slip", "caster=0.1")
    shell.wait("error: ")
    assert shell.process.wait(PATIENCE) == 2
    assert "\x1b[?1049h" not in shell.told


@needs_terminal
def test_a_terminal_that_goes_away_ends_the_drive_and_keeps_it(terminal, tmp_path):
    shell = terminal("differential", "--out", tmp_path / "drive")
    shell.wait("press a key")
    shell.wait("driving", press="i")
    os.close(shell.master)
    try:
        assert shell.process.wait(PATIENCE) == 129
    finally:
        shell.master = os.open(os.devnull, os.O_RDONLY)
    assert trundle.simulation.Run.load(tmp_path / "drive" / "run.csv").pose[-1, 0] > 0


_SIGNALS_WHILE_WRITING = """
import os, signal
from trundle.cli import teleop
leave = teleop._leave
def bombarded(*given):
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM) * 2:
        os.kill(os.getpid(), number)
    return leave(*given)
teleop._leave = bombarded
"""


@needs_terminal
@pytest.mark.parametrize(("end", "code"), [("\x03", 0), (signal.SIGHUP, 129)])
def test_signals_while_the_files_are_written_lose_nothing(terminal, tmp_path, end, code):
    """Ctrl-C twice in a hurry; a terminal that closes and a shell that passes it on."""
    shell = terminal("differential", "--out", tmp_path / "drive", before=_SIGNALS_WHILE_WRITING)
    shell.wait("press a key")
    shell.wait("driving", press="i")
    if isinstance(end, str):
        shell.type(end)
    else:
        shell.process.send_signal(end)
    shell.wait(re.escape("\x1b[?1049l"))
    assert shell.process.wait(PATIENCE) == code
    assert trundle.simulation.Run.load(tmp_path / "drive" / "run.csv").pose[-1, 0] > 0
    assert (tmp_path / "drive" / "log.csv").stat().st_size > 100


@needs_terminal
def test_a_drive_that_does_not_listen_is_interrupted_and_kept(terminal, tmp_path):
    stuck = (
        "import time; from trundle.cli.live import Screen; "
        "Screen.draw = lambda *_: (print('stuck', flush=True), time.sleep(60)); "
    )
    shell = terminal("differential", "--out", tmp_path / "drive", before=stuck)
    shell.wait("stuck")
    for _ in range(3):
        shell.process.send_signal(signal.SIGTERM)
        time.sleep(0.2)  # one by one
    shell.wait("where it is")
    assert shell.end() == 143
    assert (tmp_path / "drive" / "log.csv").exists()


@needs_terminal
def test_unknown_keys_are_told(terminal):
    shell = terminal("differential", "--speed", "5")
    shell.wait("--speed 5 is beyond --max-speed: keys drive at 1 m/s")
    shell.type("z")
    shell.wait("z does nothing")
    shell.type("J")
    shell.wait("cannot move sideways: J, L, q, e do nothing")
    shell.type("+")
    shell.wait("2 rad/s.*, the most")
    shell.type("x")
    shell.wait("keys drive at 1 m/s")
    assert shell.end() == 0
