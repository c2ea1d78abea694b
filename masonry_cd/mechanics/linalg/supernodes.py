# SPDX-License-Identifier: GPL-3.0-or-later
"""Supernodes of a factor: their squares and panels, and rows scattered into and gathered from them."""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower, kernel


@borrower()
def subtract_product(product, skip, below, begin, own, end, where, panel, n):
    """panel[j, i] -= product[j, i] for the columns j of the first ``own`` rows of the list and the other rows i of it.

    ``skip`` entries of each line of the product come before those of these rows.
    """
    i = 0
    while own + i < end - begin:
        at, first = where[below[begin + own + i]], i
        while own + i < end - begin and where[below[begin + own + i]] == at + i - first:  # neighbours in both
            i += 1
        for j in range(own):
            for q in range(n):
                to = panel[where[below[begin + j]] * n + q, n * at : n * (at + i - first)]
                what = product[j * n + q, skip + n * first : skip + n * i]
                for k in range(len(to)):
                    to[k] -= what[k]


@kernel()
def view_square(symbolic, s, squares, n):
    """The square (width, width) of supernode s as a matrix."""
    begin, width = symbolic.square[s] * n * n, n * (symbolic.first[s + 1] - symbolic.first[s])
    return squares[begin : begin + width * width].reshape((width, width))


@kernel()
def view_panel(symbolic, s, panels, n):
    """The panel (width, length) of supernode s as a matrix."""
    begin, width, length = symbolic.panel[s] * n * n, symbolic.first[s + 1] - symbolic.first[s], symbolic.start[s + 1] - symbolic.start[s]
    return panels[begin : begin + n * width * n * length].reshape((n * width, n * length))


@borrower()
def load_diagonal(symbolic, s, diagonal, square, n):
    """The blocks of A on its diagonal in the columns of supernode s into its square, which is zero elsewhere."""
    begin = symbolic.first[s]
    square[:] = 0.0
    for j in range(begin, symbolic.first[s + 1]):
        k = (j - begin) * n
        for p in range(n):
            for q in range(n):
                square[k + p, k + q] = diagonal[j, p, q]


@borrower()
def load_blocks(symbolic, s, where, blocks, square, panel, n):
    """The transposes of blocks (E, n, n) in the columns of supernode s into the upper triangle of its square and into its panel.

    ``where`` (N,) numbers their rows.
    """
    begin, end = symbolic.first[s], symbolic.first[s + 1]
    panel[:] = 0.0
    for j in range(begin, end):
        k = (j - begin) * n
        for t in range(symbolic.column[j], symbolic.column[j + 1]):
            i = where[symbolic.row[t]] * n
            for p in range(n):
                for q in range(n):
                    if symbolic.row[t] < end:
                        square[k + q, i + p] = blocks[t, p, q]
                    else:
                        panel[k + q, i + p] = blocks[t, p, q]


@borrower()
def has_single_columns(symbolic):
    """Return True if each supernode is one node, all of them in one subtree."""
    return len(symbolic.first) == len(symbolic.column) and len(symbolic.subtree) == 2


@borrower()
def extent(symbolic, first, last, n):
    """Most rows and longest line of the squares and panels of supernodes first to last, and of what updates them."""
    widest, longest = 0, 0
    for s in range(first, last):
        width = symbolic.first[s + 1] - symbolic.first[s]
        widest, longest = max(widest, n * width), max(longest, n * max(width, symbolic.start[s + 1] - symbolic.start[s]))
        for e in range(symbolic.update_start[s], symbolic.update_start[s + 1]):
            d = symbolic.updater[e]
            widest, longest = (
                max(widest, n * (symbolic.first[d + 1] - symbolic.first[d])),
                max(longest, n * (symbolic.start[d + 1] - symbolic.update_first[e])),
            )
    return widest, longest


@borrower()
def number_rows(symbolic, s, where):
    """Into ``where`` (N,) the places of the nodes of supernode s in its square, and of the rows below it in its panel."""
    for i in range(symbolic.first[s], symbolic.first[s + 1]):
        where[i] = i - symbolic.first[s]
    for t in range(symbolic.start[s], symbolic.start[s + 1]):
        where[symbolic.below[t]] = t - symbolic.start[s]


@borrower()
def end_inside(symbolic, e, end):
    """The end of those rows of the e-th updater that are before node ``end``."""
    t, last = symbolic.update_first[e], symbolic.start[symbolic.updater[e] + 1]
    while t < last and symbolic.below[t] < end:
        t += 1
    return t


@borrower()
def longest_line(symbolic, first, last, n):
    """Entries of the longest line of a panel or square of supernodes first to last."""
    longest = 0
    for s in range(first, last):
        longest = max(longest, n * max(symbolic.first[s + 1] - symbolic.first[s], symbolic.start[s + 1] - symbolic.start[s]))
    return longest


@borrower()
def gather_rows(symbolic, s, x, y, n):
    """y = the rows of x below supernode s."""
    k = 0
    for t in range(symbolic.start[s], symbolic.start[s + 1]):
        for p in range(n):
            y[k] = x[symbolic.below[t], p]
            k += 1


@borrower()
def subtract_rows(symbolic, s, row, y, x, n):
    """Take y off the rows of x below supernode s; ``row`` says where these are: symbolic.below, or symbolic.target."""
    k = 0
    for t in range(symbolic.start[s], symbolic.start[s + 1]):
        for p in range(n):
            x[row[t], p] -= y[k]
            k += 1
