"""Factors whose columns stay alone, for matrices with hardly any fill-in: blocks one after another, all loops over them unrolled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.small_blocks import copy_flat, invert, is_wide, multiply
from masonry_cd.mechanics.linalg.vectors import add_six_times, load_six, store_six
from masonry_cd.mechanics.linalg.wide_columns import backward_wide_columns, eliminate_wide_columns, forward_wide_columns

SYMMETRIC, UNSYMMETRIC = np.bool_(True), np.bool_(False)  # of a matrix


@borrower(fastmath={"contract"})
def subtract_block_product(c, at, a, i, b, size_n):
    """c[at] -= a[i] b for blocks. For n = 6 or 12 half a dozen entries of a row of c are held in registers, for n = 3 all of b."""
    n = len(size_n)
    if n == 3:
        b00, b01, b02 = b[0, 0], b[0, 1], b[0, 2]
        b10, b11, b12 = b[1, 0], b[1, 1], b[1, 2]
        b20, b21, b22 = b[2, 0], b[2, 1], b[2, 2]
        for p in range(3):
            x, y, z = a[i, p, 0], a[i, p, 1], a[i, p, 2]
            c[at, p, 0] -= x * b00 + y * b10 + z * b20
            c[at, p, 1] -= x * b01 + y * b11 + z * b21
            c[at, p, 2] -= x * b02 + y * b12 + z * b22
        return
    out, left = c[at], a[i]
    for p in range(n):
        if n % 6 == 0:
            for t in range(0, n, 6):
                six = load_six(out, p, t)
                for r in range(n):
                    six = add_six_times(six, -left[p, r], load_six(b, r, t))
                store_six(out, p, t, six)
        else:
            for q in range(n):
                total = out[p, q]
                for r in range(n):
                    total -= left[p, r] * b[r, q]
                out[p, q] = total


@kernel(inline="always")
def load_column(matrix, symbolic, j, where, square, lows, ups, symmetric, n):
    """Blocks of A in column j into ``square`` (1, n, n) and those of L and of (D U)^T; ``where`` (N,) numbers their rows."""
    (diagonal, lower, upper), row, below = matrix, symbolic.row, symbolic.below
    for t in range(symbolic.start[j], symbolic.start[j + 1]):
        where[below[t]] = t
    for t in range(symbolic.column[j], symbolic.column[j + 1]):
        i = where[row[t]]
        for p in range(n):
            for q in range(n):
                lows[i, p, q] = lower[t, p, q]
        if not symmetric:
            for p in range(n):
                for q in range(n):
                    ups[i, p, q] = upper[t, p, q]
    for p in range(n):
        for q in range(n):
            square[0, p, q] = diagonal[j, p, q]


@kernel(inline="always")
def put_transposed(block, out, n):
    """out = block^T."""
    for p in range(n):
        for q in range(n):
            out[p, q] = block[q, p]


class ColumnScratch(NamedTuple):
    """Room for :func:`factorise_columns`, N columns."""

    head: np.ndarray  # (N,) first column of the list of those whose next block is in row j; -1: none
    following: np.ndarray  # (N,) the next column in the list that a column is in
    at: np.ndarray  # (N,) the next block of each
    where: np.ndarray  # (N,) places of rows in the column at work
    work: np.ndarray  # (n, n)
    square: np.ndarray  # (1, n, n) diagonal block of the column at work
    turned: np.ndarray  # (n, n)
    other: np.ndarray  # (n, n)


@kernel()
def factorise_columns(matrix, factor, symmetric):
    """:func:`factorise_ldu` where each supernode is one node: blocks of L and of (D U)^T one after another, all loops over them unrolled.

    Of a symmetric matrix L is all.
    """
    n, count = len(factor.size), len(factor.symbolic.column) - 1
    scratch = ColumnScratch(
        np.full(count, -1), np.full(count, -1), np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64), np.empty((n, n)),
        np.empty((1, n, n)), np.empty((n, n)), np.empty((n, n)),
    )  # fmt: skip
    if is_wide(factor.size):
        return eliminate_wide_columns(matrix, factor, symmetric, scratch)
    return _eliminate_columns(matrix, factor, symmetric, scratch)


@borrower(fastmath={"contract"})
def _eliminate_columns(matrix, factor, symmetric, scratch):
    """Column after column, each by those before it; the sign of the determinant, 0 when a diagonal block cannot be inverted."""
    symbolic, size = factor.symbolic, factor.size
    n, count, first, below, sign = len(size), len(symbolic.column) - 1, symbolic.start, symbolic.below, 1.0
    squares, lows = factor.squares.reshape((count, n, n)), factor.panels.reshape((len(below), n, n))
    ups = factor.others.reshape((len(below), n, n))
    head, following, at, where, work, square, turned, other = scratch
    lows[:] = 0.0
    if not symmetric:
        ups[:] = 0.0
    for j in range(count):
        load_column(matrix, symbolic, j, where, square, lows, ups, symmetric, n)
        k = head[j]
        while k >= 0:  # all columns k < j with a block in row j
            coming, t0, end = following[k], at[k], first[k + 1]
            if symmetric:
                put_transposed(lows[t0], work, n)
                multiply(squares[k], work, False, turned, size)  # D^-1 U, which is L^T
            else:
                put_transposed(ups[t0], turned, n)
            subtract_block_product(square, 0, lows, t0, turned, size)
            for t in range(t0 + 1, end):
                subtract_block_product(lows, where[below[t]], lows, t, turned, size)
            if symmetric:
                put_transposed(turned, lows[t0], n)
            else:
                put_transposed(lows[t0], other, n)
                for t in range(t0 + 1, end):
                    subtract_block_product(ups, where[below[t]], ups, t, other, size)
            if t0 + 1 < end:
                at[k], following[k] = t0 + 1, head[below[t0 + 1]]
                head[below[t0 + 1]] = k
            k = coming
        sign *= invert(square[0], squares[j], work, size)
        if sign == 0.0:
            return sign
        if not symmetric:
            for t in range(first[j], first[j + 1]):
                multiply(lows[t], squares[j], False, work, size)  # L
                copy_flat(work, lows[t])
        if first[j] < first[j + 1]:
            at[j], following[j] = first[j], head[below[first[j]]]
            head[below[first[j]]] = j
    return sign


@borrower(fastmath={"contract"})
def forward_columns(symbolic, low, x, size_n):
    """:func:`forward_substitution` where each supernode is one node."""
    n, below = len(size_n), symbolic.below
    if is_wide(size_n):
        forward_wide_columns(symbolic, low, x, n)
        return
    lows = low.reshape((len(below), n, n))
    for j in range(len(symbolic.column) - 1):
        nothing = True  # where only a few rows of x are not zero, few columns have anything to pass on
        for q in range(n):
            nothing = nothing and x[j, q] == 0.0
        if nothing:
            continue
        if n == 3:
            y0, y1, y2 = x[j, 0], x[j, 1], x[j, 2]
            for t in range(symbolic.start[j], symbolic.start[j + 1]):
                i = below[t]
                x[i, 0] -= lows[t, 0, 0] * y0 + lows[t, 0, 1] * y1 + lows[t, 0, 2] * y2
                x[i, 1] -= lows[t, 1, 0] * y0 + lows[t, 1, 1] * y1 + lows[t, 1, 2] * y2
                x[i, 2] -= lows[t, 2, 0] * y0 + lows[t, 2, 1] * y1 + lows[t, 2, 2] * y2
            continue
        for t in range(symbolic.start[j], symbolic.start[j + 1]):
            i = below[t]
            for p in range(n):
                total = x[i, p]
                for q in range(n):
                    total -= lows[t, p, q] * x[j, q]
                x[i, p] = total


@borrower(fastmath={"contract"})
def backward_columns(symbolic, inverse, up, x, y, symmetric, size_n):
    """:func:`backward_substitution` where each supernode is one node, by the blocks of (D U)^T or, of a symmetric matrix, of L.

    y is room for the entries of a node, at least.
    """
    n, below, size = len(size_n), symbolic.below, len(symbolic.column) - 1
    if is_wide(size_n):
        backward_wide_columns(symbolic, inverse, up, x, y, symmetric)
        return
    squares, ups = inverse.reshape((size, n, n)), up.reshape((len(below), n, n))
    if symmetric:
        for j in range(size):
            divide_node(squares, j, x, y, n)
    for j in range(size - 1, -1, -1):
        subtract_from_node(symbolic, ups, j, x, n)
        if not symmetric:
            divide_node(squares, j, x, y, n)


@kernel(inline="always", fastmath={"contract"})
def divide_node(squares, j, x, y, n):
    """x_j <- D_j^-1 x_j."""
    for p in range(n):
        total = squares.dtype.type(0.0)
        for q in range(n):
            total += squares[j, p, q] * x[j, q]
        y[p] = total
    for p in range(n):
        x[j, p] = y[p]


@kernel(inline="always", fastmath={"contract"})
def subtract_from_node(symbolic, ups, j, x, n):
    """Subtract from x_j what the rows below have in column j, whose blocks are transposed."""
    below = symbolic.below
    if n == 3:  # the sums stay in registers: no block of the column waits for the one before it
        s0, s1, s2 = x[j, 0], x[j, 1], x[j, 2]
        for t in range(symbolic.start[j], symbolic.start[j + 1]):
            i = below[t]
            y0, y1, y2 = x[i, 0], x[i, 1], x[i, 2]
            s0 -= ups[t, 0, 0] * y0 + ups[t, 1, 0] * y1 + ups[t, 2, 0] * y2
            s1 -= ups[t, 0, 1] * y0 + ups[t, 1, 1] * y1 + ups[t, 2, 1] * y2
            s2 -= ups[t, 0, 2] * y0 + ups[t, 1, 2] * y1 + ups[t, 2, 2] * y2
        x[j, 0], x[j, 1], x[j, 2] = s0, s1, s2
        return
    for t in range(symbolic.start[j], symbolic.start[j + 1]):
        i = below[t]
        for q in range(n):  # summed first: the next block of the column waits for one subtraction then
            total = ups[t, 0, q] * x[i, 0]
            for p in range(1, n):
                total += ups[t, p, q] * x[i, p]
            x[j, q] -= total
