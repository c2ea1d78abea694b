"""Semismooth Newton over bodies; see newton.py for the method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction.coulomb_law import tangent_length
from masonry_cd.friction.operators import add_generalised_impulse, body_velocity, change_at, law_velocity, map_norm, missing_momentum
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat, invert, multiply
from masonry_cd.linalg.triangular import solve_ldu
from masonry_cd.solvers.linearised import augment_blocks, keep_better


class LinearisedLaw(NamedTuple):
    """The law of each contact, linearised: p+ = target - block (u+ - u)."""

    target: np.ndarray  # (C, m) g
    block: np.ndarray  # (C, m, m) B
    m: tuple[int, ...]  # m zeros


@borrower()
def linearise_law(p, u, mu, d, stiffness, law, c):
    """Linearise the law of contact c for contact stiffness ``stiffness`` / d, see newton.py; p and u have 3 components, in a plane too."""
    (pn, p1, p2), (un, u1, u2) = p, u
    m, target, block = len(law.m), law.target, law.block
    spatial = m == 3
    for i in range(m):
        target[c, i] = 0.0
        for j in range(m):
            block[c, i, j] = 0.0
    xn, x1, x2 = pn - un / d, p1 - u1 / d, p2 - u2 / d
    if xn <= 0.0:
        return
    kappa = stiffness / d
    length = tangent_length(x1, x2)
    target[c, 0] = pn - kappa * un
    block[c, 0, 0] = kappa
    if length <= mu * xn:
        target[c, 1], block[c, 1, 1] = p1 - kappa * u1, kappa
        if spatial:
            target[c, 2], block[c, 2, 2] = p2 - kappa * u2, kappa
        return
    e1, e2 = x1 / length, x2 / length
    target[c, 1], block[c, 1, 0] = mu * e1 * target[c, 0], mu * e1 * kappa
    if spatial:  # across the slip the direction of friction turns with the velocity
        share = mu * xn / length
        beta = min(share / (d * max(1.0 - share, 1e-12)), kappa)
        across = u2 * e1 - u1 * e2
        target[c, 2], block[c, 2, 0] = mu * e2 * target[c, 0], mu * e2 * kappa
        target[c, 1] += beta * across * e2
        target[c, 2] -= beta * across * e1
        block[c, 1, 1], block[c, 1, 2], block[c, 2, 1], block[c, 2, 2] = beta * e2 * e2, -beta * e1 * e2, -beta * e1 * e2, beta * e1 * e1


@borrower()
def in_series(block, compliance, share, softer, work, size_m):
    """Put the contact's own spring in series with a linearised law p+ - p = r - B (w+ - w), where w+ - w = u+ - u + C (p+ - p).

    share = (I + B C)^-1 leaves p+ - p = share r - softer (u+ - u), softer = share B. False if it is singular.
    """
    m = len(size_m)
    for i in range(m):
        for j in range(m):
            softer[i, j] = block[i, j] * compliance[j] + (1.0 if i == j else 0.0)
    regular = invert(softer, share, work, size_m)
    multiply(share, block, False, softer, size_m)
    return regular


@borrower()
def take_share(share, target, p0, p1, p2, size_m):
    """target <- p + share (target - p)."""
    m = len(size_m)
    r0, r1, r2 = target[0] - p0, target[1] - p1, target[m - 1] - p2 if m == 3 else 0.0
    for i in range(m):
        target[i] = (p0, p1, p2)[i] + share[i, 0] * r0 + share[i, 1] * r1 + share[i, m - 1] * r2


@borrower()
def damp(new: float, error: float, first: bool, stiffness: float) -> tuple[bool, float]:
    """Whether a Newton step that changed the error so is accepted, and the stiffness of the next one."""
    if not (new < 1.5 * error or (first and new < np.inf)):
        return False, 0.125 * stiffness
    if new < 0.7 * error:
        return True, min(4.0 * stiffness, 1e8)
    return True, 2.0 * stiffness if new <= error else 0.5 * stiffness


@kernel()
def linearise_contacts(problem, p, w, stiffness, law):
    """Linearise the law of all contacts at impulses p and velocities w (C, m), see :class:`LinearisedLaw`."""
    m, mu, d, compliance = len(problem.m), problem.mu, problem.d, problem.compliance
    share, softer, work = np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    for c in range(len(p)):
        p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
        linearise_law((p[c, 0], p[c, 1], p2), (w[c, 0], w[c, 1], w2), mu[c], d[c], stiffness, law, c)
        if len(compliance):
            in_series(law.block[c], compliance[c], share, softer, work, problem.m)
            take_share(share, law.target[c], p[c, 0], p[c, 1], p2, problem.m)
            copy_flat(softer, law.block[c])


@kernel()
def take_newton_step(problem, factor, law, p, v, room):
    """Impulses p and velocities v <- those that solve the linearised problem, by the factors of M + H^T B H; ``room`` (B + 1, n)."""
    m, n = len(problem.m), len(problem.n)
    missing_momentum(problem, v, room)
    add_generalised_impulse(problem, law.target, room)
    solve_ldu(factor, room)
    room[-1] = 0.0
    jacobian, index, target, block = problem.jacobian, problem.places, law.target, law.block
    for c in range(len(p)):
        for i in range(m):
            p[c, i] = target[c, i]
        for i in range(m):
            change = change_at(jacobian, index, c, i, room, n)
            for k in range(m):
                p[c, k] -= block[c, k, i] * change
    body_velocity(problem, p, room, v)


@kernel()
def newton_bodies(problem, matrix, factor, answer, settings):
    """Semismooth Newton over an OrderedProblem, see newton.py, from ``answer`` on, which gets better.

    Returns iterations, the error at the start, and the stiffness at the end.
    """
    p, v = answer.impulse.copy(), answer.velocity.copy()
    hold, hold_v, w, room = p.copy(), v.copy(), np.empty(p.shape), np.empty(v.shape)
    law = LinearisedLaw(np.empty(p.shape), np.empty((len(p), len(problem.m), len(problem.m))), problem.m)
    error = begin = answer.error[0]
    stiffness, iterations, refused = settings.stiffness, 0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance and refused < 8:
        law_velocity(problem, v, p, w)
        linearise_contacts(problem, p, w, stiffness, law)
        augment_blocks(problem, law.block, matrix)
        iterations += 1
        new = np.inf
        if factorise_ldu(matrix, factor):
            take_newton_step(problem, factor, law, p, v, room)
            new = map_norm(problem, p, v) / answer.size
        accepted, stiffness = damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            copy_flat(p, hold)
            copy_flat(v, hold_v)
        else:
            refused += 1
            copy_flat(hold, p)
            copy_flat(hold_v, v)
        keep_better(answer, p, v, error)
    return iterations, begin, stiffness
