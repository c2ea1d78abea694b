# SPDX-License-Identifier: GPL-3.0-or-later
"""Proximal points: springs, soft to stiff, that are at rest in one centre after the other.

The method is told in newton.py; what solves the problem of a centre is newton_kernels.py or, in a plane, pivoting_kernels.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import OPEN, SLIP, STICK, tangent_length
from masonry_cd.mechanics.friction.operators import OrderedProblem, has_unit_masses, velocity_of_contact
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.solvers.linearised import STIFFEST, keep_better
from masonry_cd.mechanics.solvers.shared_operators import contact_velocity, map_norm, missing_momentum, solve_by_first
from masonry_cd.mechanics.solvers.shares import add_share, begin_sums, copy_share, sum_of

GOLDEN, TIGHT = 0.6180339887498949, 1e-8
WON = 0.9  # of the error, at most, that is left by a problem that is not solved and counts all the same
FREE, HELD = np.bool_(False), np.bool_(True)  # whether a status may change; for plain False and True numba would compile the code twice


class Springs(NamedTuple):
    """The problem with springs that are at rest in the centre, and an iterate of it."""

    centre: np.ndarray  # (C, m) impulses
    x: np.ndarray  # (C, m) trial impulses
    p: np.ndarray  # (C, m) impulses
    status: np.ndarray  # (C,) OPEN, STICK or SLIP
    held: np.ndarray  # (C,) a status to come back to
    dx: np.ndarray  # (C, m) change of the trial impulses
    block: np.ndarray  # (C, m, m) B = -dp/du


class Centre(NamedTuple):
    """The centre, and the problem with velocities as they are counted from it."""

    v: np.ndarray  # velocities of the centre
    own: np.ndarray  # and of its impulses
    free: np.ndarray  # (B + 1, n) room for :func:`movable`
    offset: np.ndarray  # (C, m) likewise


class Course(NamedTuple):
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
def allocate_springs(room, shape):
    """Room for :class:`Springs` of contacts (C, m)."""
    contacts, m = shape
    status, held = take(room, shape[:1]).view(np.int64), take(room, shape[:1]).view(np.int64)
    block = take(room, (contacts, m, m))
    return Springs(take(room, shape), take(room, shape), take(room, shape), status, held, take(room, shape), block)


@kernel()
def allocate_centre(room, shape, rows):
    """:class:`Centre` for contacts (C, m) and velocities of a shape."""
    return Centre(take(room, rows), take(room, rows), take(room, rows), take(room, shape))


@kernel(inline="always")
def softness(compliance, scale, c, m):
    """Compliance of the springs of contact c along and across the normal: the proximal one and the contact's own."""
    if len(compliance):
        return scale + compliance[c, 0], scale + max(compliance[c, 1], compliance[c, m - 1])
    return scale, scale


@kernel(inline="always")
def project_trial(springs, mu, c, held, m):
    """Impulse p of contact c from its trial impulse x, by its status, which follows x or is ``held`` as it is."""
    x, p, status = springs.x, springs.p, springs.status
    length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
    if not held:
        status[c] = OPEN if x[c, 0] <= 0.0 else (STICK if length <= mu[c] * x[c, 0] else SLIP)
    share = mu[c] * x[c, 0] / length if status[c] == SLIP and length > 0.0 else 1.0
    for i in range(m):
        p[c, i] = 0.0 if status[c] == OPEN else (x[c, i] if i == 0 else share * x[c, i])


@kernel(inline="always")
def spring_block(springs, mu, soft_n, soft_t, c, size_m):
    """Fill B = -dp/du of the springs of contact c, from its trial impulse and status."""
    m, x, blocks, status = len(size_m), springs.x, springs.block, springs.status
    for i in range(m):
        for j in range(m):
            blocks[c, i, j] = 0.0
    if status[c] != OPEN:
        blocks[c, 0, 0] = 1.0 / soft_n
        length = tangent_length(x[c, 1], x[c, 2] if m == 3 else 0.0)
        share = mu * max(x[c, 0], 0.0) / length if length > 0.0 else 1.0
        for i in range(1, m):
            if status[c] == STICK:
                blocks[c, i, i] = 1.0 / soft_t
            elif length > 0.0:
                blocks[c, i, 0] = mu * x[c, i] / (length * soft_n)
                for j in range(1, m):  # zero in a plane
                    across = (1.0 if i == j else 0.0) - x[c, i] * x[c, j] / (length * length)
                    blocks[c, i, j] = min(share, 1.0) / soft_t * across


@borrower()
def spring_blocks(shares, problem, springs, stiffness):
    """B = -dp/du of the springs (C, m, m)."""
    first, end = shares.contacts
    for c in range(first, end):
        soft_n, soft_t = softness(problem.compliance, problem.d[c] / stiffness, c, len(problem.m))
        spring_block(springs, problem.mu[c], soft_n, soft_t, c, problem.m)


@borrower()
def stiffness_after_springs(stiffness, growth, leap, solved, spent):
    """The next K after ``spent`` iterations: stiffer after few, and by a ``leap`` after very few; softer after a problem not solved."""
    if not solved:
        return stiffness / growth
    if spent > 8:
        return stiffness
    return stiffness * (leap if spent < 4 else growth)


@borrower()
def break_ties(offset, size):
    """Add up to ``size`` to each velocity (C, 2), so that no two contacts reach a kink at once, nor one the tip of its cone.

    It is another multiple of the golden section for each of them, without its whole part.
    """
    flat = offset.reshape(offset.size)
    for i in range(len(flat)):
        multiple = GOLDEN * (i + 1)
        flat[i] += size * (multiple - math.floor(multiple))


@kernel()
def movable(problem, free, offset):
    """The problem in the change of the velocities from those of a centre, which spares rounding; free (B + 1, n) and offset (C, m) are
    room for what changes with it."""
    return OrderedProblem(
        problem.inverse, problem.mass, free, problem.places, problem.block, problem.jacobian, problem.frame, offset, problem.mu,
        problem.compliance, problem.width, problem.d, problem.coupling, problem.m, problem.n,
    )  # fmt: skip


@borrower()
def begin_at(shares, problem, moved, centre, v):
    """Count velocities from ``centre`` (B + 1, n), and begin there: at v = 0."""
    first, end = shares.rows
    add_share(shares.rows, problem.free, -1.0, centre, moved.free)
    contact_velocity(shares, problem, centre, moved.offset)
    v[first:end] = 0.0


@borrower()
def move_centre(shares, centre, v):
    """centre += v."""
    add_share(shares.rows, centre, 1.0, v, centre)


@borrower()
def spring_residual(shares, problem, springs, stiffness, v, held, out):
    """Fill x and p of the springs at velocities v, and out = M (v_free - v) + G p (B + 1, n); returns the norm of that in M^-1."""
    m, compliance, d, x, centre = len(problem.m), problem.compliance, problem.d, springs.x, springs.centre
    first, end = shares.contacts
    contact_velocity(shares, problem, v, x)
    for c in range(first, end):
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            soft = soft_n if i == 0 else soft_t
            own = compliance[c, i] if len(compliance) else 0.0
            x[c, i] = ((soft - own) * centre[c, i] - x[c, i]) / soft
        project_trial(springs, problem.mu, c, held, m)
    missing_momentum(shares, problem, v, springs.p, out)
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


@kernel()
def spring_direction(shares, work, search):
    """The Newton step, (M + G B H) dv = r with the residual r, which it uses up."""
    solve_by_first(shares, work.factor, search.residual)
    copy_share(shares.rows, search.residual, search.change)


@borrower()
def spring_changes(shares, problem, springs, stiffness, change):
    """Change dx of the trial impulses with a change of the velocities (B + 1, n)."""
    dx, m, (first, end) = springs.dx, len(problem.m), shares.contacts
    wait(shares.team)
    for c in range(first, end):
        soft_n, soft_t = softness(problem.compliance, problem.d[c] / stiffness, c, m)
        u0, u1, u2 = velocity_of_contact(problem, change, c)
        dx[c, 0], dx[c, 1] = -u0 / soft_n, -u1 / soft_t
        if m == 3:
            dx[c, 2] = -u2 / soft_t


@kernel()
def proximal_points(settle, shares, problem, work, inside, course, answer, settings):
    """Proximal points from ``answer`` on, which gets better; returns the iterations.

    ``settle`` solves the problem of a centre, ``inside`` are :class:`Springs`, its room, which has velocities v, and a :class:`Centre`.
    Centres that the springs leave where they are, without a factorisation, have the same limit as those: near what rounding leaves there
    may be no end of them.
    """
    springs, search, centre = inside
    copy_share(shares.contacts, answer.impulse, springs.centre)
    copy_share(shares.contacts, answer.impulse, springs.p)
    copy_share(shares.rows, answer.velocity, centre.v)
    moved, error = movable(problem, centre.free, centre.offset), answer.error[0]
    stiffness, growth, fall = min(max(1.0 / max(error, 1e-300), course.softest), course.stiffest), course.growth, course.fall
    iterations, failed, idle = 0, 0, 0
    while max(iterations, idle) < settings.limit and answer.error[0] > settings.tolerance and failed < course.failures:
        goal = answer.size * max(1e-2 * error, 1e-3 * settings.tolerance)  # a hundredth of the error
        most = min(settings.limit - iterations, course.iterations)
        begin_at(shares, problem, moved, centre.v, search.v)
        if course.ties > 0.0:
            break_ties(centre.offset, course.ties * min(settings.tolerance, TIGHT) * answer.speed)
        solved, spent = settle(shares, moved, work, springs, stiffness, goal, most, search)
        iterations += spent
        idle += spent == 0
        new = map_norm(shares, problem, springs.p, work.room, centre.own) / answer.size
        if not solved and not new < WON * error:
            stiffness, failed = max(stiffness / fall, 1e-3), failed + 1
            growth, fall = course.growth**course.calm, course.fall**course.calm
            continue
        leap = growth**course.leap if new > 0.5 * error else growth
        stiffness = min(stiffness_after_springs(stiffness, growth, leap, solved, spent), STIFFEST)
        error, failed = new, 0
        copy_share(shares.contacts, springs.p, springs.centre)
        move_centre(shares, centre.v, search.v)
        keep_better(shares, answer, springs.p, centre.own, error)
    return iterations
