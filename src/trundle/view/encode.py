"""Writing frames to GIF and MP4 files."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from trundle.errors import FileError
from trundle.view.files import replacing

_COLOURS = 96
_NEARLY_WHITE = 250


def write_gif(
    target: Path, frames: Iterator[Image.Image], delay: float, sample: Image.Image
) -> None:
    """Write a GIF that repeats for ever, with a delay [s] after each frame.

    All frames share the palette of ``sample``: only what changes between frames is stored.

    Raises:
        FileError: the file cannot be written.
    """
    palette = sample.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT)
    # Mean colours are not quite those drawn: the ground at least is to stay white.
    entries = palette.getpalette() or []
    palette.putpalette([255 if each >= _NEARLY_WHITE else each for each in entries])
    indexed = (f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames)
    with replacing(target) as partial, partial.open("wb") as file:
        next(indexed).save(
            file, format="GIF", save_all=True, append_images=indexed, optimize=False,
            duration=round(1000 * delay), loop=0, disposal=1,
        )  # fmt: skip


def write_mp4(target: Path, frames: Iterator[Image.Image], delay: float) -> None:
    """Write an MP4 that browsers play, by ffmpeg, with a delay [s] after each frame.

    Raises:
        FileError: there is no ffmpeg, or it fails.
    """
    program = shutil.which("ffmpeg")
    if program is None:
        raise FileError(
            f"{target}: MP4 needs the program ffmpeg, which is not installed; "
            "install it (https://ffmpeg.org), or write a .gif"
        )
    with replacing(target) as partial:
        _run_ffmpeg(program, frames, delay, target, partial)


def _run_ffmpeg(
    program: str, frames: Iterator[Image.Image], delay: float, target: Path, partial: Path
) -> None:
    first = next(frames)
    command = [
        program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{first.width}x{first.height}", "-r", f"{1 / delay:.6g}", "-i", "-",
        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", str(partial.resolve()),
    ]  # fmt: skip
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        try:
            process.stdin.write(first.tobytes())
            for frame in frames:
                process.stdin.write(frame.tobytes())
            process.stdin.close()
        except BrokenPipeError:
            pass  # ffmpeg has given up, and says why
        told = process.stderr.read().decode(errors="replace").strip()
    if process.returncode:
        reason = told.splitlines()[-1] if told else f"ffmpeg ended with {process.returncode}"
        raise FileError(f"{target}: cannot be written: {reason}")
