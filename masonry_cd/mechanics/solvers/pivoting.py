# SPDX-License-Identifier: GPL-3.0-or-later
r"""Proximal points by pivoting: the method for structures in a plane that slide or rock as a whole.

The problem of a centre is that of newton.py,

    M (v - v_free) = H^T P(x),     x = p - K / d (H v + b + C P(x)),     P: p_n = max(0, x_n), p_t = x_t clipped to mu p_n.

**Pivoting.** In a plane P is piecewise linear: a contact is open, sticks, or slips to one side or the other, and the residual is linear in
v as long as no contact changes its status. So the residual can be taken away exactly, in proportion, along a path that is straight in each
piece (Katzenelson, Bell System Technical Journal 44, 1965; Lemke's method for linear complementarity problems is of this kind). Where a
piece ends one contact changes its status, and the matrix M + H^T B H by one of rank one: the new direction takes a solution with the old
factors and the formula of Sherman and Morrison, an eighth of a factorisation. There is no step length, no merit function, and nowhere to
stall: a path leads to the solution, or to a fold. Ties, of contacts that would change at once, are broken by velocities of a thousandth of
what the tolerance leaves.

**Folds.** Friction makes B unsymmetric, and with stiff springs some pieces have a negative determinant, in which the path turns back. With
springs soft enough no piece has one: there is one solution, and the path leads to it. So K grows tenfold from one centre to the next; where
the path meets a fold, which the sign of the ratio of the determinants tells, K falls as much, and changes by the root of that from then on.

What it does not solve is left to the interior point method, as are problems in space, where the cone of friction is round, and those given
by W alone.
"""

from __future__ import annotations

from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution
from masonry_cd.mechanics.solvers import interior
from masonry_cd.mechanics.solvers.linearised_bodies import pivoting_by_team
from masonry_cd.mechanics.solvers.newton import solve_by_proximal_points
from masonry_cd.mechanics.solvers.options import Options

LIMIT = 300  # factorisations


def applies(problem: Problem) -> bool:
    """Return True if a problem is one over bodies in a plane."""
    return isinstance(problem, FrictionProblem) and problem.dimension == 2


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Follow paths with stiffer and stiffer springs until the natural map error is below the tolerance.

    Args:
        problem: over bodies in a plane; any other is left to ``interior``.
        options: ``max_iterations`` counts factorisations, each for at most ``pivoting_kernels.UPDATES`` pivots.
        start: its impulse (C, 2) is the first centre, its memory that of the step before.
    """
    if not (isinstance(problem, FrictionProblem) and applies(problem) and problem.contacts):
        return interior.solve(problem, options, start)
    return solve_by_proximal_points("pivoting", pivoting_by_team, LIMIT, 1, problem, options, start)
