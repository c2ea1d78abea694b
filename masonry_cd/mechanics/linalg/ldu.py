# SPDX-License-Identifier: GPL-3.0-or-later
"""A = L D U of an unsymmetric block matrix with a symmetric pattern, looking left, supernode by supernode (see symbolic.py)."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import kernel
from masonry_cd.mechanics.linalg.dense import gemm, invert_square
from masonry_cd.mechanics.linalg.supernodes import (
    end_inside,
    extent,
    load_blocks,
    load_diagonal,
    number_rows,
    subtract_product,
    view_panel,
    view_square,
)


@kernel()
def apply_update(factor, s, e, where, out):
    """Subtract from supernode s the products of an earlier one, the ``e``-th in the list of updates; ``out`` is room for a product."""
    symbolic, n = factor.symbolic, len(factor.size)
    d, t0, t1 = symbolic.updater[e], symbolic.update_first[e], end_inside(symbolic, e, symbolic.first[s + 1])
    square = view_square(symbolic, s, factor.squares, n)
    own_low, own_up = view_panel(symbolic, s, factor.panels, n), view_panel(symbolic, s, factor.others, n)
    low, up = view_panel(symbolic, d, factor.panels, n), view_panel(symbolic, d, factor.others, n)
    below, last, inner, length = symbolic.below, symbolic.start[d + 1], len(up), up.shape[1]
    first, rows = length - n * (last - t0), n * (t1 - t0)
    gemm(up, first, rows, inner, low, first, length, out)
    for j in range(t1 - t0):
        for i in range(t1 - t0):
            row, column = n * where[below[t0 + i]], n * where[below[t0 + j]]
            for q in range(n):
                for p in range(n):
                    square[row + p, column + q] -= out[j * n + q, i * n + p]
    subtract_product(out, rows, below, t0, t1 - t0, last, where, own_low, n)
    gemm(low, first, rows, inner, up, first + rows, length, out)
    subtract_product(out, 0, below, t0, t1 - t0, last, where, own_up, n)


@kernel()
def factorise_unsymmetric(factor, begin, stop):
    """A = L D U for supernodes begin to stop of a :class:`BlockFactor`, after all that update them; the sign of their part of det A."""
    symbolic, size = factor.symbolic, factor.size
    n = len(size)
    widest, longest = extent(symbolic, begin, stop, n)
    out, column, work = np.empty((widest, longest)), np.empty((n, widest)), np.empty((3, n, n))
    where, sign = np.empty(len(symbolic.column) - 1, dtype=np.int64), 1.0
    for s in range(begin, stop):
        number_rows(symbolic, s, where)
        square, low = view_square(symbolic, s, factor.squares, n), view_panel(symbolic, s, factor.panels, n)
        load_diagonal(symbolic, s, factor.diagonal, square, n)
        load_blocks(symbolic, s, where, factor.lower, square.T, low, n)
        load_blocks(symbolic, s, where, factor.upper, square, view_panel(symbolic, s, factor.others, n), n)
        for e in range(symbolic.update_start[s], symbolic.update_start[s + 1]):
            apply_update(factor, s, e, where, out)
        sign *= invert_square(square, column, out, work, size)
        if sign == 0.0:
            return sign
        width, length = low.shape
        gemm(square, 0, width, width, low, 0, length, out)
        for j in range(width):
            for i in range(length):
                low[j, i] = out[j, i]
    return sign
