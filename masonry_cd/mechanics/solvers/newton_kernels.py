"""Semismooth Newton, over bodies and where W alone is given; see newton.py for the method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coulomb_law import tangent_length
from masonry_cd.mechanics.linalg.threads import take
from masonry_cd.mechanics.solvers.linearised import keep_better
from masonry_cd.mechanics.solvers.shares import copy_share


class LinearisedLaw(NamedTuple):
    """The law of each contact, linearised: p+ = target - block (u+ - u)."""

    target: np.ndarray  # (C, m) g
    block: np.ndarray  # (C, m, m) B
    m: tuple[int, ...]  # m zeros


class NewtonRoom(NamedTuple):
    """Where the iteration is, and where it goes back to if a step is refused."""

    p: np.ndarray  # (C, m) impulses
    v: np.ndarray  # their velocities
    hold: np.ndarray  # (C, m) the last that were accepted
    hold_v: np.ndarray


@kernel()
def allocate_newton(room, shape, rows):
    """:class:`NewtonRoom` for contacts (C, m) and velocities of a shape."""
    return NewtonRoom(take(room, shape), take(room, rows), take(room, shape), take(room, rows))


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
def damp(new: float, error: float, first: bool, stiffness: float) -> tuple[bool, float]:
    """Whether a Newton step that changed the error so is accepted, and the stiffness of the next one."""
    if not (new < 1.5 * error or (first and new < np.inf)):
        return False, 0.125 * stiffness
    if new < 0.7 * error:
        return True, min(4.0 * stiffness, 1e8)
    return True, 2.0 * stiffness if new <= error else 0.5 * stiffness


@kernel()
def newton(take_step, shares, problem, work, law, inside, answer, settings):
    """Semismooth Newton from ``answer`` on, which gets better.

    ``take_step`` takes impulses p and their velocities v to those that solve the problem with its law linearised there at a stiffness, and
    returns the norm of the natural map, which is infinite if there are none; ``law`` is its room for that, ``inside`` a
    :class:`NewtonRoom`. Returns iterations, the error at the start, and the stiffness at the end.
    """
    p, v, hold, hold_v = inside
    copy_share(shares.contacts, answer.impulse, p)
    copy_share(shares.rows, answer.velocity, v)
    copy_share(shares.contacts, answer.impulse, hold)
    copy_share(shares.rows, answer.velocity, hold_v)
    error = begin = answer.error[0]
    stiffness, iterations, refused = settings.stiffness, 0, 0
    while iterations < settings.limit and answer.error[0] > settings.tolerance and refused < 8:
        iterations += 1
        new = take_step(shares, problem, work, law, stiffness, p, v) / answer.size
        accepted, stiffness = damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            copy_share(shares.contacts, p, hold)
            copy_share(shares.rows, v, hold_v)
        else:
            refused += 1
            copy_share(shares.contacts, hold, p)
            copy_share(shares.rows, hold_v, v)
        keep_better(shares, answer, p, v, error)
    return iterations, begin, stiffness
