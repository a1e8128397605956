"""Parallel parking: a differential drive moves sideways, which none of its motions does.

Its twists are X = forward and Y = turning. Forward by p, turn by q, back by p, turn by -q leaves
the pose p q [X, Y] away, to third order; the Lie bracket [X, Y] is a motion to the right. So
turning clockwise first, q < 0, leads to the left.
"""

import numpy as np

import trundle
from trundle import view

X = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # as matrices of se(2)
Y = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
bracket = (X @ Y - Y @ X)[:2, 2]  # a motion without turning: (0, -1)

robot = trundle.load("differential")
ROWS, DT = 20, 0.05  # each move takes a second


def commutator(p, q):
    """The four moves as twists (rows, 3)."""
    moves = [(p, 0, 0), (0, 0, q), (-p, 0, 0), (0, 0, -q)]
    return np.repeat(np.array(moves, dtype=float), ROWS, axis=0)


def end(twists):
    """Where they lead from the origin."""
    return trundle.simulate(robot, twist=twists, dt=DT).pose[-1]


def miss(p, q):
    """How far the bracket's prediction is off."""
    return np.hypot(*(end(commutator(p, q))[:2] - p * q * bracket))


print("p = q    sideways     predicted    off")
for size in (0.4, 0.2, 0.1):
    y = end(commutator(size, size))[1]
    print(f"{size}  {y:10.6f}   {size**2 * bracket[1]:10.6f}   {miss(size, size):.2e}")

# Each commutator also leaves it p (1 - cos q) ahead; the mirrored one undoes exactly that.
p, q = 0.5, -0.4
parking = np.concatenate([commutator(p, q), commutator(-p, -q)])
run = trundle.simulate(robot, twist=parking, dt=DT)
print("\nafter eight moves:", run.pose[-1].round(6) + 0.0)
view.animate(robot, run, "parking.gif")

assert trundle.mobility(robot).controllable  # brackets reach what single motions do not
assert list(bracket) == [0.0, -1.0]
assert 7.5 < miss(0.2, 0.2) / miss(0.1, 0.1) < 8.5  # third order: half the size, an eighth
np.testing.assert_allclose(run.pose[-1], [0, -2 * p * np.sin(q), 0], atol=1e-12)
