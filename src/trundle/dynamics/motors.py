"""What motors can give: limits of torque, and voltage and current of DC motors."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from trundle.dynamics.batches import together
from trundle.errors import TrundleError
from trundle.kinematics import finite, robot_of
from trundle.robot import Robot
from trundle.se2 import Array


class Limits(NamedTuple):
    """Limits of the n driven wheels' torques, each (n,); infinite where there is none.

    At wheel speed omega a voltage between its limits gives torques between
    ``-stall - slope omega`` and ``stall - slope omega``; of these, ``largest`` cuts off what the
    current or the gear cannot bear.
    """

    largest: Array  # [N m]
    stall: Array  # [N m]
    slope: Array  # [N m s/rad]

    @property
    def any(self) -> bool:
        """Whether some wheel has a limit."""
        return bool(np.isfinite([self.largest, self.stall]).any())

    def held(self, torques: Array, wheel_speeds: Array) -> Array:
        """Return torques (..., n) [N m] cut to what the motors can give at these speeds."""
        back = self.slope * wheel_speeds
        by_voltage = np.clip(torques, -self.stall - back, self.stall - back)
        return np.clip(by_voltage, -self.largest, self.largest)


def torque_limits(robot: Robot) -> Limits:
    """Return the limits of the driven wheels' torques, from ``max_torque`` and the motors."""
    rows: list[Any] = []
    for wheel in robot.driven:
        largest, stall, slope = wheel.max_torque, np.inf, 0.0
        largest = np.inf if largest is None else largest
        if motor := wheel.motor:
            if motor.max_current is not None:
                largest = np.minimum(largest, motor.torque_per_ampere * motor.max_current)
            if motor.max_voltage is not None:
                stall = motor.stall_torque
                slope = motor.torque_per_ampere * motor.volts_per_speed / motor.resistance
        rows += [largest, stall, slope]
    table = np.stack(np.broadcast_arrays(*rows), axis=-1) if rows else np.zeros(0)
    return Limits(*np.moveaxis(table.reshape(*table.shape[:-1], -1, 3), -1, 0))


class Motors:
    """The DC motors of a robot's n driven wheels, in order.

    Args:
        robot: the robot; each driven wheel needs a ``motor``.

    Raises:
        TrundleError: a driven wheel has none.

    >>> import trundle
    >>> motor = trundle.Motor(torque_constant=0.05, resistance=2.0, gear=20.0, max_voltage=24.0)
    >>> drive = Motors(trundle.load("differential").with_wheels(motor=motor))
    >>> drive.torques([12.0, 12.0], [0.0, 12.0]).tolist()  # at stall, and at no load
    [6.0, 0.0]
    """

    def __init__(self, robot: Robot) -> None:
        robot_of(robot)
        found = [wheel.motor for wheel in robot.driven if wheel.motor is not None]
        if len(found) < len(robot.driven):
            names = [wheel.name for wheel in robot.driven if wheel.motor is None]
            raise TrundleError(
                f"robot {robot.name!r}: {', '.join(names)} have no motor: write motor = "
                "{ torque_constant = ..., resistance = ..., gear = ... } for each driven wheel"
            )
        self._torque = np.array([motor.torque_per_ampere for motor in found])
        self._back_emf = np.array([motor.volts_per_speed for motor in found])
        self._resistance = np.array([motor.resistance for motor in found])
        self._limits = torque_limits(robot)

    def torques(self, voltages: npt.ArrayLike, wheel_speeds: npt.ArrayLike) -> Array:
        """Return the torques (..., n) at the wheels [N m] for voltages (..., n) [V].

        ``tau = N k_t i``, ``i = (U - k_e N omega) / R``; voltage and current are cut to their
        limits. The motors' own friction counts among the wheels'.
        """
        n = len(self._torque)
        U, omega = finite(voltages, "voltages", n), finite(wheel_speeds, "wheel_speeds", n)
        together({"voltages": U, "wheel_speeds": omega})
        current = (U - self._back_emf * omega) / self._resistance
        return self._limits.held(self._torque * current, omega)

    def voltages(self, torques: npt.ArrayLike, wheel_speeds: npt.ArrayLike) -> Array:
        """Return the voltages (..., n) [V] that give torques (..., n) [N m] at the wheels.

        ``U = R tau / (N k_t) + k_e N omega``, whether or not the supply reaches it.
        """
        n = len(self._torque)
        tau, omega = finite(torques, "torques", n), finite(wheel_speeds, "wheel_speeds", n)
        together({"torques": tau, "wheel_speeds": omega})
        return np.asarray(self._resistance * tau / self._torque + self._back_emf * omega)

    def currents(self, torques: npt.ArrayLike) -> Array:
        """Return the currents (..., n) [A] that give torques (..., n) [N m] at the wheels."""
        return np.asarray(finite(torques, "torques", len(self._torque)) / self._torque)
