# SPDX-License-Identifier: GPL-3.0-or-later
"""Pivoting along a piecewise linear path for the problem of a centre, in a plane; see pivoting.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.contact_geometry import add_impulse_of_side
from masonry_cd.mechanics.friction.coulomb_law import OPEN, SLIP, STICK, has_friction
from masonry_cd.mechanics.friction.operators import form_of_problem, velocity_of_contact
from masonry_cd.mechanics.linalg.triangular import solve_ldu
from masonry_cd.mechanics.solvers.linearised import factorise
from masonry_cd.mechanics.solvers.proximal_kernels import (
    FREE,
    HELD,
    Continuation,
    allocate_springs,
    proximal_points,
    softness,
    spring_blocks,
    spring_residual,
)

UPDATES = 100  # pivots on one factorisation: more, and they cost more than the next one
PIVOTING = Continuation(softest=1e3, stiffest=1e3, growth=10.0, leap=1.0, fall=10.0, calm=0.5, iterations=10**9, failures=16, ties=1e-3)


class PivotPath(NamedTuple):
    """Where the path is, and the pivots since the last factorisation.

    Pivot k changes the matrix by H_c^T a b^T H_c for its contact c; with the matrix before, z_k solves for H_c^T a.
    """

    v: np.ndarray  # (B + 1, n) velocities
    residual: np.ndarray  # (B + 1, n) M (v_free - v) + H^T p
    rate: np.ndarray  # (B + 1, n) of v, along the path
    z: np.ndarray  # (UPDATES, B + 1, n)
    contact: np.ndarray  # (UPDATES,) c
    a: np.ndarray  # (2,) of the last pivot
    b: np.ndarray  # (UPDATES, 2)
    ratio: np.ndarray  # (UPDATES,) of the determinants, after and before
    product: np.ndarray  # (UPDATES, UPDATES) b_f^T H z_e of each pivot e with those after it, f > e
    share: np.ndarray  # (UPDATES,) of the z before it in that of the last pivot
    hard: np.ndarray  # (C, 2) stiffness of the springs along and across the normal


@kernel()
def allocate_pivoting(arena, shape, rows):
    """Allocate the workspace of proximal points by pivoting, for contacts (C, 2) and velocities of a shape."""
    contacts = shape[0]
    z, contact, b, ratio = np.zeros((UPDATES, *rows)), np.zeros(UPDATES, dtype=np.int64), np.empty((UPDATES, 2)), np.empty(UPDATES)
    product, share, hard = np.empty((UPDATES, UPDATES)), np.empty(UPDATES), np.empty((contacts, 2))
    path = PivotPath(np.zeros(rows), np.empty(rows), np.empty(rows), z, contact, np.empty(2), b, ratio, product, share, hard)
    return allocate_springs(arena, shape, rows), path


@borrower()
def add_flat(x, step, change):
    """x += step change, both contiguous and of one shape."""
    x, change = x.reshape(x.size), change.reshape(change.size)
    for i in range(len(x)):
        x[i] += step * change[i]


@borrower()
def change_block(problem, springs, path, k, c, step, beyond):
    """Let contact c, a ``step`` ahead, change its status: as pivot k the change a b^T of its B = -dp/du.

    It changes between open and slip, or between stick and slip.
    """
    mu, sign = problem.mu[c], 1.0 if beyond == SLIP else -1.0
    side = 1.0 if springs.x[c, 1] + step * springs.dx[c, 1] > 0.0 else -1.0
    if springs.status[c] == OPEN or beyond == OPEN:
        a_n, a_t, b_n, b_t = sign, sign * side * mu, path.hard[c, 0], 0.0
    else:
        a_n, a_t, b_n, b_t = 0.0, sign, side * mu * path.hard[c, 0], -path.hard[c, 1]
    path.contact[k] = c
    path.a[0], path.a[1], path.b[k, 0], path.b[k, 1] = a_n, a_t, b_n, b_t
    springs.status[c] = beyond


@borrower()
def weigh(problem, path, k, v):
    """b^T H_c v of pivot k."""
    u_n, u_t, _ = velocity_of_contact(problem, v, path.contact[k])
    return path.b[k, 0] * u_n + path.b[k, 1] * u_t


@borrower()
def apply_earlier(problem, path, k):
    """Take z of pivot k from a solution with the old factors to one with the matrix before this pivot.

    One pivot e after the other would subtract b_e^T H z / ratio_e times z_e, each from what the last one left. These shares follow from the
    products of the b with the z alone, and all z_e are subtracted at once.
    """
    z, share = path.z, path.share
    for e in range(k):
        path.product[e, k] = weigh(problem, path, k, z[e])
        share[e] = weigh(problem, path, e, z[k])
    for e in range(k):
        share[e] /= path.ratio[e]
        own_share, product = share[e], path.product[e]
        for f in range(e + 1, k):
            share[f] -= own_share * product[f]
    own, fours = z[k].reshape(z[k].size), k - k % 4
    for e in range(0, fours, 4):
        z0, z1, z2, z3 = z[e].reshape(own.size), z[e + 1].reshape(own.size), z[e + 2].reshape(own.size), z[e + 3].reshape(own.size)
        s0, s1, s2, s3 = share[e], share[e + 1], share[e + 2], share[e + 3]
        for i in range(len(own)):
            own[i] -= s0 * z0[i] + s1 * z1[i] + s2 * z2[i] + s3 * z3[i]
    for e in range(fours, k):
        add_flat(z[k], -share[e], z[e])


@kernel()
def pivot(problem, work, path, k):
    """Change the matrix by pivot k; returns the ratio of its determinants, after and before.

    The rate of v follows, by the formula of Sherman and Morrison.
    """
    z, c, form = path.z[k], path.contact[k], form_of_problem(problem)
    z[:] = 0.0
    for side in range(2):
        add_impulse_of_side(form, problem.geometry, c, side, problem.places[c, side], len(problem.n), (path.a[0], path.a[1], 0.0), z)
    solve_ldu(work.factor, z)
    z[-1] = 0.0
    apply_earlier(problem, path, k)
    path.ratio[k] = 1.0 + weigh(problem, path, k, z)
    if path.ratio[k] != 0.0:
        add_flat(path.rate, -weigh(problem, path, k, path.rate) / path.ratio[k], z)
    return path.ratio[k]


@borrower(fastmath={"contract"})
def next_kink(problem, springs, path, taken):
    """Go on by ``taken`` along the changes of the trial impulses, and renew these by the rate of v.

    Returns the step to the first kink, the contact that changes its status there, and its new status.
    """
    x, dx, status = springs.x, springs.dx, springs.status
    first, which, new = np.inf, -1, OPEN
    for c in range(len(status)):
        x_n, x_t = x[c, 0] + taken * dx[c, 0], x[c, 1] + taken * dx[c, 1]
        u_n, u_t, _ = velocity_of_contact(problem, path.rate, c)
        d_n, d_t = -path.hard[c, 0] * u_n, -path.hard[c, 1] * u_t
        x[c, 0], x[c, 1], dx[c, 0], dx[c, 1] = x_n, x_t, d_n, d_t
        if status[c] == OPEN:
            if d_n > 0.0 and -x_n < first * d_n:
                first, which, new = max(-x_n, 0.0) / d_n, c, SLIP
            continue
        if d_n < 0.0 and x_n < -first * d_n:
            first, which, new = max(-x_n / d_n, 0.0), c, OPEN
        if status[c] == SLIP:  # until |x_t| falls to mu x_n; never without friction, or rounding would have it stick and slip by turns
            side = 1.0 if x_t > 0.0 else -1.0
            beyond, fall = side * x_t - problem.mu[c] * x_n, problem.mu[c] * d_n - side * d_t
            if has_friction(problem.mu[c]) and fall > 0.0 and beyond < first * fall:
                first, which, new = max(beyond, 0.0) / fall, c, STICK
            continue
        for side in (-1.0, 1.0):  # until it rises to that
            below, rise = problem.mu[c] * x_n - side * x_t, side * d_t - problem.mu[c] * d_n
            if rise > 0.0 and below < first * rise:
                first, which, new = max(below, 0.0) / rise, c, SLIP
    return first, which, new


@kernel()
def start_piece(shares, problem, work, springs, stiffness, path, left, held):
    """Factorise where the path is, and find its rate there; False if the matrix is singular."""
    spring_residual(shares, problem, springs, stiffness, path.v, held, path.residual)
    spring_blocks(shares, problem, springs, stiffness)
    if factorise(shares, problem, work, springs.block) == 0.0:
        return False
    path.rate[:] = 0.0
    add_flat(path.rate, 1.0 / left, path.residual)
    solve_ldu(work.factor, path.rate)
    path.rate[-1] = 0.0
    return True


@kernel()
def follow_path(shares, problem, work, springs, stiffness, goal, most, path):
    """Follow the path from v until the residual vanishes; there is one thread.

    Returns whether it does, and the number of factorisations: not where the path folds back, ends in a ray, or takes more than ``most``.
    """
    for c in range(len(springs.x)):
        soft_n, soft_t = softness(problem.compliance, problem.d[c] / stiffness, c, 2)
        path.hard[c, 0], path.hard[c, 1] = 1.0 / soft_n, 1.0 / soft_t
    left = 1.0  # share of the residual at the start
    held: np.bool = FREE  # whether statuses are known, or follow the trial impulses
    for spent in range(1, most + 1):
        if not start_piece(shares, problem, work, springs, stiffness, path, left, held):
            return False, spent
        held, taken = HELD, 0.0
        for k in range(UPDATES):
            step, c, beyond = next_kink(problem, springs, path, taken)
            if step >= left:
                add_flat(path.v, left, path.rate)
                spring_residual(shares, problem, springs, stiffness, path.v, HELD, path.residual)
                return True, spent
            taken, left = step, left - step
            add_flat(path.v, step, path.rate)
            change_block(problem, springs, path, k, c, step, beyond)
            if not pivot(problem, work, path, k) > 0.0:
                return False, spent
    return False, most


@kernel()
def pivoting_points(shares, problem, work, workspace, answer, settings):
    """Proximal points by pivoting from ``answer`` on, which gets better; returns the iterations."""
    return proximal_points(follow_path, shares, problem, work, workspace, PIVOTING, answer, settings)
