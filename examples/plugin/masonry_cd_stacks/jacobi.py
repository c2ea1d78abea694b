# SPDX-License-Identifier: GPL-3.0-or-later
"""``[run] solver = "jacobi"``: projected Jacobi, all contacts at once, each from what the others did in the last iteration.

    p <- P_K( p - rho_c (w + mu |w_t| n) ),      w = (W + C) p + q,      rho_c = 1 / (lambda d_c)

The iteration of De Saxce & Feng (Math. Comput. Modelling 28, 1998). d_c is the trace of the contact's own block of W + C, lambda the
largest eigenvalue of D^-1 (W + C), found by power iterations.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.friction.problem import Problem, Solution, natural_map_error
from masonry_cd.mechanics.solvers.options import Options

LIMIT = 2000  # iterations
EVERY = 20  # iterations between two measurements of the error


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Iterate until the natural map error is below the tolerance, or the limit of iterations is reached."""
    limit = options.max_iterations or LIMIT
    p = np.zeros((problem.contacts, problem.dimension)) if start is None else start.impulse.copy()
    rho, error, done = _step_lengths(problem), natural_map_error(problem, p), 0
    while error > options.tolerance and done < limit:
        for _ in range(min(EVERY, limit - done)):
            w = problem.apply(p)
            w[:, 0] += problem.mu * np.linalg.norm(w[:, 1:], axis=1)
            p = _project(p - rho * w, problem.mu)
            done += 1
        error = natural_map_error(problem, p)
    return Solution(p, problem.body_velocity(p), done, f"jacobi: error {error:.1e}", error=error)


def _project(x: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """The points of Coulomb's cones |p_t| <= mu p_n nearest to x, (C, m)."""
    size = np.linalg.norm(x[:, 1:], axis=1)
    height = np.maximum(x[:, 0] + mu * size, 0.0) / (1.0 + mu**2)
    onto = np.column_stack([height, x[:, 1:] * (mu * height / np.maximum(size, 1e-300))[:, None]])
    return np.where((size <= mu * x[:, 0])[:, None], x, onto)


def _step_lengths(problem: Problem) -> np.ndarray:
    """rho_c, (C, 1)."""
    d = np.trace(problem.delassus_diagonal(), axis1=1, axis2=2)[:, None]
    x, largest = np.random.default_rng(0).random((problem.contacts, problem.dimension)), 1.0
    for _ in range(20 if len(d) else 0):
        x = (problem.apply(x) - problem.free_relative_velocity()) / d
        largest = float(np.linalg.norm(x))
        x /= largest
    return 1.0 / (largest * d)
