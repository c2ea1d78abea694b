# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors whose columns stay alone, for matrices with hardly any fill-in: blocks one after another, loops over narrow ones unrolled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.small_blocks import invert, is_wide
from masonry_cd.mechanics.linalg.vectors import add_six_times, load_six, store_six
from masonry_cd.mechanics.linalg.wide_blocks import (
    add_squares,
    clear_rows,
    copy_rows,
    multiply_blocks,
    rows_of,
    subtract_columns_times,
    subtract_rows_times,
    transpose,
)

SYMMETRIC, UNSYMMETRIC = np.bool_(True), np.bool_(False)  # of a matrix


@borrower(fastmath={"contract"})
def subtract_block_product(c, at, a, i, b, shape, size_n):
    """c[at] -= a[i] b for blocks; a[i] has some rows and columns, and b some columns, as ``shape`` says where they are wide.

    For n = 6 a row of c is held in registers.
    """
    n = len(size_n)
    if is_wide(size_n):
        add_squares(-1.0, a[i], False, b, shape[1], (shape[0], shape[2]), c[at])
        return
    out, left = c[at], a[i]
    for p in range(n):
        if n == 6:
            six = load_six(out, p, 0)
            for r in range(6):
                six = add_six_times(six, -left[p, r], load_six(b, r, 0))
            store_six(out, p, 0, six)
        else:
            for q in range(n):
                total = out[p, q]
                for r in range(n):
                    total -= left[p, r] * b[r, q]
                out[p, q] = total


@borrower(forceinline=True)
def load_column(factor, j, where, to, symmetric):
    """Blocks of A in column j into ``to``: a square (n, n), the blocks of L and of (D U)^T; ``where`` (N,) numbers their rows."""
    symbolic, size_n, (square, lows, ups) = factor.symbolic, factor.size, to
    row, below = symbolic.row, symbolic.below
    own = rows_of(symbolic, j, size_n)
    for t in range(symbolic.start[j], symbolic.start[j + 1]):
        where[below[t]] = t
        clear_rows(rows_of(symbolic, below[t], size_n), own, lows[t])
        if not symmetric:
            clear_rows(rows_of(symbolic, below[t], size_n), own, ups[t])
    for t in range(symbolic.column[j], symbolic.column[j + 1]):
        copy_rows(factor.lower[t], rows_of(symbolic, row[t], size_n), own, lows[where[row[t]]])
        if not symmetric:
            copy_rows(factor.upper[t], rows_of(symbolic, row[t], size_n), own, ups[where[row[t]]])
    copy_rows(factor.diagonal[j], own, own, square)


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
def factorise_columns(factor, symmetric):
    """The factors where each supernode is one node: blocks of L and of (D U)^T one after another, all loops over them unrolled
    unless blocks are wide.

    Of a symmetric matrix L is all, and ``others`` has to be ``panels``. Returns the sign of det A, 0 when a block of D has no inverse.
    """
    n, count = len(factor.size), len(factor.symbolic.column) - 1
    scratch = ColumnScratch(
        np.full(count, -1), np.full(count, -1), np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64), np.empty((n, n)),
        np.empty((1, n, n)), np.empty((n, n)), np.empty((n, n)),
    )  # fmt: skip
    return _eliminate_columns(factor, symmetric, scratch)


@borrower(fastmath={"contract"})
def _eliminate_columns(factor, symmetric, scratch):
    """Column after column, each by those before it; the sign of the determinant, 0 when a diagonal block cannot be inverted."""
    symbolic, size = factor.symbolic, factor.size
    n, count, first, below, sign = len(size), len(symbolic.column) - 1, symbolic.start, symbolic.below, 1.0
    squares, lows = factor.squares.reshape((count, n, n)), factor.panels.reshape((len(below), n, n))
    ups = factor.others.reshape((len(below), n, n))
    head, following, at, where, work, square, turned, other = scratch
    for j in range(count):
        own = rows_of(symbolic, j, size)
        load_column(factor, j, where, (square[0], lows, ups), symmetric)
        k = head[j]
        while k >= 0:  # all columns k < j with a block in row j
            coming, t0, end, inner = following[k], at[k], first[k + 1], rows_of(symbolic, k, size)
            if symmetric:
                transpose(lows[t0], own, inner, work)
                multiply_blocks(squares[k], work, (inner, inner, own), turned, size)  # D^-1 U, which is L^T
            else:
                transpose(ups[t0], own, inner, turned)
            subtract_block_product(square, 0, lows, t0, turned, (own, inner, own), size)
            for t in range(t0 + 1, end):
                shape = rows_of(symbolic, below[t], size), inner, own
                subtract_block_product(lows, where[below[t]], lows, t, turned, shape, size)
            if symmetric:
                transpose(turned, inner, own, lows[t0])
            else:
                transpose(lows[t0], own, inner, other)
                for t in range(t0 + 1, end):
                    shape = rows_of(symbolic, below[t], size), inner, own
                    subtract_block_product(ups, where[below[t]], ups, t, other, shape, size)
            if t0 + 1 < end:
                at[k], following[k] = t0 + 1, head[below[t0 + 1]]
                head[below[t0 + 1]] = k
            k = coming
        sign *= invert(square[0], own, squares[j], work, size)
        if sign == 0.0:
            return sign
        if not symmetric:
            for t in range(first[j], first[j + 1]):
                rows = rows_of(symbolic, below[t], size)
                multiply_blocks(lows[t], squares[j], (rows, own, own), work, size)  # L
                copy_rows(work, rows, own, lows[t])
        if first[j] < first[j + 1]:
            at[j], following[j] = first[j], head[below[first[j]]]
            head[below[first[j]]] = j
    return sign


@borrower(fastmath={"contract"})
def forward_columns(symbolic, low, x, size_n):
    """:func:`forward_substitution` where each supernode is one node."""
    n, below = len(size_n), symbolic.below
    lows = low.reshape((len(below), n, n))
    for j in range(len(symbolic.column) - 1):
        own, nothing = rows_of(symbolic, j, size_n), True  # where only a few rows of x are not zero, few columns have anything to pass on
        for q in range(own):
            nothing = nothing and x[j, q] == 0.0
        if nothing:
            continue
        for t in range(symbolic.start[j], symbolic.start[j + 1]):
            i = below[t]
            if is_wide(size_n):
                subtract_rows_times(lows[t], x[j], rows_of(symbolic, i, size_n), own, x[i])
                continue
            if n == 6:
                subtract_times(lows, t, x, i, j, 6)
            else:
                subtract_times(lows, t, x, i, j, n)


@borrower(forceinline=True, fastmath={"contract"})
def subtract_times(lows, t, x, i, j, n):
    """x_i -= L_ij x_j."""
    for p in range(n):
        total = x[i, p]
        for q in range(n):
            total -= lows[t, p, q] * x[j, q]
        x[i, p] = total


@borrower(forceinline=True, fastmath={"contract"})
def subtract_turned(ups, t, x, i, j, n):
    """x_j -= U_ji x_i, of a block that is transposed."""
    for q in range(n):  # summed first: the next block of the column waits for one subtraction then
        total = ups[t, 0, q] * x[i, 0]
        for p in range(1, n):
            total += ups[t, p, q] * x[i, p]
        x[j, q] -= total


@borrower(fastmath={"contract"})
def backward_columns(symbolic, inverse, up, x, y, symmetric, size_n):
    """:func:`backward_substitution` where each supernode is one node, by the blocks of (D U)^T or, of a symmetric matrix, of L.

    y is room for the entries of a node, at least.
    """
    n, below, size = len(size_n), symbolic.below, len(symbolic.column) - 1
    squares, ups = inverse.reshape((size, n, n)), up.reshape((len(below), n, n))
    if symmetric:
        for j in range(size):
            divide_node(symbolic, squares, j, x, y, size_n)
    for j in range(size - 1, -1, -1):
        subtract_from_node(symbolic, ups, j, x, size_n)
        if not symmetric:
            divide_node(symbolic, squares, j, x, y, size_n)


@borrower(forceinline=True, fastmath={"contract"})
def divide_node(symbolic, squares, j, x, y, size_n):
    """x_j <- D_j^-1 x_j."""
    n = rows_of(symbolic, j, size_n)
    if is_wide(size_n):
        for p in range(n):
            y[p], x[j, p] = -x[j, p], 0.0
        subtract_rows_times(squares[j], y, n, n, x[j])
        return
    if n == 6:
        multiply_node(squares, j, x, y, 6)
    else:
        multiply_node(squares, j, x, y, n)


@borrower(forceinline=True, fastmath={"contract"})
def multiply_node(squares, j, x, y, n):
    """x_j <- D_j^-1 x_j of a block of n rows."""
    for p in range(n):
        total = squares.dtype.type(0.0)
        for q in range(n):
            total += squares[j, p, q] * x[j, q]
        y[p] = total
    for p in range(n):
        x[j, p] = y[p]


@borrower(forceinline=True, fastmath={"contract"})
def subtract_from_node(symbolic, ups, j, x, size_n):
    """Subtract from x_j what the rows below have in column j, whose blocks are transposed."""
    n, below = rows_of(symbolic, j, size_n), symbolic.below
    for t in range(symbolic.start[j], symbolic.start[j + 1]):
        i = below[t]
        if is_wide(size_n):
            subtract_columns_times(ups[t], x[i], rows_of(symbolic, i, size_n), n, x[j])
            continue
        if n == 6:
            subtract_turned(ups, t, x, i, j, 6)
        else:
            subtract_turned(ups, t, x, i, j, n)
