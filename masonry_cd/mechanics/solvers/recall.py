# SPDX-License-Identifier: GPL-3.0-or-later
"""Reuse from the last step in the methods that factorise: the order of elimination, and the factors of ADMM while they fit."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.friction.coupling import pattern_of
from masonry_cd.mechanics.friction.operators import Elimination
from masonry_cd.mechanics.friction.problem import Problem, Solution
from masonry_cd.mechanics.friction.solver_state import Factors, SolverState


class Recalled(NamedTuple):
    """The state of the last step as far as it still fits, and what a solve needs of it."""

    state: SolverState
    factors: Factors  # its own
    elimination: Elimination


def recall(problem: Problem, start: Solution | None) -> Recalled:
    """Find the order of elimination for the bodies of a problem, again only where others touch than before."""
    given, bodies = problem.arrays(), np.ascontiguousarray(problem.bodies, dtype=np.int64)
    state, (count, n) = SolverState() if start is None else start.memory, given.free.shape
    factors, stale = state.factors, state.learnt.stale
    kind = np.float64 if len(given.coupling.indptr) else np.float32  # W may be singular, and R^-1 is small next to it
    if factors is None or factors.pattern.nodes != count:  # other bodies
        factors, stale = Factors.empty(pattern_of(count, bodies, given.coupling), bodies, n, kind), True
    elif len(factors.squares) != n * n * int(factors.pattern.symbolic.square[-1]):  # other unknowns
        factors, stale = Factors.empty(factors.pattern, factors.bodies, n, kind), True
    found = factors.pattern.locate(bodies, factors.bodies)
    if found is None:  # a new pair of bodies: those that were in touch may be again
        factors = Factors.empty(pattern_of(count, bodies, given.coupling, factors.pattern.pairs), bodies, n, kind)
        found = factors.pattern.locate(bodies, bodies)
        assert found is not None
        stale = True
    index, block, same = found
    if not same:
        factors, stale = replace(factors, bodies=bodies.copy(), rho=np.empty(len(bodies))), True
    if len(given.width):
        factors = replace(factors, pattern=factors.pattern.with_width(given.width[:-1]))
    if factors is not state.factors or stale != state.learnt.stale:
        state = replace(state, factors=factors, learnt=replace(state.learnt, stale=stale))
    return Recalled(state, factors, Elimination(factors.pattern.order, index, block))
