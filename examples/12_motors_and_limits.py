"""What DC motors can give, and by how much a motion must be slowed down.

A differential drive of 40 kg is to go 4 m straight ahead in 3 s, from rest to rest. Its motors
have a stall torque and a no-load speed, between which the supply's voltage holds the torque down.
"""

import numpy as np

import trundle
from trundle import Motor, motion
from trundle.control import ReducedComputedTorque
from trundle.limits import feasibility

m, a, length, seconds = 40.0, 0.05, 4.0, 3.0
k, R, N, U = 0.05, 2.0, 10.0, 24.0  # [N m/A], [ohm], gear, [V]
motor = Motor(torque_constant=k, resistance=R, gear=N, max_voltage=U)
robot = (
    trundle.load("differential")
    .with_body(mass=m, inertia=1.0, com=(0.0, 0.0))
    .with_wheels(motor=motor)
)
asked = motion.line((0, 0), (length, 0), seconds)

found = feasibility(robot, asked)
print("\n".join(found.reports))
slower = asked.stretched(found.stretch)
print(f"\n{slower.duration:.3f} s instead of {asked.duration:g} s")
runs = {}
for name, trajectory in (("as asked", asked), ("stretched", slower)):
    runs[name] = trundle.track(robot, trajectory, ReducedComputedTorque())
    behind, most = runs[name].error[:, 0].max(), np.abs(runs[name].torques).max()
    print(f"{name:10} up to {behind:.4f} m behind, torque up to {most:.3f} N m")
print("\n".join(runs["as asked"].reports))

# By hand: the motor at the wheel, behind its gear.
stall, no_load = N * k * U / R, U / (N * k)
np.testing.assert_allclose([motor.stall_torque, motor.no_load_speed], [stall, no_load])

# The quintic's speed and acceleration at s = t / T. Each wheel gives half of m q_dd, at its rim.
s = np.linspace(0.0, 1.0, 100_001)
speed = length * 30 * s**2 * (1 - s) ** 2 / a
torque = m * length * (60 * s - 180 * s**2 + 120 * s**3) * a / 2


def voltage(T):
    """Return the largest voltage on the way, as a share of the supply's, for a duration T."""
    return np.abs(torque / T**2 / stall + speed / T / no_load).max()


before, after = voltage(asked.duration), voltage(slower.duration)
print(f"largest voltage: {before:.4f} of the supply as asked, {after:.4f} when stretched")
np.testing.assert_allclose(after, 1.0, rtol=1e-4)  # the trajectory is looked at every 10 ms
assert runs["as asked"].saturated.any()
assert not runs["stretched"].saturated.any()
