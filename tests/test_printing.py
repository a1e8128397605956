"""One set of equations, many readings: sympy to high precision, numpy, and compiled C99."""

import ctypes
import math
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import trundle
from golden_text import agrees_with_golden
from trundle.errors import TrundleError
from trundle.symbolic import (
    Function,
    Group,
    Link,
    Output,
    c_source,
    newton_euler,
    numpy_function,
    numpy_source,
    planar_base,
    symbolic_robot,
    to_latex,
)

# Sums of a few products of numbers up to 10 in doubles, against 30 digits.
AGREE = 1e-12
DIGITS = 30
CC = next((found for found in map(shutil.which, ("gcc", "clang", "cc")) if found), None)
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")


def of_equations(made: Any, name: str) -> Function:
    return Function(
        name,
        "Mass matrix and bias of the equations of motion.",
        (Group("q", made.q), Group("qdot", made.qd), Group("p", made.parameters)),
        (Output("M", made.M), Output("n", made.n, vector=True)),
    )


def of_robot(name: str) -> Function:
    made = symbolic_robot(trundle.load(name))
    sizes = tuple(each.symbol for each in made.quantities)
    return Function(
        "wheel_matrix",
        "W at steering angles and sizes.",
        (Group("steering", made.inputs.symbols), Group("size", sizes)),
        (Output("W", made.W),),
    )


def arm() -> Any:
    m, l, e, g, I = sympy.symbols("m l e g I", positive=True)
    inertia = sympy.diag(I, 2 * I, 3 * I)
    return newton_euler(
        [
            Link(kind="revolute", mass=m, com=(l, 0, e), inertia=inertia),
            Link(kind="prismatic", alpha=sympy.pi / 3, a=l, mass=2 * m, com=(0, e, 0)),
        ],
        gravity=(0, 0, -g),
    )


FUNCTIONS: dict[str, Callable[[], Function]] = {
    "planar base": lambda: of_equations(planar_base(), "planar_base"),
    "arm": lambda: of_equations(arm(), "arm"),
    "omni3": lambda: of_robot("omni3"),
    "mecanum": lambda: of_robot("mecanum"),
    "swerve": lambda: of_robot("swerve"),
    "synchro": lambda: of_robot("synchro"),
}
each_function = pytest.mark.parametrize("name", FUNCTIONS)


@cache
def function(name: str) -> Function:
    return FUNCTIONS[name]()


def cases(made: Function) -> list[list[np.ndarray]]:
    """Return arguments: small and large angles, either sign, and sizes that are positive."""
    random = np.random.default_rng(71)
    out = []
    for reach in (0.1, 1.0, 10.0):
        for _ in range(4):
            values = []
            for group in made.arguments:
                drawn = random.uniform(-reach, reach, len(group.symbols))
                sizes = [bool(symbol.is_positive) for symbol in group.symbols]
                values.append(np.where(sizes, np.abs(drawn) + 0.1, drawn))
            out.append(values)
    return out


def exactly(made: Function, values: list[np.ndarray]) -> list[np.ndarray]:
    """Return the outputs computed with 30 digits, as doubles."""
    symbols = [symbol for group in made.arguments for symbol in group.symbols]
    # A double is a fraction: nothing is lost before the 30 digits.
    at = dict(zip(symbols, map(sympy.Rational, np.concatenate(values).tolist()), strict=True))
    return [
        np.array([float(entry.evalf(DIGITS, subs=at)) for entry in each.matrix]).reshape(
            each.matrix.shape
        )
        for each in made.outputs
    ]


@each_function
def test_numpy_agrees_with_high_precision(name: str) -> None:
    made = function(name)
    run = numpy_function(made)
    for values in cases(made):
        got = run(*values)
        got = got if isinstance(got, tuple) else (got,)
        for have, want in zip(got, exactly(made, values), strict=True):
            assert have.reshape(want.shape) == pytest.approx(want, abs=AGREE, rel=AGREE)


@each_function
def test_numpy_takes_batches(name: str) -> None:
    made = function(name)
    run = numpy_function(made)
    rows = cases(made)
    together = run(*(np.stack(column).reshape(3, 4, -1) for column in zip(*rows, strict=True)))
    one_by_one = [run(*values) for values in rows]
    if not isinstance(together, tuple):
        together, one_by_one = (together,), [(each,) for each in one_by_one]
    for k, whole in enumerate(together):
        parts = np.stack([each[k] for each in one_by_one])
        np.testing.assert_array_equal(whole, parts.reshape(whole.shape))


@pytest.mark.skipif(CC is None, reason="no C compiler here (gcc, clang or cc)")
@each_function
def test_compiled_c_agrees_with_high_precision(name: str, tmp_path: Path) -> None:
    made = function(name)
    run = compiled(made, tmp_path)
    for values in cases(made):
        for have, want in zip(run(values), exactly(made, values), strict=True):
            assert have == pytest.approx(want, abs=AGREE, rel=AGREE)


def compiled(made: Function, folder: Path) -> Callable[[list[np.ndarray]], list[np.ndarray]]:
    source, library = folder / "made.c", folder / "made.so"
    # A declaration first, as a header would have it; without it some compilers warn.
    text = c_source(made)
    source.write_text(text)
    assert CC is not None
    subprocess.run(
        [CC, *FLAGS, "-shared", "-fPIC", "-O1", str(source), "-o", str(library), "-lm"], check=True
    )
    call = getattr(ctypes.CDLL(str(library)), made.name)
    call.restype = None

    def run(values: list[np.ndarray]) -> list[np.ndarray]:
        outputs = [np.full(each.matrix.shape, math.nan) for each in made.outputs]
        arrays = [np.ascontiguousarray(value, dtype=np.float64) for value in values] + outputs
        call(*(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in arrays))
        return outputs

    return run


# ---- the text --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("planar_base.c", lambda: c_source(function("planar base"))),
        ("planar_base.py", lambda: numpy_source(function("planar base"))),
        ("synchro.c", lambda: c_source(function("synchro"))),
        ("mecanum.py", lambda: numpy_source(function("mecanum"))),
        ("planar_base.tex", lambda: "\n".join(map(to_latex, (planar_base().M, planar_base().n)))),
        ("mecanum.tex", lambda: to_latex(function("mecanum").outputs[0].matrix)),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_text_is_as_it_was_read(file: str, text: Callable[[], str]) -> None:
    agrees_with_golden(file, text() + "\n" * file.endswith(".tex"))


def test_temporary_names_keep_clear_of_the_users() -> None:
    t0, x = sympy.symbols("t0 x")
    twice = sympy.sin(x) ** 2 + sympy.sin(x) * t0
    made = Function("f", "f", (Group("q", (t0, x)),), (Output("y", sympy.Matrix([twice])),))
    assert numpy_function(made)([2.0, 0.5])[0, 0] == pytest.approx(
        math.sin(0.5) ** 2 + math.sin(0.5) * 2.0, abs=AGREE
    )


def test_an_argument_that_is_not_read_does_not_warn_in_c() -> None:
    x, y = sympy.symbols("x y")
    made = Function(
        "f", "f", (Group("q", (x,)), Group("p", (y,))), (Output("z", x * sympy.eye(1)),)
    )
    assert "(void)p;" in c_source(made)


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("f", "q", "q"), "'q' is the name of two things"),
        (("lambda", "q", "y"), "'lambda' cannot be a name"),
        (("f", "x", "y"), "'x' is the name of two things"),
        (("f", "2", "y"), "'2' cannot be a name"),
    ],
)
def test_names_that_do_not_go_are_told(names: tuple[str, str, str], told: str) -> None:
    x = sympy.Symbol("x")
    with pytest.raises(TrundleError, match=told):
        Function(names[0], "", (Group(names[1], (x,)),), (Output(names[2], sympy.Matrix([x])),))


def test_a_symbol_that_no_argument_holds_is_told() -> None:
    x, y = sympy.symbols("x y")
    with pytest.raises(TrundleError, match="no argument holds y"):
        Function("f", "", (Group("q", (x,)),), (Output("z", sympy.Matrix([x + y])),))
