# SPDX-License-Identifier: GPL-3.0-or-later
"""The interior point method; see interior.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.threads import take, wait
from masonry_cd.mechanics.solvers.central_path import (
    Iterate,
    Linearisation,
    advance,
    allocate_iterate,
    allocate_linearisation,
    begin_inside,
    complementarity,
    cones_of,
    interior_direction,
    judge,
    linearise_products,
    longest_step,
    missing_velocity,
    soften,
)
from masonry_cd.mechanics.solvers.linearised import STIFFEST
from masonry_cd.mechanics.solvers.shared_operators import contact_velocity, factorise, missing_momentum
from masonry_cd.mechanics.solvers.shares import begin_sums, chunk_of, sum_of_chunks


class InteriorRoom(NamedTuple):
    """What the interior point method works on."""

    impulse: np.ndarray  # (C, m) those of the iterate, admissible where there is no friction
    v: np.ndarray  # (B + 1, n) their velocities
    here: Iterate
    way: Iterate
    linear: Linearisation


@kernel()
def allocate_interior(room, shape, rows):
    """:class:`InteriorRoom` for contacts (C, m) and velocities of a shape."""
    here, way = allocate_iterate(room, shape, rows), allocate_iterate(room, shape, rows)
    return InteriorRoom(take(room, shape), take(room, rows), here, way, allocate_linearisation(room, here))


@borrower()
def corrector_rhs(shares, cones, way, linear, target, second):
    """The changes of the products that lead to ``target``, with the second order of the last direction if ``second`` is set."""
    m, k, wanted, (first, end) = len(cones.m), len(cones.k), linear.wanted, shares.contacts
    for c in range(first, end):
        if second:
            complementarity(way.w[c], way.p[c], way.gamma[c], cones.mu[c], m, wanted[c])
        for i in range(k):
            wanted[c, i] = (target if i < 2 else 0.0) - linear.product[c, i] - (wanted[c, i] if second else 0.0)


@borrower()
def mean_second_order(shares, cones, way, wanted):
    """The second order of a direction in the gap, mean over the contacts; uses ``wanted`` (C, k) up."""
    contacts, turn, (first, end) = len(cones.mu), begin_sums(shares), shares.chunks
    for k in range(first, end):
        total = 0.0
        begin, stop = chunk_of(k, contacts)
        for c in range(begin, stop):
            complementarity(way.w[c], way.p[c], way.gamma[c], cones.mu[c], len(cones.m), wanted[c])
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
def predict_and_correct(shares, problem, work, cones, inside, means, step):
    """Predictor, then corrector with the centring that the predictor asks for; a corrector that leads nowhere is left out.

    ``means`` are the gap and what w misses, see :func:`linearise_products`, ``step`` is the last one. Returns the longest step along the
    direction that stays inside the cones.
    """
    gap, undone = means
    here, way, linear = inside.here, inside.way, inside.linear
    centring, longest = 0.0, 0.0
    for turn in range(3):
        if turn == 2 and longest >= 0.1:
            break
        corrector_rhs(shares, cones, way, linear, centring * gap, turn == 1)
        interior_direction(shares, problem, work, cones, linear, way)
        longest = longest_step(shares, here, way, cones)
        if turn == 0:
            second = mean_second_order(shares, cones, way, linear.wanted)
            centring = centring_share(gap, undone, second, longest, step)
    return longest


@borrower()
def stiffness_after(step, stiffness):
    """Long steps can do with stiffer contacts, short ones need softer."""
    if step > 0.5:
        return min(4.0 * stiffness, STIFFEST)
    return max(0.25 * stiffness, 1.0) if step < 0.1 else stiffness


@kernel()
def interior_point(shares, problem, work, inside, answer, settings):
    """Interior point method from near ``answer``, which gets better; returns the iterations.

    ``inside`` is its :class:`InteriorRoom`.
    """
    here, way, linear = inside.here, inside.way, inside.linear
    cones, room = cones_of(problem.mu, problem.m, settings.k), work.room
    contact_velocity(shares, problem, answer.velocity, linear.miss)
    begin_inside(shares, problem, answer, cones, settings.distance, here, linear.miss)
    step, stiffness, iterations, short = 1.0, settings.stiffness, 0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance and short < 6:
        iterations += 1
        missing_velocity(shares, problem, here, 0.0, linear)
        missing_momentum(shares, problem, here.v, here.p, room)
        soften(shares, problem, stiffness, linear)
        means = linearise_products(shares, cones, linear)
        if not means[0] > 0.0:
            break
        sign = factorise(shares, problem, work, linear.gain)
        if sign == 0.0:
            break
        if sign < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        step = min(1.0, 0.99 * predict_and_correct(shares, problem, work, cones, inside, means, step))
        advance(shares, here, step, way)
        short = short + 1 if step < 0.02 else 0
        stiffness = stiffness_after(step, stiffness)
        if not judge(shares, problem, work, inside, answer) < np.inf:
            break
    return iterations
