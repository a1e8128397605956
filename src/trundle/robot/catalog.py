"""The catalogue: one function for each drive, with its source and sizes that can be changed.

Lengths are full sizes in metres: ``wheelbase`` between the front and the rear contact points,
``track`` between the left and the right ones, ``arm`` from the centre to a contact point. Masses
are stand-ins for bodies of that size: change them with ``Robot.with_body``.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from math import cos, pi, radians, sin

import numpy as np

from trundle.errors import RobotError, did_you_mean
from trundle.robot.motor import Encoder
from trundle.robot.quantity import Quantity
from trundle.robot.robot import Body, Robot
from trundle.robot.wheels import (
    CasterWheel,
    FixedWheel,
    MecanumWheel,
    OmniWheel,
    SteeredWheel,
    Wheel,
)

Catalog = dict[str, Callable[..., Robot]]
_FAR = 1.25  # body outline over the span of the contact points


# No source gives masses: a stand-in, spread evenly over the outline [kg/m^2].
_DENSITY = 100.0


def _body(length: float, width: float, x: float = 0.0, margin: float = _FAR) -> Body:
    length, width = margin * length, margin * width
    mass = _DENSITY * length * width
    inertia = mass * (length**2 + width**2) / 12
    return Body(length=length, width=width, x=x, mass=mass, inertia=inertia, com=(x, 0.0))


def _corners(wheelbase: float, track: float, rear: float = 0.5) -> dict[str, tuple[float, float]]:
    """Return four contact points; ``rear`` is the rear axle's share of the wheelbase behind O."""
    front_x, rear_x, y = (1 - rear) * wheelbase, 0.0 - rear * wheelbase, track / 2
    return {
        "front_left": (front_x, y),
        "front_right": (front_x, -y),
        "rear_left": (rear_x, y),
        "rear_right": (rear_x, -y),
    }


def differential(radius: float = 0.05, track: float = 0.4) -> Robot:
    """Two driven wheels on one axle and a caster.

    Source: the lectures' differential drive (left, right); Siegwart and Nourbakhsh, Introduction
    to Autonomous Mobile Robots, 2004, section 3.2.2.
    """
    wheels: tuple[Wheel, ...] = (
        FixedWheel(name="left", x=0.0, y=track / 2, radius=radius),
        FixedWheel(name="right", x=0.0, y=-track / 2, radius=radius),
        CasterWheel(
            name="caster",
            x=-0.4 * track,
            y=0.0,
            radius=0.4 * radius,
            trail=0.4 * radius,
            heading=0.0,
        ),
    )
    return Robot(name="differential", wheels=wheels, body=_body(1.1 * track, track, -0.1 * track))


def tricycle(radius: float = 0.1, wheelbase: float = 0.8, track: float = 0.5) -> Robot:
    """A steered and driven front wheel, two free wheels behind; origin at the rear axle.

    Source: the lectures' tricycle; Siegwart and Nourbakhsh, 2004, section 3.3.3 and figure 3.13.
    """
    wheels = (
        SteeredWheel(name="front", x=wheelbase, y=0.0, radius=radius),
        FixedWheel(name="rear_left", x=0.0, y=track / 2, radius=radius, driven=False),
        FixedWheel(name="rear_right", x=0.0, y=-track / 2, radius=radius, driven=False),
    )
    return Robot(name="tricycle", wheels=wheels, body=_body(wheelbase, track, wheelbase / 2))


def bicycle(radius: float = 0.3, wheelbase: float = 1.0) -> Robot:
    """A driven rear wheel and a steered front wheel in line; origin at the rear wheel.

    Source: Corke, Robotics, Vision and Control, 2nd edition, 2017, section 4.1.1.
    """
    wheels = (
        SteeredWheel(name="front", x=wheelbase, y=0.0, radius=radius, driven=False),
        FixedWheel(name="rear", x=0.0, y=0.0, radius=radius),
    )
    body = _body(1.3 * wheelbase, 0.35 * wheelbase, wheelbase / 2, margin=1.0)
    return Robot(name="bicycle", wheels=wheels, body=body)


def ackermann(radius: float = 0.3, wheelbase: float = 2.6, track: float = 1.5) -> Robot:
    """A car: two steered front wheels, two driven rear wheels; origin at the rear axle.

    Source: the lectures' Ackermann drive; Siegwart and Nourbakhsh, 2004, section 3.3.3.
    """
    at = _corners(wheelbase, track, rear=0.0)
    wheels = tuple(
        SteeredWheel(name=name, x=x, y=y, radius=radius, driven=False)
        if name.startswith("front")
        else FixedWheel(name=name, x=x, y=y, radius=radius)
        for name, (x, y) in at.items()
    )
    return Robot(name="ackermann", wheels=wheels, body=_body(wheelbase, track, wheelbase / 2))


def rear_steered(radius: float = 0.2, wheelbase: float = 1.4, track: float = 0.9) -> Robot:
    """A forklift: two driven front wheels, two steered rear wheels; origin at the front axle.

    Source: Rajamani, Vehicle Dynamics and Control, 2nd edition, 2012, section 2.2, with the front
    angle zero.
    """
    at = _corners(wheelbase, track, rear=1.0)
    wheels = tuple(
        SteeredWheel(name=name, x=x, y=y, radius=radius, driven=False)
        if name.startswith("rear")
        else FixedWheel(name=name, x=x, y=y, radius=radius)
        for name, (x, y) in at.items()
    )
    return Robot(name="rear_steered", wheels=wheels, body=_body(wheelbase, track, -wheelbase / 2))


def four_wheel_steered(radius: float = 0.3, wheelbase: float = 2.0, track: float = 1.4) -> Robot:
    """Four driven wheels; on each side the rear wheel steers against the front one.

    The centre of rotation stays on the line midway between the axles.

    Source: Rajamani, 2012, section 2.2 (front and rear steering angles equal and opposite).
    """
    wheels = tuple(
        SteeredWheel(
            name=name,
            x=x,
            y=y,
            radius=radius,
            steering_group="left" if y > 0 else "right",
            steering_ratio=1.0 if x > 0 else -1.0,
        )
        for name, (x, y) in _corners(wheelbase, track).items()
    )
    return Robot(name="four_wheel_steered", wheels=wheels, body=_body(wheelbase, track))


def _tangential(
    angle: float, arm: float, radius: float, name: str, reversed: bool = False, turn: float = pi / 2
) -> OmniWheel:
    """Return an omni wheel at a polar angle that drives across its arm."""
    return OmniWheel(
        name=name,
        x=round(arm * cos(angle), 15),
        y=round(arm * sin(angle), 15),
        heading=angle + turn,
        radius=radius,
        reversed=reversed,
    )


def omni3(radius: float = 0.2, arm: float = 0.3) -> Robot:
    """Three omni wheels at 0, 120 and 240 degrees that spin the body counter-clockwise.

    Source: the lecture on the omnidirectional robot (a = 0.2 m, l = 0.3 m).
    """
    wheels = tuple(_tangential(radians(120 * i), arm, radius, f"wheel_{i + 1}") for i in range(3))
    return Robot(name="omni3", wheels=wheels, body=_body(1.6 * arm, 1.75 * arm))


def omni3_exercise(radius: float = 0.1, arm: float = 0.5) -> Robot:
    """Three omni wheels at 0, 120 and 240 degrees that spin the body clockwise.

    Source: the exercise in the polar form (alpha, beta, l) with beta = 0, l = 0.5 m, r = 0.1 m;
    Siegwart and Nourbakhsh, 2004, section 3.2.3.
    """
    wheels = tuple(
        _tangential(radians(120 * i), arm, radius, f"wheel_{i + 1}", turn=-pi / 2) for i in range(3)
    )
    return Robot(name="omni3_exercise", wheels=wheels, body=_body(1.6 * arm, 1.75 * arm))


def omni(
    angles: Sequence[float] = (0.0, pi / 2, pi, 3 * pi / 2), radius: float = 0.05, arm: float = 0.2
) -> Robot:
    """Omni wheels at the given polar angles [rad], each driving across its arm.

    Source: Lynch and Park, Modern Robotics, 2017, section 13.2.1.
    """
    wheels = tuple(
        _tangential(float(angle), arm, radius, f"wheel_{i + 1}") for i, angle in enumerate(angles)
    )
    return Robot(name="omni", wheels=wheels, body=_body(1.6 * arm, 1.6 * arm))


def omni4(radius: float = 0.05, arm: float = 0.2) -> Robot:
    """Four omni wheels at 45 degrees (X-drive), all mounted so that they spin backwards.

    Source: the slides on the four-wheel omni robot (FL, FR, RL, RR at 45, 315, 135, 225 deg).
    """
    at = {"front_left": 45, "front_right": 315, "rear_left": 135, "rear_right": 225}
    wheels = tuple(
        _tangential(radians(angle), arm, radius, name, reversed=True) for name, angle in at.items()
    )
    return Robot(name="omni4", wheels=wheels, body=_body(1.5 * arm, 1.5 * arm))


def mecanum(radius: float = 0.05, wheelbase: float = 0.4, track: float = 0.3) -> Robot:
    """Four mecanum wheels whose rollers form an X seen from above (usual).

    Source: Lynch and Park, 2017, section 13.2.1 and figure 13.5; the rollers on the ground form
    an O, so that the yaw arm is half the wheelbase plus half the track.
    """
    rollers = {"front_left": -45, "front_right": 45, "rear_left": 45, "rear_right": -45}
    wheels = tuple(
        MecanumWheel(name=name, x=x, y=y, radius=radius, roller=radians(rollers[name]))
        for name, (x, y) in _corners(wheelbase, track).items()
    )
    return Robot(name="mecanum", wheels=wheels, body=_body(wheelbase, track))


def mecanum_lecture(radius: float = 0.2, wheelbase: float = 0.6, track: float = 1.0) -> Robot:
    """Four mecanum wheels with the lecture's rollers: the yaw arm is only |d - l|.

    Wheels in the lecture's order (l, d), (-l, d), (-l, -d), (l, -d), with half sizes l and d.

    Source: the lecture on the mecanum robot (a = 0.2 m, l = 0.3 m).
    """
    at = _corners(wheelbase, track)
    rollers = {"front_left": 45, "rear_left": -45, "rear_right": 45, "front_right": -45}
    wheels = tuple(
        MecanumWheel(name=name, x=at[name][0], y=at[name][1], radius=radius, roller=radians(deg))
        for name, deg in rollers.items()
    )
    return Robot(name="mecanum_lecture", wheels=wheels, body=_body(wheelbase, track))


def two_steered(radius: float = 0.05, wheelbase: float = 0.5) -> Robot:
    """Two wheels in line, each steered and driven, and two casters.

    Source: the lectures' two-steer; Campion, Bastin and d'Andrea-Novel, IEEE Transactions on
    Robotics and Automation 12(1), 1996, type (1,2).
    """
    half, side = wheelbase / 2, 0.35 * wheelbase
    wheels: tuple[Wheel, ...] = (
        SteeredWheel(name="front", x=half, y=0.0, radius=radius),
        SteeredWheel(name="rear", x=-half, y=0.0, radius=radius),
        CasterWheel(name="left", x=0.0, y=side, radius=0.6 * radius, trail=0.5 * radius),
        CasterWheel(name="right", x=0.0, y=-side, radius=0.6 * radius, trail=0.5 * radius),
    )
    return Robot(name="two_steered", wheels=wheels, body=_body(1.1 * wheelbase, 0.9 * wheelbase))


def synchro(radius: float = 0.05, arm: float = 0.2) -> Robot:
    """Three driven wheels that one belt steers together.

    Source: Siegwart and Nourbakhsh, 2004, section 3.3.3 and figure 3.14.
    """
    wheels = tuple(
        SteeredWheel(
            name=f"wheel_{i + 1}",
            x=round(arm * cos(radians(120 * i)), 15),
            y=round(arm * sin(radians(120 * i)), 15),
            radius=radius,
            steering_group="belt",
        )
        for i in range(3)
    )
    return Robot(name="synchro", wheels=wheels, body=_body(2.1 * arm, 2.1 * arm))


def swerve(
    positions: Sequence[tuple[float, float]] | None = None,
    radius: float = 0.05,
    wheelbase: float = 0.5,
    track: float = 0.5,
) -> Robot:
    """Modules that steer and drive, at the given (x, y) or at four corners.

    Source: Campion, Bastin and d'Andrea-Novel, 1996, type (1,2).
    """
    if positions is None:
        at = _corners(wheelbase, track)
    else:
        at = {f"module_{i + 1}": (x, y) for i, (x, y) in enumerate(positions)}
        wheelbase = 2 * max((abs(x) for x, _ in at.values()), default=1.0) or wheelbase
        track = 2 * max((abs(y) for _, y in at.values()), default=1.0) or track
    wheels = tuple(SteeredWheel(name=n, x=x, y=y, radius=radius) for n, (x, y) in at.items())
    return Robot(name="swerve", wheels=wheels, body=_body(wheelbase, track))


def omni_steer(radius: float = 0.05, wheelbase: float = 0.4, track: float = 0.3) -> Robot:
    """One steered and driven wheel in front, two driven omni wheels behind: type (2,1).

    Source: Siegwart and Nourbakhsh, 2004, section 3.3.3 and figure 3.14 ("omni-steer").
    """
    wheels: tuple[Wheel, ...] = (
        SteeredWheel(name="front", x=wheelbase / 2, y=0.0, radius=radius),
        OmniWheel(name="rear_left", x=-wheelbase / 2, y=track / 2, radius=radius),
        OmniWheel(name="rear_right", x=-wheelbase / 2, y=-track / 2, radius=radius),
    )
    return Robot(name="omni_steer", wheels=wheels, body=_body(wheelbase, track))


def skid_steer(
    radius: float = 0.1, wheelbase: float = 0.4, track: float = 0.5, track_factor: float = 1.0
) -> Robot:
    """Four fixed wheels that slip sideways to turn, with a factor on the track.

    ``track_factor`` is the effective over the geometric track, identified from data.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007.
    """
    wheels = tuple(
        FixedWheel(name=name, x=x, y=y, radius=radius, skid=True, track_factor=track_factor)
        for name, (x, y) in _corners(wheelbase, track).items()
    )
    return Robot(name="skid_steer", wheels=wheels, body=_body(wheelbase, track))


def mixed(radius: float = 0.05, wheelbase: float = 0.4, track: float = 0.3) -> Robot:
    """Two driven mecanum wheels in front, two casters and two dead wheels behind.

    The dead wheels are fixed wheels with encoders: they hold the rear against side slip.

    Source: made for this catalogue, to show that any mixture works.
    """
    half, side, dead = wheelbase / 2, track / 2, 0.6 * radius
    wheels: list[Wheel] = []
    for name, y, deg in (("front_left", side, -45), ("front_right", -side, 45)):
        wheels.append(MecanumWheel(name=name, x=half, y=y, radius=radius, roller=radians(deg)))
    for name, y in (("caster_left", side), ("caster_right", -side)):
        wheels.append(CasterWheel(name=name, x=-half, y=y, radius=dead, trail=0.8 * dead))
    encoder = Encoder(ticks_per_motor_turn=2048)
    for name, y in (("dead_left", 0.5 * side), ("dead_right", -0.5 * side)):
        wheels.append(
            FixedWheel(name=name, x=-half, y=y, radius=dead, driven=False, encoder=encoder)
        )
    return Robot(name="mixed", wheels=tuple(wheels), body=_body(wheelbase, track))


CATALOG: Catalog = {
    make.__name__: make
    for make in (
        differential, tricycle, bicycle, ackermann, rear_steered, four_wheel_steered,
        omni3, omni3_exercise, omni, omni4, mecanum, mecanum_lecture,
        two_steered, synchro, swerve, omni_steer, skid_steer, mixed,
    )
}  # fmt: skip


def from_catalog(name: str, **sizes: object) -> Robot:
    """Return a catalogue robot, with sizes changed by keyword.

    Raises:
        RobotError: the robot has no such size, or a value is impossible.

    >>> from_catalog("omni3", arm=0.5).driven[0].x
    0.5
    """
    make = CATALOG[name]
    known = inspect.signature(make).parameters
    if strangers := [size for size in sizes if size not in known]:
        raise RobotError(
            [
                f"no size {size!r}; it has {', '.join(known)}{did_you_mean(size, known)}"
                for size in strangers
            ],
            f"catalogue robot {name!r}",
        )
    faults = []
    for size, value in sizes.items():
        if size in _LISTS:
            faults += _list_faults(size, value)
        elif fault := Quantity(unit="").fault(value):
            faults.append(f"{size} {fault}")
    if faults:
        raise RobotError(faults, f"catalogue robot {name!r}")
    return make(**sizes)


# Sizes that are lists, and the shape of their items.
_LISTS = {"angles": (), "positions": (2,)}


def _list_faults(size: str, value: object) -> list[str]:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full((), np.nan)
    if array.ndim == 0 or array.shape[1:] != _LISTS[size] or not np.isfinite(array).all():
        what = "pairs (x, y)" if _LISTS[size] else "numbers"
        return [f"{size} must be a list of {what}, finite, got {value!r}"]
    return []
