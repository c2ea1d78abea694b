# SPDX-License-Identifier: GPL-3.0-or-later
r"""Limit analysis in space with circular friction cones, as a second-order cone programme, by Clarabel.

The kinematic form is solved, whose unknowns are the velocities of the blocks, six each, and few more; Clarabel's dual variables are the
forces. With K the cone |y| <= x, over all points k,

    min  c . v + cap t + sum_k (f_k - a_k) y_k + N_y . w      w_1 . v + t = 1,      ((u_kn - y_k)/mu_k, u_kt) in K,      G v <= w,

c = -w_0 + H^T (a n), u = H v, and t, y, w >= 0: t is the multiplier of the cap on lambda, y_k of a tension that is cut off, w of a tie
that yields. A point without friction takes u_kn - y_k >= 0.

**Strips** instead of cones, |r_kt| <= s_k whatever the normal force, take u_kn - y_k >= 0 and (z_k, u_kt) in K with s_k z_k as their work:
they slide and open nothing. **Prices** of forces, p_k . r'_k + q . N, added to a factor that is now the least, take

    w_1 . v + t = -1,    ((u_kn - y_k + p_kn)/mu_k, u_kt + p_kt) in K,    G v <= w + q.

Goulart & Chen, Clarabel: an interior-point solver for conic programs with quadratic objectives, 2024.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, hstack, identity, vstack

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import Optimum, Unbounded
from masonry_cd.foundation.extras import require

TOLERANCE = 1e-8  # of residuals and gap over their scale
MOST = 75  # iterations: churches of 5,000 blocks end there with a factor that holds to four digits; the certificate has what is reached
ENDED = ("Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations")  # with an answer


@dataclass(frozen=True, eq=False)
class ConeProgramme:
    """min cost . x with matrix x + s = right, s in zero x nonnegative x second-order cones of three, in this order."""

    cost: np.ndarray
    matrix: csc_matrix
    right: np.ndarray
    normals: csr_matrix  # (3 P, E) of the points whose normal forces are the first E rows of the nonnegative cone
    lines: int  # rows of the nonnegative cone
    cones: np.ndarray  # (K,) points whose forces are the second-order cones
    strips: bool  # whether only their tangential parts are
    sense: float  # 1: the largest factor, -1: the least


def cone_programme(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float, strip: np.ndarray | None = None) -> ConeProgramme:
    """The programme of the head of this file for loads (unknowns,), with cones or with strips s (P,)."""
    n, ties, count = problem.unknowns, len(problem.strength), problem.points.count
    held = np.flatnonzero(problem.tension < problem.apex)
    cones = np.flatnonzero(problem.mu > 0.0)
    normals = _normals(problem, strip is not None)
    yields = np.flatnonzero(np.isfinite(problem.strength))
    cut = csr_matrix((np.ones(len(held)), (held, np.arange(len(held)))), (count, len(held)))
    wide = np.zeros(0) if strip is None else strip[cones]
    cost = [problem.jacobian.T @ problem.bond() - dead, [cap], (problem.tension - problem.apex)[held], problem.strength[yields], wide]
    extra = 1 + len(held) + len(yields) + len(wide)
    first = hstack([csr_matrix(live[None]), csr_matrix(([1.0], ([0], [0])), (1, extra))])
    lift = hstack([csr_matrix((count, 1)), cut, csr_matrix((count, len(yields) + len(wide)))], format="csr")
    opens = hstack([-(normals.T @ problem.jacobian), normals[0::3].T @ lift])
    signs = hstack([csr_matrix((extra, n)), -identity(extra)])
    pull = coo_matrix((-np.ones(len(yields)), (yields, 1 + len(held) + np.arange(len(yields)))), (ties, extra))
    rows = _cone_rows(problem, cones, lift) if strip is None else _strip_rows(problem, cones, extra)
    matrix = vstack([first, opens, signs, hstack([problem.bars, pull]), rows], format="csc")
    right = np.zeros(matrix.shape[0])
    right[0] = 1.0
    return ConeProgramme(np.concatenate(cost), matrix, right, normals, normals.shape[1] + extra + ties, cones, strip is not None, 1.0)


def _normals(problem: LimitProblem, strips: bool) -> csr_matrix:
    """Unit forces (3 P, E) along the normals of points without friction, with strips of all points."""
    point = np.flatnonzero((problem.mu == 0.0) | strips)
    return csr_matrix((np.ones(len(point)), (3 * point, np.arange(len(point)))), (3 * problem.points.count, len(point)))


def _cone_rows(problem: LimitProblem, rough: np.ndarray, lift: csr_matrix) -> csr_matrix:
    """Rows -((u_n - y) / mu, u_t) of the points with friction."""
    scale = np.ones((len(rough), 3))
    scale[:, 0] = 1.0 / problem.mu[rough]
    weighted = problem.jacobian[_rows_of(rough)].multiply(-scale.ravel()[:, None])
    raised = csr_matrix((scale[:, 0], (3 * np.arange(len(rough)), rough)), (3 * len(rough), problem.points.count)) @ lift
    return hstack([weighted, raised], format="csr")


def _strip_rows(problem: LimitProblem, rough: np.ndarray, extra: int) -> csr_matrix:
    """Rows -(z, u_t) of the points with friction; z are the last of the extra unknowns."""
    tangent = np.ones((len(rough), 3))
    tangent[:, 0] = 0.0
    moved = problem.jacobian[_rows_of(rough)].multiply(-tangent.ravel()[:, None])
    place = (3 * np.arange(len(rough)), extra - len(rough) + np.arange(len(rough)))
    return hstack([moved, csr_matrix((-np.ones(len(rough)), place), (3 * len(rough), extra))], format="csr")


def _rows_of(points: np.ndarray) -> np.ndarray:
    return (3 * points[:, None] + np.arange(3)).ravel()


def with_strips(programme: ConeProgramme, strip: np.ndarray) -> ConeProgramme:
    """A programme with strips s (P,), of others."""
    cost = programme.cost.copy()
    cost[len(cost) - len(programme.cones) :] = strip[programme.cones]
    return replace(programme, cost=cost)


def for_the_least(problem: LimitProblem, programme: ConeProgramme) -> ConeProgramme:
    """The programme of the least factor in place of the largest."""
    matrix = programme.matrix.copy()
    matrix.data[: matrix.indptr[problem.unknowns]][matrix.indices[: matrix.indptr[problem.unknowns]] == 0] *= -1.0
    return replace(programme, matrix=matrix, sense=-1.0)


def priced(problem: LimitProblem, programme: ConeProgramme, prices: np.ndarray, of_bars: np.ndarray | None = None) -> ConeProgramme:
    """The programme of the least lambda + prices (P, 3) times r' + ``of_bars`` (T,) times N, of one of the least lambda with cones."""
    right = programme.right.copy()
    asked = prices[programme.cones].copy()
    asked[:, 0] /= problem.mu[programme.cones]
    right[1 : 1 + programme.normals.shape[1]] = programme.normals.T @ prices.ravel()
    right[1 + programme.lines :] = asked.ravel()
    if of_bars is not None:
        right[1 + programme.lines - len(of_bars) : 1 + programme.lines] = of_bars
    return replace(programme, right=right)


def least_unborne_in_space(problem: LimitProblem) -> Optimum:
    """As :func:`masonry_cd.analysis.limit.linear.least_unborne`, with cones: max w_0 . v with w_1 . v = 0, no component of v above one.

    Raises:
        Unbounded: no answer.
    """
    programme, n = cone_programme(problem, problem.dead, problem.live, 1.0), problem.unknowns
    matrix, right, opens = programme.matrix.tolil(), programme.right.copy(), 1 + programme.normals.shape[1]
    matrix[0, n] = 0.0  # without a cap, w_1 . v has no slack
    right[0] = 0.0
    one = hstack([identity(n), csr_matrix((n, matrix.shape[1] - n))])
    rows = vstack([matrix[:opens], one, -one, matrix[opens:]], format="csc")
    right = np.concatenate([right[:opens], np.ones(2 * n), right[opens:]])
    return solve_programme(problem, replace(programme, matrix=rows, right=right, lines=programme.lines + 2 * n))


def solve_conic(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float) -> Optimum:
    """The largest factor up to ``cap``, for loads (unknowns,) that need not be the problem's own.

    Raises:
        Unbounded: no answer.
    """
    return solve_programme(problem, cone_programme(problem, dead, live, cap))


def solve_programme(problem: LimitProblem, programme: ConeProgramme) -> Optimum:
    """By Clarabel.

    Raises:
        Unbounded: no answer.
    """
    return _optimum(problem, programme, _solved(programme, True))


def solve_quickly(problem: LimitProblem, programme: ConeProgramme) -> Optimum:
    """By Clarabel without the refinement of its linear systems, which takes half of the time; with it where that fails.

    Raises:
        Unbounded: no answer.
    """
    answer = _solved(programme, False)
    if str(answer.status) != "Solved":
        return solve_programme(problem, programme)
    return _optimum(problem, programme, answer)


def _solved(programme: ConeProgramme, refined: bool) -> Any:
    """The answer of Clarabel."""
    require("a limit analysis in space", "clarabel")
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = MOST
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    settings.iterative_refinement_enable = refined
    cones = [clarabel.ZeroConeT(1), clarabel.NonnegativeConeT(programme.lines)]
    cones += [clarabel.SecondOrderConeT(3)] * len(programme.cones)
    size = len(programme.cost)
    solver = clarabel.DefaultSolver(csc_matrix((size, size)), programme.cost, programme.matrix, programme.right, cones, settings)
    return solver.solve()


def _optimum(problem: LimitProblem, programme: ConeProgramme, answer: Any) -> Optimum:
    """Forces and velocities of an answer.

    Raises:
        Unbounded: it is none.
    """
    if str(answer.status) not in ENDED:
        raise Unbounded(f"Clarabel: {answer.status}")
    x, z = np.array(answer.x), np.array(answer.z)
    force = (programme.normals @ z[1 : 1 + programme.normals.shape[1]]).reshape(-1, 3)
    inside = z[1 + programme.lines :].reshape(-1, 3)
    if not programme.strips:
        force[programme.cones, 0] += inside[:, 0] / problem.mu[programme.cones]
    force[programme.cones, 1:] += inside[:, 1:]
    force[:, 0] -= problem.apex
    bars = z[1 + programme.lines - len(problem.strength) : 1 + programme.lines]
    name, stopped = f"Clarabel ({answer.status})", "" if str(answer.status) == "Solved" else str(answer.status)
    return Optimum(-programme.sense * float(z[0]), force, bars, x[: problem.unknowns], int(answer.iterations), name, stopped)
