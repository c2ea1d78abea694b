# SPDX-License-Identifier: GPL-3.0-or-later
r"""A limit analysis of few rigid bodies, each of many blocks that move as one: a kinematic restriction of the problem of the blocks.

With the velocities q of the bodies, v = T q, and T the motion of a block as part of its body,

    v_i = V + W x (x_i - x_G),      omega_i = W,

equilibrium is asked of the bodies only, T^T (H^T r - G^T N + w_0 + lambda w_1) = 0, and joints within a body bear nothing and do not crush.
Its associated factor is at least that of the blocks. Six unknowns a body, three in a plane: milliseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import block_diag, coo_matrix, csr_matrix, identity
from scipy.sparse.linalg import spsolve

from masonry_cd.analysis.limit.interfaces import Interfaces
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.mechanics.model.blocks import Assembly


@dataclass(frozen=True, eq=False)
class RigidGroups:
    """A problem over bodies, and the way back to blocks."""

    problem: LimitProblem  # over the bodies; its ``free`` are the blocks still
    motion: csr_matrix  # T

    def of_blocks(self, velocity: np.ndarray) -> np.ndarray:
        """Velocities of the blocks, in the unknowns of their problem, from those of the bodies."""
        return np.asarray(self.motion @ velocity)

    def of_bodies(self, blocks: np.ndarray) -> np.ndarray:
        """Velocities of the bodies nearest to velocities (B, 6) of all blocks [m/s, rad/s]."""
        problem = self.problem
        scale = np.where(problem.columns < 3, 1.0, problem.length)
        moved = (blocks[problem.free][:, problem.columns] * scale).ravel()
        wanted = np.concatenate([moved, np.zeros(self.motion.shape[0] - len(moved))])
        return np.asarray(spsolve((self.motion.T @ self.motion).tocsc(), self.motion.T @ wanted))


def rigid_groups(problem: LimitProblem, assembly: Assembly, bodies: Sequence[np.ndarray]) -> RigidGroups:
    """The problem of some bodies.

    Args:
        problem: of the free blocks.
        assembly: of all blocks.
        bodies: numbers of the free blocks of each; blocks in none of them are bodies of their own.
    """
    body = _numbered(problem, assembly, bodies)
    owner = np.full(assembly.count, -1)
    owner[problem.free] = body
    ends = owner[problem.points.bodies]
    apart = np.flatnonzero(ends[:, 0] != ends[:, 1])
    bars, motion, sections = np.arange(len(problem.strength)), _motion(problem, assembly, body), problem.sections
    if sections is not None:
        crushes = np.isin(sections.joint, problem.points.joint[apart])
        bars = np.concatenate([bars[: problem.ties], problem.ties + np.flatnonzero(crushes[sections.cells.owner])])
        each = identity(problem.rates, format="csr")[:, np.repeat(crushes, 1 + sections.levers)]
        motion, sections = block_diag([motion, each], format="csr"), sections.only(crushes) if crushes.any() else None
    rows = (problem.directions * apart[:, None] + np.arange(problem.directions)).ravel()
    reduced = replace(
        problem, points=some_points(problem.points, apart), jacobian=(problem.jacobian[rows] @ motion).tocsr(),
        bars=(problem.bars[bars] @ motion).tocsr(), dead=motion.T @ problem.dead, live=motion.T @ problem.live, mu=problem.mu[apart],
        apex=problem.apex[apart], tension=problem.tension[apart], strength=problem.strength[bars], sections=sections,
    )  # fmt: skip
    return RigidGroups(reduced, motion)


def some_points(points: Interfaces, which: np.ndarray) -> Interfaces:
    """Some of the points of an analysis, by number or by a mask."""
    return Interfaces(
        joint=points.joint[which], bodies=points.bodies[which], point=points.point[which], frame=points.frame[which], mu=points.mu[which],
        apex=points.apex[which], tension=points.tension[which],
    )  # fmt: skip


def _numbered(problem: LimitProblem, assembly: Assembly, bodies: Sequence[np.ndarray]) -> np.ndarray:
    """(F,) the body of each free block."""
    of_block = np.full(assembly.count, -1)
    for number, blocks in enumerate(bodies):
        of_block[blocks] = number
    own = of_block[problem.free]
    alone = np.flatnonzero(own < 0)
    own[alone] = len(bodies) + np.arange(len(alone))
    return np.unique(own, return_inverse=True)[1]


def _motion(problem: LimitProblem, assembly: Assembly, body: np.ndarray) -> csr_matrix:
    """T, (n F, n G)."""
    count, columns = int(body.max()) + 1, problem.columns
    centre = assembly.centre[problem.free]
    weight = np.bincount(body)
    middle = np.stack([np.bincount(body, part, minlength=count) / weight for part in centre.T], axis=1)
    x, y, z = ((centre - middle[body]) / problem.length).T
    own = np.tile(np.eye(6), (len(body), 1, 1))
    own[:, 0, 4], own[:, 0, 5] = z, -y  # W x r over L
    own[:, 1, 3], own[:, 1, 5] = -z, x
    own[:, 2, 3], own[:, 2, 4] = y, -x
    own = own[:, columns[:, None], columns]
    size = len(columns)
    row = (size * np.arange(len(body))[:, None, None] + np.arange(size)[:, None]) + np.zeros(size, dtype=int)
    column = (size * body[:, None, None] + np.arange(size)) + np.zeros((size, 1), dtype=int)
    return coo_matrix((own.ravel(), (row.ravel(), column.ravel())), (size * len(body), size * count)).tocsr()
