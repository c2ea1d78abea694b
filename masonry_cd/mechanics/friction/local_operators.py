"""The operators of a friction problem given by W alone: u = W p + q by sparse blocks (CSR, one (m, m) block per entry), and its natural
map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import SCALE
from masonry_cd.mechanics.friction.natural_map import squared_residual
from masonry_cd.mechanics.linalg.cholesky import factorise_cholesky
from masonry_cd.mechanics.linalg.single_columns import SYMMETRIC
from masonry_cd.mechanics.linalg.small_blocks import identities, multiply
from masonry_cd.mechanics.linalg.supernodes import BlockMatrix, allocate_factors, view_supernode
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor


class LocalArrays(NamedTuple):
    """A LocalProblem as the kernels take it: C contacts with m rows each."""

    data: np.ndarray  # (nnz, m, m) blocks of W
    indices: np.ndarray  # (nnz,) contacts by which the blocks of a row are multiplied
    indptr: np.ndarray  # (C + 1,) starts of the rows
    q: np.ndarray  # (C, m)
    mu: np.ndarray  # (C,)
    compliance: np.ndarray  # (0, m): that of the contacts is part of W
    d: np.ndarray  # (C,) trace(W_cc) / m
    place: np.ndarray  # (C,) place of each contact in the order of elimination
    m: tuple[int, ...]  # m zeros, see small_blocks.py


@kernel(inline="always")
def row_velocity(data, indices, indptr, q, p, c, i):
    """One component of u = W p + q."""
    total = q[c, i]
    for k in range(indptr[c], indptr[c + 1]):
        j = indices[k]
        for l in range(p.shape[1]):  # noqa: E741
            total += data[k, i, l] * p[j, l]
    return total


@borrower()
def local_residual(data, indices, indptr, q, mu, p, law):
    """Natural map error of p for a local problem."""
    contacts, m = p.shape
    residual, size = 0.0, 0.0
    for c in range(contacts):
        un = row_velocity(data, indices, indptr, q, p, c, 0)
        u1 = row_velocity(data, indices, indptr, q, p, c, 1)
        u2 = row_velocity(data, indices, indptr, q, p, c, 2) if m == 3 else 0.0
        residual += squared_residual(p[c, 0], p[c, 1], p[c, 2] if m == 3 else 0.0, un, u1, u2, mu[c], law[c, SCALE])
        for i in range(m):
            size += q[c, i] * q[c, i] / law[c, SCALE]
    return np.sqrt(residual / size) if size > 0.0 else np.sqrt(residual)


@borrower()
def delassus_product(problem, p, out):
    """out = W p (C, m)."""
    data, indices, indptr, m = problem.data, problem.indices, problem.indptr, len(problem.m)
    for c in range(len(p)):
        for i in range(m):
            total = 0.0
            for k in range(indptr[c], indptr[c + 1]):
                for l in range(m):  # noqa: E741
                    total += data[k, i, l] * p[indices[k], l]
            out[c, i] = total


@borrower()
def local_velocity(problem, p, u):
    """u = W p + q (C, m)."""
    delassus_product(problem, p, u)
    for c in range(len(p)):
        for i in range(len(problem.m)):
            u[c, i] += problem.q[c, i]


@borrower()
def squared_residuals(problem, p, u):
    """Sum of the squared natural map residuals of impulses p and velocities u, (C, m)."""
    total, m = 0.0, len(problem.m)
    for c in range(len(p)):
        p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
        total += squared_residual(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, problem.mu[c], problem.d[c])
    return total


@borrower()
def local_norm(problem, p, u):
    """Norm of the natural map residual for impulses p (C, m) and their velocities u = W p + q (C, m), which it fills."""
    local_velocity(problem, p, u)
    return np.sqrt(squared_residuals(problem, p, u))


@kernel()
def block_at(column: np.ndarray, row: np.ndarray, low: int, high: int) -> int:
    """Index of block (high, low) below the diagonal."""
    return column[low] + np.searchsorted(row[column[low] : column[low + 1]], high)


@kernel()
def place_blocks(problem, scale, symbolic, symmetric, matrix):
    """The BlockMatrix of S W, S one block per contact, the first rows of ``scale`` (C, m or more, m); or of the symmetric part of S W."""
    data, indices, indptr, place, m = problem.data, problem.indices, problem.indptr, problem.place, len(problem.m)
    diagonal, lower, upper = matrix.diagonal, matrix.lower, matrix.upper
    diagonal[:] = 0.0
    lower[:] = 0.0
    upper[:] = 0.0
    block = np.empty((m, m))
    for c in range(len(place)):
        for k in range(indptr[c], indptr[c + 1]):
            i, j = place[c], place[indices[k]]
            multiply(scale[c], data[k], False, block, problem.m)
            at = 0 if i == j else block_at(symbolic.column, symbolic.row, min(i, j), max(i, j))
            for r in range(m):
                for s in range(m):
                    if i == j:
                        diagonal[i, r, s] += 0.5 * (block[r, s] + block[s, r]) if symmetric else block[r, s]
                    elif symmetric:
                        lower[at, r, s] += 0.5 * (block[r, s] if i > j else block[s, r])
                    elif i > j:
                        lower[at, r, s] += block[r, s]
                    else:
                        upper[at, s, r] += block[r, s]


@kernel()
def has_positive_pivots(square):
    """Whether a symmetric matrix is positive definite, by elimination, which uses it up."""
    width = len(square)
    for k in range(width):
        if not square[k, k] > 0.0:
            return False
        for i in range(k + 1, width):
            share = square[i, k] / square[k, k]
            for j in range(k + 1, width):
                square[i, j] -= share * square[k, j]
    return True


@entry()
def is_definite(
    data: np.ndarray,
    indices: np.ndarray,
    indptr: np.ndarray,
    shift: float,
    place: np.ndarray,
    symbolic: SymbolicFactor,
    size_m: tuple[int, ...],
) -> bool:
    """Whether the symmetric part of W, with shift added to its diagonal, is positive definite: all squares of D are (Sylvester)."""
    count, m = len(place), len(size_m)
    problem = LocalArrays(data, indices, indptr, np.empty((0, m)), np.empty(0), np.empty((0, m)), np.empty(0), place, size_m)
    lower = np.empty((len(symbolic.row), m, m))
    matrix, factor = BlockMatrix(np.empty((count, m, m)), lower, lower), allocate_factors(symbolic, size_m)
    place_blocks(problem, identities(count, size_m), symbolic, SYMMETRIC, matrix)
    for i in range(count):
        for r in range(m):
            matrix.diagonal[i, r, r] += shift
    if not factorise_cholesky(symbolic, matrix.diagonal, lower, factor.squares, factor.panels, size_m):
        return False
    for s in range(len(symbolic.first) - 1):
        square, _, _ = view_supernode(factor, s)
        if not has_positive_pivots(square.copy()):
            return False
    return True
