"""Equations of motion of serial chains: two derivations, a textbook, and the lecture."""

from collections.abc import Sequence
from typing import Any

import pytest
import sympy

from trundle.errors import TrundleError
from trundle.symbolic import (
    Equations,
    Link,
    christoffel,
    joints,
    lagrange,
    newton_euler,
    planar_base,
    planar_links,
    pose,
    rate_of,
    table,
    transforms,
)

m_1, m_2, m_3, l_1, l_2, g = sympy.symbols("m_1 m_2 m_3 l_1 l_2 g", positive=True)
m, I_cz, x_bc, y_bc = sympy.symbols("m I_cz x_bc y_bc", real=True)

# Craig, Introduction to Robotics, 3rd edition, 2005, section 6.7: two links in the vertical plane,
# each with its mass as a point at the far end; gravity along -Y.
TWO_LINKS = (
    Link(kind="revolute", mass=m_1, com=(l_1, 0, 0)),
    Link(kind="revolute", a=l_1, mass=m_2, com=(l_2, 0, 0)),
)
DOWN_Y = (0, -g, 0)

# A spherical arm: two turning joints whose axes cross, and one that slides; bodies with
# products of inertia and centres of mass off the axes.
_I = sympy.symbols("I_x I_y I_z", positive=True)
_c, _e, _p = sympy.symbols("c e p", real=True)
SPHERICAL = (
    Link(kind="revolute", mass=m_1, inertia=((_I[0], _p, 0), (_p, _I[1], 0), (0, 0, _I[2]))),
    Link(kind="revolute", alpha=-sympy.pi / 2, d=l_1, mass=m_2, com=(_c, 0, _e)),
    Link(kind="prismatic", alpha=sympy.pi / 2, mass=m_3, com=(0, _c, _e), inertia=sympy.diag(*_I)),
)
DOWN_Z = (0, 0, -g)

CHAINS: dict[str, tuple[Sequence[Link], Sequence[Any]]] = {
    "planar base": (planar_links(), (0, 0, 0)),
    "two links": (TWO_LINKS, DOWN_Y),
    "spherical": (SPHERICAL, DOWN_Z),
}
each_chain = pytest.mark.parametrize("name", CHAINS)


@pytest.fixture(scope="module")
def derived() -> dict[str, Equations]:
    return {name: newton_euler(links, gravity) for name, (links, gravity) in CHAINS.items()}


def vanishes(matrix: Any) -> bool:
    return all(sympy.simplify(entry) == 0 for entry in sympy.Matrix(matrix))


def symbols_of_base() -> tuple[Any, ...]:
    return sympy.symbols("x y psi xdot ydot psidot xddot yddot psiddot", real=True)


# ---- the lecture's planar base ---------------------------------------------------------------


def test_the_lectures_table_is_the_planar_pose() -> None:
    x, y, psi, *_ = symbols_of_base()
    half = sympy.pi / 2
    assert table(planar_links()) == (
        (3 * half, 0, 3 * half, y),
        (3 * half, 0, half, x),
        (half, 0, half + psi, 0),
    )
    c, s = sympy.cos(psi), sympy.sin(psi)
    planar = sympy.Matrix([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])
    assert pose(planar_links()) == planar


def test_the_planar_base_has_the_lectures_mass_matrix_and_bias() -> None:
    """M and n as the lecture on dynamics gives them (its slip of psi_d^2 for psi_dd mended)."""
    _, _, psi, _, _, r, *_ = symbols_of_base()
    c, s = sympy.cos(psi), sympy.sin(psi)
    M = sympy.Matrix(
        [
            [m, 0, -m * (y_bc * c + x_bc * s)],
            [0, m, m * (x_bc * c - y_bc * s)],
            [
                -m * (y_bc * c + x_bc * s),
                m * (x_bc * c - y_bc * s),
                I_cz + m * (x_bc**2 + y_bc**2),
            ],
        ]
    )
    n = sympy.Matrix([-m * r**2 * (x_bc * c - y_bc * s), -m * r**2 * (y_bc * c + x_bc * s), 0])
    base = planar_base()
    assert vanishes(base.M - M)
    assert vanishes(base.n - n)
    assert base.parameters == (I_cz, m, x_bc, y_bc)
    assert [str(q) for q in base.q] == ["x", "y", "psi"]


def test_the_mass_matrix_of_the_base_is_positive_definite() -> None:
    """Its leading minors are m, m^2 and, by hand, m^2 I_cz."""
    M = planar_base().M
    minors = [sympy.simplify(M[:k, :k].det()) for k in (1, 2, 3)]
    assert minors == [m, m**2, I_cz * m**2]


def test_the_ground_gives_force_and_moment_of_newton_and_euler() -> None:
    """f_0 is the mass times the centre's acceleration, n_0 the rate of angular momentum about O."""
    x, y, psi, *rest = symbols_of_base()
    rates, seconds = rest[:3], rest[3:]
    c, s = sympy.cos(psi), sympy.sin(psi)
    centre = sympy.Matrix([x + x_bc * c - y_bc * s, y + x_bc * s + y_bc * c])

    def rate(value: Any) -> Any:
        pairs = [*zip((x, y, psi), rates, strict=True), *zip(rates, seconds, strict=True)]
        return sum((value.diff(q) * qd for q, qd in pairs), 0 * value)

    velocity = rate(centre)
    turning = m * (centre[0] * velocity[1] - centre[1] * velocity[0]) + I_cz * rates[2]
    base = planar_base()
    assert vanishes(base.shaking_force - m * sympy.Matrix([*rate(velocity), 0]))
    assert vanishes(base.shaking_moment - sympy.Matrix([0, 0, rate(turning)]))


# ---- the textbook's arm ----------------------------------------------------------------------


def test_the_two_link_arm_is_the_one_of_the_book(derived: dict[str, Equations]) -> None:
    """Craig, Introduction to Robotics, 3rd edition, 2005, sections 6.7 and 6.8."""
    (t_1, t_2), (w_1, w_2), _ = joints(TWO_LINKS)
    c_1, c_2, s_2 = sympy.cos(t_1), sympy.cos(t_2), sympy.sin(t_2)
    c_12 = sympy.cos(t_1 + t_2)
    corner = l_2**2 * m_2 + l_1 * l_2 * m_2 * c_2
    M = sympy.Matrix(
        [
            [l_2**2 * m_2 + 2 * l_1 * l_2 * m_2 * c_2 + l_1**2 * (m_1 + m_2), corner],
            [corner, l_2**2 * m_2],
        ]
    )
    V = m_2 * l_1 * l_2 * s_2 * sympy.Matrix([-(w_2**2) - 2 * w_1 * w_2, w_1**2])
    G = sympy.Matrix([m_2 * l_2 * g * c_12 + (m_1 + m_2) * l_1 * g * c_1, m_2 * l_2 * g * c_12])
    arm = derived["two links"]
    assert vanishes(arm.M - M)
    assert vanishes(arm.n - V - G)


# ---- laws of every chain ---------------------------------------------------------------------


@each_chain
def test_energies_give_the_same_equations(name: str, derived: dict[str, Equations]) -> None:
    links, gravity = CHAINS[name]
    by_energy = lagrange(links, gravity)
    order = [joints(links).q.index(q) for q in derived[name].q]
    assert vanishes(derived[name].M - by_energy.M.extract(order, order))
    assert vanishes(derived[name].n - by_energy.n.extract(order, [0]))


@each_chain
def test_the_christoffel_form_is_the_same_and_skew(
    name: str, derived: dict[str, Equations]
) -> None:
    made = derived[name]
    C = christoffel(made.M, made.q, made.qd)
    weightless = made.n.subs(g, 0)
    assert vanishes(C * sympy.Matrix(made.qd) - weightless)
    skew = rate_of(made.M, made.q, made.qd) - 2 * C
    assert vanishes(skew + skew.T)
    assert vanishes(made.M - made.M.T)


@each_chain
def test_velocities_are_the_rates_of_positions(name: str, derived: dict[str, Equations]) -> None:
    """Outward velocities against the transforms, differentiated."""
    links, _ = CHAINS[name]
    q, qd, _ = joints(links)
    for i in range(1, len(links) + 1):
        place = pose(links[:i])
        velocity = place[:3, 3].jacobian(q) * sympy.Matrix(qd)
        turned = rate_of(place[:3, :3], q, qd)
        omega = derived[name].value(f"omega_{i}")
        assert vanishes(place[:3, :3] * derived[name].value(f"v_{i}") - velocity)
        assert vanishes(place[:3, :3].T * turned - omega.hat())


@each_chain
def test_the_steps_are_told_in_order(name: str, derived: dict[str, Equations]) -> None:
    count = len(CHAINS[name][0])
    told = [(step.phase, step.link) for step in derived[name].steps]
    outward = range(1, count + 1)
    assert told == [
        *(("transform", i) for i in outward),
        *(("outward", i) for i in outward),
        *(("inward", i) for i in range(count, -1, -1)),
        ("effort", 0),
    ]
    assert derived[name].steps[0]["T_01"] == transforms(CHAINS[name][0])[0]
    assert derived[name].value("f_0") == derived[name].shaking_force


def test_a_pendulum_by_hand() -> None:
    """m l^2 and m g l sin from the vertical: the smallest chain with gravity."""
    angle, _, _ = joints([Link(kind="revolute")])
    made = newton_euler([Link(kind="revolute", mass=m_1, com=(l_1, 0, 0))], gravity=(g, 0, 0))
    assert vanishes(made.M - sympy.Matrix([[m_1 * l_1**2]]))
    assert vanishes(made.n - sympy.Matrix([m_1 * g * l_1 * sympy.sin(angle[0])]))


# ---- bad input -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Link(kind="ball"), "kind must be revolute or prismatic, got 'ball'"),
        (lambda: Link(kind="revolute", com=(1, 2)), "com must have 3 values"),
        (lambda: Link(kind="revolute", inertia=((1, 2), (2, 1))), "symmetric matrix (3, 3)"),
        (lambda: newton_euler([]), "at least one link"),
        (
            lambda: joints([Link(kind="revolute", name="s"), Link(kind="prismatic", name="s")]),
            "names that differ",
        ),
    ],
)
def test_mistakes_are_told(make: Any, told: str) -> None:
    with pytest.raises(TrundleError) as caught:
        make()
    assert told in str(caught.value)
