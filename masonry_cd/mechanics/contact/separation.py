# SPDX-License-Identifier: GPL-3.0-or-later
"""Separating axes: how far two convex polyhedra are apart, or how deep they are in each other, and by which of their features.

The largest separation over the face normals of either and the cross products of their edges is the distance, where positive a lower bound
of it, and negative the depth by which one would have to be moved to free the other (Gottschalk, Lin & Manocha, SIGGRAPH 1996). Edge pairs
count only where their arcs cross on the Gauss map of the Minkowski difference (Gregorius, "The separating axis test between convex
polyhedra", GDC 2013).

Kernels see the two polyhedra of a pair in one frame, each as a :class:`Placed`: arrays of vertices and normals, and the numbers of the
first of them, so that polyhedra stored with many others and such as were moved into scratch arrays are treated alike.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.model.geometry import Polyhedra, turned_normal

UNKNOWN, FAR_APART, FACE_OF_A, FACE_OF_B, EDGES, ROUND = 0, 1, 2, 3, 4, 5  # kinds of separating feature; none is kept of pairs far apart

PARALLEL = 1e-4  # edges at less than this angle [rad] are parallel: a face axis is as good, and does not turn about with every small motion
FICKLE = 0.1  # share of the bias by which a face of the other part must be better than one of the part of the last face

HELD = 0.5  # of the depth of a pair on springs: what frees it by another face than the last goes at most this share of the way

WHOLE: Any = np.int64(0)  # number of the first vertex and face in arrays of all; for a plain 0 numba would compile the code twice


class Placed(NamedTuple):
    """A polyhedron, or many, in the frame of a pair; vertex i of :class:`Polyhedra` is in row i - first_vertex, faces likewise."""

    vertices: np.ndarray  # (V, 3) [m]
    normals: np.ndarray  # (F, 3)
    first_vertex: int
    first_face: int


@borrower()
def place_part(pose, p, solids, affine, vertices, normals):
    """Fill ``vertices`` and ``normals``, rows from 0 on, with those of polyhedron p turned and moved by a pose (12,).

    ``affine``: two zeros where the pose holds a strain, with which normals do not turn as vectors do, else one.
    """
    first_vertex, first_face = solids.vertex_start[p], solids.face_start[p]
    for k in range(solids.vertex_start[p + 1] - first_vertex):
        v = solids.vertices[first_vertex + k]
        for i in range(3):
            vertices[k, i] = pose[i] + pose[3 + 3 * i] * v[0] + pose[4 + 3 * i] * v[1] + pose[5 + 3 * i] * v[2]
    for k in range(solids.face_start[p + 1] - first_face):
        v = solids.normals[first_face + k]
        for i in range(3):
            normals[k, i] = pose[3 + 3 * i] * v[0] + pose[4 + 3 * i] * v[1] + pose[5 + 3 * i] * v[2]
        if len(affine) == 2:
            turned = pose[3:].reshape((1, 3, 3))
            normals[k, 0], normals[k, 1], normals[k, 2], _ = turned_normal(turned, 0, v)
    return Placed(vertices, normals, first_vertex, first_face)


@borrower()
def separate(a, b, solids, own, other, bias, springs, feature):
    """Find the axis of largest separation of polyhedra a and b, write it into ``feature`` (3,), return the separation [m].

    ``own`` and ``other`` are a and b as placed. ``feature`` has the kind and the face, or the kind and the two edges; faces win over
    edges, and the face of the last step over others, unless beaten by the ``bias`` [m]: the normal must not flicker. Where ``springs``
    carry a load, a face deeper than the bias stays until another one is at most HELD as deep.
    """
    best, face = face_axis(a, b, solids, own, other)
    best_b, face_b = face_axis(b, a, solids, other, own)
    if springs:
        last = _separation_of_last(a, b, solids, own, other, feature)
        if last < -bias and max(best, best_b) <= HELD * last:
            return last
    kind = FACE_OF_A
    if best_b > best + (-FICKLE * bias if feature[0] == FACE_OF_B else FICKLE * bias):
        best, face, kind = best_b, face_b, FACE_OF_B
    edge_best, edge_a, edge_b = edge_axis(_edges_of(a, solids), _edges_of(b, solids), solids, own, other)
    if edge_best > best + bias:
        feature[0], feature[1], feature[2] = EDGES, edge_a, edge_b
        return edge_best
    feature[0], feature[1], feature[2] = kind, face, -1
    return best


@borrower()
def _separation_of_last(a, b, solids, own, other, feature):
    """Separation by the face of the last step [m]; inf where there is none."""
    if feature[0] == FACE_OF_A:
        return face_separation(feature[1], b, solids, own, other)
    if feature[0] == FACE_OF_B:
        return face_separation(feature[1], a, solids, other, own)
    return np.inf


@borrower()
def face_separation(face, b, solids, own, other):
    """Separation of polyhedron b, placed as ``other``, from a face of the polyhedron placed as ``own`` [m]."""
    n, corner = own.normals[face - own.first_face], own.vertices[solids.loops[solids.loop_start[face]] - own.first_vertex]
    least = np.inf
    for i in range(solids.vertex_start[b] - other.first_vertex, solids.vertex_start[b + 1] - other.first_vertex):
        v = other.vertices[i]
        least = min(least, n[0] * (v[0] - corner[0]) + n[1] * (v[1] - corner[1]) + n[2] * (v[2] - corner[2]))
    return least


@borrower()
def face_axis(a, b, solids, own, other):
    """Largest separation of polyhedron b from the faces of polyhedron a [m], and that face."""
    normals, vertices, points = own.normals, own.vertices, other.vertices
    first = solids.vertex_start[b] - other.first_vertex
    last = solids.vertex_start[b + 1] - other.first_vertex
    best, at = -np.inf, -1
    for f in range(solids.face_start[a], solids.face_start[a + 1]):
        n, corner = normals[f - own.first_face], vertices[solids.loops[solids.loop_start[f]] - own.first_vertex]
        offset = n[0] * corner[0] + n[1] * corner[1] + n[2] * corner[2]
        least = np.inf
        for i in range(first, last):
            value = n[0] * points[i, 0] + n[1] * points[i, 1] + n[2] * points[i, 2]
            if value < least:
                least = value
                if least - offset < best:
                    break
        if least - offset > best:
            best, at = least - offset, f
    return best, at


@borrower()
def _edges_of(p, solids):
    """The first edge of polyhedron p, and the end of its edges."""
    return solids.edge_start[p], solids.edge_start[p + 1]


@borrower()
def edges_separate(feature, solids, own, other):
    """Return True if the axis across the two edges of a ``feature`` (3,) separates the pair as it is placed."""
    i, j = feature[1], feature[2]
    return edge_axis((i, i + 1), (j, j + 1), solids, own, other)[0] >= 0.0


@borrower()
def separation_along(n, a, b, solids, pose):
    """Separation along n (3,), which is in the frame of polyhedron a, of polyhedron b with a pose (12,) in it [m]."""
    most, least = -np.inf, np.inf
    for i in range(solids.vertex_start[a], solids.vertex_start[a + 1]):
        v = solids.vertices[i]
        most = max(most, n[0] * v[0] + n[1] * v[1] + n[2] * v[2])
    t = n[0] * pose[0] + n[1] * pose[1] + n[2] * pose[2]
    x = n[0] * pose[3] + n[1] * pose[6] + n[2] * pose[9]
    y = n[0] * pose[4] + n[1] * pose[7] + n[2] * pose[10]
    z = n[0] * pose[5] + n[1] * pose[8] + n[2] * pose[11]
    for i in range(solids.vertex_start[b], solids.vertex_start[b + 1]):
        v = solids.vertices[i]
        least = min(least, t + x * v[0] + y * v[1] + z * v[2])
    return least - most


@borrower()
def edge_axis(edges_a, edges_b, solids, own, other):
    """Largest separation over pairs of edges of two polyhedra whose Gauss arcs cross [m], and the two edges; -inf, -1 and -1 where none do.

    ``edges_a`` and ``edges_b`` are the first edge of each and the end of them.
    """
    edges, normals, vertices, normals_b, vertices_b = solids.edges, own.normals, own.vertices, other.normals, other.vertices
    a_vertex, a_face, b_vertex, b_face = own.first_vertex, own.first_face, other.first_vertex, other.first_face
    best, at_a, at_b = -np.inf, -1, -1
    for i in range(edges_a[0], edges_a[1]):
        left, right = edges[i, 2] - a_face, edges[i, 3] - a_face
        ax, ay, az = normals[left, 0], normals[left, 1], normals[left, 2]
        bx, by, bz = normals[right, 0], normals[right, 1], normals[right, 2]
        px, py, pz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax  # b x a, along the edge
        p = vertices[edges[i, 0] - a_vertex]
        for j in range(edges_b[0], edges_b[1]):
            left, right = edges[j, 2] - b_face, edges[j, 3] - b_face
            cx, cy, cz = normals_b[left, 0], normals_b[left, 1], normals_b[left, 2]
            dx, dy, dz = normals_b[right, 0], normals_b[right, 1], normals_b[right, 2]
            cba = -(cx * px + cy * py + cz * pz)
            dba = -(dx * px + dy * py + dz * pz)
            if cba * dba >= 0.0:
                continue
            qx, qy, qz = dy * cz - dz * cy, dz * cx - dx * cz, dx * cy - dy * cx
            adc = ax * qx + ay * qy + az * qz
            bdc = bx * qx + by * qy + bz * qz
            if adc * bdc >= 0.0 or cba * bdc <= 0.0:
                continue
            ux, uy, uz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
            length = np.sqrt(ux * ux + uy * uy + uz * uz)
            if length < PARALLEL * np.sqrt((px * px + py * py + pz * pz) * (qx * qx + qy * qy + qz * qz)):
                continue
            sign = 1.0 if ux * (ax + bx) + uy * (ay + by) + uz * (az + bz) > 0.0 else -1.0
            q = vertices_b[edges[j, 0] - b_vertex]
            value = sign * (ux * (q[0] - p[0]) + uy * (q[1] - p[1]) + uz * (q[2] - p[2])) / length
            if value > best:
                best, at_a, at_b = value, i, j
    return best, at_a, at_b


# --- without a bias: how deep polyhedra are in each other ------------------------------------------------------------------------


def depths(solids: Polyhedra, pairs: np.ndarray, enough: np.ndarray) -> np.ndarray:
    """How deep the convex polyhedra of each pair (n, 2) are in each other, (n,) [m].

    A depth below ``enough`` (n,) [m] may come out larger than it is, but not above ``enough``: the first axis that shows this will do.
    """
    out = np.empty(len(pairs))
    _fill_depths(solids, pairs, enough, out)
    return out


@entry()
def _fill_depths(solids: Polyhedra, pairs: np.ndarray, enough: np.ndarray, out: np.ndarray) -> None:
    """Fill ``out`` (n,), see :func:`depths`."""
    placed = Placed(solids.vertices, solids.normals, WHOLE, WHOLE)
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        apart = face_axis(a, b, solids, placed, placed)[0]
        if -apart > enough[k]:
            apart = max(apart, face_axis(b, a, solids, placed, placed)[0])
        if -apart > enough[k]:
            apart = max(apart, edge_axis(_edges_of(a, solids), _edges_of(b, solids), solids, placed, placed)[0])
        out[k] = -apart
