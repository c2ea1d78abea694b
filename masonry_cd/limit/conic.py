r"""Limit analysis in space with circular friction cones, as a second-order cone programme, by Clarabel.

The kinematic form is solved, whose unknowns are the velocities of the blocks, six each, and few more; Clarabel's dual variables are the
forces. With K the cone |y| <= x, over all points k,

    min  c . v + cap t + sum_k (a_k - f_k)(-y_k) + N_y . w      w_1 . v + t = 1,      ((u_kn - y_k)/mu_k, u_kt) in K,      G v <= w,

c = -w_0 + H^T (a n), u = H v, and t, y, w >= 0: t is the multiplier of the cap on lambda, y_k of a tension that is cut off, w of a tie
that yields. A point without friction takes u_kn >= 0. Goulart & Chen, Clarabel: an interior-point solver for conic programs with quadratic
objectives, 2024.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, hstack, identity, vstack

from masonry_cd.limit.problem import LimitProblem
from masonry_cd.limit.solution import Optimum, Unbounded

TOLERANCE = 1e-7  # of gap and residuals over their scale; what is reached is in the certificate


@dataclass(frozen=True, eq=False)
class ConeProgramme:
    """min cost . x with matrix x + s = right, s in zero x nonnegative x second-order cones of three, in this order."""

    cost: np.ndarray
    matrix: csc_matrix
    right: np.ndarray
    lines: int  # rows of the nonnegative cone
    cones: np.ndarray  # (K,) points whose forces are the second-order cones
    smooth: np.ndarray  # (Z,) points without friction: the first rows of the nonnegative cone
    held: np.ndarray  # (C,) points whose tension is cut off


def cone_programme(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float) -> ConeProgramme:
    """The programme of the head of this file for loads (unknowns,)."""
    n, ties = problem.unknowns, len(problem.strength)
    held = np.flatnonzero(problem.tension < problem.apex)
    smooth, rough = np.flatnonzero(problem.mu == 0.0), np.flatnonzero(problem.mu > 0.0)
    yields = np.flatnonzero(np.isfinite(problem.strength))
    normal = problem.jacobian[0::3]
    cut = coo_matrix((np.ones(len(held)), (held, np.arange(len(held)))), (problem.points.count, len(held))).tocsr()
    cost = np.concatenate(
        [problem.jacobian.T @ problem.bond() - dead, [cap], (problem.tension - problem.apex)[held], problem.strength[yields]]
    )
    extra = len(cost) - n
    nothing = csr_matrix((len(smooth), 1 + len(yields)))
    first = hstack([csr_matrix(live[None]), csr_matrix(([1.0], ([0], [0])), (1, extra))])
    slip = hstack([-normal[smooth], nothing[:, :1], cut[smooth], nothing[:, 1:]])
    signs = hstack([csr_matrix((extra, n)), -identity(extra)])
    pull = csr_matrix((-np.ones(len(yields)), (yields, np.arange(len(yields)))), (ties, len(yields)))
    drawn = hstack([problem.bars, csr_matrix((ties, 1 + len(held))), pull])
    matrix = vstack([first, slip, signs, drawn, _cone_rows(problem, rough, cut, len(yields))], format="csc")
    right = np.zeros(matrix.shape[0])
    right[0] = 1.0
    return ConeProgramme(cost, matrix, right, len(smooth) + extra + ties, rough, smooth, held)


def _cone_rows(problem: LimitProblem, rough: np.ndarray, cut: csr_matrix, yields: int) -> csr_matrix:
    """Rows -((u_n - y) / mu, u_t) of the points with friction."""
    rows = (3 * rough[:, None] + np.arange(3)).ravel()
    scale = np.ones((len(rough), 3))
    scale[:, 0] = 1.0 / problem.mu[rough]
    weighted = problem.jacobian[rows].multiply(-scale.ravel()[:, None])
    lift = csr_matrix((scale[:, 0], (3 * np.arange(len(rough)), rough)), (3 * len(rough), problem.points.count)) @ cut
    nothing = csr_matrix((3 * len(rough), 1))
    return hstack([weighted, nothing, lift, csr_matrix((3 * len(rough), yields))], format="csr")


def solve_conic(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float) -> Optimum:
    """The largest factor up to ``cap``, for loads (unknowns,) that need not be the problem's own.

    Raises:
        Unbounded: no answer.
    """
    import clarabel

    programme = cone_programme(problem, dead, live, cap)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    cones = [clarabel.ZeroConeT(1), clarabel.NonnegativeConeT(programme.lines)]
    cones += [clarabel.SecondOrderConeT(3)] * len(programme.cones)
    size = len(programme.cost)
    solver = clarabel.DefaultSolver(csc_matrix((size, size)), programme.cost, programme.matrix, programme.right, cones, settings)
    answer = solver.solve()
    if str(answer.status) not in ("Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations"):
        raise Unbounded(f"Clarabel: {answer.status}")
    return _optimum(problem, programme, np.array(answer.x), np.array(answer.z), int(answer.iterations), f"Clarabel ({answer.status})")


def _optimum(problem: LimitProblem, programme: ConeProgramme, x: np.ndarray, z: np.ndarray, iterations: int, method: str) -> Optimum:
    """Forces and velocities out of the unknowns x and the multipliers z."""
    force = np.zeros((problem.points.count, 3))
    cones = z[1 + programme.lines :].reshape(-1, 3).copy()
    cones[:, 0] /= problem.mu[programme.cones]
    force[programme.cones] = cones
    force[programme.smooth, 0] = z[1 : 1 + len(programme.smooth)]
    force[:, 0] -= problem.apex
    ties = len(problem.strength)
    return Optimum(-float(z[0]), force, z[1 + programme.lines - ties : 1 + programme.lines], x[: problem.unknowns], iterations, method)
