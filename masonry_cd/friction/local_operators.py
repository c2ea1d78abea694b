"""The operators of a friction problem given by W alone: u = W p + q by sparse blocks (CSR, one (m, m) block per entry), and its natural
map."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.coulomb_law import SCALE
from masonry_cd.friction.natural_map import squared_residual
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.cholesky import factorise_cholesky
from masonry_cd.linalg.single_columns import SYMMETRIC
from masonry_cd.linalg.small_blocks import identities, multiply
from masonry_cd.linalg.supernodes import allocate_factors, view_block


@kernel(inline="always")
def row_velocity(data, indices, indptr, q, p, c, i):
    """One component of u = W p + q."""
    total = q[c, i]
    for k in range(indptr[c], indptr[c + 1]):
        j = indices[k]
        for l in range(p.shape[1]):  # noqa: E741
            total += data[k, i, l] * p[j, l]
    return total


@kernel()
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


@kernel()
def delassus_product(data, indices, indptr, p, out, size_m):
    """out = W p."""
    m = len(size_m)
    for c in range(len(p)):
        for i in range(m):
            total = 0.0
            for k in range(indptr[c], indptr[c + 1]):
                for l in range(m):  # noqa: E741
                    total += data[k, i, l] * p[indices[k], l]
            out[c, i] = total


@kernel()
def local_norm(data, indices, indptr, q, mu, d, p, u, size_m):
    """u = W p + q, and the norm of the natural map residual."""
    m, total = len(size_m), 0.0
    delassus_product(data, indices, indptr, p, u, size_m)
    for c in range(len(p)):
        for i in range(m):
            u[c, i] += q[c, i]
        total += squared_residual(p[c, 0], p[c, 1], p[c, 2] if m == 3 else 0.0, u[c, 0], u[c, 1], u[c, 2] if m == 3 else 0.0, mu[c], d[c])
    return np.sqrt(total)


@kernel()
def block_at(column: np.ndarray, row: np.ndarray, low: int, high: int) -> int:
    """Index of block (high, low) below the diagonal."""
    return column[low] + np.searchsorted(row[column[low] : column[low + 1]], high)


@kernel()
def place_blocks(data, indices, indptr, scale, place, plan, symmetric, diagonal, lower, upper, size_m):
    """Diagonal, lower and transposed upper blocks of S W, S one block per contact; or the symmetric part of W into lower alone."""
    m = len(size_m)
    diagonal[:] = 0.0
    lower[:] = 0.0
    upper[:] = 0.0
    block = np.empty((m, m))
    for c in range(len(place)):
        for k in range(indptr[c], indptr[c + 1]):
            i, j = place[c], place[indices[k]]
            multiply(scale[c], data[k], False, block, size_m)
            at = 0 if i == j else block_at(plan.column, plan.row, min(i, j), max(i, j))
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


@entry()
def is_definite(data, indices, indptr, shift, place, plan, size_m):
    """Whether the symmetric part of W, with shift added to its diagonal, is positive definite: all squares of D are (Sylvester)."""
    count, m = len(place), len(size_m)
    diagonal, lower = np.empty((count, m, m)), np.empty((len(plan.row), m, m))
    squares, panels, _ = allocate_factors(plan, size_m)
    place_blocks(data, indices, indptr, identities(count, size_m), place, plan, SYMMETRIC, diagonal, lower, lower, size_m)
    for i in range(count):
        for r in range(m):
            diagonal[i, r, r] += shift
    if not factorise_cholesky(plan, diagonal, lower, squares, panels, size_m):
        return False
    for s in range(len(plan.first) - 1):
        width = m * (plan.first[s + 1] - plan.first[s])
        left = view_block(squares, plan.square[s], width, width, m).copy()
        for k in range(width):
            if not left[k, k] > 0.0:
                return False
            for i in range(k + 1, width):
                factor = left[i, k] / left[k, k]
                for j in range(k + 1, width):
                    left[i, j] -= factor * left[k, j]
    return True
