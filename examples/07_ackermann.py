"""A car: exact left and right steering angles, and the smallest circle it can drive."""

import math

import numpy as np

import trundle
from trundle import view

L, track = 2.6, 1.5
limit = math.radians(35)
car = trundle.load("ackermann", wheelbase=L, track=track)
kin = trundle.Kinematics(car)

# The origin is the middle of the rear axle, so the centre of turning is at (0, u / r).
R = 6.0
found = kin.inverse([3.0, 0.0, 3.0 / R])
left, right = found.steering
print(f"circle of {R} m: left {math.degrees(left):.3f} deg, right {math.degrees(right):.3f} deg")
print("rear wheels:", found.wheel_speeds.round(4), "rad/s")

# With a steering limit, a tighter circle than can be driven gives the nearest that can.
limited = car.with_wheels(steering_min=-limit, steering_max=limit)
nearest = trundle.Kinematics(limited).inverse([1.0, 0.0, 2.0])
u, v, r = nearest.twist
print(f"asked for a radius of 0.5 m, given {u / r:.4f} m; missing {nearest.residual.round(4)}")

once = 2 * math.pi / r
run = trundle.simulate(limited, twist=nearest.twist, duration=once, dt=once / 400)
width = np.ptp(run.pose[:, 0])
print(f"turning circle of the rear axle: {width:.3f} m across")
layout = view.plot_layout(limited, steering=nearest.steering, twist=nearest.twist)
view.save(layout, "tightest.png")

# By hand, tan(angle) = L / (R -+ track / 2): the inner, left wheel steers more.
assert math.isclose(math.tan(left), L / (R - track / 2), rel_tol=1e-12)
assert math.isclose(math.tan(right), L / (R + track / 2), rel_tol=1e-12)
assert math.isclose(1 / math.tan(right) - 1 / math.tan(left), track / L, rel_tol=1e-9)
assert found.residual.tolist() == [0, 0, 0]

# The inner wheel at its limit: R = L / tan(35 deg) + track / 2.
smallest = L / math.tan(limit) + track / 2
assert math.isclose(u / r, smallest, rel_tol=1e-9)
assert math.isclose(nearest.steering[0], limit, rel_tol=1e-9)
assert math.isclose(width, 2 * smallest, rel_tol=1e-4)  # the samples miss the widest points
