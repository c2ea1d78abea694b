# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks that overlap: bounding boxes, then separating axes, both those of contact detection; spheres by their distance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_cd.mechanics.contact.broad_phase import overlapping_boxes
from masonry_cd.mechanics.contact.round_contact import round_depths
from masonry_cd.mechanics.contact.separation import depths
from masonry_cd.mechanics.model.blocks import Block, ConvexShapes
from masonry_cd.mechanics.model.geometry import Polyhedra


def overlapping_pairs(shells: Polyhedra, owner: np.ndarray, fixed: np.ndarray, least: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the convex shells that overlap.

    Args:
        shells: S closed convex polyhedra.
        owner: (S,) block of each shell; shells of one block are not compared.
        fixed: (S,) True for supports, which are not compared among themselves.
        least: (S,) overlaps no deeper than that of either shell are none [m].

    Returns:
        (n, 2) pairs of shells, sorted, and how deep they are in each other (n,) [m].
    """
    pairs = overlapping_boxes(_boxes(shells), owner, fixed)
    limit = least[pairs].min(axis=1)
    depth = depths(shells.with_edges(), pairs, limit)
    deep = depth > limit
    return pairs[deep], depth[deep]


def overlapping_spheres(blocks: Sequence[Block], share: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the pairs of blocks of which one is a sphere, and that overlap.

    Args:
        blocks: sound ones.
        share: of the radius, or the smaller one of two; overlaps no deeper than that are none.

    Returns:
        (n, 2) pairs of blocks, and how deep they are in each other (n,) [m].
    """
    shapes = ConvexShapes.of(blocks, np.zeros((len(blocks), 3)))
    radius, owner = shapes.rounding, shapes.part_block
    fixed = np.array([block.fixed for block in blocks])[owner]
    boxes = _boxes(shapes.solids) + radius[:, None] * [-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]
    pairs = overlapping_boxes(boxes, owner, fixed)
    pairs = pairs[radius[pairs].any(axis=1)]
    depth = round_depths(shapes.solids, radius, pairs)
    deep = depth > share * np.where(radius[pairs] > 0.0, radius[pairs], np.inf).min(axis=1)
    return owner[pairs[deep]], depth[deep]


def _boxes(shells: Polyhedra) -> np.ndarray:
    """Low and high corners of polyhedra, (S, 6) [m]."""
    first = shells.vertex_start[:-1]
    return np.hstack([np.minimum.reduceat(shells.vertices, first), np.maximum.reduceat(shells.vertices, first)])
