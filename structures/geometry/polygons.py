# SPDX-License-Identifier: GPL-3.0-or-later
"""Plane polygons of shapely: their convex pieces, and whether they are level rectangles."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from masonry_cd.mechanics.model.polygon import polygon_area

SAME = 1e-9  # [m]
LEAST_AREA = 1e-9  # what is smaller is rounding [m2]
FAR = 1e6  # [m]


def box(low: float, high: float, bottom: float = -FAR, top: float = FAR) -> Polygon:
    """A rectangle."""
    return Polygon([(low, bottom), (high, bottom), (high, top), (low, top)])


def polygons(shape: BaseGeometry, least: float = LEAST_AREA) -> list[Polygon]:
    """The polygons of a geometry that have an area, from the left to the right, without corners in the middle of a side."""
    found = [part for part in getattr(shape, "geoms", [shape]) if isinstance(part, Polygon) and part.area > least]
    return sorted((_plain(part) for part in found), key=lambda part: (part.bounds[0], part.bounds[1]))


def _plain(shape: Polygon) -> Polygon:
    return Polygon(loop(shape), [without_straight(np.array(ring.coords)[:-1]) for ring in shape.interiors])


def without_holes(shape: Polygon) -> list[Polygon]:
    """A polygon, or its halves next to an upright line through its holes."""
    if not shape.interiors:
        return [shape]
    left, _, right, _ = shape.bounds
    middle = float(np.mean([loop(Polygon(ring))[:, 0].mean() for ring in shape.interiors]))
    halves = [part for a, b in ((left, middle), (middle, right)) for part in polygons(shape.intersection(box(a, b)))]
    return [whole for half in halves for whole in without_holes(half)]


def loop(shape: Polygon) -> np.ndarray:
    """The corners (n, 2) of a polygon, counter-clockwise."""
    ring = without_straight(np.array(shape.exterior.coords)[:-1])
    return ring if len(ring) < 3 or polygon_area(ring) > 0.0 else ring[::-1]


def without_straight(ring: np.ndarray, closed: bool = True) -> np.ndarray:
    """A loop (n, 2), or a line that is not closed, without doubled corners and those in the middle of a side."""
    if not closed:
        ring = ring[[True, *(np.hypot(*np.diff(ring, axis=0).T) > SAME)]]
        before, after = np.diff(ring[:-1], axis=0), np.diff(ring[1:], axis=0)
        bends = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) > 1e-6 * np.hypot(*before.T) * np.hypot(*after.T)
        return np.asarray(ring[[True, *bends, True]])
    ring = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > SAME]
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(ring[np.abs(turn) > SAME * np.hypot(*before.T) * np.hypot(*after.T)])


def plan_of(vertices: np.ndarray) -> np.ndarray:
    """The convex hull (n, 2) in plan of points (m, 3), counter-clockwise."""
    return loop(shapely.MultiPoint(vertices[:, :2]).convex_hull)


def is_rectangle(shape: Polygon) -> bool:
    """Return True if its sides are level and upright."""
    left, low, right, high = shape.bounds
    return abs(shape.area - (right - left) * (high - low)) < LEAST_AREA * max(1.0, shape.area)


def convex_pieces(shape: Polygon) -> list[np.ndarray]:
    """Convex polygons (n, 2), counter-clockwise, that fill one and share whole sides: triangles, joined as long as they stay convex."""
    ring = loop(shape)
    if not shape.interiors and _is_convex(ring):
        return [ring]
    pieces = [loop(triangle) for triangle in shapely.constrained_delaunay_triangles(shape).geoms if triangle.area > 0.0]
    pieces = [piece for piece in pieces if len(piece) > 2]
    joined = True
    while joined:
        joined = False
        for i, j, union in _neighbours(pieces):
            if _is_convex(union):
                pieces[i] = union
                del pieces[j]
                joined = True
                break
    return pieces


def _neighbours(pieces: list[np.ndarray]) -> Iterator[tuple[int, int, np.ndarray]]:
    """Pairs of polygons that share a side, and what both make together, its corners as theirs."""
    edge = {(tuple(p[k - 1]), tuple(p[k])): (i, k) for i, p in enumerate(pieces) for k in range(len(p))}
    for (a, b), (i, k) in edge.items():
        if (b, a) in edge:
            j, m = edge[b, a]
            if i < j:
                one, other = np.roll(pieces[i], -k, axis=0), np.roll(pieces[j], -m, axis=0)  # one from b to a, the other from a to b
                yield i, j, np.concatenate([one, other[1:-1]])


def _is_convex(ring: np.ndarray) -> bool:
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return bool((turn >= -SAME * np.hypot(*before.T) * np.hypot(*after.T)).all())


def clean_stretch(shape: Polygon, half: float) -> tuple[float, float]:
    """The longest stretch s of a footprint in which it has the whole thickness [m]; its middle twice where there is none."""
    left, low, right, high = shape.bounds
    if is_rectangle(shape) and high - low > 2.0 * half - 1e-7:
        return left, right
    ring = loop(shape)
    events = np.unique(np.round(ring[:, 0], 9))
    best, start = (float(events[:2].mean()), float(events[:2].mean())), None
    for low, high in pairwise(events):
        middle = 0.5 * (low + high)
        across = shape.intersection(shapely.LineString([(middle, -2.0 * half), (middle, 2.0 * half)])).length
        if across < 2.0 * half - 1e-7:
            start = None
            continue
        start = low if start is None else start
        if high - start > best[1] - best[0]:
            best = float(start), float(high)
    return best
