# SPDX-License-Identifier: GPL-3.0-or-later
"""Work of ADMM in a subtree, see admm.py: the matrix M + H^T R H, or where W alone is given W + R^-1, and the passes of an iteration.

These are forward substitution after a pass over the contacts, and backward substitution. A team of threads makes the factors.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.contact_geometry import IN_SPACE, fill_row
from masonry_cd.mechanics.friction.coupling import add_coupled, add_symmetric_blocks, is_coupled
from masonry_cd.mechanics.friction.natural_map import length_of, project_to_cone, squared_residual
from masonry_cd.mechanics.friction.operators import add_product, form_of_problem, load_mass, momentum_residual_of
from masonry_cd.mechanics.linalg.factor import factorise_cholesky
from masonry_cd.mechanics.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of, share_of_subtrees
from masonry_cd.mechanics.linalg.threads import wait
from masonry_cd.mechanics.linalg.triangular import backward_substitution, forward_substitution
from masonry_cd.mechanics.linalg.triples import inner, minus, plus, scaled
from masonry_cd.mechanics.linalg.vectors import LANES, fill_four, root_of, store_lanes, sum_of, where_at_most
from masonry_cd.mechanics.solvers.contact_groups import (
    COMPLIANCE,
    MU,
    NORMAL,
    OFFSET,
    SCALE,
    SHARE,
    STIFFNESS,
    STRETCH,
    TANGENT,
    add_rigid_stiffness,
    add_to_wrench,
    add_wrench,
    field,
    law_velocity,
    no_wrench,
    put_three,
    three,
    twist_of,
    velocity_at,
)

SLIDING = 300.0  # k below which much slides
SAME = 1e-12  # square of how far apart two R may be by rounding, relative to them


@kernel()
def factorise_augmented(team, work, k, shares, p):
    """Factorise M + H^T R H, R by k and what the contacts do at impulses p, by a team; the factors are in single precision.

    ``shares`` of k are for contacts that are open, and that slide. False if the matrix is not positive definite.
    """
    symbolic, (begin, end) = work.factor.symbolic, share_of_subtrees(team, work.factor.symbolic)
    for q in range(begin, end):
        choose_stiffness(work, q, k, shares, p)
        augment(work, q)
    wait(team)
    for q in range(begin, end):
        add_ghosts(symbolic, q, flat_rows(work.factor.diagonal))
    wait(team)
    return factorise_cholesky(team, work.factor) != 0.0


@kernel(inline="always")
def flat_rows(blocks):
    """Blocks (N, n, n) as rows (N, n n)."""
    return blocks.reshape((len(blocks), blocks.shape[1] * blocks.shape[2]))


@borrower()
def choose_stiffness(work, q, k, shares, p):
    """R of the contacts of subtree q: k / d_c for rigid ones that stick, less for others, softer for elastic ones; see admm.py."""
    groups, rho = work.groups, work.rho
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
    groups, rho = work.groups, work.rho
    for row in range(groups.start[groups.subtree[q]], groups.start[groups.subtree[q + 1]]):
        for lane in range(LANES):
            c = groups.contact[row, lane]
            groups.table[row, LANES * STIFFNESS + lane] = rho[c] if c >= 0 else 0.0
        put_stiffness(groups.table, row, field(groups.table, row, STIFFNESS))


@borrower()
def count_changes(work, q, k, shares, p):
    """How many contacts of subtree q would have another R at the same k."""
    groups, one, zero, changed = work.groups, fill_four(1.0), fill_four(0.0), fill_four(0.0)
    if k >= SLIDING or len(work.problem.compliance):
        return 0.0
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist = twist_of(groups, g, work.iterates.v, work.problem)
        for row in range(groups.start[g], groups.start[g + 1]):
            rho = field(groups.table, row, STIFFNESS)
            off = rho - stiffness_of(work, row, twist, k, shares, p)
            changed += where_at_most(off * off, SAME * rho * rho, zero, one)
    return sum_of(changed)


@borrower(forceinline=True, fastmath={"contract"})
def put_stiffness(table, row, r):
    """Set R of a row of contacts, and S^-1 = R^-1 + C of the normal and of the tangents, the softer one for both.

    The projection in the norm of S^-1 stretches a cone by S_n / S_t.
    """
    c0, c1, c2 = three(table, row, COMPLIANCE)
    normal, tangent, mu = 1.0 + r * c0, 1.0 + r * where_at_most(c1, c2, c2, c1), field(table, row, MU)
    stretch = mu * tangent / normal
    store_lanes(table, row, LANES * STIFFNESS, r)
    store_lanes(table, row, LANES * NORMAL, r / normal)
    store_lanes(table, row, LANES * TANGENT, r / tangent)
    store_lanes(table, row, LANES * STRETCH, stretch)
    store_lanes(table, row, LANES * SHARE, 1.0 / (1.0 + mu * stretch))


@borrower(forceinline=True, fastmath={"contract"})
def stiffness_of(work, row, twist, k, shares, p):
    """R of a row of contacts by k, their compliance and, of rigid ones where much slides, what they do; 0 in empty places."""
    table, problem, zero = work.groups.table, work.problem, fill_four(0.0)
    d, share = field(table, row, SCALE), fill_four(1.0)
    if len(problem.compliance):
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
    problem, groups, symbolic = work.problem, work.groups, work.factor.symbolic
    diagonal, lower = work.factor.diagonal, work.factor.lower
    m, n, form, (first, last) = len(problem.m), len(problem.n), form_of_problem(problem), nodes_of(symbolic, q)
    rows, turned = np.empty((2, m, n)), np.empty((2, m, n))
    lower[symbolic.column[first] : symbolic.column[last]] = 0.0
    lower[-1] = 0.0
    clear_ghosts(symbolic, q, diagonal)
    for b in range(first, last):
        load_mass(problem, b, diagonal)
    if is_coupled(problem):
        augment_coupled(work, first, last)
        return
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        if form == IN_SPACE:
            add_rigid_stiffness(groups, g, flat_rows(diagonal), flat_rows(lower))
            continue
        for row in range(groups.start[g], groups.start[g + 1]):
            for lane in range(LANES):
                r, c = groups.table[row, LANES * STIFFNESS + lane], groups.contact[row, lane]
                for side in range(2 if c >= 0 else 0):
                    for i in range(m):
                        fill_row(form, problem.geometry, c, side, i, n, rows[side, i])
                        for k in range(n):
                            turned[side, i, k] = r * rows[side, i, k]
                if c >= 0:
                    add_contact(work, g, lane, rows, turned)


@borrower()
def augment_coupled(work, first, last):
    """Blocks of W + R^-1 in the columns first to last, for a problem given by W alone, see coupling.py."""
    problem, factor = work.problem, work.factor
    factor.diagonal[first:last] = 0.0
    for c in range(len(problem.places)):
        b = problem.places[c, 0]
        for i in range(len(problem.n) if first <= b < last else 0):
            factor.diagonal[b, i, i] = 1.0 / work.rho[c]
    add_symmetric_blocks(problem.coupling, problem.places, problem.inverse[:, 0, 0], (first, last), factor)


@borrower()
def add_contact(work, g, lane, rows, turned):
    """Add a contact of group g to the matrix: rows of H and R H (2, m, n)."""
    problem, groups, m, lower = work.problem, work.groups, len(work.problem.m), work.factor.lower
    a, b, block = groups.place[g, lane], groups.place[g, LANES + lane], groups.block[g, lane]
    for side in range(2):
        body = b if side else a
        if body < len(problem.free):
            own = work.factor.diagonal[groups.target[g, LANES * side + lane]]
            add_product(problem, turned[side], rows[side], m, body, body, own)
            if a == b:
                add_product(problem, turned[side], rows[1 - side], m, body, body, own)
    if block < len(lower) - 1:
        low = 0 if a > b else 1
        add_product(problem, turned[low], rows[1 - low], m, max(a, b), min(a, b), lower[block])


@borrower()
def eliminate_subtree(work, q, relaxation, p, new, line):
    """The contacts of subtree q, p to new (L, 12), and L^-1 of the momentum that they leave; returns the squared scaled change of p.

    ``line`` is memory for :func:`longest_line` numbers.
    """
    problem, symbolic = work.problem, work.factor.symbolic
    v, momentum, x = work.iterates.v, work.iterates.momentum, work.iterates.correction
    first, last = nodes_of(symbolic, q)
    if is_coupled(problem):
        momentum[first:last] = 0.0
    else:
        momentum_residual_of(problem, problem.free, v, first, last, momentum)
    clear_ghosts(symbolic, q, momentum)
    add_ghosts(symbolic, q, momentum)
    change = project_impulses(work, q, relaxation, p, new)
    if is_coupled(problem):
        missing_velocity(work, first, last)
    else:
        for b in range(first, last):
            for i in range(len(problem.n)):
                x[b, i] = momentum[b, i]
    clear_ghosts(symbolic, q, x)
    add_ghosts(symbolic, q, x)
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    forward_substitution(work.factor, begin, end, symbolic.target, x, line)
    return change


@borrower(fastmath={"contract"})
def missing_velocity(work, first, last):
    """x = D (M (v_free - v) + G p), see coupling.py, for generalised impulses p: the velocities that the impulses leave to be changed."""
    problem, x, scratch = work.problem, work.iterates.correction, work.iterates.trial
    scratch[first:last] = 0.0
    add_coupled(problem, work.iterates.momentum, first, last, scratch)
    for b in range(first, last):
        for i in range(len(problem.n)):
            x[b, i] = problem.free[b, i] - work.iterates.v[b, i] + problem.inverse[b, i, i] * scratch[b, i]


@borrower()
def divide_by_stiffness(work, first, last):
    """x <- R^-1 x of the bodies first to last, which makes changes of velocities of what (W + R^-1) x is solved for."""
    for c in range(len(work.problem.places)):
        b = work.problem.places[c, 0]
        for i in range(len(work.problem.n) if first <= b < last else 0):
            work.iterates.correction[b, i] /= work.rho[c]


@borrower()
def update_subtree(work, q, relaxation, line):
    """v <- v + relaxation L^-T D^-1 x for the bodies of subtree q, x from :func:`eliminate_subtree`, after all later subtrees."""
    symbolic = work.factor.symbolic
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    backward_substitution(work.factor, begin, end, work.iterates.correction, line)
    first, last = nodes_of(symbolic, q)
    if is_coupled(work.problem):
        divide_by_stiffness(work, first, last)
    v, x = work.iterates.v, work.iterates.correction
    for b in range(first, last):
        for i in range(len(work.problem.n)):
            v[b, i] += relaxation * x[b, i]


@borrower(fastmath={"contract"})
def project_impulses(work, q, relaxation, p, new):
    """p+ = P_K(p - S (w + mu |w_t| n)), S^-1 = R^-1 + C, new = p + relaxation (p+ - p), momentum += H^T (2 p+ - p), for subtree q.

    Returns the squared scaled change of p.
    """
    problem, groups, table, change = work.problem, work.groups, work.groups.table, fill_four(0.0)
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist, wrench = twist_of(groups, g, work.iterates.v, problem), no_wrench()
        for row in range(groups.start[g], groups.start[g + 1]):
            old, mu, tangent = three(p, row, 0), field(table, row, MU), field(table, row, TANGENT)
            wn, w1, w2 = law_velocity(groups, row, twist, old)
            step = field(table, row, NORMAL) * (wn + mu * length_of(w1, w2)), tangent * w1, tangent * w2
            gain = minus(project_to_cone(minus(old, step), mu, field(table, row, STRETCH), field(table, row, SHARE)), old)
            put_three(new, row, 0, plus(old, scaled(relaxation, gain)))
            change += field(table, row, SCALE) * inner(gain, gain)
            wrench = add_to_wrench(groups, row, wrench, plus(old, scaled(2.0, gain)))
        add_wrench(groups, g, wrench, work.iterates.momentum, problem)
    return sum_of(change)


@borrower()
def clear_momentum(work, q):
    """No generalised impulse on the bodies of subtree q, nor in its ghost rows."""
    first, last = nodes_of(work.factor.symbolic, q)
    work.iterates.momentum[first:last] = 0.0
    clear_ghosts(work.factor.symbolic, q, work.iterates.momentum)


@borrower(fastmath={"contract"})
def add_momentum(work, q, p):
    """momentum += H^T p of the contacts of subtree q."""
    groups = work.groups
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        wrench = no_wrench()
        for row in range(groups.start[g], groups.start[g + 1]):
            wrench = add_to_wrench(groups, row, wrench, three(p, row, 0))
        add_wrench(groups, g, wrench, work.iterates.momentum, work.problem)


@borrower(fastmath={"contract"})
def squared_size(work, q, v):
    """Squared norm of (H v + b) / sqrt(d) of the contacts of subtree q for body velocities v (N + 1, n)."""
    groups, total, zero = work.groups, fill_four(0.0), fill_four(0.0)
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist = twist_of(groups, g, v, work.problem)
        for row in range(groups.start[g], groups.start[g + 1]):
            u, d = plus(velocity_at(groups, row, twist), three(groups.table, row, OFFSET)), field(groups.table, row, SCALE)
            total += where_at_most(d, zero, zero, inner(u, u) / d)
    return sum_of(total)


@borrower(forceinline=True, fastmath={"contract"})
def squared_residuals(groups, row, w, p):
    """Squared natural map residuals of the contacts of a row, none of empty places."""
    d = field(groups.table, row, SCALE)
    return where_at_most(d, 0.0, 0.0, squared_residual(p, w, field(groups.table, row, MU), d))


@borrower(fastmath={"contract"})
def squared_map_norm(work, q, p, v):
    """Square of the norm of the natural map residual of the contacts of subtree q, for impulses p (L, 12) and velocities v (N + 1, n)."""
    groups, total = work.groups, fill_four(0.0)
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist = twist_of(groups, g, v, work.problem)
        for row in range(groups.start[g], groups.start[g + 1]):
            old = three(p, row, 0)
            total += squared_residuals(groups, row, law_velocity(groups, row, twist, old), old)
    return sum_of(total)


@borrower(fastmath={"contract"})
def carry_impulses(work, q, relaxation, last, p):
    """carried = 2 p+ - last - R H (v+ - v), the impulses whose velocities an iteration has found, and momentum += H^T carried.

    For the contacts of subtree q; last (L, 12) and p = last + relaxation (p+ - last) are the impulses before and after the iteration.
    """
    groups = work.groups
    for g in range(groups.subtree[q], groups.subtree[q + 1]):
        twist, wrench = twist_of(groups, g, work.iterates.correction, work.problem), no_wrench()
        for row in range(groups.start[g], groups.start[g + 1]):
            old, turn = three(last, row, 0), scaled(field(groups.table, row, STIFFNESS), velocity_at(groups, row, twist))
            carried = minus(plus(old, scaled(2.0 / relaxation, minus(three(p, row, 0), old))), turn)
            put_three(work.iterates.carried, row, 0, carried)
            wrench = add_to_wrench(groups, row, wrench, carried)
        add_wrench(groups, g, wrench, work.iterates.momentum, work.problem)
