"""Laws of the kinematics, over the whole catalogue and batch shapes."""

import dataclasses
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from catalogue import (
    BATCH_SHAPES,
    CURVED,
    CURVED_RATIOS,
    ROBOTS,
    all_reversed,
    each_plane_robot,
    each_robot,
    each_steered,
    feasible_twists,
    kinematics,
    mirrored,
    reordered,
    scaled,
    seen_from,
    several,
    steering_for,
    twist_space,
)
from geometry import (
    Floats,
    allowed_twists,
    misfits,
    nearest_linked,
    rolling_rows,
    turned,
    turning,
    velocity,
    wheel_matrix,
)
from trundle import Kinematics
from trundle.errors import InfeasibleTwistError, ShapeError, TrundleError, UnobservedMotionWarning
from trundle.kinematics import diagnose, explain
from trundle.robot import BallWheel, CasterWheel, FixedWheel, OmniWheel, Robot, SteeredWheel

# Sums of some dozen products of numbers below 100, each rounded at 1e-16.
ROUNDING = 1e-12
# Plain floats and arrays must agree as closely as the order of operations allows.
BOUND = 1e-12
# Curved families of twists are searched by an iteration that stops near 1e-7 of the twist.
SEARCHED = 1e-6
# Brute-force searches: half the step of a grid of steering angles, and of a grid of directions.
GRID = 1e-5
BRUTE = 5e-4

each_shape = pytest.mark.parametrize("shape", BATCH_SHAPES, ids=str)


def tolerance(robot: Robot) -> float:
    return SEARCHED if robot is CURVED else ROUNDING


def cases(twist: Floats) -> list[tuple[int, ...]]:
    return list(np.ndindex(twist.shape[:-1]))


def worst_misfit(robot: Robot, found: trundle.Inverse, twist: Floats) -> float:
    return max(
        max(misfits(robot, twist[at], found.wheel_speeds[at], found.steering[at]).values())
        for at in cases(twist)
    )


# ---- round trip and the wheels' contacts ---------------------------------------------------


@each_robot
@each_shape
def test_inverse_then_forward_gives_an_achievable_twist_back(
    robot: Robot, shape: tuple[int, ...]
) -> None:
    kin, twist = kinematics(robot), feasible_twists(robot, shape)
    found = kin.inverse(twist)
    steering = found.steering if robot.steered else None
    assert found.wheel_speeds.shape == (*shape, len(robot.driven))
    assert found.steering.shape == (*shape, len(robot.steered))
    assert found.twist.shape == found.residual.shape == (*shape, 3)
    np.testing.assert_allclose(found.twist, twist, atol=tolerance(robot))
    np.testing.assert_allclose(found.twist + found.residual, twist, atol=ROUNDING)
    np.testing.assert_allclose(
        kin.forward(found.wheel_speeds, steering), found.twist, atol=ROUNDING
    )
    if not robot.steered:
        np.testing.assert_array_equal(found.residual, np.zeros((*shape, 3)))


@each_robot
@each_shape
def test_each_contact_moves_as_its_wheel_says(robot: Robot, shape: tuple[int, ...]) -> None:
    twist = feasible_twists(robot, shape)
    found = kinematics(robot).inverse(twist)
    assert worst_misfit(robot, found, found.twist) < ROUNDING


@each_robot
@pytest.mark.parametrize("about", [(0.0, 0.0), (0.3, -0.2)], ids=str)
def test_the_contacts_also_fit_the_nearest_twist_of_an_infeasible_one(
    robot: Robot, about: tuple[float, float]
) -> None:
    twist = np.concatenate([np.random.default_rng(3).normal(size=(3, 3)), np.eye(3), -np.eye(3)])
    found = kinematics(robot).inverse(twist[: several(robot, 9)], about=about)
    u, v, r = np.moveaxis(found.twist, -1, 0)
    origin = np.stack([u + r * about[1], v - r * about[0], r], axis=-1)
    assert worst_misfit(robot, found, origin) < ROUNDING


@each_plane_robot
def test_the_twist_given_is_the_nearest_that_the_robot_can_have(robot: Robot) -> None:
    twist = np.random.default_rng(4).normal(size=(6, 3))
    space, _ = np.linalg.qr(twist_space(robot))
    np.testing.assert_allclose(
        kinematics(robot).inverse(twist).twist, twist @ space @ space.T, atol=ROUNDING
    )


@pytest.mark.parametrize(
    "name",
    ["omni4", "mecanum", "ackermann", "swerve", "odd_omni", "odd_swerve", "odd_differential"],
)
def test_the_contact_check_refuses_a_mirrored_robot(name: str) -> None:
    """A pair of maps fitted to each other by round trip can describe the mirrored robot."""
    robot, wrong = ROBOTS[name], mirrored(ROBOTS[name])
    twist = feasible_twists(wrong, (5,))
    found = kinematics(wrong).inverse(twist)
    assert worst_misfit(robot, found, twist) > 0.05  # the twists are near 1 m/s and 1 rad/s


@each_robot
def test_forward_is_w_on_consistent_speeds(robot: Robot) -> None:
    kin, twist = kinematics(robot), feasible_twists(robot, (several(robot, 4),))
    found = kin.inverse(twist)
    W = kin.wheel_matrix(found.steering if robot.steered else None)
    np.testing.assert_allclose(
        (W @ found.wheel_speeds[..., None])[..., 0], found.twist, atol=ROUNDING
    )


@each_robot
def test_w_equals_the_matrix_computed_apart(robot: Robot) -> None:
    for twist in feasible_twists(robot, (3,), seed=5):
        steering = steering_for(robot, twist)
        ours = kinematics(robot).wheel_matrix(steering if robot.steered else None)
        np.testing.assert_allclose(ours, wheel_matrix(robot, steering), atol=ROUNDING)


@each_robot
def test_constraints_are_the_contact_velocities_of_the_unit_twists(robot: Robot) -> None:
    steering = np.random.default_rng(8).uniform(-1.0, 1.0, len(robot.steered))
    A, R, C = kinematics(robot).constraints(steering if robot.steered else None)
    rows, gains = rolling_rows(robot, robot.driven, steering)
    np.testing.assert_allclose(A, rows, atol=ROUNDING)
    np.testing.assert_allclose(R, gains, atol=ROUNDING)
    no_slip = [w for w in robot.wheels if isinstance(w, FixedWheel | SteeredWheel)]
    no_slip = [w for w in no_slip if not getattr(w, "skid", False)]
    assert C.shape == (len(no_slip), 3)
    angles = dict(zip([w.name for w in robot.steered], steering, strict=True))
    for row, wheel in zip(C, no_slip, strict=True):
        across = complex(0, 1) * np.exp(1j * (wheel.heading + angles.get(wheel.name, 0.0)))
        for coefficient, unit in zip(row, np.eye(3), strict=True):
            sideways = (velocity(unit, wheel.x, wheel.y) * across.conjugate()).real
            assert coefficient == pytest.approx(sideways, abs=ROUNDING)


# ---- invariance ----------------------------------------------------------------------------


def maps(robot: Robot, steering: Floats) -> Floats:
    return kinematics(robot).wheel_matrix(steering if robot.steered else None)


@each_robot
@pytest.mark.parametrize("angle", [0.7, math.pi / 2, -2.5])
def test_turning_the_body_frame_turns_the_twist(robot: Robot, angle: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])  # old components to new ones
    steering = steering_for(robot, feasible_twists(robot, (), seed=9))
    np.testing.assert_allclose(
        maps(seen_from(robot, 0.0, 0.0, angle), steering),
        turn @ maps(robot, steering),
        atol=ROUNDING,
    )


@each_robot
def test_a_mirrored_robot_has_mirrored_twists(robot: Robot) -> None:
    steering = steering_for(robot, feasible_twists(robot, (), seed=10))
    flip = np.diag([1.0, -1.0, -1.0])
    np.testing.assert_allclose(
        maps(mirrored(robot), -steering), flip @ maps(robot, steering), atol=ROUNDING
    )


@each_robot
def test_the_order_of_the_wheels_only_orders_the_columns(robot: Robot) -> None:
    order = np.random.default_rng(11).permutation(len(robot.wheels))
    other = reordered(robot, order)
    twist = feasible_twists(robot, ())
    steering = dict(zip([w.name for w in robot.steered], steering_for(robot, twist), strict=True))
    ours = maps(robot, np.array([steering[w.name] for w in robot.steered]))
    column = {wheel.name: ours[:, i] for i, wheel in enumerate(robot.driven)}
    np.testing.assert_allclose(
        maps(other, np.array([steering[w.name] for w in other.steered])),
        np.stack([column[wheel.name] for wheel in other.driven], axis=-1),
        atol=ROUNDING,
    )


@each_robot
@pytest.mark.parametrize("size", [1e-3, 0.1, 1e3])
def test_scaling_all_lengths_scales_the_velocities(robot: Robot, size: float) -> None:
    steering = steering_for(robot, feasible_twists(robot, (), seed=12))
    back = np.diag([1 / size, 1 / size, 1.0]) @ maps(scaled(robot, size), steering)
    np.testing.assert_allclose(back, maps(robot, steering), rtol=1e-9, atol=ROUNDING)


@each_robot
def test_a_shifted_origin_equals_about(robot: Robot) -> None:
    if any(getattr(wheel, "track_factor", 1.0) != 1.0 for wheel in robot.wheels):
        pytest.skip("a track factor widens the robot about the line through its origin")
    point = (0.31, -0.17)
    twist = np.random.default_rng(13).normal(size=(several(robot, 4), 3))
    about = kinematics(robot).inverse(twist, about=point)
    moved = kinematics(seen_from(robot, *point, 0.0)).inverse(twist)
    atol = 1e-5 if robot is CURVED else ROUNDING  # speeds are the searched twist over a radius
    np.testing.assert_allclose(about.wheel_speeds, moved.wheel_speeds, atol=100 * atol)
    np.testing.assert_allclose(about.twist, moved.twist, atol=atol)
    np.testing.assert_allclose(about.residual, moved.residual, atol=atol)


def test_a_turn_about_a_point_leaves_the_point_at_rest() -> None:
    found = kinematics(ROBOTS["mecanum"]).inverse([0.0, 0.0, 2.0], about=(0.3, 0.1))
    u, v, r = kinematics(ROBOTS["mecanum"]).forward(found.wheel_speeds)
    assert (u - r * 0.1, v + r * 0.3, r) == pytest.approx((0.0, 0.0, 2.0), abs=ROUNDING)


@each_robot
def test_time_reversal_turns_the_wheels_backwards(robot: Robot) -> None:
    kin, twist = kinematics(robot), feasible_twists(robot, (several(robot, 5),))
    present = steering_for(robot, twist) if robot.steered else None
    there = kin.inverse(twist, steering=present)
    back = kin.inverse(-twist, steering=present)
    np.testing.assert_allclose(back.steering, there.steering, atol=tolerance(robot))
    np.testing.assert_allclose(back.wheel_speeds, -there.wheel_speeds, atol=100 * tolerance(robot))


@each_robot
def test_reversed_motors_only_change_the_sign(robot: Robot) -> None:
    other, twist = all_reversed(robot), feasible_twists(robot, (several(robot, 4),))
    ours, theirs = kinematics(robot).inverse(twist), kinematics(other).inverse(twist)
    np.testing.assert_array_equal(theirs.wheel_speeds, -ours.wheel_speeds)
    np.testing.assert_array_equal(theirs.steering, ours.steering)
    np.testing.assert_allclose(
        maps(other, ours.steering[0]), -maps(robot, ours.steering[0]), atol=ROUNDING
    )


@each_robot
def test_running_twice_gives_the_same(robot: Robot) -> None:
    twist = feasible_twists(robot, (several(robot, 3),))
    first, second = Kinematics(robot).inverse(twist), Kinematics(robot).inverse(twist)
    np.testing.assert_array_equal(first.wheel_speeds, second.wheel_speeds)
    np.testing.assert_array_equal(first.steering, second.steering)


@each_robot
def test_an_item_does_not_depend_on_its_batch(robot: Robot) -> None:
    kin = kinematics(robot)
    twist = np.random.default_rng(15).normal(size=(3, 3)) * [[1e4], [1.0], [1e-10]]
    together = kin.inverse(twist)
    for k, alone in enumerate(map(kin.inverse, twist)):
        size = np.abs(twist[k]).max()
        for name in ("wheel_speeds", "steering", "twist", "residual"):
            np.testing.assert_allclose(
                getattr(together, name)[k],
                getattr(alone, name),
                rtol=1e-9,
                atol=1e-9 if name == "steering" else 100 * ROUNDING * size,
                err_msg=name,
            )


@pytest.mark.parametrize("name", ["differential", "ackermann", "mixed", "odd_differential"])
def test_w_does_not_depend_on_how_often_a_side_slip_row_is_there(name: str) -> None:
    robot = ROBOTS[name]
    axle = next(wheel for wheel in robot.wheels if isinstance(wheel, FixedWheel))
    c, s = math.cos(axle.heading), math.sin(axle.heading)
    extra = tuple(
        dataclasses.replace(
            axle, name=f"extra{k}", x=axle.x - k * s, y=axle.y + k * c, driven=False
        )
        for k in (1, 2, 3)
    )
    more = dataclasses.replace(robot, wheels=robot.wheels + extra)
    steering = steering_for(robot, feasible_twists(robot, ()))
    np.testing.assert_allclose(maps(more, steering), maps(robot, steering), atol=ROUNDING)


# ---- residual ------------------------------------------------------------------------------


@each_robot
def test_the_residual_is_zero_where_all_wheels_agree(robot: Robot) -> None:
    found = kinematics(robot).inverse(feasible_twists(robot, (2, several(robot, 3))))
    steering = found.steering if robot.steered else None
    residual = kinematics(robot).residual(found.wheel_speeds, steering)
    assert residual.shape == found.wheel_speeds.shape
    np.testing.assert_allclose(residual, 0.0, atol=ROUNDING)


def test_one_omni_wheel_off_by_hand() -> None:
    """Rows (0, 1, l), (-1, 0, l), (0, -1, l), (1, 0, l): only (1, -1, 1, -1) / 2 fits no twist."""
    radius, extra = 0.05, 2.0
    speeds = np.array([extra, 0.0, 0.0, 0.0])
    residual = kinematics(trundle.load("omni", radius=radius)).residual(speeds)
    quarter = radius * extra / 4
    np.testing.assert_allclose(residual, [quarter, -quarter, quarter, -quarter], atol=ROUNDING)


@pytest.mark.parametrize("wheel", range(4))
def test_one_mecanum_wheel_off_by_hand(wheel: int) -> None:
    """Rows c (1, -+1, -+k): only (1, 1, -1, -1) / 2 over FL, FR, RL, RR fits no twist."""
    radius, extra = 0.05, 3.0
    robot = trundle.load("mecanum", radius=radius)
    found = kinematics(robot).inverse([0.4, -0.3, 0.8])
    speeds = found.wheel_speeds + extra * np.eye(4)[wheel]
    blind = np.array([1.0, 1.0, -1.0, -1.0]) / 2
    rim = radius * math.cos(math.pi / 4) * extra  # along the roller's axis
    np.testing.assert_allclose(
        kinematics(robot).residual(speeds), rim * blind[wheel] * blind, atol=ROUNDING
    )


def test_a_steered_wheels_speed_that_does_not_fit_shows_in_the_residual() -> None:
    """Ackermann, straight on: rear rims at 1.0 and 1.2 m/s turn it; the front wheels forbid that.

    With u and r open: minimise (u - b r - 1)^2 + (u + b r - 1.2)^2 + 2 (L r)^2, b half the track.
    """
    robot = trundle.load("ackermann", radius=0.5, wheelbase=2.0, track=1.0)
    u, r = 1.1, 0.5 * 0.2 / (2 * 0.25 + 2 * 4.0)
    twist = kinematics(robot).forward([2.0, 2.4], [0.0, 0.0])
    np.testing.assert_allclose(twist, [u, 0.0, r], atol=ROUNDING)
    np.testing.assert_allclose(
        kinematics(robot).residual([2.0, 2.4], [0.0, 0.0]),
        [1.0 - (u - 0.5 * r), 1.2 - (u + 0.5 * r)],
        atol=ROUNDING,
    )


def test_forward_names_the_motion_that_the_wheels_do_not_observe() -> None:
    """A bicycle with its front wheel across turns about the rear contact, and no motor tells."""
    kin = kinematics(ROBOTS["bicycle"])
    with pytest.warns(UnobservedMotionWarning, match="turning on the spot"):
        twist = kin.forward([1.0], [math.pi / 2])
    assert twist[2] == pytest.approx(0.0, abs=ROUNDING)
    with pytest.warns(UnobservedMotionWarning, match="turning on the spot"):
        kin.forward([[1.0], [1.0]], [[0.0], [math.pi / 2]])


# ---- plain functions -----------------------------------------------------------------------


def sizes(values: Floats) -> float:
    return 1.0 + float(np.abs(values).max(initial=0.0))


@each_robot
def test_the_bound_inverse_equals_the_array_inverse(robot: Robot) -> None:
    kin, bound = kinematics(robot), kinematics(robot).bind()
    random = np.random.default_rng(17).normal(size=(20, 3))
    twists = [*random, *np.eye(3), *-np.eye(3), *feasible_twists(robot, (3,))]
    for twist in twists[:: 8 if robot is CURVED else 1]:
        found = kin.inverse(twist, limit=False)
        wanted = np.concatenate([found.wheel_speeds, found.steering])
        got = np.array(bound.inverse(*twist.tolist()))
        got[len(robot.driven) :] = near(got[len(robot.driven) :], found.steering)
        np.testing.assert_allclose(got, wanted, atol=BOUND * sizes(wanted))


def near(angles: Floats, wanted: Floats) -> Floats:
    """Return angles by the turn that brings them nearest: -180 and 180 deg are one angle."""
    return angles - 2 * np.pi * np.round((angles - wanted) / (2 * np.pi))


@each_robot
def test_the_bound_inverse_stands_still(robot: Robot) -> None:
    bound = kinematics(robot).bind()
    for zeros in itertools.product((0.0, -0.0), repeat=3):
        np.testing.assert_array_equal(
            np.abs(bound.inverse(*zeros)), np.zeros(len(robot.driven) + len(robot.steered))
        )


@each_robot
def test_the_bound_forward_equals_the_array_forward(robot: Robot) -> None:
    kin, bound = kinematics(robot), kinematics(robot).bind()
    for twist in feasible_twists(robot, (20,)):
        steering = steering_for(robot, twist)
        speeds = np.random.default_rng(18).normal(size=len(robot.driven)) * 10
        wanted = kin.forward(speeds, steering if robot.steered else None)
        got = bound.forward(*speeds.tolist(), *steering.tolist())
        np.testing.assert_allclose(got, wanted, atol=BOUND * sizes(wanted))


@each_robot
@pytest.mark.parametrize("size", [0.0, 1e-320, 1e-300, 1e-12, 1e-6, 0.1, 3.0, 1e3])
def test_the_bound_step_equals_dead_reckoning(robot: Robot, size: float) -> None:
    bound = kinematics(robot).bind()
    for sign in (1.0, -1.0):
        moved = sign * size * feasible_twists(robot, (), seed=19)
        steering = steering_for(robot, feasible_twists(robot, (), seed=19))
        angles = steering if robot.steered else None
        turns = turning(robot, robot.sensed, moved, steering)
        start = (0.3, -0.2, 2.0)
        wanted = trundle.dead_reckon(robot, [turns], angles, start)[-1]
        got = bound.step(*start, *turns.tolist(), *steering.tolist())
        np.testing.assert_allclose(got, wanted, atol=BOUND * sizes(wanted))
        if size <= 1e-6:
            straight = moved[0] + 1j * moved[1]
            there = start[0] + 1j * start[1] + straight * np.exp(1j * start[2])
            # The arc's sideways part is half the product of turn and way.
            assert abs(complex(*got[:2]) - there) <= 10 * size**2 + ROUNDING


def test_the_bound_step_at_exactly_no_turn() -> None:
    bound = kinematics(trundle.load("differential", radius=0.1)).bind()
    assert bound.step(1.0, 2.0, math.pi / 2, 5.0, 5.0) == pytest.approx(
        (1.0, 2.5, math.pi / 2), abs=ROUNDING
    )


@pytest.mark.parametrize("turn", [2e-300, -2e-300, 5e-324, -5e-324, 1e-308, -1e-308])
def test_no_turn_is_too_small_for_the_step(turn: float) -> None:
    from trundle import se2

    assert se2.step(0.0, 0.0, 0.0, 1.0, 2.0, turn) == pytest.approx((1.0, 2.0, turn), abs=ROUNDING)


# ---- the lectures' pseudo-inverses ---------------------------------------------------------


def test_the_right_inverse_is_the_minimum_norm_one() -> None:
    """X-drive, all reversed, model.md erratum 3: v_i = u sin th - v cos th - r R."""
    robot = trundle.load("omni4", radius=0.1, arm=0.5)
    th = np.radians([45.0, 315.0, 135.0, 225.0])
    rims = np.stack([np.sin(th), -np.cos(th), np.full(4, -0.5)], axis=-1)
    # Its columns are orthogonal, so this inverse of the forward map has the least norm.
    np.testing.assert_allclose(kinematics(robot).right_inverse(), rims / 0.1, atol=ROUNDING)


def test_the_left_inverse_of_a_differential_drive() -> None:
    """W = [[a/2, a/2], [0, 0], [-a/2d, a/2d]] has orthogonal columns of the plane (u, r)."""
    robot = trundle.load("differential", radius=0.1, track=0.5)
    hand = np.array([[1.0, 0.0, -0.25], [1.0, 0.0, 0.25]]) / 0.1
    np.testing.assert_allclose(kinematics(robot).left_inverse(), hand, atol=ROUNDING)


def test_the_pseudo_inverses_of_a_square_w_are_its_inverse() -> None:
    kin = kinematics(ROBOTS["omni3"])
    for inverse in (kin.left_inverse(), kin.right_inverse()):
        np.testing.assert_allclose(inverse @ kin.W, np.eye(3), atol=ROUNDING)


def test_each_pseudo_inverse_tells_the_condition_that_fails() -> None:
    with pytest.raises(TrundleError, match="right inverse needs rank W = 3, but W has rank 2"):
        kinematics(ROBOTS["differential"]).right_inverse()
    with pytest.raises(
        TrundleError, match=r"left inverse needs rank W = n, but W has rank 3.*n = 4"
    ):
        kinematics(ROBOTS["mecanum"]).left_inverse()
    with pytest.raises(TrundleError, match="rank 1"):
        kinematics(ROBOTS["ackermann"]).left_inverse([0.0, 0.0])
    with pytest.raises(TrundleError, match="rank 2"):
        kinematics(trundle.load("mecanum_lecture", track=0.6)).right_inverse()


def test_the_pseudo_inverses_take_batches_of_angles() -> None:
    kin, angles = kinematics(ROBOTS["omni_steer"]), np.linspace(-1.0, 1.0, 5)[:, None]
    each = np.stack([np.linalg.pinv(wheel_matrix(ROBOTS["omni_steer"], angle)) for angle in angles])
    alone = np.stack([np.linalg.pinv(kin.wheel_matrix(angle)) for angle in angles])
    np.testing.assert_allclose(alone, each, atol=1e-9)
    swerve = kinematics(trundle.load("swerve", positions=[(0.5, 0.0)]))
    hand = np.stack([swerve.left_inverse(angle) for angle in angles])
    np.testing.assert_allclose(swerve.left_inverse(angles), hand, atol=ROUNDING)


def test_a_steered_robot_has_no_single_w() -> None:
    with pytest.raises(
        TrundleError, match=r"'tricycle' steers.*call wheel_matrix\(steering\).*front"
    ):
        _ = kinematics(ROBOTS["tricycle"]).W


# ---- strict and wheel-speed limits ---------------------------------------------------------


def test_strict_refuses_what_the_robot_cannot_do() -> None:
    kin = kinematics(ROBOTS["differential"])
    with pytest.raises(
        InfeasibleTwistError,
        match=r"'differential' cannot have the twist .* \(0\.1, 0\.2, 0\).*\(0\.1, 0, 0\)",
    ):
        kin.inverse([0.1, 0.2, 0.0], strict=True)
    assert kin.inverse([0.1, 0.2, 0.0]).residual == pytest.approx([0.0, 0.2, 0.0], abs=ROUNDING)


@each_robot
def test_strict_lets_an_achievable_twist_pass(robot: Robot) -> None:
    if robot is CURVED:
        pytest.skip("its twists are met to the digits of a search only")
    kinematics(robot).inverse(feasible_twists(robot, (2, 3)), strict=True)


@each_robot
def test_strict_refuses_only_the_item_that_cannot_be(robot: Robot) -> None:
    if len(twist_space(robot)[0]) == 3:
        pytest.skip("it can have every twist")
    bad = np.random.default_rng(20).normal(size=3)
    batch = np.stack([1e6 * feasible_twists(robot, ()), bad])
    if robot is CURVED:
        batch = bad
    with pytest.raises(InfeasibleTwistError):
        kinematics(robot).inverse(batch, strict=True)


@each_plane_robot
def test_a_speed_limit_keeps_the_curvature(robot: Robot) -> None:
    twist = feasible_twists(robot, (6,)) * np.array([0.01, 0.1, 1.0, 3.0, 10.0, 100.0])[:, None]
    most = np.linspace(4.0, 9.0, len(robot.driven))
    limits = dict(zip([w.name for w in robot.driven], most, strict=True))
    limited = dataclasses.replace(
        robot,
        wheels=tuple(
            dataclasses.replace(w, max_speed=limits[w.name]) if w.name in limits else w
            for w in robot.wheels
        ),
    )
    free, held = kinematics(robot).inverse(twist), Kinematics(limited).inverse(twist)
    load = (np.abs(free.wheel_speeds) / most).max(axis=-1, keepdims=True)
    assert (load < 1).any()
    assert (load > 1).any()
    np.testing.assert_allclose(held.twist, twist / np.maximum(load, 1.0), rtol=1e-9, atol=ROUNDING)
    np.testing.assert_allclose(
        (np.abs(held.wheel_speeds) / most).max(axis=-1), np.minimum(load[:, 0], 1.0), rtol=1e-9
    )
    np.testing.assert_allclose(held.twist + held.residual, twist, rtol=1e-12, atol=ROUNDING)
    assert worst_misfit(limited, held, held.twist) < ROUNDING
    unlimited = Kinematics(limited).inverse(twist, limit=False)
    np.testing.assert_allclose(unlimited.wheel_speeds, free.wheel_speeds, rtol=1e-12)
    with pytest.raises(InfeasibleTwistError, match="within its limits"):
        Kinematics(limited).inverse(twist, strict=True)


# ---- steering limits -----------------------------------------------------------------------


def steering_limited(name: str, degrees: float, **sizes: float) -> Robot:
    most = math.radians(degrees)
    return trundle.load(name, **sizes).with_wheels(steering_min=-most, steering_max=most)


def check_limits(robot: Robot, found: trundle.Inverse) -> None:
    """The angles keep their limits and the contacts move as the wheels say."""
    for at in cases(found.twist):
        assert max(
            misfits(robot, found.twist[at], found.wheel_speeds[at], found.steering[at]).values()
        ) == pytest.approx(0.0, abs=1e-8)  # the projection onto the limits is iterated
        for wheel, angle in zip(robot.steered, found.steering[at], strict=True):
            low, high = wheel.steering_range
            assert low - ROUNDING <= angle <= high + ROUNDING


def brute_tricycle(asked: Floats, wheelbase: float, most: float) -> Floats:
    """Return the nearest twist over a fine grid of steering angles: (cos, 0, sin / L) scaled."""
    angle = np.linspace(-most, most, 200_001)
    ways = np.stack([np.cos(angle), 0 * angle, np.sin(angle) / wheelbase], axis=-1)
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    reach = ways @ asked
    best = int(np.argmax(np.abs(reach)))
    return np.asarray(reach[best] * ways[best])


@pytest.mark.parametrize(
    "twist", [(0.2, 0.0, 1.0), (-0.2, 0.0, 1.0), (0.0, 0.0, 1.0), (0.1, 0.4, -2.0), (1.0, 0.0, 0.1)]
)
def test_steering_limits_give_the_nearest_twist_of_a_tricycle(
    twist: tuple[float, float, float],
) -> None:
    robot = steering_limited("tricycle", 30, wheelbase=0.8)
    found = Kinematics(robot).inverse(twist)
    check_limits(robot, found)
    near = brute_tricycle(np.array(twist), 0.8, math.radians(30))
    ours = np.linalg.norm(np.array(twist) - found.twist)
    assert ours == pytest.approx(np.linalg.norm(np.array(twist) - near), abs=GRID)
    if np.abs(found.residual).max() == 0:
        return
    with pytest.raises(InfeasibleTwistError, match="within its limits"):
        Kinematics(robot).inverse(twist, strict=True)


def within(robot: Robot, twists: Floats) -> NDArray[np.bool_]:
    """Return which twists all wheels can have within their limits, if need be half a turn on."""
    inside = np.ones(len(twists), dtype=bool)
    for i, wheel in enumerate(robot.steered):
        angle = steering_for(robot, twists)[:, i]
        low, high = wheel.steering_range
        turns = [(angle + k * np.pi >= low) & (angle + k * np.pi <= high) for k in range(-3, 4)]
        inside &= np.any(turns, axis=0)
    return inside


def brute_sphere(robot: Robot, asked: Floats, about: tuple[float, float]) -> float:
    """Return the least distance over a grid of directions of a point's twist, and a finer one."""
    middle, span = np.array([np.pi / 2, np.pi / 2]), np.array([np.pi / 2, np.pi / 2])
    x, y = about
    to_origin = np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])
    best = 0.0
    for _ in range(3):
        grids = [np.linspace(m - d, m + d, 181) for m, d in zip(middle, span, strict=True)]
        tilt, turn = (grid.ravel() for grid in np.meshgrid(*grids))
        flat = np.sin(tilt)
        ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), np.cos(tilt)], axis=-1)
        reach = np.where(within(robot, ways @ to_origin.T), np.abs(ways @ asked), 0.0)
        k = int(np.argmax(reach))
        best, middle, span = float(reach[k]), np.array([tilt[k], turn[k]]), span / 15
    return float(np.sqrt(max(asked @ asked - best**2, 0.0)))


@pytest.mark.parametrize("about", [(0.0, 0.0), (0.4, -0.3)], ids=str)
@pytest.mark.parametrize("twist", [(0.3, 1.0, 0.5), (0.0, 0.1, 1.5), (-0.5, -0.6, -0.7)], ids=str)
@pytest.mark.parametrize("name", ["two_steered", "swerve"])
def test_steering_limits_give_the_nearest_twist_of_robots_that_steer_all_wheels(
    name: str, twist: tuple[float, float, float], about: tuple[float, float]
) -> None:
    robot = steering_limited(name, 50)
    found = Kinematics(robot).inverse(twist, about=about)
    x, y = about
    u, v, r = found.twist
    check_limits(robot, dataclasses.replace(found, twist=np.array([u + r * y, v - r * x, r])))
    ours = float(np.linalg.norm(np.array(twist) - found.twist))
    brute = brute_sphere(robot, np.array(twist), about)
    assert ours <= brute + ROUNDING
    assert ours >= brute - BRUTE * np.linalg.norm(twist)


def test_only_one_of_two_wheels_limited() -> None:
    robot = trundle.load("two_steered")
    front = dataclasses.replace(robot.wheels[0], steering_min=-0.5, steering_max=0.5)
    robot = dataclasses.replace(robot, wheels=(front, *robot.wheels[1:]))
    found = Kinematics(robot).inverse([0.1, 1.0, 0.0])
    check_limits(robot, found)
    ours = float(np.linalg.norm(found.residual))
    brute = brute_sphere(robot, np.array([0.1, 1.0, 0.0]), (0.0, 0.0))
    assert brute - BRUTE <= ours <= brute + ROUNDING


def test_limits_that_do_not_hold_zero() -> None:
    """A front wheel that steers from 20 to 50 deg only turns left."""
    robot = trundle.load("tricycle", wheelbase=0.8)
    low, high = math.radians(20), math.radians(50)
    robot = robot.with_wheels(steering_min=low, steering_max=high)
    found = Kinematics(robot).inverse([[1.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    check_limits(robot, found)
    ends = [np.array([math.cos(b), 0.0, math.sin(b) / 0.8]) for b in (low, low, high)]
    for asked, given, end in zip(
        [[1.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], found.twist, ends, strict=True
    ):
        np.testing.assert_allclose(given, end * (end @ asked) / (end @ end), atol=1e-8)


@pytest.mark.parametrize("ratio", [1.0, -1.0, 2.0, 0.5])
def test_a_group_of_one_wheel_drives_backwards_within_its_limits(ratio: float) -> None:
    """Backwards straight on needs no steering, whatever the ratio of wheel and group angle."""
    wheels = (
        SteeredWheel(
            name="front", x=1.0, y=0.0, radius=0.1, steering_group="g", steering_ratio=ratio,
            steering_min=-0.5, steering_max=0.5,
        ),
        FixedWheel(name="rear", x=0.0, y=0.0, radius=0.1),
    )  # fmt: skip
    found = Kinematics(Robot(name="grouped", wheels=wheels)).inverse([-1.0, 0.0, 0.0])
    np.testing.assert_allclose(found.twist, [-1.0, 0.0, 0.0], atol=1e-8)
    np.testing.assert_allclose(found.steering, [0.0], atol=1e-8)
    np.testing.assert_allclose(found.wheel_speeds, [-10.0, -10.0], atol=1e-6)


def test_limits_of_one_group_that_no_angle_keeps() -> None:
    """Wheels at q and -q that must both stand between 10 and 30 deg."""
    for ratio in (-1.0, -0.5):
        wheels = tuple(
            SteeredWheel(
                name=name, x=x, y=0.0, radius=0.1, steering_group="g", steering_ratio=q,
                steering_min=math.radians(10), steering_max=math.radians(30),
            )
            for name, x, q in (("front", 0.5, 1.0), ("rear", -0.5, ratio))
        )  # fmt: skip
        with pytest.raises(TrundleError, match=r"front.*rear|'g'"):
            Kinematics(Robot(name="jammed", wheels=wheels)).inverse([1.0, 0.0, 0.0])


def test_a_limited_wheel_on_the_spot_of_a_fixed_one_does_not_slide() -> None:
    """It cannot stand along it: only turning about the spot is left, which nothing drives."""
    robot = Robot(
        name="twins",
        wheels=(
            SteeredWheel(
                name="s", x=0.0, y=-0.5, radius=0.1, steering_min=-1.8, steering_max=-1.35
            ),
            FixedWheel(name="f", x=0.0, y=-0.5, radius=0.1),
        ),
    )
    check_limits(robot, Kinematics(robot).inverse([0.9, 1.4, 1.3]))


def test_ackermann_angles_are_exact() -> None:
    """cot(left) and cot(right) are the distances of the centre from the wheels over L."""
    wheelbase, track, centre = 2.6, 1.5, 6.0
    robot = trundle.load("ackermann", wheelbase=wheelbase, track=track, radius=0.3)
    found = Kinematics(robot).inverse([1.2, 0.0, 1.2 / centre])
    left = math.atan2(wheelbase, centre - track / 2)
    right = math.atan2(wheelbase, centre + track / 2)
    np.testing.assert_allclose(found.steering, [left, right], atol=ROUNDING)
    rims = 1.2 / centre * np.array([centre - track / 2, centre + track / 2])
    np.testing.assert_allclose(found.wheel_speeds, rims / 0.3, atol=ROUNDING)


# ---- present steering ----------------------------------------------------------------------


@each_steered
def test_with_present_angles_each_wheel_turns_by_at_most_a_quarter(robot: Robot) -> None:
    if robot is CURVED:
        pytest.skip("a half turn of one wheel is none of the other")
    twist = feasible_twists(robot, (40,), seed=21)
    random = np.random.default_rng(22)
    present = steering_for(robot, feasible_twists(robot, (40,), seed=23))
    present += np.pi * random.integers(-3, 4, size=(40, 1))
    found = kinematics(robot).inverse(twist, steering=present)
    wanted = steering_for(robot, twist)
    np.testing.assert_allclose(turned(found.steering - wanted), 0.0, atol=1e-9)
    if not any(wheel.steering_group for wheel in robot.steered):
        assert np.abs(found.steering - present).max() <= math.pi / 2 + ROUNDING
    assert worst_misfit(robot, found, twist) < ROUNDING
    np.testing.assert_allclose(found.twist, twist, atol=ROUNDING)


@each_steered
def test_at_standstill_the_present_angles_are_held(robot: Robot) -> None:
    present = steering_for(robot, feasible_twists(robot, (3,), seed=24))
    found = kinematics(robot).inverse(np.zeros((3, 3)), steering=present)
    np.testing.assert_allclose(found.steering, present, atol=ROUNDING)
    np.testing.assert_array_equal(found.wheel_speeds, np.zeros((3, len(robot.driven))))


@pytest.mark.parametrize("name", ["swerve", "two_steered", "odd_swerve"])
def test_a_module_that_the_body_turns_about_holds_its_angle(name: str) -> None:
    robot = ROBOTS[name]
    for i, wheel in enumerate(robot.steered):
        present = np.linspace(0.3, 0.9, len(robot.steered))
        found = kinematics(robot).inverse([wheel.y, -wheel.x, 1.0], steering=present)
        assert found.steering[i] == pytest.approx(present[i], abs=ROUNDING)
        if wheel.driven:
            k = [w.name for w in robot.driven].index(wheel.name)
            assert found.wheel_speeds[k] == pytest.approx(0.0, abs=ROUNDING)


def test_a_swerve_that_reverses_turns_its_wheels_not_its_modules() -> None:
    kin, present = kinematics(ROBOTS["swerve"]), np.zeros(4)
    found = kin.inverse([[-1.0, 0.0, 0.0], [-1.0, 0.1, 0.0]], steering=present)
    np.testing.assert_allclose(found.steering[0], 0.0, atol=ROUNDING)
    np.testing.assert_allclose(found.steering[1], math.atan2(-0.1, 1.0), atol=ROUNDING)
    assert (found.wheel_speeds < 0).all()
    # Without present angles they point along the velocity; 180 and -180 deg are one direction.
    np.testing.assert_allclose(
        np.abs(kin.inverse([-1.0, 0.0, 0.0]).steering), math.pi, atol=ROUNDING
    )


def test_present_angles_of_one_twist_make_a_batch() -> None:
    present = np.array([[0.1] * 4, [3.0] * 4, [2.0] * 4])
    found = kinematics(ROBOTS["swerve"]).inverse([0.0, 1.0, 0.0], steering=present)
    assert found.steering.shape == (3, 4)
    np.testing.assert_allclose(found.steering, math.pi / 2, atol=ROUNDING)


# ---- linked steering -----------------------------------------------------------------------


def test_synchro_gives_the_nearest_twist_without_turning() -> None:
    found = kinematics(ROBOTS["synchro"]).inverse([0.3, -0.4, 2.0])
    np.testing.assert_allclose(found.twist, [0.3, -0.4, 0.0], atol=ROUNDING)
    np.testing.assert_allclose(found.steering, math.atan2(-0.4, 0.3), atol=ROUNDING)
    np.testing.assert_allclose(found.wheel_speeds, 0.5 / 0.05, atol=ROUNDING)


def test_counter_phase_steering_turns_about_a_point_midway() -> None:
    """Centre at (0, 2): the wheels at (+-1, +-0.7) stand at atan2(x, 2 - y), rear the other way."""
    found = kinematics(ROBOTS["four_wheel_steered"]).inverse([1.0, 0.0, 0.5])
    inner, outer = math.atan2(1.0, 1.3), math.atan2(1.0, 2.7)
    np.testing.assert_allclose(found.steering, [inner, outer, -inner, -outer], atol=ROUNDING)
    rims = 0.5 * np.hypot(1.0, [1.3, 2.7, 1.3, 2.7])
    np.testing.assert_allclose(found.wheel_speeds, rims / 0.3, atol=ROUNDING)


@pytest.mark.parametrize("ratio", [-0.5, 0.5, -0.3, 2.0])
@pytest.mark.parametrize(
    "twist",
    [
        (1.0, 0.0, 0.4),
        (0.2, 1.0, 0.0),
        (0.3, -0.2, 1.5),
        (0.0, 0.0, 1.0),
        (-1.0, 0.5, 0.2),
        (1.5, -1.2, 1.5),
    ],
)
def test_curved_linked_steering_is_as_near_as_brute_force(
    ratio: float, twist: tuple[float, float, float]
) -> None:
    rear = dataclasses.replace(CURVED.wheels[1], steering_ratio=ratio)
    robot = dataclasses.replace(CURVED, name="linked", wheels=(CURVED.wheels[0], rear))
    found = kinematics(robot).inverse(twist)
    # After these half turns of the group both wheels stand on the same lines again (at -0.3 only
    # after five turns, which no steering column makes: half a turn is searched there).
    halves = {-0.5: 2, 0.5: 2, -0.3: 1, 2.0: 1}[ratio]
    brute = nearest_linked(robot, twist, (1.0, ratio), -halves * math.pi / 2, halves * math.pi / 2)
    assert float(np.linalg.norm(found.residual)) <= brute + SEARCHED
    assert found.steering[1] == pytest.approx(ratio * found.steering[0], abs=ROUNDING)
    assert worst_misfit(robot, found, found.twist) < ROUNDING


@pytest.mark.parametrize(
    ("low", "high"), [(-2.6, 1.0), (1.8, 2.9), (-3.1, 3.1)], ids=["wide", "behind", "a turn"]
)
def test_curved_linked_steering_searches_all_of_its_range(low: float, high: float) -> None:
    front, rear = CURVED.wheels
    front = dataclasses.replace(front, steering_min=low, steering_max=high)
    robot = dataclasses.replace(CURVED, wheels=(front, rear))
    for twist in ([-0.2, 1.0, -0.2], [0.3, -0.5, 1.0], [-1.0, -0.4, 0.3]):
        found = Kinematics(robot).inverse(twist)
        brute = nearest_linked(robot, twist, CURVED_RATIOS, low, high)
        assert float(np.linalg.norm(found.residual)) == pytest.approx(brute, abs=SEARCHED)


def test_curved_linked_steering_keeps_its_limits() -> None:
    most = 0.4
    robot = CURVED.with_wheels(steering_min=-most, steering_max=most)
    for twist in ([0.3, 0.0, 1.5], [0.0, 1.0, 0.0], [-1.0, 0.1, -0.8]):
        found = Kinematics(robot).inverse(twist)
        assert np.abs(found.steering).max() <= most + ROUNDING
        brute = nearest_linked(robot, twist, CURVED_RATIOS, -most, most)
        assert float(np.linalg.norm(found.residual)) == pytest.approx(brute, abs=SEARCHED)


# ---- the numbers of the lectures -----------------------------------------------------------


def W_of(robot: Robot, steering: object = None) -> Floats:
    return np.asarray(Kinematics(robot).wheel_matrix(steering))  # type: ignore[arg-type]


def test_w_of_the_differential_drive() -> None:
    a, d = 0.2, 0.3
    robot = trundle.load("differential", radius=a, track=2 * d)
    np.testing.assert_allclose(
        W_of(robot), [[a / 2, a / 2], [0, 0], [-a / (2 * d), a / (2 * d)]], atol=ROUNDING
    )


def test_w_of_three_omni_wheels() -> None:
    a, l, root = 0.2, 0.3, math.sqrt(3)
    hand = a / 3 * np.array([[0, -root, root], [2, -1, -1], [1 / l, 1 / l, 1 / l]])
    np.testing.assert_allclose(W_of(trundle.load("omni3")), hand, atol=ROUNDING)


def test_w_of_the_exercise_spins_the_other_way() -> None:
    a, l, root = 0.1, 0.5, math.sqrt(3)
    hand = -a / 3 * np.array([[0, -root, root], [2, -1, -1], [1 / l, 1 / l, 1 / l]])
    np.testing.assert_allclose(W_of(trundle.load("omni3_exercise")), hand, atol=ROUNDING)


def mecanum_lecture(a: float, k: float) -> Floats:
    return a / 4 * np.array([[1, 1, 1, 1], [1, -1, 1, -1], [-k, -k, k, k]])


def test_w_of_the_mecanum_lecture() -> None:
    a, l, d = 0.2, 0.3, 0.5
    robot = trundle.load("mecanum_lecture")
    np.testing.assert_allclose(W_of(robot), mecanum_lecture(a, 1 / (d - l)), atol=ROUNDING)


def test_w_of_the_mecanum_lecture_with_d_equal_to_l() -> None:
    robot = trundle.load("mecanum_lecture", wheelbase=0.6, track=0.6)
    np.testing.assert_allclose(W_of(robot), mecanum_lecture(0.2, 0.0), atol=ROUNDING)
    assert np.linalg.matrix_rank(W_of(robot)) == 2


def test_w_of_the_usual_mecanum_has_the_sum_as_yaw_arm() -> None:
    """Mirrored rollers: v = a/4 (-FL + FR + RL - RR), r = a/(4 (l + d)) (-FL + FR - RL + RR)."""
    a, l, d = 0.05, 0.2, 0.15
    k = 1 / (l + d)
    hand = a / 4 * np.array([[1, 1, 1, 1], [-1, 1, 1, -1], [-k, k, -k, k]])
    np.testing.assert_allclose(W_of(trundle.load("mecanum")), hand, atol=ROUNDING)


def test_w_of_the_x_drive_with_reversed_wheels() -> None:
    """model.md, erratum 3: u = sum v sin th / 2, v = -sum v cos th / 2, r = -sum v / (4 R)."""
    a, arm = 0.05, 0.2
    th = np.radians([45.0, 315.0, 135.0, 225.0])
    hand = a * np.stack([np.sin(th) / 2, -np.cos(th) / 2, np.full(4, -1 / (4 * arm))])
    np.testing.assert_allclose(W_of(trundle.load("omni4")), hand, atol=ROUNDING)
    forward = kinematics(ROBOTS["omni4"]).inverse([1.0, 0.0, 0.0]).wheel_speeds
    np.testing.assert_allclose(forward, np.sin(th) / a, atol=ROUNDING)


@pytest.mark.parametrize("beta", [0.0, 0.4, -1.0])
def test_w_of_the_tricycle(beta: float) -> None:
    """The front rim's speed a omega splits into cos beta along the body and sin beta across."""
    a, L = 0.1, 0.8
    np.testing.assert_allclose(
        W_of(trundle.load("tricycle"), [beta]),
        a * np.array([[math.cos(beta)], [0.0], [math.sin(beta) / L]]),
        atol=ROUNDING,
    )


@pytest.mark.parametrize("beta", [0.0, 0.4, -1.0])
def test_w_of_the_bicycle(beta: float) -> None:
    """The rear wheel gives u = a omega, the front wheel r = u tan(beta) / L."""
    np.testing.assert_allclose(
        W_of(trundle.load("bicycle"), [beta]),
        0.3 * np.array([[1.0], [0.0], [math.tan(beta) / 1.0]]),
        atol=ROUNDING,
    )


def test_w_of_the_skid_steer() -> None:
    """Each side's mean rim speed; the turn over the effective track; no side slip at the middle."""
    a, track, factor = 0.1, 0.5, 1.5
    hand = np.array([[1, 1, 1, 1], [0, 0, 0, 0], [-1, 1, -1, 1]], dtype=float)
    hand[0] *= a / 4
    hand[2] *= a / (2 * factor * track)
    robot = trundle.load("skid_steer", radius=a, track=track, track_factor=factor)
    np.testing.assert_allclose(W_of(robot), hand, atol=ROUNDING)


def test_w_of_two_steered_wheels() -> None:
    """Both wheels across: v is the mean, r the difference over the wheelbase; no forward motion."""
    robot = trundle.load("two_steered", radius=0.1, wheelbase=0.5)
    kin = Kinematics(robot)
    W = kin.wheel_matrix([math.pi / 2, math.pi / 2])
    np.testing.assert_allclose(W, [[0, 0], [0.05, 0.05], [0.2, -0.2]], atol=ROUNDING)
    # Both ahead: side slip holds v and r, and both wheels give u.
    W = kin.wheel_matrix([0.0, 0.0])
    np.testing.assert_allclose(W, [[0.05, 0.05], [0, 0], [0, 0]], atol=ROUNDING)


def test_the_question_that_the_omni_lecture_left_open() -> None:
    kin = kinematics(trundle.load("omni3"))
    np.testing.assert_allclose(
        kin.inverse([0.0, 0.5, 0.0]).wheel_speeds, [2.5, -1.25, -1.25], atol=ROUNDING
    )
    for sideways in ([2.0, 0.0, 0.0], [1.0, -1.0, -1.0]):  # the lecture's tries also turn
        assert kin.forward(sideways)[2] != pytest.approx(0.0, abs=0.1)


def test_equal_speeds_turn_omni3_and_opposite_ones_drive_it() -> None:
    kin = kinematics(trundle.load("omni3"))
    np.testing.assert_allclose(kin.forward([0.5] * 3), [0.0, 0.0, 1 / 3], atol=ROUNDING)
    np.testing.assert_allclose(kin.forward([0.0, -0.5, 0.5]), [0.11547, 0.0, 0.0], atol=5e-6)


# ---- degenerate robots and what users get wrong --------------------------------------------


def test_a_robot_without_motors_gives_nothing() -> None:
    robot = Robot(
        name="cart",
        wheels=(CasterWheel(name="a", x=1.0, y=0.0, radius=0.1), BallWheel(name="b", x=0.0, y=0.0)),
    )
    kin = Kinematics(robot)
    assert kin.W.shape == (3, 0)
    found = kin.inverse([[1.0, 2.0, 3.0]])
    assert found.wheel_speeds.shape == (1, 0)
    np.testing.assert_array_equal(found.residual, [[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(kin.bind().inverse(1.0, 2.0, 3.0), ())


def test_locked_wheels_give_no_motion() -> None:
    wheels = tuple(
        FixedWheel(name=str(i), x=math.cos(i), y=math.sin(i), radius=0.1, heading=0.7 * i)
        for i in range(3)
    )
    kin = Kinematics(Robot(name="locked", wheels=wheels))
    np.testing.assert_array_equal(kin.W, np.zeros((3, 3)))
    np.testing.assert_array_equal(kin.inverse([1.0, 2.0, 3.0]).residual, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("about", [(0.0, 0.0), (0.0, 1.0), (-2.0, 0.5)], ids=str)
def test_no_answer_is_worse_than_standing_still(about: tuple[float, float]) -> None:
    """One driven steered wheel leaves turning to chance; the point asked for may lie anywhere."""
    wheels = (
        SteeredWheel(name="s", x=0.2, y=0.1, radius=0.1),
        BallWheel(name="ball", x=0.0, y=0.0),
    )
    kin = Kinematics(Robot(name="pushed", wheels=wheels))
    for twist in np.random.default_rng(25).normal(size=(20, 3)):
        found = kin.inverse(twist, about=about)
        assert np.linalg.norm(found.residual) <= np.linalg.norm(twist) + ROUNDING
        # What is told as given is what W gives, taken at the point.
        u, v, r = kin.wheel_matrix(found.steering) @ found.wheel_speeds
        given = [u - r * about[1], v + r * about[0], r]
        np.testing.assert_allclose(found.twist, given, atol=ROUNDING)


def test_an_idle_wheel_that_may_skid_holds_nothing_that_the_others_drive() -> None:
    idle = FixedWheel(name="idle", x=0.1, y=0.0, radius=0.05, driven=False, skid=True)
    robot = ROBOTS["omni3"]
    robot = dataclasses.replace(robot, wheels=(*robot.wheels, idle))
    np.testing.assert_allclose(W_of(robot), W_of(ROBOTS["omni3"]), atol=ROUNDING)


def test_a_single_omni_wheel_gives_the_least_motion() -> None:
    """Of all twists that turn it, W takes the one of least norm: along the row (0, 1, 1)."""
    wheel = OmniWheel(name="a", x=1.0, y=0.0, radius=0.2, heading=math.pi / 2)
    W = Kinematics(Robot(name="one", wheels=(wheel,))).W
    np.testing.assert_allclose(W[:, 0], np.array([0.0, 1.0, 1.0]) * 0.2 / 2, atol=ROUNDING)


@pytest.mark.parametrize("name", ["swerve", "tricycle"])
def test_steering_angles_are_asked_for(name: str) -> None:
    kin = kinematics(ROBOTS[name])
    with pytest.raises(ShapeError, match=f"{name!r} steers: give the steering angles of front"):
        kin.forward(np.ones(len(ROBOTS[name].driven)))


def test_w_cannot_be_changed_by_accident() -> None:
    with pytest.raises(ValueError, match="read-only"):
        kinematics(ROBOTS["omni3"]).W[0, 0] = 1.0


@each_robot
def test_a_batch_of_angles_gives_a_batch_of_matrices(robot: Robot) -> None:
    steering = steering_for(robot, feasible_twists(robot, (2, 3)))
    W = kinematics(robot).wheel_matrix(steering)
    assert W.shape == (2, 3, 3, len(robot.driven))
    for at in np.ndindex(2, 3):
        np.testing.assert_allclose(W[at], wheel_matrix(robot, steering[at]), atol=ROUNDING)


@each_robot
def test_forward_takes_batches_of_speeds_and_one_set_of_angles(robot: Robot) -> None:
    twist = feasible_twists(robot, ())
    steering = steering_for(robot, twist)
    one = kinematics(robot).inverse(twist, steering=steering if robot.steered else None)
    speeds = np.array([[0.5], [1.0], [-2.0]]) * one.wheel_speeds
    got = kinematics(robot).forward(speeds, one.steering if robot.steered else None)
    np.testing.assert_allclose(got, np.array([[0.5], [1.0], [-2.0]]) * one.twist, atol=ROUNDING)


def test_allowed_twists_of_this_file_are_what_geometry_says() -> None:
    """The helpers themselves, by hand: a differential drive cannot go sideways."""
    N = allowed_twists(ROBOTS["differential"], [])
    np.testing.assert_allclose(N @ N.T, np.diag([1.0, 0.0, 1.0]), atol=ROUNDING)
    assert misfits(ROBOTS["differential"], (0.0, 1.0, 0.0), (0.0, 0.0))["left"] == 1.0


@pytest.mark.parametrize("name", ["swerve", "two_steered", "tricycle", "ackermann", "rear_steered"])
def test_straight_back_without_present_angles_is_half_a_turn(name: str) -> None:
    found = Kinematics(trundle.load(name)).inverse([-1.0, 0.0, 0.0])
    np.testing.assert_array_equal(found.steering, math.pi)


def test_what_is_handed_out_cannot_change_the_kinematics() -> None:
    kin = Kinematics(trundle.load("mecanum"))
    _, gains, _ = kin.constraints()
    with pytest.raises(ValueError, match="read-only"):
        gains[0] = 7.0


@pytest.mark.parametrize(
    "call", [trundle.mobility, diagnose, explain, lambda robot: trundle.dead_reckon(robot, [[1.0]])]
)
def test_a_name_in_place_of_a_robot_is_told(call: Callable[[Any], object]) -> None:
    with pytest.raises(TrundleError, match=r"a Robot is needed, such as trundle\.load"):
        call("omni3")
