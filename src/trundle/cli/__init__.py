"""The command ``trundle``."""

from __future__ import annotations

import sys

_INTERRUPTED = 130  # as shells have it: 128 and SIGINT


def main() -> None:
    """Run the command; exit 0 when done, 2 on the user's mistake, 1 on ours, 130 on Ctrl-C."""
    try:
        from trundle.cli.app import run

        code = run()
    except KeyboardInterrupt:  # typer sees to it once it runs, not while all is being loaded
        code = _INTERRUPTED
    sys.exit(code)


__all__ = ["main"]
