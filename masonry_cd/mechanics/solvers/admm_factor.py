"""The matrix of ADMM, M + H^T R H, and its factorisation by a team of threads; see admm.py for the choice of R."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import tangent_length
from masonry_cd.mechanics.friction.joint_twists import add_up_stiffness, rows_of_twist, twist_of, velocity_at
from masonry_cd.mechanics.friction.operators import has_unit_masses, unknowns_at
from masonry_cd.mechanics.linalg.cholesky import factorise_by_team, factorise_cholesky
from masonry_cd.mechanics.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of, share_of_subtrees
from masonry_cd.mechanics.linalg.small_blocks import copy_flat, is_wide
from masonry_cd.mechanics.linalg.supernodes import has_single_columns
from masonry_cd.mechanics.linalg.threads import wait
from masonry_cd.mechanics.linalg.wide_columns import add_turned_product

SLIDING = 300.0  # k below which much slides


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
    problem, joints, rho = work.problem, work.partition.joints, work.factor.rho
    d, compliance = problem.d, problem.compliance
    for g in range(work.partition.joint[q], work.partition.joint[q + 1]):
        twist = twist_of_joint(work, g)
        for c in range(joints.start[g], joints.start[g + 1]):
            if len(compliance):
                soft = compliance[c].sum() / compliance.shape[1]
                own = d[c] - soft
                rho[c] = 1.0 / (own / k + soft / np.sqrt(1.0 + soft / own))
            else:
                rho[c] = k / d[c] * (share_of_contact(work, twist, c, k, shares, p) if k < SLIDING else 1.0)


@borrower()
def count_changes(work, q, k, shares, p):
    """How many contacts of subtree q would have another R at the same k."""
    problem, joints, rho, changed = work.problem, work.partition.joints, work.factor.rho, 0
    if k >= SLIDING or len(problem.compliance):
        return changed
    for g in range(work.partition.joint[q], work.partition.joint[q + 1]):
        twist = twist_of_joint(work, g)
        for c in range(joints.start[g], joints.start[g + 1]):
            changed += rho[c] != k / problem.d[c] * share_of_contact(work, twist, c, k, shares, p)
    return changed


@kernel(inline="always")
def twist_of_joint(work, g):
    """The relative twist of joint g."""
    a, b = work.partition.place[g, 0], work.partition.place[g, 1]
    return twist_of(work.partition.joints, g, work.iterates.v, a, b, unknowns_at(work.problem, a, b))


@kernel(inline="always")
def share_of_contact(work, twist, c, k, shares, p):
    """The share of k / d_c that rigid contact c has, by what it does: open, sticking or sliding."""
    problem, (un, u1, u2) = work.problem, velocity_at(work.partition.joints, twist, c)
    offset, mu, r, m = problem.offset, problem.mu[c], k / problem.d[c], len(problem.m)
    un, u1, p2 = un + offset[c, 0], u1 + offset[c, 1], 0.0
    if m == 3:
        u2, p2 = u2 + offset[c, 2], p[c, 2]
    normal, tangent = p[c, 0] - r * (un + mu * tangent_length(u1, u2)), tangent_length(p[c, 1] - r * u1, p2 - r * u2)
    if mu * tangent <= -normal:
        return shares[0]
    return 1.0 if tangent <= mu * normal else shares[1]


@kernel(fastmath={"contract"})
def augment(work, q):
    """Blocks of M + H^T R H in the columns of subtree q; what its contacts add to diagonal blocks of later ones goes to ghost rows."""
    symbolic, mass, partition, diagonal, lower = (
        work.factor.symbolic,
        work.problem.mass,
        work.partition,
        work.factor.diagonal,
        work.factor.lower,
    )
    place, target, block, joints = partition.place, partition.target, partition.block, partition.joints
    s, n, bodies, (first, last) = len(joints.s), len(work.problem.n), len(mass), nodes_of(symbolic, q)
    stiffness, rows, turned = np.empty((s, s)), np.empty((2, s, n)), np.empty((2, s, n))
    lower[symbolic.column[first] : symbolic.column[last]] = 0.0
    clear_ghosts(symbolic, q, diagonal)
    for b in range(first, last):
        for p in range(n):
            for r in range(n):
                diagonal[b, n * p + r] = (1.0 if p == r else 0.0) if has_unit_masses(work.problem) else mass[b, p, r]
    for g in range(partition.joint[q], partition.joint[q + 1]):
        add_up_stiffness(joints, g, work.factor.rho, stiffness)
        rows_of_twist(joints, g, rows)
        for side in range(2):
            for i in range(s):
                for p in range(n):
                    total = 0.0
                    for k in range(s):
                        total += stiffness[i, k] * rows[side, k, p]
                    turned[side, i, p] = total
        a, b = target[g, 0], target[g, 1]
        if is_wide(work.problem.n):
            add_wide_joint(work, g, rows, turned)
            continue
        low = 0 if place[g, 0] > place[g, 1] else 1
        for i in range(s):
            for p in range(n):
                x, y = turned[0, i, p], turned[1, i, p]
                for t in range(n):
                    if a != bodies:
                        diagonal[a, n * p + t] += x * rows[0, i, t]
                    if b != bodies:
                        diagonal[b, n * p + t] += y * rows[1, i, t]
                    if a == b != bodies:
                        diagonal[a, n * p + t] += x * rows[1, i, t] + y * rows[0, i, t]
                    if block[g] >= 0:
                        lower[block[g], p, t] += turned[low, i, p] * rows[1 - low, i, t]


@borrower()
def add_wide_joint(work, g, rows, turned):
    """What joint g adds to the matrix where blocks are wide: rows of H and R H (2, s, n)."""
    problem, n = work.problem, len(work.problem.n)
    place, target, block = work.partition.place, work.partition.target, work.partition.block
    s, unit = rows.shape[1], has_unit_masses(work.problem)
    a, b = place[g, 0], place[g, 1]
    diagonal = work.factor.diagonal.reshape((len(work.factor.diagonal), n, n))
    for side in range(2):
        body = place[g, side]
        if body < len(problem.free):
            width = problem.width[body] if unit else n
            add_turned_product(turned[side], rows[side], s, (width, width), diagonal[target[g, side]])
            if a == b:
                add_turned_product(turned[side], rows[1 - side], s, (width, width), diagonal[target[g, side]])
    if block[g] >= 0:
        low = 0 if a > b else 1
        own, other = (problem.width[place[g, low]], problem.width[place[g, 1 - low]]) if unit else (n, n)
        add_turned_product(turned[low], rows[1 - low], s, (own, other), work.factor.lower[block[g]])
