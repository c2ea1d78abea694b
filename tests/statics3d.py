"""Static equilibrium of block structures in space by a linear programme, on the corners of their joints.

Every corner of a joint carries a force within a pyramid of four edges inside Coulomb's cone. If such forces balance the
weight of every free block, the structure can stand at rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.contact.find_joints import find_joints
from masonry_cd.model.blocks import Assembly, Block
from masonry_cd.model.joints import Joints


def assembled(blocks: Sequence[Block]) -> tuple[Assembly, Joints]:
    """The assembly and its joints."""
    assembly = Assembly.from_blocks(blocks, 0.6)
    return assembly, find_joints(assembly)


def in_one_piece(assembly: Assembly, joints: Joints) -> bool:
    """True when every block hangs together with every other, over joints."""
    graph = coo_matrix((np.ones(joints.count), (joints.block_a, joints.block_b)), (assembly.count, assembly.count))
    return bool(connected_components(graph, directed=False)[0] == 1)


def can_stand(blocks: Sequence[Block], mu: float, push: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> bool:
    """True when forces within the friction pyramids balance the weight of every free block.

    Args:
        mu: coefficient of friction.
        push: body force as a share of the weight, (0.1, 0, 0) is a tenth of g along x.
    """
    assembly, joints = assembled(blocks)
    free = np.cumsum(~assembly.fixed) - 1
    scale = float(np.median(assembly.mass))
    need = -(np.array(push) - [0.0, 0.0, 1.0]) * assembly.mass[:, None] / scale
    sizes = np.diff(joints.polygon_start)
    normal = np.repeat(joints.normal, sizes, axis=0)  # from a to b
    first = np.cross(normal, np.where(np.abs(normal[:, :1]) < 0.8, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    edges = np.stack([normal + side * mu * t for t in (first, second) for side in (-1.0, 1.0)], axis=1)  # (N, 4, 3) on b
    rows, cols, data = [], [], []
    column = np.arange(edges.shape[0] * 4).reshape(-1, 4)
    for sign, body in ((1.0, np.repeat(joints.block_b, sizes)), (-1.0, np.repeat(joints.block_a, sizes))):
        moving = ~assembly.fixed[body]
        arm = joints.polygon - assembly.centre[body]
        wrench = sign * np.concatenate([edges, np.cross(arm[:, None, :], edges)], axis=2)[moving]  # (n, 4, 6)
        rows.append((6 * free[body][moving][:, None, None] + np.arange(6) + np.zeros((1, 4, 1), dtype=int)).ravel())
        cols.append(np.repeat(column[moving].ravel(), 6))
        data.append(wrench.ravel())
    count = int((~assembly.fixed).sum())
    matrix = coo_matrix((np.concatenate(data), (np.concatenate(rows), np.concatenate(cols))), (6 * count, column.size)).tocsr()
    wanted = np.concatenate([need, np.zeros_like(need)], axis=1)[~assembly.fixed].ravel()
    answer = linprog(np.zeros(column.size), A_eq=matrix, b_eq=wanted, bounds=(0, None), method="highs-ipm")
    return bool(answer.status == 0)
