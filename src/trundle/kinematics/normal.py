"""The pseudo-inverse of a small normal matrix H = M^T M, in straight lines.

The sums c_m of the squared m x m minors of M are the coefficients of H's characteristic polynomial
(Cauchy and Binet); computed so, they keep their digits where H is nearly singular. With adj the
adjugate, the inverse is

    adj(H) / c_3,      (c_1 I - H) / c_2,      I / c_1      for rank 3, 2 and 1,

for fewer than three unknowns likewise. The inverse of too low a rank is meant to be applied to what
lies in the row space of M, as b = M^T y does.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from trundle.kinematics.linear import RANK_TOLERANCE
from trundle.kinematics.straight import Code
from trundle.se2 import Array

Entries = dict[tuple[int, int], str]  # of a symmetric matrix, both halves

# Where the measured wheels alone see every motion at least this well beside the best seen, the
# normal equations lose at most six of sixteen digits, whatever the loose wheels' angles.
_WELL_SEEN = 1e-3
# Constant entries this small beside the largest are rounding.
_ROUNDING = 1e-14


def normal_inverse(
    code: Code, constant: Array, varying: Sequence[Sequence[str]], least: Sequence[float]
) -> Entries:
    """Return the names of the entries of H^+, for M with constant and varying rows.

    Over the octave below ``least`` the inverse of rank m fades into that of rank m - 1, and below
    it the latter stands: so nothing is divided by zero, and there is no branch.

    Args:
        code: where the lines go.
        constant: (p, k) rows of full rank p > 0.
        varying: names of the other rows' entries.
        least: c_m (m = 1 ... k) below which the rank is taken to be less than m; those up to p are
            not read, since the constant rows see to it. Empty where H is never nearly singular.
    """
    p, k = constant.shape
    rows = [*_literals(constant), *varying]
    H = _gram(code, rows, k)
    if not least:
        square = [[H[i, j] for j in range(k)] for i in range(k)]
        return _of_rank(code, H, k, k, _determinant(code, square))
    inverse = _of_rank(code, H, k, p, _squared_minors(code, rows, p))
    for m in range(p + 1, min(k, len(rows)) + 1):
        size = _squared_minors(code, rows, m)
        inverse = _faded(code, H, k, m, size, least[m - 1], inverse)
    return inverse


def _literals(matrix: Array) -> list[list[str]]:
    small = _ROUNDING * np.abs(matrix).max(initial=0.0)
    return [[repr(x) if abs(x) > small else "0.0" for x in row] for row in matrix.tolist()]


def _gram(code: Code, rows: Sequence[Sequence[str]], k: int) -> Entries:
    """Return M^T M."""
    out = {}
    for i, j in itertools.combinations_with_replacement(range(k), 2):
        out[i, j] = out[j, i] = code.sum(*(code.product(row[i], row[j]) for row in rows))
    return out


def _determinant(code: Code, square: Sequence[Sequence[str]]) -> str:
    """Return the determinant of a square matrix of names, by its first row."""
    first, *below = square
    if not below:
        return first[0]
    plus, minus = list[str](), list[str]()
    for j, entry in enumerate(first):
        if entry != "0.0":
            part = _determinant(code, [[*row[:j], *row[j + 1 :]] for row in below])
            (minus if j % 2 else plus).append(code.product(entry, part))
    return code.sum(*plus, minus=minus)


def _squared_minors(code: Code, rows: Sequence[Sequence[str]], m: int) -> str:
    """Return the sum c_m of the squared m x m minors."""
    squares = []
    for chosen in itertools.combinations(rows, m):
        for columns in itertools.combinations(range(len(rows[0])), m):
            minor = _determinant(code, [[row[j] for j in columns] for row in chosen])
            squares.append(code.product(minor, minor))
    return code.sum(*squares)


def _of_rank(code: Code, H: Entries, k: int, m: int, size: str) -> Entries:
    """Return the inverse for rank m, with c_m."""
    per = code.name(f"1.0 / {size}")
    out = {}
    for i, j in itertools.combinations_with_replacement(range(k), 2):
        if m == 1:
            entry = per if i == j else "0.0"
        elif m == k:
            entry = code.product(per, _cofactor(code, H, k, i, j))
        else:  # m = 2 of k = 3
            others = [H[n, n] for n in range(k) if n != i]
            entry = code.product(per, code.sum(*others) if i == j else code.sum(minus=[H[i, j]]))
        out[i, j] = out[j, i] = entry
    return out


def _cofactor(code: Code, H: Entries, k: int, i: int, j: int) -> str:
    rest = [[H[r, c] for c in range(k) if c != j] for r in range(k) if r != i]
    minor = _determinant(code, rest)
    return minor if (i + j) % 2 == 0 else code.sum(minus=[minor])


def _faded(
    code: Code, H: Entries, k: int, m: int, size: str, least: float, lower: Entries
) -> Entries:
    """Return the inverse of rank m, or the lower one where c_m is too small.

    ``max(x, 0) = (x + |x|) / 2`` and ``|x| = hypot(x, 0)``: what misses of ``least`` is added to
    c_m, so that it is never divided by less; where nothing misses, the inverse is exact.
    """
    above, missing = code.name(f"{size} - {least / 2!r}"), code.name(f"{least!r} - {size}")
    twice_above = code.name(f"{above} + hypot({above}, 0.0)")
    twice_missing = code.name(f"{missing} + hypot({missing}, 0.0)")
    share = code.name(f"{twice_above} / ({twice_above} + {twice_missing})")
    rest = code.name(f"{twice_missing} / ({twice_above} + {twice_missing})")
    full = _of_rank(code, H, k, m, code.name(f"{size} + 0.5 * {twice_missing}"))
    return {
        at: code.sum(code.product(share, full[at]), code.product(rest, lower[at])) for at in full
    }


def full_rank_rows(rows: Array, rank: int) -> Array:
    """Return (rank, k) rows with the same normal matrix."""
    normal = rows.T @ rows
    sizes = np.diag(normal)
    if np.abs(normal - np.diag(sizes)).max(initial=0.0) < _ROUNDING:
        return np.asarray(np.diag(np.sqrt(sizes))[np.argsort(-sizes, kind="stable")[:rank]])
    _, size, vectors = np.linalg.svd(rows)
    return np.asarray(size[:rank, None] * vectors[:rank])


def least_minors(constant: Array, turning: Array, basis: Array, here: Array) -> tuple[float, ...]:
    """Return c_1 to c_k below which a motion is as good as unseen; none where all are seen well.

    The array functions leave out singular values below a share of the largest, in the frame's
    coordinates. There c_k has a factor; and at the limit it is at most the square of that share
    times the k-th power of the trace.
    """
    k = basis.shape[1]
    frame_basis, _ = np.linalg.qr(np.linalg.solve(here, basis))
    factor = basis.T @ here @ frame_basis
    size = np.linalg.svd(constant @ basis @ factor, compute_uv=False)
    if k == 0 or (k == len(size) and size[-1] > _WELL_SEEN * size[0]):
        return ()
    share = RANK_TOLERANCE**2
    rows = np.concatenate([constant, turning]) @ basis
    lower = [share * float(np.sum(rows**2)) ** m for m in range(1, k)]
    there = float(np.sum((rows @ factor) ** 2))
    return (*lower, share * there**k / float(np.linalg.det(factor)) ** 2)
