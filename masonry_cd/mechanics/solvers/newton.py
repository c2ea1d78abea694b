r"""Semismooth Newton: few, expensive iterations, each with the contact law linearised; quadratic near a solution.

The law in the form of Alart & Curnier (Comput. Methods Appl. Mech. Engrg. 92, 1991), x = p - u / d (or w / d, of an elastic contact):

    p_n = max(0, x_n),     p_t = projection of x_t onto the disc of radius mu p_n,

has a derivative wherever the contact is surely open, sticking or slipping, and one of its pieces' elsewhere. With the stiffness
kappa = K / d standing in for the infinite one of a rigid contact, in the derivative only, the new impulse is p+ = g - B (u+ - u):

    open    g = 0,                               B = 0
    stick   g = p - kappa u,                     B = kappa I
    slip    g_n = p_n - kappa u_n,               B_nn = kappa,    g_t = mu e g_n,   B_tn = mu kappa e,    e = x_t / |x_t|,
            and across e a stiffness |p_t| / |u_t|, since friction turns with the velocity.

Put into the equation of motion this leaves one sparse, unsymmetric system with the pattern of ADMM's,

    (M + H^T B H) (v+ - v) = M (v_free - v) + H^T g.

An elastic contact's law is about w = u + C p; with w+ - w = u+ - u + C (p+ - p) its spring comes in series with kappa,

    p+ - p = (I + B C)^-1 ( g - p - B (u+ - u) ),

so B is bounded by C^-1, and hyperstatic structures on springs answer with moderate impulses of themselves.

K works as the damping of Levenberg and Marquardt does, or as the step of a proximal point method: large near a solution, small far from
it, or else hyperstatic structures answer with impulses of any size. It grows fourfold when a step reduces the natural map error,
shrinks eightfold when a step is refused because the error grew by half. The best iterate is kept.

From one time step to the next the answer changes little, so a solve begins nearly as stiff as the last one ended: towers, arches and
arcades that are shaken then take 1 or 2 iterations a step instead of 4 to 7. What such an iteration leaves is an error of some 1 / K, so it
begins no stiffer than the tolerance asks: at 3e7 instead of 1e6 meshed blocks took 6 to 8 iterations to 1e-6 instead of 2. Walls in which
much slides are another matter: of 59 steps of one, 38 were solved from K = 1e3, and 1 from 1e7. So where stiffer took more iterations, the
next solve begins softer, as long as softer takes fewer, and one that failed lets the next begin anew.
"""

from __future__ import annotations

from math import inf

import numpy as np

from masonry_cd.mechanics.friction.local_blocks import in_elimination_order, local_arrays
from masonry_cd.mechanics.friction.problem import LocalProblem, Problem, Solution
from masonry_cd.mechanics.linalg.small_blocks import size_tuple
from masonry_cd.mechanics.solvers import admm, nlgs
from masonry_cd.mechanics.solvers.linearised import Settings, elimination_of
from masonry_cd.mechanics.solvers.linearised_bodies import NEWTON, linearised_bodies
from masonry_cd.mechanics.solvers.linearised_local import newton_local
from masonry_cd.mechanics.solvers.options import Options

LIMIT = 50  # iterations
STIFFEST = 1.0  # largest K of the first iteration, over the tolerance
JUMP = 30.0  # of K from one solve to the next
FEW = 2  # iterations of a solve after which the next one begins stiffer
NEAR = 1e-2  # natural map error to begin with; from farther away sweeps of Gauss-Seidel come first
SWEEPS = 300


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Iterate until the natural map error is below the tolerance, the limit is reached, or no step is accepted any more.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts Newton steps (one factorisation each).
        start: its impulse (C, m) is the first iterate, its memory ADMM's or Newton's of the step before.
    """
    if problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    if start is None:
        rough = Options(tolerance=max(options.tolerance, NEAR), max_iterations=SWEEPS, seed=options.seed)
        start = nlgs.solve(problem, rough)
    limit = options.limit(LIMIT)
    if isinstance(problem, LocalProblem):
        return _solve_local(problem, options, start, limit)
    arrays, (bodies, n) = problem.arrays(), problem.v_free.shape
    memory, index, block = admm.recall(arrays, start)
    impulse, velocity, pattern, tally = start.impulse.copy(), np.empty((bodies, n)), memory.pattern, memory.tally
    settings = Settings(0.0, tally.newton_stiffness, 0.0, options.tolerance, limit, size_tuple(problem.dimension + 1))
    elimination, threads = elimination_of(arrays, pattern, index, block), options.threads
    iterations, error, begin, stiffness = linearised_bodies(NEWTON, arrays, elimination, settings, impulse, velocity, threads)
    tally.newton_stiffness, tally.newton_iterations = next_stiffness(
        tally.newton_stiffness, stiffness, tally.newton_iterations, iterations, error <= options.tolerance, stiffest(options.tolerance)
    )
    return Solution(impulse, velocity, iterations, _reason(error, begin, options), memory.arrays())


def stiffest(tolerance: float) -> float:
    """The largest K with which a solve to a tolerance begins."""
    return max(STIFFEST / tolerance, admm.FIRST_STIFFNESS) if tolerance > 0.0 else inf


def next_stiffness(begin: float, end: float, before: float, iterations: int, converged: bool, most: float) -> tuple[float, float]:
    """The K with which the next solve begins, and the iterations of this one, with a minus while K falls.

    Args:
        begin: the K with which it began.
        end: and ended.
        before: iterations of the one before, with a minus while K falls.
        iterations: that it took.
        converged: or not.
        most: the largest to begin with.
    """
    if not converged:
        return admm.FIRST_STIFFNESS, inf
    if iterations == 0:
        return begin, before
    falls = iterations < -before if before < 0.0 else iterations > before + 1.0
    if falls and iterations > FEW and begin > admm.FIRST_STIFFNESS:
        return max(begin / JUMP, admm.FIRST_STIFFNESS), -float(iterations)
    return min(end, JUMP * begin, most), float(iterations)


def _solve_local(problem: LocalProblem, options: Options, start: Solution, limit: int) -> Solution:
    """Newton in the impulses: (I + B W) (p+ - p) = g - p, with W as it is given."""
    given, own = local_arrays(problem)
    arrays, pattern = in_elimination_order(given)
    impulse, settings = start.impulse.copy(), Settings(0.0, admm.FIRST_STIFFNESS, 0.0, options.tolerance, limit, arrays.m)
    iterations, error, begin = newton_local(arrays, own, pattern.symbolic, settings, impulse)
    return Solution(impulse, None, iterations, _reason(error, begin, options))


def _reason(error: float, begin: float, options: Options) -> str:
    """Say how it ended."""
    if error <= options.tolerance:
        return "newton: converged"
    return f"newton: failed at an error of {error:.1e}, begun at {begin:.1e}"
