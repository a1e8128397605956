"""Names of wheels in C, C++, YAML, XML and ROS: whatever a wheel is called, nothing breaks."""

import itertools
import json
import re
import shutil
import subprocess
import unicodedata
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

import trundle
from trundle.exchange import (
    check_xml,
    comment,
    identifiers,
    joint_names,
    plain_name,
    renamed,
    yaml_number,
    yaml_string,
)
from trundle.robot import FixedWheel, Robot, SteeredWheel

WILD = [
    "int", "a b", "a_b", "a-b", "*/", "/*", "on", "1e3", "null", "🤖", "", "räder", "Rad", "rad",
    "class", "Class", "and", "errno", "sin", "main", "_x", "__x", "x__y", "x_", "trundle_step",
    "\\", "??/", "//", "a\nint b;", "\u202eevil", "\ud800", "'", '"', "<!--", "-->", "]]>", "&amp;",
    "\x00", "\x7f", "\x85", "\ufeff", "٣", "ﬁ", "Ⅷ", "straße", "łódź", "車", "a" * 300, "yes", "~",
    "{}", "- a", "#", "%", "@", "`", "|", ">", "!x", "&x", "*x", "x: y", "wheel", "wheel_int",
]  # fmt: skip
names = st.text() | st.sampled_from(WILD)

# Words of the standards, written down apart from the code: C99 6.4.1, C++20 [lex.key].
_C = (
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while"
)
_CPP = (
    "alignas alignof and and_eq asm bitand bitor bool catch char8_t char16_t char32_t class compl "
    "concept const_cast consteval constexpr constinit co_await co_return co_yield decltype delete "
    "dynamic_cast explicit export false friend mutable namespace new noexcept not not_eq nullptr "
    "operator or or_eq private protected public reinterpret_cast requires static_assert "
    "static_cast template this thread_local throw true try typeid typename using virtual wchar_t "
    "xor xor_eq"
)
C_WORDS, CPP_WORDS = _C.split(), _CPP.split()


@given(st.lists(names))
def test_identifiers_are_plain_and_differ(given_names):
    made = identifiers(given_names)
    assert list(made) == list(dict.fromkeys(given_names))
    for name in made.values():
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", name)
        assert name not in C_WORDS
        assert name not in CPP_WORDS
        assert len(name) <= 63  # C99 5.2.4.1: as far as names are told apart
    assert len({name.upper() for name in made.values()}) == len(made)


def test_fit_names_stay_and_clashes_are_numbered():
    assert identifiers(["a b", "a_b", "a-b"]) == {"a b": "a_b_2", "a_b": "a_b", "a-b": "a_b_3"}
    assert identifiers(["a_b_2", "a b", "a_b"]) == {"a_b_2": "a_b_2", "a b": "a_b_3", "a_b": "a_b"}
    assert identifiers(["front_left", "int", "räder"]) == {
        "front_left": "front_left",
        "int": "wheel_int",
        "räder": "rader",
    }


def test_the_order_of_names_does_not_change_what_fit_names_become():
    for order in itertools.permutations(["a b", "a_b", "A_B"]):
        made = identifiers(order)
        first = min("a_b", "A_B", key=order.index)
        assert made[first] == first
        assert made["a b"] not in ("a_b", "A_B")


def test_every_name_compiles_as_c_and_as_cpp(tmp_path):
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    made = list(identifiers([*WILD, *C_WORDS, *CPP_WORDS]).values())
    lines = ["#include <math.h>", "#include <stdio.h>", "#include <errno.h>", "int main(void) {"]
    lines += [f"    int {name} = 1;" for name in made]
    lines += [f"    {name} += 1;" for name in made]
    lines += [f"    /* {comment(name)} */ // {comment(name)}" for name in WILD]
    text = "\n".join([*lines, "    return 0;", "}", ""])
    for language, standard in (("c", "c99"), ("c++", "c++20")):
        source = tmp_path / f"names.{language}"
        source.write_text(text, encoding="utf-8")
        command = ["gcc", "-x", language, f"-std={standard}", "-Wall", "-Wextra", "-Werror"]
        # Comments of line style are a matter of -pedantic in C99; trigraphs are on there.
        done = subprocess.run(
            [*command, "-fsyntax-only", str(source)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr


def robot(wheels: list[str], kind: type = FixedWheel) -> Robot:
    return Robot(
        name="r",
        wheels=tuple(kind(name=n, x=float(i), y=0.0, radius=0.1) for i, n in enumerate(wheels)),
    )


@given(st.lists(names.filter(str.strip), min_size=1, unique=True))
def test_joints_and_links_follow_ros_and_differ(wheels):
    made = joint_names(robot(wheels, SteeredWheel))
    assert list(made) == wheels
    every = [name for each in made.values() for name in vars(each).values()]
    assert len(set(every)) == len(every)
    assert "base_link" not in every
    for name in every:
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name)
        assert "__" not in name
        assert not name.endswith("_")


def test_a_wheel_called_like_anothers_joint_takes_no_name_twice():
    made = joint_names(robot(["a", "a_steering", "base"], SteeredWheel))
    assert made["a"].steering == "a_steering_joint"
    assert made["a_steering"].wheel == "a_steering_2_joint"
    assert made["base"].link == "base_2_link"


def test_what_was_renamed_is_told_in_one_line():
    told = renamed(identifiers(["left", "int", "a\nb"]))
    assert told == ["wheel 'int' is called wheel_int", "wheel 'a\\x0ab' is called a_b"]


@given(names)
def test_a_comment_ends_nothing(text):
    shown = comment(text)
    for stop in ("*/", "/*", "--", "??", "\\\n", "\n", "\r"):
        assert stop not in shown
    assert not re.search(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]", shown)
    assert not shown.endswith("\\")
    shown.encode("utf-8")
    if text.isalnum() and not set(text) & set("-*/?\\"):
        assert shown == text
    ET.fromstring(f"<!-- '{shown}' --><a/>".replace("<!--", "<x><!--").replace("<a/>", "</x>"))


@given(names)
def test_a_yaml_string_is_read_back(text):
    yaml = pytest.importorskip("yaml")
    whole = text.encode("utf-8", "replace").decode()
    assert yaml.safe_load(yaml_string(text)) == whole
    assert yaml_string(text).isascii()


@given(st.text(st.characters(max_codepoint=0x7E)))
def test_a_yaml_string_of_ascii_is_one_of_json(text):
    assert json.loads(yaml_string(text)) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_yaml_number_is_exact_and_a_double_for_ros(value):
    shown = yaml_number(value)
    assert float(shown) == value
    # YAML 1.1, tag float: a point is needed, and a sign in the exponent.
    assert re.fullmatch(r"-?[0-9]+\.[0-9]*(e[-+][0-9]+)?", shown)


@pytest.mark.parametrize("where", ["robot", "wheel", "steering group"])
def test_xml_refuses_what_it_cannot_hold(where):
    bad = "a\x0bb"
    wheel = SteeredWheel(
        name=bad if where == "wheel" else "w",
        x=0.0,
        y=0.0,
        radius=0.1,
        steering_group=bad if where == "steering group" else None,
    )
    with pytest.raises(trundle.TrundleError, match=rf"{where} 'a\\x0bb': .* U\+000B"):
        check_xml(Robot(name=bad if where == "robot" else "r", wheels=(wheel,)))


@given(names.filter(str.strip))
def test_xml_takes_what_passes_the_check(name):
    try:
        check_xml(robot([name]))
    except trundle.TrundleError:
        lone = any(0xD800 <= ord(c) <= 0xDFFF or c in "\ufffe\uffff" for c in name)
        assert lone or any(unicodedata.category(c) == "Cc" for c in name)
        return
    element = ET.Element("wheel", name=name)
    assert ET.fromstring(ET.tostring(element, encoding="utf-8")).get("name") == name


def test_plain_names_never_leave_their_folder():
    assert plain_name("../../etc/passwd", "robot") == "etc_passwd"
    assert plain_name("..", "robot") == "robot"
    assert plain_name("9", "robot") == "robot_9"
