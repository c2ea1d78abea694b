# SPDX-License-Identifier: GPL-3.0-or-later
"""A = L D L^T of a symmetric block matrix, looking left, supernode by supernode, alone or by a team of threads (see symbolic.py)."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.linalg.dense import gemm, inverse_cholesky
from masonry_cd.mechanics.linalg.ghost_rows import share_of_subtrees
from masonry_cd.mechanics.linalg.single_columns import SYMMETRIC, factorise_columns
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
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
    view_block,
)
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import share_of, wait


@kernel()
def apply_symmetric_update(symbolic, d, t0, t1, where, panel, square, own, out, n):
    """Subtract from a supernode, the upper triangle of its ``square`` and its panel ``own``, what the earlier supernode d contributes.

    ``panel`` is that of d, t0 to t1 its rows in the supernode.
    """
    last, inner, length = symbolic.start[d + 1], len(panel), panel.shape[1]
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
def factorise_supernodes(symbolic, first, last, diagonal, lower, squares, panels, n):
    """A = L L^T of a symmetric A for supernodes first to last, after all that update them, with blocks of n x n.

    Squares: C^-T of the triangles C on the diagonal of L; panels: L^T right of them; in the precision of their arrays. Only the square at
    work is always in double precision. Returns False when A is not positive definite.
    """
    size = len(symbolic.column) - 1
    widest, longest = extent(symbolic, first, last, n)
    out, where = np.empty((widest, longest), dtype=panels.dtype), np.empty(size, dtype=np.int64)
    square_at_work, root_at_work = np.empty(widest * widest), np.empty(widest * widest)
    for s in range(first, last):
        number_rows(symbolic, s, where)
        width, length = n * (symbolic.first[s + 1] - symbolic.first[s]), n * (symbolic.start[s + 1] - symbolic.start[s])
        square, panel = square_at_work[: width * width].reshape((width, width)), view_block(panels, symbolic.panel[s], width, length, n)
        load_diagonal(symbolic, s, diagonal, square, n)
        load_blocks(symbolic, s, where, lower, square, panel, n)
        for e in range(symbolic.update_start[s], symbolic.update_start[s + 1]):
            d, t1 = symbolic.updater[e], end_inside(symbolic, e, symbolic.first[s + 1])
            its = view_block(
                panels,
                symbolic.panel[d],
                n * (symbolic.first[d + 1] - symbolic.first[d]),
                n * (symbolic.start[d + 1] - symbolic.start[d]),
                n,
            )
            apply_symmetric_update(symbolic, d, symbolic.update_first[e], t1, where, its, square, panel, out, n)
        root, kept = root_at_work[: width * width].reshape((width, width)), view_block(squares, symbolic.square[s], width, width, n)
        if not inverse_cholesky(square, root):
            return False
        copy_flat(root, kept)
        for j in range(width - 1 - (width - 1) % 3, -1, -3):  # from below, where a row needs all above it and none needs it
            rows = min(3, width - j)
            gemm(kept, j, rows, j + rows, panel, 0, length, out)
            for k in range(rows):
                for i in range(length):
                    panel[j + k, i] = out[k, i]
    return True


@kernel()
def to_unit_diagonal(symbolic, first, last, squares, panels, n):
    """From the factors of :func:`factorise_supernodes` to A = L D L^T with ones on the diagonal of L: squares of D^-1 and panels of L.

    A solve then reads the squares once, not twice.
    """
    widest, longest = extent(symbolic, first, last, n)
    out, root_at_work = np.empty((3, longest), dtype=panels.dtype), np.empty(widest * widest, dtype=panels.dtype)
    for s in range(first, last):
        width, length = n * (symbolic.first[s + 1] - symbolic.first[s]), n * (symbolic.start[s + 1] - symbolic.start[s])
        square, panel = view_block(squares, symbolic.square[s], width, width, n), view_block(panels, symbolic.panel[s], width, length, n)
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


@entry()
def factorise_cholesky(
    symbolic: SymbolicFactor, diagonal: np.ndarray, lower: np.ndarray, squares: np.ndarray, panels: np.ndarray, size_n: tuple[int, ...]
) -> bool:
    """A = L D L^T: squares of D^-1 and panels of L from diagonal blocks (N, n, n) A_jj and lower ones (B, n, n) A_ij.

    Returns False when A is not positive definite; if all columns are single, when a diagonal block cannot be inverted.
    """
    if has_single_columns(symbolic):
        return factorise_columns(BlockMatrix(diagonal, lower, lower), Factor(symbolic, squares, panels, panels, size_n), SYMMETRIC) != 0.0
    n, count = len(size_n), len(symbolic.first) - 1
    ok = factorise_supernodes(symbolic, 0, count, diagonal, lower, squares, panels, n)
    if ok:
        to_unit_diagonal(symbolic, 0, count, squares, panels, n)
    return ok


@kernel()
def factorise_by_team(team, symbolic, diagonal, lower, squares, panels, n):
    """:func:`factorise_cholesky` by a team, level by level of the subtrees, where not all columns are single."""
    for level in range(len(symbolic.level) - 1):
        begin, end = share_of(team, symbolic.level[level], symbolic.level[level + 1])
        for q in range(begin, end):
            first, last = symbolic.subtree[q], symbolic.subtree[q + 1]
            if team.failed[0] == 0 and not factorise_supernodes(symbolic, first, last, diagonal, lower, squares, panels, n):
                team.failed[0] = 1
        wait(team)
    ok = team.failed[0] == 0
    begin, end = share_of_subtrees(team, symbolic)
    if ok:
        to_unit_diagonal(symbolic, symbolic.subtree[begin], symbolic.subtree[end], squares, panels, n)
    wait(team)
    team.failed[0] = 0
    return ok
