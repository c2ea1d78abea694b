# SPDX-License-Identifier: GPL-3.0-or-later
r"""Interior point and the path by its length: what ends the hardest steps of structures that slide or rock as a whole.

Where friction couples normal and tangential impulses, without symmetry, the piecewise smooth equations of a step have pieces whose Jacobian
has a negative determinant. Every path that leads to a solution by making some error or parameter smaller, be it Newton's, ADMM's or the
central path, meets points there where it turns back. Three things help: springs in series with the contacts, soft enough for all
determinants to be positive; to follow the path by its length, around its turning points; and to begin again from elsewhere.

**Interior point.** With the sliding speed gamma as an unknown of its own the law has no kink,

    M (v - v_free) = H^T p,     w = H v + b + C p,     w_n p_n = tau,     (gamma, w_t) o (mu p_n, p_t) = tau e,

w_n, p_n > 0, |w_t| < gamma, |p_t| < mu p_n, with the Jordan product x o y = (x.y, x_0 y_t + y_0 x_t); eliminating gamma as tau -> 0 gives
Coulomb's law back. Newton steps with Mehrotra's predictor and corrector lead towards tau = 0 (Acary, Armand, Nguyen & Shpakovych, Comput.
Optim. Appl., 2023, treat the convex part of the law so). Each factorises the unsymmetric matrix M + H^T B H, B from the linearised products
with a spring in series, C + d / K: it is damped by proximal terms in p (Friedlander & Orban, Math. Program. Comput. 4, 2012). K grows
fourfold with long steps, shrinks fourfold with short ones and tenfold where the determinant is negative. What the damping leaves of the
other residuals is to vanish before tau does: tau is not aimed below a third of it, in the same units. The start is any set of impulses,
moved inside the cones along x = d p - w to products (distance times the largest speed)^2 / d.

**The path by its length.** With all residuals of a start taken away in proportion to tau, and products tau times those of the start, a
path leads from there to a solution, but tau may have to grow again on the way: it falls where the determinant of the linearised equations
is positive and grows where it is negative (Allgower & Georg, Introduction to Numerical Continuation Methods, SIAM, 2003; Watson, SIAM J.
Optim. 11, 2000). So tau is an unknown. Each factorisation, here with K = RIGID, serves the way back to the path, taken across the tangent,
the tangent, and how the path bends; lengths are relative to the distance from the walls of the cones. The step is the longest that stays
inside the cones and, by WIDE times the products, near the path: with longer steps the point wanders between branches where it folds.

**Proximal points** finish, see newton.py: from some hundred times the tolerance they mostly take ten to twenty iterations.

The damped path from near the impulses of the last step is the cheapest; if that fails the other one is followed, from nothing, then the
first from farther and nearer, and at last the other from farther and farther.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from masonry_cd.foundation.jit import Entry
from masonry_cd.mechanics.friction.problem import Problem, Solution
from masonry_cd.mechanics.solvers import nlgs
from masonry_cd.mechanics.solvers.linearised import MethodSettings
from masonry_cd.mechanics.solvers.linearised_bodies import interior_by_team, newton_by_team, over_bodies, path_by_team
from masonry_cd.mechanics.solvers.options import Options
from masonry_cd.mechanics.solvers.recall import recall

DISTANCES = (1e-2, 1e-1, 1e-3)  # of the start from the walls of the cones, if there are impulses to start from
FAR = 1.0  # without
FARTHER = (FAR, 10.0, 3.0, 30.0)  # of the starts of the path by its length: each has a path of its own, some with fewer folds
TURN = 60  # iterations of the damped path, and then of proximal points
FOLLOW, FINISH = 250, 240  # iterations of the path by its length, and of proximal points after the first: stiff springs settle slowly
LEAVE = 100.0  # times the tolerance: where both paths are left, as proximal points finish sooner; at an error of FAR_OFF at most,
FAR_OFF, CLOSE = 1e-3, 1e-4  # and that by its length of CLOSE at least
FIRST = 2 * TURN  # factorisations of the first start, and of all:
MOST = FIRST * (len(DISTANCES) + 1) + (FOLLOW + TURN) * len(FARTHER) + FINISH - TURN
Method = Callable[[np.ndarray, float, int], tuple[int, float]]  # improves impulses (C, m) from a distance: iterations, error
Try = tuple[np.ndarray, float, tuple[tuple[Method, int], ...]]  # impulses to start from, distance, and methods with limits of iterations


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Interior point and proximal points from one start after the other, until the natural map error is below the tolerance.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts factorisations.
        start: its impulse (C, m) is where to start near, its memory that of the step before.
    """
    if problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    arrays, velocity = problem.arrays(), np.empty(problem.v_free.shape)
    near = max(options.tolerance, min(LEAVE * options.tolerance, FAR_OFF))  # where the damped path is left
    recalled = recall(problem, start)

    def method(by_team: Entry, tolerance: float) -> Method:
        def improve(impulse: np.ndarray, distance: float, allowed: int) -> tuple[int, float]:
            settings = MethodSettings(distance, tolerance, allowed)
            return over_bodies(by_team, arrays, recalled, settings, impulse, velocity, options.threads)

        return improve

    proximal = method(newton_by_team, options.tolerance)
    damped, path = (method(interior_by_team, near), TURN), (method(path_by_team, max(near, CLOSE)), FOLLOW)
    nothing = np.zeros((problem.contacts, problem.dimension))
    begin = nothing if start is None else start.impulse
    starts = [(begin, distance) for distance in DISTANCES if begin.any()]
    first, *others = [(*place, (damped, (proximal, TURN))) for place in (*starts, (nothing, FAR))]
    paths: list[Try] = [(nothing, distance, (path, (proximal, FINISH if distance == FAR else TURN))) for distance in FARTHER]
    best, iterations, error = _search([first, paths[0], *others, *paths[1:]], options)
    return Solution(best, problem.body_velocity(best), iterations, options.reason("interior", error), recalled.state, error)


def _search(tries: list[Try], options: Options) -> tuple[np.ndarray, int, float]:
    """One try after the other: the best impulses, the iterations spent, and the error reached."""
    limit = options.limit(sum(most for *_, methods in tries for _, most in methods))
    best, error, iterations = np.zeros_like(tries[0][0]), np.inf, 0
    for start, distance, methods in tries:
        impulse = start.copy()
        for method, most in methods:
            spent, reached = method(impulse, distance, min(most, limit - iterations))
            iterations += spent
            if reached < error:
                best, error = impulse.copy(), reached
            if error <= options.tolerance or iterations >= limit:
                return best, iterations, error
    return best, iterations, error
