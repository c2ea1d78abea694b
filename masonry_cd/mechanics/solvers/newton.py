# SPDX-License-Identifier: GPL-3.0-or-later
r"""Proximal points by Newton's method: the method for structures in space that slide or rock as a whole.

**Proximal points** (Rockafellar, SIAM J. Control Optim. 14, 1976). Springs in series with the contacts, at rest in the impulses p of a
centre, leave a problem in the velocities v alone,

    M (v - v_free) = H^T P(x),     x = p - K / d (H v + b + C P(x)),     P: p_n = max(0, x_n), p_t = projection of x_t onto the disc mu p_n,

whose solution P(x) is the next centre. The stiffer the springs, the more of the error a centre takes away, and the harder the problem. K
begins at the reciprocal of the error, grows fourfold with what few steps solve, and falls where 25 do not solve it.

**Newton's steps.** P has a derivative wherever a contact is surely open, sticking or slipping, and one of its pieces' elsewhere (Alart &
Curnier, Comput. Methods Appl. Mech. Engrg. 92, 1991); B = -dP/du leaves one sparse, unsymmetric system with the pattern of ADMM's,

    (M + H^T B H) dv = M (v_free - v) + H^T P(x),

and the step is halved until the residual, in the norm of M^-1, falls. A step that brings no progress goes to the first kink on its way,
where one contact changes its status, as in pivoting methods (Ralph, Math. Oper. Res. 19, 1994). Velocities are counted from that of the
centre, which spares rounding.

Stiff springs of the contacts' own settle next to rigid contacts where K exceeds d / C: hence its bound of 1e12.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import Entry
from masonry_cd.mechanics.friction.problem import Problem, Solution, first_impulse
from masonry_cd.mechanics.solvers import nlgs
from masonry_cd.mechanics.solvers.linearised import MethodSettings
from masonry_cd.mechanics.solvers.linearised_bodies import newton_by_team, over_bodies
from masonry_cd.mechanics.solvers.options import Options
from masonry_cd.mechanics.solvers.recall import recall

LIMIT = 240  # factorisations


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Move the centre until the natural map error is below the tolerance, the limit is reached, or no springs are soft enough.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts factorisations.
        start: its impulse (C, m) is the first centre, its memory that of the step before.
    """
    return solve_by_proximal_points("newton", newton_by_team, LIMIT, options.threads, problem, options, start)


def solve_by_proximal_points(
    name: str, by_team: Entry, limit: int, threads: int, problem: Problem, options: Options, start: Solution | None
) -> Solution:
    """:func:`solve` with what solves the problem of a centre; ``name`` is the solver's, for the reason, and ``limit`` its own."""
    if problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    impulse, velocity = first_impulse(problem, start), np.empty(problem.v_free.shape)
    recalled = recall(problem, start)
    settings = MethodSettings(0.0, options.tolerance, options.limit(limit))
    iterations, error = over_bodies(by_team, problem.arrays(), recalled, settings, impulse, velocity, threads)
    return Solution(impulse, velocity, iterations, options.reason(name, error), recalled.state, error)
