"""Drive for 24 hours at 50 Hz behind the bridge, with counters that wrap and commands that stop.

The robot rolls as it is told; 16-bit counters show its wheels' turning. Commands come at random,
stop for random times. At the end the pose of the bridge is compared with the
integration of all counts by arrays, in extended precision and without any wrapping around. The
robot must not steer.

    python benchmarks/long_drive.py --hours 24
    python benchmarks/long_drive.py --robot differential --smoke    # only see that it runs
"""

from __future__ import annotations

import argparse
import math
import random

import numpy as np
from _common import publish, table

import trundle
from trundle import Bridge, Encoder, Kinematics

DT = 0.02
ENCODER = Encoder(ticks_per_motor_turn=2048, gear=20.0)
BITS = 16
NOTES = """\
Random commands at 50 Hz that now and then stop for up to four seconds, wheels that turn as they are
told, and counters of 16 bits. The pose of the bridge against the integration of all counts, which
then do not wrap around, by exact arcs in extended precision."""


def main() -> None:
    """Drive, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--robot", default="mecanum")
    parser.add_argument("--smoke", action="store_true", help="ten seconds, to see that it runs")
    parser.add_argument("--write", action="store_true", help="put the table into the docs")
    given = parser.parse_args()
    hours = 10 / 3600 if given.smoke else given.hours
    robot = trundle.load(given.robot).with_wheels(encoder=ENCODER)
    bridge = Bridge(
        robot, timeout=0.3, counter_bits=BITS, max_speed=1.0, max_yaw_rate=2.0,
        max_acceleration=1.0, max_deceleration=2.0, max_yaw_acceleration=4.0,
    )  # fmt: skip
    cycles = round(hours * 3600 / DT)
    counts, pose, refused, stale = drive(bridge, cycles)
    x, y, psi = np.abs(np.array(pose) - integrated(robot, counts))
    path = trundle.dead_reckon(robot, np.diff(counts, axis=0) * ENCODER.radians_per_tick)
    way = float(np.hypot(*np.diff(path[:, :2], axis=0).T).sum())
    around = int(np.abs(np.diff(counts >> BITS, axis=0)).sum())
    rows = [
        ["cycles, steps refused", f"{cycles:,}, {refused}"],
        ["cycles without a live command", f"{stale:,}"],
        ["way [km]", f"{way / 1000:.1f}"],
        ["times around the counters", f"{around:,}"],
        ["trundle's x, y off by [m]", f"{x:.1e}, {y:.1e}"],
        ["its psi off by [rad]", f"{psi:.1e}"],
    ]
    title = f"## {hours:.3g} hours behind the bridge\n\n{NOTES}"
    publish("long_drive", f"{title}\n\n{table([robot.name, ''], rows)}", given)


def drive(bridge: Bridge, cycles: int) -> tuple[np.ndarray, tuple[float, float, float], int, int]:
    """Return the counts (T, k) that never wrap, the pose, and the steps refused and stale."""
    generator = random.Random(24)
    kinematics = Kinematics(bridge.robot)
    scale = [1.0 / ENCODER.radians_per_tick] * len(bridge.robot.sensed)
    state = bridge.start()
    turned = [0.0] * len(scale)
    history = np.zeros((cycles, len(scale)), dtype=np.int64)
    command, silent_until, stale = (0.0, 0.0, 0.0), 0, 0
    same = [wheel.name for wheel in bridge.robot.sensed] == [w.name for w in bridge.robot.driven]
    for k in range(cycles):
        if generator.random() < 0.01:
            command = tuple(generator.uniform(-1.5, 1.5) for _ in range(3))
        if generator.random() < 0.002:
            silent_until = k + generator.randrange(200)
        whole = [math.floor(angle * per) for angle, per in zip(turned, scale, strict=True)]
        history[k] = whole
        shown = [count & 0xFFFF for count in whole]
        output, state = bridge.step(state, k * DT, None if k < silent_until else command, shown)
        stale += output.stale
        speeds = output.wheel_speeds
        if not same:
            speeds = kinematics.rolling_speeds(output.twist, output.steering, sensed=True)
        turned = [angle + speed * DT for angle, speed in zip(turned, speeds, strict=True)]
    return history, state.pose, state.refused + state.refused_counts, stale


def integrated(robot: trundle.Robot, counts: np.ndarray) -> np.ndarray:
    """Return the last pose by exact arcs in extended precision, written apart from the library."""
    matrix = Kinematics(robot).odometry_matrix().astype(np.longdouble)
    tick = 2 * np.arctan2(np.longdouble(0), np.longdouble(-1)) / (2048 * 20)
    moved = (np.diff(counts, axis=0) * tick) @ matrix.T
    psi = np.concatenate([[np.longdouble(0)], np.cumsum(moved[:, 2])])
    half = moved[:, 2] / 2
    shrink = np.where(half == 0, 1, np.sin(half) / np.where(half == 0, 1, half))
    middle = psi[:-1] + half
    x = (shrink * (np.cos(middle) * moved[:, 0] - np.sin(middle) * moved[:, 1])).sum()
    y = (shrink * (np.sin(middle) * moved[:, 0] + np.cos(middle) * moved[:, 1])).sum()
    return np.array([x, y, psi[-1]], dtype=np.float64)


if __name__ == "__main__":
    main()
