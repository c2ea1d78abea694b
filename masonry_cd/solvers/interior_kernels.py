"""The interior point method, over bodies and where W alone is given; see interior.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import borrower, kernel
from masonry_cd.solvers.central_path import (
    STIFFEST,
    advance,
    allocate_iterate,
    allocate_linearisation,
    begin_inside,
    complementarity,
    cones_of,
    linearise_products,
    longest_step,
    soften,
    take_impulse,
)
from masonry_cd.solvers.linearised import keep_better


@borrower()
def mean_product(linear):
    """How far the products are from zero: the gap tau, mean over the contacts."""
    gap, contacts = 0.0, len(linear.product)
    for c in range(contacts):
        gap += 0.5 * (linear.product[c, 0] + linear.product[c, 1]) / contacts
    return gap


@borrower()
def mean_miss(here, linear):
    """What w misses, in the units of the gap."""
    undone, contacts = 0.0, len(linear.miss)
    for c in range(contacts):
        for i in range(linear.miss.shape[1]):
            undone += abs(linear.miss[c, i] * here.p[c, i]) / contacts
    return undone


@borrower()
def corrector_rhs(cones, way, linear, target, second):
    """The changes of the products that lead to ``target``, with the second order of the last direction if ``second`` is set."""
    m, k, wanted = len(cones.m), len(cones.k), linear.wanted
    for c in range(len(cones.mu)):
        if second:
            complementarity(way.w[c], way.p[c], way.gamma[c], cones.mu[c], m, wanted[c])
        for i in range(k):
            wanted[c, i] = (target if i < 2 else 0.0) - linear.product[c, i] - (wanted[c, i] if second else 0.0)


@borrower()
def centring_share(cones, way, linear, gap, undone, longest, step):
    """Share of the gap to aim at, from what the predictor would leave of it, and more after a short step; uses ``wanted`` up.

    ``undone`` measures what w misses in the units of the gap: the gap is not to vanish before it.
    """
    contacts, ahead, reach, room = len(cones.mu), 0.0, min(1.0, longest), linear.wanted
    for c in range(contacts):
        complementarity(way.w[c], way.p[c], way.gamma[c], cones.mu[c], len(cones.m), room[c])
        ahead += 0.5 * (1.0 - reach) * (linear.product[c, 0] + linear.product[c, 1]) / contacts
        ahead += 0.5 * reach * reach * (room[c, 0] + room[c, 1]) / contacts
    left = max(min(1.0, max(ahead / gap, 0.0)) ** 3, min(1.0, 0.3 * undone / gap))
    return max(left, 1e-6 if step > 0.2 else (0.5 if step > 0.05 else 1.0))


@kernel()
def predict_and_correct(kind, problem, work, cones, here, linear, step, way):
    """Predictor, then corrector with the centring that the predictor asks for; a corrector that leads nowhere is left out.

    ``step`` is the last one. Returns the longest step along the direction that stays inside the cones.
    """
    gap, undone = mean_product(linear), mean_miss(here, linear)
    centring, longest = 0.0, 0.0
    for turn in range(3):
        if turn == 2 and longest >= 0.1:
            break
        corrector_rhs(cones, way, linear, centring * gap, turn == 1)
        kind.interior_direction(problem, work, linear, way)
        longest = longest_step(here, way, cones)
        if turn == 0:
            centring = centring_share(cones, way, linear, gap, undone, longest, step)
    return longest


@borrower()
def stiffness_after(step, stiffness):
    """Long steps can do with stiffer contacts, short ones need softer."""
    if step > 0.5:
        return min(4.0 * stiffness, STIFFEST)
    return max(0.25 * stiffness, 1.0) if step < 0.1 else stiffness


@kernel()
def interior_point(kind, problem, work, answer, settings):
    """Interior point method with the operators of a :class:`Kind`, from near ``answer``, which gets better; returns the iterations."""
    impulse, v, room = answer.impulse.copy(), answer.velocity.copy(), work.room
    cones = cones_of(problem.mu, problem.m, settings.k)
    here, way = allocate_iterate(impulse.shape, v.shape), allocate_iterate(impulse.shape, v.shape)
    linear = allocate_linearisation(len(impulse), cones)
    kind.contact_velocity(problem, v, linear.miss)
    begin_inside(problem, answer, cones, settings.distance, here, linear.miss)
    step, stiffness, iterations, short = 1.0, settings.stiffness, 0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance and short < 6:
        iterations += 1
        kind.interior_residuals(problem, here, linear, room)
        soften(problem, stiffness, linear)
        regular = linearise_products(cones, here, linear)
        if not (regular and mean_product(linear) > 0.0):
            break
        sign = kind.factorise(problem, work, linear.gain)
        if sign == 0.0:
            break
        if sign < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        step = min(1.0, 0.99 * predict_and_correct(kind, problem, work, cones, here, linear, step, way))
        advance(here, step, way)
        short = short + 1 if step < 0.02 else 0
        stiffness = stiffness_after(step, stiffness)
        take_impulse(here.p, problem.mu, impulse)
        error = kind.map_norm(problem, impulse, room, v) / answer.size
        keep_better(answer, impulse, v, error)
        if not error < np.inf:
            break
    return iterations
