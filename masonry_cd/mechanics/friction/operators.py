# SPDX-License-Identifier: GPL-3.0-or-later
r"""The operators of a friction problem: u = H v + b, G p, M^-1, the scales d, and the residual of the natural map.

    M (v - v_free) = G p,     w = H v + b + C p,     W = H M^-1 G.

Over bodies G = H^T, and M has a block for each of them. A problem given by W alone has a body for each contact, whose velocity is that of
the contact: H = I, M = D^-1 with the d of the contacts for its diagonal, and G = D^-1 W by sparse blocks, see coupling.py.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.contact_geometry import (
    BY_ROWS,
    Geometry,
    add_impulse_of_side,
    trace_by_arms,
    velocity_of_side,
)
from masonry_cd.mechanics.friction.coupling import Coupling, add_coupled, is_coupled
from masonry_cd.mechanics.friction.natural_map import squared_residual
from masonry_cd.mechanics.linalg.intrinsics import is_tuple
from masonry_cd.mechanics.linalg.small_blocks import add_outer_product, invert, is_wide
from masonry_cd.mechanics.linalg.threads import take
from masonry_cd.mechanics.linalg.triples import inner, plus, times
from masonry_cd.mechanics.linalg.wide_blocks import add_squares


class ProblemArrays(NamedTuple):
    """A friction problem as the kernels take it: contiguous arrays of C contacts with m rows each and B free bodies with n unknowns each.

    The supports are one more body, the last, whose velocity is zero. Bodies are in their own order or, for the solvers that factorise, in
    one of elimination.
    """

    inverse: np.ndarray  # (B, n, n) M^-1
    mass: np.ndarray  # (B, n, n) M; (0, n, n) in their own order
    free: np.ndarray  # (B, n) v_free
    places: np.ndarray  # (C, 2) places of the bodies; B: a support
    block: np.ndarray  # (C,) the block of M + H^T R H that couples them, below the diagonal; -1: none; (0,) in their own order
    geometry: Geometry
    offset: np.ndarray  # (C, m)
    mu: np.ndarray  # (C,)
    compliance: np.ndarray  # (C, m); (0, m) where all contacts are rigid
    width: np.ndarray  # (B + 1,) unknowns of a body of unit mass, none of the supports, see condensation.py; (0,): each has n
    d: np.ndarray  # (C,) trace(W_cc + C_cc) / m
    coupling: Coupling
    m: tuple[int, ...]  # m zeros, see small_blocks.py
    n: Any  # n zeros, a tuple; an array where contacts have rows of H


class Elimination(NamedTuple):
    """An order in which B bodies are eliminated, and where C contacts are in it."""

    order: np.ndarray  # (B,) body at each place
    places: np.ndarray  # (C, 2) places of the bodies of each contact; B: a support
    block: np.ndarray  # (C,) the block of the matrix that couples them, below the diagonal; -1: none


@kernel()
def room_in_order(arena, given, elimination, coupling):
    """A problem with its bodies in order of elimination and a coupling, and room for what :func:`put_in_order` fills."""
    (count, n), (order, places, block), width = given.free.shape, elimination, given.width
    if has_unit_masses(given):
        width = np.zeros(count + 1, dtype=np.int64)
        for b in range(count):
            width[b] = given.width[order[b]]
    return ProblemArrays(
        take(arena, (count, n, n)), take(arena, (count, n, n)), take(arena, (count, n)), places, block, given.geometry, given.offset,
        given.mu, given.compliance, width, given.d, coupling, given.m, given.n,
    )  # fmt: skip


@kernel()
def put_in_order(given, order, first, end, ordered):
    """M^-1, M and v_free of the bodies at places first to end of an order, into the problem in that order; unit masses nobody reads."""
    inverse, mass, free, n = ordered.inverse, ordered.mass, ordered.free, len(given.n)
    work = np.empty((n, n))
    for b in range(first, end):
        for i in range(n):
            free[b, i] = given.free[order[b], i]
        if has_unit_masses(given):
            continue
        coupled = False
        for i in range(n):
            for j in range(n):
                inverse[b, i, j] = given.inverse[order[b], i, j]
                mass[b, i, j] = 0.0
                coupled = coupled or (i != j and inverse[b, i, j] != 0.0)
        if coupled:
            invert(inverse[b], n, mass[b], work, given.n)
        else:  # as in a plane
            for i in range(n):
                mass[b, i, i] = 1.0 / inverse[b, i, i]


@entry(fastmath={"contract"})
def fill_places_and_scales(bodies: np.ndarray, problem: ProblemArrays) -> None:
    """Fill the places of the bodies (C, 2), -1 for a support, of all contacts, and d_c = trace(W_cc + C_cc) / m."""
    compliance, m = problem.compliance, len(problem.m)
    for c in range(len(problem.d)):
        for side in range(2):
            problem.places[c, side] = bodies[c, side] if bodies[c, side] >= 0 else len(problem.free)
        trace = trace_of_contact(problem, c, problem.places[c, 0], problem.places[c, 1])
        if len(compliance):
            for i in range(m):
                trace += compliance[c, i]
        problem.d[c] = trace / m


@kernel(inline="always")
def trace_of_contact(problem, c, a, b):
    """trace(W_cc) of contact c, between the bodies at the places a and b, those of supports after all."""
    if has_unit_masses(problem):
        return unit_delassus_trace(problem, c, a, b)
    if has_arms(problem):
        return trace_by_arms(form_of_problem(problem), problem.inverse, problem.geometry, c, a, b)
    inverse, jacobian, n, trace = problem.inverse, problem.geometry.jacobian, len(problem.n), 0.0
    for side in range(2):
        body = b if side else a
        if body == len(inverse):
            continue
        for i in range(len(problem.m)):
            for k in range(n):
                total = 0.0
                for l in range(n):  # noqa: E741
                    total += inverse[body, k, l] * jacobian[c, side, i, l]
                    if a == b:
                        total += inverse[body, k, l] * jacobian[c, 1 - side, i, l]
                trace += total * jacobian[c, side, i, k]
    return trace


@borrower(fastmath={"contract"})
def unit_delassus_trace(problem, c, a, b):
    """:func:`trace_of_contact` for bodies of unit mass."""
    jacobian, trace = problem.geometry.jacobian, 0.0
    for side in range(2):
        body = b if side else a
        for i in range(len(problem.m)):
            for k in range(problem.width[body]):
                other = jacobian[c, 1 - side, i, k] if a == b else 0.0
                trace += jacobian[c, side, i, k] * (jacobian[c, side, i, k] + other)
    return trace


@borrower(forceinline=True)
def has_unit_masses(problem):
    """Return True if bodies have unit masses, and ``width`` says how many unknowns; known to be false where blocks are not wide."""
    return is_wide(problem.n) and len(problem.width) > 0


@borrower(forceinline=True)
def unknowns_at(problem, a, b):
    """Unknowns that the bodies at two places have, the more of both."""
    return max(problem.width[a], problem.width[b]) if has_unit_masses(problem) else len(problem.n)


@borrower()
def load_mass(problem, b, blocks):
    """Write M of the body at place b into its block of ``blocks`` (B or more, n, n)."""
    for i in range(len(problem.n)):
        for j in range(len(problem.n)):
            if has_unit_masses(problem):
                blocks[b, i, j] = 1.0 if i == j else 0.0
            else:
                blocks[b, i, j] = problem.mass[b, i, j]


@borrower(forceinline=True)
def add_product(problem, x, y, rows, one, other, out):
    """out (n, n) += x^T y of some rows of the bodies at two places, as far as these have unknowns; narrow ones are of one contact."""
    if is_wide(problem.n):
        add_squares(1.0, x, True, y, rows, (unknowns_at(problem, one, one), unknowns_at(problem, other, other)), out)
    else:
        add_outer_product(x, y, out, problem.m, problem.n)


@borrower(forceinline=True)
def has_arms(problem):
    """True if contacts have frames and arms, which the type of n tells the compiler."""
    return is_tuple(problem.n)


@borrower(forceinline=True)
def form_of_problem(problem):
    """The form of the contacts, see contact_geometry.py."""
    return len(problem.m) if has_arms(problem) else BY_ROWS


@kernel(inline="always", fastmath={"contract"})
def velocity_of_contact(problem, v, c):
    """H v of contact c for body velocities v (B + 1, n), that of supports zero: three numbers, the last zero in a plane."""
    a, b, form = problem.places[c, 0], problem.places[c, 1], form_of_problem(problem)
    of_a = velocity_of_side(form, problem.geometry, c, 0, a, unknowns_at(problem, a, a), v)
    return plus(of_a, velocity_of_side(form, problem.geometry, c, 1, b, unknowns_at(problem, b, b), v))


@borrower(fastmath={"contract"})
def add_impulse(problem, p, begin, stop, out):
    """out (B or more, n) += G p of the bodies at the places from begin to stop, for impulses p (C, m).

    Two threads may not add to one body at once. So each of a team passes over all contacts, and adds to bodies of its own: what a body gets
    is added up in the order of the contacts, whichever thread does it.
    """
    if is_coupled(problem):
        add_coupled(problem, p, begin, stop, out)
        return
    for c in range(len(p)):
        for side in range(2):
            b = problem.places[c, side]
            if begin <= b < stop:
                own, count = triple_of(p, c, len(problem.m)), unknowns_at(problem, b, b)
                add_impulse_of_side(form_of_problem(problem), problem.geometry, c, side, b, count, own, out)


@borrower(fastmath={"contract"})
def body_velocity_of(problem, momentum, first, end, v):
    """v = v_free + M^-1 momentum of the bodies first to end."""
    inverse, free, n = problem.inverse, problem.free, len(problem.n)
    for b in range(first, end):
        for i in range(n):
            if has_unit_masses(problem):
                v[b, i] = free[b, i] + momentum[b, i]
                continue
            total = free[b, i]
            for k in range(n):
                total += inverse[b, i, k] * momentum[b, k]
            v[b, i] = total


@borrower()
def momentum_residual_of(problem, free, v, first, end, out):
    """out = M (v_free - v) for the bodies first to end; ``free`` (B, n) or more rows is v_free."""
    mass, n = problem.mass, len(problem.n)
    for b in range(first, end):
        for i in range(n):
            if has_unit_masses(problem):
                out[b, i] = free[b, i] - v[b, i]
                continue
            total = 0.0
            for k in range(n):
                total += mass[b, i, k] * (free[b, k] - v[b, k])
            out[b, i] = total


@borrower(fastmath={"contract"})
def squared_map_norm_of(problem, p, v, first, end):
    """Square of the norm of the natural map residual of impulses p (C, m) and velocities v (B + 1, n), of the contacts first to end.

    w = H v + b + C p, in problems over bodies, scaled by mass, and given by W alone: this is the one loop over contacts that measures it.
    """
    compliance, m, mu, d, total = problem.compliance, len(problem.m), problem.mu, problem.d, 0.0
    for c in range(first, end):
        own, w = triple_of(p, c, m), plus(velocity_of_contact(problem, v, c), triple_of(problem.offset, c, m))
        if len(compliance):
            w = plus(w, times(triple_of(compliance, c, m), own))
        total += squared_residual(own, w, mu[c], d[c])
    return total


@borrower(fastmath={"contract"})
def squared_size_of(problem, v, first, end):
    """Squared norm of (H v + b) / sqrt(d), of the contacts first to end: with v = v_free that by which errors are divided."""
    total = 0.0
    for c in range(first, end):
        u = plus(velocity_of_contact(problem, v, c), triple_of(problem.offset, c, len(problem.m)))
        total += inner(u, u) / problem.d[c]
    return total


@borrower(forceinline=True)
def triple_of(x, c, m):
    """Row c of x (C, m), its third number zero in a plane."""
    return x[c, 0], x[c, 1], x[c, 2] if m == 3 else 0.0
