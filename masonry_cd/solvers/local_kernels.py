"""Gauss-Seidel, ADMM and Newton for problems given by W alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction.coulomb_law import ROW, START, local_impulse, own_velocity, prepare_law, tangent_length
from masonry_cd.friction.local_operators import delassus_product, local_norm, local_residual, place_blocks, row_velocity
from masonry_cd.friction.natural_map import project_to_cone, size_of, squared_residual
from masonry_cd.friction.random_order import seeded, shuffle
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.cholesky import factorise_cholesky
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat, identities, invert, multiply
from masonry_cd.linalg.supernodes import allocate_factors
from masonry_cd.linalg.triangular import solve_cholesky, solve_ldu
from masonry_cd.solvers.admm_kernels import GROWTH, SOFT, SOFTEST, STIFF, SWITCH, WON
from masonry_cd.solvers.newton_kernels import damp, linearise_law
from masonry_cd.solvers.nlgs_table import law_of

LOOK = 5  # iterations of ADMM between two measurements of the error
LAW, SHRINK = 0.02, 0.2  # share of ADMM's error that lies in the law, above which k grows; factor by which it falls otherwise


class LocalArrays(NamedTuple):
    """A LocalProblem u = W p + q as the kernels take it."""

    data: np.ndarray  # (nnz, m, m) blocks of W
    indices: np.ndarray  # (nnz,) their columns
    indptr: np.ndarray  # (C + 1,) starts of their rows
    q: np.ndarray  # (C, m)
    mu: np.ndarray  # (C,)
    d: np.ndarray  # (C,) scales
    size_m: tuple[int, ...]  # m zeros: its length is known to the compiler


@entry()
def nlgs_local(problem, own, p, settings):
    """Gauss-Seidel over a LocalProblem whose diagonal blocks are ``own`` (C, m, m). p (C, m) holds the start and then the answer.

    Returns the sweeps made and the natural map error measured last.
    """
    data, indices, indptr, q, mu = problem[:5]
    law = local_table(own, mu)
    order, state = np.arange(len(p)), seeded(settings.seed)
    error, sweeps = local_residual(data, indices, indptr, q, mu, p, law), 0
    while error > settings.tolerance and sweeps < settings.limit:
        for _ in range(min(settings.every, settings.limit - sweeps)):
            shuffle(order, state)
            sweeps += 1
            sweep_local(problem, law, order, p)
        error = local_residual(data, indices, indptr, q, mu, p, law)
    return sweeps, error


@kernel()
def local_table(own, mu):
    """The laws of the contacts (C, ROW), from the diagonal blocks of W."""
    contacts, m, _ = own.shape
    law, w = np.empty((contacts, ROW)), np.zeros((3, 3))
    for c in range(contacts):
        for i in range(m):
            for j in range(m):
                w[i, j] = own[c, i, j]
        prepare_law(w, m, mu[c], law, c)
    return law


@kernel()
def sweep_local(problem, law, order, p):
    """One sweep: the exact impulses of each contact in turn, into p (C, m), with all others held."""
    data, indices, indptr, q, mu = problem[:5]
    m = p.shape[1]
    for c in order:
        p2 = p[c, 2] if m == 3 else 0.0
        inverse_nn, c1, c2, s11, s12, s22, nn = law_of(law, c)
        own_n, own_1, own_2 = own_velocity(p[c, 0], p[c, 1], p2, c1, c2, s11, s12, s22, nn)
        qn = row_velocity(data, indices, indptr, q, p, c, 0) - own_n
        q1 = row_velocity(data, indices, indptr, q, p, c, 1) - own_1
        q2 = row_velocity(data, indices, indptr, q, p, c, 2) - own_2 if m == 3 else 0.0
        pn, p1, p2, law[c, START] = local_impulse(qn, q1, q2, inverse_nn, c1, c2, s11, s12, s22, mu[c], law[c, START])
        p[c, 0], p[c, 1] = pn, p1
        if m == 3:
            p[c, 2] = p2


@entry()
def admm_local(problem, order, place, symbolic, p, k, tolerance, limit):
    """ADMM over a LocalProblem: pi stands for the velocities, u = W pi + q, and (W + R^-1) (pi+ - pi) = R^-1 (2 p+ - p - pi).

    p (C, m) holds the start and then the best answer. Returns iterations and natural map error.
    """
    data, indices, indptr, q, mu, d, size_m = problem
    squares, panels, _ = allocate_factors(symbolic, size_m)
    size = size_of(q, d)
    pi, u, right, best = p.copy(), np.empty(p.shape), np.empty(p.shape), p.copy()
    smallest = before = local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
    iterations, checked, switched, fresh = 0, 0, 0, True
    while iterations < limit and smallest > tolerance:
        if fresh:
            if not factorise_shifted(problem, order, place, symbolic, k, squares, panels):
                k = 0.1 * k
                if k < SOFTEST:
                    break
                continue
            fresh = False
        project_local(problem, place, k, p, pi, u, right)
        solve_cholesky(symbolic, squares, panels, right, size_m)
        for c in range(len(p)):
            for i in range(len(size_m)):
                pi[c, i] += right[place[c], i]
        iterations += 1
        if iterations - checked >= LOOK or iterations == limit:
            checked = iterations
            error = local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
            if error < smallest:
                smallest = error
                copy_flat(p, best)
            if not error < np.inf:
                copy_flat(best, p)
                copy_flat(best, pi)
            if iterations - switched >= SWITCH:
                if not error < WON * before:
                    velocity_of_impulses(problem, pi, u)
                    k, fresh = local_stiffness(k, squared_residuals(problem, p, u), size, error), True
                switched, before = iterations, error
        velocity_of_impulses(problem, pi, u)
    copy_flat(best, p)
    return iterations, smallest


@kernel()
def factorise_shifted(problem, order, place, symbolic, k, squares, panels):
    """Factorise W + R^-1, its symmetric part; False if it is not positive definite."""
    data, indices, indptr, d, size_m = problem.data, problem.indices, problem.indptr, problem.d, problem.size_m
    count, m = len(d), len(size_m)
    diagonal, lower = np.empty((count, m, m)), np.empty((len(symbolic.row), m, m))
    place_blocks(data, indices, indptr, identities(count, size_m), place, symbolic, True, diagonal, lower, lower, size_m)
    for i in range(count):
        for r in range(m):
            diagonal[i, r, r] += d[order[i]] / k
    return factorise_cholesky(symbolic, diagonal, lower, squares, panels, size_m)


@kernel()
def project_local(problem, place, k, p, pi, u, right):
    """p <- p+ = P_K(p - R (u + mu |u_t| n)), and right = R^-1 (2 p+ - p - pi), that of each contact at its place."""
    mu, d, m = problem.mu, problem.d, len(problem.size_m)
    for c in range(len(mu)):
        rho = k / d[c]
        p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
        shift = mu[c] * tangent_length(u[c, 1], u2)
        xn, x1, x2 = project_to_cone(p[c, 0] - rho * (u[c, 0] + shift), p[c, 1] - rho * u[c, 1], p2 - rho * u2, mu[c])
        right[place[c], 0] = (2.0 * xn - p[c, 0] - pi[c, 0]) / rho
        right[place[c], 1] = (2.0 * x1 - p[c, 1] - pi[c, 1]) / rho
        p[c, 0], p[c, 1] = xn, x1
        if m == 3:
            right[place[c], 2] = (2.0 * x2 - p2 - pi[c, 2]) / rho
            p[c, 2] = x2


@kernel()
def velocity_of_impulses(problem, p, u):
    """u = W p + q, (C, m)."""
    delassus_product(problem.data, problem.indices, problem.indptr, p, u, problem.size_m)
    for c in range(len(u)):
        for i in range(len(problem.size_m)):
            u[c, i] += problem.q[c, i]


@kernel()
def squared_residuals(problem, p, u):
    """Sum of the squared natural map residuals of impulses p and velocities u, (C, m)."""
    total, m = 0.0, len(problem.size_m)
    for c in range(len(p)):
        p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
        total += squared_residual(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, problem.mu[c], problem.d[c])
    return total


@kernel()
def local_stiffness(k, squares, size, error):
    """The next k: larger where the error of the pair (p, pi) is more than a small share of that of p, otherwise smaller."""
    return min(GROWTH * k, STIFF) if np.sqrt(squares) / size > LAW * error else max(SHRINK * k, SOFT)


@entry()
def newton_local(data, indices, indptr, own, q, mu, d, place, plan, p, stiffness, tolerance, limit, size_m):
    """Semismooth Newton over a LocalProblem: (I + B W) (p+ - p) = g - p, its rows scaled to unit diagonal blocks.

    own (C, m, m) are the blocks W_cc. p holds the start and then the best answer. Returns iterations, error, error at the start.
    """
    count, m = len(mu), len(size_m)
    diagonal, lower, upper = np.empty((count, m, m)), np.empty((len(plan.row), m, m)), np.empty((len(plan.row), m, m))
    squares, panels, others = allocate_factors(plan, size_m)
    scale, right, unit = np.empty((count, m, m)), np.empty(p.shape), np.empty((count, m, m))
    target, block, work, inverse = np.zeros((1, m)), np.zeros((1, m, m)), np.empty((m, m)), np.empty((m, m))
    small = np.empty((m, m))
    size = size_of(q, d)
    u, best, hold = np.empty(p.shape), p.copy(), p.copy()
    smallest = error = begin = local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
    iterations, refused = 0, 0
    while iterations < limit and smallest > tolerance and refused < 8:
        regular = True
        for c in range(count):
            p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
            linearise_law(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, mu[c], d[c], stiffness, block, target, 0, size_m)
            for i in range(m):
                for j in range(m):
                    small[i, j] = block[0, i, j]
            multiply(small, own[c], False, work, size_m)
            for i in range(m):
                work[i, i] += 1.0
            regular = regular and invert(work, inverse, diagonal[0], size_m)
            multiply(inverse, small, False, scale[c], size_m)
            for i in range(m):
                total = 0.0
                for j in range(m):
                    total += inverse[i, j] * (target[0, j] - p[c, j])
                    unit[place[c], i, j] = inverse[i, j]
                right[place[c], i] = total
        place_blocks(data, indices, indptr, scale, place, plan, False, diagonal, lower, upper, size_m)
        for i in range(count):
            for r in range(m):
                for s in range(m):
                    diagonal[i, r, s] += unit[i, r, s]
        iterations += 1
        new = np.inf
        if regular and factorise_ldu(plan, diagonal, lower, upper, squares, panels, others, size_m):
            solve_ldu(plan, squares, panels, others, right, size_m)
            for c in range(count):
                for i in range(m):
                    p[c, i] += right[place[c], i]
            new = local_norm(data, indices, indptr, q, mu, d, p, u, size_m) / size
        accepted, stiffness = damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            copy_flat(p, hold)
        else:
            refused += 1
            copy_flat(hold, p)
            local_norm(data, indices, indptr, q, mu, d, p, u, size_m)
        if error < smallest:
            smallest = error
            copy_flat(p, best)
    copy_flat(best, p)
    return iterations, smallest, begin
