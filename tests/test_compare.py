"""A matrix from elsewhere beside ours: each difference is named, and nothing else."""

import time

import numpy as np
import pytest

import trundle
from trundle.errors import FileError, OffCentreError, ShapeError, TrundleError
from trundle.kinematics.compare import compare_matrix, read_matrix
from trundle.robot import CATALOG, BallWheel, FixedWheel, MecanumWheel, Robot

# Two routes to the same entry in double precision, entries up to a hundred.
ROUNDING = 1e-12

# The catalogue's usual mecanum: radius, half the wheelbase, half the track.
A, L, D = 0.05, 0.2, 0.15
X = np.array([L, L, -L, -L])
Y = np.array([D, -D, D, -D])
ROLLERS = np.array([-1.0, 1.0, 1.0, -1.0])  # tangent of the roller angles -45, 45, 45, -45 deg
NAMES = ("front_left", "front_right", "rear_left", "rear_right")


def mecanum_inverse(tangents=ROLLERS):
    """omega_i = (u + t v + (t x - y) r) / a, with t the tangent of the roller's angle."""
    return np.column_stack([np.ones(4), tangents, tangents * X - Y]) / A


def mecanum_forward(arm=L + D):
    """The textbook's forward map of the usual arrangement, wheels in the catalogue's order."""
    k = 1 / arm
    return A / 4 * np.array([[1, 1, 1, 1], [-1, 1, 1, -1], [-k, k, -k, k]])


def lecture_forward(a, l, d):
    """The lecture's W, wheels at (l, d), (-l, d), (-l, -d), (l, -d)."""
    k = 1 / (d - l)
    return a / 4 * np.array([[1, 1, 1, 1], [1, -1, 1, -1], [-k, -k, k, k]])


def omni4_inverse():
    """v_i = u sin th - v cos th - r R: the rim speeds of the slides, with their sign mended."""
    th = np.radians([45, 315, 135, 225])
    return np.column_stack([np.sin(th), -np.cos(th), np.full(4, -0.2)])


def differential_forward(a=0.05, d=0.2):
    return np.array([[a / 2, a / 2], [0, 0], [-a / (2 * d), a / (2 * d)]])


def omni3_forward(a=0.2, l=0.3):
    root = np.sqrt(3)
    return a / 3 * np.array([[0, -root, root], [2, -1, -1], [1 / l, 1 / l, 1 / l]])


def told(robot, matrix, **sizes):
    """Return the comparison with a catalogue robot, its codes, and its sentences in one text."""
    steering = sizes.pop("steering", None)
    found = compare_matrix(trundle.load(robot, **sizes), matrix, steering)
    return (
        found,
        [each.code for each in found.findings],
        " ".join(each.message for each in found.findings),
    )


@pytest.mark.parametrize(
    ("robot", "matrix", "form", "quantity"),
    [
        ("mecanum", mecanum_forward(), "forward", "wheel speeds in rad/s"),
        ("mecanum", mecanum_forward() / A, "forward", "rim speeds in m/s"),
        ("mecanum", mecanum_inverse(), "inverse", "wheel speeds in rad/s"),
        ("mecanum", A * mecanum_inverse(), "inverse", "rim speeds in m/s"),
        ("mecanum_lecture", lecture_forward(0.2, 0.3, 0.5), "forward", "wheel speeds in rad/s"),
        ("omni4", omni4_inverse(), "inverse", "rim speeds in m/s"),
        ("omni4", omni4_inverse() / 0.05, "inverse", "wheel speeds in rad/s"),
        ("differential", differential_forward(), "forward", "wheel speeds in rad/s"),
        ("omni3", omni3_forward(), "forward", "wheel speeds in rad/s"),
        ("omni3", np.linalg.inv(omni3_forward()), "inverse", "wheel speeds in rad/s"),
        ("omni3", 0.2 * np.linalg.inv(omni3_forward()), "inverse", "rim speeds in m/s"),
    ],
)
def test_the_right_matrix_agrees_in_every_form(robot, matrix, form, quantity):
    found, codes, _ = told(robot, matrix)
    assert found.agrees
    assert codes == []
    assert (found.form, found.quantity) == (form, quantity)
    assert found.order == tuple(wheel.name for wheel in trundle.load(robot).driven)
    assert found.largest_difference < ROUNDING
    np.testing.assert_allclose(found.ours, matrix, atol=ROUNDING)


# Steering angles that share a centre: straight ahead, or about a point on the fixed axle's line.
STEERING = {
    "tricycle": [0.4],
    "bicycle": [0.4],
    "ackermann": [np.arctan2(2.6, 4 - 0.75), np.arctan2(2.6, 4 + 0.75)],
    "rear_steered": [0.0, 0.0],
    "four_wheel_steered": [0.0] * 4,
    "two_steered": [0.3, -0.2],
    "synchro": [0.7] * 3,
    "swerve": [0.5] * 4,
    "omni_steer": [0.6],
}


@pytest.mark.parametrize("name", CATALOG)
def test_every_robots_own_maps_agree_in_every_form_and_order(name):
    robot = trundle.load(name)
    steering = STEERING.get(name)
    kin = trundle.Kinematics(robot)
    W = kin.wheel_matrix(steering)
    A, R, _ = kin.constraints(steering)
    radii = np.array([wheel.radius for wheel in robot.driven])
    inverse = A / R[:, None]
    turned = np.roll(np.arange(len(radii)), 1)
    for matrix in (W, W / radii, inverse, radii[:, None] * inverse):
        found = compare_matrix(robot, matrix, steering)
        assert found.agrees
        assert found.findings == ()
        assert found.largest_difference < 1e-9  # entries up to a hundred, through an SVD
        other = matrix[:, turned] if found.form == "forward" else matrix[turned]
        found = compare_matrix(robot, other, steering)
        # Where wheels stand in a symmetric pattern, another order is also another frame.
        assert found.agrees or {each.code for each in found.findings} <= {
            "vx_sign", "vy_sign", "wz_sign", "axes_swapped", "all_reversed", "order",
        }  # fmt: skip


def test_the_slides_inverse_drives_backwards():
    found, codes, text = told("omni4", omni4_inverse() * [-1, 1, 1])
    assert not found.agrees
    assert (found.form, found.quantity) == ("inverse", "rim speeds in m/s")
    assert codes == ["vx_sign"]
    assert text == "the VX column has the wrong sign, so that +VX drives backwards"
    assert found.largest_difference == pytest.approx(2 * np.sqrt(0.5), abs=ROUNDING)
    np.testing.assert_allclose(found.ours, omni4_inverse(), atol=ROUNDING)


def test_the_slides_forward_maps_are_right():
    th = np.radians([45, 315, 135, 225])
    forward = np.array([np.sin(th) / 2, -np.cos(th) / 2, np.full(4, -1 / (4 * 0.2))])
    found, codes, _ = told("omni4", forward)
    assert found.agrees
    assert codes == []


def test_the_lectures_mecanum_has_all_rollers_mirrored():
    found, codes, text = told("mecanum", lecture_forward(A, L, D))
    assert codes == ["rollers_mirrored", "order"]
    assert "45 deg in place of -45 deg" in text
    assert "the yaw arm of 'front_left' is 0.05 m in place of 0.35 m" in text
    assert found.order == ("front_left", "rear_left", "rear_right", "front_right")
    # Ours in the order of the lecture: the signs of VY and the arm L + D.
    k = 1 / (L + D)
    ours = A / 4 * np.array([[1, 1, 1, 1], [-1, 1, -1, 1], [-k, -k, k, k]])
    np.testing.assert_allclose(found.ours, ours, atol=ROUNDING)


def test_the_usual_mecanum_has_all_rollers_of_the_lecture_mirrored():
    k = 1 / 0.8
    usual = 0.05 * np.array([[1, 1, 1, 1], [-1, 1, -1, 1], [-k, -k, k, k]])
    _, codes, text = told("mecanum_lecture", usual)
    assert codes == ["rollers_mirrored"]
    assert "is 0.8 m in place of 0.2 m" in text


@pytest.mark.parametrize("form", ["forward", "inverse"])
def test_one_mirrored_roller(form):
    matrix = mecanum_inverse(ROLLERS * [-1, 1, 1, 1])
    matrix = matrix if form == "inverse" else np.linalg.pinv(matrix)
    found, codes, text = told("mecanum", matrix)
    assert codes == ["roller_mirrored"]
    assert "'front_left' has the sign of a mirrored roller" in text
    assert found.form == form
    assert found.order == NAMES


@pytest.mark.parametrize("form", ["forward", "inverse"])
def test_two_mirrored_rollers_and_a_reversed_wheel(form):
    matrix = mecanum_inverse(ROLLERS * [-1, 1, 1, -1]) * [[1], [-1], [1], [1]]
    matrix = matrix if form == "inverse" else np.linalg.pinv(matrix)
    _, codes, text = told("mecanum", matrix)
    assert codes == ["reversed", "roller_mirrored"]
    assert "'front_right' is reversed" in text
    assert "'front_left' and 'rear_right' have the sign of a mirrored roller" in text


@pytest.mark.parametrize(
    ("matrix", "line"), [(mecanum_inverse(), "row"), (mecanum_forward(), "column")]
)
def test_the_sign_of_a_mirrored_roller_in_one_line_only(matrix, line):
    matrix = matrix.copy()
    matrix[1, 1] *= -1  # VY of front_right in both forms
    _, codes, text = told("mecanum", matrix)
    assert codes == ["roller_sign"]
    words = "has VX and VY as if its roller were mirrored, but WZ as ours: one sign is wrong"
    assert text == f"{line} 'front_right' {words}"


@pytest.mark.parametrize(
    ("robot", "matrix", "where"),
    [
        ("mecanum", (mecanum_inverse, (2, 2)), "row 'rear_left', column WZ"),
        ("mecanum", (mecanum_forward, (0, 3)), "column 'rear_right', row VX"),
        ("omni3", (omni3_forward, (2, 1)), "column 'wheel_2', row WZ"),
    ],
)
def test_one_lost_sign(robot, matrix, where):
    make, at = matrix
    wrong = make()
    wrong[at] *= -1
    _, codes, text = told(robot, wrong)
    assert codes == ["entry_sign"]
    assert text == f"{where}: the entry has the wrong sign"


@pytest.mark.parametrize(
    ("factors", "code", "text"),
    [
        ([-1, 1, 1], "vx_sign", "+VX drives backwards"),
        ([1, -1, 1], "vy_sign", "+VY drives to the right"),
        ([1, 1, -1], "wz_sign", "+WZ turns clockwise"),
        ([-1, -1, -1], "all_reversed", "all wheels are reversed"),
        ([1, 1, 2], "arm_doubled", "twice ours: the yaw arm is 0.7 m in place of 0.35 m"),
        ([1, 1, 0.5], "arm_halved", "half of ours: the yaw arm is 0.175 m in place of 0.35 m"),
        ([1, 1, np.pi / 180], "degrees", "deg/s"),
        ([1, 2, 1], "vy_factor", "the VY column is twice ours"),
        ([0.5, 1, 1], "vx_factor", "the VX column is half of ours"),
        ([2, 2, 2], "factor", "every entry is twice ours"),
        ([0.5, 0.5, 0.5], "factor", "the diameter 0.1 m in place of the radius 0.05 m"),
        ([4, 4, 4], "factor", "every entry is 4 times ours"),
        ([60 / (2 * np.pi)] * 3, "rpm", "rev/min in place of rad/s"),
        ([0.05 / 0.06] * 3, "radius", "the radius 0.06 m in place of 0.05 m"),
        ([0.9 * 0.05] * 3, "scale", "every entry is 0.9 times ours"),
        ([np.sqrt(0.5)] * 3, "roller_cosine", "the cosine of the roller angle is left out"),
    ],
)
def test_factors_on_the_columns_of_an_inverse(factors, code, text):
    found, codes, words = told("mecanum", mecanum_inverse() * factors)
    assert codes == [code]
    assert text in words
    assert not found.agrees
    assert found.order == NAMES


@pytest.mark.parametrize(
    ("factors", "code", "text"),
    [
        ([-1, 1, 1], "vx_sign", "driving forwards comes out as driving backwards"),
        ([1, -1, 1], "vy_sign", "driving to the left comes out as driving to the right"),
        ([1, 1, -1], "wz_sign", "turning counter-clockwise comes out as clockwise"),
        ([1, 1, 0.5], "arm_doubled", "half of ours: the yaw arm is 0.7 m in place of 0.35 m"),
        ([1, 1, 180 / np.pi], "degrees", "the WZ row is 57.3 times ours"),
        ([4, 4, 4], "factor", "a sum over the 4 wheels in place of their mean"),
        ([2, 2, 2], "factor", "the diameter 0.1 m in place of the radius 0.05 m"),
        ([2 * np.pi / 60] * 3, "rpm", "rev/min"),
        ([1.2, 1.2, 1.2], "radius", "the radius 0.06 m in place of 0.05 m"),
    ],
)
def test_factors_on_the_rows_of_a_forward_matrix(factors, code, text):
    _, codes, words = told("mecanum", mecanum_forward() * np.array(factors)[:, None])
    assert codes == [code]
    assert text in words


@pytest.mark.parametrize(
    ("arm", "code", "text"),
    [
        (L - D, "arm_difference", "is 0.05 m in place of 0.35 m"),
        (D - L, "arm_difference", "is 0.05 m in place of 0.35 m, with the other sign"),
        (L + 2 * D, "full_track", "is 0.5 m in place of 0.35 m"),
        (2 * L + D, "full_wheelbase", "is 0.55 m in place of 0.35 m"),
        (D, "no_wheelbase", "is 0.15 m in place of 0.35 m"),
        (L, "no_track", "is 0.2 m in place of 0.35 m"),
    ],
)
@pytest.mark.parametrize("form", ["forward", "inverse"])
def test_other_yaw_arms(arm, code, text, form):
    inverse = mecanum_inverse()
    inverse[:, 2] = np.array([-1, 1, -1, 1]) * arm / A
    matrix = inverse if form == "inverse" else mecanum_forward(arm)
    _, codes, words = told("mecanum", matrix)
    assert codes == [code]
    assert text in words


def test_a_sum_where_the_lectures_arm_belongs():
    inverse = np.array([[1, 1, -0.8], [1, -1, -0.8], [1, 1, 0.8], [1, -1, 0.8]]) / 0.2
    _, codes, words = told("mecanum_lecture", inverse)
    assert codes == ["arm_difference"]
    assert "is 0.8 m in place of 0.2 m" in words


def test_full_track_of_a_differential_drive():
    matrix = differential_forward()
    matrix[2] /= 2
    _, codes, text = told("differential", matrix)
    assert codes == ["arm_doubled"]
    assert text.endswith("is 0.4 m in place of 0.2 m, the full track in place of half of it")


def test_a_differential_drive_may_leave_out_vy():
    short = differential_forward()[[0, 2]]
    found, codes, _ = told("differential", short)
    assert found.agrees
    assert codes == []
    assert found.ours.shape == (2, 2)
    inverse = np.array([[1, -0.2], [1, 0.2]]) / 0.05
    found, codes, _ = told("differential", inverse)
    assert (found.form, found.agrees) == ("inverse", True)
    np.testing.assert_allclose(found.ours, inverse, atol=ROUNDING)


def test_a_forbidden_motion_may_hold_anything_in_an_inverse():
    found, codes, _ = told("differential", [[20, 7, -4], [20, -3, 4]])
    assert found.agrees
    assert codes == []
    assert found.largest_difference < ROUNDING


def test_a_forward_matrix_must_not_give_a_forbidden_motion():
    matrix = differential_forward()
    matrix[1] = [0.01, 0.02]
    found, codes, _ = told("differential", matrix)
    assert not found.agrees
    assert codes == ["unexplained", "entry", "entry"]
    assert found.findings[1].message == "row VY, column 'right': 0.02 in place of 0"


def test_a_mean_only_in_one_row():
    matrix = differential_forward() * [[2], [1], [1]]
    _, codes, text = told("differential", matrix)
    assert codes == ["vx_factor"]
    assert text == "the VX row is twice ours"


@pytest.mark.parametrize("order", [(0, 2, 1, 3), (1, 0, 2, 3), (3, 0, 1, 2)])
@pytest.mark.parametrize("form", ["forward", "inverse"])
def test_another_order_of_the_wheels_agrees_and_is_told(order, form):
    matrix = mecanum_inverse()[list(order)]
    if form == "forward":
        matrix = mecanum_forward()[:, list(order)]
    found, codes, text = told("mecanum", matrix)
    assert found.agrees
    assert codes == ["order"]
    assert found.order == tuple(NAMES[i] for i in order)
    assert found.largest_difference < ROUNDING
    moved = [NAMES[k] for k in range(4) if order[k] != k]
    if len(moved) == 2:
        line = "rows" if form == "inverse" else "columns"
        names = " and ".join(repr(name) for name in moved)
        assert text == f"order swapped: the {line} of {names} have changed places"


def test_our_order_is_preferred_where_another_says_the_same():
    # Left and right swapped is the same matrix as yaw clockwise, and that needs no other order.
    found, codes, _ = told("differential", differential_forward()[:, ::-1])
    assert codes == ["wz_sign"]
    assert found.order == ("left", "right")


def test_a_transposed_matrix():
    found, codes, text = told("mecanum", mecanum_forward().T)
    assert codes == ["transposed"]
    assert "it is the forward matrix" in text
    assert found.form == "forward"
    np.testing.assert_allclose(found.ours, mecanum_forward(), atol=ROUNDING)
    _, codes, text = told("mecanum", mecanum_inverse().T)
    assert codes == ["transposed"]
    assert "which is not the forward matrix" in text


def test_swapped_axes():
    _, codes, text = told("omni3", omni3_forward()[[1, 0, 2]])
    assert codes == ["axes_swapped"]
    assert text == "the rows VX and VY are swapped"
    # x to the right and y ahead: a frame turned by a quarter.
    matrix = mecanum_inverse()[:, [1, 0, 2]] * [-1, 1, 1]
    _, codes, _ = told("mecanum", matrix)
    assert codes == ["axes_swapped", "vx_sign"]


def test_one_side_reversed():
    _, codes, text = told("mecanum", mecanum_inverse() * [[1], [-1], [1], [-1]])
    assert codes == ["reversed"]
    assert text == "'front_right' and 'rear_right' are reversed: the rows have the wrong sign"


def test_the_clockwise_exercise_robot_is_the_lectures_robot_reversed():
    matrix = omni3_forward(a=0.1, l=0.5)
    _, codes, _ = told("omni3_exercise", matrix)
    assert codes == ["all_reversed"]


def test_rounded_matrices_agree_to_the_digits_given():
    for decimals in (4, 3):
        found, codes, text = told("omni3", omni3_forward().round(decimals))
        assert found.agrees
        assert codes == ["rounded"]
        assert text == "it agrees to the digits given"
    _, codes, text = told("mecanum", (mecanum_inverse() * [-1, 1, 1]).round(1))
    assert codes[0] == "vx_sign"
    # A hundredth is more than the rounding of four digits.
    found, _, _ = told("omni3", omni3_forward() * [[1], [1], [1.01]])
    assert not found.agrees


def test_wheels_of_two_sizes_tell_rim_speeds_from_wheel_speeds():
    robot = Robot(
        name="two sizes",
        wheels=(
            FixedWheel(name="left", x=0.0, y=0.2, radius=0.05),
            FixedWheel(name="right", x=0.0, y=-0.2, radius=0.1),
        ),
    )
    rim = np.array([[1, 0, -0.2], [1, 0, 0.2]])
    spin = rim / [[0.05], [0.1]]
    for matrix, quantity in ((rim, "rim speeds in m/s"), (spin, "wheel speeds in rad/s")):
        for pasted in (matrix, np.linalg.pinv(matrix)):
            found = compare_matrix(robot, pasted)
            assert found.agrees
            assert found.quantity == quantity


def test_one_mirrored_roller_among_wheels_of_two_sizes():
    radii, angles = np.array([0.05, 0.05, 0.1, 0.1]), np.arctan(ROLLERS)
    wheels = [
        MecanumWheel(name=name, x=x, y=y, radius=a, roller=angle)
        for name, x, y, a, angle in zip(NAMES, X, Y, radii, angles, strict=True)
    ]
    angles[2] *= -1
    c, s = np.cos(angles), np.sin(angles)
    # W = A^+ R: least squares in speeds along the rollers' axes.
    forward = np.linalg.pinv(np.column_stack([c, s, X * s - Y * c])) * radii * c
    found = compare_matrix(Robot(name="two sizes", wheels=tuple(wheels)), forward)
    assert [each.code for each in found.findings] == ["roller_mirrored"]
    assert "column 'rear_left' has the sign" in found.findings[0].message


def test_a_steered_robot_is_compared_at_its_angles():
    steer, wheelbase, a = 0.5, 0.8, 0.1
    right = np.array([[a * np.cos(steer)], [0], [a * np.sin(steer) / wheelbase]])
    found, codes, _ = told("tricycle", right, steering=[steer])
    assert found.agrees
    assert codes == []
    wrong = right * [[1], [1], [-1]]
    _, codes, _ = told("tricycle", wrong, steering=[steer])
    assert codes == ["wz_sign"]
    with pytest.raises(ShapeError, match="give the steering angles of front"):
        told("tricycle", right)
    with pytest.raises(OffCentreError, match="share no instantaneous centre"):
        told("ackermann", np.zeros((3, 2)), steering=[0.3, 0.3])


def test_a_skid_steer_robot_with_half_its_track():
    matrix = 0.1 / 4 * np.array([[1] * 4, [0] * 4, [-8, 8, -8, 8]])  # track 0.5 m, arm 0.25 m
    _, codes, text = told("skid_steer", matrix)
    assert codes == ["arm_halved"]
    assert "0.125 m in place of 0.25 m" in text


def test_a_forward_map_that_weighs_the_wheels_in_another_way():
    # Three of four wheels determine the twist; the fourth is left unread.
    matrix = np.column_stack([np.linalg.inv(mecanum_inverse()[:3]), np.zeros(3)])
    found, codes, text = told("mecanum", matrix)
    assert not found.agrees
    assert codes == ["other_weights"]
    assert "while no wheel slips" in text


def test_where_nothing_explains_it_the_entries_that_differ_most_are_named():
    matrix = mecanum_inverse()
    matrix[2, 0] = 26.0
    matrix[1, 2] = 12.0
    found, codes, _ = told("mecanum", matrix)
    assert not found.agrees
    assert codes == ["unexplained", "entry", "entry"]
    assert found.findings[0].message == (
        "no simple change explains the difference: 2 of 12 entries differ"
    )
    assert found.findings[1].message == "row 'front_right', column WZ: 12 in place of 7"
    assert found.findings[2].message == "row 'rear_left', column VX: 26 in place of 20"
    assert found.largest_difference == pytest.approx(6.0, abs=ROUNDING)


def test_a_search_without_result_takes_less_than_a_second():
    robot = trundle.load("omni", angles=[0.0, 1.0, 2.0, 3.0, 4.0, 5.2])
    random = np.random.default_rng(1)
    compare_matrix(robot, random.normal(size=(3, 6)))  # loads scipy
    for shape in ((6, 3), (3, 6)):
        start = time.process_time()
        assert not compare_matrix(robot, random.normal(size=shape)).agrees
        # Measured 0.4 s on a slow core; three times that for a slower one.
        assert time.process_time() - start < 1.2


def test_shapes_that_fit_no_form_are_told():
    with pytest.raises(ShapeError, match=r"is 3 x 5, but robot 'mecanum' has 4 driven wheels: a"):
        told("mecanum", np.zeros((3, 5)))
    with pytest.raises(ShapeError, match=r"an inverse 2 x 3 \(without VY: 2 x 2, 2 x 2\)"):
        told("differential", np.zeros((4, 4)))
    with pytest.raises(ShapeError, match="must be finite numbers"):
        told("mecanum", np.full((3, 4), np.nan))
    with pytest.raises(ShapeError, match="the matrix is 3, but"):
        told("mecanum", np.zeros(3))
    with pytest.raises(TrundleError, match="no driven wheel moves it"):
        compare_matrix(Robot(name="b", wheels=(BallWheel(name="ball", x=0, y=0),)), np.eye(3))


@pytest.mark.parametrize("shape", [(3, 4), (4, 3)])
def test_zeros_are_no_matrix_of_this_robot(shape):
    found, codes, _ = told("mecanum", np.zeros(shape))
    assert not found.agrees
    assert codes[0] == "unexplained"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1,2\n3,4\n", [[1, 2], [3, 4]]),
        ("1, 2,\n3, 4,\n", [[1, 2], [3, 4]]),
        ("1;2\n3;4", [[1, 2], [3, 4]]),
        ("0,5; 2\n3; -4,25", [[0.5, 2], [3, -4.25]]),
        ("1\t2\n3\t4", [[1, 2], [3, 4]]),
        ("  1   2\n\n 3  4e-1 \n", [[1, 2], [3, 0.4]]),
        ("# from the slides\nleft,right\n1,2 # first\n3,4", [[1, 2], [3, 4]]),
        ("VX VY WZ\n1 2 3", [[1, 2, 3]]),
        ("\ufeff1,\u22122\n3,4", [[1, -2], [3, 4]]),
    ],
)
def test_matrices_are_read_from_text(tmp_path, text, expected):
    path = tmp_path / "matrix.csv"
    path.write_text(text, encoding="utf-8")
    assert read_matrix(path).tolist() == expected


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "there is no number in the file"),
        ("# nothing\n\n", "there is no number in the file"),
        ("a,b,c\n", "there is no number in the file"),
        ("1,2\n3,4\n5\n", "line 3 has 1 numbers, but line 1 has 2"),
        ("1,2\n3,four\n", "line 2, column 2: 'four' is not a number"),
        ("1,2\n\n,4\n", "line 3, column 1: a number is missing"),
        ("1,nan\n", "line 1, column 2: must be a finite number, got nan"),
        ("1,2\n-inf,2\n", "line 2, column 1: must be a finite number, got -inf"),
        ("left,1,2\n", "line 1, column 1: 'left' is not a number"),
    ],
)
def test_faults_of_a_matrix_file_are_told_with_line_and_column(tmp_path, text, words):
    path = tmp_path / "matrix.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_matrix(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_matrix_file_that_cannot_be_read(tmp_path):
    with pytest.raises(FileError, match="cannot be read: No such file"):
        read_matrix(tmp_path / "none.csv")
    with pytest.raises(FileError, match="cannot be read"):
        read_matrix(tmp_path)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="must be UTF-8 text"):
        read_matrix(binary)
