# SPDX-License-Identifier: GPL-3.0-or-later
"""The matrix of ADMM, M + H^T R H, or where W alone is given W + R^-1, and its factors by a team of threads; see admm.py for R."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.contact_groups import (
    COMPLIANCE,
    MU,
    OFFSET,
    SCALE,
    STIFFNESS,
    add_rigid_stiffness,
    field,
    put_stiffness,
    three,
    twist_of,
    velocity_at,
)
from masonry_cd.mechanics.friction.coupling import add_symmetric_blocks, is_coupled
from masonry_cd.mechanics.friction.natural_map import length_of
from masonry_cd.mechanics.friction.operators import has_unit_masses
from masonry_cd.mechanics.linalg.cholesky import factorise_by_team, factorise_cholesky
from masonry_cd.mechanics.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of, share_of_subtrees
from masonry_cd.mechanics.linalg.small_blocks import add_outer_product, copy_flat, is_wide
from masonry_cd.mechanics.linalg.supernodes import has_single_columns
from masonry_cd.mechanics.linalg.threads import wait
from masonry_cd.mechanics.linalg.triples import minus, plus, scaled
from masonry_cd.mechanics.linalg.vectors import LANES, fill_four, root_of, sum_of, where_at_most
from masonry_cd.mechanics.linalg.wide_blocks import add_turned_product

SLIDING = 300.0  # k below which much slides
SAME = 1e-12  # square of how far apart two R may be by rounding, relative to them


@kernel()
def factorise_augmented(team, work, k, shares, p):
    """Factorise M + H^T R H, R by k and what the contacts do at impulses p, by a team; the factors are in single precision.

    ``shares`` of k are for contacts that are open, and that slide. False if the matrix is not positive definite.
    """
    problem = work.problem
    symbolic, squares, panels, _, diagonal, lower, double_squares, double_panels = work.factor
    n, (begin, end) = len(problem.n), share_of_subtrees(team, symbolic)
    for q in range(begin, end):
        choose_stiffness(work, q, k, shares, p)
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
def choose_stiffness(work, q, k, shares, p):
    """R of the contacts of subtree q: k / d_c for rigid ones that stick, less for others, softer for elastic ones; see admm.py."""
    groups, rho = work.groups, work.factor.rho
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist = twist_of(groups, g, work.iterates.v, work.problem)
        for row in range(groups.start[g], groups.start[g + 1]):
            put_stiffness(groups.table, row, stiffness_of(work, row, twist, k, shares, p))
            for lane in range(LANES):
                if groups.contact[row, lane] >= 0:
                    rho[groups.contact[row, lane]] = groups.table[row, LANES * STIFFNESS + lane]


@borrower()
def recall_stiffness(work, q):
    """R of the contacts of subtree q as it was when the matrix was factorised last."""
    groups, rho = work.groups, work.factor.rho
    for row in range(groups.start[groups.subtree[q]], groups.start[groups.subtree[q + 1]]):
        for lane in range(LANES):
            c = groups.contact[row, lane]
            groups.table[row, LANES * STIFFNESS + lane] = rho[c] if c >= 0 else 0.0
        put_stiffness(groups.table, row, field(groups.table, row, STIFFNESS))


@borrower()
def count_changes(work, q, k, shares, p):
    """How many contacts of subtree q would have another R at the same k."""
    groups, one, zero, changed = work.groups, fill_four(1.0), fill_four(0.0), fill_four(0.0)
    if k >= SLIDING or work.problem.elastic:
        return 0.0
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist = twist_of(groups, g, work.iterates.v, work.problem)
        for row in range(groups.start[g], groups.start[g + 1]):
            rho = field(groups.table, row, STIFFNESS)
            off = rho - stiffness_of(work, row, twist, k, shares, p)
            changed += where_at_most(off * off, SAME * rho * rho, zero, one)
    return sum_of(changed)


@borrower(forceinline=True, fastmath={"contract"})
def stiffness_of(work, row, twist, k, shares, p):
    """R of a row of contacts by k, their compliance and, of rigid ones where much slides, what they do; 0 in empty places."""
    table, problem, zero = work.groups.table, work.problem, fill_four(0.0)
    d, share = field(table, row, SCALE), fill_four(1.0)
    if problem.elastic:
        c0, c1, c2 = three(table, row, COMPLIANCE)
        soft = (c0 + c1 + c2) * (1.0 / len(problem.m))
        own = d - soft
        return where_at_most(d, zero, zero, 1.0 / (own / k + soft / root_of(1.0 + soft / own)))
    if k < SLIDING:
        mu, old = field(table, row, MU), three(p, row, 0)
        un, u1, u2 = scaled(k / d, plus(velocity_at(work.groups, row, twist), three(table, row, OFFSET)))
        xn, x1, x2 = minus(old, (un + mu * length_of(u1, u2), u1, u2))
        tangent = length_of(x1, x2)
        share = where_at_most(tangent, mu * xn, share, fill_four(shares[1]))
        share = where_at_most(mu * tangent, -1.0 * xn, fill_four(shares[0]), share)
    return where_at_most(d, zero, zero, k / d * share)


@kernel(fastmath={"contract"})
def augment(work, q):
    """Blocks of M + H^T R H in the columns of subtree q; what its contacts add to diagonal blocks of later ones goes to ghost rows."""
    symbolic, problem, groups, diagonal, lower = (
        work.factor.symbolic,
        work.problem,
        work.groups,
        work.factor.diagonal,
        work.factor.lower,
    )
    s, n, rigid, (first, last) = len(groups.s), len(problem.n), len(groups.s) > 3, nodes_of(symbolic, q)
    rows, turned = np.empty((2, s, n)), np.empty((2, s, n))
    lower[symbolic.column[first] : symbolic.column[last]] = 0.0
    lower[-1] = 0.0
    clear_ghosts(symbolic, q, diagonal)
    for b in range(first, last):
        for p in range(n):
            for r in range(n):
                diagonal[b, n * p + r] = (1.0 if p == r else 0.0) if has_unit_masses(problem) else problem.mass[b, p, r]
    if is_coupled(problem):
        augment_coupled(work, first, last)
        return
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        if rigid:
            add_rigid_stiffness(groups, g, diagonal, lower.reshape((len(lower), n * n)))
            continue
        for lane in range(LANES):
            r = groups.table[groups.start[g], LANES * STIFFNESS + lane]
            for side in range(2):
                for i in range(s):
                    for k in range(n):
                        rows[side, i, k] = groups.rows[g, LANES * ((side * s + i) * n + k) + lane]
                        turned[side, i, k] = r * rows[side, i, k]
            add_contact(work, g, lane, rows, turned)


@borrower()
def augment_coupled(work, first, last):
    """Blocks of W + R^-1 in the columns first to last, for a problem given by W alone, see coupling.py."""
    problem, n, factor = work.problem, len(work.problem.n), work.factor
    diagonal = factor.diagonal.reshape((len(factor.diagonal), n, n))
    diagonal[first:last] = 0.0
    for c in range(len(problem.places)):
        b = problem.places[c, 0]
        for i in range(n if first <= b < last else 0):
            diagonal[b, i, i] = 1.0 / factor.rho[c]
    add_symmetric_blocks(problem.coupling, problem.places, problem.inverse[:, 0, 0], (first, last), factor.symbolic, diagonal, factor.lower)


@borrower()
def add_contact(work, g, lane, rows, turned):
    """What a contact of group g adds to the matrix: rows of H and R H (2, s, n)."""
    problem, groups, n, lower = work.problem, work.groups, len(work.problem.n), work.factor.lower
    a, b, block = groups.place[g, lane], groups.place[g, LANES + lane], groups.block[g, lane]
    diagonal = work.factor.diagonal.reshape((len(work.factor.diagonal), n, n))
    for side in range(2):
        body = b if side else a
        if body < len(problem.free):
            own = diagonal[groups.target[g, LANES * side + lane]]
            add_product(problem, turned[side], rows[side], body, body, own, groups.s)
            if a == b:
                add_product(problem, turned[side], rows[1 - side], body, body, own, groups.s)
    if block < len(lower) - 1:
        low = 0 if a > b else 1
        add_product(problem, turned[low], rows[1 - low], max(a, b), min(a, b), lower[block], groups.s)


@borrower()
def add_product(problem, x, y, one, other, out, size_s):
    """out (n, n) += x^T y of rows (s, n) of two bodies, as far as these have unknowns."""
    if is_wide(problem.n):
        unit, n = has_unit_masses(problem), len(problem.n)
        add_turned_product(x, y, len(size_s), (problem.width[one], problem.width[other]) if unit else (n, n), out)
    else:
        add_outer_product(x, y, out, size_s, problem.n)
