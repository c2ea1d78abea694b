# SPDX-License-Identifier: GPL-3.0-or-later
"""Small dense blocks, one per body or contact, and plain copies.

``size_n`` (or ``size_m``) has as many entries as a block has rows: a tuple of zeros, see :func:`size_tuple`, or an array
where one kernel serves all numbers.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.linalg.intrinsics import is_tuple
from masonry_cd.mechanics.linalg.vectors import add_six_times, add_times, fill_four, fill_six, load_four, load_six, store_lanes, store_six

EPSILON = 2.2e-16  # relative rounding error of a float
STEP = 4  # rows or columns of wider blocks that kernels take at a time
FULL = np.zeros(0, dtype=np.int64)  # width of blocks that use all their rows


def size_tuple(n: int) -> tuple[int, ...]:
    """n zeros. The length of a tuple is part of its type, so the compiler knows how many rows a block has, and unrolls the loops over them.

    Such tuples are fields of problems and factors.
    """
    return (0,) * n


def room_for(count: int) -> int:
    """Rows of wide blocks with room for ``count``, in steps of STEP."""
    return max(-(-count // STEP), 1) * STEP


@borrower(forceinline=True)
def is_wide(size):
    """Return True if blocks may have many rows: then not all nodes need have all, and loops go four at a time. A tuple is narrow."""
    return not is_tuple(size) and len(size) % STEP == 0


@borrower()
def copy_flat(source, target):
    """The first entries of target = source, both contiguous, of one shape but for the first length.

    Assigned to a slice, arrays are checked for overlaps and lengths first, which takes longer to compile than many a kernel.
    """
    a, b = source.reshape(source.size), target.reshape(target.size)
    for i in range(len(a)):
        b[i] = a[i]


@borrower()
def cholesky_small(a: np.ndarray, factor: np.ndarray, n: int) -> None:
    """Lower Cholesky factor of a symmetric (n, n) block, written into factor."""
    for i in range(n):
        for j in range(i + 1):
            total = 0.5 * (a[i, j] + a[j, i])
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i == j:
                factor[i, i] = np.sqrt(max(total, 0.0))
            else:
                factor[i, j] = total / factor[j, j] if factor[j, j] > 0.0 else 0.0
        for j in range(i + 1, n):
            factor[i, j] = 0.0


@borrower()
def invert(a, width, out, work, size_n):
    """Inverse of an (n, n) block, or of its first ``width`` rows if it is wide, by Gauss and Jordan in place, with row pivoting.

    Returns the sign of its determinant, or 0 if it is singular or not finite. ``work`` (2 or more, n) is scratch.
    """
    n, sign, factors, pivots = width if is_wide(size_n) else len(size_n), 1.0, work[0], work[1]
    for i in range(n):
        for j in range(n):
            out[i, j] = a[i, j]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(out[i, k]) > abs(out[best, k]):
                best = i
        pivot = out[best, k]
        if not (0.0 < abs(pivot) < np.inf):
            return 0.0
        if (pivot < 0.0) != (best != k):
            sign = -sign
        pivots[k] = best
        if best != k:
            for j in range(n):
                out[k, j], out[best, j] = out[best, j], out[k, j]
        for i in range(n):
            factors[i], out[i, k] = out[i, k], 0.0
        factors[k], out[k, k] = 0.0, 1.0
        _take_off_row(out, k, 1.0 / pivot, factors, n, size_n)
    for k in range(n - 1, -1, -1):
        best = int(pivots[k])
        if best != k:
            for i in range(n):
                out[i, k], out[i, best] = out[i, best], out[i, k]
    return sign


@borrower(forceinline=True)
def _take_off_row(a, k, scale, factors, n, size_n):
    """Scale row k of a block (n, n), and take it off all rows, some times each. Six of its entries, or STEP, are held in registers."""
    if is_wide(size_n):
        for t in range(0, n, STEP):
            four = add_times(fill_four(0.0), scale, load_four(a, k, t))
            store_lanes(a, k, t, four)
            for i in range(n):
                store_lanes(a, i, t, add_times(load_four(a, i, t), -factors[i], four))
    elif n == 6:
        line = add_six_times(fill_six(0.0), scale, load_six(a, k, 0))
        store_six(a, k, 0, line)
        for i in range(6):
            if factors[i] != 0.0:  # what turns does not couple with what shifts
                store_six(a, i, 0, add_six_times(load_six(a, i, 0), -factors[i], line))
    else:
        for j in range(n):
            x = a[k, j] * scale
            a[k, j] = x
            for i in range(n):
                a[i, j] -= factors[i] * x


@borrower(fastmath={"contract", "reassoc"})
def dot(x, y, length):
    """x . y of a given number of entries."""
    total = 0.0
    for k in range(length):
        total += x[k] * y[k]
    return total


@borrower(fastmath={"contract"})
def multiply(a, b, out, size_n):
    """out = a b. For n = 6 a row is held in registers."""
    n = len(size_n)
    if n == 6:
        for p in range(6):
            total = fill_six(0.0)
            for r in range(6):
                total = add_six_times(total, a[p, r], load_six(b, r, 0))
            store_six(out, p, 0, total)
        return
    for p in range(n):
        for q in range(n):
            total = 0.0
            for r in range(n):
                total += a[p, r] * b[r, q]
            out[p, q] = total


@borrower(fastmath={"contract"})
def add_outer_product(x, y, out, size_m, size_n):
    """out (n, n) += x^T y of x and y (m, n)."""
    m, n = len(size_m), len(size_n)
    for p in range(n):
        for q in range(n):
            total = 0.0
            for i in range(m):
                total += x[i, p] * y[i, q]
            out[p, q] += total


@entry()
def inverses(blocks, size_n):
    """Inverses of blocks (N, n, n) that are regular."""
    out, work = np.empty(blocks.shape), np.empty(blocks.shape[1:])
    for b in range(len(blocks)):
        invert(blocks[b], len(size_n), out[b], work, size_n)
    return out
