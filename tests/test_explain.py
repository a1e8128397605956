"""A robot in sentences: every number that they quote is the model's."""

import math
import re

import numpy as np
import pytest

import trundle
from trundle.errors import OffCentreError, ShapeError
from trundle.kinematics.explain import explain
from trundle.robot import (
    CATALOG,
    BallWheel,
    FixedWheel,
    OmniWheel,
    Robot,
    SteeredWheel,
)

# Numbers are printed with four digits: half a unit of the fourth is 5e-4 of the number at most.
PRINTED = 6e-4
# Angles are printed with four digits too, at most 180 deg: half a unit is 0.05 deg.
PRINTED_ANGLE = math.radians(0.051)
# Below this a coefficient is rounding, and is not printed.
NOTHING = 1e-9

# Angles that share a centre: straight ahead, or about a point on the line of the fixed axle.
STEERING = {
    "tricycle": [0.4],
    "bicycle": [-0.3],
    "ackermann": [math.atan2(2.6, 4 - 0.75), math.atan2(2.6, 4 + 0.75)],
    "rear_steered": [math.atan2(-1.4, 3 - 0.45), math.atan2(-1.4, 3 + 0.45)],
    "four_wheel_steered": [0.0] * 4,
    "two_steered": [0.3, -0.2],
    "synchro": [0.7] * 3,
    "swerve": [0.5] * 4,
    "omni_steer": [0.6],
}


def mixed_kinds():
    """A robot that no catalogue has: wheels of two sizes, one reversed, one free, a ball."""
    wheels = (
        OmniWheel(name="front", x=0.3, y=0.1, radius=0.05, heading=0.4),
        OmniWheel(name="left", x=-0.1, y=0.2, radius=0.08, heading=2.0, reversed=True),
        OmniWheel(name="right", x=-0.2, y=-0.3, radius=0.06, heading=-1.0, roller=0.3),
        OmniWheel(name="free", x=0.0, y=0.3, radius=0.06, driven=False),
        BallWheel(name="ball", x=0.2, y=-0.2),
    )
    return Robot(name="mixed kinds", wheels=wheels)


def robots():
    found = [pytest.param(trundle.load(name), STEERING.get(name), id=name) for name in CATALOG]
    sizes = {
        "mecanum_lecture": {"wheelbase": 0.6, "track": 0.6},
        "skid_steer": {"track_factor": 1.5},
    }
    for name, changed in sizes.items():
        found.append(pytest.param(trundle.load(name, **changed), None, id=f"{name} changed"))
    return [*found, pytest.param(mixed_kinds(), None, id="mixed kinds")]


each_robot = pytest.mark.parametrize(("robot", "steering"), robots())


def angles_of(robot, steering):
    return dict(zip((wheel.name for wheel in robot.steered), steering or (), strict=True))


def direction(wheel, angles):
    return wheel.heading + getattr(wheel, "roller", 0.0) + angles.get(wheel.name, 0.0)


def rolling(wheel, angles):
    """cos(t) (u - r y) + sin(t) (v + r x) = a omega cos(phi), from the model."""
    t, y = direction(wheel, angles), wheel.y * getattr(wheel, "track_factor", 1.0)
    row = np.array([math.cos(t), math.sin(t), wheel.x * math.sin(t) - y * math.cos(t)])
    sign = -1 if wheel.reversed else 1
    return row, sign * wheel.radius * math.cos(getattr(wheel, "roller", 0.0))


def across(wheel, angles):
    """-sin(t) (u - r y) + cos(t) (v + r x), from the model."""
    t = direction(wheel, angles)
    return np.array([-math.sin(t), math.cos(t), wheel.x * math.cos(t) + wheel.y * math.sin(t)])


def null_space(rows):
    _, sizes, vectors = np.linalg.svd(np.vstack([rows, np.zeros((3, 3))]))
    return vectors[np.sum(sizes > 1e-6) :].T


def model_matrix(robot, steering):
    """W = N (A N)^+ R, from the model; skid-steer: v = 0 is kept."""
    angles = angles_of(robot, steering)
    held = [
        across(wheel, angles)
        for wheel in robot.wheels
        if wheel.kind in ("fixed", "steered") and not getattr(wheel, "skid", False)
    ]
    if any(getattr(wheel, "skid", False) for wheel in robot.wheels):
        held.append(np.array([0.0, 1.0, 0.0]))
    N = null_space(np.array(held).reshape(-1, 3))
    rows = [rolling(wheel, angles) for wheel in robot.driven]
    A, R = np.array([row for row, _ in rows]), np.array([gain for _, gain in rows])
    return N @ np.linalg.pinv(A @ N, rcond=1e-9) * R, N


NUMBER = r"\d+(?:\.\d+)?(?:e-?\d+)?"


def parsed(text, names):
    """Return the coefficients of a linear combination such as "0.1 (a - b)" or "2 u - v"."""
    factor, inner = 1.0, text.strip()
    if found := re.fullmatch(rf"(-?)({NUMBER})? ?\((.*)\)", inner):
        factor = float(found[2] or 1) * (-1 if found[1] else 1)
        inner = found[3]
    values = dict.fromkeys(names, 0.0)
    if inner == "0":
        return np.array(list(values.values()))
    terms = re.split(r" (?=[+-] )", inner)
    for term in terms:
        found = re.fullmatch(rf"(-|- |\+ )?({NUMBER} )?(\w+)", term)
        assert found, f"{term!r} in {text!r}"
        sign = -1 if (found[1] or "").startswith("-") else 1
        values[found[3]] += factor * sign * float(found[2] or 1)
    return np.array(list(values.values()))


def assert_printed(quoted, expected):
    np.testing.assert_allclose(quoted, expected, rtol=PRINTED, atol=NOTHING)
    # What is printed as nothing is nothing.
    assert ((np.abs(expected) > NOTHING) == (quoted != 0)).all()


def test_the_parser_reads_what_is_printed():
    assert parsed("0.125 (right - left)", ["left", "right"]).tolist() == [-0.125, 0.125]
    assert parsed("-0.5 (a + b)", "ab").tolist() == [-0.5, -0.5]
    assert parsed("-v - 0.5 r", "uvr").tolist() == [0, -1, -0.5]
    assert parsed("1e-05 u + v", "uvr").tolist() == [1e-5, 1, 0]
    assert parsed("0", "uvr").tolist() == [0, 0, 0]


@each_robot
def test_the_rows_of_W_are_the_models(robot, steering):
    W, _ = model_matrix(robot, steering)
    names = [wheel.name for wheel in robot.driven]
    sentences = explain(robot, steering).matrix
    assert len(sentences) == 3
    for name, row, sentence in zip("uvr", W, sentences, strict=True):
        found = re.match(r"(\w) = (.*?): ", sentence)
        assert found
        assert found[1] == name
        assert_printed(parsed(found[2], names), np.where(np.abs(row) < NOTHING, 0, row))
        assert sentence.endswith(".")


@each_robot
def test_the_constraint_rows_are_the_models(robot, steering):
    angles = angles_of(robot, steering)
    sentences = list(explain(robot, steering).constraints)
    for wheel in robot.wheels:
        if wheel.kind in ("caster", "ball"):
            continue
        row, gain = rolling(wheel, angles)
        found = re.match(rf"{wheel.name} rolls: (.*) = (.*), that is (.*) = (.*?)\.(?= |$)",
                         sentences.pop(0))  # fmt: skip
        assert found
        assert_printed(parsed(found[3], "uvr"), np.where(np.abs(row) < NOTHING, 0, row))
        for text in (found[2], found[4]):
            assert_printed(parsed(text, ["omega"]), [gain])
        check_formula(found[1], r"cos\((.*) deg\) (.*) \+ sin\((.*) deg\) (.*)", row)
        if wheel.kind in ("fixed", "steered"):
            sentence, row = sentences.pop(0), across(wheel, angles)
            kept = "may slip sideways, at" if getattr(wheel, "skid", False) else "does not"
            assert sentence.startswith(f"{wheel.name} {kept}")
            found = re.search(r"(cos.*?)(?: = 0)?, that is (.*?)(?: = 0\.|; no)", sentence)
            assert found
            assert_printed(parsed(found[2], "uvr"), np.where(np.abs(row) < NOTHING, 0, row))
            check_formula(found[1], r"cos\((.*) deg\) (.*) - sin\((.*) deg\) (.*)", row)
    assert len(sentences) == 1  # the motions that are left


def check_formula(text, form, row):
    """Check that the formula in cosine and sine is the row."""
    found = re.fullmatch(form, text)
    assert found, text
    assert found[1] == found[3]
    c, s = math.cos(math.radians(float(found[1]))), math.sin(math.radians(float(found[1])))
    sign = -1 if " - sin" in text else 1
    made = c * parsed(found[2], "uvr") + sign * s * parsed(found[4], "uvr")
    size = 1 + np.abs(row).max()
    np.testing.assert_allclose(made, row, atol=(PRINTED_ANGLE + PRINTED) * size)


@each_robot
def test_force_lines_and_lever_arms_are_the_models(robot, steering):
    angles = angles_of(robot, steering)
    for wheel, text in zip(robot.wheels, explain(robot, steering).wheels, strict=True):
        assert text.startswith(f"{wheel.name} ({wheel.kind}")
        if not wheel.driven:
            assert "pushes" not in text
            continue
        row, gain = rolling(wheel, angles)
        found = re.search(rf"the line at (-?{NUMBER}) deg through \((.*), (.*)\) m", text)
        assert found
        off = math.radians(float(found[1])) - direction(wheel, angles)
        assert abs(math.remainder(off, math.tau)) < PRINTED_ANGLE
        assert_printed(np.array([float(found[2]), float(found[3])]), [wheel.x, wheel.y])
        if abs(row[2]) < NOTHING:
            assert "no lever arm" in text
            continue
        found = re.search(rf"lever arm about the origin is ({NUMBER}) m, (\S+) at", text)
        assert found
        assert_printed(np.array([float(found[1])]), [abs(row[2])])
        assert (found[2] == "counter-clockwise") == (row[2] * gain > 0)


@each_robot
def test_degrees_of_freedom_of_each_wheel_are_the_models(robot, steering):
    for wheel, text in zip(robot.wheels, explain(robot, steering).wheels, strict=True):
        count = 2 if wheel.kind in ("fixed", "steered") else 3
        if getattr(wheel, "skid", False):
            count = 3
        assert f"Alone on the ground it has {count} degrees of freedom:" in text


@each_robot
def test_the_motions_that_are_left_are_counted(robot, steering):
    if any(getattr(wheel, "skid", False) for wheel in robot.wheels):
        count = 2
    else:
        count = model_matrix(robot, steering)[1].shape[1]
    last = explain(robot, steering).constraints[-1]
    if count == 3:
        assert last == "No row forbids a motion of the plane."
    else:
        assert last.startswith(f"Together they leave {count} motion{'s' * (count > 1)} of 3: ")


@each_robot
def test_what_the_yaw_row_says_of_rim_speeds_is_true(robot, steering):
    W, _ = model_matrix(robot, steering)
    sentence = explain(robot, steering).matrix[2]
    if np.abs(W[2]).max() < NOTHING:
        assert sentence.startswith("r = 0: ")
        return
    # The twist with r = 1 that the wheels give: the origin stands still where it may.
    give = W @ np.linalg.pinv(W, rcond=1e-9)
    turn = give[:, 2] / give[2, 2]
    angles = angles_of(robot, steering)
    rows = [rolling(wheel, angles) for wheel in robot.driven]
    radii = [wheel.radius for wheel in robot.driven]
    rims = np.array([row @ turn * a / gain for (row, gain), a in zip(rows, radii, strict=True)])
    if found := re.search(rf"over the arm of ({NUMBER}) m\. In one radian", sentence):
        assert_printed(np.full(len(rims), float(found[1])), np.abs(rims))
        signs = [-1 if wheel.name in backwards(sentence) else 1 for wheel in robot.driven]
        assert np.array_equal(np.sign(rims), signs)
    else:
        runs = re.findall(rf"(-?{NUMBER}) m at (\w+)", sentence)
        assert [name for _, name in runs] == [wheel.name for wheel in robot.driven]
        assert_printed(np.array([float(run) for run, _ in runs]), rims)
    centre = re.search(rf"turning about the point \((-?{NUMBER}), (-?{NUMBER})\) m", sentence)
    expected = (-turn[1], turn[0])
    if centre:
        # Points are printed with three digits.
        quoted = (float(centre[1]), float(centre[2]))
        np.testing.assert_allclose(quoted, expected, rtol=6e-3, atol=1e-3)
    else:
        assert "turning on the spot" in sentence
        np.testing.assert_allclose(expected, 0, atol=1e-3)


def backwards(sentence):
    """Return the names of the wheels that a sentence counts backwards."""
    if "all counted backwards" in sentence:
        return re.split(r"\W+", sentence.partition(":")[0])
    found = re.search(r"(?:those|rim speed) of ([^:]*?),? counted backwards", sentence)
    return re.split(r", | and ", found[1]) if found else []


@each_robot
def test_what_the_linear_rows_say_of_rim_speeds_is_true(robot, steering):
    W, _ = model_matrix(robot, steering)
    radii = np.array([wheel.radius for wheel in robot.driven])
    names = [wheel.name for wheel in robot.driven]
    for row, sentence in zip(W[:2], explain(robot, steering).matrix[:2], strict=True):
        weights = np.where(np.abs(row) < NOTHING, 0, row / radii)
        if found := re.search(r"in rim speeds \[m/s\], \w+ speed is (.*)\.$", sentence):
            assert_printed(parsed(found[1], names), weights)
        elif "mean of the rim speeds" in sentence:
            times = re.search(rf"({NUMBER}) times", sentence)
            of = re.search(r"rim speeds of (.*?)(?:, those|\.)", sentence)
            counted = re.split(r", | and ", of[1]) if of else names
            share = (float(times[1]) if times else 1.0) / len(counted)
            quoted = [
                share * (name in counted) * (-1 if name in backwards(sentence) else 1)
                for name in names
            ]
            assert_printed(np.array(quoted), weights)
        elif "the rim speed of" in sentence:
            assert np.count_nonzero(weights) == 1
        else:
            assert not weights.any()
            assert ": no " in sentence or "slip least" in sentence


def test_sentences_of_a_mecanum_robot():
    told = explain(trundle.load("mecanum"))
    assert told.wheels[0] == (
        "front_left (mecanum, heading 0 deg, roller -45 deg): it pushes along the line at -45 deg "
        "through (0.2, 0.15) m; its lever arm about the origin is 0.2475 m, clockwise at positive "
        "speed. Alone on the ground it has 3 degrees of freedom: the wheel, the roller and turning "
        "about the contact."
    )
    assert told.matrix[1] == (
        "v = 0.0125 (front_right + rear_left - front_left - rear_right): sideways speed is the "
        "mean of the rim speeds, those of front_left and rear_right counted backwards."
    )
    assert told.matrix[2].endswith(
        "over the arm of 0.35 m. In one radian of turning on the spot each rim runs 0.35 m, so "
        "the arm divides."
    )
    assert told.constraints[0] == (
        "front_left rolls: cos(-45 deg) (u - 0.15 r) + sin(-45 deg) (v + 0.2 r) = 0.03536 omega, "
        "that is 0.7071 u - 0.7071 v - 0.2475 r = 0.03536 omega. The contact is held along the "
        "roller's axis; across it the roller turns freely."
    )


def test_sentences_of_a_differential_drive():
    told = explain(trundle.load("differential"))
    assert told.matrix[1] == (
        "v = 0: no driven wheel gives v: the side slip of left and right forbids it."
    )
    assert told.wheels[2] == (
        "caster (caster): at (-0.16, 0) m it follows every motion and restricts none. Alone on the "
        "ground it has 3 degrees of freedom: rolling, turning about the contact and about the "
        "pivot."
    )
    assert told.constraints[1] == (
        "left does not slip sideways: cos(0 deg) v - sin(0 deg) (u - 0.2 r) = 0, that is v = 0."
    )
    assert told.constraints[-1] == (
        "Together they leave 2 motions of 3: straight forward or back and turning on the spot."
    )
    assert list(told) == [*told.wheels, *told.matrix, *told.constraints]
    assert [title for title, _ in told.sections] == [
        "Wheels",
        "Rows of W (a wheel's name stands for its speed in rad/s)",
        "Constraints (omega is the wheel's speed in rad/s)",
    ]


def test_dead_wheels_and_reversed_wheels_are_told():
    told = explain(trundle.load("mixed"))
    dead = next(text for text in told.wheels if text.startswith("dead_left"))
    assert "Its turning is measured, for odometry." in dead
    assert "holds its point against side slip" in dead
    assert "It is mounted reversed" in explain(trundle.load("omni4")).wheels[0]
    free = explain(trundle.load("tricycle"), [0.0]).constraints
    assert "It is neither driven nor measured: the row only tells its speed." in free[2]


def test_why_a_row_is_zero():
    straight = explain(trundle.load("tricycle"), [0.0]).matrix[2]
    assert straight == (
        "r = 0: no driven wheel gives r: the side slip of front, rear_left and rear_right forbids "
        "it at these angles."
    )
    slipping = explain(trundle.load("skid_steer")).matrix[1]
    assert "slip least" in slipping
    cancelled = explain(trundle.load("mecanum_lecture", wheelbase=0.6, track=0.6)).matrix[2]
    assert cancelled == "r = 0: no row forbids r, but no driven wheel gives it either."
    ball = Robot(name="ball", wheels=(BallWheel(name="ball", x=0.1, y=0.0),))
    assert explain(ball).matrix[0] == "u = 0: no wheel is driven."


def test_a_robot_whose_wheels_hold_it_is_told():
    wheels = [(0.0, 0.0), (1.0, 0.3), (1.0, 1.3)]
    held = Robot(
        name="held",
        wheels=tuple(
            FixedWheel(name=f"w{i}", x=x, y=0.2 * i, radius=0.1, heading=heading)
            for i, (x, heading) in enumerate(wheels)
        ),
    )
    told = explain(held)
    assert all(
        sentence.startswith(f"{n} = 0: no driven")
        for n, sentence in zip("uvr", told.matrix, strict=True)
    )
    assert told.constraints[-1] == "Together they leave no motion."


def test_steering_angles_are_asked_for_and_checked():
    with pytest.raises(ShapeError, match="give the steering angles of front"):
        explain(trundle.load("tricycle"))
    with pytest.raises(OffCentreError, match="share no instantaneous centre"):
        explain(trundle.load("ackermann"), [0.3, 0.3])
    turned = Robot(
        name="turned",
        wheels=(SteeredWheel(name="a", x=0.5, y=0.0, radius=0.1, heading=math.radians(80)),),
    )
    # 80 + 120 deg is -160 deg.
    assert "the line at -160 deg" in explain(turned, [math.radians(120)]).wheels[0]
