# SPDX-License-Identifier: GPL-3.0-or-later
r"""Sweeps of Gauss-Seidel, accelerated: the method for packed grains.

A sweep (nlgs.py) maps impulses to impulses, S(p), and propagates the error by about one contact. Taken as a gradient step it gains what
gradient steps gain (Nesterov, Soviet Math. Dokl. 27, 1983):

    p_k = S(x_k),     x_k+1 = p_k + (w_k - 1) / w_k+1 (p_k - p_k-1),     w_k+1 = (1 + sqrt(1 + 4 w_k^2)) / 2,

with w = 1 at the start and again where the error has grown since it was last measured (the restart of O'Donoghue & Candes, Found. Comput.
Math. 15, 2015). y = G^T p is extrapolated with p, which costs less than a tenth of the sweep. A sweep solves the law of a contact exactly,
De Saxce's shift mu |u_t| n with it, which is not a gradient: projected gradients overshoot where contacts slip (docs/negative_results.md).

Spheres that pour take a fifth of the plain sweeps, spheres at rest a quarter. What slips all over, at a friction of 0.5 and more, may stop
between 1e-4 and 1e-3, as it does with every other method here.

The joints are swept colour by colour, those of a colour in parallel, always in the same order: S has to be one map, and the seed changes
nothing. So equal problems give equal bits on any number of threads.
"""

from __future__ import annotations

from masonry_cd.mechanics.friction.problem import Problem, Solution
from masonry_cd.mechanics.solvers.nlgs import solve_by_sweeps
from masonry_cd.mechanics.solvers.options import Options


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Sweep until the natural map error is below the tolerance, or the limit of sweeps is reached; the best measured impulses are returned.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts sweeps.
        start: its impulse (C, m) is the first iterate; None starts from zero.
    """
    return solve_by_sweeps("accelerated", True, problem, options, start)
