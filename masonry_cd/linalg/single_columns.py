"""Factors whose columns stay alone, for matrices with hardly any fill-in: blocks one after another, all loops over them unrolled."""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import kernel
from masonry_cd.linalg.small_blocks import invert

SYMMETRIC, UNSYMMETRIC = np.bool_(True), np.bool_(False)  # of a matrix; likewise


@kernel(fastmath={"contract"})
def subtract_block_product(c, at, a, i, b, size_n):
    """c[at] -= a[i] b for blocks. For n = 6 a row of c is held in registers."""
    n = len(size_n)
    for p in range(n):
        if n == 6:
            c0, c1, c2, c3, c4, c5 = c[at, p, 0], c[at, p, 1], c[at, p, 2], c[at, p, 3], c[at, p, 4], c[at, p, 5]
            for r in range(6):
                x = a[i, p, r]
                c0 -= x * b[r, 0]
                c1 -= x * b[r, 1]
                c2 -= x * b[r, 2]
                c3 -= x * b[r, 3]
                c4 -= x * b[r, 4]
                c5 -= x * b[r, 5]
            c[at, p, 0], c[at, p, 1], c[at, p, 2], c[at, p, 3], c[at, p, 4], c[at, p, 5] = c0, c1, c2, c3, c4, c5
        else:
            for q in range(n):
                total = c[at, p, q]
                for r in range(n):
                    total -= a[i, p, r] * b[r, q]
                c[at, p, q] = total


@kernel(fastmath={"contract"})
def factorise_columns(plan, diagonal, lower, upper, inverse, low, up, symmetric, size_n):
    """:func:`factorise_ldu` where each run is one node: blocks of L and of U^T one after another, all loops over them unrolled."""
    n, size, first, below = len(size_n), len(plan.column) - 1, plan.start, plan.below
    squares, lows, ups = inverse.reshape((size, n, n)), low.reshape((len(below), n, n)), up.reshape((len(below), n, n))
    head, following, at = np.full(size, -1), np.full(size, -1), np.empty(size, dtype=np.int64)
    where = np.empty(size, dtype=np.int64)
    square, turned, other, work = np.empty((1, n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    lows[:] = 0.0
    if not symmetric:
        ups[:] = 0.0
    for j in range(size):
        for t in range(first[j], first[j + 1]):
            where[below[t]] = t
        for t in range(plan.column[j], plan.column[j + 1]):
            i = where[plan.row[t]]
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
        k = head[j]
        while k >= 0:  # all columns k < j with a block in row j
            coming, t0, end = following[k], at[k], first[k + 1]
            for p in range(n):
                for q in range(n):
                    total = 0.0
                    for r in range(n):
                        total += squares[k, q, r] * (lows[t0, p, r] if symmetric else ups[t0, p, r])
                    turned[q, p] = total
            subtract_block_product(square, 0, lows, t0, turned, size_n)
            for t in range(t0 + 1, end):
                subtract_block_product(lows, where[below[t]], lows, t, turned, size_n)
            if symmetric:
                for p in range(n):
                    for q in range(n):
                        lows[t0, p, q] = turned[q, p]
            else:
                for p in range(n):
                    for q in range(n):
                        total = 0.0
                        for r in range(n):
                            total += lows[t0, p, r] * squares[k, r, q]
                        other[q, p] = total
                for t in range(t0 + 1, end):
                    subtract_block_product(ups, where[below[t]], ups, t, other, size_n)
                for p in range(n):
                    for q in range(n):
                        lows[t0, p, q], ups[t0, p, q] = other[q, p], turned[q, p]
            if t0 + 1 < end:
                at[k], following[k] = t0 + 1, head[below[t0 + 1]]
                head[below[t0 + 1]] = k
            k = coming
        if not invert(square[0], squares[j], work, size_n):
            return False
        if first[j] < first[j + 1]:
            at[j], following[j] = first[j], head[below[first[j]]]
            head[below[first[j]]] = j
    return True


@kernel(fastmath={"contract"})
def forward_columns(plan, low, x, size_n):
    """:func:`forward_substitution` where each run is one node."""
    n, below = len(size_n), plan.below
    lows = low.reshape((len(below), n, n))
    for j in range(len(plan.column) - 1):
        for t in range(plan.start[j], plan.start[j + 1]):
            i = below[t]
            for p in range(n):
                total = x[i, p]
                for q in range(n):
                    total -= lows[t, p, q] * x[j, q]
                x[i, p] = total


@kernel(fastmath={"contract"})
def backward_columns(plan, inverse, up, x, size_n):
    """:func:`backward_substitution` where each run is one node."""
    n, below, size = len(size_n), plan.below, len(plan.column) - 1
    squares, ups, y = inverse.reshape((size, n, n)), up.reshape((len(below), n, n)), np.empty(n, dtype=up.dtype)
    for j in range(size):
        for p in range(n):
            total = up.dtype.type(0.0)
            for q in range(n):
                total += squares[j, p, q] * x[j, q]
            y[p] = total
        for p in range(n):
            x[j, p] = y[p]
    for j in range(size - 1, -1, -1):
        for t in range(plan.start[j], plan.start[j + 1]):
            i = below[t]
            for q in range(n):
                total = x[j, q]
                for p in range(n):
                    total -= ups[t, p, q] * x[i, p]
                x[j, q] = total
