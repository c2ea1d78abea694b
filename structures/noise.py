# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise on the vertices: the gaps and overlaps of micrometres that structures from files have, on the blocks of any kind.

Each block by itself is given a small random affine map

    x' = x + s (t + G (x - m) / e),        t (3,), G (3, 3) uniform in [-1, 1],

m and e being the middle and half the extents of its bounding box, and s such that the corner which moves most moves by the size of the
noise. It shifts, turns, stretches and shears the block, so faces stay planar, what is convex stays convex, and parts of one block fit.
Along axes that are left out nothing moves or varies: prisms along such an axis stay prisms, and a planar scene stays planar.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Assembly, Block, refuse_spheres
from masonry_cd.mechanics.model.middle_plane import middle_plane
from structures.geometry.compound_block import moved
from structures.schema import Height, Table

LARGEST = 1e-4  # share of the shortest edge: gaps stay a fifth of what contact detection takes for a joint that is open


class NoiseTable(Table):
    """The table ``[structure.noise]``."""

    size: Height
    """by which the corner of each block that moves most is moved"""
    seed: int = Field(0, ge=0, lt=2**63)
    """of the random numbers"""
    axes: Literal["x", "y", "z", "xy", "xz", "yz", "xyz"] | None = None
    """along which corners move; by default x and z, or y and z, where that keeps the structure planar, else all three"""


def with_noise(blocks: Sequence[Block], table: object) -> tuple[list[Block], list[str]]:
    """Move the vertices of all blocks, supports included.

    Args:
        blocks: checked.
        table: ``[structure.noise]``.

    Returns:
        the blocks, and a line on what was done.

    Raises:
        InputError: a key that is wrong, or noise that is too large for the smallest block.
    """
    if not isinstance(table, Mapping):
        raise InputError("structure.noise", "should be a table, as { size = 1e-6, seed = 0 }")
    keys = parse_table(NoiseTable, table, "structure.noise")
    refuse_spheres(blocks, "structure.noise", "noise on corners")
    shortest = np.array([_shortest_edge(block) for block in blocks])
    at = int(shortest.argmin())
    if keys.size > LARGEST * shortest[at]:
        raise InputError(
            "structure.noise.size",
            f'{keys.size:g} m is more than {LARGEST:g} of the shortest edge, {shortest[at]:.3g} m of block "{blocks[at].name}"',
        )
    if keys.size == 0.0:
        return list(blocks), []
    axes = keys.axes or planar_axes(blocks)
    free = np.array([axis in axes for axis in "xyz"])
    drawn = np.random.default_rng(keys.seed).uniform(-1.0, 1.0, (len(blocks), 3, 4))
    moved = [_moved(block, keys.size, own, free) for block, own in zip(blocks, drawn, strict=True)]
    return moved, [f"noise: corners moved by up to {keys.size:g} m along {', '.join(axes)}, seed {keys.seed}"]


def planar_axes(blocks: Sequence[Block]) -> str:
    """The axes of the upright plane in which blocks may be noisy and stay prisms about it, all three if there is none."""
    assembly = Assembly.from_blocks(blocks, 0.5)
    return next((axes for axis, axes in ((1, "xz"), (0, "yz")) if middle_plane(assembly, axis) is not None), "xyz")


def _shortest_edge(block: Block) -> float:
    """Of the shell of a block [m]."""
    first = np.concatenate(block.faces)
    second = np.concatenate([np.roll(face, -1) for face in block.faces])
    return float(np.linalg.norm(block.vertices[first] - block.vertices[second], axis=1).min())


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
