# SPDX-License-Identifier: GPL-3.0-or-later
"""G of a problem given by W alone, by sparse blocks: its products with impulses, and what it adds to the matrices of the solvers.

Over bodies M (v - v_free) = G p with G = H^T. Where W alone is given each contact has a body that moves as the contact does: H = I, and
with M = D^-1, the d of the contacts on its diagonal, G = D^-1 W. Then W = H M^-1 G as over bodies, whatever its rank, and the solvers need
not know which of the two a problem is: those that linearise the law factorise M + G B H = D^-1 (I + W B), and ADMM the symmetric matrix

    W + R^-1 = D (M + G R H) R^-1,

the symmetric part of W if it is slightly unsymmetric, as published ones are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import qdldl
from scipy import sparse

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.small_blocks import FULL, multiply
from masonry_cd.mechanics.linalg.symbolic import block_at


class Coupling(NamedTuple):
    """D^-1 W block by block in compressed rows; all of it empty over bodies."""

    data: np.ndarray  # (nnz, m, m)
    indices: np.ndarray  # (nnz,) rows of impulses by which the blocks are multiplied
    indptr: np.ndarray  # (C + 1,) starts of the rows, one for each contact and its body; (0,)


UNCOUPLED = {m: Coupling(np.empty((0, m, m)), FULL, FULL) for m in (2, 3)}  # over bodies


def pattern_of(count: int, bodies: np.ndarray, coupling: Coupling, kept: np.ndarray | None = None) -> Pattern:
    """The pattern of the matrices of a problem of some bodies, and those of its contacts (C, 2); with the pairs ``kept`` of another."""
    if len(coupling.indptr):
        return Pattern.of(count, np.repeat(np.arange(count), np.diff(coupling.indptr)), coupling.indices, kept, in_subtrees=False)
    return Pattern.of(count, bodies[:, 0], bodies[:, 1], kept)


@kernel()
def in_places(coupling, order):
    """The coupling by whose indices impulses are found at the places of an order (N,)."""
    place, indices = np.empty(len(order), dtype=np.int64), np.empty(len(coupling.indices), dtype=np.int64)
    for k in range(len(order)):
        place[order[k]] = k
    for k in range(len(indices)):
        indices[k] = place[coupling.indices[k]]
    return Coupling(coupling.data, indices, coupling.indptr)


@borrower(forceinline=True)
def is_coupled(problem):
    """Return True if the problem is given by W alone."""
    return len(problem.coupling.indptr) > 0


@borrower(fastmath={"contract"})
def add_coupled(problem, p, begin, stop, out):
    """out += G p of the bodies at the places from begin to stop, for impulses p (C, m)."""
    (data, indices, indptr), m = problem.coupling, len(problem.m)
    for c in range(len(problem.places)):
        b = problem.places[c, 0]
        if begin <= b < stop:
            for k in range(indptr[c], indptr[c + 1]):
                for i in range(m):
                    for j in range(m):
                        out[b, i] += data[k, i, j] * p[indices[k], j]


@kernel()
def add_coupled_blocks(problem, blocks, share, factor):
    """Add G B to the columns of a share (first, end) of the matrix of a factor, B one block a contact, the first rows of ``blocks``."""
    (begin, stop), out, (data, indices, indptr) = share, np.empty((len(problem.m), len(problem.m))), problem.coupling
    symbolic, diagonal, lower, upper = factor.symbolic, factor.diagonal, factor.lower, factor.upper
    for c in range(len(problem.places)):
        for k in range(indptr[c], indptr[c + 1]):
            i, j = problem.places[c, 0], problem.places[indices[k], 0]
            if begin <= min(i, j) < stop:
                multiply(data[k], blocks[indices[k]], out, problem.m)
                at = block_at(symbolic.column, symbolic.row, min(i, j), max(i, j)) if i != j else 0
                for p in range(len(out)):
                    for q in range(len(out)):
                        if i == j:
                            diagonal[i, p, q] += out[p, q]
                        elif i > j:
                            lower[at, p, q] += out[p, q]
                        else:
                            upper[at, q, p] += out[p, q]


@borrower()
def add_symmetric_blocks(coupling, places, scale, share, factor):
    """Add the symmetric part of W to the matrix of a factor, W = ``scale`` (C,) times the coupling, in the columns (first, end) of a share.

    Of the contacts there are the places (C, 1 or more); scale and the indices of the coupling refer to these.
    """
    (data, indices, indptr), symbolic, diagonal, lower = coupling, factor.symbolic, factor.diagonal, factor.lower
    for c in range(len(places)):
        for k in range(indptr[c], indptr[c + 1]):
            i, j, n = places[c, 0], indices[k], data.shape[1]
            if not share[0] <= min(i, j) < share[1]:
                continue
            at = block_at(symbolic.column, symbolic.row, min(i, j), max(i, j)) if i != j else 0
            for p in range(n):
                for q in range(n):
                    half = 0.5 * scale[i] * data[k, p, q]
                    if i == j:
                        diagonal[i, p, q] += half
                        diagonal[i, q, p] += half
                    elif i > j:
                        lower[at, p, q] += half
                    else:
                        lower[at, q, p] += half


def is_definite(w: sparse.csr_matrix, shift: float) -> bool:
    """True if the symmetric part of W, with ``shift`` added to its diagonal, is positive definite: all of D in L D L^T is (Sylvester)."""
    shifted = 0.5 * (w + w.T) + shift * sparse.identity(w.shape[0])
    try:
        _, pivots, _ = qdldl.Solver(sparse.triu(shifted, format="csc"), upper=True).factors()
    except RuntimeError:  # a pivot is zero
        return False
    return bool((pivots > 0.0).all())
