"""Gauss-Seidel sweeps over bodies, in one thread or colour by colour in several; see nlgs.py for the method.

What sweeps call for each contact takes numbers, not arrays: an array that is passed on, or a view of one, has its references counted, which
takes longer than the arithmetic.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from masonry_cd.friction.coulomb_law import MU, ROW, SCALE, START, C, P, Q, local_impulse, own_velocity, prepare_law
from masonry_cd.friction.natural_map import squared_residual
from masonry_cd.friction.random_order import seeded, shuffle
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.intrinsics import prefetch
from masonry_cd.linalg.small_blocks import cholesky_small

GROUP = 16  # contacts visited in a row by a sweep, see groups_of


@kernel(inline="always")
def scale_rows(jacobian, factor, side, c, body, m, n, scaled):
    """scaled = H L for one contact and side, L lower triangular."""
    for i in range(m):
        for j in range(n):
            total = 0.0
            for k in range(j, n):
                total += jacobian[c, side, i, k] * factor[body, k, j]
            scaled[c, side, i, j] = total


@kernel()
def mass_scaled(inverse_mass, v_free, bodies, jacobian, offset):
    """Scale by mass: M^-1 = L L^T, G = H L, so that u = q + G y and y = G^T p, and one array of rows serves both ways.

    Supports become a last, dummy body whose rows are zero.
    """
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
def contact_table(g: np.ndarray, q: np.ndarray, index: np.ndarray, mu: np.ndarray, compliance: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The table of contacts: q, p, and the laws, from W_cc + C_cc, W_cc = sum over sides of G G^T (both sides on one body add up)."""
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
def groups_of(index: np.ndarray) -> np.ndarray:
    """Starts of the groups that a sweep visits in random order, with the end appended.

    A group is a run of whole joints (consecutive contacts between the same two bodies) of at least GROUP contacts: small enough for a
    random order to spread news as fast as single joints do, large enough that memory is read ahead, which saves a third of the time.
    """
    contacts = len(index)
    starts = np.empty(contacts + 1, dtype=np.int64)
    count = 0
    for c in range(contacts):
        new = c == 0 or index[c, 0] != index[c - 1, 0] or index[c, 1] != index[c - 1, 1]
        if new and (count == 0 or c - starts[count - 1] >= GROUP):
            starts[count] = c
            count += 1
    starts[count] = contacts
    return starts[: count + 1]


@kernel()
def sweep_spatial(g, y, index, law, starts, order, ahead):
    """One Gauss-Seidel sweep for m = 3, n = 6: what a contact sees, its exact answer, the push on its two bodies.

    Written out, so that both bodies stay in registers: half the time of loops over the components. The random order keeps the processor
    from guessing what comes next, so the group that comes ``ahead`` groups later is asked for: with 60,000 contacts that halves the time.
    """
    for place in range(len(order)):
        group = order[place]
        later = starts[order[min(place + ahead, len(order) - 1)]] - starts[group]
        for c in range(starts[group], starts[group + 1]):
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
            c1, c2, s11, s12, s22 = law[c, 1], law[c, 2], law[c, 3], law[c, 4], law[c, 5]
            old_n, old_1, old_2 = law[c, P], law[c, P + 1], law[c, P + 2]
            own_n, own_1, own_2 = own_velocity(old_n, old_1, old_2, c1, c2, s11, s12, s22, law[c, 6])
            q0 = (law[c, Q] + law[c, C] * old_n - own_n) + u0
            q1 = (law[c, Q + 1] + law[c, C + 1] * old_1 - own_1) + u1
            q2 = (law[c, Q + 2] + law[c, C + 2] * old_2 - own_2) + u2
            pn, p1, p2, law[c, START] = local_impulse((q0, q1, q2), (law[c, 0], c1, c2, s11, s12, s22), law[c, MU], law[c, START])
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
def sweep_any(g, y, index, law, starts, order):
    """The same for any size; planar problems (m = 2, n = 3) come here."""
    m, n = g.shape[2], g.shape[3]
    see, push = np.zeros(3), np.zeros(3)
    for group in order:
        for c in range(starts[group], starts[group + 1]):
            a, b = index[c, 0], index[c, 1]
            c1, c2, s11, s12, s22 = law[c, 1], law[c, 2], law[c, 3], law[c, 4], law[c, 5]
            own_n, own_1, own_2 = own_velocity(law[c, P], law[c, P + 1], law[c, P + 2], c1, c2, s11, s12, s22, law[c, 6])
            see[0], see[1], see[2] = -own_n, -own_1, -own_2 if m == 3 else 0.0
            for i in range(m):
                see[i] += law[c, Q + i] + law[c, C + i] * law[c, P + i]
                for k in range(n):
                    see[i] += g[c, 0, i, k] * y[a, k] + g[c, 1, i, k] * y[b, k]
            push[0], push[1], push[2], law[c, START] = local_impulse(
                (see[0], see[1], see[2]), (law[c, 0], c1, c2, s11, s12, s22), law[c, MU], law[c, START]
            )
            for i in range(m):
                change = push[i] - law[c, P + i]
                law[c, P + i] = push[i]
                for k in range(n):
                    y[a, k] += g[c, 0, i, k] * change
                    y[b, k] += g[c, 1, i, k] * change


@kernel()
def sweep(g, y, index, law, starts, order, ahead):
    """One Gauss-Seidel sweep, group after group in the given order."""
    if g.shape[2] == 3 and g.shape[3] == 6:
        sweep_spatial(g, y, index, law, starts, order, ahead)
    else:
        sweep_any(g, y, index, law, starts, order)


@kernel()
def collect(g: np.ndarray, index: np.ndarray, p: np.ndarray, y: np.ndarray) -> None:
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
def table_residual(g, y, index, law):
    """Natural map error of the impulses in the table, whose y = G^T p is given."""
    contacts, _, m, n = g.shape
    residual, size = 0.0, 0.0
    w = np.zeros(3)
    for c in range(contacts):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            size += law[c, Q + i] * law[c, Q + i] / law[c, SCALE]
            w[i] = law[c, Q + i] + law[c, C + i] * law[c, P + i]
            for k in range(n):
                w[i] += g[c, 0, i, k] * y[a, k] + g[c, 1, i, k] * y[b, k]
        residual += squared_residual(law[c, P], law[c, P + 1], law[c, P + 2], w[0], w[1], w[2], law[c, MU], law[c, SCALE])
    return np.sqrt(residual / size) if size > 0.0 else np.sqrt(residual)


@entry()
def collect_and_measure(g, y, index, law):
    """y = G^T p from scratch, and the natural map error."""
    collect(g, index, law[:, P : P + g.shape[2]], y)
    return table_residual(g, y, index, law)


@kernel()
def velocities_of(factor: np.ndarray, v_free: np.ndarray, y: np.ndarray, v: np.ndarray) -> None:
    """v = v_free + L y."""
    for body in range(v.shape[0]):
        for i in range(v.shape[1]):
            total = v_free[body, i]
            for k in range(i + 1):
                total += factor[body, i, k] * y[body, k]
            v[body, i] = total


@entry()
def nlgs_bodies(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p, v, tolerance, limit, seed, every):
    """Gauss-Seidel over a FrictionProblem. p (C, m) holds the start and then the answer, v (B, n) the velocities.

    Returns the sweeps made and the natural map error measured last.
    """
    factor, g, q, index = mass_scaled(inverse_mass, v_free, bodies, jacobian, offset)
    law = contact_table(g, q, index, mu, compliance, p)
    starts = groups_of(index)
    order = np.arange(len(starts) - 1)
    state = seeded(seed)
    y = np.empty((v_free.shape[0] + 1, v_free.shape[1]))
    error = collect_and_measure(g, y, index, law)
    sweeps = 0
    while error > tolerance and sweeps < limit:
        for _ in range(min(every, limit - sweeps)):
            shuffle(order, state)
            sweep(g, y, index, law, starts, order, 1)
            sweeps += 1
        error = collect_and_measure(g, y, index, law)
    for c in range(len(p)):
        for i in range(p.shape[1]):
            p[c, i] = law[c, P + i]
    velocities_of(factor, v_free, y, v)
    return sweeps, error


@entry()
def colour_joints(index: np.ndarray, bodies: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colour the joints so that no two of a colour share a body: greedily, in their order.

    Returns starts of the joints (J + 1,), the joints sorted by colour (J,) and the starts of the colours in that list.
    """
    contacts = len(index)
    start = np.empty(contacts + 1, dtype=np.int64)
    joints = 0
    for c in range(contacts):
        if c == 0 or index[c, 0] != index[c - 1, 0] or index[c, 1] != index[c - 1, 1]:
            start[joints] = c
            joints += 1
    start[joints] = contacts
    taken = np.zeros((bodies + 1, 2), dtype=np.uint64)  # 128 colours: more joints than that meet in no block
    colour = np.empty(joints, dtype=np.int64)
    count = np.zeros(129, dtype=np.int64)
    for j in range(joints):
        a, b = index[start[j], 0], index[start[j], 1]
        for k in range(128):
            word, bit = k >> 6, np.uint64(1) << np.uint64(k & 63)
            if not ((taken[a, word] | taken[b, word]) & bit) or k == 127:
                break
        colour[j] = k
        count[k + 1] += 1
        for body in (a, b):
            if body < bodies:  # supports do not move: any number of joints may rest on them at once
                taken[body, word] |= bit
    for k in range(128):
        count[k + 1] += count[k]
    at, order = count[:-1].copy(), np.empty(joints, dtype=np.int64)
    for j in range(joints):
        order[at[colour[j]]] = j
        at[colour[j]] += 1
    return start[: joints + 1], order, count


@entry(parallel=True)
def sweep_coloured(g, y, index, law, start, order, colours, first, last, chunk):
    """One sweep over the joints of the colours in the given order; those of one colour in parallel, 128 of them alone.

    Joints of a colour share no body that moves, so the result does not depend on who takes which, nor on how many threads there are.
    """
    for place in range(len(colours)):
        low, high = first[colours[place]], last[colours[place]]
        if colours[place] == 127:
            sweep(g, y, index, law, start, order[low:high], 4)
        else:
            for part in prange((high - low + chunk - 1) // chunk):
                begin = low + part * chunk
                sweep(g, y, index, law, start, order[begin : min(begin + chunk, high)], 4)


@entry()
def prepare_sweeps(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p):
    """What the coloured sweeps need: L, G, bodies of the contacts and the table of contacts."""
    factor, g, q, index = mass_scaled(inverse_mass, v_free, bodies, jacobian, offset)
    return factor, g, index, contact_table(g, q, index, mu, compliance, p)


@entry()
def velocities(factor, v_free, y, v):
    """v = v_free + L y."""
    velocities_of(factor, v_free, y, v)
