"""How much memory there is, asked before much of it is taken."""

from __future__ import annotations

import os
from pathlib import Path

from trundle.errors import TrundleError


def available_memory() -> int | None:
    """Return how many bytes can be taken without swapping, or None if the system is silent."""
    found = [limit for limit in (_of_system(), _of_group()) if limit is not None]
    return min(found, default=None)


def _of_system() -> int | None:
    info = Path("/proc/meminfo")
    try:
        for line in info.read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (OSError, ValueError, AttributeError):
        return None


def _of_group() -> int | None:
    """Return what a container's limit leaves, on Linux."""
    group = Path("/sys/fs/cgroup")
    try:
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        used = (group / "memory.current").read_text(encoding="ascii").strip()
        return None if limit == "max" else max(int(limit) - int(used), 0)
    except (OSError, ValueError):
        return None


def ask_for(size: int, what: str, instead: str) -> None:
    """Refuse to take more memory than there is.

    Args:
        size: number of bytes.
        what: what they hold.
        instead: what the user can do.

    Raises:
        TrundleError: there is less; the message says how much is needed, and how much there is.
    """
    there = available_memory()
    if there is not None and size > there:
        raise TrundleError(
            f"{what} would take {in_words(size)} of memory, and {in_words(there)} are available: "
            f"{instead}"
        )


def in_words(size: int) -> str:
    """Return a number of bytes in words: '1.5 GB'."""
    for unit, factor in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= factor:
            return f"{size / factor:.1f} {unit}"
    return f"{size} bytes"
