"""Friction at the wheels: viscous, Coulomb, and that of the motors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from trundle.kinematics import abreast
from trundle.robot import RollingWheel
from trundle.se2 import Array

# Coulomb friction changes sign within about this wheel speed [rad/s]: far slower than any wheel is
# driven, and not so sudden that a millisecond's step would chatter. It makes friction a function of
# speed alone, so a wheel at rest creeps where a real one sticks.
SLOW = 0.01


def friction_torque(viscous: Any, coulomb: Any, omega: Any, sqrt: Any, slow: Any = SLOW) -> Any:
    """Return the friction torque of a wheel at speed omega [N m], against its motion.

    ``b omega + f omega / sqrt(omega^2 + SLOW^2)``; branch-free, in the arithmetic of ``sqrt`` and,
    where that has numbers of its own, of ``slow``.
    """
    return viscous * omega + coulomb * omega / sqrt(omega * omega + slow * slow)


def coefficients(wheels: Sequence[RollingWheel]) -> tuple[Array, Array]:
    """Return viscous b [N m s/rad] and Coulomb f [N m], each (..., k); f with the motors' own."""
    motors = [wheel.motor.friction_torque if wheel.motor else 0.0 for wheel in wheels]
    coulomb = [wheel.coulomb_friction + own for wheel, own in zip(wheels, motors, strict=True)]
    return abreast([wheel.viscous_friction for wheel in wheels]), abreast(coulomb)
