# SPDX-License-Identifier: GPL-3.0-or-later
"""Forward and backward substitution with the factors of a :class:`BlockFactor`.

Sums are taken in the order that the processor likes ("reassoc"); equal inputs still give equal bits on one machine.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.single_columns import SYMMETRIC, UNSYMMETRIC, backward_columns, forward_columns
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.supernodes import gather_rows, has_single_columns, longest_line, subtract_rows


@borrower(fastmath={"contract", "reassoc"})
def add_columns(lines, at, length, factors, out, size_n):
    """out = sum of factors[k] times line k; lines of ``length`` entries one after another from ``at`` on, taken three at a time."""
    count, threes = len(factors), len(factors) - len(factors) % 3 if len(size_n) % 3 else len(factors)
    out[:length] = 0.0
    for k in range(0, threes, 3):
        x0, x1, x2 = factors[k], factors[k + 1], factors[k + 2]
        a, b, c = at + k * length, at + (k + 1) * length, at + (k + 2) * length
        l0, l1, l2 = lines[a:b], lines[b:c], lines[c : c + length]
        for i in range(length):
            out[i] += l0[i] * x0 + l1[i] * x1 + l2[i] * x2
    for k in range(threes, count):
        line = lines[at + k * length : at + (k + 1) * length]
        for i in range(length):
            out[i] += line[i] * factors[k]


@borrower(fastmath={"contract", "reassoc"})
def add_rows(lines, at, length, factors, sign, out, size_n):
    """out[k] += sign times line k . factors; lines as in :func:`add_columns`."""
    factor = lines.dtype.type(sign)
    count, threes = len(out), len(out) - len(out) % 3 if len(size_n) % 3 else len(out)
    for k in range(0, threes, 3):
        a, b, c = at + k * length, at + (k + 1) * length, at + (k + 2) * length
        l0, l1, l2 = lines[a:b], lines[b:c], lines[c : c + length]
        t0 = t1 = t2 = lines.dtype.type(0.0)
        for i in range(length):
            x = factors[i]
            t0 += l0[i] * x
            t1 += l1[i] * x
            t2 += l2[i] * x
        out[k] += factor * t0
        out[k + 1] += factor * t1
        out[k + 2] += factor * t2
    for k in range(threes, count):
        line, total = lines[at + k * length : at + (k + 1) * length], lines.dtype.type(0.0)
        for i in range(length):
            total += line[i] * factors[i]
        out[k] += factor * total


@borrower()
def forward_substitution(factor, first, last, row, x, line):
    """x <- L^-1 x for supernodes first to last of a :class:`BlockFactor`; ``row`` (R,) as in :func:`subtract_rows`.

    ``line`` is room of the type of the panels for :func:`longest_line` entries.
    """
    symbolic, panels, size = factor.symbolic, factor.panels, factor.size
    if has_single_columns(symbolic):
        forward_columns(symbolic, panels, x, size)
        return
    n, blocks, flat = len(size), len(size) * len(size), x.reshape(x.size)
    for s in range(first, last):
        own, length = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]], n * (symbolic.start[s + 1] - symbolic.start[s])
        add_columns(panels, symbolic.panel[s] * blocks, length, own, line, size)
        subtract_rows(symbolic, s, row, line, x, n)


@borrower()
def backward_substitution(factor, first, last, x, line):
    """x <- L^-T D^-1 x of a symmetric matrix for supernodes first to last, after all later ones; ``line`` as for the forward one."""
    symbolic, size = factor.symbolic, factor.size
    if has_single_columns(symbolic):
        backward_columns(symbolic, factor.squares, factor.panels, x, line, SYMMETRIC, size)
        return
    n, flat = len(size), x.reshape(x.size)
    for s in range(last - 1, first - 1, -1):
        own = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]]
        divide_by_square(factor, s, own, line)
        subtract_below(factor, factor.panels, s, x, own, line)


@kernel()
def solve_ldu(factor, x):
    """x <- (L D U)^-1 x in place, x (N or more, n)."""
    symbolic, size = factor.symbolic, factor.size
    n, count = len(size), len(symbolic.first) - 1
    line, flat = np.empty(longest_line(symbolic, 0, count, n)), x.reshape(x.size)
    forward_substitution(factor, 0, count, symbolic.below, x, line)
    if has_single_columns(symbolic):
        backward_columns(symbolic, factor.squares, factor.others, x, line, UNSYMMETRIC, size)
        return
    for s in range(count - 1, -1, -1):
        own = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]]
        subtract_below(factor, factor.others, s, x, own, line)
        divide_by_square(factor, s, own, line)


@borrower()
def divide_by_square(factor, s, own, line):
    """own <- D_s^-1 own, the rows of supernode s."""
    copy_flat(own, line[: len(own)])
    own[:] = 0.0
    add_rows(factor.squares, factor.symbolic.square[s] * len(factor.size) * len(factor.size), len(own), line, 1.0, own, factor.size)


@borrower()
def subtract_below(factor, panels, s, x, own, line):
    """Subtract from the rows of supernode s what those below it have in its columns, by panels of L^T or of D U."""
    symbolic, n = factor.symbolic, len(factor.size)
    gather_rows(symbolic, s, x, line, n)
    add_rows(panels, symbolic.panel[s] * n * n, n * (symbolic.start[s + 1] - symbolic.start[s]), line, -1.0, own, factor.size)
