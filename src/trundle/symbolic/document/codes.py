"""The functions of a robot's equations, printed as numpy or C."""

from __future__ import annotations

from trundle.errors import TrundleError
from trundle.robot import Robot
from trundle.symbolic.base import planar_base
from trundle.symbolic.c_code import c_source
from trundle.symbolic.code import Function, Group, Output
from trundle.symbolic.document.case import Case, case_of
from trundle.symbolic.document.figures import in_words
from trundle.symbolic.document.write import TOPICS, checked_topic
from trundle.symbolic.numpy_code import numpy_source
from trundle.symbolic.pseudo_inverse import pseudo_inverse

LANGUAGES = ("numpy", "c")
_PYTHON = ("#", "import numpy as np\n", "\n\n")


def functions(robot: Robot, what: str | None = None) -> tuple[Function, ...]:
    """Return the functions that a robot's equations give: W, its pseudo-inverse, M and n.

    Args:
        robot: the robot.
        what: "kinematics", "pseudo-inverse" or "dynamics"; all of them where it is left out.

    >>> import trundle
    >>> [each.name for each in functions(trundle.load("mecanum"))]
    ['wheel_matrix', 'pseudo_inverse', 'body_dynamics']
    """
    checked_topic(what)
    return _of(case_of(robot), what)


def _of(case: Case, what: str | None) -> tuple[Function, ...]:
    return tuple(
        function
        for topic in (TOPICS if what is None else (what,))
        for function in _MAKERS[topic](case)
    )


def code(robot: Robot, language: str, what: str | None = None) -> str:
    """Return a robot's equations as the source of numpy or C functions.

    Raises:
        TrundleError: the robot has no such function: it has no driven wheel, or W no inverse.

    >>> import trundle
    >>> print(code(trundle.load("omni3"), "c", "kinematics").splitlines()[1])
    // size: a = 0.2 m, l = 0.3 m
    """
    checked_topic(what)
    case = case_of(robot)
    made = _of(case, what)
    if not made:
        raise TrundleError(f"robot {robot.name!r} has no {what} that could be printed as code")
    mark, include, gap = ("//", "#include <math.h>\n", "\n") if language == "c" else _PYTHON
    source = c_source if language == "c" else numpy_source
    head = "".join(f"{mark} {' '.join(line.split())}\n" for line in _header(case, what))
    bodies = [source(each).removeprefix(include).strip("\n") + "\n" for each in made]
    return head + include + gap + gap.join(bodies)


def _header(case: Case, what: str | None) -> list[str]:
    """Return lines with the numbers that go with the arguments."""
    lines = [f"{case.robot.name}: SI units and radians"]
    if what != "dynamics" and case.made.quantities:
        sizes = [f"{s} = {in_words(v)} {unit}".strip() for s, v, unit, _ in case.made.quantities]
        lines.append(f"size: {', '.join(sizes)}")
    if what in (None, "dynamics") and case.masses:
        body = [f"{s} = {in_words(case.masses[s])}" for s in planar_base().parameters]
        lines.append(f"body: {', '.join(body)}")
    return lines


def _sizes(case: Case) -> tuple[Group, ...]:
    made = case.made
    steering = (Group("steering", made.inputs.symbols),) if made.inputs.symbols else ()
    return (*steering, Group("size", tuple(each.symbol for each in made.quantities)))


def _wheel_matrix(case: Case) -> list[Function]:
    if not case.made.W.cols:
        return []
    summary = "W: the twist (u, v, r) for one rad/s of each driven wheel."
    return [Function("wheel_matrix", summary, _sizes(case), (Output("W", case.made.W),))]


def _pseudo_inverse(case: Case) -> list[Function]:
    matrix = pseudo_inverse(case.made).matrix
    if matrix is None:
        return []
    summary = "Pseudo-inverse of W: the wheel speeds for a twist (u, v, r)."
    return [Function("pseudo_inverse", summary, _sizes(case), (Output("W_plus", matrix),))]


def _dynamics(_: Case) -> list[Function]:
    made = planar_base()
    return [
        Function(
            "body_dynamics",
            "M and n in M q_dd + n = (F_x, F_y, M_z), with q = (x, y, psi).",
            (Group("q", made.q), Group("qdot", made.qd), Group("body", made.parameters)),
            (Output("M", made.M), Output("n", made.n, vector=True)),
        )
    ]


_MAKERS = {
    "kinematics": _wheel_matrix,
    "pseudo-inverse": _pseudo_inverse,
    "dynamics": _dynamics,
}
