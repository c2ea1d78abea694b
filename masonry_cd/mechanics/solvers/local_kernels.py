"""Sweeps of Gauss-Seidel, plain and extrapolated, and ADMM for problems given by W alone."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import ROW, START, local_impulse, own_velocity, prepare_law, tangent_length
from masonry_cd.mechanics.friction.local_operators import (
    LocalArrays,
    local_norm,
    local_residual,
    local_velocity,
    place_blocks,
    row_velocity,
    squared_residuals,
)
from masonry_cd.mechanics.friction.natural_map import project_to_cone, size_of
from masonry_cd.mechanics.friction.random_order import seeded, shuffle
from masonry_cd.mechanics.linalg.cholesky import factorise_cholesky
from masonry_cd.mechanics.linalg.single_columns import SYMMETRIC
from masonry_cd.mechanics.linalg.small_blocks import copy_flat, identities
from masonry_cd.mechanics.linalg.supernodes import BlockMatrix, allocate_factors
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.triangular import solve_cholesky
from masonry_cd.mechanics.solvers.admm_kernels import GROWTH, SOFT, SOFTEST, STIFF, SWITCH, WON
from masonry_cd.mechanics.solvers.nlgs_kernels import SweepSettings, next_weight
from masonry_cd.mechanics.solvers.nlgs_table import law_of

LOOK = 5  # iterations of ADMM between two measurements of the error
LAW, SHRINK = 0.02, 0.2  # share of ADMM's error that lies in the law, above which k grows; factor by which it falls otherwise


@entry()
def sweep_local_problem(problem: LocalArrays, own: np.ndarray, p: np.ndarray, settings: SweepSettings) -> tuple[int, float]:
    """Sweeps over a LocalProblem whose diagonal blocks are ``own`` (C, m, m). p (C, m) holds the start and then the best answer.

    Returns the sweeps made and the natural map error of the answer.
    """
    data, indices, indptr, q, mu = problem.data, problem.indices, problem.indptr, problem.q, problem.mu
    law, order, last, best, state = local_table(own, mu), np.arange(len(p)), p.copy(), p.copy(), seeded(settings.seed)
    smallest = error = local_residual(data, indices, indptr, q, mu, p, law)
    sweeps, weight = 0, 1.0
    while smallest > settings.tolerance and sweeps < settings.limit:
        if not settings.extrapolated:
            shuffle(order, state)
        sweep_local(problem, law, order, p)
        sweeps += 1
        if sweeps % settings.every == 0 or sweeps == settings.limit:
            before, error = error, local_residual(data, indices, indptr, q, mu, p, law)
            if error < smallest:
                smallest = error
                copy_flat(p, best)
            if not error <= before:
                weight = 1.0
        if settings.extrapolated:
            weight, factor = next_weight(weight)
            for c in range(len(p)):
                for i in range(p.shape[1]):
                    new = p[c, i]
                    p[c, i] = new + factor * (new - last[c, i])
                    last[c, i] = new
    copy_flat(best, p)
    return sweeps, smallest


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


@borrower()
def sweep_local(problem, law, order, p):
    """One sweep: the exact impulses of each contact in turn, into p (C, m), with all others held."""
    data, indices, indptr, q, mu = problem.data, problem.indices, problem.indptr, problem.q, problem.mu
    m = p.shape[1]
    for c in order:
        p2 = p[c, 2] if m == 3 else 0.0
        inverse_nn, c1, c2, s11, s12, s22, nn = law_of(law, c)
        own_n, own_1, own_2 = own_velocity(p[c, 0], p[c, 1], p2, c1, c2, s11, s12, s22, nn)
        qn = row_velocity(data, indices, indptr, q, p, c, 0) - own_n
        q1 = row_velocity(data, indices, indptr, q, p, c, 1) - own_1
        q2 = row_velocity(data, indices, indptr, q, p, c, 2) - own_2 if m == 3 else 0.0
        pn, p1, p2, law[c, START] = local_impulse((qn, q1, q2), (inverse_nn, c1, c2, s11, s12, s22), mu[c], law[c, START])
        p[c, 0], p[c, 1] = pn, p1
        if m == 3:
            p[c, 2] = p2


@entry()
def admm_local(
    problem: LocalArrays, order: np.ndarray, symbolic: SymbolicFactor, p: np.ndarray, k: float, tolerance: float, limit: int
) -> tuple[int, float]:
    """ADMM over a LocalProblem: pi stands for the velocities, u = W pi + q, and (W + R^-1) (pi+ - pi) = R^-1 (2 p+ - p - pi).

    p (C, m) holds the start and then the best answer. Returns iterations and natural map error.
    """
    place, factor, size = problem.place, allocate_factors(symbolic, problem.m), size_of(problem.q, problem.d)
    pi, u, right, best = p.copy(), np.empty(p.shape), np.empty(p.shape), p.copy()
    smallest = before = local_norm(problem, p, u) / size
    iterations, checked, switched, fresh = 0, 0, 0, True
    while iterations < limit and smallest > tolerance:
        if fresh:
            if not factorise_shifted(problem, order, k, factor):
                k = 0.1 * k
                if k < SOFTEST:
                    break
                continue
            fresh = False
        project_local(problem, k, p, pi, u, right)
        solve_cholesky(symbolic, factor.squares, factor.panels, right, problem.m)
        for c in range(len(p)):
            for i in range(len(problem.m)):
                pi[c, i] += right[place[c], i]
        iterations += 1
        if iterations - checked >= LOOK or iterations == limit:
            checked = iterations
            error = local_norm(problem, p, u) / size
            if error < smallest:
                smallest = error
                copy_flat(p, best)
            if not error < np.inf:
                copy_flat(best, p)
                copy_flat(best, pi)
            if iterations - switched >= SWITCH:
                if not error < WON * before:
                    local_velocity(problem, pi, u)
                    k, fresh = local_stiffness(k, squared_residuals(problem, p, u), size, error), True
                switched, before = iterations, error
        local_velocity(problem, pi, u)
    copy_flat(best, p)
    return iterations, smallest


@kernel()
def factorise_shifted(problem, order, k, factor):
    """Factorise W + R^-1, its symmetric part; False if it is not positive definite."""
    symbolic, size, d = factor.symbolic, problem.m, problem.d
    count, m = len(d), len(size)
    diagonal, lower = np.empty((count, m, m)), np.empty((len(symbolic.row), m, m))
    place_blocks(problem, identities(count, size), symbolic, SYMMETRIC, BlockMatrix(diagonal, lower, lower))
    for i in range(count):
        for r in range(m):
            diagonal[i, r, r] += d[order[i]] / k
    return factorise_cholesky(symbolic, diagonal, lower, factor.squares, factor.panels, size)


@borrower()
def project_local(problem, k, p, pi, u, right):
    """p <- p+ = P_K(p - R (u + mu |u_t| n)), and right = R^-1 (2 p+ - p - pi), that of each contact at its place."""
    place, mu, d, m = problem.place, problem.mu, problem.d, len(problem.m)
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


@borrower()
def local_stiffness(k, squares, size, error):
    """The next k: larger where the error of the pair (p, pi) is more than a small share of that of p, otherwise smaller."""
    return min(GROWTH * k, STIFF) if np.sqrt(squares) / size > LAW * error else max(SHRINK * k, SOFT)
