# SPDX-License-Identifier: GPL-3.0-or-later
"""The natural map error of impulses p: v = v_free + M^-1 G p and the scales d, and with them the residual and the size of q.

The bodies keep the order of the problem. A team of threads may share the work: each takes its share of the contacts, and of the bodies,
whose momenta it adds up in the order of the contacts. Sums are taken over parts of the contacts, and then over these in order. So one
thread and many come to the same bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.contact_geometry import velocity_between
from masonry_cd.mechanics.friction.operators import (
    OrderedProblem,
    ProblemArrays,
    add_impulse,
    body_velocity_of,
    measure_scales,
    squared_map_norm_of,
    squared_size_of,
    widths_in_order,
)
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.threads import ThreadTeam, share_of, wait

PARTS = 64  # of the contacts, whose sums are added in their order


class LawTerms(NamedTuple):
    """Room for what the error is made of."""

    places: np.ndarray  # (C, 2) bodies of the contacts; B: a support
    momentum: np.ndarray  # (B + 1, n) G p
    v: np.ndarray  # (B + 1, n) v_free, then v
    d: np.ndarray  # (C,) scales; ones if not scaled
    sums: np.ndarray  # (PARTS, 2) squared norms of the residual and of q


@entry()
def allocate_terms(problem: ProblemArrays) -> LawTerms:
    """:class:`LawTerms` of ProblemArrays, to be filled."""
    contacts, bodies, n = len(problem.mu), len(problem.v_free) + 1, len(problem.n)
    places, momentum, v = np.empty((contacts, 2), dtype=np.int64), np.empty((bodies, n)), np.empty((bodies, n))
    return LawTerms(places, momentum, v, np.ones(contacts), np.empty((PARTS, 2)))


@borrower(forceinline=True)
def part_of(k, contacts):
    """First and end of the contacts of part k."""
    return contacts * k // PARTS, contacts * (k + 1) // PARTS


@kernel()
def begin_terms(team, given, scaled, terms):
    """Fill places, v = v_free, and d if ``scaled``, by a team.

    Returns the problem with its bodies in their order, and without M, for the operators that do not need it.
    """
    count, n, v = len(given.v_free), len(given.n), terms.v
    problem = OrderedProblem(
        given.inverse_mass, np.empty((0, n, n)), given.v_free, terms.places, np.empty(0, dtype=np.int64), given.geometry,
        given.offset, given.mu, given.compliance, widths_in_order(given.width, np.arange(count)), terms.d, given.coupling, given.m, given.n,
    )  # fmt: skip
    parts, (b0, b1) = share_of(team, 0, PARTS), share_of(team, 0, count)
    first, end = part_of(parts[0], len(given.mu))[0], part_of(parts[1], len(given.mu))[0]
    for c in range(first, end):
        for side in range(2):
            terms.places[c, side] = given.bodies[c, side] if given.bodies[c, side] >= 0 else count
    copy_flat(problem.free[b0:b1], v[b0:b1])
    v[count] = 0.0
    if scaled:
        measure_scales(problem, first, end)
    wait(team)
    return problem


@kernel()
def move_terms(team, problem, p, terms):
    """v = v_free + M^-1 G p of impulses p (C, m), by a team."""
    b0, b1 = share_of(team, 0, len(problem.free))
    terms.momentum[b0:b1] = 0.0
    add_impulse(problem, p, b0, b1, terms.momentum)
    wait(team)
    body_velocity_of(problem, terms.momentum, b0, b1, terms.v)
    wait(team)


@kernel()
def alone():
    """A team of one thread."""
    nobody = np.zeros(3, dtype=np.int64)
    return ThreadTeam(0, 1, nobody, nobody)


@entry()
def error_by_team(team: ThreadTeam, given: ProblemArrays, p: np.ndarray, scaled: bool, terms: LawTerms) -> tuple[float, float]:
    """Norms of the natural map residual and of q for impulses p over ProblemArrays, by a team; scaled by d, or with d = 1."""
    problem, sums, (first, end) = begin_terms(team, given, scaled, terms), terms.sums, share_of(team, 0, PARTS)
    for k in range(first, end):
        begin, stop = part_of(k, len(p))
        sums[k, 1] = squared_size_of(problem, terms.v, begin, stop)
    wait(team)
    move_terms(team, problem, p, terms)
    for k in range(first, end):
        begin, stop = part_of(k, len(p))
        sums[k, 0] = squared_map_norm_of(problem, p, terms.v, begin, stop)
    wait(team)
    return np.sqrt(sums[:, 0].sum()), np.sqrt(sums[:, 1].sum())


@entry()
def error_bodies(problem: ProblemArrays, p: np.ndarray, scaled: bool) -> tuple[float, float]:
    """As :func:`error_by_team`, to the same bits, by one thread."""
    return error_by_team(alone(), problem, p, scaled, allocate_terms(problem))


@entry()
def errors_by_group(problem: ProblemArrays, p: np.ndarray, group: np.ndarray, groups: int) -> tuple[np.ndarray, np.ndarray]:
    """Norms of the scaled natural map residual and of q over each group of contacts, (G,) each; ``group`` (C,) numbers them."""
    team, terms, residual, size = alone(), allocate_terms(problem), np.zeros(groups), np.zeros(groups)
    ordered = begin_terms(team, problem, True, terms)
    for c in range(len(p)):
        size[group[c]] += squared_size_of(ordered, terms.v, c, c + 1)
    move_terms(team, ordered, p, terms)
    for c in range(len(p)):
        residual[group[c]] += squared_map_norm_of(ordered, p, terms.v, c, c + 1)
    return np.sqrt(residual), np.sqrt(size)


@entry()
def new_velocity(problem: ProblemArrays, p: np.ndarray, v: np.ndarray) -> None:
    """v = v_free + M^-1 G p (B, n) of impulses p (C, m) over ProblemArrays."""
    terms = allocate_terms(problem)
    move_terms(alone(), begin_terms(alone(), problem, False, terms), p, terms)
    copy_flat(terms.v[: len(v)], v)


@entry()
def add_velocities(problem: ProblemArrays, v: np.ndarray, u: np.ndarray) -> None:
    """Add H v of ProblemArrays to u (C, m), for body velocities v (B, n)."""
    for c in range(len(u)):
        x = velocity_between(problem.bodies, problem.geometry, c, v)
        for i in range(len(problem.m)):
            u[c, i] += x[i]
