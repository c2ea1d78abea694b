"""The passes of an ADMM iteration over the contacts and bodies of a subtree."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.friction.natural_map import project_stretched, project_to_cone
from masonry_cd.friction.operators import missing_momentum_of, squared_map_norm_of
from masonry_cd.jit import kernel
from masonry_cd.linalg.cholesky import factorise_by_team, factorise_cholesky
from masonry_cd.linalg.ghost_rows import add_ghosts, clear_ghosts, nodes_of, share_of_subtrees
from masonry_cd.linalg.intrinsics import prefetch
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import has_single_columns
from masonry_cd.linalg.threads import share_of, wait
from masonry_cd.linalg.triangular import backward_substitution, forward_substitution


@kernel()
def clear_generalised_impulse(plan, q, push):
    """No impulse on the bodies of part q, and none left by it to later ones."""
    first, last = nodes_of(plan, q)
    push[first:last] = 0.0
    clear_ghosts(plan, q, push)


@kernel()
def velocity_by_team(team, plan, inverse, free, push, v, size_n):
    """v = v_free + M^-1 of what all parts pushed."""
    n, (begin, end) = len(size_n), share_of_subtrees(team, plan)
    wait(team)
    for q in range(begin, end):
        first, last = nodes_of(plan, q)
        add_ghosts(plan, q, push)
        for b in range(first, last):
            for i in range(n):
                total = free[b, i]
                for k in range(n):
                    total += inverse[b, i, k] * push[b, k]
                v[b, i] = total
    wait(team)


@kernel(fastmath={"contract"})
def add_generalised_impulse_of(jacobian, turns, q, p, out, size_m, size_n):
    """out += H^T p of the contacts of part q."""
    m, n = len(size_m), len(size_n)
    for c in range(turns.start[q], turns.start[q + 1]):
        a, b = turns.landing[c, 0], turns.landing[c, 1]
        for i in range(m):
            x = p[c, i]
            for k in range(n):
                out[a, k] += jacobian[c, 0, i, k] * x
                out[b, k] += jacobian[c, 1, i, k] * x


@kernel()
def map_norm_by_team(team, plan, turns, problem, p, v, sums):
    """Norm of the natural map residual by a team; sums (K,) is where they put their shares."""
    begin, end = share_of_subtrees(team, plan)
    for q in range(begin, end):
        first, last = turns.start[q], turns.start[q + 1]
        sums[q] = squared_map_norm_of(problem, p, v, first, last)
    wait(team)
    total = np.sqrt(sums.sum())
    wait(team)
    return total


class AdmmWorkspace(NamedTuple):
    """Room for what a team works on together: bodies in the order of elimination, then the supports, then the copies."""

    inverse: np.ndarray  # (N, n, n) M^-1
    mass: np.ndarray  # (N, n, n)
    free: np.ndarray  # (N, n) v_free
    v: np.ndarray  # (N + 1, n)
    trial: np.ndarray  # (N + 1, n) velocities to be judged
    best_v: np.ndarray  # (N + 1, n)
    push: np.ndarray  # (N + 1 + E, n)
    x: np.ndarray  # (N + 1 + E, n) in single precision
    jacobian: np.ndarray  # (C, 2, m, n) contacts in the order of their parts, here and in what follows
    offset: np.ndarray  # (C, m)
    mu: np.ndarray  # (C,)
    compliance: np.ndarray  # (C, m), or (0, m)
    even: np.ndarray  # (C, m) impulses after an even number of iterations
    odd: np.ndarray  # (C, m)
    best: np.ndarray  # (C, m)
    carried: np.ndarray  # (C, m) impulses to be judged
    d: np.ndarray  # (C,)
    sums: np.ndarray  # (3, K) shares of the parts in sums
    diagonal: np.ndarray  # (N + 1 + E, n n) blocks of M + H^T R H
    lower: np.ndarray  # (pairs, n, n)
    squares: np.ndarray  # of the factors in double precision, if all columns are alone
    panels: np.ndarray


@kernel()
def sort_contacts(turns, jacobian, offset, mu, compliance, p, first, end, desk, size_m, size_n):
    """Put contacts first to end on the desk, unless they lie there as they are."""
    m, n, moved = len(size_m), len(size_n), len(turns.start) > 2
    for c in range(first, end):
        old = turns.contact[c]
        for i in range(m):
            desk.even[c, i] = p[old, i]
        if not moved:
            continue
        desk.mu[c] = mu[old]
        for i in range(m):
            desk.offset[c, i] = offset[old, i]
            if len(compliance):
                desk.compliance[c, i] = compliance[old, i]
            for k in range(n):
                desk.jacobian[c, 0, i, k] = jacobian[old, 0, i, k]
                desk.jacobian[c, 1, i, k] = jacobian[old, 1, i, k]


@kernel(fastmath={"contract"})
def augment(plan, turns, q, mass, jacobian, rho, diagonal, lower, size_m, size_n):
    """Blocks of M + H^T R H in the columns of part q, and what its contacts add to diagonal blocks (.., n n) of later ones."""
    m, n, bodies, (first, last) = len(size_m), len(size_n), len(mass), nodes_of(plan, q)
    lower[plan.column[first] : plan.column[last]] = 0.0
    clear_ghosts(plan, q, diagonal)
    for b in range(first, last):
        for p in range(n):
            for r in range(n):
                diagonal[b, n * p + r] = mass[b, p, r]
    for c in range(turns.start[q], turns.start[q + 1]):
        a, b, r = turns.landing[c, 0], turns.landing[c, 1], rho[c]
        for i in range(m):
            for p in range(n):
                x, y = r * jacobian[c, 0, i, p], r * jacobian[c, 1, i, p]
                for t in range(n):
                    if a != bodies:
                        diagonal[a, n * p + t] += x * jacobian[c, 0, i, t]
                    if b != bodies:
                        diagonal[b, n * p + t] += y * jacobian[c, 1, i, t]
                if a == b != bodies:
                    for t in range(n):
                        diagonal[a, n * p + t] += x * jacobian[c, 1, i, t] + y * jacobian[c, 0, i, t]
                if turns.spot[c] >= 0:
                    for t in range(n):
                        lower[turns.spot[c], p, t] += (
                            x * jacobian[c, 1, i, t] if turns.place[c, 0] > turns.place[c, 1] else y * jacobian[c, 0, i, t]
                        )


@kernel()
def choose_stiffness(k, d, compliance, first, end, rho):
    """R of each contact: k / d_c for rigid ones, softer for elastic ones, see solvers/admm.py."""
    for c in range(first, end):
        rho[c] = k / d[c]
        if len(compliance):
            soft = compliance[c].sum() / compliance.shape[1]
            own = d[c] - soft
            rho[c] = 1.0 / (own / k + soft / np.sqrt(1.0 + soft / own))


@kernel()
def prepare_admm(team, plan, turns, k, desk, squares, panels, rho, size_m, size_n):
    """Factorise M + H^T R H by a team; the factors are in single precision. False if that is not possible."""
    n, (begin, end) = len(size_n), share_of_subtrees(team, plan)
    first, last = share_of(team, 0, len(rho))
    choose_stiffness(k, desk.d, desk.compliance, first, last, rho)
    wait(team)
    for q in range(begin, end):
        augment(plan, turns, q, desk.mass, desk.jacobian, rho, desk.diagonal, desk.lower, size_m, size_n)
    wait(team)
    for q in range(begin, end):
        add_ghosts(plan, q, desk.diagonal)
    wait(team)
    blocks = desk.diagonal.reshape((len(desk.diagonal), n, n))
    if not has_single_columns(plan):
        return factorise_by_team(team, plan, blocks, desk.lower, squares, panels, n)
    ok = factorise_cholesky(plan, blocks, desk.lower, desk.squares, desk.panels, size_n)  # by one, there is one part
    copy_flat(desk.squares, squares)
    copy_flat(desk.panels, panels)
    return ok


@kernel(fastmath={"contract"})
def augmented_pass(panels, line, end, turns, part, jacobian, offset, mu, compliance, d, rho, p, v, new, out, size_m, size_n):
    """new = P_K(p - S (w + mu |w_t| n)), S^-1 = R^-1 + C, out += H^T (2 new - p), for the contacts of a part.

    There is more to calculate than to fetch, so entries ``line`` to ``end`` of the panels, for which the next part would wait, are fetched
    on the way. Returns the squared scaled change of p.
    """
    m, n, index = len(size_m), len(size_n), turns.place
    change, contacts = 0.0, max(turns.start[part + 1] - turns.start[part], 1)
    share = (end - line + contacts - 1) // contacts
    for c in range(turns.start[part], turns.start[part + 1]):
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
        new[c, 0], new[c, 1] = xn, x1
        if m == 3:
            new[c, 2] = x2
        change += d[c] * ((xn - pn) * (xn - pn) + (x1 - p1) * (x1 - p1) + (x2 - p2) * (x2 - p2))
        tn, t1, t2 = 2.0 * xn - pn, 2.0 * x1 - p1, 2.0 * x2 - p2
        a, b = turns.landing[c, 0], turns.landing[c, 1]
        for k in range(n):
            if m == 3:
                out[a, k] += jacobian[c, 0, 0, k] * tn + jacobian[c, 0, 1, k] * t1 + jacobian[c, 0, 2, k] * t2
                out[b, k] += jacobian[c, 1, 0, k] * tn + jacobian[c, 1, 1, k] * t1 + jacobian[c, 1, 2, k] * t2
            else:
                out[a, k] += jacobian[c, 0, 0, k] * tn + jacobian[c, 0, 1, k] * t1
                out[b, k] += jacobian[c, 1, 0, k] * tn + jacobian[c, 1, 1, k] * t1
    return change


@kernel(fastmath={"contract"})
def carry_impulses(jacobian, turns, part, rho, last, p, step, out, push, size_m, size_n):
    """out = 2 p - last - R H step, the impulses whose velocities an iteration of ADMM has found, and push += H^T out.

    For the contacts of a part; step (bodies + 1, n) or more is what the iteration added to the velocities.
    """
    m, n = len(size_m), len(size_n)
    for c in range(turns.start[part], turns.start[part + 1]):
        a, b = turns.place[c, 0], turns.place[c, 1]
        to, other = turns.landing[c, 0], turns.landing[c, 1]
        for i in range(m):
            gain = 0.0
            for k in range(n):
                gain += jacobian[c, 0, i, k] * step[a, k] + jacobian[c, 1, i, k] * step[b, k]
            x = 2.0 * p[c, i] - last[c, i] - rho[c] * gain
            out[c, i] = x
            for k in range(n):
                push[to, k] += jacobian[c, 0, i, k] * x
                push[other, k] += jacobian[c, 1, i, k] * x


@kernel()
def panels_of(plan, q, n):
    """First entry and end of the panels of part q, one of several: they are stored from its last run to its first."""
    s = plan.part[q]
    end = plan.panel[s] + (plan.first[s + 1] - plan.first[s]) * (plan.start[s + 1] - plan.start[s])
    return n * n * plan.panel[plan.part[q + 1] - 1], n * n * end


@kernel()
def eliminate_subtree(plan, turns, q, coming, desk, rho, panels, p, new, size_m, size_n):
    """The contacts of part q, and L^-1 of what they ask for; ``coming`` is the part that comes down next, or -1.

    Returns the squared scaled change of p.
    """
    first, last = nodes_of(plan, q)
    line, end = panels_of(plan, coming, len(size_n)) if coming >= 0 else (0, 0)
    push, x = desk.push, desk.x
    missing_momentum_of(desk.mass, desk.free, desk.v, first, last, push, size_n)
    clear_ghosts(plan, q, push)
    add_ghosts(plan, q, push)
    change = augmented_pass(
        panels, line, end, turns, q, desk.jacobian, desk.offset, desk.mu, desk.compliance, desk.d, rho, p, desk.v, new, push, size_m, size_n
    )
    copy_flat(push[first:last], x[first:last])
    clear_ghosts(plan, q, x)
    add_ghosts(plan, q, x)
    forward_substitution(plan, plan.part[q], plan.part[q + 1], plan.target, panels, x, size_n)
    return change


@kernel()
def update_subtree(plan, q, desk, squares, panels, size_n):
    """The velocities of the bodies of part q change by L^-T D^-1 of what :func:`eliminate_subtree` left."""
    first, last = nodes_of(plan, q)
    backward_substitution(plan, plan.part[q], plan.part[q + 1], squares, panels, desk.x, size_n)
    size = (last - first) * len(size_n)
    v, x = desk.v[first:last].reshape(size), desk.x[first:last].reshape(size)
    for i in range(size):
        v[i] += x[i]
