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

from masonry_cd.foundation.jit import borrower, entry, kernel
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
from masonry_cd.mechanics.friction.operators import ProblemArrays, add_impulse, form_of_problem
from masonry_cd.mechanics.linalg.intrinsics import prefetch
from masonry_cd.mechanics.linalg.small_blocks import FULL, cholesky_small

AHEAD = 4  # joints of a list that are fetched ahead


class ScaledProblem(NamedTuple):
    """A friction problem scaled by mass, with its impulses in the table."""

    factor: np.ndarray  # (B, n, n) L
    problem: ProblemArrays  # with G for H and q for b
    table: np.ndarray  # (C, ROW)
    y: np.ndarray  # (B + 1, n) G^T p
    size: float  # square of |q / sqrt(d)|, by which errors are divided


def scaled_problem(given: ProblemArrays, p: np.ndarray) -> ScaledProblem:
    """The :class:`ScaledProblem` of ProblemArrays and impulses p (C, m); y is not yet set."""
    factor, g, q = scale_by_mass(given)
    problem = given._replace(geometry=Geometry.by_rows(g), offset=q, width=FULL, n=np.zeros(g.shape[3]))
    y = np.zeros((len(given.free) + 1, g.shape[3]))
    return ScaledProblem(factor, problem, contact_table(problem, p), y, float(np.sum(q * q / given.d[:, None])))


@entry()
def scale_by_mass(given: ProblemArrays) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """L (B, n, n), G (C, 2, m, n), and q = H v_free + b (C, m)."""
    m, n, free, contacts, form = len(given.m), len(given.n), len(given.free), len(given.mu), form_of_problem(given)
    factor, g, q, row = np.empty((free, n, n)), np.zeros((contacts, 2, m, n)), given.offset.copy(), np.empty(n)
    for b in range(free):
        cholesky_small(given.inverse[b], factor[b], n)
    for c in range(contacts):
        for side in range(2):
            body = given.places[c, side]
            if body == free:
                continue
            for i in range(m):
                fill_row(form, given.geometry, c, side, i, n, row)
                for j in range(n):
                    total = 0.0
                    for k in range(j, n):  # L is lower triangular
                        total += row[k] * factor[body, k, j]
                    g[c, side, i, j] = total
                for k in range(n):
                    q[c, i] += row[k] * given.free[body, k]
    return factor, g, q


@entry()
def contact_table(problem: ProblemArrays, p: np.ndarray) -> np.ndarray:
    """The table (C, ROW) of a problem with G for H and q for b: q, p, and the laws, from W_cc + C_cc.

    W_cc is the sum over the sides of G G^T; both sides on one body add up.
    """
    g, places, compliance = problem.geometry.jacobian, problem.places, problem.compliance
    contacts, _, m, n = g.shape
    law, w = np.zeros((contacts, ROW)), np.zeros((3, 3))
    for c in range(contacts):
        cross = places[c, 0] == places[c, 1]
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
        if is_coupled(problem):
            read_own_block(problem, c, w)
        prepare_law(w, m, problem.mu[c], law, c)
        for i in range(m):
            law[c, Q + i], law[c, P + i] = problem.offset[c, i], p[c, i]
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


@borrower(forceinline=True)
def seen_by(g, c, side, i, y, b):
    """Row i of G of contact c, on one side, times the row of y of its body b."""
    first = g[c, side, i, 0] * y[b, 0] + g[c, side, i, 1] * y[b, 1] + g[c, side, i, 2] * y[b, 2]
    return first + (g[c, side, i, 3] * y[b, 3] + g[c, side, i, 4] * y[b, 4] + g[c, side, i, 5] * y[b, 5])


@borrower(forceinline=True)
def add_to_body(g, c, side, d, y, b):
    """Add G^T d of contact c, on one side, to the row of y of its body b."""
    for k in range(6):
        y[b, k] += g[c, side, 0, k] * d[0] + g[c, side, 1, k] * d[1] + g[c, side, 2, k] * d[2]


@borrower()
def sweep_spatial(g, y, index, law, starts, order):
    """One sweep for m = 3, n = 6: the velocity without a contact's own impulse, its exact impulse, the change of its two bodies.

    The processor cannot guess a random order, so the joint that comes AHEAD joints later is fetched already: with 60,000 contacts that
    halves the time.
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
            u0 = seen_by(g, c, 0, 0, y, a) + seen_by(g, c, 1, 0, y, b)
            u1 = seen_by(g, c, 0, 1, y, a) + seen_by(g, c, 1, 1, y, b)
            u2 = seen_by(g, c, 0, 2, y, a) + seen_by(g, c, 1, 2, y, b)
            inverse_nn, c1, c2, s11, s12, s22, nn = law_of(law, c)
            old_n, old_1, old_2 = law[c, P], law[c, P + 1], law[c, P + 2]
            own_n, own_1, own_2 = own_velocity(old_n, old_1, old_2, c1, c2, s11, s12, s22, nn)
            q0 = (law[c, Q] + law[c, C] * old_n - own_n) + u0
            q1 = (law[c, Q + 1] + law[c, C + 1] * old_1 - own_1) + u1
            q2 = (law[c, Q + 2] + law[c, C + 2] * old_2 - own_2) + u2
            pn, p1, p2, law[c, START] = local_impulse((q0, q1, q2), (inverse_nn, c1, c2, s11, s12, s22), law[c, MU], law[c, START])
            change = pn - old_n, p1 - old_1, p2 - old_2
            law[c, P], law[c, P + 1], law[c, P + 2] = pn, p1, p2
            add_to_body(g, c, 0, change, y, a)
            add_to_body(g, c, 1, change, y, b)


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
