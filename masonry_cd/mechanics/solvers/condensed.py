# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves problems of meshed blocks in the unknowns that their contacts feel, see ``friction/condensation.py``, by any solver.

The equivalent problem has the same impulses, and W and q to rounding, so it has the same natural map error. What a solver remembers is in
its unknowns: factors of other ones are forgotten.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution
from masonry_cd.mechanics.solvers.options import Options

if TYPE_CHECKING:
    from masonry_cd.mechanics.solvers import Solver

UNIFORM = {2: 6, 3: 12}  # unknowns of a block of uniform strain, in a plane and in space


def in_condensed_unknowns(solver: Solver) -> Solver:
    """The solver, given equivalent problems where blocks have more unknowns than those of uniform strain, which contacts all feel."""

    def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
        if not (isinstance(problem, FrictionProblem) and problem.contacts and problem.v_free.shape[1] > UNIFORM[problem.dimension]):
            return solver(problem, options, start)
        from masonry_cd.mechanics.friction.condensation import condense  # kernels, that rigid blocks have no use for

        equivalent, velocity, rows = condense(problem, None if start is None else start.velocity)
        kept, unknowns = rows.ravel(), velocity.shape[1]
        begin = None
        if start is not None:
            state = start.memory
            if not np.array_equal(state.kept if state.kept is not None else (), kept):
                state = state.with_learnt(replace(state.learnt, stale=True))
            begin = replace(start, velocity=None if start.velocity is None else velocity, memory=state)
        found = solver(equivalent, options, begin)
        state = replace(found.memory, kept=kept, unknowns=unknowns)
        return Solution(found.impulse, None, found.iterations, found.reason, state, found.error)

    return solve
