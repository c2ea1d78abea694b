# SPDX-License-Identifier: GPL-3.0-or-later
"""A = L D U of an unsymmetric block matrix with a symmetric pattern, looking left, supernode by supernode, alone or by a team of threads.

See symbolic.py.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.linalg.dense import gemm, invert_square
from masonry_cd.mechanics.linalg.single_columns import UNSYMMETRIC, factorise_columns
from masonry_cd.mechanics.linalg.supernodes import (
    BlockMatrix,
    Factor,
    end_inside,
    extent,
    has_single_columns,
    load_blocks,
    load_diagonal,
    number_rows,
    subtract_product,
    view_supernode,
)
from masonry_cd.mechanics.linalg.threads import share_of, wait


@kernel()
def load(matrix, factor, s, where):
    """Blocks of A in the columns of supernode s into its square and its panels; ``where`` (N,) numbers their rows."""
    symbolic, n = factor.symbolic, len(factor.size)
    square, low, up = view_supernode(factor, s)
    load_diagonal(symbolic, s, matrix.diagonal, square, n)
    load_blocks(symbolic, s, where, matrix.lower, square.T, low, n)
    load_blocks(symbolic, s, where, matrix.upper, square, up, n)


@kernel()
def apply_update(factor, s, e, where, out):
    """Subtract from supernode s the products of an earlier one, the ``e``-th in the list of updates; ``out`` is room for a product."""
    symbolic, n = factor.symbolic, len(factor.size)
    d, t0, t1 = symbolic.updater[e], symbolic.update_first[e], end_inside(symbolic, e, symbolic.first[s + 1])
    square, own_low, own_up = view_supernode(factor, s)
    _, low, up = view_supernode(factor, d)
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


@entry()
def factorise_ldu(matrix: BlockMatrix, factor: Factor) -> float:
    """A = L D U: fill a :class:`Factor` from a :class:`BlockMatrix`; the sign of det A, 0 when a block of D cannot be inverted."""
    sign = 1.0
    for q in range(len(factor.symbolic.subtree) - 1):
        sign *= factorise_subtree(matrix, factor, q)
        if sign == 0.0:
            break
    return sign


@kernel()
def factorise_unsymmetric(matrix, factor, begin, stop):
    """:func:`factorise_ldu` for the supernodes from begin to stop, after all that update them; the sign of their part of det A."""
    symbolic, size = factor.symbolic, factor.size
    n = len(size)
    widest, longest = extent(symbolic, begin, stop, n)
    out, column, work = np.empty((widest, longest)), np.empty((n, widest)), np.empty((3, n, n))
    where, sign = np.empty(len(symbolic.column) - 1, dtype=np.int64), 1.0
    for s in range(begin, stop):
        number_rows(symbolic, s, where)
        load(matrix, factor, s, where)
        for e in range(symbolic.update_start[s], symbolic.update_start[s + 1]):
            apply_update(factor, s, e, where, out)
        square, low, _ = view_supernode(factor, s)
        sign *= invert_square(square, column, out, work, size)
        if sign == 0.0:
            return sign
        width, length = low.shape
        gemm(square, 0, width, width, low, 0, length, out)
        for j in range(width):
            for i in range(length):
                low[j, i] = out[j, i]
    return sign


@kernel()
def factorise_ldu_by_team(team, matrix, factor, signs):
    """:func:`factorise_ldu` by a team, level by level of the subtrees; ``signs`` (K,) has room for theirs, shared by the threads.

    Where all columns are single there is one subtree, and so one thread does it.
    """
    symbolic, sign = factor.symbolic, 1.0
    for level in range(len(symbolic.level) - 1):
        begin, end = symbolic.level[level], symbolic.level[level + 1]
        first, last = share_of(team, begin, end)
        for q in range(first, last):
            signs[q] = factorise_subtree(matrix, factor, q)
        wait(team)
        for q in range(begin, end):
            sign *= signs[q]
        if sign == 0.0:
            break
    return sign


@kernel()
def factorise_subtree(matrix, factor, q):
    """:func:`factorise_ldu` for the supernodes of subtree q, after all that update them; the sign of their part of det A."""
    symbolic = factor.symbolic
    if has_single_columns(symbolic):
        return factorise_columns(matrix, factor, UNSYMMETRIC)
    return factorise_unsymmetric(matrix, factor, symbolic.subtree[q], symbolic.subtree[q + 1])
