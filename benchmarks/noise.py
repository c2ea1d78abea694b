# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise on the corners of blocks: the gaps and overlaps of micrometres that structures from files have.

Each block by itself is given a small random affine map

    x' = x + s (t + G (x - m) / e),        t (3,), G (3, 3) uniform in [-1, 1],

m and e being the middle and half the extents of its bounding box, and s such that the corner which moves most moves by the size of the
noise. It shifts, turns, stretches and shears the block, so faces stay planar, what is convex stays convex, and parts of one block fit.
Along axes that are left out nothing moves or varies: prisms along such an axis stay prisms, and a planar scene stays planar.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.compound_block import moved


def noisy(blocks: Sequence[Block], size: float, axes: str = "xyz", seed: int = 0) -> list[Block]:
    """The blocks, supports included, with corners that moved by up to a size [m] along some axes."""
    if size == 0.0:
        return list(blocks)
    free = np.array([axis in axes for axis in "xyz"])
    drawn = np.random.default_rng(seed).uniform(-1.0, 1.0, (len(blocks), 3, 4))
    return [_moved(block, size, own, free) for block, own in zip(blocks, drawn, strict=True)]


def _moved(block: Block, size: float, drawn: np.ndarray, free: np.ndarray) -> Block:
    """A block after its affine map; ``drawn`` (3, 4) holds t and G, ``free`` (3,) the axes that take part. No BLAS: the bits are the same
    on any machine."""
    low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
    middle, extent = 0.5 * (low + high), 0.5 * (high - low)

    def shift(points: np.ndarray) -> np.ndarray:
        r = (points - middle) / extent
        out = drawn[:, 0] + sum(drawn[:, 1 + j] * r[:, j, None] for j in range(3) if free[j])
        return np.where(free, out, 0.0)

    own = shift(block.vertices)
    scale = size / float(np.sqrt((own * own).sum(axis=1).max()))
    return moved(block, lambda points: points + scale * shift(points))
