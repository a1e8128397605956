"""The peers from robotics: robotpy-wpimath's odometry, and MuJoCo's rollout."""

from __future__ import annotations

from typing import Any

import numpy as np
from _batch_tasks import DT, RADIUS, TRACK, WHEELBASE, Numbers, Sizes, few, streamed_speeds
from _common import Job


def wpimath(size: Sizes) -> Job:
    """Return odometry of one robot in a loop: wheel positions to a twist, its exact arc."""
    from wpimath.geometry import Pose2d, Translation2d
    from wpimath.kinematics import MecanumDriveKinematics, MecanumDriveWheelPositions

    a, b = WHEELBASE / 2, TRACK / 2
    corners = [Translation2d(x, y) for x in (a, -a) for y in (b, -b)]
    kinematics = MecanumDriveKinematics(*corners)

    def drive(turns: list[list[float]]) -> Any:
        pose, last, at = Pose2d(), MecanumDriveWheelPositions(), [0.0] * 4
        for row in turns:
            at = [s + RADIUS * turn for s, turn in zip(at, row, strict=True)]
            now = MecanumDriveWheelPositions()
            now.frontLeft, now.frontRight, now.rearLeft, now.rearRight = at
            # Newer releases of wpimath moved the arc from the pose to the twist.
            step = kinematics.toTwist2d(last, now)
            pose = pose.exp(step) if hasattr(pose, "exp") else pose + step.exp()
            last = now
        return pose

    turns = DT * streamed_speeds(size, "float64")[:, :, : size.few_robots]
    rows = [turns[:, :, i].tolist() for i in range(size.few_robots)]
    poses = [drive(row) for row in rows]
    answer = few(size, *np.transpose([(p.X(), p.Y(), p.rotation().radians()) for p in poses]))
    return Job("drive(turns)", {"drive": drive, "turns": rows[0]}, answer, size.steps)


BODY = """\
<mujoco>
  <option timestep="{dt}" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody>
    <body>
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 1 0"/>
      <joint name="psi" type="hinge" axis="0 0 1"/>
      <geom type="box" size="0.25 0.19 0.05" mass="10"/>
    </body>
  </worldbody>
  <actuator>
    <motor joint="x"/><motor joint="y"/><motor joint="psi"/>
  </actuator>
</mujoco>
"""


def mujoco(size: Sizes) -> Job:
    """Return a free planar base under given forces; it must go where the formula says."""
    import os

    import mujoco as mj
    from mujoco.rollout import Rollout

    robots, steps = min(size.robots, 1000), size.steps
    model, rng = mj.MjModel.from_xml_string(BODY.format(dt=DT)), np.random.default_rng(6)
    threads = os.cpu_count() or 1
    data = [mj.MjData(model) for _ in range(threads)]
    # Time, then the position and its rate; a force for each of them in every step.
    width = mj.mj_stateSize(model, mj.mjtState.mjSTATE_FULLPHYSICS)
    start = np.zeros((robots, width))
    start[:, 4:7] = rng.uniform(-1.0, 1.0, (robots, 3))
    force = rng.uniform(-1.0, 1.0, (robots, steps, 3))
    state = np.zeros((robots, steps, width))
    sensors = np.zeros((robots, steps, model.nsensordata))
    pool = Rollout(nthread=threads)
    given = {"nstep": steps, "skip_checks": False, "state": state, "sensordata": sensors}

    def call() -> None:
        pool.rollout(model, data, start, force, **given)

    call()
    wanted = pushed(start[:, 4:7], force, float(model.body_mass[1]))
    if not np.allclose(state[:, -1, 1:3], wanted, rtol=0, atol=1e-9):
        raise SystemExit("MuJoCo's base is not where its forces take it")
    return Job("call()", {"call": call}, [], robots * steps)


def pushed(rate: Numbers, force: Numbers, mass: float) -> Numbers:
    """Return positions x, y (N, 2) after semi-implicit Euler steps under forces (N, T, 3)."""
    rates = rate[:, None, :2] + np.cumsum(DT * force[:, :, :2] / mass, axis=1)
    positions: Numbers = DT * rates.sum(axis=1)
    return positions
