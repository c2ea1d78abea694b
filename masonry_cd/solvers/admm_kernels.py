"""ADMM over bodies by a team of threads; see admm.py for the method."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.natural_map import size_of
from masonry_cd.friction.operators import OrderedProblem, measure_scales, put_in_order, relative_velocity_of
from masonry_cd.jit import entry
from masonry_cd.linalg.ghost_rows import share_of_subtrees
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.threads import share_of, wait
from masonry_cd.solvers.admm_passes import (
    add_generalised_impulse_of,
    carry_impulses,
    clear_generalised_impulse,
    eliminate_subtree,
    map_norm_by_team,
    prepare_admm,
    sort_contacts,
    update_subtree,
    velocity_by_team,
)

PATIENCE = 20  # iterations of ADMM without a look at the error, half as many where its ratio to the change of p is a guess
BALANCE, ALL = 0.6, 0.95  # shares of ADMM's error that lie in the law: its stiffness falls below the one, grows above the other
SOFTEST = 1e-3  # k of ADMM at which a factorisation that fails is not tried at a tenth of it again


@entry()
def admm_bodies(
    team, inverse_mass, v_free, bodies, jacobian, offset, mu, compliance, order, plan, turns, desk, squares, panels, rho, p_out, v_out, k,
    fresh, moving, rate, tolerance, limit, size_m, size_n,
):  # fmt: skip
    """ADMM over a FrictionProblem, see solvers/admm.py, by a team. p_out and v_out hold the start and then the best answer found.

    squares, panels and rho (in the order of the parts) hold a factorisation of M + H^T R H, used as it is unless ``fresh`` is set. It is in
    single precision: what it is asked for are corrections, which become small, of velocities and impulses in double precision. The
    velocities to start from are those of the impulses; if ``moving`` is set, those of v_out where the impulses fit worse than none would.
    ``rate`` is the error over the change of p in the last iteration, as measured last, or 1.

    Returns iterations, natural map error, k at the end, the number of factorisations and the rate.
    """
    count, contacts, top = len(order), len(mu), len(plan.level) - 2
    b0, b1 = share_of(team, 0, count)
    c0, c1 = share_of(team, 0, contacts)
    q0, q1 = share_of(team, plan.level[0], plan.level[1])
    begin, end = share_of_subtrees(team, plan)
    patience = PATIENCE if rate != 1.0 else PATIENCE // 2
    v, trial, p, new, best, d, sums = desk.v, desk.trial, desk.even, desk.odd, desk.best, desk.d, desk.sums
    problem = OrderedProblem(
        desk.inverse, desk.mass, desk.free, turns.place, turns.spot, desk.jacobian, desk.offset, desk.mu, desk.compliance, d, size_m, size_n
    )
    put_in_order(inverse_mass, v_free, order, b0, b1, desk.inverse, desk.mass, desk.free, size_n)
    copy_flat(desk.free[b0:b1], v[b0:b1])
    v[count] = 0.0
    trial[count] = 0.0
    desk.x[count] = 0.0
    wait(team)
    for q in range(begin, end):  # all of a part while it is in the cache
        first, last = turns.start[q], turns.start[q + 1]
        sort_contacts(turns, jacobian, offset, mu, compliance, p_out, first, last, desk, size_m, size_n)
        copy_flat(p[first:last], best[first:last])
        measure_scales(problem, first, last)
        relative_velocity_of(problem, v, first, last, desk.carried)
        clear_generalised_impulse(plan, q, desk.push)
        add_generalised_impulse_of(desk.jacobian, turns, q, p, desk.push, size_m, size_n)
    velocity_by_team(team, plan, desk.inverse, desk.free, desk.push, v, size_n)
    size = size_of(desk.carried, d)
    error = map_norm_by_team(team, plan, turns, problem, p, v, sums[2]) / size
    copy_flat(v[b0:b1], desk.best_v[b0:b1])
    if moving and error > 1.0:  # the impulses fit worse than none would
        for b in range(b0, b1):
            for i in range(len(size_n)):
                v[b, i] = v_out[order[b], i]
        wait(team)
    smallest = before = error
    iterations, checked, switched, factorisations, ahead = 0, 0, 0, 0, False
    while iterations < limit and smallest > tolerance:
        if fresh:
            factorisations += 1
            if not prepare_admm(team, plan, turns, k, desk, squares, panels, rho, size_m, size_n):
                k = 0.1 * k  # a matrix closer to that of the masses, which is definite
                if k < SOFTEST:
                    break
                continue
            fresh = False
        changes = sums[iterations % 2]
        if not ahead:
            for q in range(q0, q1):
                changes[q] = eliminate_subtree(plan, turns, q, -1, desk, rho, panels, p, new, size_m, size_n)
            wait(team)
        for level in range(1, top + 1):
            first, last = share_of(team, plan.level[level], plan.level[level + 1])
            for q in range(first, last):
                changes[q] = eliminate_subtree(plan, turns, q, -1, desk, rho, panels, p, new, size_m, size_n)
            wait(team)
        change = np.sqrt(changes.sum()) / size
        iterations += 1
        p, new = new, p
        # the change of p tells when to look at the error itself
        ahead = iterations - checked < 2 or (rate * change > tolerance and iterations - checked < patience)
        ahead = ahead and iterations < limit
        for level in range(top, 0, -1):
            first, last = share_of(team, plan.level[level], plan.level[level + 1])
            for q in range(first, last):
                update_subtree(plan, q, desk, squares, panels, size_n)
            wait(team)
        for q in range(q0, q1):
            update_subtree(plan, q, desk, squares, panels, size_n)
            if ahead:  # while the factors are in the cache
                coming = q + 1 if q + 1 < q1 else -1
                sums[iterations % 2, q] = eliminate_subtree(plan, turns, q, coming, desk, rho, panels, p, new, size_m, size_n)
        wait(team)
        if ahead:
            continue
        for q in range(begin, end):
            clear_generalised_impulse(plan, q, desk.push)
            carry_impulses(desk.jacobian, turns, q, rho, new, p, desk.x, desk.carried, desk.push, size_m, size_n)
        velocity_by_team(team, plan, desk.inverse, desk.free, desk.push, trial, size_n)
        error = map_norm_by_team(team, plan, turns, problem, desk.carried, trial, sums[2]) / size
        checked = iterations
        rate = error / change if change > 0.0 else 1.0
        if error < smallest:
            smallest = error
            copy_flat(desk.carried[c0:c1], best[c0:c1])
            copy_flat(trial[b0:b1], desk.best_v[b0:b1])
        if not error < np.inf:
            copy_flat(best[c0:c1], p[c0:c1])
            copy_flat(desk.best_v[b0:b1], v[b0:b1])
        wait(team)
        ends = iterations == limit and smallest > tolerance  # the next step begins with a k that suits this one better
        if ends or iterations - switched >= 40 or (iterations - switched >= 20 and error > before):
            if ends or not error < 0.1 * before:
                share = map_norm_by_team(team, plan, turns, problem, p, v, sums[2]) / size / error
                if share > ALL and not ends:
                    k, fresh = min(5.0 * k, 1e6), True
                elif share < BALANCE:
                    k, fresh = max(k * max(np.sqrt(share / BALANCE), 0.01), 1.0), True
            switched, before = iterations, error
    for c in range(c0, c1):
        old = turns.contact[c]
        for i in range(len(size_m)):
            p_out[old, i] = best[c, i]
    for b in range(b0, b1):
        for i in range(len(size_n)):
            v_out[order[b], i] = desk.best_v[b, i]
    return iterations, smallest, k, factorisations, rate
