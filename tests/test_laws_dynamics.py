"""Laws of the dynamics, over the whole catalogue and awkward mixtures, all parts with masses."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import integrate, linalg, optimize

import trundle
from catalogue import (
    BATCH_SHAPES,
    CURVED_RATIOS,
    all_reversed,
    feasible_twists,
    mirrored,
    reordered,
    scaled,
    steering_for,
)
from geometry import Floats, allowed_twists, rolling_rows, slip_rows, turning, wheel_matrix
from masses import (
    HEAVY,
    STEERED,
    UNSTEERED,
    Motion,
    christoffel,
    cross,
    directions,
    each_heavy,
    each_steered_heavy,
    each_unsteered,
    friction,
    frictionless,
    heavy_seen_from,
    holding_wheels,
    motions,
    newton_euler,
    points,
    points_energy,
    points_mass_matrix,
    resultant,
    rolling_force,
    rolling_wheels,
    slope,
    steered_at,
    steering_rates,
    torques_for,
    velocities,
)
from trundle import Dynamics
from trundle.dynamics import GRAVITY, body_bias, to_body, to_inertial, wheel_loads
from trundle.robot import Robot, total_mass

# Sums of some dozen products, each rounded at 1e-16 of the largest of them.
ROUNDING = 1e-12
# Five-point differences of rows along a steered motion, divided by the robot's smallest inertia.
DIFFERENTIATED = 1e-9
# Energies at the end of an integration whose own tolerance is 1e-11 a step.
INTEGRATED = 1e-8
INTEGRATOR: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-11}

SHAPES = (*BATCH_SHAPES, (0,))
each_shape = pytest.mark.parametrize("shape", SHAPES, ids=str)
POSES = np.random.default_rng(2).normal(size=(3, 3))
RATES = np.random.default_rng(3).normal(size=(3, 3))
ACCELERATIONS = np.random.default_rng(4).normal(size=(3, 3))


def assert_close(got: Any, wanted: Any, tolerance: float = ROUNDING) -> None:
    """Compare with an error that is relative to the largest value, or absolute below 1."""
    size = 1.0 + float(np.abs(wanted).max(initial=0.0))
    np.testing.assert_allclose(got, wanted, rtol=0.0, atol=tolerance * size)


def turned(psi: float) -> Floats:
    """Return J(psi), which takes twists and body forces into the inertial frame."""
    c, s = math.cos(psi), math.sin(psi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


# ---- the body in the inertial frame --------------------------------------------------------


@each_heavy
def test_total_mass_is_that_of_the_points(robot: Robot) -> None:
    mass, place = points(robot)
    com = mass @ place / mass.sum()
    total = total_mass(robot)
    assert total.mass == pytest.approx(mass.sum(), rel=ROUNDING)
    assert_close(total.com, com)
    assert total.inertia == pytest.approx(mass @ np.square(place - com).sum(axis=1), rel=ROUNDING)


@each_heavy
def test_the_mass_matrix_is_that_of_the_points(robot: Robot) -> None:
    model = Dynamics(robot)
    for pose in POSES:
        M = model.mass_matrix(pose)
        assert_close(M, points_mass_matrix(robot, pose))
        np.testing.assert_array_equal(M, M.T)
        assert linalg.eigvalsh(M).min() > 0


@each_heavy
def test_the_bias_follows_from_the_mass_matrix_by_christoffel_symbols(robot: Robot) -> None:
    model = Dynamics(robot)
    for pose, rate in zip(POSES, RATES, strict=True):
        of_points = christoffel(lambda q: points_mass_matrix(robot, q), pose)
        assert_close(model.bias(pose, rate), of_points @ rate @ rate, DIFFERENTIATED)
        C = christoffel(model.mass_matrix, pose) @ rate
        assert_close(C @ rate, model.bias(pose, rate), DIFFERENTIATED)
        M_dot = slope(lambda t, q=pose, dq=rate: model.mass_matrix(q + t * dq))
        skew = M_dot - 2 * C
        assert_close(skew, -skew.T, DIFFERENTIATED)


@each_heavy
def test_forces_are_those_that_accelerate_the_points(robot: Robot) -> None:
    """Newton: sum m p_ddot = F, sum (p - o) x m p_ddot = M_z, differentiated along a motion."""
    model, (mass, _) = Dynamics(robot), points(robot)
    for pose, rate, acceleration in zip(POSES, RATES, ACCELERATIONS, strict=True):

        def moving(t: float, q: Floats = pose, dq: Floats = rate, a: Floats = acceleration) -> Any:
            return velocities(robot, q + t * dq + 0.5 * t * t * a, dq + t * a)

        force = mass[:, None] * slope(moving)
        arm = turned(pose[2])[:2, :2] @ points(robot)[1].T
        moment = arm[0] * force[:, 1] - arm[1] * force[:, 0]
        wanted = [*force.sum(axis=0), moment.sum()]
        assert_close(model.inverse_dynamics(pose, rate, acceleration), wanted, DIFFERENTIATED)


@each_heavy
def test_forward_dynamics_inverts_inverse_dynamics(robot: Robot) -> None:
    model = Dynamics(robot)
    force = model.inverse_dynamics(POSES, RATES, ACCELERATIONS)
    assert_close(model.forward_dynamics(POSES, RATES, force), ACCELERATIONS)
    back = model.inverse_dynamics(POSES, RATES, model.forward_dynamics(POSES, RATES, RATES))
    assert_close(back, RATES)


@each_heavy
def test_the_power_of_the_forces_is_the_growth_of_the_energy(robot: Robot) -> None:
    model = Dynamics(robot)
    for pose, rate, acceleration in zip(POSES, RATES, ACCELERATIONS, strict=True):
        growth = slope(
            lambda t, q=pose, dq=rate, a=acceleration: points_energy(robot, q + t * dq, dq + t * a)
        )
        power = model.inverse_dynamics(pose, rate, acceleration) @ rate
        assert_close(power, growth, DIFFERENTIATED)


@each_heavy
def test_the_inertial_frame_may_lie_anywhere(robot: Robot) -> None:
    model, angle = Dynamics(robot), 2.1
    T = turned(angle)
    pose, rate, acceleration = POSES[0], RATES[0], ACCELERATIONS[0]
    moved = T @ pose + (3.0, -5.0, angle)
    assert_close(model.mass_matrix(moved), T @ model.mass_matrix(pose) @ T.T)
    assert_close(model.bias(moved, T @ rate), T @ model.bias(pose, rate))
    assert_close(
        model.inverse_dynamics(moved, T @ rate, T @ acceleration),
        T @ model.inverse_dynamics(pose, rate, acceleration),
    )


@each_heavy
def test_the_body_frame_form_is_the_same_law(robot: Robot) -> None:
    """F = J M_b zeta_dot + J c(zeta), with q_ddot = J (zeta_dot + r x (u, v))."""
    model = Dynamics(robot)
    mass, com, _ = total_mass(robot)
    for pose, twist, change in zip(POSES, RATES, ACCELERATIONS, strict=True):
        u, v, r = twist
        J = turned(pose[2])
        force = model.inverse_dynamics(
            pose, J @ twist, J @ (change + np.array([-r * v, r * u, 0.0]))
        )
        in_body = J.T @ force
        assert_close(in_body, resultant(robot, twist, change))
        at_rest = model.inverse_dynamics(np.zeros(3), np.zeros(3), change)
        assert_close(at_rest + body_bias(mass, *com, u, v, r), in_body)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        assert_close(to_body(c, s, force[0], force[1]), in_body[:2])
        assert_close(to_inertial(c, s, in_body[0], in_body[1]), force[:2])


# ---- against Newton's laws for each part ---------------------------------------------------


@each_heavy
def test_newtons_laws_for_each_part_give_the_same_accelerations_and_forces(robot: Robot) -> None:
    model = Dynamics(robot)
    for i, motion in enumerate(motions(robot)):
        torques, steering = torques_for(robot, i), steered_at(robot, motion)
        wanted = newton_euler(robot, motion, torques)
        found = model.twist_acceleration(motion.twist, torques, **steering)
        assert_close(found, wanted.twist_acceleration, DIFFERENTIATED)
        forces = model.ground_forces(motion.twist, torques, **steering)
        assert_close(forces.along, wanted.along, DIFFERENTIATED)
        held, _ = holding_wheels(robot)
        assert_close(forces.side[held], wanted.side[held], DIFFERENTIATED)
        if not robot.steered:
            driven = [wheel.driven for wheel in rolling_wheels(robot)]
            omega = turning(robot, robot.driven, motion.twist)
            assert_close(
                model.wheel_acceleration(omega, torques),
                wanted.wheel_acceleration[driven],
                DIFFERENTIATED,
            )


@each_heavy
def test_the_wheels_go_on_fitting_the_motion(robot: Robot) -> None:
    """The twist a moment later is allowed at the steering angles a moment later."""
    model = Dynamics(robot)
    for i, motion in enumerate(motions(robot)):
        torques = torques_for(robot, i)
        change = model.twist_acceleration(motion.twist, torques, **steered_at(robot, motion))

        def slip(t: float, here: Motion = motion, a: Floats = change) -> Floats:
            return slip_rows(robot, here.steering + t * here.rate) @ (here.twist + t * a)

        size = float(np.abs(motion.rate).max(initial=0.0))
        rows = len(slip_rows(robot, motion.steering))
        assert_close(slope(slip, size), np.zeros(rows), DIFFERENTIATED * (1 + np.abs(change).max()))


def ground_resultant(robot: Robot, motion: Motion, along: Floats, side: Floats) -> Floats:
    """Return the resultant (F_x, F_y, M_z) in the body frame of forces at the wheels' contacts."""
    ahead, total = directions(robot, motion.steering), np.zeros(3)
    for wheel, push, hold in zip(robot.wheels, along, side, strict=True):
        if wheel.name not in ahead:
            assert push == hold == 0.0
            continue
        point = complex(wheel.x, wheel.y)
        direction, _ = rolling_force(wheel, ahead[wheel.name])  # type: ignore[arg-type]
        force = push * direction + hold * 1j * ahead[wheel.name]
        total += [force.real, force.imag, cross(point, force)]
    return total


# A track factor lengthens the arm of the rolling row, not that of the force on the ground.
true_arms = pytest.mark.parametrize(
    "robot",
    [robot for name, robot in HEAVY.items() if name != "skew_skid"],
    ids=[name for name in HEAVY if name != "skew_skid"],
)


@true_arms
def test_the_grounds_forces_are_what_accelerates_the_robot(robot: Robot) -> None:
    model = Dynamics(robot)
    for i, motion in enumerate(motions(robot)):
        torques, steering = torques_for(robot, i), steered_at(robot, motion)
        change = model.twist_acceleration(motion.twist, torques, **steering)
        forces = model.ground_forces(motion.twist, torques, **steering)
        given = ground_resultant(robot, motion, forces.along, forces.side)
        assert_close(given, resultant(robot, motion.twist, change), DIFFERENTIATED)


@each_heavy
def test_side_forces_are_the_least_that_hold_the_robot(robot: Robot) -> None:
    """Among forces with the same resultant the least has no part that only fights itself."""
    model, (fixed, skids) = Dynamics(robot), holding_wheels(robot)
    held = sorted(fixed + skids)
    if len(held) == 0:
        assert not model.ground_forces(RATES, torques_for(robot, 1, (3,))).side.any()
        return
    for i, motion in enumerate(motions(robot)):
        torques = torques_for(robot, i)
        side = model.ground_forces(motion.twist, torques, **steered_at(robot, motion)).side[held]
        rows = [
            ground_resultant(robot, motion, np.zeros(len(robot.wheels)), unit)
            for unit in np.eye(len(robot.wheels))[held]
        ]
        fighting = linalg.null_space(np.array(rows).T, rcond=1e-9)
        assert_close(fighting.T @ side, np.zeros(fighting.shape[1]), DIFFERENTIATED)


def tips(at: Floats, com: Floats) -> bool:
    """Return whether a centre of mass lies outside the wheels' hull: no weights balance there."""
    sums = np.vstack([at.T, np.ones(len(at))])
    found = optimize.linprog(np.zeros(len(at)), A_eq=sums, b_eq=[*com, 1.0], bounds=(0, None))
    return bool(found.status == 2)  # infeasible


@each_heavy
def test_weights_on_the_wheels_carry_the_robot(robot: Robot) -> None:
    load = wheel_loads(robot)
    mass, place = points(robot)
    at = np.array([(wheel.x, wheel.y) for wheel in robot.wheels])
    if np.isnan(load).all():
        assert tips(at, mass @ place / mass.sum())
        return
    assert (load >= 0).all()
    assert load.sum() == pytest.approx(mass.sum() * GRAVITY, rel=ROUNDING)
    assert_close(load @ at, GRAVITY * mass @ place)


# ---- torques -------------------------------------------------------------------------------


def pushing(robot: Robot, motion: Motion) -> Floats:
    """Return N^T G_d^T: from the motors' torques to what pushes the allowed motions."""
    A, gains = rolling_rows(robot, robot.driven, motion.steering)
    N = allowed_twists(robot, motion.steering)
    return np.asarray(N.T @ (A / gains[:, None]).T)


@each_heavy
def test_torques_give_the_acceleration_and_no_longer_torques_are_needed(robot: Robot) -> None:
    model = Dynamics(robot)
    for i, motion in enumerate(motions(robot)):
        steering = steered_at(robot, motion)
        wanted = newton_euler(robot, motion, torques_for(robot, i)).twist_acceleration
        torques = model.torques(motion.twist, wanted, **steering)
        given = newton_euler(robot, motion, torques).twist_acceleration
        assert_close(given, wanted, DIFFERENTIATED)
        found = model.twist_acceleration(motion.twist, torques, **steering)
        assert_close(found, given, DIFFERENTIATED)
        idle = linalg.null_space(pushing(robot, motion), rcond=1e-9)
        assert_close(idle.T @ torques, np.zeros(idle.shape[1]), DIFFERENTIATED)
        for k in range(idle.shape[1]):
            more = torques + 0.5 * idle[:, k]
            assert np.linalg.norm(more) > np.linalg.norm(torques)
            assert_close(model.twist_acceleration(motion.twist, more, **steering), found)


def even(robot: Robot) -> bool:
    """Return whether all driven wheels turn one rad/s into the same speed along their rows."""
    gains = np.abs(rolling_rows(robot, robot.driven, np.zeros(len(robot.steered)))[1])
    return bool(np.ptp(gains) < ROUNDING)


@pytest.mark.parametrize(
    "robot", [r for r in HEAVY.values() if even(r)], ids=[n for n, r in HEAVY.items() if even(r)]
)
def test_torques_of_wheels_of_one_size_are_the_lectures(robot: Robot) -> None:
    """tau_w = W^T F_B, with F_B what accelerates the masses; wheels without spin or friction."""
    light = frictionless(robot).with_wheels(spin_inertia=0.0)
    model = Dynamics(light)
    for i, motion in enumerate(motions(light)):
        wanted = newton_euler(light, motion, torques_for(light, i)).twist_acceleration
        F = resultant(light, motion.twist, wanted)
        W = wheel_matrix(light, motion.steering)
        found = model.torques(motion.twist, wanted, **steered_at(light, motion))
        assert_close(found, W.T @ F, DIFFERENTIATED)


# ---- the wheels' own form ------------------------------------------------------------------


@each_unsteered
def test_the_wheel_form_holds_for_consistent_motions(robot: Robot) -> None:
    model = Dynamics(robot)
    M_w, n = model.wheel_mass_matrix, len(robot.driven)
    assert_close(M_w, M_w.T)
    assert linalg.eigvalsh(M_w).min() > 0
    N = allowed_twists(robot, [])
    for i, motion in enumerate(motions(robot)):
        omega = turning(robot, robot.driven, motion.twist)
        wanted = N @ np.random.default_rng(i).normal(size=N.shape[1])
        omega_dot = turning(robot, robot.driven, wanted)
        torques = M_w @ omega_dot + model.wheel_bias(omega)
        assert_close(newton_euler(robot, motion, torques).twist_acceleration, wanted)
        assert_close(model.wheel_acceleration(omega, torques), omega_dot)
        if n == N.shape[1]:  # no torques that only work against each other
            given = torques_for(robot, i)
            omega_dot = model.wheel_acceleration(omega, given)
            assert_close(M_w @ omega_dot + model.wheel_bias(omega), given)


@each_unsteered
def test_the_wheel_form_has_the_energy_of_the_robot(robot: Robot) -> None:
    """omega^T M_w omega / 2 is the kinetic energy, whatever share is whose."""
    M_w = Dynamics(robot).wheel_mass_matrix
    for motion in motions(robot):
        omega = turning(robot, robot.driven, motion.twist)
        assert_close(0.5 * omega @ M_w @ omega, energy_of(robot, motion.twist, motion.steering))


# ---- energy --------------------------------------------------------------------------------


def energy_of(robot: Robot, twist: Floats, steering: Floats) -> float:
    """Return the kinetic energy of the mass points and of the spin about the axles."""
    wheels = rolling_wheels(robot)
    spin = np.array([wheel.spin_inertia for wheel in wheels])
    omega = turning(robot, wheels, list(twist), list(steering))
    return points_energy(robot, np.zeros(3), twist) + float(0.5 * spin @ omega**2)


@each_heavy
def test_kinetic_energy_is_that_of_the_points_and_the_spin(robot: Robot) -> None:
    model = Dynamics(robot)
    for motion in motions(robot):
        steering = {"steering": motion.steering} if robot.steered else {}
        assert_close(
            model.kinetic_energy(motion.twist, **steering),
            energy_of(robot, motion.twist, motion.steering),
        )


@each_heavy
def test_power_of_motors_and_friction_is_the_growth_of_the_energy(robot: Robot) -> None:
    model, wheels = Dynamics(robot), rolling_wheels(robot)
    for i, motion in enumerate(motions(robot)):
        torques = torques_for(robot, i)
        change = model.twist_acceleration(motion.twist, torques, **steered_at(robot, motion))

        def energy(t: float, here: Motion = motion, a: Floats = change) -> float:
            return energy_of(robot, here.twist + t * a, here.steering + t * here.rate)

        omega = turning(robot, wheels, list(motion.twist), list(motion.steering))
        driven = [wheel.driven for wheel in wheels]
        power = torques @ omega[driven] - friction(wheels, omega) @ omega
        size = float(np.abs([*motion.rate, *change]).max())
        assert_close(slope(energy, size), power, DIFFERENTIATED)


def steering_along(robot: Robot) -> Callable[[float], tuple[Floats, Floats]]:
    """Return steering angles and rates in time that always share a centre, on a path of twists."""
    if not robot.steered:
        return lambda _: (np.zeros(0), np.zeros(0))
    if robot.name == "curved":
        ratios = np.array(CURVED_RATIOS)
        return lambda t: (ratios * (0.3 + 0.4 * math.sin(t)), ratios * 0.4 * math.cos(t))
    start, change = feasible_twists(robot, (2,), 4)
    change /= 3.0

    def at(t: float) -> tuple[Floats, Floats]:
        twist = start + t * change
        return steering_for(robot, twist), steering_rates(robot, twist, change)

    return at


INTEGRATED_ROBOTS = (
    "odd_differential", "odd_omni", "skid_steer", "mixed",
    "tricycle", "ackermann", "swerve", "odd_omni_steer", "curved",
)  # fmt: skip


@pytest.mark.parametrize("name", INTEGRATED_ROBOTS)
def test_work_less_friction_is_the_energy_gained(name: str) -> None:
    """And the wheels still fit the motion in the end: what turning them adds keeps the rows."""
    robot = HEAVY[name]
    model, wheels, end = Dynamics(robot), rolling_wheels(robot), 0.5
    steering = steering_along(robot)
    driven = [wheel.driven for wheel in wheels]
    phases = np.arange(len(robot.driven))

    def slopes(t: float, state: Floats) -> Floats:
        twist, (angles, rates) = state[:3], steering(t)
        motion = Motion(twist, angles, rates)
        torques = 4.0 * np.sin(3.0 * t + phases)
        omega = turning(robot, wheels, list(twist), list(angles))
        change = model.twist_acceleration(twist, torques, **steered_at(robot, motion))
        return np.array([*change, torques @ omega[driven], friction(wheels, omega) @ omega])

    first, last_angles = steering(0.0)[0], steering(end)[0]
    N = allowed_twists(robot, list(first))
    start = np.array([*(N @ np.linspace(1.5, 0.5, N.shape[1])), 0.0, 0.0])
    last = integrate.solve_ivp(slopes, (0.0, end), start, **INTEGRATOR).y[:, -1]
    twist, (work, lost) = last[:3], last[3:]
    gained = energy_of(robot, twist, last_angles) - energy_of(robot, start[:3], first)
    assert lost > 1e-3  # friction takes its share
    assert_close(gained, work - lost, INTEGRATED)
    N = allowed_twists(robot, list(last_angles))
    assert_close(N @ (N.T @ twist), twist, INTEGRATED)


# ---- the same robot described otherwise ----------------------------------------------------


def with_body_of(changed: Robot, robot: Robot, com_y: float = 1.0, size: float = 1.0) -> Robot:
    """Return a changed robot with the body of the first one, mirrored or scaled with it."""
    assert robot.body is not None
    assert robot.body.com is not None
    x, y = robot.body.com
    body = dataclasses.replace(
        robot.body, com=(size * x, com_y * size * y), inertia=robot.body.inertia * size**2
    )
    return dataclasses.replace(changed, body=body)


@each_heavy
@pytest.mark.parametrize(
    "frame", [(0.7, 0.0, 0.0), (0.0, 0.0, 2.0), (-1.5, 0.6, -0.8)], ids=["moved", "turned", "both"]
)
def test_the_body_frame_may_lie_anywhere(robot: Robot, frame: tuple[float, float, float]) -> None:
    x, y, angle = frame
    if robot.name == "skew_skid":
        y = 0.0  # its track factor stretches the track about the body's x axis
    other = heavy_seen_from(robot, x, y, angle)
    # The twist of the same motion: velocity of the new origin, in the new directions.
    T = turned(angle).T @ np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    for i, motion in enumerate(motions(robot)):
        torques, steering = torques_for(robot, i), steered_at(robot, motion)
        model, seen, twist = Dynamics(robot), Dynamics(other), T @ motion.twist
        change = model.twist_acceleration(motion.twist, torques, **steering)
        assert_close(seen.twist_acceleration(twist, torques, **steering), T @ change, 1e-10)
        assert_close(
            seen.torques(twist, T @ change, **steering),
            model.torques(motion.twist, change, **steering),
            1e-10,
        )
        here = model.ground_forces(motion.twist, torques, **steering)
        there = seen.ground_forces(twist, torques, **steering)
        assert_close(there.along, here.along, 1e-10)
        assert_close(there.side, here.side, 1e-9)


@each_heavy
def test_the_mirror_image_moves_as_the_mirror_image(robot: Robot) -> None:
    other = with_body_of(mirrored(robot), robot, com_y=-1.0)
    flip = np.array([1.0, -1.0, -1.0])
    for i, motion in enumerate(motions(robot)):
        torques = torques_for(robot, i)
        image = Motion(flip * motion.twist, -motion.steering, -motion.rate)
        found = Dynamics(other).twist_acceleration(image.twist, torques, **steered_at(robot, image))
        change = Dynamics(robot).twist_acceleration(
            motion.twist, torques, **steered_at(robot, motion)
        )
        assert_close(found, flip * change, 1e-10)


@each_heavy
def test_the_order_of_the_wheels_does_not_matter(robot: Robot) -> None:
    order = list(range(len(robot.wheels)))[::-1]
    other = reordered(robot, order)
    for i, motion in enumerate(motions(robot)):
        torques = torques_for(robot, i)
        back = Motion(motion.twist, motion.steering[::-1], motion.rate[::-1])
        here = Dynamics(robot).ground_forces(motion.twist, torques, **steered_at(robot, motion))
        there = Dynamics(other).ground_forces(
            motion.twist, torques[::-1], **steered_at(robot, back)
        )
        for a, b in zip(here[:3], there[:3], strict=True):
            assert_close(b, a[::-1], 1e-9)


@each_heavy
def test_a_reversed_motor_only_turns_its_torque_round(robot: Robot) -> None:
    other = with_body_of(all_reversed(robot), robot)
    for i, motion in enumerate(motions(robot)):
        torques, steering = torques_for(robot, i), steered_at(robot, motion)
        here = Dynamics(robot).ground_forces(motion.twist, torques, **steering)
        there = Dynamics(other).ground_forces(motion.twist, -torques, **steering)
        for a, b in zip(here[:3], there[:3], strict=True):
            assert_close(b, a)
        change = Dynamics(robot).twist_acceleration(motion.twist, torques, **steering)
        assert_close(
            Dynamics(other).torques(motion.twist, change, **steering),
            -Dynamics(robot).torques(motion.twist, change, **steering),
        )


@each_heavy
@pytest.mark.parametrize("size", [0.1, 20.0])
def test_a_robot_of_another_size_moves_alike(robot: Robot, size: float) -> None:
    """Lengths times s, inertias times s^2: torques times s^2 give u_dot and v_dot times s."""
    grown = with_body_of(scaled(robot, size), robot, size=size)
    wheels = []
    for wheel in grown.wheels:
        names = ("yaw_inertia", "spin_inertia", "viscous_friction", "coulomb_friction")
        larger: dict[str, Any] = {
            name: getattr(wheel, name) * size**2 for name in names if hasattr(wheel, name)
        }
        wheels.append(dataclasses.replace(wheel, **larger))
    other = dataclasses.replace(grown, wheels=tuple(wheels))
    longer = np.array([size, size, 1.0])
    for i, motion in enumerate(motions(robot)):
        torques, steering = torques_for(robot, i), steered_at(robot, motion)
        change = Dynamics(robot).twist_acceleration(motion.twist, torques, **steering)
        found = Dynamics(other).twist_acceleration(
            longer * motion.twist, size**2 * torques, **steering
        )
        assert_close(found / longer, change, DIFFERENTIATED)


@each_heavy
def test_without_friction_the_motion_runs_backwards_as_well(robot: Robot) -> None:
    model = Dynamics(frictionless(robot))
    for i, motion in enumerate(motions(robot)):
        torques = torques_for(robot, i)
        back = Motion(-motion.twist, motion.steering, -motion.rate)
        assert_close(
            model.twist_acceleration(back.twist, torques, **steered_at(robot, back)),
            model.twist_acceleration(motion.twist, torques, **steered_at(robot, motion)),
        )


# ---- batches -------------------------------------------------------------------------------


def batch_of(robot: Robot, shape: tuple[int, ...]) -> tuple[Floats, Floats, dict[str, Any]]:
    """Return twists (*shape, 3), torques (*shape, n), and steering with its rates (*shape, s)."""
    count = math.prod(shape)
    some = motions(robot, max(count, 1))[:count]

    def stacked(field: str, last: int) -> Floats:
        values = [getattr(motion, field) for motion in some]
        return np.array(values, dtype=np.float64).reshape(*shape, last)

    steering: dict[str, Any] = {}
    if robot.steered:
        s = len(robot.steered)
        steering = {"steering": stacked("steering", s), "steering_rate": stacked("rate", s)}
    return stacked("twist", 3), torques_for(robot, 8, shape), steering


@each_heavy
@each_shape
def test_a_batch_is_many_single_calls(robot: Robot, shape: tuple[int, ...]) -> None:
    model = Dynamics(robot)
    twist, torques, steering = batch_of(robot, shape)
    angles = {k: v for k, v in steering.items() if k == "steering"}
    whole = {
        "twist_acceleration": model.twist_acceleration(twist, torques, **steering),
        "torques": model.torques(twist, twist, **steering),
        "kinetic_energy": model.kinetic_energy(twist, **angles),
    }
    forces = model.ground_forces(twist, torques, **steering)
    assert whole["twist_acceleration"].shape == (*shape, 3)
    assert whole["torques"].shape == (*shape, len(robot.driven))
    assert whole["kinetic_energy"].shape == shape
    k = len(robot.wheels)
    assert forces.along.shape == forces.side.shape == forces.friction.shape == (*shape, k)
    for at in np.ndindex(shape):
        one = {name: value[at] for name, value in steering.items()}
        angle = {name: value[at] for name, value in angles.items()}
        z, tau = twist[at], torques[at]
        assert_close(whole["twist_acceleration"][at], model.twist_acceleration(z, tau, **one))
        assert_close(whole["torques"][at], model.torques(z, z, **one))
        assert_close(whole["kinetic_energy"][at], model.kinetic_energy(z, **angle))
        single = model.ground_forces(z, tau, **one)
        assert_close(forces.along[at], single.along)
        assert_close(forces.side[at], single.side)


@each_unsteered
@each_shape
def test_a_batch_of_wheel_speeds_is_many_single_calls(robot: Robot, shape: tuple[int, ...]) -> None:
    model, omega, torques = Dynamics(robot), *(torques_for(robot, i, shape) for i in range(2))
    change, bias = model.wheel_acceleration(omega, torques), model.wheel_bias(omega)
    losses = model.friction_torque(omega)
    assert change.shape == bias.shape == losses.shape == (*shape, len(robot.driven))
    for at in np.ndindex(shape):
        assert_close(change[at], model.wheel_acceleration(omega[at], torques[at]))
        assert_close(bias[at], model.wheel_bias(omega[at]))
        assert_close(losses[at], friction(robot.driven, omega[at]))


@each_shape
def test_a_batch_of_poses_is_many_single_calls(shape: tuple[int, ...]) -> None:
    model, random = Dynamics(HEAVY["odd_omni"]), np.random.default_rng(0)
    pose, rate, other = random.normal(size=(3, *shape, 3))
    M, n = model.mass_matrix(pose), model.bias(pose, rate)
    force, change = (
        model.inverse_dynamics(pose, rate, other),
        model.forward_dynamics(pose, rate, other),
    )
    assert M.shape == (*shape, 3, 3)
    assert n.shape == force.shape == change.shape == (*shape, 3)
    for at in np.ndindex(shape):
        q, dq, x = pose[at], rate[at], other[at]
        assert_close(M[at], model.mass_matrix(q))
        assert_close(n[at], model.bias(q, dq))
        assert_close(force[at], model.inverse_dynamics(q, dq, x))
        assert_close(change[at], model.forward_dynamics(q, dq, x))


@each_steered_heavy
def test_one_of_a_kind_goes_with_many_of_another(robot: Robot) -> None:
    model, motion = Dynamics(robot), motions(robot, 1)[0]
    at = steered_at(robot, motion)
    many = torques_for(robot, 2, (4,))
    together = model.twist_acceleration(motion.twist, many, **at)
    assert together.shape == (4, 3)
    assert model.ground_forces(motion.twist, many, **at).along.shape == (4, len(robot.wheels))
    for torques, found in zip(many, together, strict=True):
        assert_close(found, model.twist_acceleration(motion.twist, torques, **at))
    angles, rates = (np.tile(at[name], (5, 1)) for name in ("steering", "steering_rate"))
    for steering in (
        {"steering": angles, "steering_rate": rates},
        {"steering": angles, "steering_rate": rates[0]},
        {"steering": angles[0], "steering_rate": rates},
    ):
        found = model.twist_acceleration(motion.twist, many[0], **steering)
        assert_close(found, np.tile(together[0], (5, 1)))
        assert model.torques(motion.twist, motion.twist, **steering).shape == (5, len(robot.driven))


def test_running_twice_gives_the_same_and_arguments_stay_as_they_were() -> None:
    for robot in (HEAVY["odd_differential"], HEAVY["odd_swerve"]):
        model, motion = Dynamics(robot), motions(robot, 1)[0]
        before = [x.copy() for x in motion]
        torques = torques_for(robot)
        first = model.twist_acceleration(motion.twist, torques, **steered_at(robot, motion))
        model.torques(motion.twist, first, **steered_at(robot, motion))
        again = model.twist_acceleration(motion.twist, torques, **steered_at(robot, motion))
        np.testing.assert_array_equal(first, again)
        for x, y in zip(before, motion, strict=True):
            np.testing.assert_array_equal(x, y)


def test_the_samples_cover_both_kinds_of_robot() -> None:
    assert set(STEERED) | set(UNSTEERED) == set(HEAVY)
    assert {"differential", "odd_omni"} <= set(UNSTEERED)
    assert {"ackermann", "curved"} <= set(STEERED)
    assert trundle.Dynamics is Dynamics
