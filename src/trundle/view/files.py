"""Writing pictures to files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from matplotlib.figure import Figure

from trundle.errors import FileError

_PICTURES = (".png", ".svg", ".pdf")


def save(figure: Figure, path: str | Path) -> Path:
    """Write a figure as PNG, SVG or PDF, told by the file's ending, and return the path.

    Args:
        figure: what a ``plot_`` function returned.
        path: the file; its folder must exist.

    Raises:
        FileError: the ending is another one, or the file cannot be written.

    >>> from trundle import load
    >>> from trundle.view import plot_layout
    >>> save(plot_layout(load("omni3")), "omni3.bmp")
    Traceback (most recent call last):
    trundle.errors.FileError: omni3.bmp: a picture is saved as .png, .svg or .pdf
    """
    target = target_of(path, _PICTURES, "a picture")
    # No date, and names that do not change: the same picture gives the same file.
    metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(target.suffix.lower())
    try:
        figure.savefig(
            target, dpi=150 if target.suffix.lower() == ".png" else None, metadata=metadata
        )
    except OSError as error:
        raise unwritable(target, error) from None
    return target


def target_of(path: str | Path, endings: tuple[str, ...], what: str) -> Path:
    """Return a path to write to, once its ending and its folder are known to be right.

    Raises:
        FileError: the ending is not one of ``endings``, or there is no such folder.
    """
    target = Path(path)
    if target.suffix.lower() not in endings:
        told = ", ".join(endings[:-1]) + " or " + endings[-1]
        raise FileError(f"{target}: {what} is saved as {told}")
    if not target.parent.is_dir():
        raise FileError(f"{target}: there is no folder {target.parent}")
    return target


def unwritable(target: Path, error: OSError) -> FileError:
    """Return the error for a file that cannot be written."""
    return FileError(f"{target}: cannot be written: {error.strerror or error}")


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a path beside the target to write to; only a whole file takes the target's place.

    Raises:
        FileError: it cannot be written.
    """
    partial = target.with_name(f".{target.stem}.partial{target.suffix}")
    try:
        yield partial
        partial.replace(target)
    except OSError as error:
        raise unwritable(target, error) from None
    finally:
        partial.unlink(missing_ok=True)
