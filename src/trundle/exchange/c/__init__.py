"""Robots as C99 for microcontrollers: kinematics, limits and odometry without allocation."""

from trundle.exchange.c.files import c_files

__all__ = ["c_files"]
