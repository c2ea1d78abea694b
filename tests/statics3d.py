# SPDX-License-Identifier: GPL-3.0-or-later
"""Static equilibrium of block structures in space, by the limit analysis of the program on the corners of its joints.

Every corner of a joint carries a force within Coulomb's cone. If such forces balance the weight of every free block, the structure can
stand at rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.analysis.limit.analysis import STANDS, at_rest
from masonry_cd.analysis.limit.problem import Bars, BlockLoads
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joints import Joints


def assembled(blocks: Sequence[Block]) -> tuple[Assembly, Joints]:
    """The assembly and its joints."""
    assembly = Assembly.from_blocks(blocks, 0.6)
    return assembly, find_joints(assembly)


def in_one_piece(assembly: Assembly, joints: Joints) -> bool:
    """True when every block hangs together with every other, over joints."""
    graph = coo_matrix((np.ones(joints.count), (joints.block_a, joints.block_b)), (assembly.count, assembly.count))
    return bool(connected_components(graph, directed=False)[0] == 1)


def can_stand(blocks: Sequence[Block], mu: float, push: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> bool:
    """True when forces within the friction cones balance the weight of every free block.

    Args:
        mu: coefficient of friction.
        push: body force as a share of the weight, (0.1, 0, 0) is a tenth of g along x.
    """
    assembly = Assembly.from_blocks(blocks, mu)
    dead = np.zeros((assembly.count, 6))
    dead[:, :3] = np.where(assembly.fixed, 0.0, assembly.mass)[:, None] * (np.array(push) - [0.0, 0.0, 1.0])
    _, found = at_rest(assembly, find_joints(assembly), BlockLoads(dead, np.zeros_like(dead), Bars.none()))
    return found.factor > 1.0 - STANDS
