"""Dynamics against results worked out by hand, published models, and bad input."""

import dataclasses
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import trundle
from geometry import Floats
from trundle import Dynamics, Motor, load
from trundle.dynamics import GRAVITY, Motors, friction_torque, wheel_loads
from trundle.errors import OffCentreError, RobotError, ShapeError, TrundleError
from trundle.robot import (
    BallWheel,
    Body,
    CasterWheel,
    FixedWheel,
    Robot,
    SteeredWheel,
    Wheel,
    robot_from_dict,
)

# Results by hand and by the code differ by the rounding of some dozen operations.
ROUNDING = 1e-12
# Coulomb friction is within a millionth of its full value from 7 rad/s: SLOW^2 / (2 omega^2).
FULL_COULOMB = 1.1e-6


def assert_close(got: Any, wanted: Any, tolerance: float = ROUNDING) -> None:
    size = 1.0 + float(np.abs(wanted).max(initial=0.0))
    np.testing.assert_allclose(got, wanted, rtol=0.0, atol=tolerance * size)


# ---- the body, by hand ---------------------------------------------------------------------

OFF_CENTRE: dict[str, Any] = {"mass": 30.0, "inertia": 0.7, "com": (0.05, 0.02)}


@pytest.mark.parametrize("psi", [0.0, 0.4, math.pi / 2, -2.5])
def test_mass_matrix_and_bias_are_the_lectures(psi: float) -> None:
    model = Dynamics(load("omni3").with_body(**OFF_CENTRE))
    m, x, y, c, s = 30.0, 0.05, 0.02, math.cos(psi), math.sin(psi)
    a, b = -m * (y * c + x * s), m * (x * c - y * s)
    inertia = 0.7 + m * (x * x + y * y)
    assert_close(model.mass_matrix([9.0, -7.0, psi]), [[m, 0, a], [0, m, b], [a, b, inertia]])
    turn = 1.5
    n = [-m * turn**2 * (x * c - y * s), -m * turn**2 * (y * c + x * s), 0.0]
    assert_close(model.bias([9.0, -7.0, psi], [3.0, 2.0, turn]), n)


def test_a_body_that_turns_about_its_origin_is_held_by_the_centripetal_force() -> None:
    model = Dynamics(load("omni3").with_body(mass=2.0, inertia=0.5, com=(0.3, 0.0)))
    force = model.inverse_dynamics([0.0, 0.0, math.pi / 2], [0.0, 0.0, 4.0], [0.0, 0.0, 0.0])
    assert_close(force, [0.0, -2.0 * 0.3 * 16.0, 0.0])  # from the mass at (0, 0.3) to the origin


def test_wheels_count_with_the_body() -> None:
    """Two wheels of 1.5 kg at (0, +-0.2) and a body of 5 kg at (0.16, 0): centre at 0.1 m."""
    robot = load("differential", track=0.4).with_body(mass=5.0, inertia=0.3, com=(0.16, 0.0))
    wheels = tuple(
        dataclasses.replace(wheel, mass=1.5, yaw_inertia=0.01) if wheel.driven else wheel
        for wheel in robot.wheels
    )
    model = Dynamics(dataclasses.replace(robot, wheels=wheels))
    assert model.mass == pytest.approx(8.0)
    assert_close(model.com, [0.1, 0.0])
    # About the common centre: 0.3 + 5 * 0.06^2 for the body, 0.01 + 1.5 (0.1^2 + 0.2^2) a wheel.
    assert model.inertia == pytest.approx(0.3 + 5 * 0.06**2 + 2 * (0.01 + 1.5 * 0.05))
    assert repr(model) == "Dynamics('differential': 8 kg)"


# ---- the wheels' form, by hand -------------------------------------------------------------

BODY: dict[str, Any] = {"mass": 30.0, "inertia": 1.3, "com": (0.0, 0.0)}


def test_the_wheel_mass_matrix_of_three_omni_wheels() -> None:
    """W is a/3 [[0, -s3, s3], [2, -1, -1], [1/l, 1/l, 1/l]]: M_w is circulant."""
    a, arm, J = 0.2, 0.3, 0.04
    model = Dynamics(load("omni3", radius=a, arm=arm).with_body(**BODY).with_wheels(spin_inertia=J))
    moving, turning = 30.0 * a**2 / 9, 1.3 * a**2 / (9 * arm**2)
    same, other = 4 * moving + turning + J, -2 * moving + turning
    assert_close(
        model.wheel_mass_matrix,
        [[same, other, other], [other, same, other], [other, other, same]],
    )


def test_the_wheel_mass_matrix_of_four_mecanum_wheels() -> None:
    """Order FL, FR, RL, RR; W is a/4 [[1, 1, 1, 1], [-1, 1, 1, -1], [-k, k, -k, k]]."""
    a, J = 0.05, 0.002
    robot = load("mecanum", radius=a, wheelbase=0.4, track=0.3)
    model = Dynamics(robot.with_body(**BODY).with_wheels(spin_inertia=J))
    k = 1 / (0.2 + 0.15)
    forward, left, turn = np.array([[1, 1, 1, 1], [-1, 1, 1, -1], [-k, k, -k, k]])
    felt = 30.0 * np.outer(forward, forward) + 30.0 * np.outer(left, left)
    felt += 1.3 * np.outer(turn, turn)
    assert_close(model.wheel_mass_matrix, a**2 / 16 * felt + J * np.eye(4))


def test_the_wheel_form_of_a_differential_drive() -> None:
    """u = a (l + r) / 2, yaw a (r - l) / 2d: inertia, Coriolis torques and friction of each wheel.

    With its centre of mass x ahead, u feels -m x r^2 and the yaw m x u r.
    """
    a, d, x, J = 0.1, 0.25, 0.07, 0.03
    robot = load("differential", radius=a, track=2 * d).with_body(
        mass=30.0, inertia=1.3, com=(x, 0.0)
    )
    friction = {"viscous_friction": 0.2, "coulomb_friction": 0.5}
    model = Dynamics(robot.with_wheels(spin_inertia=J, **friction))
    about_origin = 1.3 + 30.0 * x**2
    both, one = 30.0 * a**2 / 4, about_origin * a**2 / (4 * d**2)
    assert_close(
        model.wheel_mass_matrix, [[both + one + J, both - one], [both - one, both + one + J]]
    )
    left, right = 8.0, 14.0
    u, r = a * (left + right) / 2, a * (right - left) / (2 * d)
    along, yaw = -30.0 * x * r**2, 30.0 * x * u * r
    coriolis = np.array([a / 2 * along - a / (2 * d) * yaw, a / 2 * along + a / (2 * d) * yaw])
    lost = np.array([0.2 * left + 0.5, 0.2 * right + 0.5])
    assert_close(model.wheel_bias([left, right]), coriolis + lost, FULL_COULOMB)
    assert_close(model.friction_torque([left, right]), lost, FULL_COULOMB)


def test_free_wheels_are_felt_through_the_motion() -> None:
    """A tricycle straight ahead: u_dot (m + sum J / a^2) = tau / a - friction / a."""
    a, J = 0.1, 0.02
    robot = load("tricycle", radius=a).with_body(mass=20.0).with_wheels(spin_inertia=J)
    model = Dynamics(robot.with_wheels(viscous_friction=0.3))
    u, torque = 1.5, 6.0
    wanted = (torque - 3 * 0.3 * u / a) / a / (20.0 + 3 * J / a**2)
    assert_close(model.twist_acceleration([u, 0.0, 0.0], [torque], [0.0]), [wanted, 0.0, 0.0])
    forces = model.ground_forces([u, 0.0, 0.0], [torque], [0.0])
    free = (-J * wanted / a - 0.3 * u / a) / a  # the ground spins them up
    assert_close(forces.along, [20.0 * wanted - 2 * free, free, free])


def test_reversed_wheels_and_uneven_radii() -> None:
    """Rim forces add up: tau_1 / a_1 forward from the one, -tau_2 / a_2 from the reversed one."""
    wheels = (
        FixedWheel(name="left", x=0.0, y=0.3, radius=0.1),
        FixedWheel(name="right", x=0.0, y=-0.3, radius=0.05, reversed=True),
    )
    body = Body(mass=10.0, inertia=2.0, com=(0.0, 0.0))
    model = Dynamics(Robot(name="uneven", wheels=wheels, body=body))
    assert_close(model.twist_acceleration([0.0] * 3, [1.0, -1.0]), [(10 + 20) / 10, 0.0, 3.0 / 2.0])
    # 15 N from each wheel for 3 m/s^2 without yaw.
    assert_close(model.torques([0.0] * 3, [3.0, 0.0, 0.0]), [15 * 0.1, -15 * 0.05])


def test_mecanum_torques_that_only_fight_each_other_move_nothing() -> None:
    model = Dynamics(load("mecanum"))
    fight = np.array([1.0, 1.0, -1.0, -1.0])  # pushes front against rear, and turns neither way
    assert_close(model.wheel_acceleration([0.0] * 4, fight), np.zeros(4))
    forces = model.ground_forces([0.0] * 3, fight)
    np.testing.assert_allclose(np.abs(forces.along), 1.0 / 0.05 / math.cos(math.pi / 4))


def test_a_bicycle_that_steers_keeps_its_energy() -> None:
    """Free of torques T = u^2 (m + I_o tan^2(delta) / l^2) / 2 stays, so u falls as delta grows.

    I_o is the inertia about the rear wheel; r = u tan(delta) / l.
    """
    m, inertia, b, wheelbase = 80.0, 6.0, 0.45, 1.1
    robot = load("bicycle", wheelbase=wheelbase)
    model = Dynamics(robot.with_body(mass=m, inertia=inertia, com=(b, 0.0)))
    u, delta, rate = 3.0, 0.5, 0.8
    tan, about_rear = math.tan(delta), inertia + m * b**2
    tan_dot = rate / math.cos(delta) ** 2
    u_dot = -u * about_rear * tan * tan_dot / (m * wheelbase**2 + about_rear * tan**2)
    r_dot = (u_dot * tan + u * tan_dot) / wheelbase
    twist = [u, 0.0, u * tan / wheelbase]
    assert_close(model.twist_acceleration(twist, [0.0], [delta], [rate]), [u_dot, 0.0, r_dot])
    assert_close(
        model.kinetic_energy(twist, [delta]), u**2 * (m + about_rear * (tan / wheelbase) ** 2) / 2
    )
    # The motor that keeps the speed gives the power that the yaw takes.
    torque = model.torques(twist, [0.0, 0.0, u * tan_dot / wheelbase], [delta], [rate])
    power = about_rear * twist[2] * u * tan_dot / wheelbase
    assert_close(torque * u / 0.3, [power])


# ---- published models of a differential drive ----------------------------------------------

PLANES = [(0.8, 1.9), (-0.6, 1.1), (1.3, -2.4)]


@pytest.mark.parametrize(("v", "omega"), PLANES)
def test_the_model_of_dhaouadi_and_abu_hatab(v: float, omega: float) -> None:
    """A drive with its centre of mass d ahead of the axle, wheels with mass and inertia.

    m = m_c + 2 m_w, I = I_c + m_c d^2 + 2 m_w L^2 + 2 I_m::

        (m + 2 I_w / R^2) v_dot - m_c d omega^2             = (tau_R + tau_L) / R
        (I + 2 L^2 I_w / R^2) omega_dot + m_c d omega v     = L (tau_R - tau_L) / R

    Source: R. Dhaouadi and A. Abu Hatab, Dynamic Modelling of Differential-Drive Mobile Robots
    using Lagrange and Newton-Euler Methodologies: A Unified Framework, Advances in Robotics and
    Automation 2:107, 2013.
    """
    m_c, m_w, I_c, I_w, I_m = 16.0, 0.25, 0.54, 0.0011, 0.0023
    d, L, R = 0.05, 0.24, 0.095
    robot = load("differential", radius=R, track=2 * L)
    wheels = tuple(
        dataclasses.replace(wheel, mass=m_w, yaw_inertia=I_m, spin_inertia=I_w)
        for wheel in robot.driven
    )
    body = Body(mass=m_c, inertia=I_c, com=(d, 0.0))
    model = Dynamics(Robot(name="published", wheels=wheels, body=body))
    m, inertia = m_c + 2 * m_w, I_c + m_c * d**2 + 2 * m_w * L**2 + 2 * I_m
    left, right = 1.7, -0.4
    v_dot = ((right + left) / R + m_c * d * omega**2) / (m + 2 * I_w / R**2)
    omega_dot = (L * (right - left) / R - m_c * d * omega * v) / (inertia + 2 * L**2 * I_w / R**2)
    found = model.twist_acceleration([v, 0.0, omega], [left, right])
    assert_close(found, [v_dot, 0.0, omega_dot])
    # And in their wheel speeds.
    same = I_w + R**2 / (4 * L**2) * (m * L**2 + inertia)
    other = R**2 / (4 * L**2) * (m * L**2 - inertia)
    assert_close(model.wheel_mass_matrix, [[same, other], [other, same]])
    phi_left, phi_right = (v - omega * L) / R, (v + omega * L) / R
    V = R**2 / (2 * L) * m_c * d * omega
    assert_close(model.wheel_bias([phi_left, phi_right]), [-V * phi_right, V * phi_left])


@pytest.mark.parametrize(("u", "omega"), PLANES)
def test_the_model_of_martins_and_carelli_with_motors_and_speed_control(
    u: float, omega: float
) -> None:
    """A drive with DC motors whose voltages come from proportional control of u and omega.

    u_dot = (theta_3 omega^2 - theta_4 u + u_ref) / theta_1,
    omega_dot = (-theta_5 u omega - theta_6 omega + omega_ref) / theta_2.

    Source: F. N. Martins, M. Sarcinelli-Filho and R. Carelli, A Velocity-Based Dynamic Model and
    Its Properties for Differential Drive Mobile Robots, Journal of Intelligent and Robotic Systems
    85, 2017, after C. De La Cruz and R. Carelli, IECON 2006; k_DT = k_DR = 0 and R_t = r.
    """
    m, I_z, b, d, r = 12.0, 0.6, 0.06, 0.42, 0.09
    R_a, k_a, k_b, I_e, B_e = 0.7, 0.9, 0.8, 0.012, 0.05
    k_PT, k_PR, u_ref, omega_ref = 14.0, 3.0, 0.7, -0.3
    ohms = R_a / k_a
    theta = [
        ohms * (m * r**2 + 2 * I_e) / (2 * r * k_PT),
        ohms * (I_e * d**2 + 2 * r**2 * (I_z + m * b**2)) / (2 * r * d * k_PR),
        ohms * m * b * r / (2 * k_PT),
        ohms * (k_a * k_b / R_a + B_e) / (r * k_PT) + 1,
        ohms * m * b * r / (d * k_PR),
        ohms * (k_a * k_b / R_a + B_e) * d / (2 * r * k_PR) + 1,
    ]
    u_dot = (theta[2] * omega**2 - theta[3] * u + u_ref) / theta[0]
    omega_dot = (-theta[4] * u * omega - theta[5] * omega + omega_ref) / theta[1]

    motor = Motor(torque_constant=k_a, back_emf=k_b, resistance=R_a)
    robot = load("differential", radius=r, track=d).with_body(mass=m, inertia=I_z, com=(b, 0.0))
    model = Dynamics(robot.with_wheels(motor=motor, spin_inertia=I_e, viscous_friction=B_e))
    together, apart = k_PT * (u_ref - u), k_PR * (omega_ref - omega)
    speeds = [(u - omega * d / 2) / r, (u + omega * d / 2) / r]
    torques = model.motors.torques([together - apart, together + apart], speeds)
    assert_close(model.twist_acceleration([u, 0.0, omega], torques), [u_dot, 0.0, omega_dot])


def test_the_unicycle_of_siciliano() -> None:
    """Centre of mass on the axle: m v_dot and I omega_dot are the driving force and moment.

    What holds the wheels against side slip is m v omega.

    Source: Siciliano, Sciavicco, Villani and Oriolo, 2009, section 11.4, the unicycle.
    """
    m, inertia, a, half, v, omega = 8.0, 0.4, 0.05, 0.2, 1.2, 0.9
    robot = load("differential", radius=a, track=2 * half)
    model = Dynamics(robot.with_body(mass=m, inertia=inertia, com=(0.0, 0.0)))
    left, right = 0.3, 0.5
    change = model.twist_acceleration([v, 0.0, omega], [left, right])
    assert_close(change, [(left + right) / a / m, 0.0, (right - left) * half / a / inertia])
    forces = model.ground_forces([v, 0.0, omega], [left, right])
    assert forces.side.sum() == pytest.approx(m * v * omega)
    assert_close(forces.side[:2], [m * v * omega / 2] * 2)  # shared evenly on the one axle
    assert_close(forces.along, [left / a, right / a, 0.0])


# ---- loads and side forces -----------------------------------------------------------------


def standing(points: list[tuple[float, float]], com: tuple[float, float]) -> Robot:
    """Return a body of 10 kg on balls."""
    wheels = tuple(BallWheel(name=f"{i}", x=x, y=y) for i, (x, y) in enumerate(points))
    return Robot(name="stool", wheels=wheels, body=Body(mass=10.0, inertia=1.0, com=com))


def test_three_wheels_share_the_weight_by_their_levers() -> None:
    """Rear wheels at x = 0, y = +-0.3, front wheel at x = 0.8; centre of mass (0.2, 0.06)."""
    weight = 10.0 * GRAVITY
    load_at = wheel_loads(standing([(0.0, 0.3), (0.0, -0.3), (0.8, 0.0)], (0.2, 0.06)))
    front = weight * 0.2 / 0.8
    difference = weight * 0.06 / 0.3
    rear = weight - front
    assert_close(load_at, [(rear + difference) / 2, (rear - difference) / 2, front])


def test_four_wheels_share_the_weight_as_springs_do() -> None:
    corners = [(0.4, 0.25), (0.4, -0.25), (-0.4, 0.25), (-0.4, -0.25)]
    quarter = 10.0 * GRAVITY / 4
    assert_close(wheel_loads(standing(corners, (0.0, 0.0))), [quarter] * 4)
    x, y = 0.1, -0.05
    levers = [quarter * (1 + x * i / 0.4**2 + y * j / 0.25**2) for i, j in corners]
    assert_close(wheel_loads(standing(corners, (x, y))), levers)


def test_two_wheels_carry_only_what_stands_on_their_line() -> None:
    line = [(0.0, 0.0), (1.0, 0.0)]
    assert_close(wheel_loads(standing(line, (0.25, 0.0))), [75.0 / 10 * GRAVITY, 2.5 * GRAVITY])
    assert np.isnan(wheel_loads(standing(line, (0.25, 0.01)))).all()
    one = wheel_loads(standing([(0.2, 0.1)], (0.2, 0.1)))
    assert_close(one, [10.0 * GRAVITY])


def test_side_forces_of_a_bicycle_in_a_steady_curve() -> None:
    """The axles share m u r by the levers; the front wheel pushes across its own heading.

    With b from the rear axle to the centre of mass: F_f cos(delta) l = m u r b, and the friction
    that a wheel needs is its own speed times r over g.
    """
    m, b, wheelbase, u, delta = 80.0, 0.35, 1.0, 5.0, 0.3
    robot = load("bicycle", wheelbase=wheelbase)
    model = Dynamics(robot.with_body(mass=m, com=(b, 0.0)))
    r = u * math.tan(delta) / wheelbase
    forces = model.ground_forces([u, 0.0, r], [0.0], [delta])
    assert_close(model.twist_acceleration([u, 0.0, r], [0.0], [delta]), np.zeros(3))
    front = m * u * r * b / wheelbase / math.cos(delta)
    rear = m * u * r * (wheelbase - b) / wheelbase
    assert_close(forces.side, [front, rear])
    assert_close(forces.along, np.zeros(2))
    assert_close(forces.load, [m * GRAVITY * b / wheelbase, m * GRAVITY * (1 - b / wheelbase)])
    assert_close(forces.friction, [u / math.cos(delta) * r / GRAVITY, u * r / GRAVITY])


def test_a_car_in_a_curve_is_held_by_m_v_squared_over_r() -> None:
    m, b, wheelbase, track, u, radius = 900.0, 1.1, 2.6, 1.5, 10.0, 25.0
    robot = load("ackermann", wheelbase=wheelbase, track=track)
    model = Dynamics(robot.with_body(mass=m, inertia=1200.0, com=(b, 0.0)))
    inner = math.atan2(wheelbase, radius - track / 2)
    outer = math.atan2(wheelbase, radius + track / 2)
    r = u / radius
    forces = model.ground_forces([u, 0.0, r], [0.0, 0.0], [inner, outer])
    left, right, rear_left, rear_right = forces.side
    # In the body frame: towards the centre m u r, and of the centre of mass m b r^2 backwards.
    across = left * math.cos(inner) + right * math.cos(outer) + rear_left + rear_right
    back = left * math.sin(inner) + right * math.sin(outer)
    assert across == pytest.approx(m * u**2 / radius)
    assert back == pytest.approx(m * b * r**2)
    # About the rear axle: the front wheels give b / l of it, in both directions.
    moment = wheelbase * (left * math.cos(inner) + right * math.cos(outer))
    moment += track / 2 * (left * math.sin(inner) - right * math.sin(outer))
    assert moment == pytest.approx(b * m * u * r)
    assert rear_left == pytest.approx(rear_right)


def test_friction_needed_to_speed_up() -> None:
    """Two driven wheels carry half of the weight each: mu = u_dot / g."""
    wheels = (
        FixedWheel(name="left", x=0.0, y=0.2, radius=0.1),
        FixedWheel(name="right", x=0.0, y=-0.2, radius=0.1),
    )
    body = Body(mass=12.0, inertia=1.0, com=(0.0, 0.0))
    model = Dynamics(Robot(name="segway", wheels=wheels, body=body))
    forces = model.ground_forces([0.0] * 3, model.torques([0.0] * 3, [2.5, 0.0, 0.0]))
    assert_close(forces.along, [15.0, 15.0])
    assert_close(forces.friction, [2.5 / GRAVITY] * 2)


# ---- motors --------------------------------------------------------------------------------

MOTOR = Motor(
    torque_constant=0.05,
    back_emf=0.04,
    resistance=2.0,
    gear=30.0,
    no_load_current=0.1,
    max_voltage=24.0,
    max_current=5.0,
)
STALL = 30 * 0.05 * 24 / 2  # N k_t U / R = 18 N m
NO_LOAD = 24 / (30 * 0.04)  # U / (N k_e) = 20 rad/s
CURRENT = 30 * 0.05 * 5  # N k_t i = 7.5 N m


def driven_by(motor: Motor, **more: Any) -> Dynamics:
    return Dynamics(load("differential").with_wheels(motor=motor, **more))


def test_stall_torque_and_no_load_speed() -> None:
    assert MOTOR.stall_torque == pytest.approx(STALL)
    assert MOTOR.no_load_speed == pytest.approx(NO_LOAD)
    assert MOTOR.friction_torque == pytest.approx(30 * 0.05 * 0.1)
    free = dataclasses.replace(MOTOR, max_current=None)
    drive = driven_by(free).motors
    assert_close(drive.torques([24.0, -24.0], [0.0, 0.0]), [STALL, -STALL])
    assert_close(drive.torques([24.0, 24.0], [NO_LOAD, NO_LOAD / 2]), [0.0, STALL / 2])
    endless = dataclasses.replace(free, max_voltage=None)
    assert endless.stall_torque == endless.no_load_speed == math.inf
    assert_close(driven_by(endless).motors.torques([240.0, 240.0], [0.0, 0.0]), [10 * STALL] * 2)


def test_without_a_back_emf_constant_it_is_the_torque_constant() -> None:
    plain = Motor(torque_constant=0.05, resistance=2.0, gear=20.0, max_voltage=24.0)
    assert plain.volts_per_speed == plain.torque_per_ampere == pytest.approx(1.0)
    assert plain.no_load_speed == pytest.approx(24.0)


def test_current_and_torque_limits() -> None:
    drive = driven_by(MOTOR).motors
    assert_close(drive.torques([24.0, -24.0], [0.0, 0.0]), [CURRENT, -CURRENT])
    weak = driven_by(MOTOR, max_torque=3.0).motors
    assert_close(weak.torques([24.0, -24.0], [0.0, 0.0]), [3.0, -3.0])
    assert_close(drive.torques([100.0, 4.0], [15.0, 0.0]), [STALL / 4, 3.0])


def test_voltages_and_currents_give_the_torques_back() -> None:
    drive, random = driven_by(MOTOR).motors, np.random.default_rng(1)
    omega, torques = random.uniform(-8, 8, (2, 3, 2)), random.uniform(-4.5, 4.5, (2, 3, 2))
    assert_close(drive.torques(drive.voltages(torques, omega), omega), torques)
    assert_close(drive.currents(torques), torques / (30 * 0.05))
    # U = R i + k_e N omega
    wanted = 2.0 * torques / (30 * 0.05) + 0.04 * 30 * omega
    assert_close(drive.voltages(torques, omega), wanted)


def test_limits_hold_torques_within_what_the_motor_can_give() -> None:
    limits = driven_by(MOTOR).torque_limits
    assert limits.any
    asked = np.array([20.0, -20.0])
    assert_close(limits.held(asked, np.zeros(2)), [CURRENT, -CURRENT])
    # At 16 rad/s forward the supply leaves a fifth of the stall torque, but brakes at full current.
    assert_close(limits.held(asked, np.full(2, 16.0)), [STALL / 5, -CURRENT])
    assert_close(limits.held(asked, np.full(2, -16.0)), [CURRENT, -STALL / 5])
    # Faster than without load the motor brakes whatever is asked.
    fast = np.full(2, 22.0)
    assert_close(limits.held(asked, fast), [STALL * (1 - 22 / NO_LOAD), -CURRENT])
    assert_close(limits.held(np.full(2, 1.0), 2 * fast), [-CURRENT] * 2)
    assert_close(limits.held(np.array([1.0, -2.0]), np.zeros(2)), [1.0, -2.0])


def test_limits_of_wheels_without_motors() -> None:
    none = Dynamics(load("mecanum")).torque_limits
    assert not none.any
    assert_close(none.held(np.array([1e9] * 4), np.zeros(4)), [1e9] * 4)
    some = Dynamics(load("mecanum").with_wheels(max_torque=2.0)).torque_limits
    assert some.any
    assert_close(some.held(np.array([9.0, -9.0, 1.0, 0.0]), np.zeros(4)), [2.0, -2.0, 1.0, 0.0])


def test_friction_of_the_motor_counts_among_the_wheels() -> None:
    """N k_t i_0 = 0.15 N m against the motion, with the wheel's own 0.3 N m and 0.02 N m s/rad."""
    model = driven_by(MOTOR, coulomb_friction=0.3, viscous_friction=0.02)
    lost = model.friction_torque([10.0, -10.0])
    assert_close(lost, [0.45 + 0.2, -0.65], FULL_COULOMB)
    assert_close(model.friction_torque([0.0, 0.0]), [0.0, 0.0])
    # At full voltage and no other friction the motor runs until N k_t (i - i_0) is used up.
    alone = driven_by(dataclasses.replace(MOTOR, max_current=None))
    speed = NO_LOAD - 0.1 * 2.0 / (30 * 0.04)
    torque = alone.motors.torques([24.0, 24.0], [speed, speed])
    assert_close(torque, alone.friction_torque([speed, speed]), FULL_COULOMB)


def test_friction_is_smooth_and_odd() -> None:
    omega = np.array([-10.0, -0.01, 0.0, 0.01, 10.0])
    torque = friction_torque(0.1, 2.0, omega, np.sqrt)
    assert_close(torque, -torque[::-1])
    assert_close(torque[3], 0.1 * 0.01 + 2.0 / math.sqrt(2.0))
    assert_close(torque[4], 1.0 + 2.0, FULL_COULOMB)
    assert friction_torque(0.1, 2.0, 0.01, math.sqrt) == pytest.approx(torque[3])


# ---- bad input -----------------------------------------------------------------------------

OMNI, CAR = Dynamics(load("omni3")), Dynamics(load("ackermann"))
DRIVE = Dynamics(load("differential"))
Z2, Z3 = [0.0] * 2, [0.0] * 3
Make = Callable[[], object]

BAD_ROBOTS: dict[str, tuple[Make, str]] = {
    "no body": (
        lambda: Dynamics(dataclasses.replace(load("omni3"), body=None)),
        "robot 'omni3': the body's mass, inertia, com are missing: dynamics needs mass [kg], "
        "inertia about the centre of mass [kg m^2] and com, the centre of mass [x, y] [m]; write "
        "them under [body], or call robot.with_body(mass=..., inertia=..., com=...)",
    ),
    "no com": (
        lambda: Dynamics(load("omni3").with_body(com=None)),
        "robot 'omni3': the body's com is missing",
    ),
    "no mass and inertia": (
        lambda: Dynamics(load("omni3").with_body(mass=None, inertia=None)),
        "robot 'omni3': the body's mass, inertia are missing",
    ),
    "loads without a body": (
        lambda: wheel_loads(dataclasses.replace(load("omni3"), body=None)),
        "robot 'omni3': the body's mass, inertia, com are missing",
    ),
    "negative mass": (
        lambda: load("omni3").with_body(mass=-1.0),
        "body: mass must be positive, got -1 kg",
    ),
    "no inertia": (
        lambda: load("omni3").with_body(inertia=0),
        "body: inertia must be positive, got 0 kg m^2",
    ),
    "mass nan": (
        lambda: load("omni3").with_body(mass=math.nan),
        "body: mass must be finite, got nan",
    ),
    "one coordinate": (
        lambda: load("omni3").with_body(com=(0.1,)),
        "body: com must be two numbers [x, y] [m], got (0.1,)",
    ),
    "com nan": (
        lambda: load("omni3").with_body(com=(math.nan, 0.0)),
        "body: com x must be finite, got nan",
    ),
    "no such field": (
        lambda: load("omni3").with_body(mas=1.0),
        "a body has no 'mas': did you mean 'mass'?",
    ),
    "in a file": (
        lambda: robot_from_dict(
            {
                "name": "mine",
                "wheel": [{"kind": "ball", "name": "b", "x": 0.0, "y": 0.0}],
                "body": {"mass": -3.0, "inertia": 1.0, "com": [0.0, 0.0]},
            }
        ),
        "mass must be positive, got -3 kg",
    ),
    "negative wheel mass": (
        lambda: load("omni3").with_wheels(mass=-0.1),
        "wheel 'wheel_1': mass must not be negative, got -0.1 kg",
    ),
    "negative spin": (
        lambda: load("omni3").with_wheels(spin_inertia=-0.1),
        "wheel 'wheel_1': spin_inertia must not be negative, got -0.1 kg m^2",
    ),
    "negative friction": (
        lambda: load("omni3").with_wheels(viscous_friction=-2.0),
        "wheel 'wheel_1': viscous_friction must not be negative, got -2 N m s/rad",
    ),
    "motor": (
        lambda: Motor(torque_constant=0.1, resistance=0.0),
        "motor: resistance must be positive, got 0 ohm",
    ),
    "not a motor": (
        lambda: load("omni3").with_wheels(motor="big"),
        "wheel 'wheel_1': motor must be of type Motor, got 'big'",
    ),
}


@pytest.mark.parametrize(("make", "message"), BAD_ROBOTS.values(), ids=BAD_ROBOTS)
def test_bad_descriptions_are_told(make: Make, message: str) -> None:
    with pytest.raises(RobotError, match=re.escape(message)):
        make()


BAD_CALLS: dict[str, tuple[Make, str]] = {
    "a name": (lambda: Dynamics("omni3"), "a Robot is needed, such as trundle.load('omni3')"),
    "motors missing": (
        lambda: DRIVE.motors,
        "robot 'differential': left, right have no motor: write motor = { torque_constant = ...",
    ),
    "wheel form of a car": (
        lambda: CAR.wheel_mass_matrix,
        "robot 'ackermann' steers, so these matrices depend on its angles: use torques()",
    ),
    "wheel bias of a car": (lambda: CAR.wheel_bias(Z2), "robot 'ackermann' steers"),
    "wheel acceleration of a car": (
        lambda: CAR.wheel_acceleration(Z2, Z2),
        "robot 'ackermann' steers",
    ),
}


@pytest.mark.parametrize(("make", "message"), BAD_CALLS.values(), ids=BAD_CALLS)
def test_bad_calls_are_told(make: Make, message: str) -> None:
    with pytest.raises(TrundleError, match=re.escape(message)):
        make()


def many(*shape: int) -> Floats:
    return np.zeros(shape)


BAD_SHAPES: dict[str, tuple[Make, str]] = {
    "pose": (lambda: OMNI.mass_matrix(Z2), "pose must have 3 values on the last axis"),
    "rate": (lambda: OMNI.bias(Z3, [1.0]), "rate must have 3 values on the last axis"),
    "poses and rates": (
        lambda: OMNI.bias(many(2, 3), many(4, 3)),
        "these shapes do not go together: pose (2, 3), rate (4, 3)",
    ),
    "force": (lambda: OMNI.forward_dynamics(Z3, Z3, Z2), "force must have 3 values"),
    "acceleration": (lambda: OMNI.inverse_dynamics(Z3, Z3, Z2), "acceleration must have 3 values"),
    "twist": (lambda: DRIVE.twist_acceleration(Z2, Z2), "twist must have 3 values"),
    "torques": (
        lambda: DRIVE.twist_acceleration(Z3, Z3),
        "torques must have 2 values on the last axis, got shape (3,)",
    ),
    "twists and torques": (
        lambda: DRIVE.twist_acceleration(many(2, 3), many(4, 2)),
        "these shapes do not go together: twist (2, 3), torques (4, 2)",
    ),
    "accelerations": (
        lambda: DRIVE.torques(many(2, 3), many(4, 3)),
        "these shapes do not go together: twist (2, 3), acceleration (4, 3)",
    ),
    "wheel speeds": (lambda: OMNI.wheel_bias(Z2), "wheel_speeds must have 3 values"),
    "nan": (
        lambda: DRIVE.twist_acceleration([math.nan, 0.0, 0.0], Z2),
        "twist must be finite numbers, got nan or inf",
    ),
    "infinite": (lambda: DRIVE.torques(Z3, [math.inf, 0.0, 0.0]), "acceleration must be finite"),
    "text": (lambda: DRIVE.ground_forces("fast", Z2), "twist must be an array of numbers"),
    "nothing": (lambda: DRIVE.wheel_acceleration(None, Z2), "wheel_speeds must have 2 values"),
    "steering missing": (
        lambda: CAR.twist_acceleration(Z3, Z2),
        "robot 'ackermann' steers: give the steering angles of front_left, front_right [rad]",
    ),
    "no steering for the energy": (lambda: CAR.kinetic_energy(Z3), "give the steering angles"),
    "one angle": (
        lambda: CAR.torques(Z3, Z3, [0.0]),
        "steering of front_left, front_right must have 2 values on the last axis",
    ),
    "an angle too many": (
        lambda: DRIVE.twist_acceleration(Z3, Z2, [0.1]),
        "steering of a robot without steering must have 0 values",
    ),
    "one rate": (
        lambda: CAR.twist_acceleration(Z3, Z2, Z2, [0.0]),
        "steering_rate must have 2 values on the last axis",
    ),
    "rate nan": (
        lambda: CAR.ground_forces(Z3, Z2, Z2, [math.nan, 0.0]),
        "steering_rate must be finite numbers",
    ),
    "voltages": (
        lambda: driven_by(MOTOR).motors.torques(Z3, Z2),
        "voltages must have 2 values on the last axis",
    ),
    "torques of motors": (
        lambda: driven_by(MOTOR).motors.currents(Z3),
        "torques must have 2 values on the last axis",
    ),
}


@pytest.mark.parametrize(("make", "message"), BAD_SHAPES.values(), ids=BAD_SHAPES)
def test_bad_arrays_are_told(make: Make, message: str) -> None:
    with pytest.raises(ShapeError, match=re.escape(message)):
        make()


def test_angles_without_a_common_centre_are_told() -> None:
    with pytest.raises(OffCentreError, match=r"share no instantaneous centre.*nearest that do"):
        CAR.twist_acceleration(Z3, Z2, [0.3, 0.1])


LOOSE_BATCHES: dict[str, Make] = {
    "poses and accelerations": lambda: OMNI.inverse_dynamics(many(2, 3), many(2, 3), many(4, 3)),
    "poses and forces": lambda: OMNI.forward_dynamics(many(2, 3), many(2, 3), many(4, 3)),
    "twists and steering": lambda: CAR.kinetic_energy(many(4, 3), many(5, 2)),
    "steering": lambda: CAR.twist_acceleration(many(4, 3), Z2, many(5, 2)),
    "steering and rates": lambda: CAR.twist_acceleration(Z3, Z2, many(2, 2), many(4, 2)),
    "twists and rates": lambda: CAR.twist_acceleration(many(4, 3), Z2, Z2, many(5, 2)),
    "voltages and speeds": lambda: driven_by(MOTOR).motors.torques(many(2, 2), many(3, 2)),
    "torques and speeds": lambda: driven_by(MOTOR).motors.voltages(many(2, 2), many(3, 2)),
    "rates of a robot without steering": lambda: DRIVE.twist_acceleration(Z3, Z2, None, [1.0]),
}


@pytest.mark.parametrize("make", LOOSE_BATCHES.values(), ids=LOOSE_BATCHES)
def test_batches_that_do_not_go_together_are_told(make: Make) -> None:
    with pytest.raises(ShapeError):
        make()


# ---- robots at the edge --------------------------------------------------------------------


def test_a_cart_without_motors_coasts() -> None:
    wheels: tuple[Wheel, ...] = (
        FixedWheel(name="left", x=0.0, y=0.3, radius=0.1, driven=False, viscous_friction=0.2),
        FixedWheel(name="right", x=0.0, y=-0.3, radius=0.1, driven=False, viscous_friction=0.2),
        BallWheel(name="ball", x=0.4, y=0.0),
    )
    body = Body(mass=5.0, inertia=0.5, com=(0.1, 0.0))
    model = Dynamics(Robot(name="cart", wheels=wheels, body=body))
    assert_close(model.twist_acceleration([2.0, 0.0, 0.0], []), [-2 * 0.2 * 20 / 0.1 / 5, 0.0, 0.0])
    assert model.torques([2.0, 0.0, 0.0], Z3).shape == (0,)
    with pytest.raises(TrundleError, match="push 0 of the 2 motions"):
        _ = model.wheel_mass_matrix
    assert model.motors.torques([], []).shape == (0,)
    assert not model.torque_limits.any


def test_a_body_on_balls_and_casters_slides_freely() -> None:
    wheels: tuple[Wheel, ...] = (
        BallWheel(name="ball", x=0.3, y=0.0, mass=1.0),
        CasterWheel(name="left", x=-0.3, y=0.3, radius=0.05, trail=0.03, mass=2.0),
        CasterWheel(name="right", x=-0.3, y=-0.3, radius=0.05, mass=2.0),
    )
    body = Body(mass=5.0, inertia=0.5, com=(0.18, 0.0))  # and the whole at the origin
    model = Dynamics(Robot(name="sledge", wheels=wheels, body=body))
    assert_close(model.com, Z2)
    # Straight ahead in the inertial frame while it turns: (u, v) turns back by r.
    assert_close(model.twist_acceleration([1.0, 2.0, 3.0], []), [3.0 * 2.0, -3.0 * 1.0, 0.0])
    forces = model.ground_forces([1.0, 2.0, 3.0], [])
    assert not forces.along.any()
    assert not forces.side.any()
    assert not forces.friction.any()


def test_wheels_that_lock_each_other_do_not_move() -> None:
    wheels = (
        FixedWheel(name="a", x=0.0, y=0.3, radius=0.1),
        FixedWheel(name="b", x=0.5, y=-0.3, radius=0.1, heading=0.4),
        FixedWheel(name="c", x=-0.3, y=0.0, radius=0.1, heading=1.2),
    )
    model = Dynamics(Robot(name="locked", wheels=wheels, body=Body(**BODY)))
    assert_close(model.twist_acceleration(Z3, [1.0, 2.0, 3.0]), Z3)
    assert_close(model.torques(Z3, [1.0, 1.0, 1.0]), Z3)


def test_a_motion_that_nothing_drives_is_carried_along() -> None:
    """Two omni wheels ahead and to the left: what a third would drive is free, and coasts."""
    robot = load("omni", angles=(0.0, math.pi / 2), radius=0.05, arm=0.2)
    model = Dynamics(robot.with_body(mass=4.0, inertia=0.25, com=(0.0, 0.0)))
    # The wheel at (0.2, 0) drives along y, that at (0, 0.2) along -x.
    found = model.twist_acceleration(Z3, [1.0, 0.5])
    assert_close(found, [-10.0 / 4.0, 20.0 / 4.0, (20.0 + 10.0) * 0.2 / 0.25])
    assert_close(model.ground_forces(Z3, [1.0, 0.5]).along, [20.0, 10.0])


def test_torques_leave_out_what_the_wheels_do_not_allow() -> None:
    """A drive with its centre of mass ahead of the axle is asked to speed up sideways."""
    model = Dynamics(load("differential").with_body(mass=20.0, inertia=1.0, com=(0.1, 0.0)))
    assert_close(model.torques(Z3, [0.0, 1.0, 0.0]), Z2)
    assert_close(model.torques(Z3, [1.0, 1.0, 0.0]), model.torques(Z3, [1.0, 0.0, 0.0]))


@pytest.mark.parametrize("x", [0.0, 0.3, -1.7])
def test_a_wheel_about_which_the_robot_turns_cannot_push(x: float) -> None:
    """A bicycle, front wheel at 90 deg: it turns about its rear wheel, which only rolls along."""
    wheels = (
        SteeredWheel(name="front", x=x + 0.8, y=0.8, radius=0.3, heading=math.pi / 4, driven=False),
        FixedWheel(name="rear", x=x, y=0.0, radius=0.3, heading=math.pi / 4),
    )
    model = Dynamics(Robot(name="bicycle", wheels=wheels, body=Body(**OFF_CENTRE)))
    torques = model.torques(Z3, [1.0, 1.0, 1.0], [math.pi / 2])
    assert np.abs(torques).max() < 1e3  # the body weighs 30 kg


@pytest.mark.parametrize("com", [(-0.1, 0.0), (0.9, 0.0), (0.4, 0.2)])
def test_three_wheels_that_tip_carry_nothing(com: tuple[float, float]) -> None:
    """The centre of mass lies behind, ahead of or beside the triangle of the wheels."""
    robot = standing([(0.0, 0.3), (0.0, -0.3), (0.8, 0.0)], com)
    assert np.isnan(wheel_loads(robot)).all()


def test_no_wheel_pulls_on_the_ground() -> None:
    """Four wheels stand safely on three, with the centre of mass near the fourth's opposite."""
    corners = [(0.4, 0.4), (0.4, -0.4), (-0.4, 0.4), (-0.4, -0.4)]
    assert (wheel_loads(standing(corners, (0.25, 0.25))) >= 0).all()


def test_steering_turns_the_condition_of_wheels_that_may_skid() -> None:
    """Two skidding wheels in line behind a free steered one: the twist a moment later fits."""
    wheels = (
        SteeredWheel(name="front", x=0.5, y=0.1, radius=0.1, driven=False),
        FixedWheel(name="middle", x=-0.2, y=0.0, radius=0.1, skid=True),
        FixedWheel(name="rear", x=-0.5, y=0.0, radius=0.1, skid=True),
    )
    robot = Robot(name="in_line", wheels=wheels, body=Body(**BODY))
    kin, model, angle, rate, h = trundle.Kinematics(robot), Dynamics(robot), 0.3, 0.7, 1e-6

    def direction(t: float) -> Floats:
        W = kin.wheel_matrix([angle + rate * t])
        twist = W @ np.ones(2)
        return np.asarray(twist / np.linalg.norm(twist))

    twist = direction(0.0)
    change = model.twist_acceleration(twist, Z2, [angle], [rate])
    later, allowed = twist + h * change, direction(h)
    # A difference quotient with a step of 1e-6 has an error of that size.
    assert np.abs(later - allowed * (allowed @ later)).max() / h < 1e-4


def test_the_public_names_are_there() -> None:
    assert trundle.Dynamics is Dynamics
    assert isinstance(driven_by(MOTOR).motors, Motors)
    assert pytest.approx(9.80665) == GRAVITY
