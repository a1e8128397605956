"""What sits on a wheel's motor shaft: the motor itself and an encoder."""

from __future__ import annotations

import math
from dataclasses import dataclass

from trundle.errors import RobotError
from trundle.robot.quantity import check, quantity


@dataclass(frozen=True, kw_only=True)
class Motor:
    """A permanent-magnet DC motor behind a gear without play.

    With the wheel's speed omega, the gear N, voltage U and current i, inductance left out::

        U = R i + k_e N omega,    tau = N k_t (i - i_0 sign(omega))

    Source: Siciliano, Sciavicco, Villani and Oriolo, Robotics: Modelling, Planning and Control,
    2009, section 5.2.1 for the circuit and section 5.2.3 for the gear.

    >>> motor = Motor(torque_constant=0.02, resistance=2.0, gear=30.0, max_voltage=12.0)
    >>> round(motor.stall_torque, 9), round(motor.no_load_speed, 9)
    (3.6, 20.0)
    """

    torque_constant: float = quantity(
        "N m/A", positive=True, help="torque of the motor's shaft for one ampere"
    )
    resistance: float = quantity("ohm", positive=True, help="resistance of the winding")
    back_emf: float | None = quantity(
        "V s/rad",
        default=None,
        positive=True,
        help="voltage at 1 rad/s of the motor's shaft (default: the torque constant)",
    )
    gear: float = quantity(
        "", default=1.0, positive=True, help="turns of the motor for one turn of the wheel"
    )
    no_load_current: float = quantity(
        "A", default=0.0, nonnegative=True, help="current that only overcomes the motor's friction"
    )
    max_voltage: float | None = quantity("V", default=None, positive=True, help="supply voltage")
    max_current: float | None = quantity("A", default=None, positive=True, help="largest current")

    def __post_init__(self) -> None:
        if faults := check(self):
            raise RobotError(faults, "motor")

    @property
    def torque_per_ampere(self) -> float:
        """Torque at the wheel for one ampere [N m/A]."""
        return self.gear * self.torque_constant

    @property
    def volts_per_speed(self) -> float:
        """Back-EMF at one rad/s of the wheel [V s/rad]."""
        return self.gear * (self.torque_constant if self.back_emf is None else self.back_emf)

    @property
    def friction_torque(self) -> float:
        """Friction of the motor at the wheel [N m]."""
        return self.torque_per_ampere * self.no_load_current

    @property
    def stall_torque(self) -> float:
        """Torque at the wheel at standstill and full voltage, before friction [N m]; or inf."""
        if self.max_voltage is None:
            return math.inf
        return self.torque_per_ampere * self.max_voltage / self.resistance

    @property
    def no_load_speed(self) -> float:
        """Wheel speed at full voltage at which no torque is left, before friction [rad/s]."""
        return math.inf if self.max_voltage is None else self.max_voltage / self.volts_per_speed


@dataclass(frozen=True, kw_only=True)
class Encoder:
    """An incremental encoder on a wheel's motor shaft.

    >>> round(Encoder(ticks_per_motor_turn=64, gear=43.7).radians_per_tick, 9)
    0.002246562
    """

    ticks_per_motor_turn: float = quantity(
        "ticks", positive=True, help="encoder ticks in one turn of the motor shaft"
    )
    gear: float = quantity(
        "", default=1.0, positive=True, help="turns of the motor for one turn of the wheel"
    )

    def __post_init__(self) -> None:
        if faults := check(self):
            raise RobotError(faults, "encoder")

    @property
    def radians_per_tick(self) -> float:
        """Turn of the wheel for one tick [rad]."""
        return 2 * math.pi / (self.ticks_per_motor_turn * self.gear)
