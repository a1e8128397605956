"""The planar mobile base as a chain: two prismatic joints and a revolute one."""

from __future__ import annotations

from functools import cache

import sympy

from trundle.symbolic.chain import Joints, Link, joints
from trundle.symbolic.equations import Equations, equations_of
from trundle.symbolic.newton_euler import newton_euler

m, I_cz, x_bc, y_bc = sympy.symbols("m I_cz x_bc y_bc", real=True)

# The table gives y first; the pose is (x, y, psi).
ORDER = (1, 0, 2)


def planar_links() -> tuple[Link, Link, Link]:
    """Return the table of the planar joint: y-prismatic, x-prismatic, z-revolute.

    The rows (alpha, a, theta, d) are (3pi/2, 0, 3pi/2, y), (3pi/2, 0, pi/2, x) and
    (pi/2, 0, pi/2 + psi, 0): the joints move along +y and +x and turn about +z. The first two
    links have no mass; the third is the body, with mass m and inertia I_cz about the vertical
    through its centre of mass (x_bc, y_bc).

    Source: the lecture on the dynamics of mobile robots.

    >>> from trundle.symbolic import pose
    >>> pose(planar_links())
    Matrix([
    [cos(psi), -sin(psi), 0, x],
    [sin(psi),  cos(psi), 0, y],
    [       0,         0, 1, 0],
    [       0,         0, 0, 1]])
    """
    quarter = sympy.pi / 2
    return (
        Link(kind="prismatic", alpha=3 * quarter, theta=3 * quarter, name="y"),
        Link(kind="prismatic", alpha=3 * quarter, theta=quarter, name="x"),
        Link(
            kind="revolute",
            alpha=quarter,
            theta=quarter,
            mass=m,
            com=(x_bc, y_bc, 0),
            inertia=((0, 0, 0), (0, 0, 0), (0, 0, I_cz)),
            name="psi",
        ),
    )


@cache
def planar_base() -> Equations:
    """Return the equations of motion of the planar base, in the order (x, y, psi).

    ``M(q) q_dd + n(q, q_d) = (F_x, F_y, M_z)``

    Source: the lecture on the dynamics of mobile robots, by the recursion of ``newton_euler``.

    >>> planar_base().M[0, 2]
    -m*(x_bc*sin(psi) + y_bc*cos(psi))
    """
    made = newton_euler(planar_links())
    efforts = [made.efforts[i] for i in ORDER]
    q, qd, qdd = (tuple(each[i] for i in ORDER) for each in joints(planar_links()))
    shaking = made.shaking_force, made.shaking_moment
    return equations_of(efforts, Joints(q, qd, qdd), shaking, made.steps)
