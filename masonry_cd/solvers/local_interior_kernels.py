"""Interior point and proximal points for problems given by W alone.

In the impulses instead of the velocities: a step solves (I + S W) dp = r, S one block per contact. The problems come scaled, so that
trace(W_cc) = m; then the centring treats all contacts alike.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.local_operators import LocalArrays, delassus_product, local_norm, place_blocks
from masonry_cd.friction.natural_map import size_of
from masonry_cd.jit import borrower, entry, kernel
from masonry_cd.linalg.inertia import determinant_sign
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.single_columns import UNSYMMETRIC
from masonry_cd.linalg.small_blocks import copy_flat
from masonry_cd.linalg.supernodes import allocate_factors, allocate_matrix
from masonry_cd.linalg.symbolic import SymbolicFactor
from masonry_cd.linalg.triangular import solve_ldu
from masonry_cd.solvers.central_path import (
    advance,
    allocate_iterate,
    allocate_linearisation,
    central_start,
    cones_of,
    linearise_products,
    longest_step,
    start_direction,
    take_impulse,
)
from masonry_cd.solvers.interior_kernels import centring_share, corrector_rhs, mean_miss, mean_product, stiffness_after
from masonry_cd.solvers.linearised import Settings, largest
from masonry_cd.solvers.proximal_kernels import (
    FOLDS,
    FREE,
    HELD,
    add_step,
    allocate_springs,
    first_change,
    project_trial,
    spring_block,
    stiffness_after_springs,
)

MOST_LOCAL = 60  # iterations for one problem with springs


@kernel()
def factorise_local(problem, blocks, symbolic, matrix, factor):
    """Factorise I + S W, S the first rows of ``blocks`` (C, m or more, m). False if that fails."""
    place_blocks(problem, blocks, symbolic, UNSYMMETRIC, matrix)
    for i in range(len(problem.place)):
        for r in range(len(problem.m)):
            matrix.diagonal[i, r, r] += 1.0
    return factorise_ldu(matrix, factor)


@kernel()
def solve_local(problem, factor, right, x):
    """x <- (I + S W)^-1 x, by contact; right (C, m) is room for x in the order of elimination."""
    m, place = len(problem.m), problem.place
    for c in range(len(place)):
        for i in range(m):
            right[place[c], i] = x[c, i]
    solve_ldu(factor, right)
    for c in range(len(place)):
        for i in range(m):
            x[c, i] = right[place[c], i]


@borrower()
def missing_velocity_local(problem, here, linear):
    """What w misses, W p + q - w."""
    delassus_product(problem, here.p, linear.miss)
    for c in range(len(here.p)):
        for i in range(len(problem.m)):
            linear.miss[c, i] += problem.q[c, i] - here.w[c, i]


@kernel()
def interior_direction_local(problem, factor, linear, right, way):
    """The direction that changes the products as wanted and takes the other residual away; ``right`` (C, m) is room."""
    m, k = len(problem.m), linear.product.shape[1]
    start_direction(linear, way, m, k)
    solve_local(problem, factor, right, way.p)
    delassus_product(problem, way.p, way.w)
    for c in range(len(way.p)):
        for j in range(m):
            way.gamma[c] -= linear.gain[c, m, j] * way.w[c, j]
        for i in range(m):
            way.w[c, i] += linear.miss[c, i] + linear.soft[c, i] * way.p[c, i]


@kernel()
def predict_and_correct_local(problem, factor, cones, here, linear, right, step, way):
    """:func:`predict_and_correct` in the impulses; ``right`` (C, m) is room."""
    gap, undone = mean_product(linear), mean_miss(here, linear)
    centring, longest = 0.0, 0.0
    for turn in range(3):
        if turn == 2 and longest >= 0.1:
            break
        corrector_rhs(cones, way, linear, centring * gap, turn == 1)
        interior_direction_local(problem, factor, linear, right, way)
        longest = longest_step(here, way, cones)
        if turn == 0:
            centring = centring_share(cones, way, linear, gap, undone, longest, step)
    return longest


@entry()
def interior_local(problem: LocalArrays, symbolic: SymbolicFactor, settings: Settings, impulse: np.ndarray) -> tuple[int, float]:
    """Interior point method over scaled LocalArrays, as :func:`interior_bodies`: (I + G W) dp = r, G the first rows of the gains.

    impulse holds the start and then the best answer found. Returns iterations and natural map error.
    """
    contacts, m, cones = len(impulse), len(problem.m), cones_of(problem.mu, problem.m, settings.k)
    matrix, factor = allocate_matrix(symbolic, problem.m), allocate_factors(symbolic, problem.m)
    rows = impulse[:0].shape  # no bodies
    here, way = allocate_iterate(impulse.shape, rows), allocate_iterate(impulse.shape, rows)
    linear, u, right = allocate_linearisation(contacts, cones), np.empty(impulse.shape), np.empty(impulse.shape)
    size, shift, best = size_of(problem.q, problem.d), settings.distance * largest(problem.q), impulse.copy()
    smallest = local_norm(problem, best, u) / size
    for c in range(contacts):
        here.gamma[c] = central_start(best[c], u[c], cones.mu[c], 1.0, shift, here.w[c], here.p[c], m)
    step, stiffness, iterations, short = 1.0, settings.stiffness, 0, 0
    while iterations < settings.limit and smallest > settings.tolerance and short < 6:
        iterations += 1
        missing_velocity_local(problem, here, linear)
        linear.soft[:] = 1.0 / stiffness
        regular = linearise_products(cones, here, linear)
        if not (mean_product(linear) > 0.0 and regular) or not factorise_local(problem, linear.gain, symbolic, matrix, factor):
            break
        if determinant_sign(factor) < 0.0 and stiffness > 1.0:
            stiffness = max(0.1 * stiffness, 1.0)  # beyond a turning point of the path
            continue
        step = min(1.0, 0.99 * predict_and_correct_local(problem, factor, cones, here, linear, right, step, way))
        advance(here, step, way)
        short = short + 1 if step < 0.02 else 0
        stiffness = stiffness_after(step, stiffness)
        take_impulse(here.p, problem.mu, impulse)
        error = local_norm(problem, impulse, u) / size
        if error < smallest:
            smallest = error
            copy_flat(impulse, best)
        if not error < np.inf:
            break
    copy_flat(best, impulse)
    return iterations, smallest


@borrower()
def spring_residual_local(problem, springs, stiffness, u, held, out):
    """Fill x and p of the springs at velocities u (C, m), and out = W p + q - u (C, m); returns its norm."""
    m, total, x = len(problem.m), 0.0, springs.x
    for c in range(len(u)):
        for i in range(m):
            x[c, i] = springs.centre[c, i] - stiffness * u[c, i]
        project_trial(springs, problem.mu, c, held, m)
    delassus_product(problem, springs.p, out)
    for c in range(len(u)):
        for i in range(m):
            out[c, i] += problem.q[c, i] - u[c, i]
            total += out[c, i] * out[c, i]
    return np.sqrt(total)


@kernel()
def spring_direction_local(problem, factor, springs, out, right, change):
    """The Newton step of u, du = r + W dp with (I + B W) dp = -B r, r = ``out`` (C, m); ``right`` (C, m) is room."""
    m = len(problem.m)
    for c in range(len(out)):
        for i in range(m):
            change[c, i] = 0.0
            for j in range(m):
                change[c, i] -= springs.block[c, i, j] * out[c, j]
    solve_local(problem, factor, right, change)  # that of p
    delassus_product(problem, change, right)
    for c in range(len(out)):
        for i in range(m):
            change[c, i] = out[c, i] + right[c, i]


@borrower()
def shorten_step_local(problem, springs, stiffness, u, norm, change, trial, out):
    """:func:`shorten_step` in the velocities u (C, m) of the contacts."""
    step, new = 2.0, np.inf
    while not new < (1.0 - 0.1 * step) * norm and step > 0.1:
        step *= 0.5
        add_step(u, step, change, trial)
        new = spring_residual_local(problem, springs, stiffness, trial, FREE, out)
    return new, new < (1.0 - 0.1 * step) * norm


@borrower()
def turn_first_local(problem, springs, stiffness, u, change, out):
    """:func:`turn_first` in the velocities u (C, m) of the contacts."""
    copy_flat(springs.held, springs.status)
    spring_residual_local(problem, springs, stiffness, u, HELD, out)
    for c in range(len(u)):
        for i in range(len(problem.m)):
            springs.dx[c, i] = -stiffness * change[c, i]
    step, which, other = first_change(problem.mu, springs.status, springs.x, springs.dx, problem.m)
    if step < 1.0:
        springs.status[which] = other
    add_step(u, min(step, 0.5) if step >= 1.0 else step, change, u)
    return spring_residual_local(problem, springs, stiffness, u, HELD, out), which, step


@kernel()
def settle_springs_local(problem, symbolic, matrix, factor, springs, stiffness, goal, most, u):
    """:func:`settle_springs` in the velocities u (C, m) of the contacts, from those given."""
    out, change, trial, right = np.empty(u.shape), np.empty(u.shape), np.empty(u.shape), np.empty(u.shape)
    norm = spring_residual_local(problem, springs, stiffness, u, FREE, out)
    spent, turned, last = 0, 0, -1
    while norm > goal and spent < most and turned < FOLDS:
        for c in range(len(u)):
            spring_block(springs, problem.mu[c], 1.0 / stiffness, 1.0 / stiffness, c, problem.m)
        spent += 1
        if not factorise_local(problem, springs.block, symbolic, matrix, factor):
            break
        spring_direction_local(problem, factor, springs, out, right, change)
        copy_flat(springs.status, springs.held)
        new, enough = shorten_step_local(problem, springs, stiffness, u, norm, change, trial, out)
        if enough:
            copy_flat(trial, u)
            norm, last, turned = new, -1, 0
            continue
        norm, which, step = turn_first_local(problem, springs, stiffness, u, change, out)
        if step < 1.0:
            turned, last = turned + 1 if which == last and step < 1e-9 else 0, which
    return norm <= goal, spent


@entry()
def proximal_local(problem: LocalArrays, symbolic: SymbolicFactor, settings: Settings, p: np.ndarray) -> tuple[int, float]:
    """Proximal points over scaled LocalArrays, as :func:`proximal_bodies` but in u: du = r + W dp, (I + B W) dp = -B r, r = W p + q - u.

    p holds the start and then the best answer found. Returns iterations (one factorisation each) and natural map error.
    """
    matrix, factor = allocate_matrix(symbolic, problem.m), allocate_factors(symbolic, problem.m)
    u, trial, springs, size = np.empty(p.shape), np.empty(p.shape), allocate_springs(p), size_of(problem.q, problem.d)
    smallest = error = local_norm(problem, p, u) / size
    centre_u = u.copy()
    stiffness = min(max(1.0 / max(error, 1e-300), 1e2), 1e6)
    iterations, failed = 0, 0
    while iterations < settings.limit and smallest > settings.tolerance and failed < 16:
        goal = size * max(1e-2 * error, 1e-3 * settings.tolerance)  # a hundredth of the error
        copy_flat(centre_u, u)
        most = min(settings.limit - iterations, MOST_LOCAL)
        solved, spent = settle_springs_local(problem, symbolic, matrix, factor, springs, stiffness, goal, most, u)
        iterations += spent
        new = local_norm(problem, springs.p, trial) / size
        if not solved and not new < error:
            stiffness, failed = max(0.125 * stiffness, 1.0), failed + 1
            continue
        stiffness = stiffness_after_springs(stiffness, solved, spent, new > 0.5 * error)
        error = new
        stiffness = min(stiffness, max(1e13 * error, 1e4))  # or else rounding, EPSILON times it, shows
        copy_flat(springs.p, springs.centre)
        copy_flat(u, centre_u)
        if error < smallest:
            smallest = error
            copy_flat(springs.p, p)
    return iterations, smallest
