# SPDX-License-Identifier: GPL-3.0-or-later
"""Proximal points: springs, soft to stiff, that are at rest in one centre after the other.

The method is described in newton.py; what solves the problem of a centre is newton_kernels.py or, in a plane, pivoting_kernels.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import OPEN, SLIP, STICK, tangent_length
from masonry_cd.mechanics.friction.operators import has_unit_masses
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.solvers.linearised import STIFFEST, contact_velocity, keep_better, law_velocity, map_norm, momentum_residual
from masonry_cd.mechanics.solvers.shares import add_share, begin_sums, copy_share, sum_of

GOLDEN, TIGHT = 0.6180339887498949, 1e-8
WON = 0.9  # of the error, at most, that is left by a problem that is not solved and counts all the same
FREE, HELD = np.bool_(False), np.bool_(True)  # whether a status may change; for plain False and True numba would compile the code twice


class CentredSprings(NamedTuple):
    """The problem with springs that are at rest in the centre, and an iterate of it."""

    centre: np.ndarray  # (C, m) impulses
    x: np.ndarray  # (C, m) trial impulses
    p: np.ndarray  # (C, m) impulses
    status: np.ndarray  # (C,) OPEN, STICK or SLIP
    held: np.ndarray  # (C,) a status to come back to
    dx: np.ndarray  # (C, m) change of the trial impulses
    block: np.ndarray  # (C, m, m) B = -dp/du
    v: np.ndarray  # (B + 1, n) velocities of the centre
    own: np.ndarray  # (B + 1, n) those of its impulses
    free: np.ndarray  # (B + 1, n) v_free less v: velocities are counted from those of the centre, which spares rounding
    offset: np.ndarray  # (C, m) H v + b


class Continuation(NamedTuple):
    """How stiff the springs are from one centre to the next, and when to give up."""

    softest: float  # K to begin with: the reciprocal of the error, within these
    stiffest: float
    growth: float  # of K after a problem that is solved
    leap: float  # power of it where that took little and left more than half of the error
    fall: float  # of K after one that is not
    calm: float  # power of both from the first such problem on
    iterations: int  # for the problem of one centre
    failures: int  # problems in a row that are not solved
    ties: float  # velocities by which ties are broken, as a share of the tolerance, or of TIGHT if it is looser; 0: they are not


@kernel()
def allocate_springs(arena, shape, rows):
    """Memory for :class:`Springs` of contacts (C, m) and velocities of a shape."""
    contacts, m = shape
    status, held = take(arena, shape[:1]).view(np.int64), take(arena, shape[:1]).view(np.int64)
    centre, x, p, dx, block = take(arena, shape), take(arena, shape), take(arena, shape), take(arena, shape), take(arena, (contacts, m, m))
    return CentredSprings(
        centre, x, p, status, held, dx, block, take(arena, rows), take(arena, rows), take(arena, rows), take(arena, shape)
    )


@kernel(inline="always")
def softness(compliance, scale, c, m):
    """Compliance of the springs of contact c along and across the normal: the proximal one and the contact's own."""
    if len(compliance):
        return scale + compliance[c, 0], scale + max(compliance[c, 1], compliance[c, m - 1])
    return scale, scale


@borrower()
def spring_blocks(shares, problem, springs, stiffness):
    """B = -dp/du of the springs (C, m, m), from their trial impulses and statuses."""
    m, x, blocks, status, (first, end) = len(problem.m), springs.x, springs.block, springs.status, shares.contacts
    for c in range(first, end):
        soft_n, soft_t = softness(problem.compliance, problem.d[c] / stiffness, c, m)
        for i in range(m):
            for j in range(m):
                blocks[c, i, j] = 0.0
        if status[c] == OPEN:
            continue
        blocks[c, 0, 0] = 1.0 / soft_n
        length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        share = problem.mu[c] * max(x[c, 0], 0.0) / length if length > 0.0 else 1.0
        for i in range(1, m):
            if status[c] == STICK:
                blocks[c, i, i] = 1.0 / soft_t
            elif length > 0.0:
                blocks[c, i, 0] = problem.mu[c] * x[c, i] / (length * soft_n)
                for j in range(1, m):  # zero in a plane
                    across = (1.0 if i == j else 0.0) - x[c, i] * x[c, j] / (length * length)
                    blocks[c, i, j] = min(share, 1.0) / soft_t * across


@borrower()
def break_ties(offset, size):
    """Add up to ``size`` to each velocity (C, 2), so that no two contacts reach a kink at once, nor one the tip of its cone.

    It is another multiple of the golden section for each of them, without its whole part.
    """
    flat = offset.reshape(offset.size)
    for i in range(len(flat)):
        multiple = GOLDEN * (i + 1)
        flat[i] += size * (multiple - math.floor(multiple))


@borrower()
def spring_residual(shares, problem, springs, stiffness, v, held, out):
    """Fill x and p of the springs at velocities v, and out = M (v_free - v) + G p (B + 1, n); returns the norm of that in M^-1.

    The statuses follow x, or are ``held`` as they are.
    """
    m, compliance, d, x, p, centre = len(problem.m), problem.compliance, problem.d, springs.x, springs.p, springs.centre
    mu, status, (first, end) = problem.mu, springs.status, shares.contacts
    contact_velocity(shares, problem, v, x)
    for c in range(first, end):
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            soft = soft_n if i == 0 else soft_t
            own = compliance[c, i] if len(compliance) else 0.0
            x[c, i] = ((soft - own) * centre[c, i] - (x[c, i] + springs.offset[c, i])) / soft
        length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        if not held:
            status[c] = OPEN if x[c, 0] <= 0.0 else (STICK if length <= mu[c] * x[c, 0] else SLIP)
        share = mu[c] * x[c, 0] / length if status[c] == SLIP and length > 0.0 else 1.0
        for i in range(m):
            p[c, i] = 0.0 if status[c] == OPEN else (x[c, i] if i == 0 else share * x[c, i])
    momentum_residual(shares, problem, springs.free, v, springs.p, out)
    return norm_of_momentum(shares, problem, out)


@borrower()
def norm_of_momentum(shares, problem, momentum):
    """Norm of momenta (B + 1, n) in M^-1."""
    n, turn, (first, end) = len(problem.n), begin_sums(shares), shares.rows
    for b in range(first, end):
        total = 0.0
        for i in range(n):
            if has_unit_masses(problem):
                total += momentum[b, i] * momentum[b, i]
                continue
            for j in range(n):
                total += momentum[b, i] * problem.inverse[b, i, j] * momentum[b, j]
        shares.sums[turn, 0, b] = total
    wait(shares.team)
    return np.sqrt(max(sum_of(shares, 0, len(problem.inverse)), 0.0))


@borrower()
def spring_changes(shares, problem, springs, stiffness, change):
    """Change dx of the trial impulses with a change of the velocities (B + 1, n)."""
    dx, m, (first, end) = springs.dx, len(problem.m), shares.contacts
    contact_velocity(shares, problem, change, dx)
    for c in range(first, end):
        soft_n, soft_t = softness(problem.compliance, problem.d[c] / stiffness, c, m)
        for i in range(m):
            dx[c, i] /= -soft_n if i == 0 else -soft_t


@kernel()
def proximal_points(solve_centre, shares, problem, work, workspace, continuation, answer, settings):
    """Proximal points from ``answer`` on, which gets better; returns the iterations.

    ``solve_centre`` solves the problem of a centre, ``workspace`` are :class:`Springs` and its memory, which has velocities v.
    Centres that the springs leave where they are, without a factorisation, have the same limit as those: near what rounding leaves there
    may be no end of them.
    """
    springs, iterate = workspace
    copy_share(shares.contacts, answer.impulse, springs.centre)
    copy_share(shares.contacts, answer.impulse, springs.p)
    copy_share(shares.rows, answer.velocity, springs.v)
    error = answer.error[0]
    stiffness, growth, fall = (
        min(max(1.0 / max(error, 1e-300), continuation.softest), continuation.stiffest),
        continuation.growth,
        continuation.fall,
    )
    iterations, failed, idle = 0, 0, 0
    while max(iterations, idle) < settings.limit and answer.error[0] > settings.tolerance and failed < continuation.failures:
        goal = answer.size * max(1e-2 * error, 1e-3 * settings.tolerance)  # a hundredth of the error
        most = min(settings.limit - iterations, continuation.iterations)
        add_share(shares.rows, problem.free, -1.0, springs.v, springs.free)
        law_velocity(shares, problem, springs.v, springs.offset)
        iterate.v[shares.rows[0] : shares.rows[1]] = 0.0
        if continuation.ties > 0.0:
            break_ties(springs.offset, continuation.ties * min(settings.tolerance, TIGHT) * answer.speed)
        solved, spent = solve_centre(shares, problem, work, springs, stiffness, goal, most, iterate)
        iterations += spent
        idle += spent == 0
        new = map_norm(shares, problem, springs.p, work.scratch, springs.own) / answer.size
        if not solved and not new < WON * error:
            stiffness, failed = max(stiffness / fall, 1e-3), failed + 1
            growth, fall = continuation.growth**continuation.calm, continuation.fall**continuation.calm
            continue
        leap = growth**continuation.leap if new > 0.5 * error else growth
        if not solved:
            stiffness /= growth
        elif spent <= 8:
            stiffness *= leap if spent < 4 else growth
        stiffness = min(stiffness, STIFFEST)
        error, failed = new, 0
        copy_share(shares.contacts, springs.p, springs.centre)
        add_share(shares.rows, springs.v, 1.0, iterate.v, springs.v)
        keep_better(shares, answer, springs.p, springs.own, error)
    return iterations
