# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed shells in a soup of faces whose corners may be shared by several solids.

Solids that touch share corners, and edges, once equal corners are one. Around such an edge its faces alternate: where a solid is entered,
where it is left. With outward faces, the one that runs along the edge bounds its solid from above, in the angle about the edge, and the
one that runs against it from below; so each of the former belongs with the nearest of the latter below it:

    partner(f) = arg min over g against the edge of  (angle_f - angle_g) mod 2 pi,    zero counting as a full turn.

Zero is a face of one solid upon that of another. Faces that are joined so, and by edges that only two share, make up a shell.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from structures.files.foreign import Faces

Shell = tuple[np.ndarray, Faces]
FLAT = 1e-3  # [rad]: faces upon each other, also in single precision; no stone has an edge so sharp
NEEDLE = 1e-300  # [m] of an edge or a height: has no direction


def shells(vertices: np.ndarray, loops: Sequence[Sequence[int]]) -> list[Shell]:
    """The shells of a soup, in the order of the file; equal corners are one.

    Args:
        vertices: (V, 3) [any unit].
        loops: of corners, counter-clockwise seen from outside.

    Raises:
        ValueError: a face names a corner that does not exist, or none.
    """
    corners = np.array([i for loop in loops for i in loop], dtype=np.int64)
    if not len(corners):
        return []
    if not all(len(loop) for loop in loops):
        raise ValueError("a face without corners")
    if corners.min() < 0 or corners.max() >= len(vertices):
        raise ValueError(f"a face names a corner outside 0 to {len(vertices) - 1}")
    points, one = np.unique(vertices, axis=0, return_inverse=True)
    starts = np.concatenate([[0], np.cumsum([len(loop) for loop in loops])])
    welded = one.ravel()[corners]
    owner = np.repeat(np.arange(len(loops)), np.diff(starts))
    label = _labels(points, welded, starts, owner)
    found = []
    for own in _in_order(label):
        loops_of = [welded[starts[f] : starts[f + 1]] for f in own]
        used, local = np.unique(np.concatenate(loops_of), return_inverse=True)
        ends = np.cumsum([len(loop) for loop in loops_of])[:-1]
        found.append((points[used], tuple(tuple(map(int, part)) for part in np.split(local.ravel(), ends))))
    return found


def _in_order(label: np.ndarray) -> list[np.ndarray]:
    """The faces of each label, by the first of them."""
    order = np.argsort(label, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return sorted(parts, key=lambda part: int(part[0]))


def neighbours(vertices: np.ndarray, loops: Sequence[Sequence[int]]) -> np.ndarray:
    """Pairs of faces that belong together at an edge, (n, 4): the ends of the edge and the two faces; corners are one by their number."""
    starts = np.concatenate([[0], np.cumsum([len(loop) for loop in loops])])
    return _joined(vertices, np.array([i for loop in loops for i in loop]), starts, np.repeat(np.arange(len(loops)), np.diff(starts)))


def _labels(points: np.ndarray, welded: np.ndarray, starts: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """(F,) which shell each face belongs to."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    joined = _joined(points, welded, starts, owner)[:, 2:]
    faces = len(starts) - 1
    graph = coo_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(faces, faces))
    return np.asarray(connected_components(graph, directed=False)[1])


def _joined(points: np.ndarray, welded: np.ndarray, starts: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """Ends of an edge and two faces that belong together there, (n, 4)."""
    after = np.arange(len(welded)) + 1
    after[starts[1:] - 1] = starts[:-1]
    begin, end = welded, welded[after]
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    _, edge, count = np.unique(low * len(points) + high, return_inverse=True, return_counts=True)
    edge = edge.ravel()
    order = np.argsort(edge, kind="stable")
    places = np.split(order, np.cumsum(count)[:-1])
    plain = np.array([place for place in places if len(place) == 2], dtype=np.int64).reshape(-1, 2)
    found = [np.column_stack([low[plain[:, 0]], high[plain[:, 0]], owner[plain]])]
    for place in (place for place in places if len(place) > 2):
        pairs = _around(points, welded, starts, owner, place, begin < end)
        found.append(np.column_stack([np.tile([low[place[0]], high[place[0]]], (len(pairs), 1)), pairs]))
    return np.concatenate(found)


def _around(
    points: np.ndarray, welded: np.ndarray, starts: np.ndarray, owner: np.ndarray, place: np.ndarray, along: np.ndarray
) -> np.ndarray:
    """Which faces belong together about an edge that more than two share, (n, 2), see the head of this file."""
    first = place[along[place]] if along[place].any() else place
    loop = _next(starts, owner, int(first[0]))
    a, b = (points[welded[int(first[0])]], points[welded[loop]])
    if not along[place].any():
        a, b = b, a
    axis = b - a
    size = float(np.linalg.norm(axis))
    if size < NEEDLE:
        return np.zeros((0, 2), dtype=np.int64)
    axis = axis / size
    inward = np.array([_across(points, welded, starts, owner, int(k), a, axis) for k in place])
    right = np.cross(axis, inward[0])
    angle = np.array([math.atan2(y, x) for y, x in zip(inward @ right, inward @ inward[0], strict=True)])
    forward, backward = np.flatnonzero(along[place]), np.flatnonzero(~along[place])
    if not len(forward) or not len(backward):
        return np.zeros((0, 2), dtype=np.int64)
    gap = np.mod(angle[forward][:, None] - angle[backward][None], 2.0 * np.pi)
    gap[gap < FLAT] += 2.0 * np.pi
    return np.column_stack([owner[place[forward]], owner[place[backward[np.argmin(gap, axis=1)]]]])


def _next(starts: np.ndarray, owner: np.ndarray, k: int) -> int:
    """The place of the corner behind another in its loop."""
    face = int(owner[k])
    return int(starts[face]) if k + 1 == starts[face + 1] else k + 1


def _across(
    points: np.ndarray, welded: np.ndarray, starts: np.ndarray, owner: np.ndarray, k: int, on: np.ndarray, axis: np.ndarray
) -> np.ndarray:
    """The unit vector across an edge into a face of it, (3,): towards the corner that is farthest from the edge."""
    face = int(owner[k])
    spokes = points[welded[starts[face] : starts[face + 1]]] - on
    across = spokes - np.outer(spokes @ axis, axis)
    far = across[int(np.argmax((across * across).sum(axis=1)))]
    size = float(np.linalg.norm(far))
    return far / size if size > NEEDLE else np.array([1.0, 0.0, 0.0])
