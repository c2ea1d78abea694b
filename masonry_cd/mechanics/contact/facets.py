# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contact points between facets: where faces of meshed blocks meet, the corners of all overlaps of a facet of one with one of the other.

Within such an overlap both surfaces are linear, and forces at the corners of a convex polygon carry any pressure resultant on it: with the
barycentric coordinates of its centroid as shares they do on every linear field what a uniform pressure does. So a uniform pressure on faces
whose meshes do not match has an exact counterpart of forces at these points, on both sides at once, and uniform stress passes through
(the patch test, Taylor & Papadopoulos, 1991). The corners of the overlap of the whole faces do not have it: forces there bend the meshes
between them. Nodes against faces, one side or both, have it for matching meshes only.

A joint whose law is per area shares the area of each such overlap out among its corners and centroid (``manifold.py``).

In a plane the facets of a face are strips across it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.contact.manifold import SNAP, share_out
from masonry_cd.mechanics.model.block_mesh import BlockMesh
from masonry_cd.mechanics.model.blocks import ConvexShapes
from masonry_cd.mechanics.model.geometry import Polyhedra
from masonry_cd.mechanics.model.polygon import clip_in_place

ON_FACE = 1e-6  # a facet this close to the plane of a face lies in it, as a share of the part's reach
FINE = SNAP  # corners of overlaps closer than this are one, as a share of the smaller part's width
CORNERS = 12  # most of an overlap while it is cut, beyond those of the faces'


class Facets(NamedTuple):
    """The facets of the faces of all parts; those of face f are start[f], ..., start[f + 1] - 1."""

    start: np.ndarray  # (F + 1,); (1,) where no block is meshed
    corner_start: np.ndarray  # (T + 1,)
    corners: np.ndarray  # (K, 3) counter-clockwise from outside, body frame [m]

    @classmethod
    def none(cls) -> Facets:
        """No block is meshed."""
        zero = np.zeros(1, dtype=np.int64)
        return cls(zero, zero, np.zeros((0, 3)))

    @classmethod
    def of(cls, shapes: ConvexShapes, meshes: tuple[BlockMesh, ...], of_block: np.ndarray) -> Facets:
        """Those of the parts of blocks with meshes ``of_block`` (B,), -1 for none."""
        solids, count = shapes.solids, np.zeros(len(shapes.solids.normals), dtype=np.int64)
        loops: list[np.ndarray] = []
        for f, part in enumerate(solids.owner_of_face()):
            g = of_block[shapes.part_block[part]]
            if g >= 0:
                own = _on_face(meshes[g], solids, f, ON_FACE * float(shapes.radius[part]))
                count[f] = len(own)
                loops += own
        sizes = [len(loop) for loop in loops]
        return cls(np.concatenate([[0], np.cumsum(count)]), np.cumsum([0, *sizes]), np.concatenate(loops))

    def most(self, owner: np.ndarray, parts: int) -> np.ndarray:
        """The largest number of facets of a face of each part, (P,); ``owner`` (F,) is the part of each face."""
        out = np.zeros(parts, dtype=np.int64)
        if len(self.start) > 1:
            np.maximum.at(out, owner, np.diff(self.start))
        return out


def _on_face(mesh: BlockMesh, solids: Polyhedra, f: int, close: float) -> list[np.ndarray]:
    """The facets of a mesh that lie in face f, each (3, 3) or (4, 3)."""
    normal, loop = solids.normals[f], solids.vertices[solids.loops[solids.loop_start[f] : solids.loop_start[f + 1]]]
    corners = mesh.nodes[mesh.facets]
    if mesh.axis >= 0:  # strips across the plane
        if abs(normal[mesh.axis]) > 0.5:
            return []
        low, high = loop[:, mesh.axis].min(), loop[:, mesh.axis].max()
        ends = corners[:, [0, 1, 1, 0]]
        ends[:, :, mesh.axis] = [low, low, high, high]
        corners = ends
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    outward = np.sum(np.cross(first, second) * normal, axis=1)
    inside = np.abs(np.sum((corners - loop[0]) * normal, axis=2)).max(axis=1) <= close
    return [own if turn > 0.0 else own[::-1] for own, turn in zip(corners[inside], outward[inside], strict=True)]


class Overlay(NamedTuple):
    """The facets, and scratch for the points of one pair: at most N, on polygons of at most M corners."""

    facets: Facets
    faces: np.ndarray  # (2,) by which a and b touch
    whole: np.ndarray  # (M, 4) the overlap of both faces, with the gap as the fourth coordinate [m]
    first: np.ndarray  # (M, 4) its part within one facet
    second: np.ndarray  # (M, 4) and within one of the other face
    other: np.ndarray  # (M, 4)
    distance: np.ndarray  # (M,)
    area: np.ndarray  # (M,)
    corner: np.ndarray  # (4, 3)
    crowded: np.ndarray  # (2,) faces of a and b for whose points there was no room; -1: there was always room

    @classmethod
    def allocate(cls, facets: Facets, corners: int) -> Overlay:
        """Room for faces, by their largest number of corners."""
        most = 2 * corners + CORNERS
        whole, first, second, other = (np.empty((most, 4)) for _ in range(4))
        return cls(
            facets, np.zeros(2, dtype=np.int64), whole, first, second, other, np.empty(most), np.empty(most), np.empty((4, 3)),
            np.full(2, -1),
        )  # fmt: skip


@borrower()
def has_facets(facets, faces):
    """Return True if one of the two faces (2,) that a pair touches with has facets."""
    return facets.start[faces[0] + 1] > facets.start[faces[0]] or facets.start[faces[1] + 1] > facets.start[faces[1]]


@borrower()
def split(overlay, pose, normal, count, width, with_area, room, manifold):
    """Put the points of all overlaps of facets in place of the corners of the overlap of two faces; returns how many.

    ``pose`` (12,) of b in the frame of a; the first ``count`` points of ``manifold`` are the corners of the
    overlap, with ``normal`` (3,); ``width`` of the smaller part [m]; ``with_area``: with areas; at most ``room`` points.
    """
    facets, faces, whole, first, second = overlay.facets, overlay.faces, overlay.whole, overlay.first, overlay.second
    for k in range(count):
        for d in range(3):
            whole[k, d] = manifold.point[k, d]
        whole[k, 3] = manifold.height[k]
    total, close = 0, FINE * width
    begin_a, end_a = facets.start[faces[0]], facets.start[faces[0] + 1]
    begin_b, end_b = facets.start[faces[1]], facets.start[faces[1] + 1]
    for i in range(max(1, end_a - begin_a)):
        left = _copied(whole, count, first)
        if end_a > begin_a:
            left = _cut_by_facet(begin_a + i, pose, False, normal, first, left, close, overlay)
        if left < 3:
            continue
        for j in range(max(1, end_b - begin_b)):
            rest = _copied(first, left, second)
            if end_b > begin_b:
                rest = _cut_by_facet(begin_b + j, pose, True, normal, second, rest, close, overlay)
            if rest >= 3:
                total = _add_points(second, rest, normal, close, with_area, min(room, len(manifold.height)), total, manifold, overlay)
    return total


@borrower()
def _copied(polygon, count, to):
    """Copy the first rows of a polygon (M, 4); returns how many."""
    for k in range(count):
        for d in range(4):
            to[k, d] = polygon[k, d]
    return count


@borrower()
def _cut_by_facet(t, pose, moved, normal, polygon, count, close, overlay):
    """Cut a polygon by the sides of facet t, placed by the pose where ``moved``; returns the number of corners left."""
    facets, corner = overlay.facets, overlay.corner
    begin, corners = facets.corner_start[t], facets.corner_start[t + 1] - facets.corner_start[t]
    for k in range(corners):
        p = facets.corners[begin + k]
        for d in range(3):
            corner[k, d] = pose[d] + pose[3 + 3 * d] * p[0] + pose[4 + 3 * d] * p[1] + pose[5 + 3 * d] * p[2] if moved else p[d]
    sign = -1.0 if moved else 1.0  # the normal points out of a and into b
    nx, ny, nz = sign * normal[0], sign * normal[1], sign * normal[2]
    for k in range(corners):
        p, q = corner[k], corner[k + 1 if k + 1 < corners else 0]
        ex, ey, ez = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        sx, sy, sz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        scale = 1.0 / np.sqrt(sx * sx + sy * sy + sz * sz)
        for c in range(count):
            x = polygon[c]
            overlay.distance[c] = scale * (sx * (x[0] - p[0]) + sy * (x[1] - p[1]) + sz * (x[2] - p[2]))
        count = clip_in_place(polygon, count, overlay.distance, close, overlay.other)
        if count < 3:
            return 0
    return count


@borrower()
def _add_points(polygon, count, normal, close, with_area, room, total, manifold, overlay):
    """Add the corners of a polygon to the first ``total`` points of the manifold, each place once; returns how many there are then."""
    area, nx, ny, nz = overlay.area, normal[0], normal[1], normal[2]
    twice = 0.0
    for k in range(1, count - 1):
        p, q, r = polygon[0], polygon[k], polygon[k + 1]
        ax, ay, az, bx, by, bz = q[0] - p[0], q[1] - p[1], q[2] - p[2], r[0] - p[0], r[1] - p[1], r[2] - p[2]
        twice += nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx)
    if abs(twice) < close * close:
        return total
    for k in range(count):
        area[k] = 0.0
    if with_area:
        count = share_out(polygon, count, nx, ny, nz, area)
    for k in range(count):
        at = -1
        for s in range(total):
            off = 0.0
            for d in range(3):
                off += (manifold.point[s, d] - polygon[k, d]) ** 2
            if off <= close * close:
                at = s
                break
        if at >= 0:
            manifold.area[at] += area[k]
        elif total == room:
            overlay.crowded[0], overlay.crowded[1] = overlay.faces[0], overlay.faces[1]
        else:
            for d in range(3):
                manifold.point[total, d] = polygon[k, d]
            manifold.height[total], manifold.area[total] = polygon[k, 3], area[k]
            total += 1
    return total
