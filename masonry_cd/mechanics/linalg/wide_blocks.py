# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of which a node may use a part, with loops as long as each node has rows.

Wide blocks have room for (n, n) entries, of which a node uses ``width``, see condensation.py; both are multiples of STEP. Most of the work
is in products, four rows and four columns of the result at a time, which fit into the registers.
"""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.linalg.small_blocks import STEP, is_wide, multiply
from masonry_cd.mechanics.linalg.vectors import add_times, fill_four, load_four, store_lanes


@borrower(forceinline=True)
def rows_of(symbolic, j, size_n):
    """Rows of node j: those of a block, or as many as the node has where blocks are wide."""
    return symbolic.width[j] if is_wide(size_n) and len(symbolic.width) > 0 else len(size_n)


@borrower(forceinline=True)
def add_squares(sign, a, turned, b, inner, size, out):
    """out, of a size (rows, columns), += sign times a b or, if ``turned``, a^T b; the sums of ``inner`` terms are held in registers."""
    rows, columns = size
    for p in range(0, rows, STEP):
        for t in range(0, columns, STEP):
            s0, s1, s2, s3 = fill_four(0.0), fill_four(0.0), fill_four(0.0), fill_four(0.0)
            for r in range(inner):
                line = load_four(b, r, t)
                s0 = add_times(s0, a[r, p] if turned else a[p, r], line)
                s1 = add_times(s1, a[r, p + 1] if turned else a[p + 1, r], line)
                s2 = add_times(s2, a[r, p + 2] if turned else a[p + 2, r], line)
                s3 = add_times(s3, a[r, p + 3] if turned else a[p + 3, r], line)
            add_square(out, p, t, sign, (s0, s1, s2, s3))


@borrower(forceinline=True)
def add_square(out, p, t, sign, lines):
    """Add sign times four lines of four entries to ``out`` from row p and column t on."""
    store_lanes(out, p, t, add_times(load_four(out, p, t), sign, lines[0]))
    store_lanes(out, p + 1, t, add_times(load_four(out, p + 1, t), sign, lines[1]))
    store_lanes(out, p + 2, t, add_times(load_four(out, p + 2, t), sign, lines[2]))
    store_lanes(out, p + 3, t, add_times(load_four(out, p + 3, t), sign, lines[3]))


@borrower()
def multiply_blocks(a, b, shape, out, size_n):
    """out = a b; a has a given number of rows and columns, and b a given number of columns, as ``shape`` says where blocks are wide."""
    if is_wide(size_n):
        rows, inner, columns = shape
        clear_rows(rows, columns, out)
        add_squares(1.0, a, False, b, inner, (rows, columns), out)
    else:
        multiply(a, b, out, size_n)


@borrower(forceinline=True)
def transpose(a, rows, columns, out):
    """out (columns, rows) = a^T of the first rows and columns of a block."""
    for p in range(rows):
        for q in range(columns):
            out[q, p] = a[p, q]


@borrower(forceinline=True)
def clear_rows(rows, columns, out):
    """out = 0, in the first rows and columns of a block."""
    for p in range(rows):
        for q in range(columns):
            out[p, q] = 0.0


@borrower(forceinline=True)
def copy_rows(a, rows, columns, out):
    """out = a, in the first rows and columns of a block."""
    for p in range(rows):
        for q in range(columns):
            out[p, q] = a[p, q]


@borrower(fastmath={"contract"})
def subtract_rows_times(a, x, rows, columns, out):
    """out (rows,) -= a (rows, columns) x."""
    for p in range(0, rows, STEP):
        t0, t1, t2, t3 = out[p], out[p + 1], out[p + 2], out[p + 3]
        for q in range(columns):
            y = x[q]
            t0 -= a[p, q] * y
            t1 -= a[p + 1, q] * y
            t2 -= a[p + 2, q] * y
            t3 -= a[p + 3, q] * y
        out[p], out[p + 1], out[p + 2], out[p + 3] = t0, t1, t2, t3


@borrower(fastmath={"contract"})
def subtract_columns_times(a, x, rows, columns, out):
    """out (columns,) -= a^T x, a (rows, columns)."""
    for q in range(0, columns, STEP):
        t0, t1, t2, t3 = out[q], out[q + 1], out[q + 2], out[q + 3]
        for p in range(rows):
            y = x[p]
            t0 -= a[p, q] * y
            t1 -= a[p, q + 1] * y
            t2 -= a[p, q + 2] * y
            t3 -= a[p, q + 3] * y
        out[q], out[q + 1], out[q + 2], out[q + 3] = t0, t1, t2, t3
