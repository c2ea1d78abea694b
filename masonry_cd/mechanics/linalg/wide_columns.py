"""Blocks of more than NARROW rows whose columns stay alone: :mod:`single_columns` with loops as long as each node has rows.

Blocks have room for (n, n) entries, of which a node uses ``width``, see condensation.py; both are multiples of STEP. Most of the work is in
products, two rows and four columns of the result at a time, which fit into the registers.
"""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.small_blocks import STEP
from masonry_cd.mechanics.linalg.vectors import add_times, fill_four, load_four, store_lanes


@kernel(inline="always")
def rows_of(symbolic, j, n):
    """Rows of node j, of the n of a block."""
    return symbolic.width[j] if len(symbolic.width) else n


@borrower()
def add_product(sign, a, b, rows, inner, columns, out):
    """out (rows, columns) += sign times a (rows, inner) b (inner, columns)."""
    add_squares(sign, a, False, b, inner, (rows, columns), out)


@borrower()
def add_turned_product(a, b, inner, size, out):
    """out += a^T b, a and b with so many rows (inner), out of a size (rows, columns)."""
    add_squares(1.0, a, True, b, inner, size, out)


@kernel(inline="always")
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


@kernel(inline="always")
def add_square(out, p, t, sign, lines):
    """Add sign times four lines of four entries to ``out`` from row p and column t on."""
    store_lanes(out, p, t, add_times(load_four(out, p, t), sign, lines[0]))
    store_lanes(out, p + 1, t, add_times(load_four(out, p + 1, t), sign, lines[1]))
    store_lanes(out, p + 2, t, add_times(load_four(out, p + 2, t), sign, lines[2]))
    store_lanes(out, p + 3, t, add_times(load_four(out, p + 3, t), sign, lines[3]))


@borrower()
def set_product(a, b, rows, inner, columns, out):
    """out (rows, columns) = a (rows, inner) b (inner, columns)."""
    clear_rows(rows, columns, out)
    add_product(1.0, a, b, rows, inner, columns, out)


@borrower()
def transpose(a, rows, columns, out):
    """out (columns, rows) = a^T of the first rows and columns of a block."""
    for p in range(rows):
        for q in range(columns):
            out[q, p] = a[p, q]


@borrower(fastmath={"contract"})
def invert_wide(a, width, work, out):
    """Inverse of the first rows of a block by Gauss and Jordan in place, with row pivoting; the sign of its determinant, or 0 if there is
    none. ``work`` (2, n) is scratch."""
    sign, factors, pivots = 1.0, work[0], work[1]
    for i in range(width):
        for j in range(width):
            out[i, j] = a[i, j]
    for k in range(width):
        best = k
        for i in range(k + 1, width):
            if abs(out[i, k]) > abs(out[best, k]):
                best = i
        pivot = out[best, k]
        if not (0.0 < abs(pivot) < float("inf")):
            return 0.0
        if (pivot < 0.0) != (best != k):
            sign = -sign
        pivots[k] = best
        if best != k:
            for j in range(width):
                out[k, j], out[best, j] = out[best, j], out[k, j]
        for i in range(width):
            factors[i], out[i, k] = out[i, k], 0.0
        factors[k], out[k, k] = 0.0, 1.0
        scale = 1.0 / pivot
        for t in range(0, width, STEP):
            line = add_times(fill_four(0.0), scale, load_four(out, k, t))
            store_lanes(out, k, t, line)
            for i in range(width):
                store_lanes(out, i, t, add_times(load_four(out, i, t), -factors[i], line))
    for k in range(width - 1, -1, -1):
        best = int(pivots[k])
        if best != k:
            for i in range(width):
                out[i, k], out[i, best] = out[i, best], out[i, k]
    return sign


@borrower()
def eliminate_wide_columns(matrix, factor, symmetric, scratch):
    """Column after column, each by those before it; the sign of the determinant, 0 when a diagonal block cannot be inverted.

    As in :func:`single_columns.factorise_columns`.
    """
    symbolic, n = factor.symbolic, len(factor.size)
    count, first, below, sign = len(symbolic.column) - 1, symbolic.start, symbolic.below, 1.0
    squares, lows = factor.squares.reshape((count, n, n)), factor.panels.reshape((len(below), n, n))
    ups = factor.others.reshape((len(below), n, n))
    head, following, at, where, work, square, turned, other = scratch
    for j in range(count):
        own = rows_of(symbolic, j, n)
        load_wide_column(matrix, symbolic, j, where, (square[0], lows, ups), symmetric, n)
        k = head[j]
        while k >= 0:  # all columns k < j with a block in row j
            coming, t0, end, inner = following[k], at[k], first[k + 1], rows_of(symbolic, k, n)
            if symmetric:
                transpose(squares[k], inner, inner, work)
                set_product(lows[t0], work, own, inner, inner, other)  # L
                transpose(other, own, inner, turned)
            else:
                transpose(ups[t0], own, inner, turned)
            add_product(-1.0, lows[t0], turned, own, inner, own, square[0])
            for t in range(t0 + 1, end):
                add_product(-1.0, lows[t], turned, rows_of(symbolic, below[t], n), inner, own, lows[where[below[t]]])
            if symmetric:
                copy_rows(other, own, inner, lows[t0])
            else:
                transpose(lows[t0], own, inner, turned)
                for t in range(t0 + 1, end):
                    add_product(-1.0, ups[t], turned, rows_of(symbolic, below[t], n), inner, own, ups[where[below[t]]])
            if t0 + 1 < end:
                at[k], following[k] = t0 + 1, head[below[t0 + 1]]
                head[below[t0 + 1]] = k
            k = coming
        sign *= invert_wide(square[0], own, work, squares[j])
        if sign == 0.0:
            return sign
        if not symmetric:
            for t in range(first[j], first[j + 1]):
                rows = rows_of(symbolic, below[t], n)
                set_product(lows[t], squares[j], rows, own, own, work)  # L
                copy_rows(work, rows, own, lows[t])
        if first[j] < first[j + 1]:
            at[j], following[j] = first[j], head[below[first[j]]]
            head[below[first[j]]] = j
    return sign


@borrower()
def load_wide_column(matrix, symbolic, j, where, to, symmetric, n):
    """Blocks of A in column j into ``to``: a square (n, n), the blocks of L and of U^T; ``where`` (N,) numbers their rows."""
    (diagonal, lower, upper), (square, lows, ups), row, below = matrix, to, symbolic.row, symbolic.below
    own = rows_of(symbolic, j, n)
    for t in range(symbolic.start[j], symbolic.start[j + 1]):
        where[below[t]] = t
        clear_rows(rows_of(symbolic, below[t], n), own, lows[t])
        if not symmetric:
            clear_rows(rows_of(symbolic, below[t], n), own, ups[t])
    for t in range(symbolic.column[j], symbolic.column[j + 1]):
        copy_rows(lower[t], rows_of(symbolic, row[t], n), own, lows[where[row[t]]])
        if not symmetric:
            copy_rows(upper[t], rows_of(symbolic, row[t], n), own, ups[where[row[t]]])
    copy_rows(diagonal[j], own, own, square)


@borrower()
def clear_rows(rows, columns, out):
    """out = 0, in the first rows and columns of a block."""
    for p in range(rows):
        for q in range(columns):
            out[p, q] = 0.0


@borrower()
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


@borrower()
def forward_wide_columns(symbolic, low, x, n):
    """x <- L^-1 x in place, x (N or more, n)."""
    below = symbolic.below
    lows = low.reshape((len(below), n, n))
    for j in range(len(symbolic.column) - 1):
        own = rows_of(symbolic, j, n)
        for t in range(symbolic.start[j], symbolic.start[j + 1]):
            subtract_rows_times(lows[t], x[j], rows_of(symbolic, below[t], n), own, x[below[t]])


@borrower()
def backward_wide_columns(symbolic, inverse, up, x, y, symmetric):
    """x <- U^-1 D^-1 x in place, as :func:`single_columns.backward_columns`; y is room for the entries of a node, at least."""
    below, size, n = symbolic.below, len(symbolic.column) - 1, x.shape[1]
    squares, ups = inverse.reshape((size, n, n)), up.reshape((len(below), n, n))
    if symmetric:
        for j in range(size):
            divide_wide_node(squares[j], rows_of(symbolic, j, n), x[j], y)
    for j in range(size - 1, -1, -1):
        own = rows_of(symbolic, j, n)
        for t in range(symbolic.start[j], symbolic.start[j + 1]):
            subtract_columns_times(ups[t], x[below[t]], rows_of(symbolic, below[t], n), own, x[j])
        if not symmetric:
            divide_wide_node(squares[j], own, x[j], y)


@borrower()
def divide_wide_node(inverse, own, x, y):
    """x <- D^-1 x of a node; y is room."""
    for p in range(own):
        y[p], x[p] = -x[p], 0.0
    subtract_rows_times(inverse, y, own, own, x)
