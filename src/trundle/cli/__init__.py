"""The command ``trundle``."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command; exit 0 when done, 2 on the user's mistake, 1 on ours."""
    from trundle.cli.app import run

    sys.exit(run())


__all__ = ["main"]
