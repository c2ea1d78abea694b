"""What an ADMM iteration does in a subtree: forward substitution after a pass over its contacts, and backward substitution; see admm.py."""

from __future__ import annotations

from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.friction.natural_map import project_stretched, project_to_cone
from masonry_cd.friction.operators import add_generalised_impulse_of, missing_momentum_of
from masonry_cd.jit import borrower
from masonry_cd.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of
from masonry_cd.linalg.intrinsics import prefetch
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.triangular import backward_substitution, forward_substitution


@borrower()
def eliminate_subtree(work, q, coming, relaxation, p, new, line):
    """The contacts of subtree q, p to new (C, m), and L^-1 of the momentum that they leave; returns the squared scaled change of p.

    ``coming`` is the subtree of the next backward substitution, or -1; ``line`` is room for :func:`longest_line` numbers.
    """
    problem, symbolic, panels = work.problem, work.factor.symbolic, work.factor.panels
    v, momentum, x = work.iterates.v, work.iterates.momentum, work.iterates.correction
    first, last = nodes_of(symbolic, q)
    missing_momentum_of(problem.mass, problem.free, v, first, last, momentum, problem.n)
    clear_ghosts(symbolic, q, momentum)
    add_ghosts(symbolic, q, momentum)
    ahead = panels_of(symbolic, coming, len(problem.n)) if coming >= 0 else (0, 0)
    change = meet_contacts(work, q, relaxation, p, new, ahead)
    copy_flat(momentum[first:last], x[first:last])
    clear_ghosts(symbolic, q, x)
    add_ghosts(symbolic, q, x)
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    forward_substitution(symbolic, begin, end, symbolic.target, panels, x, line, problem.n)
    return change


@borrower()
def update_subtree(work, q, relaxation, line):
    """v <- v + relaxation L^-T D^-1 x for the bodies of subtree q, x from :func:`eliminate_subtree`, after all later subtrees."""
    symbolic, size_n = work.factor.symbolic, work.problem.n
    begin, end = symbolic.subtree[q], symbolic.subtree[q + 1]
    backward_substitution(symbolic, begin, end, work.factor.squares, work.factor.panels, work.iterates.correction, line, size_n)
    first, last = nodes_of(symbolic, q)
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
    problem, partition, rho, panels = work.problem, work.partition, work.factor.rho, work.factor.panels
    v, momentum = work.iterates.v, work.iterates.momentum
    jacobian, offset, mu, compliance, d = problem.jacobian, problem.offset, problem.mu, problem.compliance, problem.d
    m, n, index, target = len(problem.m), len(problem.n), problem.places, partition.target
    line, end = ahead
    change, contacts = 0.0, max(partition.start[q + 1] - partition.start[q], 1)
    share = (end - line + contacts - 1) // contacts
    for c in range(partition.start[q], partition.start[q + 1]):
        for entry in range(line, min(line + share, end), 16):
            prefetch(panels, entry)
        line += share
        a, b, r = index[c, 0], index[c, 1], rho[c]
        un, u1, u2 = offset[c, 0], offset[c, 1], 0.0
        pn, p1, p2 = p[c, 0], p[c, 1], 0.0
        if m == 3:
            u2, p2 = offset[c, 2], p[c, 2]
        for k in range(n):
            x, y = v[a, k], v[b, k]
            un += jacobian[c, 0, 0, k] * x + jacobian[c, 1, 0, k] * y
            u1 += jacobian[c, 0, 1, k] * x + jacobian[c, 1, 1, k] * y
            if m == 3:
                u2 += jacobian[c, 0, 2, k] * x + jacobian[c, 1, 2, k] * y
        if len(compliance):
            un += compliance[c, 0] * pn
            u1 += compliance[c, 1] * p1
            u2 += compliance[c, m - 1] * p2
            s, r = r / (1.0 + r * max(compliance[c, 1], compliance[c, m - 1])), r / (1.0 + r * compliance[c, 0])
            xn, x1, x2 = project_stretched(pn - r * (un + mu[c] * tangent_length(u1, u2)), p1 - s * u1, p2 - s * u2, mu[c], r / s)
        else:
            xn, x1, x2 = project_to_cone(pn - r * (un + mu[c] * tangent_length(u1, u2)), p1 - r * u1, p2 - r * u2, mu[c])
        new[c, 0], new[c, 1] = pn + relaxation * (xn - pn), p1 + relaxation * (x1 - p1)
        if m == 3:
            new[c, 2] = p2 + relaxation * (x2 - p2)
        change += d[c] * ((xn - pn) * (xn - pn) + (x1 - p1) * (x1 - p1) + (x2 - p2) * (x2 - p2))
        tn, t1, t2 = 2.0 * xn - pn, 2.0 * x1 - p1, 2.0 * x2 - p2
        a, b = target[c, 0], target[c, 1]
        for k in range(n):
            if m == 3:
                momentum[a, k] += jacobian[c, 0, 0, k] * tn + jacobian[c, 0, 1, k] * t1 + jacobian[c, 0, 2, k] * t2
                momentum[b, k] += jacobian[c, 1, 0, k] * tn + jacobian[c, 1, 1, k] * t1 + jacobian[c, 1, 2, k] * t2
            else:
                momentum[a, k] += jacobian[c, 0, 0, k] * tn + jacobian[c, 0, 1, k] * t1
                momentum[b, k] += jacobian[c, 1, 0, k] * tn + jacobian[c, 1, 1, k] * t1
    return change


@borrower()
def clear_momentum(work, q):
    """No generalised impulse on the bodies of subtree q, nor in its ghost rows."""
    first, last = nodes_of(work.factor.symbolic, q)
    work.iterates.momentum[first:last] = 0.0
    clear_ghosts(work.factor.symbolic, q, work.iterates.momentum)


@borrower()
def add_momentum(work, q, p):
    """momentum += H^T p of the contacts of subtree q."""
    start, target = work.partition.start, work.partition.target
    add_generalised_impulse_of(work.problem, target, p, start[q], start[q + 1], work.iterates.momentum)


@borrower(fastmath={"contract"})
def carry_impulses(work, q, relaxation, last, p):
    """carried = 2 p+ - last - R H (v+ - v), the impulses whose velocities an iteration has found, and momentum += H^T carried.

    For the contacts of subtree q; last (C, m) and p = last + relaxation (p+ - last) are the impulses before and after the iteration.
    """
    jacobian, places, partition, rho = work.problem.jacobian, work.problem.places, work.partition, work.factor.rho
    step, carried, momentum = work.iterates.correction, work.iterates.carried, work.iterates.momentum
    m, n = len(work.problem.m), len(work.problem.n)
    for c in range(partition.start[q], partition.start[q + 1]):
        a, b = places[c, 0], places[c, 1]
        to, other = partition.target[c, 0], partition.target[c, 1]
        for i in range(m):
            gain = 0.0
            for k in range(n):
                gain += jacobian[c, 0, i, k] * step[a, k] + jacobian[c, 1, i, k] * step[b, k]
            x = last[c, i] + 2.0 / relaxation * (p[c, i] - last[c, i]) - rho[c] * gain
            carried[c, i] = x
            for k in range(n):
                momentum[to, k] += jacobian[c, 0, i, k] * x
                momentum[other, k] += jacobian[c, 1, i, k] * x
