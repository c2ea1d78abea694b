# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of a friction problem over bodies by a team of threads: each does its own contacts or bodies, see shares.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.body_sides import add_impulse
from masonry_cd.mechanics.friction.operators import (
    body_velocity_of,
    missing_momentum_of,
    relative_velocity_of,
    squared_map_norm_of,
    velocity_of_contact,
)
from masonry_cd.mechanics.linalg.ldu import factorise_ldu_by_team
from masonry_cd.mechanics.linalg.threads import wait
from masonry_cd.mechanics.linalg.triangular import solve_ldu
from masonry_cd.mechanics.solvers.augmented import augment_blocks, turn_blocks
from masonry_cd.mechanics.solvers.shares import begin_sums, chunk_of, sum_of_chunks


@borrower()
def contact_velocity(shares, problem, v, u):
    """u = H v + b (C, m) for body velocities v (B + 1, n)."""
    first, end = shares.contacts
    wait(shares.team)
    relative_velocity_of(problem, v, first, end, u)


@borrower()
def contact_change(shares, problem, change, u):
    """u = H dv (C, m) for a change of the body velocities (B + 1, n), when all threads have theirs."""
    first, end = shares.contacts
    for c in range(first, end):
        u0, u1, u2 = velocity_of_contact(problem, change, c)
        u[c, 0], u[c, 1] = u0, u1
        if len(problem.m) == 3:
            u[c, 2] = u2


@borrower()
def missing_momentum(shares, problem, v, p, out):
    """out = M (v_free - v) + H^T p (B + 1, n); its last row, of the supports, is left as it is."""
    first, end = shares.rows
    wait(shares.team)
    missing_momentum_of(problem, v, first, end, out)
    add_impulse(problem, p, first, end, out)


@borrower()
def body_velocity(shares, problem, p, room, v):
    """v = v_free + M^-1 H^T p (B + 1, n) of impulses p (C, m), but for the last row; ``room`` (B + 1, n) gets H^T p."""
    first, end = shares.rows
    wait(shares.team)
    room[first:end] = 0.0
    add_impulse(problem, p, first, end, room)
    body_velocity_of(problem, room, first, end, v)


@borrower()
def map_norm(shares, problem, p, room, v):
    """Norm of the natural map of impulses p (C, m); v (B + 1, n) <- their velocities."""
    body_velocity(shares, problem, p, room, v)
    turn, (first, end) = begin_sums(shares), shares.chunks
    wait(shares.team)
    for k in range(first, end):
        begin, stop = chunk_of(k, len(p))
        shares.sums[turn, 0, k] = squared_map_norm_of(problem, p, v, begin, stop)
    wait(shares.team)
    return np.sqrt(sum_of_chunks(shares, 0, len(p)))


@kernel()
def factorise(shares, problem, work, blocks):
    """Factorise M + H^T B H, B the first rows of ``blocks`` (C, m or more, m); the sign of its determinant, 0 if that fails."""
    turn_blocks(problem, blocks, shares.contacts[0], shares.contacts[1], work.world)
    wait(shares.team)
    augment_blocks(problem, blocks, work.world, work.factor.symbolic, shares.rows, work.matrix)
    wait(shares.team)
    return factorise_ldu_by_team(shares.team, work.matrix, work.factor, work.signs)


@kernel()
def solve_by_first(shares, factor, x):
    """x <- (L D U)^-1 x (B + 1, n), by the first thread: the substitutions are too short to be shared."""
    wait(shares.team)
    if shares.team.rank == 0:
        solve_ldu(factor, x)
    wait(shares.team)
