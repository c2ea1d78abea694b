# SPDX-License-Identifier: GPL-3.0-or-later
r"""The linear and second-order cone programmes of limit analysis: one builder, in a plane and in space.

The kinematic form is solved. Its unknowns are the velocities v of the blocks and few more; its multipliers are the forces. With u = H v at
the points k, K the cone |y| <= x,

    min  c . v + cap t + sum_k (f_k - a_k) y_k + N_y . w      w_1 . v + t = 1,      ((u_kn - y_k)/mu_k, u_kt) in K,      G v <= w,

c = -w_0 + H^T (a n), and t, y, w >= 0: t is the multiplier of the cap on lambda, y_k of a tension that is cut off, w of a tie that yields.
Every row of forces is -(F_R . u - F_Rn y) for a force F_R, so that multipliers z are the forces r' = F z and prices p of forces are right
sides F^T p. F has

    n + mu t and n - mu t      of points in a plane: shares of the edges of Coulomb's cone, a linear programme,
    (n / mu, t_1, t_2)         of points in space: a second-order cone,
    n                          of points without friction.

**Strips** |r_kt| <= s_k in place of the cones, whatever the normal force, have F = n and t, -t in a plane or (0, t_1, t_2) in space, and
z_k >= |u_kt| as unknowns whose work is s_k z_k: what slides in them opens nothing.

**Prices** of forces, p_k . r'_k + q . N, added to a factor that is now the least, take w_1 . v + t = -1 and the right sides F^T p and q.

Linear programmes are solved in the multipliers, by the dual simplex of HiGHS (Huangfu & Hall, Math. Prog. Comp. 10, 2018), exactly; cone
programmes by Clarabel (Goulart & Chen, Clarabel: an interior-point solver for conic programs with quadratic objectives, 2024).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, hstack, identity, vstack
from scipy.sparse.linalg import norm

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.solution import Optimum, Unbounded
from masonry_cd.foundation.extras import require

EXACT = 1e-10  # feasibility of linear programmes
TOLERANCE = 1e-8  # of residuals and gap of cone programmes, over their scale
MOST = 75  # iterations of Clarabel, which takes 30 to 70; one that ends there is reported
ENDED = ("Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations")  # with an answer
MANY = 20_000  # multipliers from which HiGHS' interior point method is faster than its simplex


@dataclass(frozen=True, eq=False)
class Programme:
    """min cost . x with matrix x + s = right, where s is zero in the first row, then nonnegative, then in cones of three rows."""

    problem: LimitProblem
    cost: np.ndarray  # (n,)
    matrix: csc_matrix  # (R, n)
    right: np.ndarray  # (R,)
    forces: csr_matrix  # (P m, R) F, zero in rows that are no forces
    bars: np.ndarray  # (T,) rows whose multipliers are the forces of bars
    cones: int  # second-order cones at the end
    points: np.ndarray  # (K,) points that have friction, whose strips are the last unknowns
    sense: float = 1.0  # 1: the largest factor, -1: the least

    def within(self, strip: np.ndarray) -> Programme:
        """The programme of strips s (P,), of one that has strips."""
        cost = self.cost.copy()
        cost[len(cost) - len(self.points) :] = strip[self.points]
        return replace(self, cost=cost)

    def for_the_least(self) -> Programme:
        """The programme of the least factor in place of the largest."""
        signs = np.ones(self.matrix.shape[1])
        signs[: self.problem.unknowns] = -1.0
        first = self.matrix[:1].multiply(signs[None])
        return replace(self, matrix=vstack([first, self.matrix[1:]], format="csc"), sense=-1.0)

    def priced(self, prices: np.ndarray, of_bars: np.ndarray | None = None) -> Programme:
        """The programme of the least lambda + prices (P, m) times r' + ``of_bars`` (T,) times N, of one of the least lambda."""
        right = self.right + self.forces.T @ prices.ravel()
        if of_bars is not None:
            right[self.bars] = of_bars
        return replace(self, right=right)

    def solved(self, refined: bool = True) -> Optimum:
        """The best velocities and forces.

        Args:
            refined: let Clarabel refine the solutions of its linear systems, which takes half of the time; otherwise where it fails only.

        Raises:
            Unbounded: there is no answer, or the solver found none.
        """
        if not self.cones:
            return self._by_simplex()
        answer = self._by_clarabel(refined)
        if not refined and str(answer.status) != "Solved":
            answer = self._by_clarabel(True)
        status = str(answer.status)
        if status not in ENDED:
            raise Unbounded(f"Clarabel: {status}")
        facts = int(answer.iterations), f"Clarabel ({status})", "" if status == "Solved" else status
        return self._optimum(np.array(answer.x) / self.measure, np.array(answer.z), facts)

    @property
    def measure(self) -> float:
        """The size of velocities for a solver, near one as forces are: w_1 . v is |w_1|, or less where prices are high."""
        return float(norm(self.matrix[0])) / max(float(np.abs(self.right).max()), 1.0)

    def _by_simplex(self) -> Optimum:
        """The answer of HiGHS: the least right . z with matrix^T z = -cost and z >= 0 but in the first row."""
        bounds = np.zeros((len(self.right), 2))
        bounds[:, 1] = np.inf
        bounds[0, 0] = -np.inf
        inner = len(self.right) > MANY
        answer = linprog(
            self.right, A_eq=self.matrix.T, b_eq=-self.cost, bounds=bounds, method="highs-ipm" if inner else "highs-ds",
            options={"primal_feasibility_tolerance": EXACT, "dual_feasibility_tolerance": EXACT},
        )  # fmt: skip
        if answer.status != 0:
            raise Unbounded(answer.message)
        method = f"HiGHS {'interior point' if inner else 'dual simplex'}"
        return self._optimum(np.asarray(answer.eqlin.marginals), answer.x, (int(answer.nit), method, ""))

    def _by_clarabel(self, refined: bool) -> Any:
        """The answer of Clarabel."""
        require("a limit analysis in space", "clarabel")
        import clarabel

        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_iter = MOST
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
        settings.iterative_refinement_enable = refined
        settings.direct_solve_method, settings.max_threads = "faer", 1  # supernodal; one thread: the same bits everywhere
        lines, size = len(self.right) - 1 - 3 * self.cones, len(self.cost)
        cones = [clarabel.ZeroConeT(1), clarabel.NonnegativeConeT(lines), *[clarabel.SecondOrderConeT(3)] * self.cones]
        right = self.measure * self.right
        return clarabel.DefaultSolver(csc_matrix((size, size)), self.cost, self.matrix, right, cones, settings).solve()

    def _optimum(self, x: np.ndarray, z: np.ndarray, facts: tuple[int, str, str]) -> Optimum:
        """Forces and velocities from unknowns and multipliers."""
        problem = self.problem
        force = (self.forces @ z).reshape(-1, problem.directions)
        force[:, 0] -= problem.apex
        return Optimum(-self.sense * float(z[0]), force, z[self.bars], x[: problem.unknowns], *facts)


def programme(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float, strips: bool = False) -> Programme:
    """The programme of the largest factor up to ``cap`` under loads (unknowns,), with Coulomb's cones or with strips of width zero."""
    ties, count, m = len(problem.strength), problem.points.count, problem.directions
    held = np.flatnonzero(problem.tension < problem.apex)
    yields = np.flatnonzero(np.isfinite(problem.strength))
    rough = np.flatnonzero(problem.mu > 0.0)
    edges, cones = _strip_forces(problem, rough) if strips else _cone_forces(problem, rough)
    wide = len(rough) if strips else 0
    extra = 1 + len(held) + len(yields) + wide
    cost = [problem.jacobian.T @ problem.bond() - dead, [cap], (problem.tension - problem.apex)[held], problem.strength[yields]]
    cost.append(np.zeros(wide))
    lift = coo_matrix((np.ones(len(held)), (m * held, 1 + np.arange(len(held)))), (count * m, extra)).tocsr()
    sizes = _strip_sizes(problem, edges.shape[1], wide, extra) if strips else None
    rows = [hstack([-(part.T @ problem.jacobian), part.T @ lift]) for part in (edges, cones)]
    if sizes is not None:
        rows = [row + size for row, size in zip(rows, sizes, strict=True)]
    first = hstack([csr_matrix(live[None]), csr_matrix(([1.0], ([0], [0])), (1, extra))])
    signs = hstack([csr_matrix((extra, problem.unknowns)), -identity(extra)])
    pull = coo_matrix((-np.ones(len(yields)), (yields, 1 + len(held) + np.arange(len(yields)))), (ties, extra))
    matrix = vstack([first, rows[0], signs, hstack([problem.bars, pull]), rows[1]], format="csc")
    right = np.zeros(matrix.shape[0])
    right[0] = 1.0
    between = csr_matrix((count * m, extra + ties))
    forces = hstack([csr_matrix((count * m, 1)), edges, between, cones], format="csr")
    bars = 1 + edges.shape[1] + extra + np.arange(ties)
    return Programme(problem, np.concatenate(cost), matrix, right, forces, bars, cones.shape[1] // 3, rough[:wide])


def _cone_forces(problem: LimitProblem, rough: np.ndarray) -> tuple[csr_matrix, csr_matrix]:
    """(P m, E) edges of the cones, or normals without friction, and (P m, 3 K) the axes of second-order cones."""
    smooth = np.setdiff1d(np.arange(problem.points.count), rough)
    if problem.axis is None:
        axes = np.stack([1.0 / problem.mu[rough], np.ones(len(rough)), np.ones(len(rough))], axis=1)
        return _normals(problem, smooth), _forces(problem, np.repeat(rough, 3), np.tile(np.arange(3), len(rough)), axes.ravel())
    lean = np.stack([problem.mu[rough], -problem.mu[rough]], axis=1).ravel()
    normal = _normals(problem, np.repeat(rough, 2))
    tangent = _forces(problem, np.repeat(rough, 2), np.ones(2 * len(rough), dtype=np.int64), lean)
    return hstack([normal + tangent, _normals(problem, smooth)], format="csr"), csr_matrix((problem.points.count * 2, 0))


def _strip_forces(problem: LimitProblem, rough: np.ndarray) -> tuple[csr_matrix, csr_matrix]:
    """(P m, E) normals of all points, in a plane with both tangents behind them, and (P m, 3 K) second-order cones without normals."""
    normals = _normals(problem, np.arange(problem.points.count))
    if problem.axis is None:
        tangents = np.tile([0.0, 1.0, 1.0], len(rough))
        return normals, _forces(problem, np.repeat(rough, 3), np.tile(np.arange(3), len(rough)), tangents)
    both = _forces(problem, np.repeat(rough, 2), np.ones(2 * len(rough), dtype=np.int64), np.tile([1.0, -1.0], len(rough)))
    return hstack([normals, both], format="csr"), csr_matrix((problem.points.count * 2, 0))


def _strip_sizes(problem: LimitProblem, edges: int, wide: int, extra: int) -> tuple[csr_matrix, csr_matrix]:
    """The part of z_k in the rows of strips, over all unknowns: rows of edges, and of cones."""
    column = problem.unknowns + extra - wide + np.arange(wide)
    shape = problem.unknowns + extra
    if problem.axis is None:
        return csr_matrix((edges, shape)), csr_matrix((-np.ones(wide), (3 * np.arange(wide), column)), (3 * wide, shape))
    row = problem.points.count + np.arange(2 * wide)
    return csr_matrix((-np.ones(2 * wide), (row, np.repeat(column, 2))), (edges, shape)), csr_matrix((0, shape))


def _normals(problem: LimitProblem, points: np.ndarray) -> csr_matrix:
    """(P m, N) normal forces of one at points, in their order."""
    return _forces(problem, points, np.zeros(len(points), dtype=np.int64), np.ones(len(points)))


def _forces(problem: LimitProblem, point: np.ndarray, direction: np.ndarray, size: np.ndarray) -> csr_matrix:
    """(P m, N) forces of a size at a point along a direction of its frame each."""
    m = problem.directions
    return csr_matrix((size, (m * point + direction, np.arange(len(point)))), (m * problem.points.count, len(point)))


def largest(problem: LimitProblem, dead: np.ndarray, live: np.ndarray, cap: float) -> Optimum:
    """The largest factor up to ``cap``, for loads (unknowns,) that need not be the problem's own.

    Raises:
        Unbounded: no forces bear the dead loads with any factor up to ``cap``.
    """
    return programme(problem, dead, live, cap).solved()


def least_unborne(problem: LimitProblem) -> Optimum:
    """The forces that leave least of the loads unborne, where no factor bears them all, and how blocks then begin to fall.

    The least sum of what is left, over all components, under any factor; dual to it is the fastest fall, max w_0 . v with w_1 . v = 0 and
    no component of v above one: the load neither helps nor hinders it.

    Raises:
        Unbounded: no answer of the solver.
    """
    made, n = programme(problem, problem.dead, problem.live, 1.0), problem.unknowns
    matrix, opens = made.matrix.tolil(), made.forces.shape[1] - 3 * made.cones
    matrix[0, n] = 0.0  # without a cap, w_1 . v has no slack
    one = hstack([identity(n), csr_matrix((n, matrix.shape[1] - n))])
    rows = vstack([matrix[:opens], one, -one, matrix[opens:]], format="csc")
    right = np.concatenate([np.zeros(opens), np.ones(2 * n), np.zeros(3 * made.cones)])
    empty = csr_matrix((made.forces.shape[0], 2 * n))
    forces = hstack([made.forces[:, :opens], empty, made.forces[:, opens:]], format="csr")
    return replace(made, matrix=rows, right=right, forces=forces).solved()
