"""The operators of a friction problem over bodies: u = H v + b, H^T p, M^-1, the scales d, and the natural map of all contacts."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.natural_map import natural_map_norms, squared_residual
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.small_blocks import copy_flat, invert


@kernel()
def in_order(inverse_mass, v_free, order, size_n):
    """M^-1, M and v_free with the bodies in elimination order."""
    bodies, n = len(order), len(size_n)
    inverse, mass, free = np.empty((bodies, n, n)), np.empty((bodies, n, n)), np.empty((bodies, n))
    put_in_order(inverse_mass, v_free, order, 0, bodies, inverse, mass, free, size_n)
    return inverse, mass, free


@kernel()
def put_in_order(inverse_mass, v_free, order, first, end, inverse, mass, free, size_n):
    """The same for places first to end of given arrays."""
    n = len(size_n)
    work = np.empty((n, n))
    for b in range(first, end):
        coupled = False
        for i in range(n):
            free[b, i] = v_free[order[b], i]
            for j in range(n):
                inverse[b, i, j] = inverse_mass[order[b], i, j]
                mass[b, i, j] = 0.0
                coupled = coupled or (i != j and inverse[b, i, j] != 0.0)
        if coupled:
            invert(inverse[b], mass[b], work, size_n)
        else:  # as in a plane
            for i in range(n):
                mass[b, i, i] = 1.0 / inverse[b, i, i]


@kernel(fastmath={"contract"})
def contact_scales(inverse, jacobian, index, compliance, size_m, size_n):
    """d_c = trace(W_cc + C_cc) / m."""
    d = np.empty(len(index))
    measure_scales(inverse, jacobian, index, compliance, 0, len(index), d, size_m, size_n)
    return d


@kernel(fastmath={"contract"})
def measure_scales(inverse, jacobian, index, compliance, first, end, d, size_m, size_n):
    """The same for contacts first to end."""
    m, n, bodies = len(size_m), len(size_n), len(inverse)
    for c in range(first, end):
        a, b, trace = index[c, 0], index[c, 1], 0.0
        for side in range(2):
            body = index[c, side]
            if body == bodies:
                continue
            for i in range(m):
                for k in range(n):
                    total = 0.0
                    for l in range(n):  # noqa: E741
                        total += inverse[body, k, l] * jacobian[c, side, i, l]
                        if a == b:
                            total += inverse[body, k, l] * jacobian[c, 1 - side, i, l]
                    trace += total * jacobian[c, side, i, k]
        if len(compliance):
            for i in range(m):
                trace += compliance[c, i]
        d[c] = trace / m


@kernel()
def relative_velocity(jacobian, index, offset, v, u, size_m, size_n):
    """u = H v + b; v (bodies + 1, n) with a last row of zeros for the supports."""
    relative_velocity_of(jacobian, index, offset, v, 0, len(index), u, size_m, size_n)


@kernel()
def relative_velocity_of(jacobian, index, offset, v, first, end, u, size_m, size_n):
    """The same for contacts first to end."""
    m, n = len(size_m), len(size_n)
    for c in range(first, end):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            total = offset[c, i]
            for k in range(n):
                total += jacobian[c, 0, i, k] * v[a, k] + jacobian[c, 1, i, k] * v[b, k]
            u[c, i] = total


@kernel(fastmath={"contract"})
def add_generalised_impulse(jacobian, index, p, out, size_m, size_n):
    """out += H^T p; the last row of out, of the supports, is of no use."""
    m, n = len(size_m), len(size_n)
    for c in range(len(index)):
        a, b = index[c, 0], index[c, 1]
        for i in range(m):
            x = p[c, i]
            for k in range(n):
                out[a, k] += jacobian[c, 0, i, k] * x
                out[b, k] += jacobian[c, 1, i, k] * x


@kernel(fastmath={"contract"})
def body_velocity(inverse, free, jacobian, index, p, push, v, size_m, size_n):
    """v = v_free + M^-1 H^T p, with a last row of zeros."""
    n = len(size_n)
    push[:] = 0.0
    add_generalised_impulse(jacobian, index, p, push, size_m, size_n)
    for b in range(len(inverse)):
        for i in range(n):
            total = free[b, i]
            for k in range(n):
                total += inverse[b, i, k] * push[b, k]
            v[b, i] = total
    v[-1] = 0.0


@kernel()
def missing_momentum(mass, free, v, out, size_n):
    """out = M (v_free - v)."""
    missing_momentum_of(mass, free, v, 0, len(mass), out, size_n)
    out[-1] = 0.0


@kernel()
def missing_momentum_of(mass, free, v, first, end, out, size_n):
    """The same for bodies first to end."""
    n = len(size_n)
    for b in range(first, end):
        for i in range(n):
            total = 0.0
            for k in range(n):
                total += mass[b, i, k] * (free[b, k] - v[b, k])
            out[b, i] = total


@kernel(fastmath={"contract"})
def map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n):
    """Norm of the natural map residual for impulses p and body velocities v."""
    return np.sqrt(squared_map_norm_of(jacobian, index, offset, mu, compliance, d, p, v, 0, len(index), size_m, size_n))


@kernel(fastmath={"contract"})
def squared_map_norm_of(jacobian, index, offset, mu, compliance, d, p, v, first, end, size_m, size_n):
    """Its square, of the contacts first to end."""
    m, n = len(size_m), len(size_n)
    total = 0.0
    for c in range(first, end):
        a, b = index[c, 0], index[c, 1]
        un, u1, u2 = offset[c, 0], offset[c, 1], 0.0
        if m == 3:
            u2 = offset[c, 2]
        for k in range(n):
            x, y = v[a, k], v[b, k]
            un += jacobian[c, 0, 0, k] * x + jacobian[c, 1, 0, k] * y
            u1 += jacobian[c, 0, 1, k] * x + jacobian[c, 1, 1, k] * y
            if m == 3:
                u2 += jacobian[c, 0, 2, k] * x + jacobian[c, 1, 2, k] * y
        p2 = p[c, 2] if m == 3 else 0.0
        if len(compliance):
            un += compliance[c, 0] * p[c, 0]
            u1 += compliance[c, 1] * p[c, 1]
            u2 += compliance[c, m - 1] * p2
        total += squared_residual(p[c, 0], p[c, 1], p2, un, u1, u2, mu[c], d[c])
    return total


@kernel()
def put_back(v, order, out):
    """Velocities from elimination order to the order of the problem."""
    for b in range(len(order)):
        for i in range(out.shape[1]):
            out[order[b], i] = v[b, i]


@kernel()
def law_terms(inverse_mass, v_free, bodies, jacobian, offset, compliance, p, scaled, size_m, size_n):
    """w = H v + b + C p of impulses p, q = H v_free + b, and d, which is 1 if not ``scaled``."""
    count, contacts, m, n = len(v_free), len(p), len(size_m), len(size_n)
    index = np.empty((contacts, 2), dtype=np.int64)
    for c in range(contacts):
        for side in range(2):
            index[c, side] = bodies[c, side] if bodies[c, side] >= 0 else count
    v, push, q, w = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.empty((contacts, m)), np.empty((contacts, m))
    copy_flat(v_free, v)
    relative_velocity(jacobian, index, offset, v, q, size_m, size_n)
    body_velocity(inverse_mass, v_free, jacobian, index, p, push, v, size_m, size_n)
    relative_velocity(jacobian, index, offset, v, w, size_m, size_n)
    if len(compliance):
        for c in range(contacts):
            for i in range(m):
                w[c, i] += compliance[c, i] * p[c, i]
    d = contact_scales(inverse_mass, jacobian, index, compliance, size_m, size_n) if scaled else np.ones(contacts)
    return w, q, d


@entry()
def error_bodies(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p, scaled, size_m, size_n):
    """Norms of the natural map residual and of q for impulses p over a FrictionProblem; scaled by d, or with d = 1."""
    w, q, d = law_terms(inverse_mass, v_free, bodies, jacobian, offset, compliance, p, scaled, size_m, size_n)
    return natural_map_norms(p, w, q, mu, d)


@entry()
def errors_by_group(inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, p, group, groups, size_m, size_n):
    """The same norms, scaled, over each group of contacts: (G,) and (G,); ``group`` (C,) is the number of each contact's."""
    w, q, d = law_terms(inverse_mass, v_free, bodies, jacobian, offset, compliance, p, True, size_m, size_n)
    residual, size, m = np.zeros(groups), np.zeros(groups), len(size_m)
    for c in range(len(p)):
        p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
        residual[group[c]] += squared_residual(p[c, 0], p[c, 1], p2, w[c, 0], w[c, 1], w2, mu[c], d[c])
        for i in range(m):
            size[group[c]] += q[c, i] * q[c, i] / d[c]
    return np.sqrt(residual), np.sqrt(size)


@entry()
def new_velocity(impulse, bodies, jacobian, inverse_mass, v_free, v):
    """v = v_free + M^-1 H^T p, (B, n)."""
    contacts, m, n = impulse.shape[0], jacobian.shape[2], jacobian.shape[3]
    push = np.zeros_like(v_free)
    for c in range(contacts):
        for side in range(2):
            b = bodies[c, side]
            if b >= 0:
                for i in range(m):
                    for j in range(n):
                        push[b, j] += jacobian[c, side, i, j] * impulse[c, i]
    for b in range(v_free.shape[0]):
        for j in range(n):
            value = v_free[b, j]
            for k in range(n):
                value += inverse_mass[b, j, k] * push[b, k]
            v[b, j] = value
