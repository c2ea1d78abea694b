# SPDX-License-Identifier: GPL-3.0-or-later
"""Forward and backward substitution with the factors of ldu.py and cholesky.py.

Sums are taken in the order that the processor likes ("reassoc"); equal inputs still give equal bits on one machine.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.linalg.single_columns import SYMMETRIC, UNSYMMETRIC, backward_columns, forward_columns
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.supernodes import Factor, gather_rows, has_single_columns, longest_line, subtract_rows
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor


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


@entry()
def solve_ldu(factor: Factor, x: np.ndarray) -> None:
    """Solve L D U x = x in place, x (N or more, n)."""
    symbolic, size, low, up = factor.symbolic, factor.size, factor.panels, factor.others
    if has_single_columns(symbolic):
        forward_columns(symbolic, low, x, size)
        backward_columns(symbolic, factor.squares, up, x, np.empty(len(size)), UNSYMMETRIC, size)
        return
    n, count = len(size), len(symbolic.first) - 1
    longest, blocks, flat = longest_line(symbolic, 0, count, n), n * n, x.reshape(x.size)
    y, z = np.empty(longest), np.empty(longest)
    for s in range(count):
        own, length = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]], n * (symbolic.start[s + 1] - symbolic.start[s])
        add_columns(low, symbolic.panel[s] * blocks, length, own, y, size)
        subtract_rows(symbolic, s, symbolic.below, y, x, n)
    for s in range(count - 1, -1, -1):
        own, length = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]], n * (symbolic.start[s + 1] - symbolic.start[s])
        gather_rows(symbolic, s, x, y, n)
        add_rows(up, symbolic.panel[s] * blocks, length, y, -1.0, own, size)
        copy_flat(own, z)
        own[:] = 0.0
        add_rows(factor.squares, symbolic.square[s] * blocks, len(own), z, 1.0, own, size)


@borrower()
def forward_substitution(symbolic, first, last, row, panels, x, line, size_n):
    """x <- L^-1 x of a symmetric matrix for supernodes first to last; ``row`` (R,) as in :func:`subtract_rows`.

    ``line`` is room of the type of the panels for :func:`longest_line` entries.
    """
    if has_single_columns(symbolic):
        forward_columns(symbolic, panels, x, size_n)
        return
    n, blocks, flat = len(size_n), len(size_n) * len(size_n), x.reshape(x.size)
    for s in range(first, last):
        own, length = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]], n * (symbolic.start[s + 1] - symbolic.start[s])
        add_columns(panels, symbolic.panel[s] * blocks, length, own, line, size_n)
        subtract_rows(symbolic, s, row, line, x, n)


@borrower()
def backward_substitution(symbolic, first, last, squares, panels, x, line, size_n):
    """x <- L^-T D^-1 x of a symmetric matrix for supernodes first to last, after all later ones; ``line`` as for the forward one."""
    if has_single_columns(symbolic):
        backward_columns(symbolic, squares, panels, x, line, SYMMETRIC, size_n)
        return
    n, blocks, flat = len(size_n), len(size_n) * len(size_n), x.reshape(x.size)
    for s in range(last - 1, first - 1, -1):
        own, length = flat[n * symbolic.first[s] : n * symbolic.first[s + 1]], n * (symbolic.start[s + 1] - symbolic.start[s])
        copy_flat(own, line[: len(own)])
        own[:] = 0.0
        add_rows(squares, symbolic.square[s] * blocks, len(own), line, 1.0, own, size_n)
        gather_rows(symbolic, s, x, line, n)
        add_rows(panels, symbolic.panel[s] * blocks, length, line, -1.0, own, size_n)


@entry()
def solve_cholesky(symbolic: SymbolicFactor, squares: np.ndarray, panels: np.ndarray, x: np.ndarray, size_n: tuple[int, ...]) -> None:
    """Solve A x = x in place for the factors of a symmetric A, x (N or more, n)."""
    count = len(symbolic.first) - 1
    line = np.empty(longest_line(symbolic, 0, count, len(size_n)), dtype=panels.dtype)
    forward_substitution(symbolic, 0, count, symbolic.below, panels, x, line, size_n)
    backward_substitution(symbolic, 0, count, squares, panels, x, line, size_n)
