# SPDX-License-Identifier: GPL-3.0-or-later
"""What sweeps of Gauss-Seidel work on: the problem scaled by mass, and a table with a row for each contact; see nlgs.py for the method.

With M^-1 = L L^T and G = H L one array of rows serves both ways: u = q + G y and y = G^T p. The columns of the table are those of
``coulomb_law``: 1 / W_nn, the coupling w / W_nn (2), the Schur complement (3), W_nn, d, the start of the slip equation, mu, and
then q (3), p (3) and the compliance (3). A problem given by W alone has its coupling in the place of G^T, y = L^T (coupling) p, and sweeps
read W p from its rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.body_sides import add_impulse
from masonry_cd.mechanics.friction.coulomb_law import COUPLING, INVERSE_NN, NN, ROW, SCALE, SCHUR, C, P, Q, prepare_law
from masonry_cd.mechanics.friction.coupling import is_coupled
from masonry_cd.mechanics.friction.joint_twists import NUMBERS
from masonry_cd.mechanics.friction.natural_map import error_of
from masonry_cd.mechanics.friction.operators import OrderedProblem, squared_map_norm_of
from masonry_cd.mechanics.linalg.small_blocks import cholesky_small


class ScaledProblem(NamedTuple):
    """A friction problem scaled by mass, with its impulses in the table."""

    factor: np.ndarray  # (B, n, n) L
    problem: OrderedProblem  # with G for H and q for b; supports are a last body whose rows of G are zero
    table: np.ndarray  # (C, ROW)
    y: np.ndarray  # (B + 1, n) G^T p
    size: float  # square of |q / sqrt(d)|, by which errors are divided


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
def contact_table(given, g, q, index, p):
    """The table (C, ROW): q, p, and the laws, from W_cc + C_cc, W_cc = sum over sides of G G^T (both sides on one body add up)."""
    contacts, _, m, n = g.shape
    law, compliance = np.zeros((contacts, ROW)), given.compliance
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
        if is_coupled(given):
            read_own_block(given, c, w)
        prepare_law(w, m, given.mu[c], law, c)
        for i in range(m):
            law[c, Q + i], law[c, P + i] = q[c, i], p[c, i]
            if len(compliance):
                law[c, C + i] = compliance[c, i]
    return law


@borrower()
def read_own_block(given, c, w):
    """W_cc of a problem given by W alone in the place of w, d I, which stays where W_cc is zero: whatever it is, the impulse stays."""
    data, indices, indptr, m, d = given.coupling.data, given.coupling.indices, given.coupling.indptr, len(given.m), w[0, 0]
    for k in range(indptr[c], indptr[c + 1]):
        trace = 0.0
        for i in range(m):
            trace += data[k, i, i]
        if indices[k] == c and trace > 0.5 * m:  # of what is divided by d
            for i in range(m):
                for j in range(m):
                    w[i, j] = d * data[k, i, j]


@kernel()
def scaled_problem(given, p):
    """The :class:`ScaledProblem` of ProblemArrays and impulses p (C, m); y is not yet set."""
    factor, g, q, index = scale_by_mass(given.inverse_mass, given.v_free, given.bodies, given.jacobian, given.offset)
    n, table, size, nothing = len(given.n), contact_table(given, g, q, index, p), 0.0, np.empty(0, dtype=np.int64)
    y = np.zeros((len(given.v_free) + 1, n))
    for c in range(len(table)):
        for i in range(len(given.m)):
            size += q[c, i] * q[c, i] / table[c, SCALE]
    problem = OrderedProblem(
        given.inverse_mass, np.empty((0, n, n)), given.v_free, index, nothing, g, np.empty((0, NUMBERS)), q, given.mu, given.compliance,
        nothing, table[:, SCALE].copy(), given.coupling, given.m, given.n,
    )  # fmt: skip
    return ScaledProblem(factor, problem, table, y, size)


@kernel(inline="always")
def law_of(law, c):
    """1 / W_nn, w / W_nn (2), the Schur complement (3), and W_nn of contact c, from its row of a table."""
    return (
        law[c, INVERSE_NN], law[c, COUPLING], law[c, COUPLING + 1], law[c, SCHUR], law[c, SCHUR + 1], law[c, SCHUR + 2], law[c, NN]
    )  # fmt: skip


@kernel()
def collect(scaled, first, end):
    """y = G^T p of the bodies first to end, from scratch, which also clears the rounding of many sweeps."""
    scaled.y[first:end] = 0.0
    add_impulse(scaled.problem, impulses_of(scaled), first, end, scaled.y)
    if is_coupled(scaled.problem):
        for b in range(first, end):
            for i in range(scaled.y.shape[1]):
                scaled.y[b, i] *= scaled.factor[b, i, i]


@kernel(inline="always")
def impulses_of(scaled):
    """The impulses (C, m) in the table."""
    return scaled.table[:, P : P + len(scaled.problem.m)]


@kernel()
def squared_residuals_of(scaled, first, end):
    """Square of the norm of the natural map residual of the contacts first to end, whose y is given."""
    return squared_map_norm_of(scaled.problem, impulses_of(scaled), scaled.y, first, end)


@kernel()
def measure_error(scaled):
    """Set y of a ScaledProblem anew; returns the natural map error of its impulses."""
    collect(scaled, 0, len(scaled.factor))
    return error_of(squared_residuals_of(scaled, 0, len(scaled.table)), scaled.size)


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
