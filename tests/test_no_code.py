"""A robot file runs no code: neither when it is read, nor when its names end up in code."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import trundle
from trundle.exchange import c_files, ros2_controllers, urdf
from trundle.robot import FixedWheel, Robot, to_toml

# Code in Python, in a shell, in C and in YAML, each of which would leave a file behind.
HOSTILE = [
    "__import__('os').system('touch pwned')",
    '"""\n__import__("os").system("touch pwned")\n"""',
    "'); __import__('os').system('touch pwned') #",
    "{__import__('os').system('touch pwned')}",
    "$(touch pwned)`touch pwned`;touch pwned",
    '*/ int x = system("touch pwned"); /*',
    '\nint trundle_x(void) { return system("touch pwned"); }\n',
    "!!python/object/apply:os.system ['touch pwned']",
    "\\input{|touch pwned}",
    "<script>fetch('pwned')</script>",
]
# What Python tells before it does something that reading a file has no need of.
FORBIDDEN = (
    "exec", "compile", "import", "os.system", "os.exec", "os.spawn", "os.posix_spawn", "os.fork",
    "subprocess.Popen", "socket.connect", "socket.getaddrinfo", "urllib.Request", "ctypes.dlopen",
    "os.remove", "os.rename", "os.mkdir", "pickle.find_class", "marshal.loads",
)  # fmt: skip
READER = f"""
import sys
import trundle
paths = sys.argv[1:]
for path in paths:  # what is loaded once, at the first use, is loaded here
    try:
        trundle.load(path)
    except trundle.TrundleError:
        pass
reading = True
def watch(event, args):
    if reading and event in {FORBIDDEN!r}:
        print(event, args, file=sys.stderr)
    if reading and event == "open" and str(args[0]) not in paths:
        print(event, args, file=sys.stderr)
sys.addaudithook(watch)
for path in paths:
    try:
        trundle.load(path)
        print("accepted")
    except trundle.TrundleError:
        print("refused")
reading = False
"""
ENTITY = """<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY stolen SYSTEM "file:///etc/hostname">]>
<robot name="&stolen;"><link name="base_link"/></robot>
"""
BOMB = """<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;">
<!ENTITY e "&d;&d;&d;&d;&d;&d;&d;&d;&d;&d;"><!ENTITY f "&e;&e;&e;&e;&e;&e;&e;&e;&e;&e;">
<!ENTITY g "&f;&f;&f;&f;&f;&f;&f;&f;&f;&f;"><!ENTITY h "&g;&g;&g;&g;&g;&g;&g;&g;&g;&g;">]>
<robot name="&h;&h;&h;&h;"><link name="base_link"/></robot>
"""
INCLUDE = """<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro" xmlns:xi="http://www.w3.org/2001/XInclude">
<xi:include href="file:///etc/hostname" parse="text"/>
<link name="${__import__('os').system('touch pwned')}"/></robot>
"""


def hostile() -> Robot:
    names = HOSTILE[: len(HOSTILE) // 2 * 2]
    wheels = tuple(
        FixedWheel(name=name, x=0.0, y=0.2 if i % 2 else -0.2, radius=0.1)
        for i, name in enumerate(names)
    )
    return Robot(name=HOSTILE[0], wheels=wheels)


def read(tmp_path: Path, *paths: Path) -> subprocess.CompletedProcess[str]:
    here = str(Path(trundle.__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    return subprocess.run(
        [sys.executable, "-c", READER, *map(str, paths)],
        env=os.environ | {"PYTHONPATH": path},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,  # only ends a run that hangs
        check=False,
    )


def test_reading_a_file_opens_it_and_does_nothing_else(tmp_path):
    paths = [tmp_path / "robot.toml", tmp_path / "robot.urdf"]
    paths[0].write_text(to_toml(hostile()), encoding="utf-8")
    paths[1].write_text(urdf(hostile()), encoding="utf-8")
    done = read(tmp_path, *paths)
    assert done.returncode == 0, done.stderr
    assert (done.stdout.split(), done.stderr) == (["accepted", "accepted"], "")
    assert not (tmp_path / "pwned").exists()


@pytest.mark.parametrize("text", [ENTITY, BOMB, INCLUDE], ids=["entity", "bomb", "include"])
def test_xml_takes_nothing_from_elsewhere(tmp_path, text):
    path = tmp_path / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    done = read(tmp_path, path)
    assert done.returncode == 0, done.stderr
    assert (done.stdout, done.stderr) == ("refused\n", "")
    assert not (tmp_path / "pwned").exists()


def test_a_reader_that_ran_code_would_be_seen(tmp_path):
    """The watch itself: a load that runs code is told."""
    path = tmp_path / "robot.toml"
    path.write_text(to_toml(hostile()), encoding="utf-8")
    reckless = READER.replace(
        "reading = True", "reading = True\ntrundle.load = lambda path: eval('1 + 1')"
    )
    here = str(Path(trundle.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", reckless, str(path)],
        env=os.environ | {"PYTHONPATH": here},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "compile" in done.stderr


def test_names_stay_names_in_what_is_made_of_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    robot = hostile()
    trundle.Kinematics(robot).bind()
    for line in ros2_controllers(robot).splitlines():
        named = "touch" in line and not line.startswith("#")
        assert not named or re.fullmatch(r' +\w+: \[("\w+"(, )?)+\]', line)
    c = c_files(robot)
    code = "\n".join(text for name, text in c.items() if name.endswith((".c", ".h")))
    assert "system(" not in without_comments(code)
    assert not (tmp_path / "pwned").exists()


def without_comments(code: str) -> str:
    """Return C without its comments, found as a compiler finds them."""
    out, i = "", 0
    while i < len(code):
        if code.startswith("/*", i):
            i = code.index("*/", i) + 2
        elif code.startswith("//", i):
            i = code.index("\n", i)
        else:
            out, i = out + code[i], i + 1
    return out


@pytest.mark.parametrize("form", ["numpy", "c"])
def test_printed_code_of_hostile_names_does_nothing(trundle, tmp_path, monkeypatch, form):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.toml").write_text(to_toml(hostile()), encoding="utf-8")
    code, out, err = trundle("derive", "robot.toml", "--what", "kinematics", "--format", form)
    assert (code, err) == (0, "")
    if form == "numpy":
        exec(compile(out, "printed", "exec"), {})  # what the user would do with it
    else:
        assert "system(" not in without_comments(out)
    assert not (tmp_path / "pwned").exists()
