# SPDX-License-Identifier: GPL-3.0-or-later
"""The natural map error of impulses p: v = v_free + M^-1 G p, and with it the residual and the size of q.

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
    ProblemArrays,
    add_impulse,
    body_velocity_of,
    squared_map_norm_of,
    squared_size_of,
)
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.threads import ThreadTeam, alone, run_by_team, share_of, wait

PARTS = 64  # of the contacts, whose sums are added in their order


class LawTerms(NamedTuple):
    """Room for what the error is made of."""

    momentum: np.ndarray  # (B + 1, n) G p
    v: np.ndarray  # (B + 1, n) v_free, then v
    sums: np.ndarray  # (PARTS, 2) squared norms of the residual and of q


@entry()
def allocate_terms(problem: ProblemArrays) -> LawTerms:
    """:class:`LawTerms` of ProblemArrays, to be filled."""
    bodies, n = len(problem.free) + 1, len(problem.n)
    return LawTerms(np.empty((bodies, n)), np.empty((bodies, n)), np.empty((PARTS, 2)))


@borrower(forceinline=True)
def part_of(k, contacts):
    """First and end of the contacts of part k."""
    return contacts * k // PARTS, contacts * (k + 1) // PARTS


@borrower()
def begin_terms(team, problem, terms):
    """v = v_free, by a team."""
    count, v = len(problem.free), terms.v
    b0, b1 = share_of(team, 0, count)
    copy_flat(problem.free[b0:b1], v[b0:b1])
    v[count] = 0.0
    wait(team)


@kernel()
def move_terms(team, problem, p, terms):
    """v = v_free + M^-1 G p of impulses p (C, m), by a team."""
    b0, b1 = share_of(team, 0, len(problem.free))
    terms.momentum[b0:b1] = 0.0
    add_impulse(problem, p, b0, b1, terms.momentum)
    wait(team)
    body_velocity_of(problem, terms.momentum, b0, b1, terms.v)
    wait(team)


@entry()
def error_by_team(team: ThreadTeam, problem: ProblemArrays, p: np.ndarray, terms: LawTerms) -> tuple[float, float]:
    """Norms of the natural map residual and of q for impulses p over ProblemArrays, scaled by their d, by a team."""
    sums, (first, end) = terms.sums, share_of(team, 0, PARTS)
    begin_terms(team, problem, terms)
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


def error_norms(problem: ProblemArrays, p: np.ndarray, threads: int = 1) -> tuple[float, float]:
    """Norms of the natural map residual and of q for impulses p (C, m), by threads that change no bit."""
    found: tuple[float, float] = run_by_team(error_by_team, threads, problem, p, allocate_terms(problem))
    return found


@entry()
def errors_by_group(problem: ProblemArrays, p: np.ndarray, group: np.ndarray, groups: int) -> tuple[np.ndarray, np.ndarray]:
    """Norms of the scaled natural map residual and of q over each group of contacts, (G,) each; ``group`` (C,) numbers them."""
    team, terms, residual, size = alone(), allocate_terms(problem), np.zeros(groups), np.zeros(groups)
    begin_terms(team, problem, terms)
    for c in range(len(p)):
        size[group[c]] += squared_size_of(problem, terms.v, c, c + 1)
    move_terms(team, problem, p, terms)
    for c in range(len(p)):
        residual[group[c]] += squared_map_norm_of(problem, p, terms.v, c, c + 1)
    return np.sqrt(residual), np.sqrt(size)


@entry()
def new_velocity(problem: ProblemArrays, p: np.ndarray, v: np.ndarray) -> None:
    """v = v_free + M^-1 G p (B, n) of impulses p (C, m) over ProblemArrays."""
    terms = allocate_terms(problem)
    begin_terms(alone(), problem, terms)
    move_terms(alone(), problem, p, terms)
    copy_flat(terms.v[: len(v)], v)


@entry()
def add_velocities(problem: ProblemArrays, v: np.ndarray, u: np.ndarray) -> None:
    """Add H v of ProblemArrays to u (C, m), for body velocities v (B, n)."""
    for c in range(len(u)):
        x = velocity_between(problem.places, problem.geometry, c, v)
        for i in range(len(problem.m)):
            u[c, i] += x[i]
