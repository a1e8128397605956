"""A controller and a trajectory of one's own: an integral finds the force that PD lacks.

A controller has `output` ("force", "torques" or "twist") and `step`. That takes its own memory,
what is measured and what is wanted, and returns the command and the memory for the next step.
"""

import numpy as np

import trundle
from trundle.control import PD, ComputedTorque

KP, KD, KI = np.array([[120, 120, 8], [120, 120, 8], [60, 60, 4]], dtype=float)
BELIEVED, MASS, GAIN, FASTER = 30.0, 36.0, 4.0, 0.05  # [kg], [kg], [1/s^2], [m/s^2]


class PID:
    """F = K_p e + K_d e_d + K_i times the integral of e, which is the memory."""

    output = "force"
    dt = 0.01

    def step(self, state, measurement, reference):
        """Return the force (F_x, F_y, M_z) in the inertial frame, and the integral."""
        error = reference.error(measurement.pose)
        total = error * self.dt if state is None else state + error * self.dt
        return KP * error + KD * (reference.velocity - measurement.rate) + KI * total, total


class SpeedingUp:
    """Ahead at constant acceleration; a trajectory is any value with these three."""

    def position(self, t):
        """Return x, y, psi (3,) at a time."""
        return np.array([FASTER * t**2 / 2, 0.0, 0.0])

    def velocity(self, t):
        """Return their rates (3,)."""
        return np.array([FASTER * t, 0.0, 0.0])

    def acceleration(self, t):
        """Return their second derivatives (3,)."""
        return np.array([FASTER, 0.0, 0.0])


robot = trundle.load("omni3").with_body(mass=MASS, inertia=2.0, com=(0.0, 0.0))
model = trundle.Dynamics(robot.with_body(mass=BELIEVED))  # 6 kg have been loaded since
laws = {"PD": PD(KP, KD), "PID": PID(), "CT": ComputedTorque([GAIN] * 3, [4.0] * 3, model=model)}
last = {}
for name, law in laws.items():
    run = trundle.track(robot, SpeedingUp(), law, duration=30.0, dt=PID.dt, method="rk4")
    last[name] = run.error[-1, 0]
    print(f"{name:4} {last[name]:.6e} m behind after 30 s, force {run.force[-1, 0]:.4f} N")

# By hand: PD needs an error for the whole force, computed torque for what its model lacks of it.
np.testing.assert_allclose(last["PD"], MASS * FASTER / KP[0], rtol=1e-6)
np.testing.assert_allclose(last["CT"], (MASS / BELIEVED - 1) * FASTER / GAIN, rtol=1e-6)
assert abs(last["PID"]) < 1e-6
