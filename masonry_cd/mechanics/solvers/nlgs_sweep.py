# SPDX-License-Identifier: GPL-3.0-or-later
"""One sweep of Gauss-Seidel over the contacts of a list of joints; see nlgs.py for the method.

What a sweep calls for each contact takes numbers, not arrays: an array that is passed on, or a view of one, has its references counted,
which takes longer than the arithmetic.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import MU, ROW, SCALE, START, C, P, Q, local_impulse, own_velocity
from masonry_cd.mechanics.friction.coupling import is_coupled
from masonry_cd.mechanics.linalg.intrinsics import prefetch
from masonry_cd.mechanics.solvers.nlgs_table import law_of


@borrower()
def sweep_spatial(g, y, index, law, starts, order, ahead):
    """One sweep for m = 3, n = 6: the velocity without a contact's own impulse, its exact impulse, the change of its two bodies.

    Written out, so that both bodies stay in registers: half the time of loops over the components. The processor cannot guess a random
    order, so the joint that comes ``ahead`` joints later is fetched already: with 60,000 contacts that halves the time.
    """
    for place in range(len(order)):
        joint = order[place]
        later = starts[order[min(place + ahead, len(order) - 1)]] - starts[joint]
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
    g, index, (data, indices, indptr) = problem.jacobian, problem.places, problem.coupling
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
def sweep(scaled, starts, order, ahead):
    """One sweep, joint after joint in the given order: new impulses in the table of a :class:`ScaledProblem`, and new y."""
    g = scaled.problem.jacobian
    if g.shape[2] == 3 and g.shape[3] == 6:
        sweep_spatial(g, scaled.y, scaled.problem.places, scaled.table, starts, order, ahead)
    else:
        sweep_any(scaled, starts, order)
