"""Leading axes that must broadcast."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from trundle.errors import ShapeError
from trundle.se2 import Array


def together(arrays: Mapping[str, Array]) -> tuple[int, ...]:
    """Return the batch shape that arrays (..., k) have together.

    Raises:
        ShapeError: their leading axes do not broadcast.
    """
    try:
        return np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()))
    except ValueError:
        told = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise ShapeError(f"these shapes do not go together: {told}") from None
