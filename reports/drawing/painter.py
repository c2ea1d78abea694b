# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which blocks are painted, the farther before the nearer, for pictures made of polygons.

Two blocks that do not overlap have a plane between them; whichever lies behind it, seen from the viewer, is painted first. The planes tried
are those of their faces: the one from which the other block keeps farthest away. Where the planes of several blocks go round in a circle,
which masonry hardly does, the farthest block of the circle is painted first.
"""

from __future__ import annotations

import heapq

import numpy as np

from masonry_cd.mechanics.model.geometry import area_vectors
from reports.drawing.parts import Surface, View

EDGE_ON = 1e-3  # a plane whose normal is nearer to perpendicular to the view than this puts neither block before the other


class Planes:
    """The faces of B blocks that a surface has and owns: corners and planes of each."""

    def __init__(self, surface: Surface) -> None:
        assert surface.owner is not None
        self.count = int(surface.owner.max(initial=-1)) + 1
        area = area_vectors(surface.points, surface.loops, surface.loop_start)
        self.normals = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-300)  # (P, 3)
        self.foot = np.einsum("fi,fi->f", self.normals, surface.points[surface.loops[surface.loop_start[:-1]]])
        self.faces = rows_by_block(surface.owner, self.count)
        corner_block = np.repeat(surface.owner, np.diff(surface.loop_start))
        self.corners = [surface.points[np.unique(surface.loops[rows])] for rows in rows_by_block(corner_block, self.count)]

    def contain(self, block: int, point: np.ndarray) -> bool:
        """Whether a point (3,) lies within a block."""
        own = self.faces[block]
        return bool((self.normals[own] @ point < self.foot[own]).all())


def painting_order(planes: Planes, view: View) -> np.ndarray:
    """(B,) the rank of each block, 0 for the one that is painted first."""
    depth = np.array([float((corner @ view.towards).mean()) if len(corner) else 0.0 for corner in planes.corners])
    nearer: list[list[int]] = [[] for _ in range(planes.count)]  # blocks that are painted after this one
    waits = np.zeros(planes.count, dtype=np.int64)
    for a, b in overlapping(planes.corners, view).tolist():
        (apart_a, towards_a), (apart_b, towards_b) = _facing(planes, b, a, view), _facing(planes, a, b, view)
        side = towards_a if apart_a >= apart_b else -towards_b  # above 0: b is nearer to the viewer than a
        if abs(side) < EDGE_ON:
            continue
        far, near = (a, b) if side > 0 else (b, a)
        nearer[far].append(near)
        waits[near] += 1
    return in_order(nearer, waits, depth)


def rows_by_block(block: np.ndarray, count: int) -> list[np.ndarray]:
    """For each of ``count`` blocks the rows, in order, at which ``block`` (N,) names it."""
    order = np.argsort(block, kind="stable")
    return np.split(order, np.searchsorted(block[order], np.arange(1, count)))


def overlapping(corners: list[np.ndarray], view: View) -> np.ndarray:
    """(P, 2) pairs of blocks, given by their corners, whose boxes overlap in the picture."""
    flat = [view.plane(corner) for corner in corners]
    low, high = np.array([p.min(axis=0) for p in flat]), np.array([p.max(axis=0) for p in flat])
    slack = 1e-9 * float((high.max(axis=0) - low.min(axis=0)).max())
    by_left = np.argsort(low[:, 0], kind="stable")
    pairs = []
    for k, a in enumerate(by_left.tolist()):
        others = by_left[k + 1 :]
        others = others[: np.searchsorted(low[others, 0], high[a, 0] - slack)]
        hit = others[(low[others, 1] < high[a, 1] - slack) & (high[others, 1] > low[a, 1] + slack)]
        pairs.append(np.stack([np.full(len(hit), a), hit], axis=1))
    return np.concatenate(pairs) if pairs else np.zeros((0, 2), np.int64)


def _facing(planes: Planes, block: int, other: int, view: View) -> tuple[float, float]:
    """How far a block keeps away from the farthest of another's planes [m], and how much its normal looks towards the viewer."""
    own = planes.faces[other]
    apart = (planes.normals[own] @ planes.corners[block].T - planes.foot[own][:, None]).min(axis=1)
    best = int(np.argmax(apart))
    return float(apart[best]), float(planes.normals[own][best] @ view.towards)


def in_order(nearer: list[list[int]], waits: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """The ranks: what waits for nothing comes, the farthest first; where all wait, in a circle, the farthest of all."""
    rank, left = np.full(len(depth), -1), set(range(len(depth)))
    ready = [(depth[b], b) for b in range(len(depth)) if waits[b] == 0]
    heapq.heapify(ready)
    while left:
        block = heapq.heappop(ready)[1] if ready else min(left, key=lambda b: (depth[b], b))
        if block not in left:
            continue
        rank[block] = len(depth) - len(left)
        left.remove(block)
        for other in nearer[block]:
            waits[other] -= 1
            if waits[other] == 0 and other in left:
                heapq.heappush(ready, (depth[other], other))
    return rank
