"""Interior point and proximal points for problems given by W alone.

In the impulses instead of the velocities: a step solves (I + S W) dp = r, S one block per contact. The problems come scaled, so that
trace(W_cc) = m; then the centring treats all contacts alike.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.coulomb_law import OPEN, SLIP, STICK, tangent_length
from masonry_cd.friction.local_operators import delassus_product, local_norm, place_blocks
from masonry_cd.friction.natural_map import size_of
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.inertia import determinant_sign
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.single_columns import UNSYMMETRIC
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import allocate_factors
from masonry_cd.linalg.triangular import solve_ldu
from masonry_cd.solvers.central_path import (
    advance,
    central_start,
    centring_share,
    complementarity,
    corrector_rhs,
    linearise_products,
    longest_step,
    stiffness_after,
)
from masonry_cd.solvers.proximal_kernels import FREE, HELD, first_change, spring_blocks


@kernel()
def factorise_local(data, indices, indptr, blocks, place, plan, diagonal, lower, upper, factors, size_m):
    """Factorise I + S W, S one block per contact. False if that fails."""
    place_blocks(data, indices, indptr, blocks, place, plan, UNSYMMETRIC, diagonal, lower, upper, size_m)
    for i in range(len(place)):
        for r in range(len(size_m)):
            diagonal[i, r, r] += 1.0
    return factorise_ldu(plan, diagonal, lower, upper, factors[0], factors[1], factors[2], size_m)


@kernel()
def solve_local(plan, factors, place, right, x, size_m):
    """x <- (I + S W)^-1 x, by contact; right (C, m) is room for x in the order of elimination."""
    m = len(size_m)
    for c in range(len(place)):
        for i in range(m):
            right[place[c], i] = x[c, i]
    solve_ldu(plan, factors[0], factors[1], factors[2], right, size_m)
    for c in range(len(place)):
        for i in range(m):
            x[c, i] = right[place[c], i]


@kernel()
def interior_direction_local(
    data, indices, indptr, wanted, inverse, gain, miss, soft, plan, factors, place, right, dw, dp, dgamma, size_m, size_k
):
    """The step that changes the products as wanted and takes the other residual away, miss = W p + q - w: dw, dp, dgamma."""
    m, k = len(size_m), len(size_k)
    for c in range(len(dp)):
        for i in range(k):
            total = 0.0
            for j in range(k):
                total += inverse[c, i, j] * wanted[c, j]
            for j in range(m):
                total -= gain[c, i, j] * miss[c, j]
            if i < m:
                dp[c, i] = total
            else:
                dgamma[c] = total
    solve_local(plan, factors, place, right, dp, size_m)
    delassus_product(data, indices, indptr, dp, dw, size_m)
    for c in range(len(dp)):
        for j in range(m):
            dgamma[c] -= gain[c, m, j] * dw[c, j]
        for i in range(m):
            dw[c, i] += miss[c, i] + soft[c, i] * dp[c, i]


@entry()
def interior_local(
    data, indices, indptr, q, friction, place, plan, impulse, distance, stiffness, tolerance, limit, size_m, size_k
):  # fmt: skip
    """Interior point method over a scaled LocalProblem, as :func:`interior_bodies`: (I + G W) dp = r, G the first rows of the gains.

    impulse holds the start and then the best answer found. Returns iterations and natural map error.
    """
    contacts, m, k = len(friction), len(size_m), len(size_k)
    d = np.ones(contacts)
    u, soft, right = np.empty((contacts, m)), np.empty((contacts, m)), np.empty((contacts, m))
    w, p, gamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    dw, dp, dgamma = np.empty((contacts, m)), np.empty((contacts, m)), np.empty(contacts)
    product, wanted, gain = np.empty((contacts, k)), np.empty((contacts, k)), np.empty((contacts, k, m))
    undo, work, blocks = np.empty((contacts, k, k)), np.empty((3, k, k)), np.empty((contacts, m, m))
    diagonal, lower, upper = np.empty((contacts, m, m)), np.empty((len(plan.row), m, m)), np.empty((len(plan.row), m, m))
    factors = allocate_factors(plan, size_m)
    mu = np.maximum(friction, 1e-6)  # a cone without width has no inside
    size, shift = size_of(q, d), distance * np.abs(q).max()
    best = impulse.copy()
    smallest = local_norm(data, indices, indptr, q, friction, d, best, u, size_m) / size
    for c in range(contacts):
        gamma[c] = central_start(best[c], u[c], mu[c], 1.0, shift, w[c], p[c], m)
    step, iterations, short = 1.0, 0, 0
    while iterations < limit and smallest > tolerance and short < 6:
        iterations += 1
        delassus_product(data, indices, indptr, p, u, size_m)
        gap, undone, regular = 0.0, 0.0, True
        for c in range(contacts):
            for i in range(m):
                soft[c, i] = 1.0 / stiffness
                u[c, i] += q[c, i] - w[c, i]  # what w misses
                undone += abs(u[c, i] * p[c, i]) / contacts
            complementarity(w[c], p[c], gamma[c], mu[c], m, product[c])
            gap += 0.5 * (product[c, 0] + product[c, 1]) / contacts
            regular = linearise_products(w[c], p[c], gamma[c], mu[c], soft[c], undo[c], gain[c], work, size_m, size_k) and regular
            copy_flat(gain[c, :m], blocks[c])
        if not (gap > 0.0 and regular) or not factorise_local(
            data, indices, indptr, blocks, place, plan, diagonal, lower, upper, factors, size_m
        ):
            break
        if determinant_sign(plan, factors[0], size_m) < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        centring, longest = 0.0, 0.0
        for turn in range(3):
            if turn == 2 and longest >= 0.1:
                break
            corrector_rhs(dw, dp, dgamma, mu, product, centring * gap, turn == 1, wanted, size_m, size_k)
            interior_direction_local(
                data, indices, indptr, wanted, undo, gain, u, soft, plan, factors, place, right, dw, dp, dgamma, size_m, size_k
            )
            longest = longest_step(w, p, gamma, mu, dw, dp, dgamma, size_m)
            if turn == 0:
                centring = centring_share(dw, dp, dgamma, mu, product, gap, undone, longest, step, wanted, size_m)
        step = min(1.0, 0.99 * longest)
        advance(w, p, gamma, dw, dp, dgamma, step, friction, impulse, size_m)
        short = short + 1 if step < 0.02 else 0
        stiffness = stiffness_after(step, stiffness)
        error = local_norm(data, indices, indptr, q, friction, d, impulse, dw, size_m) / size
        if error < smallest:
            smallest = error
            copy_flat(impulse, best)
        if not error < np.inf:
            break
    copy_flat(best, impulse)
    return iterations, smallest


@kernel()
def spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, held, status, x, p, out, size_m):
    """Trial impulses x and impulses p of the springs at velocities u (C, m), and out = W p + q - u; returns its norm.

    The status of the contacts follows x, or is held as it is.
    """
    m, total = len(size_m), 0.0
    for c in range(len(mu)):
        for i in range(m):
            x[c, i] = centre[c, i] - stiffness * u[c, i]
        length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        if not held:
            status[c] = OPEN if x[c, 0] <= 0.0 else (STICK if length <= mu[c] * x[c, 0] else SLIP)
        share = mu[c] * x[c, 0] / length if status[c] == SLIP and length > 0.0 else 1.0
        for i in range(m):
            p[c, i] = 0.0 if status[c] == OPEN else (x[c, i] if i == 0 else share * x[c, i])
    delassus_product(data, indices, indptr, p, out, size_m)
    for c in range(len(mu)):
        for i in range(m):
            out[c, i] += q[c, i] - u[c, i]
            total += out[c, i] * out[c, i]
    return np.sqrt(total)


@entry()
def proximal_local(data, indices, indptr, q, mu, place, plan, p, tolerance, limit, size_m):
    """Proximal points over a scaled LocalProblem, as :func:`proximal_bodies` but in u: du = r + W dp, (I + B W) dp = -B r, r = W p + q - u.

    p holds the start and then the best answer found. Returns iterations (one factorisation each) and natural map error.
    """
    contacts, m = len(mu), len(size_m)
    d, u, out = np.ones(contacts), np.empty(p.shape), np.empty(p.shape)
    change, trial, right = np.empty(p.shape), np.empty(p.shape), np.empty(p.shape)
    x, dx, blocks, rigid = np.empty(p.shape), np.empty(p.shape), np.empty((contacts, m, m)), np.empty((0, m))
    diagonal, lower, upper = np.empty((contacts, m, m)), np.empty((len(plan.row), m, m)), np.empty((len(plan.row), m, m))
    factors = allocate_factors(plan, size_m)
    status, held = np.zeros(contacts, dtype=np.int64), np.zeros(contacts, dtype=np.int64)
    size = size_of(q, d)
    smallest = error = local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
    best, centre, centre_u = p.copy(), p.copy(), u.copy()
    stiffness = min(max(1.0 / max(error, 1e-300), 1e2), 1e6)
    iterations, failed = 0, 0
    while iterations < limit and smallest > tolerance and failed < 16:
        # the springs' problem to a hundredth of the error, from the centre
        goal = size * max(1e-2 * error, 1e-3 * tolerance)
        copy_flat(centre_u, u)
        norm = spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, FREE, status, x, p, out, size_m)
        begun, turned, last = iterations, 0, -1
        while norm > goal and iterations < min(limit, begun + 60) and turned < 3:
            spring_blocks(mu, rigid, d, stiffness, status, x, blocks, size_m)
            iterations += 1
            if not factorise_local(data, indices, indptr, blocks, place, plan, diagonal, lower, upper, factors, size_m):
                break
            for c in range(contacts):
                for i in range(m):
                    change[c, i] = 0.0
                    for j in range(m):
                        change[c, i] -= blocks[c, i, j] * out[c, j]
            solve_local(plan, factors, place, right, change, size_m)  # that of p
            delassus_product(data, indices, indptr, change, trial, size_m)
            for c in range(contacts):
                for i in range(m):
                    change[c, i] = out[c, i] + trial[c, i]
            step, new = 2.0, np.inf
            copy_flat(status, held)
            while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
                step *= 0.5
                for c in range(contacts):
                    for i in range(m):
                        trial[c, i] = u[c, i] + step * change[c, i]
                new = spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, trial, FREE, status, x, p, out, size_m)
            if new < (1.0 - 0.1 * step) * norm:
                copy_flat(trial, u)
                norm, last, turned = new, -1, 0
                continue
            # no progress across the kinks: as far as the first of them, and the contact there changes its status
            copy_flat(held, status)
            spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, HELD, status, x, p, out, size_m)
            for c in range(contacts):
                for i in range(m):
                    dx[c, i] = -stiffness * change[c, i]
            step, which, other = first_change(mu, status, x, dx, size_m)
            if step < 1.0:
                turned = turned + 1 if which == last and step < 1e-9 else 0
                status[which], last = other, which
            share = min(step, 0.5) if step >= 1.0 else step
            for c in range(contacts):
                for i in range(m):
                    u[c, i] += share * change[c, i]
            norm = spring_residual_local(data, indices, indptr, q, mu, stiffness, centre, u, HELD, status, x, p, out, size_m)
        solved, spent = norm <= goal, iterations - begun
        new = local_norm(data, indices, indptr, q, mu, d, p, trial, size_m) / size
        if not solved and not new < error:
            stiffness, failed = max(0.125 * stiffness, 1.0), failed + 1
            continue
        if not solved:
            stiffness *= 0.25
        elif spent <= 8:
            stiffness *= 16.0 if new > 0.5 * error and spent < 4 else 4.0
        error = new
        stiffness = min(stiffness, max(1e13 * error, 1e4))  # or else rounding, EPSILON times it, shows
        copy_flat(p, centre)
        copy_flat(u, centre_u)
        if error < smallest:
            smallest = error
            copy_flat(p, best)
    copy_flat(best, p)
    return iterations, smallest
