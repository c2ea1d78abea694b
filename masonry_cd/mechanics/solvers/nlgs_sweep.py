# SPDX-License-Identifier: GPL-3.0-or-later
"""A sweep of Gauss-Seidel, and what it works on: the problem scaled by mass, and a table with a row for each contact; see nlgs.py.

With M^-1 = L L^T and G = H L one array of rows serves both ways: u = q + G y and y = G^T p. The columns of the table are those of
``coulomb_law``: 1 / W_nn, the coupling w / W_nn (2), the Schur complement (3), W_nn, d, the start of the slip equation, mu, and
then q (3), p (3) and the compliance (3). A problem given by W alone has its coupling in the place of G^T, y = L^T (coupling) p, and sweeps
read W p from its rows.

What a sweep calls for each contact takes numbers, not arrays: an array that is passed on, or a view of one, has its references counted,
which takes longer than the arithmetic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.contact_geometry import Geometry, fill_row
from masonry_cd.mechanics.friction.coulomb_law import (
    COUPLING,
    INVERSE_NN,
    MU,
    NN,
    ROW,
    SCALE,
    SCHUR,
    START,
    C,
    P,
    Q,
    local_impulse,
    own_velocity,
    prepare_law,
)
from masonry_cd.mechanics.friction.coupling import is_coupled
from masonry_cd.mechanics.friction.operators import OrderedProblem, add_impulse
from masonry_cd.mechanics.linalg.intrinsics import prefetch
from masonry_cd.mechanics.linalg.small_blocks import cholesky_small

AHEAD = 4  # joints of a list that are fetched ahead


class ScaledProblem(NamedTuple):
    """A friction problem scaled by mass, with its impulses in the table."""

    factor: np.ndarray  # (B, n, n) L
    problem: OrderedProblem  # with G for H and q for b; supports are a last body whose rows of G are zero
    table: np.ndarray  # (C, ROW)
    y: np.ndarray  # (B + 1, n) G^T p
    size: float  # square of |q / sqrt(d)|, by which errors are divided


@kernel()
def scale_by_mass(given):
    """L (B, n, n), G (C, 2, m, n), q = H v_free + b (C, m), and the bodies (C, 2) with the supports as a last one."""
    m, n, free, contacts = len(given.m), len(given.n), len(given.v_free), len(given.mu)
    factor, g, q = np.empty((free, n, n)), np.zeros((contacts, 2, m, n)), given.offset.copy()
    index, row = np.empty(given.bodies.shape, dtype=np.int64), np.empty(n)
    for b in range(free):
        cholesky_small(given.inverse_mass[b], factor[b], n)
    for c in range(len(index)):
        for side in range(2):
            body = given.bodies[c, side]
            index[c, side] = body if body >= 0 else free
            if body < 0:
                continue
            for i in range(m):
                fill_row(given.geometry, c, side, i, row)
                for j in range(n):
                    total = 0.0
                    for k in range(j, n):  # L is lower triangular
                        total += row[k] * factor[body, k, j]
                    g[c, side, i, j] = total
                for k in range(n):
                    q[c, i] += row[k] * given.v_free[body, k]
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
    factor, g, q, index = scale_by_mass(given)
    n, table, size, nothing = len(given.n), contact_table(given, g, q, index, p), 0.0, np.empty(0, dtype=np.int64)
    y = np.zeros((len(given.v_free) + 1, n))
    for c in range(len(table)):
        for i in range(len(given.m)):
            size += q[c, i] * q[c, i] / table[c, SCALE]
    rows = Geometry(np.empty((0, 3, 3)), np.empty((0, 2, 3)), g)
    problem = OrderedProblem(
        given.inverse_mass, np.empty((0, n, n)), given.v_free, index, nothing, rows, q, given.mu, given.compliance, nothing,
        table[:, SCALE].copy(), given.coupling, given.m, given.n,
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


@borrower()
def sweep_spatial(g, y, index, law, starts, order):
    """One sweep for m = 3, n = 6: the velocity without a contact's own impulse, its exact impulse, the change of its two bodies.

    Written out, so that both bodies stay in registers: half the time of loops over the components. The processor cannot guess a random
    order, so the joint that comes AHEAD joints later is fetched already: with 60,000 contacts that halves the time.
    """
    for place in range(len(order)):
        joint = order[place]
        later = starts[order[min(place + AHEAD, len(order) - 1)]] - starts[joint]
        for c in range(starts[joint], starts[joint + 1]):
            for line in range(5):
                prefetch(g, 36 * (c + later) + 8 * line)
            for line in range(3):
                prefetch(law, ROW * (c + later) + 8 * line)
            a, b = index[c, 0], index[c, 1]
            a0, a1, a2, a3, a4, a5 = y[a, 0], y[a, 1], y[a, 2], y[a, 3], y[a, 4], y[a, 5]
            b0, b1, b2, b3, b4, b5 = y[b, 0], y[b, 1], y[b, 2], y[b, 3], y[b, 4], y[b, 5]
            u0 = (
                (g[c, 0, 0, 0] * a0 + g[c, 0, 0, 1] * a1 + g[c, 0, 0, 2] * a2)
                + (g[c, 0, 0, 3] * a3 + g[c, 0, 0, 4] * a4 + g[c, 0, 0, 5] * a5)
                + (g[c, 1, 0, 0] * b0 + g[c, 1, 0, 1] * b1 + g[c, 1, 0, 2] * b2)
                + (g[c, 1, 0, 3] * b3 + g[c, 1, 0, 4] * b4 + g[c, 1, 0, 5] * b5)
            )
            u1 = (
                (g[c, 0, 1, 0] * a0 + g[c, 0, 1, 1] * a1 + g[c, 0, 1, 2] * a2)
                + (g[c, 0, 1, 3] * a3 + g[c, 0, 1, 4] * a4 + g[c, 0, 1, 5] * a5)
                + (g[c, 1, 1, 0] * b0 + g[c, 1, 1, 1] * b1 + g[c, 1, 1, 2] * b2)
                + (g[c, 1, 1, 3] * b3 + g[c, 1, 1, 4] * b4 + g[c, 1, 1, 5] * b5)
            )
            u2 = (
                (g[c, 0, 2, 0] * a0 + g[c, 0, 2, 1] * a1 + g[c, 0, 2, 2] * a2)
                + (g[c, 0, 2, 3] * a3 + g[c, 0, 2, 4] * a4 + g[c, 0, 2, 5] * a5)
                + (g[c, 1, 2, 0] * b0 + g[c, 1, 2, 1] * b1 + g[c, 1, 2, 2] * b2)
                + (g[c, 1, 2, 3] * b3 + g[c, 1, 2, 4] * b4 + g[c, 1, 2, 5] * b5)
            )
            inverse_nn, c1, c2, s11, s12, s22, nn = law_of(law, c)
            old_n, old_1, old_2 = law[c, P], law[c, P + 1], law[c, P + 2]
            own_n, own_1, own_2 = own_velocity(old_n, old_1, old_2, c1, c2, s11, s12, s22, nn)
            q0 = (law[c, Q] + law[c, C] * old_n - own_n) + u0
            q1 = (law[c, Q + 1] + law[c, C + 1] * old_1 - own_1) + u1
            q2 = (law[c, Q + 2] + law[c, C + 2] * old_2 - own_2) + u2
            pn, p1, p2, law[c, START] = local_impulse((q0, q1, q2), (inverse_nn, c1, c2, s11, s12, s22), law[c, MU], law[c, START])
            d0, d1, d2 = pn - old_n, p1 - old_1, p2 - old_2
            law[c, P], law[c, P + 1], law[c, P + 2] = pn, p1, p2
            y[a, 0] = a0 + (g[c, 0, 0, 0] * d0 + g[c, 0, 1, 0] * d1 + g[c, 0, 2, 0] * d2)
            y[a, 1] = a1 + (g[c, 0, 0, 1] * d0 + g[c, 0, 1, 1] * d1 + g[c, 0, 2, 1] * d2)
            y[a, 2] = a2 + (g[c, 0, 0, 2] * d0 + g[c, 0, 1, 2] * d1 + g[c, 0, 2, 2] * d2)
            y[a, 3] = a3 + (g[c, 0, 0, 3] * d0 + g[c, 0, 1, 3] * d1 + g[c, 0, 2, 3] * d2)
            y[a, 4] = a4 + (g[c, 0, 0, 4] * d0 + g[c, 0, 1, 4] * d1 + g[c, 0, 2, 4] * d2)
            y[a, 5] = a5 + (g[c, 0, 0, 5] * d0 + g[c, 0, 1, 5] * d1 + g[c, 0, 2, 5] * d2)
            y[b, 0] = b0 + (g[c, 1, 0, 0] * d0 + g[c, 1, 1, 0] * d1 + g[c, 1, 2, 0] * d2)
            y[b, 1] = b1 + (g[c, 1, 0, 1] * d0 + g[c, 1, 1, 1] * d1 + g[c, 1, 2, 1] * d2)
            y[b, 2] = b2 + (g[c, 1, 0, 2] * d0 + g[c, 1, 1, 2] * d1 + g[c, 1, 2, 2] * d2)
            y[b, 3] = b3 + (g[c, 1, 0, 3] * d0 + g[c, 1, 1, 3] * d1 + g[c, 1, 2, 3] * d2)
            y[b, 4] = b4 + (g[c, 1, 0, 4] * d0 + g[c, 1, 1, 4] * d1 + g[c, 1, 2, 4] * d2)
            y[b, 5] = b5 + (g[c, 1, 0, 5] * d0 + g[c, 1, 1, 5] * d1 + g[c, 1, 2, 5] * d2)


@kernel()
def sweep_any(scaled, starts, order):
    """One sweep for any m and n; planar problems (m = 2, n = 3) come here, and those given by W alone, which have no y to keep."""
    problem, y, law = scaled.problem, scaled.y, scaled.table
    g, index, (data, indices, indptr) = problem.geometry.jacobian, problem.places, problem.coupling
    m, n, coupled = len(problem.m), len(problem.n), is_coupled(problem)
    seen, impulse = np.zeros(3), np.zeros(3)
    for joint in order:
        for c in range(starts[joint], starts[joint + 1]):
            a, b = index[c, 0], index[c, 1]
            inverse_nn, c1, c2, s11, s12, s22, nn = law_of(law, c)
            own_n, own_1, own_2 = own_velocity(law[c, P], law[c, P + 1], law[c, P + 2], c1, c2, s11, s12, s22, nn)
            seen[0], seen[1], seen[2] = -own_n, -own_1, -own_2 if m == 3 else 0.0
            for i in range(m):
                seen[i] += law[c, Q + i] + law[c, C + i] * law[c, P + i]
                for k in range(0 if coupled else n):
                    seen[i] += g[c, 0, i, k] * y[a, k] + g[c, 1, i, k] * y[b, k]
            for k in range(indptr[c] if coupled else 0, indptr[c + 1] if coupled else 0):
                row, d = indices[k], law[c, SCALE]
                for i in range(m):
                    for j in range(m):
                        seen[i] += d * data[k, i, j] * law[row, P + j]
            impulse[0], impulse[1], impulse[2], law[c, START] = local_impulse(
                (seen[0], seen[1], seen[2]), (inverse_nn, c1, c2, s11, s12, s22), law[c, MU], law[c, START]
            )
            for i in range(m):
                change = impulse[i] - law[c, P + i]
                law[c, P + i] = impulse[i]
                for k in range(0 if coupled else n):
                    y[a, k] += g[c, 0, i, k] * change
                    y[b, k] += g[c, 1, i, k] * change


@kernel()
def sweep(scaled, starts, order):
    """One sweep, joint after joint in the given order: new impulses in the table of a :class:`ScaledProblem`, and new y."""
    g = scaled.problem.geometry.jacobian
    if g.shape[2] == 3 and g.shape[3] == 6:
        sweep_spatial(g, scaled.y, scaled.problem.places, scaled.table, starts, order)
    else:
        sweep_any(scaled, starts, order)
