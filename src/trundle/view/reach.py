"""The twists that a robot can have within its wheels' speed limits, as plane figures."""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trundle.kinematics import Kinematics
from trundle.robot import Robot
from trundle.se2 import Array

ASSUMED_SPEED = 10.0  # where no wheel has a max_speed [rad/s]

_COMPONENTS = ("u", "v", "r")
_PAIRS = ((0, 2), (0, 1), (1, 2))  # for flat sets of twists, the one preferred first
# Twists that are left by less than this share of their size are met.
_MET = 1e-6
_DIRECTIONS = 720
# Far beyond any limit, so that the answer ends at the limit.
_FAR = 1e3
# No wheel base is so short that a limited motor lets the rim of the robot run so many times faster
# than its wheels; such a motion has no limit, and its picture is cut nearer.
_ENDLESS, _CUT = 50.0, 3.0


@dataclass(frozen=True)
class Section:
    """One plane figure of reachable twists.

    Attributes:
        axes: the two components of the twist that are drawn: 0, 1, 2 for u, v, r.
        outline: (k, 2) its corners, in order; two of them where it is only a line.
        words: what holds for the third component, such as "r = 0" or "v = 0.2 r".
        unlimited: components that no motor limits; the outline is cut far out.
    """

    axes: tuple[int, int]
    outline: Array
    words: str
    unlimited: tuple[str, ...] = ()


def limited(robot: Robot) -> tuple[Robot, float | None]:
    """Return the robot with a limit on every motor, and the limit that was assumed, or None."""
    if all(wheel.max_speed is not None for wheel in robot.driven):
        return robot, None
    wheels = tuple(
        dataclasses.replace(wheel, max_speed=ASSUMED_SPEED)
        if wheel in robot.driven and getattr(wheel, "max_speed", None) is None
        else wheel
        for wheel in robot.wheels
    )
    return dataclasses.replace(robot, wheels=wheels), ASSUMED_SPEED


def sections_at(kinematics: Kinematics, steering: npt.ArrayLike | None = None) -> list[Section]:
    """Return the reachable twists at fixed steering angles (s,), exactly.

    The twists are those that the wheels give without slip, ``zeta`` in the range of W, with
    ``|R^-1 A zeta| <= max_speed`` for every driven wheel.

    Raises:
        OffCentreError: the angles share no instantaneous centre.
    """
    W = kinematics.wheel_matrix(steering)
    rolling, gains, _ = kinematics.constraints(steering)
    limits = np.array([wheel.max_speed for wheel in kinematics.robot.driven], dtype=np.float64)
    rates = rolling / gains[:, None] / limits[:, None]
    found = []
    for axes, lift, words in _planes(_span(W.T, kinematics.robot.reach)):
        corners = _line(rates @ lift) if lift.shape[1] == 1 else _polygon(rates @ lift)
        outline = corners @ lift[list(axes)].T
        found.append(Section(axes, outline, words))
    return found


def sections_over_steering(kinematics: Kinematics) -> list[Section]:
    """Return the twists reachable at some steering angles or others, by direction."""
    robot = kinematics.robot
    scale = np.array([1.0, 1.0, 1.0 / robot.reach])
    asked = np.array(list(itertools.product((-1.0, -0.4, 0.0, 0.7, 1.0), repeat=3))) * scale
    given = kinematics.inverse(_FAR * asked).twist
    found = []
    for axes, lift, words in _planes(_span(given, robot.reach)):
        if lift.shape[1] == 1:
            ends = np.array([[1.0], [-1.0]])
            outline = (ends * _distances(kinematics, ends @ lift.T)[:, None]) @ lift[list(axes)].T
            found.append(Section(axes, outline, words))
        else:
            rim, unlimited = _star(kinematics, lift, axes)
            found.append(Section(axes, rim, words, unlimited))
    return found


def _span(twists: Array, reach: float) -> Array:
    """Return a basis (3, k) of what twists (m, 3) span."""
    scaled = twists * (1.0, 1.0, reach)
    if not scaled.size:
        return np.zeros((3, 0))
    _, size, vectors = np.linalg.svd(scaled, full_matrices=False)
    kept = size > _MET * max(float(size[0]), 1e-300)
    basis = np.where(np.abs(vectors[kept]) > _MET, vectors[kept], 0.0)
    return np.asarray(basis.T / np.array([[1.0], [1.0], [reach]]))


def _planes(span: Array) -> list[tuple[tuple[int, int], Array, str]]:
    """Return the planes to draw: their axes, the map (3, 2) from these to twists, and words."""
    if span.shape[1] == 3:
        whole = np.eye(3)
        return [
            ((i, j), whole[:, [i, j]], f"{_COMPONENTS[3 - i - j]} = 0")
            for i, j in ((0, 1), (0, 2), (1, 2))
        ]
    if span.shape[1] == 2:
        size = np.abs(span).max(axis=1, keepdims=True)
        scaled = span / np.where(size > 0, size, 1.0)
        i, j = next(p for p in _PAIRS if abs(np.linalg.det(scaled[list(p)])) > _MET)
        lift = span @ np.linalg.inv(span[[i, j]])
        return [((i, j), lift, _dependence(3 - i - j, lift[3 - i - j], (i, j)))]
    if span.shape[1] == 1:
        order = np.argsort(-np.abs(span[:, 0]) + (1e-12, 2e-12, 0.0))
        i, j = sorted(int(each) for each in order[:2])
        return [((i, j), span, _ray_words(span[:, 0]))]
    return []


def _dependence(third: int, weights: Array, axes: tuple[int, int]) -> str:
    terms = [
        f"{weight:.3g} {_COMPONENTS[axis]}"
        for weight, axis in zip(weights, axes, strict=True)
        if abs(weight) > _MET
    ]
    return f"{_COMPONENTS[third]} = {' + '.join(terms) or '0'}".replace("+ -", "- ")


def _ray_words(ray: Array) -> str:
    lead = int(np.argmax(np.abs(ray) > _MET * np.abs(ray).max()))
    others = [k for k in range(3) if k != lead]
    return ", ".join(
        _dependence(k, np.array([ray[k] / ray[lead]]), (lead,))  # type: ignore[arg-type]
        for k in others
    )


def _line(rates: Array) -> Array:
    """Return the two ends (2, 1) of ``|rates z| <= 1`` on a line."""
    end = 1.0 / float(np.abs(rates).max())
    return np.array([[-end], [end]])


def _polygon(rates: Array) -> Array:
    """Return the corners (k, 2) of ``|rates z| <= 1``, counter-clockwise."""
    corners = []
    for first, second in itertools.combinations(rates, 2):
        pair = np.array([first, second])
        if abs(np.linalg.det(pair)) < _MET * float(np.linalg.norm(first) * np.linalg.norm(second)):
            continue
        for sides in itertools.product((1.0, -1.0), repeat=2):
            point = np.linalg.solve(pair, np.array(sides))
            if np.abs(rates @ point).max() <= 1.0 + _MET:
                corners.append(point)
    return _in_order(np.array(corners))


def _in_order(corners: Array) -> Array:
    """Return points of a convex rim counter-clockwise, each once."""
    size = np.abs(corners).max(axis=0)
    angle = np.arctan2(corners[:, 1] / size[1], corners[:, 0] / size[0])
    ordered = corners[np.argsort(angle)]
    away = np.abs(ordered - np.roll(ordered, 1, axis=0)) / size
    return np.asarray(ordered[away.max(axis=1) > 10 * _MET])


def _star(
    kinematics: Kinematics, lift: Array, axes: tuple[int, int]
) -> tuple[Array, tuple[str, ...]]:
    """Return the rim (k, 2) of the reachable twists in a plane, and components without a limit.

    Where a motion turns no driven wheel (a bicycle about its driven rear wheel), it has no end.
    """
    robot = kinematics.robot
    turn = np.linspace(0.0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    weight = np.array([1.0, 1.0, robot.reach])[list(axes)]
    nearly = np.array([(1.0, 1e-4), (1e-4, 1.0)])
    rough = np.vstack([circle[:: _DIRECTIONS // 72], nearly]) / weight
    size = np.abs(rough * _distances(kinematics, rough @ lift.T)[:, None]).max(axis=0)
    fastest = max(wheel.radius * (wheel.max_speed or 0.0) for wheel in robot.driven)
    far = size * weight > _ENDLESS * fastest
    size = np.where(far, _CUT * fastest / weight, np.where(size > 0, size, 1.0))
    rays = circle * size
    share = _distances(kinematics, rays @ lift.T)
    if not far.any():
        return np.asarray(rays * share[:, None]), ()
    longest = np.abs(circle[:, far]).max(axis=1)
    rim = rays * np.minimum(share, 1.0 / np.maximum(longest, 1e-9))[:, None]
    unlimited = tuple(_COMPONENTS[k] for k, endless in zip(axes, far, strict=True) if endless)
    # The motion that turns no driven wheel cannot be driven itself: a gap without width.
    return rim[share > 0], unlimited


def _distances(kinematics: Kinematics, rays: Array) -> Array:
    """Return how far (m,) along rays (m, 3) twists can be had, in lengths of the rays."""
    weight = np.array([1.0, 1.0, kinematics.robot.reach])
    asked = rays * weight
    given = kinematics.inverse(_FAR * rays).twist * weight
    share = (given * asked).sum(axis=1) / (asked**2).sum(axis=1)
    miss = np.abs(given - share[:, None] * asked).max(axis=1)
    met = (share > 0) & (miss <= _MET * np.maximum(np.abs(given).max(axis=1), 1e-300))
    return np.where(met, share, 0.0)
