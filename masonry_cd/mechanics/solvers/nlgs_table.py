"""What sweeps of Gauss-Seidel work on: the problem scaled by mass, and a table with a row for each contact; see nlgs.py for the method.

With M^-1 = L L^T and G = H L one array of rows serves both ways: u = q + G y and y = G^T p. The columns of the table are those of
``coulomb_law``: 1 / W_nn, the coupling w / W_nn (2), the Schur complement (3), W_nn, d, the start of the slip equation, mu, and
then q (3), p (3) and the compliance (3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import COUPLING, INVERSE_NN, MU, NN, ROW, SCALE, SCHUR, C, P, Q, prepare_law
from masonry_cd.mechanics.friction.natural_map import squared_residual
from masonry_cd.mechanics.linalg.small_blocks import cholesky_small


class ScaledProblem(NamedTuple):
    """A friction problem scaled by mass, with its impulses in the table; supports are a last body whose rows of G are zero."""

    factor: np.ndarray  # (B, n, n) L
    jacobian: np.ndarray  # (C, 2, m, n) G
    bodies: np.ndarray  # (C, 2) of each contact
    table: np.ndarray  # (C, ROW)
    y: np.ndarray  # (B + 1, n) G^T p


@kernel(inline="always")
def scale_rows(jacobian, factor, side, c, body, m, n, scaled):
    """scaled[c, side] = H L for one contact and side, L lower triangular."""
    for i in range(m):
        for j in range(n):
            total = 0.0
            for k in range(j, n):
                total += jacobian[c, side, i, k] * factor[body, k, j]
            scaled[c, side, i, j] = total


@kernel()
def scale_by_mass(inverse_mass, v_free, bodies, jacobian, offset):
    """L (B, n, n), G (C, 2, m, n), q = H v_free + b (C, m), and the bodies (C, 2) with the supports as a last one."""
    contacts, m = offset.shape
    free, n = v_free.shape
    factor = np.empty((free, n, n))
    for b in range(free):
        cholesky_small(inverse_mass[b], factor[b], n)
    g = np.zeros(jacobian.shape)
    q = offset.copy()
    index = np.empty((contacts, 2), dtype=np.int64)
    for c in range(contacts):
        for side in range(2):
            body = bodies[c, side]
            index[c, side] = body if body >= 0 else free
            if body < 0:
                continue
            if m == 3 and n == 6:
                scale_rows(jacobian, factor, side, c, body, 3, 6, g)
            else:
                scale_rows(jacobian, factor, side, c, body, m, n, g)
            for i in range(m):
                for k in range(n):
                    q[c, i] += jacobian[c, side, i, k] * v_free[body, k]
    return factor, g, q, index


@kernel()
def contact_table(g, q, index, mu, compliance, p):
    """The table (C, ROW): q, p, and the laws, from W_cc + C_cc, W_cc = sum over sides of G G^T (both sides on one body add up)."""
    contacts, _, m, n = g.shape
    law = np.zeros((contacts, ROW))
    w = np.zeros((3, 3))
    for c in range(contacts):
        cross = index[c, 0] == index[c, 1]
        for i in range(m):
            for j in range(m):
                total = 0.0
                for k in range(n):
                    total += g[c, 0, i, k] * g[c, 0, j, k] + g[c, 1, i, k] * g[c, 1, j, k]
                    if cross:
                        total += g[c, 0, i, k] * g[c, 1, j, k] + g[c, 1, i, k] * g[c, 0, j, k]
                w[i, j] = total
            if len(compliance):
                w[i, i] += compliance[c, i]
        prepare_law(w, m, mu[c], law, c)
        for i in range(m):
            law[c, Q + i], law[c, P + i] = q[c, i], p[c, i]
            if len(compliance):
                law[c, C + i] = compliance[c, i]
    return law


@kernel()
def scaled_problem(given, p):
    """The :class:`ScaledProblem` of ProblemArrays and impulses p (C, m); y is not yet set."""
    factor, g, q, index = scale_by_mass(given.inverse_mass, given.v_free, given.bodies, given.jacobian, given.offset)
    y = np.empty((len(given.v_free) + 1, len(given.n)))
    return ScaledProblem(factor, g, index, contact_table(g, q, index, given.mu, given.compliance, p), y)


@kernel(inline="always")
def law_of(law, c):
    """1 / W_nn, w / W_nn (2), the Schur complement (3), and W_nn of contact c, from its row of a table."""
    return (
        law[c, INVERSE_NN], law[c, COUPLING], law[c, COUPLING + 1], law[c, SCHUR], law[c, SCHUR + 1], law[c, SCHUR + 2], law[c, NN]
    )  # fmt: skip


@borrower()
def collect(g, index, p, y):
    """y = G^T p from scratch, which also clears the rounding of many sweeps."""
    contacts, _, m, n = g.shape
    y[:] = 0.0
    for c in range(contacts):
        for side in range(2):
            body = index[c, side]
            for i in range(m):
                for k in range(n):
                    y[body, k] += g[c, side, i, k] * p[c, i]


@kernel()
def squared_residuals_of(g, y, index, law, first, end):
    """Squares of the norms of the natural map residual and of q / sqrt(d) over the contacts first to end, whose y = G^T p is given."""
    m, n = g.shape[2], g.shape[3]
    residual, size = 0.0, 0.0
    w = np.zeros(3)
    for c in range(first, end):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            size += law[c, Q + i] * law[c, Q + i] / law[c, SCALE]
            w[i] = law[c, Q + i] + law[c, C + i] * law[c, P + i]
            for k in range(n):
                w[i] += g[c, 0, i, k] * y[a, k] + g[c, 1, i, k] * y[b, k]
        residual += squared_residual(law[c, P], law[c, P + 1], law[c, P + 2], w[0], w[1], w[2], law[c, MU], law[c, SCALE])
    return residual, size


@kernel(inline="always")
def error_of(residual, size):
    """The natural map error by the squares of both norms."""
    return np.sqrt(residual / size) if size > 0.0 else np.sqrt(residual)


@kernel()
def measure_error(scaled):
    """Set y = G^T p of a ScaledProblem anew; returns the natural map error of its impulses."""
    collect(scaled.jacobian, scaled.bodies, scaled.table[:, P : P + scaled.jacobian.shape[2]], scaled.y)
    residual, size = squared_residuals_of(scaled.jacobian, scaled.y, scaled.bodies, scaled.table, 0, len(scaled.table))
    return error_of(residual, size)


@borrower()
def read_answer(scaled, v_free, p, v):
    """Copy the impulses from the table into p (C, m), and v = v_free + L y into v (B, n)."""
    for c in range(len(p)):
        for i in range(p.shape[1]):
            p[c, i] = scaled.table[c, P + i]
    factor, y = scaled.factor, scaled.y
    for body in range(v.shape[0]):
        for i in range(v.shape[1]):
            total = v_free[body, i]
            for k in range(i + 1):
                total += factor[body, i, k] * y[body, k]
            v[body, i] = total
