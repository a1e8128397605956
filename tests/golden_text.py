"""Golden files: generated text as it was when somebody last read it, in ``tests/golden``.

After a change that is meant, ``TRUNDLE_GOLDEN=write pytest tests/test_printing.py
tests/test_derive.py`` writes them anew; read the difference before it is committed.
"""

import os
from pathlib import Path

import pytest
import sympy

FOLDER = Path(__file__).parent / "golden"

# Another release of sympy may write the same thing otherwise.
SYMPY = "1.14"


def agrees_with_golden(name: str, text: str) -> None:
    """Compare text with the golden file of that name, or write it where that is asked for."""
    path = FOLDER / name
    if os.environ.get("TRUNDLE_GOLDEN") == "write":
        FOLDER.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
        return
    if not sympy.__version__.startswith(SYMPY):
        pytest.skip(f"the golden files were written with sympy {SYMPY}, not {sympy.__version__}")
    assert text == path.read_text(encoding="utf-8"), f"golden/{name} differs: see golden_text.py"
