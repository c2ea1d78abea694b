"""The interior point method over bodies, and the four methods that linearise the law behind one entry; see interior.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.operators import (
    ProblemArrays,
    add_generalised_impulse,
    body_velocity,
    in_order,
    map_norm,
    missing_momentum,
    put_back,
)
from masonry_cd.jit import borrower, entry, kernel
from masonry_cd.linalg.inertia import determinant_sign
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.supernodes import allocate_factors, allocate_matrix
from masonry_cd.solvers.central_path import (
    STIFFEST,
    advance,
    allocate_iterate,
    allocate_linearisation,
    begin_inside,
    complementarity,
    cones_of,
    interior_direction,
    linearise_products,
    longest_step,
    missing_velocity,
    soften,
    take_impulse,
)
from masonry_cd.solvers.linearised import Elimination, Settings, augment_blocks, first_answer, keep_better
from masonry_cd.solvers.newton_kernels import newton_bodies
from masonry_cd.solvers.path_kernels import path_bodies
from masonry_cd.solvers.proximal_kernels import proximal_bodies

NEWTON, INTERIOR, PATH, PROXIMAL = 0, 1, 2, 3  # methods that linearise the law


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
def predict_and_correct(problem, factor, cones, here, linear, momentum, step, way):
    """Predictor, then corrector with the centring that the predictor asks for; a corrector that leads nowhere is left out.

    ``step`` is the last one, ``momentum`` (B + 1, n) room. Returns the longest step along the direction that stays inside the cones.
    """
    missing_momentum(problem, here.v, momentum)
    add_generalised_impulse(problem, here.p, momentum)
    gap, undone = mean_product(linear), mean_miss(here, linear)
    centring, longest = 0.0, 0.0
    for turn in range(3):
        if turn == 2 and longest >= 0.1:
            break
        corrector_rhs(cones, way, linear, centring * gap, turn == 1)
        interior_direction(problem, factor, momentum, linear, way)
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
def interior_bodies(problem, matrix, factor, answer, settings):
    """Interior point method over an OrderedProblem, see interior.py, from near ``answer``, which gets better; returns the iterations."""
    impulse, v, room = answer.impulse.copy(), np.zeros(answer.velocity.shape), np.empty(answer.velocity.shape)
    cones = cones_of(problem.mu, problem.m, settings.k)
    here, way = allocate_iterate(impulse.shape, v.shape), allocate_iterate(impulse.shape, v.shape)
    linear = allocate_linearisation(len(impulse), cones)
    begin_inside(problem, answer, cones, settings.distance, here, linear.miss)
    step, stiffness, iterations, short = 1.0, settings.stiffness, 0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance and short < 6:
        iterations += 1
        missing_velocity(problem, here, 0.0, linear)
        soften(problem, stiffness, linear)
        regular = linearise_products(cones, here, linear)
        augment_blocks(problem, linear.gain, matrix)
        if not (regular and factorise_ldu(matrix, factor) and mean_product(linear) > 0.0):
            break
        if determinant_sign(factor) < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        step = min(1.0, 0.99 * predict_and_correct(problem, factor, cones, here, linear, room, step, way))
        advance(here, step, way)
        short = short + 1 if step < 0.02 else 0
        stiffness = stiffness_after(step, stiffness)
        take_impulse(here.p, problem.mu, impulse)
        body_velocity(problem, impulse, room, v)
        error = map_norm(problem, impulse, v) / answer.size
        keep_better(answer, impulse, v, error)
        if not error < np.inf:
            break
    return iterations


@entry()
def linearised_bodies(
    method: int, problem: ProblemArrays, elimination: Elimination, settings: Settings, impulse: np.ndarray, velocity: np.ndarray
) -> tuple[int, float, float, float]:
    """One of these methods over ProblemArrays. ``impulse`` (C, m) holds the start and then the best answer found, velocity (B, n) its own.

    Python enters here alone, so that their factorisation, the larger part of each, is compiled once. Returns iterations, natural map
    error, and of Newton the error at the start and the stiffness at the end.
    """
    symbolic = elimination.symbolic
    ordered = in_order(problem, elimination.order, elimination.places, elimination.block)
    matrix, factor = allocate_matrix(symbolic, problem.n), allocate_factors(symbolic, problem.n)
    answer, begin, stiffness = first_answer(ordered, impulse), np.nan, settings.stiffness
    if method == NEWTON:
        iterations, begin, stiffness = newton_bodies(ordered, matrix, factor, answer, settings)
    elif method == INTERIOR:
        iterations = interior_bodies(ordered, matrix, factor, answer, settings)
    elif method == PATH:
        iterations = path_bodies(ordered, matrix, factor, answer, settings)
    else:
        iterations = proximal_bodies(ordered, matrix, factor, answer, settings)
    put_back(answer.velocity, elimination.order, velocity)
    return iterations, answer.error[0], begin, stiffness
