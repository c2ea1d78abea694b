"""The sign of a determinant, from the squares of a factorised matrix."""

from __future__ import annotations

from masonry_cd.jit import kernel
from masonry_cd.linalg.supernodes import view_block


@kernel()
def determinant_sign(plan, squares, size_n):
    """Sign of the determinant of a factorised matrix, from the inverses of its diagonal squares."""
    sign = 1.0
    for s in range(len(plan.first) - 1):
        width = len(size_n) * (plan.first[s + 1] - plan.first[s])
        work = view_block(squares, plan.square[s], width, width, len(size_n)).copy()
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
                factor = work[i, k] / work[k, k]
                for j in range(k + 1, width):
                    work[i, j] -= factor * work[k, j]
    return sign
