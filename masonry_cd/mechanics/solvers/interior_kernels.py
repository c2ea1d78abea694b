# SPDX-License-Identifier: GPL-3.0-or-later
"""The interior point method and the central path followed by its length; see interior.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.threads import wait
from masonry_cd.mechanics.solvers.central_path import (
    advance,
    are_inside,
    complementarity,
    cones_of,
    interior_direction,
    keep_if_better,
    linearise_products,
    longest_step,
    missing_velocity,
    set_damping,
    start_inside_cones,
)
from masonry_cd.mechanics.solvers.linearised import STIFFEST, body_velocity, factorise, law_velocity, momentum_residual
from masonry_cd.mechanics.solvers.shares import any_of, begin_sums, chunk_of, copy_share, sum_of_chunks

STIFFNESS = 1e4  # K of the interior point method, to begin with
RIGID = 1e8  # K of the path
BEYOND = 1.02  # of a step, inside the cones
WIDE = 0.5  # how far products may be off the path, relative to those on it: much more, and it takes other branches for its own


@borrower()
def corrector_rhs(shares, cones, direction, linear, target, second):
    """The changes of the products that lead to ``target``, with the second order of the last direction if ``second`` is set."""
    m, wanted, (first, end) = len(cones.m), linear.wanted, shares.contacts
    for c in range(first, end):
        if second:
            complementarity(direction.w[c], direction.p[c], direction.gamma[c], cones.mu[c], m, wanted[c])
        for i in range(m + 1):
            wanted[c, i] = (target if i < 2 else 0.0) - linear.product[c, i] - (wanted[c, i] if second else 0.0)


@borrower()
def mean_second_order(shares, cones, direction, wanted):
    """The second order of a direction in the gap, mean over the contacts; uses ``wanted`` (C, m + 1) up."""
    contacts, turn, (first, end) = len(cones.mu), begin_sums(shares), shares.chunks
    for k in range(first, end):
        total = 0.0
        begin, stop = chunk_of(k, contacts)
        for c in range(begin, stop):
            complementarity(direction.w[c], direction.p[c], direction.gamma[c], cones.mu[c], len(cones.m), wanted[c])
            total += 0.5 * (wanted[c, 0] + wanted[c, 1])
        shares.sums[turn, 0, k] = total
    wait(shares.team)
    return sum_of_chunks(shares, 0, contacts) / contacts


@borrower()
def centring_share(gap, undone, second, longest, step):
    """Share of the gap to aim at, from what the predictor would leave of it, and more after a short step.

    ``undone`` measures what w misses in the units of the gap, which is not to vanish before it; ``second`` is the second order of the
    predictor in the gap, and ``longest`` its longest step.
    """
    reach = min(1.0, longest)
    ahead = (1.0 - reach) * gap + reach * reach * second
    left = max(min(1.0, max(ahead / gap, 0.0)) ** 3, min(1.0, 0.3 * undone / gap))
    return max(left, 1e-6 if step > 0.2 else (0.5 if step > 0.05 else 1.0))


@kernel()
def predict_and_correct(shares, problem, work, cones, workspace, means, step):
    """Predictor, then corrector with the centring that the predictor asks for; a corrector that leads nowhere is left out.

    ``means`` are the gap and what w misses, see :func:`linearise_products`, ``step`` is the last one. Returns the longest step along the
    direction that stays inside the cones.
    """
    (gap, undone), here, direction, linear = means, workspace.here, workspace.directions.ahead, workspace.linear
    centring, longest = 0.0, 0.0
    for turn in range(3):
        if turn == 2 and longest >= 0.1:
            break
        corrector_rhs(shares, cones, direction, linear, centring * gap, turn == 1)
        interior_direction(shares, problem, work, cones, linear, direction)
        longest = longest_step(shares, here, direction, cones)
        if turn == 0:
            second = mean_second_order(shares, cones, direction, linear.wanted)
            centring = centring_share(gap, undone, second, longest, step)
    return longest


@kernel()
def interior_point(shares, problem, work, workspace, answer, settings):
    """Interior point method from near ``answer``, which gets better; returns the iterations."""
    here, linear, cones, scratch = workspace.here, workspace.linear, cones_of(problem), work.scratch
    law_velocity(shares, problem, answer.velocity, linear.miss)
    start_inside_cones(shares, problem, answer, cones, settings.distance, here, linear.miss)
    step, stiffness, iterations, short = 1.0, STIFFNESS, 0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance and short < 6:
        iterations += 1
        missing_velocity(shares, problem, here, 0.0, linear)
        momentum_residual(shares, problem, problem.free, here.v, here.p, scratch)
        set_damping(shares, problem, stiffness, linear)
        means = linearise_products(shares, cones, linear)
        if not means[0] > 0.0:
            break
        sign = factorise(shares, problem, work, linear.gain)
        if sign == 0.0:
            break
        if sign < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        step = min(1.0, 0.99 * predict_and_correct(shares, problem, work, cones, workspace, means, step))
        advance(shares, here, step, workspace.directions.ahead, here)
        short = short + 1 if step < 0.02 else 0
        if step > 0.5:  # long steps can do with stiffer contacts, short ones need softer
            stiffness = min(4.0 * stiffness, STIFFEST)
        elif step < 0.1:
            stiffness = max(0.25 * stiffness, 1.0)
        if not keep_if_better(shares, problem, work, workspace, answer) < np.inf:
            break
    return iterations


@borrower()
def direction_product(shares, a, b, here, cones):
    """Inner product of two directions, each relative to what it changes, mean over the contacts."""
    mu, m, (w, p, gamma, _) = cones.mu, len(cones.m), here
    turn, (first, end) = begin_sums(shares), shares.chunks
    for k in range(first, end):
        total = 0.0
        begin, stop = chunk_of(k, len(mu))
        for c in range(begin, stop):
            slide, bound = 1.0 / gamma[c], 1.0 / (mu[c] * p[c, 0])
            total += a.w[c, 0] * b.w[c, 0] / (w[c, 0] * w[c, 0]) + a.p[c, 0] * b.p[c, 0] / (p[c, 0] * p[c, 0])
            total += a.gamma[c] * b.gamma[c] * slide * slide
            for i in range(1, m):
                total += a.w[c, i] * b.w[c, i] * slide * slide + a.p[c, i] * b.p[c, i] * bound * bound
        shares.sums[turn, 0, k] = total
    wait(shares.team)
    return sum_of_chunks(shares, 0, len(mu)) / len(mu)


@kernel(inline="always")
def is_near(product, goal):
    """Return True if the products of a contact are off goal (1, e) by less than WIDE times goal."""
    bound, across = WIDE * goal, (product[1] - goal) ** 2
    for i in range(2, len(product)):
        across += product[i] * product[i]
    return abs(product[0] - goal) < bound and across < bound * bound


@kernel()
def path_directions(shares, problem, work, cones, linear, level, tau, directions):
    """Fill ``back``, ``tangent`` and ``bend``; the products on the path are tau times ``level`` (C,)."""
    m, wanted, (first, end), (begin, stop) = len(cones.m), linear.wanted, shares.contacts, shares.rows
    momentum_residual(shares, problem, problem.free, linear.here.v, linear.here.p, work.scratch)
    for c in range(first, end):
        for i in range(m + 1):
            wanted[c, i] = (tau * level[c] if i < 2 else 0.0) - linear.product[c, i]
    interior_direction(shares, problem, work, cones, linear, directions.back)
    work.scratch[begin:stop] = 0.0
    for c in range(first, end):
        for i in range(m + 1):
            wanted[c, i] = tau * level[c] if i < 2 else 0.0
        for i in range(m):
            linear.miss[c, i] = -tau * linear.far[c, i]
    interior_direction(shares, problem, work, cones, linear, directions.tangent)
    dw, dp, dgamma, _ = directions.tangent
    for c in range(first, end):
        complementarity(dw[c], dp[c], dgamma[c], cones.mu[c], m, wanted[c])
        for i in range(m + 1):
            wanted[c, i] = -wanted[c, i]
        for i in range(m):
            linear.miss[c, i] = 0.0
    interior_direction(shares, problem, work, cones, linear, directions.bend)


@borrower()
def across_tangent(shares, directions, here, cones):
    """Turn ``back`` and ``bend`` across the tangent: this is what lets the path turn back. Returns the relative changes of tau in them."""
    back, tangent, bend = directions.back, directions.tangent, directions.bend
    length = 1.0 + direction_product(shares, tangent, tangent, here, cones)
    drop = -direction_product(shares, back, tangent, here, cones) / length
    curve = -direction_product(shares, bend, tangent, here, cones) / length
    advance(shares, back, drop, tangent, back)
    advance(shares, bend, curve, tangent, bend)
    return drop, curve


@kernel()
def step_ahead(shares, here, directions, cones, level, tau, changes):
    """ahead = back + h tangent + h^2 bend with the largest h of 2 (0.97 where tau falls), 3/4 of it, and so on, that stays inside the cones
    and near the path.

    ``changes`` are those of tau that go along, drop, sign and curve: drop + h sign + h^2 curve. Near: no product of a contact is off tau
    times its level by more than WIDE times that. Returns the relative change of tau.
    """
    drop, sign, curve = changes
    h, change, forbidding, scratch = (2.0 if sign > 0.0 else 0.97), 0.0, -1, np.empty((3, len(cones.m) + 1))
    for turn in range(40):
        h *= 0.75 if turn > 0 else 1.0
        change = drop + h * sign + h * h * curve
        if change <= -0.98:
            continue
        along = (h * sign, h * h, tau * (1.0 + change))
        forbidding = first_forbidding(shares, here, directions, cones, forbidding, along, level, scratch)
        if not any_of(shares, forbidding >= 0, len(level)):
            break
    advance(shares, directions.back, h * sign, directions.tangent, directions.ahead)
    advance(shares, directions.ahead, h * h, directions.bend, directions.ahead)
    return change


@borrower()
def first_forbidding(shares, here, directions, cones, last, along, level, scratch):
    """A contact of the thread's that does not allow a step, -1 if there is none; see :func:`step_ahead`.

    The one that forbade the last step is asked first, since it mostly forbids the next one too. ``along`` are the shares of tangent and
    bend in the step, and tau at its end.
    """
    first, end = shares.contacts
    for k in range(first - 1 if last >= 0 else first, end):
        c = max(last, first) if k < first else k
        if not _allows(here, directions, cones, c, along, along[2] * level[c], scratch):
            return c
    return -1


@borrower()
def _allows(here, directions, cones, c, along, goal, scratch):
    """Return True if contact c stays inside the cones, a little beyond the step too, and near the path with products ``goal`` at its end.

    The step is back + along[0] tangent + along[1] bend; ``scratch`` (3, m + 1) is overwritten.
    """
    (back, tangent, bend, _), (first, second, _), m, mu = directions, along, len(cones.m), cones.mu[c]
    w, p, product, gamma = scratch[0], scratch[1], scratch[2], 0.0
    for share in (BEYOND, 1.0):
        for i in range(m):
            w[i] = here.w[c, i] + share * (back.w[c, i] + first * tangent.w[c, i] + second * bend.w[c, i])
            p[i] = here.p[c, i] + share * (back.p[c, i] + first * tangent.p[c, i] + second * bend.p[c, i])
        gamma = here.gamma[c] + share * (back.gamma[c] + first * tangent.gamma[c] + second * bend.gamma[c])
        if share > 1.0 and not are_inside(w, p, gamma, mu, m):
            return False
    complementarity(w, p, gamma, mu, m, product)
    return is_near(product, goal)


@kernel()
def choose_step(shares, here, directions, cones, level, tau, sign):
    """Fill ``ahead``: back to the path first, and along it from near; returns the relative change of tau, whose sign is given."""
    drop, curve = across_tangent(shares, directions, here, cones)
    longest = 0.9 * longest_step(shares, here, directions.back, cones)
    if longest < 1.0:
        advance(shares, directions.back, longest - 1.0, directions.back, directions.ahead)
        return longest * drop
    return step_ahead(shares, here, directions, cones, level, tau, (drop, sign, curve))


@kernel()
def path_by_length(shares, problem, work, workspace, answer, settings):
    """The central path followed by its length from near ``answer``, which gets better; returns the iterations."""
    here, linear, directions, cones, scratch = workspace.here, workspace.linear, workspace.directions, cones_of(problem), work.scratch
    # a point on the path at tau = 1, where w is off by far
    law_velocity(shares, problem, answer.velocity, linear.miss)
    shift = start_inside_cones(shares, problem, answer, cones, settings.distance, here, linear.miss)
    level = shift * shift / problem.d
    body_velocity(shares, problem, here.p, scratch, here.v)
    missing_velocity(shares, problem, here, 0.0, linear)
    copy_share(shares.contacts, linear.miss, linear.far)
    set_damping(shares, problem, RIGID, linear)
    tau, iterations = 1.0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance:
        iterations += 1
        missing_velocity(shares, problem, here, tau, linear)
        gap, _ = linearise_products(shares, cones, linear)
        if np.isnan(gap):
            break
        sign = factorise(shares, problem, work, linear.gain)
        if sign == 0.0:
            break
        path_directions(shares, problem, work, cones, linear, level, tau, directions)
        change = choose_step(shares, here, directions, cones, level, tau, -sign)
        advance(shares, here, 1.0, directions.ahead, here)
        tau *= 1.0 + change
        if not keep_if_better(shares, problem, work, workspace, answer) < np.inf:
            break
    return iterations
