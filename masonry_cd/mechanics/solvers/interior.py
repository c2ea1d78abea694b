# SPDX-License-Identifier: GPL-3.0-or-later
r"""Interior points on a path by its length: what ends the hardest steps of structures that slide or rock as a whole.

**What is hard there.** Where friction couples normal and tangential impulses, without symmetry, the piecewise smooth equations of a step
have pieces whose Jacobian has a negative determinant. Every path that leads to a solution by making some error or parameter smaller, be it
Newton's, ADMM's or the central path, then meets points where it turns back, and the method stalls in front of them, at natural map errors
of 1e-2 to 1e-5. Three things were found to help: springs in series with the contacts, soft enough for all determinants to be positive; to
follow the path by its length, around its turning points; and to begin again from elsewhere.

**Interior points.** With the sliding speed gamma as an unknown of its own the law has no kink,

    M (v - v_free) = H^T p,     w = H v + b + C p,     w_n p_n = tau,     (gamma, w_t) o (mu p_n, p_t) = tau e,

w_n, p_n > 0, |w_t| < gamma, |p_t| < mu p_n, with the Jordan product x o y = (x.y, x_0 y_t + y_0 x_t); eliminating gamma as tau -> 0 gives
Coulomb's law back (Acary, Armand, Nguyen & Shpakovych, Comput. Optim. Appl., 2023, treat the convex part of the law so). Newton's steps
factorise the unsymmetric matrix M + H^T B H, B from the linearised products with a spring in series, C + d / K (Friedlander & Orban, Math.
Program. Comput. 4, 2012). The start is moved inside the cones, to products (distance times the largest speed)^2 / d.

**The path by its length.** With all residuals of a start taken away in proportion to tau, and products tau times those of the start, a
path leads from there to a solution, but tau may have to grow again on the way: it falls where the determinant of the linearised equations
is positive and grows where it is negative (Allgower & Georg, Introduction to Numerical Continuation Methods, SIAM, 2003; Watson, SIAM J.
Optim. 11, 2000). So tau is an unknown. Each factorisation, with K = RIGID, serves the way back to the path, taken across the tangent,
the tangent, and how the path bends; lengths are relative to the distance from the walls of the cones. The step is the longest that stays
inside the cones and, by WIDE times the products, near the path. Where the path folds closely its branches are near one another: with
longer steps the point wanders between them, and which it takes hangs on rounding. It takes 40 to 250 iterations. Paths from starts farther
away are others, with folds elsewhere. Of walls thrown apart at random (mu 0.8 to 2.5), tests/mechanics/solvers/test_interior.py counts how
many end below 1e-8: nine of ten at least.

**Proximal points** finish, see newton.py: from some hundred times the tolerance they mostly take ten to twenty iterations. If they do not,
the next path begins farther away. All begin from nothing, not from the impulses of the last step, where the other methods got stuck.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import Entry
from masonry_cd.mechanics.friction.problem import Problem, Solution
from masonry_cd.mechanics.linalg.small_blocks import size_tuple
from masonry_cd.mechanics.solvers import admm, nlgs
from masonry_cd.mechanics.solvers.linearised import Settings, elimination_of
from masonry_cd.mechanics.solvers.linearised_bodies import newton_by_team, over_bodies, path_by_team
from masonry_cd.mechanics.solvers.options import Options

DISTANCES = (1.0, 10.0, 3.0, 30.0)  # of the starts from the walls of the cones: each has a path of its own, some with fewer folds
FOLLOW = 250  # factorisations of a path at most,
FINISH, AGAIN = 240, 60  # and of proximal points after the first and the others: stiff springs settle slowly
RIGID = 1e8  # K of the path
WIDE = 0.5  # how far products may be off the path, relative to those on it: much more, and it takes other branches for its own
LEAVE, CLOSE = 100.0, 1e-4  # times the tolerance, and at least: the error at which proximal points take over, as they finish sooner
MOST = FOLLOW + FINISH + (len(DISTANCES) - 1) * (FOLLOW + AGAIN)


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """A path and proximal points from one start after the other, until the natural map error is below the tolerance.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts factorisations.
        start: its memory is that of the step before.
    """
    if problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    arrays, m, limit = problem.arrays(), problem.dimension, options.limit(MOST)
    state, factors, index, block = admm.recall(arrays, start)
    elimination, velocity = elimination_of(problem, factors.pattern, index, block), np.empty(problem.v_free.shape)
    best, least, iterations = np.zeros((problem.contacts, m)), np.inf, 0
    near = max(LEAVE * options.tolerance, CLOSE)
    for distance in DISTANCES:
        impulse = np.zeros_like(best)
        finish = FINISH if distance == DISTANCES[0] else AGAIN
        turns: tuple[tuple[Entry, float, int], ...] = (path_by_team, near, FOLLOW), (newton_by_team, options.tolerance, finish)
        for by_team, tolerance, most in turns:
            settings = Settings(distance, RIGID, WIDE, tolerance, min(most, limit - iterations), size_tuple(m + 1))
            spent, error = over_bodies(by_team, arrays, elimination, settings, impulse, velocity, options.threads)
            iterations += spent
            if error < least:
                best, least = impulse.copy(), error
            if least <= options.tolerance or iterations >= limit:
                return Solution(best, problem.body_velocity(best), iterations, options.reason("interior", least), state, least)
    return Solution(best, problem.body_velocity(best), iterations, options.reason("interior", least), state, least)
