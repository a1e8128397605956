"""``trundle derive``: documents that can be read, and the command that writes them."""

import dataclasses
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy
import typer

import trundle
from catalogue import ROBOTS
from golden_text import agrees_with_golden
from trundle import symbolic
from trundle.cli.derive import derive
from trundle.cli.numbers import NumbersCommand
from trundle.errors import OffCentreError, TrundleError
from trundle.robot import CATALOG
from trundle.symbolic import (
    TOPICS,
    Document,
    code,
    document,
    render_html,
    render_latex,
    render_text,
)
from trundle.symbolic.document import Law, Section, Step, Value
from trundle.symbolic.document.layout import lines_of, width
from trundle.symbolic.document.plain_math import plain_math
from trundle.symbolic.document.tex import formula_latex
from trundle.symbolic.document.text import formula_lines

WIDTH = 100
MATHML = "http://www.w3.org/1998/Math/MathML"
# Numbers in documents have five digits.
SHOWN = 5e-5
# A few of them added up, where their difference is not small.
SUMMED = 5e-4

each_catalogue_robot = pytest.mark.parametrize("name", CATALOG)
# The others among the awkward mixtures are like one of these, and take long.
each_robot = pytest.mark.parametrize("name", [*CATALOG, "skew_skid"])


@cache
def whole(name: str) -> Document:
    return document(ROBOTS[name], steps=True)


def steps_of(made: Document) -> list[Step]:
    return [step for section in made.sections for step in section.steps]


def values_of(made: Document) -> list[Value]:
    formulas = [formula for step in steps_of(made) for formula in step.formulas]
    return [formula for formula in formulas if isinstance(formula, Value)]


# ---- what stands in a document ---------------------------------------------------------------


@each_robot
def test_every_robot_has_every_topic(name: str) -> None:
    headings = [section.heading for section in whole(name).sections]
    assert headings == [
        "Notation",
        "Kinematics",
        "What the robot can do",
        "The pseudo-inverse of W",
        "The body as a chain of joints",
        "Equations of motion of the body",
        "Wheel torques",
    ]


@each_robot
def test_w_stands_there_with_the_numbers_of_the_kinematics(name: str) -> None:
    """At the position that the document tells; the last formula for W has the numbers."""
    robot = ROBOTS[name]
    steering = (
        trundle.Kinematics(robot).inverse((1.0, 0.2, 0.25 / robot.reach), limit=False).steering
    )
    told = [each for each in values_of(whole(name)) if each.left == "W"][-1]
    shown = told.right if told.numbers is None else told.numbers
    W = trundle.Kinematics(robot).wheel_matrix(steering if robot.steered else None)
    got = np.array(shown.tolist(), dtype=np.float64)
    assert got == pytest.approx(W, rel=SHOWN, abs=1e-12)


@each_catalogue_robot
def test_numbers_are_those_of_the_symbols(name: str) -> None:
    """Each formula's numbers against its symbols, at the sizes of the notation table."""
    from trundle.symbolic.document.case import case_of

    case = case_of(ROBOTS[name])
    values = case.values | case.masses
    for each in values_of(whole(name)):
        if each.numbers is None:
            continue
        entries, shown = entries_of(each.right), entries_of(each.numbers)
        assert len(entries) == len(shown)
        for entry, number in zip(entries, shown, strict=True):
            there = dict.fromkeys(entry.free_symbols | number.free_symbols, 0.7)
            want = float(entry.evalf(subs=there | values))
            got = float(number.evalf(subs=there))
            assert got == pytest.approx(want, rel=SUMMED, abs=1e-9)


def entries_of(expression: Any) -> list[Any]:
    if isinstance(expression, sympy.MatMul):
        expression = expression.as_explicit()
    return list(expression) if isinstance(expression, sympy.MatrixBase) else [expression]


def test_without_steps_only_results_are_left() -> None:
    few = document(ROBOTS["omni3"])
    assert not any(step.detail for step in steps_of(few))
    headings = [step.heading for step in steps_of(few)]
    assert "Wheel 1 (wheel_1)" not in headings
    assert {"W", "Equations of motion", "Wheel torques"} <= set(headings)


@pytest.mark.parametrize("topic", TOPICS)
def test_a_topic_comes_alone_with_its_notation(topic: str) -> None:
    made = document(ROBOTS["differential"], topic)
    assert made.title == f"differential: {topic}, derived"
    assert made.sections[0].heading == "Notation"
    assert len(made.sections) < len(whole("differential").sections)


def test_missing_masses_are_named_and_the_symbols_still_there() -> None:
    wheels = (
        trundle.FixedWheel(name="left", x=0.0, y=0.2, radius=0.05),
        trundle.FixedWheel(name="right", x=0.0, y=-0.2, radius=0.05),
    )
    text = render_text(document(trundle.Robot(name="bare", wheels=wheels), "dynamics"))
    assert "the body's mass, inertia, com are missing" in " ".join(text.split())
    assert "M₁₁" in text or "⎡" in text.partition("M(q)")[2]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("ackermann", "steering of wheel 2 is not free: it follows from the centre of rotation"),
        ("swerve", "steering of wheels 2 and 4 is not free"),
        ("skid_steer", "least sum of squares of the side slips"),
        ("mixed", "caster_left (caster) follows every motion"),
        ("odd_omni", "loose is not driven, and its rollers let it follow every motion"),
        ("odd_omni", "the entries of W are long"),
        ("synchro", "Neither pseudo-inverse of the lectures exists"),
        ("mecanum", "by a Lagrange multiplier"),
        ("differential", "by least squares"),
        ("odd_differential", "this robot's dependencies between sizes"),
        ("differential", "It is the same as the rolling rows"),
        ("mecanum", "It is the same as the rolling rows"),
        ("tricycle", "depends on that choice of units"),
    ],
)
def test_special_cases_are_told_in_words(name: str, words: str) -> None:
    told = " ".join(render_text(whole(name)).split())
    assert words in told


def test_motions_that_nothing_drives_are_told() -> None:
    wheels = (
        trundle.OmniWheel(name="o", x=0.2, y=0.0, heading=np.pi / 2, radius=0.05),
        trundle.BallWheel(name="b", x=-0.2, y=0.0),
    )
    robot = trundle.Robot(name="one", wheels=wheels)
    text = " ".join(render_text(document(robot, steps=True)).split())
    assert "No driven wheel pushes the twists in the columns of U" in text
    assert "b (ball) follows every motion" in text
    none = trundle.Robot(name="none", wheels=wheels[1:])
    text = " ".join(render_text(document(none, steps=True)).split())
    assert "No wheel is driven" in text


def test_steering_angles_can_be_given() -> None:
    tricycle = ROBOTS["tricycle"]
    made = document(tricycle, "kinematics", steering=[np.radians(30.0)])
    assert "30 deg" in render_text(made)
    with pytest.raises(OffCentreError, match="share no instantaneous centre"):
        document(ROBOTS["ackermann"], steering=[0.3, 0.3])
    with pytest.raises(TrundleError, match="did you mean 'dynamics'"):
        document(tricycle, "dynamic")


# ---- reduced dynamics ------------------------------------------------------------------------

# Products of three matrices with sines of plain angles: some tens of roundings.
ROUNDING = 1e-12
TWIST = (0.7, -0.3, 0.9)


def loaded(name: str) -> trundle.Robot:
    """A robot whose centre of mass is off its origin, so that every term counts."""
    return trundle.load(name).with_body(mass=30.0, inertia=0.7, com=(0.05, 0.02))


def told_of(robot: trundle.Robot, left: str) -> Any:
    made = document(robot, "dynamics", steps=True)
    return next(each.right for each in values_of(made) if each.left == left)


def rigid_bias_of(model: trundle.Dynamics, twist: tuple[float, float, float]) -> Any:
    """c_B from M and n of the inertial frame, at psi = 0: there q_dd = zeta_d + r (-v, u, 0)."""
    u, v, r = twist
    turned = model.mass_matrix([0.0, 0.0, 0.0]) @ [-r * v, r * u, 0.0]
    return model.bias([0.0, 0.0, 0.0], list(twist)) + turned


@pytest.mark.parametrize("name", ["differential", "skid_steer"])
def test_reduced_dynamics_are_those_of_the_numbers(name: str) -> None:
    from trundle.symbolic.document.case import case_of

    robot = loaded(name)
    case, model = case_of(robot), trundle.Dynamics(robot)
    u, v, r = sympy.symbols("u v r", real=True)
    # A twist that the wheels allow: neither robot goes sideways.
    forward = (TWIST[0], 0.0, TWIST[2])
    values = case.values | case.masses | dict(zip((u, v, r), forward, strict=True))
    N = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    M = symbolic.numbers(told_of(robot, "N^{T} M_{B} N"), values)
    assert pytest.approx(N.T @ model.reduced().M @ N, abs=ROUNDING) == M
    c = symbolic.numbers(told_of(robot, "N^{T} c_{B}"), values)[:, 0]
    assert c == pytest.approx(N.T @ rigid_bias_of(model, forward), abs=ROUNDING)
    gain = symbolic.numbers(told_of(robot, r"\left(R^{-1} A N\right)^{T}"), values)
    assert gain == pytest.approx((model.reduced().G_d @ N).T, abs=ROUNDING * 1e2)


@pytest.mark.parametrize("name", ["omni3", "mecanum"])
def test_dynamics_in_wheel_speeds_are_those_of_the_numbers(name: str) -> None:
    from trundle.symbolic.document.case import case_of
    from trundle.symbolic.reduced import TWIST as SYMBOLS
    from trundle.symbolic.reduced import body_bias, projected

    robot = loaded(name)
    case, model = case_of(robot), trundle.Dynamics(robot)
    omega = np.linalg.pinv(trundle.Kinematics(robot).W) @ TWIST
    values = case.values | case.masses | dict(zip(SYMBOLS, TWIST, strict=True))
    M, c = projected(case.made.W, body_bias())
    assert symbolic.numbers(M, values) == pytest.approx(model.wheel_mass_matrix, abs=ROUNDING)
    assert symbolic.numbers(c, values)[:, 0] == pytest.approx(model.wheel_bias(omega), abs=ROUNDING)
    shown = np.array(told_of(robot, "M_{w}").tolist(), dtype=np.float64)
    assert shown == pytest.approx(model.wheel_mass_matrix, rel=SHOWN)


def test_a_long_w_leaves_the_numbers() -> None:
    robot = ROBOTS["odd_omni"].with_body(mass=30.0, inertia=0.7, com=(0.05, 0.02))
    wheels = tuple(dataclasses.replace(each, mass=0.5, spin_inertia=0.0) for each in robot.wheels)
    robot = dataclasses.replace(robot, wheels=wheels)
    shown = np.array(told_of(robot, "M_{w}").tolist(), dtype=np.float64)
    assert shown == pytest.approx(trundle.Dynamics(robot).wheel_mass_matrix, rel=SHOWN)


def test_the_differential_drive_has_two_scalar_equations() -> None:
    """Force over mass with I_cz, and turning about the axle; x_bc brings both together."""
    step = next(each for each in steps_of(whole("differential")) if "scalar" in each.heading)
    m, I_cz, x, y = sympy.symbols("m I_cz x_bc y_bc", real=True)
    u, r, udot, rdot = sympy.symbols("u r udot rdot", real=True)
    tau = sympy.symbols("tau_1 tau_2", real=True)
    a, d = sympy.symbols("a d", positive=True)
    wanted = [
        (m * udot - m * y * rdot - m * x * r**2, (tau[0] + tau[1]) / a),
        ((I_cz + m * (x**2 + y**2)) * rdot - m * y * udot + m * x * r * u,
         d * (tau[1] - tau[0]) / a),
    ]  # fmt: skip
    told = [each for each in step.formulas if isinstance(each, Value)]
    assert len(told) == 4
    for value, (left, right) in zip(told, wanted, strict=False):
        assert sympy.expand(value.left - left) == 0
        assert sympy.expand(value.right - right) == 0


@pytest.mark.parametrize("name", ["tricycle", "swerve"])
def test_robots_that_steer_are_sent_to_the_numbers(name: str) -> None:
    text = " ".join(render_text(whole(name)).split())
    assert "trundle.Dynamics(robot).torques(..., steering=...)" in text


def test_what_the_wheels_and_motors_add_is_told_where_it_is_there() -> None:
    plain = render_text(document(ROBOTS["differential"], "dynamics"))
    assert "leave out the wheels' spin, friction and motors" in " ".join(plain.split())
    assert "friction(ω)" not in plain
    motor = trundle.Motor(torque_constant=0.02, resistance=1.5, gear=43.7)
    robot = ROBOTS["differential"]
    wheels = tuple(
        dataclasses.replace(each, spin_inertia=0.001, motor=motor) if each.driven else each
        for each in robot.wheels
    )
    text = render_text(document(dataclasses.replace(robot, wheels=wheels), "dynamics"))
    assert "τ_w = Wᵀ F_B + J ω̇ + friction" in text
    assert "U = R" in text


def test_the_order_of_the_joint_efforts_is_told() -> None:
    step = next(each for each in steps_of(whole("omni3")) if each.heading == "Joint efforts")
    assert "Joint 1 is y and joint 2 is x" in step.text
    told = [str(each.left) for each in step.formulas if isinstance(each, Value)]
    assert told[1:] == ["F_x", "F_y", "M_z"]


# ---- how it is written out -------------------------------------------------------------------


@each_robot
def test_text_keeps_to_its_columns(name: str) -> None:
    assert max(width(line) for line in render_text(whole(name)).splitlines()) <= WIDTH


@each_robot
def test_html_is_well_formed_and_needs_nothing_else(name: str) -> None:
    page = render_html(whole(name))
    root = ElementTree.fromstring(page.removeprefix("<!DOCTYPE html>"))
    assert root.tag == "html"
    formulas = root.findall(f".//{{{MATHML}}}math")
    assert len(formulas) > 30
    # Attributes by which a page loads something; #... leads inside it.
    for element in root.iter():
        for attribute in ("src", "href", "data", "action", "poster", "srcset"):
            assert element.get(attribute, "#").startswith("#")
    assert not re.search(r"https?:", page.replace(MATHML, ""))
    assert not re.search(r"url\(|@import|<script", page)


@each_robot
def test_latex_is_balanced(name: str) -> None:
    text = render_latex(whole(name))
    assert text.startswith(r"\documentclass")
    assert text.endswith("\\end{document}\n")
    opened: list[str] = []
    for what, which in re.findall(r"\\(begin|end)\{(\w+\*?)\}", text):
        if what == "begin":
            opened.append(which)
        else:
            assert opened.pop() == which
    assert not opened
    plain = re.sub(r"\\[{}$]", "", text)
    assert plain.count("{") == plain.count("}")
    assert plain.count("$") % 2 == 0
    assert text.count("\n\\[\n") == text.count("\n\\]\n")
    assert text.count(r"\left") - text.count(r"\leftarrow") == text.count(r"\right")


@pytest.mark.parametrize(
    ("file", "name", "what", "steps", "render"),
    [
        ("omni3.txt", "omni3", "kinematics", True, render_text),
        ("swerve.txt", "swerve", None, False, render_text),
        ("differential.tex", "differential", None, True, render_latex),
        ("mecanum.txt", "mecanum", "pseudo-inverse", True, render_text),
    ],
    ids=lambda value: value if isinstance(value, str) and "." in value else "",
)
def test_the_text_is_as_it_was_read(
    file: str, name: str, what: str | None, steps: bool, render: Callable[[Document], str]
) -> None:
    agrees_with_golden(f"derive_{file}", render(document(ROBOTS[name], what, steps)))


@pytest.mark.parametrize(
    ("latex", "plain"),
    [
        (r"\dot{\eta} = J(\psi)\, \zeta", "η̇ = J(ψ) ζ"),
        (r"\frac{\sqrt{3} l}{2}", "√3 l/2"),
        (r"\frac{a + b}{2 l}", "(a + b)/(2 l)"),
        (r"\left(A N\right)^{-1} x_{C1}", "(A N)⁻¹ x_C1"),
        (r"a^{b + c}", "a^(b + c)"),
        (r"\cos\theta_{i} - \sin^{2}{\left(\beta \right)}", "cos θᵢ - sin²(β)"),
        (r"\left(- a, - b\right)", "(-a, -b)"),
    ],
)
def test_latex_in_sentences_reads_well(latex: str, plain: str) -> None:
    assert plain_math(latex) == plain


def test_long_sums_break_with_the_right_signs() -> None:
    """A part that begins with a minus keeps its inner signs: it is not a minus before a sum."""
    names = sympy.symbols("a:h")
    signs = (1, -1, -1, 1, 1, -1, 1, 1)
    long = [sympy.Symbol(f"{name}_with_a_long_name") for name in names]
    total = sympy.Add(*(sign * name for sign, name in zip(signs, long, strict=True)))
    (line,) = lines_of(Value("T", total))
    assert len(line.parts) > 1
    assert sum(line.parts) == total
    rows = formula_lines(Value("T", total))
    assert len(rows) == len(line.parts)
    flat = "".join(rows).replace(" ", "").removeprefix("T=")
    read = {found[1]: found[0] for found in re.findall(r"(^|[+-])([a-h])_with", flat)}
    assert {name: sign == "-" for name, sign in read.items()} == {
        str(name): sign < 0 for name, sign in zip(names, signs, strict=True)
    }
    latex = formula_latex(Value("T", total))
    read = {found[1]: found[0] for found in re.findall(r"([=+-]) ([a-h])_\{with", latex)}
    assert {name: sign == "-" for name, sign in read.items()} == {
        str(name): sign < 0 for name, sign in zip(names, signs, strict=True)
    }


def test_a_wide_matrix_is_told_entry_by_entry() -> None:
    a = sympy.Symbol("a")
    wide = sympy.Matrix([[sympy.sin(a + i) * int(i != 1) for i in range(14)]])
    lines = formula_lines(Value("W", wide))
    assert lines[0] == "W_(1,1) = sin(a)"
    assert lines[1] == "W_(1,3) = sin(a + 2)"
    assert lines[-1] == "(the other entries are zero)"


def test_names_of_users_do_no_harm() -> None:
    wheel = trundle.OmniWheel(name="50% <b>&_{$", x=0.1, y=0.0, radius=0.05)
    robot = trundle.Robot(name="a*/ <i>$ \\ #\n~^", wheels=(wheel,))
    made = document(robot, steps=True)
    page = render_html(made)
    ElementTree.fromstring(page.removeprefix("<!DOCTYPE html>"))
    assert "<b>" not in page
    text = render_latex(made)
    assert text.count(r"\begin{document}") == 1
    head = code(robot, "c").partition("#include")[0]
    assert all(line.startswith("//") for line in head.splitlines())
    compile(code(robot, "numpy"), "made", "exec")
    assert render_text(made)


# ---- the command -----------------------------------------------------------------------------


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    app = typer.Typer()
    app.command(cls=NumbersCommand)(derive)

    def run(*args: str) -> str:
        app(args=list(args), standalone_mode=False)
        return capsys.readouterr().out

    return run


def test_it_prints_a_document(command: Callable[..., str]) -> None:
    out = command("omni3", "--what", "kinematics")
    assert out.startswith("omni3: kinematics, derived\n")
    assert "Wheel 1 (wheel_1)" not in out
    assert "Wheel 1 (wheel_1)" in command("omni3", "--what", "kinematics", "--steps")


@pytest.mark.parametrize(
    ("given", "file", "start"),
    [
        (["--out", "sheets"], "sheets/derive.txt", "omni3"),
        (["--out", "sheets", "--format", "html"], "sheets/derive.html", "<!DOCTYPE html>"),
        (["--out", "deep/a.html"], "deep/a.html", "<!DOCTYPE html>"),
        (["--out", "a.tex"], "a.tex", r"\documentclass"),
        (["--out", "a.py"], "a.py", "# omni3"),
        (["--out", "a.c"], "a.c", "// omni3"),
        (["--out", "a.txt", "--format", "text"], "a.txt", "omni3"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_it_leaves_a_file_and_says_which(
    command: Callable[..., str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    given: list[str],
    file: str,
    start: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    out = command("omni3", "--what", "kinematics", *given)
    assert " ".join(out.split()) == f"wrote {Path(file)}"
    assert (tmp_path / file).read_text(encoding="utf-8").startswith(start)


def test_sizes_and_angles_go_in(command: Callable[..., str]) -> None:
    out = command(
        "tricycle", "--set", "wheelbase=1.25", "--steering-deg", "-20", "--what=kinematics"
    )
    assert "1.25 m" in out
    assert "-20 deg" in out


def test_json_has_the_text_or_the_file(command: Callable[..., str], tmp_path: Path) -> None:
    told = json.loads(command("omni3", "--what", "kinematics", "--json"))
    assert (told["name"], told["format"], told["files"]) == ("omni3", "text", [])
    assert told["text"].startswith("omni3")
    told = json.loads(command("omni3", "--out", str(tmp_path / "a.html"), "--json"))
    assert told["files"] == [str(tmp_path / "a.html")]
    assert told["text"] is None


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (["omni3", "--what", "kinematic"], "--what takes kinematics, pseudo-inverse, dynamics"),
        (["omni3", "--format", "pdf"], "--format takes text, latex, html, numpy, c, got 'pdf'"),
        (["omni33"], "omni33"),
        (["omni3", "--out", "a.pdf"], "the suffix must be .txt for text"),
        (["omni3", "--format", "html", "--out", "a.tex"], "the suffix must be"),
        (["omni3", "--format", "c", "--steps"], "--steps belongs to documents"),
        (["tricycle", "--format", "c", "--steering-deg", "9"], "--steering-deg belongs to"),
        (["omni3", "--steering-deg", "3"], "does not steer"),
        (["ackermann", "--steering-deg", "20", "30"], "share no instantaneous centre"),
        (["swerve", "--what", "pseudo-inverse", "--format", "c"], "no pseudo-inverse that could"),
    ],
)
def test_mistakes_are_told(command: Callable[..., str], args: list[str], told: str) -> None:
    with pytest.raises(TrundleError) as caught:
        command(*args)
    assert told in str(caught.value)


def test_a_file_that_cannot_be_written_is_told(command: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(TrundleError, match="nothing can be written there"):
        command("omni3", "--out", str(tmp_path / "file" / "a.html"))


def test_help_teaches_with_an_example() -> None:
    assert "trundle derive omni3" in (derive.__doc__ or "")


def test_other_commands_do_not_load_sympy() -> None:
    here = str(Path(trundle.__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    loaded = subprocess.run(
        [sys.executable, "-c", "import sys, trundle.cli.derive; print('sympy' in sys.modules)"],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert loaded.stdout.strip() == "False"


def test_printed_code_of_a_robot_runs() -> None:
    space: dict[str, Any] = {}
    exec(code(ROBOTS["mecanum"], "numpy"), space)
    W = space["wheel_matrix"]([0.05, 0.2, 0.15])
    assert pytest.approx(W, abs=1e-12) == trundle.Kinematics(ROBOTS["mecanum"]).W
    assert space["pseudo_inverse"]([0.05, 0.2, 0.15]) @ np.ones(3) == pytest.approx(
        trundle.Kinematics(ROBOTS["mecanum"]).right_inverse() @ np.ones(3), abs=1e-12
    )


def test_a_law_and_an_empty_section_can_be_written() -> None:
    made = Document("t", "", (Section("s", (Step("", "", (Law("a = b"),)),)), Section("e", ())))
    assert "a = b" in render_text(made)
    assert "<math" in render_html(made)
