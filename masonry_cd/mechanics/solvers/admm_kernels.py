# SPDX-License-Identifier: GPL-3.0-or-later
"""ADMM over bodies by a team of threads; see admm.py for the method.

Each thread runs all of this, on its share of the contacts, the bodies or the subtrees, and they wait for one another where one needs what
the others compute. What they decide they all decide alike, from the same numbers.
"""

from __future__ import annotations

import math

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coupling import add_coupled, is_coupled
from masonry_cd.mechanics.friction.operators import Elimination, ProblemArrays, body_velocity_of, put_in_order
from masonry_cd.mechanics.linalg.ghost_rows import add_ghosts, nodes_of, share_of_subtrees
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.supernodes import longest_line
from masonry_cd.mechanics.linalg.threads import SharedArena, ThreadTeam, share_of, wait
from masonry_cd.mechanics.linalg.vectors import LANES
from masonry_cd.mechanics.solvers.admm_subtrees import (
    SLIDING,
    add_momentum,
    carry_impulses,
    clear_momentum,
    count_changes,
    eliminate_subtree,
    factorise_augmented,
    recall_stiffness,
    squared_map_norm,
    squared_size,
    update_subtree,
)
from masonry_cd.mechanics.solvers.admm_workspace import AdmmSettings, KeptFactors, allocate_workspace
from masonry_cd.mechanics.solvers.contact_groups import fill_group

PATIENCE = 20  # iterations without a measurement of the error, half as many where its ratio to the change of p is a guess
SWITCH, WORSE = 40, 20  # iterations at one k after which it is reviewed, and where the error has grown
WON = 0.1  # share of the error that may be left after as many iterations, or k changes
BALANCE, ALL = 0.6, 0.95  # shares of the error that lie in the law: k falls below the one, grows above the other
CHANGED = 0.1  # share of the contacts that do something else, above which the matrix is factorised again
GROWTH, FALL = 5.0, 0.01  # factor by which k grows, and the least by which it falls, at a time
LEG = 200  # iterations after which it is asked whether there is hope
HOPE = 10.0  # times the limit: ADMM goes on while its last leg promises an end within that; legs are uneven
RELAXATION, ROUGH = 1.5, 1e-4  # of the steps where much slides; the natural map error above which they are relaxed
SOFT, STIFF = 1.0, 1e6  # bounds of k
SOFTEST = 1e-3  # k at which a factorisation that fails is not tried at a tenth of it again


@entry()
def admm_bodies(
    team: ThreadTeam,
    given: ProblemArrays,
    elimination: Elimination,
    kept: KeptFactors,
    settings: AdmmSettings,
    p_out: np.ndarray,
    v_out: np.ndarray,
    values: np.ndarray,
) -> tuple[int, float, float, float]:
    """ADMM over ProblemArrays, by a team, whose :class:`SharedArena` has ``values``.

    p_out (C, m) and v_out (N, n) hold the start and then the best answer found. The factors kept are used as they are unless
    ``settings.fresh`` is set. They are in single precision: they yield corrections, which become small, of velocities and impulses in
    double precision. The velocities to start from are those of the impulses; if ``settings.moving`` is set, those of v_out where the
    impulses fit worse than none would.

    Returns iterations, natural map error, k at the end, and the error over the change of p.
    """
    work, order = allocate_workspace(SharedArena(values, np.zeros(1, dtype=np.int64)), given, elimination, kept), elimination.order
    k, fresh, rate, tolerance, limit = settings.k, settings.fresh, settings.rate, settings.tolerance, settings.limit
    patience, symbolic = PATIENCE if rate != 1.0 else PATIENCE // 2, work.factor.symbolic
    line = np.empty(longest_line(symbolic, 0, len(symbolic.first) - 1, len(given.n)), dtype=work.factor.panels.dtype)
    size, error = start_iterates(team, given, order, work, settings, p_out, v_out)
    p, new = work.iterates.even, work.iterates.odd
    smallest = before = error
    iterations, checked, switched, ahead = 0, 0, 0, False
    reviewed, then = 0, error
    while iterations < limit and smallest > tolerance:
        if fresh:
            if not factorise_augmented(team, work, k, settings.shares, p):
                k = 0.1 * k  # a matrix closer to that of the masses, which is definite
                if k < SOFTEST:
                    break
                continue
            fresh = False
        relaxation = RELAXATION if k < SLIDING and error > ROUGH else 1.0
        change = eliminate(team, work, iterations, ahead, relaxation, p, new, line) / size
        iterations += 1
        p, new = new, p
        # the change of p tells when to measure the error itself
        ahead = iterations - checked < 2 or (rate * change > tolerance and iterations - checked < patience)
        ahead = ahead and iterations < limit
        update(team, work, iterations, ahead, relaxation, p, new, line)
        if ahead:
            continue
        error, checked = measure_carried(team, work, relaxation, new, p) / size, iterations
        rate = error / change if change > 0.0 else 1.0
        keep_best(team, work, error, smallest, p)
        smallest = error if error < smallest else smallest
        if iterations - reviewed >= LEG:
            if smallest > tolerance and is_hopeless(then, smallest, tolerance, iterations, reviewed, limit):
                limit = iterations
            reviewed, then = iterations, smallest
        ends = iterations == limit and smallest > tolerance  # the next step begins with a k that suits this one better
        if ends or iterations - switched >= SWITCH or (iterations - switched >= WORSE and error > before):
            if ends or not error < WON * before:
                share = map_norm(team, work, p, work.iterates.v) / size / error
                k, fresh = adapt_stiffness(k, share, ends)
                fresh = fresh or share_of_changes(team, work, k, settings.shares, p) > CHANGED
            switched, before = iterations, error
    write_answer(team, order, work, p_out, v_out)
    return iterations, smallest, k, rate


@kernel()
def start_iterates(team, given, order, work, settings, p_out, v_out):
    """Put the problem in order and start from the impulses p_out and their velocities, or from v_out, see :func:`admm_bodies`.

    Returns |q / sqrt(d)|, by which errors are divided, and the natural map error of the start.
    """
    problem, groups, iterates, sums = work.problem, work.groups, work.iterates, work.sums[2]
    b0, b1 = share_of(team, 0, len(order))
    begin, end = share_of_subtrees(team, work.factor.symbolic)
    put_in_order(given, order, b0, b1, problem)
    copy_flat(problem.free[b0:b1], iterates.v[b0:b1])
    iterates.v[len(order)] = 0.0
    iterates.trial[len(order)] = 0.0
    iterates.correction[len(order)] = 0.0
    wait(team)
    for q in range(begin, end):  # all of a subtree while it is in the cache
        for g in range(groups.subtree[q], groups.subtree[q + 1]):
            fill_group(problem, groups, g)
        read_impulses(work, q, p_out)
        recall_stiffness(work, q)
        sums[q] = squared_size(work, q, iterates.v)
        clear_momentum(work, q)
        add_momentum(work, q, iterates.even)
    velocity_of_momentum(team, work, iterates.v)
    size = np.sqrt(sums.sum())
    size = size if size > 0.0 else 1.0
    wait(team)
    error = map_norm(team, work, iterates.even, iterates.v) / size
    copy_flat(iterates.v[b0:b1], iterates.best_v[b0:b1])
    if settings.moving and error > 1.0:  # the impulses fit worse than none would
        for b in range(b0, b1):
            for i in range(len(problem.n)):
                iterates.v[b, i] = v_out[order[b], i]
        wait(team)
    return size, error


@borrower()
def read_impulses(work, q, p):
    """Copy the impulses p (C, m) of the contacts of subtree q, to begin with."""
    groups, even, best = work.groups, work.iterates.even, work.iterates.best
    for row in range(groups.start[groups.subtree[q]], groups.start[groups.subtree[q + 1]]):
        even[row] = 0.0
        for lane in range(LANES):
            for i in range(p.shape[1] if groups.contact[row, lane] >= 0 else 0):
                even[row, LANES * i + lane] = p[groups.contact[row, lane], i]
        copy_flat(even[row], best[row])


@borrower()
def eliminate(team, work, iterations, ahead, relaxation, p, new, line):
    """The first step of ADMM, p to new, and forward substitution, level by level; returns the norm of the scaled change of p.

    If ``ahead``, the first level is done: :func:`update` did it while the factors were in the cache.
    """
    level, changes = work.factor.symbolic.level, work.sums[iterations % 2]
    for y in range(1 if ahead else 0, len(level) - 1):
        first, last = share_of(team, level[y], level[y + 1])
        for q in range(first, last):
            changes[q] = eliminate_subtree(work, q, relaxation, p, new, line)
        wait(team)
    return np.sqrt(changes.sum())


@borrower()
def update(team, work, iterations, ahead, relaxation, p, new, line):
    """Backward substitution, level by level, and the second step of ADMM: v <- v+.

    If ``ahead``, the first step of the next iteration, p to new, follows in each subtree of the first level while its factors are in the
    cache.
    """
    level, changes = work.factor.symbolic.level, work.sums[iterations % 2]
    for y in range(len(level) - 2, 0, -1):
        first, last = share_of(team, level[y], level[y + 1])
        for q in range(first, last):
            update_subtree(work, q, relaxation, line)
        wait(team)
    first, last = share_of(team, level[0], level[1])
    for q in range(first, last):
        update_subtree(work, q, relaxation, line)
        if ahead:
            changes[q] = eliminate_subtree(work, q, relaxation, p, new, line)
    wait(team)


@borrower()
def measure_carried(team, work, relaxation, last, p):
    """The impulses that belong to the velocities of an iteration from ``last`` to p, (L, 12); returns the norm of their natural map."""
    begin, end = share_of_subtrees(team, work.factor.symbolic)
    for q in range(begin, end):
        clear_momentum(work, q)
        carry_impulses(work, q, relaxation, last, p)
    velocity_of_momentum(team, work, work.iterates.trial)
    return map_norm(team, work, work.iterates.carried, work.iterates.trial)


@borrower()
def velocity_of_momentum(team, work, v):
    """v = v_free + M^-1 (generalised impulses of all subtrees), into v (N + 1, n)."""
    problem, momentum, symbolic = work.problem, work.iterates.momentum, work.factor.symbolic
    begin, end = share_of_subtrees(team, symbolic)
    wait(team)
    for q in range(begin, end):
        first, last = nodes_of(symbolic, q)
        add_ghosts(symbolic, q, momentum)
        if is_coupled(problem):  # within subtrees alone
            v[first:last] = 0.0
            add_coupled(problem, momentum, first, last, v)
            copy_flat(v[first:last], momentum[first:last])
        body_velocity_of(problem, momentum, first, last, v)
    wait(team)


@borrower()
def map_norm(team, work, p, v):
    """Norm of the natural map residual of impulses p (L, 12) and velocities v (N + 1, n)."""
    sums, (begin, end) = work.sums[2], share_of_subtrees(team, work.factor.symbolic)
    for q in range(begin, end):
        sums[q] = squared_map_norm(work, q, p, v)
    wait(team)
    total = np.sqrt(sums.sum())
    wait(team)
    return total


@borrower()
def keep_best(team, work, error, smallest, p):
    """Keep the impulses and velocities just measured if their error is the smallest; go back to the best if it is not finite."""
    iterates = work.iterates
    c0, c1 = share_of(team, 0, len(p))
    b0, b1 = share_of(team, 0, len(work.problem.free))
    if error < smallest:
        copy_flat(iterates.carried[c0:c1], iterates.best[c0:c1])
        copy_flat(iterates.trial[b0:b1], iterates.best_v[b0:b1])
    if not error < np.inf:
        copy_flat(iterates.best[c0:c1], p[c0:c1])
        copy_flat(iterates.best_v[b0:b1], iterates.v[b0:b1])
    wait(team)


@borrower()
def is_hopeless(then, now, tolerance, iterations, since, limit):
    """Return True if an error that falls as it did from ``then`` to ``now`` takes HOPE times the limit to the tolerance."""
    gained, missing = math.log(then / now), math.log(now / tolerance)
    return iterations * gained + (iterations - since) * missing > HOPE * limit * gained


@borrower()
def adapt_stiffness(k, share, ends):
    """The next k, and whether it needs new factors, by the share of the error that lies in the law; see "Choice of k" in admm.py.

    ``ends`` says that the limit of iterations is reached: k does not grow then.
    """
    if share > ALL and not ends:
        return min(GROWTH * k, STIFF), True
    if share < BALANCE:
        return max(k * max(np.sqrt(share / BALANCE), FALL), SOFT), True
    return k, False


@borrower()
def share_of_changes(team, work, k, shares, p):
    """Share of the contacts that do something else at impulses p than when the matrix was factorised, at the same k."""
    sums, (begin, end) = work.sums[2], share_of_subtrees(team, work.factor.symbolic)
    for q in range(begin, end):
        sums[q] = count_changes(work, q, k, shares, p)
    wait(team)
    total = sums.sum() / len(work.problem.places)
    wait(team)
    return total


@borrower()
def write_answer(team, order, work, p_out, v_out):
    """Copy the best impulses and velocities, in the order of the problem, into p_out (C, m) and v_out (N, n)."""
    groups, best = work.groups, work.iterates.best
    first, last = share_of(team, 0, len(best))
    b0, b1 = share_of(team, 0, len(order))
    for row in range(first, last):
        for lane in range(LANES):
            for i in range(p_out.shape[1] if groups.contact[row, lane] >= 0 else 0):
                p_out[groups.contact[row, lane], i] = best[row, LANES * i + lane]
    for b in range(b0, b1):
        for i in range(len(work.problem.n)):
            v_out[order[b], i] = work.iterates.best_v[b, i]
