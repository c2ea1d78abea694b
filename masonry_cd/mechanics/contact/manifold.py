# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contact points of a pair of convex parts, by the feature that separates them.

**Face on face**: the face of the other part that faces the reference face most squarely, clipped by the sides of the reference face, all
its corners kept, no inset (their placement is physics: an inset of 1.25 % raises the minimum thickness of an arch by 2.6 %). Overlaps
narrower than SLIVER of the smaller part are no interface: blocks that only share an edge or a corner, as diagonal neighbours in a bond do,
must not wedge each other apart. Corners that have moved less than SNAP off a side plane stay on it, or every small turn would double them.

**Crossing edges**: one point, midway between them. Where one of them ends before they come nearest, the axis across them is not the
shortest way from one part to the other: such edges have a point only where they are within reach all the same.

**Areas.** A joint whose law is per area, elastic or bonded, has one more point, at the centroid of its polygon, and shares its area out so
that springs at the points act as springs all over it. With A_i the triangles (centroid, c_i, c_i+1), c seen from the centroid,

    w_i = lambda (A_i-1 + A_i) / 6 at corner i, the rest at the centroid,   lambda = 1 + sum A_i c_i . c_i+1 / sum A_i (c_i^2 + c_i+1^2).

First moments sum w_i c_i are zero for any polygon; lambda, between 1/2 and 3/2, gives the second moments their exact trace (the torsion of
the joint), and all of them are exact for triangles, parallelograms and regular polygons (A/12 at a corner of a rectangle). No weight is
negative. Crossing edges have no area: they are rigid and dry in any joint.

All is done in the frame of part a of the pair; see :class:`masonry_cd.mechanics.contact.separation.Placed` for the two parts as placed
there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.contact.joint_points import MOST
from masonry_cd.mechanics.contact.separation import EDGES, FACE_OF_A
from masonry_cd.mechanics.model.polygon import clip_in_place, plane_distances

SLIVER = 1e-4  # narrowest interface, as a share of the smaller part's width
SNAP = 1e-4  # a corner this close to a side plane is on it, as a share of the smaller part's width


class Manifold(NamedTuple):
    """The contact points of one pair, in the frame of part a; arrays with rows for the most points a pair can have, N."""

    point: np.ndarray  # (N, 3) [m]
    height: np.ndarray  # (N,) gap [m]; side distances while the polygon is clipped
    area: np.ndarray  # (N,) share of the joint's area [m2], where its law is per area
    other: np.ndarray  # (N, 3) scratch

    @classmethod
    def allocate(cls, corners: int, more: int = 0) -> Manifold:
        """Memory for the points of two faces with some corners at most, of their rings, and of ``more`` where facets cut them."""
        most = 2 * corners * (MOST // 2) + 8 + more
        return cls(np.empty((most, 3)), np.empty(most), np.empty(most), np.empty((most, 3)))


@borrower()
def contact_points(parts, feature, solids, own, other, width, reach, with_area, normal, manifold):
    """Fill ``manifold`` and ``normal`` (3,), from a to b, with the contact points of a pair; returns how many.

    ``parts`` are the numbers of a and b, ``own`` and ``other`` the two as placed; ``feature`` (3,) separates them; ``width`` [m] of the
    smaller; ``reach`` [m] of edges that do not cross within their lengths; ``with_area``: with the centroid and the areas.
    """
    a, b = parts
    if feature[0] == EDGES:
        return _edge_contact(solids.edges[feature[1]], solids.edges[feature[2]], own, other, reach, normal, manifold)
    if feature[0] == FACE_OF_A:
        face, sign = feature[1], 1.0
        incident = incident_face(b, solids, other, own.normals[face - own.first_face])
        return _face_contacts(face, incident, solids, own, other, width, with_area, sign, normal, manifold)
    face, sign = feature[1], -1.0
    incident = incident_face(a, solids, own, other.normals[face - other.first_face])
    return _face_contacts(face, incident, solids, other, own, width, with_area, sign, normal, manifold)


@borrower()
def incident_face(p, solids, placed, outward):
    """The face of part p that faces the direction -outward (3,) most squarely."""
    least, at = np.inf, -1
    for f in range(solids.face_start[p], solids.face_start[p + 1]):
        n = placed.normals[f - placed.first_face]
        value = n[0] * outward[0] + n[1] * outward[1] + n[2] * outward[2]
        if value < least:
            least, at = value, f
    return at


@borrower()
def _face_contacts(reference, incident, solids, own, other, width, with_area, sign, normal, manifold):
    """Contact points between the reference face of ``own`` and the incident face of ``other``; returns how many.

    ``normal`` becomes ``sign`` times the outward normal of the reference face.
    """
    polygon, height = manifold.point, manifold.height
    outward = own.normals[reference - own.first_face]
    nx, ny, nz = outward[0], outward[1], outward[2]
    normal[0], normal[1], normal[2] = sign * nx, sign * ny, sign * nz
    start = solids.loop_start[incident]
    count = solids.loop_start[incident + 1] - start
    for i in range(count):
        v = other.vertices[solids.loops[start + i] - other.first_vertex]
        polygon[i, 0], polygon[i, 1], polygon[i, 2] = v[0], v[1], v[2]
    count = _clip_by_sides(reference, solids, own, count, SNAP * width, (nx, ny, nz), manifold)
    count = _without_duplicates(polygon, count, SNAP * width)
    if count < 3 or _narrowness(polygon, count, nx, ny, nz) < SLIVER * width:
        return 0
    if with_area:
        count = share_out(polygon, count, nx, ny, nz, manifold.area)
    p = own.vertices[solids.loops[solids.loop_start[reference]] - own.first_vertex]
    for k in range(count):  # the point lies midway between the two surfaces
        height[k] = nx * (polygon[k, 0] - p[0]) + ny * (polygon[k, 1] - p[1]) + nz * (polygon[k, 2] - p[2])
        polygon[k, 0] -= 0.5 * height[k] * nx
        polygon[k, 1] -= 0.5 * height[k] * ny
        polygon[k, 2] -= 0.5 * height[k] * nz
    return count


@borrower()
def _clip_by_sides(reference, solids, own, count, snap, outward, manifold):
    """Clip the first ``count`` points of the manifold by the side planes of the reference face; returns how many are left.

    The planes run along ``outward``, the face's normal as three numbers; points within ``snap`` [m] of one count as on it.
    """
    nx, ny, nz = outward
    loops, vertices, first, last = solids.loops, own.vertices, solids.loop_start[reference], solids.loop_start[reference + 1]
    for i in range(first, last):  # side planes point inwards: normal x edge
        p, q = vertices[loops[i] - own.first_vertex], vertices[loops[i + 1 if i + 1 < last else first] - own.first_vertex]
        ex, ey, ez = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        sx, sy, sz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        scale = 1.0 / np.sqrt(sx * sx + sy * sy + sz * sz)
        plane_distances(manifold.point, count, (scale * sx, scale * sy, scale * sz), (p[0], p[1], p[2]), manifold.height)
        count = clip_in_place(manifold.point, count, manifold.height, snap, manifold.other)
    return count


@borrower()
def _without_duplicates(polygon, count, tolerance):
    """Drop corners that coincide with the one before; returns how many stay."""
    out = 0
    for k in range(count):
        last = polygon[out - 1 if out > 0 else count - 1]
        dx, dy, dz = polygon[k, 0] - last[0], polygon[k, 1] - last[1], polygon[k, 2] - last[2]
        if dx * dx + dy * dy + dz * dz > tolerance * tolerance or count == 1:
            for d in range(3):
                polygon[out, d] = polygon[k, d]
            out += 1
    return out


@borrower()
def _narrowness(polygon, count, nx, ny, nz):
    """Area over diameter of a polygon (count, 3) seen along n: about its width [m]."""
    area, diameter = 0.0, 0.0
    for k in range(1, count):
        ax, ay, az = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1], polygon[k, 2] - polygon[0, 2]
        diameter = max(diameter, ax * ax + ay * ay + az * az)
        if k + 1 < count:
            area += _triangle(polygon[0], polygon[k], polygon[k + 1], nx, ny, nz)
    return abs(area) / np.sqrt(diameter) if diameter > 0.0 else 0.0


@borrower()
def share_out(polygon, count, nx, ny, nz, area):
    """Append the centroid to a polygon, and share its area seen along n out between corners and centroid; returns the number of points.

    ``polygon`` (N, 3), or (N, 4) with a number at each corner that is linear in its place; ``area`` (N,) [m2]; see the head of this file.
    """
    total, first = 0.0, polygon[0]
    centre = polygon[count]
    centre[:] = 0.0
    for i in range(1, count - 1):
        part = _triangle(first, polygon[i], polygon[i + 1], nx, ny, nz)
        total += part
        for d in range(polygon.shape[1]):
            centre[d] += part * (first[d] + polygon[i, d] + polygon[i + 1, d]) / 3.0
    for d in range(polygon.shape[1]):
        centre[d] /= total
    mixed, squares = 0.0, 0.0
    area[: count + 1] = 0.0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        part = abs(_triangle(centre, polygon[i], polygon[j], nx, ny, nz))
        area[i] += part / 6.0
        area[j] += part / 6.0
        for d in range(3):
            x, y = polygon[i, d] - centre[d], polygon[j, d] - centre[d]
            mixed += part * x * y
            squares += part * (x * x + y * y)
    area[count] = abs(total)
    for i in range(count):
        area[i] *= 1.0 + mixed / squares
        area[count] -= area[i]
    return count + 1


@borrower()
def _triangle(p, q, r, nx, ny, nz):
    """Signed area of a triangle with corners p, q, r (3,) seen along n [m2]."""
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    return 0.5 * (nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx))


@borrower()
def _edge_contact(edge_a, edge_b, own, other, reach, normal, manifold):
    """The point midway between two edges (4,) of a and b, its gap, and the normal (3,) from a to b; returns how many points: 1, or 0 where
    they separate a and b, but do not cross within their lengths and are farther apart than ``reach`` [m]."""
    p, p_end = own.vertices[edge_a[0] - own.first_vertex], own.vertices[edge_a[1] - own.first_vertex]
    q, q_end = other.vertices[edge_b[0] - other.first_vertex], other.vertices[edge_b[1] - other.first_vertex]
    left, right = own.normals[edge_a[2] - own.first_face], own.normals[edge_a[3] - own.first_face]
    point, height = manifold.point, manifold.height
    uu, uv, vv, uw, vw = 0.0, 0.0, 0.0, 0.0, 0.0  # u, v along the edges, w from one to the other
    length, side = 0.0, 0.0
    ux, uy, uz = p_end[0] - p[0], p_end[1] - p[1], p_end[2] - p[2]
    vx, vy, vz = q_end[0] - q[0], q_end[1] - q[1], q_end[2] - q[2]
    normal[0], normal[1], normal[2] = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    for d in range(3):
        u, v, w = p_end[d] - p[d], q_end[d] - q[d], q[d] - p[d]
        uu, uv, vv, uw, vw = uu + u * u, uv + u * v, vv + v * v, uw + u * w, vw + v * w
        length += normal[d] * normal[d]
        side += normal[d] * (left[d] + right[d])
    scale = (1.0 if side >= 0.0 else -1.0) / np.sqrt(length)
    det = uu * vv - uv * uv
    s, t = (uw * vv - uv * vw) / det, (uw * uv - uu * vw) / det
    crossing = 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0
    if not crossing:  # the nearest points of the edges themselves
        t = min(1.0, max(0.0, (min(1.0, max(0.0, s)) * uv - vw) / vv))
        s = min(1.0, max(0.0, (uw + t * uv) / uu))
    height[0], distance = 0.0, 0.0
    for d in range(3):
        normal[d] *= scale
        height[0] += normal[d] * (q[d] - p[d])
        from_a, from_b = p[d] + s * (p_end[d] - p[d]), q[d] + t * (q_end[d] - q[d])
        point[0, d] = 0.5 * (from_a + from_b)
        distance += (from_b - from_a) ** 2
    return 1 if crossing or height[0] < 0.0 or distance <= reach * reach else 0
