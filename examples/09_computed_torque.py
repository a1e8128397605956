"""PD and computed torque on a circle, against the errors that theory gives.

With a true model, computed torque leaves e_dd + kd e_d + kp e = 0: an error at the start dies out
by itself. PD knows no mass. To make the force m q_dd it needs an error:
m e_dd + kd e_d + kp e = m q_dd.
"""

import numpy as np

import trundle
from trundle import motion
from trundle.control import PD, ComputedTorque

MASS, RADIUS, RATE = 30.0, 3.0, 0.1  # [kg], [m], [rad/s]

robot = trundle.load("omni3").with_body(mass=MASS, inertia=0.1, com=(0.0, 0.0))
circle = motion.circle(RADIUS, RATE)
aside = [0.1, 0.0, 0.0]  # the circle starts at the origin

pd = PD(kp=[120, 120, 0.4], kd=[120, 120, 0.4])
computed = ComputedTorque(kp=[4, 4, 4], kd=[4, 4, 4])  # critically damped: kd = 2 sqrt(kp)

runs = {
    name: trundle.track(robot, circle, law, dt=0.01, method="rk4", pose=aside)
    for name, law in {"PD": pd, "computed torque": computed}.items()
}
print(f"{'':16}{'after 1 s':>12}{'2 s':>12}{'5 s':>12}{'60 s':>12}   error in x [m]")
for name, run in runs.items():
    at = [run.error[round(t / 0.01), 0] for t in (1, 2, 5, 60)]
    print(f"{name:16}" + "".join(f"{error:12.2e}" for error in at))
    print(f"{'':16}largest torque of a wheel {np.abs(run.torques).max():.3f} N m")

# By hand, for two equal roots at -2: e = e_0 (1 + 2 t) exp(-2 t).
run = runs["computed torque"]
np.testing.assert_allclose(run.error[:, 0], -0.1 * (1 + 2 * run.t) * np.exp(-2 * run.t), atol=1e-8)
assert np.abs(run.error[:, 1:]).max() < 1e-8  # y and psi do not notice

# The circle's q_dd is a vector of size r w^2 that turns with w. So is PD's error, once it is
# steady: e = m r w^2 / |kp - m w^2 + i kd w|.
steady = MASS * RADIUS * RATE**2 / abs(120 - MASS * RATE**2 + 120j * RATE)
last = np.hypot(*runs["PD"].error[-1, :2])
print(f"PD's steady error: {last:.6e} m, by hand {steady:.6e} m")
np.testing.assert_allclose(last, steady, rtol=1e-6)
