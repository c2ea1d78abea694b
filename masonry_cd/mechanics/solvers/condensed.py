"""Solves problems of meshed blocks in the unknowns that their contacts feel, see ``friction/condensation.py``, by any solver.

The equivalent problem has the same impulses, and W and q to rounding, so it has the same natural map error. What a solver remembers is in
its unknowns: factors of other ones are forgotten.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution
from masonry_cd.mechanics.linalg.small_blocks import NARROW
from masonry_cd.mechanics.solvers.options import Options

if TYPE_CHECKING:
    from masonry_cd.mechanics.solvers import Solver

KEPT, UNKNOWNS = "condensed_kept", "condensed_unknowns"  # in the memory: rows that add an unknown (2 C m,), and room for how many (1,)


def in_condensed_unknowns(solver: Solver) -> Solver:
    """The solver, given equivalent problems where blocks have more unknowns than those of uniform strain, which contacts all feel."""

    def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
        if not (isinstance(problem, FrictionProblem) and is_condensed(problem.v_free.shape[1]) and problem.contacts):
            return solver(problem, options, start)
        return _solve(solver, problem, options, start)

    return solve


def is_condensed(unknowns: int) -> bool:
    """Whether blocks with so many unknowns are: more than one of uniform strain has. Kernels for fewer have their loops unrolled."""
    return unknowns > NARROW


def _solve(solver: Solver, problem: FrictionProblem, options: Options, start: Solution | None) -> Solution:
    """Solve the equivalent problem."""
    from masonry_cd.mechanics.friction.condensation import condense  # kernels, that rigid blocks have no use for
    from masonry_cd.mechanics.solvers.admm import with_stale_factors

    equivalent, velocity, rows = condense(problem, None if start is None else start.velocity)
    kept, unknowns = rows.ravel(), velocity.shape[1]
    begin = None
    if start is not None:
        memory = start.memory
        if not np.array_equal(memory.get(KEPT, ()), kept):
            memory = with_stale_factors(memory)
        begin = Solution(start.impulse, None if start.velocity is None else velocity, 0, memory=memory)
    found = solver(equivalent, options, begin)
    memory = found.memory | {KEPT: kept, UNKNOWNS: np.array([unknowns])}
    return Solution(found.impulse, None, found.iterations, found.reason, memory, found.error)
