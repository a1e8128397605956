"""The files of a robot's firmware."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from trundle.errors import TrundleError, did_you_mean
from trundle.exchange.c import tables
from trundle.exchange.c.printer import Slots, function, head, number, prototype, remark
from trundle.exchange.c.programs import check_observed, parts_of_step, wheel_programs
from trundle.exchange.c.template import filled, template
from trundle.exchange.names import comment, identifiers
from trundle.kinematics import straight_lines
from trundle.limits import TwistLimits, limit_names, per, steering_inputs
from trundle.robot import Encoder, Robot

_FILES = ("trundle.h", "trundle.c", "README.md", "example.ino")
# Where a robot's description has no encoder: common on motors for hobbyists.
_STAND_IN_TICKS = 2048
# Microseconds in 32 bits wrap around after 71 minutes: ages must stay far below half of that.
_LONGEST = 600.0
_MICRO = 1e6


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The settings of a bridge that its C takes over; ``trundle.Bridge`` says what they mean.

    Raises:
        TrundleError: a setting is impossible in C.
    """

    timeout: float = 0.5
    encoder: Encoder | None = None
    counter_bits: int = 32
    max_interval: float = 0.1

    def __post_init__(self) -> None:
        for name in ("timeout", "max_interval"):
            value = getattr(self, name)
            sound = isinstance(value, int | float) and 1 / _MICRO <= value <= _LONGEST
            if not sound or isinstance(value, bool):
                raise TrundleError(
                    f"{name} must be from a microsecond to {_LONGEST:g} s in C, got {value!r}"
                )
        bits = self.counter_bits
        if not isinstance(bits, int) or isinstance(bits, bool) or not 8 <= bits <= 32:
            raise TrundleError(f"counter_bits must be from 8 to 32 in C, got {bits!r}")
        if not isinstance(self.encoder, Encoder | None):
            raise TrundleError(f"encoder must be an Encoder, got {self.encoder!r}")


def c_files(robot: Robot, **settings: Any) -> dict[str, str]:
    """Return a robot's firmware: file name -> text.

    ``trundle.h`` and ``trundle.c`` are C99 that allocates nothing and keeps nothing between calls;
    ``README.md`` says how to use them, ``example.ino`` is a main loop for Arduino-style boards.
    Inverse, forward and odometry are printed from the programs that ``Kinematics.bind`` runs.

    Args:
        robot: the robot.
        settings: those of ``trundle.Bridge``: timeout, encoder, counter_bits, max_interval, and
            the limits. Noise and slip are not watched in C.

    Raises:
        TrundleError: a setting is impossible, no wheel is driven or measured, or the robot's
            linked steering has no closed formula.
        UnobservedMotionError: the counters do not tell every motion.

    >>> import trundle
    >>> files = c_files(trundle.load("mecanum"), max_speed=1.0, max_acceleration=0.5)
    >>> sorted(files)
    ['README.md', 'example.ino', 'trundle.c', 'trundle.h']
    >>> "void trundle_forward(const trundle_real wheel_speeds[4]" in files["trundle.h"]
    True
    """
    if not isinstance(robot, Robot):
        raise TrundleError(f"a Robot is needed, such as trundle.load('omni3'), got {robot!r}")
    known = (*Settings.__dataclass_fields__, *limit_names())
    for name in settings:
        if name not in known:
            raise TrundleError(f"the bridge in C has no {name!r}{did_you_mean(name, known)}")
    for what, wheels in (("driven", robot.driven), ("measured", robot.sensed)):
        if not wheels:
            raise TrundleError(f"robot {robot.name!r}: no wheel is {what}; firmware needs one")
    limits = TwistLimits(**{k: v for k, v in settings.items() if k in limit_names()})
    own = Settings(**{k: v for k, v in settings.items() if k not in limit_names()})
    functions = _functions(robot)
    check_observed(robot)
    places = functions | _numbers(robot, own, limits) | _words(robot, own)
    true = _conditions(robot, own, limits)
    if "PROJECT" in functions:
        true.add("projects")
    if true & {"projects", "jerk"}:
        true.add("differs")
    return {name: filled(template(name), places, true) for name in _FILES}


def _functions(robot: Robot) -> dict[str, str]:
    """Return the printed functions, and prototypes of those that others call."""
    programs = wheel_programs(robot)  # first: it tells best why a robot has no formulas
    lines = straight_lines(robot)
    n, s, k = len(robot.driven), len(robot.steered), len(robot.sensed)
    speeds, twist, pose = Slots("wheel_speeds", n), Slots("twist", 3), Slots("pose", 3)
    steering = [Slots("steering", s)] if s else []
    turned, moved = Slots("wheel_increments", k), Slots("moved", 3)
    inverse = ("trundle_inverse", [twist], [speeds, *steering])
    forward = ("trundle_forward", [speeds, *steering], [twist])
    increment, advance = parts_of_step(lines.step)
    made = {
        "INVERSE": function(lines.inverse, *inverse),
        "FORWARD": function(lines.forward, *forward),
        "INCREMENT": function(increment, "increment", [turned, *steering], [moved]),
        "ADVANCE": function(advance, "advance", [pose, moved], [pose]),
        "INVERSE_HEAD": prototype(*inverse),
        "FORWARD_HEAD": prototype(*forward),
        "ODOMETRY_HEAD": prototype("trundle_odometry", [pose, turned, *steering], [pose]),
    }
    for name, straight in programs.items():
        out = Slots("to", len(straight.results))
        made[name.upper()] = function(straight, name, [twist], [out])
    return made


def _numbers(robot: Robot, settings: Settings, limits: TwistLimits) -> dict[str, str]:
    """Return the tables and constants."""
    inputs = steering_inputs(robot)
    bits, plausible = settings.counter_bits, _watched(robot)
    return {
        "TIMEOUT_US": f"UINT32_C({round(settings.timeout * _MICRO)})",
        "MAX_INTERVAL_US": f"UINT32_C({round(settings.max_interval * _MICRO)})",
        "LIMITS": tables.limit_lines(limits),
        "TURNS": ", ".join(str(each).lower() for each in limits.turns),
        "FIXED": str(len(robot.driven) - sum(wheel.steers for wheel in robot.driven)),
        "PER_SPEED": tables.numbers(per(w.max_speed) for w in robot.driven),
        "PER_ACCELERATION": tables.numbers(per(w.max_acceleration) for w in robot.driven),
        "DRIVEN_TABLE": tables.driven_table(robot),
        "INPUT_TABLE": tables.input_table(inputs),
        "STEERED_TABLE": tables.steered_table(inputs),
        "UNIT_TABLE": tables.unit_table(robot, settings.encoder),
        "COUNTER_TABLE": tables.counter_table(robot, settings.encoder, plausible),
        "TICKS_PER_TURN": str(_STAND_IN_TICKS),
        "COUNTER_RANGE": f"UINT32_C({(1 << bits) - 1:#x})",
        "COUNTER_HALF": f"UINT32_C({1 << (bits - 1):#x})",
        "TURN": number(math.tau),
        "RPM": number(60.0 / math.tau),
    }


def _words(robot: Robot, settings: Settings) -> dict[str, str]:
    """Return the names and sentences."""
    names = identifiers(wheel.name for wheel in robot.wheels)
    groups = [("WHEEL", robot.driven), ("STEERED", robot.steered), ("COUNTER", robot.sensed)]
    places = [
        ",\n".join(
            f"    TRUNDLE_{word}_{names[wheel.name].upper()} = {i}"
            for i, wheel in enumerate(wheels)
        )
        for word, wheels in groups
        if wheels
    ]
    steered = bool(robot.steered)
    blind = [w.name for w in robot.sensed if not (w.encoder or settings.encoder)]
    start = ["trundle_state *state", "uint32_t now_us", "const trundle_real pose[3]"]
    step = [
        "trundle_state *state",
        "uint32_t now_us",
        "const trundle_real command[3]",
        f"const uint32_t counts[{len(robot.sensed)}]",
    ]
    if steered:
        angles = f"const trundle_real steering[{len(robot.steered)}]"
        start, step = [*start, angles], [*step, angles]
    read = ["trundle_state *state", f"const uint32_t counts[{len(robot.sensed)}]"]
    if steered:
        read.append(f"const trundle_real angles[{len(robot.steered)}]")
    step.append("trundle_output *output")
    return {
        "ROBOT": comment(robot.name),
        "PLACES": ",\n".join(places),
        "WHEELS": str(len(robot.driven)),
        "STEERED": str(len(robot.steered)),
        "INPUTS": str(len(steering_inputs(robot))),
        "COUNTERS": str(len(robot.sensed)),
        "STAND_IN": remark(
            "Counts in one turn of a wheel. The robot's description has no encoder for "
            f"{comment(', '.join(blind))}: this is a stand-in until you put yours here."
        ),
        "START": head("trundle_start", start),
        "STEP": head("trundle_step", step),
        "TIMEOUT": f"{settings.timeout:g}",
        "ENCODERS": _encoders(bool(blind), settings.counter_bits),
        "NO_STEERING": ", NULL" if steered else "",
        "NO_MEASURED": "NULL, " if steered else "",
        "STEERING": "steering, " if steered else "",
        "MIDDLE": "middle, " if steered else "",
        "ANGLES": ", angles" if steered else "",
        "READ_COUNTERS": head("read_counters", read),
        "AND_STEERING": " and steering angles [rad]" if steered else "",
        "AND_FROM_STEERING": " and the steering angles [rad]" if steered else "",
        "AT_STEERING": (
            ",\n * at the steering angles [rad] midway between the two" if steered else ""
        ),
        "ROUNDED_ANGLE": ", and of a steering angle at its limit [rad]" if steered else "",
        "OF_STEERED": "of steered ones, " if steered else "",
        "WRAP_WORDS": (
            f" after {settings.counter_bits} bits" if settings.counter_bits < 32 else ""
        ),
        "FASTEST_WORDS": (
            ", and the speed beyond which a\n * reading of it cannot be [rad/s]; 0: none"
            if _watched(robot)
            else ""
        ),
    }


def _encoders(blind: bool, bits: int) -> str:
    """Return what is to be known about the counters."""
    if blind:
        return (
            f"Set `TRUNDLE_TICKS_PER_TURN` in `trundle.h` to the counts in a turn of your wheels: "
            f"{_STAND_IN_TICKS} is a stand-in, the robot's description has no encoder."
        )
    return f"Counters have {bits} bits and wrap around; counts in a turn come from the encoders."


def _conditions(robot: Robot, settings: Settings, limits: TwistLimits) -> set[str]:
    """Return which conditions of the templates are true."""
    speeds = any(wheel.max_speed for wheel in robot.driven)
    accelerations = any(wheel.max_acceleration for wheel in robot.driven)
    jerk = limits.max_jerk is not None or limits.max_yaw_jerk is not None
    conditions = {
        "steered": bool(robot.steered),
        "fixed": not all(wheel.steers for wheel in robot.driven),
        "turning": any(wheel.steers for wheel in robot.driven),
        "ranged": any(map(math.isfinite, _ends(robot))),
        "wheel_speed": speeds,
        "wheel_acceleration": accelerations,
        "wheel_limits": speeds or accelerations,
        "turns": any(limits.turns),
        "jerk": jerk,
        "rests": jerk or bool(robot.steered),
        "floors": jerk or bool(robot.steered),
        "stand_in": any(not (w.encoder or settings.encoder) for w in robot.sensed),
        "narrow": settings.counter_bits < 32,
        "plausible": _watched(robot),
    }
    return {name for name, true in conditions.items() if true}


def _ends(robot: Robot) -> list[float]:
    return [end for each in steering_inputs(robot) for end in (each.low, each.high)]


def _watched(robot: Robot) -> bool:
    """Return whether some reading of a counter can be too fast to be true."""
    return any(wheel.max_speed and wheel.driven for wheel in robot.sensed)
