"""How a robot and its wheels stand at chosen times of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.errors import TrundleError
from trundle.kinematics import robot_of
from trundle.robot import CasterWheel, Robot, RollingWheel, Wheel
from trundle.se2 import Array, point_twist
from trundle.simulation import Run, caster_angles
from trundle.view.stance import Stance, stand


@dataclass(frozen=True)
class Motion:
    """A run at chosen times.

    Attributes:
        t: (F,) [s].
        pose: (F, 3) x, y, psi [m, m, rad].
        stances: how the wheels stand at each time.
    """

    t: Array
    pose: Array
    stances: tuple[Stance, ...]


def at_times(robot: Robot, run: Run, t: Array) -> Motion:
    """Return a run at other times: poses and wheel angles in between, steering angles held.

    Raises:
        TrundleError: the run is of another robot.
    """
    check_same(robot, run)
    if len(run.twist) == 0:
        raise TrundleError("this run made no step: there is nothing to draw")
    step = np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, len(run.twist) - 1)
    swivel = np.unwrap(caster_angles(robot, run), axis=0)
    casters = [wheel for wheel in robot.wheels if isinstance(wheel, CasterWheel)]
    turning = {wheel.name: _turn(wheel, robot, run, swivel) for wheel in robot.wheels}
    turns = {name: np.interp(t, run.t, values) for name, values in turning.items()}
    swivels = {w.name: np.interp(t, run.t, swivel[:, i]) for i, w in enumerate(casters)}
    stances = tuple(
        stand(
            robot,
            run.steering[step[k]],
            {name: float(values[k]) for name, values in swivels.items()},
            {name: float(values[k]) for name, values in turns.items()},
        )
        for k in range(len(t))
    )
    return Motion(np.asarray(t), run.pose_at(t), stances)


def check_same(robot: Robot, run: Run) -> None:
    """Raise where a run was not made with a robot like this one.

    Raises:
        TrundleError: its driven or steered wheels have other names, or this is no robot.
    """
    robot_of(robot)
    for words, wheels, names in (
        ("driven", robot.driven, run.driven),
        ("steered", robot.steered, run.steered),
    ):
        own = [wheel.name for wheel in wheels]
        if own != list(names):
            raise TrundleError(
                f"the run is of another robot: its {words} wheels are {_join(names)}, "
                f"those of {robot.name!r} are {_join(own)}"
            )


def _join(names: tuple[str, ...] | list[str]) -> str:
    return ", ".join(names) or "none"


def _turn(wheel: Wheel, robot: Robot, run: Run, swivel: Array) -> Array:
    """Return how far a wheel has turned forward at each time of the run (T + 1,) [rad].

    A motor tells; a wheel without one rolls as the twist makes it.
    """
    if isinstance(wheel, RollingWheel) and wheel.driven:
        return wheel.spin_sign * run.wheel_angles[:, run.driven.index(wheel.name)]
    if isinstance(wheel, RollingWheel):
        names = [each.name for each in robot.steered]
        angle = run.steering[:, names.index(wheel.name)] if wheel.name in names else 0.0
        rows = wheel.rows(angle, np)
        assert rows.rolling is not None
        row = np.stack(np.broadcast_arrays(*rows.rolling, np.zeros(len(run.twist))), axis=-1)
        rate = (row[:, :3] * run.twist).sum(axis=1) / (rows.gain * wheel.spin_sign)
    elif isinstance(wheel, CasterWheel):
        place = [each.name for each in robot.wheels if isinstance(each, CasterWheel)]
        g = swivel[:-1, place.index(wheel.name)]
        velocity = point_twist(run.twist, (wheel.x, wheel.y))
        rate = (np.cos(g) * velocity[:, 0] + np.sin(g) * velocity[:, 1]) / wheel.radius
    else:
        rate = np.zeros(len(run.twist))
    return np.concatenate([[0.0], np.cumsum(rate * np.diff(run.t))])
