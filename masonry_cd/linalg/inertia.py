"""The sign of a determinant, from the squares of a factorised matrix."""

from __future__ import annotations

from masonry_cd.jit import kernel
from masonry_cd.linalg.supernodes import view_supernode


@kernel()
def determinant_sign(factor):
    """Sign of the determinant of a factorised matrix, 1.0 or -1.0, from the inverses of its diagonal squares."""
    sign = 1.0
    for s in range(len(factor.symbolic.first) - 1):
        square, _, _ = view_supernode(factor, s)
        work = square.copy()
        width = len(work)
        for k in range(width):
            best = k
            for i in range(k + 1, width):
                if abs(work[i, k]) > abs(work[best, k]):
                    best = i
            if best != k:
                sign = -sign
                for j in range(k, width):
                    work[k, j], work[best, j] = work[best, j], work[k, j]
            if work[k, k] < 0.0:
                sign = -sign
            for i in range(k + 1, width):
                share = work[i, k] / work[k, k]
                for j in range(k + 1, width):
                    work[i, j] -= share * work[k, j]
    return sign
