"""The central path followed by its length over bodies; see interior.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction.operators import add_generalised_impulse, body_velocity, missing_momentum, relative_velocity
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.solvers.central_path import (
    Iterate,
    advance,
    allocate_iterate,
    allocate_linearisation,
    begin_inside,
    complementarity,
    cones_of,
    contact_step,
    interior_direction,
    linearise_products,
    longest_step,
    missing_velocity,
    soften,
    take_impulse,
)
from masonry_cd.solvers.linearised import keep_better

BEYOND = 1.02  # of a step, inside the cones


class PathWays(NamedTuple):
    """The directions of a step along the path."""

    back: Iterate  # to the path, with tau held
    tangent: Iterate  # by d(log tau)
    bend: Iterate  # second order
    ahead: Iterate  # the step


@borrower()
def way_product(a, b, here, cones):
    """Inner product of two directions, each relative to what it changes, mean over the contacts."""
    mu, m, total = cones.mu, len(cones.m), 0.0
    w, p, gamma, _ = here
    for c in range(len(mu)):
        slide, bound = 1.0 / gamma[c], 1.0 / (mu[c] * p[c, 0])
        total += a.w[c, 0] * b.w[c, 0] / (w[c, 0] * w[c, 0]) + a.p[c, 0] * b.p[c, 0] / (p[c, 0] * p[c, 0])
        total += a.gamma[c] * b.gamma[c] * slide * slide
        for i in range(1, m):
            total += a.w[c, i] * b.w[c, i] * slide * slide + a.p[c, i] * b.p[c, i] * bound * bound
    return total / len(mu)


@borrower()
def combine(x, a, y, b, z, out):
    """out = x + a y + b z, for arrays of any shape."""
    x, y, z, out = x.reshape(x.size), y.reshape(y.size), z.reshape(z.size), out.reshape(out.size)
    for i in range(len(out)):
        out[i] = x[i] + a * y[i] + b * z[i]


@borrower()
def combine_ways(x, a, y, b, z, out):
    """out = x + a y + b z for points or directions."""
    combine(x.w, a, y.w, b, z.w, out.w)
    combine(x.p, a, y.p, b, z.p, out.p)
    combine(x.gamma, a, y.gamma, b, z.gamma, out.gamma)
    combine(x.v, a, y.v, b, z.v, out.v)


@borrower()
def off_path(product, goal):
    """How far the products of a contact are from goal (1, e), relative to goal."""
    across = (product[1] - goal) ** 2
    for i in range(2, len(product)):
        across += product[i] * product[i]
    return max(abs(product[0] - goal), np.sqrt(across)) / goal


@kernel()
def path_directions(problem, work, cones, here, linear, level, tau, ways):
    """Fill ``back``, ``tangent`` and ``bend``; the products on the path are tau times ``level`` (C,)."""
    m, wanted, momentum = len(cones.m), linear.wanted, work.room
    missing_momentum(problem, here.v, momentum)
    add_generalised_impulse(problem, here.p, momentum)
    for c in range(len(level)):
        for i in range(m + 1):
            wanted[c, i] = (tau * level[c] if i < 2 else 0.0) - linear.product[c, i]
    interior_direction(problem, work, linear, ways.back)
    momentum[:] = 0.0
    for c in range(len(level)):
        for i in range(m + 1):
            wanted[c, i] = tau * level[c] if i < 2 else 0.0
        for i in range(m):
            linear.miss[c, i] = -tau * linear.far[c, i]
    interior_direction(problem, work, linear, ways.tangent)
    dw, dp, dgamma, _ = ways.tangent
    for c in range(len(level)):
        complementarity(dw[c], dp[c], dgamma[c], cones.mu[c], m, wanted[c])
        for i in range(m + 1):
            wanted[c, i] = -wanted[c, i]
        for i in range(m):
            linear.miss[c, i] = 0.0
    interior_direction(problem, work, linear, ways.bend)


@borrower()
def turn_across(ways, here, cones):
    """Turn ``back`` and ``bend`` across the tangent: this is what lets the path turn back. Returns the relative changes of tau in them."""
    back, tangent, bend = ways.back, ways.tangent, ways.bend
    length = 1.0 + way_product(tangent, tangent, here, cones)
    drop = -way_product(back, tangent, here, cones) / length
    curve = -way_product(bend, tangent, here, cones) / length
    combine_ways(back, drop, tangent, 0.0, tangent, back)
    combine_ways(bend, curve, tangent, 0.0, tangent, bend)
    return drop, curve


@kernel()
def step_ahead(here, ways, cones, level, tau, changes, wide):
    """ahead = back + h tangent + h^2 bend with the largest h of 2 (0.97 where tau falls), 3/4 of it, and so on, that stays inside the cones
    and near the path.

    ``changes`` are those of tau that go along, drop, sign and curve: drop + h sign + h^2 curve. Near: no product of a contact is off tau
    times its level by more than ``wide`` times that. The contact that forbade the last h is asked first, since it mostly forbids the next
    one too. Returns the relative change of tau.
    """
    (drop, sign, curve), contacts, room = changes, len(level), np.empty((3, len(cones.k)))
    h, again, change, forbids = (2.0 if sign > 0.0 else 0.97), 0, 0.0, True
    for turn in range(40):
        h *= 0.75 if turn > 0 else 1.0
        change = drop + h * sign + h * h * curve
        forbids = change <= -0.98
        if forbids:
            continue
        for k in range(contacts):
            c = again if k == 0 else (k - 1 if k <= again else k)
            if not _allows(here, ways, cones, c, (h * sign, h * h), tau * (1.0 + change) * level[c], wide, room):
                forbids, again = True, c
                break
        if not forbids:
            break
    combine_ways(ways.back, h * sign, ways.tangent, h * h, ways.bend, ways.ahead)
    return change


@borrower()
def _allows(here, ways, cones, c, along, goal, wide, room):
    """Whether contact c stays inside the cones, a little beyond the step too, and near the path with products of ``goal`` at its end.

    The step is back + along[0] tangent + along[1] bend; ``room`` (3, k) is scratch.
    """
    (back, tangent, bend, _), (first, second), m, mu = ways, along, len(cones.m), cones.mu[c]
    w, p, product = room[0], room[1], room[2]
    for i in range(m):
        w[i] = back.w[c, i] + first * tangent.w[c, i] + second * bend.w[c, i]
        p[i] = back.p[c, i] + first * tangent.p[c, i] + second * bend.p[c, i]
    turn = back.gamma[c] + first * tangent.gamma[c] + second * bend.gamma[c]
    if contact_step(here.w[c], here.p[c], here.gamma[c], w, p, turn, mu, m) <= BEYOND:
        return False
    for i in range(m):
        w[i] += here.w[c, i]
        p[i] += here.p[c, i]
    complementarity(w, p, here.gamma[c] + turn, mu, m, product)
    return off_path(product, goal) < wide


@kernel()
def choose_step(here, ways, cones, level, tau, sign, wide):
    """Fill ``ahead``: back to the path first, and along it from near; returns the relative change of tau, whose sign is given."""
    drop, curve = turn_across(ways, here, cones)
    longest = 0.9 * longest_step(here, ways.back, cones)
    if longest < 1.0:
        combine_ways(ways.back, longest - 1.0, ways.back, 0.0, ways.back, ways.ahead)
        return longest * drop
    return step_ahead(here, ways, cones, level, tau, (drop, sign, curve), wide)


@kernel()
def path_bodies(kind, problem, work, answer, settings):
    """The central path followed by its length over bodies, see interior.py, from near ``answer``, which gets better.

    Returns the iterations.
    """
    impulse, v, room = answer.impulse.copy(), answer.velocity.copy(), work.room
    cones, rows, shape = cones_of(problem.mu, problem.m, settings.k), v.shape, impulse.shape
    here, linear = allocate_iterate(shape, rows), allocate_linearisation(len(impulse), cones)
    back, tangent = allocate_iterate(shape, rows), allocate_iterate(shape, rows)
    ways = PathWays(back, tangent, allocate_iterate(shape, rows), allocate_iterate(shape, rows))
    # a point on the path at tau = 1, where w is off by far
    relative_velocity(problem, answer.velocity, linear.miss)
    shift = begin_inside(problem, answer, cones, settings.distance, here, linear.miss)
    level = shift * shift / problem.d
    body_velocity(problem, here.p, room, here.v)
    missing_velocity(problem, here, 0.0, linear)
    copy_flat(linear.miss, linear.far)
    soften(problem, settings.stiffness, linear)
    tau, iterations = 1.0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance:
        iterations += 1
        missing_velocity(problem, here, tau, linear)
        regular = linearise_products(cones, here, linear)
        sign = kind.factorise(problem, work, linear.gain)
        if not regular or sign == 0.0:
            break
        path_directions(problem, work, cones, here, linear, level, tau, ways)
        change = choose_step(here, ways, cones, level, tau, -sign, settings.wide)
        advance(here, 1.0, ways.ahead)
        tau *= 1.0 + change
        take_impulse(here.p, problem.mu, impulse)
        error = kind.map_norm(problem, impulse, room, v) / answer.size
        keep_better(answer, impulse, v, error)
        if not error < np.inf:
            break
    return iterations
