# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors of a sparse matrix of blocks with a symmetric pattern: one value and four verbs.

    pattern = Pattern.of(nodes, first, second)                 # the graph of the blocks, analysed once; see ordering.py
    factor = BlockFactor.set(pattern.symbolic, size_tuple(6))  # room for the matrix A and its factors
    factor.update(diagonal, lower, upper)                      # the blocks of A, where the symbolic factor has them
    sign = factor.factor()                                     # A = L D U; the sign of det A, 0: a block of D has no inverse
    factor.solve(x)                                            # x (N, n) <- A^-1 x, in place

The order is changed from that of the graph to ``pattern.order``, in which nodes are eliminated. A symmetric matrix, ``symmetric=True``, has
no upper blocks; it is factorised as L D L^T, and must be positive definite. Kernels update blocks in place, factorise by a team of threads,
:func:`factorise_ldu` or :func:`factorise_cholesky`, and substitute by subtrees, see triangular.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.linalg.cholesky import factorise_symmetric, to_unit_diagonal
from masonry_cd.mechanics.linalg.ldu import factorise_unsymmetric
from masonry_cd.mechanics.linalg.single_columns import SYMMETRIC, UNSYMMETRIC, factorise_columns
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.supernodes import has_single_columns, longest_line
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import alone, share_of, wait
from masonry_cd.mechanics.linalg.triangular import backward_substitution, forward_substitution, solve_ldu


class BlockFactor(NamedTuple):
    """A matrix A of (n, n) blocks for N nodes in order of elimination, E blocks below the diagonal, and its factors."""

    symbolic: SymbolicFactor
    symmetric: bool
    diagonal: np.ndarray  # (N or more, n, n) A_jj
    lower: np.ndarray  # (E or more, n, n) A_ij below the diagonal
    upper: np.ndarray  # (E, n, n) A_ji^T; of a symmetric matrix (0, n, n)
    squares: np.ndarray  # D^-1, flat
    panels: np.ndarray  # L, flat
    others: np.ndarray  # D U, flat; of a symmetric matrix (0,)
    signs: np.ndarray  # (K,) of the determinants of the subtrees
    size: tuple[int, ...] | np.ndarray  # with n entries, see small_blocks.py

    @classmethod
    def set(cls, symbolic: SymbolicFactor, size: tuple[int, ...] | np.ndarray, symmetric: bool = False) -> BlockFactor:
        """Room for a matrix and its factors."""
        n, edges, upper = len(size), len(symbolic.row), 0 if symmetric else 1
        squares, panels = (n * n * int(starts[-1]) for starts in (symbolic.square, symbolic.panel))
        return cls(
            symbolic, symmetric, np.empty((len(symbolic.column) - 1, n, n)), np.empty((edges, n, n)), np.empty((upper * edges, n, n)),
            np.empty(squares), np.empty(panels), np.empty(upper * panels), np.empty(len(symbolic.subtree) - 1), size,
        )  # fmt: skip

    def update(self, diagonal: np.ndarray, lower: np.ndarray, upper: np.ndarray | None = None) -> None:
        """Take the blocks of A: (N, n, n), (E, n, n) and, unless it is symmetric, (E, n, n)."""
        self.diagonal[:], self.lower[:] = diagonal, lower
        if upper is not None:
            self.upper[:] = upper

    def factor(self) -> float:
        """The sign of det A; 0 where there are no factors: a block of D has no inverse, or a symmetric A is not positive definite."""
        return factorise_alone(self)

    def solve(self, x: np.ndarray) -> None:
        """x (N or more, n) <- A^-1 x, in place."""
        solve_alone(self, x)


@kernel()
def factorise_levels(factorise_subtree, team, factor):
    """Factorise the subtrees level by level, each by one thread; the sign of det A, 0 where one of them has no factors."""
    symbolic, signs, sign = factor.symbolic, factor.signs, 1.0
    for level in range(len(symbolic.level) - 1):
        begin, end = symbolic.level[level], symbolic.level[level + 1]
        first, last = share_of(team, begin, end)
        for q in range(first, last):
            signs[q] = factorise_subtree(factor, q)
        wait(team)
        for q in range(begin, end):
            sign *= signs[q]
        if sign == 0.0:
            break
    return sign


@kernel()
def ldu_of_subtree(factor, q):
    """L D U of the columns of subtree q, after all that update them; the sign of their part of det A."""
    symbolic = factor.symbolic
    if has_single_columns(symbolic):
        return factorise_columns(factor, UNSYMMETRIC)
    return factorise_unsymmetric(factor, symbolic.subtree[q], symbolic.subtree[q + 1])


@kernel()
def cholesky_of_subtree(factor, q):
    """L L^T of the columns of subtree q likewise; single ones are L D L^T, made in double precision and rounded to that of the factor."""
    symbolic = factor.symbolic
    if not has_single_columns(symbolic):
        return factorise_symmetric(factor, symbolic.subtree[q], symbolic.subtree[q + 1])
    squares, panels = np.empty(len(factor.squares)), np.empty(len(factor.panels))
    double = BlockFactor(
        symbolic, True, factor.diagonal, factor.lower, factor.upper, squares, panels, panels, factor.signs, factor.size
    )  # fmt: skip
    sign = factorise_columns(double, SYMMETRIC)
    copy_flat(squares, factor.squares)
    copy_flat(panels, factor.panels)
    return sign


@kernel()
def factorise_ldu(team, factor):
    """A = L D U by a team; the sign of det A, 0 where a block of D has no inverse."""
    return factorise_levels(ldu_of_subtree, team, factor)


@kernel()
def factorise_cholesky(team, factor):
    """A = L D L^T of a symmetric A by a team; 0 where it is not positive definite."""
    symbolic, sign = factor.symbolic, factorise_levels(cholesky_of_subtree, team, factor)
    if sign != 0.0 and not has_single_columns(symbolic):
        begin, end = share_of(team, 0, len(symbolic.subtree) - 1)
        to_unit_diagonal(factor, symbolic.subtree[begin], symbolic.subtree[end])
    wait(team)
    return sign


@entry()
def factorise_alone(factor: BlockFactor) -> float:
    """Factorise A by one thread; the sign of det A, or 0."""
    if factor.symmetric:
        return factorise_cholesky(alone(), factor)
    return factorise_ldu(alone(), factor)


@entry()
def solve_alone(factor: BlockFactor, x: np.ndarray) -> None:
    """x <- A^-1 x, in place, x (N or more, n)."""
    if not factor.symmetric:
        solve_ldu(factor, x)
        return
    symbolic, count = factor.symbolic, len(factor.symbolic.first) - 1
    line = np.empty(longest_line(symbolic, 0, count, len(factor.size)), dtype=factor.panels.dtype)
    forward_substitution(factor, 0, count, symbolic.below, x, line)
    backward_substitution(factor, 0, count, x, line)
