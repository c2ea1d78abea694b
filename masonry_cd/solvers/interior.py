r"""Interior point: from anywhere to near a solution in about twenty factorisations, whatever lifts off at once.

With w = u + mu |u_t| n the law says that w in K*, p in K are orthogonal. In coordinates (p_n mu, p_t), (w_n / mu, w_t) both cones become
the round one, |x_t| <= x_0, with its Jordan product x o y = (x.y, x_0 y_t + y_0 x_t), and the method follows the path

    M (v - v_free) = H^T p,     w = H v + b + mu |u_t| n,     w o p = sigma mu_gap e,

towards mu_gap = 0 by Newton steps in Nesterov and Todd's scaling, with Mehrotra's predictor and corrector (Andersen, Roos & Terlaky,
Math. Program. 95, 2003; for friction Acary, Armand, Nguyen & Shpakovych, Comput. Optim. Appl., 2023). Each step factorises
M + H^T W^-2 H, which has the pattern of ADMM's matrix. |u_t| is taken from the last step, its kink rounded by the distance from the end
of the path; with frozen |u_t| the problem is convex. Elastic contacts have C p in u as well, eliminated as in newton.py.

It cannot start from the impulses of the last step, and where much slides it ends at errors of 1e-3 to 1e-6. So its use is in ``auto``:
to bring Newton near when a structure rocks at a jolt, where ADMM takes tens of thousands of iterations.
"""

from __future__ import annotations

import numpy as np

from masonry_cd import coulomb
from masonry_cd.friction import FrictionProblem, Problem, Solution
from masonry_cd.solvers import admm, nlgs
from masonry_cd.solvers.options import Options

LIMIT = 40  # iterations


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Follow the central path until the natural map error is below the tolerance, or the limit is reached.

    Args:
        problem: over bodies; a local problem goes to Gauss-Seidel.
        options: ``max_iterations`` counts steps (one factorisation each).
        start: only its memory is used.
    """
    if not isinstance(problem, FrictionProblem) or problem.contacts == 0:
        return nlgs.solve(problem, options, start)
    limit = LIMIT if options.max_iterations is None else options.max_iterations
    arrays, n = problem.arrays(), problem.v_free.shape[1]
    memory, index, spot = admm.recall(arrays[2], len(problem.v_free), n, start)
    impulse, velocity = np.zeros((problem.contacts, problem.dimension)), np.empty(problem.v_free.shape)
    pattern = memory.pattern
    iterations, error = coulomb.interior_bodies(
        *arrays, pattern.order, pattern.plan, index, spot, impulse, velocity, options.tolerance, limit,
        (0,) * problem.dimension, (0,) * n,
    )  # fmt: skip
    reason = "interior: converged" if error <= options.tolerance else f"interior: stopped at an error of {error:.1e}"
    return Solution(impulse, velocity, iterations, reason, memory.arrays())
