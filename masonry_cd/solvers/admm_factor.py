"""The matrix of ADMM, M + H^T R H, and its factorisation by a team of threads; see admm.py for the choice of R."""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.cholesky import factorise_by_team, factorise_cholesky
from masonry_cd.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of, share_of_subtrees
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import has_single_columns
from masonry_cd.linalg.threads import share_of, wait


@kernel()
def factorise_augmented(team, work, k):
    """Factorise M + H^T R H, R by k, by a team; the factors are in single precision. False if it is not positive definite."""
    problem = work.problem
    symbolic, squares, panels, rho, diagonal, lower, double_squares, double_panels = work.factor
    n, (begin, end) = len(problem.n), share_of_subtrees(team, symbolic)
    first, last = share_of(team, 0, len(rho))
    choose_stiffness(k, problem.d, problem.compliance, first, last, rho)
    wait(team)
    for q in range(begin, end):
        augment(work, q)
    wait(team)
    for q in range(begin, end):
        add_ghosts(symbolic, q, diagonal)
    wait(team)
    blocks = diagonal.reshape((len(diagonal), n, n))
    if not has_single_columns(symbolic):
        return factorise_by_team(team, symbolic, blocks, lower, squares, panels, n)
    ok = factorise_cholesky(symbolic, blocks, lower, double_squares, double_panels, problem.n)  # one subtree, so one thread
    copy_flat(double_squares, squares)
    copy_flat(double_panels, panels)
    return ok


@borrower()
def choose_stiffness(k, d, compliance, first, end, rho):
    """R of the contacts first to end: k / d_c for rigid ones, softer for elastic ones."""
    for c in range(first, end):
        rho[c] = k / d[c]
        if len(compliance):
            soft = compliance[c].sum() / compliance.shape[1]
            own = d[c] - soft
            rho[c] = 1.0 / (own / k + soft / np.sqrt(1.0 + soft / own))


@borrower(fastmath={"contract"})
def augment(work, q):
    """Blocks of M + H^T R H in the columns of subtree q; what its contacts add to diagonal blocks of later ones goes to ghost rows."""
    symbolic, mass, jacobian, partition = work.factor.symbolic, work.problem.mass, work.problem.jacobian, work.partition
    places, block, rho, diagonal, lower = work.problem.places, work.problem.block, work.factor.rho, work.factor.diagonal, work.factor.lower
    m, n, bodies, (first, last) = len(work.problem.m), len(work.problem.n), len(mass), nodes_of(symbolic, q)
    lower[symbolic.column[first] : symbolic.column[last]] = 0.0
    clear_ghosts(symbolic, q, diagonal)
    for b in range(first, last):
        for p in range(n):
            for r in range(n):
                diagonal[b, n * p + r] = mass[b, p, r]
    for c in range(partition.start[q], partition.start[q + 1]):
        a, b, r = partition.target[c, 0], partition.target[c, 1], rho[c]
        for i in range(m):
            for p in range(n):
                x, y = r * jacobian[c, 0, i, p], r * jacobian[c, 1, i, p]
                for t in range(n):
                    if a != bodies:
                        diagonal[a, n * p + t] += x * jacobian[c, 0, i, t]
                    if b != bodies:
                        diagonal[b, n * p + t] += y * jacobian[c, 1, i, t]
                if a == b != bodies:
                    for t in range(n):
                        diagonal[a, n * p + t] += x * jacobian[c, 1, i, t] + y * jacobian[c, 0, i, t]
                if block[c] >= 0:
                    for t in range(n):
                        lower[block[c], p, t] += x * jacobian[c, 1, i, t] if places[c, 0] > places[c, 1] else y * jacobian[c, 0, i, t]
