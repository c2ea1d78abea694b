"""Small dense blocks, one per body or contact, and plain copies.

``size_n`` (or ``size_m``) is a tuple of as many zeros as a block has rows, see :func:`size_tuple`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.jit import borrower, entry, kernel

EPSILON = 2.2e-16  # relative rounding error of a float
NARROW = 12  # unknowns of a rigid block, or of one of uniform strain, at the most: loops over so many are unrolled
STEP = 4  # rows or columns of wider blocks that kernels take at a time
FULL = np.zeros(0, dtype=np.int64)  # width of blocks that use all their rows


def size_tuple(n: int) -> tuple[int, ...]:
    """n zeros. The length of a tuple is part of its type, so the compiler knows how many rows a block has, and unrolls the loops over them.

    Such tuples are fields of problems and factors.
    """
    return (0,) * n


def size_of_blocks(n: int) -> Any:
    """What has n for its length: a tuple as :func:`size_tuple` makes it, or an array where blocks are wide, with one kernel for all n."""
    return np.zeros(n) if n > NARROW and n % STEP == 0 else size_tuple(n)


def room_for(count: int) -> int:
    """Rows of wide blocks that have room for so many: more than NARROW, in steps of STEP."""
    return max(-(-count // STEP) * STEP, NARROW + STEP)


@kernel(inline="always")
def is_wide(size):
    """Whether blocks have many rows: not all nodes need have all then, and loops go four at a time. Known when kernels are compiled."""
    return len(size) > NARROW and len(size) % STEP == 0


@borrower()
def copy_flat(source, target):
    """The first entries of target = source, both contiguous, of one shape but for the first length.

    Assigned to a slice, arrays are asked for overlaps and lengths first, which takes longer to compile than many a kernel.
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
def invert(a, out, work, size_n):
    """Inverse of an (n, n) block by Gauss-Jordan with row pivoting; the sign of its determinant, or 0 if it is singular or not finite."""
    n, sign = len(size_n), 1.0
    for i in range(n):
        for j in range(n):
            work[i, j] = a[i, j]
            out[i, j] = 1.0 if i == j else 0.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(work[i, k]) > abs(work[best, k]):
                best = i
        if not (0.0 < abs(work[best, k]) < np.inf):
            return 0.0
        if (work[best, k] < 0.0) != (best != k):
            sign = -sign
        if best != k:
            for j in range(n):
                work[k, j], work[best, j] = work[best, j], work[k, j]
                out[k, j], out[best, j] = out[best, j], out[k, j]
        scale = 1.0 / work[k, k]
        for j in range(n):
            work[k, j] *= scale
            out[k, j] *= scale
        for i in range(n):
            factor = work[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    work[i, j] -= factor * work[k, j]
                    out[i, j] -= factor * out[k, j]
    return sign


@borrower(fastmath={"contract"})
def multiply(a, b, transposed, out, size_n):
    """out = a b, or a b^T."""
    n = len(size_n)
    for p in range(n):
        for q in range(n):
            total = 0.0
            for r in range(n):
                total += a[p, r] * (b[q, r] if transposed else b[r, q])
            out[p, q] = total


@entry()
def inverses(blocks, size_n):
    """Inverses of blocks (N, n, n) that are regular."""
    out, work = np.empty(blocks.shape), np.empty(blocks.shape[1:])
    for b in range(len(blocks)):
        invert(blocks[b], out[b], work, size_n)
    return out


@kernel()
def identities(count, size_m):
    """Unit blocks (count, m, m)."""
    out = np.zeros((count, len(size_m), len(size_m)))
    for c in range(count):
        for i in range(len(size_m)):
            out[c, i, i] = 1.0
    return out
