# SPDX-License-Identifier: GPL-3.0-or-later
"""Newton's method for the problem of a centre; see newton.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import OPEN, SLIP, STICK
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.solvers.linearised import factorise, solve_by_first
from masonry_cd.mechanics.solvers.proximal_kernels import (
    FREE,
    HELD,
    Continuation,
    allocate_springs,
    proximal_points,
    spring_blocks,
    spring_changes,
    spring_residual,
)
from masonry_cd.mechanics.solvers.shares import add_share, begin_sums, chunk_of, copy_share, least_of_chunks

REPEATS = 3  # times that the same contact turns at once, after which a problem with springs is given up
NEWTON = Continuation(softest=1e2, stiffest=1e6, growth=4.0, leap=2.0, fall=8.0, calm=1.0, iterations=25, failures=8, ties=0.0)


class NewtonIterate(NamedTuple):
    """Where the Newton steps for a problem with springs are."""

    v: np.ndarray  # velocities
    change: np.ndarray  # of them, a Newton step
    trial: np.ndarray  # velocities a share of it ahead
    residual: np.ndarray


@kernel()
def allocate_newton(arena, shape, rows):
    """Allocate the workspace of proximal points by Newton, for contacts (C, m) and velocities of a shape."""
    iterate = NewtonIterate(take(arena, rows), take(arena, rows), take(arena, rows), take(arena, rows))
    return allocate_springs(arena, shape, rows), iterate


@entry()
def first_status_change(mu, status, x, dx, begin, stop, size_m):
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
def shorten_step(shares, problem, springs, stiffness, iterate, norm):
    """trial = v + step change with the first of the steps 1, 1/2, .. 1/16 that makes enough progress.

    Returns the norm of the residual there, and whether that is enough.
    """
    step, new = 2.0, np.inf
    while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
        step *= 0.5
        add_share(shares.rows, iterate.v, step, iterate.change, iterate.trial)
        new = spring_residual(shares, problem, springs, stiffness, iterate.trial, FREE, iterate.residual)
    return new, new < (1.0 - 0.1 * step) * norm


@borrower()
def go_to_first_kink(shares, problem, springs, stiffness, iterate):
    """Go along a change of the velocities as far as the first kink on the way, where a contact changes its status, or half of it.

    Returns the norm of the residual there, that contact or -1, and the step.
    """
    v, change, _, residual = iterate
    copy_share(shares.contacts, springs.held, springs.status)
    spring_residual(shares, problem, springs, stiffness, v, HELD, residual)
    spring_changes(shares, problem, springs, stiffness, change)
    step, which = change_first_status(shares, problem, springs)
    add_share(shares.rows, v, min(step, 0.5) if step >= 1.0 else step, change, v)
    return spring_residual(shares, problem, springs, stiffness, v, HELD, residual), which, step


@borrower()
def change_first_status(shares, problem, springs):
    """Change the status of the first contact along dx that does so in a step of less than one; returns that step, and the contact or -1."""
    turn, (first, end), contacts, new = begin_sums(shares), shares.chunks, len(problem.mu), OPEN
    for k in range(first, end):
        begin, stop = chunk_of(k, contacts)
        step, which, _ = first_status_change(problem.mu, springs.status, springs.x, springs.dx, begin, stop, problem.m)
        shares.sums[turn, 0, k], shares.sums[turn, 1, k] = step, which
    wait(shares.team)
    step, k = least_of_chunks(shares, contacts)
    if k < 0:
        return step, k
    which = int(shares.sums[turn, 1, k])
    if step < 1.0 and first <= k < end:
        _, _, new = first_status_change(problem.mu, springs.status, springs.x, springs.dx, which, which + 1, problem.m)
        springs.status[which] = new
    return step, which


@kernel()
def semismooth_newton(shares, problem, work, springs, stiffness, goal, most, iterate):
    """Semismooth Newton for the problem with springs: its impulses, and its velocities, from those given.

    Ends at a norm of ``goal`` or after ``most`` factorisations; returns whether it is solved and the number of these.
    """
    norm = spring_residual(shares, problem, springs, stiffness, iterate.v, FREE, iterate.residual)
    spent, turned, last = 0, 0, -1
    while norm > goal and spent < most and turned < REPEATS:
        spring_blocks(shares, problem, springs, stiffness)
        spent += 1
        if factorise(shares, problem, work, springs.block) == 0.0:
            break
        solve_by_first(shares, work.factor, iterate.residual)
        copy_share(shares.rows, iterate.residual, iterate.change)
        copy_share(shares.contacts, springs.status, springs.held)
        new, enough = shorten_step(shares, problem, springs, stiffness, iterate, norm)
        if enough:
            copy_share(shares.rows, iterate.trial, iterate.v)
            norm, last, turned = new, -1, 0
            continue
        norm, which, step = go_to_first_kink(shares, problem, springs, stiffness, iterate)
        if step < 1.0:
            turned, last = turned + 1 if which == last and step < 1e-9 else 0, which
    return norm <= goal, spent


@kernel()
def newton_points(shares, problem, work, workspace, answer, settings):
    """Proximal points by Newton from ``answer`` on, which gets better; returns the iterations."""
    return proximal_points(semismooth_newton, shares, problem, work, workspace, NEWTON, answer, settings)
