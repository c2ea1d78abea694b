"""Blocks that overlap: bounding boxes, then separating axes, both those of contact detection."""

from __future__ import annotations

import numpy as np

from masonry_cd.contact.broad_phase import overlapping_boxes
from masonry_cd.contact.separation import depths
from masonry_cd.model.geometry import Polyhedra


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
    first = shells.vertex_start[:-1]
    boxes = np.hstack([np.minimum.reduceat(shells.vertices, first), np.maximum.reduceat(shells.vertices, first)])
    pairs = overlapping_boxes(boxes, owner, fixed)
    limit = least[pairs].min(axis=1)
    depth = depths(shells.with_edges(), pairs, limit)
    deep = depth > limit
    return pairs[deep], depth[deep]
