"""A = L D U of an unsymmetric block matrix with a symmetric pattern, looking left, supernode by supernode (see symbolic.py)."""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.dense import gemm, invert_square
from masonry_cd.linalg.single_columns import UNSYMMETRIC, factorise_columns
from masonry_cd.linalg.supernodes import end_inside, extent, has_single_columns, number_rows, subtract_product, view_block


@kernel()
def load_blocks(plan, s, where, diagonal, lower, upper, square, low, up, size_n):
    """Blocks of A of the run s into its square and its panels."""
    n, begin, end = len(size_n), plan.first[s], plan.first[s + 1]
    square[:] = 0.0
    up[:] = 0.0
    low[:] = 0.0
    for j in range(begin, end):
        k = (j - begin) * n
        for p in range(n):
            for q in range(n):
                square[k + p, k + q] = diagonal[j, p, q]
        for t in range(plan.column[j], plan.column[j + 1]):
            i = where[plan.row[t]] * n
            for p in range(n):
                for q in range(n):
                    if plan.row[t] < end:
                        square[i + p, k + q], square[k + q, i + p] = lower[t, p, q], upper[t, p, q]
                    else:
                        low[k + q, i + p], up[k + q, i + p] = lower[t, p, q], upper[t, p, q]


@kernel()
def apply_update(plan, d, t0, t1, where, low, up, square, own_low, own_up, out, size_n):
    """Take from a run what the earlier run d leaves to it; ``low`` and ``up`` are the panels of d, t0 to t1 its rows in the run."""
    n, last, inner, length = len(size_n), plan.start[d + 1], len(up), up.shape[1]
    first, rows = length - n * (last - t0), n * (t1 - t0)
    gemm(up, first, rows, inner, low, first, length, out)
    for j in range(t1 - t0):
        for i in range(t1 - t0):
            row, column = n * where[plan.below[t0 + i]], n * where[plan.below[t0 + j]]
            for q in range(n):
                for p in range(n):
                    square[row + p, column + q] -= out[j * n + q, i * n + p]
    subtract_product(out, rows, plan.below, t0, t1 - t0, last, where, own_low, n)
    gemm(low, first, rows, inner, up, first + rows, length, out)
    subtract_product(out, 0, plan.below, t0, t1 - t0, last, where, own_up, n)


@entry()
def factorise_ldu(plan, diagonal, lower, upper, inverse, low, up, size_n):
    """A = L D U: inverse (squares of D^-1), low (panels of L) and up (panels of D U) from diagonal blocks A_jj, lower A_ij, upper A_ji^T.

    Returns False when a diagonal block cannot be inverted.
    """
    if has_single_columns(plan):
        return factorise_columns(plan, diagonal, lower, upper, inverse, low, up, UNSYMMETRIC, size_n)
    n, size, count = len(size_n), len(plan.column) - 1, len(plan.first) - 1
    widest, longest = extent(plan, 0, count, n)
    out, column, work = np.empty((widest, longest)), np.empty((n, widest)), np.empty((3, n, n))
    where = np.empty(size, dtype=np.int64)
    for s in range(count):
        number_rows(plan, s, where)
        width, length = n * (plan.first[s + 1] - plan.first[s]), n * (plan.start[s + 1] - plan.start[s])
        square = view_block(inverse, plan.square[s], width, width, n)
        own_low, own_up = view_block(low, plan.panel[s], width, length, n), view_block(up, plan.panel[s], width, length, n)
        load_blocks(plan, s, where, diagonal, lower, upper, square, own_low, own_up, size_n)
        for e in range(plan.update_start[s], plan.update_start[s + 1]):
            d = plan.updater[e]
            rows, columns = n * (plan.first[d + 1] - plan.first[d]), n * (plan.start[d + 1] - plan.start[d])
            its_low, its_up = view_block(low, plan.panel[d], rows, columns, n), view_block(up, plan.panel[d], rows, columns, n)
            t1 = end_inside(plan, e, plan.first[s + 1])
            apply_update(plan, d, plan.update_first[e], t1, where, its_low, its_up, square, own_low, own_up, out, size_n)
        if not invert_square(square, column, out, work, size_n):
            return False
        gemm(square, 0, width, width, own_low, 0, length, out)
        for j in range(width):
            for i in range(length):
                own_low[j, i] = out[j, i]
    return True
