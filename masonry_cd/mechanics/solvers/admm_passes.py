# SPDX-License-Identifier: GPL-3.0-or-later
"""What an ADMM iteration does in a subtree: forward substitution after a pass over its contacts, and backward substitution; see admm.py."""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.friction.contact_groups import (
    MU,
    NORMAL,
    OFFSET,
    SCALE,
    SHARE,
    STIFFNESS,
    STRETCH,
    TANGENT,
    add_to_wrench,
    add_wrench,
    field,
    law_velocity,
    no_wrench,
    put_three,
    squared_residuals,
    three,
    twist_of,
    velocity_at,
)
from masonry_cd.mechanics.friction.coupling import add_coupled, is_coupled
from masonry_cd.mechanics.friction.natural_map import length_of, project_to_cone
from masonry_cd.mechanics.friction.operators import missing_momentum_of
from masonry_cd.mechanics.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of
from masonry_cd.mechanics.linalg.intrinsics import prefetch
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.triangular import backward_substitution, forward_substitution
from masonry_cd.mechanics.linalg.triples import inner, minus, plus, scaled
from masonry_cd.mechanics.linalg.vectors import fill_four, sum_of, where_at_most


@borrower()
def eliminate_subtree(work, q, coming, relaxation, p, new, line):
    """The contacts of subtree q, p to new (L, 12), and L^-1 of the momentum that they leave; returns the squared scaled change of p.

    ``coming`` is the subtree of the next backward substitution, or -1; ``line`` is room for :func:`longest_line` numbers.
    """
    problem, symbolic, panels = work.problem, work.factor.symbolic, work.factor.panels
    v, momentum, x = work.iterates.v, work.iterates.momentum, work.iterates.correction
    first, last = nodes_of(symbolic, q)
    if is_coupled(problem):
        momentum[first:last] = 0.0
    else:
        missing_momentum_of(problem, v, first, last, momentum)
    clear_ghosts(symbolic, q, momentum)
    add_ghosts(symbolic, q, momentum)
    ahead = panels_of(symbolic, coming, len(problem.n)) if coming >= 0 else (0, 0)
    change = meet_contacts(work, q, relaxation, p, new, ahead)
    if is_coupled(problem):
        missing_velocity(work, first, last)
    else:
        copy_flat(momentum[first:last], x[first:last])
    clear_ghosts(symbolic, q, x)
    add_ghosts(symbolic, q, x)
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    forward_substitution(symbolic, begin, end, symbolic.target, panels, x, line, problem.n)
    return change


@borrower(fastmath={"contract"})
def missing_velocity(work, first, last):
    """x = D (M (v_free - v) + G p), see coupling.py, for generalised impulses p: the velocities that the impulses leave to be changed."""
    problem, x, room = work.problem, work.iterates.correction, work.iterates.trial
    room[first:last] = 0.0
    add_coupled(problem, work.iterates.momentum, first, last, room)
    for b in range(first, last):
        for i in range(len(problem.n)):
            x[b, i] = problem.free[b, i] - work.iterates.v[b, i] + problem.inverse[b, i, i] * room[b, i]


@borrower()
def divide_by_stiffness(work, first, last):
    """x <- R^-1 x of the bodies first to last, which makes changes of velocities of what (W + R^-1) x is solved for."""
    for c in range(len(work.problem.places)):
        b = work.problem.places[c, 0]
        for i in range(len(work.problem.n) if first <= b < last else 0):
            work.iterates.correction[b, i] /= work.factor.rho[c]


@borrower()
def update_subtree(work, q, relaxation, line):
    """v <- v + relaxation L^-T D^-1 x for the bodies of subtree q, x from :func:`eliminate_subtree`, after all later subtrees."""
    symbolic, size_n = work.factor.symbolic, work.problem.n
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    backward_substitution(symbolic, begin, end, work.factor.squares, work.factor.panels, work.iterates.correction, line, size_n)
    first, last = nodes_of(symbolic, q)
    if is_coupled(work.problem):
        divide_by_stiffness(work, first, last)
    size = (last - first) * len(size_n)
    v, x = work.iterates.v[first:last].reshape(size), work.iterates.correction[first:last].reshape(size)
    for i in range(size):
        v[i] += relaxation * x[i]


@borrower()
def panels_of(symbolic, q, n):
    """First entry and end of the panels of subtree q, one of several: they are stored from its last supernode to its first."""
    s = symbolic.subtree[q]
    end = symbolic.panel[s] + (symbolic.first[s + 1] - symbolic.first[s]) * (symbolic.start[s + 1] - symbolic.start[s])
    return n * n * symbolic.panel[symbolic.subtree[q + 1] - 1], n * n * end


@borrower(fastmath={"contract"})
def meet_contacts(work, q, relaxation, p, new, ahead):
    """p+ = P_K(p - S (w + mu |w_t| n)), S^-1 = R^-1 + C, new = p + relaxation (p+ - p), momentum += H^T (2 p+ - p), for subtree q.

    There is more to calculate than to fetch, so the panels between the two entries ``ahead``, which the next backward substitution needs,
    are fetched on the way. Returns the squared scaled change of p.
    """
    problem, groups, panels, table = work.problem, work.groups, work.factor.panels, work.groups.table
    begin, stop = groups.subtree[q], groups.subtree[q + 1]
    line, end = ahead
    change, count = fill_four(0.0), max(stop - begin, 1)
    share = (end - line + count - 1) // count
    for g in range(begin, stop):
        for entry in range(line, min(line + share, end), 16):
            prefetch(panels, entry)
        line += share
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
