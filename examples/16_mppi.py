"""A robot that looks ahead: at every tick it tries many futures and goes on as the cheap ones say.

It knows the goal, three circles to keep away from, and the wheels' limits; nobody plans a path.
"""

import dataclasses

import numpy as np
from matplotlib.patches import Circle

import trundle
from trundle import view
from trundle.control import MPPI
from trundle.simulation import Measurement, Reference

GOAL, CIRCLES = (3.0, 0.5, 0.0), np.array([[1.0, 0.0, 0.3], [2.0, 0.9, 0.3], [2.1, -0.3, 0.25]])
DT, TICKS, SHOWN = 0.05, 120, 24  # [s]; futures are shown at one tick

robot = trundle.load("mecanum", wheelbase=0.2, track=0.16).with_wheels(max_speed=20)  # [rad/s]
# Where numba is there, leave out device: 2000 samples then take less time than these.
law = MPPI(robot, samples=400, horizon=40, dt=DT, obstacles=CIRCLES, device="numpy")


class Goal:
    """A trajectory that stands still; any other would do."""

    def position(self, t):
        """Return x, y, psi (..., 3)."""
        return np.zeros((*np.shape(t), 3)) + GOAL

    def velocity(self, t):
        """Return no velocity (..., 3)."""
        return np.zeros((*np.shape(t), 3))

    acceleration = velocity


run = trundle.track(robot, Goal(), law, duration=DT * TICKS, dt=DT, pose=np.zeros(3))
away = np.hypot(*(run.pose[:, None, :2] - CIRCLES[:, :2]).T).T - CIRCLES[:, 2]
print(f"{np.hypot(*run.error[-1, :2]):.3f} m from the goal, {away.min():.3f} m from circles")

# One tick again, to see what it looked at: the darker a future, the more it counts.
wanted, state = Reference(np.array(GOAL), np.zeros(3), np.zeros(3)), None
for k in range(SHOWN + 1):
    here = Measurement(run.t[k], run.pose[k], np.zeros(3))
    seen = law.foresee(state, here, wanted)
    state = seen.plan
figure = view.plot_path(robot, dataclasses.replace(run, desired=None, error=None))
for way, weight in zip(seen.poses, seen.weights / seen.weights.max(), strict=True):
    color = (0.58, 0.40, 0.74, 0.06 + 0.9 * weight)
    figure.axes[0].plot(way[:, 0], way[:, 1], color=color, lw=0.8, zorder=9)
for x, y, radius in CIRCLES:
    figure.axes[0].add_patch(Circle((x, y), radius, color="0.75"))
view.save(figure, "mppi.png")

assert away.min() > 0.17  # half of the robot's diagonal
assert np.hypot(*run.error[-1, :2]) < 0.05
assert np.abs(run.wheel_speeds).max() <= 20.0 * (1 + 1e-12)
np.testing.assert_allclose(seen.plan.twists[0], run.twist[SHOWN], atol=1e-9)  # the same again
