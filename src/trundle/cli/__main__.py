"""``python -m trundle.cli``."""

from trundle.cli import main

main()
