"""A differential drive whose centre of mass lies ahead of its axle, driven by wheel torques.

Side slip is excluded, so two equations are left of three. With the half track d:

    m (u_dot - x_c r^2) = (tau_R + tau_L) / a
    (I + m x_c^2) r_dot + m x_c u r = d (tau_R - tau_L) / a

(Dhaouadi and Abu Hatab, Advances in Robotics and Automation 2:107, 2013, with massless wheels.)
"""

import numpy as np

import trundle
from trundle import Body, CasterWheel, FixedWheel, motion
from trundle.control import ReducedComputedTorque

m, I, x_c, a, d = 20.0, 0.5, 0.08, 0.05, 0.2
robot = trundle.Robot(
    name="nose_heavy",
    body=Body(length=0.4, width=0.4, x=0.1, mass=m, inertia=I, com=(x_c, 0.0)),
    wheels=(
        FixedWheel(name="left", x=0.0, y=d, radius=a),
        FixedWheel(name="right", x=0.0, y=-d, radius=a),
        CasterWheel(name="front", x=0.2, y=0.0, radius=0.03, trail=0.03),
    ),
)


class LetGo:
    """No torques at all."""

    output = "torques"

    def step(self, state, measurement, reference):
        """Return the torques at the wheels and the controller's memory, here none."""
        return [0.0, 0.0], state


# Turning on the spot and let go, the heavy nose flies outwards and pulls the robot along.
r_0, still = 2.0, motion.line((0, 0, 0), (0, 0, 0), duration=8.0)
free = trundle.track(robot, still, LetGo(), method="rk4", rate=[0, 0, r_0])
print("let go at 2 rad/s, 8 s later (u, v, r) =", free.twist[-1].round(4))

# By hand: u = A tanh(k t), r = r_0 / cosh(k t), A = r_0 sqrt(J / m), k = x_c r_0 sqrt(m / J).
J, t = I + m * x_c**2, free.t[:-1]
A, k = r_0 * np.sqrt(J / m), x_c * r_0 * np.sqrt(m / J)
np.testing.assert_allclose(free.twist[:, 0], A * np.tanh(k * t), atol=1e-9)
np.testing.assert_allclose(free.twist[:, 2], r_0 / np.cosh(k * t), atol=1e-9)
np.testing.assert_allclose(free.energy, J * r_0**2 / 2, rtol=1e-9)

# On a circle: 1 m/s and 0.5 rad/s take unequal torques, although nothing speeds up.
u, r = 1.0, 0.5
run = trundle.track(robot, motion.circle(u / r, r), ReducedComputedTorque(), pose=[0, -0.2, 0.3])
print("circle: torques", run.torques[-1].round(4), "error", run.error[-1].round(6) + 0.0)
by_hand = a / 2 * m * x_c * (-(r**2) + np.array([-1, 1]) * u * r / d)
np.testing.assert_allclose(run.torques[-1], by_hand, rtol=1e-3)
forces = trundle.Dynamics(robot).ground_forces([u, 0, r], by_hand)
np.testing.assert_allclose(forces.side.sum(), m * u * r, rtol=1e-12)
