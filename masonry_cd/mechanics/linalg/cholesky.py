# SPDX-License-Identifier: GPL-3.0-or-later
"""A = L D L^T of a symmetric block matrix, looking left, supernode by supernode (see symbolic.py)."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import kernel
from masonry_cd.mechanics.linalg.dense import gemm, inverse_cholesky
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
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
def apply_symmetric_update(symbolic, d, rows_inside, where, panel, square, own, out, n):
    """Subtract from a supernode, the upper triangle of its ``square`` and its panel ``own``, what the earlier supernode d contributes.

    ``panel`` is that of d, ``rows_inside`` the first and the end of its rows in the supernode.
    """
    (t0, t1), last, inner, length = rows_inside, symbolic.start[d + 1], len(panel), panel.shape[1]
    first, rows = length - n * (last - t0), n * (t1 - t0)
    gemm(panel, first, rows, inner, panel, first, length, out)
    for j in range(t1 - t0):
        row = n * where[symbolic.below[t0 + j]]
        for i in range(j, t1 - t0):
            column = n * where[symbolic.below[t0 + i]]
            for q in range(n):
                for p in range(n):
                    square[row + q, column + p] -= out[j * n + q, i * n + p]
    subtract_product(out, rows, symbolic.below, t0, t1 - t0, last, where, own, n)


@kernel()
def factorise_symmetric(factor, first, last):
    """A = L L^T of a symmetric A for supernodes first to last of a :class:`BlockFactor`, after all that update them.

    Squares: C^-T of the triangles C on the diagonal of L; panels: L^T right of them; in the precision of their arrays. Only the square at
    work is always in double precision. Returns 1, or 0 where A is not positive definite.
    """
    symbolic, n, panels = factor.symbolic, len(factor.size), factor.panels
    size = len(symbolic.column) - 1
    widest, longest = extent(symbolic, first, last, n)
    out, where = np.empty((widest, longest), dtype=panels.dtype), np.empty(size, dtype=np.int64)
    square_at_work, root_at_work = np.empty(widest * widest), np.empty(widest * widest)
    for s in range(first, last):
        number_rows(symbolic, s, where)
        kept, panel = view_square(symbolic, s, factor.squares, n), view_panel(symbolic, s, panels, n)
        width, length = panel.shape
        square, root = square_at_work[: width * width].reshape((width, width)), root_at_work[: width * width].reshape((width, width))
        load_diagonal(symbolic, s, factor.diagonal, square, n)
        load_blocks(symbolic, s, where, factor.lower, square, panel, n)
        for e in range(symbolic.update_start[s], symbolic.update_start[s + 1]):
            d, inside = symbolic.updater[e], (symbolic.update_first[e], end_inside(symbolic, e, symbolic.first[s + 1]))
            apply_symmetric_update(symbolic, d, inside, where, view_panel(symbolic, d, panels, n), square, panel, out, n)
        if not inverse_cholesky(square, root):
            return 0.0
        copy_flat(root, kept)
        for j in range(width - 1 - (width - 1) % 3, -1, -3):  # from below, where a row needs all above it and none needs it
            rows = min(3, width - j)
            gemm(kept, j, rows, j + rows, panel, 0, length, out)
            for k in range(rows):
                for i in range(length):
                    panel[j + k, i] = out[k, i]
    return 1.0


@kernel()
def to_unit_diagonal(factor, first, last):
    """From the factors of :func:`factorise_symmetric` to A = L D L^T with ones on the diagonal of L: squares of D^-1 and panels of L.

    A solve then reads the squares once, not twice.
    """
    symbolic, n, panels = factor.symbolic, len(factor.size), factor.panels
    widest, longest = extent(symbolic, first, last, n)
    out, root_at_work = np.empty((3, longest), dtype=panels.dtype), np.empty(widest * widest, dtype=panels.dtype)
    for s in range(first, last):
        square, panel = view_square(symbolic, s, factor.squares, n), view_panel(symbolic, s, panels, n)
        width = len(square)
        root = root_at_work[: width * width].reshape((width, width))  # C^-1
        for j in range(width):
            for i in range(width):
                root[i, j] = square[j, i]
        for j in range(0, width, 3):  # from above, where a row needs all below it and none needs it
            rows = min(3, width - j)
            for lines, of in ((square, root), (panel, panel)):
                gemm(root[j:], j, rows, width - j, of[j:], 0, lines.shape[1], out)
                for k in range(rows):
                    for i in range(lines.shape[1]):
                        lines[j + k, i] = out[k, i]
