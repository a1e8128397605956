"""From a Denavit-Hartenberg table to M and n: the lecture's mobile base, and a two-link arm.

The base is three joints: y and x slide, psi turns. Newton and Euler's recursion leads outward
with velocities and back inward with forces; Lagrange's energies must give the same.
"""

import numpy as np
import sympy
from sympy import cos, pi, simplify, sin

import trundle
from trundle.symbolic import Link, lagrange, newton_euler, pose

m, I, x_c, y_c, l, g = sympy.symbols("m I x_c y_c l g", real=True)
spin = ((0, 0, 0), (0, 0, 0), (0, 0, I))

base = (  # the lecture's rows (alpha, a, theta, d), with a = 0
    Link(kind="prismatic", alpha=3 * pi / 2, theta=3 * pi / 2, name="y"),
    Link(kind="prismatic", alpha=3 * pi / 2, theta=pi / 2, name="x"),
    Link(
        kind="revolute", alpha=pi / 2, theta=pi / 2, name="psi",
        mass=m, com=(x_c, y_c, 0), inertia=spin,
    ),
)  # fmt: skip
found = newton_euler(base)
y, x, psi = found.q
turning = found.qd[2]
told = {"pose": pose(base), "M": found.M, "n": found.n, "ground": found.shaking_force}
for name, matrix in told.items():
    print(f"{name} of {found.q}:", *matrix.tolist(), sep="\n    ")

# By hand, in the table's order (y, x, psi): the lecture's M and n.
a, b = m * (x_c * cos(psi) - y_c * sin(psi)), -m * (y_c * cos(psi) + x_c * sin(psi))
M = sympy.Matrix([[m, 0, a], [0, m, b], [a, b, I + m * (x_c**2 + y_c**2)]])
n = turning**2 * sympy.Matrix([b, -a, 0])
assert simplify(found.M - M).is_zero_matrix
assert simplify(found.n - n).is_zero_matrix
by_energy = lagrange(base)
assert simplify(by_energy.M - M).is_zero_matrix
assert simplify(by_energy.n - n).is_zero_matrix

# With numbers it is what trundle computes with, there in the order (x, y, psi).
robot = trundle.load("omni3").with_body(mass=30.0, inertia=0.7, com=(0.05, 0.02))
values = {m: 30.0, I: 0.7, x_c: 0.05, y_c: 0.02, psi: 0.4}
numbers = np.array(found.M.subs(values), dtype=float)[np.ix_([1, 0, 2], [1, 0, 2])]
np.testing.assert_allclose(trundle.Dynamics(robot).mass_matrix([0, 0, 0.4]), numbers, atol=1e-12)

# An arm of two equal links with their masses at the tips: Craig, 2005, section 6.7.
first = Link(kind="revolute", mass=m, com=(l, 0, 0))
second = Link(kind="revolute", a=l, mass=m, com=(l, 0, 0))
arm = newton_euler([first, second], gravity=(0, -g, 0))
q_1, q_2 = arm.q
assert simplify(arm.M[0, 0] - m * l**2 * (3 + 2 * cos(q_2))) == 0
assert simplify(arm.n[1] - m * l * (l * sin(q_2) * arm.qd[0] ** 2 + g * cos(q_1 + q_2))) == 0
