"""Names of wheels as other languages and formats take them, and texts that stay what they are.

A wheel may have any name: ``int``, ``a b``, ``*/``, an emoji. C, ROS and URDF may not, so names
are made plain there; what became of a name is told (``renamed``).
"""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from trundle.errors import TrundleError
from trundle.robot import Robot

# What stands in front of a name that may not stand alone, or for one of which nothing is left.
_PREFIX = "wheel"
# C99 tells external names apart by 31 characters, others by 63; a suffix needs room, too.
_LONGEST = 48

# Keywords of C99, of later C and of C++; then what the headers of boards and compilers define.
_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while alignas alignof bool complex constexpr false imaginary noreturn nullptr
static_assert thread_local true typeof typeof_unqual
and and_eq asm bitand bitor catch char16_t char32_t char8_t class co_await co_return co_yield compl
concept consteval constinit const_cast decltype delete dynamic_cast explicit export friend import
module mutable namespace new noexcept not not_eq operator or or_eq private protected public
reinterpret_cast requires static_cast template this throw try typeid typename using virtual wchar_t
xor xor_eq
abs acos asin assert atan atan2 bit boolean byte ceil constrain cos degrees double_t eof errno exp
fabs far float_t floor fmod high hypot i386 index input interrupts j0 j1 jn linux log loop low main
map max memcpy memset min near null output pi pow radians random round serial setup signal sin
size_t sq sqrt stderr stdin stdout tan time unix word y0 y1 yn
"""
_KEYWORDS = frozenset(_WORDS.split())
# Letters that keep no ASCII letter when their accents are taken away.
_LETTERS = {"ß": "ss", "æ": "ae", "œ": "oe", "ø": "o", "ł": "l", "đ": "d", "ı": "i"}
_LETTERS |= {letter.upper(): plain.upper() for letter, plain in _LETTERS.items() if letter != "ß"}


@dataclass(frozen=True)
class JointNames:
    """What URDF and ros2_control call the parts of one wheel.

    ``wheel`` is the joint that rolls, ``steering`` the joint that steers (for steered wheels and
    casters), ``link`` and ``steering_link`` the bodies that the two joints carry.
    """

    wheel: str
    steering: str
    link: str
    steering_link: str


def plain_name(name: str, instead: str = _PREFIX) -> str:
    """Return a name in ASCII letters, digits and single underscores, none of them at an end.

    Accents are taken away; whatever is neither letter nor digit becomes an underscore. A name of
    which nothing is left, or that starts with a digit, gets the word ``instead`` in front.

    >>> [plain_name(each) for each in ("front_left", "a b", "räder", "*/", "1e3", "__x")]
    ['front_left', 'a_b', 'rader', 'wheel', 'wheel_1e3', 'x']
    """
    letters = "".join(_LETTERS.get(letter, letter) for letter in name)
    ascii_only = unicodedata.normalize("NFKD", letters)
    bare = "".join(c for c in ascii_only if not unicodedata.combining(c))
    plain = re.sub(r"[^A-Za-z0-9]+", "_", bare).strip("_")[:_LONGEST].rstrip("_")
    return plain if plain[:1].isalpha() else f"{instead}_{plain}".rstrip("_")


def identifiers(names: Iterable[str]) -> dict[str, str]:
    """Return for each name an identifier that C99, C++ and their headers leave free.

    They differ even where case does not count, so that they may be written in capitals. Names
    that are fit stay as they are; a number keeps others apart.

    >>> identifiers(["int", "a b", "a_b", "Left", "left"])
    {'int': 'wheel_int', 'a b': 'a_b_2', 'a_b': 'a_b', 'Left': 'Left', 'left': 'left_2'}
    """

    def made(name: str) -> str:
        plain = plain_name(name)
        free = plain.lower() not in _KEYWORDS and not plain.lower().startswith("trundle")
        return plain if free else f"{_PREFIX}_{plain}"

    return _apart(list(dict.fromkeys(names)), made, lambda name: {name.lower()})


def joint_names(robot: Robot) -> dict[str, JointNames]:
    """Return the names of each wheel's joints and links, by the name of the wheel.

    They follow ROS: letters, digits and single underscores, no digit at the start. No name is used
    twice in a robot, neither by two joints nor by a joint and a link, and ``base_link`` is free.

    Source: ROS 2 design, Topic and Service name mapping to DDS, "ROS 2 Name Tokens".

    >>> from trundle import load
    >>> joint_names(load("differential"))["left"].wheel
    'left_joint'
    >>> joint_names(load("tricycle"))["front"].steering
    'front_steering_joint'
    """
    stems = _apart(
        [w.name for w in robot.wheels], plain_name, lambda n: set(_parts(n)), {"base_link"}
    )
    return {name: JointNames(*_parts(stem)) for name, stem in stems.items()}


def _parts(stem: str) -> tuple[str, str, str, str]:
    return f"{stem}_joint", f"{stem}_steering_joint", f"{stem}_link", f"{stem}_steering_link"


def _apart(
    names: list[str],
    made: Callable[[str], str],
    taken_by: Callable[[str], set[str]],
    reserved: Iterable[str] = (),
) -> dict[str, str]:
    """Return made(name) for each name, numbered where it takes what another has taken."""
    taken, out = set(reserved), {}
    for name in sorted(names, key=lambda each: made(each) != each):  # fit names first, stable
        stem, again = made(name), 2
        while taken & taken_by(stem):
            stem, again = f"{made(name)}_{again}", again + 1
        taken |= taken_by(stem)
        out[name] = stem
    return {name: out[name] for name in names}


def renamed(names: Mapping[str, str]) -> list[str]:
    """Return a sentence for each name that is called otherwise, fit for a comment of one line.

    >>> renamed({"left": "left", "a b": "a_b"})
    ["wheel 'a b' is called a_b"]
    """
    changed = ((name, new) for name, new in names.items() if name != new)
    return [f"wheel '{one_line(name)}' is called {new}" for name, new in changed]


def one_line(text: str) -> str:
    r"""Return a text for a comment that ends with its line, as YAML's do.

    Line ends and characters that are not printed become escapes.

    >>> print(one_line("*/ \\"), one_line("left\nright"))
    */ \ left\x0aright
    """
    return "".join(c if c.isprintable() else _escape(c) for c in text)


def comment(text: str) -> str:
    r"""Return a text that ends no comment and runs into no other line, in C, YAML and XML.

    Line ends, characters that are not printed (which may turn round what is read) and the
    backslash become escapes; ``*/``, ``/*``, ``--`` and ``??`` are set apart.

    >>> print(comment("a */ b -- c ??/"), comment("left\nint x;"))
    a * / b - - c ? ?/ left\x0aint x;
    """
    shown = "".join(c if c.isprintable() and c != "\\" else _escape(c) for c in text)
    for pair in ("*/", "/*", "--", "??"):
        while pair in shown:
            shown = shown.replace(pair, f"{pair[0]} {pair[1]}")
    return shown


def _escape(letter: str) -> str:
    code = ord(letter)
    return (
        f"\\x{code:02x}"
        if code < 0x100
        else f"\\u{code:04x}"
        if code < 0x10000
        else f"\\U{code:08x}"
    )


def _utf8(text: str) -> bytes:
    """Return the bytes of a text; half a surrogate pair, which is no character, becomes "?"."""
    return text.encode("utf-8", "replace")


def yaml_string(text: str) -> str:
    r"""Return a text as a quoted scalar of YAML, so that ``on``, ``1e3`` and ``null`` stay texts.

    >>> print(yaml_string("null"), yaml_string("ä"), yaml_string('say "on"'))
    "null" "\xe4" "say \"on\""
    """
    safe = _utf8(text).decode()
    return '"' + "".join(_yaml_letter(c) for c in safe) + '"'


def _yaml_letter(letter: str) -> str:
    return json.dumps(letter)[1:-1] if letter.isascii() and letter != "\x7f" else _escape(letter)


def yaml_number(value: float) -> str:
    """Return a number as YAML and ROS read it: a double always has a point.

    >>> yaml_number(2.0), yaml_number(1e-05), yaml_number(-0.25)
    ('2.0', '1.0e-05', '-0.25')
    """
    digits, exponent, power = repr(float(value)).partition("e")
    return digits + ("" if "." in digits else ".0") + exponent + power


def check_xml(robot: Robot) -> None:
    """Raise where a name of the robot has a character that XML cannot hold in any spelling.

    Source: W3C, Extensible Markup Language 1.0, fifth edition, section 2.2, production 2.

    Raises:
        TrundleError: the first such name, and the character.
    """
    texts = [("robot", robot.name)]
    texts += [("wheel", wheel.name) for wheel in robot.wheels]
    groups = dict.fromkeys(wheel.steering_group or "" for wheel in robot.steered)
    texts += [("steering group", group) for group in groups]
    for what, text in texts:
        if found := _NOT_IN_XML.search(text):
            raise TrundleError(
                f"{what} {text!r}: XML cannot hold the character U+{ord(found[0]):04X} of its "
                "name: choose another name"
            )


_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
