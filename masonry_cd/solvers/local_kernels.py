"""Gauss-Seidel and ADMM for problems given by W alone."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.coulomb_law import ROW, START, local_impulse, own_velocity, prepare_law, tangent_length
from masonry_cd.friction.local_operators import LocalArrays, delassus_product, local_norm, local_residual, place_blocks, row_velocity
from masonry_cd.friction.natural_map import project_to_cone, size_of, squared_residual
from masonry_cd.friction.random_order import seeded, shuffle
from masonry_cd.jit import entry
from masonry_cd.linalg.cholesky import factorise_cholesky
from masonry_cd.linalg.small_blocks import copy_flat, identities
from masonry_cd.linalg.supernodes import BlockMatrix, allocate_factors
from masonry_cd.linalg.triangular import solve_cholesky
from masonry_cd.solvers.admm_kernels import SOFTEST


@entry()
def nlgs_local(data, indices, indptr, diagonal, q, mu, p, tolerance, limit, seed, every):
    """Gauss-Seidel over a LocalProblem with W in blocks (nnz, m, m). p holds the start and then the answer."""
    contacts, m = p.shape
    law = np.empty((contacts, ROW))
    w = np.zeros((3, 3))
    for c in range(contacts):
        for i in range(m):
            for j in range(m):
                w[i, j] = diagonal[c, i, j]
        prepare_law(w, m, mu[c], law, c)
    order = np.arange(contacts)
    state = seeded(seed)
    error = local_residual(data, indices, indptr, q, mu, p, law)
    sweeps = 0
    while error > tolerance and sweeps < limit:
        for _ in range(min(every, limit - sweeps)):
            shuffle(order, state)
            sweeps += 1
            for c in order:
                p2 = p[c, 2] if m == 3 else 0.0
                c1, c2, s11, s12, s22 = law[c, 1], law[c, 2], law[c, 3], law[c, 4], law[c, 5]
                own_n, own_1, own_2 = own_velocity(p[c, 0], p[c, 1], p2, c1, c2, s11, s12, s22, law[c, 6])
                qn = row_velocity(data, indices, indptr, q, p, c, 0) - own_n
                q1 = row_velocity(data, indices, indptr, q, p, c, 1) - own_1
                q2 = row_velocity(data, indices, indptr, q, p, c, 2) - own_2 if m == 3 else 0.0
                pn, p1, p2, law[c, START] = local_impulse((qn, q1, q2), (law[c, 0], c1, c2, s11, s12, s22), mu[c], law[c, START])
                p[c, 0], p[c, 1] = pn, p1
                if m == 3:
                    p[c, 2] = p2
        error = local_residual(data, indices, indptr, q, mu, p, law)
    return sweeps, error


@entry()
def admm_local(data, indices, indptr, q, mu, d, order, place, plan, p, k, tolerance, limit, size_m):
    """ADMM over a LocalProblem: pi stands for the velocities, u = W pi + q, and (W + R^-1) (pi+ - pi) = R^-1 (2 p+ - p - pi).

    p holds the start and then the best answer. Returns iterations and natural map error.
    """
    count, m = len(mu), len(size_m)
    diagonal, lower = np.empty((count, m, m)), np.empty((len(plan.row), m, m))
    problem, matrix = LocalArrays(data, indices, indptr, q, mu, d, place, size_m), BlockMatrix(diagonal, lower, lower)
    factor = allocate_factors(plan, size_m)
    squares, panels = factor.squares, factor.panels
    scale = identities(count, size_m)
    size = size_of(q, d)
    pi, u, right, best = p.copy(), np.empty(p.shape), np.empty(p.shape), p.copy()
    smallest = before = local_norm(problem, p, u) / size
    iterations, checked, switched, fresh = 0, 0, 0, True
    while iterations < limit and smallest > tolerance:
        if fresh:
            place_blocks(problem, scale, plan, True, matrix)
            for i in range(count):
                for r in range(m):
                    diagonal[i, r, r] += d[order[i]] / k
            if not factorise_cholesky(plan, diagonal, lower, squares, panels, size_m):
                k = 0.1 * k
                if k < SOFTEST:
                    break
                continue
            fresh = False
        for c in range(count):
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
        solve_cholesky(plan, squares, panels, right, size_m)
        for c in range(count):
            for i in range(m):
                pi[c, i] += right[place[c], i]
        iterations += 1
        if iterations - checked >= 5 or iterations == limit:
            checked = iterations
            error = local_norm(problem, p, u) / size
            if error < smallest:
                smallest = error
                copy_flat(p, best)
            if not error < np.inf:
                copy_flat(best, p)
                copy_flat(best, pi)
            if iterations - switched >= 40:
                if not error < 0.1 * before:
                    delassus_product(problem, pi, u)
                    total = 0.0
                    for c in range(count):
                        for i in range(m):
                            u[c, i] += q[c, i]
                        p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
                        total += squared_residual(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, mu[c], d[c])
                    own = np.sqrt(total) / size
                    k = min(5.0 * k, 1e6) if own > 0.02 * error else max(0.2 * k, 1.0)
                    fresh = True
                switched, before = iterations, error
        delassus_product(problem, pi, u)
        for c in range(count):
            for i in range(m):
                u[c, i] += q[c, i]
    copy_flat(best, p)
    return iterations, smallest
