# SPDX-License-Identifier: GPL-3.0-or-later
"""The central path followed by its length over bodies; see interior.py."""

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
    are_inside,
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
from masonry_cd.mechanics.solvers.shared_operators import body_velocity, contact_velocity, factorise, missing_momentum
from masonry_cd.mechanics.solvers.shares import any_of, begin_sums, chunk_of, copy_share, sum_of_chunks

BEYOND = 1.02  # of a step, inside the cones


class PathWays(NamedTuple):
    """The directions of a step along the path."""

    back: Iterate  # to the path, with tau held
    tangent: Iterate  # by d(log tau)
    bend: Iterate  # second order
    ahead: Iterate  # the step


class PathRoom(NamedTuple):
    """What the path by its length works on."""

    impulse: np.ndarray  # (C, m) those of the iterate, admissible where there is no friction
    v: np.ndarray  # (B + 1, n) their velocities
    here: Iterate
    linear: Linearisation
    ways: PathWays


@kernel()
def allocate_paths(room, shape, rows):
    """:class:`PathRoom` for contacts (C, m) and body velocities of a shape (B + 1, n)."""
    here = allocate_iterate(room, shape, rows)
    linear = allocate_linearisation(room, here)
    back, tangent = allocate_iterate(room, shape, rows), allocate_iterate(room, shape, rows)
    ways = PathWays(back, tangent, allocate_iterate(room, shape, rows), allocate_iterate(room, shape, rows))
    return PathRoom(take(room, shape), take(room, rows), here, linear, ways)


@borrower()
def way_product(shares, a, b, here, cones):
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


@borrower()
def combine(share, x, a, y, b, z, out):
    """The thread's share of out = x + a y + b z, for arrays of any shape."""
    size = out.size // len(out)
    x, y, z, out = x.reshape(x.size), y.reshape(y.size), z.reshape(z.size), out.reshape(out.size)
    for i in range(share[0] * size, share[1] * size):
        out[i] = x[i] + a * y[i] + b * z[i]


@borrower()
def combine_ways(shares, x, a, y, b, z, out):
    """out = x + a y + b z for points or directions."""
    combine(shares.contacts, x.w, a, y.w, b, z.w, out.w)
    combine(shares.contacts, x.p, a, y.p, b, z.p, out.p)
    combine(shares.contacts, x.gamma, a, y.gamma, b, z.gamma, out.gamma)
    combine(shares.rows, x.v, a, y.v, b, z.v, out.v)


@kernel(inline="always")
def is_near(product, goal, wide):
    """Whether the products of a contact are off goal (1, e) by less than ``wide`` times goal."""
    bound, across = wide * goal, (product[1] - goal) ** 2
    for i in range(2, len(product)):
        across += product[i] * product[i]
    return abs(product[0] - goal) < bound and across < bound * bound


@kernel()
def path_directions(shares, problem, work, cones, linear, level, tau, ways):
    """Fill ``back``, ``tangent`` and ``bend``; the products on the path are tau times ``level`` (C,)."""
    m, wanted, (first, end), (begin, stop) = len(cones.m), linear.wanted, shares.contacts, shares.rows
    missing_momentum(shares, problem, linear.here.v, linear.here.p, work.room)
    for c in range(first, end):
        for i in range(m + 1):
            wanted[c, i] = (tau * level[c] if i < 2 else 0.0) - linear.product[c, i]
    interior_direction(shares, problem, work, cones, linear, ways.back)
    work.room[begin:stop] = 0.0
    for c in range(first, end):
        for i in range(m + 1):
            wanted[c, i] = tau * level[c] if i < 2 else 0.0
        for i in range(m):
            linear.miss[c, i] = -tau * linear.far[c, i]
    interior_direction(shares, problem, work, cones, linear, ways.tangent)
    dw, dp, dgamma, _ = ways.tangent
    for c in range(first, end):
        complementarity(dw[c], dp[c], dgamma[c], cones.mu[c], m, wanted[c])
        for i in range(m + 1):
            wanted[c, i] = -wanted[c, i]
        for i in range(m):
            linear.miss[c, i] = 0.0
    interior_direction(shares, problem, work, cones, linear, ways.bend)


@borrower()
def turn_across(shares, ways, here, cones):
    """Turn ``back`` and ``bend`` across the tangent: this is what lets the path turn back. Returns the relative changes of tau in them."""
    back, tangent, bend = ways.back, ways.tangent, ways.bend
    length = 1.0 + way_product(shares, tangent, tangent, here, cones)
    drop = -way_product(shares, back, tangent, here, cones) / length
    curve = -way_product(shares, bend, tangent, here, cones) / length
    combine_ways(shares, back, drop, tangent, 0.0, tangent, back)
    combine_ways(shares, bend, curve, tangent, 0.0, tangent, bend)
    return drop, curve


@kernel()
def step_ahead(shares, here, ways, cones, level, tau, changes, wide):
    """ahead = back + h tangent + h^2 bend with the largest h of 2 (0.97 where tau falls), 3/4 of it, and so on, that stays inside the cones
    and near the path.

    ``changes`` are those of tau that go along, drop, sign and curve: drop + h sign + h^2 curve. Near: no product of a contact is off tau
    times its level by more than ``wide`` times that. Returns the relative change of tau.
    """
    drop, sign, curve = changes
    h, change, forbidding, room = (2.0 if sign > 0.0 else 0.97), 0.0, -1, np.empty((3, len(cones.k)))
    for turn in range(40):
        h *= 0.75 if turn > 0 else 1.0
        change = drop + h * sign + h * h * curve
        if change <= -0.98:
            continue
        along = (h * sign, h * h, tau * (1.0 + change))
        forbidding = first_forbidding(shares, here, ways, cones, forbidding, along, level, wide, room)
        if not any_of(shares, forbidding >= 0, len(level)):
            break
    combine_ways(shares, ways.back, h * sign, ways.tangent, h * h, ways.bend, ways.ahead)
    return change


@borrower()
def first_forbidding(shares, here, ways, cones, last, along, level, wide, room):
    """A contact of the thread's that does not allow a step, -1 if there is none; see :func:`step_ahead`.

    The one that forbade the last step is asked first, since it mostly forbids the next one too. ``along`` are the shares of tangent and
    bend in the step, and tau at its end.
    """
    first, end = shares.contacts
    for k in range(first - 1 if last >= 0 else first, end):
        c = max(last, first) if k < first else k
        if not _allows(here, ways, cones, c, along, along[2] * level[c], wide, room):
            return c
    return -1


@borrower()
def _allows(here, ways, cones, c, along, goal, wide, room):
    """Whether contact c stays inside the cones, a little beyond the step too, and near the path with products of ``goal`` at its end.

    The step is back + along[0] tangent + along[1] bend; ``room`` (3, k) is scratch.
    """
    (back, tangent, bend, _), (first, second, _), m, mu = ways, along, len(cones.m), cones.mu[c]
    w, p, product, gamma = room[0], room[1], room[2], 0.0
    for share in (BEYOND, 1.0):
        for i in range(m):
            w[i] = here.w[c, i] + share * (back.w[c, i] + first * tangent.w[c, i] + second * bend.w[c, i])
            p[i] = here.p[c, i] + share * (back.p[c, i] + first * tangent.p[c, i] + second * bend.p[c, i])
        gamma = here.gamma[c] + share * (back.gamma[c] + first * tangent.gamma[c] + second * bend.gamma[c])
        if share > 1.0 and not are_inside(w, p, gamma, mu, m):
            return False
    complementarity(w, p, gamma, mu, m, product)
    return is_near(product, goal, wide)


@kernel()
def choose_step(shares, here, ways, cones, level, tau, sign, wide):
    """Fill ``ahead``: back to the path first, and along it from near; returns the relative change of tau, whose sign is given."""
    drop, curve = turn_across(shares, ways, here, cones)
    longest = 0.9 * longest_step(shares, here, ways.back, cones)
    if longest < 1.0:
        combine_ways(shares, ways.back, longest - 1.0, ways.back, 0.0, ways.back, ways.ahead)
        return longest * drop
    return step_ahead(shares, here, ways, cones, level, tau, (drop, sign, curve), wide)


@kernel()
def path_by_length(shares, problem, work, inside, answer, settings):
    """The central path followed by its length, see interior.py, from near ``answer``, which gets better.

    ``inside`` is its :class:`PathRoom`. Returns the iterations.
    """
    here, linear, ways = inside.here, inside.linear, inside.ways
    cones, room = cones_of(problem.mu, problem.m, settings.k), work.room
    # a point on the path at tau = 1, where w is off by far
    contact_velocity(shares, problem, answer.velocity, linear.miss)
    shift = begin_inside(shares, problem, answer, cones, settings.distance, here, linear.miss)
    level = shift * shift / problem.d
    body_velocity(shares, problem, here.p, room, here.v)
    missing_velocity(shares, problem, here, 0.0, linear)
    copy_share(shares.contacts, linear.miss, linear.far)
    soften(shares, problem, settings.stiffness, linear)
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
        path_directions(shares, problem, work, cones, linear, level, tau, ways)
        change = choose_step(shares, here, ways, cones, level, tau, -sign, settings.wide)
        advance(shares, here, 1.0, ways.ahead)
        tau *= 1.0 + change
        if not judge(shares, problem, work, inside, answer) < np.inf:
            break
    return iterations
