# SPDX-License-Identifier: GPL-3.0-or-later
"""The problem of the blocks that move in a mechanism and of their neighbours, all others held: what a late round of a descent changes.

Held blocks bear whatever the points between them and the others bring, so that a pair found here is one of the structure only if the rest
has forces in equilibrium with it: the search solves for these once, at the end. A church of 544 blocks, 75 of which move, has a fifth of
its points near them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.rigid_groups import some_points
from masonry_cd.analysis.limit.solution import Optimum

MOVES = 1e-2  # share of the largest velocity from which on a block counts as moving: cone programmes leave less of it everywhere
FEW = 0.5  # share of the points up to which those near the blocks that move are looked at alone


@dataclass(frozen=True, eq=False)
class Neighbours:
    """A problem of some blocks, all others held, and its place in the problem of all."""

    problem: LimitProblem
    unknowns: np.ndarray  # (n,) of the problem of all
    points: np.ndarray  # (P,) of it

    def of_all(self, velocity: np.ndarray, count: int) -> np.ndarray:
        """Velocities (count,) of all blocks from those of some (n,)."""
        out = np.zeros(count)
        out[self.unknowns] = velocity
        return out

    def of_some(self, found: Optimum) -> Optimum:
        """Forces and velocities of these blocks from those of all; bars are left out."""
        return replace(found, force=found.force[self.points], velocity=found.velocity[self.unknowns], bars=np.zeros(0))


def neighbours(problem: LimitProblem, velocity: np.ndarray) -> Neighbours | None:
    """The blocks that move with velocities (unknowns,), and those that touch them; None where these are many, or joints crush."""
    n, m = len(problem.columns), problem.directions
    blocks = problem.unknowns // n
    speed = np.abs(velocity[: blocks * n]).reshape(blocks, n).max(axis=1)
    if problem.sections is not None or problem.moves_support:
        return None
    row, column = problem.jacobian.tocoo().coords
    touches = csr_matrix((np.ones(len(row)), (row // m, column // n)), shape=(problem.points.count, blocks))
    moving = (speed > MOVES * speed.max(initial=0.0)).astype(np.float64)
    near = touches.T @ (touches @ moving) > 0.0
    at = np.flatnonzero(touches @ near.astype(np.float64) > 0.0)
    if len(at) > FEW * problem.points.count:
        return None
    unknowns = (n * np.flatnonzero(near)[:, None] + np.arange(n)).ravel()
    bars = problem.bars[:, unknowns]
    pulls = np.flatnonzero(np.diff(bars.indptr))
    rows = (m * at[:, None] + np.arange(m)).ravel()
    some = replace(
        problem, points=some_points(problem.points, at), jacobian=problem.jacobian[rows][:, unknowns], bars=bars[pulls],
        dead=problem.dead[unknowns], live=problem.live[unknowns], mu=problem.mu[at], apex=problem.apex[at], tension=problem.tension[at],
        strength=problem.strength[pulls],
    )  # fmt: skip
    return Neighbours(some, unknowns, at)
