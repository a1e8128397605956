"""Animations: the robot on its way, its wheels turning, steering and swivelling."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from PIL import Image

from trundle.errors import TrundleError
from trundle.robot import Robot, SwedishWheel
from trundle.se2 import Array
from trundle.simulation import Run
from trundle.view.along import draw_desired, steps_in_view
from trundle.view.drawing import Shape, place, repaint, robot_shapes
from trundle.view.encode import write_gif, write_mp4
from trundle.view.files import target_of
from trundle.view.motion import Motion, at_times
from trundle.view.pace import pace
from trundle.view.style import (
    BLUE,
    FAINT,
    INK,
    LABEL,
    MUTED,
    ORANGE,
    SMALL,
    fit,
    new_figure,
    put_title,
    style_axes,
)

_GIF_TICK = 0.01  # GIF counts in hundredths of a second
# A robot that is smaller than this share of the picture gets a close-up beside it.
_SMALL = 0.2
_TRAIL_POINTS = 1500

Progress = Callable[[int, int], None]


def animate(
    robot: Robot,
    run: Run,
    path: str | Path,
    fps: float = 20,
    seconds: float | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write an animation of a run, as GIF or, with ffmpeg, as MP4; return the path.

    Wheels turn as seen from above: the tops of wheels that roll forward move forward. Steered
    wheels steer and casters swivel. A robot that is small beside its path gets a close-up.

    Args:
        robot: the robot of the run.
        run: the run.
        path: the file, ending in ``.gif`` or ``.mp4``; its folder must exist.
        fps: frames per second; a GIF's delays are multiples of 0.01 s.
        seconds: length of the animation [s]; by default that of the run, but from 2.5 s to 15 s
            and in no more than 150 frames. It says how much faster or slower time passes.
        progress: called with the frames done and the number of all frames.

    Raises:
        FileError: another ending, no such folder, no ffmpeg, or the file cannot be written.
        TrundleError: fps or seconds is not positive, or the run is of another robot.

    >>> from trundle import load, simulate
    >>> robot = load("omni3")
    >>> animate(robot, simulate(robot, wheel_speeds=[1, 1, 1], duration=1), "spin.avi")
    Traceback (most recent call last):
    trundle.errors.FileError: spin.avi: an animation is saved as .gif or .mp4
    """
    target = target_of(path, (".gif", ".mp4"), "an animation")
    for name, value in (("fps", fps), ("seconds", 1.0 if seconds is None else seconds)):
        if not (math.isfinite(value) and value > 0):
            raise TrundleError(f"{name} must be positive, got {value!r}")
    is_gif = target.suffix.lower() == ".gif"
    chosen = pace(run, fps, seconds, _GIF_TICK if is_gif else 0.0)
    stage = Stage(robot, run, at_times(robot, run, chosen.times), chosen.speed)
    frames = _counted(stage.frames(), len(chosen.times), progress)
    if is_gif:
        write_gif(target, frames, chosen.delay, stage.sample())
    else:
        write_mp4(target, frames, chosen.delay)
    return target


def _counted(
    frames: Iterator[Image.Image], count: int, progress: Progress | None
) -> Iterator[Image.Image]:
    for done, frame in enumerate(frames, start=1):
        yield frame
        if progress is not None:
            progress(done, count)


class Stage:
    """The figure of an animation: what stands still is drawn once, the rest for every frame."""

    def __init__(self, robot: Robot, run: Run, motion: Motion, speed: float) -> None:
        self.motion = motion
        self._shapes = [robot_shapes(robot, s, "top", marked=True) for s in motion.stances]
        self.figure = new_figure(8.0, 5.6)
        seen = steps_in_view(robot, run)
        put_title(self.figure, robot.name, _notes(robot, run, speed, seen))
        bounds = _bounds(run, self._shapes[0], seen)
        self.closeup = _reach(self._shapes[0]) < _SMALL * float(np.ptp(bounds, axis=0).max())
        self.axes = self.figure.add_axes((0.115, 0.12, 0.425 if self.closeup else 0.855, 0.705))
        style_axes(self.axes, "x [m]", "y [m]")
        fit(self.axes, *bounds)
        skip = max(len(run.t) // _TRAIL_POINTS, 1)
        self._way = np.column_stack([run.t, run.pose[:, :2]])[::skip]
        self.trail = Line2D([], [], color=BLUE, linewidth=2.0, zorder=1.5, animated=True)
        self.axes.add_line(self.trail)
        self._wanted, self.ring = self._desired(run)
        self.robot = _moving(self.axes)
        self.near = _moving(_closeup(self.figure, self._shapes[0])) if self.closeup else None
        self.clock = self._clock()

    def _desired(self, run: Run) -> tuple[Array, Line2D | None]:
        """Draw the trajectory, and return where on it (F, 2) the robot should be, and a ring."""
        if run.desired is None:
            return np.empty((0, 2)), None
        self.axes.autoscale(False)
        draw_desired(self.axes, run.desired)
        ring = Line2D(
            [], [], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=ORANGE,
            markeredgewidth=2.2, linestyle="", zorder=4, animated=True,
        )  # fmt: skip
        self.axes.add_line(ring)
        t = self.motion.t
        return np.column_stack([np.interp(t, run.t, run.desired[:, i]) for i in (0, 1)]), ring

    def _clock(self) -> Text:
        return self.figure.text(
            0.97, 0.962, "", fontsize=LABEL, color=INK, ha="right", va="top", animated=True
        )

    def frames(self, which: Iterable[int] | None = None) -> Iterator[Image.Image]:
        """Yield frames as pictures, all of them or those with the numbers given."""
        canvas: Any = self.figure.canvas  # matplotlib gives its methods no types
        canvas.draw()
        still = canvas.copy_from_bbox(self.figure.bbox)
        for k in range(len(self.motion.t)) if which is None else which:
            canvas.restore_region(still)
            for artist in self.show(k):
                where = artist.axes if isinstance(artist.axes, Axes) else self.figure
                where.draw_artist(artist)
            yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")

    def show(self, k: int) -> list[Artist]:
        """Move everything that moves to frame k, and return it."""
        t, pose = float(self.motion.t[k]), self.motion.pose[k]
        gone = self._way[self._way[:, 0] <= t, 1:]
        self.trail.set_data(*np.vstack([gone, pose[:2]]).T)
        repaint(self.robot, self._shapes[k], pose)
        self.clock.set_text(f"t = {t:.1f} s")
        moving: list[Artist] = [self.trail, self.robot]
        if self.ring is not None:
            self.ring.set_data(*self._wanted[[k]].T)
            moving.append(self.ring)
        if self.near is not None:
            repaint(self.near, self._shapes[k], (0.0, 0.0, 0.0))
            moving.append(self.near)
        return [*moving, self.clock]

    def sample(self) -> Image.Image:
        """Return a picture that holds all colours of the film."""
        frames = list(self.frames([0, len(self.motion.t) // 2, -1]))
        whole = Image.new("RGB", (frames[0].width, sum(each.height for each in frames)))
        for k, each in enumerate(frames):
            whole.paste(each, (0, k * each.height))
        return whole


def _moving(axes: Axes) -> PolyCollection:
    artist = PolyCollection([], zorder=2, animated=True)
    axes.add_collection(artist, autolim=False)
    return artist


def _notes(robot: Robot, run: Run, speed: float, seen: int) -> list[str]:
    notes = []
    if not math.isclose(speed, 1.0, rel_tol=0.02):
        times = f"{speed:.2g} times faster" if speed > 1 else f"{1 / speed:.2g} times slower"
        notes.append(f"{times} than real")
    swedish = any(isinstance(wheel, SwedishWheel) for wheel in robot.wheels)
    notes.append("seen from above" + (", the tops of the rollers" if swedish else ""))
    notes.append("yellow: one mark on each wheel")
    if run.desired is not None:
        notes.append("dashed: desired, ring: where to be")
    if seen < len(run.t):
        notes.append(f"lost at t = {run.t[seen]:.4g} s")
    return notes


def _reach(shapes: list[Shape]) -> float:
    points = np.vstack([each.points for each in shapes])
    return float(np.ptp(points, axis=0).max())


def _bounds(run: Run, shapes: list[Shape], seen: int) -> tuple[Array, Array]:
    """Return the corners of a box that the robot does not leave until it is lost."""
    points = np.vstack([each.points for each in shapes if each.part in ("body", "wheel")])
    poses = run.pose[:seen]
    poses = np.vstack([poses[:: max(seen // 400, 1)], poses[-1:]])
    swept = np.vstack([place(points, pose) for pose in poses])
    if run.desired is not None:
        swept = np.vstack([swept, run.desired[:, :2]])
    return swept.min(axis=0), swept.max(axis=0)


def _closeup(figure: Figure, shapes: list[Shape]) -> Axes:
    """Return axes beside the path in which the robot stands still and its wheels move."""
    axes = figure.add_axes((0.58, 0.2, 0.395, 0.565))
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color(FAINT)
    axes.set_title("close-up, moving with the body", fontsize=SMALL, color=MUTED)
    points = np.vstack([each.points for each in shapes])
    fit(axes, *(points.min(axis=0), points.max(axis=0)), margin=0.12)
    return axes
