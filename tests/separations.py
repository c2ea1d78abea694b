# SPDX-License-Identifier: GPL-3.0-or-later
"""How far convex parts are apart in truth, by the hull of their Minkowski difference, and whether contacts agree with it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.model.blocks import ConvexShapes


def signed_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Distance of the hulls of two sets of corners (N, 3) [m]; where they overlap, minus the least shift that parts them."""
    difference = (b[:, None] - a[None]).reshape(-1, 3)
    hull = ConvexHull(difference)
    if (deepest := float(hull.equations[:, 3].max())) <= 0.0:
        return deepest
    return float(_distances_from_origin(difference[hull.simplices]).min())


def _distances_from_origin(triangles: np.ndarray) -> np.ndarray:
    """Distance of the origin from each of the triangles (n, 3, 3), (n,)."""
    p = triangles
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    square = (n * n).sum(axis=1)
    height = (n * p[:, 0]).sum(axis=1)
    foot = n * np.divide(height, square, out=np.zeros_like(height), where=square > 0.0)[:, None]
    inside = square > 0.0
    edges = []
    for i, j in pairwise((0, 1, 2, 0)):
        along = p[:, j] - p[:, i]
        inside &= (np.cross(along, foot - p[:, i]) * n).sum(axis=1) >= 0.0
        length = (along * along).sum(axis=1)
        share = np.clip(np.divide(-(along * p[:, i]).sum(axis=1), length, out=np.zeros_like(length), where=length > 0.0), 0.0, 1.0)
        edges.append(np.linalg.norm(p[:, i] + share[:, None] * along, axis=1))
    return np.where(inside, np.linalg.norm(foot, axis=1), np.min(edges, axis=0))


def parts_in_world(shapes: ConvexShapes, position: np.ndarray, rotation: np.ndarray) -> list[np.ndarray]:
    """The corners of each part (V, 3) in the world frame [m]."""
    starts, blocks = shapes.solids.vertex_start, shapes.part_block
    local = [shapes.solids.vertices[first:end] for first, end in pairwise(starts)]
    return [corners @ rotation[block].T + position[block] for corners, block in zip(local, blocks, strict=True)]


def shortfall(found: ContactSet, detector: Detector, corners: list[np.ndarray]) -> np.ndarray:
    """Return the shortfall of the gap of each contact against the separation of its parts along its normal, (C,) [m]."""
    parts, out = detector.pairs[found.pair], np.empty(len(found.gap))
    for c, (a, b) in enumerate(parts):
        n = found.normal[c]
        out[c] = (corners[b] @ n).min() - (corners[a] @ n).max() - found.gap[c]
    return out
