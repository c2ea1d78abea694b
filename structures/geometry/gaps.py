# SPDX-License-Identifier: GPL-3.0-or-later
"""Gaps closed: faces of neighbours that nearly coincide are put into one plane, and the corners follow.

Two faces of different blocks nearly coincide when they face each other, within a small angle, and are no farther apart than the tolerance
wherever they lie over each other; a small overlap counts as a gap. Faces linked in this way share the mean of their planes, weighted by
area, so a bed joint becomes one plane along the whole course. Each corner then moves by the least distance that puts it into the planes
of all its faces: faces stay planar, and faces without such a neighbour stay where they were.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.mechanics.contact.broad_phase import overlapping_boxes
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.polygon import clip, loop_area, loop_planes
from structures.geometry.checks import Unsound

ANGLE = 0.02  # [rad] faces at more than this to each other do not face each other
COPLANAR = 1e-6  # relative to the size of the block: its own faces closer than this are in one plane
LIMIT = 2.0  # corners move by no more than this many tolerances: at sharp corners more than the planes do


@dataclass(frozen=True, eq=False)
class BlockFaces:
    """All faces of all blocks: normals (F, 3), offsets (F,) [m], areas (F,) [m2], block (F,), and their corners."""

    normal: np.ndarray
    offset: np.ndarray
    area: np.ndarray
    block: np.ndarray
    polygon: list[np.ndarray]


def close_gaps(blocks: Sequence[Block], tolerance: float) -> tuple[list[Block], float, int]:
    """Close the gaps between blocks.

    Args:
        blocks: with sound shells (:func:`structures.geometry.checks.check_shells`); their parts are dropped.
        tolerance: of the widest gap to close [m].

    Returns:
        the blocks, how far a corner was moved at most [m], and how many pairs of faces were brought together.

    Raises:
        Unsound: a corner would have to move by more than twice the tolerance; names the block.
    """
    planes = _planes(blocks)
    pairs = [pair for pair in _facing(blocks, planes, tolerance) if _are_near(planes, *pair, tolerance)]
    normal, offset = _common(planes, [*pairs, *_own(blocks, planes)])
    out, most, face = [], 0.0, 0
    for block in blocks:
        own = slice(face, face + len(block.faces))
        moved = _followed(block, normal[own], offset[own])
        far = float(np.linalg.norm(moved - block.vertices, axis=1).max())
        if far > LIMIT * tolerance:
            raise Unsound(
                f'block "{block.name}"',
                f"to close its gaps a corner would have to move by {1e3 * far:.3g} mm, "
                f"more than twice the {1e3 * tolerance:.3g} mm allowed",
                [block.name],
                blocks,
            )
        out.append(replace(block, vertices=moved, parts=()))
        most, face = max(most, far), own.stop
    return out, most, len(pairs)


def _planes(blocks: Sequence[Block]) -> BlockFaces:
    """The planes of all faces."""
    polygon = [block.vertices[list(face)].astype(float) for block in blocks for face in block.faces]
    normal, offset = loop_planes(polygon)
    area = np.array([loop_area(corners) for corners in polygon])
    return BlockFaces(normal, offset, area, np.repeat(np.arange(len(blocks)), [len(block.faces) for block in blocks]), polygon)


def _facing(blocks: Sequence[Block], planes: BlockFaces, tolerance: float) -> Iterator[tuple[int, int]]:
    """Pairs of faces of blocks whose boxes meet, that look at each other."""
    low = np.array([block.vertices.min(axis=0) for block in blocks]) - tolerance
    high = np.array([block.vertices.max(axis=0) for block in blocks]) + tolerance
    start = np.cumsum([0, *(len(block.faces) for block in blocks)])
    for a, b in overlapping_boxes(np.hstack([low, high]), np.arange(len(blocks)), np.zeros(len(blocks), dtype=bool)):
        opposed = planes.normal[start[a] : start[a + 1]] @ planes.normal[start[b] : start[b + 1]].T < -math.cos(ANGLE)
        for i, j in np.argwhere(opposed):
            yield int(start[a] + i), int(start[b] + j)


def _are_near(planes: BlockFaces, i: int, j: int, tolerance: float) -> bool:
    """Return True if two faces lie over each other, nowhere farther apart than the tolerance."""
    normal = planes.normal[i]
    sides = np.roll(planes.polygon[i], -1, axis=0) - planes.polygon[i]
    along = sides[np.argmax(np.linalg.norm(sides, axis=1) > 0.0)]  # corners may coincide
    along /= np.linalg.norm(along)
    axes = np.stack([along, np.cross(normal, along)])
    below, above = _hull(planes.polygon[i] @ axes.T), _hull(planes.polygon[j] @ axes.T)
    if not len(below) or not len(above):
        return False
    common = _overlap(below, above)
    if len(common) < 3:
        return False
    # the plane of j as a height over that of i: h = c0 + c . (s, t)
    other = planes.normal[j]
    heights = (planes.offset[j] - common @ (axes @ other)) / (normal @ other) - planes.offset[i]
    return bool(np.abs(heights).max() <= tolerance)


def _hull(points: np.ndarray) -> np.ndarray:
    """The convex hull of points (n, 2), counter-clockwise; empty where they lie on a line."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points[:0]


def _overlap(polygon: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Return the share of a polygon (n, 2) in a convex one; empty where they share no area."""
    size = float(np.ptp(polygon, axis=0).max())
    for a, b in zip(window, np.roll(window, -1, axis=0), strict=True):
        inward = np.array([a[1] - b[1], b[0] - a[0]]) / max(float(np.linalg.norm(b - a)), 1e-300)
        depth = (polygon - a) @ inward
        if depth.max() <= 1e-6 * size:
            return np.zeros((0, 2))
        polygon = clip(polygon, depth)
    return polygon


def _own(blocks: Sequence[Block], planes: BlockFaces) -> Iterator[tuple[int, int]]:
    """Pairs of faces of one block in one plane, such as the triangles of a side."""
    start = 0
    for block in blocks:
        own = slice(start, start + len(block.faces))
        size = float(np.linalg.norm(np.ptp(block.vertices, axis=0)))
        offset = planes.offset[own]
        same = (planes.normal[own] @ planes.normal[own].T > 1.0 - COPLANAR) & (np.abs(offset[:, None] - offset) <= COPLANAR * size)
        for i, j in np.argwhere(np.triu(same, 1)):
            yield start + int(i), start + int(j)
        start = own.stop


def _common(planes: BlockFaces, pairs: Sequence[tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """Normals and offsets of all faces, those that are linked to each other in one plane."""
    count = len(planes.area)
    if not pairs:
        return planes.normal, planes.offset
    links = np.array(pairs)
    label = connected_components(links[:, 0], links[:, 1], count)
    groups = int(label.max()) + 1
    _, first = np.unique(label, return_index=True)
    turn = np.where((planes.normal * planes.normal[first[label]]).sum(axis=1) > 0, 1.0, -1.0)  # faces of the far side look the other way
    weight = turn * planes.area
    normal = np.stack([np.bincount(label, weight * n, groups) for n in planes.normal.T], axis=1)
    alone = np.bincount(label, minlength=groups) == 1
    normal[alone] = planes.normal[first[alone]]
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    middle = np.array([corners.mean(axis=0) for corners in planes.polygon])
    heights = (middle * normal[label]).sum(axis=1)
    offset = np.bincount(label, planes.area * heights, groups) / np.bincount(label, planes.area, groups)
    return turn[:, None] * normal[label], turn * offset[label]


def _followed(block: Block, normal: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """The corners of a block, each moved by the least distance into the planes of its faces."""
    out = block.vertices.astype(float)
    member = np.zeros((len(block.faces), len(out)), dtype=bool)
    for number, face in enumerate(block.faces):
        member[number, list(face)] = True
    for k, corner in enumerate(block.vertices):
        n = normal[member[:, k]]
        out[k] = corner + np.linalg.pinv(n, rcond=1e-4) @ (offset[member[:, k]] - n @ corner)
    return out
