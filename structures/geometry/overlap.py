"""Blocks that overlap: a sweep over bounding boxes, then separating axes.

Two convex polyhedra are apart if and only if some axis separates them, and it suffices to try the normals of both and
the cross products of their edges (Gottschalk, Lin & Manocha, SIGGRAPH 1996). The smallest overlap over these axes is the
depth by which one would have to be moved to free the other.

The kernels call each other, so they share this file: numba's cache does not see changes of a callee elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.jit import entry, kernel


@dataclass(frozen=True, eq=False)
class Shells:
    """Polyhedra in flat arrays: S shells, V vertices, F faces, L loop entries. ``*_start`` delimit a shell or a face."""

    vertices: np.ndarray  # (V, 3) [m]
    vertex_start: np.ndarray  # (S + 1,)
    loops: np.ndarray  # (L,) vertex indices, counted over all shells
    loop_start: np.ndarray  # (F + 1,)
    face_start: np.ndarray  # (S + 1,)
    normals: np.ndarray  # (F, 3) outward unit normals
    size: np.ndarray  # (S,) diagonal of the bounding box [m]


def overlapping_pairs(shells: Shells, owner: np.ndarray, skip: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the convex shells that overlap by more than a tolerance.

    Args:
        shells: convex polyhedra.
        owner: (S,) block of each shell; shells of one block are not compared.
        skip: (S,) True for supports, which are not compared among themselves.
        tolerance: relative to the size of the smaller shell.

    Returns:
        (n, 2) pairs of shells and their depths (n,) [m].
    """
    low = np.minimum.reduceat(shells.vertices, shells.vertex_start[:-1])
    high = np.maximum.reduceat(shells.vertices, shells.vertex_start[:-1])
    order = np.argsort(low[:, 0], kind="stable")
    edges, edge_start = _edges(shells)
    arrays = (shells.vertices, shells.vertex_start, shells.face_start, shells.normals, edges, edge_start, shells.size)
    capacity = 1024
    while True:
        pairs, depths = np.empty((capacity, 2), dtype=np.int64), np.empty(capacity)
        found = _sweep(order, low, high, owner, skip, tolerance, *arrays, pairs, depths)
        if found <= capacity:
            return pairs[:found], depths[:found]
        capacity = found


def _edges(shells: Shells) -> tuple[np.ndarray, np.ndarray]:
    """Each edge once as a pair of vertices (E, 2), and the start of each shell's edges (S + 1,)."""
    after = np.roll(shells.loops, -1)
    after[shells.loop_start[1:] - 1] = shells.loops[shells.loop_start[:-1]]
    once = shells.loops < after
    edges = np.stack([shells.loops[once], after[once]], axis=1)
    counted = np.concatenate([[0], np.cumsum(once)])
    return edges, counted[shells.loop_start[shells.face_start]]


@entry()
def _sweep(order, low, high, owner, skip, tolerance, vertices, vertex_start, face_start, normals, edges, edge_start, size, pairs, depths):
    """Pass a plane along x, keep the boxes it cuts, and test those that meet. Returns the number found."""
    active = np.empty(len(order), dtype=np.int64)
    count, found = 0, 0
    for a in order:
        kept = 0
        for j in range(count):
            b = active[j]
            if high[b, 0] <= low[a, 0]:
                continue
            active[kept] = b
            kept += 1
            if low[a, 1] >= high[b, 1] or low[b, 1] >= high[a, 1] or low[a, 2] >= high[b, 2] or low[b, 2] >= high[a, 2]:
                continue
            if owner[a] == owner[b] or (skip[a] and skip[b]):
                continue
            limit = tolerance * min(size[a], size[b])
            depth = _depth(a, b, limit, vertices, vertex_start, face_start, normals, edges, edge_start)
            if depth > limit:
                if found < len(depths):
                    pairs[found, 0], pairs[found, 1], depths[found] = min(a, b), max(a, b), depth
                found += 1
        count = kept
        active[count] = a
        count += 1
    return found


@kernel()
def _depth(a, b, limit, vertices, vertex_start, face_start, normals, edges, edge_start):
    """Smallest overlap over the separating axes [m]; returns early below the limit."""
    va = vertices[vertex_start[a] : vertex_start[a + 1]]
    vb = vertices[vertex_start[b] : vertex_start[b + 1]]
    smallest = np.inf
    for shell in (a, b):
        for f in range(face_start[shell], face_start[shell + 1]):
            smallest = min(smallest, _along(va, vb, normals[f, 0], normals[f, 1], normals[f, 2]))
            if smallest <= limit:
                return smallest
    for i in range(edge_start[a], edge_start[a + 1]):
        p = vertices[edges[i, 1]] - vertices[edges[i, 0]]
        for j in range(edge_start[b], edge_start[b + 1]):
            q = vertices[edges[j, 1]] - vertices[edges[j, 0]]
            x, y, z = p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]
            length = np.sqrt(x * x + y * y + z * z)
            if length <= 1e-9 * np.sqrt((p @ p) * (q @ q)):
                continue  # parallel edges: the normals of their faces have covered this
            smallest = min(smallest, _along(va, vb, x / length, y / length, z / length))
            if smallest <= limit:
                return smallest
    return smallest


@kernel()
def _along(va, vb, x, y, z):
    """Overlap of the shadows of two vertex sets on a unit axis, negative when they are apart [m]."""
    low_a, high_a, low_b, high_b = np.inf, -np.inf, np.inf, -np.inf
    for i in range(len(va)):
        s = va[i, 0] * x + va[i, 1] * y + va[i, 2] * z
        low_a, high_a = min(low_a, s), max(high_a, s)
    for i in range(len(vb)):
        s = vb[i, 0] * x + vb[i, 1] * y + vb[i, 2] * z
        low_b, high_b = min(low_b, s), max(high_b, s)
    return min(high_a - low_b, high_b - low_a)
