"""A = L D L^T of a symmetric block matrix, looking left, supernode by supernode, alone or by a team of threads (see symbolic.py)."""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.dense import gemm, inverse_cholesky
from masonry_cd.linalg.ghost_rows import share_of_subtrees
from masonry_cd.linalg.single_columns import SYMMETRIC, factorise_columns
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import (
    BlockMatrix,
    Factor,
    end_inside,
    extent,
    has_single_columns,
    number_rows,
    subtract_product,
    view_block,
)
from masonry_cd.linalg.threads import share_of, wait


@kernel()
def load_symmetric(plan, s, where, diagonal, lower, square, panel, n):
    """Blocks of a symmetric A of the run s into the upper triangle of its square and into its panel."""
    begin, end = plan.first[s], plan.first[s + 1]
    square[:] = 0.0
    panel[:] = 0.0
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
                        square[k + q, i + p] = lower[t, p, q]
                    else:
                        panel[k + q, i + p] = lower[t, p, q]


@kernel()
def apply_symmetric_update(plan, d, t0, t1, where, panel, square, own, out, n):
    """:func:`apply_update` of a symmetric matrix, of the upper triangle of the square."""
    last, inner, length = plan.start[d + 1], len(panel), panel.shape[1]
    first, rows = length - n * (last - t0), n * (t1 - t0)
    gemm(panel, first, rows, inner, panel, first, length, out)
    for j in range(t1 - t0):
        row = n * where[plan.below[t0 + j]]
        for i in range(j, t1 - t0):
            column = n * where[plan.below[t0 + i]]
            for q in range(n):
                for p in range(n):
                    square[row + q, column + p] -= out[j * n + q, i * n + p]
    subtract_product(out, rows, plan.below, t0, t1 - t0, last, where, own, n)


@kernel()
def factorise_supernodes(plan, first, last, diagonal, lower, squares, panels, n):
    """A = L L^T of a symmetric A for runs first to last, if all that they pull from are done, with blocks of n x n.

    Squares: C^-T of the triangles C on the diagonal of L; panels: L^T right of them; in the precision of their arrays. Only the square at
    work is in double precision whatever they are. Returns False when A is not positive definite.
    """
    size = len(plan.column) - 1
    widest, longest = extent(plan, first, last, n)
    out, where = np.empty((widest, longest), dtype=panels.dtype), np.empty(size, dtype=np.int64)
    room, other = np.empty(widest * widest), np.empty(widest * widest)
    for s in range(first, last):
        number_rows(plan, s, where)
        width, length = n * (plan.first[s + 1] - plan.first[s]), n * (plan.start[s + 1] - plan.start[s])
        square, panel = room[: width * width].reshape((width, width)), view_block(panels, plan.panel[s], width, length, n)
        load_symmetric(plan, s, where, diagonal, lower, square, panel, n)
        for e in range(plan.pull[s], plan.pull[s + 1]):
            d, t1 = plan.puller[e], end_inside(plan, e, plan.first[s + 1])
            its = view_block(panels, plan.panel[d], n * (plan.first[d + 1] - plan.first[d]), n * (plan.start[d + 1] - plan.start[d]), n)
            apply_symmetric_update(plan, d, plan.entry[e], t1, where, its, square, panel, out, n)
        root, kept = other[: width * width].reshape((width, width)), view_block(squares, plan.square[s], width, width, n)
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
def to_unit_diagonal(plan, first, last, squares, panels, n):
    """From the factors of :func:`factorise_supernodes` to A = L D L^T with ones on the diagonal of L: squares of D^-1 and panels of L.

    A solve then reads the squares once, not twice.
    """
    widest, longest = extent(plan, first, last, n)
    out, room = np.empty((3, longest), dtype=panels.dtype), np.empty(widest * widest, dtype=panels.dtype)
    for s in range(first, last):
        width, length = n * (plan.first[s + 1] - plan.first[s]), n * (plan.start[s + 1] - plan.start[s])
        square, panel = view_block(squares, plan.square[s], width, width, n), view_block(panels, plan.panel[s], width, length, n)
        root = room[: width * width].reshape((width, width))  # C^-1
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
def factorise_cholesky(plan, diagonal, lower, squares, panels, size_n):
    """A = L D L^T: squares of D^-1 and panels of L from diagonal blocks A_jj and lower A_ij.

    Returns False when A is not positive definite; if all columns are alone, when a diagonal block cannot be inverted.
    """
    if has_single_columns(plan):
        return factorise_columns(BlockMatrix(diagonal, lower, lower), Factor(plan, squares, panels, panels, size_n), SYMMETRIC)
    n, count = len(size_n), len(plan.first) - 1
    ok = factorise_supernodes(plan, 0, count, diagonal, lower, squares, panels, n)
    if ok:
        to_unit_diagonal(plan, 0, count, squares, panels, n)
    return ok


@kernel()
def factorise_by_team(team, plan, diagonal, lower, squares, panels, n):
    """:func:`factorise_cholesky` by a team, where not all columns are alone."""
    for level in range(len(plan.level) - 1):
        begin, end = share_of(team, plan.level[level], plan.level[level + 1])
        for q in range(begin, end):
            first, last = plan.part[q], plan.part[q + 1]
            if team.gate[2] == 0 and not factorise_supernodes(plan, first, last, diagonal, lower, squares, panels, n):
                team.gate[2] = 1
        wait(team)
    ok = team.gate[2] == 0
    begin, end = share_of_subtrees(team, plan)
    if ok:
        to_unit_diagonal(plan, plan.part[begin], plan.part[end], squares, panels, n)
    wait(team)
    team.gate[2] = 0
    return ok
