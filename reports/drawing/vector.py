# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws scenes as polygons, in SVG and PDF: sharp at any size, and open to a drawing program.

Instead of a depth buffer it paints the farther polygons first: blocks in the order of :mod:`reports.drawing.vector`, of each the faces
that look at the viewer, the band of a joint as soon as both of its blocks are painted. Of a cut structure the caps and the joints in the
plane come last, since nothing lies before them.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from masonry_cd.mechanics.model.geometry import area_vectors
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing import palette
from reports.drawing.bands import DrawnJoints
from reports.drawing.parts import AMONG, Lines, Surface, View
from reports.drawing.render import AMBIENT, LIGHTS
from reports.drawing.scene import PictureScene, cut_layers, joint_layers, tie_layers, ties_of

OUTLINE = 0.55  # width of the edges of blocks [points]
POINT = 0.72 / 2.0  # points of a line that is a pixel of the sampled image wide
NEAR = 1e-3  # how far next to a joint it is asked what covers it, as a share of the joint's extent
CAPS, TRACES, LAST = 1.0, 2.0, 3.0  # ranks behind that of the last block: of caps, of joints in the plane, of what is before everything


@dataclass(eq=False)
class _Painting:
    """Polygons with the rank in which they are painted."""

    view: View
    rank: list[float] = field(default_factory=list)
    polygons: list[np.ndarray] = field(default_factory=list)  # (n, 2) each, in the plane of the picture [m]
    colours: list[np.ndarray] = field(default_factory=list)  # (3,) each, 0..1
    outlined: list[bool] = field(default_factory=list)

    def add(self, surface: Surface, rank: np.ndarray | float, colours: np.ndarray | None = None, outlined: bool = False) -> None:
        """Add the polygons of a surface, with ranks (P,), in its colours or others (P, 3) 0..1."""
        flat, count = self.view.plane(surface.points), len(surface.colours)
        self.polygons += [flat[loop] for loop in np.split(surface.loops, surface.loop_start[1:-1])] if count else []
        self.colours += list(surface.colours / 255.0 if colours is None else colours)
        self.rank += np.broadcast_to(rank, count).tolist()
        self.outlined += [outlined] * count


def draw_polygons(axes: Any, scene: PictureScene) -> None:
    """Draw a scene into axes of its window's shape."""
    from matplotlib.collections import PolyCollection

    painting = _painted(scene)
    order = np.argsort(painting.rank, kind="stable")
    colours = np.array([painting.colours[k] for k in order]).reshape(-1, 3)
    # without outlines, edges of their own colour hide the seams
    edges = [palette.EDGE if painting.outlined[k] else tuple(painting.colours[k]) for k in order]
    widths = [OUTLINE if painting.outlined[k] else 0.15 for k in order]
    polygons = [painting.polygons[k] for k in order]
    axes.add_collection(PolyCollection(polygons, facecolors=colours, edgecolors=edges, linewidths=widths, joinstyle="round"))
    for layer in cut_layers(scene):
        if isinstance(layer, Lines) and not layer.outline:
            _draw_lines(axes, layer, scene.view)
    for lines in tie_layers(ties_of(scene)):
        _draw_lines(axes, lines, scene.view)


def _painted(scene: PictureScene) -> _Painting:
    """All polygons of a scene."""
    painting, whole = _Painting(scene.view), [layer for layer in scene.layers if isinstance(layer, Surface)]
    solid = next(layer for layer in whole if layer.owner is not None)
    planes = FacePlanes(solid)
    rank, last = painting_order(planes, scene.view).astype(float), float(planes.count)
    for layer in cut_layers(scene):
        if not isinstance(layer, Surface):
            continue
        if layer.place != AMONG:
            painting.add(layer, -1.0 if layer.place < AMONG else last + LAST)
        elif layer.spared is None:
            painting.add(layer, last + CAPS, outlined=True)
        elif layer.owner is not None:
            _add_faces(painting, layer, rank)
    hidden = None if scene.joints is None else hidden_sides(scene.joints, planes, scene.view)
    for surface in joint_layers(scene, hidden):
        assert surface.owner is not None
        painting.add(surface, last + TRACES if surface.spared is None else np.maximum(*rank[surface.owner]) + 0.5)
    return painting


def _add_faces(painting: _Painting, surface: Surface, rank: np.ndarray) -> None:
    """The faces of the blocks that look at the viewer, shaded as in the picture; edges with them."""
    normals, view = FacePlanes(surface).normals, painting.view
    seen = normals @ view.towards > 1e-6
    light = np.full(len(normals), AMBIENT)
    for (right, up, towards), strength in LIGHTS:
        direction = right * view.right + up * view.up + towards * view.towards
        light += strength * np.maximum(normals @ (direction / np.linalg.norm(direction)), 0.0)
    left = surface.some(seen)
    painting.add(left, rank[left.owner], np.clip(left.colours / 255.0 * light[seen, None], 0.0, 1.0), outlined=True)


def hidden_sides(joints: DrawnJoints, planes: FacePlanes, view: View) -> np.ndarray:
    """(2, N): whether the side of a joint's polygon that begins at a corner lies behind block a of its joint, and behind block b.

    The block on the viewer's side of a joint hides a side over which it reaches out, as a stone does above a head joint.
    """
    joint, following = joints.owner, next_in_loop(joints.start)
    hidden = np.zeros((2, len(joint)), bool)
    for k, sign in enumerate((-1.0, 1.0)):
        corners, normal = joints.corners[k], sign * joints.normals[k]
        middle = (corners + corners[following]) / 2.0
        outward = middle - joints.centres(corners)[joint] if len(joint) else middle
        inside = middle + NEAR * outward + NEAR * normal[joint] * np.linalg.norm(outward, axis=1, keepdims=True)
        for side in np.flatnonzero((normal @ view.towards > EDGE_ON)[joint]).tolist():
            own = planes.faces[int(joints.blocks[k, joint[side]])]
            hidden[k, side] = (planes.normals[own] @ inside[side] < planes.foot[own]).all()
    return hidden


def _draw_lines(axes: Any, lines: Lines, view: View) -> None:
    """Lines behind everything or before it."""
    from matplotlib.collections import LineCollection

    flat = view.plane(lines.points)[lines.pairs]
    axes.add_collection(LineCollection(flat, colors=lines.colour, linewidths=POINT * lines.width, zorder=0 if lines.place < AMONG else 2))


EDGE_ON = 1e-3  # a plane whose normal is nearer to perpendicular to the view than this puts neither block before the other


class FacePlanes:
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


def painting_order(planes: FacePlanes, view: View) -> np.ndarray:
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


def _facing(planes: FacePlanes, block: int, other: int, view: View) -> tuple[float, float]:
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
