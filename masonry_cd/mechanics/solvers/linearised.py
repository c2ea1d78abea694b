# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts common to the methods that linearise the law: settings, the best answer so far, the matrix that they factorise, and operators.

Newton, the interior point method and proximal points are written once, for problems over bodies and for those given by W alone: what these
differ in are the operators of friction/operators.py, and the assembly of the matrix in augmented.py. A team of threads shares them: each
does its own contacts or bodies, see shares.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.operators import (
    add_impulse,
    body_velocity_of,
    momentum_residual_of,
    squared_map_norm_of,
    velocity_of_contact,
)
from masonry_cd.mechanics.linalg.factor import BlockFactor, factorise_ldu
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.linalg.triangular import solve_ldu
from masonry_cd.mechanics.solvers.augmented import NUMBERS, augment_blocks, rotate_blocks
from masonry_cd.mechanics.solvers.shares import add_share, begin_sums, chunk_of, copy_share, sum_of_chunks

STIFFEST = 1e12  # K of interior and proximal points; stiff springs next to rigid contacts settle where K exceeds d / C


class MethodSettings(NamedTuple):
    """Settings of a method."""

    distance: float  # of the start from the walls of the cones, relative to the largest speed; proximal points have none
    tolerance: float  # natural map error at which to stop
    limit: int  # iterations, one factorisation each


class BestSolution(NamedTuple):
    """The best answer so far; its arrays are overwritten by a better one."""

    impulse: np.ndarray  # (C, m)
    velocity: np.ndarray  # (B + 1, n)
    error: np.ndarray  # (1,) natural map error; of each thread its own
    size: float  # |q / sqrt(d)|, by which errors are divided
    speed: float  # largest component of q


class Work(NamedTuple):
    """Memory for the matrix of a problem whose law is linearised and its factors, and for two more arrays."""

    factor: BlockFactor
    world: np.ndarray  # (C, NUMBERS) the blocks of contacts between rigid blocks in space, see augmented.py, or (0, NUMBERS)
    scratch: np.ndarray  # (B + 1, n), as velocities


@kernel()
def allocate_work(arena, symbolic, size, velocity, world):
    """:class:`Work` for blocks of a size, see small_blocks.py, velocities of a shape, and as many contacts as ``world`` has."""
    n, nodes, pairs = len(size), len(symbolic.column) - 1, len(symbolic.row)
    diagonal, lower, upper = take(arena, (nodes, n, n)), take(arena, (pairs, n, n)), take(arena, (pairs, n, n))
    squares, panel, signs = take(arena, (n * n * symbolic.square[-1],)), n * n * symbolic.panel[-1], len(symbolic.subtree) - 1
    factor = BlockFactor(
        symbolic, False, diagonal, lower, upper, squares, take(arena, (panel,)), take(arena, (panel,)), take(arena, (signs,)), size
    )  # fmt: skip
    return Work(factor, take(arena, (world, NUMBERS)), take(arena, velocity))


@borrower()
def largest(x):
    """Largest size of an entry of x (C, m)."""
    most = 0.0
    for c in range(len(x)):
        for i in range(x.shape[1]):
            most = max(most, abs(x[c, i]))
    return most


@borrower()
def keep_better(shares, answer, p, v, error):
    """Take impulses p and velocities v as the answer if their error is less than that of the best so far."""
    if error < answer.error[0]:
        answer.error[0] = error
        copy_share(shares.contacts, p, answer.impulse)
        copy_share(shares.rows, v, answer.velocity)


@borrower()
def contact_velocity(shares, problem, v, u):
    """u = H v (C, m) for body velocities, or a change of them, v (B + 1, n)."""
    first, end = shares.contacts
    wait(shares.team)
    for c in range(first, end):
        u0, u1, u2 = velocity_of_contact(problem, v, c)
        u[c, 0], u[c, 1] = u0, u1
        if len(problem.m) == 3:
            u[c, 2] = u2


@borrower()
def law_velocity(shares, problem, v, u):
    """u = H v + b (C, m)."""
    contact_velocity(shares, problem, v, u)
    add_share(shares.contacts, u, 1.0, problem.offset, u)


@borrower()
def momentum_residual(shares, problem, free, v, p, out):
    """out = M (v_free - v) + H^T p (B + 1, n), v_free = ``free``; its last row, of the supports, is left as it is."""
    first, end = shares.rows
    wait(shares.team)
    momentum_residual_of(problem, free, v, first, end, out)
    add_impulse(problem, p, first, end, out)


@borrower()
def body_velocity(shares, problem, p, scratch, v):
    """v = v_free + M^-1 H^T p (B + 1, n) of impulses p (C, m), but for the last row; ``scratch`` (B + 1, n) gets H^T p."""
    first, end = shares.rows
    wait(shares.team)
    scratch[first:end] = 0.0
    add_impulse(problem, p, first, end, scratch)
    body_velocity_of(problem, scratch, first, end, v)


@borrower()
def map_norm(shares, problem, p, scratch, v):
    """Norm of the natural map of impulses p (C, m); v (B + 1, n) <- their velocities."""
    body_velocity(shares, problem, p, scratch, v)
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
    rotate_blocks(problem, blocks, shares.contacts[0], shares.contacts[1], work.world)
    wait(shares.team)
    augment_blocks(problem, blocks, work.world, shares.rows, work.factor)
    wait(shares.team)
    return factorise_ldu(shares.team, work.factor)


@kernel()
def solve_by_first(shares, factor, x):
    """x <- (L D U)^-1 x (B + 1, n), by the first thread: the substitutions are too short to be shared."""
    wait(shares.team)
    if shares.team.rank == 0:
        solve_ldu(factor, x)
    wait(shares.team)
