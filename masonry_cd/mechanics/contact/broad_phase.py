# SPDX-License-Identifier: GPL-3.0-or-later
"""Broad phase: which parts may meet at all, by their bounding boxes.

The boxes are grown by a skin and by what a part may do within the step, then swept along the axis on which the fewest overlap (sweep and
prune: Baraff, Ph.D. thesis, Cornell 1992): what falls for ever next to a structure must not have it swept from top to bottom. The list of
pairs stays valid until a part has moved through that growth. The common motion of the supports is taken off first, so that shaking alone
rebuilds nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.motion import BodyMotion, part_reach
from masonry_cd.mechanics.model.blocks import ConvexShapes

SKIN = 0.2  # growth of the bounding boxes, as a share of the median width of the parts


class Listing(NamedTuple):
    """Where the B blocks were when the pairs were listed, and how far each of the P parts may go until they are listed again."""

    position: np.ndarray  # (B, 3) centres of mass, the displacement of the supports taken off [m]
    rotation: np.ndarray  # (B, 3, 3) body to world
    allowance: np.ndarray  # (P,) [m]

    @classmethod
    def none(cls, blocks: int, parts: int) -> Listing:
        """Before the first list: no distance is less than the allowance NaN."""
        return cls(np.zeros((blocks, 3)), np.zeros((blocks, 3, 3)), np.full(parts, np.nan))


def list_pairs(listing: Listing, shapes: ConvexShapes, motion: BodyMotion, fixed: np.ndarray, skin: float) -> np.ndarray:
    """Pairs (n, 2) of parts whose boxes overlap, sorted; those of two supports or of one block left out.

    Args:
        listing: its poses are those of the blocks now; the allowances are filled in.
        shapes: P parts.
        motion: the blocks' velocities, and the step.
        fixed: (P,) parts of supports.
        skin: by which each box is grown [m].
    """
    boxes = np.empty((len(listing.allowance), 6))
    grown_boxes(listing, shapes, motion, skin, boxes)
    return overlapping_boxes(boxes, shapes.part_block, fixed)


def overlapping_boxes(boxes: np.ndarray, owner: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Pairs (n, 2) of boxes that overlap or touch, sorted.

    Args:
        boxes: (P, 6) low and high corners [m].
        owner: (P,) block of each box; boxes of one block are not compared.
        fixed: (P,) True for supports, which are not compared among themselves.
    """
    axis = sweep_axis(boxes)
    pairs = _sweep(boxes, axis, np.argsort(boxes[:, axis], kind="stable"), fixed, owner)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def sweep_axis(boxes: np.ndarray) -> int:
    """The axis on which the fewest boxes (P, 6) overlap, by whose number the sweep's work grows."""
    low = np.sort(boxes[:, :3], axis=0)
    return int(np.argmin([np.searchsorted(low[:, axis], boxes[:, 3 + axis], side="right").sum() for axis in range(3)]))


@borrower()
def list_holds(listing, shapes, motion, origin):
    """Return True if no part has moved, nor may move within the step, by more than its allowance.

    ``origin`` (3,) is the displacement of the supports since the start [m].
    """
    part_block, radius, size = shapes.part_block, shapes.radius, shapes.size
    position, rotation = motion.position, motion.rotation
    listed_position, listed_rotation = listing.position, listing.rotation
    for p in range(part_block.shape[0]):
        b = part_block[p]
        shift, turn = 0.0, 0.0
        for i in range(3):
            shift += (position[b, i] - origin[i] - listed_position[b, i]) ** 2
            for j in range(3):
                turn += (rotation[b, i, j] - listed_rotation[b, i, j]) ** 2
        moved = np.sqrt(shift) + radius[p] * np.sqrt(turn)
        if not moved + part_reach(motion, b, radius[p], size[p]) <= listing.allowance[p]:
            return False
    return True


@entry()
def grown_boxes(listing: Listing, shapes: ConvexShapes, motion: BodyMotion, skin: float, boxes: np.ndarray) -> None:
    """Fill ``boxes`` (P, 6) with low and high corners, grown by the allowances, filled too: skin and reach within the step [m]."""
    solids, allowance = shapes.solids, listing.allowance
    position, rotation, vertices = listing.position, listing.rotation, solids.vertices
    for p in range(allowance.shape[0]):
        b = shapes.part_block[p]
        allowance[p] = skin + part_reach(motion, b, shapes.radius[p], shapes.size[p])
        for d in range(3):
            low, high = np.inf, -np.inf
            for i in range(solids.vertex_start[p], solids.vertex_start[p + 1]):
                value = position[b, d]
                for e in range(3):
                    value += rotation[b, d, e] * vertices[i, e]
                low, high = min(low, value), max(high, value)
            grown = allowance[p] + shapes.rounding[p]
            boxes[p, d], boxes[p, 3 + d] = low - grown, high + grown


@entry()
def _sweep(boxes, axis, order, fixed, owner):
    """Pairs (n, 2) of overlapping boxes (P, 6), lower number first, swept along an axis in the order (P,) in which they begin there."""
    parts = boxes.shape[0]
    u, w = (axis + 1) % 3, (axis + 2) % 3
    capacity, count = 8 * parts + 16, 0
    pairs = np.empty((capacity, 2), dtype=np.int64)
    for i in range(parts):
        p = order[i]
        for j in range(i + 1, parts):
            q = order[j]
            if boxes[q, axis] > boxes[p, 3 + axis]:
                break
            if boxes[q, u] > boxes[p, 3 + u] or boxes[q, 3 + u] < boxes[p, u]:
                continue
            if boxes[q, w] > boxes[p, 3 + w] or boxes[q, 3 + w] < boxes[p, w]:
                continue
            if (fixed[p] and fixed[q]) or owner[p] == owner[q]:
                continue
            if count == capacity:
                capacity *= 2
                grown = np.empty((capacity, 2), dtype=np.int64)
                for k in range(count):
                    grown[k, 0], grown[k, 1] = pairs[k, 0], pairs[k, 1]
                pairs = grown
            pairs[count, 0], pairs[count, 1] = min(p, q), max(p, q)
            count += 1
    return pairs[:count].copy()
