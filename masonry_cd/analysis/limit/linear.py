# SPDX-License-Identifier: GPL-3.0-or-later
r"""Limit analysis in a plane: a linear programme, by HiGHS.

A force in Coulomb's cone is a sum of forces along its two edges, r' = x_1 (n + mu t) + x_2 (n - mu t) with x >= 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_diag, csr_matrix, hstack, identity

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import Optimum, Unbounded

MANY = 20_000  # unknowns from which HiGHS' interior point method is faster than its simplex


def solve_linear(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float) -> Optimum:
    """The largest factor up to ``cap``, for loads (unknowns,) that need not be the problem's own.

    Args:
        problem: the structure.
        dead: w_0.
        live: w_1.
        cap: largest factor that is looked for.

    Raises:
        Unbounded: no forces bear the dead loads with any factor up to ``cap``.
    """
    programme = _programme(problem, dead, live)
    programme.bounds[-1] = -cap, cap
    cost = np.zeros(programme.matrix.shape[1])
    cost[-1] = -1.0
    return programme.solved(cost)


def least_unborne(problem: LimitProblem) -> Optimum:
    """The forces that leave least of the loads unborne, where no factor bears them all, and how blocks then begin to fall.

    The least sum of what is left, over all components, under any factor; dual to it is the fastest fall, max w_0 . v with w_1 . v = 0 and
    no component of v above one: the load neither helps nor hinders it.

    Raises:
        Unbounded: no answer of the solver.
    """
    programme = _programme(problem, problem.dead, problem.live)
    programme.bounds[-1] = -np.inf, np.inf
    count, rest = programme.matrix.shape[1], identity(problem.unknowns, format="csr")
    cost = np.concatenate([np.zeros(count), np.ones(2 * problem.unknowns)])
    return programme.with_columns(hstack([rest, -rest], format="csr")).solved(cost)


@dataclass(frozen=True, eq=False)
class _LinearProgramme:
    """min cost . x over x of shares of the edges of all cones, tensions of ties, the factor, and more; x within bounds."""

    problem: LimitProblem
    spread: csr_matrix  # (P m, edges)
    matrix: csr_matrix  # (unknowns, ...)
    wanted: np.ndarray  # (unknowns,)
    bounds: np.ndarray  # (..., 2)

    def with_columns(self, more: csr_matrix) -> _LinearProgramme:
        """A programme with unknowns added, none of them negative, by their columns (unknowns of the blocks, n)."""
        wide = np.tile([0.0, np.inf], (more.shape[1], 1))
        return replace(self, matrix=hstack([self.matrix, more], format="csr"), bounds=np.concatenate([self.bounds, wide]))

    def solved(self, cost: np.ndarray) -> Optimum:
        """The best for a cost."""
        problem, matrix = self.problem, self.matrix
        held = np.flatnonzero(problem.tension < problem.apex)
        count, ties = self.spread.shape[1], len(problem.strength)
        below = _cut_off(held, matrix.shape[1])
        method = "highs-ipm" if matrix.shape[1] > MANY else "highs-ds"
        options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
        answer = linprog(
            cost, A_ub=below, b_ub=(problem.tension - problem.apex)[held] if len(held) else None, A_eq=matrix, b_eq=self.wanted,
            bounds=self.bounds, method=method, options=options,
        )  # fmt: skip
        if answer.status != 0:
            raise Unbounded(answer.message)
        x = answer.x
        return Optimum(
            factor=float(x[count + ties]),
            force=(self.spread @ x[:count] - problem.bond()).reshape(problem.points.count, problem.directions),
            bars=x[count : count + ties],
            velocity=-np.asarray(answer.eqlin.marginals),
            iterations=int(answer.nit),
            method=f"HiGHS {'interior point' if matrix.shape[1] > MANY else 'dual simplex'}",
        )


def _programme(problem: LimitProblem, dead: np.ndarray, live: np.ndarray) -> _LinearProgramme:
    """Equilibrium under loads (unknowns,); the factor has no bounds yet."""
    edges = _edges(problem)
    spread = block_diag(list(edges.transpose(0, 2, 1)), format="csr") if problem.points.count else csr_matrix((0, 0))
    matrix = hstack([problem.jacobian.T @ spread, -problem.bars.T, csr_matrix(live[:, None])], format="csr")
    bounds = np.zeros((matrix.shape[1], 2))
    bounds[: spread.shape[1], 1] = np.inf
    bounds[spread.shape[1] : -1, 1] = problem.strength
    return _LinearProgramme(problem, spread, matrix, problem.jacobian.T @ problem.bond() - dead, bounds)


def _edges(problem: LimitProblem) -> np.ndarray:
    """Edges of the friction cones, (P, 2, 2)."""
    out = np.ones((problem.points.count, 2, 2))
    out[:, :, 1] = problem.mu[:, None] * [1.0, -1.0]
    return out


def _cut_off(held: np.ndarray, columns: int) -> csr_matrix | None:
    """Rows -r'_n of the points whose tension is cut off before the tip of the cone."""
    if not len(held):
        return None
    place = (2 * held[:, None] + np.arange(2)).ravel()
    return csr_matrix((-np.ones(len(place)), (np.repeat(np.arange(len(held)), 2), place)), (len(held), columns))
