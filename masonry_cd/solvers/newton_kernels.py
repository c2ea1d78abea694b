"""Semismooth Newton over bodies; see newton.py for the method."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.friction.natural_map import size_of
from masonry_cd.friction.operators import (
    add_generalised_impulse,
    body_velocity,
    contact_scales,
    in_order,
    map_norm,
    missing_momentum,
    put_back,
    relative_velocity,
)
from masonry_cd.jit import kernel
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat, invert, multiply
from masonry_cd.linalg.supernodes import allocate_factors
from masonry_cd.linalg.triangular import solve_ldu


@kernel()
def linearise_law(pn, p1, p2, un, u1, u2, mu, d, stiffness, block, target, c, size_m):
    """Linearised law of contact c, p+ = target[c] - block[c] (u+ - u), for contact stiffness ``stiffness`` / d; see solvers/newton.py."""
    m = len(size_m)
    spatial = m == 3
    for i in range(m):
        target[c, i] = 0.0
        for j in range(m):
            block[c, i, j] = 0.0
    xn, x1, x2 = pn - un / d, p1 - u1 / d, p2 - u2 / d
    if xn <= 0.0:
        return
    kappa = stiffness / d
    length = tangent_length(x1, x2)
    target[c, 0] = pn - kappa * un
    block[c, 0, 0] = kappa
    if length <= mu * xn:
        target[c, 1], block[c, 1, 1] = p1 - kappa * u1, kappa
        if spatial:
            target[c, 2], block[c, 2, 2] = p2 - kappa * u2, kappa
        return
    e1, e2 = x1 / length, x2 / length
    target[c, 1], block[c, 1, 0] = mu * e1 * target[c, 0], mu * e1 * kappa
    if spatial:  # across the slip the direction of friction turns with the velocity
        share = mu * xn / length
        beta = min(share / (d * max(1.0 - share, 1e-12)), kappa)
        across = u2 * e1 - u1 * e2
        target[c, 2], block[c, 2, 0] = mu * e2 * target[c, 0], mu * e2 * kappa
        target[c, 1] += beta * across * e2
        target[c, 2] -= beta * across * e1
        block[c, 1, 1], block[c, 1, 2], block[c, 2, 1], block[c, 2, 2] = beta * e2 * e2, -beta * e1 * e2, -beta * e1 * e2, beta * e1 * e1


@kernel()
def in_series(block, compliance, share, softer, work, size_m):
    """Put the contact's own spring in series with a linearised law p+ - p = r - B (w+ - w), where w+ - w = u+ - u + C (p+ - p).

    share = (I + B C)^-1 leaves p+ - p = share r - softer (u+ - u), softer = share B. False if it is singular.
    """
    m = len(size_m)
    for i in range(m):
        for j in range(m):
            softer[i, j] = block[i, j] * compliance[j] + (1.0 if i == j else 0.0)
    regular = invert(softer, share, work, size_m)
    multiply(share, block, False, softer, size_m)
    return regular


@kernel()
def take_share(share, target, p0, p1, p2, size_m):
    """target <- p + share (target - p)."""
    m = len(size_m)
    r0, r1, r2 = target[0] - p0, target[1] - p1, target[m - 1] - p2 if m == 3 else 0.0
    for i in range(m):
        target[i] = (p0, p1, p2)[i] + share[i, 0] * r0 + share[i, 1] * r1 + share[i, m - 1] * r2


@kernel(fastmath={"contract"})
def augment_blocks(mass, jacobian, index, spot, blocks, diagonal, lower, upper, size_m, size_n):
    """Diagonal, lower and transposed upper blocks of M + H^T B H, B one (m, m) block per contact."""
    m, n, bodies = len(size_m), len(size_n), len(mass)
    copy_flat(mass, diagonal)
    lower[:] = 0.0
    upper[:] = 0.0
    turned = np.empty((2, m, n))
    for c in range(len(index)):
        a, b = index[c, 0], index[c, 1]
        for side in range(2):
            for i in range(m):
                for q in range(n):
                    total = 0.0
                    for k in range(m):
                        total += blocks[c, i, k] * jacobian[c, side, k, q]
                    turned[side, i, q] = total
            body = index[c, side]
            if body < bodies:
                for p in range(n):
                    for q in range(n):
                        total = 0.0
                        for i in range(m):
                            total += jacobian[c, side, i, p] * turned[side, i, q]
                        diagonal[body, p, q] += total
        if a == b < bodies:
            for p in range(n):
                for q in range(n):
                    for i in range(m):
                        diagonal[a, p, q] += jacobian[c, 0, i, p] * turned[1, i, q] + jacobian[c, 1, i, p] * turned[0, i, q]
        if spot[c] >= 0:
            low = 1 if a > b else 0
            high = 1 - low
            for p in range(n):
                for q in range(n):
                    one, other = 0.0, 0.0
                    for i in range(m):
                        one += jacobian[c, high, i, p] * turned[low, i, q]
                        other += jacobian[c, low, i, q] * turned[high, i, p]
                    lower[spot[c], p, q] += one
                    upper[spot[c], p, q] += other


@kernel()
def damp(new: float, error: float, first: bool, stiffness: float) -> tuple[bool, float]:
    """Whether a Newton step that changed the error so is accepted, and the stiffness of the next one."""
    if not (new < 1.5 * error or (first and new < np.inf)):
        return False, 0.125 * stiffness
    if new < 0.7 * error:
        return True, min(4.0 * stiffness, 1e8)
    return True, 2.0 * stiffness if new <= error else 0.5 * stiffness


@kernel()
def newton_bodies(
    inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, index, spot, p, v_out, stiffness, tolerance, limit,
    size_m, size_n,
):  # fmt: skip
    """Semismooth Newton over a FrictionProblem, see solvers/newton.py. p holds the start and then the best answer found.

    Returns iterations, natural map error, the error at the start, and the stiffness at the end.
    """
    count, m, n, contacts = len(order), len(size_m), len(size_n), len(mu)
    inverse, mass, free = in_order(inverse_mass, v_free, order, size_n)
    d = contact_scales(inverse, jacobian, index, compliance, size_m, size_n)
    v, out, best_v = np.zeros((count + 1, n)), np.empty((count + 1, n)), np.empty((count + 1, n))
    w, target, blocks = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m, m))
    copy_flat(free, v)
    relative_velocity(jacobian, index, offset, v, w, size_m, size_n)
    size = size_of(w, d)
    body_velocity(inverse, free, jacobian, index, p, out, v, size_m, size_n)
    best = p.copy()
    copy_flat(v, best_v)
    smallest = error = begin = map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n) / size
    hold, hold_v = p.copy(), v.copy()
    diagonal, lower, upper = np.empty((count, n, n)), np.empty((len(plan.row), n, n)), np.empty((len(plan.row), n, n))
    squares, panels, others = allocate_factors(plan, size_n)
    share, softer, work = np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    iterations, refused = 0, 0
    while iterations < limit and smallest > tolerance and refused < 8:
        relative_velocity(jacobian, index, offset, v, w, size_m, size_n)
        for c in range(contacts):
            if len(compliance):
                for i in range(m):
                    w[c, i] += compliance[c, i] * p[c, i]
            p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
            linearise_law(p[c, 0], p[c, 1], p2, w[c, 0], w[c, 1], w2, mu[c], d[c], stiffness, blocks, target, c, size_m)
            if len(compliance):
                in_series(blocks[c], compliance[c], share, softer, work, size_m)
                take_share(share, target[c], p[c, 0], p[c, 1], p2, size_m)
                copy_flat(softer, blocks[c])
        augment_blocks(mass, jacobian, index, spot, blocks, diagonal, lower, upper, size_m, size_n)
        iterations += 1
        new = np.inf
        if factorise_ldu(plan, diagonal, lower, upper, squares, panels, others, size_n):
            missing_momentum(mass, free, v, out, size_n)
            add_generalised_impulse(jacobian, index, target, out, size_m, size_n)
            solve_ldu(plan, squares, panels, others, out, size_n)
            out[count] = 0.0
            for c in range(contacts):
                a, b = index[c, 0], index[c, 1]
                for i in range(m):
                    p[c, i] = target[c, i]
                for i in range(m):
                    change = 0.0
                    for k in range(n):
                        change += jacobian[c, 0, i, k] * out[a, k] + jacobian[c, 1, i, k] * out[b, k]
                    for k in range(m):
                        p[c, k] -= blocks[c, k, i] * change
            body_velocity(inverse, free, jacobian, index, p, out, v, size_m, size_n)
            new = map_norm(jacobian, index, offset, mu, compliance, d, p, v, size_m, size_n) / size
        accepted, stiffness = damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            copy_flat(p, hold)
            copy_flat(v, hold_v)
        else:
            refused += 1
            copy_flat(hold, p)
            copy_flat(hold_v, v)
        if error < smallest:
            smallest = error
            copy_flat(p, best)
            copy_flat(v, best_v)
    copy_flat(best, p)
    put_back(best_v, order, v_out)
    return iterations, smallest, begin, stiffness
