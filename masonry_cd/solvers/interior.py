r"""Interior point and proximal points: the method for structures that slide or rock as a whole.

**What is hard there.** Where friction couples normal and tangential impulses, without symmetry, the piecewise smooth equations of a step
have pieces whose Jacobian has a negative determinant. Every path that leads to a solution by making some error or parameter smaller, be it
Newton's, ADMM's or the central path, then meets points where it turns back, and the method stalls in front of them, at natural map errors
of 1e-2 to 1e-5. Two things were found to help: springs in series with the contacts, soft enough for all determinants to be positive, and
beginning again from elsewhere.

**Interior point.** With the sliding speed gamma as an unknown of its own the law has no kink,

    M (v - v_free) = H^T p,     w = H v + b + C p,     w_n p_n = tau,     (gamma, w_t) o (mu p_n, p_t) = tau e,

w_n, p_n > 0, |w_t| < gamma, |p_t| < mu p_n, with the Jordan product x o y = (x.y, x_0 y_t + y_0 x_t); eliminating gamma as tau -> 0 gives
Coulomb's law back. Newton steps with Mehrotra's predictor and corrector lead towards tau = 0 (Acary, Armand, Nguyen & Shpakovych, Comput.
Optim. Appl., 2023, treat the convex part of the law so). Each factorises the unsymmetric matrix M + H^T B H, B from the linearised products
with a spring in series, C + d / K: it is damped by proximal terms in p (Friedlander & Orban, Math. Program. Comput. 4, 2012). K grows
fourfold with long steps, shrinks fourfold with short ones and tenfold where the determinant is negative. The start is any set of impulses,
moved inside the cones along x = d p - w to products (distance times the largest speed)^2 / d.

**Proximal points** finish (Rockafellar, SIAM J. Control Optim. 14, 1976): p+ solves the problem with springs that are at rest in p,

    p+ = P(p - K / d (H v + b + C p+)),     P: p_n = max(0, x_n), p_t = projection of x_t onto the disc of radius mu p_n,

in v alone, M (v - v_free) = H^T p+, by semismooth Newton steps. A step that brings no progress goes to the first kink on its way, where one
contact changes its status, as in pivoting methods (Ralph, Math. Oper. Res. 19, 1994): exact in a plane, where all pieces are linear. What
cannot be solved so is tried with softer springs. Where ``newton`` moves its centre with every step, this one moves it when the springs'
problem is solved.

Starting near the impulses of the last step is best; if that fails, from nearer, farther, or from nothing.
"""

from __future__ import annotations

import numpy as np

from masonry_cd import coulomb
from masonry_cd.friction import FrictionProblem, Problem, Solution
from masonry_cd.solvers import admm, nlgs
from masonry_cd.solvers.options import Options

DISTANCES = (1e-2, 1e-1, 1e-3)  # of the start from the walls of the cones, if there are impulses to start from
FAR = 1.0  # without
TURN = 60  # iterations of the interior point method, and then of proximal points, from one start
STIFFNESS = 1e4  # K at the start


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Interior point and proximal points from one start after the other, until the natural map error is below the tolerance.

    Args:
        problem: over bodies; a local problem goes to Gauss-Seidel.
        options: ``max_iterations`` counts factorisations.
        start: its impulse (C, m) is where to start near, its memory that of the step before.
    """
    if not isinstance(problem, FrictionProblem) or problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    arrays, n, m = problem.arrays(), problem.v_free.shape[1], problem.dimension
    memory, index, spot = admm.recall(arrays[2], len(problem.v_free), n, start)
    pattern = memory.pattern
    given = (*arrays, pattern.order, pattern.plan, index, spot)
    nothing, sizes = np.zeros((problem.contacts, m)), ((0,) * m, (0,) * n)
    starts = [(nothing, FAR)]
    if start is not None and start.impulse.any():
        starts = [(start.impulse, distance) for distance in DISTANCES] + starts
    limit = 2 * TURN * len(starts) if options.max_iterations is None else options.max_iterations
    best, best_velocity, error, iterations = nothing, problem.v_free, np.inf, 0
    velocity = np.empty(problem.v_free.shape)
    for begin, distance in starts:
        impulse = begin.copy()
        for turn in range(2):
            allowed = min(TURN, limit - iterations)
            if turn == 0:
                spent, reached = coulomb.interior_bodies(
                    *given, impulse, velocity, distance, STIFFNESS, options.tolerance, allowed, *sizes, (0,) * (m + 1)
                )
            else:
                spent, reached = coulomb.proximal_bodies(*given, impulse, velocity, options.tolerance, allowed, *sizes)
            iterations += spent
            if reached < error:
                best, best_velocity, error = impulse.copy(), velocity.copy(), reached
            if error <= options.tolerance or iterations >= limit:
                return Solution(best, best_velocity, iterations, _reason(error, options), memory.arrays())
    return Solution(best, best_velocity, iterations, _reason(error, options), memory.arrays())


def affordable(iterations: float) -> int:
    """A limit of iterations not far above a number of them: one start at least, all starts at most."""
    return int(min(max(iterations, 2 * TURN), 2 * TURN * (len(DISTANCES) + 1)))


def _reason(error: float, options: Options) -> str:
    """Say how it ended."""
    return "interior: converged" if error <= options.tolerance else f"interior: stopped at an error of {error:.1e}"
