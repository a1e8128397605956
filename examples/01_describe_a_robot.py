"""Describe a robot by its wheels; read off W and what the robot can and cannot do."""

from pathlib import Path

import numpy as np

import trundle
from trundle import CasterWheel, FixedWheel, Robot
from trundle.robot import save

RADIUS, HALF_TRACK = 0.04, 0.15  # a and d [m]

# The origin is the middle of the axle, x forward, y left: the left wheel is at +y.
robot = Robot(
    name="tortoise",
    wheels=(
        FixedWheel(name="left", x=0.0, y=HALF_TRACK, radius=RADIUS),
        FixedWheel(name="right", x=0.0, y=-HALF_TRACK, radius=RADIUS),
        CasterWheel(name="caster", x=-0.1, y=0.0, radius=0.02, trail=0.02),
    ),
)

W = trundle.Kinematics(robot).W
print("(u, v, r) = W @ (left, right), with W =")
print(W.round(4))

can = trundle.mobility(robot)
print(f"\nClass {can.kind}, rank of W {can.rank}:")
for reason in can.reasons:
    print(" ", reason)

# The file can be edited, and used in place of a catalogue name: trundle show tortoise.toml
path = save(robot, Path("tortoise.toml"))
print(f"\n{path}:\n\n{path.read_text(encoding='utf-8')}")

# By hand: each wheel gives half of u; a wheel at +d turns the body clockwise.
a, d = RADIUS, HALF_TRACK
by_hand = [[a / 2, a / 2], [0, 0], [-a / (2 * d), a / (2 * d)]]
np.testing.assert_allclose(W, by_hand, atol=1e-15)
assert (can.kind, can.rank, can.omnidirectional) == ("(2,0)", 2, False)
assert can.controllable
assert not can.holonomic
assert trundle.load(path) == robot
