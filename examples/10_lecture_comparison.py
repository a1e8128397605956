"""The lecture's comparison of PD and computed torque, with its own step of 0.1 s.

Mass 30 kg, 60 s, the lecture's heading: psi = atan2(y_d, x_d) in [0, 2 pi), no psi_dd, plain
difference. For the circle the lecture's loop can be solved by hand, step and all.
"""

import numpy as np

import trundle
from trundle import motion
from trundle.control import PD, ComputedTorque

DT, RADIUS, RATE = 0.1, 3.0, 0.1
robot = trundle.load("omni3").with_body(mass=30.0, inertia=0.1, com=(0.0, 0.0))
points, times = [(0, 0), (2, 2), (0, 4)], (0, 30, 60)
paths = {
    "circle": motion.circle(RADIUS, RATE, heading="lecture"),
    "via, stop": motion.cubic_via(points, times, (0, 0), heading="lecture"),
    "via, smooth": motion.cubic_via(points, times, heading="lecture"),
    "ellipse": motion.ellipse(3.0, 2.0, RATE, heading="lecture"),
    "Lissajous": motion.lissajous(3.0, 3.0, 0.2, 0.1, heading="lecture"),
}
laws = {"PD": PD([120, 120, 0.4], [120, 120, 0.4]), "CT": ComputedTorque([4] * 3, [4] * 3)}
worst = {}
print(f"{'largest error':22}{'x [m]':>12}{'y [m]':>12}{'psi [rad]':>12}")
for path, trajectory in paths.items():
    for name, law in laws.items():
        run = trundle.track(robot, trajectory, law, duration=60.0, dt=DT, method="lecture")
        worst[path, name] = np.abs(run.error).max(axis=0)
        print(f"{path:14}{name:8}" + "".join(f"{error:12.4e}" for error in worst[path, name]))


def steady(kp, kd, ahead):
    """Return the size of the steady error (e, e_d) z^k on the circle p z^k, z = exp(i w dt).

    q' = q + dt q_d + dt^2 a / 2 and q_d' = q_d + dt a, with a = kp e + kd e_d + ahead.
    """
    z, p = np.exp(1j * RATE * DT), RADIUS
    desired = p * np.array([z - 1 - 1j * RATE * DT, 1j * RATE * (z - 1)])
    left = np.array([[z - 1 + DT**2 * kp / 2, -DT + DT**2 * kd / 2], [DT * kp, z - 1 + DT * kd]])
    return abs(np.linalg.solve(left, desired - ahead * np.array([DT**2 / 2, DT]))[0])


by_hand = {"PD": steady(4.0, 4.0, 0.0), "CT": steady(4.0, 4.0, -RADIUS * RATE**2)}
print("the circle by hand:", {name: f"{error:.4e}" for name, error in by_hand.items()})
for name, error in by_hand.items():
    np.testing.assert_allclose(worst["circle", name][:2], error, rtol=1e-4)
# PD / m is the same loop without the desired acceleration: 120 / 30 = 4. The lecture's numbers:
np.testing.assert_allclose(worst["via, stop", "PD"], [3.2190e-3, 3.1215e-3, 2.3562], rtol=2e-5)
np.testing.assert_allclose(worst["Lissajous", "PD"], [2.9704e-2, 7.4813e-3, 6.2845], rtol=2e-5)
# A cubic has a constant jerk, 12 length / time^3, and the step leaves jerk (dt/2 - kd dt^2/12)/kp.
jerks = np.array([12 * 2 / 30**3, 12 * 4 / 60**3])
left = jerks * (DT / 2 - 4 * DT**2 / 12) / 4
np.testing.assert_allclose(worst["via, smooth", "CT"][:2], left, rtol=1e-6)
