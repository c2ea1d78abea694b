# SPDX-License-Identifier: GPL-3.0-or-later
r"""Polygons: area, centroid, normal, and what a half-space leaves of them.

A polygon is an array of its corners in order: (n, 2) in a plane of its own, (n, 3) in space, where its corners lie in one plane. Many
polygons stand one after another in one array, polygon k at loop_start[k], ..., loop_start[k + 1] - 1.

**Clipping** (Sutherland & Hodgman, Comm. ACM 17(1), 1974). With d_k the signed distance of corner k from the plane, a corner stays where
d_k >= -tolerance, and a side whose ends lie beyond the tolerance on different sides of the plane yields the point

    X_k + d_k / (d_k - d_l) (X_l - X_k).

So the corners of what is left follow in the order of the polygon: corner k, then the point on the side behind it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from masonry_cd.foundation.jit import borrower, entry

NEXT, LAST = [1, 2, 0], [2, 0, 1]  # axes in cyclic order after x, y, z


def polygon_area(polygon: np.ndarray) -> float:
    """Signed area of a polygon (n, 2) [m2], positive when it runs counter-clockwise."""
    x, z = (polygon - polygon[0]).T
    return 0.5 * float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))


def polygon_centroid(polygon: np.ndarray) -> np.ndarray:
    """Centre of area (2,) of a polygon (n, 2) [m]."""
    local = polygon - polygon[0]
    after = np.roll(local, -1, axis=0)
    weight = local[:, 0] * after[:, 1] - after[:, 0] * local[:, 1]
    return polygon[0] + ((local + after) * weight[:, None]).sum(axis=0) / (3.0 * weight.sum())


def loop_area(loop: np.ndarray) -> float:
    """Area of a polygon in space (n, 3) [m2]."""
    return 0.5 * math.hypot(*np.cross(loop[1:-1] - loop[0], loop[2:] - loop[0]).sum(axis=0))


def loop_normal(loop: np.ndarray) -> np.ndarray:
    """Unit normal (3,) of a polygon in space (n, 3), convex or not, by Newell's sum."""
    spoke = loop - loop[0]
    rest = np.concatenate([spoke[1:], spoke[:1]])
    ahead, back = spoke.take(NEXT, axis=1), spoke.take(LAST, axis=1)
    cross = ahead * rest.take(LAST, axis=1) - back * rest.take(NEXT, axis=1)  # numpy's own takes several times as long on a few rows
    area = 0.5 * cross.sum(axis=0)
    return area / np.sqrt(np.sum(area**2))


def loop_planes(loops: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (n, 3) and offsets (n,) [m] of the planes of n polygons in space; a plane is normal . x = offset."""
    normals = np.array([loop_normal(loop) for loop in loops])
    return normals, np.array([np.sum(normal * loop.mean(axis=0)) for normal, loop in zip(normals, loops, strict=True)])


def next_in_loop(loop_start: np.ndarray) -> np.ndarray:
    """Row (L,) of the corner that follows each corner in its polygon."""
    following = np.arange(1, loop_start[-1] + 1)
    following[loop_start[1:] - 1] = loop_start[:-1]
    return following


def clip_loops(
    points: np.ndarray, loop_start: np.ndarray, distance: np.ndarray, tolerance: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Clip many polygons, all at once.

    Args:
        points: (L, d) corners of n polygons [m].
        loop_start: (n + 1,)
        distance: (L,) of the corners from the plane, positive where they stay [m].
        tolerance: distance within which a corner counts as in the plane [m].

    Returns:
        the corners of the polygons of which something is left (M, d), their starts (m + 1,), and their rows among the n (m,).
    """
    out, count = np.empty((2 * len(points), points.shape[1])), np.empty(len(loop_start) - 1, dtype=np.int64)
    used = _clip_loops(np.ascontiguousarray(points, dtype=float), loop_start, distance, tolerance, out, count)
    rows = np.flatnonzero(count)
    return out[:used], np.concatenate([[0], np.cumsum(count[rows])]), rows


def clip(polygon: np.ndarray, distance: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """Corners (m, d) of what is left of one polygon (n, d), whose corners have a distance (n,) from the plane [m]."""
    return clip_loops(polygon, np.array([0, len(polygon)]), distance, tolerance)[0]


@entry()
def _clip_loops(points, loop_start, distance, tolerance, out, count):
    """Fill ``out`` (2 L, d) with the corners of what is left, and ``count`` (n,) with how many each polygon has; returns their sum."""
    used = 0
    for k in range(loop_start.shape[0] - 1):
        first, last = loop_start[k], loop_start[k + 1]
        count[k] = clip_into(points[first:last], last - first, distance[first:last], tolerance, out[used:])
        used += count[k]
    return used


@borrower()
def clip_in_place(polygon, count, distance, tolerance, other):
    """Clip a polygon, the first ``count`` rows of ``polygon`` (N, d); returns the number of its corners then.

    ``distance`` (N,) of the corners; ``other`` (N, d) is scratch. A convex polygon gains one corner at most, which N must allow for.
    """
    whole = True
    for k in range(count):
        whole = whole and distance[k] >= -tolerance
    if whole:
        return count
    left = clip_into(polygon, count, distance, tolerance, other)
    for k in range(left):
        for d in range(polygon.shape[1]):
            polygon[k, d] = other[k, d]
    return left


@borrower()
def clip_into(polygon, count, distance, tolerance, out):
    """Fill ``out`` with the corners of what is left of the first ``count`` rows of ``polygon`` (N, d); returns how many."""
    left = 0
    for k in range(count):
        j = k + 1 if k + 1 < count else 0
        here, there = distance[k], distance[j]
        if here >= -tolerance:
            for d in range(polygon.shape[1]):
                out[left, d] = polygon[k, d]
            left += 1
        if (here > tolerance and there < -tolerance) or (here < -tolerance and there > tolerance):
            t = here / (here - there)
            for d in range(polygon.shape[1]):
                out[left, d] = polygon[k, d] + t * (polygon[j, d] - polygon[k, d])
            left += 1
    return left


@borrower()
def plane_distances(polygon, count, normal, point, distance):
    """Fill ``distance`` (N,) for the first ``count`` rows of ``polygon`` (N, 3); plane through ``point``, both three numbers [m]."""
    nx, ny, nz = normal
    px, py, pz = point
    for k in range(count):
        distance[k] = nx * (polygon[k, 0] - px) + ny * (polygon[k, 1] - py) + nz * (polygon[k, 2] - pz)
