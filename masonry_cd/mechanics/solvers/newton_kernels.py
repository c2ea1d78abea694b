"""Proximal points, over bodies and where W alone is given; see interior.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import OPEN, SLIP, STICK, tangent_length
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.solvers.linearised import keep_better
from masonry_cd.mechanics.solvers.shares import add_share, begin_sums, chunk_of, copy_share, least_of_chunks

FREE, HELD = np.bool_(False), np.bool_(True)  # whether a status may change; for plain False and True numba would compile the code twice
FOLDS = 3  # times that the same contact turns at once, after which a problem with springs is given up


class Springs(NamedTuple):
    """The problem with springs that are at rest in the centre, and an iterate of it."""

    centre: np.ndarray  # (C, m) impulses
    x: np.ndarray  # (C, m) trial impulses
    p: np.ndarray  # (C, m) impulses
    status: np.ndarray  # (C,) OPEN, STICK or SLIP
    held: np.ndarray  # (C,) a status to come back to
    dx: np.ndarray  # (C, m) change of the trial impulses
    block: np.ndarray  # (C, m, m) B = -dp/du


class Search(NamedTuple):
    """Where the Newton steps for a problem with springs are."""

    v: np.ndarray  # velocities
    change: np.ndarray  # of them, a Newton step
    trial: np.ndarray  # velocities a share of it ahead
    residual: np.ndarray


class Patience(NamedTuple):
    """When proximal points give up."""

    iterations: int  # for one problem with springs
    failures: int  # problems in a row that could not be solved


class ProximalRoom(NamedTuple):
    """What proximal points work on."""

    springs: Springs
    search: Search
    centre: np.ndarray  # velocities of the centre
    own: np.ndarray  # and of its impulses
    free: np.ndarray  # (B + 1, n) room for :attr:`Kind.movable`
    offset: np.ndarray  # (C, m) likewise


@kernel()
def allocate_springs(room, shape):
    """Room for :class:`Springs` of contacts (C, m)."""
    contacts, m = shape
    status, held = take(room, shape[:1]).view(np.int64), take(room, shape[:1]).view(np.int64)
    block = take(room, (contacts, m, m))
    return Springs(take(room, shape), take(room, shape), take(room, shape), status, held, take(room, shape), block)


@kernel()
def allocate_proximal(room, shape, rows):
    """:class:`ProximalRoom` for contacts (C, m) and velocities of a shape."""
    search = Search(take(room, rows), take(room, rows), take(room, rows), take(room, rows))
    return ProximalRoom(allocate_springs(room, shape), search, take(room, rows), take(room, rows), take(room, rows), take(room, shape))


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


@entry()
def first_change(mu, status, x, dx, begin, stop, size_m):
    """The step along dx at which the first of the contacts begin to stop changes its status, that contact, and its new status."""
    m, first, which, new = len(size_m), np.inf, -1, OPEN
    for c in range(begin, stop):
        if (status[c] == OPEN) == (dx[c, 0] > 0.0):  # closes or opens
            step = max(-x[c, 0] / dx[c, 0], 0.0)
            if step < first:
                first, which, new = step, c, SLIP if status[c] == OPEN else OPEN
        if status[c] == OPEN:
            continue
        a, b, e = -((mu[c] * dx[c, 0]) ** 2), -mu[c] * mu[c] * x[c, 0] * dx[c, 0], -((mu[c] * x[c, 0]) ** 2)
        for i in range(1, m):  # |x_t|^2 - mu^2 x_n^2 = a step^2 + 2 b step + e
            a += dx[c, i] * dx[c, i]
            b += x[c, i] * dx[c, i]
            e += x[c, i] * x[c, i]
        outward, root, step = 1.0 if status[c] == STICK else -1.0, b * b - a * e, np.inf
        if outward * e >= 0.0 and outward * b > 0.0:  # there already
            step = 0.0
        elif root >= 0.0:
            q = -(b + np.sqrt(root)) if b >= 0.0 else -(b - np.sqrt(root))
            if q != 0.0 and e / q > 0.0 and outward * (a * (e / q) + b) > 0.0:
                step = e / q
            if a != 0.0 and q / a > 0.0 and outward * (q + b) > 0.0:
                step = min(step, q / a)
        if step < first:
            first, which, new = step, c, STICK + SLIP - status[c]
    return first, which, new


@borrower()
def shorten_step(kind, shares, moved, springs, stiffness, search, norm):
    """trial = v + step change with the first of the steps 1, 1/2, .. 1/16 that makes enough progress.

    Returns the norm of the residual there, and whether that is enough.
    """
    step, new = 2.0, np.inf
    while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
        step *= 0.5
        add_share(shares.rows, search.v, step, search.change, search.trial)
        new = kind.spring_residual(shares, moved, springs, stiffness, search.trial, FREE, search.residual)
    return new, new < (1.0 - 0.1 * step) * norm


@borrower()
def turn_first(kind, shares, moved, springs, stiffness, search):
    """Go along a change of the velocities as far as the first kink on the way, where a contact changes its status, or half of it.

    Returns the norm of the residual there, that contact or -1, and the step.
    """
    v, change, _, residual = search
    copy_share(shares.contacts, springs.held, springs.status)
    kind.spring_residual(shares, moved, springs, stiffness, v, HELD, residual)
    kind.spring_changes(shares, moved, springs, stiffness, change)
    step, which = turn_at_first(shares, moved, springs)
    add_share(shares.rows, v, min(step, 0.5) if step >= 1.0 else step, change, v)
    return kind.spring_residual(shares, moved, springs, stiffness, v, HELD, residual), which, step


@borrower()
def turn_at_first(shares, moved, springs):
    """Change the status of the first contact along dx that does so in a step of less than one; returns that step, and the contact or -1."""
    turn, (first, end), contacts, new = begin_sums(shares), shares.chunks, len(moved.mu), OPEN
    for k in range(first, end):
        begin, stop = chunk_of(k, contacts)
        step, which, _ = first_change(moved.mu, springs.status, springs.x, springs.dx, begin, stop, moved.m)
        shares.sums[turn, 0, k], shares.sums[turn, 1, k] = step, which
    wait(shares.team)
    step, k = least_of_chunks(shares, contacts)
    if k < 0:
        return step, k
    which = int(shares.sums[turn, 1, k])
    if step < 1.0 and first <= k < end:
        _, _, new = first_change(moved.mu, springs.status, springs.x, springs.dx, which, which + 1, moved.m)
        springs.status[which] = new
    return step, which


@kernel()
def settle_springs(kind, shares, moved, work, springs, stiffness, goal, most, search):
    """Semismooth Newton for the problem with springs: its impulses, and its velocities, from those given.

    Ends at a norm of ``goal`` or after ``most`` factorisations; returns whether it is solved and the number of these.
    """
    norm = kind.spring_residual(shares, moved, springs, stiffness, search.v, FREE, search.residual)
    spent, turned, last = 0, 0, -1
    while norm > goal and spent < most and turned < FOLDS:
        spring_blocks(shares, moved, springs, stiffness)
        spent += 1
        if kind.factorise(shares, moved, work, springs.block) == 0.0:
            break
        kind.spring_direction(shares, moved, work, springs, search)
        copy_share(shares.contacts, springs.status, springs.held)
        new, enough = shorten_step(kind, shares, moved, springs, stiffness, search, norm)
        if enough:
            copy_share(shares.rows, search.trial, search.v)
            norm, last, turned = new, -1, 0
            continue
        norm, which, step = turn_first(kind, shares, moved, springs, stiffness, search)
        if step < 1.0:
            turned, last = turned + 1 if which == last and step < 1e-9 else 0, which
    return norm <= goal, spent


@borrower()
def stiffness_after_springs(stiffness, solved, spent, slow):
    """The next K after ``spent`` iterations: stiffer after few, and more so if that was ``slow`` and took very few; else softer."""
    if not solved:
        return 0.25 * stiffness
    if spent > 8:
        return stiffness
    return stiffness * (16.0 if slow and spent < 4 else 4.0)


@kernel()
def proximal_points(kind, shares, problem, work, inside, patience, answer, settings):
    """Proximal points with the operators of a :class:`Kind`, from ``answer`` on, which gets better; returns the iterations.

    ``inside`` is its :class:`ProximalRoom`. Centres that the springs leave where they are, without a factorisation, have the same limit
    as those: near what rounding leaves there may be no end of them.
    """
    springs, search, centre, own, free, offset = inside
    copy_share(shares.contacts, answer.impulse, springs.centre)
    copy_share(shares.contacts, answer.impulse, springs.p)
    copy_share(shares.rows, answer.velocity, centre)
    moved, error = kind.movable(problem, free, offset), answer.error[0]
    stiffness = min(max(1.0 / max(error, 1e-300), 1e2), 1e6)
    iterations, failed, idle = 0, 0, 0
    while max(iterations, idle) < settings.limit and answer.error[0] > settings.tolerance and failed < patience.failures:
        goal = answer.size * max(1e-2 * error, 1e-3 * settings.tolerance)  # a hundredth of the error
        most = min(settings.limit - iterations, patience.iterations)
        kind.begin_at(shares, problem, moved, centre, search.v)
        solved, spent = settle_springs(kind, shares, moved, work, springs, stiffness, goal, most, search)
        iterations += spent
        idle += spent == 0
        new = kind.map_norm(shares, problem, springs.p, work.room, own) / answer.size
        if not solved and not new < error:
            stiffness, failed = max(0.125 * stiffness, 1.0), failed + 1
            continue
        stiffness = min(stiffness_after_springs(stiffness, solved, spent, new > 0.5 * error), kind.stiffest(new))
        error, failed = new, 0
        copy_share(shares.contacts, springs.p, springs.centre)
        kind.move_centre(shares, centre, search.v)
        keep_better(shares, answer, springs.p, own, error)
    return iterations
