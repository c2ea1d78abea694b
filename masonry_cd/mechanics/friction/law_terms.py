"""What the error measure of a friction problem over bodies is made of: v = v_free + M^-1 H^T p, q = H v_free + b, w = H v + b + C p, d.

The bodies keep the order of the problem. A team of threads may share the work: each takes its share of the contacts, and of the bodies,
whose momenta it adds up in the order of the contacts. So one thread and many come to the same bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.joint_twists import NUMBERS
from masonry_cd.mechanics.friction.natural_map import natural_map_norms, squared_residual
from masonry_cd.mechanics.friction.operators import (
    OrderedProblem,
    ProblemArrays,
    body_velocity_of,
    law_velocity_of,
    measure_scales,
    relative_velocity_of,
    unknowns_at,
    widths_in_order,
)
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.threads import ThreadTeam, share_of, wait


class LawTerms(NamedTuple):
    """Velocities that the law is about, and room for what leads to them."""

    places: np.ndarray  # (C, 2) bodies of the contacts; B: a support
    momentum: np.ndarray  # (B + 1, n) H^T p
    v: np.ndarray  # (B + 1, n)
    q: np.ndarray  # (C, m) H v_free + b
    w: np.ndarray  # (C, m) H v + b + C p
    d: np.ndarray  # (C,) scales; ones if not scaled


@kernel()
def room_for_law(problem):
    """:class:`LawTerms` of ProblemArrays, to be filled."""
    contacts, bodies, m, n = len(problem.mu), len(problem.v_free) + 1, len(problem.m), len(problem.n)
    return LawTerms(
        np.empty((contacts, 2), dtype=np.int64), np.empty((bodies, n)), np.empty((bodies, n)), np.empty((contacts, m)),
        np.empty((contacts, m)), np.ones(contacts),
    )  # fmt: skip


@kernel()
def as_given(problem, terms):
    """ProblemArrays as an :class:`OrderedProblem` whose bodies keep their order, and without M, for the operators that do not need it."""
    return OrderedProblem(
        problem.inverse_mass, np.empty((0, len(problem.n), len(problem.n))), problem.v_free, terms.places, np.empty(0, dtype=np.int64),
        problem.jacobian, np.empty((0, NUMBERS)), problem.offset, problem.mu, problem.compliance,
        widths_in_order(problem.width, np.arange(len(problem.v_free))), terms.d, problem.m, problem.n,
    )  # fmt: skip


@kernel()
def fill_law_terms(team, given, p, scaled, terms):
    """Fill :class:`LawTerms` for impulses p (C, m) over ProblemArrays, by a team; d only if ``scaled``."""
    problem, count, v = as_given(given, terms), len(given.v_free), terms.v
    first, end = share_of(team, 0, len(p))
    b0, b1 = share_of(team, 0, count)
    for c in range(first, end):
        for side in range(2):
            terms.places[c, side] = given.bodies[c, side] if given.bodies[c, side] >= 0 else count
    copy_flat(problem.free[b0:b1], v[b0:b1])
    v[count] = 0.0
    wait(team)
    relative_velocity_of(problem, v, first, end, terms.q)
    add_impulse_of_own(problem, p, b0, b1, terms.momentum)
    wait(team)
    body_velocity_of(problem, terms.momentum, b0, b1, v)
    wait(team)
    law_velocity_of(problem, v, p, first, end, terms.w)
    if scaled:
        measure_scales(problem, first, end)
    wait(team)


@borrower(fastmath={"contract"})
def add_impulse_of_own(problem, p, begin, stop, out):
    """out = H^T p of the bodies from begin to stop; each adds up in the order of the contacts, whatever the others do."""
    jacobian, m = problem.jacobian, len(problem.m)
    out[begin:stop] = 0.0
    for c in range(len(p)):
        for side in range(2):
            b = problem.places[c, side]
            if begin <= b < stop:
                n = unknowns_at(problem, b, b)
                for i in range(m):
                    x = p[c, i]
                    for k in range(n):
                        out[b, k] += jacobian[c, side, i, k] * x


@kernel()
def law_terms(given, p, scaled):
    """The :class:`LawTerms` of impulses p (C, m) over ProblemArrays."""
    terms, nobody = room_for_law(given), np.zeros(3, dtype=np.int64)
    fill_law_terms(ThreadTeam(0, 1, nobody, nobody), given, p, scaled, terms)
    return terms


@entry()
def error_bodies(problem: ProblemArrays, p: np.ndarray, scaled: bool) -> tuple[float, float]:
    """Norms of the natural map residual and of q for impulses p over ProblemArrays; scaled by d, or with d = 1."""
    terms = law_terms(problem, p, scaled)
    return natural_map_norms(p, terms.w, terms.q, problem.mu, terms.d)


@entry()
def allocate_terms(problem: ProblemArrays) -> LawTerms:
    """Room for :func:`error_by_team`."""
    return room_for_law(problem)


@entry()
def error_by_team(team: ThreadTeam, problem: ProblemArrays, p: np.ndarray, scaled: bool, terms: LawTerms) -> tuple[float, float]:
    """As :func:`error_bodies`, to the same bits, by a team of threads; the first one adds up."""
    fill_law_terms(team, problem, p, scaled, terms)
    return natural_map_norms(p, terms.w, terms.q, problem.mu, terms.d) if team.rank == 0 else (0.0, 0.0)


@entry()
def errors_by_group(problem: ProblemArrays, p: np.ndarray, group: np.ndarray, groups: int) -> tuple[np.ndarray, np.ndarray]:
    """Norms of the scaled natural map residual and of q over each group of contacts, (G,) each; ``group`` (C,) numbers them."""
    terms = law_terms(problem, p, True)
    w, q, d, residual, size, m = terms.w, terms.q, terms.d, np.zeros(groups), np.zeros(groups), len(problem.m)
    for c in range(len(p)):
        p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
        residual[group[c]] += squared_residual(p[c, 0], p[c, 1], p2, w[c, 0], w[c, 1], w2, problem.mu[c], d[c])
        for i in range(m):
            size[group[c]] += q[c, i] * q[c, i] / d[c]
    return np.sqrt(residual), np.sqrt(size)
