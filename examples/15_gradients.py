"""Gradients through the motion: wheel speeds that take a mecanum robot to a pose, by descent.

The step of the package, ``make_step``, is branch-free, so that jax differentiates it as it is; jax
is asked for by ``pip install jax``. All wheels keep their speeds for two seconds.
"""

import sys

import numpy as np

import trundle
from trundle.se2 import make_step

try:
    import jax
    import jax.numpy as jnp
except ImportError:
    print("left out: this example needs jax: pip install jax")
    sys.exit()

jax.config.update("jax_enable_x64", True)

GOAL = np.array([1.0, 0.5, np.pi / 2])  # x, y, psi [m, m, rad]
DURATION, STEPS = 2.0, 20  # [s]
RATE, ROUNDS = 50.0, 400  # the descent's

robot = trundle.load("mecanum")
matrix = trundle.Kinematics(robot).W  # from wheel speeds to the twist
step = make_step(jnp.sin, jnp.cos)


def final_pose(wheel_speeds):
    """Return where the wheel speeds lead from the origin."""
    increment = DURATION / STEPS * (matrix @ wheel_speeds)

    def one_step(pose, _):
        return step(*pose, *increment), None

    pose, _ = jax.lax.scan(one_step, (0.0, 0.0, 0.0), length=STEPS)
    return jnp.stack(pose)


def cost(wheel_speeds):
    """Return half of the squared distance that is left."""
    return 0.5 * jnp.sum((final_pose(wheel_speeds) - GOAL) ** 2)


downhill = jax.jit(jax.grad(cost))
speeds = jnp.ones(4)  # straight on: there, too, the step has its derivatives
for _ in range(ROUNDS):
    speeds = speeds - RATE * downhill(speeds)
print("wheel speeds:", np.round(speeds, 4), "rad/s, to", np.round(final_pose(speeds), 6))

np.testing.assert_allclose(final_pose(speeds), GOAL, atol=1e-6)
# The loops of the package agree, and by hand: a quarter turn has the chord 2 sqrt 2 / pi.
driven = trundle.rollout(robot, trundle.Constant(speeds), dt=DURATION, steps=1, device="numpy")
np.testing.assert_allclose(driven.pose[0], GOAL, atol=1e-6)
speed = np.hypot(*(matrix @ speeds)[:2])
np.testing.assert_allclose(speed * DURATION * 2 * np.sqrt(2) / np.pi, np.hypot(1, 0.5), atol=1e-6)
