# SPDX-License-Identifier: GPL-3.0-or-later
"""Static equilibrium of planar block structures by a linear programme, independent of the program's own contacts.

Joints are found as the common stretch of two straight sides; each end of a stretch carries a force within Coulomb's
friction angle. If no such forces balance the weights, the structure falls; if there are, it can stand at rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.polygon import polygon_centroid


def section(block: Block) -> np.ndarray:
    """The polygon (n, 2) in the x-z plane of a prism along y."""
    return block.vertices[: len(block.vertices) // 2][:, [0, 2]]


def stretches(blocks: Sequence[Block], tolerance: float = 1e-9) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Common stretches of sides: block, block, its two ends (2, 2), and the normal (2,) out of the second into the first."""
    start, end, owner = [], [], []
    for i, block in enumerate(blocks):
        polygon = section(block)
        start.append(polygon)
        end.append(np.roll(polygon, -1, axis=0))
        owner += [i] * len(polygon)
    a, b, own = np.concatenate(start), np.concatenate(end), np.array(owner)
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)  # outward, the polygons run counter-clockwise
    found = []
    for e in range(len(a)):
        height = np.abs((a - a[e]) @ normal[e]) + np.abs((b - a[e]) @ normal[e])
        low, high = (b - a[e]) @ along[e], (a - a[e]) @ along[e]
        opposite = (normal @ normal[e] < 0) & (height < 1e-7) & (own > own[e])
        shared = np.minimum(high, length[e]) - np.maximum(low, 0.0)
        for f in np.flatnonzero(opposite & (shared > tolerance)):
            stretch = [max(low[f], 0.0), min(high[f], length[e])]
            found.append((int(own[f]), int(own[e]), a[e] + np.outer(stretch, along[e]), normal[e]))
    return found


def can_stand(blocks: Sequence[Block], mu: float) -> bool:
    """True when forces within the friction angle balance the weight of every free block."""
    free = {i: n for n, i in enumerate(i for i, block in enumerate(blocks) if not block.fixed)}
    centre = [polygon_centroid(section(block)) for block in blocks]
    weight = np.zeros((len(free), 3))
    for i, n in free.items():
        weight[n, 1] = mass_properties(blocks[i].vertices, blocks[i].faces).volume
    rows, cols, data, column = [], [], [], 0
    edges = np.array([[mu, 1.0], [-mu, 1.0]])  # the two edges of the friction cone, as tangent and normal parts
    for first, second, ends, normal in stretches(blocks):
        frame = np.array([[normal[1], -normal[0]], normal])
        for point in ends:
            for force in edges @ frame:
                for body, sign in ((first, 1.0), (second, -1.0)):
                    if body in free:
                        arm = point - centre[body]
                        rows += [3 * free[body] + k for k in range(3)]
                        cols += [column] * 3
                        data += [sign * force[0], sign * force[1], sign * (arm[0] * force[1] - arm[1] * force[0])]
                column += 1
    matrix = coo_matrix((data, (rows, cols)), (3 * len(free), column)).tocsr()
    answer = linprog(np.zeros(column), A_eq=matrix, b_eq=weight.ravel(), bounds=(0, None), method="highs")
    return bool(answer.status == 0)
