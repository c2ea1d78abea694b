# SPDX-License-Identifier: GPL-3.0-or-later
r"""Alternating directions (ADMM): with one sparse solve an iteration propagates the error through the whole structure.

With De Saxce's shift s = mu |u_t| n the problem reads: u + s in K*, p in K, orthogonal. The augmented Lagrangian of the convex
problem with s held (Cadoux, Ph.D. thesis, Grenoble 2009; Boyd et al., Found. Trends Mach. Learn. 3, 2011), split at z = H v + b + s,
gives two steps, here with the auxiliary z eliminated and s renewed in each:

    p+ = P_K( p - R (u + s) ),     u = H v + b,
    (M + H^T R H) (v+ - v) = M (v_free - v) + H^T (2 p+ - p).

At a fixed point M (v - v_free) = H^T p and p = P_K(p - R (u + s)), whatever R and whatever stands in the brackets on the left: the
matrix may be an old one, and R may change between iterations. R = diag(k / d_c), d_c = trace(W_cc) / m, makes k a pure number.

**Elastic contacts** have w = u + C p in place of u in the law. The first step is then the projection in the norm of R^-1 + C,

    p+ = P_K( p - S (w + s) ),     S^-1 = R^-1 + C,

and the second stays as it is. Where everything sticks an iteration leaves (1 + a^2 c) / ((1 + a c)(1 + a)) of the error, a = 1 / (R C),
c = C / W: least at R = (C W)^-1/2 if C > W. So R^-1 = d / k + C (1 + C / d)^-1/2 with the d of W alone and the mean of C.

**The answer.** p+ obeys the law's cones and v+ nearly its velocities. The impulses that belong to v+ follow from the second step,

    p^ = 2 p+ - p - R H (v+ - v),     M (v+ - v_free) = H^T p^.

They are a little outside the cones, and their map error is 5 to 20 times less than that of p+: they are the answer. The start is the
impulses of the last step and their velocities; where their map error is above 1, as where contacts rattle, the velocities before the step.

**Choice of k.** A large k holds closed joints together at once, but a contact that has to open or to slip then takes many iterations to do
so: structures at rest want 1e4, churches that rattle 1 to 10. So: start at 1e4; where an iteration has not won a factor of 10 in 40
iterations, or is worse off after 20, look at the map error of the pair (p+, v+), which is what R is to make small, as a share of that of
p^. If it is nearly all, k grows by 5; if little, k falls with its square root. It also falls where the limit of iterations ends a step too
early. And over a run a neighbouring k is tried now and then and kept if it took fewer iterations.

**Where much slides** (k < 300) a rigid contact has k / d_c if it sticks, a tenth of that if it is open and three tenths if it slides, by
the trial impulse p - R (u + s) when the matrix is factorised: a third fewer iterations. And while the error is large the iteration is
relaxed, it goes on from p + a (p+ - p) and v + a (v+ - v), with the same fixed points for any a between 0 and 2 (Eckstein & Bertsekas,
Math. Program. 55, 1992): a quarter less.

**Cost.** The factorisation costs as much as ten to fifty iterations and is kept from step to step until k or the contacts ask for another.
To measure the error costs as much as one or two iterations; the change of p, which costs nothing, tells when to, by the ratio of the two
as measured last, if need be in the step before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.friction.problem import Problem, Solution, first_impulse
from masonry_cd.mechanics.friction.solver_state import Learnt
from masonry_cd.mechanics.linalg.threads import run_by_team
from masonry_cd.mechanics.solvers.admm_kernels import admm_bodies
from masonry_cd.mechanics.solvers.admm_workspace import AdmmSettings, KeptFactors, room_of_workspace
from masonry_cd.mechanics.solvers.options import Options
from masonry_cd.mechanics.solvers.recall import recall

LIMIT = 2000  # iterations
OPEN, SLIDES = 0.1, 0.3  # shares of R of contacts that do not stick, where much slides
PROBE = 40  # steps between two trials of a neighbouring k
NEIGHBOUR = 3.0  # factor between neighbouring k
BETTER = 0.8  # share of the mean iterations below which a trial wins


def next_k(learnt: Learnt) -> float:
    """The k of the next step: the best so far, and now and then one next to it."""
    if learnt.steps % PROBE == PROBE - 1:
        return learnt.k * (NEIGHBOUR if learnt.steps // PROBE % 2 else 1.0 / NEIGHBOUR)
    return learnt.k


def learn(learnt: Learnt, k: float, k_end: float, iterations: int, rate: float) -> Learnt:
    """Learn from a step that began with k and ended with k_end, and with an error of ``rate`` over the change of p."""
    steps, best, mean = learnt.steps + 1, learnt.k, learnt.mean_iterations
    if k_end != k:  # it had to change on the way
        return replace(learnt, steps=steps, k=k_end, stale=True, mean_iterations=0.0, rate=rate)
    if k != best:  # a trial
        if iterations >= BETTER * mean:
            return replace(learnt, steps=steps, stale=True, rate=rate)
        best, mean = k, float(iterations)
    mean = 0.8 * mean + 0.2 * iterations if mean else float(iterations)
    return Learnt(best, False, steps, mean, rate, learnt.budget)


def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
    """Iterate until the natural map error is below the tolerance, or the limit is reached; the best iterate is returned.

    Args:
        problem: over bodies, or in the impulses alone.
        options: ``max_iterations`` counts iterations (one sparse solve each).
        start: its impulse (C, m) is the first iterate, with its velocity or else that of the impulses; its memory that of the step before.
    """
    impulse, limit = first_impulse(problem, start), options.limit(LIMIT)
    given = problem.arrays()
    moving = start is not None and start.velocity is not None
    velocity = start.velocity.copy() if start is not None and start.velocity is not None else np.empty(problem.v_free.shape)
    state, factors, elimination = recall(problem, start)
    symbolic, learnt, k = factors.pattern.symbolic, state.learnt, next_k(state.learnt)
    settings = AdmmSettings(k, (OPEN, SLIDES), learnt.stale or k != learnt.k, moving, learnt.rate, options.tolerance, limit)
    kept = KeptFactors(symbolic, factors.squares, factors.panels, factors.rho)
    threads = min(options.threads, int(symbolic.level[1]))  # as many as there are subtrees at first, at most
    values = np.zeros(room_of_workspace(given, elimination, kept) if threads > 1 else 0)
    iterations, error, k_end, rate = run_by_team(admm_bodies, threads, given, elimination, kept, settings, impulse, velocity, values)
    state = state.with_learnt(learn(learnt, k, k_end, iterations, rate))
    end = "given up" if iterations < limit else "iteration limit reached"  # without hope, or without a definite matrix
    return Solution(impulse, velocity, iterations, options.reason("admm", error, end), state, error)
