"""The document of a robot: which sections, in which order."""

from __future__ import annotations

import numpy.typing as npt

from trundle.errors import TrundleError, did_you_mean
from trundle.robot import Robot
from trundle.symbolic.document.can import abilities
from trundle.symbolic.document.case import Case, case_of
from trundle.symbolic.document.chain_steps import chain
from trundle.symbolic.document.inverses import inverses
from trundle.symbolic.document.motion import equations_of_motion
from trundle.symbolic.document.notation import notation
from trundle.symbolic.document.parts import Document, Section, Step, literal
from trundle.symbolic.document.rows import rows
from trundle.symbolic.document.torques import wheel_torques
from trundle.symbolic.document.twist_map import allowed_twists, speeds_from_twist, wheel_map

_LETTERS = Step(
    "Letters",
    r"In this section $R$ holds the wheels' radii, $C$ the side-slip rows and $N$ the allowed "
    r"twists; $\omega$ are wheel speeds, $\theta_{i}$ is the direction in which wheel $i$ rolls, "
    "and $a$, $d$ and $l$, with or without an index, are sizes of the robot.",
)

TOPICS = ("kinematics", "pseudo-inverse", "dynamics")


def document(
    robot: Robot,
    what: str | None = None,
    steps: bool = False,
    steering: npt.ArrayLike | None = None,
) -> Document:
    """Return the derivation of a robot's equations as a document.

    Args:
        robot: the robot.
        what: "kinematics", "pseudo-inverse" or "dynamics"; all of them where it is left out.
        steps: whether every intermediate step is shown.
        steering: (s,) steering angles [rad] of the numbers; a gentle turn by default.

    Raises:
        TrundleError: there is no such topic.

    >>> import trundle
    >>> made = document(trundle.load("omni3"), "kinematics")
    >>> [section.heading for section in made.sections]
    ['Notation', 'Kinematics', 'What the robot can do']
    """
    checked_topic(what)
    case = case_of(robot, steering)
    topics = TOPICS if what is None else (what,)
    sections = [notation(case)]
    for topic in topics:
        sections += _SECTIONS[topic](case)
    made = Document(
        f"{literal(robot.name)}: {_listed(topics)}, derived",
        "From the constraint of each wheel, with the symbols of this robot and with its numbers. "
        "Units are SI and radians.",
        tuple(sections),
    )
    return made if steps else made.results()


def checked_topic(what: str | None) -> None:
    """Check that there is such a topic, or that it is left out."""
    if what is not None and what not in TOPICS:
        raise TrundleError(
            f"there is a derivation of {', '.join(TOPICS)}; got {what!r}"
            f"{did_you_mean(what, TOPICS)}"
        )


def _listed(topics: tuple[str, ...]) -> str:
    return topics[0] if len(topics) == 1 else f"{', '.join(topics[:-1])} and {topics[-1]}"


def _kinematics(case: Case) -> list[Section]:
    steps = [
        _LETTERS,
        *rows(case),
        *allowed_twists(case),
        *wheel_map(case),
        *speeds_from_twist(case),
    ]
    return [Section("Kinematics", tuple(steps)), abilities(case)]


def _pseudo_inverse(case: Case) -> list[Section]:
    return [inverses(case)]


def _dynamics(case: Case) -> list[Section]:
    return [chain(case), equations_of_motion(case), wheel_torques(case)]


_SECTIONS = {
    "kinematics": _kinematics,
    "pseudo-inverse": _pseudo_inverse,
    "dynamics": _dynamics,
}
