"""Dense kernels of a supernode: products, and the inverse or the inverse Cholesky factor of a diagonal block.

Multiplications and additions are fused ("contract"), which rounds once instead of twice.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import borrower
from masonry_cd.linalg.small_blocks import invert


@borrower(fastmath={"contract"})
def gemm(x, at, rows, inner, g, begin, end, out):
    """out (rows, end - begin) = x[:, at : at + rows]^T g[:, begin:end]. Most of a factorisation is spent here: three rows at a time."""
    length, threes, full = end - begin, inner - inner % 3, rows - rows % 3
    for j in range(0, full, 3):
        a, b, c = out[j, :length], out[j + 1, :length], out[j + 2, :length]
        a[:], b[:], c[:] = 0.0, 0.0, 0.0
        for k in range(0, threes, 3):
            x0, x1, x2 = x[k, at + j], x[k + 1, at + j], x[k + 2, at + j]
            y0, y1, y2 = x[k, at + j + 1], x[k + 1, at + j + 1], x[k + 2, at + j + 1]
            z0, z1, z2 = x[k, at + j + 2], x[k + 1, at + j + 2], x[k + 2, at + j + 2]
            g0, g1, g2 = g[k, begin:end], g[k + 1, begin:end], g[k + 2, begin:end]
            for i in range(length):
                h0, h1, h2 = g0[i], g1[i], g2[i]
                a[i] += x0 * h0 + x1 * h1 + x2 * h2
                b[i] += y0 * h0 + y1 * h1 + y2 * h2
                c[i] += z0 * h0 + z1 * h1 + z2 * h2
        for k in range(threes, inner):
            for i in range(length):
                a[i] += x[k, at + j] * g[k, begin + i]
                b[i] += x[k, at + j + 1] * g[k, begin + i]
                c[i] += x[k, at + j + 2] * g[k, begin + i]
    for j in range(full, rows):
        out[j, :length] = 0.0
        for k in range(inner):
            for i in range(length):
                out[j, i] += x[k, at + j] * g[k, begin + i]


@borrower(fastmath={"contract"})
def invert_square(a, column, out, work, size_n):
    """Inverse of a square in place, block by block (Gauss & Jordan); the sign of its determinant, 0 when a block cannot be inverted."""
    n, size, sign = len(size_n), len(a), 1.0
    block, inverse = work[0], work[1]
    for b in range(0, size, n):
        for p in range(n):
            for q in range(n):
                block[p, q] = a[b + p, b + q]
        sign *= invert(block, inverse, work[2], size_n)
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
