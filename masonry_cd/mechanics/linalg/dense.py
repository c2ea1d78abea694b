# SPDX-License-Identifier: GPL-3.0-or-later
"""Dense kernels of a supernode: products, and the inverse or the inverse Cholesky factor of a diagonal block.

Multiplications and additions are fused ("contract"), which rounds once instead of twice.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.small_blocks import invert
from masonry_cd.mechanics.linalg.vectors import add_times, fill_eight, fill_four, load_eight, load_four, store_lanes


@borrower(fastmath={"contract"})
def gemm(x, at, rows, inner, g, begin, end, out):
    """out (rows, end - begin) = x[:, at : at + rows]^T g[:, begin:end]. Most of a factorisation is spent here.

    Sums stay in registers, those of three rows and eight columns at a time.
    """
    threes, zero = rows - rows % 3, g.dtype.type(0.0)
    for j in range(0, threes, 3):
        i = begin
        while i + 8 <= end:
            multiply_lanes(fill_eight, load_eight, x, at + j, inner, g, i, out, j, i - begin)
            i += 8
        if i + 4 <= end:
            multiply_lanes(fill_four, load_four, x, at + j, inner, g, i, out, j, i - begin)
            i += 4
        while i < end:
            a, b, c = zero, zero, zero
            for k in range(inner):
                a, b, c = a + x[k, at + j] * g[k, i], b + x[k, at + j + 1] * g[k, i], c + x[k, at + j + 2] * g[k, i]
            out[j, i - begin], out[j + 1, i - begin], out[j + 2, i - begin] = a, b, c
            i += 1
    for j in range(threes, rows):
        for i in range(begin, end):
            total = zero
            for k in range(inner):
                total += x[k, at + j] * g[k, i]
            out[j, i - begin] = total


@kernel(inline="always")
def multiply_lanes(fill, load, x, at, inner, g, i, out, j, k):
    """Three rows of x^T g, those of columns ``at`` on of x, into rows j on of ``out``: as many columns, from i of g and k of ``out``, as
    ``fill`` and ``load`` take."""
    zero = g.dtype.type(0.0)
    d, e, f = fill(zero), fill(zero), fill(zero)
    for r in range(inner):
        line = load(g, r, i)
        d, e, f = add_times(d, x[r, at], line), add_times(e, x[r, at + 1], line), add_times(f, x[r, at + 2], line)
    store_lanes(out, j, k, d)
    store_lanes(out, j + 1, k, e)
    store_lanes(out, j + 2, k, f)


@borrower(fastmath={"contract"})
def invert_square(a, column, out, work, size_n):
    """Inverse of a square in place, block by block (Gauss & Jordan); the sign of its determinant, 0 when a block cannot be inverted."""
    n, size, sign = len(size_n), len(a), 1.0
    block, inverse = work[0], work[1]
    for b in range(0, size, n):
        for p in range(n):
            for q in range(n):
                block[p, q] = a[b + p, b + q]
        sign *= invert(block, n, inverse, work[2], size_n)
        if sign == 0.0:
            return sign
        for q in range(n):
            for i in range(size):
                column[q, i] = a[i, b + q]
                a[i, b + q] = 0.0
            a[b + q, b + q] = 1.0
            for p in range(n):
                block[q, p] = inverse[p, q]
        gemm(block, 0, n, n, a[b : b + n], 0, size, out)
        for p in range(n):
            for i in range(size):
                a[b + p, i] = out[p, i]
        for i in range(size):
            if not b <= i < b + n:
                subtract_lines(a[i], column, i, out, n, size)
    return sign


@borrower(fastmath={"contract"})
def subtract_lines(to, factors, at, lines, n, length):
    """to -= sum of factors[q, at] times line q, of n lines, three at a time."""
    threes = n - n % 3
    for q in range(0, threes, 3):
        x, y, z, a, b, c = factors[q, at], factors[q + 1, at], factors[q + 2, at], lines[q], lines[q + 1], lines[q + 2]
        for k in range(length):
            to[k] -= x * a[k] + y * b[k] + z * c[k]
    for q in range(threes, n):
        for k in range(length):
            to[k] -= factors[q, at] * lines[q, k]


@borrower(fastmath={"contract"})
def inverse_cholesky(a, out):
    """out = C^-T, upper triangular, of a symmetric a = C C^T, of which the upper triangle is given and used up; False if there is none."""
    size = len(a)
    out[:] = 0.0
    for k in range(size):
        if not (0.0 < a[k, k] < np.inf):
            return False
        out[k, k] = 1.0
        own, line, inverse = a[k], out[k], 1.0 / a[k, k]
        for i in range(k + 1, size):  # rows of the identity below each other: C^-1 but for the lengths of its rows
            factor, other, root = own[i] * inverse, a[i], out[i]
            for j in range(i, size):
                other[j] -= factor * own[j]
            for j in range(k + 1):
                root[j] -= factor * line[j]
    for k in range(size):
        length = 1.0 / np.sqrt(a[k, k])
        for j in range(k + 1):
            out[k, j] *= length
    for k in range(size):
        for j in range(k):
            out[j, k], out[k, j] = out[k, j], 0.0
    return True
