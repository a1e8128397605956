"""Null spaces and pseudo-inverses of stacks of 3-column matrices; ranks are decided here."""

from __future__ import annotations

import numpy as np

from trundle.se2 import Array

# A motion that is held or driven a billion times more weakly than the strongest is not held or
# driven: geometry in files has at most nine meaningful digits, and rounding lies at 1e-16.
RANK_TOLERANCE = 1e-9
# Every row has a unit direction, so 1 is also the scale where a projection leaves only rounding.
_SCALE = 1.0
# Steering angles come from sensors, from logs with six decimals and from degrees: angles that miss
# a common centre by a millionth of a radian share it.
ANGLE_TOLERANCE = 1e-6

_IDENTITY = np.eye(3)


def null_projector(
    rows: Array, tolerance: float = RANK_TOLERANCE, frame: Array = _IDENTITY
) -> tuple[Array, Array]:
    """Return the orthogonal projector onto the null space of rows (..., k, 3), and the rank.

    Args:
        rows: (..., k, 3) coefficients of (u, v, r).
        tolerance: singular values below this share of the largest count as zero.
        frame: (3, 3) map from well-scaled coordinates to twists, in which the rank is decided.

    Returns:
        P (..., 3, 3) = N N^T with N an orthonormal basis of the null space, and rank (...,).
    """
    batch = rows.shape[:-2]
    if rows.shape[-2] == 0:
        return np.broadcast_to(_IDENTITY, (*batch, 3, 3)).copy(), np.zeros(batch, dtype=int)
    _, size, vectors = np.linalg.svd(rows @ frame, full_matrices=True)
    held = np.zeros((*batch, 3), dtype=bool)
    held[..., : size.shape[-1]] = size > tolerance * np.maximum(size[..., :1], _SCALE)
    rank = held.sum(axis=-1)
    # The vectors of the null space come last; first here, QR makes them orthonormal, each to the
    # digits of its own length.
    span, _ = np.linalg.qr(frame @ np.swapaxes(vectors, -1, -2)[..., ::-1])
    kept = np.where(np.arange(3) < 3 - rank[..., None, None], span, 0.0)
    return kept @ np.swapaxes(kept, -1, -2), rank


def pseudo_inverse(matrix: Array, rank: Array | None = None) -> tuple[Array, Array]:
    """Return the Moore-Penrose inverse (..., 3, k) of (..., k, 3), and the rank (...,).

    A rank (...,) that is known is taken; without it singular values that are rounding are left out.
    """
    if matrix.shape[-2] == 0:
        return np.swapaxes(matrix, -1, -2).copy(), np.zeros(matrix.shape[:-2], dtype=int)
    left, size, right = np.linalg.svd(matrix, full_matrices=False)
    if rank is None:
        kept = size > RANK_TOLERANCE * np.maximum(size[..., :1], _SCALE)
    else:
        kept = np.arange(size.shape[-1]) < rank[..., None]
    inverse = np.where(kept, 1.0, 0.0) / np.where(kept, size, 1.0)
    made = np.swapaxes(right, -1, -2) @ (inverse[..., None] * np.swapaxes(left, -1, -2))
    return made, kept.sum(axis=-1)


def basis(projector: Array) -> Array:
    """Return an orthonormal basis (3, k) of the space that a projector (3, 3) projects onto."""
    values, vectors = np.linalg.eigh(projector)
    return vectors[:, values > 0.5]
